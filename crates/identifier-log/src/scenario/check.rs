//! Checks that the settings of a log go together.

use identifier_core::error::Allowed;
use identifier_core::parameters::Term;
use identifier_core::settings::SettingsError;

use super::read::read;
use super::{Arithmetic, Estimator, Fault, LoopKind, Options, ScenarioError, inner, log, physical};

/// The position unit of an ideal sensor, rad: as of an encoder that is finer than any effect.
const IDEAL_UNIT: f64 = 1e-5;

impl Options {
    /// Reads the tables of a log from a text. Errors show `name` as the file.
    ///
    /// # Errors
    /// File, line, key and what is allowed there.
    pub fn parse(name: &str, text: &str) -> Result<Self, ScenarioError> {
        read(Self::blank(), name, text, Self::checked)
    }

    /// Completes what was read with what follows from it. `is_log`: it is that of a log.
    ///
    /// # Errors
    /// The key that is not allowed.
    pub fn complete(&mut self, is_log: bool) -> Result<(), Fault> {
        if let Some(counts) = self.counts_per_rev {
            (Allowed::AtLeast(0.0).check("counts_per_rev", counts))
                .map_err(|error| Fault::new("encoder.counts_per_rev", error))?;
        }
        let unit = |counts| std::f64::consts::TAU / counts;
        self.stated.resolution = self.counts_per_rev.map_or(IDEAL_UNIT, unit);
        self.checked_units()?;
        physical::check(self, is_log)?;
        if self.identifier.arithmetic == Arithmetic::Fixed && !self.identifier.law.is_gradient() {
            return Err(Fault::new(
                "identifier.arithmetic",
                "only \"gradient\", \"paper\" and \"pd-gradient\" exist in fixed point",
            ));
        }
        Ok(())
    }

    /// The options of a log, completed and checked.
    ///
    /// # Errors
    /// The key that is missing or not allowed.
    pub(crate) fn checked(mut self) -> Result<Self, Fault> {
        self.complete(true)?;
        self.check_log(false)?;
        Ok(self)
    }

    /// Checks that the terms which a fit is required to have come with their settings.
    ///
    /// # Errors
    /// The key of the setting that is missing.
    pub fn check_terms_of_fit(&self) -> Result<(), Fault> {
        let terms = &self.stated.identifier.terms;
        let declared = [
            (
                Term::LowSpeed,
                terms.low_speed_velocity,
                "low_speed_velocity",
            ),
            (Term::Ripple, terms.ripple_order, "ripple_order"),
        ];
        for (term, value, setting) in declared {
            if terms.demanded.has(term) && value.is_none() {
                return Err(self.fault(&SettingsError::NotGiven { setting }));
            }
        }
        Ok(())
    }

    /// Checks the needs of a log, apart from the log itself. `own`: it is that of a simulated run of this loop.
    ///
    /// # Errors
    /// The key that is missing or not allowed.
    pub fn check_log(&self, own: bool) -> Result<(), Fault> {
        log::check(self)?;
        inner::check(self)?;
        let (given, identifier) = (&self.stated, &self.stated.identifier);
        let law = self.identifier.law;
        let log = self.log_columns();
        let own_loop = format!(
            "\"{}\" runs only in its own loop and cannot take a log: {} can",
            law.name(),
            replayable_names()
        );
        let follows = given.controller.is_some()
            || identifier.correction.is_some()
            || identifier.parameter_range.is_some();
        let refusals = [
            (
                log.command.is_none() && log.reference.is_none(),
                "log.command",
                "the log must have the command, or the reference from which the declared controller computes it",
            ),
            (
                identifier.terms.demanded.has(Term::Gravity) && !log.absolute && !own,
                "log.angle",
                "gravity depends on the absolute angle, which this counter does not give: if position zero is the same \
             angle in every recording, state angle = \"absolute\", else remove the term \"gravity\"",
            ),
            (
                !(law.is_replayable() || own && law.closing() == LoopKind::Pd),
                "identifier.law",
                own_loop.as_str(),
            ),
            (
                self.identifier.arithmetic == Arithmetic::Fixed && self.counts_per_rev.is_none(),
                "identifier.arithmetic",
                "\"fixed\" needs encoder.counts_per_rev, the resolution of the log's position; \"f32\" and \"f64\" do not",
            ),
            (
                given.controller.is_none() && log.command.is_none() && log.inner.is_none(),
                "controller",
                "without log.command declare the controller that ran, so that its command can be computed: [controller], \
             or [inner] for a servo that takes position goals",
            ),
            (
                law.is_gradient() && !follows,
                "identifier.correction",
                "without a [controller] this estimator needs the gains of its correction, or a servo_range to derive them \
             from",
            ),
            (
                law.is_gradient() && log.reference.is_none() && identifier.gamma.is_none(),
                "identifier.gamma",
                "without log.reference no gamma can be chosen: state it",
            ),
        ];
        let refusal = refusals.into_iter().find(|(is_refused, ..)| *is_refused);
        refusal.map_or(Ok(()), |(_, key, fault)| Err(Fault::new(key, fault)))
    }
}

fn replayable_names() -> String {
    let replayable = Estimator::ALL.iter().filter(|law| law.is_replayable());
    let names: Vec<_> = replayable
        .map(|law| format!("\"{}\"", law.name()))
        .collect();
    names.join(", ")
}
