//! Scenes: of the package, and meshes that are made here.

use std::error::Error;
use std::fmt::Write;
use std::fs;
use std::path::Path;

use glam::DVec3;
use telamon::load::{LoadOptions, load_scene, load_text};
use telamon::render::Description;

/// What is rendered.
pub(crate) enum Subject {
    /// A scene file of the package.
    File(&'static str),
    /// A dented ball of 409,600 triangles with a radius of about 1 that lies so far from the origin, under an even sky.
    Ball { away: f64 },
    /// A sphere with 20,000 thin triangles for fur, each a quarter of its radius long, under the same sky.
    Needles,
}

impl Subject {
    /// What it is, for the document.
    pub(crate) fn name(&self) -> String {
        match self {
            Self::File(path) => format!("`{path}`"),
            Self::Ball { away: 0.0 } => {
                "a dented ball of 409,600 triangles at the origin".to_owned()
            }
            Self::Ball { away } => {
                format!("a dented ball of 409,600 triangles, {away} radii from the origin")
            }
            Self::Needles => "a fur of 20,000 long and thin triangles in all directions".to_owned(),
        }
    }

    /// Loads it; files of the package are under `root`.
    pub(crate) fn load(&self, root: &Path) -> Result<Description, Box<dyn Error>> {
        match *self {
            Self::Ball { away } => self.load_with(root, &ball(away)),
            Self::Needles => self.load_with(root, &needles()),
            Self::File(_) => self.load_outline(root),
        }
    }

    /// The same in all but meshes, which are a triangle: enough to know how it is rendered.
    pub(crate) fn load_outline(&self, root: &Path) -> Result<Description, Box<dyn Error>> {
        let positions = vec![DVec3::ZERO, DVec3::X, DVec3::Y];
        self.load_with(root, &Mesh { positions, triangles: vec![[0, 1, 2]] })
    }

    fn load_with(&self, root: &Path, mesh: &Mesh) -> Result<Description, Box<dyn Error>> {
        let options = LoadOptions::default();
        let away = match *self {
            Self::File(path) => return Ok(load_scene(&root.join(path), &options)?.description),
            Self::Ball { away } => away,
            Self::Needles => 0.0,
        };
        let folder = tempfile::tempdir()?;
        fs::write(folder.path().join("mesh.ply"), mesh.ply())?;
        let text = format!(
            r#"<scene version="3.0.0">
                <integrator type="path"><integer name="max_depth" value="5"/></integrator>
                <sensor type="perspective">
                    <float name="fov" value="45"/>
                    <transform name="to_world">
                        <lookat origin="{away}, 1, 3" target="{away}, 0, 0" up="0, 1, 0"/>
                    </transform>
                    <sampler type="independent"/>
                    <film type="hdrfilm"><rfilter type="box"/></film>
                </sensor>
                <shape type="ply">
                    <string name="filename" value="mesh.ply"/>
                    <bsdf type="twosided"><bsdf type="diffuse">
                        <rgb name="reflectance" value="0.8"/>
                    </bsdf></bsdf>
                </shape>
                <emitter type="constant"/>
            </scene>"#
        );
        Ok(load_text(&text, &folder.path().join("scene.xml"), &options)?.description)
    }
}

struct Mesh {
    positions: Vec<DVec3>,
    triangles: Vec<[usize; 3]>,
}

impl Mesh {
    /// As a text file in Stanford's format.
    fn ply(&self) -> String {
        let mut text = format!(
            "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\n\
             property float z\nelement face {}\nproperty list uchar int vertex_indices\nend_header\n",
            self.positions.len(),
            self.triangles.len()
        );
        for p in &self.positions {
            writeln!(text, "{} {} {}", p.x, p.y, p.z).expect("a string takes all");
        }
        for [a, b, c] in &self.triangles {
            writeln!(text, "3 {a} {b} {c}").expect("a string takes all");
        }
        text
    }
}

const RINGS: usize = 321;
const SEGMENTS: usize = 640;

/// Closed, and every ray from its centre at (`away`, 0, 0) leaves it once.
fn ball(away: f64) -> Mesh {
    let center = DVec3::new(away, 0.0, 0.0);
    let point = |ring: usize, segment: usize| {
        let theta = std::f64::consts::PI * ring as f64 / RINGS as f64;
        let phi = std::f64::consts::TAU * segment as f64 / SEGMENTS as f64;
        let dents = 1.0 + 0.12 * theta.sin() * (9.0 * theta).sin() * (8.0 * phi).sin();
        let (across, up) = theta.sin_cos();
        center + dents * DVec3::new(across * phi.cos(), up, across * phi.sin())
    };
    let mut positions = vec![point(0, 0)];
    positions.extend((1..RINGS).flat_map(|r| (0..SEGMENTS).map(move |s| point(r, s))));
    positions.push(point(RINGS, 0));
    let last = positions.len() - 1;
    let index = |ring: usize, segment: usize| match ring {
        0 => 0,
        RINGS => last,
        _ => 1 + (ring - 1) * SEGMENTS + segment % SEGMENTS,
    };
    let mut triangles = Vec::new();
    for ring in 0..RINGS {
        for segment in 0..SEGMENTS {
            let [a, b] = [index(ring, segment), index(ring, segment + 1)];
            let [c, d] = [index(ring + 1, segment), index(ring + 1, segment + 1)];
            if ring > 0 {
                triangles.push([a, b, d]);
            }
            if ring + 1 < RINGS {
                triangles.push([a, d, c]);
            }
        }
    }
    Mesh { positions, triangles }
}

/// Thorns of the unit sphere in all directions, each a triangle 0.002 wide at its foot.
fn needles() -> Mesh {
    const COUNT: usize = 20_000;
    // Kronecker's sequence on the square roots of primes: even, and the same each time.
    let number = |i: usize, root: f64| (root.sqrt() * (i + 1) as f64).fract();
    let on_sphere = |i: usize, a: f64, b: f64| {
        let z = 2.0 * number(i, a) - 1.0;
        let (sin, cos) = (std::f64::consts::TAU * number(i, b)).sin_cos();
        let across = (1.0 - z * z).sqrt();
        DVec3::new(across * cos, z, across * sin)
    };
    let mut positions = Vec::new();
    for i in 0..COUNT {
        let (foot, direction) = (on_sphere(i, 2.0, 3.0), on_sphere(i, 5.0, 7.0));
        let side = 0.002 * direction.any_orthonormal_vector();
        positions.extend([foot, foot + 0.25 * direction, foot + side]);
    }
    let triangles = (0..COUNT).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    Mesh { positions, triangles }
}
