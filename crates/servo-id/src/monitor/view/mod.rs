//! The drawing of a drive's state.

mod charts;
mod lines;
mod numbers;

use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect, Size};
use ratatui::text::Line;
use ratatui::widgets::{Paragraph, Wrap};

use super::dialogue::Dialogue;
use super::state::State;

/// Smallest screen, columns and rows.
pub const MIN_SIZE: Size = Size {
    width: 80,
    height: 24,
};

/// Columns of the numbers beside the charts.
const NUMBERS: u16 = 31;

/// The contents of a screen.
#[derive(Debug, Clone, Copy)]
pub struct Shown<'a> {
    /// The drive's state.
    pub state: &'a State,
    /// The open question.
    pub dialogue: &'a Dialogue,
    /// The file of the recording, and its rows so far.
    pub recording: Option<(&'a str, u64)>,
    /// The largest motion of a commissioning, in words, if one can be started.
    pub commission: Option<&'a str>,
    /// The drive stays running at the end.
    pub leaves: bool,
}

/// Draws a screen.
pub fn draw(frame: &mut Frame<'_>, shown: &Shown<'_>) {
    let area = frame.area();
    if area.width < MIN_SIZE.width || area.height < MIN_SIZE.height {
        return too_small(frame, area, shown);
    }
    let [head, reason, body, telemetry, prompt, help] = Layout::vertical([
        Constraint::Length(1),
        Constraint::Length(2),
        Constraint::Min(0),
        Constraint::Length(1),
        Constraint::Length(2),
        Constraint::Length(1),
    ])
    .areas(area);
    let [signals, numbers] = Layout::horizontal([Constraint::Min(0), Constraint::Length(NUMBERS)])
        .spacing(1)
        .areas(body);
    lines::head(frame, head, shown.state);
    frame.render_widget(wrapped(shown.state.reason()), reason);
    charts::draw(frame, signals, shown.state);
    frame.render_widget(Paragraph::new(numbers::lines(shown.state)), numbers);
    frame.render_widget(lines::telemetry(shown), telemetry);
    frame.render_widget(lines::prompt(shown), prompt);
    frame.render_widget(lines::help(), help);
}

fn wrapped(text: String) -> Paragraph<'static> {
    Paragraph::new(text).wrap(Wrap { trim: true })
}

fn too_small(frame: &mut Frame<'_>, area: Rect, shown: &Shown<'_>) {
    let text = vec![
        Line::from(format!(
            "{} x {} is too small for the monitor:",
            area.width, area.height
        )),
        Line::from(format!(
            "it needs {} x {}; make the window larger.",
            MIN_SIZE.width, MIN_SIZE.height
        )),
        Line::from(if shown.state.is_driven() {
            "The servo is driven: Space stops it, q leaves."
        } else {
            "The servo is disabled; q leaves."
        }),
    ];
    frame.render_widget(Paragraph::new(text).wrap(Wrap { trim: true }), area);
}
