//! The materials under test: one row for each thing worth checking, at least one for each plugin.

use std::sync::Arc;

use glam::{Affine2, Vec2, Vec3A};
use telamon::bsdf::conductor::Metal;
use telamon::bsdf::microfacet::{Distribution, Roughness};
use telamon::bsdf::perturbed::{Normals, PerturbedOptions};
use telamon::bsdf::plastic::Coat;
use telamon::bsdf::{
    Blend, Bsdf, BsdfSample, Conductor, Dielectric, Diffuse, Mask, Null, Perturbed, Place, Plastic,
    RoughConductor, RoughDielectric, RoughPlastic, ThinDielectric, TwoSided,
};
use telamon::texture::bitmap::{BitmapFilter, BitmapSettings, Encoding, Wrap};
use telamon::texture::image::Texels;
use telamon::texture::{Bitmap, Checkerboard, Image, Texture, Textured};

/// A row of the table of materials.
pub(crate) struct Material {
    /// Name of the plugin in scene files.
    pub(crate) plugin: &'static str,
    /// What is special about this row.
    pub(crate) variant: &'static str,
    pub(crate) bsdf: Box<dyn Bsdf>,
    /// Sides from which it scatters light: signs of z.
    pub(crate) sides: &'static [f32],
    /// Where on a surface it is asked.
    pub(crate) place: Place,
    /// Parts of a cell, in either direction, that its lobes are not narrow against.
    pub(crate) parts: usize,
    /// Its albedo has a closed form.
    pub(crate) exact_albedo: bool,
    /// Light and eye may change places.
    pub(crate) reciprocal: bool,
    /// No sample has a greater weight.
    pub(crate) largest_weight: f32,
}

impl Material {
    pub(crate) fn name(&self) -> String {
        format!("{} ({})", self.plugin, self.variant)
    }

    pub(crate) fn eval(&self, wi: Vec3A, wo: Vec3A) -> Vec3A {
        self.bsdf.eval(&self.place, wi, wo)
    }

    pub(crate) fn pdf(&self, wi: Vec3A, wo: Vec3A) -> f32 {
        self.bsdf.pdf(&self.place, wi, wo)
    }

    pub(crate) fn sample(&self, wi: Vec3A, u: Vec2) -> Option<BsdfSample> {
        self.bsdf.sample(&self.place, wi, u)
    }

    pub(crate) fn albedo(&self, wi: Vec3A) -> Vec3A {
        self.bsdf.albedo(&self.place, wi)
    }

    fn narrow(self) -> Self {
        Self { parts: 4, ..self }
    }

    fn inexact_albedo(self) -> Self {
        Self { exact_albedo: false, ..self }
    }

    fn one_way(self) -> Self {
        Self { reciprocal: false, ..self }
    }

    fn at(self, place: Place) -> Self {
        Self { place, ..self }
    }

    fn with_weights_up_to(self, largest_weight: f32) -> Self {
        Self { largest_weight, ..self }
    }
}

const FRONT: &[f32] = &[1.0];
const BOTH: &[f32] = &[1.0, -1.0];

fn row(
    plugin: &'static str,
    variant: &'static str,
    bsdf: impl Bsdf + 'static,
    sides: &'static [f32],
) -> Material {
    Material {
        plugin,
        variant,
        bsdf: Box::new(bsdf),
        sides,
        place: Place::default(),
        parts: 1,
        exact_albedo: true,
        reciprocal: true,
        largest_weight: 1.0,
    }
}

/// Every material of the library, at least once.
pub(crate) fn materials() -> Vec<Material> {
    let mut rows = smooth();
    rows.extend(rough());
    rows.extend(composite());
    rows.extend(perturbed());
    rows
}

fn smooth() -> Vec<Material> {
    vec![
        row("diffuse", "coloured", diffuse(Vec3A::new(0.8, 0.5, 0.1)), FRONT),
        row("diffuse", "white", diffuse(Vec3A::ONE), FRONT),
        row("diffuse", "black", diffuse(Vec3A::ZERO), FRONT),
        row("diffuse", "textured", Diffuse::new(Textured::Varying(board())), FRONT)
            .at(at(Vec2::new(0.7, 0.2))),
        row("conductor", "mirror", Conductor::mirror(Vec3A::ONE), FRONT),
        row("conductor", "gold", Conductor::new(gold()), FRONT),
        row("dielectric", "glass", dielectric(1.5, 1.0), BOTH),
        row("dielectric", "bubble", dielectric(1.0, 1.5), BOTH),
        row("dielectric", "diamond in water", dielectric(2.419, 1.333), BOTH),
        row("dielectric", "equal indices", dielectric(1.333, 1.333), BOTH),
        row("dielectric", "tinted", tinted_glass(), BOTH),
        row("thindielectric", "glass", pane(1.5, Vec3A::ONE), BOTH),
        row("thindielectric", "tinted", pane(1.5, Vec3A::new(0.2, 0.5, 1.0)), BOTH),
        // (1 − 0.04) / (1 − 0.092) where the base sends light out straight: there the coat lets more than
        // its mean through.
        row("plastic", "grey", Plastic::new(coat(1.5, 0.5, false)), FRONT).with_weights_up_to(1.06),
        row("plastic", "white", Plastic::new(coat(1.5, 1.0, false)), FRONT)
            .with_weights_up_to(1.06),
        row("plastic", "nonlinear", Plastic::new(coat(1.9, 0.7, true)), FRONT)
            .with_weights_up_to(1.06),
        row("plastic", "no coat", Plastic::new(coat(1.0, 0.8, false)), FRONT),
        row("null", "nothing", Null, BOTH),
    ]
}

fn rough() -> Vec<Material> {
    use Distribution::{Beckmann, Ggx};
    let mirror = |roughness| RoughConductor::new(Metal::new(None, Vec3A::ONE), roughness);
    let uneven = |distribution| Roughness::anisotropic(distribution, 0.1, 0.4);
    let alpha = Textured::Varying(board());
    let conductors = vec![
        row("roughconductor", "ggx 0.1", mirror(Roughness::new(Ggx, 0.1)), FRONT).narrow(),
        Material {
            parts: 8,
            ..row("roughconductor", "ggx 0.01", mirror(Roughness::new(Ggx, 0.01)), FRONT)
        },
        row("roughconductor", "ggx 1", mirror(Roughness::new(Ggx, 1.0)), FRONT),
        row("roughconductor", "ggx uneven", mirror(uneven(Ggx)), FRONT).narrow(),
        row("roughconductor", "beckmann 0.1", mirror(Roughness::new(Beckmann, 0.1)), FRONT)
            .narrow(),
        row("roughconductor", "beckmann 1", mirror(Roughness::new(Beckmann, 1.0)), FRONT),
        row("roughconductor", "beckmann uneven", mirror(uneven(Beckmann)), FRONT).narrow(),
        row(
            "roughconductor",
            "gold",
            RoughConductor::new(gold(), Roughness::new(Beckmann, 0.3)),
            FRONT,
        ),
        row("roughconductor", "textured", mirror(Roughness::new(Ggx, alpha)), FRONT)
            .at(at(Vec2::new(0.2, 0.2))),
    ];
    let glass = |eta: f32, roughness| {
        RoughDielectric::new(eta, roughness, Vec3A::ONE, Vec3A::ONE).expect("refracts")
    };
    let dielectrics = vec![
        row("roughdielectric", "ggx 0.1", glass(1.5, Roughness::new(Ggx, 0.1)), BOTH).narrow(),
        row("roughdielectric", "ggx 0.6", glass(1.5, Roughness::new(Ggx, 0.6)), BOTH),
        row("roughdielectric", "bubble", glass(1.0 / 1.5, Roughness::new(Beckmann, 0.3)), BOTH),
        row("roughdielectric", "uneven", glass(2.4, uneven(Ggx)), BOTH).narrow(),
        row("roughdielectric", "beckmann 0.1", glass(1.33, Roughness::new(Beckmann, 0.1)), BOTH)
            .narrow(),
    ];
    let plastics = vec![
        row("roughplastic", "ggx 0.1", RoughPlastic::new(coat(1.5, 0.5, false), Ggx, 0.1), FRONT)
            .narrow()
            .with_weights_up_to(2.0),
        row(
            "roughplastic",
            "beckmann 0.3",
            RoughPlastic::new(coat(1.5, 1.0, true), Beckmann, 0.3),
            FRONT,
        )
        .with_weights_up_to(2.0),
    ];
    let all = conductors.into_iter().chain(dielectrics).chain(plastics);
    all.map(|row| Material { exact_albedo: false, ..row }).collect()
}

fn composite() -> Vec<Material> {
    let two_diffuse = Some(Box::new(diffuse(Vec3A::new(0.1, 0.9, 0.4))) as Box<dyn Bsdf>);
    let rough = || {
        let roughness = Roughness::new(Distribution::Ggx, 0.3);
        Box::new(RoughConductor::new(gold(), roughness)) as Box<dyn Bsdf>
    };
    let blend = |weight: f32, materials| Blend::new(weight, materials);
    let grey = || Box::new(diffuse(Vec3A::splat(0.5))) as Box<dyn Bsdf>;
    vec![
        row("twosided", "one material", twosided(diffuse(Vec3A::splat(0.7)), None), BOTH),
        row("twosided", "two materials", twosided(diffuse(Vec3A::splat(0.2)), two_diffuse), BOTH),
        row(
            "twosided",
            "diffuse and gold",
            twosided(
                diffuse(Vec3A::splat(0.5)),
                Some(Box::new(Conductor::new(gold())) as Box<dyn Bsdf>),
            ),
            BOTH,
        ),
        row("blendbsdf", "two smooth", blend(0.3, [grey(), rough()]), FRONT).inexact_albedo(),
        row("blendbsdf", "with glass", blend(0.6, [grey(), Box::new(dielectric(1.5, 1.0))]), BOTH),
        row("blendbsdf", "second only", blend(1.0, [grey(), Box::new(Null)]), BOTH),
        row("mask", "diffuse", Mask::new(0.3, grey()), BOTH),
        row("mask", "rough", Mask::new(Textured::Varying(board()), rough()), BOTH)
            .inexact_albedo()
            .at(at(Vec2::new(0.7, 0.2))),
        row("mask", "solid", Mask::new(1.0, Box::new(Plastic::new(coat(1.5, 0.5, false)))), FRONT)
            .with_weights_up_to(1.06),
        row("mask", "hole", Mask::new(0.0, grey()), BOTH),
    ]
}

fn perturbed() -> Vec<Material> {
    let options =
        |both| PerturbedOptions { flip_invalid_normals: both, use_shadowing_function: both };
    let white = || Box::new(diffuse(Vec3A::ONE)) as Box<dyn Bsdf>;
    let rough = || {
        let roughness = Roughness::anisotropic(Distribution::Ggx, 0.3, 0.5);
        Box::new(RoughConductor::new(gold(), roughness)) as Box<dyn Bsdf>
    };
    let mirror = || Box::new(Conductor::mirror(Vec3A::ONE)) as Box<dyn Bsdf>;
    let mapped = |n: Vec3A, both, material| {
        let normals = Normals::Map((n.normalize() * 0.5 + 0.5).into());
        Perturbed::new(normals, options(both), material)
    };
    // A slope of 4 along u and of 2 along v in the middle of the picture.
    let height = picture(2, 1, Texels::Float(vec![0.0, 2.0, 1.0, 3.0]), Encoding::Linear);
    let bumped = |scale, material| {
        let normals = Normals::Bump { height: Arc::clone(&height), scale };
        Perturbed::new(normals, options(true), material)
    };
    let middle = || at(Vec2::splat(0.5));
    let (slight, steep) = (Vec3A::new(0.1, -0.2, 1.0), Vec3A::new(1.0, 0.3, 0.4));
    let rows = vec![
        row("normalmap", "slight", mapped(slight, true, white()), FRONT),
        row("normalmap", "steep", mapped(steep, true, rough()), FRONT),
        row("normalmap", "uncorrected", mapped(slight, false, white()), FRONT),
        row("normalmap", "no normal", mapped_grey(options(true), white()), FRONT),
        row("normalmap", "mirror", mapped(steep, true, mirror()), FRONT),
        row("normalmap", "glass", mapped(steep, true, Box::new(dielectric(1.5, 1.0))), BOTH),
        row("bumpmap", "slight", bumped(0.05, white()), FRONT).at(middle()),
        row("bumpmap", "steep", bumped(1.0, rough()), FRONT).at(middle()),
        row("bumpmap", "mirror", bumped(0.1, mirror()), FRONT).at(middle()),
        row("bumpmap", "flat", bumped(0.0, white()), FRONT).at(middle()),
    ];
    // What the turned surface scatters below the other one is lost.
    let rows = rows.into_iter().map(Material::inexact_albedo).map(Material::one_way);
    // The turned horizon cuts cells.
    rows.map(Material::narrow).collect()
}

fn mapped_grey(options: PerturbedOptions, material: Box<dyn Bsdf>) -> Perturbed {
    Perturbed::new(Normals::Map(Vec3A::splat(0.5).into()), options, material)
}

/// A place with these texture coordinates.
fn at(uv: Vec2) -> Place {
    Place { uv: uv.into(), ..Place::default() }
}

fn board() -> Arc<dyn Texture> {
    let [a, b] = [Vec3A::splat(0.8), Vec3A::new(0.1, 0.2, 0.6)].map(Textured::Uniform);
    Arc::new(Checkerboard::new([a, b], Affine2::IDENTITY))
}

/// A picture of two rows with bilinear interpolation, repeated.
fn picture(width: u32, channels: usize, texels: Texels, encoding: Encoding) -> Arc<dyn Texture> {
    let image = Image::new(width, 2, channels, texels).expect("as many texels as pixels");
    let settings = BitmapSettings {
        encoding,
        filter: BitmapFilter::Bilinear,
        wrap: Wrap::Repeat,
        to_uv: Affine2::IDENTITY,
    };
    Arc::new(Bitmap::new(Arc::new(image), settings))
}

fn diffuse(reflectance: Vec3A) -> Diffuse {
    Diffuse::new(reflectance)
}

fn dielectric(int_ior: f32, ext_ior: f32) -> Dielectric {
    Dielectric::new(int_ior, ext_ior, Vec3A::ONE, Vec3A::ONE)
}

fn tinted_glass() -> Dielectric {
    Dielectric::new(1.5, 1.0, Vec3A::new(0.9, 1.0, 0.5), Vec3A::new(0.3, 0.6, 0.9))
}

fn pane(ior: f32, transmittance: Vec3A) -> ThinDielectric {
    ThinDielectric::new(ior, 1.0, Vec3A::ONE, transmittance)
}

fn coat(ior: f32, diffuse: f32, nonlinear: bool) -> Coat {
    Coat::new(ior, 1.0, Vec3A::splat(diffuse), Vec3A::ONE, nonlinear)
}

/// Near 650, 550 and 450 nm (Johnson and Christy 1972), to two digits.
fn gold() -> Metal {
    let index = (Vec3A::new(0.16, 0.42, 1.38).into(), Vec3A::new(3.8, 2.4, 1.9).into());
    Metal::new(Some(index), Vec3A::ONE)
}

fn twosided(front: Diffuse, back: Option<Box<dyn Bsdf>>) -> TwoSided {
    TwoSided::new(Box::new(front), back).expect("neither side transmits")
}
