//! The controller that is declared to have run, computed again from a log.

use identifier_core::Settings;
use identifier_core::control::{ControlState, Controller};
use identifier_core::error::StepError;
use identifier_core::measurement::velocity::VelocityEstimate;
use identifier_core::settings::SettingsError;

use super::Agreement;
use super::agreement::Comparison;
use super::heard::Heard;

/// The declared controller on its way through a log, in double precision: what a drive computes in is
/// not known.
pub(super) struct Declared<V: VelocityEstimate<f64>> {
    controller: Controller<f64, V>,
    control: ControlState<f64, V::State>,
    limit: [f64; 2],
    /// Command for a sum of errors of one position unit.
    integral_gain: f64,
    /// Whether the integral is known where a stretch begins.
    begins_known: bool,
    /// Whether the integral is what it was in the controller that ran.
    knows_integral: bool,
    is_lost: bool,
    comparison: Comparison,
}

impl<V: VelocityEstimate<f64>> Declared<V> {
    /// At rest. What its integral held when the log began is not known yet where the command was
    /// recorded, and nothing otherwise.
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

    /// Its command in a sample, with what was added to it.
    pub(super) fn process(&mut self, heard: &Heard) -> Result<f64, StepError> {
        let sample = self
            .controller
            .process(&mut self.control, heard.error, heard.increment)?;
        Ok(sample.command + heard.record.injection)
    }

    /// Holds its command against the one that was recorded in a log, by its number from 0, until there
    /// is a sample that it cannot compute with. `settled` says whether its velocity estimate can be
    /// relied on by now.
    pub(super) fn compare(&mut self, heard: &Heard, log: usize, settled: bool) {
        if !self.is_lost {
            self.is_lost = self.try_compare(heard, log, settled).is_err();
        }
    }

    fn try_compare(&mut self, heard: &Heard, log: usize, settled: bool) -> Result<(), StepError> {
        let record = &heard.record;
        let before = self.control;
        let mut command = self.process(heard)?;
        let Some(recorded) = record.command.filter(|_| settled && !record.bridged) else {
            return Ok(());
        };
        if !self.knows_integral {
            let Some(integral) = self.integral(before, heard, recorded - record.injection) else {
                return Ok(());
            };
            self.knows_integral = true;
            self.control = before.with_integral(integral);
            command = self.process(heard)?;
        }
        self.comparison.add(log, record.line, recorded, command);
        Ok(())
    }

    /// What the integral must have held for this command of the controller's own: what that needs beyond
    /// its proportional and derivative parts. A command at the limit says nothing of it: there the
    /// integral stood still, or not, at whatever it was.
    fn integral(
        &self,
        mut before: ControlState<f64, V::State>,
        heard: &Heard,
        own: f64,
    ) -> Option<f64> {
        /// A limit that passed through single precision or a few decimals is still the limit.
        const ROUNDED: f64 = 1e-5;
        let [low, high] = self.limit.map(|limit| (1.0 - ROUNDED) * limit);
        if own <= low || own >= high {
            return None;
        }
        let sample = self
            .controller
            .process(&mut before, heard.error, heard.increment)
            .ok()?;
        let pid = &self.controller.pid;
        let rest = own - pid.linear(sample.error, sample.velocity);
        Some(rest / self.integral_gain)
    }

    /// How well it reproduced the recorded command, where there is one.
    pub(super) fn agreement(&self) -> Option<Agreement> {
        self.comparison.finish()
    }
}
