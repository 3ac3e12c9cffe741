//! Damaged files of every format that is read do no harm: no panic, no abort, and memory in proportion to
//! their bytes.
//!
//! The files are the same in every run. `cargo test --test fuzz` tries 60,000; with
//! `TELAMON_FUZZ=1000000 cargo test --test fuzz` it is that many. A file that does harm is kept in
//! `target/tmp`.

mod mutate;
mod seeds;

use std::alloc::System;
use std::fs;
use std::panic::catch_unwind;
use std::path::Path;
use std::process::Command;

use cap::Cap;
use exr::prelude::Compression;
use image::{ExtendedColorType, ImageFormat};
use mutate::{Random, damage, png_with_sums};
use telamon::film::read::read_exr;
use telamon::load::mesh::{
    LoadedMesh, MeshFileError, MeshFormat, MeshOptions, load_obj, load_ply, load_serialized,
    load_stl,
};
use telamon::load::{LoadOptions, Problem, load_scene, load_text};
use telamon::measure::store::Store;
use telamon::memory::Limits;
use telamon::parity::Recorded;
use telamon::studio::{Setup, Studio};

/// Counts what is allocated, and ends the process where that is more than is allowed.
#[global_allocator]
static MEMORY: Cap<System> = Cap::new(System, usize::MAX);

/// What any file may take: buffers of readers.
const FIXED: usize = 24 << 20;

/// What each byte of a file may take. DEFLATE expands a byte to 1032, each of which may be eight pixels of
/// a palette of three bytes.
const PER_BYTE: usize = 1032 * 8 * 3;

const INPUTS: usize = 60_000;

/// Number of files that the process is to try that does the work.
const CHILD: &str = "TELAMON_FUZZ_CHILD";

/// Something that is read.
struct Format {
    name: &'static str,
    /// What the file is called.
    file: &'static str,
    seed: Vec<u8>,
    /// What becomes of a damaged seed before it is read: compression, sums.
    finish: fn(Vec<u8>) -> Vec<u8>,
    /// Whether it was read.
    read: fn(&Path) -> bool,
}

fn formats() -> Vec<Format> {
    let as_is: fn(Vec<u8>) -> Vec<u8> = |bytes| bytes;
    let mut formats = Vec::new();
    let mut add = |name, file, seed: Vec<u8>, finish, read| {
        formats.push(Format { name, file, seed, finish, read });
    };
    add("scene", "a.xml", seeds::SCENE.into(), as_is, scene);
    add("scene of Nori's", "a.xml", seeds::NORI_SCENE.into(), as_is, scene);
    add("obj", "a.obj", seeds::OBJ.into(), as_is, obj);
    add("obj.gz", "a.obj", seeds::gzip(seeds::OBJ.as_bytes()), as_is, obj);
    add("obj in gz", "a.obj", seeds::OBJ.into(), |bytes| seeds::gzip(&bytes), obj);
    for (name, format) in [
        ("ascii ply", "ascii"),
        ("little-endian ply", "binary_little_endian"),
        ("big-endian ply", "binary_big_endian"),
    ] {
        add(name, "a.ply", seeds::ply(format), as_is, ply);
    }
    let binary = seeds::ply("binary_little_endian");
    add("ply.gz", "a.ply", seeds::gzip(&binary), as_is, ply);
    add("ply in gz", "a.ply", binary, |bytes| seeds::gzip(&bytes), ply);
    add("ascii stl", "a.stl", seeds::ascii_stl().into(), as_is, stl);
    add("binary stl", "a.stl", seeds::binary_stl(), as_is, stl);
    add("stl.gz", "a.stl", seeds::gzip(&seeds::binary_stl()), as_is, stl);
    add("stl in gz", "a.stl", seeds::binary_stl(), |bytes| seeds::gzip(&bytes), stl);
    add("ascii stl in gz", "a.stl", seeds::ascii_stl().into(), |b| seeds::gzip(&b), stl);
    add("mtl", "a.mtl", seeds::MTL.into(), as_is, mtl);
    add("obj with mtl", "a.obj", seeds::OBJ_OF_MTL.into(), as_is, obj_of_mtl);
    add("obj as a picture", "a.obj", seeds::OBJ.into(), as_is, picture);
    add("stl as a picture", "a.stl", seeds::binary_stl(), as_is, picture);
    let data = seeds::serialized_data();
    add("serialized", "a.serialized", seeds::serialized(&data), as_is, serialized);
    add("data of serialized", "a.serialized", data, |d| seeds::serialized(&d), serialized);
    for (name, color) in
        [("png, 8 bits", ExtendedColorType::Rgb8), ("png, 16 bits", ExtendedColorType::La16)]
    {
        add(name, "a.png", seeds::picture(ImageFormat::Png, color), png_with_sums, texture);
    }
    add("png, raw", "a.png", seeds::interlaced_palette_png(), as_is, texture);
    add("png, palette", "a.png", seeds::interlaced_palette_png(), png_with_sums, texture);
    for (name, format, color) in [
        ("jpeg", ImageFormat::Jpeg, ExtendedColorType::Rgb8),
        ("jpeg, grey", ImageFormat::Jpeg, ExtendedColorType::L8),
        ("bmp", ImageFormat::Bmp, ExtendedColorType::Rgb8),
        ("bmp, alpha", ImageFormat::Bmp, ExtendedColorType::Rgba8),
        ("bmp, grey", ImageFormat::Bmp, ExtendedColorType::L8),
    ] {
        add(name, "picture", seeds::picture(format, color), as_is, texture);
    }
    add("bmp, runs", "picture", seeds::run_length_bmp(), as_is, texture);
    add("hdr", "picture", seeds::radiance_hdr(), as_is, texture);
    for (name, compression) in [
        ("exr", Compression::Uncompressed),
        ("exr, RLE", Compression::RLE),
        ("exr, ZIP1", Compression::ZIP1),
        ("exr, ZIP16", Compression::ZIP16),
        ("exr, PIZ", Compression::PIZ),
        ("exr, PXR24", Compression::PXR24),
        ("exr, B44", Compression::B44),
        ("exr, B44A", Compression::B44A),
        ("exr, DWAA", Compression::DWAA(None)),
        ("exr, DWAB", Compression::DWAB(Some(45.0))),
    ] {
        let seed = seeds::openexr(compression, exr::prelude::Blocks::ScanLines, 1);
        add(name, "picture", seed, as_is, texture);
    }
    for (name, compression, layers) in
        [("exr, tiles", Compression::ZIP16, 1), ("exr, layers", Compression::RLE, 2)]
    {
        let seed = seeds::openexr(compression, seeds::TILES, layers);
        add(name, "picture", seed.clone(), as_is, texture);
        add(name, "picture.exr", seed, as_is, |path| read_exr(path).is_ok());
    }
    add("rays", "rays.jsonl", seeds::RAYS.into(), as_is, |path| Recorded::read(path).is_ok());
    formats
}

fn judge(problems: &[Problem]) {
    assert!(!problems.is_empty());
    for problem in problems {
        assert!(!problem.message.is_empty());
        if let Some(p) = &problem.position {
            assert!(p.source.get(p.span.clone()).is_some() && p.line >= 1 && p.column >= 1);
        }
    }
}

fn scene(path: &Path) -> bool {
    match load_scene(path, &LoadOptions::default()) {
        Ok(_) => true,
        Err(error) => {
            judge(error.problems());
            false
        }
    }
}

fn mesh(loaded: Result<LoadedMesh, MeshFileError>) -> bool {
    match loaded {
        Ok(loaded) => {
            let vertices = loaded.mesh.positions().len() as u32;
            assert!(loaded.mesh.triangles().iter().flatten().all(|&i| i < vertices));
            true
        }
        Err(error) => {
            assert!(!error.to_string().is_empty());
            false
        }
    }
}

fn obj(path: &Path) -> bool {
    mesh(load_obj(path, &MeshOptions::default()))
}

fn ply(path: &Path) -> bool {
    mesh(load_ply(path, &MeshOptions::default()))
}

/// With normals of its own, which no file has.
fn stl(path: &Path) -> bool {
    mesh(load_stl(path, &MeshOptions { max_smooth_angle: Some(40.0), ..MeshOptions::default() }))
}

/// An OBJ file in a scene without materials.
fn obj_in_scene(folder: &Path) -> bool {
    let text = "<scene version=\"3.0.0\"><sensor type=\"perspective\"/><shape type=\"obj\">\
                <string name=\"filename\" value=\"a.obj\"/></shape></scene>";
    match load_text(text, &folder.join("a.xml"), &LoadOptions::default()) {
        Ok(_) => true,
        Err(error) => {
            judge(error.problems());
            false
        }
    }
}

/// The file beside a whole mesh.
fn mtl(path: &Path) -> bool {
    fs::write(path.with_extension("obj"), seeds::OBJ_OF_MTL).expect("writable");
    fs::write(path.with_file_name("a.png"), seeds::interlaced_palette_png()).expect("writable");
    obj_in_scene(path.parent().expect("in a folder"))
}

/// The file beside whole materials.
fn obj_of_mtl(path: &Path) -> bool {
    fs::write(path.with_extension("mtl"), seeds::MTL).expect("writable");
    fs::write(path.with_file_name("a.png"), seeds::interlaced_palette_png()).expect("writable");
    obj_in_scene(path.parent().expect("in a folder"))
}

/// The scene that is made of a mesh.
fn picture(path: &Path) -> bool {
    let format = MeshFormat::of(path).expect("a mesh's name");
    match Studio::new(path, format, &Setup::default(), 1, &Limits::default()) {
        Ok(studio) => {
            let loaded = load_text(&studio.scene(), &studio.name(), &LoadOptions::default());
            // The mesh has something to be seen, so there is nothing wrong with what was made up around it; its
            // materials may be.
            loaded.is_ok() || fs::metadata(path.with_extension("mtl")).is_ok()
        }
        Err(error) => {
            assert!(!error.to_string().is_empty());
            false
        }
    }
}

fn serialized(path: &Path) -> bool {
    mesh(load_serialized(path, 0, &MeshOptions::default()))
}

/// The file as a texture.
fn texture(path: &Path) -> bool {
    let name = path.file_name().and_then(|n| n.to_str()).expect("ours");
    let text = format!(
        "<scene version=\"3.0.0\"><sensor type=\"perspective\"/><shape type=\"disk\"><bsdf type=\"diffuse\">\
         <texture type=\"bitmap\" name=\"reflectance\"><string name=\"filename\" value=\"{name}\"/></texture>\
         </bsdf></shape></scene>"
    );
    load_text(&text, &path.with_file_name("a.xml"), &LoadOptions::default()).is_ok()
}

/// The record of an experiment, as `telamon measure` writes it.
fn record(folder: &Path) -> Vec<u8> {
    fs::write(folder.join("scene.xml"), seeds::SMALL_SCENE).expect("writable");
    let run = Command::new(env!("CARGO_BIN_EXE_telamon"))
        .args(["measure", "scene.xml", "--vary", "spp=1,2", "--report", "report", "--quiet"])
        .args(["--reference-spp", "16", "--repeats", "2"])
        .current_dir(folder)
        .output()
        .expect("the program is there");
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
    fs::read(folder.join("report/measurements.json")).expect("written")
}

#[test]
fn damaged_files_do_no_harm() {
    let inputs = std::env::var("TELAMON_FUZZ").map_or(INPUTS, |n| n.parse().expect("a number"));
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join("measurements.json"), record(folder.path())).expect("writable");
    let child = Command::new(std::env::current_exe().expect("a test has a file"))
        .args(["--exact", "child", "--ignored", "--nocapture", "--test-threads=1"])
        .env(CHILD, inputs.to_string())
        .current_dir(folder.path())
        .output()
        .expect("it can be run");
    let [out, err] = [&child.stdout, &child.stderr].map(|text| String::from_utf8_lossy(text));
    if child.status.success() {
        assert!(out.contains("files were damaged"), "{out}");
        return;
    }
    let kept = Path::new(env!("CARGO_TARGET_TMPDIR"));
    for entry in fs::read_dir(folder.path()).expect("there").flatten() {
        let name = entry.file_name();
        if entry.file_type().is_ok_and(|t| t.is_file()) {
            let to = kept.join(format!("fuzz-{}", name.to_string_lossy()));
            fs::copy(entry.path(), to).expect("writable");
        }
    }
    let last: Vec<_> = err.lines().rev().take(40).collect();
    let last: Vec<_> = last.into_iter().rev().collect();
    panic!("{}\n{out}\n{}\nthe file is kept in {}", child.status, last.join("\n"), kept.display());
}

/// Does the work of the test above, in a process that may end.
#[test]
#[ignore = "run by the test above"]
#[expect(clippy::print_stdout, reason = "it is what the test above reads")]
fn child() {
    let Ok(inputs) = std::env::var(CHILD) else { return };
    let inputs: usize = inputs.parse().expect("a number");
    // On one core, so that what is allocated is what one file needs.
    rayon::ThreadPoolBuilder::new().num_threads(1).build_global().expect("the first pool");
    let mut formats = formats();
    let record = fs::read("measurements.json").expect("written");
    formats.push(Format {
        name: "measurements",
        file: "measurements.json",
        seed: record,
        finish: |bytes| bytes,
        read: |path| {
            let folder = path.parent().filter(|p| !p.as_os_str().is_empty());
            let store = Store::open(folder.unwrap_or(Path::new("."))).expect("there");
            store.record().is_ok()
        },
    });
    let each = inputs.div_ceil(formats.len());
    let mut harmful = Vec::new();
    for (number, format) in formats.iter().enumerate() {
        let path = Path::new(".").join(format.file);
        let attempt = |bytes: &[u8]| {
            // A new file: the contents of one that is cut and written again are waited for by some disks.
            let _ = fs::remove_file(&path);
            fs::write(&path, bytes).expect("writable");
            let allowed = MEMORY.allocated() + FIXED + PER_BYTE * bytes.len();
            MEMORY.set_limit(allowed).expect("more than there is");
            let read = catch_unwind(|| (format.read)(&path));
            MEMORY.set_limit(usize::MAX).expect("all there is");
            read
        };
        let whole = (format.finish)(format.seed.clone());
        assert!(attempt(&whole).expect("no panic"), "{} is whole", format.name);
        let mut random = Random(number as u64);
        let (mut good, mut bad) = (0, 0);
        for index in 0..each {
            let bytes = (format.finish)(damage(&format.seed, &mut random));
            match attempt(&bytes) {
                Ok(true) => good += 1,
                Ok(false) => bad += 1,
                Err(_) => {
                    let name = format!("panic-{number}-{index}-{}", format.file);
                    fs::write(&name, &bytes).expect("writable");
                    harmful.push(format!("{}: {name}", format.name));
                }
            }
        }
        // The damage is neither harmless nor all in the first bytes.
        println!("{}: {good} good, {bad} bad", format.name);
        assert!(bad > each / 20, "{}: {good} good, {bad} bad", format.name);
    }
    assert!(harmful.is_empty(), "{} panics:\n{}", harmful.len(), harmful.join("\n"));
    println!("{} files were damaged", each * formats.len());
}
