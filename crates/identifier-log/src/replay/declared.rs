//! The controller that is declared to have run, computed again from a log.

use identifier_core::Settings;
use identifier_core::control::{ControlSample, ControlState, Controller, Shaped, ShapedState};
use identifier_core::error::StepError;
use identifier_core::measurement::VelocityEstimate;
use identifier_core::settings::SettingsError;

use super::Agreement;
use super::agreement::Comparison;
use super::scaled::ScaledRow;

/// The declared controller in double precision: the number format of the drive is unknown.
#[derive(Debug)]
pub(crate) struct DeclaredPid<V: VelocityEstimate<f64>> {
    controller: Controller<f64, V, Shaped<f64>>,
    limit: [f64; 2],
    /// Command for a sum of errors of one position unit.
    integral_gain: f64,
}

type State<V> = ControlState<f64, <V as VelocityEstimate<f64>>::State, ShapedState<f64>>;

impl<V: VelocityEstimate<f64>> DeclaredPid<V> {
    pub(crate) fn new(settings: &Settings) -> Result<Self, SettingsError> {
        let (given, units) = (settings.own_controller()?, settings.units()?);
        Ok(Self {
            controller: settings.build()?,
            limit: given.limit,
            integral_gain: given.ki * units.rate() / units.position(),
        })
    }

    pub(crate) fn has_integral(&self) -> bool {
        self.integral_gain > 0.0
    }

    /// A sample, from error and increment, position units.
    pub(crate) fn process(
        &self,
        state: &mut State<V>,
        error: f64,
        increment: f64,
    ) -> Result<ControlSample<f64>, StepError> {
        self.controller.process(state, error, increment)
    }

    /// The state before a sample with the integral behind its `own` command, which is the command minus its
    /// proportional and derivative parts. A command at the limit does not determine it.
    pub(crate) fn with_integral(
        &self,
        mut before: State<V>,
        error: f64,
        increment: f64,
        own: f64,
    ) -> Option<State<V>> {
        /// Relative rounding of a limit in single precision or a few decimals.
        const COMMAND_TOLERANCE: f64 = 1e-5;
        let [low, high] = self.limit.map(|limit| (1.0 - COMMAND_TOLERANCE) * limit);
        if own <= low || own >= high {
            return None;
        }
        let state = before;
        let step = self.process(&mut before, error, increment).ok()?;
        let rest = own - self.controller.linear(step.error, step.velocity);
        Some(state.with_integral(rest / self.integral_gain))
    }
}

/// The declared controller on its way through a log.
#[derive(Debug)]
pub(super) struct Declared<V: VelocityEstimate<f64>> {
    pid: DeclaredPid<V>,
    control: State<V>,
    /// True if the integral is known where a segment begins.
    begins_known: bool,
    /// True once the integral is that of the controller that ran.
    knows_integral: bool,
    is_lost: bool,
    comparison: Comparison,
}

impl<V: VelocityEstimate<f64>> Declared<V> {
    /// At rest. Its integral at the beginning of the log is unknown where the command was recorded, and zero
    /// otherwise.
    pub(super) fn new(settings: &Settings, command_recorded: bool) -> Result<Self, SettingsError> {
        let pid = DeclaredPid::new(settings)?;
        let begins_known = !pid.has_integral() || !command_recorded;
        Ok(Self {
            pid,
            control: ControlState::default(),
            begins_known,
            knows_integral: begins_known,
            is_lost: false,
            comparison: Comparison::default(),
        })
    }

    /// Begins again at the first sample of a segment.
    pub(super) fn begin(&mut self) {
        self.control = ControlState::default();
        self.knows_integral = self.begins_known;
    }

    /// Its command in a sample.
    pub(super) fn process(&mut self, scaled: &ScaledRow) -> Result<f64, StepError> {
        let (error, increment) = (scaled.error, scaled.increment);
        let sample = self.pid.process(&mut self.control, error, increment)?;
        Ok(sample.command)
    }

    /// Compares its command with the recorded one in a log, by its number from 0, until it cannot compute a sample. The
    /// argument `comparable` is true once its velocity estimate is reliable.
    pub(super) fn compare(&mut self, scaled: &ScaledRow, log: usize, comparable: bool) {
        if !self.is_lost {
            self.is_lost = self.try_compare(scaled, log, comparable).is_err();
        }
    }

    fn try_compare(
        &mut self,
        scaled: &ScaledRow,
        log: usize,
        comparable: bool,
    ) -> Result<(), StepError> {
        let row = &scaled.row;
        let before = self.control;
        let mut command = self.process(scaled)?;
        if row.bridged {
            // The input of the integral is not recorded.
            self.knows_integral = !self.pid.has_integral();
        }
        let Some(recorded) = row.command.filter(|_| comparable) else {
            return Ok(());
        };
        if !self.knows_integral {
            let (error, increment) = (scaled.error, scaled.increment);
            let Some(known) = (self.pid).with_integral(before, error, increment, recorded) else {
                return Ok(());
            };
            self.knows_integral = true;
            self.control = known;
            command = self.process(scaled)?;
        }
        self.comparison
            .add(log, u64::from(row.line), recorded, command);
        Ok(())
    }

    /// Its agreement with the recorded command, where there is one.
    pub(super) fn agreement(&self) -> Option<Agreement> {
        self.comparison.finish()
    }
}
