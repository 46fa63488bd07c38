//! The motion beside its command: sign, columns, noise, directions.

use identifier_core::parameters::Parameter;

use super::remark::{Remark, RemarkKind};
use super::weak_form::{Beside, Order, Response, Signals, responses};
use crate::log::{Log, Segment};
use crate::scenario::Scenario;

/// Standard errors from which a gain has a sign.
const CLEAR: f64 = 8.0;
/// Standard errors below which, at every width of the window, a command has no effect.
const NONE: f64 = 4.5;
/// The part that the right input explains of a motion well above its noise.
const NEARLY_ALL: f64 = 0.8;

/// A column by what it is stated to hold.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Of {
    Position,
    Command,
    Reference,
}

impl Of {
    fn samples(self, segment: &Segment) -> &[f64] {
        match self {
            Self::Position => &segment.positions,
            Self::Command => &segment.commands,
            Self::Reference => &segment.references,
        }
    }

    /// True if the log has it.
    fn is_in(self, log: &Log) -> bool {
        log.segments()
            .iter()
            .all(|segment| !self.samples(segment).is_empty())
    }
}

/// The findings about the motion of a log, at most one about its command.
pub(super) fn remarks(scenario: &Scenario, log: &Log) -> Vec<Remark> {
    if let Some(remark) = without_motion(log) {
        return vec![remark];
    }
    let mut remarks = Vec::new();
    remarks.extend(command(scenario, log));
    remarks.extend(direction(scenario, log));
    remarks
}

/// A position that shows no motion.
fn without_motion(log: &Log) -> Option<Remark> {
    /// Deviation of the position, of its noise, below which nothing is known to move.
    const MIN_MOTION: f64 = 2.0;
    let noise = noise(log, Of::Position);
    let deviation = deviation(log, Of::Position);
    (deviation < MIN_MOTION * noise).then(|| {
        let text = format!(
            "the position shows noise of {noise:.3e} rad rms and no motion above it ({deviation:.3e} rad rms): let the \
             servo move further, or state the column of the measured position as log.position"
        );
        Remark::refusing(RemarkKind::NoiseAlone, text)
    })
}

/// The recorded command beside the motion.
fn command(scenario: &Scenario, log: &Log) -> Option<Remark> {
    if !Of::Command.is_in(log) || !scenario.identifier.parameters.contains(&Parameter::B) {
        return None;
    }
    if let Some(remark) = ramp(log) {
        return Some(remark);
    }
    let (low, high) = log
        .segments()
        .iter()
        .fold(crate::log::extremes(&[]), |(low, high), of| {
            let (lowest, highest) = crate::log::extremes(&of.commands);
            (low.min(lowest), high.max(highest))
        });
    if low >= high {
        let text = format!(
            "the command is {low} in all samples: state the column of the command that acted as log.command, or let it \
             change"
        );
        return Some(Remark::refusing(RemarkKind::NoEffect, text));
    }
    let plain = respond(
        log,
        Of::Position,
        Of::Command,
        Order::Second,
        Beside::Nothing,
    );
    let beside_place = respond(log, Of::Position, Of::Command, Order::Second, Beside::Place);
    wrong_column(log, &plain, &beside_place)
        .or_else(|| reversed(log, &plain, &beside_place))
        .or_else(|| without_effect(&plain, &beside_place))
}

/// A column that advances by the same step in every row.
fn ramp(log: &Log) -> Option<Remark> {
    /// Deviation of the steps, of their mean.
    const MAX_DEVIATION: f64 = 1e-3;
    let columns = [
        (Of::Position, "position", &log.settings().position),
        (Of::Command, "command", log.settings().command.as_ref()?),
    ];
    columns.into_iter().find_map(|(of, name, column)| {
        let (mut count, mut sum, mut squares) = (0.0, 0.0, 0.0);
        for segment in log.segments() {
            for pair in of.samples(segment).windows(2) {
                let step = pair[1] - pair[0];
                count += 1.0;
                sum += step;
                squares += step * step;
            }
        }
        let mean: f64 = sum / count;
        let deviation = (squares / count - mean * mean).max(0.0).sqrt();
        (deviation < MAX_DEVIATION * mean.abs()).then(|| {
            let text = format!(
                "the {name} advances by the same step in every row, as a time or a counter does: state its column as \
                 log.{name}, where {column} stands"
            );
            Remark::refusing(RemarkKind::WrongColumn, text)
        })
    })
}

/// A reading of the columns that explains the motion where the stated one does not.
fn wrong_column(log: &Log, plain: &[Response], beside_place: &[Response]) -> Option<Remark> {
    /// The residual of the stated reading over that of another one from which the other is right.
    const CLEARLY_MORE: f64 = 4.0;
    let is_clearer = |found: Vec<Response>, stated: f64| {
        best(&found).is_some_and(|found| {
            found.gain > 0.0
                && found.significance > CLEAR
                && found.explained > NEARLY_ALL
                && CLEARLY_MORE * (1.0 - found.explained) < 1.0 - stated
        })
    };
    // The weight of a link may explain what its command does not.
    let alone = best(plain).map_or(0.0, |of| of.explained);
    let with_place = best(beside_place).map_or(0.0, |of| of.total);
    let explains = |position: Of, command: Of, order: Order| {
        let is_there = position.is_in(log) && command.is_in(log);
        is_there
            && is_clearer(
                respond(log, position, command, order, Beside::Nothing),
                alone.max(with_place),
            )
    };
    let settings = log.settings();
    let [position, command] = [Some(&settings.position), settings.command.as_ref()]
        .map(|column| column.map_or(String::new(), ToString::to_string));
    let reference = settings
        .reference
        .as_ref()
        .map_or(String::new(), ToString::to_string);
    let text = if explains(Of::Command, Of::Position, Order::Second) {
        format!(
            "position and command seem to be exchanged: state log.position = \"{command}\" and log.command = \
             \"{position}\""
        )
    } else if explains(Of::Reference, Of::Command, Order::Second) {
        format!(
            "the command moves the reference and not the position, so they seem to be exchanged: state log.position = \
             \"{reference}\" and log.reference = \"{position}\""
        )
    } else if explains(Of::Reference, Of::Position, Order::Second) {
        format!(
            "position, command and reference seem to be exchanged: state log.position = \"{reference}\" and \
             log.command = \"{position}\""
        )
    } else if explains(Of::Position, Of::Reference, Order::Second) {
        format!(
            "command and reference seem to be exchanged: state log.command = \"{reference}\" and log.reference = \
             \"{command}\""
        )
    } else if is_clearer(respond_to_error(log), alone) {
        format!(
            "the position follows the column {command} as it follows a reference: state the column of the command that \
             acted as log.command; or, if this is the goal of a servo with a position loop of its own, as log.reference with \
             inner.kp, the gain of that loop; or log.scan = \"warn\" where a spring or a weight holds it there"
        )
    } else if explains(Of::Position, Of::Command, Order::First) {
        format!(
            "the column {position} seems to hold the velocity: state the column of the measured position as log.position"
        )
    } else {
        return None;
    };
    Some(Remark::refusing(RemarkKind::WrongColumn, text))
}

/// A command that moves the servo the other way, whatever else acts.
fn reversed(log: &Log, plain: &[Response], beside_place: &[Response]) -> Option<Remark> {
    /// The least part that a reversed command explains.
    const MIN_EXPLAINED: f64 = 0.3;
    let against = |all: &[Response]| {
        let found = best(all)?;
        let most = |sign: f64| {
            let signed = all.iter().map(|of| sign * of.significance);
            signed.fold(0.0, f64::max)
        };
        let is_clear = found.gain < 0.0
            && found.explained > MIN_EXPLAINED
            && found.significance < -CLEAR
            && most(1.0) < 0.5 * most(-1.0);
        is_clear.then_some(found)
    };
    against(plain)?;
    let found = against(beside_place)?;
    let against_reference = Of::Reference.is_in(log)
        && covariance(log, Of::Position, Of::Reference)
            < -0.5 * deviation(log, Of::Position) * deviation(log, Of::Reference);
    let remedy = if against_reference {
        "the position goes against its reference, too: state log.position_scale = -1"
    } else if Of::Reference.is_in(log) {
        "state log.command_scale = -1"
    } else {
        "state log.command_scale = -1, or log.position_scale = -1 where it is the encoder that counts backwards"
    };
    let text = format!(
        "the command moves the servo the other way (b below 0 by {:.0} standard errors): {remedy}",
        found.significance.abs()
    );
    Some(Remark::refusing(RemarkKind::Reversed, text))
}

/// A command that the motion does not depend on.
fn without_effect(plain: &[Response], beside_place: &[Response]) -> Option<Remark> {
    let mut all = plain.iter().chain(beside_place);
    let none = !plain.is_empty() && all.all(|of| of.significance.abs() < NONE);
    none.then(|| {
        Remark::refusing(
            RemarkKind::NoEffect,
            "the motion does not depend on the command: state the column of the command that acted as log.command, and \
             log.cut where it did not reach the motor; if it did, let the servo move further and faster",
        )
    })
}

/// A motion of one direction, in which friction and load are one force.
fn direction(scenario: &Scenario, log: &Log) -> Option<Remark> {
    /// Part of the travel that must go backwards.
    const MIN_BACK: f64 = 0.01;
    let parameters = &scenario.identifier.parameters;
    if !parameters.contains(&Parameter::Coulomb) || !parameters.contains(&Parameter::Load) {
        return None;
    }
    let threshold = (10.0 * noise(log, Of::Position)).max(4.0 * scenario.stated.resolution);
    let (mut forth, mut back) = (0.0, 0.0);
    for segment in log.segments() {
        let mut from = *segment.positions.first()?;
        for position in &segment.positions {
            let step = position - from;
            if step.abs() > threshold {
                from = *position;
                if step > 0.0 {
                    forth += step;
                } else {
                    back -= step;
                }
            }
        }
    }
    let (more, less) = (f64::max(forth, back), f64::min(forth, back));
    (more > 0.0 && less < MIN_BACK * more).then(|| {
        // A fit to the whole record always estimates both.
        let remedy = match scenario.identifier.law.takes_whole_record() {
            true => "let the servo turn round",
            false => {
                "leave coulomb or load out of identifier.parameters, or let the servo turn round"
            }
        };
        Remark::refusing(
            RemarkKind::OneDirection,
            format!(
                "the servo moves in one direction, in which friction and load are one force: {remedy}"
            ),
        )
    })
}

/// The width at which the input explains most.
fn best(all: &[Response]) -> Option<Response> {
    let clear = all.iter().filter(|of| of.significance.abs() > NONE);
    clear
        .copied()
        .max_by(|one, other| one.explained.total_cmp(&other.explained))
}

fn respond(log: &Log, output: Of, input: Of, order: Order, beside: Beside) -> Vec<Response> {
    let signals: Vec<_> = (log.segments().iter())
        .map(|segment| Signals {
            output: output.samples(segment),
            input: input.samples(segment),
        })
        .collect();
    responses(&signals, noise(log, output), order, beside)
}

/// The response to the command less the position, which is that of a loop if the command is its reference.
fn respond_to_error(log: &Log) -> Vec<Response> {
    let errors: Vec<Vec<f64>> = (log.segments().iter())
        .map(|segment| {
            let pairs = segment.commands.iter().zip(&segment.positions);
            pairs
                .map(|(command, position)| command - position)
                .collect()
        })
        .collect();
    let signals: Vec<_> = (log.segments().iter().zip(&errors))
        .map(|(segment, errors)| Signals {
            output: &segment.positions,
            input: errors,
        })
        .collect();
    responses(
        &signals,
        noise(log, Of::Position),
        Order::Second,
        Beside::Nothing,
    )
}

/// White noise of a column, from its third differences, in which a motion hardly shows.
fn noise(log: &Log, of: Of) -> f64 {
    noise_of(log.segments().iter().map(|segment| of.samples(segment)))
}

fn noise_of<'a>(stretches: impl Iterator<Item = &'a [f64]>) -> f64 {
    /// Variance of a third difference of white noise of one.
    const VARIANCE: f64 = 20.0;
    let (mut count, mut squares) = (0.0, 0.0);
    for samples in stretches {
        for four in samples.windows(4) {
            let third = four[3] - 3.0 * four[2] + 3.0 * four[1] - four[0];
            count += 1.0;
            squares += third * third;
        }
    }
    (squares / VARIANCE / f64::max(count, 1.0)).sqrt()
}

/// The part of a motion that an input explains as the command of a servo explains its position, either way; zero where
/// it does not do so clearly.
pub(crate) fn explained_by(position: &[f64], command: &[f64]) -> f64 {
    let signals = Signals {
        output: position,
        input: command,
    };
    let noise = noise_of(std::iter::once(position));
    let found = responses(&[signals], noise, Order::Second, Beside::Nothing);
    best(&found)
        .filter(|found| found.significance.abs() > CLEAR)
        .map_or(0.0, |found| found.explained)
}

fn deviation(log: &Log, of: Of) -> f64 {
    covariance(log, of, of).max(0.0).sqrt()
}

fn covariance(log: &Log, one: Of, other: Of) -> f64 {
    let (mut count, mut sums, mut products) = (0.0, [0.0; 2], 0.0);
    let mut origin = None;
    for segment in log.segments() {
        for (x, y) in one.samples(segment).iter().zip(other.samples(segment)) {
            let [from, to] = *origin.get_or_insert([*x, *y]);
            let (x, y) = (x - from, y - to);
            count += 1.0;
            sums = [sums[0] + x, sums[1] + y];
            products += x * y;
        }
    }
    let count = f64::max(count, 1.0);
    products / count - sums[0] * sums[1] / (count * count)
}
