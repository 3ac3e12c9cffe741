use std::io::Write as _;
use std::path::Path;

use flate2::Compression;
use flate2::write::ZlibEncoder;
use glam::{Vec2, Vec3, Vec3A};

use super::super::tests::{load_bytes, mesh, message};
use super::super::{LoadedMesh, MeshFileError, MeshOptions, load_ply, load_serialized};

const POSITIONS: [[f64; 3]; 4] =
    [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
const NORMALS: [[f64; 3]; 4] = [[0.0, 0.0, 2.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]];
const UVS: [[f64; 2]; 4] = [[0.0, 0.25], [1.0, 0.0], [0.0, 1.0], [0.5, 0.5]];
const TRIANGLES: [[u32; 3]; 2] = [[0, 1, 2], [0, 2, 3]];

const FIRST: Load = |path, options| load_serialized(path, 0, options);
const SECOND: Load = |path, options| load_serialized(path, 1, options);
type Load = fn(&Path, &MeshOptions) -> Result<LoadedMesh, MeshFileError>;

/// The data of a mesh before it is compressed; `flags` say what there is in it.
fn data(version: u16, flags: u32) -> Vec<u8> {
    let mut bytes = flags.to_le_bytes().to_vec();
    if version == 4 {
        bytes.extend(b"name\0");
    }
    bytes.extend(4_u64.to_le_bytes());
    bytes.extend(2_u64.to_le_bytes());
    let mut array = |values: &[f64]| {
        for value in values {
            match flags & 0x2000 {
                0 => bytes.extend((*value as f32).to_le_bytes()),
                _ => bytes.extend(value.to_le_bytes()),
            }
        }
    };
    array(POSITIONS.as_flattened());
    for (flag, values) in
        [(0x1, NORMALS.as_flattened()), (0x2, UVS.as_flattened()), (0x8, POSITIONS.as_flattened())]
    {
        array(if flags & flag == 0 { &[] } else { values });
    }
    bytes.extend(TRIANGLES.as_flattened().iter().flat_map(|i| i.to_le_bytes()));
    bytes
}

/// A file of meshes with such data.
fn file(version: u16, meshes: &[Vec<u8>]) -> Vec<u8> {
    let (mut bytes, mut offsets) = (Vec::new(), Vec::new());
    for data in meshes {
        offsets.push(bytes.len() as u64);
        bytes.extend(0x041c_u16.to_le_bytes());
        bytes.extend(version.to_le_bytes());
        let mut encoder = ZlibEncoder::new(&mut bytes, Compression::none());
        encoder.write_all(data).and_then(|()| encoder.try_finish()).expect("a Vec takes all");
    }
    for offset in offsets {
        let entry = offset.to_le_bytes();
        bytes.extend(if version == 4 { &entry[..] } else { &entry[..4] });
    }
    bytes.extend((meshes.len() as u32).to_le_bytes());
    bytes
}

/// Two meshes with something of everything.
pub(crate) fn example(version: u16) -> Vec<u8> {
    file(version, &[data(version, 0x100b), data(version, 0x2002)])
}

#[test]
fn all_that_flags_announce_is_read() {
    for version in [3, 4] {
        for flags in [0x1000, 0x2000, 0, 0x1001, 0x2002, 0x100b, 0x200f, 0x1013] {
            for (index, load) in [FIRST, SECOND].into_iter().enumerate() {
                let mut meshes = vec![data(version, flags); 2];
                meshes[1 - index] = data(version, 0x2003);
                let mesh = mesh(load, file(version, &meshes));
                let what = format!("version {version}, flags {flags:#x}, mesh {index}");
                let positions = POSITIONS.map(|p| Vec3A::from(p.map(|x| x as f32)));
                assert_eq!(mesh.positions(), positions, "{what}");
                assert_eq!(mesh.triangles(), TRIANGLES, "{what}");
                let normals = [Vec3::Z, Vec3::Y, Vec3::X, Vec3::Z];
                let kept = if flags & 0x11 == 1 { &normals[..] } else { &[] };
                assert_eq!(mesh.normals(), kept, "{what}");
                let uvs = UVS.map(|uv| Vec2::from(uv.map(|x| x as f32)));
                assert_eq!(mesh.uvs(), if flags & 2 == 2 { &uvs[..] } else { &[] }, "{what}");
            }
        }
    }
    let options = MeshOptions { face_normals: true, ..Default::default() };
    let loaded = load_bytes(FIRST, &example(4), &options).expect("a good file");
    assert!(loaded.mesh.normals().is_empty() && !loaded.mesh.uvs().is_empty());
}

/// The file that Mitsuba reads too (`tests/peers/`) holds the balls of the files beside it.
#[test]
fn the_peers_file_holds_the_same_balls() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/peers/scenes/meshes");
    let options = MeshOptions::default();
    let ply = load_ply(&folder.join("ball.ply"), &options).expect("a good file").mesh;
    let path = folder.join("balls.serialized");
    for index in 0..2 {
        let ball = load_serialized(&path, index, &options).expect("a good file").mesh;
        assert!(ball.positions() == ply.positions(), "mesh {index}");
        assert!(ball.triangles() == ply.triangles(), "mesh {index}");
        assert_eq!(ball.uvs().is_empty(), index == 0);
        // In single precision the digits of the text are rounded before and after their normalisation.
        let normals = ball.normals().iter().zip(ply.normals());
        let off = normals.map(|(a, b)| (a - b).abs().max_element()).fold(0.0, f32::max);
        assert!(off <= if index == 0 { 2.0 * f32::EPSILON } else { 0.0 }, "mesh {index}: {off}");
    }
}

/// Without a list of meshes there still is a first one.
#[test]
fn the_first_mesh_needs_no_list() {
    let mut bytes = example(4);
    bytes.truncate(bytes.len() - 20);
    assert_eq!(mesh(FIRST, &bytes).triangles(), TRIANGLES);
}

#[test]
fn every_problem_is_named_by_byte() {
    let edited = |edit: &dyn Fn(&mut Vec<u8>)| {
        let mut data = data(4, 0x1003);
        edit(&mut data);
        file(4, &[data])
    };
    // Flags, name and the two counts.
    let header = 4 + 5 + 16;
    let (normals, uvs, faces) = (header + 48, header + 96, header + 128);
    for (edit, expected) in [
        (
            &(|d: &mut Vec<u8>| d.truncate(2)) as &dyn Fn(&mut Vec<u8>),
            ": mesh 0: byte 2: the data ends inside the header",
        ),
        (&|d| d.truncate(7), ": mesh 0: byte 7: the data ends inside the header"),
        (&|d| d[1] |= 0x04, ": mesh 0: byte 0: the flags 0x400 are not known"),
        (&|d| d[1] |= 0x20, ": mesh 0: byte 0: the flags say both single and double precision"),
        (
            &|d| d[9 + 4] = 1,
            ": mesh 0: byte 9: 4294967300 vertices: more than a 32-bit index can name",
        ),
        (
            &|d| d[17..25].fill(0xff),
            ": mesh 0: byte 17: 18446744073709551615 triangles: more than a 32-bit index can name",
        ),
        (
            &|d| d.truncate(header + 15),
            ": mesh 0: byte 40 (vertex 1): the file ends after 1 of 4 records of the element `vertex`",
        ),
        (
            &|d| d.truncate(normals),
            ": mesh 0: byte 73 (normal 0): the file ends after 0 of 4 records of the element `normal`",
        ),
        (
            &|d| d.truncate(uvs + 8),
            ": mesh 0: byte 129 (texture coordinate 1): the file ends after 1 of 4 records of the element \
             `texture coordinate`",
        ),
        (
            &|d| d[faces + 16] = 4,
            ": mesh 0: byte 169 (triangle 1): vertex index 4 is out of range (there are 4)",
        ),
        (
            &|d| d[17] = 3,
            ": mesh 0: byte 177 (triangle 2): the file ends after 2 of 3 records of the element `triangle`",
        ),
        (
            &|d| d.push(0),
            ": mesh 0: byte 177: the file goes on after the last element that its header declares",
        ),
    ] {
        assert_eq!(message(FIRST, edited(edit)), expected);
    }
}

#[test]
fn problems_around_the_data_are_named_by_byte() {
    let edited = |version, edit: &dyn Fn(&mut Vec<u8>)| {
        let mut bytes = example(version);
        edit(&mut bytes);
        bytes
    };
    let wrong_magic = ": byte 0: not a serialized mesh (one starts with the bytes 1c 04)";
    assert_eq!(message(FIRST, b""), wrong_magic);
    assert_eq!(message(FIRST, b"ply\n"), wrong_magic);
    assert_eq!(
        message(SECOND, edited(4, &|b| b[2] = 5)),
        ": byte 2: version 5 of the format is not read (expected 3 or 4)"
    );
    let end = example(4).len();
    assert_eq!(
        message(SECOND, edited(4, &|b| b[end - 4] = 1)),
        format!(": byte {}: there is no mesh 1: the file has 1, counted from 0", end - 4)
    );
    assert_eq!(
        message(SECOND, edited(4, &|b| b[end - 1] = 1)),
        format!(": byte {}: the file is too short for 16777218 meshes", end - 4)
    );
    let entry = example(4)[end - 12..].first_chunk().copied();
    let start_of_second = u64::from_le_bytes(entry.expect("8 bytes"));
    assert_eq!(
        message(SECOND, edited(4, &|b| b[end - 6] = 1)),
        format!(
            ": byte {}: mesh 1 is said to start at byte {}, behind all meshes of a file of {end} bytes",
            end - 12,
            (1_u64 << 48) + start_of_second
        )
    );
    let second = example(3).len() - 12;
    let start = u32::from_le_bytes(example(3)[second + 4..][..4].try_into().expect("4 bytes"));
    assert_eq!(
        message(SECOND, edited(3, &|b| b[second + 4] += 1)),
        format!(": byte {}: not a serialized mesh (one starts with the bytes 1c 04)", start + 1)
    );
    assert_eq!(
        message(SECOND, edited(3, &|b| b[start as usize + 2] = 4)),
        format!(
            ": byte {}: version 4 of the format is not read (expected that of the first mesh)",
            start + 2
        )
    );
    // A value changed behind the checksum's back, and data that are no stream at all.
    let changed = edited(3, &|b| b[start as usize - 1] ^= 1);
    for bytes in [changed, edited(3, &|b| b[4..6].fill(0xff))] {
        assert_eq!(message(FIRST, bytes), ": byte 4: cannot be read: corrupt deflate stream");
    }
    let bytes = edited(3, &|b| b[start as usize + 4..][..2].fill(0xff));
    let expected = format!(": byte {}: cannot be read: corrupt deflate stream", start + 4);
    assert_eq!(message(SECOND, bytes), expected);
}
