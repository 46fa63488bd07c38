//! The signals of the last seconds.

use drive_link::State as Does;
use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::{Color, Style};
use ratatui::symbols::Marker;
use ratatui::text::{Line, Span};
use ratatui::widgets::{Axis, Block, Borders, Chart, Dataset, GraphType};

use super::numbers::signed;
use crate::monitor::history::{LENGTH, Signal};
use crate::monitor::state::State;
use crate::present::number::plain;

/// Colours that everyone can distinguish, on every terminal.
const MEASURED: Style = Style::new().fg(Color::Cyan);
const WANTED: Style = Style::new().fg(Color::Yellow);

/// Margin beyond the extremes, as a fraction of the range.
const MARGIN: f64 = 0.05;

pub(super) fn draw(frame: &mut Frame<'_>, area: Rect, state: &State) {
    let [motion, command, error] = Layout::vertical([
        Constraint::Fill(5),
        Constraint::Fill(4),
        Constraint::Fill(4),
    ])
    .areas(area);
    let position = state.history.signal(Signal::Position);
    let reference = state.history.signal(Signal::Reference);
    let mut title = vec![Span::styled("position", MEASURED)];
    if !reference.is_empty() {
        title.push(Span::raw(" (line), "));
        title.push(Span::styled("reference", WANTED));
        title.push(Span::raw(" (dots)"));
    }
    title.push(Span::raw(" [rad]"));
    chart(
        frame,
        motion,
        Line::from(title),
        &position,
        &reference,
        None,
    );
    let acting = state.history.signal(Signal::Command);
    let is_disabled = matches!(state.status().state, Does::Disabled | Does::Faulted(_));
    let title = match (state.command_limit(), is_disabled) {
        (_, true) => "command [u], now disabled".to_owned(),
        (Some([low, high]), false) => {
            format!("command [u], limits {} to {}", plain(low), plain(high))
        }
        (None, false) => "command [u]".to_owned(),
    };
    chart(
        frame,
        command,
        Line::from(title),
        &acting,
        &[],
        state.command_limit(),
    );
    let output_error = state.history.signal(Signal::OutputError);
    chart(
        frame,
        error,
        Line::from(format!("output error [rad], last {LENGTH} s")),
        &output_error,
        &[],
        None,
    );
}

/// Signals over the last seconds, a line and dots; without limits their own extremes bound what is seen of them.
fn chart(
    frame: &mut Frame<'_>,
    area: Rect,
    title: Line<'_>,
    measured: &[(f64, f64)],
    wanted: &[(f64, f64)],
    limits: Option<[f64; 2]>,
) {
    let bounds = limits.unwrap_or_else(|| extremes(measured.iter().chain(wanted)));
    let datasets = [
        (wanted, Marker::Dot, GraphType::Scatter, WANTED),
        (measured, Marker::Braille, GraphType::Line, MEASURED),
    ];
    let datasets = datasets.map(|(points, marker, kind, style)| {
        let drawn = Dataset::default().marker(marker).graph_type(kind);
        drawn.style(style).data(points)
    });
    let [low, high] = bounds;
    let label = |value: f64| format!("{:>9}", signed(value));
    let chart = Chart::new(datasets.into())
        .block(Block::new().borders(Borders::TOP).title(title))
        .legend_position(None)
        .x_axis(Axis::default().bounds([-LENGTH, 0.0]))
        .y_axis(
            Axis::default()
                .bounds(bounds)
                .labels([label(low), label(high)]),
        );
    frame.render_widget(chart, area);
}

/// A range that holds all values, with a margin.
fn extremes<'a>(points: impl Iterator<Item = &'a (f64, f64)>) -> [f64; 2] {
    let [low, high] = points.fold(
        [f64::INFINITY, f64::NEG_INFINITY],
        |[low, high], (_, value)| [low.min(*value), high.max(*value)],
    );
    if low > high {
        return [-1.0, 1.0];
    }
    // A constant is a line in the middle.
    let margin = (MARGIN * (high - low)).max(1e-6 * (1.0 + high.abs()));
    [low - margin, high + margin]
}
