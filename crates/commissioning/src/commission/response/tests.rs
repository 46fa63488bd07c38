//! Lines of known servos, as their samples show them, with noise.

use std::f64::consts::TAU;
use std::vec::Vec;

use super::{MeasuredResponse, ResponseEstimate, ResponseFit};
use crate::commission::frequency_response::{FrictionBalance, LineSearch, LineSums, Lines};
use crate::commission::{CommissionSettings, Limits};
use identifier_core::number::Complex;
use identifier_core::parameters::{IdentifiedServo, ServoParameters};
use identifier_core::tuning::{MeasuredLine, Mode};
use virtual_servo::SplitMix64;

const SAMPLE_TIME: f64 = 1e-4;
const B: f64 = 400.0;
const A: f64 = 2.0;
const DELAY: f64 = 2.3e-4;
const LAG: f64 = 1e-4;

/// b (1/(s (s + a)) + β/(s² + 2ζωs + ω²)) e^(−sτ)/(1 + sT_c) behind the hold, sampled as the sum over the images.
fn response(mode: Option<&Mode>, frequency: f64) -> Complex {
    /// Images on either side. The rest falls with the square of their number.
    const IMAGES: i32 = 40;
    let s_of = |image: i32| Complex {
        re: 0.0,
        im: frequency + f64::from(image) * TAU / SAMPLE_TIME,
    };
    let hold = Complex::ONE - s_of(0).scaled(-SAMPLE_TIME).exponential();
    let images = (-IMAGES..=IMAGES).map(|image| {
        let s = s_of(image);
        let together = Complex::ONE / (s * (s + A));
        let servo = match mode {
            Some(mode) => {
                let denominator = s * s
                    + s.scaled(2.0 * mode.damping * mode.frequency)
                    + mode.frequency * mode.frequency;
                together + Complex::ONE.scaled(mode.ratio) / denominator
            }
            None => together,
        };
        let late = s.scaled(-DELAY).exponential() / (s.scaled(LAG) + 1.0);
        servo * late * hold / s.scaled(SAMPLE_TIME)
    });
    let zero = Complex { re: 0.0, im: 0.0 };
    images
        .fold(zero, |sum: Complex, image| sum + image)
        .scaled(B)
}

/// The estimate from lines with a relative noise, beginning with a gain.
fn shown(mode: Option<&Mode>, noise: f64, gain: f64) -> ResponseEstimate {
    shown_through(mode, &|_| noise, gain)
}

/// The same with a noise that depends on the frequency, rad/s.
fn shown_through(mode: Option<&Mode>, noise: &dyn Fn(f64) -> f64, gain: f64) -> ResponseEstimate {
    let mut random = SplitMix64::new(7);
    let lines: Vec<MeasuredLine> = LineSearch::first_pass(SAMPLE_TIME, 1.0)
        .all()
        .frequencies()
        .map(|frequency| {
            let exact = response(mode, frequency);
            let size = noise(frequency) * exact.power().sqrt();
            let mut uniform = || 1.2247 * size * random.uniform(-1.0, 1.0);
            MeasuredLine {
                frequency,
                gain: exact
                    + Complex {
                        re: uniform(),
                        im: uniform(),
                    },
                deviation: size,
            }
        })
        .collect();
    let servo = IdentifiedServo {
        unexplained: 1e-4,
        ..IdentifiedServo::known(ServoParameters::new(A, gain, 20.0, 0.0), 4e-4)
    };
    let mut fit = ResponseFit::begin(&lines, &servo, false, SAMPLE_TIME).expect("enough lines");
    for _ in 0..60_000 {
        if let Some(estimate) = fit.work(&lines) {
            return estimate;
        }
    }
    panic!("it does not end");
}

#[test]
fn two_masses_are_found_with_frequency_and_gain_within_their_errors() {
    for (hertz, damping, ratio) in [
        (25.0, 0.02, 0.5),
        (90.0, 0.01, 3.0),
        (300.0, 0.05, 0.3),
        (600.0, 0.008, 1.0),
    ] {
        let mode = Mode {
            frequency: TAU * hertz,
            damping,
            ratio,
        };
        for (noise, gain) in [(0.01, B), (0.05, 1.4 * B)] {
            let found = shown(Some(&mode), noise, gain);
            let resonance = found.resonance.expect("two masses");
            let off = resonance.mode.frequency / mode.frequency - 1.0;
            let error = resonance.errors[0];
            assert!(
                off.abs() < (3.0 * error).max(2e-3) && error < 0.03,
                "{hertz} Hz: {off} {error}"
            );
            assert!(
                (found.gain / B).ln().abs() < (4.0 * found.gain_error).max(0.02),
                "{hertz} Hz: {}",
                found.gain
            );
            let [delay, _] = found.delay;
            assert!((delay - DELAY - LAG).abs() < 1e-4, "{delay}");
        }
    }
}

/// The lines show where the antiresonance is; whatever resonance they end on, its error does not claim more.
#[test]
fn a_resonance_that_no_line_shows_is_uncertain() {
    let mode = Mode {
        frequency: TAU * 300.0,
        damping: 0.02,
        ratio: 3.0,
    };
    for most in [0.1, 1.0] {
        let noise = |frequency: f64| if frequency < TAU * 200.0 { 0.03 } else { most };
        let resonance = shown_through(Some(&mode), &noise, B).resonance;
        let [error, _] = resonance.expect("two masses").errors;
        assert_eq!(error >= 0.1, most > 0.2, "{most}: {error}");
    }
}

#[test]
fn one_mass_shows_no_resonance() {
    for noise in [0.0, 0.01, 0.1, 0.3] {
        let found = shown(None, noise, 0.8 * B);
        assert_eq!(found.resonance, None, "{noise}");
        assert!(
            (found.gain / B - 1.0).abs() < 0.02 + 0.3 * noise,
            "{}",
            found.gain
        );
        assert!(found.misfit < 1.5, "{}", found.misfit);
    }
}

/// b u = v̇ + a v ± c − d of each motion, of means in counts and samples.
#[test]
fn friction_and_load_are_those_that_balance_the_response_motions() {
    const RESOLUTION: f64 = 1e-4;
    let truth = ServoParameters::new(A, B, 60.0, -25.0);
    let limits = Limits::new([-1.0, 1.0], 15.0, [-10.0, 10.0]);
    let settings = CommissionSettings::new(SAMPLE_TIME, RESOLUTION, limits);
    let mut response = MeasuredResponse::<f64>::none();
    response.restart(&settings);
    let mut response_motion = |velocity: f64, acceleration: f64| {
        let needed = acceleration + A * velocity + truth.coulomb.copysign(velocity) - truth.load;
        response.take_balance(&FrictionBalance {
            velocity: velocity * SAMPLE_TIME / RESOLUTION,
            acceleration: acceleration * SAMPLE_TIME * SAMPLE_TIME / RESOLUTION,
            command: needed / B,
        });
        response.friction(&truth)
    };
    assert_eq!(response_motion(3.0, 1.5), None);
    assert_eq!(response_motion(2.0, -0.7), None);
    for velocity in [-3.0, -2.5] {
        let [coulomb, load] = response_motion(velocity, 4.0).expect("both ways");
        assert!((coulomb - truth.coulomb).abs() < 1e-9, "{coulomb}");
        assert!((load - truth.load).abs() < 1e-9, "{load}");
    }
}

/// Measures lines in so many motions that all show the same.
fn measure(measured: &mut MeasuredResponse<f64>, lines: &Lines, beside: bool, motions: u8) {
    measured.begin(lines, beside);
    for line in (0..lines.count() as u8).flat_map(|line| (0..motions).map(move |_| line)) {
        measured.take(&LineSums {
            line,
            inverted: false,
            position: [1.0, 0.0],
            command: [1.0, 0.0],
        });
    }
    let mut measuring = measured.begin_lines();
    while !measured.measure(&mut measuring) {}
}

#[test]
fn lines_take_the_place_of_those_before_up_to_their_highest() {
    let first = LineSearch::first_pass(SAMPLE_TIME, 1.0).all();
    let (between, low) = (
        LineSearch::between(SAMPLE_TIME, 1.0, 0.0).all(),
        LineSearch::low(SAMPLE_TIME).all(),
    );
    let limits = Limits::new([-0.5, 0.5], 15.0, [-10.0, 10.0]);
    let settings = CommissionSettings::new(SAMPLE_TIME, 1e-3, limits);
    for (lines, beside, motions) in [
        (&between, false, 2),
        (&low, false, 2),
        (&between, true, 2),
        (&between, false, 0),
    ] {
        let mut measured = MeasuredResponse::none();
        measured.restart(&settings);
        measure(&mut measured, &first, false, 2);
        measure(&mut measured, lines, beside, motions);
        let highest = lines.frequencies().last().expect("lines");
        let kept = |&frequency: &f64| beside || motions == 0 || frequency > highest;
        let shown = lines.frequencies().filter(|_| motions > 0);
        let mut expected: Vec<f64> = first.frequencies().filter(kept).chain(shown).collect();
        expected.sort_by(f64::total_cmp);
        let seen: Vec<f64> = measured.lines().iter().map(|line| line.frequency).collect();
        assert!(expected.len() > 10);
        assert_eq!(seen, expected, "{beside} {motions}");
    }
}
