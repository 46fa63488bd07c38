use crate::constants::{Encode, encode};
use crate::number::Number;

/// The declared amplifier between a command and the servo: dead band, then delay, then a
/// first-order current loop. [`Settings::amplifier`](crate::Settings::amplifier) builds it.
///
/// Declared effects that are not estimated act here, for every estimator: an identifier learns from the command that
/// [`Amplifier::process`] returns. A declared delay or dead band may also be a term to be estimated. It is then the
/// initial value of the estimate, in the identifier. So nothing counts twice, and a report gives the total.
///
/// L is the length of its ring of commands, a power of two; the delay may be L − 2 samples.
///
/// A model that is driven by the mean of the acting command over each sample is exact in velocity. Within a sample its
/// position differs by at most b T²/8 times the change of the command.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Amplifier<N, const L: usize> {
    dead_band: N,
    /// Whole samples of the delay.
    whole: usize,
    /// The part of a sample over which the older of two commands still acts.
    part: N,
    /// e^(−T/T_c).
    kept: N,
    /// The mean error over a sample of a current that begins with an error of one. The first is for the older command's
    /// part of the sample, the second for the newer one's.
    lag: [N; 2],
}

encode! {
    [N: Encode, const L: usize] Amplifier<N, L> as "Amplifier" { dead_band, whole, part, kept, lag }
    also L as u32
}

/// The state of an [`Amplifier`]: the commands that have not acted in full.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AmplifierState<N, const L: usize> {
    /// The last L commands behind the dead band; L is a power of two.
    commands: [N; L],
    last: usize,
    /// The current where the older of the acting commands began to act, command units.
    current: N,
}

impl<N: Number, const L: usize> AmplifierState<N, L> {
    /// The command of some samples ago.
    #[inline]
    fn ago(&self, samples: usize) -> N {
        self.commands[self.last.wrapping_sub(samples) & (L - 1)]
    }
}

impl<N: Number, const L: usize> Amplifier<N, L> {
    /// The longest delay that it can represent, samples.
    pub(crate) const MAX_DELAY: f64 = {
        assert!(L >= 4 && L.is_power_of_two());
        (L - 2) as f64
    };

    /// A dead band (command units), a delay (samples) and the time constant of a current loop (samples). Zero is none.
    pub(crate) fn new(dead_band: f64, delay: f64, current_loop: f64) -> Self {
        let whole = libm::floor(delay);
        let part = delay - whole;
        let (kept, lag) = if current_loop > 0.0 {
            let rate = 1.0 / current_loop;
            let newer = 1.0 - part;
            let decayed = |time: f64| -libm::expm1(-time * rate) * current_loop;
            (
                libm::exp(-rate),
                [libm::exp(-newer * rate) * decayed(part), decayed(newer)],
            )
        } else {
            (0.0, [0.0; 2])
        };
        Self {
            dead_band: N::from_f64(dead_band),
            whole: whole as usize,
            part: N::from_f64(part),
            kept: N::from_f64(kept),
            lag: lag.map(N::from_f64),
        }
    }

    /// True if a command acts otherwise than it was given.
    #[must_use]
    pub fn acts(&self) -> bool {
        self.whole > 0
            || [self.dead_band, self.part, self.lag[1]]
                .iter()
                .any(|x| *x != N::ZERO)
    }

    /// Nothing was commanded yet.
    #[must_use]
    pub fn start(&self) -> AmplifierState<N, L> {
        AmplifierState {
            commands: [N::ZERO; L],
            last: 0,
            current: N::ZERO,
        }
    }

    /// Takes the command from this sample to the next, and returns the mean command that acts until then.
    #[inline]
    pub fn process(&self, state: &mut AmplifierState<N, L>, command: N) -> N {
        state.last = state.last.wrapping_add(1) & (L - 1);
        state.commands[state.last] = self.behind_dead_band(command);
        let (older, newer) = (state.ago(self.whole + 1), state.ago(self.whole));
        let off = state.current - older;
        state.current = older + self.kept * off;
        let off_newer = state.current - newer;
        let held = newer + self.part * (older - newer);
        held + self.lag[0] * off + self.lag[1] * off_newer
    }

    #[inline]
    fn behind_dead_band(&self, command: N) -> N {
        command - command.limited(-self.dead_band, self.dead_band)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The mean current of each sample, by many small steps.
    fn integrated(commands: &[f64; 40], delay: f64, current_loop: f64) -> [f64; 40] {
        const STEPS: usize = 4000;
        let mut current = 0.0;
        core::array::from_fn(|k| {
            let mut sum = 0.0;
            for step in 0..STEPS {
                let time = k as f64 + (step as f64 + 0.5) / STEPS as f64 - delay;
                let command = if time < 0.0 {
                    0.0
                } else {
                    commands[time as usize]
                };
                let kept = libm::exp(-1.0 / (STEPS as f64 * current_loop));
                let next = command + (current - command) * kept;
                sum += 0.5 * (current + next);
                current = next;
            }
            sum / STEPS as f64
        })
    }

    #[test]
    fn the_mean_of_a_delayed_current_is_exact() {
        let commands: [f64; 40] = core::array::from_fn(|k| ((k * 7919) % 13) as f64 - 6.0);
        let delays = [0.0, 0.25, 1.0, 2.5, 5.75];
        for (delay, current_loop) in delays.into_iter().zip([0.4, 3.0, 1.0, 0.1, 20.0]) {
            let amplifier = Amplifier::<f64, 8>::new(0.0, delay, current_loop);
            assert!(amplifier.acts());
            let mut state = amplifier.start();
            let exact = integrated(&commands, delay, current_loop);
            for (command, exact) in commands.into_iter().zip(exact) {
                let off = amplifier.process(&mut state, command) - exact;
                assert!(off.abs() < 1e-2, "{delay} {current_loop}: {off}");
            }
        }
    }

    #[test]
    fn without_a_current_loop_two_commands_share_a_sample() {
        let amplifier = Amplifier::<f32, 4>::new(0.0, 1.25, 0.0);
        assert!(amplifier.acts());
        let mut state = amplifier.start();
        let acted = [4.0, 8.0, 0.0, 0.0].map(|command| amplifier.process(&mut state, command));
        let expected = [0.0_f32, 3.0, 7.0, 2.0];
        assert_eq!(acted.map(f32::to_bits), expected.map(f32::to_bits));
    }

    #[test]
    fn a_dead_band_takes_its_width_from_both_sides() {
        let amplifier = Amplifier::<f32, 4>::new(0.5, 0.0, 0.0);
        assert!(amplifier.acts());
        let mut state = amplifier.start();
        for (command, acts) in [(3.0, 2.5), (-3.0, -2.5), (0.4, 0.0), (-0.5, 0.0)] {
            let off = amplifier.process(&mut state, command) - acts;
            assert!(off.abs() < 1e-6, "{command}: {off}");
        }
    }

    #[test]
    fn an_amplifier_without_effects_changes_no_bit() {
        let amplifier = Amplifier::<f32, 4>::new(0.0, 0.0, 0.0);
        assert!(!amplifier.acts());
        let mut state = amplifier.start();
        for k in 0..100 {
            let command = (k as f32 * 0.37 - 11.0) / 3.0;
            let acts = amplifier.process(&mut state, command);
            assert_eq!(acts.to_bits(), command.to_bits());
        }
    }
}
