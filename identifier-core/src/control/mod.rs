//! The PID (3) that closes the loop around the servo.
//!
//! In sample k, with the sample time T:
//!
//! u_k = sat( k_p e_k − k_d v_k + k_i T ∑ e_j + f_k, j < k )
//!
//! - e_k is the position error of this sample ([`Setpoint::error`]). With a `ReferenceFilter` it is that of the
//!   filtered reference. With a `FeedForward`, whose command is f_k, it is that of the reference model behind the
//!   filter. The velocity v_k is the estimate of the *measured* velocity, this sample's increment included
//!   ([`VelocityEstimate`]). The reference is not differentiated.
//! - The sum contains the errors of the samples *before* this one; e_k is added after the command was
//!   computed. In single precision the sum is compensated, so that a small error is not lost in a large
//!   integral.
//! - The limit ([`CommandLimit`]) acts on the whole sum, the integral included.
//! - Anti-windup is conditional integration (`Command::integrates`). A positive e_k is *not* added if the command
//!   before the limit is above the upper limit. A negative e_k is not added if that command is below the lower limit.
//! - u_k acts unchanged from this sample to the next (zero-order hold).
//! - An error that is not a number gives no command within the limits. So the usual sample does not test the error.
//!
//! The model loop's correction (`CommandCorrection`) has the same gains unless others are stated. It also has the same
//! filter, sum and hold, but neither limit nor anti-windup. It is added to the command that acted, which is limited
//! already.

mod feed_forward;
mod gains;
mod limit;
mod notch;
mod pid;
mod reference_filter;
mod shaping;

pub(crate) use feed_forward::FeedForward;
pub use feed_forward::FeedForwardSettings;
pub use gains::Gains;
pub use limit::CommandLimit;
pub(crate) use notch::{Notch, notch_at};
use pid::Command;
pub(crate) use pid::{Pid, PidTerms, per_error, sum_exponent};
pub(crate) use reference_filter::ReferenceFilter;
pub(crate) use shaping::Shaping;
pub use shaping::{Shaped, ShapedState, Unshaped};

use crate::constants::{Encode, encode};
use crate::error::StepError;
use crate::measurement::velocity::{LowPass, LowPassState, VelocityEstimate};
use crate::number::{Arithmetic, Encoded, Number, RunningSum};
use crate::scales::FullScales;
use crate::units::Units;

/// The sampled controller: velocity estimate and PID, and around the PID a `Shaping`: filter of the reference,
/// feed-forward and notch, or none of them. The documentation of this [module](self) has its control law.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Controller<N: Arithmetic, V, S = Unshaped> {
    /// The control law.
    pid: Pid<N>,
    /// What acts before and behind it.
    shaping: S,
    /// The velocity estimate the derivative acts on.
    pub velocity: V,
    /// The largest increment that is taken.
    most: N,
    scales: FullScales,
    errors: N::Counts,
    increments: N::Counts,
}

encode! {
    [N: Encoded, V: Encode, S: Encode] Controller<N, V, S> as "Controller" {
        pid, shaping, velocity, most, scales, errors, increments,
    }
}

impl<N: Arithmetic, V, S: Default> Controller<N, V, S> {
    /// In fixed point for the signals' full scales.
    pub(crate) fn with_pid(pid: Pid<N>, velocity: V, scales: FullScales) -> Self {
        Self {
            pid,
            shaping: S::default(),
            velocity,
            most: N::REACH,
            scales,
            errors: N::counts(scales.position),
            increments: N::counts(scales.velocity),
        }
    }
}

impl<N: Arithmetic, V, S> Controller<N, V, S> {
    /// The same with a largest increment, machine units.
    pub(crate) fn with_most_increment(self, most: f64) -> Self {
        let most = N::signal(most, self.scales.velocity);
        Self { most, ..self }
    }

    /// The position error of a setpoint, whole counts and an offset on top, at a count. Counts may wrap at 32 bits:
    /// setpoint and position are never further apart than half of that. In fixed point it saturates.
    #[inline]
    #[must_use]
    pub fn error(&self, setpoint: i32, offset: N::Offset, count: i32) -> N {
        N::distance(setpoint, offset, count, self.errors)
    }

    /// Counts moved since the last sample as an increment. In fixed point it saturates.
    #[inline]
    #[must_use]
    pub fn increment(&self, moved: i32) -> N {
        N::increment(moved, self.increments)
    }

    /// A command as a number, command units.
    #[must_use]
    pub fn command(&self, command: N) -> f64 {
        command.value(self.scales.command)
    }

    /// A velocity estimate as a number, machine units.
    #[must_use]
    pub fn velocity(&self, velocity: N) -> f64 {
        velocity.value(self.scales.velocity)
    }
}

impl<N: Arithmetic, V> Controller<N, V, Shaped<N>> {
    /// The same with a shaping that is made for its gains and its velocity estimate.
    #[inline]
    #[must_use]
    pub fn with_shaping(self, shaping: Shaped<N>) -> Self {
        let finer = self.scales.position - self.scales.velocity;
        let shaping = shaping.with_finer_increments(finer);
        Self { shaping, ..self }
    }
}

impl<N: Number, V, S: Default> Controller<N, V, S> {
    /// A controller of these parts that shapes nothing. Increments may be as large as the number format counts exactly.
    #[must_use]
    pub fn new(units: &Units, gains: &Gains, limit: &CommandLimit, velocity: V) -> Self {
        let scales = FullScales::NONE;
        Self::with_pid(Pid::new(units, gains, limit, &scales), velocity, scales)
    }

    /// The same with a PID in machine units. The gains are k_p, k_d and k_i: command units per position unit, per
    /// position unit a sample and per sum of position units. The last is above zero. The limit is the lowest and the
    /// highest command.
    ///
    /// It checks nothing and divides by k_i alone, as multiplications: for a sample in which gains change.
    #[must_use]
    pub fn in_machine_units(gains: [N; 3], limit: [N; 2], velocity: V) -> Self {
        Self::with_pid(
            Pid::in_machine_units(gains, limit),
            velocity,
            FullScales::NONE,
        )
    }

    /// A copy with k_p, k_d and k_i multiplied by these factors, above zero, and another velocity estimate. Nothing is
    /// shaped. As [`Controller::in_machine_units`] for a sample in which gains
    /// change.
    #[must_use]
    pub fn scaled(&self, factors: [N; 3], velocity: V) -> Self {
        Self::with_pid(self.pid.scaled(factors), velocity, FullScales::NONE)
    }
}

impl<N: Number, V, S> Controller<N, V, S> {
    /// The command without integral, notch and limit, command units, for a position error and a velocity in
    /// machine units.
    #[inline]
    pub fn linear(&self, error: N, velocity: N) -> N {
        self.pid.linear(error, velocity)
    }

    /// The integral ∑e that gives a command at a position error and a velocity: (u − k_p e + k_d v)/k_i. Integral,
    /// error and velocity are in machine units. Zero without integral action.
    #[must_use]
    pub fn integral_for(&self, command: N, error: N, velocity: N) -> N {
        self.pid.integral_for(command, error, velocity)
    }
}

/// State of the controller between samples; H is that of its shaping.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ControlState<N: Arithmetic, F, H = ()> {
    integral: N::Sum,
    filter: F,
    shaping: H,
}

impl<N: Arithmetic, F: Default, H: Default> Default for ControlState<N, F, H> {
    /// At rest, integral empty, the filtered reference at the servo's position.
    fn default() -> Self {
        Self {
            integral: N::ZERO.sum(),
            filter: F::default(),
            shaping: H::default(),
        }
    }
}

impl<N: Number, F, H> ControlState<N, F, H> {
    /// With an integral ∑e that a controller has gathered before, machine units.
    #[must_use]
    pub fn with_integral(self, integral: N) -> Self {
        Self {
            integral: N::Sum::new(integral),
            ..self
        }
    }

    /// Subtracts this from the integral, machine units.
    #[must_use]
    pub fn with_integral_less(self, integral: N) -> Self {
        let left = self.integral.value() - integral;
        self.with_integral(left)
    }

    /// For a controller with this part of k_i, above zero: the integral's command stays.
    #[must_use]
    pub fn with_integral_for(self, part: N) -> Self {
        let integral = self.integral.value() * part.reciprocal();
        self.with_integral(integral)
    }
}

/// One sample of the loop, machine units.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ControlSample<N> {
    /// Position error e = q_d − q, q_d behind the filter of the reference and the reference model.
    pub error: N,
    /// Increment of the measured position since the last sample.
    pub increment: N,
    /// Velocity estimate.
    pub velocity: N,
    /// The command u, limited.
    pub command: N,
}

impl<N: Number> ControlSample<N> {
    /// The same with positions in another unit, which each of error, increment and velocity is taken to.
    #[must_use]
    pub fn scaled(self, to_unit: impl Fn(N) -> N) -> Self {
        Self {
            error: to_unit(self.error),
            increment: to_unit(self.increment),
            velocity: to_unit(self.velocity),
            command: self.command,
        }
    }
}

impl<N: Number, S: Shaping<N>> Controller<N, LowPass<N>, S> {
    /// The state for a bumpless transfer from another controller, whose last sample is `last`. The command and the
    /// filtered reference continue; a reference model continues from rest.
    #[must_use]
    pub fn take_over(&self, last: &ControlSample<N>) -> ControlState<N, LowPassState<N>, S::State> {
        let integral = self
            .pid
            .integral_for(last.command, last.error, last.velocity);
        ControlState {
            integral: N::Sum::new(integral),
            filter: LowPassState::moving(last.velocity),
            shaping: S::continuing(last.error, last.command),
        }
    }
}

impl<N: Arithmetic, V: VelocityEstimate<N>, S: Shaping<N>> Controller<N, V, S> {
    /// The state at rest, integral empty, the reference at the servo's position.
    #[must_use]
    pub fn start(&self) -> ControlState<N, V::State, S::State> {
        ControlState::default()
    }

    /// One sample: position error and increment of the measured position (machine units) to command.
    ///
    /// # Errors
    /// [`StepError`] when an input is not finite, or beyond the range of the number format where the command is not
    /// within its limits; the state is then untouched. In fixed point an error beyond its range saturates.
    // A call, and a result that passes through memory, would cost a tenth of a sample.
    #[inline(always)]
    pub fn process(
        &self,
        state: &mut ControlState<N, V::State, S::State>,
        error: N,
        increment: N,
    ) -> Result<ControlSample<N>, StepError> {
        // No number fails this comparison too.
        let moved_within = increment.magnitude() <= self.most;
        if !moved_within {
            return Err(StepError::CountJumped);
        }
        let mut filter = state.filter;
        let velocity = self.velocity.process(&mut filter, increment);
        let sum = state.integral;
        let pid = &self.pid;
        let wanted = move |error| pid.wanted(error, velocity, sum);
        let (near, wanted, shaped) =
            self.shaping
                .process(&state.shaping, error.saturated(), increment, wanted);
        let command = if pid.is_within(wanted) {
            Command {
                value: wanted,
                integrates: true,
            }
        } else {
            rare();
            let is_near = error.magnitude() <= N::REACH;
            let limited = pid.limited(wanted, near).filter(|_| is_near);
            limited.ok_or_else(|| Self::refusal(error))?
        };
        if command.integrates {
            pid.gather(&mut state.integral, near);
        }
        state.filter = filter;
        if let Some(shaped) = shaped {
            state.shaping = shaped;
        }
        Ok(ControlSample {
            error: near,
            increment,
            velocity,
            command: pid.as_command(command.value),
        })
    }

    #[cold]
    fn refusal(error: N) -> StepError {
        if error.is_finite() {
            StepError::TooFarApart
        } else {
            StepError::ErrorNotFinite
        }
    }
}

/// Says that a branch is seldom taken: the usual one then falls through, an instruction less in each sample.
#[cold]
#[inline]
fn rare() {}

/// The position to hold: a whole number of counts plus an offset (position units). The offset is a fraction of a count,
/// a moving reference or dither.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Setpoint<N> {
    /// Counts, wrapping at 32 bits as the sensor's do.
    pub count: i32,
    /// The offset, position units.
    pub offset: N,
}

impl<N: Number> Setpoint<N> {
    /// The position error at a count, machine units: the whole counts and the offset, less the count.
    ///
    /// Counts may wrap: setpoint and position are never further apart than half of 32 bits. So a setpoint keeps every
    /// fraction of a count at any number of turns, and there is no origin to move.
    #[inline]
    #[must_use]
    pub fn error(&self, count: i32) -> N {
        N::from_count(self.count.wrapping_sub(count)) + self.offset
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measurement::velocity::LowPass;
    use crate::units::Units;
    use proptest::prelude::*;

    /// With a filter of the reference, s, at 1 kHz, in counts of 1 mrad.
    fn controller(kp: f64, kd: f64, ki: f64, filter: f64) -> Controls {
        let units = Units::new(1e-3, 1e-3).expect("valid");
        let gains = Gains::new(kp, kd, ki).expect("valid");
        let velocity = LowPass::new(&units, 500.0).expect("valid");
        let filter = ReferenceFilter::new(&units, filter).expect("valid");
        let shaped = Shaped::new(filter, FeedForward::default(), Notch::NONE);
        Controller::new(&units, &gains, &CommandLimit::NONE, velocity).with_shaping(shaped)
    }

    type Controls = Controller<f32, LowPass<f32>, Shaped<f32>>;

    #[test]
    fn a_controller_with_other_gains_takes_over_in_the_middle_of_a_step_without_a_bump() {
        const STEP: f32 = 1000.0;
        const INCREMENT: f32 = 2.0;
        let mut position = 0.0;
        let mut process = |of: &Controls, state: &mut _| {
            position += INCREMENT;
            let sample = of.process(state, STEP - position, INCREMENT);
            sample.expect("in range")
        };
        let before = controller(9.0, 0.19, 4.0, 0.05);
        let after = controller(12.0, 0.3, 60.0, 0.2);
        let mut state = ControlState::default();
        let mut last = process(&before, &mut state);
        for _ in 0..40 {
            last = process(&before, &mut state);
        }
        let mut state = after.take_over(&last);
        let next = process(&after, &mut state);
        // The filtered reference goes on by a 200th of what is left of the step, and the servo by its increment.
        let left = STEP - (position - INCREMENT + last.error);
        let expected = last.error - INCREMENT + left / 200.0;
        assert!(left > 300.0 && (next.error - expected).abs() < 0.01 * left / 200.0);
        let moved = 12e-3 * (next.error - last.error);
        let bump = next.command - last.command - moved;
        assert!(bump.abs() < 1e-3, "{last:?} {next:?}");
    }

    proptest! {
        #[test]
        fn an_error_is_exact_at_any_count_and_through_the_wrap(
            count: i32,
            apart in -1_000_000_i32..1_000_000,
            quarters in 0_i32..4,
        ) {
            let offset = f64::from(quarters) / 4.0;
            let setpoint = Setpoint {
                count: count.wrapping_add(apart),
                offset: offset as f32,
            };
            let error = setpoint.error(count);
            prop_assert_eq!(f64::from(error).to_bits(), (f64::from(apart) + offset + 0.0).to_bits());
        }
    }
}
