use identifier_core::Settings;
use identifier_core::control::{ControlState, ShapedState};
use identifier_core::measurement::VelocityEstimate;
use identifier_core::settings::SettingsError;
use serde::Serialize;

use super::frozen_servo::{FrozenServo, State};
use super::squares::Squares;
use crate::log::Row;
use crate::replay::DeclaredPid;
use crate::scenario::{Fault, Options};

/// Relative deviation of a closed-loop simulation from the recording: ‖recorded − simulated‖/‖recorded‖.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ClosedLoop {
    /// Samples that it covers: all but those in which each segment settles.
    pub samples: u64,
    /// Error of the position, from the beginning of each segment.
    pub position: f64,
    /// Error of the velocity, by the declared velocity estimate on both sides.
    pub velocity: f64,
    /// Error of the command; none if none was recorded.
    pub command: Option<f64>,
}

/// Lets a servo follow the recorded reference under the declared controller.
///
/// **The start is taken from the first samples** of each segment. There the controller follows the recording until its
/// velocity estimate has settled. With an integral, it does so until a recorded command within the limit has shown the
/// integral's value. The loop forgets its start, so nothing is fitted.
///
/// None where samples have no reference, or the loop leaves every bound.
///
/// # Errors
/// A controller that cannot be built, or a log that can no longer be read.
pub(super) fn closed_loop<V: VelocityEstimate<f64>>(
    scenario: &Options,
    servo: &FrozenServo,
    rows: &[Row],
) -> Result<Option<ClosedLoop>, Fault> {
    let simulation = Simulation::<V>::new(servo, &scenario.stated);
    let mut simulation = simulation.map_err(|error| scenario.fault(&error))?;
    rows.iter().for_each(|sample| simulation.add(sample));
    Ok(simulation.finish())
}

struct Simulation<V: VelocityEstimate<f64>> {
    servo: FrozenServo,
    declared: DeclaredPid<V>,
    velocity: V,
    /// A position unit, rad.
    unit: f64,
    /// Samples in which a segment settles.
    settling: u64,
    segment_run: Option<SegmentRun<V>>,
    position: Squares,
    speed: Squares,
    command: Squares,
    commanded: bool,
    samples: u64,
    is_lost: bool,
}

/// On the way through a segment.
struct SegmentRun<V: VelocityEstimate<f64>> {
    first: f64,
    /// The recorded position of the last sample, and its filtered velocity.
    last: f64,
    filtered: V::State,
    control: ControlState<f64, V::State, ShapedState<f64>>,
    samples: u64,
    /// The simulated servo, which is the recorded one until it runs.
    state: State,
    runs: bool,
    knows_integral: bool,
}

impl<V: VelocityEstimate<f64>> Simulation<V> {
    fn new(servo: &FrozenServo, settings: &Settings) -> Result<Self, SettingsError> {
        /// Samples of a velocity estimate without a pole.
        const MIN_SAMPLES: f64 = 3.0;
        /// Time constants after which a low-pass has settled to 0.03 % of a step.
        const TIME_CONSTANTS: f64 = 8.0;
        let velocity = settings.velocity::<f64, V>()?;
        let pole = velocity.transfer().pole.clamp(0.0, 0.999_9);
        let constant = if pole > 0.0 {
            -1.0 / libm::log(pole)
        } else {
            0.0
        };
        Ok(Self {
            servo: *servo,
            declared: DeclaredPid::new(settings)?,
            velocity,
            unit: settings.units()?.position_unit(),
            settling: (MIN_SAMPLES + TIME_CONSTANTS * constant) as u64,
            segment_run: None,
            position: Squares::default(),
            speed: Squares::default(),
            command: Squares::default(),
            commanded: true,
            samples: 0,
            is_lost: false,
        })
    }

    fn add(&mut self, sample: &Row) {
        if self.is_lost {
            return;
        }
        self.is_lost = self.follow(sample).is_none();
    }

    /// None where the loop leaves every bound or a reference is missing.
    fn follow(&mut self, sample: &Row) -> Option<()> {
        let reference = sample.reference?;
        let unit = self.unit;
        self.commanded &= sample.command.is_some();
        let (servo, declared) = (&self.servo, &self.declared);
        let fresh = || SegmentRun {
            first: sample.position,
            last: sample.position,
            filtered: V::State::default(),
            control: ControlState::default(),
            samples: 0,
            state: servo.start(sample.position, 0.0, sample.command.unwrap_or(0.0)),
            runs: false,
            // Without a recorded command the integral at the beginning of the log is taken to be zero.
            knows_integral: !declared.has_integral() || sample.command.is_none(),
        };
        if sample.begins {
            self.segment_run = None;
        }
        let segment_run = self.segment_run.get_or_insert_with(fresh);
        let moved = (sample.position - segment_run.last) / unit;
        let recorded = self.velocity.process(&mut segment_run.filtered, moved);
        segment_run.last = sample.position;
        segment_run.samples += 1;
        let before = segment_run.control;
        let (position, increment) = if segment_run.runs {
            (segment_run.state.position, segment_run.state.moved / unit)
        } else {
            (sample.position, moved)
        };
        let error = (reference - position) / unit;
        let control = &mut segment_run.control;
        let step = declared.process(control, error, increment).ok()?;
        let command = step.command;
        if segment_run.runs {
            let first = segment_run.first;
            self.position.add(sample.position - first, position - first);
            self.speed.add(recorded, step.velocity);
            if let Some(recorded) = sample.command {
                self.command.add(recorded, command);
            }
            self.samples += 1;
            servo.advance(&mut segment_run.state, command);
            return Some(());
        }
        let settled = segment_run.samples >= self.settling;
        if settled
            && !segment_run.knows_integral
            && let Some(own) = sample.command
            && let Some(mut known) = declared.with_integral(before, error, increment, own)
        {
            declared.process(&mut known, error, increment).ok()?;
            segment_run.control = known;
            segment_run.knows_integral = true;
        }
        let command = sample.command.unwrap_or(command);
        if settled && segment_run.knows_integral {
            segment_run.state.velocity = recorded * unit;
            (segment_run.state.position, segment_run.state.moved) = (
                sample.position,
                sample.position - segment_run.state.position,
            );
            servo.advance(&mut segment_run.state, command);
            segment_run.runs = true;
        } else {
            servo.follow(
                &mut segment_run.state,
                sample.position,
                recorded * unit,
                command,
            );
        }
        Some(())
    }

    fn finish(self) -> Option<ClosedLoop> {
        let whole = !self.is_lost && self.samples > 0 && self.position.error.is_finite();
        whole.then(|| ClosedLoop {
            samples: self.samples,
            position: self.position.relative(),
            velocity: self.speed.relative(),
            command: self.commanded.then(|| self.command.relative()),
        })
    }
}

#[cfg(test)]
mod tests {
    use identifier_core::control::Controller;
    use identifier_core::measurement::LowPass;
    use identifier_core::parameters::ServoParameters;
    use identifier_core::settings::ControllerSettings;
    use virtual_servo::Plant;

    use super::*;

    const SERVO: ServoParameters = ServoParameters::new(0.5, 250.0, 10.0, 15.0);

    fn settings() -> Settings {
        let pid = ControllerSettings::pid(9.0, 0.19, 4.0).limited(1.0);
        Settings {
            controller: Some(pid),
            ..Settings::new(1e-3, 10_000.0)
        }
    }

    /// The simulator's servo under the core's controller, from sample 700 on, which finds it in motion.
    fn recorded() -> Vec<Row> {
        let settings = settings();
        let controller: Controller<f64, LowPass<f64>> = settings.build().expect("valid");
        let unit = settings.resolution;
        let (mut state, mut plant) = (ControlState::default(), Plant::at_rest(&SERVO, 1e-3));
        let (mut samples, mut before) = (Vec::new(), 0.0);
        for k in 0..6000_u32 {
            let time = 1e-3 * f64::from(k);
            let step = 0.2 * f64::from(1 - (k / 800) % 2);
            let reference = 0.5 * libm::sin(5.0 * time) + step;
            let (error, moved) = (reference - plant.position, plant.position - before);
            before = plant.position;
            let sample = controller.process(&mut state, error / unit, moved / unit);
            let command = sample.expect("within bounds").command;
            if k >= 700 {
                samples.push(Row {
                    reference: Some(3.0 + reference),
                    position: 3.0 + plant.position,
                    command: Some(command),
                    begins: k == 700,
                    ..Row::at(u64::from(k), time)
                });
            }
            plant.advance(command);
        }
        samples
    }

    fn simulated(servo: &ServoParameters, samples: &[Row]) -> Option<ClosedLoop> {
        let frozen = FrozenServo::new(servo, 1e-3).expect("valid");
        let simulation = Simulation::<LowPass<f64>>::new(&frozen, &settings());
        let mut simulation = simulation.expect("a controller");
        samples.iter().for_each(|sample| simulation.add(sample));
        simulation.finish()
    }

    #[test]
    fn the_true_servo_does_what_was_recorded_and_a_wrong_one_shows_in_the_command() {
        let found = simulated(&SERVO, &recorded()).expect("a loop");
        assert!((5200..5300).contains(&found.samples), "{found:?}");
        let command = found.command.expect("it was recorded");
        // The velocity that it starts with is a filter's, which is late.
        let motion = [found.position / 3e-4, found.velocity / 1e-3];
        assert!(
            motion.iter().all(|part| *part < 1.0) && command < 2e-2,
            "{found:?}"
        );
        for wrong in [
            ServoParameters { b: 275.0, ..SERVO },
            ServoParameters::new(SERVO.a, SERVO.b, 0.0, SERVO.load),
            ServoParameters { a: 3.0, ..SERVO },
        ] {
            let found = simulated(&wrong, &recorded()).expect("a loop").command;
            assert!(found > Some(2.0 * command), "{found:?}, {command}");
        }
    }

    #[test]
    fn a_loop_needs_a_reference_and_has_to_stay_in_bounds() {
        let mut samples = recorded();
        let wild = ServoParameters::new(SERVO.a, f64::NAN, 0.0, 0.0);
        assert_eq!(simulated(&wild, &samples), None);
        samples[9].reference = None;
        assert_eq!(simulated(&SERVO, &samples), None);
    }
}
