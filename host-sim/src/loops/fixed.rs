//! The Γ-gradient identifier in fixed point, alone and beside the PID of its loop.

use identifier_core::Settings;
use identifier_core::control::{Setpoint, Shaped, ShapedState};
use identifier_core::error::StepError;
use identifier_core::fixed_point::Word;
use identifier_core::identifier::{
    GradientIdentifier, GradientRecursion, Identify, ServoLoop, ServoLoopState, Update,
};
use identifier_core::measurement::VelocityEstimate;
use identifier_core::number::Arithmetic;
use identifier_core::parameters::{ParameterSet, PerParameter, ServoParameters};
use identifier_core::settings::SettingsError;

use super::identifier::Innovation;
use super::{DynIdentifier, Measurement, SimLoop, Step};
use crate::scenario::gamma_over;
use identifier_log::experiment::Outcome;

type LawState<V, S, const P: usize> = <GradientIdentifier<Word, V, S, P> as Identify<Word>>::State;

/// Controller and identifier in fixed point.
pub(crate) struct FixedLoop<V: VelocityEstimate<Word>, S: ParameterSet<P>, const P: usize> {
    servo_loop: ServoLoop<Word, V, GradientIdentifier<Word, V, S, P>, Shaped<Word>>,
    state: ServoLoopState<Word, V::State, LawState<V, S, P>, ShapedState<Word>>,
    start: i32,
    remembers: bool,
    known: Outcome,
}

impl<V: VelocityEstimate<Word>, S: ParameterSet<P>, const P: usize> FixedLoop<V, S, P> {
    /// At rest at a count, with its memory or without.
    ///
    /// # Errors
    /// The setting that does not fit the number format, and its range.
    pub(crate) fn new(
        settings: &Settings,
        start: i32,
        remembers: bool,
    ) -> Result<Self, SettingsError> {
        let servo_loop: ServoLoop<_, _, GradientIdentifier<Word, V, S, P>, _> = settings.build()?;
        Ok(Self {
            state: servo_loop.start(start),
            start,
            remembers,
            known: known(settings, servo_loop.identifier()),
            servo_loop,
        })
    }
}

impl<V: VelocityEstimate<Word>, S: ParameterSet<P>, const P: usize> SimLoop for FixedLoop<V, S, P> {
    fn process(&mut self, reference: f64, measured: Measurement) -> Result<Step, StepError> {
        let wanted = Setpoint::from_counts(reference);
        let setpoint = self.start.wrapping_add(wanted.count);
        let count = measured.count();
        let step = self
            .servo_loop
            .process(&mut self.state, setpoint, wanted.offset, count)?;
        let (controller, identifier) = (self.servo_loop.controller(), self.servo_loop.identifier());
        if self.remembers {
            self.servo_loop.work(&mut self.state, u32::MAX);
        }
        let report = identifier.report(self.state.identification());
        let snapshot = identifier.snapshot(self.state.identification());
        Ok(Step {
            command: controller.command(step.control.command),
            velocity: Some(controller.velocity(step.control.velocity)),
            output_error: Some(identifier.output_error(&step.seen)),
            event: Some(step.seen.event),
            estimates: identifier.estimates_in(&snapshot),
            standard_errors: report.errors_of_parameters(),
            at_bounds: identifier.at_bounds_in(&snapshot),
        })
    }

    fn outcome(&self) -> Outcome {
        self.known.clone()
    }
}

/// The identifier alone, which counts.
pub(crate) struct FixedIdentifier<V: VelocityEstimate<Word>, S: ParameterSet<P>, const P: usize> {
    identifier: GradientIdentifier<Word, V, S, P>,
    state: LawState<V, S, P>,
    remembers: bool,
    known: Outcome,
    /// The position from the first sample, counts, and the count nearest to it.
    position: f64,
    count: i64,
}

impl<V: VelocityEstimate<Word>, S: ParameterSet<P>, const P: usize> FixedIdentifier<V, S, P> {
    /// At rest, with its memory or without.
    ///
    /// # Errors
    /// The setting that does not fit the number format, and its range.
    pub(crate) fn new(settings: &Settings, remembers: bool) -> Result<Self, SettingsError> {
        let identifier: GradientIdentifier<Word, V, S, P> = settings.build()?;
        Ok(Self {
            state: identifier.start(),
            remembers,
            known: known(settings, &identifier),
            identifier,
            position: 0.0,
            count: 0,
        })
    }

    /// Whole counts of an increment: the fractions add up.
    fn moved(&mut self, increment: f64) -> i32 {
        self.position += increment;
        let count = self.position.round() as i64;
        let moved = count - self.count;
        self.count = count;
        // A counter of 32 bits.
        moved as i32
    }
}

impl<V: VelocityEstimate<Word>, S: ParameterSet<P>, const P: usize> DynIdentifier
    for FixedIdentifier<V, S, P>
{
    fn update(&mut self, increment: f64, command: f64) -> Result<Innovation, StepError> {
        let moved = self.moved(increment);
        let command = self.identifier.command_word(command);
        let update = self.identifier.process(&mut self.state, moved, command)?;
        if self.remembers {
            self.identifier.work(&mut self.state, u32::MAX);
        }
        Ok(Innovation {
            command: self.identifier.command(command),
            update: Some(Update {
                output_error: self.identifier.output_error(&update),
                event: update.event,
            }),
        })
    }

    fn estimates(&self) -> ServoParameters {
        let snapshot = self.identifier.snapshot(&self.state);
        self.identifier.estimates_in(&snapshot)
    }

    fn standard_errors(&self) -> Option<ServoParameters> {
        self.identifier.report(&self.state).errors_of_parameters()
    }

    fn at_bounds(&self) -> PerParameter<bool> {
        let snapshot = self.identifier.snapshot(&self.state);
        self.identifier.at_bounds_in(&snapshot)
    }

    fn resume_moving(&mut self, increment: f64) {
        let increment = self.identifier.increment(increment.round() as i32);
        self.identifier.resume_moving(&mut self.state, increment);
    }

    fn outcome(&self) -> Outcome {
        self.known.clone()
    }
}

/// The outcome of a gradient estimator before its first sample.
pub(crate) fn known<N: Arithmetic, V: VelocityEstimate<N>, S: ParameterSet<P>, const P: usize>(
    settings: &Settings,
    identifier: &GradientRecursion<N, V, S, P>,
) -> Outcome {
    Outcome {
        gamma: gamma_over::<S, P>(settings),
        mu: Some(identifier.mu()),
        certified: identifier.certificate().is_some(),
        gain_margin: identifier.gain_margin(),
        ..Outcome::default()
    }
}
