//! Unknown servos, sensible limits for them, and their first motion.

use std::vec::Vec;

use crate::commission::{CommissionSettings, Limits, Probing, ProbingState};
use identifier_core::parameters::ServoParameters;
use identifier_core::reason::Reason;
use virtual_servo::{Effects, Encoder, Servo, SplitMix64};

/// A servo that is unknown to the probing experiment.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Unknown {
    pub(crate) parameters: ServoParameters,
    pub(crate) effects: Effects,
    /// Samples.
    pub(crate) delay: f64,
    /// Encoder counts per revolution.
    pub(crate) counts: f64,
    pub(crate) sample_time: f64,
    pub(crate) limits: Limits,
    /// The command with which a controller holds it; `None` if it coasts.
    pub(crate) held: Option<f64>,
    /// Position between two edges of the encoder.
    pub(crate) between_edges: f64,
}

impl Unknown {
    /// The command limit of all of them.
    pub(crate) const COMMAND: f64 = 10.0;

    /// The smallest b, rad/s² per command unit; the largest is a hundred times that.
    const WEAKEST: f64 = 50.0;

    /// Drawn by a seed: b over 100:1, viscous friction up to ten times the nominal servo's, Coulomb
    /// friction to 20 % and load to 30 % of the limit, delays of zero to two samples, whole and
    /// fractional, coasting or held.
    pub(crate) fn from_seed(seed: u64) -> Self {
        let mut random =
            SplitMix64::new(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ 0x5851_f42d_4c95_7f2d);
        let b = Self::WEAKEST * libm::exp(random.next_uniform() * libm::log(100.0));
        let authority = b * Self::COMMAND;
        let sample_time = random.one_of(&[1e-3, 2.5e-4, 1e-4]);
        let counts = random.one_of(&[
            1000.0, 2000.0, 4096.0, 10_000.0, 20_000.0, 65_536.0, 131_072.0,
        ]);
        let coulomb = random.uniform(0.0, 0.2) * authority;
        let load = random.uniform(-0.3, 0.3) * authority;
        let a = random.uniform(0.0, 10.0) * 0.2174 / 257.7 * b;
        let delay = match (random.next_uniform() * 6.0) as u32 {
            whole @ 0..3 => f64::from(whole),
            _ => random.uniform(0.0, 2.0),
        };
        let within = random.uniform(-0.7, 0.7) * coulomb;
        let held = (random.next_uniform() < 0.5).then_some((within - load) / b);
        Self {
            parameters: ServoParameters::new(a, b, coulomb, load),
            effects: Effects::NONE,
            delay,
            counts,
            sample_time,
            limits: Self::allowed(b),
            held,
            between_edges: random.next_uniform(),
        }
    }

    /// The limits that a user allows a class of servos, two classes to a decade of b: ±0.16 rad and 15 rad/s for the
    /// weakest, and up to ±2.1 rad and 200 rad/s (1900 1/min) for the strongest, which passes that in 4 ms
    /// of full command. So travel and speed go with the authority to the power of 3/4.
    fn allowed(b: f64) -> Limits {
        let class = libm::floor(2.0 * libm::log10(b / Self::WEAKEST) + 1e-9).min(3.0);
        let scale = libm::pow(10.0, 0.5 * class * 0.75);
        Limits {
            travel: [-0.16 * scale, 0.16 * scale],
            speed: 15.0 * scale,
            command: [-Self::COMMAND, Self::COMMAND],
            duration: 1.0,
        }
    }

    pub(crate) fn is_sampled_every(&self, time: f64) -> bool {
        (self.sample_time - time).abs() < 1e-9
    }

    pub(crate) fn resolution(&self) -> f64 {
        std::f64::consts::TAU / self.counts
    }

    pub(crate) fn settings(&self) -> CommissionSettings {
        CommissionSettings::new(self.sample_time, self.resolution(), self.limits)
    }

    /// Its first motion.
    pub(crate) fn probe(&self) -> Probed {
        let probing = Probing::new(&self.settings()).expect("these limits are allowed");
        let held = self.held.map(|held| held as f32);
        self.moved_by(&probing, Some(probing.start(held)))
    }

    /// The same after the check of a released servo, if it coasts.
    pub(crate) fn probe_released(&self) -> Probed {
        let probing = Probing::new(&self.settings()).expect("these limits are allowed");
        let held = self.held.map(|held| probing.start(Some(held as f32)));
        self.moved_by(&probing, held)
    }

    /// A motion from a state, or once it has been released.
    pub(crate) fn moved_by(
        &self,
        probing: &Probing<f32>,
        mut state: Option<ProbingState<f32>>,
    ) -> Probed {
        let time = self.sample_time;
        // The command that holds it is taken for none, and its load for what is left: so it has stood
        // under it for ever.
        let held = self.held.unwrap_or(0.0);
        let balanced = self.parameters.with_load_of(held);
        let effects = Effects {
            delay: self.delay * time,
            ..self.effects
        };
        let mut servo = Servo::at_rest(&balanced, &effects, time, 1).expect("a servo");
        let encoder = Encoder::new(self.counts);
        let start = state.map_or(0.0, |state| f64::from(state.position()) * self.resolution());
        let (mut last, mut released) = (0, 0);
        let mut result = Probed::NOTHING;
        while result.progress.is_none() {
            let between = self.between_edges * self.resolution();
            let count = encoder.read(servo.position() + between);
            let increment = (count - last) as f32;
            last = count;
            let command = match &mut state {
                Some(state) => {
                    let command = probing.control(state, increment);
                    result.samples.push([increment, command]);
                    result.progress = probing.learn(state, increment);
                    command
                }
                None => {
                    released += 1;
                    state = probing.start_released(count as f32, released);
                    result.samples.push([increment, 0.0]);
                    0.0
                }
            };
            assert!(command.is_finite());
            servo.advance(f64::from(command) - held);
            result.observe(&self.limits, start + servo.position(), servo.velocity());
            assert!(
                result.samples.len() < (3.0 / time) as usize,
                "it ends: {self:?}"
            );
        }
        result.has_broken_away = state.is_some_and(|state| state.broke_away().is_some());
        let evidence = state.and_then(|state| state.evidence());
        result.evidence = evidence.map(|samples| f64::from(samples) * time);
        result
    }
}

/// Outcome of a motion.
#[derive(Debug, Clone)]
pub(crate) struct Probed {
    pub(crate) progress: Option<Result<(), Reason>>,
    /// After which time there was evidence, s.
    pub(crate) evidence: Option<f64>,
    /// The lowest and highest position, rad.
    pub(crate) reached: [f64; 2],
    /// Largest travel and speed, each as a share of its limit.
    pub(crate) travel: f64,
    pub(crate) speed: f64,
    /// The largest speed backwards, relative to the limit.
    pub(crate) backwards: f64,
    /// True if the command at its break-away is known.
    pub(crate) has_broken_away: bool,
    /// Increment and command of every sample.
    pub(crate) samples: Vec<[f32; 2]>,
}

impl Probed {
    const NOTHING: Self = Self {
        progress: None,
        evidence: None,
        reached: [0.0; 2],
        travel: 0.0,
        speed: 0.0,
        backwards: 0.0,
        has_broken_away: false,
        samples: Vec::new(),
    };

    fn observe(&mut self, limits: &Limits, position: f64, velocity: f64) {
        let [low, high] = self.reached;
        self.reached = [low.min(position), high.max(position)];
        let [lowest, highest] = limits.travel;
        let part = |reached: f64, allowed: f64| {
            if allowed.abs() < 1e-12 {
                0.0
            } else {
                reached / allowed
            }
        };
        self.travel = part(self.reached[0], lowest).max(part(self.reached[1], highest));
        self.speed = self.speed.max(velocity.abs() / limits.speed);
        self.backwards = self.backwards.max(-velocity / limits.speed);
    }
}

/// The unknown servos of a test; others than usual if the environment sets a seed (`CAMPAIGN_SEED=1`).
pub(crate) fn unknown_servos() -> impl Iterator<Item = Unknown> {
    let seed = std::env::var("CAMPAIGN_SEED").ok();
    let first = 1000 * seed.and_then(|seed| seed.parse().ok()).unwrap_or(0_u64);
    (first..first + 1000).map(Unknown::from_seed)
}
