//! Both tests at the extremes of what f32 can hold.

use super::*;
use crate::intersect::lanes::{LANES, Portable};
use crate::math::{Frame, warp};
use crate::sampler::{Independent, PathSampler};
use glam::Vec3A;

const UNIT: Corners = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

fn test<T: RayTriangle>(ray: &Ray, corners: &Corners) -> Option<TriangleHit> {
    let all = std::array::from_fn(|axis| corners.map(|corner| F32x8([corner[axis]; LANES])));
    let test = T::new(ray);
    (test.candidates(Portable, &all) != 0).then(|| test.hit(ray, corners)).flatten()
}

fn both(ray: &Ray, corners: &Corners) -> [Option<TriangleHit>; 2] {
    [test::<Watertight>(ray, corners), test::<Plain>(ray, corners)]
}

fn scaled(corners: Corners, s: f32) -> Corners {
    corners.map(|corner| corner.map(|x| x * s))
}

#[test]
fn weights_name_the_second_and_third_corner() {
    let ray = Ray::new(Vec3A::new(0.5, 0.25, -1.0), Vec3A::Z);
    assert_eq!(both(&ray, &UNIT), [Some(TriangleHit { t: 1.0, u: 0.5, v: 0.25 }); 2]);
}

#[test]
fn a_ray_in_the_plane_misses() {
    for direction in [Vec3A::X, Vec3A::new(1.0, 0.5, 0.0).normalize()] {
        let ray = Ray::new(Vec3A::new(-1.0, 0.1, 0.0), direction);
        assert_eq!(both(&ray, &UNIT), [None; 2]);
    }
}

#[test]
fn a_ray_that_starts_in_the_plane_misses() {
    let sampler = Independent::new(1);
    for i in 0..10_000 {
        let mut u = PathSampler::new(&sampler, i, 0);
        let p = warp::square_to_uniform_triangle(u.next_2d()).extend(0.0);
        // The plane z = 0 leaves `SurfacePoint::leave_towards` nothing to move by.
        let ray = Ray::new(p, warp::square_to_uniform_sphere(u.next_2d()));
        assert_eq!(both(&ray, &UNIT), [None; 2], "{ray:?}");
    }
}

#[test]
fn a_ray_without_direction_misses() {
    let ray = Ray::new(Vec3A::new(0.25, 0.25, -1.0), Vec3A::ZERO);
    assert_eq!(both(&ray, &UNIT), [None; 2]);
    // One that is not normalised does not harm.
    let ray = Ray::new(Vec3A::new(0.25, 0.25, -1.0), Vec3A::new(0.0, 0.0, 1e-30));
    for hit in both(&ray, &UNIT) {
        // t = 1/1e-30, with the rounding of 1e-30 and of t.
        let t = hit.expect("in the middle").t;
        assert!((t / 1e30 - 1.0).abs() <= f32::EPSILON, "{t}");
    }
}

/// Legs and height s. The solution is in f64, so t, u and v are off by their own rounding only; the
/// products of three lengths reach 1e54, which f32 does not.
#[test]
fn size_does_not_matter() {
    for exponent in -36..=18 {
        let s = 10f32.powi(exponent);
        let ray = Ray::new(Vec3A::new(0.25, 0.25, -1.0) * s, Vec3A::Z);
        for hit in both(&ray, &scaled(UNIT, s)) {
            let TriangleHit { t, u, v } = hit.unwrap_or_else(|| panic!("missed at {s}"));
            assert_eq!(t, s);
            // s/4 is rounded for a denormal s only.
            assert_eq!((u, v), (0.25, 0.25), "{s}");
        }
        // As far outside as it was inside.
        let ray = Ray::new(Vec3A::new(-0.25, 0.25, -1.0) * s, Vec3A::Z);
        assert_eq!(both(&ray, &scaled(UNIT, s)), [None; 2], "{s}");
    }
}

/// Legs s seen from a distance of 1, down to where their products are 0 in f32.
#[test]
fn a_small_triangle_is_hit_from_afar() {
    for exponent in -40..=-1 {
        let s = 10f64.powi(exponent) as f32;
        let ray = Ray::new(Vec3A::new(0.25 * s, 0.25 * s, -1.0), Vec3A::Z);
        for hit in both(&ray, &scaled(UNIT, s)) {
            let TriangleHit { t, u, v } = hit.unwrap_or_else(|| panic!("missed at {s}"));
            assert_eq!(t, 1.0);
            // A denormal s has few digits of which a quarter is rounded: half of 1e-45 in 1e-40.
            assert!((u - 0.25).abs() <= 1e-5 && (v - 0.25).abs() <= 1e-5, "{s}: {u}, {v}");
        }
    }
}

#[test]
fn the_segment_bounds_the_hit() {
    let ray = Ray::new(Vec3A::new(0.25, 0.25, -1.0), Vec3A::Z);
    for (segment, hits) in [
        (ray.until(0.999), false),
        (Ray { t_min: 1.001, ..ray }, false),
        (ray.until(1.001), true),
        (Ray { t_min: 1.0, t_max: 1.0, ..ray }, true),
        (Ray { t_min: 1.5, t_max: 0.5, ..ray }, false),
    ] {
        assert_eq!(both(&segment, &UNIT).map(|h| h.is_some()), [hits; 2], "{segment:?}");
    }
}

/// A triangle of random corners in the unit cube and a ray through it.
fn random(u: &mut PathSampler) -> (Ray, Corners) {
    let mut cube = || Vec3A::new(u.next_1d(), u.next_1d(), u.next_1d());
    let (corners, origin) = ([cube(), cube(), cube()], cube() * 3.0 - 1.0);
    let [a, b, c] = corners;
    let weights = warp::square_to_uniform_triangle(u.next_2d());
    let target = a + (b - a) * weights.x + (c - a) * weights.y;
    (Ray::new(origin, (target - origin).normalize()), corners.map(|c| c.to_array()))
}

/// The same bits, whatever power of two the unit of length is: as far as f32 goes, for the plain test as
/// far as its products of two lengths go.
#[test]
fn scaling_by_two_changes_nothing() {
    let sampler = Independent::new(2);
    for i in 0..1000 {
        let (ray, corners) = random(&mut PathSampler::new(&sampler, i, 0));
        let [watertight, plain] = both(&ray, &corners);
        for exponent in -100..=60 {
            let s = 2f32.powi(exponent);
            let scaled = both(&Ray { origin: ray.origin * s, ..ray }, &scaled(corners, s));
            let unscale = |TriangleHit { t, u, v }| TriangleHit { t: t / s, u, v };
            let [w, p] = scaled.map(|hit| hit.map(unscale));
            assert_eq!(w, watertight, "2^{exponent}: {ray:?}");
            assert!(p == plain || exponent < -50, "2^{exponent}: {ray:?}");
        }
    }
}

/// For every hit the point on the ray and the point on the triangle are the same up to the rounding
/// of t, u, v: 64u (|o| + t), of which a long thin triangle seen edge-on from 600 away takes a fiftieth.
/// Plain f32 is 20 times over, and so is Embree, which has reported t = 12,291 there.
#[test]
fn a_sliver_seen_edge_on_is_hit_where_it_is() {
    let sampler = Independent::new(3);
    let sine = 0.5f32.to_radians().sin();
    let mut hits = 0;
    for i in 0..200_000 {
        let mut u = PathSampler::new(&sampler, i, 0);
        let frame = Frame::from_normal(warp::square_to_uniform_sphere(u.next_2d()));
        let shift = 10.0 * Vec3A::new(u.next_1d(), u.next_1d(), u.next_1d());
        // Edges 11.2, 9.7 and 1.6.
        let sliver = [Vec3A::ZERO, Vec3A::new(11.2, 0.0, 0.0), Vec3A::new(9.686, 0.518, 0.0)];
        let corners = sliver.map(|p| frame.to_world(p) + shift);
        let weights = warp::square_to_uniform_triangle(u.next_2d());
        let [a, b, c] = corners;
        let target = a + (b - a) * weights.x + (c - a) * weights.y;
        let (y, x) = (std::f32::consts::TAU * u.next_1d()).sin_cos();
        let cosine = (1.0 - sine * sine).sqrt();
        let direction = frame.to_world(Vec3A::new(x * cosine, y * cosine, sine)).normalize();
        let ray = Ray::new(target - direction * 600.0, direction);
        for hit in both(&ray, &corners.map(|c| c.to_array())).into_iter().flatten() {
            hits += 1;
            let [a, b, c, o, d] = [a, b, c, ray.origin, direction].map(|p| p.as_dvec3());
            let on_triangle = a + (b - a) * f64::from(hit.u) + (c - a) * f64::from(hit.v);
            let gap = (o + d * f64::from(hit.t)).distance(on_triangle);
            let bound = 64.0 * 2f64.powi(-24) * (o.length() + f64::from(hit.t));
            assert!(gap <= bound, "{gap} > {bound}: {ray:?}");
        }
    }
    assert!(hits > 390_000, "{hits}: hardly a hit");
}

/// Triangles of a closed sphere of radius 2 around `center`.
fn sphere(center: Vec3A, rings: u32, segments: u32) -> Vec<Corners> {
    let corner = |ring: u32, segment: u32| {
        let theta = std::f32::consts::PI * ring as f32 / rings as f32;
        let phi = std::f32::consts::TAU * (segment % segments) as f32 / segments as f32;
        let sin = if ring.is_multiple_of(rings) { 0.0 } else { theta.sin() };
        let n = Vec3A::new(sin * phi.cos(), sin * phi.sin(), theta.cos());
        (center + 2.0 * n).to_array()
    };
    let mut triangles = Vec::new();
    for ring in 0..rings {
        for segment in 0..segments {
            let [a, b] = [corner(ring, segment), corner(ring, segment + 1)];
            let [c, d] = [corner(ring + 1, segment), corner(ring + 1, segment + 1)];
            if ring > 0 {
                triangles.push([a, c, b]);
            }
            if ring + 1 < rings {
                triangles.push([b, c, d]);
            }
        }
    }
    triangles
}

/// How many of `count` rays from inside `mesh` to a point on an edge, or to a corner, leave it.
fn leaks<T: RayTriangle>(center: Vec3A, mesh: &[Corners], count: u32, to_corner: bool) -> u32 {
    let sampler = Independent::new(4);
    let leaks = |i: &u32| {
        let mut u = PathSampler::new(&sampler, *i, 0);
        let inside = warp::square_to_uniform_sphere(u.next_2d()) * (1.9 * u.next_1d());
        let triangle = mesh[(u.next_1d() * mesh.len() as f32) as usize];
        let [a, b, _] = triangle.map(Vec3A::from);
        let target = if to_corner { a } else { a + (b - a) * u.next_1d() };
        let ray = Ray::new(center + inside, (target - center - inside).normalize());
        !mesh.iter().any(|triangle| test::<T>(&ray, triangle).is_some())
    };
    (0..count).filter(leaks).count() as u32
}

/// No ray leaves a closed mesh through an edge or a corner, near the origin and far from it. The plain
/// test shows that the rays are of the kind that can: it loses about a tenth.
#[test]
fn a_closed_mesh_is_watertight() {
    for center in [Vec3A::ZERO, Vec3A::splat(10.0), Vec3A::new(148_376.0, 1234.0, -223_423.0)] {
        let mesh = sphere(center, 12, 16);
        for to_corner in [false, true] {
            assert_eq!(leaks::<Watertight>(center, &mesh, 10_000, to_corner), 0, "{center}");
        }
    }
    let mesh = sphere(Vec3A::ZERO, 12, 16);
    for to_corner in [false, true] {
        let leaks = leaks::<Plain>(Vec3A::ZERO, &mesh, 10_000, to_corner);
        assert!((300..3000).contains(&leaks), "{leaks}");
    }
}

/// A closed unit cube in a random frame, with `cells` by `cells` squares of two triangles a face.
struct Cube {
    frame: Frame,
    mesh: Vec<Corners>,
}

impl Cube {
    fn new(u: &mut PathSampler, cells: usize) -> Self {
        let frame = Frame::from_normal(warp::square_to_uniform_sphere(u.next_2d()));
        let mut cube = Self { frame, mesh: Vec::new() };
        for place in 0..6 * cells * cells {
            let (face, i, j) = (place / cells / cells, place / cells % cells, place % cells);
            let corner = |(x, y): (usize, usize)| {
                let mut p = [0.0; 3];
                p[face / 2] = (face % 2) as f64;
                p[(face / 2 + 1) % 3] = (i + x) as f64 / cells as f64;
                p[(face / 2 + 2) % 3] = (j + y) as f64 / cells as f64;
                cube.point(p.into()).to_array()
            };
            let triangles = [[(0, 0), (1, 0), (1, 1)], [(0, 0), (1, 1), (0, 1)]];
            let triangles = triangles.map(|triangle| triangle.map(corner));
            cube.mesh.extend(triangles);
        }
        cube
    }

    fn point(&self, p: DVec3) -> Vec3A {
        let axes = [self.frame.s, self.frame.t, self.frame.n].map(Vec3A::as_dvec3);
        let [x, y, z] = [axes[0] * p.x, axes[1] * p.y, axes[2] * p.z];
        (x + y + z + DVec3::new(0.3, 0.2, 0.1)).as_vec3a()
    }

    /// A ray that leaves the plane z = 0 of the cube's frame at an angle of 1e-9 to 1e-5.
    fn grazing(&self, u: &mut PathSampler, origin: DVec3) -> Ray {
        let climb = 10f32.powf(4.0 * u.next_1d() - 9.0).copysign(u.next_1d() - 0.5);
        let (y, x) = (std::f32::consts::TAU * u.next_1d()).sin_cos();
        let direction = self.frame.to_world(Vec3A::new(x, y, climb)).normalize();
        Ray::new(self.point(origin), direction)
    }
}

/// Rays that start a rounding inside a face of a cube and go along it stay inside: of two triangles with a
/// common edge, none is missed for the sake of one that is seen edge-on.
#[test]
fn rays_along_a_face_stay_inside() {
    let sampler = Independent::new(5);
    for i in 0..60 {
        let mut u = PathSampler::new(&sampler, i, 0);
        let cube = Cube::new(&mut u, 4);
        for _ in 0..3000 {
            let origin = u.next_2d().extend(1e-7).as_dvec3();
            let ray = cube.grazing(&mut u, origin);
            let hits = |corners: &Corners| test::<Watertight>(&ray, corners).is_some();
            assert!(cube.mesh.iter().any(hits), "{ray:?}");
        }
    }
}

/// Rays that start within rounding of an edge of a cube, on any side of it: each hits the cube if the
/// solution in f64 says so of some triangle, and only then. With places in f32, 1 of 200 did not.
#[test]
fn rays_from_an_edge_hit_what_they_meet() {
    let sampler = Independent::new(6);
    let mut hits = 0;
    for i in 0..60 {
        let mut u = PathSampler::new(&sampler, i, 0);
        let cube = Cube::new(&mut u, 1);
        for _ in 0..3000 {
            let distance = 10f64.powf(4.0 * f64::from(u.next_1d()) - 9.0);
            let (z, x) = (std::f64::consts::TAU * f64::from(u.next_1d())).sin_cos();
            let origin = DVec3::new(distance * x, u.next_1d().into(), distance * z);
            let ray = if u.next_1d() < 0.5 {
                cube.grazing(&mut u, origin)
            } else {
                Ray::new(cube.point(origin), warp::square_to_uniform_sphere(u.next_2d()))
            };
            let meets = |corners: &&Corners| {
                let Solution { t, u, v } = Solution::new(&ray, corners);
                t > 0.0 && u >= 0.0 && v >= 0.0 && u + v <= 1.0
            };
            let found = |corners: &&Corners| test::<Watertight>(&ray, corners).is_some();
            let [met, found] =
                [cube.mesh.iter().any(|c| meets(&c)), cube.mesh.iter().any(|c| found(&c))];
            assert_eq!(found, met, "{ray:?}");
            hits += u32::from(met);
        }
    }
    assert!((60_000..120_000).contains(&hits), "{hits} of 180,000");
}
