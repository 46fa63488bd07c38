use super::FrictionBalance;
use super::line::product;
use identifier_core::number::Number;

/// A sample of the servo.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::commission) struct ResponseWindows<N> {
    pub(in crate::commission) position: N,
    pub(in crate::commission) increment: N,
    /// A smoothed velocity.
    pub(in crate::commission) velocity: N,
    /// The command that acts from now on.
    pub(in crate::commission) command: N,
    /// True if the governor has changed the command.
    pub(in crate::commission) is_cut: bool,
}

/// The window of a motion: Hann's weight h_k = 1 − cos(2πk/n), and the mean motion.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Window<N> {
    /// e^(j2πk/n).
    turned: [N; 2],
    /// ∑ h_k Δq_k, ∑ sin(2πk/n) Δq_k and ∑ h_k u_k.
    beneath: [N; 3],
    /// The farthest that the servo was from its reference.
    pub(super) farthest: N,
}

impl<N: Number> Window<N> {
    /// Before its first sample.
    pub(super) fn begin() -> Self {
        Self {
            turned: [N::ONE, N::ZERO],
            ..Self::default()
        }
    }

    /// Takes a sample; its increment and its command, weighted. `rotation` is e^(j2π/n).
    #[inline(always)]
    pub(super) fn take(&mut self, sample: &ResponseWindows<N>, rotation: [N; 2]) -> [N; 2] {
        let [cosine, sine] = self.turned;
        let weight = N::ONE - cosine;
        self.turned = product(self.turned, rotation);
        let (increment, command) = (weight * sample.increment, weight * sample.command);
        self.beneath[0] += increment;
        self.beneath[1] += sine * sample.increment;
        self.beneath[2] += command;
        [increment, command]
    }

    /// The balance of a finished window of n samples: ∑ h_k = n, and the mean of h_k v̇_k is that of −ḣ_k v_k.
    pub(super) fn balance(&self, samples: u32) -> FrictionBalance<N> {
        let [distance, change, command] = self.beneath;
        let per_sample = N::from_count(samples as i32).reciprocal();
        let angle = N::from_f64(-core::f64::consts::TAU) * per_sample;
        FrictionBalance {
            velocity: distance * per_sample,
            acceleration: angle * change * per_sample,
            command: command * per_sample,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A servo of c and d that accelerates evenly needs u = (v̇ + a v + c − d)/b. The mean with Hann's weight is that in the
    /// middle, and the command is linear in time.
    #[test]
    fn the_balance_of_an_even_acceleration_is_exact() {
        const SAMPLES: u32 = 500;
        let (first, acceleration) = (20.0, 0.004);
        let command_at = |velocity: f64| 0.3 + 0.01 * velocity;
        let angle = core::f64::consts::TAU / f64::from(SAMPLES);
        let mut window = Window::<f64>::begin();
        for k in 0..SAMPLES {
            let velocity = first + acceleration * f64::from(k);
            let sample = ResponseWindows {
                position: 0.0,
                increment: velocity,
                velocity,
                command: command_at(velocity),
                is_cut: false,
            };
            window.take(&sample, [libm::cos(angle), libm::sin(angle)]);
        }
        let balance = window.balance(SAMPLES);
        let middle = first + acceleration * 0.5 * f64::from(SAMPLES);
        std::println!("{balance:?} {middle}");
        assert!((balance.velocity / middle - 1.0).abs() < 1e-9);
        assert!((balance.acceleration / acceleration - 1.0).abs() < 1e-4);
        assert!((balance.command / command_at(middle) - 1.0).abs() < 1e-9);
    }
}
