//! Rays of cameras, and where samples lie in their pixel.

use std::array;

use glam::{DAffine3, DVec2, DVec3, Vec2 as GlamVec2};
use telamon::camera::{
    Camera, Lens, Orthographic, OrthographicSettings, Perspective, PerspectiveSettings,
};
use telamon::film::{Filter, FilterSampler};
use telamon::math::real::{Lanes, Level, Simd, Task, f32x8, f64x8};
use telamon::math::vector::Vec2;
use telamon::ray::{Ray, Rays};

use crate::support::points;

fn cameras() -> [Camera; 4] {
    let to_world = DAffine3::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), 0.7)
        * DAffine3::from_translation(DVec3::new(3.0, -5.0, 1e3));
    let perspective = |lens| {
        let settings = PerspectiveSettings {
            to_world,
            fov_x_deg: 40.0,
            aspect: 1.5,
            principal_point_offset: GlamVec2::new(0.1, -0.2),
            lens,
            near_clip: 0.01,
            far_clip: 1e4,
        };
        Camera::Perspective(Perspective::new(&settings).expect("valid"))
    };
    let lens = |focus_distance| Some(Lens { aperture_radius: 0.3, focus_distance });
    let settings = OrthographicSettings { to_world, aspect: 1.5, near_clip: 0.0, far_clip: 1e4 };
    [
        perspective(None),
        perspective(lens(7.0)),
        perspective(lens(f64::INFINITY)),
        Camera::Orthographic(Orthographic::new(&settings).expect("valid")),
    ]
}

struct Look<'a> {
    camera: &'a Camera,
    film: [DVec2; 8],
    lens: [GlamVec2; 8],
}

impl Task for Look<'_> {
    type Output = [Ray; 8];

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> [Ray; 8] {
        let Self { camera, film, lens } = self;
        let film: Vec2<f64x8<S>> = Vec2::from_fn(simd, |i| film[i].into());
        let lens = camera.has_lens().then(|| Vec2::from_fn(simd, |i| lens[i].into()));
        let rays = camera.rays::<f32x8<S>>(film, lens);
        let mut columns = Rays::default();
        columns.append_from_camera(f32x8::<S>::mask(simd, |i| i != 3), &rays);
        let lanes: [Ray; 8] = array::from_fn(|i| rays.lane(i));
        for (k, i) in [0, 1, 2, 4, 5, 6, 7].into_iter().enumerate() {
            assert_eq!(columns.get(k), lanes[i]);
        }
        lanes
    }
}

#[test]
fn rays_of_cameras_have_one_form() {
    for camera in cameras() {
        let places: Vec<_> = points(80, 800).zip(points(81, 800)).collect();
        for eight in places.as_chunks::<8>().0 {
            let film = eight.map(|(film, _)| film.as_dvec2());
            let lens = eight.map(|(_, lens)| lens);
            for level in [Level::baseline(), Level::detect()] {
                let rays = level.run(Look { camera: &camera, film, lens });
                for (lane, ray) in rays.into_iter().enumerate() {
                    let alone = if camera.has_lens() {
                        camera.ray_through_lens(film[lane], lens[lane])
                    } else {
                        camera.ray(film[lane])
                    };
                    assert_eq!(ray, alone, "{camera:?} {level:?}");
                }
            }
        }
    }
}

struct Place<'a> {
    filter: &'a FilterSampler,
    u: [GlamVec2; 8],
}

impl Task for Place<'_> {
    type Output = [[u32; 2]; 8];

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> [[u32; 2]; 8] {
        let u: Vec2<f32x8<S>> = Vec2::from_fn(simd, |i| self.u[i].into());
        let offset = self.filter.sample(u);
        array::from_fn(|i| offset.lane(i).to_array().map(f32::to_bits))
    }
}

#[test]
fn places_in_pixels_have_one_form() {
    for filter in [Filter::Box, Filter::Tent { radius: 1.5 }, Filter::Gaussian { stddev: 0.5 }] {
        let sampler = FilterSampler::new(filter);
        let all: Vec<_> = points(82, 800).chain([GlamVec2::splat(0.5); 8]).collect();
        for u in all.as_chunks::<8>().0 {
            for level in [Level::baseline(), Level::detect()] {
                let places = level.run(Place { filter: &sampler, u: *u });
                for (lane, place) in places.into_iter().enumerate() {
                    let alone = sampler.sample::<f32>(u[lane].into());
                    assert_eq!(place, alone.to_array().map(f32::to_bits), "{filter:?}");
                }
            }
        }
    }
}
