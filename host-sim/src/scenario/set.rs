//! The parameters of the model, chosen at run time.

use identifier_core::model::ServoParameters;
use identifier_core::parameters::{Ab, AbCoulomb, AbCoulombLoad, AbLoad, Parameter, ParameterSet};

use super::{IdentifierSettings, Law, Scenario};

/// The core's parameter sets.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[expect(missing_docs, reason = "each variant is the core's type of that name")]
pub enum ModelSet {
    Ab,
    AbCoulomb,
    AbLoad,
    AbCoulombLoad,
}

/// A computation that works with any parameter set; the scenario says with which.
pub trait WithSet {
    /// Its result.
    type Output;

    /// Does it, for the P parameters of S; Q counts the two initial states besides.
    fn with<S: ParameterSet<P> + 'static, const P: usize, const Q: usize>(self) -> Self::Output;
}

impl ModelSet {
    /// Does a computation with this set.
    pub fn with<W: WithSet>(self, work: W) -> W::Output {
        match self {
            Self::Ab => work.with::<Ab, 2, 4>(),
            Self::AbCoulomb => work.with::<AbCoulomb, 3, 5>(),
            Self::AbLoad => work.with::<AbLoad, 3, 5>(),
            Self::AbCoulombLoad => work.with::<AbCoulombLoad, 4, 6>(),
        }
    }
}

impl IdentifierSettings {
    /// Whether a parameter is estimated.
    #[must_use]
    pub fn estimates(&self, parameter: Parameter) -> bool {
        self.parameters.contains(&parameter)
    }

    /// Whether a parameter of the model stays at its initial value. The Gauss–Newton laws always find
    /// the load: what the integral takes over only slowly would bias their first seconds.
    #[must_use]
    pub fn is_frozen(&self, parameter: Parameter) -> bool {
        let finds_load = matches!(self.law, Law::GaussNewton(..) | Law::Window(_))
            && parameter == Parameter::Load;
        !self.estimates(parameter) && !finds_load
    }

    /// The smallest set that holds every parameter that is estimated or known to be there.
    #[must_use]
    pub fn model_set(&self) -> ModelSet {
        let ServoParameters { coulomb, load, .. } = self.initial;
        let has_coulomb = !self.is_frozen(Parameter::Coulomb) || coulomb > 0.0;
        let has_load = !self.is_frozen(Parameter::Load) || load != 0.0;
        match (has_coulomb, has_load) {
            (false, false) => ModelSet::Ab,
            (true, false) => ModelSet::AbCoulomb,
            (false, true) => ModelSet::AbLoad,
            (true, true) => ModelSet::AbCoulombLoad,
        }
    }
}

impl Scenario {
    /// The parameters that a run of this scenario finds: those that the user chose, and the load
    /// where the law or the integral finds it besides.
    #[must_use]
    pub fn estimated(&self) -> Vec<Parameter> {
        let identifier = &self.identifier;
        let mut found = identifier.parameters.clone();
        if matches!(identifier.law, Law::Baseline(..)) {
            return found;
        }
        let by_integral = self.controller.gains.ki() > 0.0;
        let finds_load = by_integral || !identifier.is_frozen(Parameter::Load);
        if finds_load && !found.contains(&Parameter::Load) {
            found.push(Parameter::Load);
        }
        found
    }
}
