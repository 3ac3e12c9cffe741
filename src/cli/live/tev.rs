//! Pictures for the viewer tev, over TCP: https://github.com/Tom94/tev.

use std::io::{self, ErrorKind};
use std::net::{TcpStream, ToSocketAddrs};
use std::path::Path;
use std::time::{Duration, Instant};

use telamon::film::Crop;
use tev_client::{PacketCreateImage, PacketUpdateImage, TevClient};

use super::{Pace, Shared};

/// Where tev listens unless it is told otherwise.
pub(super) const DEFAULT: &str = "127.0.0.1:14158";

/// How long an attempt to connect takes at most, for each address of a name.
const CONNECTING: Duration = Duration::from_millis(500);
/// Time between attempts.
const AGAIN: Duration = Duration::from_secs(1);
/// How long a viewer may leave what is sent to it unread, before the connection is given up.
const UNREAD: Duration = Duration::from_secs(1);

/// Shows a render to its end, whenever there is a viewer.
pub(super) fn show(shared: &Shared, address: &str, warn: &dyn Fn(String)) {
    let mut has_warned = false;
    let mut connection: Option<Connection> = None;
    let mut pace = Pace::new();
    loop {
        // Before the look at the picture: what it has then is all of it.
        let has_ended = shared.wait(pace.left());
        let begin = Instant::now();
        let mut shown = Ok(Duration::ZERO);
        if connection.is_none() {
            shown = Connection::open(shared, address).map(|opened| {
                connection = Some(opened);
                Duration::ZERO
            });
        }
        if let Some(open) = &mut connection {
            shown = open.update(shared);
        }
        match shown {
            Ok(work) => pace.worked(begin, work),
            Err(error) => {
                // Half of something may have been sent.
                connection = None;
                pace.pause(AGAIN);
                if !has_warned {
                    has_warned = true;
                    warn(format!(
                        "tev does not take the picture at {address} ({error}); it gets it when it does"
                    ));
                }
            }
        }
        if has_ended {
            return;
        }
    }
}

/// An image in a viewer.
struct Connection {
    client: TevClient,
    /// The same, to see whether it is closed.
    socket: TcpStream,
    /// What the image is called there.
    name: String,
    channels: Vec<String>,
    /// Version of the picture that was sent last.
    since: u64,
}

impl Connection {
    fn open(shared: &Shared, address: &str) -> io::Result<Self> {
        let mut socket = Err(io::Error::new(ErrorKind::NotFound, "no such host"));
        for address in address.to_socket_addrs()? {
            socket = TcpStream::connect_timeout(&address, CONNECTING);
            if socket.is_ok() {
                break;
            }
        }
        let socket = socket?;
        socket.set_write_timeout(Some(UNREAD))?;
        socket.set_read_timeout(Some(Duration::from_millis(1)))?;
        socket.set_nodelay(true)?;
        let mut client = TevClient::wrap(socket.try_clone()?);
        // Of texts with zeros the protocol knows nothing.
        let text = |text: &str| text.replace('\0', "");
        let file = Path::new(&shared.scene).file_name().unwrap_or_default().to_string_lossy();
        let name = text(&file);
        let channels: Vec<_> = shared.preview.channels().iter().map(|c| text(c)).collect();
        let Crop { width, height, .. } = shared.preview.crop();
        client.send(PacketCreateImage {
            image_name: &name,
            grab_focus: true,
            width,
            height,
            channel_names: &channels,
        })?;
        Ok(Self { client, socket, name, channels, since: 0 })
    }

    /// Sends what is new; how much work it was.
    fn update(&mut self, shared: &Shared) -> io::Result<Duration> {
        self.check()?;
        let begin = Instant::now();
        let mut run = Run::default();
        let mut sent = Ok(());
        let Self { client, name, channels, .. } = self;
        let mut send = |run: &mut Run| {
            if !run.tiles.is_empty() && sent.is_ok() {
                sent = run.send(client, name, channels, shared.preview.crop());
            }
            run.tiles.clear();
        };
        let version = shared.preview.changes(self.since, |area, values| {
            if !run.is_continued_by(area) {
                send(&mut run);
            }
            run.tiles.push((area, values.to_vec()));
        });
        send(&mut run);
        sent?;
        self.since = version;
        Ok(begin.elapsed())
    }

    /// Whether the viewer is still there: it sends nothing, but an end may be seen.
    fn check(&self) -> io::Result<()> {
        match self.socket.peek(&mut [0]) {
            Ok(0) => Err(io::Error::new(ErrorKind::ConnectionAborted, "it was closed")),
            Err(e) if !matches!(e.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => Err(e),
            _ => Ok(()),
        }
    }
}

/// Neighbours in a row of tiles, which are sent as one.
#[derive(Default)]
struct Run {
    tiles: Vec<(Crop, Vec<f32>)>,
}

impl Run {
    fn is_continued_by(&self, next: Crop) -> bool {
        self.tiles.last().is_some_and(|(last, _)| last.y == next.y && last.x + last.width == next.x)
    }

    fn send(
        &self,
        client: &mut TevClient,
        name: &str,
        channels: &[String],
        crop: Crop,
    ) -> io::Result<()> {
        let first = self.tiles[0].0;
        let width: u32 = self.tiles.iter().map(|(area, _)| area.width).sum();
        let pixels = (width * first.height) as usize;
        // Channel by channel, row by row.
        let mut data = Vec::with_capacity(channels.len() * pixels);
        for channel in 0..channels.len() {
            for row in 0..first.height as usize {
                for (area, values) in &self.tiles {
                    let columns = area.width as usize;
                    let begin = (channel * area.height as usize + row) * columns;
                    data.extend_from_slice(&values[begin..][..columns]);
                }
            }
        }
        let offsets: Vec<_> = (0..channels.len() as u64).map(|c| c * pixels as u64).collect();
        client.send(PacketUpdateImage {
            image_name: name,
            grab_focus: false,
            channel_names: channels,
            channel_offsets: &offsets,
            channel_strides: &vec![1; channels.len()],
            x: first.x - crop.x,
            y: first.y - crop.y,
            width,
            height: first.height,
            data: &data,
        })
    }
}
