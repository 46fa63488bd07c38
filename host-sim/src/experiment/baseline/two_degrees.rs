//! A loop with two degrees of freedom, tuned from what is known, off-line least squares over what
//! it recorded, tuned again: Iwasaki, Sato, Morita and Maruyama, "Autotuning of two degree of freedom
//! motor control for high accuracy trajectory motion", Control Engineering Practice 4(4), 1996.
//!
//! The first controller knows the rotor's inertia alone (the initial b̂), its viscous and Coulomb
//! friction are zero. The reference passes a reference model, a feedforward moves the servo along it
//! by the model u = (q̈ + â q̇ + ĉ sign q̇)/b̂, and a feedback with two equal poles takes what is left.
//! After each stage the least squares of u_f = (q̈_f + a q̇_f + c s_f)/b over the stage's samples
//! gives the next controller.

use identifier_core::adaptation::NormalEquations;
use identifier_core::excitation::Excitation;
use identifier_core::model::ServoParameters;
use identifier_core::settings::PerParameter;
use identifier_core::units::Units;
use rivals::{Filtered, StateVariableFilter};

use super::NO_ESTIMATE;
use crate::experiment::sensor::Sensor;
use crate::experiment::{Outcome, Sample};
use crate::scenario::{BaselineSettings, CHECKED, Reference, Scenario};
use virtual_servo::Plant;

/// Stages of a run.
const STAGES: u64 = 4;

/// Cut-off of the velocity that the feedback sees, times its poles.
const VELOCITY_CUTOFF: f64 = 10.0;

pub(super) fn run(
    scenario: &Scenario,
    settings: &BaselineSettings,
    observe: &mut impl FnMut(&Sample),
) -> Outcome {
    let units = &scenario.units();
    let sample_time = units.sample_time();
    let reference = Reference::<f64>::new(units, &scenario.excitation).expect(CHECKED);
    let mut sensor = Sensor::<f64>::new(scenario);
    let mut known = ServoParameters {
        a: 0.0,
        b: scenario.stated.identifier.initial.b.expect(CHECKED),
        coulomb: 0.0,
        load: 0.0,
    };
    let [low, high] = scenario.controller().limit;
    let mut controller = Controller::new(units, scenario, known.b);
    let mut fit = Fit::new(units, settings);
    let mut plant = Plant::at_rest(&scenario.plant.expect(CHECKED), sample_time);
    let mut reference_state = reference.start();
    let mut found = false;
    let mut outcome = Outcome::default();
    let samples = scenario.samples();
    let stage = samples.div_ceil(STAGES).max(1);
    for k in 0..samples {
        if k > 0 && k % stage == 0 {
            // A stage that gives no servo leaves the controller as it is.
            let next = fit.solve();
            found = next.is_some();
            known = next.unwrap_or(known);
            fit = Fit::new(units, settings);
        }
        let wanted = reference.process(&mut reference_state);
        let measured = sensor.read(plant.position, wanted);
        let command = controller
            .process(&known, wanted, measured.position, measured.increment)
            .clamp(low, high);
        fit.process(measured.increment, command);
        outcome.count(None);
        observe(&Sample {
            time: k as f64 * sample_time,
            reference: wanted * units.position_unit(),
            position: measured.position * units.position_unit(),
            command,
            output_error: None,
            estimates: if found { known } else { NO_ESTIMATE },
            standard_errors: None,
            at_bounds: PerParameter::default(),
        });
        plant.advance(command);
    }
    if !found {
        outcome.failure = Some("the last stage's least squares gave no servo");
    }
    outcome
}

/// Feedforward along a reference model and feedback with two equal poles.
struct Controller {
    units: Units,
    poles: f64,
    filter: StateVariableFilter<f64>,
    wanted: Filtered<f64>,
    velocity_filter: StateVariableFilter<f64>,
    velocity: Filtered<f64>,
}

impl Controller {
    /// Poles where the scenario's proportional gain would have the natural frequency of the servo
    /// that is assumed at first.
    fn new(units: &Units, scenario: &Scenario, b: f64) -> Self {
        let nyquist = std::f64::consts::PI / units.sample_time();
        let poles = (b * scenario.controller().kp)
            .sqrt()
            .min(0.5 * nyquist / VELOCITY_CUTOFF);
        let filter = |cutoff: f64| StateVariableFilter::new(units, cutoff).expect(CHECKED);
        Self {
            units: *units,
            poles,
            filter: filter(poles),
            wanted: Filtered::AT_REST,
            velocity_filter: filter(VELOCITY_CUTOFF * poles),
            velocity: Filtered::AT_REST,
        }
    }

    /// The command for a reference, a position and its increment, machine units.
    fn process(
        &mut self,
        known: &ServoParameters,
        reference: f64,
        position: f64,
        increment: f64,
    ) -> f64 {
        let unit = self.units.position_unit();
        let per_sample = 1.0 / self.units.velocity();
        self.velocity_filter.process(&mut self.velocity, increment);
        let velocity = self.velocity.value * per_sample;
        self.filter.process(&mut self.wanted, reference);
        let wanted = self.wanted.value * unit;
        let wanted_velocity = self.wanted.rate * per_sample;
        let square = self.poles * self.poles;
        let acceleration =
            square * (reference * unit - wanted) - 2.0 * self.poles * wanted_velocity;
        let friction = known.a * wanted_velocity + known.coulomb * direction(wanted_velocity);
        let feedback =
            square * (wanted - position * unit) + 2.0 * self.poles * (wanted_velocity - velocity);
        (acceleration + friction + feedback) / known.b
    }
}

/// sign x, zero at zero.
fn direction(x: f64) -> f64 {
    if x == 0.0 { 0.0 } else { x.signum() }
}

/// Least squares of u_f = J q̈_f + F q̇_f + C s_f, s = sign q̇.
///
/// It is done off-line, so the direction of a sample may be that of the motion from some samples
/// before to as many after it: an encoder's single counts say little.
struct Fit {
    units: Units,
    filter: StateVariableFilter<f64>,
    recent: [(f64, f64); 2 * Fit::AROUND + 1],
    motion: Filtered<f64>,
    drive: Filtered<f64>,
    friction: Filtered<f64>,
    settling: u32,
    equations: NormalEquations<f64, 3>,
}

impl Fit {
    /// Time constants of the filter before the first sample counts.
    const SETTLING: f64 = 10.0;

    /// Samples to each side from which a direction is taken.
    const AROUND: usize = 4;

    fn new(units: &Units, settings: &BaselineSettings) -> Self {
        let settling = Self::SETTLING / (settings.filter_cutoff * units.sample_time());
        Self {
            units: *units,
            filter: StateVariableFilter::new(units, settings.filter_cutoff).expect(CHECKED),
            recent: [(0.0, 0.0); 2 * Self::AROUND + 1],
            motion: Filtered::AT_REST,
            drive: Filtered::AT_REST,
            friction: Filtered::AT_REST,
            settling: settling as u32,
            equations: NormalEquations::empty(),
        }
    }

    fn process(&mut self, increment: f64, command: f64) {
        self.recent.rotate_left(1);
        self.recent[2 * Self::AROUND] = (increment, command);
        let around: f64 = self.recent.iter().map(|(increment, _)| increment).sum();
        let (increment, _) = self.recent[Self::AROUND];
        // The command that was held while the position moved by it.
        let (_, command) = self.recent[Self::AROUND - 1];
        self.filter.process(&mut self.motion, increment);
        self.filter.process(&mut self.drive, command);
        self.filter.process(&mut self.friction, direction(around));
        if self.settling > 0 {
            self.settling -= 1;
            return;
        }
        let row = [self.motion.rate, self.motion.value, self.friction.value];
        self.equations.add(&row, self.drive.value);
    }

    fn solve(&self) -> Option<ServoParameters> {
        let [inertia, viscous, coulomb] = self.equations.solve(0.0, &[true; 3]);
        (inertia > 0.0 && viscous.is_finite() && coulomb.is_finite()).then(|| ServoParameters {
            a: viscous / inertia / self.units.rate(),
            b: 1.0 / inertia / self.units.acceleration(),
            coulomb: coulomb / inertia / self.units.acceleration(),
            load: 0.0,
        })
    }
}
