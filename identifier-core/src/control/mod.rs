//! The real loop: the PID that the user already trusts, closed around the servo.

mod gains;
mod limit;
mod pid;

pub use gains::Gains;
pub use limit::CommandLimit;
pub use pid::{Command, Pid};

use crate::error::StepError;
use crate::measurement::velocity::VelocityEstimate;
use crate::number::{Number, RunningSum};

/// The sampled controller: velocity estimate and PID.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Controller<N, V> {
    /// The control law.
    pub pid: Pid<N>,
    /// The velocity estimate the derivative acts on.
    pub velocity: V,
}

/// What the controller remembers between samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ControlState<N: Number, S> {
    position: N,
    velocity: N,
    integral: N::Sum,
    filter: S,
}

impl<N: Number, S: Default> ControlState<N, S> {
    /// At rest at a position (machine units), integral empty.
    #[must_use]
    pub fn at_rest(position: N) -> Self {
        Self {
            position,
            velocity: N::ZERO,
            integral: N::Sum::new(N::ZERO),
            filter: S::default(),
        }
    }

    /// The velocity estimate of the last sample.
    #[must_use]
    pub fn velocity(&self) -> N {
        self.velocity
    }

    /// Whether the loop has done nothing yet: no velocity, no integral. A servo that only stands for
    /// the moment has an integral.
    #[must_use]
    pub fn is_fresh(&self) -> bool {
        self.velocity == N::ZERO && self.integral.value() == N::ZERO
    }

    /// The state of the velocity estimate.
    #[must_use]
    pub fn filter(&self) -> &S {
        &self.filter
    }

    /// With an integral ∑e that a controller has gathered before, machine units.
    #[must_use]
    pub fn with_integral(self, integral: N) -> Self {
        Self {
            integral: N::Sum::new(integral),
            ..self
        }
    }

    /// Follows a move of the origin by `moved` (machine units): see
    /// [`Origin::follow`](crate::measurement::origin::Origin::follow).
    ///
    /// The position of the last sample is all in the loop that knows of an origin.
    pub fn shift_origin(&mut self, moved: N) {
        self.position = self.position - moved;
    }
}

/// One sample of the real loop, as the model loop needs it.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ControlSample<N> {
    /// Position error e = q_d − q.
    pub error: N,
    /// Increment of the measured position since the last sample.
    pub increment: N,
    /// Velocity estimate.
    pub velocity: N,
    /// The integral ∑e that this sample's command was computed with.
    pub integral: N,
    /// The command u.
    pub command: N,
    /// Whether the integral took this sample's error (anti-windup holds it otherwise).
    pub integrates: bool,
    /// A known signal that is added to the command behind the controller and its limit; zero
    /// unless the caller sets it.
    pub injection: N,
}

impl<N: Number, V: VelocityEstimate<N>> Controller<N, V> {
    /// One sample: reference and measured position (machine units, same origin) to command.
    ///
    /// # Errors
    /// [`StepError`] when an input is not finite or beyond the range of the number format; the
    /// state is then untouched.
    #[inline]
    pub fn process(
        &self,
        state: &mut ControlState<N, V::State>,
        reference: N,
        position: N,
    ) -> Result<ControlSample<N>, StepError> {
        let error = reference - position;
        let increment = position - state.position;
        // One comparison for both; it fails for what is no number.
        let within = error.magnitude() + increment.magnitude() <= N::REACH;
        if !within {
            return Err(Self::refusal(reference, position));
        }
        let velocity = self.velocity.process(&mut state.filter, increment);
        let integral = state.integral.value();
        let command = self.pid.command(error, velocity, integral);
        if command.integrates {
            state.integral.add(error);
        }
        state.position = position;
        state.velocity = velocity;
        Ok(ControlSample {
            error,
            increment,
            velocity,
            integral,
            command: command.value,
            integrates: command.integrates,
            injection: N::ZERO,
        })
    }

    #[cold]
    fn refusal(reference: N, position: N) -> StepError {
        if !reference.is_finite() {
            StepError::ReferenceNotFinite
        } else if !position.is_finite() {
            StepError::PositionNotFinite
        } else {
            StepError::TooFarApart
        }
    }
}
