//! A pass of the model over a stretch, with what each of many effects would do to its output error.

use identifier_core::replay::ReplayModel;

use super::effect::{Effect, Instant, LAGS, Memory};
use crate::analysis::stretch::Kept;

/// A stretch of a run, machine units.
#[derive(Debug, Clone)]
pub(super) struct Recorded {
    /// Positions, counts from the first; where a motion begins, it continues from the last position.
    pub(super) positions: Vec<f64>,
    /// Positions as they are, counts.
    angles: Vec<f64>,
    /// The samples at which a motion begins.
    begins: Vec<usize>,
    /// Commands that acted from there on, behind the declared amplifier.
    pub(super) commands: Vec<f64>,
}

impl Recorded {
    /// Of samples, with the counts per rad, behind the declared amplifier of a model.
    pub(super) fn new(
        samples: impl Iterator<Item = Kept>,
        per_rad: f64,
        model: &ReplayModel,
    ) -> Self {
        let mut current = model.start(0.0, 0.0);
        let mut recorded = Self {
            positions: Vec::new(),
            angles: Vec::new(),
            begins: Vec::new(),
            commands: Vec::new(),
        };
        for sample in samples {
            let angle = sample.position * per_rad;
            let last = recorded.angles.last().zip(recorded.positions.last());
            let position = match last {
                Some((last, position)) if !sample.begins => position + (angle - last),
                Some((_, position)) => *position,
                None => 0.0,
            };
            if sample.begins || last.is_none() {
                recorded.begins.push(recorded.positions.len());
                current = model.start(0.0, 0.0);
            }
            recorded.positions.push(position);
            recorded.angles.push(angle);
            let acts = model.amplify(&mut current, sample.command);
            recorded.commands.push(acts);
        }
        recorded
    }
}

/// The settings of a pass.
#[derive(Debug, Clone, Copy)]
pub(super) struct Plan {
    /// The model with the correction.
    pub(super) model: ReplayModel,
    /// ω T of the correction that keeps the model with the servo.
    pub(super) omega: f64,
    /// The size of a usual command.
    pub(super) usual_command: f64,
    /// Samples to a block.
    pub(super) block: usize,
    /// Samples at the beginning in which the model and its tangents find the servo.
    pub(super) settling: usize,
}

/// The result of a pass: means over blocks.
#[derive(Debug, Clone)]
pub(super) struct Blocks {
    /// Of the output error, counts.
    pub(super) error: Vec<f64>,
    /// Of what a unit of each effect adds to it, counts; in the effects' order.
    pub(super) columns: Vec<Vec<f64>>,
    /// Root mean square of the output error, counts, and its correlation from sample to sample.
    pub(super) rms: f64,
    pub(super) correlation: f64,
}

/// Runs the model over a stretch.
pub(super) fn pass(recorded: &Recorded, plan: &Plan, effects: &[Effect]) -> Blocks {
    let Recorded {
        positions,
        commands,
        angles,
        begins,
    } = recorded;
    let mut begins = begins.iter().copied().peekable();
    let model = &plan.model;
    let mut state = model.start(0.0, 0.0);
    let mut tangents = vec![Tangent::default(); effects.len()];
    let mut gathered = Gathered::new(plan, effects.len(), positions.len());
    let (mut lagged, mut acceleration) = ([0.0; LAGS.len()], 0.0);
    for (k, (&position, &command)) in positions.iter().zip(commands).enumerate() {
        let increment = if k > 0 {
            position - positions[k - 1]
        } else {
            0.0
        };
        if begins.next_if_eq(&k).is_some() {
            let velocity = beginning(&positions[k..], plan.omega);
            state = model.start(angles[k] - increment, velocity);
            tangents.fill(Tangent::default());
            (lagged, acceleration) = ([command; LAGS.len()], 0.0);
            gathered.leave_out_until(k + plan.settling);
        }
        let before = state.velocity;
        let sample = model.process(&mut state, increment, command);
        for (lagged, lag) in lagged.iter_mut().zip(LAGS) {
            *lagged += (command - *lagged) / (1.0 + lag);
        }
        let instant = Instant {
            model,
            sample: &sample,
            commands: &commands[..=k],
            usual_command: plan.usual_command,
            lagged,
            angle: (angles[k] + 0.5 * before) * model.angle_resolution(),
            passed: k as f64 / positions.len() as f64 - 0.5,
            acceleration,
        };
        gathered.error(k, sample.innovation);
        for (i, (tangent, effect)) in tangents.iter_mut().zip(effects).enumerate() {
            let [position, _] = tangent.motion;
            let output = position + effect.offset(&mut tangent.memory, &instant);
            gathered.column(k, i, output);
            let push = effect.push(&instant);
            tangent.motion = model.propagate(&sample, tangent.motion, push, output);
        }
        acceleration = state.velocity - before;
    }
    gathered.finish()
}

/// The velocity at the first sample, counts per sample: over a time in which it hardly changes.
fn beginning(positions: &[f64], omega: f64) -> f64 {
    const CHANGE: f64 = 0.3;
    let span = ((CHANGE / omega) as usize)
        .clamp(1, 100)
        .min(positions.len() - 1);
    (positions[span] - positions[0]) / span.max(1) as f64
}

/// ∂q_e/∂θ and ∂v_e/∂θ of one effect.
#[derive(Debug, Clone, Copy, Default)]
struct Tangent {
    motion: [f64; 2],
    memory: Memory,
}

/// Gathers [`Blocks`].
struct Gathered {
    settling: usize,
    from: usize,
    block: usize,
    error: Vec<f64>,
    columns: Vec<Vec<f64>>,
    errors: [f64; 3],
    last: f64,
}

impl Gathered {
    fn new(plan: &Plan, columns: usize, samples: usize) -> Self {
        // Whole blocks alone.
        let blocks = samples.saturating_sub(plan.settling) / plan.block;
        Self {
            settling: plan.settling,
            from: 0,
            block: plan.block,
            error: vec![0.0; blocks],
            columns: vec![vec![0.0; blocks]; columns],
            errors: [0.0; 3],
            last: 0.0,
        }
    }

    /// Leaves out what comes before a sample.
    fn leave_out_until(&mut self, sample: usize) {
        self.from = sample;
    }

    fn place(&self, sample: usize) -> Option<usize> {
        if sample < self.from {
            return None;
        }
        let block = sample.checked_sub(self.settling)? / self.block;
        (block < self.error.len()).then_some(block)
    }

    fn error(&mut self, sample: usize, value: f64) {
        if let Some(block) = self.place(sample) {
            self.error[block] += value / self.block as f64;
            self.errors[0] += 1.0;
            self.errors[1] += value * value;
            self.errors[2] += value * self.last;
        }
        self.last = value;
    }

    fn column(&mut self, sample: usize, column: usize, value: f64) {
        if let Some(block) = self.place(sample) {
            self.columns[column][block] += value / self.block as f64;
        }
    }

    fn finish(self) -> Blocks {
        let [count, squares, lagged] = self.errors;
        Blocks {
            error: self.error,
            columns: self.columns,
            rms: (squares / count.max(1.0)).sqrt(),
            // The first and the last square are in one sum only.
            correlation: if squares > 0.0 {
                (lagged / squares).clamp(-1.0, 1.0)
            } else {
                0.0
            },
        }
    }
}
