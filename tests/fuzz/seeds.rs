//! Whole files of every format that is read, to be damaged.

use std::io::{Cursor, Write};

use exr::prelude::{
    AnyChannel, AnyChannels, Blocks, Compression, Encoding, FlatSamples, Image, Layer,
    LayerAttributes, LineOrder, Vec2, WritableImage, f16,
};
use flate2::write::{GzEncoder, ZlibEncoder};
use image::{ExtendedColorType, ImageFormat};

/// A scene with something of everything.
pub(crate) const SCENE: &str = "<?xml version=\"1.0\"?>\n<!-- all -->\n<scene version=\"0.6.0\">\n\
<default name=\"spp\" value=\"4\"/><default name=\"r\" value=\"0.5\"/>\n\
<integrator type=\"aov\"><string name=\"aovs\" value=\"d:depth,n:sh_normal\"/><integrator type=\"path\">\
<integer name=\"maxDepth\" value=\"-1\"/></integrator></integrator>\n\
<sensor type=\"perspective\"><float name=\"fov\" value=\"40\"/><string name=\"fovAxis\" value=\"diagonal\"/>\
<transform name=\"toWorld\"><scale value=\"2\"/><rotate y=\"1\" angle=\"30\"/>\
<lookAt origin=\"0 0 5\" target=\"0,0,0\" up=\"0 1 0\"/><matrix value=\"1 0 0 0 1 0 0 0 1\"/></transform>\
<film type=\"hdrfilm\"><integer name=\"width\" value=\"64\"/><integer name=\"cropWidth\" value=\"9\"/>\
<rfilter type=\"tent\"><float name=\"radius\" value=\"2\"/></rfilter></film>\
<sampler type=\"independent\"><integer name=\"sampleCount\" value=\"$spp\"/></sampler></sensor>\n\
<bsdf type=\"twosided\" id=\"two\"><bsdf type=\"diffuse\"><rgb name=\"reflectance\" value=\"$r, .1 .2\"/></bsdf>\
<bsdf type=\"conductor\"><string name=\"material\" value=\"Au\"/></bsdf></bsdf><alias id=\"two\" as=\"too\"/>\n\
<shape type=\"sphere\"><ref id=\"too\"/><point name=\"center\" x=\"1\" y=\"2\" z=\"3\"/></shape>\n\
<shape type=\"disk\"><bsdf type=\"dielectric\"><string name=\"intIOR\" value=\"bk7\"/></bsdf>\
<emitter type=\"area\"><spectrum name=\"radiance\" value=\"3\"/></emitter></shape>\n\
<shape type=\"cube\"><transform name=\"toWorld\"><translate x=\"1\"/></transform></shape>\n\
<emitter type=\"constant\"/><emitter type=\"point\"><point name=\"position\" value=\"1\"/></emitter>\n</scene>\n";

/// The same of Nori's.
pub(crate) const NORI_SCENE: &str = "<scene>\n<integrator type=\"path_mats\"/><sampler type=\"independent\">\
<integer name=\"sampleCount\" value=\"3\"/></sampler>\n<camera type=\"perspective\"><float name=\"fov\" value=\"40\"/>\
<transform name=\"toWorld\"><scale value=\"-1,1,1\"/><rotate axis=\"0,1,0\" angle=\"9\"/>\
<lookat origin=\"0,0,5\" target=\"0,0,0\" up=\"0,1,0\"/></transform><integer name=\"width\" value=\"64\"/>\
<rfilter type=\"gaussian\"><float name=\"stddev\" value=\".4\"/></rfilter></camera>\n\
<mesh type=\"sphere\"><point name=\"center\" value=\"1 2 3\"/><bsdf type=\"microfacet\">\
<color name=\"kd\" value=\".2,.1,.3\"/><float name=\"alpha\" value=\".3\"/></bsdf></mesh>\n\
<mesh type=\"sphere\"><emitter type=\"area\"><color name=\"radiance\" value=\"1,2,3\"/></emitter></mesh>\n\
<emitter type=\"point\"><point name=\"position\" value=\"1,2,3\"/><color name=\"power\" value=\"9\"/></emitter>\n\
</scene>\n";

/// A ball under a white sky.
pub(crate) const SMALL_SCENE: &str = "<scene version=\"3.0.0\"><sensor type=\"perspective\"><film type=\"hdrfilm\">\
<integer name=\"width\" value=\"16\"/><integer name=\"height\" value=\"12\"/></film></sensor><shape type=\"sphere\"/>\
<emitter type=\"constant\"/></scene>";

/// With comments, groups, normals, texture coordinates, a quadrilateral, indices of all kinds and a
/// continued line.
pub(crate) const OBJ: &str = "# all\nmtllib a.mtl\no cube\nv 0 0 0\nv 1 0 0 1\nv 1 1 -0.5e-1\nv 0 1 0 .1 .2 .3\n\
vt 0 0\nvt 1 0\nvt 1 1 0\nvn 0 0 1\nvn 0 1e-3 1\ng side\nusemtl grey\ns off\nf 1 2 3\nf 1/1 2/2 3/3\n\
f 1//1 2//2 3//1 4//2\nf -4/1/1 -3/2/-1 \\\n -2/3/1\nl 1 2\np 1\n";

const PLY_HEADER: &str = "comment all\nobj_info nothing\nelement camera 1\nproperty list ushort short numbers\n\
property char sign\nelement vertex 4\nproperty float x\nproperty float y\nproperty double z\nproperty float nx\n\
property float ny\nproperty float nz\nproperty float u\nproperty float v\nproperty uchar red\nelement face 2\n\
property list uchar int vertex_indices\nproperty ushort flags\nend_header\n";

/// Text, or binary with the most significant byte last or first.
pub(crate) fn ply(format: &str) -> Vec<u8> {
    let mut file = format!("ply\nformat {format} 1.0\n{PLY_HEADER}").into_bytes();
    let mut put = |value: f64, scalar: &str| {
        let mut bytes = match scalar {
            _ if format == "ascii" => format!("{value} ").into_bytes(),
            "i8" => (value as i8).to_le_bytes().to_vec(),
            "u8" => (value as u8).to_le_bytes().to_vec(),
            "i16" => (value as i16).to_le_bytes().to_vec(),
            "u16" => (value as u16).to_le_bytes().to_vec(),
            "i32" => (value as i32).to_le_bytes().to_vec(),
            "f32" => (value as f32).to_le_bytes().to_vec(),
            _ => value.to_le_bytes().to_vec(),
        };
        if format == "binary_big_endian" {
            bytes.reverse();
        }
        file.extend(bytes);
        if format == "ascii" && matches!(scalar, "i8" | "u8 end" | "u16 end") {
            file.push(b'\n');
        }
    };
    for (value, scalar) in [(2.0, "u16"), (-300.0, "i16"), (7.0, "i16"), (-1.0, "i8")] {
        put(value, scalar);
    }
    for [x, y] in [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]] {
        for (value, scalar) in
            [(x, "f32"), (y, "f32"), (0.5, "f64"), (0.0, "f32"), (0.0, "f32"), (1.0, "f32")]
        {
            put(value, scalar);
        }
        put(x, "f32");
        put(y, "f32");
        put(9.0, if format == "ascii" { "u8 end" } else { "u8" });
    }
    for (corners, flags) in [(&[0.0, 1.0, 2.0][..], 7.0), (&[0.0, 1.0, 2.0, 3.0], 8.0)] {
        put(corners.len() as f64, "u8");
        corners.iter().for_each(|&corner| put(corner, "i32"));
        put(flags, if format == "ascii" { "u16 end" } else { "u16" });
    }
    file
}

/// The data of a mesh of Mitsuba's format before it is compressed: in single precision, with normals and
/// texture coordinates.
pub(crate) fn serialized_data() -> Vec<u8> {
    let mut data = 0x1003_u32.to_le_bytes().to_vec();
    data.extend(b"name\0");
    data.extend(3_u64.to_le_bytes());
    data.extend(1_u64.to_le_bytes());
    let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0_f32]];
    let normals = [[0.0, 0.0, 1.0_f32]; 3];
    let numbers = corners.into_iter().chain(normals).flatten();
    data.extend(numbers.chain([0.0, 0.0, 1.0, 0.0, 0.0, 1.0]).flat_map(f32::to_le_bytes));
    data.extend([0, 1, 2_u32].into_iter().flat_map(u32::to_le_bytes));
    data
}

/// A file of one mesh with that data, version 4.
pub(crate) fn serialized(data: &[u8]) -> Vec<u8> {
    let mut file = vec![0x1c, 0x04, 4, 0];
    let mut encoder = ZlibEncoder::new(&mut file, flate2::Compression::fast());
    encoder.write_all(data).and_then(|()| encoder.try_finish()).expect("a Vec takes all");
    drop(encoder);
    file.extend(0_u64.to_le_bytes());
    file.extend(1_u32.to_le_bytes());
    file
}

pub(crate) fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = GzEncoder::new(Vec::new(), flate2::Compression::fast());
    encoder.write_all(bytes).and_then(|()| encoder.finish()).expect("a Vec takes all")
}

/// Numbers without a pattern, the same everywhere.
fn noise(count: usize) -> Vec<u8> {
    (0..count).map(|i| (i * i * 37 + i * 11 + 5) as u8).collect()
}

const SIDE: u32 = 12;

/// A picture by the encoder of a format.
pub(crate) fn picture(format: ImageFormat, color: ExtendedColorType) -> Vec<u8> {
    let bytes = noise((SIDE * SIDE * u32::from(color.bits_per_pixel()) / 8) as usize);
    let mut file = Cursor::new(Vec::new());
    image::write_buffer_with_format(&mut file, &bytes, SIDE, SIDE, color, format)
        .expect("the format has this colour");
    file.into_inner()
}

pub(crate) fn interlaced_palette_png() -> Vec<u8> {
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, SIDE, SIDE);
    encoder.set_color(png::ColorType::Indexed);
    encoder.set_depth(png::BitDepth::Four);
    encoder.set_palette(noise(48));
    encoder.set_trns(noise(5));
    encoder.add_text_chunk("Title".into(), "noise".into()).expect("short");
    let mut writer = encoder.write_header().expect("in memory");
    writer.write_image_data(&noise((SIDE * SIDE / 2) as usize)).expect("in memory");
    writer.finish().expect("in memory");
    file
}

pub(crate) fn radiance_hdr() -> Vec<u8> {
    let mut file = Vec::new();
    let pixels: Vec<_> = noise((SIDE * SIDE) as usize)
        .into_iter()
        .map(|v| image::Rgb([f32::from(v), 0.5, 2.0]))
        .collect();
    image::codecs::hdr::HdrEncoder::new(&mut file)
        .encode(&pixels, SIDE as usize, SIDE as usize)
        .expect("in memory");
    file
}

/// Bands of a bitmap with runs, which no encoder at hand writes: 8 pixels of 8 rows, in 4 colours.
pub(crate) fn run_length_bmp() -> Vec<u8> {
    let mut file =
        b"BM\0\0\0\0\0\0\0\0\x46\0\0\0\x28\0\0\0\x08\0\0\0\x08\0\0\0\x01\0\x08\0\x01\0\0\0"
            .to_vec();
    file.resize(46, 0);
    file.extend(4_u32.to_le_bytes());
    file.extend(0_u32.to_le_bytes());
    file.extend(noise(16));
    for row in 0..8 {
        // A run, some pixels by themselves, the end of the row.
        file.extend([5, row % 4, 0, 3, 1, 2, 3, 0, 0, 0]);
    }
    file.extend([0, 1]);
    file
}

/// A picture with the channels R, G and B, or one of two layers.
pub(crate) fn openexr(compression: Compression, blocks: Blocks, layers: usize) -> Vec<u8> {
    let count = (SIDE * SIDE) as usize;
    let layer = |number: usize| {
        let channel = |name: &str, single: bool| {
            let values = noise(count).into_iter().map(|v| f32::from(v) / 16.0);
            let samples = if single {
                FlatSamples::F32(values.collect())
            } else {
                FlatSamples::F16(values.map(f16::from_f32).collect())
            };
            AnyChannel::new(name, samples)
        };
        let list = ["R", "G", "B"].map(|name| channel(name, number == 1));
        let encoding = Encoding { compression, blocks, line_order: LineOrder::Increasing };
        let size = (SIDE as usize, SIDE as usize);
        let name = format!("layer {number}");
        let attributes = LayerAttributes::named(name.as_str());
        Layer::new(size, attributes, encoding, AnyChannels::sort(list.into_iter().collect()))
    };
    let mut file = Cursor::new(Vec::new());
    match layers {
        1 => Image::from_layer(layer(0)).write().non_parallel().to_buffered(&mut file),
        _ => Image::from_layers(
            exr::prelude::ImageAttributes::with_size((SIDE as usize, SIDE as usize)),
            (0..layers).map(layer).collect::<exr::prelude::SmallVec<_>>(),
        )
        .write()
        .non_parallel()
        .to_buffered(&mut file),
    }
    .expect("in memory");
    file.into_inner()
}

pub(crate) const TILES: Blocks = Blocks::Tiles(Vec2(8, 8));

/// Rays as `telamon parity` records them, and as people may write them.
pub(crate) const RAYS: &str = "{\"index\":3,\"family\":\"pair\",\"origin\":[\"0x1.8p+0\",\"0x0p+0\",\"-0x1p-149\"],\
\"direction\":[\"0x1p+0\",\"0x0p+0\",\"0x0p+0\"],\"t_min\":\"0x0p+0\",\"t_max\":\"inf\",\"time\":\"0x1p-1\"}\n\n\
{\"origin\":[0.5,1e-3,-2],\"direction\":[0,0,1]}\n";

/// Materials without highlights, whose tables would take longer than all the reading.
pub(crate) const MTL: &str = "newmtl red\nKd 1 0 0\nKs 0 0 0\nNs 98\nNi 1.4\nillum 1\nmap_Kd -s 2 2 -o .5 a.png\nbump -bm .5 a.png\n\
newmtl blue\nKd 0 0 1\nKe 1 1 1\nd .5\nmap_d a.png\nnorm a.png\nPr 1\n\
newmtl glass\nillum 7\nNi 1.5\nTf .9 1 1\nKd .1 .1 .1\nnewmtl mirror\nillum 3\nKd .2 .2 .2\nKs 0 0 0\n";

/// A mesh of those.
pub(crate) const OBJ_OF_MTL: &str = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nvt 0 0\nvt 1 0\nvt 1 1\n\
usemtl red\ns 1\nf 1/1 2/2 3/3\nusemtl blue\nf 1 3 4\nusemtl glass\ns off\nf 1 2 5\nusemtl mirror\nf 2 3 4 5\n";

/// Some triangles.
const STL: [[[f32; 3]; 3]; 3] = [
    [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
    [[0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
    [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]],
];

pub(crate) fn ascii_stl() -> String {
    let facet = |corners: &[[f32; 3]; 3]| {
        let vertices: String =
            corners.iter().map(|[x, y, z]| format!("vertex {x} {y} {z}\n")).collect();
        format!("facet normal 0 0 1\nouter loop\n{vertices}endloop\nendfacet\n")
    };
    format!("solid a\n{}endsolid a\n", STL.iter().map(facet).collect::<String>())
}

pub(crate) fn binary_stl() -> Vec<u8> {
    let mut bytes = vec![0; 80];
    bytes.extend((STL.len() as u32).to_le_bytes());
    for corners in STL {
        bytes.extend([0; 12]);
        bytes.extend(corners.as_flattened().iter().flat_map(|v| v.to_le_bytes()));
        bytes.extend([0; 2]);
    }
    bytes
}
