//! Materials and textures.

use std::sync::Arc;

use crate::support::materials::{Material, materials};
use crate::support::{corners, points};
use glam::{Affine2, Vec3A};
use half::f16;
use telamon::bsdf::{BsdfSample, Lobe};
use telamon::math::real::{Lanes, Level, Simd, Task, f32x8};
use telamon::math::vector::{Vec2, Vec3};
use telamon::math::warp;
use telamon::texture::bitmap::{BitmapFilter, BitmapSettings, Encoding, Wrap};
use telamon::texture::image::Texels;
use telamon::texture::{Bitmap, Checkerboard, Image, Texture, Textured};

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
            ([r, g, b, pdf.lane(i)], sample.lane(i))
        })
    }
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

/// Pictures of all kinds of texels, filters and borders, and a board of two of them.
fn textures() -> Vec<Arc<dyn Texture>> {
    let byte = |i: u32| (i * 37 % 251) as u8;
    let grey = || (0..35).map(byte);
    let color = || (0..105).map(byte);
    let kinds = [
        (1, Texels::Unorm8(grey().collect())),
        (3, Texels::Unorm8(color().collect())),
        (3, Texels::Unorm16(color().map(|v| u16::from(v) * 257).collect())),
        (1, Texels::Half(grey().map(|v| f16::from_f32(v.into())).collect())),
        (3, Texels::Float(color().map(|v| f32::from(v) - 100.0).collect())),
    ];
    let to_uv = Affine2::from_scale_angle_translation(
        glam::Vec2::new(1.5, -0.75),
        0.4,
        glam::Vec2::new(0.2, 0.3),
    );
    let mut textures: Vec<Arc<dyn Texture>> = Vec::new();
    for (channels, texels) in kinds {
        let image = Image::new(7, 5, channels, texels).expect("as many texels as pixels");
        let image = Arc::new(image);
        for filter in [BitmapFilter::Nearest, BitmapFilter::Bilinear] {
            for wrap in [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp] {
                let settings = BitmapSettings { encoding: Encoding::Srgb, filter, wrap, to_uv };
                textures.push(Arc::new(Bitmap::new(Arc::clone(&image), settings)));
            }
        }
    }
    let colors = [Textured::Varying(Arc::clone(&textures[9])), Textured::Uniform(Vec3A::X)];
    let board = Checkerboard::new(colors, to_uv);
    textures.push(board.clamped([0.1, 0.5]));
    textures.push(Arc::new(board));
    textures
}

#[derive(Clone, Copy)]
struct LookUp<'a>(&'a dyn Texture, [Vec2; 8]);

impl Task for LookUp<'_> {
    type Output = [[f32; 6]; 8];

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> [[f32; 6]; 8] {
        let uv = Vec2::<f32x8<S>>::load(simd, &self.1);
        let (color, number, slope) = (self.0.color(uv), self.0.number(uv), self.0.slope(uv));
        std::array::from_fn(|i| {
            let ([r, g, b], [u, v]) = (color.lane(i).to_array(), slope.lane(i).to_array());
            [r, g, b, number.lane(i), u, v]
        })
    }
}

/// Also at places that are none, and far from the picture.
#[test]
fn textures_have_one_form() {
    let special = [
        [0.0, 1.0],
        [-0.0, 0.5],
        [1e8, -1e8],
        [f32::MAX, 1e30],
        [f32::NAN, 0.3],
        [0.3, f32::INFINITY],
        [f32::NEG_INFINITY, f32::NAN],
        [1e-40, -1e-40],
    ];
    let random = points(93, 992).map(|u| Vec2::from(u * 6.0 - 3.0));
    let places: Vec<Vec2> = special.map(Vec2::from).into_iter().chain(random).collect();
    for texture in &textures() {
        for uv in places.chunks_exact(8) {
            let uv = std::array::from_fn(|lane| uv[lane]);
            for level in [Level::baseline(), Level::detect()] {
                let answers = level.run(LookUp(texture.as_ref(), uv));
                for (answer, uv) in answers.into_iter().zip(uv) {
                    let uv = uv.into();
                    let ([r, g, b], [u, v]) =
                        (texture.rgb(uv).to_array(), texture.gradient(uv).to_array());
                    let alone = [r, g, b, texture.scalar(uv), u, v];
                    assert_eq!(bits(answer), bits(alone), "{texture:?}, {level:?}: {uv}");
                }
            }
        }
    }
}
