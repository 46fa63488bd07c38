//! A commissioning as a transaction. From rest, the settings that hold are saved before anything moves. In place of a
//! run the store is left alone, which holds all of the old. The result is saved as one record, once it is validated and
//! the servo is disabled.

use drive_link::{
    Commissioning as LastCommissioning, Gains, Kept, NotAllowed, Origin, Outcome, Refusal,
    Settings, State,
};
use embedded_storage::nor_flash::NorFlash;
use identifier_core::commission::{CommissionSettings, HoldingGains, Phase, Reason};

use super::Supervisor;
use super::record::{Commissioned, Record};
use crate::commissioning::Commissioning;
use crate::conversion;
use crate::messages::{Mode, Order};
use crate::store::StoreError;

impl<F: NorFlash> Supervisor<'_, F> {
    /// Orders a commissioning, unless it is overtaken by a stop.
    pub(super) fn commission(
        &mut self,
        given: &CommissionSettings,
        listen: impl FnOnce(),
    ) -> Result<(), Refusal> {
        // Repeated, it is done already.
        if self.is_commissioning() && !self.is_stopping() && self.requested == Some(*given) {
            return Ok(());
        }
        let replaces_run = self.state() == State::Running && !self.is_stopping();
        if replaces_run {
            self.must_not_be_homing()?;
        } else {
            self.must_be_ready()?;
        }
        let commissioning = self.commissioning(given).map_err(Refusal::Setting)?;
        let Some(slot) = self.commissioning_slot.take() else {
            return Err(Refusal::Busy);
        };
        let commissioning = Mode::Commissioning(slot.filled(commissioning));
        let ordered = if replaces_run {
            self.order_after(listen, Order::Replace(commissioning))
        } else {
            self.mark_and_order(commissioning, listen)
        };
        match ordered {
            Ok(()) => (self.requested, self.phase) = (Some(*given), Phase::Idle),
            Err(_) => self.solver.end_commissioning(),
        }
        ordered
    }

    /// A commissioning with its solver begun.
    fn commissioning(&mut self, given: &CommissionSettings) -> Result<Commissioning, NotAllowed> {
        let core = &self.settings.closed_loop.core;
        for (name, value, own) in [
            ("sample_time", given.sample_time, core.sample_time),
            ("resolution", given.resolution, core.resolution),
        ] {
            if value.to_bits() != own.to_bits() {
                return Err(conversion::out_of_range(name, value, (own, own)));
            }
        }
        conversion::check_stage_limits(given.limits.command, &self.stage)?;
        let settings = CommissionSettings {
            command_delay: given.command_delay + self.stage.command_delay,
            ..*given
        };
        let before = core.controller.map(|controller| HoldingGains {
            controller,
            cutoff: core.cutoff,
        });
        let protection = &self.settings.protection;
        let commissioning = Commissioning::new(&settings, before.as_ref(), protection)?;
        let slices = commissioning.slices();
        self.solver.begin_commissioning(&settings, slices)?;
        self.channel.discard_record();
        Ok(commissioning)
    }

    /// Saves the settings that hold with the mark that a commissioning is under way, and orders it.
    fn mark_and_order(
        &mut self,
        commissioning: Mode,
        listen: impl FnOnce(),
    ) -> Result<(), Refusal> {
        if self.keep(true).is_err() {
            self.free(commissioning);
            return Err(Refusal::NotKept);
        }
        // To save may take long: only now is it known whether a stop has come.
        let ordered = self.order_after(listen, Order::Begin(commissioning));
        if ordered.is_err() {
            // If that fails, the next boot reports a commissioning that never began.
            let _ = self.keep(false);
        }
        ordered
    }

    /// Orders a commissioning, unless a stop has overtaken it.
    fn order_after(&mut self, listen: impl FnOnce(), order: Order) -> Result<(), Refusal> {
        listen();
        if let Err(refusal) = self.must_be_last() {
            self.take_back(order);
            return Err(refusal);
        }
        self.order(order)
    }

    /// Takes a commissioning back that is over, and saves its result.
    pub(super) fn conclude(&mut self, over: &'static mut Commissioning) {
        self.solver.end_commissioning();
        let mut outcome = over.outcome();
        self.free(Mode::Commissioning(over));
        let is_applied = outcome.commissioning.phase == Phase::Applied;
        if is_applied && self.apply(&outcome).is_err() {
            outcome.commissioning = LastCommissioning {
                phase: Phase::RolledBack,
                reason: Some(Reason::NoGains),
            };
        }
        self.save_pending |= outcome.commissioning.phase == Phase::Applied;
        self.outcome = Some(outcome);
        self.save_if_pending();
    }

    /// Saves the settings that hold, if that is pending and the servo is disabled: writing stops the processor, and with
    /// it the mode that holds the servo.
    pub(super) fn save_if_pending(&mut self) {
        if self.save_pending && !self.is_driven() {
            // If that fails, the store holds all of the old, and the next time may do.
            let _ = self.keep(false);
        }
    }

    /// Puts the result of a commissioning in force.
    fn apply(&mut self, outcome: &Outcome) -> Result<(), NotAllowed> {
        let (Some(servo), Some(tuning)) = (outcome.servo, outcome.tuning) else {
            return Err(conversion::refusal("gains", drive_link::Why::NotGiven));
        };
        let found = Commissioned::new(&servo, tuning, outcome.trial);
        self.settings = self.settings_with(&found)?;
        self.estimates = Some(conversion::identified(&servo));
        self.commissioned = Some(found);
        Ok(())
    }

    /// The settings in force with the gains of a commissioning.
    pub(super) fn settings_with(&self, found: &Commissioned) -> Result<Settings, NotAllowed> {
        let limit = self
            .requested
            .map_or([0.0; 2], |requested| requested.limits.command);
        found.settings(&self.settings, limit, &self.stage)
    }

    /// Saves the settings that hold.
    pub(super) fn keep(&mut self, under_way: bool) -> Result<(), StoreError> {
        self.store.keep(&Record {
            settings: self.settings,
            estimates: self.estimates,
            commissioned: self.commissioned,
            under_way,
        })?;
        self.kept = Kept::Record;
        self.save_pending = under_way;
        if let Some(outcome) = &mut self.outcome {
            let is_applied = outcome.commissioning.phase == Phase::Applied;
            outcome.kept = is_applied && self.commissioned.is_some();
        }
        Ok(())
    }

    /// Phase and reason of the last commissioning.
    pub(super) fn last_commissioning(&self) -> Option<LastCommissioning> {
        if self.is_commissioning() {
            return Some(LastCommissioning {
                phase: self.phase,
                reason: None,
            });
        }
        self.outcome.as_ref().map(|outcome| outcome.commissioning)
    }

    /// The gains that hold.
    pub(super) fn gains(&self) -> Option<Gains> {
        let core = &self.settings.closed_loop.core;
        let controller = core.controller.filter(|_| self.configured)?;
        Some(Gains {
            controller,
            cutoff: core.cutoff,
            origin: if self.commissioned.is_some() {
                Origin::Commissioned
            } else {
                Origin::Given
            },
        })
    }

    /// The outcome of the last commissioning in a record.
    pub(super) fn outcome_in(record: &Record) -> Option<Outcome> {
        if record.under_way {
            return Some(Outcome {
                commissioning: LastCommissioning {
                    phase: Phase::Aborted,
                    reason: Some(Reason::PowerLost),
                },
                servo: None,
                tuning: None,
                no_gains: None,
                trial: None,
                kept: false,
            });
        }
        record.commissioned.map(|found| Outcome {
            commissioning: LastCommissioning {
                phase: Phase::Applied,
                reason: None,
            },
            servo: Some(found.servo()),
            tuning: Some(found.tuning),
            no_gains: None,
            trial: found.trial,
            kept: true,
        })
    }
}
