//! The motion of a servo with effects that no closed form describes.

use identifier_core::parameters::ServoParameters;

use crate::Effects;
use crate::equation::{Acting, Angular, Equation, Spring, State};
use crate::friction::Friction;
use crate::front_end::Held;
use crate::integrator::Integrator;
use crate::wander::Wander;

/// A servo in motion. Drifting and wandering parameters are held from sample to sample.
#[derive(Debug, Clone)]
pub(crate) struct Motion {
    /// Without drift, and with the load that does not wander.
    at_first: Equation,
    /// In this sample.
    now: Equation,
    gain_drift: f64,
    friction_drift: f64,
    wander: Option<Wander>,
    /// Bandwidth of the current loop, 1/s.
    rate: Option<f64>,
    state: State,
    /// The part of the twist that the encoder shows: one if it is on the load.
    shown_twist: f64,
    integrator: Integrator,
    sample_time: f64,
    samples: u64,
}

impl Motion {
    /// At rest at position zero, the spring relaxed; the effects are known to be allowed.
    pub(crate) fn at_rest(
        servo: &ServoParameters,
        effects: &Effects,
        sample_time: f64,
        seed: u32,
    ) -> Self {
        let equation = Equation {
            gain: servo.b,
            gain_asymmetry: effects.gain_asymmetry,
            torque_ripple: Angular::new(effects.torque_ripple, effects.torque_ripple_order),
            acting: Acting {
                target: 0.0,
                excess: 0.0,
                rate: 0.0,
            },
            load: servo.load,
            friction: Friction::new(servo, effects),
            gravity: Angular::new(effects.gravity, 1),
            ripple: Angular::new(effects.ripple, effects.ripple_order),
            ripples: (effects.ripples).map(|(wave, order)| Angular::new(wave, order)),
            inertia: Angular::new(effects.inertia_variation, effects.inertia_order),
            spring: effects.are_two_masses().then(|| Spring::new(effects)),
        };
        let wanders = effects.load_wander[0] > 0.0;
        Self {
            at_first: equation,
            now: equation,
            gain_drift: effects.gain_drift,
            friction_drift: effects.friction_drift,
            wander: wanders.then(|| Wander::new(effects.load_wander, sample_time, seed)),
            rate: (effects.current_loop > 0.0).then(|| 1.0 / effects.current_loop),
            state: [0.0; 4],
            shown_twist: f64::from(u8::from(effects.encoder_on_load)),
            integrator: Integrator::new(Integrator::TOLERANCE, sample_time),
            sample_time,
            samples: 0,
        }
    }

    /// Brings what drifts and what wanders to the sample that begins.
    pub(crate) fn begin_sample(&mut self) {
        let time = self.samples as f64 * self.sample_time;
        let drifted = |rate: f64| (1.0 + rate * time).max(0.0);
        let wandered = self.wander.as_mut().map_or(0.0, Wander::next);
        self.now.gain = self.at_first.gain * drifted(self.gain_drift);
        self.now.friction = self.at_first.friction.scaled(drifted(self.friction_drift));
        self.now.load = self.at_first.load + wandered;
        self.samples += 1;
    }

    /// Moves for the time of a held command.
    pub(crate) fn advance(&mut self, held: &Held) {
        let acting = &mut self.now.acting;
        if let Some(rate) = self.rate {
            let last = acting.target + acting.excess;
            *acting = Acting {
                target: held.command,
                excess: last - held.command,
                rate,
            };
        } else {
            acting.target = held.command;
        }
        let equation = &self.now;
        self.integrator
            .advance(equation, &mut self.state, held.time);
        let acting = &mut self.now.acting;
        acting.excess = acting.at(held.time) - acting.target;
    }

    /// Stands for a sample.
    pub(crate) fn stand(&mut self) {
        self.begin_sample();
        [_, self.state[1], _, self.state[3]] = [0.0; 4];
    }

    /// As if this command had acted for long.
    pub(crate) fn hold(&mut self, command: f64) {
        self.now.acting.target = command;
    }

    /// Sets load and Coulomb friction from the next sample on, rad/s².
    pub(crate) fn disturb(&mut self, load: f64, coulomb: f64) {
        self.at_first.load = load;
        self.at_first.friction.coulomb = coulomb;
    }

    /// Position at the encoder, rad.
    pub(crate) fn position(&self) -> f64 {
        self.state[0] + self.shown_twist * self.state[2]
    }

    /// Velocity at the encoder, rad/s.
    pub(crate) fn velocity(&self) -> f64 {
        self.state[1] + self.shown_twist * self.state[3]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SAMPLE_TIME: f64 = 1e-3;

    /// The positions of a servo that is driven to and fro for 10 s.
    fn positions(effects: &Effects, tolerance: f64, longest_step: f64) -> [f64; 10] {
        let servo = ServoParameters::new(1.1, 200.0, 12.0, 5.0);
        let mut motion = Motion::at_rest(&servo, effects, SAMPLE_TIME, 5);
        motion.integrator = Integrator::new(tolerance, longest_step);
        core::array::from_fn(|second| {
            for sample in 0..1000 {
                let time = second as f64 + f64::from(sample) * SAMPLE_TIME;
                // Held to the servo's middle, so that it stays where it is and turns often.
                let pull = -0.4 * motion.position() - 0.05 * motion.velocity();
                let command = 0.5 * libm::sin(9.0 * time) + 0.3 * libm::sin(31.0 * time) + pull;
                motion.begin_sample();
                motion.advance(&Held {
                    command,
                    time: SAMPLE_TIME,
                });
            }
            motion.position()
        })
    }

    #[test]
    fn halving_the_steps_changes_less_than_a_thousandth_of_a_count() {
        let count = core::f64::consts::TAU / 10_000.0;
        let cases: [fn(&mut Effects); 8] = [
            |of| of.current_loop = 4e-4,
            |of| (of.asymmetry, of.gain_drift) = (-0.6, 0.01),
            |of| (of.low_speed_friction, of.low_speed_velocity) = (8.0, 0.05),
            |of| of.gravity = [-20.0, 5.0],
            |of| (of.ripple, of.ripple_order) = ([6.0, 3.0], 140),
            |of| (of.resonance, of.inertia_ratio) = (700.0, 0.6),
            |of| (of.resonance, of.inertia_ratio, of.backlash) = (300.0, 0.4, 0.004),
            |of| (of.resonance, of.inertia_ratio, of.load_friction) = (200.0, 0.5, 15.0),
        ];
        for change in cases {
            let mut effects = Effects::NONE;
            change(&mut effects);
            // The error of a step is proportional to the fifth power of its length.
            let coarse = positions(&effects, Integrator::TOLERANCE, SAMPLE_TIME);
            let fine = positions(&effects, Integrator::TOLERANCE / 32.0, SAMPLE_TIME / 2.0);
            let moves = coarse.iter().any(|position| position.abs() > 0.05);
            assert!(moves, "{coarse:?}");
            for (coarse, fine) in coarse.iter().zip(fine) {
                let difference = (coarse - fine).abs() / count;
                assert!(difference < 1e-3, "{difference} counts: {effects:?}");
            }
        }
    }
}
