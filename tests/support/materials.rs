//! The materials under test: one row for each thing worth checking, at least one for each plugin.

use glam::Vec3A;
use telamon::bsdf::conductor::ComplexIndex;
use telamon::bsdf::{Bsdf, Conductor, Dielectric, Diffuse, TwoSided};

/// A row of the table of materials.
pub(crate) struct Material {
    /// Name of the plugin in scene files.
    pub(crate) plugin: &'static str,
    /// What is special about this row.
    pub(crate) variant: &'static str,
    pub(crate) bsdf: Box<dyn Bsdf>,
    /// Sides from which it scatters light: signs of z.
    pub(crate) sides: &'static [f32],
}

impl Material {
    pub(crate) fn name(&self) -> String {
        format!("{} ({})", self.plugin, self.variant)
    }
}

const FRONT: &[f32] = &[1.0];
const BOTH: &[f32] = &[1.0, -1.0];

/// Every material of the library, at least once.
pub(crate) fn materials() -> Vec<Material> {
    let row = |plugin, variant, bsdf, sides| Material { plugin, variant, bsdf, sides };
    vec![
        row("diffuse", "coloured", Box::new(diffuse(Vec3A::new(0.8, 0.5, 0.1))), FRONT),
        row("diffuse", "white", Box::new(diffuse(Vec3A::ONE)), FRONT),
        row("diffuse", "black", Box::new(diffuse(Vec3A::ZERO)), FRONT),
        row("conductor", "mirror", Box::new(Conductor::new(None, Vec3A::ONE)), FRONT),
        row("conductor", "gold", Box::new(gold()), FRONT),
        row("dielectric", "glass", Box::new(dielectric(1.5, 1.0)), BOTH),
        row("dielectric", "bubble", Box::new(dielectric(1.0, 1.5)), BOTH),
        row("dielectric", "diamond in water", Box::new(dielectric(2.419, 1.333)), BOTH),
        row("dielectric", "equal indices", Box::new(dielectric(1.333, 1.333)), BOTH),
        row("dielectric", "tinted", Box::new(tinted_glass()), BOTH),
        row("twosided", "one material", twosided(diffuse(Vec3A::splat(0.7)), None), BOTH),
        row(
            "twosided",
            "two materials",
            twosided(
                diffuse(Vec3A::splat(0.2)),
                Some(Box::new(diffuse(Vec3A::new(0.1, 0.9, 0.4)))),
            ),
            BOTH,
        ),
        row(
            "twosided",
            "diffuse and gold",
            twosided(diffuse(Vec3A::splat(0.5)), Some(Box::new(gold()))),
            BOTH,
        ),
    ]
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

/// Near 650, 550 and 450 nm (Johnson and Christy 1972), to two digits.
fn gold() -> Conductor {
    let index = ComplexIndex { eta: Vec3A::new(0.16, 0.42, 1.38), k: Vec3A::new(3.8, 2.4, 1.9) };
    Conductor::new(Some(index), Vec3A::ONE)
}

fn twosided(front: Diffuse, back: Option<Box<dyn Bsdf>>) -> Box<dyn Bsdf> {
    Box::new(TwoSided::new(Box::new(front), back).expect("neither side transmits"))
}
