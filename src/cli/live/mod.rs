//! `--live`: the picture, shown while it is rendered.
//!
//! Each viewer has a thread of its own, which copies from a [`Preview`] what has changed since it looked last. The
//! render never waits for a viewer, however slow that is.

use std::str::FromStr;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use telamon::film::AovLayer;
use telamon::render::{Description, Effort, Ended, Errors, Preview, Progress, Statistics};

mod pace;
mod terminal;
mod tev;
mod web;

use super::message::{Failure, say, warn};
use pace::Pace;
use terminal::Terminal;

/// How long viewers have in the end to take what is new.
const FAREWELL: Duration = Duration::from_secs(2);

/// Something that shows a picture while it is rendered.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Viewer {
    /// The viewer tev, at a host and port.
    Tev(String),
    /// A web page, at a port of this machine; 0 is one that is free.
    Web(u16),
    /// The terminal in which the program runs.
    Terminal,
}

impl FromStr for Viewer {
    type Err = &'static str;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let (name, place) =
            text.split_once(':').map_or((text, None), |(name, place)| (name, Some(place)));
        let is_port = |port: &str| port.parse::<u16>().is_ok_and(|port| port > 0);
        match (name, place) {
            ("tev", None) => Ok(Self::Tev(tev::DEFAULT.to_owned())),
            ("tev", Some(place)) => match place.rsplit_once(':') {
                Some((host, port)) if !host.is_empty() && is_port(port) => {
                    Ok(Self::Tev(place.to_owned()))
                }
                _ => Err("expected a host and a port, such as tev:127.0.0.1:14158"),
            },
            ("web", None) => Ok(Self::Web(0)),
            ("web", Some(port)) if is_port(port) => Ok(Self::Web(port.parse().unwrap_or(0))),
            ("web", Some(_)) => Err("expected a port from 1 to 65535, such as web:8080"),
            ("terminal", None) => Ok(Self::Terminal),
            _ => Err("expected tev, tev:HOST:PORT, web, web:PORT or terminal"),
        }
    }
}

/// Viewers that wait for a render to begin.
#[derive(Debug, Default)]
pub(super) struct Waiting(Vec<Open>);

/// A viewer for which all is there that can fail.
#[derive(Debug)]
enum Open {
    Tev(String),
    Web(web::Listener),
    Terminal(Terminal),
}

impl Waiting {
    /// Takes the ports of the web pages and says where they are.
    pub(super) fn open(viewers: &[Viewer]) -> Result<Self, Failure> {
        let open = |viewer: &Viewer| match viewer {
            Viewer::Tev(address) => Ok(Open::Tev(address.clone())),
            Viewer::Web(port) => web::Listener::open(*port)
                .map(Open::Web)
                .map_err(|e| Failure::new(format!("cannot serve on 127.0.0.1:{port}: {e}"))),
            Viewer::Terminal => Terminal::open().map(Open::Terminal).map_err(Failure::new),
        };
        let opened = viewers.iter().map(open).collect::<Result<Vec<_>, _>>()?;
        for viewer in &opened {
            if let Open::Web(listener) = viewer {
                say(&format!("live: {}", listener.address()));
            }
        }
        Ok(Self(opened))
    }

    pub(super) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Begins to show the renders of `description` and of others that differ in the camera alone, made from the scene
    /// file `scene`. `aside` runs what writes to standard error, while nothing else does.
    pub(super) fn start(
        self,
        description: &Description,
        scene: String,
        aside: impl Fn(&dyn Fn()) + Send + Sync + 'static,
    ) -> Result<Live, Failure> {
        if self.is_empty() {
            return Ok(Live { shared: None, viewers: Vec::new() });
        }
        let in_terminal = self.0.iter().any(|viewer| matches!(viewer, Open::Terminal(_)));
        if in_terminal && description.integrator.picture().is_none() {
            let message = "`--live terminal` shows the picture, and the scene makes layers alone";
            return Err(Failure::new(message));
        }
        let shared = Arc::new(Shared { in_terminal, ..Shared::new(description, scene) });
        let aside = Arc::new(aside);
        let mut viewers = Vec::new();
        for viewer in self.0 {
            let (shared, aside) = (Arc::clone(&shared), Arc::clone(&aside));
            let show = move || match viewer {
                Open::Tev(address) => {
                    let warn = |text: String| aside(&|| shared.say(|| warn(text.as_str())));
                    tev::show(&shared, &address, &warn);
                }
                Open::Web(listener) => web::serve(&shared, &listener),
                Open::Terminal(terminal) => {
                    terminal::show(&shared, &terminal, &|write| aside(&|| write()));
                }
            };
            viewers.push(thread::Builder::new().name("live".to_owned()).spawn(show)?);
        }
        Ok(Live { shared: Some(shared), viewers })
    }
}

/// Viewers of a render; none of one that nobody watches.
#[derive(Debug)]
pub(super) struct Live {
    shared: Option<Arc<Shared>>,
    viewers: Vec<JoinHandle<()>>,
}

impl Live {
    /// Takes over what is new.
    pub(super) fn update(&self, progress: &Progress<'_>) {
        let Some(shared) = &self.shared else { return };
        shared.preview.update(progress.tile);
        // Who reads it at this moment has older numbers, which are as good; a render does not wait for them.
        if let Ok(mut status) = shared.status.try_lock() {
            let Progress { samples_done, samples_total, errors, .. } = *progress;
            status.begun.get_or_insert_with(Instant::now);
            if samples_done > status.samples_done {
                (status.samples_done, status.samples_total) = (samples_done, samples_total);
            }
            status.errors = errors.or(status.errors);
        }
    }

    /// Another picture begins, of the same scene and film.
    pub(super) fn begin(&self) {
        let Some(shared) = &self.shared else { return };
        *shared.status() = Status::default();
    }

    /// Runs what writes lines to standard error, once a picture in the terminal above them has all that there is.
    pub(super) fn say<T>(&self, write: impl FnOnce() -> T) -> T {
        let Some(shared) = &self.shared else { return write() };
        let begin = Instant::now();
        let is_late = || shared.drawn.load(Ordering::Acquire) < shared.preview.version();
        while shared.in_terminal && is_late() && begin.elapsed() < FAREWELL {
            thread::sleep(Duration::from_millis(5));
        }
        shared.say(write)
    }

    /// No more samples come. Viewers get what they lack while the picture is written.
    pub(super) fn end(&self, statistics: &Statistics) {
        let Some(shared) = &self.shared else { return };
        let mut status = shared.status();
        status.samples_done = statistics.samples;
        status.errors = statistics.errors;
        status.ended = Some((Some(statistics.ended), statistics.elapsed));
        shared.has_ended.notify_all();
    }

    /// Lets viewers take what is new, and ends. One that hangs is left behind.
    pub(super) fn close(&mut self) {
        let Some(shared) = self.shared.take() else { return };
        shared.status().ended.get_or_insert((None, Duration::ZERO));
        shared.has_ended.notify_all();
        let begin = Instant::now();
        while begin.elapsed() < FAREWELL && !self.viewers.iter().all(JoinHandle::is_finished) {
            thread::sleep(Duration::from_millis(5));
        }
    }
}

impl Drop for Live {
    fn drop(&mut self) {
        self.close();
    }
}

/// What the threads of a render and of its viewers share.
#[derive(Debug)]
struct Shared {
    preview: Preview,
    /// The scene file.
    scene: String,
    /// Layers beside the picture.
    layers: Vec<AovLayer>,
    effort: Effort,
    status: Mutex<Status>,
    has_ended: Condvar,
    /// Whether a terminal shows the picture.
    in_terminal: bool,
    /// Version of the preview that it shows.
    drawn: AtomicU64,
    /// How many times something else was written there. Who writes keeps it.
    said: Mutex<u64>,
}

/// How far a render has come.
#[derive(Clone, Debug, Default)]
struct Status {
    /// When the first samples came.
    begun: Option<Instant>,
    samples_done: u64,
    samples_total: u64,
    errors: Option<Errors>,
    /// Why and after what time it ended; why is not known of one that failed.
    ended: Option<(Option<Ended>, Duration)>,
}

impl Shared {
    fn new(description: &Description, scene: String) -> Self {
        Self {
            preview: Preview::new(description),
            scene,
            layers: description.integrator.layers().to_vec(),
            effort: description.effort,
            status: Mutex::default(),
            has_ended: Condvar::new(),
            in_terminal: false,
            drawn: AtomicU64::new(0),
            said: Mutex::default(),
        }
    }

    /// Runs what writes lines to standard error.
    fn say<T>(&self, write: impl FnOnce() -> T) -> T {
        let mut said = self.said.lock().unwrap_or_else(PoisonError::into_inner);
        *said += 1;
        write()
    }

    /// Kept for a moment only: a render does without it meanwhile.
    fn status(&self) -> MutexGuard<'_, Status> {
        self.status.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Waits for so long, or until the render has ended; whether it has.
    fn wait(&self, time: Duration) -> bool {
        let waited =
            self.has_ended.wait_timeout_while(self.status(), time, |status| status.ended.is_none());
        waited.unwrap_or_else(PoisonError::into_inner).0.ended.is_some()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn viewers_have_names_and_places() {
        let tev = |address: &str| Ok(Viewer::Tev(address.to_owned()));
        assert_eq!("tev".parse(), tev("127.0.0.1:14158"));
        assert_eq!("tev:farm.example:1".parse(), tev("farm.example:1"));
        assert_eq!("tev:[::1]:14159".parse(), tev("[::1]:14159"));
        assert_eq!("terminal".parse(), Ok(Viewer::Terminal));
        assert_eq!("web".parse(), Ok(Viewer::Web(0)));
        assert_eq!("web:8080".parse(), Ok(Viewer::Web(8080)));
        for (bad, expected) in [
            ("tev:", "a host and a port"),
            ("tev:farm", "a host and a port"),
            ("tev::1", "a host and a port"),
            ("tev:farm:0", "a host and a port"),
            ("web:", "a port from 1 to 65535"),
            ("web:0", "a port from 1 to 65535"),
            ("web:65536", "a port from 1 to 65535"),
            ("", "tev, tev:HOST:PORT, web, web:PORT or terminal"),
            ("Web", "tev, tev:HOST:PORT, web, web:PORT or terminal"),
            ("terminal:1", "tev, tev:HOST:PORT, web, web:PORT or terminal"),
        ] {
            let refusal = bad.parse::<Viewer>().expect_err(bad);
            assert!(refusal.contains(expected), "{bad}: {refusal}");
        }
    }
}
