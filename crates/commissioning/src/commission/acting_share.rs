use super::RoughModel;
use identifier_core::number::Number;

/// The part of a command's effect that the first half of a step shows. It is one for a sound actuator, less for a weak
/// one.
///
/// With x counts since the servo departed, n samples before, and u beyond the command that balances the load,
///
/// x + a ∑x + c n²/2 = share b ∑∑u.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct ActingShare<N> {
    /// The counts up to which it is measured.
    half: N,
    samples: N,
    gone: N,
    gone_sum: N,
    command_sum: N,
    command_double_sum: N,
}

impl<N: Number> ActingShare<N> {
    /// The counts from which on a servo has departed.
    const DEPARTED: f64 = 2.0;

    /// The least share of an actuator that is not weak. Delay, and friction that is higher at low speed, reduce it too.
    const SOUND: f64 = 0.55;

    /// The least effect that is evidence, counts.
    const TELLING: f64 = 14.0;

    /// For a step of this size, counts.
    pub(super) fn new(step: N) -> Self {
        Self {
            half: N::from_f64(0.5) * step,
            ..Self::default()
        }
    }

    /// Takes the counts since the step began and the command beyond the load's. Both are positive towards the step.
    pub(super) fn take(&mut self, gone: N, command: N) {
        let departs = gone >= N::from_f64(Self::DEPARTED);
        if self.gone >= self.half || (self.samples == N::ZERO && !departs) {
            return;
        }
        self.samples += N::ONE;
        self.gone = gone;
        self.gone_sum += gone;
        self.command_sum += command;
        self.command_double_sum += self.command_sum;
    }

    /// True if much less of the command acts on this servo than of a sound actuator's.
    pub(super) fn is_weak(&self, servo: &RoughModel<N>) -> bool {
        let braked = N::from_f64(0.5) * self.samples * self.samples * servo.coulomb();
        let acts = self.gone + servo.viscous * self.gone_sum + braked;
        let force = servo.gain * self.command_double_sum;
        force >= N::from_f64(Self::TELLING) && acts < N::from_f64(Self::SOUND) * force
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use identifier_core::parameters::ServoParameters;

    const TIME: f64 = 1e-3;
    const RESOLUTION: f64 = 1e-4;

    /// True if a servo is found weak. A share of its command acts, one or more samples late, under a command that
    /// steps.
    fn is_weak(share: f64, delay: usize) -> bool {
        let parameters = ServoParameters::new(4.0, 300.0, 60.0, 20.0);
        let servo = RoughModel::<f64>::from_si(&parameters, TIME, RESOLUTION);
        let mut measured = ActingShare::new(400.0);
        let commands: [f64; 400] = core::array::from_fn(|k| if k < 40 { 2.0 } else { 0.8 });
        let (mut position, mut velocity) = (0.0, 0.0);
        for k in 0..commands.len() {
            measured.take(libm::floor(position), commands[k]);
            let late = k.checked_sub(delay).map_or(0.0, |k| commands[k]);
            velocity += servo.acceleration(share * late + servo.holding(), velocity);
            velocity = velocity.max(0.0);
            position += velocity;
        }
        measured.is_weak(&servo)
    }

    #[test]
    fn a_share_of_less_than_a_half_is_weak() {
        for delay in [0, 1, 3] {
            for share in [0.7, 0.85, 1.0, 1.3] {
                assert!(!is_weak(share, delay), "{share} {delay}");
            }
            for share in [0.35, 0.4, 0.45] {
                assert!(is_weak(share, delay), "{share} {delay}");
            }
        }
    }

    #[test]
    fn a_servo_that_never_moved_shows_no_share() {
        let servo = RoughModel::<f64>::default();
        let mut measured = ActingShare::new(400.0);
        assert!(!measured.is_weak(&servo));
        measured.take(0.0, 1.0);
        assert!(!measured.is_weak(&servo));
    }
}
