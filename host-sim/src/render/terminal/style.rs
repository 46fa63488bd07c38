//! Colours of words on a terminal. Whoever writes them leaves them out where they are not shown.

use anstyle::{AnsiColor, Style};

use crate::analysis::Status;

/// Of what failed.
pub const FAULT: Style = AnsiColor::Red.on_default().bold();
/// Of what is not as it should be.
pub const WARNING: Style = AnsiColor::Yellow.on_default().bold();
/// Of what is as it should be.
const GOOD: Style = AnsiColor::Green.on_default().bold();

const STATUSES: [Status; 5] = [
    Status::Converged,
    Status::Unexplained,
    Status::NoInformation,
    Status::Moving,
    Status::Aborted,
];

/// The name of a status.
#[must_use]
pub fn status(status: Status) -> String {
    let style = match status {
        Status::Converged => GOOD,
        Status::Aborted => FAULT,
        _ => WARNING,
    };
    format!("{style}{}{style:#}", status.name())
}

/// The word that goes before what is not as it should be.
#[must_use]
pub fn warning() -> String {
    format!("{WARNING}warning:{WARNING:#}")
}

/// A row of a table, whose last word may be a status.
pub(crate) fn row(line: &str) -> String {
    let known = STATUSES.into_iter().find_map(|known| {
        let before = line.strip_suffix(known.name())?;
        Some(format!("{before}{}", status(known)))
    });
    known.unwrap_or_else(|| line.to_owned())
}
