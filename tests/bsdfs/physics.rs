//! What physics says of single materials: Snell's law, energy at interfaces, and the extremes of what they can be told.

use glam::{Vec2, Vec3A};
use telamon::bsdf::conductor::Metal;
use telamon::bsdf::microfacet::{Distribution, Roughness};
use telamon::bsdf::plastic::Coat;
use telamon::bsdf::{
    Bsdf, Dielectric, Place, Plastic, RoughConductor, RoughDielectric, RoughPlastic,
};

use crate::support::quadrature::direction;
use crate::support::stats::Moments;
use crate::support::{BELOW_ONE, corners, points, points_3d};
use crate::{check_sample, direction_of, ensure, row};

/// Pairs of indices inside and outside.
const INDICES: [(f32, f32); 5] =
    [(1.5, 1.0), (1.0, 1.5), (1.33, 1.0), (2.419, 1.333), (1.000_277, 1.0)];

#[test]
fn refraction_keeps_the_law_of_snell() {
    for (int_ior, ext_ior) in INDICES {
        let glass = Dielectric::new(int_ior, ext_ior, Vec3A::ONE, Vec3A::ONE);
        for u in points_3d(81, 10_000) {
            let wi = direction_of(u.truncate());
            let (near, far) = if wi.z > 0.0 { (ext_ior, int_ior) } else { (int_ior, ext_ior) };
            // The largest number chooses refraction wherever there is any.
            let s = glass
                .sample(&Place::default(), wi, Vec2::new(BELOW_ONE, u.z))
                .expect("glass absorbs nothing");
            if s.wo.z * wi.z > 0.0 {
                let total = wi.truncate().length() * near / far;
                // sin of the refracted angle; R rounds to 1 just before it, 1e-6 is generous.
                assert!(total > 1.0 - 1e-6, "{near} -> {far}: {wi} reflected at {total}");
                assert_eq!(s.eta, 1.0);
                continue;
            }
            let eta = far / near;
            assert!((s.eta - eta).abs() <= 2.0 * f32::EPSILON * eta, "{} {eta}", s.eta);
            assert!((s.weight.x * eta * eta - 1.0).abs() < 1e-6, "weight {}", s.weight);
            // The tangential part is scaled, in f32: 8 roundings.
            let off = (s.wo.truncate() * far + wi.truncate() * near).length();
            assert!(off <= 8.0 * f32::EPSILON / 2.0 * near.max(far), "{near} -> {far}: {wi} {s:?}");
        }
    }
}

/// All of the light is reflected or refracted, and a refracted ray that turns round finds the same
/// fraction passing and the inverse index.
#[test]
fn interfaces_are_symmetric_and_keep_energy() {
    for (int_ior, ext_ior) in INDICES {
        let glass = Dielectric::new(int_ior, ext_ior, Vec3A::ONE, Vec3A::ONE);
        for u in points(82, 10_000) {
            let wi = direction_of(u);
            let reflected =
                glass.sample(&Place::default(), wi, Vec2::ZERO).expect("glass absorbs nothing");
            let refracted = glass
                .sample(&Place::default(), wi, Vec2::splat(BELOW_ONE))
                .expect("glass absorbs nothing");
            if refracted.wo.z * wi.z > 0.0 {
                continue;
            }
            // R may be so small that even 0 chooses refraction.
            let r = if reflected.wo.z * wi.z > 0.0 { reflected.pdf } else { 0.0 };
            assert!((r + refracted.pdf - 1.0).abs() <= f32::EPSILON, "{r} + {}", refracted.pdf);
            let back = glass
                .sample(&Place::default(), refracted.wo, Vec2::splat(BELOW_ONE))
                .expect("reversible");
            if back.wo.z * refracted.wo.z > 0.0 {
                continue;
            }
            assert!((back.eta * refracted.eta - 1.0).abs() <= 4.0 * f32::EPSILON);
            // The cosine of the steeper side carries 3 roundings. Snell's law scales its square by eta²,
            // the root divides by twice the cosine of the flatter side, and 1 - R has a slope of up
            // to 4 there.
            let flat = wi.z.abs().min(refracted.wo.z.abs());
            let squeeze = refracted.eta.max(1.0 / refracted.eta).powi(2);
            let tolerance = 12.0 * f32::EPSILON / 2.0 * squeeze / flat;
            let difference = (back.pdf - refracted.pdf).abs();
            assert!(difference <= tolerance, "{wi}: {refracted:?}, back {back:?}");
            assert!((back.wo - wi).length() <= tolerance, "{wi} returns as {}", back.wo);
        }
    }
}

/// 1.5 → 1 three ulp around the critical angle, and the flattest angles there are.
#[test]
fn no_angle_makes_glass_fail() {
    let glass = row("dielectric", "glass");
    let critical = 0.745_355_96f32;
    let near = (-3i32..=3).map(|step| f32::from_bits((critical.to_bits() as i32 + step) as u32));
    for z in near.chain([1.0, 1e-7, 1e-20, f32::MIN_POSITIVE, 1e-45]) {
        for side in [1.0, -1.0] {
            let wi = Vec3A::new((1.0 - z * z).sqrt(), 0.0, side * z);
            for u in points(83, 1_000).chain(corners()) {
                check_sample(&glass, wi, u).unwrap_or_else(|what| panic!("{wi} {u}: {what}"));
                assert!(glass.sample(wi, u).is_some(), "{wi} is absorbed");
            }
        }
    }
    assert!(glass.sample(Vec3A::X, Vec2::splat(0.5)).is_none(), "a direction in the surface");
}

/// The mean weight of a million samples on a grid.
fn mean_weight(material: &dyn Bsdf, wi: Vec3A) -> f64 {
    const SIDE: u32 = 1000;
    let weight = |i: u32| {
        let cell = Vec2::new((i % SIDE) as f32, (i / SIDE) as f32);
        let u = (cell + 0.5) / SIDE as f32;
        material.sample(&Place::default(), wi, u).map_or(0.0, |s| f64::from(s.weight.x))
    };
    (0..SIDE * SIDE).map(weight).sum::<f64>() / f64::from(SIDE * SIDE)
}

/// Directional albedo of GGX with separable masking and without Fresnel's factor, by quadrature in f64.
#[test]
fn single_scattering_loses_what_it_should() {
    for (alpha, theta, expected) in [
        (0.1, 0.0f64, 0.9883),
        (0.1, 60.0, 0.9691),
        (0.1, 80.0, 0.8920),
        (0.1, 85.0, 0.8731),
        (0.3, 0.0, 0.8774),
        (0.3, 60.0, 0.8181),
        (0.3, 85.0, 0.8470),
        (0.5, 0.0, 0.6878),
        (0.5, 60.0, 0.6860),
        (0.5, 85.0, 0.7772),
        (1.0, 0.0, 0.3069),
        (1.0, 60.0, 0.4091),
        (1.0, 85.0, 0.5645),
    ] {
        let roughness = Roughness::new(Distribution::Ggx, alpha);
        let mirror = RoughConductor::new(Metal::new(None, Vec3A::ONE), roughness);
        let found = mean_weight(&mirror, direction(theta.to_radians().cos(), 0.0));
        // Half of the last digit, and what the edge of the lobe costs the grid.
        assert!((found - expected).abs() < 1e-4, "{alpha} at {theta}: {found}");
    }
}

/// The least and the greatest roughness, substances that hardly refract and that refract beyond nature, from
/// straight above to nearly along the surface.
#[test]
fn extremes_stay_in_bounds() {
    let one = Vec3A::ONE;
    let indices = [1.0f32, 1.000_001, 1.5, 1000.0];
    for alpha in [0.0, 1e-4, 1.0] {
        for distribution in [Distribution::Ggx, Distribution::Beckmann] {
            let roughness = || Roughness::new(distribution, alpha);
            let mut cases: Vec<(Box<dyn Bsdf>, f32, f64)> = vec![(
                Box::new(RoughConductor::new(Metal::new(None, one), roughness())),
                1.0,
                1e-5,
            )];
            for eta in indices {
                let coat = || Coat::new(eta, 1.0, one, one, false);
                // A coat of 1000 lets a hundred times its mean through at the angle of Brewster.
                let plastic = RoughPlastic::new(coat(), distribution, alpha);
                // Its table is a quadrature, which is off where a coat that hardly refracts is seen
                // along the surface.
                cases.push((Box::new(plastic), 200.0, 0.05));
                cases.push((Box::new(Plastic::new(coat())), 200.0, 1e-5));
                for eta in [eta, 1.0 / eta] {
                    let glass = RoughDielectric::new(eta, roughness(), one, one);
                    assert_eq!(glass.is_none(), eta == 1.0);
                    cases.extend(glass.map(|g| (Box::new(g) as Box<dyn Bsdf>, 1.0, 1e-5)));
                }
            }
            for (bsdf, most, slack) in cases {
                for z in [1.0, 0.5, 1e-2, 1e-4, 1e-6] {
                    check_extreme(bsdf.as_ref(), direction(z, 0.3), most, slack)
                        .unwrap_or_else(|what| panic!("{bsdf:?} from {z}: {what}"));
                }
            }
        }
    }
}

/// Weights up to `most`, and not more light than there is and a fraction `slack`.
fn check_extreme(bsdf: &dyn Bsdf, wi: Vec3A, most: f32, slack: f64) -> Result<(), String> {
    let place = Place::default();
    let mut energies = Vec::new();
    let samples = points(91, 2_000).chain(corners());
    for s in samples.filter_map(|u| bsdf.sample(&place, wi, u)) {
        let energy = s.weight.max_element() * s.eta * s.eta;
        let unit = (s.wo.length() - 1.0).abs() < 1e-6;
        let positive = s.pdf > 0.0 && s.pdf.is_finite() && s.weight.min_element() >= 0.0;
        ensure(unit && positive && energy <= most * (1.0 + 1e-6), || format!("{s:?}"))?;
        let finite = bsdf.eval(&place, wi, s.wo).is_finite();
        ensure(finite && bsdf.pdf(&place, wi, s.wo).is_finite(), || format!("{s:?}"))?;
        energies.push(f64::from(energy));
    }
    let missing = std::iter::repeat_n(0.0, 2_004 - energies.len());
    let scattered = Moments::of(energies.into_iter().chain(missing));
    let bound = 1.0 + slack + 4.0 * scattered.standard_error();
    ensure(scattered.mean() <= bound, || format!("{scattered:?} is scattered"))
}
