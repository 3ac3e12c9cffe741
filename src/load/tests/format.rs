//! The format itself: references, parameters, several files, older versions.

use std::fs;
use std::path::Path;
use std::sync::Arc;

use super::super::{LoadOptions, load_scene, load_text};
use super::{SENSOR, description, load};
use crate::bsdf::Place;
use crate::film::Filter;
use crate::integrator::IntegratorSettings;
use crate::sampler::{SamplerKind, SamplerSettings};
use crate::scene::Object;
use crate::shape::Geometry;

#[test]
fn references_share_materials_and_may_point_forwards() {
    let d = description(
        "<shape type='sphere' id='ball'><ref id='red'/></shape>\
         <shape type='cube'><ref id='other' name='bsdf'/></shape><shape type='disk'/><shape type='disk'/>\
         <bsdf type='conductor' id='unused'/><bsdf type='diffuse' id='red'/><alias id='red' as='other'/>",
    );
    let objects = d.scene.objects();
    assert_eq!(objects[0].bsdf, objects[1].bsdf);
    assert_eq!(objects[2].bsdf, objects[3].bsdf);
    assert_eq!((d.scene.bsdfs().len(), objects[0].name.as_str()), (3, "ball"));
}

/// A group is built once, however often it is placed, and before or after that it is defined; its shapes
/// keep their materials.
#[test]
fn instances_share_a_group_with_its_materials() {
    let d = description(
        "<shape type='instance'><ref id='pair'/></shape>\
         <shape type='shapegroup' id='pair'>\
           <shape type='cube'/><shape type='disk'><bsdf type='conductor'/></shape></shape>\
         <shape type='disk'/>\
         <shape type='instance' id='two'><ref id='pair'/></shape>",
    );
    let [one, disk, two] = d.scene.objects() else { panic!("{:?}", d.scene.objects()) };
    let group = |object: &Object| match object.shape.geometry() {
        Geometry::Instance(instance) => Arc::as_ptr(instance.group()),
        other => panic!("{other:?}"),
    };
    assert_eq!(group(one), group(two));
    assert_eq!((one.bsdfs(), two.name.as_str()), (two.bsdfs(), "two"));
    assert_eq!([one.bsdf_of(0), disk.bsdf_of(0)], [disk.bsdf; 2]);
    assert_eq!(d.scene.bsdfs()[one.bsdf_of(1)].kind(), "Conductor");
}

#[test]
fn lights_are_found_where_they_stand() {
    let d = description(
        "<emitter type='point'/><shape type='disk'><emitter type='area'/></shape>\
         <emitter type='area' id='e'/><shape type='disk'><ref id='e'/></shape><emitter type='constant'/>",
    );
    assert_eq!(d.scene.emitters().len(), 4);
    let emitters: Vec<_> = d.scene.objects().iter().map(|o| o.emitter).collect();
    // Those of shapes come first, in the order of the shapes; then the others.
    assert_eq!(emitters, [Some(0), Some(1)]);
    assert_eq!(d.scene.environment().map(|(index, _)| index), Some(3));
}

/// A shape that names no material is half grey, unless it emits: then it is black, as in Mitsuba.
#[test]
fn shapes_without_a_material_have_one() {
    let scene = description(
        "<shape type='sphere'/><shape type='sphere'><emitter type='area'/></shape>
         <shape type='cube'/><shape type='cube'><emitter type='area'/></shape>",
    )
    .scene;
    let up = glam::Vec3A::Z;
    let albedos: Vec<f32> = scene
        .objects()
        .iter()
        .map(|o| scene.bsdfs()[o.bsdf].albedo(&Place::default(), up).x)
        .collect();
    assert_eq!(albedos, [0.5, 0.0, 0.5, 0.0]);
    assert_eq!(scene.bsdfs().len(), 2, "shared");
}

#[test]
fn shapes_keep_the_order_of_the_file() {
    let shapes: String = (0..40)
        .map(|i| {
            let kind = ["sphere", "cube", "disk", "rectangle"][i % 4];
            format!("<shape type='{kind}' id='{i}'/>")
        })
        .collect();
    let names: Vec<String> =
        description(&shapes).scene.objects().iter().map(|o| o.name.clone()).collect();
    assert_eq!(names, (0..40).map(|i| i.to_string()).collect::<Vec<_>>());
}

#[test]
fn parameters_are_substituted() {
    let text = "<scene version='3.0.0'><default name='spp' value='16'/><default name='kind' value='cube'/>\
         <shape type='$kind'/><sensor type='perspective'><sampler type='independent'>\
         <integer name='sample_count' value='$spp'/></sampler></sensor><emitter type='point'/></scene>";
    let spp = |defines: &[(&str, &str)]| {
        let defines = defines.iter().map(|(n, v)| ((*n).to_owned(), (*v).to_owned())).collect();
        let loaded =
            load_text(text, Path::new("a.xml"), &LoadOptions { defines, ..LoadOptions::default() })
                .expect("valid");
        let warnings: Vec<_> = loaded.warnings.iter().map(ToString::to_string).collect();
        (loaded.description.sampler.samples_per_pixel, warnings)
    };
    assert_eq!(spp(&[]), (16, vec![]));
    assert_eq!(spp(&[("spp", "64"), ("kind", "disk")]).0, 64);
    let warning = "a.xml: nothing refers to the parameter `ssp` (given as 64)".to_owned();
    assert_eq!(spp(&[("ssp", "64")]), (16, vec![warning]));
}

#[test]
fn several_sensors_and_stray_text_are_warned_about() {
    let text =
        format!("<scene version='3.0.0'>\n{SENSOR} oops\n{SENSOR}<emitter type='point'/></scene>");
    let warnings: Vec<_> =
        load(&text).expect("valid").warnings.iter().map(ToString::to_string).collect();
    assert_eq!(
        warnings,
        [
            "scene.xml:2:29: text inside <scene> means nothing",
            "scene.xml:3:1: this sensor is not used: the first one of the scene is",
        ]
    );
}

/// What stands for another sampler says so, and takes the count and the seed from it.
#[test]
fn samplers_that_are_replaced_are_named() {
    let sampler = |name: &str, more: &str| {
        let text = format!(
            "<scene version='3.0.0'><sensor type='perspective'>\n<sampler type='{name}'>{more}\
             <integer name='sample_count' value='8'/><integer name='seed' value='3'/></sampler></sensor>\
             <emitter type='point'/></scene>"
        );
        let loaded = load(&text).expect("valid");
        let warnings: Vec<_> = loaded.warnings.iter().map(ToString::to_string).collect();
        (loaded.description.sampler, warnings)
    };
    let settings = |kind| SamplerSettings { kind, samples_per_pixel: 8, seed: 3 };
    let sobol = settings(SamplerKind::Sobol);
    assert_eq!(sampler("independent", ""), (settings(SamplerKind::Independent), vec![]));
    assert_eq!(sampler("sobol", ""), (sobol, vec![]));
    for (name, more) in [
        ("stratified", "<boolean name='jitter' value='false'/>"),
        ("multijitter", ""),
        ("orthogonal", "<integer name='strength' value='3'/>"),
        ("ldsampler", ""),
    ] {
        let warning = format!("scene.xml:2:16: sampler `sobol` is used in place of `{name}`");
        assert_eq!(sampler(name, more), (sobol, vec![warning]));
    }
}

/// A scene in the words of Mitsuba 0.6, with all kinds of renamed things.
#[test]
fn old_scenes_are_upgraded() {
    let loaded = load(
        "<scene version='0.6.0'><integrator type='path'><integer name='maxDepth' value='3'/>\
         <integer name='rrDepth' value='7'/><boolean name='hideEmitters' value='true'/></integrator>\
         <sensor type='perspective'><string name='fovAxis' value='smaller'/><float name='fov' value='40'/>\
         <transform name='toWorld'><lookAt origin='0,0,5' target='0,0,0' up='0,1,0'/></transform>\
         <sampler type='independent'><integer name='sampleCount' value='9'/></sampler>\
         <film type='hdrfilm'><integer name='cropOffsetX' value='3'/><string name='pixelFormat' value='rgba'/>\
         <rfilter type='box'/></film></sensor>\
         <shape type='sphere'><transform name='toWorld'><scale value='3'/></transform>\
         <boolean name='flipNormals' value='true'/>\
         <bsdf type='dielectric'><float name='intIOR' value='1.5'/><float name='extIOR' value='1'/></bsdf></shape>\
         <shape type='disk'><bsdf type='diffuse'><rgb name='diffuseReflectance' value='.25'/></bsdf></shape>\
         </scene>",
    )
    .unwrap_or_else(|e| panic!("{e}"));
    let d = loaded.description;
    let IntegratorSettings::Path(path) = d.integrator else { panic!("{:?}", d.integrator) };
    assert_eq!((path.max_depth, path.roulette.min_depth, path.hide_emitters), (Some(3), 7, true));
    assert_eq!((d.sampler.samples_per_pixel, d.film.crop.x, d.film.alpha), (9, 3, true));
    assert_eq!(d.film.filter, Filter::Box);
    let albedo =
        d.scene.bsdfs()[d.scene.objects()[1].bsdf].albedo(&Place::default(), glam::Vec3A::Z);
    assert_eq!(albedo, glam::Vec3A::splat(0.25));
}

/// What only older versions have, and the picture does not need.
#[test]
fn what_old_scenes_have_of_their_own_is_left_out_or_replaced() {
    let loaded = load(
        "<scene version='0.5.0'><integrator type='path'><boolean name='strictNormals' value='true'/></integrator>
<sensor type='perspective'><float name='focusDistance' value='6'/>
<sampler type='halton'><integer name='sampleCount' value='9'/><integer name='scramble' value='-1'/></sampler>
<film type='ldrfilm'><integer name='width' value='9'/><string name='fileFormat' value='png'/>
<string name='pixelFormat' value='rgba'/><float name='gamma' value='2.2'/><boolean name='banner' value='false'/>
<rfilter type='box'/></film></sensor><emitter type='point'/></scene>",
    )
    .unwrap_or_else(|e| panic!("{e}"));
    let said: Vec<_> = loaded.warnings.iter().map(ToString::to_string).collect();
    assert_eq!(
        said,
        [
            "scene.xml:3:16: sampler `sobol` is used in place of `halton`",
            "scene.xml:4:13: film `hdrfilm` is used in place of `ldrfilm`",
        ]
    );
    let d = loaded.description;
    assert_eq!((d.film.width, d.film.alpha, d.film.filter), (9, true, Filter::Box));
    assert_eq!((d.sampler.kind, d.sampler.samples_per_pixel), (SamplerKind::Sobol, 9));
}

/// What Mitsuba 0.6 names and version 3 has in other words.
#[test]
fn old_objects_are_said_in_new_words() {
    let scene = |version: &str, content: &str| {
        let text = format!("<scene version='{version}'>{content}{SENSOR}</scene>");
        let loaded = load(&text).unwrap_or_else(|e| panic!("{e}"));
        format!("{:?}", loaded.description.scene)
    };
    for (old, new) in [
        (
            "<shape type='disk'><emitter type='area'><blackbody name='radiance' temperature='3500K'/></emitter></shape>",
            "<shape type='disk'><emitter type='area'><spectrum type='blackbody' name='radiance'>\
             <float name='temperature' value='3500'/></spectrum></emitter></shape>",
        ),
        (
            "<shape type='disk'><bsdf type='roughconductor'><float name='extEta' value='1'/></bsdf></shape>",
            "<shape type='disk'><bsdf type='roughconductor'/></shape>",
        ),
        (
            "<emitter type='point'><float name='samplingWeight' value='3'/></emitter>",
            "<emitter type='point'/>",
        ),
    ] {
        assert_eq!(scene("0.6.0", old), scene("3.0.0", new), "{old}");
    }
}

#[test]
fn second_moments_are_left_out() {
    let text = format!(
        "<scene version='3.0.0'><integrator type='moment'><integrator type='path'>\
         <integer name='max_depth' value='3'/></integrator></integrator>{SENSOR}<emitter type='point'/></scene>"
    );
    let loaded = load(&text).unwrap_or_else(|e| panic!("{e}"));
    let IntegratorSettings::Path(path) = loaded.description.integrator else {
        panic!("{:?}", loaded.description.integrator)
    };
    assert_eq!(path.max_depth, Some(3));
    let said: Vec<_> = loaded.warnings.iter().map(ToString::to_string).collect();
    assert_eq!(said, ["scene.xml:1:42: second moments are left out"]);
}

fn write(folder: &Path, name: &str, text: &str) {
    let path = folder.join(name);
    fs::create_dir_all(path.parent().expect("has a folder")).expect("can be made");
    fs::write(path, text).expect("can be written");
}

#[test]
fn files_are_joined() {
    let folder = tempfile::tempdir().expect("a folder");
    let of = folder.path();
    write(
        of,
        "main.xml",
        &format!(
            "<scene version='3.0.0'><default name='depth' value='4'/><path value='parts'/>\
             <include filename='shapes.xml'/><include filename='parts/more/light.xml'/>\
             <include filename='bsdf.xml' name='x'/><integrator type='path'>\
             <integer name='max_depth' value='$depth'/><integer name='rr_depth' value='$later'/></integrator>\
             {SENSOR}</scene>"
        ),
    );
    // Found through <path>; sees the includer's parameters, defines more, and is of an older version.
    write(
        of,
        "parts/shapes.xml",
        "<scene version='2.1.0'><default name='depth' value='5'/><default name='later' value='6'/>\
         <shape type='sphere'><transform name='toWorld'><translate x='$depth'/></transform>\
         <ref id='grey'/></shape></scene>",
    );
    // Finds its own neighbour, although the main file's folder has none of that name.
    write(
        of,
        "parts/more/light.xml",
        "<scene version='3.0.0'><include filename='neighbour.xml'/></scene>",
    );
    write(of, "parts/more/neighbour.xml", "<emitter type='constant' version='3.0.0'/>");
    write(of, "bsdf.xml", "<bsdf version='3.0.0' type='diffuse' id='grey'/>");
    let loaded =
        load_scene(&of.join("main.xml"), &LoadOptions::default()).unwrap_or_else(|e| panic!("{e}"));
    let d = loaded.description;
    let IntegratorSettings::Path(path) = d.integrator else { panic!("{:?}", d.integrator) };
    assert_eq!((path.max_depth, path.roulette.min_depth), (Some(4), 6));
    assert_eq!(d.scene.bounds().expect("a sphere").max.x.round(), 5.0);
    assert_eq!(
        (d.scene.objects().len(), d.scene.bsdfs().len(), d.scene.emitters().len()),
        (1, 1, 1)
    );
}

/// The text of the error of loading `main.xml`, with the folder's name taken out.
fn error_of(folder: &Path) -> String {
    let error = load_scene(&folder.join("main.xml"), &LoadOptions::default()).expect_err("wrong");
    error
        .to_string()
        .replace(&format!("{}/", folder.display()), "")
        .replace(&folder.display().to_string(), "HERE")
}

#[test]
fn includes_that_go_wrong_say_where() {
    let folder = tempfile::tempdir().expect("a folder");
    let of = folder.path();
    let scene = |content: &str| format!("<scene version='3.0.0'>\n  {content}\n{SENSOR}</scene>");
    write(of, "a.xml", &scene("<include filename='main.xml'/>"));
    write(of, "broken.xml", "<scene version='3.0.0'>\n<shape></scene>");
    write(of, "latin.xml", "<scene/>");
    fs::write(of.join("latin.xml"), b"<scene>\n\xe9</scene>").expect("can be written");
    for i in 0..20 {
        write(of, &format!("d{i}.xml"), &scene(&format!("<include filename='d{}.xml'/>", i + 1)));
    }
    for (content, expected) in [
        (
            "<include filename='a.xml'/>",
            "a.xml:2:22: a file includes itself: main.xml -> a.xml -> main.xml",
        ),
        (
            "<include filename='none.xml'/>",
            "main.xml:2:22: there is no file `none.xml`\n  help: looked in `HERE`",
        ),
        (
            "<include filename='broken.xml'/>",
            "broken.xml:2:8: this is not well-formed XML: expected 'shape' tag, not 'scene'",
        ),
        ("<include filename='latin.xml'/>", "main.xml:2:22: latin.xml: line 2 is not UTF-8 text"),
        ("<include filename='.'/>", "main.xml:2:22: .: is not a file"),
        (
            "<include filename='d0.xml'/>",
            "d14.xml:2:22: files include each other more than 15 deep",
        ),
        ("<path value='nowhere'/>", "main.xml:2:16: there is no folder `nowhere`"),
    ] {
        write(of, "main.xml", &scene(content));
        assert_eq!(error_of(of), expected, "{content}");
    }
    fs::remove_file(of.join("main.xml")).expect("is there");
    assert_eq!(error_of(of), "main.xml: cannot be read: No such file or directory (os error 2)");
}

/// Includes that multiply: 10 in each of 10 levels would be 10¹⁰ files.
#[test]
fn include_bombs_are_defused() {
    let folder = tempfile::tempdir().expect("a folder");
    for i in 0..10 {
        let includes = format!("<include filename='{}.xml'/>", i + 1).repeat(10);
        let name = if i == 0 { "main.xml".to_owned() } else { format!("{i}.xml") };
        write(folder.path(), &name, &format!("<scene version='3.0.0'>{includes}</scene>"));
    }
    write(folder.path(), "10.xml", "<scene version='3.0.0'/>");
    let error = error_of(folder.path());
    assert!(error.contains("more than 1000 files are included"), "{error}");
}

/// A comment right before a file name, or at the head of the file, tells where to get it.
#[test]
fn missing_meshes_are_explained_by_the_scene() {
    let error = |head: &str, comment: &str| {
        let text = format!(
            "{head}<scene version='3.0.0'><shape type='obj'>\n{comment}\
             <string name='filename' value='meshes/bust.obj'/></shape>{SENSOR}</scene>"
        );
        load(&text).expect_err("there is no such file").problems()[0].clone()
    };
    let head = "<!-- A bust.\n     Get bust.obj from the sculptor. -->";
    let help = |head: &str, comment: &str| error(head, comment).help.unwrap_or_default();
    assert_eq!(help(head, "<!-- Look there. -->"), "the scene says: Look there.");
    assert_eq!(help(head, ""), "the scene says: A bust.\nGet bust.obj from the sculptor.");
    assert_eq!(help("<!-- A bust. -->", ""), "looked in `.`");
    let shown = error(head, "").to_string();
    assert_eq!(shown, "scene.xml:3:32: there is no file `meshes/bust.obj`");
}
