//! What cannot fit into memory is refused before it is begun, and so is what files promise and do not hold.

mod support;

use std::fs;
use std::io::Write;
use std::process::{Command, Stdio};

use flate2::Compression;
use flate2::write::{GzEncoder, ZlibEncoder};
use support::command::{Folder, PROGRAM, Run, SCENE};

/// A run whose address space is bounded, so that believing a header ends in an abort.
fn bounded(folder: &Folder, mebibytes: u32, arguments: &str) -> Run {
    let command = format!("ulimit -v {}; exec {PROGRAM} {arguments}", mebibytes << 10);
    Command::new("sh")
        .args(["-c", &command])
        .current_dir(folder.path(""))
        // Each thread takes addresses, and a large machine has many.
        .env("RAYON_NUM_THREADS", "2")
        .stdin(Stdio::null())
        .output()
        .expect("a shell is there")
        .into()
}

/// So many samples that no test would see the end of it.
const ENDLESS: &str = "render scene.xml --threads 2 --spp 4000000000";

#[test]
fn a_film_that_cannot_fit_is_refused_with_both_sizes() {
    let folder = Folder::new();
    // Four f64 and a count in the film, three f32 in the picture, and a copy of 16 bytes: 64 bytes a pixel.
    for (size, needed) in [("40000x40000", "102 GB"), ("65535x65535", "275 GB")] {
        let told = folder.fail(&format!("{ENDLESS} --size {size} --memory 16G"), 1);
        assert_eq!(
            told,
            format!("error: {needed} of memory are needed at least, and there are 17.2 GB\n")
        );
    }
    let measure = "measure scene.xml --vary spp=1,2 --size 40000x40000 --memory 16G";
    assert!(folder.fail(measure, 1).starts_with("error: 102 GB of memory"));
    // Found out by itself: 30000x30000 pixels do not fit into two gibibytes of addresses.
    let run = bounded(&folder, 2048, &format!("{ENDLESS} --size 30000x30000"));
    assert_eq!(run.code, Some(1), "{}", run.stderr);
    assert!(run.stderr.starts_with("error: 57.6 GB of memory are needed at least, and there are "));
    // What fits is not refused.
    folder.succeed("render scene.xml --quiet --spp 1 --size 100x100 --memory 1M");
    folder.fail("render scene.xml --quiet --spp 1 --size 200x100 --memory 1M", 1);
}

/// Three vertices of a triangle.
fn corners() -> Vec<u8> {
    [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0_f32].iter().flat_map(|v| v.to_le_bytes()).collect()
}

fn ply_header(vertices: usize, faces: usize) -> Vec<u8> {
    format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex {vertices}\nproperty float x\nproperty float y\n\
         property float z\nelement face {faces}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    .into_bytes()
}

/// A PLY file of so many vertices, all but three zeros, and so many times the same triangle.
fn ply(vertices: usize, faces: usize) -> Vec<u8> {
    let mut file = ply_header(vertices, faces);
    file.extend(corners());
    file.resize(file.len() + 12 * (vertices - 3), 0);
    for _ in 0..faces {
        file.extend([3, 0, 0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0]);
    }
    file
}

fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::fast());
    encoder.write_all(bytes).expect("in memory");
    encoder.finish().expect("in memory")
}

/// One triangle of so many vertices in Mitsuba's format, version 4, without any attribute.
fn serialized(vertices: u64) -> Vec<u8> {
    let mut file = vec![0x1c, 0x04, 4, 0];
    let mut encoder = ZlibEncoder::new(&mut file, Compression::fast());
    let mut header = 0x1000_u32.to_le_bytes().to_vec();
    header.push(0);
    header.extend(vertices.to_le_bytes());
    header.extend(1_u64.to_le_bytes());
    header.extend(corners());
    encoder.write_all(&header).expect("in memory");
    encoder.write_all(&vec![0; 12 * (vertices as usize - 3)]).expect("in memory");
    encoder.write_all(&[0, 0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0]).expect("in memory");
    encoder.finish().expect("in memory");
    file.extend(0_u64.to_le_bytes());
    file.extend(1_u32.to_le_bytes());
    file
}

fn scene_with(kind: &str, file: &str) -> String {
    let shape = format!(
        "<shape type=\"{kind}\"><string name=\"filename\" value=\"{file}\"/></shape>\n<shape type=\"sphere\">"
    );
    SCENE.replace("<shape type=\"sphere\">", &shape)
}

#[test]
fn a_mesh_that_cannot_fit_is_refused_by_its_header() {
    let folder = Folder::with_scene(&scene_with("ply", "a.ply"));
    fs::write(folder.path("a.ply"), ply(100_000, 100_000)).expect("writable");
    let told = folder.fail("inspect scene.xml --memory 2M", 1);
    // 16 bytes a vertex, and then 12 a triangle.
    assert!(told.contains("2.8 MB of memory are needed at least, and there are 2.1 MB"), "{told}");
    assert!(told.contains("[scene.xml:"), "{told}");
    // The mesh fits, but not the engine over it.
    let told = folder.fail("inspect scene.xml --memory 4M --backend rust", 1);
    assert!(told.starts_with("error: 11.8 MB of memory are needed at least"), "{told}");
    folder.succeed("inspect scene.xml --memory 12M --backend rust");
}

#[test]
fn compressed_files_are_bounded_and_an_option_lifts_it() {
    let folder = Folder::new();
    // Zeros pack a thousandfold, and meshes do not.
    let mut zeros = GzEncoder::new(Vec::new(), Compression::fast());
    zeros.write_all(&ply_header(25_000_000, 1)).expect("in memory");
    (0..300).for_each(|_| zeros.write_all(&[0; 1_000_000]).expect("in memory"));
    fs::write(folder.path("zeros.ply"), zeros.finish().expect("in memory")).expect("writable");
    let size = fs::metadata(folder.path("zeros.ply")).expect("there").len();
    assert!(size < 4 << 20, "{size}");
    fs::write(folder.path("scene.xml"), scene_with("ply", "zeros.ply")).expect("writable");
    let run = bounded(&folder, 1024, "inspect scene.xml");
    assert_eq!(run.code, Some(1), "{}", run.stderr);
    assert!(run.stderr.contains(" unpacks to more than 268 MB"), "{}", run.stderr);
    let run = bounded(&folder, 1024, "inspect scene.xml --max-unpacked 400M --memory 64M");
    assert!(run.stderr.contains("400 MB of memory are needed at least"), "{}", run.stderr);

    fs::write(folder.path("a.ply"), gzip(&ply(200_000, 1))).expect("writable");
    fs::write(folder.path("a.serialized"), serialized(200_000)).expect("writable");
    for kind in ["ply", "serialized"] {
        let scene = scene_with(kind, &format!("a.{kind}"));
        fs::write(folder.path("scene.xml"), scene).expect("writable");
        let told = folder.fail("inspect scene.xml --max-unpacked 1M", 1);
        assert!(told.contains(" unpacks to more than 1.0 MB"), "{told}");
        assert!(told.contains("help: `--max-unpacked` raises the limit"), "{told}");
        let run = folder.succeed("inspect scene.xml --max-unpacked 3M");
        assert!(run.stdout.contains("2 with 1 triangles, 3.2 MB"), "{}", run.stdout);
        folder.succeed("inspect scene.xml");
    }
}

/// A PNG file's header and nothing behind it; the sum of its first chunk is right.
fn png_header(width: u32, height: u32) -> Vec<u8> {
    let mut chunk = b"IHDR".to_vec();
    chunk.extend(width.to_be_bytes());
    chunk.extend(height.to_be_bytes());
    chunk.extend([8, 2, 0, 0, 0]);
    let mut crc = flate2::Crc::new();
    crc.update(&chunk);
    let mut file = b"\x89PNG\r\n\x1a\n\0\0\0\r".to_vec();
    file.extend(chunk);
    file.extend(crc.sum().to_be_bytes());
    file.extend(b"\0\0\0\0IDAT\x35\xaf\x06\x1e");
    file
}

/// A BMP file of 24 bits a pixel whose header promises more than there is.
fn bmp_header(width: i32, height: i32) -> Vec<u8> {
    let mut file = b"BM\0\0\0\0\0\0\0\0\x36\0\0\0\x28\0\0\0".to_vec();
    file.extend(width.to_le_bytes());
    file.extend(height.to_le_bytes());
    file.extend([1, 0, 24, 0]);
    file.resize(54 + 300, 0);
    file
}

fn hdr_header(width: u32, height: u32) -> Vec<u8> {
    let mut file =
        format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {height} +X {width}\n").into_bytes();
    file.extend([0; 300]);
    file
}

/// A JPEG file of one grey block whose size is another one.
fn jpeg_header(width: u16, height: u16) -> Vec<u8> {
    let mut bytes = Vec::new();
    let encoder = image::codecs::jpeg::JpegEncoder::new(&mut bytes);
    image::ImageEncoder::write_image(encoder, &[128; 64], 8, 8, image::ExtendedColorType::L8)
        .expect("in memory");
    let start = bytes.windows(2).position(|w| w == [0xff, 0xc0]).expect("a frame");
    bytes[start + 5..start + 7].copy_from_slice(&height.to_be_bytes());
    bytes[start + 7..start + 9].copy_from_slice(&width.to_be_bytes());
    bytes
}

#[test]
fn sizes_in_headers_of_images_are_not_believed() {
    let textured = SCENE.replace(
        "<bsdf type=\"diffuse\"/>",
        "<bsdf type=\"diffuse\"><texture type=\"bitmap\" name=\"reflectance\">\
         <string name=\"filename\" value=\"picture\"/></texture></bsdf>",
    );
    let folder = Folder::with_scene(&textured);
    for (kind, file, promised) in [
        ("PNG", png_header(100_000, 100_000), "100000x100000"),
        ("BMP", bmp_header(30_000, 30_000), "30000x30000"),
        ("HDR", hdr_header(30_000, 30_000), "30000x30000"),
        ("JPEG", jpeg_header(65_000, 65_000), "65000x65000"),
    ] {
        fs::write(folder.path("picture"), &file).expect("writable");
        let run = bounded(&folder, 512, "inspect scene.xml");
        assert_eq!(run.code, Some(1), "{kind}: {}", run.stderr);
        let said = format!(
            "picture is too small for the {promised} pixels that its header promises (it has {} bytes; expected",
            file.len()
        );
        assert!(run.stderr.contains(&said), "{kind}: {}", run.stderr);
    }
}
