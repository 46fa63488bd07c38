//! Runs, from the servo's rest position and from the one where a commissioning holds it.

use commissioning::Phase;
use commissioning::servo_change::ServoChangeState;
use drive_link::{Commissioned, Estimates, NotAllowed, Refusal, Settings};
use embedded_storage::nor_flash::NorFlash;

use super::Supervisor;
use super::memory::Slot;
use super::solver::{Learner, Solver};
use crate::chip::OutputStage;
use crate::conversion;
use crate::messages::{Mode, Order};
use crate::run::Run;

impl<F: NorFlash> Supervisor<'_, F> {
    /// Orders a run from the servo's position, unless it is overtaken by a stop.
    pub(super) fn start(&mut self, listen: impl FnOnce()) -> Result<(), Refusal> {
        self.must_be_startable()?;
        let learner = self.prepare_before()?;
        listen();
        self.must_be_last()?;
        self.order_run(learner, Order::Begin)
    }

    /// Orders a run if a commissioning that is over holds the servo, unless it was ordered already. The gains are those
    /// that it validated, or those before.
    #[cold]
    #[inline(never)]
    pub(super) fn resume(&mut self) {
        if self.is_stopping() || self.run_slot.is_none() {
            return;
        }
        let prepared = self
            .prepare_validated()
            .or_else(|| self.prepare_before().ok());
        match prepared {
            // If there is no room for the order, the next turn tries again.
            Some(learner) => drop(self.order_run(learner, Order::Replace)),
            None => self.channel.stop(),
        }
    }

    /// Prepares a run under the gains that a commissioning has validated, if it has, and with its knowledge of the servo.
    #[inline(never)]
    fn prepare_validated(&mut self) -> Option<Option<Learner>> {
        if self.phase != Phase::Applied {
            return None;
        }
        let (servo, tuning) = (self.solver.servo()?, self.solver.tuning()?);
        let known = Known {
            estimates: Some(conversion::identified(servo)),
            commissioned: Some(Commissioned::new(servo, *tuning, None)),
            is_latest: true,
        };
        let settings = self.settings_with(known.commissioned.as_ref()?).ok()?;
        prepare(self.run_slot.as_mut()?, &settings, &known, &self.stage).ok()
    }

    /// Prepares one under the settings in force.
    #[inline(never)]
    fn prepare_before(&mut self) -> Result<Option<Learner>, Refusal> {
        let known = self.known();
        let slot = self.run_slot.as_mut().ok_or(Refusal::Busy)?;
        prepare(slot, &self.settings, &known, &self.stage).map_err(Refusal::Setting)
    }

    /// Knowledge of the servo: from a commissioning, and what a run has learnt since.
    fn known(&self) -> Known {
        let found = self
            .commissioned
            .map(|found| conversion::identified(&found.servo()));
        Known {
            estimates: self.estimates,
            commissioned: self.commissioned,
            is_latest: found == self.estimates,
        }
    }

    /// Orders the run that was prepared from these settings.
    #[inline(never)]
    fn order_run(
        &mut self,
        learner: Option<Learner>,
        order: impl FnOnce(Mode) -> Order,
    ) -> Result<(), Refusal> {
        let Some(run) = self.run_slot.take().and_then(Slot::into_filled) else {
            return Err(Refusal::Busy);
        };
        run.set_origin(self.origin);
        let identifier = run.closed_loop().identifier();
        self.order(order(Mode::Run(run)))?;
        self.identifier = Some(identifier);
        self.known_before = self.estimates;
        self.changes = ServoChangeState::default();
        self.solver.begin_run(learner);
        Ok(())
    }
}

/// Fills a slot with a run that starts from the knowledge of the servo. If the settings would be rejected with it, the
/// run starts from the configuration. Returns the background's half of its estimator.
///
/// Not generic, to be compiled here and once.
#[inline(never)]
fn prepare(
    slot: &mut Slot<Run>,
    settings: &Settings,
    known: &Known,
    stage: &OutputStage,
) -> Result<Option<Learner>, NotAllowed> {
    let (mut begun, mut is_latest) = (*settings, known.is_latest);
    if let Some(estimates) = &known.estimates {
        conversion::set_initial(estimates, &mut begun.closed_loop.core.identifier);
    }
    let run = match fill(slot, &begun, stage) {
        Ok(run) => run,
        Err(_) => {
            (begun, is_latest) = (*settings, false);
            fill(slot, &begun, stage)?
        }
    };
    if let Some(estimates) = &known.estimates {
        run.balance(estimates, &begun);
    }
    if let Some(found) = &known.commissioned {
        let servo = found.servo();
        run.know(&servo);
        if is_latest {
            run.begin_from(&servo, &found.motion());
        }
    }
    Ok(Solver::learner(&begun.closed_loop, run.closed_loop()))
}

/// Fills a slot with a run. Not inlined, for its stack to be free again.
#[inline(never)]
fn fill<'a>(
    slot: &'a mut Slot<Run>,
    settings: &Settings,
    stage: &OutputStage,
) -> Result<&'a mut Run, NotAllowed> {
    Ok(slot.fill(Run::new(settings, stage)?))
}

/// Knowledge of the servo before a run.
struct Known {
    estimates: Option<Estimates>,
    /// The servo with its covariance, where a commissioning has found it; false if a run has learnt since.
    commissioned: Option<Commissioned>,
    is_latest: bool,
}
