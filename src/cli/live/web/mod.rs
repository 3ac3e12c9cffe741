//! A page on this machine that shows a render.
//!
//! Whoever knows the address may look, and nobody else: it has a random token in it, and the server listens on the
//! loopback interface alone. Names of other machines that point there (DNS rebinding) are refused.

use std::collections::HashMap;
use std::io::{self, Write};
use std::net::{Ipv4Addr, Shutdown, SocketAddr, TcpListener, TcpStream};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use super::{FAREWELL, Pace, Shared};

mod answer;
mod http;

use http::{Refusal, Request};

/// The whole page; it asks for nothing but `data` beside itself.
const PAGE: &str = include_str!("page.html");

/// Connections at a time.
const MOST: usize = 32;
/// How long a question waits for something new.
const PATIENCE: Duration = Duration::from_secs(1);
/// How long a page that asks no more is thought to be there.
const SILENCE: Duration = Duration::from_secs(2);
/// How long one may take to ask.
const ASKING: Duration = Duration::from_secs(5);
/// How long one may leave the answer unread.
const READING: Duration = Duration::from_secs(2);

/// A port of this machine that is listened to.
#[derive(Debug)]
pub(super) struct Listener {
    socket: TcpListener,
    address: SocketAddr,
    token: String,
}

impl Listener {
    /// Listens to a port; to one that is free, if it is 0.
    pub(super) fn open(port: u16) -> io::Result<Self> {
        let socket = TcpListener::bind((Ipv4Addr::LOCALHOST, port))?;
        let address = socket.local_addr()?;
        let mut token = [0; 16];
        getrandom::fill(&mut token).map_err(|e| io::Error::other(e.to_string()))?;
        let token = token.iter().map(|byte| format!("{byte:02x}")).collect();
        Ok(Self { socket, address, token })
    }

    /// Where the page is.
    pub(super) fn address(&self) -> String {
        format!("http://{}/{}/", self.address, self.token)
    }
}

/// What the connections of a server share.
struct Server {
    shared: Arc<Shared>,
    token: String,
    pace: Mutex<Pace>,
    /// Pages that do not have all of the finished picture yet, and when they were last heard of.
    pages: Mutex<HashMap<String, Instant>>,
    connections: AtomicUsize,
    /// Answers with data that are under way.
    answers: AtomicUsize,
    is_closed: AtomicBool,
}

/// Serves the page until the render has ended and all pages have what it made.
pub(super) fn serve(shared: &Arc<Shared>, listener: &Listener) {
    let server = Arc::new(Server {
        shared: Arc::clone(shared),
        token: listener.token.clone(),
        pace: Mutex::new(Pace::new()),
        pages: Mutex::default(),
        connections: AtomicUsize::new(0),
        answers: AtomicUsize::new(0),
        is_closed: AtomicBool::new(false),
    });
    let (closing, address) = (Arc::clone(&server), listener.address);
    thread::spawn(move || {
        while !closing.shared.wait(Duration::from_secs(3600)) {}
        let begin = Instant::now();
        while begin.elapsed() < FAREWELL && closing.has_pages() {
            thread::sleep(Duration::from_millis(10));
        }
        closing.is_closed.store(true, Ordering::Release);
        // The server waits for connections, and so gets one.
        let _ = TcpStream::connect_timeout(&address, FAREWELL);
    });
    for stream in listener.socket.incoming() {
        if server.is_closed.load(Ordering::Acquire) {
            return;
        }
        let Ok(stream) = stream else {
            // Too many open files, perhaps: no reason to keep a processor busy.
            thread::sleep(Duration::from_millis(100));
            continue;
        };
        if server.connections.fetch_add(1, Ordering::AcqRel) >= MOST {
            server.connections.fetch_sub(1, Ordering::AcqRel);
            continue;
        }
        // Not waited for in the end: browsers keep connections in store on which nothing is asked.
        let server = Arc::clone(&server);
        thread::spawn(move || {
            // Whoever has gone gets nothing.
            let _ = server.answer(stream);
            server.connections.fetch_sub(1, Ordering::AcqRel);
        });
    }
}

impl Server {
    /// Answers one question.
    fn answer(&self, mut stream: TcpStream) -> io::Result<()> {
        stream.set_write_timeout(Some(READING))?;
        stream.set_nodelay(true)?;
        let request = http::read(&mut stream, ASKING).and_then(|request| {
            let path = request.path.strip_prefix('/').and_then(|p| p.strip_prefix(&self.token));
            match path {
                Some("" | "/") => Ok((false, request)),
                Some("/data") => Ok((true, request)),
                _ => Err(Refusal::NotFound),
            }
        });
        match request {
            Err(refusal) => http::refuse(&mut stream, refusal)?,
            Ok((true, request)) => {
                self.answers.fetch_add(1, Ordering::AcqRel);
                let answered = self.data(&mut stream, &request);
                self.answers.fetch_sub(1, Ordering::AcqRel);
                answered?;
            }
            Ok((false, _)) => {
                http::head(&mut stream, "200 OK", "text/html; charset=utf-8", PAGE.len())?;
                stream.write_all(PAGE.as_bytes())?;
            }
        }
        stream.shutdown(Shutdown::Write)
    }

    /// Answers with what has changed, as soon as something has and it is time.
    fn data(&self, stream: &mut TcpStream, request: &Request) -> io::Result<()> {
        let number = |name: &str| request.parameter(name).and_then(|text| text.parse().ok());
        let since = number("since").unwrap_or(0);
        let layer = number("layer").unwrap_or(0) as usize;
        let has_more_to_ask = number("more").unwrap_or(0) > 0;
        let page: String = request.parameter("page").unwrap_or("").chars().take(32).collect();
        // Before the look at the picture: what it has then is all of it.
        let has_ended = self.wait(since);
        let begin = Instant::now();
        self.pace().worked(begin, Duration::ZERO);
        let answer = answer::Answer::new(&self.shared, since, layer, has_ended);
        self.pace().worked(begin, begin.elapsed());
        http::head(stream, "200 OK", "application/octet-stream", answer.len())?;
        answer.write(stream)?;
        let mut pages = self.pages();
        pages.retain(|_, heard| heard.elapsed() < SILENCE);
        if has_ended && !has_more_to_ask {
            pages.remove(&page);
        } else if pages.len() < MOST {
            pages.insert(page, Instant::now());
        }
        Ok(())
    }

    /// Waits until something has changed and may be sent, until nothing seems to change, or for the end;
    /// whether that has come.
    fn wait(&self, since: u64) -> bool {
        let begin = Instant::now();
        loop {
            let left = self.pace().left();
            let is_due = left.is_zero()
                && (self.shared.preview.version() > since || begin.elapsed() >= PATIENCE);
            if is_due {
                return self.shared.wait(Duration::ZERO);
            }
            if self.shared.wait(left.clamp(Duration::from_millis(20), PATIENCE)) {
                return true;
            }
        }
    }

    fn pace(&self) -> MutexGuard<'_, Pace> {
        self.pace.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn pages(&self) -> MutexGuard<'_, HashMap<String, Instant>> {
        self.pages.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Whether a page may be there that does not know of the end.
    fn has_pages(&self) -> bool {
        let mut pages = self.pages();
        pages.retain(|_, heard| heard.elapsed() < SILENCE);
        !pages.is_empty() || self.answers.load(Ordering::Acquire) > 0
    }
}
