//! The lines above and below the charts: state, telemetry, question and keys.

use drive_link::State as Does;
use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::{Color, Modifier, Style};
use ratatui::text::{Line, Span};
use ratatui::widgets::{Paragraph, Wrap};

use super::Shown;
use crate::monitor::dialogue::{Dialogue, Motion, number};
use crate::monitor::state::{Note, State};

const BAD: Style = Style::new().fg(Color::Red).add_modifier(Modifier::BOLD);
const BOLD: Style = Style::new().add_modifier(Modifier::BOLD);

pub(super) fn head(frame: &mut Frame<'_>, area: Rect, state: &State) {
    let (name, style) = match state.status().state {
        Does::Disabled => ("DISABLED", Style::new()),
        Does::Running => ("RUNNING", Style::new().fg(Color::Green)),
        Does::Commissioning => ("COMMISSIONING", Style::new().fg(Color::Yellow)),
        Does::Faulted(_) => ("FAULT", Style::new().fg(Color::Red)),
    };
    let mut spans = vec![Span::styled(
        format!(" {name} "),
        style.add_modifier(Modifier::REVERSED | Modifier::BOLD),
    )];
    if let Some((time, _)) = state.newest().filter(|_| state.is_driven()) {
        spans.push(Span::raw(format!(" for {time:.1} s")));
    }
    let port = Line::from(state.port.as_str());
    let [left, right] = Layout::horizontal([
        Constraint::Min(0),
        Constraint::Length((port.width() as u16).min(area.width / 2)),
    ])
    .areas(area);
    frame.render_widget(Line::from(spans), left);
    frame.render_widget(port.right_aligned(), right);
}

/// Received and lost frames, and the recording.
pub(super) fn telemetry(shown: &Shown<'_>) -> Line<'static> {
    let telemetry = shown.state.telemetry();
    let every = match telemetry.samples_apart() {
        1 => "every sample".to_owned(),
        apart => format!("every {apart} samples"),
    };
    let mut spans = vec![Span::raw(format!(
        "{} frames ({every}), ",
        telemetry.frames()
    ))];
    spans.push(match telemetry.lost() {
        0 => Span::raw("none lost"),
        lost => Span::styled(
            match shown.state.dropped() {
                0 => format!("{lost} LOST"),
                dropped => format!("{lost} LOST, {dropped} dropped by a full line"),
            },
            BAD,
        ),
    });
    if let Some((name, rows)) = shown.recording {
        spans.push(Span::raw("; "));
        spans.push(Span::styled(format!("recording {name}, {rows} rows"), BOLD));
    }
    Line::from(spans)
}

/// The open question, or else the last message.
pub(super) fn prompt(shown: &Shown<'_>) -> Paragraph<'static> {
    let line = match shown.dialogue {
        Dialogue::Confirm(Motion::Start) => Line::styled(
            "Close the loop at the present position and identify: y starts, any other key cancels.",
            BOLD,
        ),
        Dialogue::Confirm(Motion::Commission) => Line::styled(
            match shown.commission {
                Some(most) => format!("{most} y commissions, any other key cancels."),
                None => {
                    "No limits for a commissioning: start the monitor with --scenario.".to_owned()
                }
            },
            BOLD,
        ),
        Dialogue::Target(typed) => {
            let wrong = !typed.is_empty() && number(typed).is_none();
            Line::styled(
                format!(
                    "Target, rad from the start: {typed}_{} Enter sends it, Esc cancels.",
                    if wrong { " (not a number)" } else { "" }
                ),
                BOLD,
            )
        }
        Dialogue::Quit if shown.leaves => Line::styled(
            "The servo is driven, and stays driven without the monitor: y leaves, any other key stays.",
            BOLD,
        ),
        Dialogue::Quit => Line::styled(
            "The servo is driven. Leaving disables it: y leaves, any other key stays.",
            BOLD,
        ),
        Dialogue::Idle => match shown.state.note() {
            Some(Note::Done(text)) => Line::from(text.clone()),
            Some(Note::Failed(text)) => Line::styled(text.clone(), BAD),
            None => Line::default(),
        },
    };
    Paragraph::new(line).wrap(Wrap { trim: true })
}

/// The keys.
pub(super) fn help() -> Line<'static> {
    let mut spans = Vec::new();
    for (key, what) in [
        ("s", "start"),
        ("Space", "stop"),
        ("t", "target"),
        ("c", "commission"),
        ("a", "abort"),
        ("f", "clear"),
        ("k", "keep"),
        ("r", "record"),
        ("q", "quit"),
    ] {
        spans.push(Span::styled(key, BOLD.add_modifier(Modifier::REVERSED)));
        spans.push(Span::raw(format!(" {what} ")));
    }
    Line::from(spans)
}
