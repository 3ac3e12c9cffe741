//! Surfaces as their material sees them, in lanes.

use glam::Vec3A;

use super::{DirectionSampling, Vertex};
use crate::bsdf::{Bsdf, Flags, Needs, Place, Scattered, shading_normal};
use crate::emitter::Receivers;
use crate::math::real::{Lanes, Mask, Real};
use crate::math::vector::Vec3;
use crate::math::{Frame, Rgb};
use crate::ray::{Hit, Ray};
use crate::sampler::PathSampler;
use crate::shape::{Arrivals, Interaction};

/// The surface that a ray has met in each lane, all of one material: a frame around the shading normal, bent where it has
/// to be ([`shading_normal`]), and the rule that the geometric normal decides what is a reflection.
#[derive(Debug)]
pub(super) struct Shading<'a, R: Real = f32> {
    pub(super) bsdf: &'a dyn Bsdf,
    pub(super) flags: Flags,
    pub(super) place: Place<R>,
    frame: Frame<R>,
    geometric_normal: Vec3<R>,
    /// Where the path came from, local.
    pub(super) wi: Vec3<R>,
    /// Cosine of the same with the geometric normal.
    cos_geometric: R,
}

impl<'a> Shading<'a> {
    /// One lane.
    pub(super) fn of_vertex(vertex: &Vertex<'a>, ray: &Ray) -> Self {
        let arrivals = Arrivals::one(vertex.object.shape.as_ref(), ray, &vertex.hit);
        Self::new(vertex.bsdf, &Interaction::from(vertex.surface), &arrivals, |_| *ray)
    }

    /// See [`Bsdf::albedo`].
    pub(super) fn albedo(&self) -> Rgb {
        self.bsdf.albedo(&self.place, self.wi.into())
    }

    /// A direction for the path to go on, in the world, with the weight f·|cosθ|/pdf. `None` where it
    /// ends.
    pub(super) fn scatter(
        &self,
        directions: DirectionSampling,
        sampler: &mut PathSampler<'_>,
    ) -> Option<(Vec3A, Rgb)> {
        let sample = directions.sample(self, sampler.next_2d().into());
        let (direction, goes_on) = self.onward(&sample);
        goes_on.then_some((direction.into(), sample.weight.into()))
    }
}

impl<'a, R: Real> Shading<'a, R> {
    /// Of `interaction`, which is of surfaces of the material `bsdf` and was made of `arrivals`. Where the material has to be
    /// told where it is, all of a `ray` is asked.
    #[inline(always)]
    pub(super) fn new(
        bsdf: &'a dyn Bsdf,
        interaction: &Interaction<R>,
        arrivals: &Arrivals<'_, R>,
        ray: impl Fn(usize) -> Ray,
    ) -> Self {
        let token = interaction.time.token();
        let flags = bsdf.flags();
        let geometric_normal = interaction.geometric_normal;
        let back = -arrivals.direction;
        let (normal, same) = normal(bsdf, interaction, back);
        let mut shading = Self {
            bsdf,
            flags,
            place: Place::anywhere(token),
            frame: Frame::from_normal(normal),
            geometric_normal,
            wi: back,
            cos_geometric: back.dot(geometric_normal),
        };
        if !same.all() && bsdf.interface().is_some() {
            let local = shading.frame.to_local(geometric_normal);
            shading.place.geometric_normal =
                Vec3::select(same, shading.place.geometric_normal, local);
        }
        if flags.needs != Needs::Nothing {
            shading.look_up(interaction, arrivals, ray);
        }
        shading.wi = shading.frame.to_local(back);
        shading
    }

    /// The place as far as the material needs it. With tangents x of the frame is the direction in which the
    /// first texture coordinate grows. Lane by lane.
    #[inline(always)]
    fn look_up(
        &mut self,
        interaction: &Interaction<R>,
        arrivals: &Arrivals<'_, R>,
        ray: impl Fn(usize) -> Ray,
    ) {
        let token = self.wi.token();
        let hit = |i: usize| {
            let [u, v] = interaction.parameters.lane(i).to_array();
            Hit { u, v, ..arrivals.hits.as_ref()[i] }
        };
        let shape = |i: usize| arrivals.shapes.as_ref()[i];
        self.place.uv = Lanes::from_fn(token, |i| shape(i).uv(&ray(i), &hit(i)).into());
        if self.flags.needs != Needs::Tangents {
            return;
        }
        let tangents = R::each(|i| shape(i).tangents(&ray(i), &hit(i)));
        let [dp_du, dp_dv] =
            [0, 1].map(|k| Vec3::from_fn(token, |i| tangents.as_ref()[i][k].into()));
        self.frame = Frame::from_normal_and_tangent(self.frame.n, dp_du);
        self.place.dp_du = self.frame.to_local(dp_du);
        self.place.dp_dv = self.frame.to_local(dp_dv);
        self.place.geometric_normal = self.frame.to_local(self.geometric_normal);
    }

    /// The surfaces as such that light is to arrive at: what does not transmit needs none from behind.
    #[inline(always)]
    pub(super) fn receivers(&self, interaction: &Interaction<R>) -> Receivers<R> {
        let normal = self.geometric_normal;
        let everywhere = |holds| R::Mask::splat(normal.token(), holds);
        Receivers {
            position: interaction.position,
            normal: Vec3::select(self.cos_geometric.lt(0.0), -normal, normal),
            both_sides: everywhere(self.flags.transmits),
            is_diffuse: everywhere(!self.flags.glossy),
        }
    }

    #[inline(always)]
    pub(super) fn to_local(&self, direction: Vec3<R>) -> Vec3<R> {
        self.frame.to_local(direction)
    }

    /// The direction of a sample in the world, and whether the path goes there: not where there is none, or it would
    /// leak.
    #[inline(always)]
    pub(super) fn onward(&self, sample: &Scattered<R>) -> (Vec3<R>, R::Mask) {
        let mut direction = self.frame.to_world(sample.wo);
        if sample.is_delta.any() {
            // It comes from the one before it: its length would drift, by 1e-4 in ten thousand bounces.
            direction = Vec3::select(sample.is_delta, direction.normalize(), direction);
        }
        (direction, sample.exists & self.sides_agree(sample.wo, direction))
    }

    /// Whether the shading normal and the geometric normal agree on which side of the surface `wo` is
    /// (local and world form of one direction): whether it is a reflection for both, or for neither.
    /// Where they do not, light would leak through the surface (Veach 1997, section 5.3).
    #[inline(always)]
    pub(super) fn sides_agree(&self, wo: Vec3<R>, wo_world: Vec3<R>) -> R::Mask {
        let reflected = (self.wi.z * wo.z).gt(0.0);
        let reflected_geometrically =
            (self.cos_geometric * self.geometric_normal.dot(wo_world)).gt(0.0);
        !(reflected ^ reflected_geometrically)
    }
}

/// The shading normals as the material sees them from the directions `back`, and whether they are the geometric ones.
#[inline(always)]
fn normal<R: Real>(
    bsdf: &dyn Bsdf,
    interaction: &Interaction<R>,
    back: Vec3<R>,
) -> (Vec3<R>, R::Mask) {
    let (shading, geometric) = (interaction.shading_normal, interaction.geometric_normal);
    let same = shading.x.eq(geometric.x) & shading.y.eq(geometric.y) & shading.z.eq(geometric.z);
    if same.all() {
        return (shading, same);
    }
    let bent = shading_normal::bend(shading, geometric, back, bsdf.interface());
    (Vec3::select(same, shading, bent), same)
}
