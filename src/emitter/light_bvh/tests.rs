use std::f32::consts::PI;

use glam::{DVec3, Vec3, Vec3A};

use super::*;
use crate::math::{Aabb, Cone};

/// Numbers in `[0, 1)` that look random.
pub(in crate::emitter) fn numbers() -> impl Iterator<Item = f32> {
    let mut state = 0x9e37_79b9_7f4a_7c15u64;
    std::iter::repeat_with(move || {
        state = state.wrapping_mul(0x5851_f42d_4c95_7f2d).wrapping_add(0x1405_7b7e_f767_814f);
        (state >> 40) as f32 / 16_777_216.0
    })
}

fn vectors() -> impl Iterator<Item = Vec3> {
    let mut numbers = numbers();
    std::iter::repeat_with(move || Vec3::from_array([0; 3].map(|_| numbers.next().unwrap_or(0.0))))
}

/// Lights of all kinds in the unit cube: narrow and wide cones, points and boxes.
pub(in crate::emitter) fn lights(count: usize) -> Vec<EmitterBounds> {
    let vectors: Vec<_> = vectors().take(4 * count).collect();
    let light = |v: &[Vec3]| EmitterBounds {
        space: Aabb { min: v[0], max: v[0] + v[1] * v[1].x.powi(8) },
        normals: Cone {
            axis: (v[2] - 0.5).normalize(),
            angle: if v[3].x < 0.2 { PI } else { 0.5 * v[3].x },
        },
        emission: v[3].y * 0.5 * PI,
        intensity: f64::from(v[3].z.powi(4)),
    };
    vectors.chunks_exact(4).map(light).collect()
}

pub(in crate::emitter) fn receivers() -> impl Iterator<Item = Receiver> {
    let mut vectors = vectors().skip(17);
    std::iter::repeat_with(move || {
        let [position, normal, side] = [0; 3].map(|_| vectors.next().unwrap_or_default());
        Receiver {
            position: (position * 2.0 - 0.5).as_dvec3(),
            normal: (normal - 0.5).normalize().into(),
            both_sides: side.x < 0.5,
            is_diffuse: side.y < 0.5,
        }
    })
}

/// How often nothing is found is what is left of the sum: a node may promise what none of its lights keeps.
#[test]
fn probabilities_are_those_of_samples_and_sum_to_one() {
    let narrow = lights(500);
    let everywhere = |light: &EmitterBounds| EmitterBounds { normals: Cone::ALL, ..*light };
    let wide: Vec<_> = narrow.iter().map(everywhere).collect();
    for (lights, complete) in [(narrow, false), (wide, true)] {
        let bvh = LightBvh::new(&lights).expect("some shine");
        for receiver in receivers().take(200) {
            let receiver = Receiver { both_sides: receiver.both_sides || complete, ..receiver };
            let sum: f64 = (0..lights.len()).map(|i| bvh.probability(&receiver, i)).sum();
            let found = numbers().take(1000).filter_map(|u| bvh.sample(&receiver, u.into()));
            let mut count = 0;
            for LightChoice { light, probability, rest } in found {
                assert_eq!(probability, bvh.probability(&receiver, light));
                assert!(probability > 0.0 && (0.0..1.0).contains(&rest));
                count += 1;
            }
            // Some ten levels of a rounding of each share; five standard deviations of the count.
            assert!(sum <= 1.0 + 1e-14 && (sum >= 1.0 - 1e-14 || !complete), "{sum}");
            let deviation = (1000.0 * sum * (1.0 - sum).max(0.0)).sqrt();
            let off = (f64::from(count) - 1000.0 * sum).abs();
            assert!(off <= 5.0 * deviation + 1e-9, "{count}, {sum}");
        }
        let receiver = receivers().next().expect("endless");
        assert_eq!(bvh.probability(&receiver, lights.len()), 0.0);
    }
}

/// What is known of a light says that it can be of use: then it can be chosen.
#[test]
fn no_light_of_use_is_left_out() {
    let lights = lights(300);
    let bvh = LightBvh::new(&lights).expect("some shine");
    let (mut of_use, mut of_none) = (0, 0);
    for receiver in receivers().take(500) {
        for (index, light) in lights.iter().enumerate() {
            let probability = bvh.probability(&receiver, index);
            // Exactly, in f64: whether a corner or the middle of the box, as a light by itself, shines there.
            let shines = |p: Vec3| {
                let to = receiver.position - p.as_dvec3();
                let axis = light.normals.axis.as_dvec3();
                let angle = axis.angle_between(to) - f64::from(light.normals.angle);
                let above = -to.dot(receiver.normal.as_dvec3());
                angle <= f64::from(light.emission) && (receiver.both_sides || above > 0.0)
            };
            let Aabb { min, max } = light.space;
            let places = [min, max, 0.5 * (min + max), Vec3::new(max.x, min.y, max.z)];
            if light.intensity > 0.0 && places.into_iter().any(shines) {
                assert!(probability > 0.0, "{light:?} for {receiver:?}");
                of_use += 1;
            } else {
                of_none += usize::from(probability == 0.0);
            }
        }
    }
    // Most of the others are known to be of no use, or the tree would be good for little.
    assert!(of_use > 10_000 && of_none > 10_000, "{of_use} {of_none}");
}

/// The choice is the same to the last bit when all is 2ᵏ times as large.
#[test]
fn size_does_not_matter() {
    let small = lights(100);
    let choices = |power: i32| -> Vec<_> {
        let scale = f32::from(2u8).powi(power);
        let scaled = small.iter().map(|light| {
            let Aabb { min, max } = light.space;
            EmitterBounds { space: Aabb { min: min * scale, max: max * scale }, ..*light }
        });
        let bvh = LightBvh::new(&scaled.collect::<Vec<_>>()).expect("some shine");
        let chosen = receivers().zip(numbers()).take(100).map(|(receiver, u)| {
            let receiver = Receiver { position: receiver.position * f64::from(scale), ..receiver };
            bvh.sample(&receiver, u.into())
        });
        chosen.collect()
    };
    let expected = choices(0);
    for power in [-40, -20, 1, 20, 40] {
        assert_eq!(choices(power), expected, "{power}");
    }
}

/// In one place, in a row, with intensities over 600 decades, a million.
#[test]
fn odd_lights_have_trees() {
    let at = |p: Vec3, intensity| EmitterBounds::point(p.into(), Cone::ALL, 0.0, intensity);
    let count = 100_000u32;
    let row = |i: u32| Vec3::X * (1.0005f32).powi(i as i32 % 80_000);
    let cases: [Vec<EmitterBounds>; 4] = [
        (0..count).map(|_| at(Vec3::ONE, 1.0)).collect(),
        (0..count).map(|i| at(row(i), 1.0)).collect(),
        (0..600).map(|i| at(Vec3::Y * i as f32, 10f64.powi(i - 300))).collect(),
        vectors().take(1_000_000).map(|p| at(p, 1.0)).collect(),
    ];
    for lights in &cases {
        let bvh = LightBvh::new(lights).expect("all shine");
        assert_eq!(bvh.nodes.len(), 2 * lights.len() - 1);
        for (receiver, u) in receivers().zip(numbers()).take(100) {
            let receiver = Receiver { both_sides: true, ..receiver };
            let choice = bvh.sample(&receiver, u.into()).expect("all shine everywhere");
            assert_eq!(choice.probability, bvh.probability(&receiver, choice.light));
        }
    }
    assert!(LightBvh::new(&[]).is_none() && LightBvh::new(&[at(Vec3::ZERO, 0.0)]).is_none());
}

/// Of two like lights the nearer is taken more often by the square of the distance, and one that faces away never.
#[test]
fn the_nearer_is_taken_more_often() {
    let at = |x: f32, axis| {
        let space = Aabb { min: Vec3::X * x, max: Vec3::X * x };
        EmitterBounds::surface(space, Cone::direction(axis), 1.0)
    };
    let receiver =
        Receiver { position: DVec3::ZERO, normal: Vec3A::X, both_sides: false, is_diffuse: false };
    let shares = |lights: [EmitterBounds; 2]| {
        let bvh = LightBvh::new(&lights).expect("both shine");
        [0, 1].map(|i| bvh.probability(&receiver, i))
    };
    let [near, far] = shares([at(1.0, Vec3::NEG_X), at(3.0, Vec3::NEG_X)]);
    assert!((near - 0.9).abs() < 1e-6 && (far - 0.1).abs() < 1e-6, "{near} {far}");
    assert_eq!(shares([at(1.0, Vec3::X), at(3.0, Vec3::NEG_X)]), [0.0, 1.0]);
    assert_eq!(shares([at(-1.0, Vec3::X), at(3.0, Vec3::NEG_X)]), [0.0, 1.0]);
    // Hidden or not, none that is of use is given up.
    let least = shares([at(1e-3, Vec3::NEG_X), at(3.0, Vec3::NEG_X)])[1];
    assert_eq!(least, LEAST_SHARE);
}
