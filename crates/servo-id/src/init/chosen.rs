//! Gains, parameter range and reference for a servo of which only the data sheet is known.

use std::f64::consts::TAU;

use super::{DataSheet, ServoSheet};

/// Gains, parameter range and reference.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Chosen {
    /// ω that the poles are placed at, rad/s.
    pub omega: f64,
    /// Why it is not larger.
    pub omega_from: &'static str,
    /// Command units per rad, per rad/s, per rad s.
    pub kp: f64,
    /// See `kp`.
    pub kd: f64,
    /// See `kp`.
    pub ki: f64,
    /// Cut-off of the velocity filter, rad/s.
    pub cutoff: f64,
    /// Where a may lie, 1/s.
    pub a_range: [f64; 2],
    /// Where b may lie.
    pub b_range: [f64; 2],
    /// Amplitude of the reference, rad.
    pub amplitude: f64,
    /// For how long it holds at least, s.
    pub hold: f64,
    /// To either side, for a commissioning, rad.
    pub travel: f64,
    /// rad/s.
    pub speed: f64,
}

/// The part of the limit that a step of the reference asks for.
pub(super) const SHARE: f64 = 0.5;

/// The factor that inertia and gain may be off by, either way.
pub(super) const UNSURE: f64 = 2.0;

impl Chosen {
    /// For a servo.
    #[must_use]
    pub fn for_servo(sheet: &DataSheet, servo: &ServoSheet) -> Self {
        /// ω T, at which the crossover of the largest servo of the range, 6 ω, stays well below the sampling.
        const OF_A_SAMPLE: f64 = 0.05;
        /// The cut-off of the velocity filter, ω.
        const CUTOFF: f64 = 10.0;
        /// The step that the limit is to suffice for, rad.
        const STEP: f64 = 0.5;
        /// The part of the limit that a count may move the command by.
        const NOISE: f64 = 0.02;
        let ServoSheet { a, b, limit, .. } = *servo;
        let resolution = TAU / sheet.counts;
        let omegas = [
            (OF_A_SAMPLE / sheet.sample_time, "0.05 per sample"),
            (
                (b * limit / (3.0 * STEP)).sqrt(),
                "a step of 0.5 rad uses the whole limit",
            ),
            (
                (NOISE * b * limit / (3.0 * CUTOFF * resolution)).sqrt(),
                "one count moves the command by 2 % of the limit",
            ),
        ];
        let least = |one: (f64, &'static str), other: (f64, &'static str)| match one.0 <= other.0 {
            true => one,
            false => other,
        };
        let (omega, omega_from) = omegas.into_iter().fold((f64::INFINITY, ""), least);
        let kp = 3.0 * omega * omega / b;
        let kd = (3.0 * omega - a).max(omega) / b;
        let a_range = [0.0, 2.0 * a + 0.1 * omega];
        let b_range = [b / UNSURE, UNSURE * b];
        // (14) holds for the parameter range if kp > √(2 ki (kd + a_max/b_min)): half of that.
        let most = 0.5 * kp * kp / (2.0 * (kd + a_range[1] / b_range[0]));
        let amplitude = 0.5 * SHARE * limit / kp;
        Self {
            omega,
            omega_from,
            kp,
            kd,
            ki: (0.5 * omega * omega * omega / b).min(most),
            cutoff: CUTOFF * omega,
            a_range,
            b_range,
            amplitude,
            hold: samples(4.0 / omega, sheet.sample_time),
            travel: TAU,
            speed: servo
                .top_speed
                .unwrap_or(f64::INFINITY)
                .min(0.3 * (2.0 * b * limit * TAU).sqrt()),
        }
    }
}

/// A time in whole samples.
fn samples(time: f64, sample_time: f64) -> f64 {
    (time / sample_time).round().max(1.0) * sample_time
}
