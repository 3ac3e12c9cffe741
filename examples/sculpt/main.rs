//! Writes a sculpture, a carved ball on a plinth, as a watertight mesh of a requested size: the
//! large mesh that `scenes/gyroid.xml` shows and the benchmarks trace. The same request gives the
//! same bytes on any number of threads.

mod figure;
mod lattice;
mod mesh;
#[cfg(test)]
mod tests;

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Parser;

use lattice::Lattice;
use mesh::{Mesh, write_ply};

/// Write a watertight sculpture of a given number of triangles as a binary PLY file.
#[derive(Parser)]
struct Arguments {
    /// Number of triangles, met within 5 percent.
    #[arg(value_parser = clap::value_parser!(u32).range(1_000..=20_000_000))]
    triangles: u32,
    /// File to write.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Leave out the smooth vertex normals.
    #[arg(long)]
    no_normals: bool,
}

#[expect(clippy::print_stderr, reason = "this is a command")]
fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let mesh = sculpt(arguments.triangles as usize);
    eprintln!(
        "{} triangles, {} vertices, {} component(s), genus {}",
        mesh.triangles.len(),
        mesh.vertices.len(),
        mesh.components(),
        mesh.genus(),
    );
    match write_ply(&mesh, !arguments.no_normals, &arguments.output) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{}: {error}", arguments.output.display());
            ExitCode::FAILURE
        }
    }
}

/// The figure in `wanted` triangles, give or take 5 percent.
fn sculpt(wanted: usize) -> Mesh {
    // The count goes with spacing^-2; 10.6² is what the figure's area comes to. Coarse lattices carve
    // other openings at each spacing, so there the neighbourhood is searched, nearest first.
    let guess = 10.6 / (wanted as f32).sqrt();
    let off = |mesh: &Mesh| mesh.triangles.len().abs_diff(wanted);
    let mut nearest = Lattice::new(guess).surface();
    for per_mille in (5..=500).step_by(5).flat_map(|n| [n, -n]) {
        if off(&nearest) * 20 <= wanted {
            break;
        }
        let mesh = Lattice::new(guess * (1.0 + 0.001 * per_mille as f32)).surface();
        if off(&mesh) < off(&nearest) {
            nearest = mesh;
        }
    }
    nearest
}
