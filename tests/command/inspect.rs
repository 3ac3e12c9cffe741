//! Scenes and paths looked at.

use crate::support::command::{Folder, SCENE};

#[test]
fn inspect_shows_what_is_there_and_what_is_skipped() {
    let folder = Folder::new();
    let run = folder.succeed("inspect scene.xml -D spp=11 --backend rust");
    assert_eq!(run.stderr, "");
    assert!(folder.names().is_empty());
    let text = run.stdout;
    for part in
        ["Sphere", "Diffuse", "32x24 pixels", "independent, 11 samples per pixel", "Rust BVH"]
    {
        assert!(text.contains(part), "{part}: {text}");
    }
    let (modelled, skipped) = text
        .split_once("\nThe render will model\n")
        .and_then(|(_, rest)| rest.split_once("\nThe render will skip\n"))
        .expect("both lists");
    let (skipped, carried) = skipped.split_once("\nA path carries ").expect("a third list");
    assert!(modelled.contains("\n  next-event estimation ") || modelled.starts_with("  next"));
    assert!(modelled.contains("environment light"), "{modelled}");
    for feature in ["time", "lens", "textures", "variance"] {
        assert!(skipped.contains(&format!("  {feature} ")), "{feature}: {skipped}");
    }
    assert!(carried.starts_with("108 of 116 bytes\n"), "{carried}");
    for part in [
        "  time                       0  no shape moves\n",
        "  relative index             0  no light passes through any surface\n",
    ] {
        assert!(carried.contains(part), "{carried}");
    }
}

/// A ball in a room so bright that a bounce leaves the range of f32.
const BLINDING: &str = r#"<scene version="3.0.0">
    <integrator type="path"/>
    <sensor type="perspective">
        <sampler type="independent"><integer name="sample_count" value="1"/></sampler>
        <film type="hdrfilm">
            <integer name="width" value="4"/>
            <integer name="height" value="3"/>
        </film>
    </sensor>
    <shape type="cube">
        <boolean name="flip_normals" value="true"/>
        <bsdf type="diffuse"/>
        <emitter type="area"><rgb name="radiance" value="3e38"/></emitter>
    </shape>
</scene>
"#;

#[test]
fn lost_samples_are_told_and_can_be_followed() {
    let folder = Folder::with_scene(BLINDING);
    let run = folder.succeed("render scene.xml --quiet --seed 5 --size 8x6");
    assert_eq!(
        run.stderr,
        "warning: samples that were not finite and are left out: 48; the first is sample 0 of pixel 0,0 with \
         seed 5\n  help: `telamon trace` follows its path: give it the same scene, --define, --size, --backend \
         and --accel, and --pixel 0,0 --sample 0 --seed 5\n"
    );
    let path = folder.succeed("trace scene.xml --pixel 0,0 --sample 0 --seed 5 --size 8x6").stdout;
    assert!(path.contains("\nedge 1\n  ray from (0.0, 0.0, 0.0) towards ("), "{path}");
    assert!(path.contains("(TriangleMesh, Diffuse), triangle "), "{path}");
    assert!(
        path.contains("  radiance so far: (3e38, 3e38, 3e38)\n\nedge 2\n  shadow ray "),
        "{path}"
    );
    let end = "\nradiance (inf, inf, inf), which is not finite and left out; alpha 1\n";
    assert!(path.ends_with(end), "{path}");
}

#[test]
fn what_half_floats_cannot_hold_is_clamped_and_told() {
    let folder = Folder::with_scene(&BLINDING.replace("3e38", "1e30"));
    let run = folder.succeed("render scene.xml -o a.exr --quiet");
    // Twelve pixels of three channels.
    assert_eq!(run.stderr, "warning: a.exr: values clamped to ±65504: 36\n");
}

#[test]
fn paths_that_are_not_there_cannot_be_followed() {
    let folder = Folder::new();
    let told = folder.fail("trace scene.xml --pixel 32,0", 1);
    assert_eq!(told, "error: pixel 32,0 does not lie within the film of 32x24 pixels\n");
    let told = folder.fail("trace scene.xml --pixel 32", 2);
    assert!(told.contains("expected column and row, such as 3,4"), "{told}");
    let layers = SCENE.replace(
        "<integrator type=\"path\"/>",
        "<integrator type=\"aov\"><string name=\"aovs\" value=\"z:depth\"/></integrator>",
    );
    let told = Folder::with_scene(&layers).fail("trace scene.xml --pixel 0,0", 1);
    assert_eq!(told, "error: there is no path: the integrator makes layers alone\n");
}
