//! The lecture's recursive estimator, kept to show what it costs.

use super::Vertex;
use super::directions::{self, DIRECTIONS};
use super::knobs::{Knob, Needs, Turn};
use super::plugin::{Common, HIDE_EMITTERS, MOST_SAMPLES, Plugin};
use super::settings::edges;
use super::shading::Shading;
use super::{DirectionSampling, Estimate, Integrator, IntegratorSettings, Parts, Settings, Tracer};
use crate::math::Rgb;
use crate::property::given::chosen;
use crate::property::{self, Given, Kind, Nothing, PropertyInfo, property};
use crate::ray::Ray;
use crate::sampler::PathSampler;
use crate::scene::Scene;

/// All that it can be told.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BranchingSettings {
    /// N, at least 1.
    pub branches: u32,
    /// Longest path in edges, as in [`PathSettings::max_depth`](super::PathSettings::max_depth); always limited.
    pub max_depth: u32,
    /// How directions are chosen.
    pub directions: DirectionSampling,
    /// Leave emitters out of the camera's view.
    pub hide_emitters: bool,
}

const BRANCHES: PropertyInfo = property(
    "branches",
    Kind::Integer(1, MOST_SAMPLES),
    property::Default::Integer(4),
    "rays at each bounce",
);

/// Beyond, not even one sample would end.
const DEEPEST: u32 = 32;

const MAX_DEPTH: PropertyInfo = property(
    "max_depth",
    Kind::Integer(0, DEEPEST as i64),
    property::Default::Integer(3),
    "longest path in edges",
);

const BRANCHING: Plugin = Plugin {
    name: "branching",
    help: "Many rays at each bounce, whose cost grows as branches^depth (not in Mitsuba).",
    properties: &[BRANCHES, MAX_DEPTH, DIRECTIONS, HIDE_EMITTERS],
    contains: false,
    read: |told| Ok(BranchingSettings::read(told).into()),
    in_place_of: Some(|other| match other {
        IntegratorSettings::Branching(branching) => (*branching).into(),
        other => BranchingSettings::with(other.about().common()).into(),
    }),
};

static KNOBS: &[Knob<BranchingSettings>] = &[
    Knob {
        property: &MAX_DEPTH,
        needs: Needs::Integrators(&[BRANCHING.name], || {
            format!(", and the latter a limit up to {DEEPEST}")
        }),
        turn: Turn::Value(|branching, value| {
            branching.max_depth = value.count();
            true
        }),
    },
    Knob {
        property: &BRANCHES,
        needs: Needs::Integrators(&[BRANCHING.name], String::new),
        turn: Turn::Value(|branching, value| {
            branching.branches = value.count();
            true
        }),
    },
    Knob {
        property: &DIRECTIONS,
        needs: directions::NEEDS,
        turn: Turn::Value(|branching, value| {
            branching.directions = value.named();
            true
        }),
    },
];

impl BranchingSettings {
    fn read(told: &dyn Given) -> Self {
        Self {
            branches: told.count(&BRANCHES),
            max_depth: told.count(&MAX_DEPTH),
            directions: chosen(told, &DIRECTIONS),
            hide_emitters: told.boolean(&HIDE_EMITTERS),
        }
    }

    /// With what another integrator has too, as far as that goes.
    fn with(Common { max_depth, directions, hide_emitters }: Common) -> Self {
        let default = Self::default();
        let max_depth = max_depth.map_or(default.max_depth, |depth| depth.min(DEEPEST));
        Self { max_depth, directions, hide_emitters, ..default }
    }
}

impl Default for BranchingSettings {
    fn default() -> Self {
        Self::read(&Nothing)
    }
}

impl Settings for BranchingSettings {
    fn plugins() -> &'static [Plugin] {
        static PLUGINS: [Plugin; 1] = [BRANCHING];
        &PLUGINS
    }

    fn knobs() -> &'static [Knob<Self>] {
        KNOBS
    }

    fn build<'a>(&'a self, _: &Scene) -> Parts<'a> {
        let Self { branches, max_depth, directions, hide_emitters } = *self;
        (Some(Box::new(Branching::new(branches, max_depth, directions, hide_emitters))), None)
    }

    fn describe(&self) -> String {
        format!("branching, {} rays at each bounce, {}", self.branches, edges(Some(self.max_depth)))
    }

    fn common(&self) -> Common {
        let Self { max_depth, directions, hide_emitters, .. } = *self;
        Common { max_depth: Some(max_depth), directions, hide_emitters }
    }
}

/// N rays at each vertex, each of which branches again: N^depth rays for one estimate. Emitters are
/// found by directions alone.
#[derive(Debug)]
pub struct Branching {
    branches: u32,
    max_depth: u32,
    directions: DirectionSampling,
    hide_emitters: bool,
}

impl Branching {
    /// `branches` rays at each vertex, of which paths of up to `max_depth` edges come.
    #[must_use]
    pub fn new(
        branches: u32,
        max_depth: u32,
        directions: DirectionSampling,
        hide_emitters: bool,
    ) -> Self {
        Self { branches, max_depth, directions, hide_emitters }
    }

    /// Mean over N directions of what arrives at `vertex` and is scattered back along `ray`, which was
    /// edge number `edges` of its path.
    fn scattered(
        &self,
        tracer: &mut Tracer<'_>,
        ray: &Ray,
        vertex: &Vertex<'_>,
        edges: u32,
        sampler: &mut PathSampler<'_>,
    ) -> Rgb {
        if edges >= self.max_depth {
            return Rgb::ZERO;
        }
        let shading = Shading::of_vertex(vertex, ray);
        let mut sum = Rgb::ZERO;
        for _ in 0..self.branches {
            let Some((direction, weight)) = shading.scatter(self.directions, sampler) else {
                continue;
            };
            let ray = vertex.surface.spawn(direction);
            let next = tracer.closest_vertex(&ray);
            let mut arriving = tracer.emitted(&ray, next.as_ref());
            if let Some(next) = next {
                arriving += self.scattered(tracer, &ray, &next, edges + 1, sampler);
            }
            sum += weight * arriving;
        }
        sum / self.branches as f32
    }
}

impl Integrator for Branching {
    fn estimate(
        &self,
        tracer: &mut Tracer<'_>,
        ray: &Ray,
        sampler: &mut PathSampler<'_>,
    ) -> Estimate {
        let mut ray = *ray;
        let (vertex, mut estimate) = tracer.camera_vertex(&mut ray, self.hide_emitters);
        if let Some(vertex) = vertex {
            estimate.radiance += self.scattered(tracer, &ray, &vertex, 1, sampler);
        }
        estimate
    }
}
