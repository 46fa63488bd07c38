//! The frequency response of the sampled loop, opened at the command.

use std::f64::consts::PI;

use identifier_core::control::Gains;
use identifier_core::measurement::{Transfer, VelocityEstimate};
use identifier_core::number::Complex;
use identifier_core::parameters::ServoParameters;
use identifier_core::settings::SettingsError;
use identifier_core::stability::SampledLoop;

use crate::scenario::dispatch::with_velocity;
use crate::scenario::{LoopKind, Scenario};

/// Speed and margins of a loop. All but the first are none where it is unstable.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LoopFigures {
    /// True if it is stable, delay left aside.
    pub stable: bool,
    /// Frequency at which the closed loop has fallen by 3 dB, rad/s.
    pub bandwidth: Option<f64>,
    /// Frequency at which |L| last falls below 1, rad/s.
    pub crossover: Option<f64>,
    /// Phase margin there, degrees.
    pub phase_margin: Option<f64>,
    /// The factors by which the gain may fall and rise; none for any.
    pub gain_margins: [Option<f64>; 2],
    /// The least |1 + L|.
    pub modulus_margin: Option<f64>,
}

/// A loop whose response is known at every frequency.
#[derive(Debug, Clone, Copy)]
pub struct Response {
    a: f64,
    b: f64,
    gains: Gains,
    velocity: Transfer,
    sample_time: f64,
    /// Delay in front of the servo, s, and time constant of the current loop, s.
    delay: f64,
    current_loop: f64,
}

impl Response {
    /// The loop of a scenario's controller around a servo; none where another than a PID closes it.
    pub fn new(scenario: &Scenario, servo: &ServoParameters) -> Option<Self> {
        let closing = scenario.identifier.law.closing();
        if closing == LoopKind::Relay {
            return None;
        }
        scenario.stated.controller?;
        let velocity = with_velocity!(scenario, f64 => transfer(scenario)).ok()?;
        let gains = scenario.stated.own_controller().ok()?.gains().ok()?;
        Some(Self {
            a: servo.a,
            b: servo.b,
            gains,
            velocity,
            sample_time: scenario.sample_time(),
            delay: scenario.effects.delay,
            current_loop: scenario.effects.current_loop,
        })
    }

    /// L at a frequency, rad/s: the servo held over a sample times the controller.
    fn at(&self, frequency: f64) -> Complex {
        let time = self.sample_time;
        let z = at_angle(frequency * time);
        let delta = z - Complex::ONE;
        let x = self.a * time;
        // (1 − e^(−x))/x and (x − 1 + e^(−x))/x², also for a servo without friction.
        let h1 = if x > 0.0 { -(-x).exp_m1() / x } else { 1.0 };
        let h2 = if x > 1e-4 {
            (1.0 - h1) / x
        } else {
            0.5 - x / 6.0
        };
        let zero = delta.scaled(h2) + h1;
        let pole = delta + x * h1;
        let servo = (zero / (delta * pole)).scaled(self.b * time * time);
        let [constant, slope] = self.velocity.numerator;
        let filter = (z.scaled(slope) + constant) * delta / (z * (z + -self.velocity.pole));
        let controller = (Complex::ONE / delta).scaled(self.gains.ki() * time)
            + self.gains.kp()
            + filter.scaled(self.gains.kd() / time);
        let lag = Complex {
            re: 1.0,
            im: frequency * self.current_loop,
        };
        servo * controller * at_angle(-frequency * self.delay) / lag
    }

    /// Margins and bandwidth.
    pub fn figures(&self, scenario: &Scenario) -> LoopFigures {
        /// Frequencies of a decade, and decades below half the sample rate.
        const A_DECADE: u32 = 400;
        const DECADES: f64 = 6.0;
        let units = scenario.units();
        let stable =
            SampledLoop::new(&units, &self.gains, &self.velocity).is_stable(self.a, self.b);
        let mut found = LoopFigures {
            stable,
            bandwidth: None,
            crossover: None,
            phase_margin: None,
            gain_margins: [None; 2],
            modulus_margin: None,
        };
        if !stable {
            return found;
        }
        let most = PI / self.sample_time;
        let points = (DECADES * f64::from(A_DECADE)) as u32;
        let mut last: Option<(f64, Complex)> = None;
        for point in 0..=points {
            let below = f64::from(points - point) / f64::from(A_DECADE);
            let frequency = most * 10_f64.powf(-below);
            let gain = self.at(frequency);
            let distance = magnitude(gain + 1.0);
            let least = found.modulus_margin.get_or_insert(distance);
            *least = least.min(distance);
            if let Some((before, was)) = last {
                // Where a curve falls through a level, on the logarithm of the frequency.
                let crossing = |from: f64, to: f64, level: f64| {
                    (from >= level && to < level).then(|| {
                        let part = (from / level).ln() / (from / to).ln();
                        before * (frequency / before).powf(part)
                    })
                };
                let follows = |gain: Complex| magnitude(gain / (gain + 1.0));
                let level = 0.5_f64.sqrt();
                if let Some(at) = crossing(follows(was), follows(gain), level) {
                    found.bandwidth = Some(at);
                }
                if let Some(at) = crossing(magnitude(was), magnitude(gain), 1.0) {
                    let there = self.at(at);
                    let phase = there.im.atan2(there.re).to_degrees();
                    found.crossover = Some(at);
                    found.phase_margin = Some((phase + 180.0).rem_euclid(360.0));
                }
                if (was.im > 0.0) != (gain.im > 0.0) && was.re < 0.0 && gain.re < 0.0 {
                    let part = was.im / (was.im - gain.im);
                    let at = was.re + (gain.re - was.re) * part;
                    found.bear(-1.0 / at);
                }
            }
            last = Some((frequency, gain));
        }
        found
    }
}

impl LoopFigures {
    /// The gain may change by less than this factor.
    fn bear(&mut self, factor: f64) {
        let [fall, rise] = &mut self.gain_margins;
        if factor < 1.0 {
            *fall = Some(fall.map_or(factor, |known| known.max(factor)));
        } else {
            *rise = Some(rise.map_or(factor, |known| known.min(factor)));
        }
    }
}

fn at_angle(angle: f64) -> Complex {
    let (im, re) = angle.sin_cos();
    Complex { re, im }
}

fn magnitude(value: Complex) -> f64 {
    value.re.hypot(value.im)
}

fn transfer<V: VelocityEstimate<f64>>(scenario: &Scenario) -> Result<Transfer, SettingsError> {
    let velocity = scenario.stated.velocity::<f64, V>()?;
    Ok(velocity.transfer())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::Purpose;

    fn loop_of(controller: &str) -> (Scenario, Response) {
        let text = format!(
            "[plant]\na = 2.0\nb = 300.0\n[identifier]\nlaw = \"gauss-newton\"\n\
             [controller]\nsample_time = 0.001\n{controller}"
        );
        let scenario = Scenario::parse("s.toml", &text, Purpose::Run).expect("a scenario");
        let servo = scenario.plant.expect("a plant");
        let response = Response::new(&scenario, &servo).expect("a PID");
        (scenario, response)
    }

    #[test]
    fn the_gain_margins_are_where_the_cores_polynomial_becomes_unstable() {
        for controller in [
            "kp = 9.0\nkd = 0.19\nki = 4.0",
            "kp = 20.0\nkd = 0.3\nki = 90.0",
        ] {
            let (scenario, response) = loop_of(controller);
            let [fall, rise] = response.figures(&scenario).gain_margins;
            let units = scenario.units();
            let sampled = SampledLoop::new(&units, &response.gains, &response.velocity);
            let stable = |factor: f64| sampled.is_stable(response.a, factor * response.b);
            let rise = rise.expect("sampling bounds every gain");
            let is_edge = stable(0.999 * rise) && !stable(1.001 * rise);
            assert!(rise > 1.0 && is_edge, "{rise}");
            if let Some(fall) = fall {
                assert!(stable(1.001 * fall) && !stable(0.999 * fall), "{fall}");
            }
        }
        // Three integrations fall to no gain at all.
        let (scenario, response) = loop_of("kp = 20.0\nkd = 0.3\nki = 90.0");
        assert!(response.figures(&scenario).gain_margins[0].is_some());
    }

    #[test]
    fn a_slow_pd_loop_is_the_double_pole_of_the_textbook() {
        // Both poles at −ω: kp = ω²/b, kd = (2ω − a)/b, and L = (kd s + kp) b/(s (s + a)).
        let omega = 8.0_f64;
        let (kp, kd) = (omega * omega / 300.0, (2.0 * omega - 2.0) / 300.0);
        let (scenario, response) = loop_of(&format!("kp = {kp}\nkd = {kd}\nki = 0.0"));
        let found = response.figures(&scenario);
        // |L| = 1: ω⁴ + (a² − b²kd²) ω² − b²kp² = 0.
        let (p, q) = (4.0 - 14.0_f64.powi(2), omega.powi(4));
        let crossover = (-0.5 * p + (0.25 * p * p + q).sqrt()).sqrt();
        let told = found.crossover.expect("a crossover");
        assert!((told / crossover - 1.0).abs() < 0.01, "{told}, {crossover}");
        let phase = 90.0 + (14.0 * crossover / omega.powi(2)).atan().to_degrees()
            - (crossover / 2.0).atan().to_degrees();
        let told = found.phase_margin.expect("a margin");
        assert!((told - phase).abs() < 2.0, "{told}, {phase}");
    }
}
