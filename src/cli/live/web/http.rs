//! As much of HTTP/1.1 as a page on this machine needs: one question a connection, and no body.

use std::io::{self, Read, Write};
use std::net::TcpStream;
use std::time::{Duration, Instant};

/// Bytes of a question at most.
const MOST: usize = 16 << 10;

/// What is asked for.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Request {
    /// Before the question mark.
    pub(super) path: String,
    /// After it.
    query: String,
}

impl Request {
    /// A value of the query, as it is written there.
    pub(super) fn parameter(&self, name: &str) -> Option<&str> {
        let mut pairs = self.query.split('&').filter_map(|pair| pair.split_once('='));
        pairs.find(|(n, _)| *n == name).map(|(_, value)| value)
    }
}

/// Why a question is not answered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Refusal {
    /// It is none, or has not come in time.
    Malformed,
    /// It asks for another machine.
    OtherHost,
    /// There is nothing of the kind, or it is not told.
    NotFound,
    /// It wants to change something.
    OtherMethod,
}

/// Reads a question, which has so much time to come.
pub(super) fn read(stream: &mut TcpStream, time: Duration) -> Result<Request, Refusal> {
    let begin = Instant::now();
    let mut bytes = Vec::new();
    let mut part = [0; 2048];
    loop {
        if let Some(request) = parse(&bytes)? {
            return Ok(request);
        }
        let left = time.saturating_sub(begin.elapsed());
        if bytes.len() > MOST || left.is_zero() {
            return Err(Refusal::Malformed);
        }
        let malformed = |_: io::Error| Refusal::Malformed;
        stream.set_read_timeout(Some(left)).map_err(malformed)?;
        match stream.read(&mut part).map_err(malformed)? {
            0 => return Err(Refusal::Malformed),
            count => bytes.extend_from_slice(&part[..count]),
        }
    }
}

/// The question that `bytes` are; `None` if they are the beginning of one.
fn parse(bytes: &[u8]) -> Result<Option<Request>, Refusal> {
    let mut headers = [httparse::EMPTY_HEADER; 64];
    let mut request = httparse::Request::new(&mut headers);
    if request.parse(bytes).map_err(|_| Refusal::Malformed)?.is_partial() {
        return Ok(None);
    }
    let mut hosts = request.headers.iter().filter(|h| h.name.eq_ignore_ascii_case("host"));
    let host = hosts.next().and_then(|h| str::from_utf8(h.value).ok());
    if !host.is_some_and(is_here) || hosts.next().is_some() {
        return Err(Refusal::OtherHost);
    }
    if request.method != Some("GET") {
        return Err(Refusal::OtherMethod);
    }
    let target = request.path.unwrap_or_default();
    let (path, query) = target.split_once('?').unwrap_or((target, ""));
    Ok(Some(Request { path: path.to_owned(), query: query.to_owned() }))
}

/// Whether a host is a name of this machine for itself. The port may be another one where it is forwarded, as by
/// `ssh -L`.
fn is_here(host: &str) -> bool {
    let (name, port) = host.rsplit_once(':').unwrap_or((host, "80"));
    (name == "127.0.0.1" || name.eq_ignore_ascii_case("localhost")) && port.parse::<u16>().is_ok()
}

/// Writes what comes before a body of so many bytes.
pub(super) fn head(
    stream: &mut TcpStream,
    status: &str,
    kind: &str,
    length: usize,
) -> io::Result<()> {
    // The page has all in itself, and nothing of it is for others.
    let text = format!(
        "HTTP/1.1 {status}\r\n\
         Content-Type: {kind}\r\n\
         Content-Length: {length}\r\n\
         Connection: close\r\n\
         Cache-Control: no-store\r\n\
         Content-Security-Policy: default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; \
         connect-src 'self'; img-src data:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'\r\n\
         Cross-Origin-Resource-Policy: same-origin\r\n\
         Referrer-Policy: no-referrer\r\n\
         X-Content-Type-Options: nosniff\r\n\r\n"
    );
    stream.write_all(text.as_bytes())
}

/// Says why there is no answer.
pub(super) fn refuse(stream: &mut TcpStream, refusal: Refusal) -> io::Result<()> {
    let (status, text) = match refusal {
        Refusal::Malformed => ("400 Bad Request", "this is no question"),
        Refusal::OtherHost => ("403 Forbidden", "this is for 127.0.0.1 and localhost alone"),
        Refusal::NotFound => {
            ("404 Not Found", "telamon says the whole address on standard error; is it complete?")
        }
        Refusal::OtherMethod => ("405 Method Not Allowed\r\nAllow: GET", "there is only GET"),
    };
    head(stream, status, "text/plain; charset=utf-8", text.len())?;
    stream.write_all(text.as_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn get(target: &str, host: &str) -> Result<Option<Request>, Refusal> {
        parse(format!("GET {target} HTTP/1.1\r\n{host}\r\n\r\n").as_bytes())
    }

    #[test]
    fn questions_have_a_path_and_a_query() {
        let request = get("/abc/data?since=7&page=x", "Host: 127.0.0.1:8080").expect("well-formed");
        let request = request.expect("whole");
        assert_eq!(request.path, "/abc/data");
        assert_eq!(request.parameter("since"), Some("7"));
        assert_eq!(request.parameter("page"), Some("x"));
        assert_eq!(request.parameter("layer"), None);
        assert_eq!(parse(b"GET / HTTP/1.1\r\nHos"), Ok(None));
        assert_eq!(parse(b""), Ok(None));
    }

    #[test]
    fn other_hosts_are_refused() {
        for host in ["127.0.0.1:1", "localhost:65535", "LOCALHOST", "127.0.0.1"] {
            assert!(get("/", &format!("hOsT: {host}")).is_ok(), "{host}");
        }
        for header in [
            "Host: evil.example:8080",
            "Host: 127.0.0.1.evil.example",
            "Host: localhost:x",
            "Host: ",
            "Accept: */*",
            "Host: localhost\r\nHost: evil.example",
        ] {
            assert_eq!(get("/", header), Err(Refusal::OtherHost), "{header}");
        }
    }

    #[test]
    fn what_is_no_question_is_refused() {
        for bytes in
            [&b"\x16\x03\x01\x02\x00\x01"[..], b"GET /\x01 HTTP/1.1\r\n", b"GET / HTTP/9\r\n"]
        {
            assert_eq!(parse(bytes), Err(Refusal::Malformed), "{bytes:?}");
        }
        let posted = b"POST / HTTP/1.1\r\nHost: localhost\r\n\r\n";
        assert_eq!(parse(posted), Err(Refusal::OtherMethod));
    }
}
