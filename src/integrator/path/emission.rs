//! What paths see of emitters at the ends of their edges, with the weight of having found it that way.

use super::{Carried, LastEdge, Path, Strategy};
use crate::emitter::{Area, Receivers, Sight};
use crate::integrator::tracer::CameraView;
use crate::integrator::{Estimate, Tracer, Vertex};
use crate::math::Rgb;
use crate::math::real::{Lanes, Mask, Real};
use crate::math::vector::Vec3;
use crate::ray::Ray;
use crate::scene::Object;
use crate::shape::{Arrivals, Interaction};

/// How the newest edges were chosen: see [`LastEdge`].
#[derive(Clone, Copy, Debug)]
pub(super) struct LastEdges<R: Real> {
    /// Where it is [`LastEdge::Forced`].
    pub(super) is_forced: R::Mask,
    /// Elsewhere its density.
    pub(super) pdf: R,
    /// Elsewhere the surface that it leaves.
    pub(super) receivers: Receivers<R>,
    /// Where that is the first surface of the path that is no ideal mirror or glass.
    pub(super) is_first: R::Mask,
}

impl LastEdges<f32> {
    fn of(edge: LastEdge, ray: &Ray) -> Self {
        let (LastEdge::Chosen { pdf, flags, is_first }, Some(start)) = (edge, &ray.start) else {
            let receivers = Receivers {
                position: ray.exact_origin().into(),
                normal: Vec3::default(),
                both_sides: true,
                is_diffuse: true,
            };
            return Self { is_forced: true, pdf: 0.0, receivers, is_first: true };
        };
        let receivers = Receivers {
            position: start.point.into(),
            normal: start.facing_normal().into(),
            both_sides: flags.transmits,
            is_diffuse: !flags.glossy,
        };
        Self { is_forced: false, pdf, receivers, is_first }
    }
}

impl Path {
    /// Whether the weight of what is found depends on how likely the other technique finds it.
    #[inline(always)]
    fn compares<R: Real>(&self, edges: &LastEdges<R>) -> bool {
        matches!(self.settings.strategy, Strategy::Mis(_)) && !edges.is_forced.all()
    }

    /// The weight of having found an emitter by following the path, if the other technique finds it with the density
    /// `other`.
    #[inline(always)]
    fn weight<R: Real>(&self, edges: &LastEdges<R>, other: R) -> R {
        let weight = match self.settings.strategy {
            Strategy::Bsdf => return R::splat(other.token(), 1.0),
            Strategy::Emitter => R::splat(other.token(), 0.0),
            Strategy::Mis(heuristic) => {
                heuristic.weight(edges.pdf, other * self.settings.emitter_samples as f32)
            }
        };
        R::select(edges.is_forced, 1.0, weight)
    }

    /// Weighted radiance of the surfaces that the lanes' rays have met, where they are `emitting`.
    #[inline(always)]
    pub(super) fn emitted<'a, R: Real>(
        &self,
        tracer: &Tracer<'a>,
        object: impl Fn(usize) -> &'a Object,
        arrivals: &Arrivals<'_, R>,
        surface: &Interaction<R>,
        emitting: R::Mask,
        edges: &LastEdges<R>,
    ) -> Vec3<R> {
        let token = edges.pdf.token();
        let emitters = tracer.scene().emitters();
        let none = Vec3::splat(token, Vec3::default());
        let Some(first) = (0..R::LANES).find(|&i| emitting.lane(i)) else { return none };
        // In lanes without any, that of another will do.
        let lane = |i: usize| if emitting.lane(i) { i } else { first };
        let emitter = R::each(|i| object(lane(i)).emitter.unwrap_or_default() as u32);
        let area = R::each(|i| emitters[emitter.as_ref()[i] as usize].area());
        let mut seen = none;
        if let Some(any) = area.as_ref().iter().flatten().next() {
            let areas = R::each(|i| area.as_ref()[i].unwrap_or(any));
            let radiance = Area::radiance_each(&areas, arrivals, surface);
            let mut other = R::splat(token, 0.0);
            if self.compares(edges) {
                let LastEdges { receivers, is_first, .. } = edges;
                // By itself, as it is long and rarely needed.
                other = R::vectorize(
                    token,
                    #[inline(always)]
                    || {
                        self.lights
                            .pdf_of_areas(&emitter, &areas, receivers, *is_first, arrivals, surface)
                    },
                );
            }
            seen = radiance * self.weight(edges, other);
        }
        for i in (0..R::LANES).filter(|&i| emitting.lane(i) && area.as_ref()[i].is_none()) {
            let one = LastEdges::<f32> {
                is_forced: edges.is_forced.lane(i),
                pdf: edges.pdf.lane(i),
                receivers: edges.receivers.lane(i).into(),
                is_first: edges.is_first.lane(i),
            };
            let (surface, hit) = (surface.lane(i), arrivals.hits.as_ref()[i]);
            let sight = Sight {
                from: arrivals.origin.lane(i).into(),
                direction: arrivals.direction.lane(i).into(),
                surface: Some((&hit, &surface)),
            };
            let index = emitter.as_ref()[i] as usize;
            let receiver = edges.receivers.lane(i);
            let other = self.lights.pdf_toward(emitters, index, &receiver, one.is_first, &sight);
            let weight = self.weight(&one, other);
            let here = Vec3::splat(token, (emitters[index].radiance(&sight) * weight).into());
            seen = Vec3::select(R::mask(token, |lane| lane == i), here, seen);
        }
        seen.only_where(emitting)
    }

    /// Weighted radiance of the environment along rays that have left the scene.
    #[inline(always)]
    pub(super) fn background<R: Real>(
        &self,
        tracer: &Tracer<'_>,
        from: Vec3<R::Double>,
        direction: Vec3<R>,
        edges: &LastEdges<R>,
    ) -> Vec3<R> {
        let token = edges.pdf.token();
        let Some((index, environment)) = tracer.scene().environment() else {
            return Vec3::splat(token, Vec3::default());
        };
        let (radiance, pdf) = environment.background(from, direction);
        radiance
            * self.weight(
                edges,
                self.lights.pdf_of_emitter(index, &edges.receivers, edges.is_first, pdf),
            )
    }

    /// What a ray that leaves the scene says of the film's alpha, from the camera or on a path that has met nothing that it
    /// did not pass straight through.
    #[inline(always)]
    pub(super) fn leave(
        &self,
        tracer: &Tracer<'_>,
        from_camera: bool,
        unscattered: bool,
        estimate: &mut Estimate,
    ) {
        let alpha = if self.settings.hide_emitters { 0.0 } else { tracer.background_alpha() };
        if from_camera {
            estimate.alpha = alpha;
        } else if unscattered {
            estimate.alpha += (alpha - 1.0) / self.settings.bsdf_samples as f32;
        }
    }

    /// Adds what is seen at the end of the newest edge, `ray`, to what the path has found.
    pub(super) fn arrive(
        &self,
        tracer: &Tracer<'_>,
        ray: &Ray,
        vertex: Option<&Vertex<'_>>,
        path: &Carried,
        estimate: &mut Estimate,
    ) {
        let edges = LastEdges::of(path.edge, ray);
        let seen = match vertex {
            Some(vertex) => {
                let arrivals = Arrivals::one(vertex.object.shape.as_ref(), ray, &vertex.hit);
                let surface = Interaction::from(vertex.surface);
                let emits = vertex.object.emitter.is_some();
                self.emitted(tracer, |_| vertex.object, &arrivals, &surface, emits, &edges)
            }
            None => {
                self.leave(tracer, false, path.unscattered, estimate);
                let from = ray.exact_origin().into();
                self.background(tracer, from, ray.direction.into(), &edges)
            }
        };
        estimate.radiance += path.throughput * Rgb::from(seen);
    }

    /// The rest of a ray from the camera that looks through an emitter.
    pub(super) fn look_through(tracer: &Tracer<'_>, ray: &Ray, vertex: &Vertex<'_>) -> Option<Ray> {
        match tracer.seen_by_camera(ray, Some(vertex), true) {
            CameraView::Seen(_) => None,
            CameraView::Behind(rest) => Some(rest),
        }
    }
}
