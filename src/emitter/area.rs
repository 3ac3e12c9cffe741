//! Surfaces that emit.

use std::f64::consts::PI;
use std::sync::Arc;

use glam::{DVec2, DVec3, Vec2, Vec3A};

use super::sample::{EmitterSampleRows, SampleRows};
use super::{Emitter, EmitterBounds, EmitterSample, EmitterSamples, Sight};
use crate::math::discrete::ONE_MINUS_ULP;
use crate::math::real::{Double, Float, Lanes, Level, Mask, Real, Simd, Task, f32x8, f64x8};
use crate::math::{Choices, Discrete, Rgb, luminance, vector as real};
use crate::ray::{Hit, Ray, RayEnds};
use crate::shape::{Shape, ShapeSamples, SurfacePoint};
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

    /// Radiance of a point of the front, seen along a ray that starts at `from`. Channels below 0 count as 0.
    fn radiance_at(&self, from: DVec3, direction: Vec3A, hit: &Hit) -> Rgb {
        match &self.radiance {
            Textured::Uniform(radiance) => *radiance,
            Textured::Varying(texture) => self.texel(texture.as_ref(), from, direction, hit),
        }
    }

    /// The same where it varies.
    fn texel(&self, texture: &dyn Texture, from: DVec3, direction: Vec3A, hit: &Hit) -> Rgb {
        let uv = self.shape.uv(&Ray::from_exact(from, direction), hit);
        texture.rgb(uv).max(Rgb::ZERO)
    }

    /// Whether it is chosen by primitives: they lie apart or face apart. A square's two triangles do not.
    fn is_split(&self) -> bool {
        self.shape.primitive_count() > 2
    }

    /// A point of one primitive in each lane, which was chosen with this probability. Triangles are sampled together, other
    /// shapes and textured light one lane after the other.
    #[inline(always)]
    fn sample_primitives<R: Real>(
        &self,
        primitives: &R::Each<u32>,
        probability: R::Double,
        from: real::Vec3<R::Double>,
        u: real::Vec2<R::Double>,
    ) -> EmitterSamples<R> {
        let u = u.narrow().map(|u| u.min(ONE_MINUS_ULP));
        let samples = ShapeSamples::<R>::new(self.shape.as_ref(), primitives, from, u);
        let ShapeSamples { exists, position, parameters, normal, direction, pdf, .. } = samples;
        let radiance = match &self.radiance {
            Textured::Uniform(radiance) => real::Vec3::splat(u.x.token(), (*radiance).into()),
            Textured::Varying(texture) => real::Vec3::from_fn(u.x.token(), |i| {
                let [from, to] = [from, position].map(|point| DVec3::from(point.lane(i)));
                let distance = (to - from).length() as f32;
                let primitive = primitives.as_ref()[i] as usize;
                let hit = hit_at(primitive, distance, parameters.lane(i).into());
                self.texel(texture.as_ref(), from, direction.lane(i).into(), &hit).into()
            }),
        };
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

    /// A point of the part that is named in each lane, or of any.
    #[inline(always)]
    fn sample<R: Real>(
        &self,
        parts: Option<R::Each<u32>>,
        from: real::Vec3<R::Double>,
        u: real::Vec2<R::Double>,
    ) -> EmitterSamples<R> {
        let Choices { index, probability, rest } = match parts {
            Some(index) if self.is_split() => {
                let probability = R::Double::splat(u.x.token(), 1.0);
                Choices { index, probability, rest: u.x }
            }
            _ => self.primitives.sample_each::<R>(u.x),
        };
        self.sample_primitives(&index, probability, from, real::Vec2::new(rest, u.y))
    }
}

/// [`Emitter::sample_eight`] of an [`Area`].
struct Sample<'a> {
    area: &'a Area,
    asked: &'a SampleRows,
    samples: &'a mut EmitterSampleRows,
}

impl Task for Sample<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let Self { area, asked, samples: output } = self;
        let from = asked.from.load::<f64x8<S>>(simd).into();
        let u = asked.u.load::<f64x8<S>>(simd).into();
        let samples = area.sample::<f32x8<S>>(asked.parts, from, u);
        output.store(&samples);
    }
}

impl Emitter for Area {
    fn sample_toward(&self, from: DVec3, u: DVec2) -> Option<EmitterSample> {
        self.sample::<f32>(None, from.into(), u.into()).lane(0)
    }

    fn pdf_toward(&self, sight: &Sight<'_>) -> f32 {
        match sight.surface {
            Some((hit, point)) if is_front(point, sight.direction) => {
                let primitive = hit.primitive as usize;
                let pdf = self.shape.primitive_pdf(primitive, sight.from, point);
                narrow(pdf * self.primitives.probability(primitive))
            }
            _ => 0.0,
        }
    }

    fn radiance(&self, sight: &Sight<'_>) -> Rgb {
        match sight.surface {
            Some((hit, point)) if is_front(point, sight.direction) => {
                self.radiance_at(sight.from, sight.direction, hit)
            }
            _ => Rgb::ZERO,
        }
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
        self.sample::<f32>(Some([part as u32]), from.into(), u.into()).lane(0)
    }

    fn sample_eight(&self, level: Level, asked: &SampleRows, samples: &mut EmitterSampleRows) {
        level.run(Sample { area: self, asked, samples });
    }

    fn part_pdf_toward(&self, sight: &Sight<'_>) -> (usize, f32) {
        match sight.surface {
            Some((hit, point)) if self.is_split() && is_front(point, sight.direction) => {
                let primitive = hit.primitive as usize;
                (primitive, narrow(self.shape.primitive_pdf(primitive, sight.from, point)))
            }
            _ => (0, self.pdf_toward(sight)),
        }
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

/// Whether `direction` arrives at the side that emits.
fn is_front(point: &SurfacePoint, direction: Vec3A) -> bool {
    point.geometric_normal.dot(direction) < 0.0
}

/// The density as an f32: a finite one even where a light of a solid angle below 1e-38 has a greater.
#[inline(always)]
fn narrow<D: Double>(pdf: D) -> D::Real {
    let pdf = pdf.narrow();
    D::Real::select(pdf.gt(f32::MAX), f32::MAX, pdf)
}
