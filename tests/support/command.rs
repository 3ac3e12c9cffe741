//! The command, run in a fresh folder.

use std::fs::{self, File};
use std::io::BufReader;
use std::path::PathBuf;
use std::process::{Child, Command, Output, Stdio};
use std::time::Duration;

use exr::meta::header::Header;

pub(crate) const PROGRAM: &str = env!("CARGO_BIN_EXE_telamon");

/// A ball under a white sky; `$spp` is 4 unless `-D` says otherwise.
pub(crate) const SCENE: &str = r#"<scene version="3.0.0">
    <default name="spp" value="4"/>
    <integrator type="path"/>
    <sensor type="perspective">
        <transform name="to_world">
            <lookat origin="0, 0, -4" target="0, 0, 0" up="0, 1, 0"/>
        </transform>
        <float name="fov" value="45"/>
        <sampler type="independent">
            <integer name="sample_count" value="$spp"/>
        </sampler>
        <film type="hdrfilm">
            <integer name="width" value="32"/>
            <integer name="height" value="24"/>
            <rfilter type="box"/>
        </film>
    </sensor>
    <shape type="sphere">
        <bsdf type="diffuse"/>
    </shape>
    <emitter type="constant"/>
</scene>
"#;

/// A fresh folder with `scene.xml` in it.
pub(crate) struct Folder(tempfile::TempDir);

/// How a run of the program ended.
pub(crate) struct Run {
    pub(crate) code: Option<i32>,
    pub(crate) stdout: String,
    pub(crate) stderr: String,
}

impl Folder {
    pub(crate) fn new() -> Self {
        Self::with_scene(SCENE)
    }

    pub(crate) fn with_scene(scene: &str) -> Self {
        let folder = Self(tempfile::tempdir().expect("a folder"));
        fs::write(folder.path("scene.xml"), scene).expect("writable");
        folder
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// All names but the scene's, sorted.
    pub(crate) fn names(&self) -> Vec<String> {
        let entries = fs::read_dir(self.0.path()).expect("exists").flatten();
        let names = entries.map(|e| e.file_name().to_string_lossy().into_owned());
        let mut names: Vec<_> = names.filter(|n| n != "scene.xml").collect();
        names.sort_unstable();
        names
    }

    pub(crate) fn spawn(&self, arguments: &str) -> Child {
        with_signals(PROGRAM)
            .args(arguments.split_whitespace())
            .current_dir(self.0.path())
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the program is there")
    }

    pub(crate) fn run(&self, arguments: &str) -> Run {
        self.spawn(arguments).wait_with_output().expect("it ends").into()
    }

    /// A run that must succeed.
    pub(crate) fn succeed(&self, arguments: &str) -> Run {
        let run = self.run(arguments);
        assert_eq!(run.code, Some(0), "{arguments}: {}", run.stderr);
        run
    }

    /// What a run that must end with `code` says on standard error; it must leave nothing behind.
    pub(crate) fn fail(&self, arguments: &str, code: i32) -> String {
        let before = self.names();
        let run = self.run(arguments);
        assert_eq!(run.code, Some(code), "{arguments}: {}", run.stderr);
        assert_eq!(self.names(), before, "{arguments}");
        run.stderr
    }

    /// A run without end that is interrupted once it had begun, as `begun` says. However long that takes on a
    /// busy machine: each attempt is given double the time.
    pub(crate) fn interrupt(&self, arguments: &str, begun: impl Fn(&Run) -> bool) -> Run {
        let mut delay = Duration::from_millis(200);
        loop {
            let run = Endless(Some(self.spawn(arguments))).interrupt(delay);
            if begun(&run) {
                return run;
            }
            delay *= 2;
        }
    }

    pub(crate) fn header(&self, name: &str) -> Header {
        let data = exr::meta::MetaData::read_from_file(self.path(name), true).expect("an EXR file");
        data.headers.into_iter().next().expect("one part")
    }

    /// Width, height and bytes.
    pub(crate) fn png(&self, name: &str) -> (u32, u32, Vec<u8>) {
        let file = BufReader::new(File::open(self.path(name)).expect("written"));
        let mut reader = png::Decoder::new(file).read_info().expect("a PNG file");
        let mut bytes = vec![0; reader.output_buffer_size().expect("small")];
        let info = reader.next_frame(&mut bytes).expect("a picture");
        (info.width, info.height, bytes)
    }
}

impl From<Output> for Run {
    fn from(output: Output) -> Self {
        let text = |bytes| String::from_utf8(bytes).expect("UTF-8");
        let run = Self {
            code: output.status.code(),
            stdout: text(output.stdout),
            stderr: text(output.stderr),
        };
        assert!(!run.stderr.contains('\x1b'), "no colours where there is no terminal");
        assert!(!run.stderr.contains("panicked"), "{}", run.stderr);
        run
    }
}

/// A program that obeys the signals that end a run. It would keep to ignore them where the tests run behind a shell's `&` or
/// `nohup`.
pub(crate) fn with_signals(program: &str) -> Command {
    let mut command = Command::new("env");
    command.args(["--default-signal=HUP,INT,TERM", program]);
    command
}

/// A run without end, which ends with the test if that fails.
struct Endless(Option<Child>);

impl Drop for Endless {
    fn drop(&mut self) {
        if let Some(child) = &mut self.0 {
            // It may have ended by itself.
            let _ = child.kill();
            let _ = child.wait();
        }
    }
}

impl Endless {
    /// Sends SIGINT, `delay` after the start, and waits for the end.
    fn interrupt(mut self, delay: Duration) -> Run {
        std::thread::sleep(delay);
        let id = self.0.as_ref().expect("not yet waited for").id();
        // The shell's own: a small Debian has no program of this name.
        let kill = format!("kill -INT {id}");
        let status = Command::new("sh").args(["-c", &kill]).status().expect("a shell is there");
        assert!(status.success(), "it had not ended by itself");
        let child = self.0.take().expect("not yet waited for");
        child.wait_with_output().expect("it ends").into()
    }
}
