use identifier_core::model::{FrictionStep, ServoParameters};

/// A servo whose parameters do not change: q̈ = −a q̇ + b u + d − c sign(q̇) from sample to sample, in the
/// core's exact step, for a command that is held.
///
/// Whatever the model of the identifiers learns to contain belongs into [`advance`](Self::advance), and
/// nowhere else.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrozenServo {
    step: FrictionStep<f64>,
    /// a T.
    x: f64,
    /// b T², d T², c T², rad.
    gain: f64,
    load: f64,
    coulomb: f64,
}

/// Where a servo is, and how fast.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct State {
    /// Position, rad.
    pub position: f64,
    /// Velocity, rad a sample.
    pub velocity: f64,
}

impl FrozenServo {
    /// A servo with these parameters in samples of `sample_time`, s. A friction below zero is none.
    #[must_use]
    pub fn new(servo: &ServoParameters, sample_time: f64) -> Self {
        let square = sample_time * sample_time;
        Self {
            step: FrictionStep::new(),
            x: servo.a * sample_time,
            gain: servo.b * square,
            load: servo.load * square,
            coulomb: servo.coulomb.max(0.0) * square,
        }
    }

    /// One sample under a held command.
    pub fn advance(&self, state: &mut State, command: f64) {
        let drive = self.gain * command + self.load;
        let (motion, _) = self
            .step
            .process(self.x, drive, self.coulomb, state.velocity);
        state.position += motion.increment;
        state.velocity = motion.velocity;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use virtual_servo::Plant;

    /// The servo of the simulator, which was written apart from the core's model.
    #[test]
    fn it_moves_as_the_simulated_servo_does() {
        let servo = ServoParameters {
            a: 0.2174,
            b: 257.7,
            load: 20.0,
            coulomb: 10.0,
        };
        let frozen = FrozenServo::new(&servo, 1e-3);
        let (mut state, mut plant) = (State::default(), Plant::at_rest(&servo, 1e-3));
        let mut most: f64 = 0.0;
        for k in 0..20_000_u32 {
            let time = 1e-3 * f64::from(k);
            let command = 0.3 * libm::sin(7.0 * time) - 0.08;
            frozen.advance(&mut state, command);
            plant.advance(command);
            most = most.max((state.position - plant.position).abs());
        }
        assert!(plant.position.abs() > 0.1, "{}", plant.position);
        assert!(most < 1e-6, "{most}");
    }
}
