//! A commissioning as a transaction. From rest, what held before is kept before anything moves. Beside a
//! loop the store is left alone, which holds all of the old. What was found is kept as one record, once it
//! is proved and the servo is let go.

use drive_link::{
    Commissioning as Standing, Gains, Kept, NotAllowed, Origin, Outcome, Refusal, Settings, State,
};
use embedded_storage::nor_flash::NorFlash;
use identifier_core::commission::{CommissionSettings, HoldingGains, Phase, StopReason};

use super::Supervisor;
use super::record::{Commissioned, Record};
use crate::commissioning::Commissioning;
use crate::messages::Order;
use crate::parts;
use crate::spare::Spare;
use crate::store::StoreError;

impl<F: NorFlash> Supervisor<'_, F> {
    /// Orders a commissioning, unless it is overtaken by a stop.
    pub(super) fn commission(
        &mut self,
        given: &CommissionSettings,
        overtaken: impl FnOnce(&Self) -> bool,
    ) -> Result<(), Refusal> {
        // Said again, it is done already.
        if self.is_commissioning() && !self.is_stopping() && self.ordered == Some(*given) {
            return Ok(());
        }
        let is_beside = self.state() == State::Running && !self.is_stopping();
        if !is_beside {
            self.must_be_ready()?;
        }
        let commissioning = self.commissioning(given).map_err(Refusal::Setting)?;
        let Some(spare) = self.spare_commissioning.take() else {
            return Err(Refusal::Busy);
        };
        let commissioning = spare.filled(commissioning);
        let ordered = if is_beside {
            self.order_unless(overtaken, Order::CommissionBeside(commissioning))
        } else {
            self.mark_and_order(commissioning, overtaken)
        };
        match ordered {
            Ok(()) => (self.ordered, self.phase) = (Some(*given), Phase::Idle),
            Err(_) => self.studying.end(),
        }
        ordered
    }

    /// A commissioning with its study begun.
    fn commissioning(&mut self, given: &CommissionSettings) -> Result<Commissioning, NotAllowed> {
        let core = &self.settings.closed_loop.core;
        for (name, value, own) in [
            ("sample_time", given.sample_time, core.sample_time),
            ("resolution", given.resolution, core.resolution),
        ] {
            if value.to_bits() != own.to_bits() {
                return Err(parts::out_of_range(name, value, (own, own)));
            }
        }
        parts::within_stage(given.limits.command, &self.stage)?;
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
        self.studying.begin(&settings, slices, &mut self.channel)?;
        Ok(commissioning)
    }

    /// Keeps what holds with the mark that a commissioning is under way, and has it begun.
    fn mark_and_order(
        &mut self,
        commissioning: &'static mut Commissioning,
        overtaken: impl FnOnce(&Self) -> bool,
    ) -> Result<(), Refusal> {
        if self.keep(true).is_err() {
            self.spare_commissioning = Some(Spare::Used(commissioning));
            return Err(Refusal::NotKept);
        }
        // To keep may take long: only now is it known whether a stop has come.
        let ordered = self.order_unless(overtaken, Order::Commission(commissioning));
        if ordered.is_err() {
            // If that fails, the next boot tells of a commissioning that never began.
            let _ = self.keep(false);
        }
        ordered
    }

    /// Orders a commissioning, unless a stop has overtaken it.
    fn order_unless(
        &mut self,
        overtaken: impl FnOnce(&Self) -> bool,
        order: Order,
    ) -> Result<(), Refusal> {
        let (order, refusal) = if overtaken(self) {
            (order, Refusal::Overtaken)
        } else {
            match self.channel.order(order) {
                Ok(()) => return Ok(()),
                Err(order) => (order, Refusal::Busy),
            }
        };
        if let Order::Commission(back) | Order::CommissionBeside(back) = order {
            self.spare_commissioning = Some(Spare::Used(back));
        }
        Err(refusal)
    }

    /// Takes a commissioning back that is over, and keeps what it came to.
    pub(super) fn conclude(&mut self, over: &'static mut Commissioning) {
        self.studying.end();
        let mut outcome = over.outcome();
        self.spare_commissioning = Some(Spare::Used(over));
        let is_applied = outcome.commissioning.phase == Phase::Applied;
        if is_applied && self.apply(&outcome).is_err() {
            outcome.commissioning = Standing {
                phase: Phase::RolledBack,
                reason: Some(StopReason::NoGains),
            };
        }
        self.unkept |= outcome.commissioning.phase == Phase::Applied;
        self.outcome = Some(outcome);
        self.keep_what_is_due();
    }

    /// Keeps what holds, if that is due and the servo is let go: writing stops the processor, and with it
    /// whatever holds the servo.
    pub(super) fn keep_what_is_due(&mut self) {
        if self.unkept && !self.is_out() {
            // If that fails, the store holds all of the old, and the next time may do.
            let _ = self.keep(false);
        }
    }

    /// Lets what was found hold from now on.
    fn apply(&mut self, outcome: &Outcome) -> Result<(), NotAllowed> {
        let (Some(servo), Some(tuning)) = (outcome.servo, outcome.tuning) else {
            return Err(parts::refusal("gains", drive_link::Why::NotGiven));
        };
        let found = Commissioned::new(&servo, tuning, outcome.trial);
        self.settings = self.with_gains_of(&found)?;
        self.estimates = Some(parts::identified(&servo));
        self.commissioned = Some(found);
        Ok(())
    }

    /// The settings that hold with the gains that were found.
    pub(super) fn with_gains_of(&self, found: &Commissioned) -> Result<Settings, NotAllowed> {
        let limit = self
            .ordered
            .map_or([0.0; 2], |ordered| ordered.limits.command);
        found.settings(&self.settings, limit, &self.stage)
    }

    /// Keeps what holds.
    pub(super) fn keep(&mut self, under_way: bool) -> Result<(), StoreError> {
        self.store.keep(&Record {
            settings: self.settings,
            estimates: self.estimates,
            commissioned: self.commissioned,
            under_way,
        })?;
        self.kept = Kept::Record;
        self.unkept = under_way;
        if let Some(outcome) = &mut self.outcome {
            let is_applied = outcome.commissioning.phase == Phase::Applied;
            outcome.kept = is_applied && self.commissioned.is_some();
        }
        Ok(())
    }

    /// How the last commissioning stands or ended.
    pub(super) fn commissioning_stands(&self) -> Option<Standing> {
        if self.is_commissioning() {
            return Some(Standing {
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

    /// What a record says of the last commissioning.
    pub(super) fn outcome_of(record: &Record) -> Option<Outcome> {
        if record.under_way {
            return Some(Outcome {
                commissioning: Standing {
                    phase: Phase::Aborted,
                    reason: Some(StopReason::PowerLost),
                },
                servo: None,
                tuning: None,
                no_gains: None,
                trial: None,
                kept: false,
            });
        }
        record.commissioned.map(|found| Outcome {
            commissioning: Standing {
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
