//! Samples of a tile's pixels, taken one after the other.

use super::{Description, EXAMPLES, SECOND_HALF, SampleId, allocation, content};
use crate::film::{Content, Film, FilterSampler, Tile};
use crate::integrator::{self, Aov, Estimate, Integrator, RayCounts, Tracer};
use crate::intersect::Intersector;
use crate::math::Rgb;
use crate::ray::Ray;
use crate::sampler::{self, Sampler, SamplerSettings};

/// Side of the squares of pixels of which one comes first in a [coarse](Part::Coarse) step.
const COARSE: u32 = 8;

/// Which pixels of a tile get samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Part {
    /// The middle one of each square of 8x8: enough to see what the picture will be, at a 64th of its cost. Not
    /// the first of the tile, whose number of samples stands for that of all.
    Coarse,
    /// All that have too few.
    Whole,
}

impl Part {
    /// Whether it has the pixel in this column and row of a tile.
    fn has(self, column: u32, row: u32) -> bool {
        let is_middle = |at: u32| at % COARSE == COARSE / 2;
        self == Self::Whole || (is_middle(column) && is_middle(row))
    }
}

/// What a tile's samples need.
pub(super) struct Renderer<'a> {
    pub(super) description: &'a Description,
    engine: &'a dyn Intersector,
    /// Seed and numbers of each half of the samples.
    samplers: Vec<(u64, Box<dyn Sampler>)>,
    pub(super) filter: FilterSampler,
    /// Whether samples have a time.
    pub(super) moves: bool,
    pub(super) content: Content,
    picture: Option<Box<dyn Integrator>>,
    aov: Option<Aov<'a>>,
}

impl<'a> Renderer<'a> {
    pub(super) fn new(description: &'a Description, engine: &'a dyn Intersector) -> Self {
        let (picture, aov) = integrator::build(&description.integrator, &description.scene);
        let content = content(description);
        let seed = description.sampler.seed;
        let seeds = if content.halves { vec![seed, seed ^ SECOND_HALF] } else { vec![seed] };
        let sampler =
            |seed| (seed, sampler::build(&SamplerSettings { seed, ..description.sampler }));
        Self {
            description,
            engine,
            samplers: seeds.into_iter().map(sampler).collect(),
            filter: FilterSampler::new(description.film.filter),
            moves: description.moves(),
            content,
            picture,
            aov,
        }
    }

    /// For each tile the samples that each half of its pixels has after the next pass, which brings the mean
    /// of both together from `done` to `mean`. The first half has one more of an odd number.
    pub(super) fn ends(&self, film: &Film, done: u32, mean: u32) -> Vec<[u32; 2]> {
        if self.adaptive() {
            allocation::allocate(film, done, mean)
        } else if self.content.halves {
            vec![[mean.div_ceil(2), mean / 2]; film.tiles().len()]
        } else {
            vec![[mean, 0]; film.tiles().len()]
        }
    }

    fn adaptive(&self) -> bool {
        self.content.halves && self.description.effort.adaptive
    }

    /// Adds samples to a part of a tile until each half of its pixels has as many as `ends` says.
    pub(super) fn add_samples(&self, tile: &mut Tile, ends: &[u32; 2], part: Part) -> Tally {
        let mut tally = Tally { tiles: 1, ..Tally::default() };
        let mut tracer = Tracer::new(&self.description.scene, self.engine);
        for (half, (numbers, &end)) in self.samplers.iter().zip(ends).enumerate() {
            let mut done = tile.count(tile.cell(0, half));
            while done < end {
                let record = self.adaptive().then(|| allocation::next_record(done));
                done = record.map_or(end, |record| record.min(end));
                let target = (part, done);
                self.add_to_half(tile, half, numbers, target, &mut tracer, &mut tally);
                if record == Some(done) {
                    tile.record_noise(half);
                }
            }
        }
        tally.rays = tracer.counts;
        tally
    }

    /// Adds samples to one half of a tile until each of the part's pixels has `end`.
    fn add_to_half(
        &self,
        tile: &mut Tile,
        half: usize,
        (seed, sampler): &(u64, Box<dyn Sampler>),
        (part, end): (Part, u32),
        tracer: &mut Tracer<'_>,
        tally: &mut Tally,
    ) {
        let corner = tile.area();
        let begun: Vec<_> = tile
            .pixels()
            .enumerate()
            .filter(|&(_, (x, y))| part.has(x - corner.x, y - corner.y))
            .map(|(pixel, (x, y))| {
                let cell = tile.cell(pixel, half);
                (cell, x, y, tile.count(cell))
            })
            .collect();
        let ids = || {
            begun.iter().flat_map(|&(cell, x, y, first)| {
                (first..end).map(move |sample| (cell, SampleId { x, y, sample, seed: *seed }))
            })
        };
        let mut next = ids();
        let mut add = |estimate: Option<Estimate>, tracer: &mut Tracer<'_>| {
            let (cell, id) = next.next().expect("one estimate for each sample");
            let finite = estimate.is_none_or(|estimate| self.add_picture(tile, cell, estimate));
            if !finite {
                tally.non_finite += 1;
                if tally.examples.len() < EXAMPLES {
                    tally.examples.push(id);
                }
            }
            if let Some(aov) = &self.aov {
                // Once more: by now the path is far from the camera.
                let ray = self.begin(sampler.as_ref(), id).ray;
                self.add_layers(tile, cell, id, aov, &ray, tracer);
            }
            tile.count_sample(cell);
            tally.samples += 1;
        };
        let Some(integrator) = &self.picture else {
            ids().for_each(|_| add(None, tracer));
            return;
        };
        let mut samples = self.begin_all(sampler.as_ref(), ids().map(|(_, id)| id));
        integrator.estimates(tracer, &mut samples, &mut |estimate, tracer| {
            add(Some(estimate), tracer);
        });
    }

    /// Adds one sample to the picture; whether its value was finite. If not, it counts as black, so that the numbers of
    /// samples stay alike.
    fn add_picture(&self, tile: &mut Tile, cell: usize, estimate: Estimate) -> bool {
        let finite = estimate.radiance.is_finite();
        let Estimate { radiance, alpha } = if finite { estimate } else { Estimate::default() };
        tile.add_picture(cell, clamped(radiance, self.description.film.clamp), alpha);
        finite
    }

    /// Adds one sample to the layers.
    fn add_layers(
        &self,
        tile: &mut Tile,
        cell: usize,
        id: SampleId,
        aov: &Aov<'_>,
        ray: &Ray,
        tracer: &mut Tracer<'_>,
    ) {
        let (numbers, indices) = tile.layers_mut(cell);
        let (mut numbers, mut indices) = (numbers.iter_mut(), indices.iter_mut());
        aov.evaluate(
            tracer,
            ray,
            |value| *numbers.next().expect("as many as components") += f64::from(value),
            |value| {
                let slot = indices.next().expect("as many as layers");
                if id.sample == 0 && id.seed == self.description.sampler.seed {
                    *slot = value;
                }
            },
        );
    }
}

/// A sample whose components are `most` at most, of the same hue (as pbrt-v4's `maxcomponentvalue`).
fn clamped(radiance: Rgb, most: Option<f32>) -> Rgb {
    let largest = radiance.max_element();
    match most {
        Some(most) if largest > most => radiance * (most / largest),
        _ => radiance,
    }
}

/// Counts of one or more tiles.
#[derive(Default)]
pub(super) struct Tally {
    pub(super) tiles: usize,
    pub(super) samples: u64,
    pub(super) rays: RayCounts,
    pub(super) non_finite: u64,
    pub(super) examples: Vec<SampleId>,
}

impl Tally {
    pub(super) fn merge(mut self, other: Self) -> Self {
        self.tiles += other.tiles;
        self.samples += other.samples;
        self.rays += other.rays;
        self.non_finite += other.non_finite;
        self.examples.extend(other.examples);
        // The smallest, so that they do not depend on which tile came first.
        self.examples.sort_unstable();
        self.examples.truncate(EXAMPLES);
        self
    }
}
