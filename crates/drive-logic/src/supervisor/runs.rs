//! Runs, from where the servo is let go and from where a commissioning holds it.

use drive_link::{Estimates, LoopSettings, NotAllowed, Refusal, Settings};
use embedded_storage::nor_flash::NorFlash;
use identifier_core::commission::Phase;

use super::Supervisor;
use super::record::Commissioned;
use crate::first_fit::FirstFit;
use crate::messages::Order;
use crate::parts;
use crate::run::Run;
use crate::spare::Spare;

impl<F: NorFlash> Supervisor<'_, F> {
    /// Orders a run from where the servo stands, unless it is overtaken by a stop.
    pub(super) fn start(&mut self, overtaken: impl FnOnce(&Self) -> bool) -> Result<(), Refusal> {
        self.must_be_ready()?;
        let prepared = self.prepared(&self.settings, &self.known());
        let prepared = prepared.map_err(Refusal::Setting)?;
        if overtaken(self) {
            return Err(Refusal::Overtaken);
        }
        self.order_run(prepared, Order::Run)
    }

    /// Orders a run where a commissioning that is over holds the servo, unless it was ordered already: with
    /// the gains that it proved, or with those before.
    #[cold]
    #[inline(never)]
    pub(super) fn go_on(&mut self) {
        if self.spare.is_none() || self.is_stopping() {
            return;
        }
        let prepared = self
            .proved()
            .and_then(|(settings, known)| self.prepared(&settings, &known).ok())
            .or_else(|| self.prepared(&self.settings, &self.known()).ok());
        match prepared {
            // If there is no room for the order, the next turn tries again.
            Some(prepared) => drop(self.order_run(prepared, Order::GoOn)),
            None => self.channel.stop(),
        }
    }

    /// The settings with the gains that a commissioning has proved, and what it knows of the servo.
    fn proved(&self) -> Option<(Settings, Known)> {
        if self.phase != Phase::Applied {
            return None;
        }
        let (servo, tuning) = (self.studying.servo()?, self.studying.tuning()?);
        let found = Commissioned::new(servo, *tuning, None);
        let settings = self.with_gains_of(&found).ok()?;
        let known = Known {
            estimates: Some(parts::identified(servo)),
            identified: Some(found),
        };
        Some((settings, known))
    }

    /// What is known of the servo: from a commissioning, unless a run has learnt since.
    fn known(&self) -> Known {
        let estimates = self.estimates;
        let is_latest = |found: &Commissioned| estimates == Some(parts::identified(&found.servo()));
        Known {
            estimates,
            identified: self.commissioned.filter(is_latest),
        }
    }

    /// A run that begins with what is known of the servo; with what was configured, where that would not
    /// do.
    fn prepared(&self, settings: &Settings, known: &Known) -> Result<Prepared, NotAllowed> {
        let of = |settings: &Settings| {
            Run::new(settings, &self.stage).map(|run| Prepared {
                run,
                begun_from: settings.closed_loop,
            })
        };
        if let Some(estimates) = &known.estimates {
            let mut settings = *settings;
            parts::begin_with(estimates, &mut settings.closed_loop.core.identifier);
            if let Ok(mut prepared) = of(&settings) {
                if let Some(found) = &known.identified {
                    prepared.run.know(&found.servo(), &found.motion());
                }
                return Ok(prepared);
            }
        }
        of(settings)
    }

    fn order_run(
        &mut self,
        prepared: Prepared,
        order: fn(&'static mut Run) -> Order,
    ) -> Result<(), Refusal> {
        let Prepared { run, begun_from } = prepared;
        let Some(spare) = self.spare.take() else {
            return Err(Refusal::Busy);
        };
        let run = spare.filled(run);
        let closed_loop = *run.closed_loop();
        // Nothing records now: what is still there is of a run before.
        while self.channel.block().is_some() {}
        match self.channel.order(order(run)) {
            Ok(()) => {
                self.closed_loop = Some(closed_loop);
                self.first_fit = FirstFit::of(&begun_from);
                Ok(())
            }
            Err(Order::Run(run) | Order::GoOn(run)) => {
                self.spare = Some(Spare::Used(run));
                Err(Refusal::Busy)
            }
            Err(_) => Err(Refusal::Busy),
        }
    }
}

/// A run, and what its loop was built from.
struct Prepared {
    run: Run,
    begun_from: LoopSettings,
}

/// What is known of the servo before a run.
struct Known {
    estimates: Option<Estimates>,
    /// The servo with its covariance, where a commissioning has found it.
    identified: Option<Commissioned>,
}
