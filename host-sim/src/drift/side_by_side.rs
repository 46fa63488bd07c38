use identifier_core::error::StepError;
use identifier_core::parameters::ServoParameters;
use identifier_core::units::Units;

use crate::loops::{Measurement, NO_ESTIMATE, SimLoop, Step};
use crate::scenario::{Arithmetic, Fault, Scenario};
use crate::simulate::{LocalLoop, closed_by_pid};
use identifier_log::experiment::Outcome;

/// The number formats that are compared: double precision, which the others are held against, first.
pub const FORMATS: [Arithmetic; 3] = [Arithmetic::F64, Arithmetic::F32, Arithmetic::Fixed];

/// Signals of a format in a sample, SI.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Signals {
    /// Velocity estimate, rad/s.
    pub velocity: f64,
    /// Command, command units.
    pub command: f64,
    /// Output error, rad.
    pub output_error: f64,
    /// The estimates.
    pub estimates: ServoParameters,
}

/// A signal that formats are compared in.
#[derive(Debug, Clone, Copy)]
pub struct Signal {
    /// Its name.
    pub name: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// Its value, SI.
    pub value: fn(&Signals) -> f64,
}

/// The signals.
pub const SIGNALS: [Signal; 7] = [
    signal("velocity", "rad/s", |signals| signals.velocity),
    signal("command", "command units", |signals| signals.command),
    signal("output error", "rad", |signals| signals.output_error),
    signal("a", "1/s", |signals| signals.estimates.a),
    signal("b", "rad/s² per command unit", |signals| {
        signals.estimates.b
    }),
    signal("coulomb", "rad/s²", |signals| signals.estimates.coulomb),
    signal("load", "rad/s²", |signals| signals.estimates.load),
];

const fn signal(name: &'static str, unit: &'static str, value: fn(&Signals) -> f64) -> Signal {
    Signal { name, unit, value }
}

/// A loop in every format on the same measurements: that in double precision commands the servo.
pub(super) struct SideBySide {
    /// In the order of [`FORMATS`].
    formats: [LocalLoop; 3],
    steps: [Option<Step>; 3],
    units: Units,
}

impl SideBySide {
    /// The loops of a scenario, at rest at a count.
    pub(super) fn new(scenario: &Scenario, start: i32) -> Result<Self, Fault> {
        let mut scenario = scenario.clone();
        // The settings that fixed point needs are given to every format.
        scenario.identifier.arithmetic = Arithmetic::Fixed;
        let settings = scenario.settings()?;
        let units = scenario.checked_units()?;
        let mut closed = |format: Arithmetic| {
            scenario.identifier.arithmetic = format;
            closed_by_pid(&scenario, &settings, start)
        };
        let [exact, single, fixed] = FORMATS;
        Ok(Self {
            formats: [closed(exact)?, closed(single)?, closed(fixed)?],
            steps: [None; 3],
            units,
        })
    }

    /// The signals of each in the last sample; NaN for one that it refused.
    pub(super) fn signals(&self) -> [Signals; 3] {
        let of = |number: Option<f64>| number.unwrap_or(f64::NAN);
        self.steps.map(|step| Signals {
            velocity: of(step.and_then(|step| step.velocity)) / self.units.velocity(),
            command: of(step.map(|step| step.command)),
            output_error: of(step.and_then(|step| step.output_error)) * self.units.position_unit(),
            estimates: step.map_or(NO_ESTIMATE, |step| step.estimates),
        })
    }
}

impl SimLoop for SideBySide {
    fn process(&mut self, reference: f64, measured: Measurement) -> Result<Step, StepError> {
        let [exact, others @ ..] = &mut self.formats;
        let acting = exact.process(reference, measured)?;
        let [first, steps @ ..] = &mut self.steps;
        *first = Some(acting);
        for (format, step) in others.iter_mut().zip(steps) {
            *step = format.process(reference, measured).ok();
        }
        Ok(acting)
    }

    fn outcome(&self) -> Outcome {
        self.formats[0].outcome()
    }
}
