//! Vectors, frames and warps have the same bits in one lane and in eight, too.

use super::*;
use crate::math::vector::{Vec2, Vec3};
use crate::math::{Frame, warp};

/// What is made of a point of the square, a number of [0, 1], and two directions.
#[inline(always)]
fn everything<R: Real>(u: Vec2<R>, x: R) -> [R; 32] {
    let disk = warp::square_to_uniform_disk(u);
    let sphere = warp::square_to_uniform_sphere(u);
    let hemisphere = warp::square_to_uniform_hemisphere(u);
    let cosine = warp::square_to_cosine_hemisphere(u);
    let cone = warp::square_to_uniform_cone(u, x);
    let triangle = warp::square_to_uniform_triangle(u);
    let frame = Frame::from_normal_and_tangent(sphere, cosine.lerp(cone, x));
    let local = frame.to_local(frame.to_world(cone));
    let steep = Frame::from_normal(cone.normalize()).s.cross(hemisphere);
    let inverse = [
        warp::uniform_disk_to_square(disk),
        warp::uniform_sphere_to_square(sphere),
        warp::uniform_hemisphere_to_square(hemisphere),
        warp::cosine_hemisphere_to_square(cosine),
        warp::uniform_cone_to_square(cone, x),
        warp::uniform_triangle_to_square(triangle),
    ];
    let sum = Vec2::select(u.x.lt(u.y), inverse[0] + inverse[1], inverse[2] - inverse[3]);
    let rest = -(inverse[4] / 3.0 + inverse[5] * x);
    [
        disk.x,
        disk.y,
        sphere.x,
        sphere.y,
        sphere.z,
        hemisphere.x,
        hemisphere.y,
        hemisphere.z,
        cosine.x,
        cosine.y,
        cosine.z,
        cone.x,
        cone.y,
        cone.z,
        triangle.x,
        triangle.y,
        local.x,
        local.y,
        local.z,
        steep.x,
        steep.y,
        steep.z,
        sum.x,
        sum.y,
        rest.x,
        rest.y,
        warp::square_to_uniform_disk_pdf(disk),
        warp::square_to_uniform_hemisphere_pdf(sphere),
        warp::square_to_cosine_hemisphere_pdf(sphere),
        warp::square_to_uniform_cone_pdf(x),
        warp::square_to_uniform_triangle_pdf(triangle * 1.5),
        rest.length(),
    ]
}

#[derive(Clone, Copy)]
struct Eight<'a>(&'a [Vec3]);

impl Task for Eight<'_> {
    type Output = Vec<[u32; 32]>;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Self::Output {
        let eight = |points: &[Vec3]| {
            let points = Vec3::<f32x8<S>>::load(simd, points);
            let results = everything(points.truncate(), points.z);
            [0, 1, 2, 3, 4, 5, 6, 7].map(|i| results.map(|result| result.lane(i).to_bits()))
        };
        self.0.chunks_exact(8).flat_map(eight).collect()
    }
}

#[test]
fn geometry_has_the_bits_of_one_lane() {
    let sampler = Independent::new(2);
    // Also the corners, edges, middle and diagonals of the square, and cones without extent.
    let special = [0.0, 0.25, 0.5, 0.75, 1.0 - f32::EPSILON / 2.0];
    let grid = special.iter().flat_map(|&x| special.map(|y| Vec3::new(x, y, x)));
    let any = (0..20_000).map(|i| {
        let mut u = PathSampler::new(&sampler, i, 0);
        Vec3::new(u.next_1d(), u.next_1d(), u.next_1d())
    });
    let points: Vec<Vec3> = grid.chain(any).collect();
    let expected = points.iter().map(|p| everything(p.truncate(), p.z).map(f32::to_bits));
    let expected: Vec<_> = expected.collect();
    for (level, found) in at_every_level(Eight(&points)) {
        for ((point, expected), found) in points.iter().zip(&expected).zip(&found) {
            let number = f32::from_bits;
            let same = |(a, b): (&u32, &u32)| a == b || number(*a).is_nan() && number(*b).is_nan();
            let differs = expected.iter().zip(found).position(|pair| !same(pair));
            assert_eq!(differs, None, "{level}: {point:?}");
        }
    }
}

#[test]
fn vectors_are_loaded_and_stored_by_lane() {
    let vectors: [Vec3; 8] = std::array::from_fn(|i| Vec3::new(i as f32, 1.0, -(i as f32)));
    #[derive(Clone, Copy)]
    struct RoundTrip([Vec3; 8]);
    impl Task for RoundTrip {
        type Output = [Vec3; 8];

        #[inline(always)]
        fn run<S: Simd>(self, simd: S) -> [Vec3; 8] {
            let loaded = Vec3::<f32x8<S>>::from_fn(simd, |i| self.0[i]);
            let mut stored = [Vec3::default(); 8];
            loaded.store(&mut stored);
            stored
        }
    }
    assert!(at_every_level(RoundTrip(vectors)).iter().all(|(_, stored)| *stored == vectors));
    let v = Vec3::new(3.0, 0.0, -4.0);
    assert_eq!((v.length(), v.normalize(), v.try_normalize().1), (5.0, v / 5.0, true));
    assert!(!Vec3::<f32>::default().try_normalize().1);
    assert_eq!(glam::Vec3::from(Vec3::from(glam::Vec3A::Y)), glam::Vec3::Y);
}
