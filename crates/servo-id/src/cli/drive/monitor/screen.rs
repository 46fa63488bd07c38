//! The terminal, restored however the program ends.

use std::io::{self, IsTerminal};
use std::time::Duration;

use ratatui::DefaultTerminal;
use ratatui::crossterm::event::{self, Event, KeyEvent, KeyEventKind};

use crate::cli::fault::Fault;
use crate::monitor::{Shown, draw};

/// A terminal that shows a drive.
pub(super) struct Screen(DefaultTerminal);

/// # Errors
/// If there is no terminal.
pub(super) fn must_be_there() -> Result<(), Fault> {
    let dumb = std::env::var_os("TERM").is_some_and(|kind| kind == "dumb");
    if io::stdin().is_terminal() && io::stdout().is_terminal() && !dumb {
        return Ok(());
    }
    Err(Fault::Input(
        "the monitor needs a terminal to draw on and to read keys from; without one, `drive watch` lists \
         what the drive reports, and `drive start`, `target` and `stop` operate it"
            .to_owned(),
    ))
}

/// A terminal that is lost.
pub(super) fn fault(error: &io::Error) -> Fault {
    Fault::unwritable("the terminal", error)
}

impl Screen {
    /// Takes the terminal; a panic restores it before its message.
    pub(super) fn open() -> Result<Self, Fault> {
        ratatui::try_init().map(Self).map_err(|error| fault(&error))
    }

    /// Draws.
    pub(super) fn show(&mut self, shown: &Shown<'_>) -> io::Result<()> {
        self.0.draw(|frame| draw(frame, shown)).map(drop)
    }

    /// A key, if one is pressed within a time.
    pub(super) fn key(&mut self, patience: Duration) -> io::Result<Option<KeyEvent>> {
        if !event::poll(patience)? {
            return Ok(None);
        }
        Ok(match event::read()? {
            Event::Key(key) if key.kind != KeyEventKind::Release => Some(key),
            // The next drawing queries the size itself.
            _ => None,
        })
    }
}

impl Drop for Screen {
    fn drop(&mut self) {
        // No other terminal could show the error.
        let _ = ratatui::try_restore();
    }
}
