//! From a scenario to what the chip builds its loop from.

use drive_link::{Format, Law as LinkLaw, LoopSettings};

use super::PilError;
use crate::experiment::{self, Outcome};
use crate::scenario::{Arithmetic, Law, ModelSet, Scenario, Velocity};

/// Why an ideal sensor will not do.
pub(super) const NO_COUNTS: &str = "encoder.counts_per_rev: a chip counts, so it must not be 0";

/// The settings, and what the same identifier is known to be on the host.
pub(super) fn of(scenario: &Scenario) -> Result<(LoopSettings, Outcome), PilError> {
    let refused = |what: &str| Err(PilError::Scenario(what.to_owned()));
    let identifier = &scenario.identifier;
    let gradient = match &identifier.law {
        Law::Gradient => true,
        Law::GaussNewton => false,
        _ => {
            return refused("identifier.law: the firmware has \"gradient\" and \"gauss-newton\"");
        }
    };
    let format = match identifier.arithmetic {
        Arithmetic::F32 => Format::Single,
        Arithmetic::Fixed => Format::Fixed,
        Arithmetic::F64 => {
            return refused("identifier.arithmetic: the firmware has \"f32\" and \"fixed\"");
        }
    };
    let law = match scenario.model_set() {
        ModelSet::Ab if gradient => LinkLaw::Gradient { friction: false },
        ModelSet::AbCoulomb if gradient && format == Format::Single => {
            LinkLaw::Gradient { friction: true }
        }
        ModelSet::AbCoulombLoad if !gradient && format == Format::Single => LinkLaw::GaussNewton,
        _ => {
            return refused(
                "identifier.parameters: the firmware has [\"a\", \"b\"], in f32 \
                 [\"a\", \"b\", \"coulomb\"] too, and for gauss-newton \
                 [\"a\", \"b\", \"coulomb\", \"load\"]",
            );
        }
    };
    if scenario.velocity != Velocity::LowPass {
        return refused("controller.velocity_filter.kind: the firmware has \"low-pass\"");
    }
    if scenario.counts_per_rev.is_none() {
        return refused(NO_COUNTS);
    }
    let core_refuses = |error| PilError::Scenario(scenario.fault(&error).to_string());
    let core = scenario.settings().map_err(core_refuses)?;
    let (_, outcome) = experiment::learner::<f64>(scenario, &core).map_err(core_refuses)?;
    let rows = core.identifier.gamma.iter().flatten().enumerate();
    for (i, row) in rows {
        if row
            .iter()
            .enumerate()
            .any(|(j, &entry)| i != j && entry != 0.0)
        {
            return refused("identifier.gamma: the firmware has a diagonal one");
        }
    }
    let settings = LoopSettings { core, law, format };
    Ok((settings, outcome))
}
