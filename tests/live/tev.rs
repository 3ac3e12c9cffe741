//! A stand-in for tev, which reads its protocol: https://github.com/Tom94/tev, `include/tev/Ipc.h`.

use std::io::{self, Read};
use std::net::{TcpListener, TcpStream};
use std::sync::mpsc::{Receiver, channel};
use std::thread;

use crate::support::command::{Folder, Run};
use crate::{CHANNELS, Canvas, SCENE, end, first_line, interrupt};

/// So few pixels that a connection holds all of them: a viewer that is not given the time to read loses nothing.
const SMALL: &str = "-D width=131 -D height=77";

/// A packet's content, from its beginning.
struct Packet<'a>(&'a [u8]);

impl Packet<'_> {
    fn bytes<const N: usize>(&mut self) -> [u8; N] {
        let (bytes, rest) = self.0.split_first_chunk().expect("a longer packet");
        self.0 = rest;
        *bytes
    }

    fn u32(&mut self) -> usize {
        u32::from_le_bytes(self.bytes()) as usize
    }

    fn u64(&mut self) -> usize {
        u64::from_le_bytes(self.bytes()) as usize
    }

    fn text(&mut self) -> String {
        let end = self.0.iter().position(|byte| *byte == 0).expect("a zero at the end");
        let text = String::from_utf8(self.0[..end].to_vec()).expect("UTF-8");
        self.0 = &self.0[end + 1..];
        text
    }
}

fn read_packet(stream: &mut TcpStream) -> io::Result<Vec<u8>> {
    let mut length = [0; 4];
    stream.read_exact(&mut length)?;
    // The length counts itself.
    let mut packet = vec![0; u32::from_le_bytes(length) as usize - 4];
    stream.read_exact(&mut packet)?;
    Ok(packet)
}

/// The image that a packet creates.
fn create(packet: &[u8]) -> Canvas {
    let mut packet = Packet(packet);
    assert_eq!(packet.bytes(), [4, 1], "creates an image and shows it");
    assert_eq!(packet.text(), "scene.xml");
    let (width, height, count) = (packet.u32(), packet.u32(), packet.u32());
    let channels: Vec<_> = (0..count).map(|_| packet.text()).collect();
    assert_eq!(channels, CHANNELS);
    assert!(packet.0.is_empty());
    Canvas::new(width, height, count)
}

/// Puts what a packet has into an image.
fn update(packet: &[u8], canvas: &mut Canvas) {
    let mut packet = Packet(packet);
    assert_eq!(packet.bytes(), [6, 0], "updates an image and takes no focus");
    assert_eq!(packet.text(), "scene.xml");
    let count = packet.u32();
    let channels: Vec<_> = (0..count).map(|_| packet.text()).collect();
    assert_eq!(channels, CHANNELS);
    let [x, y, width, height] = [0; 4].map(|_| packet.u32());
    assert!(width > 0 && x + width <= canvas.width && y + height <= canvas.height);
    let offsets: Vec<_> = (0..count).map(|_| packet.u64()).collect();
    let strides: Vec<_> = (0..count).map(|_| packet.u64()).collect();
    let data: Vec<_> =
        packet.0.chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect();
    for channel in 0..count {
        let value = |i| data[offsets[channel] + i * strides[channel]];
        let values: Vec<_> = (0..width * height).map(value).collect();
        canvas.put(channel, [x, y, width], &values);
    }
}

/// A viewer that shows what comes, until the program goes; how it looked after each packet.
fn viewer(listener: TcpListener) -> Receiver<Canvas> {
    let (tell, told) = channel();
    thread::spawn(move || {
        let (mut stream, _) = listener.accept().expect("a connection");
        let mut canvas = create(&read_packet(&mut stream).expect("a packet"));
        // Whoever has seen enough goes.
        while tell.send(canvas.clone()).is_ok() {
            let Ok(packet) = read_packet(&mut stream) else { break };
            update(&packet, &mut canvas);
        }
    });
    told
}

fn listen() -> (TcpListener, String) {
    let listener = TcpListener::bind("127.0.0.1:0").expect("a free port");
    let address = listener.local_addr().expect("bound").to_string();
    (listener, address)
}

/// The same without a viewer.
fn unwatched(folder: &Folder, arguments: &str) -> Canvas {
    folder.succeed(&format!("render scene.xml {arguments} -o plain.exr"));
    Canvas::read(&folder.path("plain.exr"))
}

#[test]
fn tev_gets_the_picture_and_its_layers() {
    for arguments in ["--spp 5", "--spp 40 --adaptive", "--error 0.05"] {
        let arguments = &format!("{arguments} {SMALL}");
        let folder = Folder::with_scene(SCENE);
        let (listener, address) = listen();
        let told = viewer(listener);
        let run = folder.succeed(&format!(
            "render scene.xml {arguments} --quiet --live tev:{address} -o a.exr"
        ));
        assert_eq!(run.stderr, "", "{arguments}");
        let written = Canvas::read(&folder.path("a.exr"));
        assert!(written.is_whole());
        // The first is empty; the last has come before the program has ended.
        let first = told.recv().expect("a viewer");
        assert_eq!((first.width, first.height), (written.width, written.height));
        let last = told.iter().last();
        assert!(last.is_some_and(|seen| seen == written), "{arguments}: what was seen last");
        assert!(written == unwatched(&folder, arguments), "{arguments}");
    }
}

#[test]
fn a_viewer_that_is_not_there_is_missed_once() {
    let folder = Folder::with_scene(SCENE);
    // Bound, and closed again.
    let address = listen().1;
    // Long enough for several attempts.
    let run = folder.interrupt(
        &format!(
            "render scene.xml --quiet --spp 4000000000 --live tev:{address} --live tev:{address} -o a.exr"
        ),
        |run| run.stderr.contains("tev") && run.code == Some(130) && run.stderr.contains("samples"),
    );
    let warning = format!(
        "warning: tev does not take the picture at {address} (Connection refused (os error 111)); it gets it \
         when it does\n"
    );
    // One for each viewer.
    assert_eq!(run.stderr.matches(&warning).count(), 2, "{}", run.stderr);
    assert_eq!(run.stderr.matches("tev").count(), 2, "{}", run.stderr);
    assert_eq!(run.code, Some(130));
}

#[test]
fn a_viewer_that_hangs_costs_the_picture_nothing() {
    let folder = Folder::with_scene(SCENE);
    let (listener, address) = listen();
    // It takes connections, as the system does for it, and reads nothing.
    let arguments = "-D width=1000 -D height=750 --spp 2";
    let run = folder
        .succeed(&format!("render scene.xml {arguments} --quiet --live tev:{address} -o a.exr"));
    drop(listener);
    assert!(run.stderr.matches("warning").count() <= 1, "{}", run.stderr);
    assert!(Canvas::read(&folder.path("a.exr")) == unwatched(&folder, arguments));
}

#[test]
fn a_viewer_that_goes_and_comes_again_gets_all_of_it() {
    let folder = Folder::with_scene(SCENE);
    let (listener, address) = listen();
    let port = listener.local_addr().expect("bound");
    let mut child = folder.spawn(&format!(
        "render scene.xml --quiet --spp 4000000000 {SMALL} --live tev:{address} -o a.exr"
    ));
    let (mut stream, _) = listener.accept().expect("a connection");
    create(&read_packet(&mut stream).expect("a packet"));
    drop((stream, listener));
    // Until then it is away.
    let (warning, rest) = first_line(&mut child);
    assert!(
        warning.starts_with(&format!("warning: tev does not take the picture at {address} (")),
        "{warning}"
    );
    let told = viewer(TcpListener::bind(port).expect("still free"));
    assert!(told.iter().any(|seen| seen.is_whole()));
    interrupt(&child);
    let Run { code, stderr, .. } = end(child, rest);
    assert_eq!(code, Some(130), "{stderr}");
    assert!(stderr.starts_with("warning: interrupted"), "{stderr}");
    let written = Canvas::read(&folder.path("a.exr"));
    assert!(told.iter().last().is_some_and(|seen| seen == written), "what was seen last");
}
