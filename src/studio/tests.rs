use std::fs;
use std::path::PathBuf;

use glam::{DVec2, DVec3};

use super::framing::NEAREST;
use super::{Axis, Background, Light, MARGIN, Material, Setup, Studio, View};
use crate::camera::Camera;
use crate::load::mesh::MeshFormat;
use crate::load::{LoadOptions, load_text};
use crate::memory::Limits;
use crate::render::Description;

/// A mesh in a folder of its own.
struct Mesh {
    _folder: tempfile::TempDir,
    path: PathBuf,
    points: Vec<DVec3>,
}

fn obj(points: &[DVec3], faces: &str) -> String {
    let lines: String = points.iter().map(|p| format!("v {} {} {}\n", p.x, p.y, p.z)).collect();
    lines + faces
}

impl Mesh {
    fn new(points: Vec<DVec3>, faces: &str) -> Self {
        Self::with_files(points, faces, &[])
    }

    fn with_files(points: Vec<DVec3>, faces: &str, others: &[(&str, &str)]) -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a & b $c.obj");
        fs::write(&path, obj(&points, faces)).expect("can be written");
        for (name, text) in others {
            fs::write(folder.path().join(name), text).expect("can be written");
        }
        Self { _folder: folder, path, points }
    }

    /// Some triangles whose corners are spread over a box.
    fn random(seed: u64, size: DVec3, center: DVec3) -> Self {
        let mut state = seed;
        let mut number = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) as f64 / f64::from(1_u32 << 31) - 0.5
        };
        let points: Vec<_> =
            (0..30).map(|_| center + size * DVec3::new(number(), number(), number())).collect();
        let faces: String =
            (0..10).map(|i| format!("f {} {} {}\n", 3 * i + 1, 3 * i + 2, 3 * i + 3)).collect();
        // As the renderer sees them.
        let points = points.into_iter().map(|p| p.as_vec3().as_dvec3()).collect();
        Self::new(points, &faces)
    }

    fn studio(&self, setup: &Setup, turntable: u32) -> Studio {
        Studio::new(&self.path, MeshFormat::Obj, setup, turntable, &Limits::default())
            .unwrap_or_else(|e| panic!("{e}"))
    }

    fn error(&self, setup: &Setup) -> String {
        Studio::new(&self.path, MeshFormat::Obj, setup, 1, &Limits::default())
            .map(|_| ())
            .expect_err("makes no sense")
            .to_string()
    }
}

fn load(text: &str) -> Description {
    let loaded = load_text(text, "scene.xml".as_ref(), &LoadOptions::default());
    loaded.unwrap_or_else(|e| panic!("{text}\n{e}")).description
}

/// Where a camera sees a point: from (0, 0) at the upper left to (1, 1). By its corner rays alone, which do not know how it
/// was placed.
fn seen(camera: &Camera, point: DVec3) -> DVec2 {
    let ray = |x, y| {
        let ray = camera.ray(DVec2::new(x, y));
        ray.direction.as_dvec3()
    };
    let origin = camera.ray(DVec2::splat(0.5)).origin.as_dvec3();
    let view = ray(0.5, 0.5);
    let flat = |d: DVec3| d / d.dot(view);
    let (across, down) =
        (flat(ray(1.0, 0.5)) - flat(ray(0.0, 0.5)), flat(ray(0.5, 1.0)) - flat(ray(0.5, 0.0)));
    let p = flat(point - origin) - view;
    let distance = (point - origin).dot(view);
    assert!(distance > 0.0, "in front");
    DVec2::splat(0.5)
        + DVec2::new(p.dot(across), p.dot(down))
            / DVec2::new(across.length_squared(), down.length_squared())
}

fn views() -> Vec<View> {
    let named = View::names().map(|name| name.parse::<View>().expect("a name"));
    named.chain([View::Angles(-200.0, 63.0), View::Angles(77.0, -31.0)]).collect()
}

/// From every side, all vertices are within the margins, and those at two opposite ones touch them.
#[test]
fn the_mesh_fills_the_picture() {
    let shapes = [
        (DVec3::ONE, DVec3::ZERO),
        (DVec3::new(3.0, 0.2, 0.5), DVec3::new(5.0, -2.0, 9.0)),
        (DVec3::new(0.02, 0.9, 0.04), DVec3::new(0.0, 0.5, 0.0)),
        (DVec3::splat(300.0), DVec3::splat(-700.0)),
    ];
    for (seed, (size, center)) in (1..).zip(shapes) {
        let mesh = Mesh::random(seed, size, center);
        let least = mesh.points.iter().copied().reduce(DVec3::min).expect("some");
        let most = mesh.points.iter().copied().reduce(DVec3::max).expect("some");
        let radius = (most - least).length() / 2.0;
        for view in views() {
            for up in Axis::ALL {
                for (size, fov) in [((800, 600), 30.0), ((300, 700), 75.0), ((500, 500), 5.0)] {
                    let setup = Setup { up: Some(up), view, fov, size, ..Setup::default() };
                    let text = mesh.studio(&setup, 1).cameras().next().expect("one");
                    let camera = load(&text).camera;
                    let seen: Vec<_> = mesh.points.iter().map(|&p| seen(&camera, p)).collect();
                    let least = seen.iter().copied().reduce(DVec2::min).expect("some");
                    let most = seen.iter().copied().reduce(DVec2::max).expect("some");
                    // Rays have 32-bit floats, and so have the places that are looked at.
                    let rounding = 2e-4;
                    let what = format!("{view} {up} {size:?} {fov}: {least} {most}");
                    assert!(least.min_element() > MARGIN - rounding, "{what}");
                    assert!(most.max_element() < 1.0 - MARGIN + rounding, "{what}");
                    let touches = |axis: usize| {
                        least[axis] < MARGIN + rounding && most[axis] > 1.0 - MARGIN - rounding
                    };
                    // Wide views stay away from what is nearest.
                    let place = camera.ray(DVec2::splat(0.5)).origin.as_dvec3();
                    let view = camera.ray(DVec2::splat(0.5)).direction.as_dvec3();
                    let depths = mesh.points.iter().map(|&p| (p - place).dot(view));
                    let nearest = depths.fold(f64::INFINITY, f64::min);
                    let is_near = nearest < (NEAREST + rounding) * radius;
                    assert!(touches(0) || touches(1) || is_near, "{what}");
                }
            }
        }
    }
}

/// Around the mesh the camera stays at one height and distance, and every picture holds all of it.
#[test]
fn a_turntable_keeps_its_distance() {
    let mesh = Mesh::random(7, DVec3::new(2.0, 1.0, 0.3), DVec3::new(0.3, 0.1, -4.0));
    let studio = mesh.studio(&Setup::default(), 7);
    let (least, most) = (
        mesh.points.iter().copied().reduce(DVec3::min).expect("some"),
        mesh.points.iter().copied().reduce(DVec3::max).expect("some"),
    );
    let center = (least + most) / 2.0;
    let mut places = Vec::new();
    for text in studio.cameras() {
        let camera = load(&text).camera;
        let place = camera.ray(DVec2::splat(0.5)).origin.as_dvec3() - center;
        places.push((place.y, DVec2::new(place.x, place.z).length()));
        for &point in &mesh.points {
            let seen = seen(&camera, point);
            let margin = seen.min(1.0 - seen).min_element();
            assert!(margin > MARGIN - 2e-4, "{margin}");
        }
    }
    assert_eq!(places.len(), 7);
    let (height, distance) = places[0];
    assert!(places.iter().all(|(h, d)| (h - height).abs() < 1e-5 && (d - distance).abs() < 1e-5));
    // The first picture is what the scene shows.
    let first = load(&studio.cameras().next().expect("one")).camera;
    let scene = load(&studio.scene()).camera;
    assert_eq!(format!("{first:?}"), format!("{scene:?}"));
}

/// Everything that can be asked for is a scene that loads without a warning, and whose lamps are not in the picture.
#[test]
fn every_choice_is_an_ordinary_scene() {
    let mesh = Mesh::random(3, DVec3::ONE, DVec3::ZERO);
    let sky = mesh.path.with_file_name("sky.hdr");
    let pixels = [image::Rgb([0.5_f32, 0.6, 0.9]); 8];
    let mut bytes = Vec::new();
    image::codecs::hdr::HdrEncoder::new(&mut bytes).encode(&pixels, 4, 2).expect("memory");
    fs::write(&sky, bytes).expect("can be written");
    let default = Setup::default;
    let mut setups: Vec<Setup> = Material::ALL
        .into_iter()
        .filter(|material| *material != Material::File)
        .map(|material| Setup { material: Some(material), ..default() })
        .collect();
    setups.extend(views().into_iter().map(|view| Setup { view, ..default() }));
    setups.extend(Axis::ALL.map(|up| Setup { up: Some(up), light: Light::Sky, ..default() }));
    setups.extend(Axis::ALL.map(|up| Setup {
        up: Some(up),
        light: Light::File(sky.clone()),
        ..default()
    }));
    setups.extend(["white", "transparent", "0.1,0.2,0"].map(|text| {
        let background = Some(text.parse::<Background>().expect("understood"));
        Setup { background, ..default() }
    }));
    let white = Some(Background::Color(DVec3::ONE));
    setups.push(Setup { light: Light::None, background: white, ..default() });
    for setup in setups {
        let studio = mesh.studio(&setup, 1);
        let text = studio.scene();
        let loaded = load_text(&text, "scene.xml".as_ref(), &LoadOptions::default());
        let loaded = loaded.unwrap_or_else(|e| panic!("{text}\n{e}"));
        assert!(loaded.warnings.is_empty(), "{text}\n{:?}", loaded.warnings);
        let film = &loaded.description.film;
        assert_eq!((film.width, film.height), setup.size);
        assert_eq!(film.alpha, setup.background == Some(Background::Transparent));
    }
}

/// A map of points.
type Turn = fn(DVec3) -> DVec3;

fn cube(size: DVec3) -> Vec<DVec3> {
    let bit = |i: usize, b: usize| (i >> b & 1) as f64;
    (0..8).map(|i| size * DVec3::new(bit(i, 0), bit(i, 1), bit(i, 2))).collect()
}

const CUBE: &str = "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";

/// +y, or +z in STL files; but a mesh that stands on a flat base elsewhere, and has nothing like it above, stands there.
#[test]
fn up_is_found() {
    let up = |mesh: &Mesh, format| {
        let subject = super::Subject::load(&mesh.path, MeshFormat::Obj, &Limits::default());
        subject.expect("a mesh").up(format).0.to_string()
    };
    let random = Mesh::random(1, DVec3::ONE, DVec3::ZERO);
    assert_eq!(up(&random, MeshFormat::Ply), "+y");
    assert_eq!(up(&random, MeshFormat::Stl), "+z");
    // A box has a base on all sides.
    assert_eq!(up(&Mesh::new(cube(DVec3::ONE), CUBE), MeshFormat::Obj), "+y");
    // A pyramid on the side that `turn` brings it to.
    let pyramid = |height: f64, turn: Turn| {
        let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
        let base = corners.map(|(x, z)| DVec3::new(x, 0.0, -z));
        let points = base.into_iter().chain([DVec3::Y * height]).map(turn).collect();
        Mesh::new(points, "f 4 3 2 1\nf 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n")
    };
    let turns: [(Turn, &str); 4] = [
        (|p| p, "+y"),
        (|p| DVec3::new(p.x, -p.z, p.y), "+z"),
        (|p| DVec3::new(p.x, -p.y, -p.z), "-y"),
        (|p| DVec3::new(-p.y, p.x, p.z), "-x"),
    ];
    for (turn, expected) in turns {
        assert_eq!(up(&pyramid(2.0, turn), MeshFormat::Obj), expected);
    }
    // A plaque with a flat back is no statue that lies.
    assert_eq!(up(&pyramid(0.3, turns[1].0), MeshFormat::Obj), "+y");
}

/// What is too large, too small or too far away for lamps around it is brought into reach, with its details.
#[test]
fn extreme_meshes_are_brought_into_reach() {
    for (size, center) in [
        (1e8, DVec3::ZERO),
        (1e-8, DVec3::ZERO),
        (1.0, DVec3::new(1e6, -2e6, 3e5)),
        (1e-8, DVec3::splat(1e-3)),
        (1e30, DVec3::ZERO),
    ] {
        let points = cube(DVec3::splat(size)).into_iter().map(|p| p + center).collect();
        let mesh = Mesh::new(points, CUBE);
        if size > 1e18 {
            let error = mesh.error(&Setup::default());
            assert!(
                error.contains("there is no triangle with an area and finite vertices"),
                "{error}"
            );
            continue;
        }
        let studio = mesh.studio(&Setup::default(), 1);
        let description = load(&studio.scene());
        let bounds = description.scene.objects()[0].shape.bounds();
        let extent = (bounds.max - bounds.min).as_dvec3();
        let scaled = if size == 1.0 { 1.0 } else { 2.0 / 3.0_f64.sqrt() };
        // Where it is and how large it is was found with 32-bit floats; its own form is exact.
        let rounding = f64::from(f32::EPSILON) * center.length() / size;
        let size_error = if size == 1.0 { 0.0 } else { rounding };
        let error = (extent / scaled - 1.0).abs().max_element();
        assert!(error < 1e-6 + size_error, "{size} {extent}");
        assert!((extent / extent.x - 1.0).abs().max_element() < 1e-6, "{extent}");
        let middle = (bounds.min + bounds.max).as_dvec3() / 2.0;
        assert!(middle.abs().max_element() < 1e-6 + rounding, "{size} {middle}");
    }
}

#[test]
fn what_makes_no_sense_is_refused() {
    let mesh = Mesh::new(cube(DVec3::ONE), CUBE);
    let default = Setup::default;
    let dark = Setup { light: Light::None, ..default() };
    assert_eq!(
        mesh.error(&dark),
        "without a light the picture is black: the mesh has no material that emits (give a --light or a --background)"
    );
    let below = Setup { view: View::Named("bottom"), ground: Some(true), ..default() };
    assert_eq!(
        mesh.error(&below),
        "the ground hides the mesh from below (leave out --ground on, or look from above: --view)"
    );
    let both = Setup {
        light: Light::File("sky.exr".into()),
        background: Some(Background::Color(DVec3::ONE)),
        ..default()
    };
    assert_eq!(
        mesh.error(&both),
        "--background has no effect beside --light sky.exr: what that shows is the background"
    );
    let file = Setup { material: Some(Material::File), ..default() };
    assert!(mesh.error(&file).ends_with(
        "has no materials of its own for --material file (only an OBJ file with its .mtl does)"
    ));
    let point = Mesh::new(vec![DVec3::ONE; 3], "f 1 2 3\n");
    assert!(
        point.error(&default()).ends_with(
            "there is no triangle with an area and finite vertices, so nothing to be seen"
        )
    );
    // A lamp of its own is light enough.
    let faces = format!("mtllib lamp.mtl\nusemtl lamp\n{CUBE}");
    let lamp =
        Mesh::with_files(cube(DVec3::ONE), &faces, &[("lamp.mtl", "newmtl lamp\nKe 1 1 1\n")]);
    let description = load(&lamp.studio(&dark, 1).scene());
    assert_eq!(description.scene.emitters().len(), 1);
}

#[test]
fn words_are_understood_or_explained() {
    for axis in Axis::ALL {
        assert_eq!(axis.to_string().parse::<Axis>(), Ok(axis));
        let right_handed = axis.right().cross(axis.direction());
        assert_eq!(right_handed, axis.front());
        assert_eq!(axis.front().length(), 1.0);
    }
    assert_eq!("Z".parse::<Axis>().map(|a| a.to_string()), Ok("+z".to_owned()));
    assert_eq!("30,-15".parse::<View>(), Ok(View::Angles(30.0, -15.0)));
    let explained =
        |error: Result<(), super::setup::Misunderstood>| error.expect_err("wrong").to_string();
    assert_eq!(
        explained("w".parse::<Axis>().map(|_| ())),
        "expected an axis: +x, +y, +z, -x, -y or -z"
    );
    for wrong in ["side", "1", "1,91", "nan,0", "400,0"] {
        assert_eq!(
            explained(wrong.parse::<View>().map(|_| ())),
            "expected three-quarter, front, back, left, right, top, bottom, or degrees to the right of the front (-360 to \
             360) and above (-90 to 90), such as 30,15"
        );
    }
    for wrong in ["red", "1,2", "-1,0,0", "nan,0,0", "1,1,1e39"] {
        assert_eq!(
            explained(wrong.parse::<Background>().map(|_| ())),
            "expected white, black, transparent, or red, green and blue of 0 or above (linear), such as 0.1,0.1,0.2"
        );
    }
    assert_eq!(
        explained("moon".parse::<Light>().map(|_| ())),
        "expected studio, sky, none, or a picture file such as sky.exr"
    );
}

/// Grey ground is all that is seen above the mesh; where the ground ends in the picture, or a background is asked for, it
/// reflects all light, and is as bright as what is behind it.
#[test]
fn there_is_no_horizon() {
    let mesh = Mesh::new(cube(DVec3::new(1.0, 2.0, 1.0)), CUBE);
    let radius = 1.5_f64.sqrt();
    let (mut grey, mut white) = (0, 0);
    for elevation in [0.0, 4.0, 11.0, 12.0, 15.0, 22.0, 24.0, 50.0, 90.0] {
        for (size, fov) in
            [((800, 600), 30.0), ((300, 600), 30.0), ((800, 600), 4.0), ((90, 60), 80.0)]
        {
            let view = View::Angles(-30.0, elevation);
            let setup = Setup { view, size, fov, ..Setup::default() };
            let text = mesh.studio(&setup, 1).scene();
            let ray = load(&text).camera.ray(DVec2::new(0.5, 0.0));
            let (from, toward) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
            let at = from - toward * (from.y / toward.y);
            let is_ground = toward.y < 0.0 && DVec2::new(at.x, at.z).length() < 1000.0 * radius;
            let reflects = |value: &str| {
                text.contains(&format!("<rgb name=\"reflectance\" value=\"{value}\"/>"))
            };
            assert_eq!((reflects("0.45"), reflects("1")), (is_ground, !is_ground), "{setup:?}");
            *if is_ground { &mut grey } else { &mut white } += 1;
            let background = Some(Background::Color(DVec3::splat(0.3)));
            let setup = Setup { background, ..setup };
            assert!(
                mesh.studio(&setup, 1).scene().contains("<rgb name=\"reflectance\" value=\"1\"/>")
            );
        }
    }
    assert!(grey > 9 && white > 9, "{grey} {white}");
}
