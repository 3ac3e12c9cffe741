//! The scenes that are made of meshes look the same in Mitsuba 3.

use std::fs;

use telamon::load::mesh::MeshFormat;
use telamon::memory::Limits;
use telamon::studio::{ERROR, Light, Material, SAMPLES, Setup, Studio, View};

use crate::judge::judge;
use crate::mitsuba::{Mitsuba, Renders};
use crate::support::pictures::in_package;

const RUNS: u32 = 16;

/// Independent points and a box filter, as in the other scenes that are compared: what is made up is kept otherwise.
#[test]
fn made_up_scenes_are_the_same() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut mitsuba = Mitsuba::start();
    let size = (40, 32);
    let setups = [
        ("ball.obj", Setup { size, ..Setup::default() }),
        (
            "ball.ply",
            Setup {
                size,
                view: View::Angles(50.0, 4.0),
                material: Some(Material::Gold),
                light: Light::Sky,
                ..Setup::default()
            },
        ),
    ];
    let count = setups.len();
    for (mesh, setup) in setups {
        let path = in_package(&format!("tests/peers/scenes/meshes/{mesh}"));
        let format = MeshFormat::of(&path).expect("a mesh's name");
        let studio = Studio::new(&path, format, &setup, 1, &Limits::default()).expect("a mesh");
        let text = studio.scene();
        let error = format!("<float name=\"error\" value=\"{ERROR}\"/>");
        let samples = format!("\"sample_count\" value=\"{SAMPLES}\"");
        let mut compared = text.clone();
        for (old, new) in [
            ("\"sobol\"", "\"independent\""),
            (samples.as_str(), "\"sample_count\" value=\"32\""),
            // Mitsuba ends with the samples.
            (error.as_str(), ""),
            ("</film>", "<rfilter type=\"box\"/></film>"),
        ] {
            assert_eq!(compared.matches(old).count(), 1, "{old}: {text}");
            compared = compared.replace(old, new);
        }
        let scene = folder.path().join(format!("{mesh}.xml"));
        fs::write(&scene, compared).expect("writable");
        let theirs = mitsuba.renders(&scene, RUNS).expect("it renders");
        let ours = Renders::ours(&scene, &[], RUNS);
        judge(&ours, &theirs, count).unwrap_or_else(|why| panic!("{mesh}: {why}\n{text}"));
    }
}
