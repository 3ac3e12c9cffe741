//! One lane and eight: the same bits at every level, for all that a path asks.

mod support;

use glam::Vec3A;
use support::materials::{Material, materials};
use support::{corners, points};
use telamon::bsdf::{BsdfSample, Lobe, Scattered};
use telamon::math::real::{Lanes, Level, Mask, Real, Simd, Task, f32x8};
use telamon::math::vector::{Vec2, Vec3};
use telamon::math::warp;

/// The bits of numbers, of NaN always the same ones.
fn bits<const N: usize>(numbers: [f32; N]) -> [u32; N] {
    numbers.map(|x| if x.is_nan() { f32::NAN.to_bits() } else { x.to_bits() })
}

/// What a material is asked, eight at a time.
#[derive(Clone, Copy)]
struct Questions {
    wi: [Vec3; 8],
    wo: [Vec3; 8],
    u: [Vec2; 8],
}

/// What is evaluated and sampled in each lane.
type Answers = [([f32; 4], Option<BsdfSample>); 8];

#[derive(Clone, Copy)]
struct Ask<'a>(&'a Material, Questions);

impl Task for Ask<'_> {
    type Output = Answers;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Answers {
        let Self(material, Questions { wi, wo, u }) = self;
        let place = telamon::bsdf::Place {
            uv: Vec2::splat(simd, material.place.uv),
            dp_du: Vec3::splat(simd, material.place.dp_du),
            dp_dv: Vec3::splat(simd, material.place.dp_dv),
            geometric_normal: Vec3::splat(simd, material.place.geometric_normal),
        };
        let wi = Vec3::<f32x8<S>>::load(simd, &wi);
        let (value, pdf) = material.bsdf.evaluate(&place, wi, Vec3::load(simd, &wo));
        let sample = material.bsdf.scatter(&place, wi, Vec2::load(simd, &u));
        std::array::from_fn(|i| {
            let [r, g, b] = value.lane(i).to_array();
            ([r, g, b, pdf.lane(i)], lane_of(&sample, i))
        })
    }
}

fn lane_of<R: Real>(sample: &Scattered<R>, i: usize) -> Option<BsdfSample> {
    let lobe = match (sample.is_delta.lane(i), sample.is_null.lane(i)) {
        (false, _) => Lobe::Smooth,
        (true, false) => Lobe::Delta,
        (true, true) => Lobe::Null,
    };
    sample.exists.lane(i).then(|| BsdfSample {
        wo: sample.wo.lane(i).into(),
        weight: sample.weight.lane(i).into(),
        pdf: sample.pdf.lane(i),
        lobe,
        eta: sample.eta.lane(i),
    })
}

/// All of a sample as bits.
fn sample_bits(sample: Option<BsdfSample>) -> Option<([u32; 8], Lobe)> {
    let BsdfSample { wo, weight, pdf, lobe, eta } = sample?;
    Some((bits([wo.x, wo.y, wo.z, weight.x, weight.y, weight.z, pdf, eta]), lobe))
}

/// Directions all around, some in the horizon, at the poles, and such as are no directions.
fn directions(seed: u64) -> impl Iterator<Item = Vec3> {
    let special = [
        Vec3A::Z,
        Vec3A::NEG_Z,
        Vec3A::X,
        Vec3A::new(0.0, 1.0, -0.0),
        Vec3A::new(1.0, 0.0, 1e-40),
        Vec3A::ZERO,
        Vec3A::NAN,
        Vec3A::new(0.0, 0.6, 0.8),
    ];
    let random = points(seed, 992).map(|u| warp::square_to_uniform_sphere(u.into()));
    special.map(Vec3::from).into_iter().chain(random)
}

#[test]
fn materials_have_one_form() {
    let wi: Vec<_> = directions(90).collect();
    let wo: Vec<_> = directions(91).skip(3).chain(directions(91).take(3)).collect();
    let u: Vec<Vec2> = corners().chain(points(92, 996)).map(Vec2::from).collect();
    for material in &materials() {
        for i in (0..1000).step_by(8) {
            let questions = Questions {
                wi: std::array::from_fn(|lane| wi[i + lane]),
                wo: std::array::from_fn(|lane| wo[i + lane]),
                u: std::array::from_fn(|lane| u[i + lane]),
            };
            for level in [Level::baseline(), Level::detect()] {
                let answers = level.run(Ask(material, questions));
                for (lane, (value, sample)) in answers.into_iter().enumerate() {
                    let (wi, wo) = (wi[i + lane].into(), wo[i + lane].into());
                    let [r, g, b] = material.eval(wi, wo).to_array();
                    let alone = bits([r, g, b, material.pdf(wi, wo)]);
                    let name = material.name();
                    assert_eq!(bits(value), alone, "{name}, {level:?}: {wi} {wo}");
                    let alone = sample_bits(material.sample(wi, u[i + lane].into()));
                    assert_eq!(sample_bits(sample), alone, "{name}, {level:?}: {wi}, lane {lane}");
                }
            }
        }
    }
}
