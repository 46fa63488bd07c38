//! The controller that is declared to have run, computed again from a log.

use identifier_core::Settings;
use identifier_core::control::{ControlState, Controller};
use identifier_core::error::StepError;
use identifier_core::measurement::velocity::VelocityEstimate;
use identifier_core::settings::SettingsError;

use super::Agreement;
use super::agreement::Comparison;
use super::scaled::ScaledRow;

/// The declared controller on its way through a log, in double precision: the number format of the drive is
/// unknown.
pub(super) struct Declared<V: VelocityEstimate<f64>> {
    controller: Controller<f64, V>,
    control: ControlState<f64, V::State>,
    limit: [f64; 2],
    /// Command for a sum of errors of one position unit.
    integral_gain: f64,
    /// True if the integral is known where a stretch begins.
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
        let (given, units) = (settings.own_controller()?, settings.units()?);
        let begins_known = given.ki <= 0.0 || !command_recorded;
        Ok(Self {
            controller: settings.build()?,
            control: ControlState::default(),
            limit: given.limit,
            integral_gain: given.ki * units.rate() / units.position(),
            begins_known,
            knows_integral: begins_known,
            is_lost: false,
            comparison: Comparison::default(),
        })
    }

    /// Begins again at the first sample of a stretch.
    pub(super) fn begin(&mut self) {
        self.control = ControlState::default();
        self.knows_integral = self.begins_known;
    }

    /// Its command in a sample, with the injection.
    pub(super) fn process(&mut self, scaled: &ScaledRow) -> Result<f64, StepError> {
        let sample = self
            .controller
            .process(&mut self.control, scaled.error, scaled.increment)?;
        Ok(sample.command + scaled.row.injection)
    }

    /// Holds its command against the one that was recorded in a log, by its number from 0, until there
    /// is a sample that it cannot compute with; `settled` once its velocity estimate is reliable.
    pub(super) fn compare(&mut self, scaled: &ScaledRow, log: usize, settled: bool) {
        if !self.is_lost {
            self.is_lost = self.try_compare(scaled, log, settled).is_err();
        }
    }

    fn try_compare(
        &mut self,
        scaled: &ScaledRow,
        log: usize,
        settled: bool,
    ) -> Result<(), StepError> {
        let row = &scaled.row;
        let before = self.control;
        let mut command = self.process(scaled)?;
        let Some(recorded) = row.command.filter(|_| settled && !row.bridged) else {
            return Ok(());
        };
        if !self.knows_integral {
            let Some(integral) = self.integral(before, scaled, recorded - row.injection) else {
                return Ok(());
            };
            self.knows_integral = true;
            self.control = before.with_integral(integral);
            command = self.process(scaled)?;
        }
        self.comparison.add(log, row.line, recorded, command);
        Ok(())
    }

    /// The integral behind this command of the controller's own: the command less its proportional and
    /// derivative parts. A command at the limit does not determine it.
    fn integral(
        &self,
        mut before: ControlState<f64, V::State>,
        scaled: &ScaledRow,
        own: f64,
    ) -> Option<f64> {
        /// Relative rounding of a limit in single precision or a few decimals.
        const ROUNDING: f64 = 1e-5;
        let [low, high] = self.limit.map(|limit| (1.0 - ROUNDING) * limit);
        if own <= low || own >= high {
            return None;
        }
        let sample = self
            .controller
            .process(&mut before, scaled.error, scaled.increment)
            .ok()?;
        let pid = &self.controller.pid;
        let rest = own - pid.linear(sample.error, sample.velocity);
        Some(rest / self.integral_gain)
    }

    /// Its agreement with the recorded command, where there is one.
    pub(super) fn agreement(&self) -> Option<Agreement> {
        self.comparison.finish()
    }
}
