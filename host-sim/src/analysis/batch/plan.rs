//! The settings of a pass over the end of a run: units, usual sizes, the bandwidth of the correction, blocks.

use identifier_core::replay::ReplayModel;

use super::pass::{Plan, Recorded};
use super::{Effort, Judged, Scales};
use crate::analysis::Statistics;
use crate::analysis::stretch::Kept;

/// A stretch and how to pass over it.
#[derive(Debug, Clone)]
pub(super) struct Prepared {
    pub(super) recorded: Recorded,
    pub(super) plan: Plan,
    pub(super) scales: Scales,
    /// The largest command but for one sample in a thousand.
    pub(super) high_command: f64,
}

/// Samples without which nothing is looked at.
const MIN_SAMPLES: usize = 100;

/// The bandwidth of the correction relative to how fast the velocity changes: slow enough to let the
/// model show what it is, fast enough to keep it with the servo.
const BANDWIDTH_RATIO: f64 = 0.5;

/// The fastest correction, and the slowest that a stretch has time for, as ω T and ω times its length.
const MAX_OMEGA: f64 = 0.1;
const MIN_OMEGA_LENGTH: f64 = 40.0;

/// The time in which the model and its tangents find the servo, over 1/ω, and the most of a stretch.
const SETTLING_TIME: f64 = 6.0;
const MAX_SETTLING_DIVISOR: usize = 4;

/// The longest block of samples, relative to 1/ω.
const MAX_BLOCK: f64 = 0.15;

impl Prepared {
    pub(super) fn new(
        judged: &Judged<'_>,
        samples: impl ExactSizeIterator<Item = Kept> + Clone,
        effort: Effort,
    ) -> Option<Self> {
        let units = judged.scenario.units();
        let skipped = samples.len().saturating_sub(effort.samples);
        let terms = &judged.scenario.stated.identifier.terms;
        let found = judged.terms.iter().map(|term| (term.unknown, term.value));
        let model = ReplayModel::new(&units, &judged.servo, terms, found);
        let recorded = Recorded::new(samples.skip(skipped), units.position(), &model);
        let Recorded {
            positions,
            commands,
            ..
        } = &recorded;
        if !model.is_sound() || positions.len() < MIN_SAMPLES {
            return None;
        }
        let mut command = Statistics::default();
        commands.iter().for_each(|&value| command.add(value));
        let (velocity, acceleration) = (
            velocity(positions, model.gain(), command.deviation()?)?,
            model.gain().abs() * command.deviation()?,
        );
        let slowest = (MIN_OMEGA_LENGTH / positions.len() as f64).min(MAX_OMEGA);
        let omega = (BANDWIDTH_RATIO * acceleration / velocity).clamp(slowest, MAX_OMEGA);
        let samples = positions.len();
        let block = ((MAX_BLOCK / omega) as usize)
            .clamp(1, 8)
            .max(samples.div_ceil(effort.blocks));
        let mut position = Statistics::default();
        positions.iter().for_each(|&value| position.add(value));
        Some(Self {
            plan: Plan {
                model: model.corrected(omega),
                omega,
                usual_command: command.deviation()?.max(f64::MIN_POSITIVE),
                block,
                settling: ((SETTLING_TIME / omega) as usize).min(samples / MAX_SETTLING_DIVISOR),
            },
            scales: Scales {
                velocity: velocity / units.velocity(),
                command: command.deviation()?,
                position: position.deviation()? * units.position_unit(),
            },
            high_command: high(commands),
            recorded,
        })
    }
}

/// The deviation of the velocity, counts per sample, over spans in which it hardly changes.
fn velocity(positions: &[f64], gain: f64, command: f64) -> Option<f64> {
    const CHANGE: f64 = 0.3;
    const MAX_SPAN: usize = 200;
    let over = |span: usize| {
        let mut velocity = Statistics::default();
        for pair in positions.windows(span + 1).step_by(span.div_ceil(4)) {
            velocity.add((pair[span] - pair[0]) / span as f64);
        }
        velocity.deviation().filter(|deviation| *deviation > 0.0)
    };
    let rough = over(5)?;
    let span = (CHANGE * rough / (gain.abs() * command)) as usize;
    over(span.clamp(1, MAX_SPAN.min(positions.len() / 4)))
}

/// The command that one sample in a thousand exceeds.
fn high(commands: &[f64]) -> f64 {
    let mut sizes: Vec<f64> = commands.iter().map(|command| command.abs()).collect();
    let place = sizes.len() - 1 - sizes.len() / 1000;
    *sizes.select_nth_unstable_by(place, f64::total_cmp).1
}
