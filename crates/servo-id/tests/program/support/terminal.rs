//! A pseudo-terminal: keys typed, the screen read.

use std::io::{Read, Write};
use std::num::NonZero;
use std::path::Path;
use std::sync::{Arc, Mutex};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use portable_pty::{Child, CommandBuilder, MasterPty, PtySize, native_pty_system};

/// Longest wait for a text on the screen: this machine may be busy.
const TIMEOUT: Duration = Duration::from_secs(60);

/// A terminal with a program in it.
pub(crate) struct Terminal {
    master: Box<dyn MasterPty + Send>,
    keyboard: Box<dyn Write + Send>,
    screen: Arc<Mutex<vt100::Parser>>,
    /// Ends with the program, once all that it has printed is on the screen.
    reader: JoinHandle<()>,
    child: Box<dyn Child + Send + Sync>,
    /// The terminal's settings before.
    before: String,
}

impl Terminal {
    /// Starts a program in a folder, in a terminal of `columns` by `rows`.
    pub(crate) fn start(command: &[&str], folder: &Path, columns: u16, rows: u16) -> Self {
        let pair = native_pty_system()
            .openpty(size(columns, rows))
            .expect("a pseudo-terminal");
        let before = settings(pair.master.as_ref());
        let mut builder = CommandBuilder::new(command[0]);
        builder.args(&command[1..]);
        builder.cwd(folder);
        builder.env("TERM", "xterm-256color");
        let child = pair.slave.spawn_command(builder).expect("it starts");
        let screen = Arc::new(Mutex::new(vt100::Parser::new(some(rows), some(columns), 0)));
        let seen = Arc::clone(&screen);
        let mut output = pair.master.try_clone_reader().expect("a terminal");
        let reader = thread::spawn(move || {
            let mut bytes = [0; 4096];
            while let Ok(read @ 1..) = output.read(&mut bytes) {
                seen.lock()
                    .expect("no thread panicked")
                    .process(&bytes[..read]);
            }
        });
        Self {
            keyboard: pair.master.take_writer().expect("a terminal"),
            master: pair.master,
            screen,
            reader,
            child,
            before,
        }
    }

    /// Presses keys.
    pub(crate) fn types(&mut self, keys: &str) {
        self.keyboard
            .write_all(keys.as_bytes())
            .and_then(|()| self.keyboard.flush())
            .expect("the channel is read");
    }

    /// The screen's text.
    pub(crate) fn text(&self) -> String {
        let screen = self.screen.lock().expect("no thread panicked");
        screen.screen().contents()
    }

    /// True if anything on the screen has a colour.
    pub(crate) fn is_coloured(&self) -> bool {
        let screen = self.screen.lock().expect("no thread panicked");
        let screen = screen.screen();
        let (rows, columns) = screen.size();
        let mut places =
            (0..rows.get()).flat_map(|row| (0..columns.get()).map(move |at| (row, at)));
        places.any(|(row, column)| {
            let cell = screen.cell(row, column);
            cell.is_some_and(|cell| cell.fgcolor() != vt100::Color::Default)
        })
    }

    /// Types an answer once this is on the screen and a whole question is its end: the echo of an earlier key would
    /// stand within it.
    pub(crate) fn answers(&mut self, asked: &str, answer: &str) {
        self.waits(asked, |text| {
            text.contains(asked) && text.trim_end().ends_with(':')
        });
        self.types(&format!("{answer}\r"));
    }

    /// Waits until this is on the screen, and answers with the whole of it.
    pub(crate) fn shows(&mut self, wanted: &str) -> String {
        self.waits(wanted, |text| text.contains(wanted))
    }

    fn waits(&mut self, wanted: &str, is_there: impl Fn(&str) -> bool) -> String {
        let until = Instant::now() + TIMEOUT;
        loop {
            let text = self.text();
            if is_there(&text) {
                return text;
            }
            assert!(
                Instant::now() < until,
                "{wanted:?} is not to be seen, ended: {:?}\n{text}",
                self.child.try_wait()
            );
            thread::sleep(Duration::from_millis(20));
        }
    }

    /// Waits for the program to end: its status, and what is on the screen then. The terminal must be as
    /// it was.
    pub(crate) fn ends(mut self) -> (u32, String) {
        let until = Instant::now() + TIMEOUT;
        let status = loop {
            match self.child.try_wait().expect("it is a child") {
                Some(status) => break status.exit_code(),
                None => assert!(Instant::now() < until, "it goes on\n{}", self.text()),
            }
            thread::sleep(Duration::from_millis(20));
        };
        // Its last output is on its way.
        while !self.reader.is_finished() {
            assert!(Instant::now() < until, "the terminal stays open");
            thread::sleep(Duration::from_millis(20));
        }
        assert_eq!(settings(self.master.as_ref()), self.before);
        let screen = self.screen.lock().expect("no thread panicked");
        let screen = screen.screen();
        assert!(!screen.alternate_screen(), "it is not given back");
        assert!(!screen.hide_cursor(), "the cursor is hidden");
        (status, screen.contents())
    }
}

fn some(length: u16) -> NonZero<u16> {
    NonZero::new(length).expect("a terminal has rows and columns")
}

fn size(columns: u16, rows: u16) -> PtySize {
    PtySize {
        rows,
        cols: columns,
        pixel_width: 0,
        pixel_height: 0,
    }
}

/// A terminal's settings: echo, wait for a line, signals from keys.
#[cfg(unix)]
fn settings(master: &dyn MasterPty) -> String {
    format!("{:?}", master.get_termios())
}

#[cfg(not(unix))]
fn settings(_: &dyn MasterPty) -> String {
    String::new()
}
