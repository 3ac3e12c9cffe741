//! `telamon render --live`: viewers that are there, that hang, that go and come again, and what they get.

#[cfg(feature = "peers")]
mod browser;
#[path = "../support/mod.rs"]
mod support;
mod tev;
mod web;

use std::io::{BufRead, BufReader, Read};
use std::path::Path;
use std::process::{Child, Command};

use support::command::Run;
use telamon::film::picture::Values;
use telamon::film::read::read_exr;

/// A ball before a mirror with two layers beside the picture, so large that no connection holds it unread; a crop
/// of which some tiles are narrow. Colours are written as they are.
const SCENE: &str = r#"<scene version="3.0.0">
    <default name="spp" value="3"/><default name="width" value="640"/><default name="height" value="480"/>
    <integrator type="aov">
        <string name="aovs" value="far:depth, way:sh_normal"/>
        <integrator type="path"/>
    </integrator>
    <sensor type="perspective">
        <transform name="to_world"><lookat origin="0, 1, -4" target="0, 0, 0" up="0, 1, 0"/></transform>
        <sampler type="independent"><integer name="sample_count" value="$spp"/></sampler>
        <film type="hdrfilm">
            <integer name="width" value="$width"/><integer name="height" value="$height"/>
            <integer name="crop_offset_x" value="3"/><integer name="crop_offset_y" value="2"/>
            <string name="component_format" value="float32"/>
        </film>
    </sensor>
    <shape type="sphere"><bsdf type="diffuse"><rgb name="reflectance" value="0.7, 0.4, 0.2"/></bsdf></shape>
    <shape type="disk">
        <transform name="to_world">
            <rotate x="1" angle="-90"/><scale value="3"/><translate y="-1"/>
        </transform>
        <bsdf type="conductor"/>
    </shape>
    <emitter type="constant"><rgb name="radiance" value="0.6, 0.8, 1"/></emitter>
</scene>"#;

/// Channels in the order in which viewers get them.
const CHANNELS: [&str; 7] = ["R", "G", "B", "far.T", "way.X", "way.Y", "way.Z"];

/// A picture that is put together from tiles.
#[derive(Clone, Default, PartialEq)]
struct Canvas {
    width: usize,
    height: usize,
    /// NaN where nothing has come.
    channels: Vec<Vec<f32>>,
}

impl Canvas {
    fn new(width: usize, height: usize, channels: usize) -> Self {
        Self { width, height, channels: vec![vec![f32::NAN; width * height]; channels] }
    }

    /// What a file holds.
    fn read(path: &Path) -> Self {
        let picture = read_exr(path).expect("an EXR file");
        let values = |name: &&str| {
            let channel = picture.channels.iter().find(|c| c.name == *name).expect("there");
            match &channel.values {
                Values::Color(values) | Values::Float(values) => values.clone(),
                Values::Index(_) => panic!("{name} is none of the scene's"),
            }
        };
        Self {
            width: picture.crop.width as usize,
            height: picture.crop.height as usize,
            channels: CHANNELS.iter().map(values).collect(),
        }
    }

    fn put(&mut self, channel: usize, [x, y, width]: [usize; 3], values: &[f32]) {
        for (row, values) in values.chunks_exact(width).enumerate() {
            let begin = (y + row) * self.width + x;
            self.channels[channel][begin..][..width].copy_from_slice(values);
        }
    }

    fn is_whole(&self) -> bool {
        self.channels.iter().flatten().all(|value| !value.is_nan())
    }
}

/// The first line that a program says on standard error, and then the rest.
fn first_line(child: &mut Child) -> (String, impl Read + use<>) {
    let mut stderr = BufReader::new(child.stderr.take().expect("piped"));
    let mut line = String::new();
    stderr.read_line(&mut line).expect("text");
    (line, stderr)
}

/// The end of a program whose standard error is read by `rest`.
fn end(mut child: Child, mut rest: impl Read) -> Run {
    let mut stderr = String::new();
    rest.read_to_string(&mut stderr).expect("text");
    let code = child.wait().expect("it ends").code();
    Run { code, stdout: String::new(), stderr }
}

fn interrupt(child: &Child) {
    // The shell's own: a small Debian has no program of this name.
    let kill = format!("kill -INT {}", child.id());
    let status = Command::new("sh").args(["-c", &kill]).status().expect("a shell is there");
    assert!(status.success(), "it had not ended by itself");
}
