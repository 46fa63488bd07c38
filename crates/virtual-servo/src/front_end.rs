//! The way of a command from the controller to the motor: limit, dead band, delay.

use crate::Effects;

/// Clips a held command, takes the dead band out of it and delays it. It moves once a sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct FrontEnd {
    limit: f64,
    dead_band: f64,
    /// Whole samples of the delay.
    whole: usize,
    /// The part of a sample in which the command before still acts, and the rest, s.
    parts: [f64; 2],
    /// The commands that have not acted yet, and the one that acted last.
    waiting: [f64; Effects::MAX_DELAYED_SAMPLES + 2],
    newest: usize,
}

/// A command that acts for a time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Held {
    /// Command units.
    pub(crate) command: f64,
    /// S; zero for a part that there is not.
    pub(crate) time: f64,
}

impl FrontEnd {
    /// The share of a sample below which a rest of the delay is rounding.
    const WHOLE_TOLERANCE: f64 = 1e-9;

    /// That of some effects, which are known to be allowed, before the first command: nothing acts.
    pub(crate) fn new(effects: &Effects, sample_time: f64) -> Self {
        let samples = effects.delay / sample_time + Self::WHOLE_TOLERANCE;
        let whole = (samples as usize).min(Effects::MAX_DELAYED_SAMPLES);
        let rest = samples - whole as f64;
        let before = if rest > 2.0 * Self::WHOLE_TOLERANCE {
            (rest - Self::WHOLE_TOLERANCE) * sample_time
        } else {
            0.0
        };
        Self {
            limit: if effects.hidden_limit > 0.0 {
                effects.hidden_limit
            } else {
                f64::INFINITY
            },
            dead_band: effects.dead_band,
            whole,
            parts: [before, sample_time - before],
            waiting: [0.0; Effects::MAX_DELAYED_SAMPLES + 2],
            newest: 0,
        }
    }

    /// As if this command had been given for long.
    pub(crate) fn hold(&mut self, command: f64) {
        let clipped = command.clamp(-self.limit, self.limit);
        self.waiting
            .fill(clipped - clipped.clamp(-self.dead_band, self.dead_band));
    }

    /// The last command, as it comes out.
    pub(crate) fn last(&self) -> f64 {
        self.waiting[self.newest]
    }

    /// The commands that act during a sample, one after the other, at whose beginning this one is given.
    pub(crate) fn process(&mut self, command: f64) -> [Held; 2] {
        let size = self.waiting.len();
        let clipped = command.clamp(-self.limit, self.limit);
        self.newest = (self.newest + 1) % size;
        self.waiting[self.newest] = clipped - clipped.clamp(-self.dead_band, self.dead_band);
        let given_before = |samples: usize| self.waiting[(self.newest + size - samples) % size];
        let [first, second] = self.parts;
        [
            Held {
                command: given_before(self.whole + 1),
                time: first,
            },
            Held {
                command: given_before(self.whole),
                time: second,
            },
        ]
    }
}
