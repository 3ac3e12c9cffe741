//! The text and place of every message.
use super::load;

#[test]
fn print() {
    for (content, _) in MESSAGES {
        let text =
            format!("<scene version='3.0.0'>\n{content}\n<sensor type='perspective'/></scene>");
        match load(&text) {
            Ok(_) => println!("NOERR {content}"),
            Err(e) => println!(
                "    (\n        {content:?},\n        {:?},\n    ),",
                e.to_string()
            ),
        }
    }
}
const MESSAGES: &[(&str, &str)] = &[
    ("<shap type='cube'/>", ""),
    ("<translate x='1'/>", ""),
    ("<shape type='cub'/>", ""),
    ("<shape type='hair'/>", ""),
    ("<bsdf type='principled'/>", ""),
    ("<shape/>", ""),
    ("<shape type='cube' colour='red'/>", ""),
    ("<texture type='bitmap' name='reflectance'/>", ""),
    ("<medium type='homogeneous'/>", ""),
    ("<spectrum type='blackbody' name='radiance'/>", ""),
    (
        "<bsdf type='diffuse'><rgb name='reflectence' value='1'/></bsdf>",
        "",
    ),
    (
        "<emitter type='constant'><float name='scale' value='1'/></emitter>",
        "",
    ),
    (
        "<rfilter type='box' id='f'><float name='radius' value='1'/></rfilter>",
        "",
    ),
    ("<float name='x' value='1'/>", ""),
    (
        "<shape type='sphere'><float name='radius' value='1.0f'/></shape>",
        "",
    ),
    (
        "<shape type='sphere'><float name='radius' value='inf'/></shape>",
        "",
    ),
    (
        "<shape type='sphere'><float name='radius' value='0'/></shape>",
        "",
    ),
    ("<shape type='sphere'><float name='radius'/></shape>", ""),
    (
        "<shape type='sphere'><float name='radius' value='1'><float/></float></shape>",
        "",
    ),
    (
        "<shape type='sphere'><string name='radius' value='1'/></shape>",
        "",
    ),
    (
        "<shape type='sphere'><float name='radius' value='1'/><float name='radius' value='2'/></shape>",
        "",
    ),
    (
        "<shape type='sphere'><point name='center' x='1' y='2'/></shape>",
        "",
    ),
    (
        "<shape type='sphere'><point name='center' value='1 2'/></shape>",
        "",
    ),
    (
        "<shape type='sphere'><boolean name='flip_normals' value='1'/></shape>",
        "",
    ),
    (
        "<integrator type='path'><integer name='max_depth' value='5.0'/></integrator>",
        "",
    ),
    (
        "<integrator type='path'><integer name='max_depth' value='-2'/></integrator>",
        "",
    ),
    (
        "<integrator type='path'><float name='max_depth' value='2'/></integrator>",
        "",
    ),
    (
        "<integrator type='path'><string name='strategy' value='best'/></integrator>",
        "",
    ),
    (
        "<integrator type='path'><string name='rr_policy' value='fixed'/></integrator>",
        "",
    ),
    (
        "<integrator type='path'><float name='rr_survival' value='0.5'/></integrator>",
        "",
    ),
    (
        "<integrator type='path'><string name='rr_policy' value='none'/><float name='rr_max_survival' value='0.5'/></integrator>",
        "",
    ),
    (
        "<integrator type='direct'><integer name='shading_samples' value='4'/></integrator>",
        "",
    ),
    (
        "<integrator type='direct'><integer name='shading_samples' value='1'/><integer name='bsdf_samples' value='1'/></integrator>",
        "",
    ),
    (
        "<integrator type='direct'><integer name='emitter_samples' value='0'/><integer name='bsdf_samples' value='0'/></integrator>",
        "",
    ),
    (
        "<integrator type='direct'><string name='strategy' value='bsdf'/><integer name='bsdf_samples' value='1'/></integrator>",
        "",
    ),
    ("<integrator type='aov'/>", ""),
    (
        "<integrator type='aov'><string name='aovs' value=' , '/></integrator>",
        "",
    ),
    (
        "<integrator type='aov'><string name='aovs' value='depth'/></integrator>",
        "",
    ),
    (
        "<integrator type='aov'><string name='aovs' value='d:dept'/></integrator>",
        "",
    ),
    (
        "<integrator type='aov'><string name='aovs' value='d:depth,d:uv'/></integrator>",
        "",
    ),
    (
        "<integrator type='aov'><string name='aovs' value='d:depth'/><integrator type='aov'><string name='aovs' value='d:uv'/></integrator></integrator>",
        "",
    ),
    ("<integrator type='path'/><integrator type='ao'/>", ""),
    (
        "<integrator type='path'><sampler type='independent'/></integrator>",
        "",
    ),
    ("<sampler type='independent'/>", ""),
    ("<rfilter type='box'/>", ""),
    (
        "<bsdf type='diffuse'><rgb name='reflectance' value='1.2 1 1'/></bsdf>",
        "",
    ),
    (
        "<bsdf type='diffuse'><rgb name='reflectance' value='1 1'/></bsdf>",
        "",
    ),
    (
        "<bsdf type='diffuse'><rgb name='reflectance' value='#ff0000'/></bsdf>",
        "",
    ),
    (
        "<bsdf type='diffuse'><spectrum name='reflectance' value='400:.1, 700:.2'/></bsdf>",
        "",
    ),
    (
        "<bsdf type='diffuse'><spectrum name='reflectance' value='.1 .2 .3'/></bsdf>",
        "",
    ),
    (
        "<bsdf type='diffuse'><spectrum name='reflectance' filename='a.spd'/></bsdf>",
        "",
    ),
    (
        "<bsdf type='diffuse'><boolean name='reflectance' value='true'/></bsdf>",
        "",
    ),
    (
        "<emitter type='constant'><rgb name='radiance' value='1 -1 1'/></emitter>",
        "",
    ),
    ("<emitter type='constant'/><emitter type='constant'/>", ""),
    ("<emitter type='area'/>", ""),
    ("<shape type='cube'><emitter type='constant'/></shape>", ""),
    (
        "<emitter type='point'><point name='position' value='1'/><transform name='to_world'/></emitter>",
        "",
    ),
    (
        "<emitter type='point'><point name='position' value='1e200'/></emitter>",
        "",
    ),
    (
        "<shape type='cube'><bsdf type='diffuse'/><bsdf type='diffuse'/></shape>",
        "",
    ),
    ("<shape type='cube'><film type='hdrfilm'/></shape>", ""),
    ("<bsdf type='twosided'/>", ""),
    ("<bsdf type='twosided'><bsdf type='dielectric'/></bsdf>", ""),
    (
        "<bsdf type='twosided'><bsdf type='twosided'><bsdf type='diffuse'/></bsdf></bsdf>",
        "",
    ),
    (
        "<bsdf type='conductor'><string name='material' value='Gold'/></bsdf>",
        "",
    ),
    (
        "<bsdf type='conductor'><string name='material' value='Au'/><float name='k' value='1'/></bsdf>",
        "",
    ),
    (
        "<bsdf type='dielectric'><string name='int_ior' value='bk8'/></bsdf>",
        "",
    ),
    (
        "<bsdf type='dielectric'><float name='int_ior' value='-1'/></bsdf>",
        "",
    ),
    (
        "<bsdf type='dielectric'><boolean name='int_ior' value='true'/></bsdf>",
        "",
    ),
    (
        "<shape type='cube'><ref id='red'/></shape><bsdf type='diffuse' id='rad'/>",
        "",
    ),
    (
        "<bsdf type='diffuse' id='a'/><bsdf type='diffuse' id='a'/>",
        "",
    ),
    ("<alias id='a' as='b'/><bsdf type='diffuse' id='a'/>", ""),
    (
        "<bsdf type='twosided' id='a'><ref id='b'/></bsdf><bsdf type='twosided' id='b'><ref id='a'/></bsdf>",
        "",
    ),
    ("<shape type='obj'/>", ""),
    (
        "<shape type='obj'><string name='filename' value='no.obj'/></shape>",
        "",
    ),
    (
        "<shape type='ply'><string name='filename' value='/no.ply'/></shape>",
        "",
    ),
    (
        "<shape type='sphere'><transform name='to_world'><scale x='2'/></transform></shape>",
        "",
    ),
    (
        "<shape type='sphere'><transform name='to_world'><scale value='1e-60'/></transform></shape>",
        "",
    ),
    (
        "<shape type='sphere'><transform name='to_world'><translate x='1e30'/></transform></shape>",
        "",
    ),
    (
        "<shape type='disk'><transform name='to_world'><scale z='0'/></transform></shape>",
        "",
    ),
    (
        "<shape type='cube'><transform name='to_world'><scale value='0'/></transform></shape>",
        "",
    ),
    (
        "<shape type='cube'><transform name='to_world'><scale value='1 2'/></transform></shape>",
        "",
    ),
    (
        "<shape type='cube'><transform name='to_world'><scale value='1' x='2'/></transform></shape>",
        "",
    ),
    (
        "<shape type='cube'><transform name='to_world'><scale value='1e300'/><scale value='1e300'/></transform></shape>",
        "",
    ),
    (
        "<shape type='cube'><transform name='to_world'><rotate angle='3'/></transform></shape>",
        "",
    ),
    (
        "<shape type='cube'><transform name='to_world'><rotate x='1'/></transform></shape>",
        "",
    ),
    (
        "<shape type='cube'><transform name='to_world'><turn x='1'/></transform></shape>",
        "",
    ),
    (
        "<shape type='cube'><transform name='to_world'><lookAt origin='0 0 0' target='0 0 1'/></transform></shape>",
        "",
    ),
    (
        "<shape type='cube'><transform name='to_world'><lookat origin='0 0 0' target='0 0 0'/></transform></shape>",
        "",
    ),
    (
        "<shape type='cube'><transform name='to_world'><lookat origin='0 0 0' target='0 0 1' up='0 0 2'/></transform></shape>",
        "",
    ),
    (
        "<shape type='cube'><transform name='to_world'><lookat origin='0 0' target='0 0 1'/></transform></shape>",
        "",
    ),
    (
        "<shape type='cube'><transform name='to_world'><matrix value='1 2 3'/></transform></shape>",
        "",
    ),
    (
        "<shape type='cube'><transform name='to_world'><matrix value='1 0 0 0 0 1 0 0 0 0 1 0 0 0 1 1'/></transform></shape>",
        "",
    ),
    ("<shape type='cube'><transform/></shape>", ""),
    (
        "<sensor type='perspective'><float name='fov' value='180'/></sensor>",
        "",
    ),
    (
        "<sensor type='perspective'><float name='fov' value='30'/><string name='focal_length' value='50mm'/></sensor>",
        "",
    ),
    (
        "<sensor type='perspective'><string name='fov_axis' value='y'/></sensor>",
        "",
    ),
    (
        "<sensor type='perspective'><string name='focal_length' value='5in'/></sensor>",
        "",
    ),
    (
        "<sensor type='perspective'><float name='near_clip' value='2'/><float name='far_clip' value='1'/></sensor>",
        "",
    ),
    (
        "<sensor type='perspective'><transform name='to_world'><scale y='0'/></transform></sensor>",
        "",
    ),
    (
        "<sensor type='perspective'><film type='hdrfilm'><integer name='crop_width' value='1000'/></film></sensor>",
        "",
    ),
    (
        "<sensor type='perspective'><film type='hdrfilm'><integer name='width' value='100000'/><integer name='height' value='100000'/></film></sensor>",
        "",
    ),
    (
        "<sensor type='perspective'><film type='hdrfilm'><string name='pixel_format' value='luminance'/></film></sensor>",
        "",
    ),
    (
        "<sensor type='perspective'><film type='hdrfilm'><rfilter type='mitchell'/></film></sensor>",
        "",
    ),
    (
        "<sensor type='perspective'><sampler type='multijitter'/></sensor>",
        "",
    ),
    ("<shape type='$kind'/>", ""),
    ("<default name='a'/>", ""),
    ("<default name='' value='1'/>", ""),
    ("<include/>", ""),
    ("<shape type='cube'><path value='.'/></shape>", ""),
    ("<ref id='x'><ref id='y'/></ref>", ""),
    ("<shape type='cube'", ""),
];
