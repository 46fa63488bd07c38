//! The parameters of the model, chosen at run time.

use identifier_core::parameters::Parameter;

use super::{Identification, Options};

/// The core's parameter sets.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[expect(missing_docs, reason = "each variant is the core's type of that name")]
pub enum ModelSet {
    Ab,
    AbCoulomb,
    AbLoad,
    AbCoulombLoad,
}

impl Identification {
    /// True for a parameter that the user asks for.
    #[must_use]
    pub fn estimates(&self, parameter: Parameter) -> bool {
        self.parameters.contains(&parameter)
    }

    /// True for a parameter of the model that stays at its initial value. The Gauss–Newton estimators always find the
    /// load: nothing else in them would account for it.
    #[must_use]
    pub fn is_known(&self, parameter: Parameter) -> bool {
        let finds_load = self.law.fits() && parameter == Parameter::Load;
        !self.estimates(parameter) && !finds_load
    }
}

impl Options {
    /// True if the model may have optional terms.
    #[must_use]
    pub fn has_terms(&self) -> bool {
        !self.stated.identifier.terms.demanded.is_empty()
    }

    /// The smallest set that holds every parameter that is estimated or known to be there.
    #[must_use]
    pub fn model_set(&self) -> ModelSet {
        let has = |parameter| {
            let known = self.stated.identifier.initial.get(parameter);
            !self.identifier.is_known(parameter) || known.is_some_and(|value| value != 0.0)
        };
        match (has(Parameter::Coulomb), has(Parameter::Load)) {
            (false, false) => ModelSet::Ab,
            (true, false) => ModelSet::AbCoulomb,
            (false, true) => ModelSet::AbLoad,
            (true, true) => ModelSet::AbCoulombLoad,
        }
    }

    /// The parameters that a run of this scenario estimates. They are those of the user's choice, and the load if the
    /// estimator or the integral of its correction finds it besides.
    #[must_use]
    pub fn estimated(&self) -> Vec<Parameter> {
        let mut found = self.identifier.parameters.clone();
        if self.identifier.law.is_rival() {
            return found;
        }
        let by_integral = || {
            let gains = self.stated.correction_gains();
            gains.is_ok_and(|gains| gains.ki() > 0.0)
        };
        let finds_load = !self.identifier.is_known(Parameter::Load)
            || self.identifier.law.is_gradient() && by_integral();
        if finds_load && !found.contains(&Parameter::Load) {
            found.push(Parameter::Load);
        }
        found
    }
}
