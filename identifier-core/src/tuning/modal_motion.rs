//! The motion of a second mass's mode in time.
//!
//! s is the pole of the mode, ÿ the acceleration of both masses as one, by friction and command. Then ż = s z + ÿ, and
//! the motor is displaced from both masses by β Im z/Im s.

use super::resonance::Mode;
use crate::number::Complex;

/// A mode that is driven by accelerations, each held for a part of a sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ModalMotion {
    /// β/Im s, s.
    share: f64,
    /// z, rad/s.
    state: Complex,
    parts: [ModalPart; 2],
}

/// A time for which an acceleration is held.
#[derive(Debug, Clone, Copy, PartialEq)]
struct ModalPart {
    /// e^(st).
    pole: Complex,
    /// (e^(st) − 1)/(s t), 1 without the mode's own motion, over t.
    driven: Complex,
}

impl ModalMotion {
    /// At rest, for the two parts of a sample, s.
    pub(super) fn new(mode: &Mode, parts: [f64; 2]) -> Self {
        let s = mode.pole();
        Self {
            share: mode.ratio / s.im,
            state: Complex::ZERO,
            parts: parts.map(|time| {
                let pole = s.scaled(time).exponential();
                let driven = (pole - Complex::ONE) / s.scaled(time * time);
                ModalPart { pole, driven }
            }),
        }
    }

    /// The motor's displacement from both masses as one, after a part of a sample. `change` is the change of their
    /// speed, rad per part.
    pub(super) fn process(&mut self, part: usize, change: f64) -> f64 {
        if let Some(ModalPart { pole, driven }) = self.parts.get(part) {
            self.state = *pole * self.state + driven.scaled(change);
        }
        self.share * self.state.im
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::TAU;

    #[test]
    fn a_held_acceleration_twists_it_by_the_closed_form() {
        let mode = Mode {
            frequency: TAU * 30.0,
            damping: 0.05,
            ratio: 1.5,
        };
        let (part, sample) = (0.3, 1e-3);
        let times = [part * sample, (1.0 - part) * sample];
        let mut motion = ModalMotion::new(&mode, times);
        let decay = mode.damping * mode.frequency;
        let turning = mode.frequency * (1.0 - mode.damping * mode.damping).sqrt();
        let acceleration = 40.0;
        let at_rest = mode.ratio * acceleration / (mode.frequency * mode.frequency);
        for k in 1..200 {
            let mut twist = 0.0;
            for (place, time) in times.into_iter().enumerate() {
                twist = motion.process(place, acceleration * time * time);
            }
            let time = f64::from(k) * sample;
            let (sine, cosine) = (turning * time).sin_cos();
            let transient = (-decay * time).exp() * (cosine + decay / turning * sine);
            let off = twist / at_rest - (1.0 - transient);
            assert!(off.abs() < 1e-9, "{k}: {off}");
        }
    }

    #[test]
    fn one_mass_has_none() {
        let mode = Mode {
            frequency: 100.0,
            damping: 0.01,
            ratio: 0.0,
        };
        let mut motion = ModalMotion::new(&mode, [5e-4, 5e-4]);
        assert!(motion.process(0, 1.0).abs() <= 0.0);
    }
}
