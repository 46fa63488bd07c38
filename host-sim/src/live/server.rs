use std::io::{self, Write};
use std::net::{Ipv4Addr, SocketAddr, TcpListener, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;
use std::time::Duration;

use super::board::{Board, Update};
use super::request::{self, Request};

/// Browsers that are served at once.
const MAX_BROWSERS: usize = 32;

/// Silence after which a connection is closed.
const PATIENCE: Duration = Duration::from_secs(10);

/// Time without a change after which a browser gets a sign of life.
const QUIET: Duration = Duration::from_secs(5);

/// A server on the loopback address, which this machine alone can reach. It ends with the program.
#[derive(Debug)]
pub struct Server {
    address: SocketAddr,
    board: Arc<Board>,
}

impl Server {
    /// Serves on a port; on any that is free for 0.
    ///
    /// # Errors
    /// If the port is in use, or may not be used.
    pub fn start(port: u16) -> io::Result<Self> {
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port))?;
        let address = listener.local_addr()?;
        let board = Arc::new(Board::default());
        let shared = Arc::clone(&board);
        thread::Builder::new()
            .name("live".to_owned())
            .spawn(move || accept(&listener, address, &shared))?;
        Ok(Self { address, board })
    }

    /// Its address.
    #[must_use]
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// Shows a page as it is now.
    pub fn show(&self, update: Update) {
        self.board.put(update);
    }
}

fn accept(listener: &TcpListener, own: SocketAddr, board: &Arc<Board>) {
    let served = Arc::new(AtomicUsize::new(0));
    for stream in listener.incoming().flatten() {
        if served.fetch_add(1, Ordering::Relaxed) >= MAX_BROWSERS {
            served.fetch_sub(1, Ordering::Relaxed);
            continue;
        }
        let (board, count) = (Arc::clone(board), Arc::clone(&served));
        let begun = thread::Builder::new().spawn(move || {
            // A browser may go away at any time.
            let _ = serve(stream, own, &board);
            count.fetch_sub(1, Ordering::Relaxed);
        });
        if begun.is_err() {
            served.fetch_sub(1, Ordering::Relaxed);
        }
    }
}

fn serve(mut stream: TcpStream, own: SocketAddr, board: &Board) -> io::Result<()> {
    stream.set_read_timeout(Some(PATIENCE))?;
    stream.set_write_timeout(Some(PATIENCE))?;
    match request::read(&mut stream, own)? {
        Request::Page => match board.after(0, PATIENCE) {
            Some((_, update)) => answer(&mut stream, "200 OK", "text/html", &update.page),
            None => answer(
                &mut stream,
                "503 Service Unavailable",
                "text/plain",
                "not yet\n",
            ),
        },
        Request::Changes => changes(&mut stream, board),
        Request::Unknown => answer(&mut stream, "404 Not Found", "text/plain", "not here\n"),
        Request::Foreign => answer(&mut stream, "403 Forbidden", "text/plain", "not for you\n"),
    }
}

fn answer(stream: &mut TcpStream, status: &str, kind: &str, text: &str) -> io::Result<()> {
    write!(
        stream,
        "HTTP/1.1 {status}\r\nContent-Type: {kind}; charset=utf-8\r\nContent-Length: {}\r\n\
         Cache-Control: no-store\r\nConnection: close\r\n\r\n",
        text.len()
    )?;
    stream.write_all(text.as_bytes())
}

/// Server-sent events: every change, as soon as the one before is through.
fn changes(stream: &mut TcpStream, board: &Board) -> io::Result<()> {
    stream.write_all(
        b"HTTP/1.1 200 OK\r\nContent-Type: text/event-stream\r\nCache-Control: no-store\r\n\
          Connection: close\r\n\r\n",
    )?;
    let mut shown = 0;
    loop {
        match board.after(shown, QUIET) {
            Some((number, update)) => {
                write!(stream, "data: {}\n\n", update.change)?;
                shown = number;
            }
            None => stream.write_all(b":\n\n")?,
        }
    }
}
