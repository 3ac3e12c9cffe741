//! Every material, checked the same way. A new one gets its rows in `support::materials` and no test
//! of its own here, unless its physics has something to say.

mod physics;
#[path = "../support/mod.rs"]
mod support;

use std::collections::BTreeSet;

use glam::{Vec2, Vec3A};
use rayon::prelude::*;
use support::materials::{Material, materials};
use support::quadrature::{SphereGrid, direction};
use support::stats::{Moments, chi_squared};
use support::{corners, plugin_names, points};
use telamon::bsdf::{Bsdf, BsdfSample, Flags, Place};
use telamon::load::plugins::Category;

const GRID: SphereGrid = SphereGrid { rows: 10, columns: 20 };

const SAMPLES: u32 = 1_000_000;

/// Directions of view on the side of +z: polar angle in degrees, azimuth in radians.
const VIEWS: [(f64, f64); 5] = [(0.0, 0.0), (30.0, 0.7), (60.0, 2.9), (80.0, 4.1), (89.0, 5.6)];

fn row(plugin: &str, variant: &str) -> Material {
    let is_it = |m: &Material| m.plugin == plugin && m.variant == variant;
    materials().into_iter().find(is_it).expect("a row of the table")
}

/// Each view from each side that scatters light.
fn views(material: &Material) -> Vec<Vec3A> {
    let sides = material.sides.iter();
    sides
        .flat_map(|&side| {
            VIEWS.map(|(theta, phi)| {
                direction(theta.to_radians().cos(), phi) * Vec3A::new(1.0, 1.0, side)
            })
        })
        .collect()
}

/// Materials that have more than delta lobes on the side of `wi`.
fn is_smooth(material: &Material, wi: Vec3A) -> bool {
    points(7, 64).filter_map(|u| material.sample(wi, u)).any(|s| !s.lobe.is_delta())
}

/// Counts of sampled directions per cell, and in one cell more what was absorbed or went to delta lobes.
fn counts(material: &Material, wi: Vec3A, seed: u64) -> Vec<u64> {
    let mut counts = vec![0; GRID.cells() + 1];
    for u in points(seed, SAMPLES) {
        let sample = material.sample(wi, u).filter(|s| !s.lobe.is_delta());
        let cell = sample.map_or(GRID.cells(), |s| GRID.cell(s.wo));
        counts[cell] += 1;
    }
    counts
}

/// What `pdf` says about the same cells.
fn expected_counts(parts: usize, pdf: impl Fn(Vec3A) -> f64) -> Vec<f64> {
    let mut expected = GRID.integrals(parts, pdf);
    let returned: f64 = expected.iter().sum();
    // One direction in 2²⁰ may be lost because its cosine rounds to 0.
    expected.push((1.0 - returned).max(1.0 / 1_048_576.0));
    expected.iter().map(|p| p * f64::from(SAMPLES)).collect()
}

#[test]
fn every_material_of_scene_files_is_in_the_table() {
    let tested: BTreeSet<_> = materials().iter().map(|m| m.plugin).collect();
    assert_eq!(tested, plugin_names(Category::Bsdf));
}

#[test]
fn samples_follow_their_density() {
    let materials = materials();
    let cases: Vec<_> = materials
        .iter()
        .flat_map(|m| views(m).into_iter().map(move |wi| (m, wi)))
        .filter(|(m, wi)| is_smooth(m, *wi))
        .collect();
    cases.par_iter().enumerate().for_each(|(case, &(material, wi))| {
        let seed = 100 + case as u64;
        let expected = expected_counts(material.parts, |wo| f64::from(material.pdf(wi, wo)));
        chi_squared(&counts(material, wi, seed), &expected, cases.len())
            .unwrap_or_else(|table| panic!("{} from {wi}: {table}", material.name()));
    });
}

/// A density that is 5 % too high, one that is tilted by 5 %, and one that ignores that samples are
/// missing: the test above would notice all three.
#[test]
fn wrong_densities_are_rejected() {
    let white = row("diffuse", "white");
    let wi = Vec3A::Z;
    let right = |wo: Vec3A| f64::from(white.pdf(wi, wo));
    let counts = counts(&white, wi, 99);
    assert!(chi_squared(&counts, &expected_counts(1, right), 1).is_ok());
    assert!(chi_squared(&counts, &expected_counts(1, |wo| 1.05 * right(wo)), 1).is_err());
    let tilted = |wo: Vec3A| (1.0 + 0.05 * f64::from(wo.x)) * right(wo);
    assert!(chi_squared(&counts, &expected_counts(1, tilted), 1).is_err());
    let mut thinned = counts.clone();
    thinned.iter_mut().for_each(|c| *c -= *c / 20);
    thinned[GRID.cells()] = u64::from(SAMPLES) - thinned.iter().sum::<u64>();
    assert!(chi_squared(&thinned, &expected_counts(1, right), 1).is_err());
}

/// An error unless the claim holds. Claims are comparisons that NaN fails.
fn ensure(claim: bool, otherwise: impl FnOnce() -> String) -> Result<(), String> {
    if claim { Ok(()) } else { Err(otherwise()) }
}

/// `None`, or a sample that a path can go on with.
fn check_sample(material: &Material, wi: Vec3A, u: Vec2) -> Result<(), String> {
    const ULP: f32 = f32::EPSILON / 2.0;
    let Some(s) = material.sample(wi, u) else { return Ok(()) };
    let BsdfSample { wo, weight, pdf, lobe, eta } = s;
    // Two roundings for each of three coordinates.
    ensure((wo.length() - 1.0).abs() <= 6.0 * ULP, || format!("|wo| = {}", wo.length()))?;
    let usable = pdf > 0.0 && pdf.is_finite() && eta > 0.0 && eta.is_finite();
    ensure(usable, || format!("{s:?}"))?;
    // What refraction adds is undone by eta²; 4 roundings.
    let energy = weight * (eta * eta);
    let most = material.largest_weight * (1.0 + 4.0 * ULP);
    let kept = energy.min_element() >= 0.0 && energy.max_element() <= most;
    ensure(kept, || format!("energy {energy} in {s:?}"))?;
    let (value, density) = (material.eval(wi, wo), material.pdf(wi, wo));
    if lobe.is_delta() {
        // Unless another lobe has a density there.
        return ensure(
            material.bsdf.flags().smooth || value == Vec3A::ZERO && density == 0.0,
            || format!("delta lobe with eval {value} and pdf {density}"),
        );
    }
    ensure((density - pdf).abs() <= 1e-5 * pdf, || {
        format!("pdf {density}, but sample returns {pdf}")
    })?;
    // Compared as products: the quotient of two tiny numbers says little.
    ensure((value - weight * pdf).abs().max_element() <= 1e-5 * pdf, || {
        format!("weight {weight}, but eval / pdf = {}", value / pdf)
    })
}

#[test]
fn samples_agree_with_eval_and_pdf() {
    // Just above the horizon, down to where the square of the cosine underflows.
    let extremes = [1e-3, 1e-6, 1e-20, 1e-40].map(|z| direction(z, 0.3));
    for material in &materials() {
        let mirrored = |w: &Vec3A| *w * Vec3A::new(1.0, 1.0, -1.0);
        for wi in views(material).iter().chain(&extremes).flat_map(|w| [*w, mirrored(w)]) {
            for u in points(61, 10_000).chain(corners()) {
                check_sample(material, wi, u)
                    .unwrap_or_else(|what| panic!("{} from {wi}, {u}: {what}", material.name()));
            }
        }
    }
}

/// A material whose density is 5 % too high.
#[derive(Debug)]
struct Wrong(Box<dyn Bsdf>);

impl Bsdf for Wrong {
    fn eval(&self, place: &Place, wi: Vec3A, wo: Vec3A) -> Vec3A {
        self.0.eval(place, wi, wo)
    }
    fn pdf(&self, place: &Place, wi: Vec3A, wo: Vec3A) -> f32 {
        1.05 * self.0.pdf(place, wi, wo)
    }
    fn sample(&self, place: &Place, wi: Vec3A, u: Vec2) -> Option<BsdfSample> {
        self.0.sample(place, wi, u).map(|s| BsdfSample { weight: s.weight * 1.05, ..s })
    }
    fn flags(&self) -> Flags {
        self.0.flags()
    }
    fn albedo(&self, place: &Place, wi: Vec3A) -> Vec3A {
        self.0.albedo(place, wi)
    }
}

#[test]
fn wrong_materials_are_rejected() {
    for material in materials().into_iter().filter(|m| m.variant != "black" && m.exact_albedo) {
        let name = material.name();
        let flags = material.bsdf.flags();
        let wrong = Material { bsdf: Box::new(Wrong(material.bsdf)), ..material };
        let wi = Vec3A::new(0.6, 0.0, 0.8);
        let refused = points(62, 100).any(|u| check_sample(&wrong, wi, u).is_err());
        // Too much energy shows only where a lobe carries nearly all; a density shows everywhere.
        assert!(refused || flags.delta, "{name}");
        let albedo = albedo_of(&wrong, wi, 63);
        assert!(albedo.has_mean(f64::from(wrong.albedo(wi).x), 1).is_err(), "{name}: albedo");
    }
}

/// The scattered fraction in the first channel, without the factor that refraction adds.
fn albedo_of(material: &Material, wi: Vec3A, seed: u64) -> Moments {
    let value = |s: BsdfSample| f64::from(s.weight.x) * f64::from(s.eta).powi(2);
    Moments::of(points(seed, 100_000).map(|u| material.sample(wi, u).map_or(0.0, value)))
}

#[test]
fn albedo_is_the_mean_of_the_weights() {
    let materials = materials();
    let cases: Vec<_> =
        materials.iter().flat_map(|m| views(m).into_iter().map(move |wi| (m, wi))).collect();
    for (seed, &(material, wi)) in (200..).zip(&cases) {
        let albedo = material.albedo(wi);
        // Eight roundings; for plastic the tables of the rough coat, which are rounded too.
        let kept = albedo.min_element() >= 0.0 && albedo.max_element() <= 1.0 + 8.0 * f32::EPSILON;
        assert!(kept, "{} from {wi}: {albedo}", material.name());
        if !material.exact_albedo {
            continue;
        }
        albedo_of(material, wi, seed)
            .has_mean(f64::from(albedo.x), cases.len())
            .unwrap_or_else(|figures| panic!("{} from {wi}: {figures}", material.name()));
    }
}

/// In a white furnace nothing is brighter than the furnace, from straight above to 89.9 degrees. Shows the
/// table: `cargo test --test bsdfs energy -- --nocapture`.
#[test]
#[expect(clippy::print_stdout, reason = "a test's output is shown when it is asked for")]
fn no_material_makes_energy() {
    const ANGLES: [f64; 5] = [0.0, 30.0, 60.0, 80.0, 89.9];
    println!("share of the light that leaves, seen at {ANGLES:?} degrees");
    for material in &materials() {
        for &side in material.sides {
            let mut shares = String::new();
            for (seed, theta) in (300..).zip(ANGLES) {
                let wi = direction(theta.to_radians().cos(), 0.4) * Vec3A::new(1.0, 1.0, side);
                let albedo = albedo_of(material, wi, seed);
                let bound = 1.0 + 1e-6 + 3.0 * albedo.standard_error();
                assert!(albedo.mean() <= bound, "{} from {wi}: {albedo:?}", material.name());
                shares += &format!("  {:.3}", albedo.mean());
            }
            let side = if side > 0.0 { "front" } else { "back" };
            println!("{:40} {side:5}{shares}", material.name());
        }
    }
}

/// The relative index by which light is refracted that goes on to the other side of `wi`.
fn eta_across(material: &Material, wi: Vec3A) -> f32 {
    let across = |u| material.sample(wi, u).filter(|s| s.wo.z * wi.z < 0.0);
    points(73, 1000).find_map(across).map_or(1.0, |sample| sample.eta)
}

/// Light and eye may change places: f is symmetric (Helmholtz), and where it is refracted f/η² is, with the index
/// of the side that it goes to (Veach 1997, equation 5.14). Bump maps and normal maps break this.
#[test]
fn scattering_is_reciprocal() {
    let mut across = 0;
    for material in materials().iter().filter(|m| m.reciprocal) {
        let eta = [Vec3A::Z, Vec3A::NEG_Z].map(|wi| eta_across(material, wi));
        for (a, b) in points(71, 10_000).zip(points(72, 10_000)) {
            let (wi, wo) = (direction_of(a), direction_of(b));
            let crosses = wi.z * wo.z < 0.0;
            let index = eta[usize::from(wi.z < 0.0)];
            let eta = if crosses { index } else { 1.0 };
            let forth = material.eval(wi, wo) / wo.z.abs() * (eta * eta);
            let back = material.eval(wo, wi) / wi.z.abs();
            if forth == back {
                continue;
            }
            across += usize::from(crosses && eta != 1.0 && back != Vec3A::ZERO);
            // Eight roundings on each side, and what is lost below the normal range. Fresnel's factor is
            // asked with either direction: at grazing angles it multiplies their difference by 6 / cosθ.
            //
            // Of glass a half vector is a difference, at least |η - 1| = 1/3 long, so off by 9 roundings, of which
            // the slope distribution makes 100 times as many at most on each side: Beckmann's exponent, before
            // the exponential leaves the normal range. Fresnel's factor has the cosine of the other side from
            // Snell's law, whose square is off by 3 roundings of 1.
            let squared = (wi + wo * eta).normalize().dot(wi).powi(2);
            let refracted = (1.0 - (1.0 - squared) / (index * index)).abs();
            let least = squared.min(refracted);
            if index != 1.0 && least < 1e-3 {
                // So close to total reflection rounding decides whether there is any light.
                continue;
            }
            let roundings = match (index != 1.0, material.exact_albedo) {
                (true, _) => 2000.0 + 10.0 / least,
                (false, true) => 16.0,
                (false, false) => 160.0,
            };
            let tolerance = roundings * f32::EPSILON / 2.0 * forth.max_element() + 1e-30;
            assert!(
                (forth - back).abs().max_element() <= tolerance,
                "{}: {wi} {wo}: {forth} {back}",
                material.name()
            );
        }
    }
    assert!(across > 1000, "{across} refracted");
}

fn direction_of(u: Vec2) -> Vec3A {
    Vec3A::from(telamon::math::warp::square_to_uniform_sphere(u.into()))
}

/// No light on the wrong side of what does not transmit, whatever the directions.
#[test]
fn nothing_passes_what_is_opaque() {
    for material in materials().iter().filter(|m| !m.bsdf.flags().transmits) {
        for (a, b) in points(73, 10_000).zip(points(74, 10_000)) {
            let (wi, wo) = (direction_of(a), direction_of(b));
            let seen = material.sides.contains(&wi.z.signum());
            if !seen || wi.z * wo.z < 0.0 {
                assert_eq!(material.eval(wi, wo), Vec3A::ZERO, "{}", material.name());
                assert_eq!(material.pdf(wi, wo), 0.0, "{}", material.name());
            }
            if let Some(s) = material.sample(wi, a) {
                assert!(seen && s.wo.z * wi.z > 0.0, "{}: {s:?}", material.name());
            }
        }
    }
}

/// Each lobe that is sampled is in the flags, and each lobe of the flags is sampled, unless a texture or a
/// fraction leaves it out.
#[test]
fn flags_tell_the_lobes() {
    for material in &materials() {
        let sampled = |delta: bool| {
            views(material).into_iter().any(|wi| {
                let mut samples = points(75, 100).filter_map(|u| material.sample(wi, u));
                samples.any(|s| s.lobe.is_delta() == delta)
            })
        };
        let Flags { smooth, delta, .. } = material.bsdf.flags();
        let name = material.name();
        assert!((smooth || !sampled(false)) && (delta || !sampled(true)), "{name}");
        if !["mask", "blendbsdf"].contains(&material.plugin) && material.variant != "no coat" {
            assert_eq!((smooth, delta), (sampled(false), sampled(true)), "{name}");
        }
    }
}
