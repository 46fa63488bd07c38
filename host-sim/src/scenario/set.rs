//! The parameters of the model, chosen at run time.

use identifier_core::parameters::Parameter;

use super::{Identification, Law, Scenario};

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
    /// Whether the user asks for a parameter.
    #[must_use]
    pub fn estimates(&self, parameter: Parameter) -> bool {
        self.parameters.contains(&parameter)
    }

    /// Whether a parameter of the model stays at its initial value. The Gauss–Newton laws always find
    /// the load: nothing else in them would account for it.
    #[must_use]
    pub fn is_known(&self, parameter: Parameter) -> bool {
        let finds_load =
            matches!(self.law, Law::GaussNewton | Law::Window) && parameter == Parameter::Load;
        !self.estimates(parameter) && !finds_load
    }
}

impl Scenario {
    /// Whether the model may have more than the four parameters.
    #[must_use]
    pub fn has_terms(&self) -> bool {
        let terms = &self.stated.identifier.terms;
        !terms.demanded.or(terms.allowed).is_empty()
    }

    /// The smallest set that holds every parameter that is estimated or known to be there.
    #[must_use]
    pub fn model_set(&self) -> ModelSet {
        let has = |parameter| {
            let known = self.stated.identifier.initial.of(parameter);
            !self.identifier.is_known(parameter) || known.is_some_and(|value| value != 0.0)
        };
        match (has(Parameter::Coulomb), has(Parameter::Load)) {
            (false, false) => ModelSet::Ab,
            (true, false) => ModelSet::AbCoulomb,
            (false, true) => ModelSet::AbLoad,
            (true, true) => ModelSet::AbCoulombLoad,
        }
    }

    /// The parameters that a run of this scenario finds: those that the user chose, and the load
    /// where the law or the integral of its correction finds it besides.
    #[must_use]
    pub fn estimated(&self) -> Vec<Parameter> {
        let mut found = self.identifier.parameters.clone();
        if matches!(self.identifier.law, Law::Baseline(..)) {
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
