//! The server of the page, asked by hand.

use std::io::{Read, Write};
use std::net::{Shutdown, TcpListener, TcpStream};
use std::process::Child;

use serde_json::Value;

use crate::support::command::{Folder, Run};
use crate::{CHANNELS, Canvas, SCENE, end, first_line, interrupt};

/// A program whose page is at `http://` and these two.
pub(crate) struct Served<R> {
    pub(crate) child: Child,
    pub(crate) host: String,
    pub(crate) path: String,
    pub(crate) rest: R,
}

pub(crate) fn serve(folder: &Folder, arguments: &str) -> Served<impl Read + use<>> {
    let mut child = folder.spawn(&format!("render scene.xml --quiet {arguments} -o a.exr"));
    let (line, rest) = first_line(&mut child);
    let address = line.trim_end().strip_prefix("live: http://").expect("an address");
    let (host, path) = address.split_once('/').expect("a path");
    assert!(host.starts_with("127.0.0.1:"), "{host}");
    let token = path.strip_suffix('/').expect("a folder");
    assert!(token.len() == 32 && token.bytes().all(|b| b.is_ascii_hexdigit()), "{token}");
    Served { child, host: host.to_owned(), path: format!("/{path}"), rest }
}

/// What is said to these bytes: status line and headers, and the body.
fn answer(host: &str, question: &[u8]) -> (String, Vec<u8>) {
    let mut stream = TcpStream::connect(host).expect("listens");
    stream.write_all(question).expect("takes it");
    stream.shutdown(Shutdown::Write).expect("open");
    let mut bytes = Vec::new();
    stream.read_to_end(&mut bytes).expect("answers");
    let end = bytes.windows(4).position(|w| w == b"\r\n\r\n").expect("an end of the headers") + 4;
    let body = bytes.split_off(end);
    (String::from_utf8(bytes).expect("text"), body)
}

fn get(host: &str, target: &str) -> (String, Vec<u8>) {
    answer(host, format!("GET {target} HTTP/1.1\r\nHost: {host}\r\n\r\n").as_bytes())
}

/// Asks for a layer and puts it into `canvas`, whose channels it has from `first` on; what is told beside.
fn look(host: &str, target: &str, canvas: &mut Canvas, first: usize) -> Value {
    let (head, body) = get(host, target);
    assert!(head.starts_with("HTTP/1.1 200 OK\r\n"), "{head}");
    let word = |at: usize| {
        let bytes = body[at..at + 4].try_into().expect("four bytes");
        u32::from_le_bytes(bytes)
    };
    let mut at = 4 + word(0) as usize;
    assert_eq!(at % 4, 0);
    let told: Value = serde_json::from_slice(&body[4..at]).expect("JSON");
    let channels = told["channels"].as_u64().expect("a number") as usize;
    if canvas.channels.is_empty() {
        let side = |name: &str| told[name].as_u64().expect("a number") as usize;
        *canvas = Canvas::new(side("width"), side("height"), CHANNELS.len());
    }
    while at < body.len() {
        let [x, y, width, height] = [0, 4, 8, 12].map(|offset| word(at + offset) as usize);
        at += 16;
        for channel in first..first + channels {
            let values = (0..width * height).map(|i| f32::from_bits(word(at + 4 * i)));
            canvas.put(channel, [x, y, width], &values.collect::<Vec<_>>());
            at += 4 * width * height;
        }
    }
    assert_eq!(at, body.len());
    told
}

#[test]
fn only_who_knows_the_address_is_answered() {
    let folder = Folder::with_scene(SCENE);
    let Served { child, host, path, rest } = serve(&folder, "--spp 4000000000 --live web");
    let token = path.trim_matches('/').to_owned();
    let asked = |question: String| answer(&host, question.as_bytes()).0;
    let (head, body) = get(&host, &path);
    assert!(head.starts_with("HTTP/1.1 200 OK\r\nContent-Type: text/html"), "{head}");
    for header in ["Cache-Control: no-store", "default-src 'none'", "frame-ancestors 'none'"] {
        assert!(head.contains(header), "{head}");
    }
    let page = String::from_utf8(body).expect("text");
    assert!(page.starts_with("<!doctype html>"));
    // It names nothing that is elsewhere.
    assert!(!page.contains("http:") && !page.contains("https:") && !page.contains("//cdn"));
    assert_eq!(get(&host, &format!("/{token}")).1, page.as_bytes());

    let almost = format!("/{}/", token.chars().rev().collect::<String>());
    let short = format!("/{}/", &token[1..]);
    for target in ["/", "/data", "/favicon.ico", &almost, &short, &format!("/{token}/x"), "//"] {
        let (head, body) = get(&host, target);
        assert!(head.starts_with("HTTP/1.1 404 Not Found\r\n"), "{target}: {head}");
        assert!(!String::from_utf8(body).expect("text").contains(&token), "{target}");
    }
    for name in ["evil.example", "evil.example:80", "127.0.0.1.evil.example"] {
        let head = asked(format!("GET {path} HTTP/1.1\r\nHost: {name}\r\n\r\n"));
        assert!(head.starts_with("HTTP/1.1 403 Forbidden\r\n"), "{name}: {head}");
    }
    // Through `ssh -L 9000:…` another port is asked for.
    let head = asked(format!("GET {path} HTTP/1.1\r\nHost: localhost:9000\r\n\r\n"));
    assert!(head.starts_with("HTTP/1.1 200 OK\r\n"), "{head}");
    let head = asked(format!("POST {path} HTTP/1.1\r\nHost: {host}\r\n\r\n"));
    assert!(head.starts_with("HTTP/1.1 405 Method Not Allowed\r\nAllow: GET\r\n"), "{head}");
    let long = format!("GET {path} HTTP/1.1\r\nX: {}\r\n\r\n", "x".repeat(1 << 17));
    // Refused before all of it is there, so that the rest may find the connection closed.
    let mut stream = TcpStream::connect(&host).expect("listens");
    let _ = stream.write_all(long.as_bytes());
    for question in ["\r\n\r\n\r\n", "GET / HTTP/1.1\r\nHost", "\u{16}\u{3}\u{1}", ""] {
        let head = asked(question.to_owned());
        assert!(head.starts_with("HTTP/1.1 400 Bad Request\r\n"), "{question}: {head}");
    }
    interrupt(&child);
    assert_eq!(end(child, rest).code, Some(130));
}

#[test]
fn a_page_gets_the_picture_while_it_grows_and_the_end_of_it() {
    let folder = Folder::with_scene(SCENE);
    let Served { child, host, path, rest } = serve(&folder, "--spp 4000000000 --live web");
    let mut canvas = Canvas::default();
    let mut told = Value::Null;
    let mut layers = String::new();
    let ask = |told: &Value, canvas: &mut Canvas| {
        let since = told["version"].as_u64().unwrap_or(0);
        look(&host, &format!("{path}data?since={since}&layer=0&more=1&page=p"), canvas, 0)
    };
    while told["samples"].as_f64().unwrap_or(0.0) < 3.0 {
        told = ask(&told, &mut canvas);
        layers = told["layers"].to_string();
        assert!(told["ended"].is_null() && told["errors"] == Value::Array(Vec::new()), "{told}");
    }
    assert!(canvas.channels[..3].iter().flatten().all(|value| !value.is_nan()));
    assert_eq!(told["scene"], "scene.xml");
    assert_eq!(
        layers,
        r#"[{"kind":"picture","name":"picture"},{"kind":"depth","name":"far"},{"kind":"sh_normal","name":"way"}]"#
    );
    interrupt(&child);
    while told["ended"].is_null() {
        told = ask(&told, &mut canvas);
    }
    assert_eq!(told["ended"], "interrupted");
    // The program waits until the page says that it has all.
    for (layer, first, more) in [(1, 3, 1), (2, 4, 0)] {
        let target = format!("{path}data?since=0&layer={layer}&more={more}&page=p");
        let told = look(&host, &target, &mut canvas, first);
        assert_eq!((&told["ended"], &told["layer"]), (&"interrupted".into(), &layer.into()));
    }
    let Run { code, stderr, .. } = end(child, rest);
    assert_eq!(code, Some(130), "{stderr}");
    assert!(canvas == Canvas::read(&folder.path("a.exr")));
    TcpStream::connect(&host).expect_err("nobody listens");
}

#[test]
fn a_page_is_told_of_the_error_that_was_asked_for() {
    let folder = Folder::with_scene(SCENE);
    let arguments = "--spp 4000000000 --error 1e-9 --live web";
    let Served { child, host, path, rest } = serve(&folder, arguments);
    let mut canvas = Canvas::default();
    let mut told = look(&host, &format!("{path}data?page=p"), &mut canvas, 0);
    assert_eq!(told["errors"][0]["target"], 1e-9);
    while told["errors"][0]["value"].is_null() {
        // Before the first look nobody can know.
        assert!(told["seconds_left"].is_null(), "{told}");
        let since = told["version"].as_u64().expect("a number");
        told = look(&host, &format!("{path}data?since={since}&page=p"), &mut canvas, 0);
    }
    let error = |name: &str| told["errors"][0][name].as_f64().expect("a number");
    assert!(error("value") > 0.0 && error("bound") >= error("value"), "{told}");
    assert!(told["seconds_left"].as_f64().expect("known") > 0.0);
    interrupt(&child);
    assert_eq!(end(child, rest).code, Some(130));
}

/// Browsers open connections in store. Nor does one that asks and goes keep anything from ending.
#[test]
fn who_asks_nothing_delays_nothing() {
    let folder = Folder::with_scene(SCENE);
    let Served { mut child, host, path, rest } = serve(&folder, "--spp 4000000000 --live web");
    let idle: Vec<_> = (0..20).map(|_| TcpStream::connect(&host).expect("listens")).collect();
    let mut gone = TcpStream::connect(&host).expect("listens");
    let question = format!("GET {path}data?page=gone HTTP/1.1\r\nHost: {host}\r\n\r\n");
    gone.write_all(question.as_bytes()).expect("takes it");
    drop(gone);
    let (head, _) = get(&host, &path);
    assert!(head.starts_with("HTTP/1.1 200 OK\r\n"), "{head}");
    interrupt(&child);
    assert_eq!(child.wait().expect("it ends").code(), Some(130));
    drop((idle, rest));
}

#[test]
fn a_port_that_is_taken_is_a_failure_before_anything_is_done() {
    let folder = Folder::with_scene(SCENE);
    let listener = TcpListener::bind("127.0.0.1:0").expect("a free port");
    let port = listener.local_addr().expect("bound").port();
    let told = folder.fail(&format!("render scene.xml --spp 4000000000 --live web:{port}"), 1);
    let expected =
        format!("error: cannot serve on 127.0.0.1:{port}: Address already in use (os error 98)\n");
    assert_eq!(told, expected);
}

/// Nobody looks, and two viewers of one kind and one of another are no trouble.
#[test]
fn several_viewers_change_nothing() {
    let folder = Folder::with_scene(SCENE);
    let run =
        folder.succeed("render scene.xml --live web --live web --live tev:127.0.0.1:1 -o a.exr");
    let lines: Vec<_> = run.stderr.lines().collect();
    assert!(lines[0].starts_with("live: http://127.0.0.1:") && lines[1].starts_with("live: http"));
    assert_ne!(lines[0], lines[1]);
    folder.succeed("render scene.xml -o b.exr");
    assert!(Canvas::read(&folder.path("a.exr")) == Canvas::read(&folder.path("b.exr")));
}
