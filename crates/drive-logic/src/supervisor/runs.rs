//! Runs, from where the servo rests and from where a commissioning holds it.

use drive_link::{Estimates, LoopSettings, NotAllowed, Refusal, Settings};
use embedded_storage::nor_flash::NorFlash;
use identifier_core::commission::Phase;

use super::Supervisor;
use super::record::Commissioned;
use crate::conversion;
use crate::messages::{Mode, Order};
use crate::run::Run;

impl<F: NorFlash> Supervisor<'_, F> {
    /// Orders a run from where the servo stands, unless it is overtaken by a stop.
    pub(super) fn start(&mut self, listen: impl FnOnce()) -> Result<(), Refusal> {
        self.must_be_ready()?;
        let prepared = self.prepared(&self.settings, &self.known());
        let prepared = prepared.map_err(Refusal::Setting)?;
        listen();
        self.must_be_last()?;
        self.order_run(prepared, Order::Begin)
    }

    /// Orders a run where a commissioning that is over holds the servo, unless it was ordered already: with
    /// the gains that it validated, or with those before.
    #[cold]
    #[inline(never)]
    pub(super) fn resume(&mut self) {
        if self.run_slot.is_none() || self.is_stopping() {
            return;
        }
        let prepared = self
            .validated()
            .and_then(|(settings, known)| self.prepared(&settings, &known).ok())
            .or_else(|| self.prepared(&self.settings, &self.known()).ok());
        match prepared {
            // If there is no room for the order, the next turn tries again.
            Some(prepared) => drop(self.order_run(prepared, Order::Replace)),
            None => self.channel.stop(),
        }
    }

    /// The settings with the gains that a commissioning has validated, and its knowledge of the servo.
    fn validated(&self) -> Option<(Settings, Known)> {
        if self.phase != Phase::Applied {
            return None;
        }
        let (servo, tuning) = (self.solver.servo()?, self.solver.tuning()?);
        let found = Commissioned::new(servo, *tuning, None);
        let settings = self.settings_with(&found).ok()?;
        let known = Known {
            estimates: Some(conversion::identified(servo)),
            identified: Some(found),
        };
        Some((settings, known))
    }

    /// Knowledge of the servo: from a commissioning, unless a run has learnt since.
    fn known(&self) -> Known {
        let estimates = self.estimates;
        let is_latest =
            |found: &Commissioned| estimates == Some(conversion::identified(&found.servo()));
        Known {
            estimates,
            identified: self.commissioned.filter(is_latest),
        }
    }

    /// A run that starts from the knowledge of the servo; from the configuration, where the settings would be refused
    /// with that.
    fn prepared(&self, settings: &Settings, known: &Known) -> Result<Prepared, NotAllowed> {
        let of = |settings: &Settings| {
            Run::new(settings, &self.stage).map(|run| Prepared {
                run,
                begun_from: settings.closed_loop,
            })
        };
        if let Some(estimates) = &known.estimates {
            let mut settings = *settings;
            conversion::set_initial(estimates, &mut settings.closed_loop.core.identifier);
            if let Ok(mut prepared) = of(&settings) {
                if let Some(found) = &known.identified {
                    prepared.run.know(&found.servo(), &found.motion());
                }
                return Ok(prepared);
            }
        }
        of(settings)
    }

    fn order_run(&mut self, prepared: Prepared, order: fn(Mode) -> Order) -> Result<(), Refusal> {
        let Prepared {
            mut run,
            begun_from,
        } = prepared;
        run.set_origin(self.origin);
        let Some(slot) = self.run_slot.take() else {
            return Err(Refusal::Busy);
        };
        let run = slot.filled(run);
        let closed_loop = *run.closed_loop();
        self.channel.discard_record();
        self.order(order(Mode::Run(run)))?;
        self.closed_loop = Some(closed_loop);
        self.solver.begin_run(&begun_from);
        Ok(())
    }
}

/// A run, and the settings that its loop was built from.
struct Prepared {
    run: Run,
    begun_from: LoopSettings,
}

/// Knowledge of the servo before a run.
struct Known {
    estimates: Option<Estimates>,
    /// The servo with its covariance, where a commissioning has found it.
    identified: Option<Commissioned>,
}
