//! Light sources: the contract that each keeps, one file for each, and the choice among them.

use std::fmt::Debug;

use glam::{DVec2, DVec3, Vec3A};

use self::rows::{BackgroundRows, EmitterSampleRows, SampleRows, SightRows};
use crate::math::real::Level;
use crate::math::{Rgb, type_word};
use crate::ray::Hit;
use crate::shape::SurfacePoint;

pub mod area;
pub mod bounds;
pub mod candidates;
pub mod choice;
pub mod choice_policy;
pub mod constant;
pub mod directional;
pub mod environment_map;
mod importance;
pub mod light;
pub mod light_bvh;
mod light_list;
pub mod light_sampler;
pub mod parts;
pub mod point;
pub mod rows;
pub mod sample;
pub mod spot;

pub use area::Area;
pub use bounds::EmitterBounds;
pub use candidates::Candidates;
pub use choice::{Chosen, EmitterChoice, Receiver, Receivers};
pub use choice_policy::ChoicePolicy;
pub use constant::Constant;
pub use directional::Directional;
pub use environment_map::EnvironmentMap;
pub use light::Light;
pub use light_bvh::LightBvh;
pub use light_sampler::LightSampler;
pub use parts::{LightChoice, LightChoices};
pub use point::Point;
pub use sample::{EmitterSample, EmitterSamples, LightOrigin};
pub use spot::Spot;

/// A source of light.
pub trait Emitter: Debug + Send + Sync {
    /// A direction in which light from this emitter may arrive at `from`, chosen by `u` in `[0, 1)²`, of
    /// which x may have to serve a choice among millions. `None` where none can.
    fn sample_toward(&self, from: DVec3, u: DVec2) -> Option<EmitterSample>;

    /// Density with which [`Emitter::sample_toward`] chooses what is seen, in sr⁻¹; 0 for an emitter
    /// that no ray can hit.
    fn pdf_toward(&self, sight: &Sight<'_>) -> f32;

    /// Radiance that arrives along the line of sight, in W·m⁻²·sr⁻¹.
    fn radiance(&self, sight: &Sight<'_>) -> Rgb;

    /// Emitted power in W, as luminance. `None` for an emitter outside the scene: what of its light enters
    /// grows with the scene, and says nothing about what arrives at a point. Guides the choice among emitters,
    /// so a rough value costs noise but no bias.
    fn power(&self) -> Option<f64>;

    /// Whether it is all around and the same in every direction. What a surface makes of that follows from how it
    /// scatters alone, so that directions which it scatters to find such a light better than any that the light chooses.
    fn is_uniform(&self) -> bool {
        false
    }

    /// Bounds of what may be chosen by itself: of the emitter, or of each primitive of one that has many. None for
    /// an emitter outside the scene.
    fn parts(&self) -> Vec<EmitterBounds>;

    /// As [`Emitter::sample_toward`], among the points of one of its parts.
    fn sample_part_toward(&self, _part: usize, from: DVec3, u: DVec2) -> Option<EmitterSample> {
        self.sample_toward(from, u)
    }

    /// [`Emitter::sample_part_toward`], or without parts [`Emitter::sample_toward`], in eight lanes, with the same bits. One
    /// after the other, unless the emitter does better.
    fn sample_eight(&self, _level: Level, asked: &SampleRows, samples: &mut EmitterSampleRows) {
        rows::lane_by_lane(self, asked, samples);
    }

    /// [`Emitter::radiance`] and [`Emitter::pdf_toward`] along eight rays that have left the scene. One after the other, unless
    /// the emitter does better.
    fn background_eight(&self, _level: Level, sights: &SightRows, seen: &mut BackgroundRows) {
        rows::background_lane_by_lane(self, sights, seen);
    }

    /// The emitter if it is a surface: those are sampled together, whatever surfaces they are.
    fn area(&self) -> Option<&Area> {
        None
    }

    /// The part that is seen, and the density with which [`Emitter::sample_part_toward`] chooses what is seen if it
    /// is asked for that part.
    fn part_pdf_toward(&self, sight: &Sight<'_>) -> (usize, f32) {
        (0, self.pdf_toward(sight))
    }

    /// Whether what it emits depends on texture coordinates.
    fn is_textured(&self) -> bool {
        false
    }

    /// Name of the emitter's type, for reports.
    fn kind(&self) -> &'static str {
        type_word::<Self>()
    }
}

/// What a ray that left `from` sees of an emitter.
#[derive(Clone, Copy, Debug)]
pub struct Sight<'a> {
    /// Where the ray started.
    pub from: DVec3,
    /// Its unit direction.
    pub direction: Vec3A,
    /// The hit and the point of the surface there; `None` if the ray left the scene.
    pub surface: Option<(&'a Hit, &'a SurfacePoint)>,
}
