use core::fmt::Debug;

use super::terms::TermValues;
use crate::measurement::angle::AngleSettings;
use crate::number::Number;

/// The known inputs of the model over a sample. These are the command behind dead band and delay, and functions of the
/// measured angle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Acting<N> {
    /// Mean of the command that acts, command units.
    pub command: N,
    /// The first moment: the additional distance per unit of gain within the sample because the command came earlier
    /// than evenly spread. It is f (1 − f) (u₁ − u₀)/2 if u₁ acts for a part f and then u₀; command units.
    pub lead: N,
    /// ∂`command`/∂τ, command units per sample.
    pub per_delay: N,
    /// ∂`command`/∂δ: −1, 0 or 1.
    pub per_dead_band: N,
    /// sin q, cos q, sin Nq, cos Nq of the measured angle in the middle of the sample.
    pub waves: [N; 4],
}

impl<N: Number> Acting<N> {
    /// A command that acts unchanged.
    #[inline]
    #[must_use]
    pub fn at_once(command: N) -> Self {
        Self {
            command,
            lead: N::ZERO,
            per_delay: N::ZERO,
            per_dead_band: N::ZERO,
            waves: [N::ZERO; 4],
        }
    }
}

/// The part of a model's state that does not depend on its motion: the past commands and the servo's position.
pub trait KnownInputs<N: Number>: Copy + Debug + PartialEq {
    /// Nothing was commanded yet; the servo is at the angle zero.
    const START: Self;

    /// The longest delay that it can represent, samples.
    const MAX_DELAY: f64;

    /// Takes the increment of a sample and the command from this sample to the next. Returns the inputs that act until
    /// then. The servo moves at about `velocity` meanwhile.
    fn take(
        &mut self,
        angle: &AngleSettings<N>,
        terms: &TermValues<N>,
        increment: N,
        command: N,
        velocity: N,
    ) -> Acting<N>;

    /// Sets the measured position, position units, before the first sample.
    fn place(&mut self, angle: &AngleSettings<N>, position: N);
}

/// For models without terms: the command acts at once.
impl<N: Number> KnownInputs<N> for () {
    const START: Self = ();
    const MAX_DELAY: f64 = 0.0;

    #[inline]
    fn take(
        &mut self,
        _: &AngleSettings<N>,
        _: &TermValues<N>,
        _: N,
        command: N,
        _: N,
    ) -> Acting<N> {
        Acting::at_once(command)
    }

    #[inline]
    fn place(&mut self, _: &AngleSettings<N>, _: N) {}
}

/// The last L commands, for models with a delay or a dead band; L is a power of two. The delay may be
/// up to L − 2 samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DelayedInputs<N, const L: usize> {
    commands: [N; L],
    last: usize,
}

impl<N: Number, const L: usize> DelayedInputs<N, L> {
    /// The command of some samples ago behind the dead band, and its derivative by the dead band.
    #[inline]
    fn behind_dead_band(&self, ago: usize, dead_band: N) -> (N, N) {
        let command = self.commands[self.last.wrapping_sub(ago) & (L - 1)];
        if command > dead_band {
            (command - dead_band, -N::ONE)
        } else if command < -dead_band {
            (command + dead_band, N::ONE)
        } else {
            (N::ZERO, N::ZERO)
        }
    }
}

impl<N: Number, const L: usize> KnownInputs<N> for DelayedInputs<N, L> {
    const START: Self = {
        assert!(L >= 4 && L.is_power_of_two());
        Self {
            commands: [N::ZERO; L],
            last: 0,
        }
    };
    const MAX_DELAY: f64 = (L - 2) as f64;

    #[inline]
    fn take(
        &mut self,
        _: &AngleSettings<N>,
        terms: &TermValues<N>,
        _: N,
        command: N,
        _: N,
    ) -> Acting<N> {
        let last = self.last.wrapping_add(1) & (L - 1);
        self.last = last;
        self.commands[last] = command;
        let whole = terms.delay.whole();
        let part = terms.delay - N::from_count(whole);
        let whole = whole.unsigned_abs() as usize;
        let (late, late_slope) = self.behind_dead_band(whole + 1, terms.dead_band);
        let (early, early_slope) = self.behind_dead_band(whole, terms.dead_band);
        let change = late - early;
        Acting {
            command: early + part * change,
            lead: N::from_f64(0.5) * part * (N::ONE - part) * change,
            per_delay: change,
            per_dead_band: early_slope + part * (late_slope - early_slope),
            waves: [N::ZERO; 4],
        }
    }

    #[inline]
    fn place(&mut self, _: &AngleSettings<N>, _: N) {}
}

/// The last L commands and the angle, for models with gravity or ripple too.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AngledInputs<N, const L: usize> {
    delayed: DelayedInputs<N, L>,
    /// From zero to a revolution, position units.
    position: N,
}

impl<N: Number, const L: usize> KnownInputs<N> for AngledInputs<N, L> {
    const START: Self = Self {
        delayed: DelayedInputs::START,
        position: N::ZERO,
    };
    const MAX_DELAY: f64 = <DelayedInputs<N, L> as KnownInputs<N>>::MAX_DELAY;

    #[inline]
    fn take(
        &mut self,
        angle: &AngleSettings<N>,
        terms: &TermValues<N>,
        increment: N,
        command: N,
        velocity: N,
    ) -> Acting<N> {
        self.position = angle.within(self.position + increment);
        Acting {
            waves: angle.waves(self.position + N::from_f64(0.5) * velocity),
            ..self
                .delayed
                .take(angle, terms, increment, command, velocity)
        }
    }

    fn place(&mut self, angle: &AngleSettings<N>, position: N) {
        self.position = angle.within(position);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::Response;

    fn terms(delay: f64, dead_band: f64) -> TermValues<f64> {
        TermValues {
            delay,
            dead_band,
            ..TermValues::default()
        }
    }

    /// A mass that the last commands accelerate from rest, each in two parts, in closed form.
    fn pushed(commands: &[f64], delay: f64) -> (f64, f64) {
        let mut position = 0.0;
        let mut velocity = 0.0;
        let at = |index: i64| usize::try_from(index).map_or(0.0, |index| commands[index]);
        let whole = delay.floor();
        let part = delay - whole;
        for k in 0..commands.len() as i64 {
            for (command, time) in [
                (at(k - whole as i64 - 1), part),
                (at(k - whole as i64), 1.0 - part),
            ] {
                position += velocity * time + 0.5 * command * time * time;
                velocity += command * time;
            }
        }
        (position, velocity)
    }

    #[test]
    fn a_delay_of_any_part_of_a_sample_is_exact_for_a_mass() {
        let commands: [f64; 40] = core::array::from_fn(|k| ((k * 7919) % 13) as f64 - 6.0);
        for delay in [0.0, 0.25, 0.999, 1.0, 2.5, 5.75] {
            let mut inputs = DelayedInputs::<f64, 8>::START;
            let (mut position, mut velocity) = (0.0, 0.0);
            let mass = Response {
                displacement: 0.5,
                velocity: 1.0,
            };
            for command in commands {
                let acting = inputs.take(
                    &AngleSettings::default(),
                    &terms(delay, 0.0),
                    0.0,
                    command,
                    0.0,
                );
                let motion = mass.motion(0.0, acting.command, velocity);
                position += motion.increment + acting.lead;
                velocity = motion.velocity;
            }
            let exact = pushed(&commands, delay);
            assert!((position - exact.0).abs() < 1e-9, "{delay}");
            assert!((velocity - exact.1).abs() < 1e-9, "{delay}");
        }
    }

    #[test]
    fn a_dead_band_takes_its_width_from_both_sides() {
        for (command, acts, slope) in [(3.0, 2.5, -1.0), (-3.0, -2.5, 1.0), (0.4, 0.0, 0.0)] {
            let mut inputs = DelayedInputs::<f64, 4>::START;
            let acting = inputs.take(
                &AngleSettings::default(),
                &terms(0.0, 0.5),
                0.0,
                command,
                0.0,
            );
            assert_eq!((acting.command, acting.per_dead_band), (acts, slope));
        }
    }

    #[test]
    fn the_angle_is_measured_through_every_revolution_from_where_it_begins() {
        let angle = AngleSettings::<f64>::new(1000.0, 6.0);
        let mut inputs = AngledInputs::<f64, 4>::START;
        let mut position = -12_345.0;
        inputs.place(&angle, position);
        for increment in [3.0, 700.0, -999.0, 250.0, -1.0, 999.0, 5321.0, -7777.0] {
            let acting = inputs.take(&angle, &TermValues::default(), increment, 0.0, 2.0);
            position += increment;
            let q = (position + 1.0) * angle.resolution;
            let exact = [q.sin(), q.cos(), (6.0 * q).sin(), (6.0 * q).cos()];
            for (wave, exact) in acting.waves.iter().zip(exact) {
                assert!((wave - exact).abs() < 1e-9);
            }
        }
    }
}
