//! Colours of words on a terminal. The writer leaves them out where they are not shown.

use anstyle::{AnsiColor, Style};
use identifier_log::verdict::Status;

use crate::present::Tone;

/// Of what failed.
pub const FAULT: Style = AnsiColor::Red.on_default().bold();
/// Style of a fault.
pub const WARNING: Style = AnsiColor::Yellow.on_default().bold();
/// Style of the expected state.
const GOOD: Style = AnsiColor::Green.on_default().bold();

const STATUSES: [Status; 6] = [
    Status::Converged,
    Status::Partial,
    Status::Unexplained,
    Status::NoInformation,
    Status::Moving,
    Status::Aborted,
];

/// The name of a status, in the colour of its tone.
#[must_use]
pub fn status(name: &str, tone: Tone) -> String {
    let style = match tone {
        Tone::Good => GOOD,
        Tone::Failed => FAULT,
        Tone::Doubtful => WARNING,
    };
    format!("{style}{name}{style:#}")
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
        Some(format!("{before}{}", status(known.name(), known.into())))
    });
    known.unwrap_or_else(|| line.to_owned())
}
