//! Standard output.

use std::fmt;
use std::io::{self, ErrorKind, Write};
use std::sync::atomic::{AtomicBool, Ordering};

use super::fault::Fault;
use super::terminal::folded;

/// `println!` that returns a fault where standard output cannot be written.
macro_rules! show {
    ($($text:tt)*) => {
        $crate::cli::standard_output::line(format_args!($($text)*))
    };
}
pub(super) use show;

/// Only errors and requested results are printed.
static QUIET: AtomicBool = AtomicBool::new(false);

/// From now on, only errors and requested results are printed.
pub(super) fn be_quiet() {
    QUIET.store(true, Ordering::Relaxed);
}

/// Only errors and requested results are printed.
pub(super) fn is_quiet() -> bool {
    QUIET.load(Ordering::Relaxed)
}

/// Prints text, with colours where they are supported and folded to the width of the terminal; nothing with
/// `--quiet`.
pub(super) fn line(text: fmt::Arguments<'_>) -> Result<(), Fault> {
    if is_quiet() {
        return Ok(());
    }
    result(format_args!("{}", folded(&text.to_string())))
}

/// Prints a requested result, also with `--quiet`.
pub(super) fn result(text: fmt::Arguments<'_>) -> Result<(), Fault> {
    // In one piece, and not piece by piece as the text is made.
    written(anstream::stdout().write_all(format!("{text}\n").as_bytes()))
}

/// Flushes standard output.
pub(super) fn flush() -> Result<(), Fault> {
    written(io::stdout().flush())
}

/// Distinguishes a standard output that fails from a reader that has gone away.
pub(super) fn written(result: io::Result<()>) -> Result<(), Fault> {
    match result {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(Fault::unwritable("standard output", &error))
        }
        _ => Ok(()),
    }
}

/// A writer whose reader may close the pipe early, which is no error.
#[derive(Debug)]
pub(super) struct UntilClosed<W>(pub(super) W);

impl<W: Write> Write for UntilClosed<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match self.0.write(bytes) {
            Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(bytes.len()),
            done => done,
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        match self.0.flush() {
            Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(()),
            done => done,
        }
    }
}
