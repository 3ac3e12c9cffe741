//! Scenes in the words of Nori.

use std::f64::consts::{FRAC_1_PI, PI};

use glam::{DVec3, Vec3A};

use super::super::{LoadOptions, Loaded, NoriX, load_text};
use super::{description, load};
use crate::bsdf::Place;
use crate::render::Description;

const CAMERA: &str = "<camera type='perspective'/>";

fn scene(content: &str) -> String {
    format!("<scene>{content}{CAMERA}</scene>")
}

fn nori(content: &str) -> Description {
    load(&scene(content)).unwrap_or_else(|e| panic!("{content}\n{e}")).description
}

/// Each object in the words of both.
#[test]
fn objects_have_counterparts() {
    let in_mesh = |inner: &str| format!("<mesh type='sphere'>{inner}</mesh>");
    let in_shape = |inner: &str| format!("<shape type='sphere'>{inner}</shape>");
    let cases: [(String, String); 18] = [
        (
            "<mesh type='sphere'><point name='center' value='1, 2, 3'/><float name='radius' value='2'/></mesh>"
                .into(),
            "<shape type='sphere'><point name='center' x='1' y='2' z='3'/><float name='radius' value='2'/></shape>"
                .into(),
        ),
        (
            in_mesh("<bsdf type='diffuse'><color name='albedo' value='.1 .2 .3'/></bsdf>"),
            in_shape("<bsdf type='diffuse'><rgb name='reflectance' value='.1 .2 .3'/></bsdf>"),
        ),
        (in_mesh("<bsdf type='diffuse'/>"), in_shape("<bsdf type='diffuse'/>")),
        (in_mesh(""), in_shape("<bsdf type='diffuse'/>")),
        (in_mesh("<bsdf type='mirror'/>"), in_shape("<bsdf type='conductor'/>")),
        (in_mesh("<bsdf type='dielectric'/>"), in_shape("<bsdf type='dielectric'/>")),
        (
            in_mesh(
                "<bsdf type='dielectric'><float name='intIOR' value='1.3'/><float name='extIOR' value='1.1'/></bsdf>",
            ),
            in_shape(
                "<bsdf type='dielectric'><float name='int_ior' value='1.3'/><float name='ext_ior' value='1.1'/></bsdf>",
            ),
        ),
        (
            in_mesh("<emitter type='area'><color name='radiance' value='1 2 3'/></emitter>"),
            in_shape(
                "<emitter type='area'><rgb name='radiance' value='1 2 3'/></emitter><bsdf type='diffuse'/>",
            ),
        ),
        (
            "<emitter type='point'><point name='position' value='1,2,3'/><color name='power' value='500,250,0'/></emitter>"
                .into(),
            format!(
                "<emitter type='point'><point name='position' value='1,2,3'/><rgb name='intensity' value='{} {} 0'/></emitter>",
                125.0 * FRAC_1_PI,
                62.5 * FRAC_1_PI
            ),
        ),
        ("<integrator type='path'/>".into(), "<integrator type='path'/>".into()),
        ("<integrator type='path_mis'/>".into(), "<integrator type='path'/>".into()),
        (
            "<integrator type='path_mats'/>".into(),
            "<integrator type='path'><string name='strategy' value='bsdf'/></integrator>".into(),
        ),
        (
            "<integrator type='path_ems'/>".into(),
            "<integrator type='path'><string name='strategy' value='emitter'/></integrator>".into(),
        ),
        ("<integrator type='direct'/>".into(), "<integrator type='direct'/>".into()),
        ("<integrator type='direct_mis'/>".into(), "<integrator type='direct'/>".into()),
        (
            "<integrator type='direct_mats'/>".into(),
            "<integrator type='direct'><string name='strategy' value='bsdf'/></integrator>".into(),
        ),
        (
            "<integrator type='direct_ems'/>".into(),
            "<integrator type='direct'><string name='strategy' value='emitter'/></integrator>".into(),
        ),
        ("<integrator type='ao'/>".into(), "<integrator type='ao'/>".into()),
    ];
    for (ours, theirs) in cases {
        let (nori, mitsuba) = (nori(&ours), description(&theirs));
        assert_eq!(format!("{:?}", nori.scene), format!("{:?}", mitsuba.scene), "{ours}");
        assert_eq!(nori.integrator, mitsuba.integrator, "{ours}");
    }
}

/// Nori's x axis points to the right of the picture; lengths and angles are Mitsuba's.
#[test]
fn cameras_have_counterparts() {
    let lookat = "<lookat origin='1,2,3' target='0,0,1' up='0,1,0'/>";
    for (ours, theirs, film, sampler) in [
        (
            "",
            "<float name='fov' value='30'/><transform name='to_world'><scale x='-1'/></transform>",
            "<integer name='width' value='1280'/><integer name='height' value='720'/>",
            "",
        ),
        (
            "<transform name='toWorld'><scale value='-1,1,1'/><rotate axis='0,1,0' angle='20'/></transform>\
             <float name='fov' value='50'/><integer name='width' value='30'/><rfilter type='box'/>",
            "<transform name='to_world'><rotate y='1' angle='20'/></transform>\
             <float name='fov' value='50'/>",
            "<integer name='width' value='30'/><integer name='height' value='720'/><rfilter type='box'/>",
            "<integer name='COUNT' value='7'/>",
        ),
        (
            &format!(
                "<transform name='toWorld'>{lookat}</transform><integer name='height' value='30'/>\
                 <float name='nearClip' value='0.1'/><float name='farClip' value='9'/>\
                 <rfilter type='gaussian'><float name='stddev' value='0.4'/></rfilter>"
            ),
            &format!(
                "<transform name='to_world'><scale x='-1'/>{lookat}</transform><float name='fov' value='30'/>\
                 <float name='near_clip' value='0.1'/><float name='far_clip' value='9'/>"
            ),
            "<integer name='width' value='1280'/><integer name='height' value='30'/>\
             <rfilter type='gaussian'><float name='stddev' value='0.4'/></rfilter>",
            "<integer name='COUNT' value='1'/>",
        ),
    ] {
        let sampler = |name: &str| {
            format!("<sampler type='independent'>{}</sampler>", sampler.replace("COUNT", name))
        };
        let nori = format!(
            "<scene><camera type='perspective'>{ours}</camera>{}</scene>",
            sampler("sampleCount")
        );
        let mitsuba = format!(
            "<scene version='3.0.0'><sensor type='perspective'>{theirs}<film type='hdrfilm'>{film}</film>{}\
             </sensor></scene>",
            sampler("sample_count")
        );
        let [nori, mitsuba] = [nori, mitsuba].map(|text| {
            let Description { camera, film, sampler, .. } =
                load(&text).unwrap_or_else(|e| panic!("{text}\n{e}")).description;
            format!("{camera:?} {film:?} {sampler:?}")
        });
        assert_eq!(nori, mitsuba, "{ours}");
    }
}

/// Which side is assumed is said, unless the user says it.
#[test]
fn the_side_of_the_x_axis_can_be_chosen() {
    let light = "<emitter type='point'><color name='power' value='1 1 1'/></emitter></scene>";
    let text = scene("").replace("</scene>", light);
    let load = |nori_x| -> Loaded {
        let options = LoadOptions { nori_x, ..LoadOptions::default() };
        load_text(&text, "scene.xml".as_ref(), &options).expect("valid")
    };
    let camera = |loaded: &Loaded| format!("{:?}", loaded.description.camera);
    let [assumed, right, left] = [None, Some(NoriX::Right), Some(NoriX::Left)].map(load);
    assert_eq!(camera(&assumed), camera(&right));
    let mitsuba = |map: &str| {
        let sensor = "<float name='fov' value='30'/><film type='hdrfilm'><integer name='width' value='1280'/>\
                      <integer name='height' value='720'/></film>";
        let text = format!(
            "<scene version='3.0.0'><sensor type='perspective'>{map}{sensor}</sensor></scene>"
        );
        camera(&super::load(&text).expect("valid"))
    };
    assert_eq!(camera(&left), mitsuba(""));
    let mirror = "<transform name='to_world'><scale x='-1'/></transform>";
    assert_eq!(camera(&right), mitsuba(mirror));
    assert!(right.warnings.is_empty() && left.warnings.is_empty());
    let warnings: Vec<_> = assumed.warnings.iter().map(ToString::to_string).collect();
    assert_eq!(
        warnings,
        [
            "scene.xml:1:8: a scene of Nori: the camera's x axis is taken to point to the right of the picture"
        ]
    );
    assert_eq!(
        assumed.warnings[0].help.as_deref(),
        Some(
            "versions of Nori differ; if left and right are swapped, use `--nori-x left`, and `--nori-x right` \
             if this is as it should be"
        )
    );
    assert_eq!(
        "up".parse::<NoriX>().map_err(|e| e.to_string()),
        Err("`up` is no side of a picture (expected right or left)".to_owned())
    );
}

/// `kd / π + (1 - max kd) F D G / (4 cosθi cosθo)` as the assignment of the course has it.
fn microfacet(kd: DVec3, alpha: f64, [int_ior, ext_ior]: [f64; 2], wi: DVec3, wo: DVec3) -> DVec3 {
    let m = (wi + wo).normalize();
    let tan = |w: DVec3| (1.0 - w.z * w.z).sqrt() / w.z;
    let d = (-(tan(m) / alpha).powi(2)).exp() / (PI * (alpha * m.z * m.z).powi(2));
    let g1 = |w: DVec3| match 1.0 / (alpha * tan(w)) {
        b if b < 1.6 => (3.535 * b + 2.181 * b * b) / (1.0 + 2.276 * b + 2.577 * b * b),
        _ => 1.0,
    };
    let (cos_i, eta) = (wi.dot(m), int_ior / ext_ior);
    let cos_t = (1.0 - (1.0 - cos_i * cos_i) / (eta * eta)).sqrt();
    let s = (cos_i - eta * cos_t) / (cos_i + eta * cos_t);
    let p = (eta * cos_i - cos_t) / (eta * cos_i + cos_t);
    let f = 0.5 * (s * s + p * p);
    kd * FRAC_1_PI + (1.0 - kd.max_element()) * f * d * g1(wi) * g1(wo) / (4.0 * wi.z * wo.z)
}

#[test]
fn microfacets_are_those_of_the_course() {
    let direction = |theta: f64, phi: f64| {
        DVec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos())
    };
    for (text, kd, alpha, indices) in [
        ("", DVec3::splat(0.5), 0.1, [1.5046, 1.000277]),
        (
            "<color name='kd' value='0.2 0.3 0.05'/><float name='alpha' value='0.4'/>\
             <float name='intIOR' value='1.7'/><float name='extIOR' value='1.1'/>",
            DVec3::new(0.2, 0.3, 0.05),
            0.4,
            [1.7, 1.1],
        ),
        ("<color name='kd' value='0'/>", DVec3::ZERO, 0.1, [1.5046, 1.000277]),
        ("<color name='kd' value='1,0.5,0'/>", DVec3::new(1.0, 0.5, 0.0), 0.1, [1.5046, 1.000277]),
    ] {
        let scene =
            nori(&format!("<mesh type='sphere'><bsdf type='microfacet'>{text}</bsdf></mesh>"))
                .scene;
        let bsdf = &scene.bsdfs()[0];
        for (theta_i, theta_o, phi) in
            [(0.1, 0.2, 3.0), (0.6, 0.5, 3.1), (1.2, 1.3, 3.1), (1.0, 0.3, 1.0)]
        {
            let (wi, wo) = (direction(theta_i, 0.0), direction(theta_o, phi));
            let found = bsdf.eval(&Place::default(), wi.as_vec3a(), wo.as_vec3a()).as_dvec3();
            let expected = microfacet(kd, alpha, indices, wi, wo) * wo.z;
            // The course's fit to Smith's masking errs by less than 0.4 % for each direction.
            let off = (found - expected).abs().max_element() / expected.max_element();
            assert!(off < 0.01, "{text} {theta_i} {theta_o}: {found} {expected}");
        }
        let below = direction(2.0, 0.0).as_vec3a();
        assert_eq!(bsdf.eval(&Place::default(), below, Vec3A::Z), Vec3A::ZERO);
    }
}

#[test]
fn what_noris_scenes_cannot_have_is_listed_in_their_words() {
    let text = "<scene>\n<integrator type='whitted'/>\n\
        <mesh type='spere'/>\n\
        <mesh type='sphere'><bsdf type='diffuse'><color name='reflectance' value='1'/></bsdf></mesh>\n\
        <mesh type='sphere'><bsdf type='microfacet'><color name='kd' value='.2 1.5 0'/></bsdf></mesh>\n\
        <mesh type='sphere'><bsdf type='microfacet'><color name='kd' value='green'/></bsdf></mesh>\n\
        <mesh type='sphere'><bsdf type='mirror'><float name='a' value='1'/></bsdf></mesh>\n\
        <mesh/>\n<medium type='homogeneous'/>\n\
        <emitter type='point'><color name='power' value='bright'/></emitter>\n\
        <camera type='perspective'><rfilter type='mitchell'/></camera>\n</scene>";
    let expected = "scene.xml:2:19: integrator `whitted` is not supported
  help: in a scene of Nori's, use one of `path`, `path_mats`, `path_ems`, `path_mis`, `direct`, `direct_mats`, \
  `direct_ems`, `direct_mis`, `ao`
scene.xml:3:13: mesh `spere` is not supported (did you mean `sphere`?)
  help: in a scene of Nori's, use one of `obj`, `sphere`
scene.xml:4:55: bsdf `diffuse`: unexpected property `reflectance`
  help: expected one of `albedo`
scene.xml:5:69: `kd` has a channel of 1.5 (expected: colour from 0 to 1)
scene.xml:6:69: `green` is not a number
scene.xml:7:54: bsdf `mirror`: unexpected property `a`
  help: bsdf `mirror` takes no properties
scene.xml:8:1: <shape> lacks the attribute `type`
scene.xml:9:15: <medium> `homogeneous` is not supported
  help: light travels through vacuum here; remove it, and what refers to it
scene.xml:10:50: `bright` is not a number
scene.xml:11:43: rfilter `mitchell` is not supported
  help: in a scene of Nori's, use one of `gaussian`, `tent`, `box`";
    let error = load(text).map(|_| ()).expect_err("wrong").to_string();
    assert_eq!(error, expected);
    let error = load("<scene><mesh type='sphere'/><sampler type='independent'/></scene>");
    assert_eq!(
        error.map(|_| ()).expect_err("no camera").to_string(),
        "scene.xml:1:1: the scene has no camera\n  \
         help: add <camera type=\"perspective\"> with a `toWorld` and a `fov`"
    );
}
