//! Reconstruction filters, by importance sampling.
//!
//! A sample's position is drawn in proportion to the filter around its pixel and its value then counts
//! with weight 1 for this pixel alone (Ernst, Stamminger and Greiner, "Filter Importance Sampling",
//! 2006). No sample is shared between pixels: their noise stays uncorrelated, the estimate unbiased,
//! and no pixel depends on the order in which threads finish.

use crate::math::discrete::ONE_MINUS_ULP;
use crate::math::real::Real;
use crate::math::vector::Vec2;
use crate::property::{Bounds, Default, Given, Kind, PropertyInfo, property};

/// A reconstruction filter, separable and not negative; lengths in pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Filter {
    /// The pixel itself.
    Box,
    /// Falls linearly to 0 at `radius`.
    Tent {
        /// Where it reaches 0.
        radius: f32,
    },
    /// A Gaussian lowered so that it reaches 0 at four standard deviations.
    Gaussian {
        /// Standard deviation.
        stddev: f32,
    },
}

/// What there is to know about a kind of filter.
#[derive(Debug)]
pub struct About {
    /// Its name in scene files and for `measure`.
    pub name: &'static str,
    /// What it is, in a sentence.
    pub help: &'static str,
    /// Its length, if it has one.
    pub properties: &'static [PropertyInfo],
    /// The filter of that length.
    build: fn(f32) -> Filter,
}

/// All kinds of filters.
pub static KINDS: &[About] = &[
    About { name: "box", help: "The pixel itself.", properties: &[], build: |_| Filter::Box },
    About {
        name: "tent",
        help: "Falls linearly from the pixel's centre.",
        properties: &[property(
            "radius",
            Kind::Float(Bounds::Positive),
            Default::Float(1.0),
            "where it reaches 0, in pixels",
        )],
        build: |radius| Filter::Tent { radius },
    },
    GAUSSIAN,
];

/// The filter of films that have none.
pub(crate) const GAUSSIAN: About = About {
    name: "gaussian",
    help: "A Gaussian cut off at four standard deviations; the filter of films that have none.",
    properties: &[property(
        "stddev",
        Kind::Float(Bounds::Positive),
        Default::Float(0.5),
        "standard deviation in pixels",
    )],
    build: |stddev| Filter::Gaussian { stddev },
};

impl About {
    /// The filter that was told its length, or not.
    pub(crate) fn read(&self, given: &dyn Given) -> Filter {
        let length = self.properties.first().and_then(|length| given.number(length));
        (self.build)(length.unwrap_or_default() as f32)
    }

    /// The filter of this kind that `text` says: its name, and after a colon the length.
    fn parse(&self, text: &str) -> Option<Filter> {
        let rest = text.strip_prefix(self.name)?;
        match self.properties {
            [] => rest.is_empty().then(|| (self.build)(0.0)),
            [length, ..] => {
                length.kind.parse(rest.strip_prefix(':')?).map(|v| (self.build)(v.number()))
            }
        }
    }
}

impl Filter {
    /// The filter that `text` says, as [`Filter::words`] has it.
    #[must_use]
    pub fn parse(text: &str) -> Option<Self> {
        KINDS.iter().find_map(|kind| kind.parse(text))
    }

    /// What [`Filter::parse`] takes, in words.
    #[must_use]
    pub fn words() -> String {
        let form = |kind: &About| match kind.properties {
            [] => kind.name.to_owned(),
            [length, ..] => format!("{}:{}", kind.name, length.name.to_uppercase()),
        };
        let forms: Vec<_> = KINDS.iter().map(form).collect();
        let (last, others) = forms.split_last().expect("there are filters");
        format!("{} or {last}, in pixels above 0", others.join(", "))
    }

    /// What it is, for reports.
    #[must_use]
    pub fn describe(self) -> String {
        match self {
            Self::Box => "box filter".to_owned(),
            Self::Tent { radius } => format!("tent filter of radius {radius}"),
            Self::Gaussian { stddev } => format!("Gaussian filter of standard deviation {stddev}"),
        }
    }
}

/// Draws positions in proportion to a filter.
#[derive(Clone, Debug)]
pub struct FilterSampler {
    profile: Profile,
}

/// A filter along one axis; the filter is the product of both axes' profiles.
#[derive(Clone, Debug)]
enum Profile {
    Box,
    Tent { radius: f32 },
    Tabulated(Table),
}

/// A density on `[-radius, radius]`, constant in each of equal cells.
#[derive(Clone, Debug)]
struct Table {
    radius: f32,
    /// Probability of lying left of each cell's left edge, and 1.
    cumulative: Vec<f32>,
    /// For equal steps of the number that is inverted, the cell in which to begin the search.
    guide: Vec<u16>,
}

/// Where a Gaussian is cut off, in standard deviations (as in Mitsuba).
const CUTOFF: f32 = 4.0;
/// Cells of a table. With 128 cells to a standard deviation the variance is 5e-6 too large.
const CELLS: usize = 1024;

impl FilterSampler {
    /// A sampler of `filter`.
    #[must_use]
    pub fn new(filter: Filter) -> Self {
        let profile = match filter {
            Filter::Box => Profile::Box,
            Filter::Tent { radius } => Profile::Tent { radius },
            Filter::Gaussian { stddev } => {
                let cut = f64::from(CUTOFF * CUTOFF);
                Profile::Tabulated(Table::new(CUTOFF * stddev, |x| {
                    (-0.5 * cut * x * x).exp() - (-0.5 * cut).exp()
                }))
            }
        };
        Self { profile }
    }

    /// An offset from the centre of the pixel, in pixels, for `u` in `[0, 1)²`.
    #[must_use]
    #[inline(always)]
    pub fn sample<R: Real>(&self, u: Vec2<R>) -> Vec2<R> {
        Vec2::new(self.profile.sample(u.x), self.profile.sample(u.y))
    }
}

impl Profile {
    #[inline(always)]
    fn sample<R: Real>(&self, u: R) -> R {
        match self {
            Self::Box => u - 0.5,
            Self::Tent { radius } => {
                let side = R::splat(u.token(), *radius).copysign(u - 0.5);
                // 1 − |2u − 1| is uniform, and its square root has the density of a ramp.
                let uniform = (u * 2.0 - 1.0).abs().one_minus();
                side * uniform.sqrt().one_minus()
            }
            Self::Tabulated(table) => R::from_fn(u.token(), |i| table.sample(u.lane(i))),
        }
    }
}

impl Table {
    /// Tabulates `density`, given on `[-1, 1]` up to a factor.
    fn new(radius: f32, density: impl Fn(f64) -> f64) -> Self {
        let mut sums = vec![0.0];
        for cell in 0..CELLS {
            let center = 2.0 * (cell as f64 + 0.5) / CELLS as f64 - 1.0;
            sums.push(sums[cell] + density(center));
        }
        let cumulative: Vec<f32> = sums.iter().map(|s| (s / sums[CELLS]) as f32).collect();
        let guide = (0..CELLS)
            .map(|step| {
                let u = step as f32 / CELLS as f32;
                (cumulative.partition_point(|&c| c <= u) - 1) as u16
            })
            .collect();
        Self { radius, cumulative, guide }
    }

    /// Inverts the cumulative distribution (Chen and Asau's guide table).
    fn sample(&self, u: f32) -> f32 {
        let u = u.min(ONE_MINUS_ULP);
        let mut cell = usize::from(self.guide[(u * CELLS as f32) as usize]);
        while self.cumulative[cell + 1] <= u {
            cell += 1;
        }
        let (low, high) = (self.cumulative[cell], self.cumulative[cell + 1]);
        let place = (cell as f32 + (u - low) / (high - low)) / CELLS as f32;
        self.radius * (2.0 * place - 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A name, and a length after it where there is one.
    #[test]
    fn filters_are_told_in_one_word() {
        assert_eq!(Filter::words(), "box, tent:RADIUS or gaussian:STDDEV, in pixels above 0");
        assert_eq!(Filter::parse("box"), Some(Filter::Box));
        assert_eq!(Filter::parse("tent:1.5"), Some(Filter::Tent { radius: 1.5 }));
        assert_eq!(Filter::parse("gaussian:0.5"), Some(Filter::Gaussian { stddev: 0.5 }));
        for bad in ["", "box:1", "tent", "tent:", "tent:0", "tent:NaN", "gaussian:1e-60", "boxes"] {
            assert_eq!(Filter::parse(bad), None, "{bad}");
        }
    }

    /// Mean of |x| and of x² under a filter, by stratified numbers.
    fn moments(filter: Filter) -> (f64, f64) {
        let sampler = FilterSampler::new(filter);
        let n = 100_000;
        let mut sums = (0.0, 0.0);
        for i in 0..n {
            let u = (i as f32 + 0.5) / n as f32;
            let x = f64::from(sampler.sample(Vec2::new(u, 0.5)).x);
            sums = (sums.0 + x.abs() / f64::from(n), sums.1 + x * x / f64::from(n));
        }
        sums
    }

    /// Box of width 1: 1/4 and 1/12. Tent of radius r: r/3 and r²/6. Gaussian: σ√(2/π) and σ² less what
    /// the cut at 4σ takes, which quadrature gives as below.
    #[test]
    fn moments_are_those_of_the_filter() {
        let close =
            |(a, b): (f64, f64), c: f64, d: f64| (a - c).abs() < 2e-5 && (b - d).abs() < 2e-5;
        assert!(close(moments(Filter::Box), 0.25, 1.0 / 12.0));
        assert!(close(moments(Filter::Tent { radius: 1.5 }), 0.5, 0.375));
        let (mut mass, mut first, mut second) = (0.0, 0.0, 0.0);
        for i in 0..200_000 {
            let x = (f64::from(i) + 0.5) * (4.0 / 200_000.0);
            let w = (-0.5 * x * x).exp() - (-8f64).exp();
            (mass, first, second) = (mass + w, first + w * x, second + w * x * x);
        }
        let sigma = 0.5;
        let gaussian = moments(Filter::Gaussian { stddev: 0.5 });
        assert!(
            close(gaussian, sigma * first / mass, sigma * sigma * second / mass),
            "{gaussian:?}"
        );
    }

    #[test]
    fn samples_stay_within_the_radius() {
        for (filter, radius) in [
            (Filter::Box, 0.5),
            (Filter::Tent { radius: 1.0 }, 1.0),
            (Filter::Gaussian { stddev: 0.5 }, 2.0),
        ] {
            let sampler = FilterSampler::new(filter);
            for u in [0.0, 0.25, 0.5, ONE_MINUS_ULP] {
                let x = sampler.sample(Vec2::new(u, u));
                assert!(x.x.abs() <= radius && x.y.abs() <= radius, "{filter:?} {u}: {x:?}");
            }
        }
    }
}
