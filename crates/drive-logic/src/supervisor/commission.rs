//! A commissioning as a transaction: what held before is kept before anything moves; what was found is
//! kept as one record, once it is proved and the servo is let go.

use drive_link::{Commissioning as Standing, Gains, Kept, NotAllowed, Origin, Outcome, Refusal};
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
        self.must_be_ready()?;
        let commissioning = self.commissioning(given).map_err(Refusal::Setting)?;
        let Some(spare) = self.spare_commissioning.take() else {
            return Err(Refusal::Busy);
        };
        let commissioning = spare.filled(commissioning);
        let ordered = self.mark_and_order(commissioning, overtaken);
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
        let refused = if overtaken(self) {
            self.spare_commissioning = Some(Spare::Used(commissioning));
            Refusal::Overtaken
        } else {
            match self.channel.order(Order::Commission(commissioning)) {
                Ok(()) => return Ok(()),
                Err(Order::Commission(back)) => {
                    self.spare_commissioning = Some(Spare::Used(back));
                    Refusal::Busy
                }
                Err(_) => Refusal::Busy,
            }
        };
        // If that fails, the next boot tells of a commissioning that never began.
        let _ = self.keep(false);
        Err(refused)
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
        let is_applied = outcome.commissioning.phase == Phase::Applied;
        let kept = self.keep(false);
        outcome.kept = is_applied && kept.is_ok();
        self.outcome = Some(outcome);
    }

    /// Lets what was found hold from now on.
    fn apply(&mut self, outcome: &Outcome) -> Result<(), NotAllowed> {
        let (Some(servo), Some(tuning)) = (outcome.servo, outcome.tuning) else {
            return Err(parts::refusal("gains", drive_link::Why::NotGiven));
        };
        let found = Commissioned::new(&servo, tuning, outcome.trial);
        let limit = self
            .ordered
            .map_or([0.0; 2], |ordered| ordered.limits.command);
        self.settings = found.settings(&self.settings, limit, &self.stage)?;
        self.estimates = Some(parts::identified(&servo));
        self.commissioned = Some(found);
        Ok(())
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
        self.outcome.map(|outcome| outcome.commissioning)
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
            trial: found.trial,
            kept: true,
        })
    }
}
