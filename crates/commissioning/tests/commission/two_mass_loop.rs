//! The sampled loop of applied gains around the true servo of two masses, by its frequency response.
//!
//! As one rigid body of inertia 1 with the load a share ρ: (1 − ρ) q̈ = b i − a q̇ + K w + D ẇ, ρ (q̈ + ẅ) = −K w − D ẇ,
//! K = ω² ρ (1 − ρ), D = 2 ζ ω ρ (1 − ρ), w being the twist and i the command behind the current loop and the delay. The
//! response of the samples is the sum over the images of the held command.

use std::f64::consts::{PI, TAU};

use identifier_core::number::Complex;
use identifier_core::parameters::{IdentifiedServo, ServoParameters};
use identifier_core::tuning::{Tuning, TuningSettings};
use virtual_servo::Effects;

use super::rig::Bench;
use super::two_masses::hidden;

const J: Complex = Complex { re: 0.0, im: 1.0 };

/// Images on either side. The rest falls with the square of their number.
const IMAGES: i32 = 40;

/// Frequencies of the whole range, and about each of resonance and antiresonance.
const FREQUENCIES: usize = 1500;
const NEAR: i32 = 150;

/// The loop of gains around a servo of two masses.
#[derive(Debug, Clone, Copy)]
pub(crate) struct TwoMassLoop {
    servo: ServoParameters,
    effects: Effects,
    damping: f64,
    sample_time: f64,
    tuning: Tuning,
}

fn exponential(angle: f64) -> Complex {
    Complex::new(angle.cos(), angle.sin())
}

impl TwoMassLoop {
    /// Of a servo of two masses.
    pub(crate) fn new(bench: &Bench, tuning: &Tuning) -> Self {
        let effects = bench.effects;
        Self {
            servo: bench.servo,
            damping: (effects.resonance_damping).unwrap_or(Effects::RESONANCE_DAMPING),
            effects,
            sample_time: bench.settings.sample_time,
            tuning: *tuning,
        }
    }

    /// The antiresonance, rad/s: the load alone on the spring.
    fn antiresonance(&self) -> f64 {
        self.effects.resonance * (1.0 - self.effects.inertia_ratio).sqrt()
    }

    /// The motor's position per acting command at a frequency, rad/s.
    fn continuous(&self, frequency: f64) -> Complex {
        let Effects {
            resonance,
            inertia_ratio: share,
            current_loop,
            delay,
            ..
        } = self.effects;
        let s = J.scaled(frequency);
        let spring = (s.scaled(2.0 * self.damping * resonance) + resonance * resonance)
            .scaled(share * (1.0 - share));
        let load = (s * s).scaled(share);
        let motor = (s * s).scaled(1.0 - share) + s.scaled(self.servo.a);
        // The load answers the motor through the spring: its mass in parallel to the spring.
        let carried = match share {
            0.0 => load,
            _ => load * spring / (load + spring),
        };
        let current = s.scaled(current_loop) + 1.0;
        exponential(-frequency * delay).scaled(self.servo.b) / ((motor + carried) * current)
    }

    /// The same of the samples, under a held command.
    fn sampled(&self, frequency: f64) -> Complex {
        let hold = Complex::ONE - exponential(-frequency * self.sample_time);
        let images = (-IMAGES..=IMAGES).map(|image| {
            let frequency = frequency + f64::from(image) * TAU / self.sample_time;
            self.continuous(frequency) / J.scaled(frequency * self.sample_time)
        });
        hold * images.fold(J.scaled(0.0), |sum, image| sum + image)
    }

    fn controller(&self, frequency: f64) -> Complex {
        let time = self.sample_time;
        let delta = exponential(frequency * time) - Complex::ONE;
        let g = -(-self.tuning.cutoff * time).exp_m1();
        let derivative = delta.scaled(self.tuning.kd * g / time) / (delta + g);
        let integral = Complex::ONE.scaled(self.tuning.ki * time) / delta;
        (derivative + integral + self.tuning.kp) * self.notch(frequency)
    }

    /// The notch filter of the command under Tustin's transform, s = 2 (z − 1)/(T (z + 1)).
    fn notch(&self, frequency: f64) -> Complex {
        let (time, notch) = (self.sample_time, self.tuning.notch);
        if notch == 0.0 {
            return Complex::ONE;
        }
        let z = exponential(frequency * time);
        let s = (z - Complex::ONE).scaled(2.0 / time) / (z + 1.0);
        let warped = 2.0 / time * (0.5 * notch * time).tan();
        let of = |damping: f64| s * s + s.scaled(2.0 * damping * warped) + warped * warped;
        of(0.05) / of(0.5)
    }

    /// Close together about resonance and antiresonance, with the distances of the damping.
    fn frequencies(&self) -> Vec<f64> {
        let highest = 0.9999 * PI / self.sample_time;
        let lowest = (1e-4 / self.sample_time).min(0.02 * self.tuning.bandwidth);
        let ratio = (highest / lowest).powf(1.0 / FREQUENCIES as f64);
        let mut all: Vec<f64> = (0..=FREQUENCIES)
            .map(|place| lowest * ratio.powi(place as i32))
            .collect();
        for centre in [self.effects.resonance, self.antiresonance()] {
            all.extend((-NEAR..=NEAR).map(|place| {
                let distance = (4.5 * f64::from(place) / f64::from(NEAR)).sinh();
                centre * (1.0 + 0.3 * self.damping * distance)
            }));
        }
        all.retain(|frequency| (lowest..=highest).contains(frequency));
        all.sort_by(f64::total_cmp);
        all
    }

    /// Mₛ, the largest |1/(1 + L)|; none if the loop is unstable.
    ///
    /// The loop opened has poles at z = 1, two, or three where a = 0, and none outside the unit circle: the argument of
    /// (1 + L)(1 − z⁻¹)²(1 − e^(−aT) z⁻¹), whose value at z = 1 is real and positive, returns to where it began if and
    /// only if no root of it is outside (the principle of the argument).
    pub(crate) fn sensitivity(&self) -> Option<f64> {
        let time = self.sample_time;
        let slowing = (-self.servo.a * time).exp();
        let (mut largest, mut turned, mut last) = (0.0_f64, 0.0, None);
        for frequency in self.frequencies() {
            let distance = self.controller(frequency) * self.sampled(frequency) + 1.0;
            largest = largest.max(1.0 / distance.power().sqrt());
            let back = exponential(-frequency * time);
            let difference = Complex::ONE - back;
            let pole = Complex::ONE - back.scaled(slowing);
            let characteristic = distance * difference * difference * pole;
            if let Some(before) = last {
                let turn: Complex = characteristic * Complex::conjugate(before);
                turned += turn.im.atan2(turn.re);
            }
            last = Some(characteristic);
        }
        (turned.abs() < 0.5 * PI).then_some(largest)
    }
}

/// Gains that were applied to an axis on which friction hides a resonance of 224 Hz from a motor that stands drive its
/// command from limit to limit. Those of a fifth of the bandwidth do not.
#[test]
fn gains_that_half_cycle_the_second_mass_are_unstable_and_slower_ones_are_not() {
    let bench = hidden();
    let rigid = TuningSettings::new(1e-3, 0.0, 48.0, 0.1);
    let known = IdentifiedServo::known(bench.servo, 0.0);
    let known = rigid.tune(&known).expect("one mass");
    let with = |factor: f64| {
        let tuning = Tuning {
            kp: 73.274 * factor * factor,
            kd: 0.72091 * factor,
            ki: 1671.9 * factor * factor * factor,
            cutoff: 1597.2 * factor,
            bandwidth: 160.0 * factor,
            ..known
        };
        TwoMassLoop::new(&bench, &tuning).sensitivity()
    };
    assert_eq!(with(1.0), None);
    let slower = with(0.2).expect("stable");
    assert!((1.0..1.8).contains(&slower), "{slower}");
}
