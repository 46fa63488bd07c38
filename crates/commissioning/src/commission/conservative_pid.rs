use super::gains::Loop;
use super::{Limits, RoughModel};
use identifier_core::measurement::LowPass;
use identifier_core::number::Number;
use identifier_core::units::Units;

/// Gains that hold a servo during its study, with a double pole at −ω and one at −ω/5. They are placed for the present
/// estimate, which may be rough.
///
/// They are computed in the sample of the takeover, hence in the working number and in machine units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ConservativePid<N> {
    /// Lowest and highest command.
    limit: [N; 2],
    /// The change of the command that a count of the encoder may make, over (k_p + k_d ω_c)/(ω²/b).
    quantisation_gain: N,
    /// The largest ω T.
    max_bandwidth: N,
}

impl<N: Number> ConservativePid<N> {
    /// The largest ω T: unknown delays of some samples cost little phase.
    pub(super) const MAX_BANDWIDTH_PER_SAMPLE: f64 = 0.08;

    /// The largest ω, rad/s: a servo at rest asks for no more.
    pub(super) const MAX_BANDWIDTH: f64 = 250.0;

    /// The part of its bandwidth that a loop keeps whose servo oscillates.
    pub(super) const REDUCED_BANDWIDTH: f64 = 0.4;

    /// The part of the command that a count of the encoder may change.
    const MAX_QUANTISATION_SHARE: f64 = 0.1;

    /// The cut-off of the velocity estimate over ω.
    const CUTOFF: f64 = 6.0;

    /// The slow pole over ω.
    const SLOW_POLE: f64 = 0.2;

    /// k_p, k_d and k_i over ω²/b, ω/b and ω³/b for these poles, without viscous friction.
    const PLACED: [f64; 3] = [
        1.0 + 2.0 * Self::SLOW_POLE,
        2.0 + Self::SLOW_POLE,
        Self::SLOW_POLE,
    ];

    /// Within these limits.
    pub(super) fn new(units: &Units, limits: &Limits) -> Self {
        let [low, high] = limits.command;
        let [proportional, derivative, _] = Self::PLACED;
        let through_the_filter = proportional + derivative * Self::CUTOFF;
        Self {
            limit: limits.command.map(N::from_f64),
            quantisation_gain: N::from_f64(
                Self::MAX_QUANTISATION_SHARE * high.min(-low) / through_the_filter,
            ),
            max_bandwidth: N::from_f64(Self::MAX_BANDWIDTH * units.rate()),
        }
    }

    /// The largest ω T of all.
    pub(super) fn max_bandwidth(&self) -> N {
        self.max_bandwidth
    }

    /// The loop, with an ω T up to `bandwidth`, for a servo with a delay of its commands, samples. None if no loop
    /// holds it.
    pub(super) fn around(&self, servo: &RoughModel<N>, delay: N, bandwidth: N) -> Option<Loop<N>> {
        let bandwidth = bandwidth.smaller(self.max_bandwidth);
        let quarter = N::from_f64(0.25);
        let sampled =
            N::from_f64(Self::MAX_BANDWIDTH_PER_SAMPLE) * (N::ONE + quarter * delay).reciprocal();
        let noise = servo.gain * self.quantisation_gain;
        let quiet = noise * noise.reciprocal_root();
        let omega = sampled.smaller(quiet).smaller(bandwidth);
        let [proportional, derivative, integral] = Self::PLACED.map(N::from_f64);
        let damping = derivative * omega - servo.viscous;
        let gains = [
            proportional * omega * omega * servo.per_gain,
            damping.limited(N::ZERO, N::REACH) * servo.per_gain,
            integral * omega * omega * omega * servo.per_gain,
        ];
        let cutoff = N::from_f64(Self::CUTOFF) * omega;
        let usable = gains.iter().all(|gain| gain.is_finite()) && gains[0] > N::ZERO;
        usable.then(|| Loop::in_machine_units(gains, self.limit, low_pass(cutoff)))
    }

    /// The ω T of a loop of these.
    pub(super) fn bandwidth(controller: &Loop<N>) -> N {
        let passed = controller.velocity.passed();
        let cutoff = passed * (N::ONE - passed).reciprocal();
        N::from_f64(1.0 / Self::CUTOFF) * cutoff
    }

    /// A loop of these with a part of its bandwidth.
    pub(super) fn slower(controller: &Loop<N>, part: N) -> Loop<N> {
        let factors = [part * part, part, part * part * part];
        let cutoff = N::from_f64(Self::CUTOFF) * part * Self::bandwidth(controller);
        controller.scaled(factors, low_pass(cutoff))
    }
}

/// With a cut-off ω_c T and the pole of the backward difference. An exponential is expensive where there is no other.
fn low_pass<N: Number>(cutoff: N) -> LowPass<N> {
    LowPass::passing(cutoff * (N::ONE + cutoff).reciprocal())
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::commission::HoldingGains;
    use identifier_core::measurement::VelocityEstimate;
    use identifier_core::parameters::ServoParameters;
    use identifier_core::settings::ControllerSettings;

    pub(in crate::commission) const LIMITS: Limits = Limits::new([-1.0, 1.0], 20.0, [-8.0, 10.0]);

    /// The widest loop for a servo of a gain, at a sample time. `counts` are those per turn, and the delay is in
    /// samples.
    pub(in crate::commission) fn loop_for(b: f64, time: f64, counts: f64, delay: f64) -> Loop<f64> {
        let resolution = core::f64::consts::TAU / counts;
        let units = Units::new(time, resolution).expect("valid");
        let parameters = ServoParameters::new(0.5, b, 10.0, 3.0);
        let servo = RoughModel::from_si(&parameters, time, resolution);
        let conservative = ConservativePid::new(&units, &LIMITS);
        let most = conservative.max_bandwidth();
        conservative
            .around(&servo, delay, most)
            .expect("it can be held")
    }

    #[test]
    fn the_poles_are_placed_in_si_as_they_are_in_machine_units() {
        // Slow enough for the largest ω to bind: 0.08/(1e-4 (1 + 2/4)) = 533 rad/s.
        let (time, counts, b) = (1e-4, 1e6, 200.0);
        let omega = ConservativePid::<f64>::MAX_BANDWIDTH;
        let expected = HoldingGains {
            controller: ControllerSettings {
                limit: LIMITS.command,
                ..ControllerSettings::pid(
                    1.4 * omega * omega / b,
                    (2.2 * omega - 0.5) / b,
                    0.2 * omega * omega * omega / b,
                )
            },
            cutoff: 6.0 * omega,
        };
        let units = Units::new(time, core::f64::consts::TAU / counts).expect("valid");
        let expected: Loop<f64> = expected.build(&units).expect("valid");
        let placed = loop_for(b, time, counts, 2.0);
        for (error, velocity, integral) in [(1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)] {
            let [own, other] =
                [placed, expected].map(|controller| wanted(&controller, error, velocity, integral));
            assert!((own / other - 1.0).abs() < 1e-6, "{own} {other}");
        }
        let [own, other] = [placed, expected].map(|one| one.velocity.transfer().pole);
        // x/(1 + x) for 1 − e^(−x).
        assert!((own - other).abs() < 0.02, "{own} {other}");
    }

    #[test]
    fn a_count_of_a_coarse_encoder_changes_little_of_the_command() {
        let quantisation_gain = |counts: f64| {
            let controller = loop_for(5000.0, 1e-3, counts, 0.0);
            let velocity = 1.0 - controller.velocity.transfer().pole;
            controller.linear(1.0, -velocity)
        };
        assert!(
            quantisation_gain(1000.0) < 0.1 * 8.0,
            "{}",
            quantisation_gain(1000.0)
        );
        assert!(quantisation_gain(1e5) < 0.1 * quantisation_gain(1000.0));
    }

    /// The command without limit.
    fn wanted(controller: &Loop<f64>, error: f64, velocity: f64, integral: f64) -> f64 {
        controller.linear(error, velocity) + integral / controller.integral_for(1.0, 0.0, 0.0)
    }

    #[test]
    fn a_late_servo_is_held_more_slowly() {
        let stiffness = |delay: f64| loop_for(200.0, 1e-3, 1e5, delay).linear(1.0, 0.0);
        assert!((stiffness(4.0) / stiffness(0.0) - 0.25).abs() < 1e-6);
    }

    #[test]
    fn a_slower_loop_is_the_one_that_is_placed_with_less_bandwidth() {
        let (time, resolution) = (1e-4, core::f64::consts::TAU / 1e6);
        let units = Units::new(time, resolution).expect("valid");
        let parameters = ServoParameters::new(0.0, 200.0, 10.0, 3.0);
        let servo = RoughModel::from_si(&parameters, time, resolution);
        let conservative = ConservativePid::<f64>::new(&units, &LIMITS);
        let within = |bandwidth| {
            conservative
                .around(&servo, 2.0, bandwidth)
                .expect("it can be held")
        };
        let most = conservative.max_bandwidth();
        let (slower, placed) = (
            ConservativePid::slower(&within(most), 0.3),
            within(0.3 * most),
        );
        for (error, velocity, integral) in [(1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)] {
            let [own, other] = [slower, placed].map(|one| wanted(&one, error, velocity, integral));
            assert!((own / other - 1.0).abs() < 1e-9, "{own} {other}");
        }
        let [own, other] = [slower, placed].map(|one| ConservativePid::bandwidth(&one) / most);
        assert!(
            (own - 0.3).abs() < 1e-9 && (other - 0.3).abs() < 1e-9,
            "{own} {other}"
        );
    }

    #[test]
    fn a_servo_that_no_loop_holds_gets_no_gains() {
        let units = Units::new(1e-3, 1e-3).expect("valid");
        let conservative = ConservativePid::<f32>::new(&units, &LIMITS);
        let most = conservative.max_bandwidth();
        assert_eq!(conservative.around(&RoughModel::default(), 2.0, most), None);
    }
}
