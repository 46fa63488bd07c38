//! A commissioning as a transaction. From rest, the settings that hold are saved before anything moves. In place of a
//! run the store is left alone, which holds all of the old. The result is saved as one record, once it is validated and
//! the servo is disabled.

use commissioning::{CommissionIsr, CommissionSettings, HoldingGains, Limits, Phase};
use drive_link::{
    Commissioned, Commissioning as LastCommissioning, Estimates, Estimator, Gains, Kept,
    NotAllowed, Origin, Outcome, Protection, Record, Refusal, Settings, State, Why,
};
use embedded_storage::nor_flash::NorFlash;
use identifier_core::error::Allowed;
use identifier_core::reason::Reason;
use identifier_core::settings::{ControllerSettings, IdentifierSettings};
use identifier_core::units::Units;

use super::Supervisor;
use super::memory::Slot;
use super::solver::Solver;
use crate::brake::BrakeTimes;
use crate::built::{HAS_COMMISSIONING, Part, not_built};
use crate::chip::OutputStage;
use crate::commissioning::Commissioning;
use crate::ending::REST_TIME;
use crate::limits::AllowedRange;
use crate::messages::{Mode, Order};
use crate::protection::largest;
use crate::run::Run;
use crate::store::StoreError;
use crate::{conversion, guide};

impl<F: NorFlash> Supervisor<'_, F> {
    /// Orders a commissioning, unless it is overtaken by a stop.
    pub(super) fn commission(
        &mut self,
        given: &CommissionSettings,
        listen: impl FnOnce(),
    ) -> Result<(), Refusal> {
        let replaces_run = self.state() == State::Running && !self.is_stopping();
        if replaces_run {
            self.must_not_be_homing()?;
        } else {
            self.must_be_startable()?;
        }
        self.prepare_commissioning(given)?;
        let slot = self.commissioning_slot.take();
        let Some(commissioning) = slot.and_then(Slot::into_filled) else {
            return Err(Refusal::Busy);
        };
        let commissioning = Mode::Commissioning(commissioning);
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

    /// Fills the slot with a commissioning, and begins its solver.
    fn prepare_commissioning(&mut self, given: &CommissionSettings) -> Result<(), Refusal> {
        let position = self.position();
        let slot = self.commissioning_slot.as_mut().ok_or(Refusal::Busy)?;
        let (settings, stage) = (&self.settings, &self.stage);
        let known = self.estimates.as_ref();
        let begun = prepare(
            slot,
            &mut self.solver,
            given,
            settings,
            position,
            known,
            stage,
        );
        begun.map_err(Refusal::Setting)?;
        self.channel.discard_record();
        Ok(())
    }

    /// Saves the settings that hold with the mark that a commissioning is under way, and orders it.
    fn mark_and_order(
        &mut self,
        commissioning: Mode,
        listen: impl FnOnce(),
    ) -> Result<(), Refusal> {
        if let Err(refusal) = self.keep(true) {
            self.free(commissioning);
            return Err(refusal);
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
    pub(super) fn conclude(&mut self, over: &'static mut Part<Commissioning>) {
        self.solver.end_commissioning();
        let mut outcome = over.outcome();
        self.invalidate_position_after(outcome.commissioning.reason);
        self.free(Mode::Commissioning(over));
        let is_applied = outcome.commissioning.phase == Phase::Applied;
        if is_applied && self.apply(&outcome).is_err() {
            outcome.commissioning = LastCommissioning {
                phase: Phase::RolledBack,
                reason: Some(Reason::NoGains),
            };
        }
        self.outcome = Some(outcome);
    }

    /// True for commissioned gains that do not survive a loss of power yet.
    pub(super) fn has_unsaved_gains(&self) -> bool {
        let is_unsaved = |last: &Outcome| last.commissioning.phase == Phase::Applied && !last.kept;
        self.commissioned.is_some() && self.outcome.as_ref().is_some_and(is_unsaved)
    }

    /// Saves the settings in force, if that is pending and the servo is disabled. Writing stops the processor, and with
    /// it the mode that holds the servo.
    pub(super) fn save_if_pending(&mut self) {
        if self.save_pending && !self.is_driven() && (self.stands() || !self.store.must_erase()) {
            // If that fails, the store holds all of the old, and the end of the next run may do.
            self.save_pending = false;
            let _ = self.keep(false);
        }
    }

    /// The disabled servo stands. No sample follows it while the flash is erased.
    fn stands(&self) -> bool {
        f64::from(self.channel.standstill()) * self.sample_time() >= REST_TIME
    }

    /// Puts the result of a commissioning in force.
    fn apply(&mut self, outcome: &Outcome) -> Result<(), NotAllowed> {
        let (Some(servo), Some(tuning)) = (outcome.servo, outcome.tuning) else {
            return Err(NotAllowed::new("gains", Why::NotGiven));
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
        settings_with(found, &self.settings, limit, &self.stage)
    }

    /// Saves the settings that hold.
    ///
    /// # Errors
    /// The servo does not stand, or the flash does not take the record.
    pub(super) fn keep(&mut self, under_way: bool) -> Result<(), Refusal> {
        let record = Record {
            settings: self.settings,
            estimates: self.estimates,
            commissioned: self.commissioned,
            under_way,
        };
        let build = self.stage.build(Record::VERSION);
        let (stands, erasures) = (self.stands(), self.store.erasures());
        let kept = self.store.keep(stands, |room| record.to_bytes(build, room));
        if self.store.erasures() != erasures {
            // Meanwhile an axis that is turned may lose a turn of the counter.
            self.origin = guide::Origin::Start;
        }
        kept.map_err(|error| match error {
            StoreError::MustErase => Refusal::NotAtRest,
            _ => Refusal::NotKept,
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
            origin: match self.commissioned {
                Some(_) => Origin::Commissioned,
                None => Origin::Given,
            },
        })
    }

    /// The outcome of the last commissioning in a record.
    pub(super) fn outcome_in(record: &Record) -> Option<Outcome> {
        let found = record.commissioned.filter(|_| !record.under_way);
        let (phase, reason) = match &found {
            Some(_) => (Phase::Applied, None),
            None => (Phase::Aborted, Some(Reason::PowerLost)),
        };
        (record.under_way || found.is_some()).then(|| Outcome {
            commissioning: LastCommissioning { phase, reason },
            servo: found.as_ref().map(Commissioned::servo),
            tuning: found.map(|found| found.tuning),
            no_gains: None,
            trial: found.and_then(|found| found.trial),
            noise: 0.0,
            kept: found.is_some(),
        })
    }
}

/// Checks that an order for an axis at this position, rad from the origin, asks for no more than the settings allow. The
/// travel that is left to it, rad from there.
///
/// # Errors
/// The limit that is wider than the drive's.
#[inline(never)]
fn check_order(order: &Limits, settings: &Settings, position: f64) -> Result<[f64; 2], NotAllowed> {
    /// Part of the travel by which an axis at rest may be off its target: the loop holds it against friction.
    const OFF_TARGET: f64 = 0.01;
    let Protection { travel, speed, .. } = settings.protection;
    let travel = AllowedRange::new(travel);
    travel.narrowed("travel", order.travel)?;
    let from_here = travel.seen_from(position);
    if position.abs() > OFF_TARGET * travel.width() {
        from_here.narrowed("travel", order.travel)?;
    }
    let speeds = AllowedRange::new([-speed, speed]);
    speeds.narrowed("speed", [order.speed; 2])?;
    if let Some(controller) = settings.closed_loop.core.controller {
        AllowedRange::new(controller.limit).narrowed("command", order.command)?;
    }
    Ok(from_here.clipped(order.travel))
}

/// Fills a slot with a commissioning beside these settings, of an axis at this position, rad from the origin, and begins
/// its solver.
///
/// Not generic, to be compiled here and once.
#[inline(never)]
fn prepare(
    slot: &mut Slot<Part<Commissioning>>,
    solver: &mut Solver,
    given: &CommissionSettings,
    beside: &Settings,
    position: f64,
    known: Option<&Estimates>,
    stage: &OutputStage,
) -> Result<(), NotAllowed> {
    if !HAS_COMMISSIONING {
        return Err(not_built("commissioning"));
    }
    let core = &beside.closed_loop.core;
    for (name, value, own) in [
        ("sample_time", given.sample_time, core.sample_time),
        ("resolution", given.resolution, core.resolution),
    ] {
        Allowed::Within(own, own).check(name, value)?;
    }
    let units = core.units()?;
    let limits = &given.limits;
    let ([low, high], [farthest, fastest, longest]) = (limits.travel, largest(&units));
    Allowed::PositiveUpTo(farthest).check("travel", high - low)?;
    Allowed::PositiveUpTo(fastest).check("speed", limits.speed)?;
    Allowed::PositiveUpTo(longest).check("duration", limits.duration)?;
    conversion::check_stage_limits(limits.command, stage)?;
    let travel = check_order(limits, beside, position)?;
    let settings = CommissionSettings {
        limits: Limits { travel, ..*limits },
        command_delay: given.command_delay + stage.command_delay,
        ..*given
    };
    let before = HoldingGains::of(core);
    let brake = BrakeTimes::new(beside.brake.as_ref(), &units)?;
    // Without a brake a load of before may be gone, and its command would move the axis.
    let known = known.filter(|_| brake.is_some());
    let [low, high] = limits.command;
    let balance = known.map_or(0.0, |known| {
        conversion::balance(known, [f64::NEG_INFINITY, f64::INFINITY])
    });
    settings.check_held(balance)?;
    let balance = balance.max(low).min(high);
    let isr = CommissionIsr::new(&settings, before.as_ref())?;
    solver.begin_commissioning(&settings, isr.slices())?;
    fill(
        slot,
        isr,
        &beside.protection,
        &units,
        (balance as f32, brake),
    );
    Ok(())
}

/// Fills a slot with a commissioning. Not inlined, for its stack to be free again.
#[inline(never)]
fn fill(
    slot: &mut Slot<Part<Commissioning>>,
    isr: CommissionIsr<f32>,
    protection: &Protection,
    units: &Units,
    hold: (f32, Option<BrakeTimes>),
) {
    if let Some(part) = Part::of(Commissioning::new(isr, protection, units, hold)) {
        slot.fill(part);
    }
}

/// Settings with the gains of a commissioning, within the limits of the command that were given, or else these. An
/// estimator that is rejected with its gains, for example with a parameter range for others, is replaced by
/// Gauss–Newton. That needs no range.
///
/// # Errors
/// The setting that is not allowed all the same.
#[inline(never)]
fn settings_with(
    found: &Commissioned,
    given: &Settings,
    limit: [f64; 2],
    stage: &OutputStage,
) -> Result<Settings, NotAllowed> {
    let tuning = &found.tuning;
    let mut settings = *given;
    let closed_loop = &mut settings.closed_loop;
    let limit = closed_loop.core.controller.map_or(limit, |own| own.limit);
    closed_loop.core.cutoff = tuning.cutoff;
    closed_loop.core.controller = Some(ControllerSettings::tuned(tuning, limit));
    if Run::check(&settings, stage).is_err() {
        let closed_loop = &mut settings.closed_loop;
        closed_loop.core.identifier = IdentifierSettings::UNSTATED;
        closed_loop.law = Estimator::GaussNewton;
        Run::check(&settings, stage)?;
    }
    Ok(settings)
}

#[cfg(test)]
mod tests {
    use drive_link::{Estimator, LoopSettings};

    use super::*;

    #[test]
    fn an_axis_that_is_a_little_off_its_target_keeps_what_is_left_of_its_travel() {
        let core = identifier_core::Settings::new(1e-3, 1e4);
        let law = Estimator::GaussNewton;
        let mut settings = Settings::example(LoopSettings { core, law });
        (settings.protection.travel, settings.protection.speed) = ([-8.0, 8.0], 60.0);
        let order = Limits::new([-8.0, 8.0], 60.0, [-10.0, 10.0]);
        for (position, left) in [(0.15, [-8.0, 7.85]), (-0.15, [-7.85, 8.0])] {
            let found = check_order(&order, &settings, position).expect("allowed");
            let off = |end: usize| (found[end] - left[end]).abs();
            assert!(off(0).max(off(1)) < 1e-12, "{found:?}");
        }
    }
}
