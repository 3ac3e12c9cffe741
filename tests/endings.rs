//! How a run ends: by a signal, and with pictures that cannot be written where they should go.

mod support;

use std::fs::{self, File};
use std::io::Read;
use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use support::command::{Folder, PROGRAM, Run, with_signals};

/// Numbers of signals.
const HUP: u32 = 1;
const INT: u32 = 2;
const TERM: u32 = 15;

/// So many samples that no test would see the end of it.
const ENDLESS: &str = "render scene.xml --quiet --spp 4000000000";

/// A line of the kernel's account of a process, as a set of signals.
fn signals(child: &Child, line: &str) -> u64 {
    let status = fs::read_to_string(format!("/proc/{}/status", child.id())).unwrap_or_default();
    let mask = status.lines().find_map(|l| l.strip_prefix(line)?.strip_prefix(':'));
    mask.map_or(0, |digits| u64::from_str_radix(digits.trim(), 16).expect("hexadecimal"))
}

fn has(set: u64, signal: u32) -> bool {
    set >> (signal - 1) & 1 == 1
}

fn send(child: &Child, signal: u32) {
    // The shell's own: a small Debian has no program of this name.
    let kill = format!("kill -{signal} {}", child.id());
    let status = Command::new("sh").args(["-c", &kill]).status().expect("a shell is there");
    assert!(status.success(), "it had not ended by itself");
}

/// Waits until the program obeys signals by itself, however long it takes to come so far.
fn wait_until_it_watches(child: &mut Child) {
    while !has(signals(child, "SigCgt"), TERM) {
        assert!(child.try_wait().expect("a child").is_none(), "it had not ended by itself");
        std::thread::sleep(Duration::from_millis(5));
    }
}

fn end(child: Child) -> Run {
    child.wait_with_output().expect("it ends").into()
}

/// Runs the program by a shell that has set its signals.
fn by_shell(folder: &Folder, prepare: &str) -> Child {
    with_signals("sh")
        .args(["-c", &format!("{prepare}; exec {PROGRAM} {ENDLESS} -o a.exr")])
        .current_dir(folder.path(""))
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("a shell is there")
}

fn make_fifo(path: &Path) {
    let made = Command::new("mkfifo").arg(path).status().expect("a part of every Debian");
    assert!(made.success());
}

#[test]
fn the_exit_code_says_which_signal_it_was() {
    let folder = Folder::new();
    for (signal, code) in [(HUP, 129), (INT, 130), (TERM, 143)] {
        let mut child = folder.spawn(&format!("{ENDLESS} -o a.exr"));
        wait_until_it_watches(&mut child);
        send(&child, signal);
        let run = end(child);
        assert_eq!(run.code, Some(code), "{}", run.stderr);
        assert!(run.stderr.starts_with("warning: interrupted"), "{}", run.stderr);
    }
}

#[test]
fn signals_that_were_ignored_stay_ignored() {
    let folder = Folder::new();
    // As nohup does, and as shells do for jobs in the background of a script.
    for (prepare, ignored) in [("trap '' HUP", &[HUP][..]), ("trap '' INT HUP", &[INT, HUP])] {
        let mut child = by_shell(&folder, prepare);
        wait_until_it_watches(&mut child);
        for &signal in ignored {
            assert!(has(signals(&child, "SigIgn"), signal), "{prepare}: {signal}");
            send(&child, signal);
        }
        send(&child, TERM);
        let run = end(child);
        // Had one of the others counted, it would have been the first.
        assert_eq!(run.code, Some(143), "{prepare}: {}", run.stderr);
    }
}

#[test]
fn the_second_signal_ends_at_once() {
    let folder = Folder::new();
    make_fifo(&folder.path("a.exr"));
    let mut child = folder.spawn("render scene.xml --quiet -o a.exr");
    wait_until_it_watches(&mut child);
    // Nobody reads the FIFO, so the first one cannot end it.
    while child.try_wait().expect("a child").is_none() {
        send_if_alive(&child, INT);
        std::thread::sleep(Duration::from_millis(20));
    }
    assert_eq!(end(child).code, Some(130));
    assert_eq!(folder.names(), ["a.exr"]);
}

/// Between the question and the signal the program may end; it is not yet waited for, so its number is its
/// own.
fn send_if_alive(child: &Child, signal: u32) {
    let kill = format!("kill -{signal} {}", child.id());
    let _ = Command::new("sh").args(["-c", &kill]).stderr(Stdio::null()).status();
}

/// While the first picture waits in a FIFO, the folder of the second one goes.
#[test]
fn a_picture_whose_folder_is_gone_goes_to_the_temporary_folder() {
    let folder = Folder::new();
    make_fifo(&folder.path("fifo.exr"));
    for name in ["sub", "tmp"] {
        fs::create_dir(folder.path(name)).expect("writable");
    }
    // More than a FIFO holds, so that the program waits for its reader.
    let arguments = "render scene.xml --spp 1 --size 400x300 -o fifo.exr -o sub/b.png";
    let child = Command::new(PROGRAM)
        .args(arguments.split(' '))
        .current_dir(folder.path(""))
        .env("TMPDIR", folder.path("tmp"))
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program is there");
    // Returns when the program has opened the other end: it has rendered.
    let mut fifo = File::open(folder.path("fifo.exr")).expect("readable");
    fs::remove_dir(folder.path("sub")).expect("empty");
    let mut picture = Vec::new();
    fifo.read_to_end(&mut picture).expect("readable");
    let run = end(child);
    assert!(picture.len() > 1 << 16, "only {} bytes", picture.len());
    assert_eq!(picture[..4], [0x76, 0x2f, 0x31, 0x01], "an OpenEXR file");
    assert_eq!(run.code, Some(3), "{}", run.stderr);
    let place = folder.path("tmp/b-rescued.png");
    let warning = format!(
        "warning: cannot write `sub/b.png`: there is no folder `sub`; the picture is in `{}`\n",
        place.display()
    );
    assert!(run.stderr.starts_with(&warning), "{}", run.stderr);
    let (width, height, _) = folder.png("tmp/b-rescued.png");
    assert_eq!((width, height), (400, 300));
}

#[test]
fn a_picture_for_a_full_disk_goes_beside() {
    let folder = Folder::new();
    symlink("/dev/full", folder.path("a.exr")).expect("writable");
    let run = folder.run("render scene.xml --quiet -o a.exr -o b.exr");
    assert_eq!(run.code, Some(3), "{}", run.stderr);
    assert_eq!(
        run.stderr,
        "warning: cannot write `a.exr`: No space left on device (os error 28); the picture is in \
         `./a-rescued.exr`\n"
    );
    assert_eq!(folder.names(), ["a-rescued.exr", "a.exr", "b.exr"]);
    assert_eq!(folder.header("a-rescued.exr").layer_size.0, 32);
}

#[test]
fn links_stay_and_what_killed_runs_left_goes() {
    let folder = Folder::new();
    fs::create_dir(folder.path("far")).expect("writable");
    fs::write(folder.path("far/b.exr"), "old").expect("writable");
    symlink("far/b.exr", folder.path("a.exr")).expect("writable");
    for name in ["far/.telamon-Ab12", ".telamon-Ab12"] {
        fs::write(folder.path(name), "half of a picture").expect("writable");
    }
    folder.succeed("render scene.xml --quiet -o a.exr -o c.exr");
    assert!(fs::symlink_metadata(folder.path("a.exr")).expect("there").is_symlink());
    assert_eq!(folder.header("far/b.exr").layer_size.0, 32);
    assert_eq!(folder.names(), ["a.exr", "c.exr", "far"]);
    assert_eq!(fs::read_dir(folder.path("far")).expect("there").count(), 1);
}

/// The line that is too long for Miette has an error in it, and so do its neighbours.
#[test]
fn an_error_at_any_column_is_shown() {
    for width in [100, 65_500, 65_536, 70_000, 200_000] {
        let filler = "é\t".repeat(width / 2);
        let folder = Folder::with_scene(&format!(
            "<scene version=\"3.0.0\"><!--{filler}--><shape type=\"shpere\"/></scene>"
        ));
        let told = folder.fail("render scene.xml", 1);
        assert!(
            told.starts_with("error: shape `shpere` is not supported (did you mean `sphere`?)")
        );
        let column = 44 + width;
        assert!(told.contains(&format!("[scene.xml:1:{column}]")), "{column}: {told}");
        assert!(told.len() < 2000, "{}", told.len());
    }
}
