//! Every property of the table changes what is loaded.

use super::super::plugins::{Category, Plugin, supported};
use super::load;
use crate::property::Kind;

/// A scene that contains an object of the given kind.
pub(super) fn scene_with(category: Category, plugin: &str, inner: &str) -> String {
    let object = format!("<{0} type=\"{plugin}\">{inner}</{0}>", category.tag());
    let sensor = |inner: &str| format!("<sensor type=\"perspective\">{inner}</sensor>");
    let content = match (category, plugin) {
        (Category::Texture, _) => {
            let texture = format!("<texture name='reflectance' type='{plugin}'>{inner}</texture>");
            let bsdf = format!("<bsdf type='diffuse'>{texture}</bsdf>");
            format!("<shape type='rectangle'>{bsdf}</shape>{}", sensor(""))
        }
        (Category::Bsdf, _) | (Category::Emitter, "area") => {
            format!("<shape type=\"rectangle\">{object}</shape>{}", sensor(""))
        }
        (Category::Sensor, _) => format!("{object}{MOVING_CUBE}"),
        (Category::Film | Category::Sampler, _) => sensor(&object),
        (Category::Filter, _) => sensor(&format!("<film type=\"hdrfilm\">{object}</film>")),
        _ => format!("{object}{}", sensor("")),
    };
    format!("<scene version=\"3.0.0\">{content}</scene>")
}

/// What a shutter makes a difference to.
const MOVING_CUBE: &str = "<shape type='cube'><animation name='to_world'>\
    <transform time='0'/><transform time='1'><translate x='1'/></transform></animation></shape>";
const CLOSE: &str = "<float name='shutter_close' value='1'/>";
const LENS_AND_CLOSE: &str =
    "<float name='aperture_radius' value='1'/><float name='shutter_close' value='1'/>";
const ALPHA_U_AND_V: &str =
    "<float name='alpha_u' value='0.3'/><float name='alpha_v' value='0.1'/>";
pub(super) const LENS: &str = "<float name='aperture_radius' value='1'/>";
const NORMAL: &str = "<rgb name='normalmap' value='.5 .5 1'/><bsdf type='diffuse'/>";

/// Plugin, property, what stands beside it, a value that must change the scene.
const EFFECTS: &[(&str, &str, &str, &str)] = &[
    ("rectangle", "to_world", "", "<transform name='to_world'><translate x='1'/></transform>"),
    ("rectangle", "flip_normals", "", "<boolean name='flip_normals' value='true'/>"),
    ("cube", "to_world", "", "<transform name='to_world'><scale value='2'/></transform>"),
    ("cube", "flip_normals", "", "<boolean name='flip_normals' value='true'/>"),
    ("sphere", "center", "", "<point name='center' x='1' y='2' z='3'/>"),
    ("sphere", "radius", "", "<float name='radius' value='2'/>"),
    ("sphere", "to_world", "", "<transform name='to_world'><rotate x='1' angle='9'/></transform>"),
    ("sphere", "flip_normals", "", "<boolean name='flip_normals' value='true'/>"),
    ("disk", "to_world", "", "<transform name='to_world'><scale x='2'/></transform>"),
    ("disk", "flip_normals", "", "<boolean name='flip_normals' value='true'/>"),
    ("cylinder", "p0", "", "<point name='p0' x='1' y='2' z='3'/>"),
    ("cylinder", "p1", "", "<point name='p1' x='1' y='2' z='3'/>"),
    ("cylinder", "radius", "", "<float name='radius' value='2'/>"),
    (
        "cylinder",
        "to_world",
        "",
        "<transform name='to_world'><scale x='2' y='2' z='3'/></transform>",
    ),
    ("cylinder", "flip_normals", "", "<boolean name='flip_normals' value='true'/>"),
    (
        "deformable",
        "times",
        "<shape type='cube'/><shape type='cube'><transform name='to_world'><scale value='2'/></transform></shape>",
        "<string name='times' value='-1, 1'/>",
    ),
    (
        "instance",
        "to_world",
        "<shape type='shapegroup'><shape type='cube'/></shape>",
        "<transform name='to_world'><translate x='1'/></transform>",
    ),
    ("diffuse", "reflectance", "", "<rgb name='reflectance' value='0.1 0.2 0.3'/>"),
    ("conductor", "material", "", "<string name='material' value='Au'/>"),
    ("conductor", "eta", "", "<rgb name='eta' value='1 2 3'/>"),
    ("conductor", "k", "", "<rgb name='k' value='1 2 3'/>"),
    ("conductor", "specular_reflectance", "", "<float name='specular_reflectance' value='0.3'/>"),
    ("dielectric", "int_ior", "", "<string name='int_ior' value='diamond'/>"),
    ("dielectric", "ext_ior", "", "<float name='ext_ior' value='1.3'/>"),
    ("dielectric", "specular_reflectance", "", "<float name='specular_reflectance' value='0.3'/>"),
    (
        "dielectric",
        "specular_transmittance",
        "",
        "<float name='specular_transmittance' value='0.3'/>",
    ),
    ("thindielectric", "int_ior", "", "<string name='int_ior' value='diamond'/>"),
    ("thindielectric", "ext_ior", "", "<float name='ext_ior' value='1.3'/>"),
    (
        "thindielectric",
        "specular_reflectance",
        "",
        "<float name='specular_reflectance' value='0.3'/>",
    ),
    (
        "thindielectric",
        "specular_transmittance",
        "",
        "<float name='specular_transmittance' value='0.3'/>",
    ),
    ("plastic", "int_ior", "", "<string name='int_ior' value='diamond'/>"),
    ("plastic", "ext_ior", "", "<float name='ext_ior' value='1.3'/>"),
    ("plastic", "diffuse_reflectance", "", "<rgb name='diffuse_reflectance' value='.1 .2 .3'/>"),
    ("plastic", "specular_reflectance", "", "<float name='specular_reflectance' value='0.3'/>"),
    ("plastic", "nonlinear", "", "<boolean name='nonlinear' value='true'/>"),
    ("roughconductor", "material", "", "<string name='material' value='Au'/>"),
    ("roughconductor", "eta", "", "<rgb name='eta' value='1 2 3'/>"),
    ("roughconductor", "k", "", "<rgb name='k' value='1 2 3'/>"),
    (
        "roughconductor",
        "specular_reflectance",
        "",
        "<float name='specular_reflectance' value='0.3'/>",
    ),
    ("roughconductor", "distribution", "", "<string name='distribution' value='ggx'/>"),
    ("roughconductor", "alpha", "", "<float name='alpha' value='0.3'/>"),
    ("roughconductor", "alpha_u", "", ALPHA_U_AND_V),
    ("roughconductor", "alpha_v", "", ALPHA_U_AND_V),
    ("roughdielectric", "int_ior", "", "<string name='int_ior' value='diamond'/>"),
    ("roughdielectric", "ext_ior", "", "<float name='ext_ior' value='1.3'/>"),
    (
        "roughdielectric",
        "specular_reflectance",
        "",
        "<float name='specular_reflectance' value='0.3'/>",
    ),
    (
        "roughdielectric",
        "specular_transmittance",
        "",
        "<float name='specular_transmittance' value='0.3'/>",
    ),
    ("roughdielectric", "distribution", "", "<string name='distribution' value='ggx'/>"),
    ("roughdielectric", "alpha", "", "<float name='alpha' value='0.3'/>"),
    ("roughdielectric", "alpha_u", "", ALPHA_U_AND_V),
    ("roughdielectric", "alpha_v", "", ALPHA_U_AND_V),
    ("roughplastic", "int_ior", "", "<string name='int_ior' value='diamond'/>"),
    ("roughplastic", "ext_ior", "", "<float name='ext_ior' value='1.3'/>"),
    (
        "roughplastic",
        "diffuse_reflectance",
        "",
        "<rgb name='diffuse_reflectance' value='.1 .2 .3'/>",
    ),
    (
        "roughplastic",
        "specular_reflectance",
        "",
        "<float name='specular_reflectance' value='0.3'/>",
    ),
    ("roughplastic", "nonlinear", "", "<boolean name='nonlinear' value='true'/>"),
    ("roughplastic", "distribution", "", "<string name='distribution' value='ggx'/>"),
    ("roughplastic", "alpha", "", "<float name='alpha' value='0.3'/>"),
    (
        "normalmap",
        "flip_invalid_normals",
        NORMAL,
        "<boolean name='flip_invalid_normals' value='false'/>",
    ),
    (
        "normalmap",
        "use_shadowing_function",
        NORMAL,
        "<boolean name='use_shadowing_function' value='false'/>",
    ),
    ("checkerboard", "color0", "", "<rgb name='color0' value='.1 .2 .3'/>"),
    ("checkerboard", "color1", "", "<rgb name='color1' value='.1 .2 .3'/>"),
    ("checkerboard", "to_uv", "", "<transform name='to_uv'><scale x='2'/></transform>"),
    ("mask", "opacity", "<bsdf type='diffuse'/>", "<float name='opacity' value='0.3'/>"),
    ("area", "radiance", "", "<rgb name='radiance' value='3 2 1'/>"),
    ("constant", "radiance", "", "<spectrum name='radiance' value='3'/>"),
    ("directional", "irradiance", "", "<float name='irradiance' value='2'/>"),
    ("directional", "direction", "", "<vector name='direction' value='1 0 0'/>"),
    (
        "directional",
        "to_world",
        "",
        "<transform name='to_world'><rotate x='1' angle='9'/></transform>",
    ),
    ("spot", "intensity", "", "<float name='intensity' value='2'/>"),
    ("spot", "cutoff_angle", "", "<float name='cutoff_angle' value='30'/>"),
    ("spot", "beam_width", "", "<float name='beam_width' value='12'/>"),
    ("spot", "texture", "", "<texture name='texture' type='checkerboard'/>"),
    ("spot", "to_world", "", "<transform name='to_world'><translate x='1'/></transform>"),
    ("point", "intensity", "", "<integer name='intensity' value='3'/>"),
    ("point", "position", "", "<point name='position' value='3'/>"),
    ("point", "to_world", "", "<transform name='to_world'><translate y='3'/></transform>"),
    ("perspective", "to_world", "", "<transform name='to_world'><translate y='3'/></transform>"),
    ("perspective", "fov", "", "<float name='fov' value='30'/>"),
    (
        "perspective",
        "fov_axis",
        "<float name='fov' value='30'/>",
        "<string name='fov_axis' value='y'/>",
    ),
    ("perspective", "focal_length", "", "<string name='focal_length' value='35mm'/>"),
    (
        "perspective",
        "principal_point_offset_x",
        "",
        "<float name='principal_point_offset_x' value='.1'/>",
    ),
    (
        "perspective",
        "principal_point_offset_y",
        "",
        "<float name='principal_point_offset_y' value='.1'/>",
    ),
    ("perspective", "near_clip", "", "<float name='near_clip' value='0.1'/>"),
    ("perspective", "far_clip", "", "<float name='far_clip' value='100'/>"),
    ("thinlens", "to_world", LENS, "<transform name='to_world'><translate y='3'/></transform>"),
    ("thinlens", "fov", LENS, "<float name='fov' value='30'/>"),
    (
        "thinlens",
        "fov_axis",
        "<float name='aperture_radius' value='1'/><float name='fov' value='30'/>",
        "<string name='fov_axis' value='y'/>",
    ),
    ("thinlens", "focal_length", LENS, "<string name='focal_length' value='35mm'/>"),
    ("thinlens", "focus_distance", LENS, "<float name='focus_distance' value='3'/>"),
    ("thinlens", "near_clip", LENS, "<float name='near_clip' value='0.1'/>"),
    ("thinlens", "far_clip", LENS, "<float name='far_clip' value='100'/>"),
    ("orthographic", "to_world", "", "<transform name='to_world'><scale x='3'/></transform>"),
    ("orthographic", "near_clip", "", "<float name='near_clip' value='0.1'/>"),
    ("orthographic", "far_clip", "", "<float name='far_clip' value='100'/>"),
    ("perspective", "shutter_open", CLOSE, "<float name='shutter_open' value='.5'/>"),
    ("perspective", "shutter_close", "", CLOSE),
    ("thinlens", "shutter_open", LENS_AND_CLOSE, "<float name='shutter_open' value='.5'/>"),
    ("thinlens", "shutter_close", LENS, CLOSE),
    ("orthographic", "shutter_open", CLOSE, "<float name='shutter_open' value='.5'/>"),
    ("orthographic", "shutter_close", "", CLOSE),
    ("hdrfilm", "width", "", "<integer name='width' value='100'/>"),
    ("hdrfilm", "height", "", "<integer name='height' value='100'/>"),
    ("hdrfilm", "crop_offset_x", "", "<integer name='crop_offset_x' value='10'/>"),
    ("hdrfilm", "crop_offset_y", "", "<integer name='crop_offset_y' value='10'/>"),
    ("hdrfilm", "crop_width", "", "<integer name='crop_width' value='10'/>"),
    ("hdrfilm", "crop_height", "", "<integer name='crop_height' value='10'/>"),
    ("hdrfilm", "pixel_format", "", "<string name='pixel_format' value='RGBA'/>"),
    ("hdrfilm", "component_format", "", "<string name='component_format' value='float32'/>"),
    ("tent", "radius", "", "<float name='radius' value='2'/>"),
    ("gaussian", "stddev", "", "<float name='stddev' value='0.6'/>"),
    ("independent", "sample_count", "", "<integer name='sample_count' value='64'/>"),
    ("independent", "seed", "", "<integer name='seed' value='1'/>"),
    ("independent", "error", "", "<float name='error' value='0.01'/>"),
    ("sobol", "sample_count", "", "<integer name='sample_count' value='64'/>"),
    ("sobol", "seed", "", "<integer name='seed' value='1'/>"),
    ("sobol", "error", "", "<float name='error' value='0.01'/>"),
    ("stratified", "sample_count", "", "<integer name='sample_count' value='64'/>"),
    ("stratified", "seed", "", "<integer name='seed' value='1'/>"),
    ("multijitter", "sample_count", "", "<integer name='sample_count' value='64'/>"),
    ("multijitter", "seed", "", "<integer name='seed' value='1'/>"),
    ("orthogonal", "sample_count", "", "<integer name='sample_count' value='64'/>"),
    ("orthogonal", "seed", "", "<integer name='seed' value='1'/>"),
    ("ldsampler", "sample_count", "", "<integer name='sample_count' value='64'/>"),
    ("ldsampler", "seed", "", "<integer name='seed' value='1'/>"),
    ("path", "max_depth", "", "<integer name='max_depth' value='8'/>"),
    ("path", "rr_depth", "", "<integer name='rr_depth' value='8'/>"),
    ("path", "hide_emitters", "", "<boolean name='hide_emitters' value='true'/>"),
    ("path", "strategy", "", "<string name='strategy' value='mis_balance'/>"),
    ("path", "directions", "", "<string name='directions' value='cosine'/>"),
    ("path", "emitter_choice", "", "<string name='emitter_choice' value='power'/>"),
    (
        "path",
        "rr_policy",
        "<integer name='max_depth' value='9'/>",
        "<string name='rr_policy' value='none'/>",
    ),
    (
        "path",
        "rr_survival",
        "",
        "<string name='rr_policy' value='fixed'/><float name='rr_survival' value='.7'/>",
    ),
    ("path", "rr_factor", "", "<float name='rr_factor' value='1'/>"),
    ("path", "rr_max_survival", "", "<float name='rr_max_survival' value='0.9'/>"),
    ("path", "emitter_samples", "", "<integer name='emitter_samples' value='4'/>"),
    ("direct", "shading_samples", "", "<integer name='shading_samples' value='2'/>"),
    ("direct", "emitter_samples", "", "<integer name='emitter_samples' value='4'/>"),
    ("direct", "bsdf_samples", "", "<integer name='bsdf_samples' value='4'/>"),
    ("direct", "hide_emitters", "", "<boolean name='hide_emitters' value='true'/>"),
    ("direct", "strategy", "", "<string name='strategy' value='emitter'/>"),
    ("direct", "directions", "", "<string name='directions' value='uniform'/>"),
    ("direct", "emitter_choice", "", "<string name='emitter_choice' value='power'/>"),
    ("direct_uniform", "hide_emitters", "", "<boolean name='hide_emitters' value='true'/>"),
    ("branching", "branches", "", "<integer name='branches' value='2'/>"),
    ("branching", "max_depth", "", "<integer name='max_depth' value='2'/>"),
    ("branching", "directions", "", "<string name='directions' value='uniform'/>"),
    ("branching", "hide_emitters", "", "<boolean name='hide_emitters' value='true'/>"),
    ("ao", "ray_length", "", "<float name='ray_length' value='2'/>"),
];

/// Properties that have no second value to try, are documented to be read and not needed, or are
/// required and tested by themselves. Meshes are left to `meshes.rs`, because they need files.
const WITHOUT_EFFECT: [(&str, &str); 17] = [
    ("perspective", "focus_distance"),
    ("orthographic", "focus_distance"),
    ("thinlens", "aperture_radius"),
    ("stratified", "jitter"),
    ("multijitter", "jitter"),
    ("orthogonal", "jitter"),
    ("orthogonal", "strength"),
    ("hdrfilm", "file_format"),
    ("hdrfilm", "sample_border"),
    ("hdrfilm", "compensate"),
    ("hdrfilm", "banner"),
    ("aov", "aovs"),
    ("roughconductor", "sample_visible"),
    ("roughdielectric", "sample_visible"),
    ("roughplastic", "sample_visible"),
    ("blendbsdf", "weight"),
    ("normalmap", "normalmap"),
];

/// Bump maps need one because they need a bitmap.
fn needs_file(plugin: &Plugin) -> bool {
    plugin.name == "bumpmap" || plugin.properties.iter().any(|p| p.kind == Kind::File)
}

#[test]
fn every_property_has_an_effect() {
    for plugin in supported().filter(|p| !needs_file(p)) {
        for property in plugin.properties {
            let key = (plugin.name, property.name);
            let Some(row) = EFFECTS.iter().find(|r| (r.0, r.1) == key) else {
                assert!(WITHOUT_EFFECT.contains(&key), "no test shows that {key:?} has an effect");
                continue;
            };
            let debug = |inner: &str| {
                let text = scene_with(plugin.category(), plugin.name, inner);
                format!("{:?}", load(&text).unwrap_or_else(|e| panic!("{text}\n{e}")).description)
            };
            let (without, with) = (debug(row.2), debug(&format!("{}{}", row.2, row.3)));
            assert_ne!(without, with, "{key:?}");
        }
    }
}

/// The constructors read only what the table lists: each works with nothing but what is required.
#[test]
fn every_plugin_loads_with_its_defaults() {
    for plugin in supported().filter(|p| !needs_file(p)) {
        let inner = match plugin.name {
            "twosided" | "mask" => "<bsdf type='diffuse'/>",
            "normalmap" => NORMAL,
            "thinlens" => LENS,
            "shapegroup" | "deformable" => "<shape type='cube'/>",
            "instance" => "<shape type='shapegroup'><shape type='cube'/></shape>",
            "blendbsdf" => {
                "<float name='weight' value='.5'/><bsdf type='diffuse'/><bsdf type='null'/>"
            }
            "aov" => "<string name='aovs' value='dd:depth'/>",
            "moment" => "<integrator type='path'/>",
            _ => "",
        };
        let text = scene_with(plugin.category(), plugin.name, inner);
        assert!(load(&text).is_ok(), "{text}");
    }
}
