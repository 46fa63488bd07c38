use identifier_core::parameters::ServoParameters;

/// q̈ = −a q̇ + b u + d − c sign(q̇), integrated from sample to sample in closed form for a held command.
///
/// Coulomb friction is taken event by event. If the velocity reaches zero within a sample, the time is found in closed
/// form. From there the servo is at standstill if friction can hold it, or it turns. Standing, it breaks away when the
/// drive exceeds friction; the drive is held, so that happens at a sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plant {
    a: f64,
    gain: f64,
    load: f64,
    coulomb: f64,
    whole: Step,
    /// Position q, rad.
    pub position: f64,
    /// Velocity q̇, rad/s.
    pub velocity: f64,
}

/// The exact step of q̈ = −a q̇ + w over a time t, with q += g₁ q̇ + g₂ w, q̇ = e^(−at) q̇ + g₁ w.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Step {
    time: f64,
    decay: f64,
    g1: f64,
    g2: f64,
}

impl Step {
    fn new(a: f64, time: f64) -> Self {
        /// Below this a t the two integrals are taken from their series, whose next term is then below 10⁻¹⁸. The
        /// closed form would cancel.
        const SERIES_BELOW: f64 = 1e-4;
        let t = time;
        let x = a * t;
        let (g1, g2) = if x < SERIES_BELOW {
            (
                t * (1.0 - x / 2.0 * (1.0 - x / 3.0 * (1.0 - x / 4.0))),
                t * t * (0.5 - x / 6.0 * (1.0 - x / 4.0 * (1.0 - x / 5.0))),
            )
        } else {
            let g1 = -libm::expm1(-x) / a;
            (g1, (t - g1) / a)
        };
        Self {
            time,
            decay: libm::exp(-x),
            g1,
            g2,
        }
    }
}

impl Plant {
    /// At rest at position zero, to be moved in steps of `sample_time` (s).
    #[must_use]
    pub fn at_rest(parameters: &ServoParameters, sample_time: f64) -> Self {
        Self {
            a: parameters.a,
            gain: parameters.b,
            load: parameters.load,
            coulomb: parameters.coulomb,
            whole: Step::new(parameters.a, sample_time),
            position: 0.0,
            velocity: 0.0,
        }
    }

    /// Moves one sample under a held command.
    #[inline]
    pub fn advance(&mut self, command: f64) {
        let whole = self.whole;
        self.advance_by(&whole, command);
    }

    /// Moves for a part of a sample, s, under a held command.
    pub(crate) fn advance_for(&mut self, time: f64, command: f64) {
        let step = if time < self.whole.time {
            Step::new(self.a, time)
        } else {
            self.whole
        };
        self.advance_by(&step, command);
    }

    #[inline]
    fn advance_by(&mut self, step: &Step, command: f64) {
        let drive = self.gain * command + self.load;
        if self.coulomb > 0.0 {
            self.advance_with_friction(step, drive);
        } else {
            self.move_without_stop(step, drive);
        }
    }

    #[inline]
    fn move_without_stop(&mut self, step: &Step, drive: f64) {
        self.position += step.g1 * self.velocity + step.g2 * drive;
        self.velocity = step.decay * self.velocity + step.g1 * drive;
    }

    fn advance_with_friction(&mut self, whole: &Step, drive: f64) {
        let mut left = whole.time;
        while left > 0.0 {
            let direction = if self.velocity != 0.0 {
                self.velocity.signum()
            } else if drive.abs() > self.coulomb {
                drive.signum()
            } else {
                return;
            };
            let pushed = drive - self.coulomb * direction;
            let until_rest = self.time_to_rest(pushed);
            if until_rest >= left {
                let rest = if left < whole.time {
                    Step::new(self.a, left)
                } else {
                    *whole
                };
                self.move_without_stop(&rest, pushed);
                return;
            }
            self.move_without_stop(&Step::new(self.a, until_rest), pushed);
            self.velocity = 0.0;
            left -= until_rest;
        }
    }

    /// The time at which q̇ e^(−at) + w (1 − e^(−at))/a is zero. It is t = ln(1 − a q̇/w)/a, or q̇/−w without
    /// viscosity. It is infinite if the acceleration w drives the servo on.
    fn time_to_rest(&self, w: f64) -> f64 {
        if self.velocity == 0.0 || self.velocity * w >= 0.0 {
            return f64::INFINITY;
        }
        let r = -self.velocity / w;
        if self.a * r < 1e-8 {
            r
        } else {
            libm::log1p(self.a * r) / self.a
        }
    }

    /// Sets load and Coulomb friction from now on, rad/s².
    pub(crate) fn disturb(&mut self, load: f64, coulomb: f64) {
        self.load = load;
        self.coulomb = coulomb;
    }

    /// The time of one step, s.
    #[must_use]
    pub fn sample_time(&self) -> f64 {
        self.whole.time
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SERVO: ServoParameters = ServoParameters::new(0.2174, 257.7, 0.0, 20.0);

    /// q and q̇ at time t after a step of acceleration w from velocity v0. Where the closed form
    /// would cancel, its power series.
    fn step_response(a: f64, w: f64, v0: f64, t: f64) -> (f64, f64) {
        let x = a * t;
        let (first, second) = if x < 0.1 {
            let series = |order: u32| {
                let mut term = 1.0 / f64::from((1..=order).product::<u32>());
                let mut sum = 0.0;
                for k in 1..20 {
                    sum += term;
                    term *= -x / f64::from(k + order);
                }
                sum
            };
            (series(1), series(2))
        } else {
            let first = (1.0 - (-x).exp()) / x;
            (first, (1.0 - first) / x)
        };
        let velocity = v0 * (-x).exp() + w * t * first;
        (v0 * t * first + w * t * t * second, velocity)
    }

    #[track_caller]
    fn assert_state(plant: &Plant, (q, v): (f64, f64)) {
        for (found, expected) in [(plant.position, q), (plant.velocity, v)] {
            let off = (found - expected).abs() / (1.0 + expected.abs());
            assert!(off <= 1e-11, "{found} for {expected}: {plant:?}");
        }
    }

    #[test]
    fn step_is_the_closed_form_for_any_viscosity_and_sample_time() {
        for a in [0.0, 1e-9, 1e-3, 0.09, 0.11, 0.2174, 50.0, 900.0] {
            for sample_time in [25e-6, 1e-3, 0.02] {
                let servo = ServoParameters { a, ..SERVO };
                let mut plant = Plant::at_rest(&servo, sample_time);
                for k in 1..=500 {
                    plant.advance(0.3);
                    let t = sample_time * f64::from(k);
                    assert_state(&plant, step_response(a, 257.7 * 0.3 + 20.0, 0.0, t));
                }
            }
        }
    }

    #[test]
    fn saturated_step_is_the_step_of_the_limit_then_the_free_run() {
        let mut plant = Plant::at_rest(&SERVO, 1e-3);
        for _ in 0..200 {
            plant.advance(25.0_f64.clamp(-1.0, 1.0));
        }
        let (q1, v1) = step_response(SERVO.a, 257.7 + 20.0, 0.0, 0.2);
        assert_state(&plant, (q1, v1));
        for _ in 0..300 {
            plant.advance(-20.0 / 257.7);
        }
        let (gone, v2) = step_response(SERVO.a, 0.0, v1, 0.3);
        assert_state(&plant, (q1 + gone, v2));
    }

    #[test]
    fn friction_stops_a_coasting_servo_where_the_closed_form_does() {
        // q̈ = −a q̇ − c from v₀: rest after t = ln(1 + a v₀/c)/a, at q = (v₀ − c t)/a.
        for sample_time in [1e-4, 1e-3, 7e-3] {
            let servo = ServoParameters::new(3.0, 100.0, 12.0, 0.0);
            let mut plant = Plant::at_rest(&servo, sample_time);
            plant.velocity = 5.0;
            let rest = (1.0_f64 + 3.0 * 5.0 / 12.0).ln() / 3.0;
            for _ in 0..(2.0 * rest / sample_time) as u32 {
                plant.advance(0.0);
            }
            assert!(plant.velocity == 0.0, "it stays at rest");
            assert_state(&plant, ((5.0 - 12.0 * rest) / 3.0, 0.0));
        }
    }

    #[test]
    fn friction_holds_until_the_drive_exceeds_it_and_then_takes_its_share() {
        let servo = ServoParameters::new(2.0, 100.0, 10.0, -5.0);
        let mut plant = Plant::at_rest(&servo, 1e-3);
        for _ in 0..100 {
            plant.advance(0.149);
        }
        let rests = plant.position == 0.0 && plant.velocity == 0.0;
        assert!(rests, "15 − 5 does not exceed 10");
        for _ in 0..100 {
            plant.advance(0.4);
        }
        assert_state(&plant, step_response(2.0, 40.0 - 5.0 - 10.0, 0.0, 0.1));
    }

    #[test]
    fn a_reversal_within_a_sample_is_exact() {
        // Braked by w₁ = −60 to rest, then driven back by w₂ = −40: friction changes its side.
        let servo = ServoParameters::new(0.0, 100.0, 10.0, 0.0);
        let mut plant = Plant::at_rest(&servo, 0.1);
        plant.velocity = 2.0;
        plant.advance(-0.5);
        let rest = 2.0 / 60.0;
        let left = 0.1 - rest;
        let position = 2.0 * rest / 2.0 - 40.0 * left * left / 2.0;
        assert_state(&plant, (position, -40.0 * left));
    }
}
