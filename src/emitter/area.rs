//! Surfaces that emit.

use std::f64::consts::PI;
use std::sync::Arc;

use glam::{DVec2, DVec3, Vec2, Vec3A};

use super::{Emitter, EmitterBounds, EmitterSample, EmitterSamples, Sight};
use crate::math::discrete::ONE_MINUS_ULP;
use crate::math::real::{Double, Float, Lanes, Mask, Real};
use crate::math::{Choice, Choices, Discrete, Rgb, luminance, vector as real};
use crate::ray::{Hit, Ray, RayEnds};
use crate::shape::sample::primitive_pdf;
use crate::shape::{Arrivals, Interaction, Shape, ShapeSamples};
use crate::texture::{Texture, Textured};

/// The same radiance in all directions from each point of the front of a shape.
#[derive(Debug)]
pub struct Area {
    shape: Arc<dyn Shape>,
    radiance: Textured<Rgb>,
    /// Choice of a primitive by its area and a guess of its mean radiance.
    primitives: Discrete,
    /// Emitted power in W.
    power: f64,
}

/// Share of the mean of a texture in the guess for a primitive, which therefore is nowhere 0.
const FLOOR: f32 = 0.1;

/// Where on a triangle a texture is looked up for that guess: the points of a quadrature that is exact for
/// polynomials of degree 2 (Strang and Fix 1973), and the middle.
const PLACES: [Vec2; 4] = [
    Vec2::new(1.0 / 6.0, 1.0 / 6.0),
    Vec2::new(2.0 / 3.0, 1.0 / 6.0),
    Vec2::new(1.0 / 6.0, 2.0 / 3.0),
    Vec2::new(1.0 / 3.0, 1.0 / 3.0),
];

impl Area {
    /// `None` if the shape has no area.
    #[must_use]
    pub fn new(shape: Arc<dyn Shape>, radiance: impl Into<Textured<Rgb>>) -> Option<Self> {
        let radiance = radiance.into();
        let count = shape.primitive_count();
        let areas = (0..count).map(|i| shape.primitive_area(i));
        let (primitives, mean) = match &radiance {
            Textured::Uniform(radiance) => {
                (Discrete::new(&areas.collect::<Vec<_>>())?, luminance(*radiance))
            }
            Textured::Varying(texture) => {
                let guess = luminances(shape.as_ref(), texture.as_ref());
                let weights: Vec<_> =
                    areas.zip(guess).map(|(area, l)| area * f64::from(l)).collect();
                (Discrete::new(&weights)?, 1.0)
            }
        };
        let power = PI * primitives.total() * f64::from(mean);
        Some(Self { shape, radiance, primitives, power })
    }

    /// Radiance of a point of the front where it varies, seen along a ray that starts at `from`. Channels below 0 count as 0.
    fn texel(&self, texture: &dyn Texture, from: DVec3, direction: Vec3A, hit: &Hit) -> Rgb {
        let uv = self.shape.uv(&Ray::from_exact(from, direction), hit);
        texture.rgb(uv).max(Rgb::ZERO)
    }

    /// Whether it is chosen by primitives: they lie apart or face apart. A square's two triangles do not.
    fn is_split(&self) -> bool {
        self.shape.primitive_count() > 2
    }

    /// The primitive for one number, among all, or that which is the named part.
    fn choose(&self, part: Option<u32>, u: f64) -> Choice {
        match part {
            Some(part) if self.is_split() => {
                Choice { index: part as usize, probability: 1.0, rest: u }
            }
            _ => self.primitives.sample(u),
        }
    }

    /// A point of each lane's light as seen from `from`, or of a part of it that is named.
    #[inline(always)]
    pub(super) fn sample<R: Real>(
        areas: &R::Each<&Self>,
        parts: &R::Each<Option<u32>>,
        from: real::Vec3<R::Double>,
        u: real::Vec2<R::Double>,
    ) -> EmitterSamples<R> {
        let token = u.token();
        let (area, parts) = (areas.as_ref(), parts.as_ref());
        let are_one = (1..R::LANES).all(|i| std::ptr::eq(area[i], area[0]));
        let Choices { index, probability, rest } =
            if are_one && !(area[0].is_split() && parts.iter().any(Option::is_some)) {
                area[0].primitives.sample_each::<R>(u.x)
            } else {
                Choices::from_fn(token, |i| area[i].choose(parts[i], u.x.lane(i)))
            };
        let u = real::Vec2::new(rest, u.y).narrow().map(|u| u.min(ONE_MINUS_ULP));
        let shapes = R::each(|i| area[i].shape.as_ref());
        let samples = ShapeSamples::<R>::new(&shapes, &index, from, u);
        let ShapeSamples { exists, position, parameters, normal, direction, pdf, .. } = samples;
        let radiance = real::Vec3::from_fn(token, |i| match &area[i].radiance {
            Textured::Uniform(radiance) => (*radiance).into(),
            Textured::Varying(texture) => {
                let [from, to] = [from, position].map(|point| DVec3::from(point.lane(i)));
                let distance = (to - from).length() as f32;
                let primitive = index.as_ref()[i] as usize;
                let hit = hit_at(primitive, distance, parameters.lane(i).into());
                area[i].texel(texture.as_ref(), from, direction.lane(i).into(), &hit).into()
            }
        });
        let pdf = pdf * probability;
        let is_moderate = pdf.ge(1e-30) & pdf.lt(1e30);
        let mut weight = radiance * pdf.recip().narrow();
        if !is_moderate.all() {
            // The inverse may be too small for an f32, and its product with the radiance not.
            let exact = (radiance.widen() / pdf).narrow();
            weight = real::Vec3::select(is_moderate, weight, exact);
        }
        let is_front = normal.dot(direction).lt(0.0);
        let end = RayEnds::new(position, normal, -direction);
        EmitterSamples::of_surface(exists & is_front, direction, weight, narrow(pdf), end)
    }

    /// Radiance of each lane's light at the surface that its ray has met.
    #[inline(always)]
    pub(crate) fn radiance_each<R: Real>(
        areas: &R::Each<&Self>,
        arrivals: &Arrivals<'_, R>,
        surface: &Interaction<R>,
    ) -> real::Vec3<R> {
        let Arrivals { hits, origin, direction, .. } = arrivals;
        let radiance = real::Vec3::from_fn(direction.token(), |i| {
            let area = areas.as_ref()[i];
            match &area.radiance {
                Textured::Uniform(radiance) => (*radiance).into(),
                Textured::Varying(texture) => {
                    let [u, v] = surface.parameters.lane(i).to_array();
                    let hit = Hit { u, v, ..hits.as_ref()[i] };
                    let (from, direction) = (origin.lane(i).into(), direction.lane(i).into());
                    area.texel(texture.as_ref(), from, direction, &hit).into()
                }
            }
        });
        radiance.only_where(is_front(arrivals, surface))
    }

    /// Densities of the same surfaces.
    #[inline(always)]
    pub(super) fn pdf_each<R: Real>(
        areas: &R::Each<&Self>,
        arrivals: &Arrivals<'_, R>,
        surface: &Interaction<R>,
    ) -> AreaPdf<R> {
        let token = arrivals.time.token();
        let (area, hits) = (areas.as_ref(), arrivals.hits.as_ref());
        let shapes = R::each(|i| area[i].shape.as_ref());
        let primitives = R::each(|i| hits[i].primitive);
        let pdf = primitive_pdf::<R>(&shapes, &primitives, arrivals.origin, surface);
        let share = |i: usize| area[i].primitives.probability(hits[i].primitive as usize);
        let of_whole = pdf * R::Double::from_fn(token, share);
        let is_split = R::mask(token, |i| area[i].is_split());
        let is_front = is_front(arrivals, surface);
        let shown = |pdf| R::select(is_front, narrow(pdf), 0.0);
        AreaPdf {
            part: R::each(|i| if is_split.lane(i) { hits[i].primitive } else { 0 }),
            pdf: shown(of_whole),
            part_pdf: shown(R::Double::select(is_split, pdf, of_whole)),
        }
    }

    /// [`Area::pdf_each`] along one line of sight.
    fn pdf_along(&self, sight: &Sight<'_>) -> Option<AreaPdf<f32>> {
        let (hit, point) = sight.surface?;
        let ray = Ray::from_exact(sight.from, sight.direction);
        let arrivals = Arrivals::one(self.shape.as_ref(), &ray, hit);
        Some(Self::pdf_each(&[self], &arrivals, &Interaction::from(*point)))
    }
}

/// Where rays arrive at the side that emits.
#[inline(always)]
fn is_front<R: Real>(arrivals: &Arrivals<'_, R>, surface: &Interaction<R>) -> R::Mask {
    surface.geometric_normal.dot(arrivals.direction).lt(0.0)
}

/// With which densities what is seen of a light is chosen, in each lane.
#[derive(Clone, Copy, Debug)]
pub(super) struct AreaPdf<R: Real> {
    /// See [`Emitter::pdf_toward`].
    pub(super) pdf: R,
    /// See [`Emitter::part_pdf_toward`].
    pub(super) part: R::Each<u32>,
    /// The same.
    pub(super) part_pdf: R,
}

impl Emitter for Area {
    fn sample_toward(&self, from: DVec3, u: DVec2) -> Option<EmitterSample> {
        Self::sample::<f32>(&[self], &[None], from.into(), u.into()).lane(0)
    }

    fn pdf_toward(&self, sight: &Sight<'_>) -> f32 {
        self.pdf_along(sight).map_or(0.0, |seen| seen.pdf)
    }

    fn radiance(&self, sight: &Sight<'_>) -> Rgb {
        let Some((hit, point)) = sight.surface else { return Rgb::ZERO };
        let ray = Ray::from_exact(sight.from, sight.direction);
        let arrivals = Arrivals::one(self.shape.as_ref(), &ray, hit);
        Self::radiance_each::<f32>(&[self], &arrivals, &Interaction::from(*point)).into()
    }

    fn area(&self) -> Option<&Area> {
        Some(self)
    }

    fn parts(&self) -> Vec<EmitterBounds> {
        let part = |primitive| {
            let (space, normals) = self.shape.primitive_extent(primitive);
            let share = self.primitives.probability(primitive);
            EmitterBounds::surface(space, normals, self.power * share / PI)
        };
        let parts = (0..self.shape.primitive_count()).map(part);
        if self.is_split() {
            parts.collect()
        } else {
            parts.reduce(|a, b| a.union(&b)).into_iter().collect()
        }
    }

    fn sample_part_toward(&self, part: usize, from: DVec3, u: DVec2) -> Option<EmitterSample> {
        Self::sample::<f32>(&[self], &[Some(part as u32)], from.into(), u.into()).lane(0)
    }

    fn part_pdf_toward(&self, sight: &Sight<'_>) -> (usize, f32) {
        self.pdf_along(sight).map_or((0, 0.0), |seen| (seen.part[0] as usize, seen.part_pdf))
    }

    fn is_textured(&self) -> bool {
        self.radiance.varies()
    }

    fn power(&self) -> Option<f64> {
        Some(self.power)
    }
}

/// For each primitive about its mean luminance; finite and above 0.
fn luminances(shape: &dyn Shape, texture: &dyn Texture) -> impl Iterator<Item = f32> {
    // One whose mean is 0 need not be black: pixels may be below 0, or lie outside of the unit square.
    let mean = texture.mean().clamp(f32::MIN_POSITIVE, f32::MAX);
    let count = shape.primitive_count();
    (0..count).map(move |primitive| {
        if count == 1 {
            return mean;
        }
        let at = |place| {
            let ray = Ray::new(Vec3A::ZERO, Vec3A::Z);
            let uv = shape.uv(&ray, &hit_at(primitive, 0.0, place));
            luminance(texture.rgb(uv).max(Rgb::ZERO)) / PLACES.len() as f32
        };
        let here: f32 = PLACES.into_iter().map(at).sum();
        FLOOR * mean + (1.0 - FLOOR) * here
    })
}

/// A hit of a primitive at the surface parameters `at`.
fn hit_at(primitive: usize, t: f32, at: Vec2) -> Hit {
    Hit { t, u: at.x, v: at.y, shape: 0, primitive: primitive as u32, member: 0 }
}

/// The density as an f32: a finite one even where a light of a solid angle below 1e-38 has a greater.
#[inline(always)]
fn narrow<D: Double>(pdf: D) -> D::Real {
    let pdf = pdf.narrow();
    D::Real::select(pdf.gt(f32::MAX), f32::MAX, pdf)
}
