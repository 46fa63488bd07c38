//! Instructions of a whole sample of Gauss–Newton with one optional term that has entered.

use firmware_stm32::instructions::{Counter as Instructions, Tally};
use firmware_stm32::measured::{COULOMB, COUNTED, Experiment, GaussNewton, Halves};
use firmware_stm32::paper;
use identifier_core::Settings;
use identifier_core::identifier::{AngledInputs, DelayedInputs, IdentifiableSet, Identify};
use identifier_core::number::Number;
use identifier_core::parameters::{Term, Terms, Unknown, UnknownSet, Unknowns};
use identifier_core::settings::{IdentifierSettings, SettingsError};

/// Samples after which a demanded term has entered, and the estimator has settled.
const UNTIL_IT_ENTERED: u32 = 5000;

pub(crate) fn run() -> Result<(), &'static str> {
    terms(&Instructions::start()).map_err(|_| "a term did not enter")
}

/// Every term separately.
fn terms(instructions: &Instructions) -> Result<(), SettingsError> {
    with_term::<Unknowns<5>, 5>(instructions, Term::Delay, "gauss-newton-with-delay")?;
    with_term::<WithAsymmetry, 5>(instructions, Term::Asymmetry, "gauss-newton-with-asymmetry")?;
    with_term::<WithLowSpeed, 5>(instructions, Term::LowSpeed, "gauss-newton-with-low-speed")?;
    with_term::<WithDeadBand, 5>(instructions, Term::DeadBand, "gauss-newton-with-dead-band")?;
    with_term::<WithGravity, 6>(instructions, Term::Gravity, "gauss-newton-with-gravity")?;
    with_term::<WithRipple, 6>(instructions, Term::Ripple, "gauss-newton-with-ripple")
}

/// A set of unknowns: those of Gauss–Newton's four parameters and one term.
macro_rules! with_term {
    ($($set:ident, $count:literal, $lower:literal, $inputs:ident: [$($term:ident),*];)*) => {$(
        #[derive(Debug, Clone, Copy)]
        struct $set;

        impl UnknownSet<$count> for $set {
            const UNKNOWNS: [Unknown; $count] = [
                Unknown::A, Unknown::B, Unknown::Coulomb, $(Unknown::$term,)* Unknown::Load,
            ];
        }

        impl IdentifiableSet<$count> for $set {
            type Lower<N: Number> = [N; $lower];
            type Inputs<N: Number> = $inputs<N, 8>;
        }
    )*};
}

with_term! {
    WithAsymmetry, 5, 10, DelayedInputs: [Asymmetry];
    WithLowSpeed, 5, 10, DelayedInputs: [LowSpeed];
    WithDeadBand, 5, 10, DelayedInputs: [DeadBand];
    WithGravity, 6, 15, AngledInputs: [GravitySine, GravityCosine];
    WithRipple, 6, 15, AngledInputs: [RippleSine, RippleCosine];
}

/// A running recursion with a term that has entered, on the same servo; `name` is that of its figures.
fn with_term<S: IdentifiableSet<P>, const P: usize>(
    instructions: &Instructions,
    term: Term,
    name: &str,
) -> Result<(), SettingsError> {
    let mut settings = Settings {
        identifier: IdentifierSettings::UNSTATED,
        ..paper::settings()
    };
    let terms = &mut settings.identifier.terms;
    terms.demanded = Terms::NONE.with(term);
    terms.low_speed_velocity = Some(1.0);
    terms.ripple_order = Some(24.0);
    let mut halves = Halves::<S, P>::build(&settings)?;
    let mut experiment = Experiment::start(COULOMB)?;
    let mut fitting = Tally::default();
    let mut sample =
        |reference, register| halves.counted(instructions, (reference, register), &mut fitting);
    experiment.count(UNTIL_IT_ENTERED, &mut sample);
    let tally = experiment.count(COUNTED, &mut sample);
    let interrupt = &halves.interrupt;
    let identifier = interrupt.servo_loop.identifier();
    if !identifier
        .report(interrupt.state.identification())
        .entered
        .has(term)
    {
        return Err(SettingsError::NotGiven { setting: "motion" });
    }
    let bytes = size_of::<<GaussNewton<S, P> as Identify<f32>>::State>();
    tally.print(name, bytes);
    Ok(())
}
