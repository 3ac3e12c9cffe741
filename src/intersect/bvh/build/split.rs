//! Where to divide primitives, by the binned surface area heuristic.
//!
//! Wald, "On fast Construction of SAH-based Bounding Volume Hierarchies" (2007).

use glam::Vec4;
use rayon::prelude::*;

use super::partition::Around;
use super::reference::{Bounds, Reference};
use crate::intersect::bvh::LANES;

/// Bins per axis; a power of two.
const BINS: usize = 16;

/// References that a thread bins in one go.
const CHUNK: usize = 1 << 13;

/// Maps centres to bins.
#[derive(Clone, Copy, Debug)]
pub(super) struct Binning {
    base: Vec4,
    scale: Vec4,
}

impl Binning {
    fn new(centers: &Bounds) -> Self {
        let extent = centers.upper - centers.lower;
        // An axis without extent puts all in one bin.
        let scale = extent.truncate().map(|e| {
            let scale = (BINS - 1) as f32 / e;
            if scale.is_finite() { scale } else { 0.0 }
        });
        Self { base: centers.lower.with_w(0.0), scale: scale.extend(0.0) }
    }

    /// By axis. Centres are rounded to the nearest bin, by adding a number whose neighbours differ by 1.
    #[inline(always)]
    fn bins(&self, reference: &Reference) -> [usize; 4] {
        let places = (reference.center() - self.base) * self.scale + 8_388_608.0;
        places.to_array().map(|place| place.to_bits() as usize % BINS)
    }
}

/// What fell into the bins of all axes.
#[derive(Clone)]
struct Bins {
    bounds: [[Bounds; 3]; BINS],
    counts: [[u32; 3]; BINS],
}

impl Bins {
    const EMPTY: Self = Self { bounds: [[Bounds::EMPTY; 3]; BINS], counts: [[0; 3]; BINS] };

    fn fill(&mut self, references: &[Reference], binning: &Binning) {
        for reference in references {
            for (axis, bin) in binning.bins(reference).into_iter().take(3).enumerate() {
                self.bounds[bin][axis].extend(reference.lower(), reference.upper());
                self.counts[bin][axis] += 1;
            }
        }
    }

    fn merge(mut self, other: &Self) -> Self {
        for (bounds, other) in self.bounds.iter_mut().flatten().zip(other.bounds.iter().flatten()) {
            *bounds = bounds.union(other);
        }
        for (count, other) in self.counts.iter_mut().flatten().zip(other.counts.iter().flatten()) {
            *count += other;
        }
        self
    }
}

/// A plane between bins: references whose bin on the axis is below `bin` go left.
#[derive(Clone, Copy, Debug)]
pub(super) struct Split {
    axis: usize,
    bin: usize,
    binning: Binning,
    /// Around the boxes on both sides.
    pub(super) bounds: [Bounds; 2],
}

impl Split {
    #[inline(always)]
    pub(super) fn is_left(&self, reference: &Reference) -> bool {
        self.binning.bins(reference)[self.axis] < self.bin
    }
}

/// The cheapest plane; `None` if all references fall into one bin on each axis.
pub(super) fn best_split(references: &[Reference], around: &Around) -> Option<Split> {
    let binning = Binning::new(&around.centers);
    let mut bins = Bins::EMPTY;
    if references.len() < 2 * CHUNK {
        bins.fill(references, &binning);
    } else {
        // Counts and boxes are exact, so how they are merged makes no difference.
        let fill = |chunk: &[Reference]| {
            let mut bins = Bins::EMPTY;
            bins.fill(chunk, &binning);
            bins
        };
        let merge = |a: Bins, b: Bins| a.merge(&b);
        bins = references.par_chunks(CHUNK).map(fill).reduce(|| Bins::EMPTY, merge);
    }
    let measure = Measure::new(&around.bounds);
    let mut best: Option<(f32, usize, usize)> = None;
    for axis in 0..3 {
        let mut costs = [0.0; BINS];
        let mut right = (Bounds::EMPTY, 0);
        for bin in (1..BINS).rev() {
            right.0 = right.0.union(&bins.bounds[bin][axis]);
            right.1 += bins.counts[bin][axis];
            costs[bin] = measure.cost(&right.0, right.1);
        }
        let mut left = (Bounds::EMPTY, 0);
        for (bin, right) in costs.iter().enumerate().skip(1) {
            left.0 = left.0.union(&bins.bounds[bin - 1][axis]);
            left.1 += bins.counts[bin - 1][axis];
            let cost = measure.cost(&left.0, left.1) + right;
            let divides = left.1 > 0 && (left.1 as usize) < references.len();
            if divides && best.is_none_or(|(least, ..)| cost < least) {
                best = Some((cost, axis, bin));
            }
        }
    }
    let (_, axis, bin) = best?;
    let around = |bins: &[[Bounds; 3]]| bins.iter().fold(Bounds::EMPTY, |b, a| b.union(&a[axis]));
    let sides = [around(&bins.bounds[..bin]), around(&bins.bounds[bin..])];
    Some(Split { axis, bin, binning, bounds: sides })
}

/// Areas in units of the box that is divided, so that they neither overflow nor vanish.
#[derive(Clone, Copy)]
pub(super) struct Measure {
    unit: f32,
}

impl Measure {
    pub(super) fn new(bounds: &Bounds) -> Self {
        Self { unit: bounds.extent().max_element().recip().min(f32::MAX) }
    }

    pub(super) fn half_area(&self, bounds: &Bounds) -> f32 {
        let e = bounds.extent() * self.unit;
        e.x * e.y + e.y * e.z + e.z * e.x
    }

    /// Of packs that a ray tests, if it enters the box in proportion to its area.
    fn cost(&self, bounds: &Bounds, count: u32) -> f32 {
        if count == 0 { 0.0 } else { self.half_area(bounds) * count.div_ceil(LANES as u32) as f32 }
    }
}
