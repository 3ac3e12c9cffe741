//! Shading normals that would lose light, and how they are bent until they do not.
//!
//! An interpolated normal, or one from a map, belongs to a surface that is not there. Near silhouettes it may be
//! seen from behind where the real surface is seen from in front, and a mirror or glass with that normal may send
//! light through the real surface, or to where it came from. The geometric normal decides on which side light is
//! (Veach 1997, section 5.3), so such light can only be dropped, and glass that absorbs nothing would have black
//! rims. Instead the normal is bent towards the geometric one, which has none of these faults, as far as it takes.
//! Cycles bends for the mirror direction (`ensure_valid_specular_reflection`), and so does Iray (Keller et al., "The
//! Iray Light Transport Simulation and Rendering System", 2017). Refraction needs more: light that one
//! facet lets in has to find a facet that lets it out, or a coarse mesh is a trap.
//!
//! The result depends on `wi` alone, so that a material evaluates, samples and has its density by one normal. As it
//! does so, bent materials are not reciprocal.

use crate::math::real::{Lanes, Mask, Real};
use crate::math::vector::Vec3;

/// How high the mirror direction has to be, over how high the viewer is (both as sines above the surface). Above 0
/// for rough lobes, half of which would otherwise lie below the surface. With 1, each normal that leans away from
/// the viewer would be bent, and smooth surfaces would show their facets.
const LEAST_MIRRORED: f32 = 0.25;

/// The same for glass, whose inside must not be a trap: a mirror direction that creeps along one facet after the
/// other never leaves.
const LEAST_MIRRORED_BY_GLASS: f32 = 0.5;

/// The same for materials without such lobes: as low as can be, but with the viewer in front of the bent normal; -1
/// would put him into its plane.
const LEAST_DIFFUSE: f32 = -0.9;

/// Where refracted light has to be, between the flattest that leaves on the way back (0) and where the geometric
/// normal sends it (1).
const LEAST_REFRACTED: f32 = 0.5;

/// Halvings of the angle between the two normals.
const STEPS: u32 = 14;

/// The unit normal `shading`, or if that is not valid as seen from `wi`, one between it and `geometric` that is, as
/// near to it as halving the angle finds. `geometric` is the unit normal of the surface, and `wi` a unit vector on
/// any side of it; for the material's `interface` see [`Bsdf::interface`](super::Bsdf::interface). If both are on the
/// same side, as for interpolated normals, the result is in front of `geometric`, and `wi` on the same side of both.
///
/// Valid is a normal
/// - with which a mirror reflects to the side of `wi` (for diffuse materials: which `wi` sees from the side from which
///   it sees the surface);
/// - with which glass refracts to the other side;
/// - with which light enters the denser side so steeply that it could leave by the geometric normal;
/// - and which does not see total reflection where the geometric normal sees none.
#[inline(always)]
#[must_use]
pub fn bend<R: Real>(
    shading: Vec3<R>,
    geometric: Vec3<R>,
    wi: Vec3<R>,
    interface: Option<f32>,
) -> Vec3<R> {
    let view = View::new(shading, geometric, wi, interface);
    view.accepts(shading).either(
        #[inline(always)]
        || shading,
        #[inline(always)]
        || view.bent(shading),
    )
}

/// A surface as seen from one direction.
struct View<R> {
    geometric: Vec3<R>,
    /// The direction, or its opposite in front of the surface.
    w: Vec3<R>,
    /// Its cosine with the geometric normal.
    height: R,
    least_mirrored: f32,
    /// Least cosine of `w` with the normal.
    least_cosine: R,
    refraction: Option<Refraction<R>>,
}

/// What glass asks of a normal.
struct Refraction<R> {
    /// Index of the other side over that of this one.
    eta: R,
    /// Least cosine of the refracted direction with the geometric normal, on the other side.
    least_depth: R,
}

impl<R: Real> View<R> {
    #[inline(always)]
    fn new(shading: Vec3<R>, geometric: Vec3<R>, wi: Vec3<R>, interface: Option<f32>) -> Self {
        let zero = R::splat(wi.token(), 0.0);
        let below = wi.dot(geometric).lt(0.0);
        let w = Vec3::select(below, -wi, wi);
        let height = w.dot(geometric);
        let least_mirrored = if interface.is_some() { LEAST_MIRRORED } else { LEAST_DIFFUSE };
        let mut view =
            Self { geometric, w, height, least_mirrored, least_cosine: zero, refraction: None };
        let Some(eta) = interface.filter(|&eta| eta != 1.0) else { return view };
        let eta = R::select(below, R::splat(wi.token(), 1.0 / eta), eta);
        let denser = eta.gt(1.0);
        // Cosine of the critical angle, on the denser side.
        let critical = cosine_across(zero, R::select(denser, eta, eta.recip()));
        let straight = cosine_across(height, eta);
        let flattest = R::select(denser, critical, 0.0);
        let least_depth = flattest + (straight - flattest) * LEAST_REFRACTED;
        view.refraction = Some(Refraction { eta, least_depth });
        view.least_mirrored = LEAST_MIRRORED_BY_GLASS;
        let cosine = w.dot(shading);
        let reflects_all = eta.lt(1.0) & height.gt(critical) & cosine.lt(critical);
        // As far this side of the critical angle as the shading normal is beyond. Less than the height by more
        // than rounding, so that halving can reach it.
        let least_cosine = (critical * 2.0 - cosine).min(height * 0.9999);
        view.least_cosine = R::select(reflects_all, least_cosine, 0.0);
        view
    }

    /// What is valid nearest to `shading`, which is not.
    #[inline(always)]
    fn bent(&self, shading: Vec3<R>) -> Vec3<R> {
        let (mut valid, mut invalid) = (self.geometric, shading);
        for _ in 0..STEPS {
            let (middle, exists) = (valid + invalid).try_normalize();
            let middle = Vec3::select(exists, middle, self.geometric);
            let accepted = self.accepts(middle);
            valid = Vec3::select(accepted, middle, valid);
            invalid = Vec3::select(accepted, invalid, middle);
        }
        valid
    }

    #[inline(always)]
    fn accepts(&self, n: Vec3<R>) -> R::Mask {
        let (cosine, tilt) = (self.w.dot(n), n.dot(self.geometric));
        let mirrored = cosine * 2.0 * tilt - self.height;
        // Comparisons that NaN fails.
        let reflects = tilt.gt(0.0) & mirrored.ge(self.height * self.least_mirrored);
        let accepted = reflects & cosine.ge(self.least_cosine);
        let Some(glass) = &self.refraction else { return accepted };
        let across = cosine_across(cosine, glass.eta);
        // w = cosine n + …, of which the part along the surface of n is divided by eta.
        let depth = (self.height - cosine * tilt) / glass.eta + across * tilt;
        accepted & (across.eq(0.0) | depth.ge(glass.least_depth))
    }
}

/// Cosine of the refracted direction for that of the other one; 0 in total reflection.
#[inline(always)]
fn cosine_across<R: Real>(cosine: R, eta: R) -> R {
    ((cosine * cosine).one_minus() / (eta * eta)).one_minus().max(0.0).sqrt()
}

#[cfg(test)]
mod tests {
    use glam::Vec3A;

    fn bend(shading: Vec3A, geometric: Vec3A, wi: Vec3A, interface: Option<f32>) -> Vec3A {
        super::bend::<f32>(shading.into(), geometric.into(), wi.into(), interface).into()
    }

    /// Unit vectors around the upper half sphere; `lean` from z at most.
    fn directions(count: u32, lean: f32) -> impl Iterator<Item = Vec3A> {
        (0..count).map(move |i| {
            let theta = lean * (i as f32 + 0.5) / count as f32;
            let phi = 2.399_963 * i as f32;
            Vec3A::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos())
        })
    }

    const INTERFACES: [Option<f32>; 6] =
        [None, Some(1.0), Some(1.1), Some(1.5), Some(2.4), Some(1.0 / 1.5)];

    fn each_view(mut check: impl FnMut(Vec3A, Vec3A, Option<f32>)) {
        for shading in directions(100, 1.57) {
            for wi in directions(100, 1.57).chain(directions(100, 1.57).map(|w| -w)) {
                for interface in INTERFACES {
                    check(shading, wi, interface);
                }
            }
        }
    }

    fn refracted(w: Vec3A, n: Vec3A, eta: f32) -> Option<Vec3A> {
        let cosine = w.dot(n);
        let squared = 1.0 - (1.0 - cosine * cosine) / (eta * eta);
        (squared > 0.0).then(|| (n * cosine - w) / eta - n * squared.sqrt())
    }

    /// Directions that are computed from a bent normal are on their sides; 1e-5 is for some ten roundings.
    #[test]
    fn bent_normals_keep_light_on_its_side() {
        let geometric = Vec3A::Z;
        let mut bent = 0;
        each_view(|shading, wi, interface| {
            let n = bend(shading, geometric, wi, interface);
            bent += u32::from(n != shading);
            let case = || format!("{shading} from {wi}, {interface:?}: {n}");
            assert!((n.length() - 1.0).abs() < 1e-6 && n.z > 0.0, "{}", case());
            // In the plane of both, and between them.
            let volume = n.dot(shading.cross(geometric));
            assert!(volume.abs() < 1e-6 && n.z >= shading.z - 1e-6, "{}", case());
            let (w, eta) =
                if wi.z < 0.0 { (-wi, interface.map(|eta| 1.0 / eta)) } else { (wi, interface) };
            assert!(w.dot(n) > 0.0, "{}", case());
            let Some(eta) = eta else { return };
            let mirrored = n * (2.0 * w.dot(n)) - w;
            assert!(mirrored.z > 0.24 * w.z, "{} mirrors to {mirrored}", case());
            let straight = refracted(w, geometric, eta);
            match refracted(w, n, eta) {
                Some(across) => {
                    assert!(across.z < 1e-5, "{} refracts to {across}", case());
                    let back = refracted(-across, geometric, 1.0 / eta);
                    assert!(eta < 1.0 || back.is_some(), "{} lets {across} in for good", case());
                }
                // Unless that is within 1e-4 of the critical angle.
                None => assert!(straight.is_none_or(|s| s.z > -0.1), "{} reflects all", case()),
            }
        });
        assert!(bent > 1000, "{bent}");
    }

    /// What is valid stays as it is, to the last bit: most normals within 10 degrees of the geometric one, as seen
    /// from within 60, and the geometric normal itself.
    #[test]
    fn valid_normals_are_left_alone() {
        for wi in directions(100, 1.04) {
            for shading in directions(100, 0.17) {
                assert_eq!(bend(shading, Vec3A::Z, wi, None), shading);
                assert_eq!(bend(shading, Vec3A::Z, wi, Some(1.0)), shading);
            }
        }
        each_view(|geometric, wi, interface| {
            let height = wi.dot(geometric);
            if height.abs() > 1e-3 {
                let n = bend(geometric, geometric, wi, interface);
                assert!((n - geometric).length() < 1e-6, "{geometric} from {wi}: {n}");
            }
        });
    }

    /// A surface seen along itself, a normal in it or behind it: a unit vector in front all the same.
    #[test]
    fn no_view_makes_it_fail() {
        let flat = [Vec3A::X, Vec3A::new(1.0, 0.0, 1e-20).normalize(), -Vec3A::Z, Vec3A::Z];
        for shading in flat {
            for wi in flat.into_iter().chain([-Vec3A::X, Vec3A::Y]) {
                for interface in INTERFACES {
                    let n = bend(shading, Vec3A::Z, wi, interface);
                    let unit = (n.length() - 1.0).abs() < 1e-6;
                    assert!(unit && n.z > 0.0, "{shading} from {wi}, {interface:?}: {n}");
                }
            }
        }
    }
}
