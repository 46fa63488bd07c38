//! A commissioned axis in motion, which Gauss–Newton identifies and whose changes are looked for.

use std::f64::consts::TAU;

use commissioning::servo_change::{CommissionedServo, ServoChange, ServoChangeState};
use identifier_core::control::{Shaped, ShapedState};
use identifier_core::identifier::{
    Event, ExpectedMotion, GaussNewtonIdentifier, Identify, ServoLoop, ServoLoopState,
};
use identifier_core::measurement::{LowPass, VelocityEstimate};
use identifier_core::parameters::{IdentifiedServo, ServoParameters, Unknowns};
use identifier_core::settings::{ControllerSettings, Settings};
use identifier_core::tuning::{Goal, Tuning, TuningSettings};
use virtual_servo::{Encoder, Plant, SplitMix64};

type Identifier = GaussNewtonIdentifier<f32, Unknowns<4>, 4, 64>;
type Loop = ServoLoop<f32, LowPass<f32>, Identifier, Shaped<f32>>;
type State = ServoLoopState<
    f32,
    <LowPass<f32> as VelocityEstimate<f32>>::State,
    <Identifier as Identify<f32>>::State,
    ShapedState<f32>,
>;

pub(crate) const LIMIT: f64 = 10.0;

/// A commissioned axis in motion.
pub(crate) struct Axis {
    pub(crate) truth: ServoParameters,
    pub(crate) sample_time: f64,
    resolution: f64,
    /// Standard deviation of the encoder's noise, rad.
    noise: f64,
    tuning: Tuning,
    predicted: CommissionedServo,
    servo_loop: Loop,
    state: State,
    plant: Plant,
    encoder: Encoder,
    random: SplitMix64,
    /// Half of the range of its targets, rad.
    range: f64,
    reference: f64,
    target: f64,
    /// Until the next target, s.
    left: f64,
    pub(crate) time: f64,
    examined_at: f64,
    pub(crate) changes: ServoChangeState,
}

/// A normal deviate, nearly.
fn normal(random: &mut SplitMix64) -> f64 {
    (0..12).map(|_| random.uniform(-0.5, 0.5)).sum()
}

impl Axis {
    /// None where the servo has no gains.
    pub(crate) fn new(
        truth: ServoParameters,
        sample_time: f64,
        counts: f64,
        noise: f64,
        share: f64,
        seed: u64,
    ) -> Option<Self> {
        let mut random = SplitMix64::new(seed);
        let resolution = TAU / counts;
        let noise = noise * resolution;
        let authority = truth.b * LIMIT;
        // As after a commissioning: b known to a thousandth, and estimates that are off by their errors.
        let errors = [0.1, 1e-3 * truth.b, 1e-3 * authority, 0.0, 1e-3 * authority];
        let mut draw = |value: f64, error: f64| value + error * normal(&mut random);
        let servo = IdentifiedServo {
            unexplained: resolution / 12.0_f64.sqrt() + noise,
            ..IdentifiedServo::known(
                ServoParameters::new(
                    draw(truth.a, errors[0]).max(0.0),
                    draw(truth.b, errors[1]),
                    draw(truth.coulomb, errors[2]).max(0.0),
                    draw(truth.load, errors[4]),
                ),
                0.0,
            )
            .with_errors(errors)
        };
        let step = (50.0 * resolution).max(0.02 * authority * 0.01);
        let mut settings = TuningSettings::new(sample_time, resolution, LIMIT, step);
        settings.noise = noise;
        let stiffest = settings.tune(&servo).ok()?;
        settings.goal = Goal::Bandwidth(share * stiffest.bandwidth);
        let tuning = settings.tune(&servo).ok()?;
        let mut own = Settings::new(sample_time, counts);
        own.cutoff = tuning.cutoff;
        own.controller = Some(ControllerSettings::tuned(&tuning, [-LIMIT, LIMIT]));
        own.identifier.noise = (noise > 0.0).then_some(noise);
        let servo_loop: Loop = own.build().expect("allowed");
        let mut state = servo_loop.start(0);
        let identifier = servo_loop.identifier();
        *state.identification_mut() = identifier.start_from(&identifier.recorder().prepare(
            &servo,
            &ExpectedMotion {
                bandwidth: tuning.bandwidth,
                command: tuning.kp * tuning.predicted_response.step,
            },
        ));
        Some(Self {
            truth,
            sample_time,
            resolution,
            noise,
            predicted: CommissionedServo::new(&servo, &tuning, LIMIT)?,
            range: (300.0 * resolution).max(authority / tuning.bandwidth.powi(2)),
            tuning,
            servo_loop,
            state,
            plant: Plant::at_rest(&truth, sample_time),
            encoder: Encoder::new(counts),
            random,
            reference: 0.0,
            target: 0.0,
            left: 0.0,
            time: 0.0,
            examined_at: 0.0,
            changes: ServoChangeState::default(),
        })
    }

    /// From now on another servo, at the same place and speed.
    pub(crate) fn change(&mut self, inertia: f64, friction: f64) {
        let other = ServoParameters::new(
            self.truth.a / inertia,
            self.truth.b / inertia,
            friction * self.truth.coulomb / inertia,
            self.truth.load / inertia,
        );
        let mut plant = Plant::at_rest(&other, self.sample_time);
        (plant.position, plant.velocity) = (self.plant.position, self.plant.velocity);
        self.plant = plant;
    }

    /// Moves from target to target with pauses, until a change is reported, or for so long, s.
    pub(crate) fn runs(&mut self, duration: f64) -> Option<ServoChange> {
        let end = self.time + duration;
        while self.time < end {
            self.sample();
            if let Some(change) = self.changes.reported() {
                return Some(*change);
            }
        }
        None
    }

    pub(crate) fn sample(&mut self) {
        self.left -= self.sample_time;
        if self.left <= 0.0 {
            let slow = 10.0 / self.tuning.bandwidth;
            self.left = self.random.uniform(slow, 4.0 * slow).max(0.1);
            self.target = self.random.uniform(-self.range, self.range);
        }
        let pace = 0.3 * self.range * self.tuning.bandwidth * self.sample_time;
        self.reference += (self.target - self.reference).clamp(-pace, pace);
        let seen = self.plant.position + self.noise * normal(&mut self.random);
        let count = self.encoder.read(seen) as i32;
        let place = self.reference / self.resolution;
        let fraction = (place - place.floor()) as f32;
        let (servo_loop, state) = (&self.servo_loop, &mut self.state);
        let done = servo_loop
            .process(state, place.floor() as i32, fraction, count)
            .expect("within reach");
        if done.seen.event != Event::None {
            self.changes.interrupt();
        }
        servo_loop.identifier().work(state.identification_mut(), 8);
        self.plant.advance(f64::from(done.control.command));
        self.time += self.sample_time;
        if self.time - self.examined_at >= ServoChangeState::INTERVAL {
            self.examined_at = self.time;
            self.examine();
        }
    }

    fn examine(&mut self) {
        let identifier = self.servo_loop.identifier();
        match identifier.settled(self.state.identification()) {
            Some(settled) => {
                let [found, errors] = identifier.recorder().settled_in(&settled);
                self.changes.take(self.predicted.change(&found, &errors));
            }
            None => self.changes.interrupt(),
        }
        identifier.check_estimates(self.state.identification_mut());
    }
}
