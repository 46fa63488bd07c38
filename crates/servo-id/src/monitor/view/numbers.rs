//! The newest values, and the estimates.

use drive_link::Estimates;
use identifier_core::parameters::Parameter;
use ratatui::style::{Color, Modifier, Style};
use ratatui::text::{Line, Span};

use super::NUMBERS;
use crate::monitor::frame::Frame;
use crate::monitor::state::State;
use crate::present::number::{DASH, figure, with_error};

/// Distance at which a command counts as at its limit, as a fraction of the range.
const AT_LIMIT: f64 = 1e-3;

/// Columns of a name.
const NAME: usize = 13;

pub(super) fn lines(state: &State) -> Vec<Line<'static>> {
    let newest = state.newest().map(|(_, frame)| frame);
    let mut lines = vec![
        value("position", newest.map(Frame::position), "rad"),
        value("reference", newest.and_then(Frame::reference), "rad"),
    ];
    lines.extend(command(newest, state.command_limit()));
    lines.push(value(
        "output error",
        newest.and_then(Frame::output_error),
        "rad",
    ));
    lines.push(Line::default());
    lines.extend(match newest {
        Some(Frame::Commissioning(progress)) if state.is_driven() => {
            let gain = progress
                .gain
                .map(|[b, error]| with_error(f64::from(b), Some(f64::from(error))));
            vec![
                heading("the drive's commissioning"),
                Line::from(format!("  {}", progress.phase.name())),
                Line::from(format!("  blocks recorded {}", progress.recorded)),
                Line::from(format!(
                    "b {}",
                    gain.unwrap_or_else(|| "not known yet".to_owned())
                )),
            ]
        }
        _ => {
            let mut lines = known(state.status().estimates.as_ref());
            let rejection_reason = state.status().rejection_reason;
            lines.extend(
                rejection_reason.map(|of| Line::from(format!("  no first fit: {}", of.name()))),
            );
            let noise = state.status().noise;
            lines.extend(noise.map(|noise| Line::from(format!("noise {noise:.2} counts"))));
            let change = state.status().servo_change.map(|change| change.reason);
            lines.extend(change.map(|of| Line::from(format!("  {} {}", of.number(), of.name()))));
            lines
        }
    });
    lines
}

fn heading(text: &'static str) -> Line<'static> {
    Line::styled(text, Style::new().add_modifier(Modifier::BOLD))
}

/// A value of nine columns with its sign, with a power of ten where it is small.
pub(super) fn signed(value: f64) -> String {
    if value != 0.0 && value.abs() < 1e-2 {
        format!("{value:+.2e}")
    } else {
        format!("{value:+.4}")
    }
}

fn value(name: &str, value: Option<f64>, unit: &str) -> Line<'static> {
    let text = value.map_or_else(|| DASH.to_owned(), signed);
    Line::from(format!("{name:<NAME$}{text:>9} {unit}"))
}

/// The command, and its position between its limits.
fn command(newest: Option<&Frame>, limit: Option<[f64; 2]>) -> [Line<'static>; 2] {
    let acting = newest.and_then(Frame::command);
    let number = value("command", acting, "u");
    let Some([low, high]) = limit.filter(|[low, high]| low < high) else {
        return [number, Line::from("  limits unknown")];
    };
    let width = usize::from(NUMBERS) - 2;
    let place = |command: f64| {
        let part = ((command - low) / (high - low)).clamp(0.0, 1.0);
        (part * (width - 1) as f64).round() as usize
    };
    let zero = place(0.0);
    let acts = acting.map_or(zero, place);
    let bar: String = (0..width)
        .map(|column| match column {
            _ if column == zero => '┃',
            _ if (zero.min(acts)..=zero.max(acts)).contains(&column) => '━',
            _ => '╌',
        })
        .collect();
    let near = AT_LIMIT * (high - low);
    let limited = acting.is_some_and(|acting| acting - low < near || high - acting < near);
    let style = if limited {
        Style::new().fg(Color::Red).add_modifier(Modifier::BOLD)
    } else {
        Style::default()
    };
    let number = if limited {
        Line::from(vec![
            Span::raw(format!("{:<NAME$}", "command")),
            Span::styled(
                format!("{:>9} AT LIMIT", signed(acting.unwrap_or(0.0))),
                style,
            ),
        ])
    } else {
        number
    };
    [number, Line::styled(format!("[{bar}]"), style)]
}

fn known(estimates: Option<&Estimates>) -> Vec<Line<'static>> {
    let title = heading("the drive's estimates");
    let Some(estimates) = estimates else {
        return vec![title, Line::from("  not known yet")];
    };
    let row = |(name, parameter, unit): (&str, Parameter, &str)| {
        let value = estimates.servo.get(parameter);
        let errors = estimates.standard_errors;
        let text = match estimates.at_bounds.get(parameter) {
            true => format!("{} (at a bound)", figure(value)),
            false => with_error(value, errors.map(|errors| errors.get(parameter))),
        };
        Line::from(format!("{name} {text} {unit}"))
    };
    let rows = [
        ("a", Parameter::A, "1/s"),
        ("b", Parameter::B, "rad/s²/u"),
        ("c", Parameter::Coulomb, "rad/s²"),
        ("d", Parameter::Load, "rad/s²"),
    ];
    [title].into_iter().chain(rows.map(row)).collect()
}

#[cfg(test)]
mod tests {
    use super::signed;

    #[test]
    fn a_small_value_has_a_power_of_ten() {
        assert_eq!(signed(-0.000_123), "-1.23e-4");
        assert_eq!(signed(0.0), "+0.0000");
    }
}
