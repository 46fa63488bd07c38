//! Reference signals for experiments, besides the drive's own
//! [`Prbs`](identifier_core::excitation::Prbs), and the random source of all noise.

mod chirp;
mod multisine;
mod oscillator;
mod square;
mod steps;
mod white_noise;

pub use chirp::{Chirp, ChirpState};
pub use multisine::{Multisine, MultisineState, SineTone};
pub use square::{Square, SquareState};
pub use steps::{Steps, StepsState};
pub use white_noise::{BandLimitedWhiteNoise, BandLimitedWhiteNoiseState, NormalSource};

#[cfg(test)]
mod tests {
    use identifier_core::excitation::Excitation;
    use identifier_core::units::Units;

    use super::*;

    #[track_caller]
    fn assert_is<E: Excitation<f64>>(
        signal: &E,
        samples: u32,
        most: f64,
        exact: impl Fn(u32) -> f64,
    ) {
        let mut state = signal.start();
        for k in 0..samples {
            let off = signal.process(&mut state) - exact(k);
            assert!(off.abs() < most, "sample {k}: {off:e}");
        }
    }

    #[test]
    fn each_signal_is_its_closed_form_in_counts() {
        let units = Units::new(1e-3, 0.5).expect("valid");
        let square = Square::new(&units, 0.25, 0.02).expect("valid");
        assert_is(&square, 100, 1e-15, |k| [0.5, -0.5][k as usize / 10 % 2]);
        let steps = Steps::<_, 4>::new(&units, &[0.1, -0.2, 0.3], 5e-3).expect("valid");
        assert_is(&steps, 100, 1e-15, |k| [0.2, -0.4, 0.6][k as usize / 5 % 3]);
        let tone = SineTone {
            amplitude: 0.3,
            frequency: 40.0,
        };
        let sine = Multisine::<_, 4>::new(&units, &[tone]).expect("valid");
        let exact = |k| 0.6 * libm::sin(40.0 * 1e-3 * f64::from(k));
        assert_is(&sine, 10_000, 1e-8, exact);
        for (from, to) in [(2.0, 60.0), (60.0, 2.0)] {
            let chirp = Chirp::new(&units, 0.5, from, to, 4.0).expect("valid");
            // Phase of a frequency that rises by equal steps each sample. It starts again without a jump.
            let phase = |k: u32| {
                let k = f64::from(k);
                1e-3 * (from * k + (to - from) * k * (k - 1.0) / 8000.0)
            };
            let both = |k: u32| phase(k.min(4000)) + phase(k.saturating_sub(4000));
            assert_is(&chirp, 5000, 1e-8, |k| libm::sin(both(k)));
        }
    }

    #[test]
    fn a_square_of_an_odd_period_is_refused() {
        let units = Units::new(1e-3, 1.0).expect("valid");
        let error = Square::<f64>::new(&units, 1.0, 0.025).expect_err("25 samples");
        assert_eq!(error.parameter, "period");
        assert!((error.value - 0.025).abs() < 1e-15);
    }
}
