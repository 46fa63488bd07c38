use std::io::{self, Read};
use std::net::{SocketAddr, TcpStream};

/// A request of a browser.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Request {
    /// The page.
    Page,
    /// Its changes.
    Changes,
    /// Anything else.
    Unknown,
    /// Under another machine's name: from a page elsewhere that would read this one.
    Foreign,
}

/// The largest request that is read, bytes.
const MAX_LENGTH: usize = 16 << 10;

/// Reads the request that a connection begins with.
///
/// # Errors
/// If it is none, too long, or the connection ends.
pub(super) fn read(stream: &mut TcpStream, own: SocketAddr) -> io::Result<Request> {
    let mut text = Vec::new();
    let mut part = [0; 1024];
    loop {
        let length = stream.read(&mut part)?;
        if length == 0 || text.len() > MAX_LENGTH {
            return Err(io::ErrorKind::InvalidData.into());
        }
        text.extend_from_slice(&part[..length]);
        if let Some(request) = parse(&text, own)? {
            return Ok(request);
        }
    }
}

/// The request, once it is whole.
fn parse(text: &[u8], own: SocketAddr) -> io::Result<Option<Request>> {
    let mut headers = [httparse::EMPTY_HEADER; 64];
    let mut request = httparse::Request::new(&mut headers);
    let status = request
        .parse(text)
        .map_err(|error| io::Error::new(io::ErrorKind::InvalidData, error))?;
    if status.is_partial() {
        return Ok(None);
    }
    let host = request
        .headers
        .iter()
        .find(|header| header.name.eq_ignore_ascii_case("host"))
        .map_or(&b""[..], |header| header.value);
    let names = [own.to_string(), format!("localhost:{}", own.port())];
    if names.iter().all(|name| name.as_bytes() != host) {
        return Ok(Some(Request::Foreign));
    }
    Ok(Some(match (request.method, request.path) {
        (Some("GET"), Some("/")) => Request::Page,
        (Some("GET"), Some("/changes")) => Request::Changes,
        _ => Request::Unknown,
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parsed(text: &str) -> Option<Request> {
        let own = SocketAddr::from(([127, 0, 0, 1], 8000));
        parse(text.as_bytes(), own).expect("a request")
    }

    #[test]
    fn a_page_and_its_changes_are_all_there_is() {
        let asked =
            |line: &str, host: &str| parsed(&format!("{line} HTTP/1.1\r\nHost: {host}\r\n\r\n"));
        for host in ["127.0.0.1:8000", "localhost:8000"] {
            assert_eq!(asked("GET /", host), Some(Request::Page));
            assert_eq!(asked("GET /changes", host), Some(Request::Changes));
            assert_eq!(asked("GET /../etc/passwd", host), Some(Request::Unknown));
            assert_eq!(asked("POST /", host), Some(Request::Unknown));
        }
        for host in ["example.org", "example.org:8000", "127.0.0.1:80", ""] {
            assert_eq!(asked("GET /", host), Some(Request::Foreign), "{host}");
        }
    }

    #[test]
    fn a_request_in_parts_is_waited_for() {
        assert_eq!(parsed("GET / HTTP/1.1\r\nHost: 127"), None);
        let own = SocketAddr::from(([127, 0, 0, 1], 8000));
        assert!(parse(b"\x16\x03\x01 no text", own).is_err());
    }
}
