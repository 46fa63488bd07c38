use crate::error::StepError;
use crate::number::Arithmetic;
use crate::parameters::{Parameter, PerParameter, ServoParameters, Terms, Unknown};
use crate::reason::Reason;

/// An identifier: it only listens. It gets two numbers per sample. One is the increment of the encoder since the last
/// sample, the other the command that acts until the next.
///
/// N is the number that it computes in: [`Number`](crate::number::Number), or a fixed-point word.
pub trait Identify<N: Copy> {
    /// The state between samples.
    type State: Clone + core::fmt::Debug;

    /// The estimates as it computes with them: a few words, which an interrupt copies and the
    /// background converts to SI.
    type Snapshot: Copy + core::fmt::Debug;

    /// The state at the start: the model at rest at the servo's position.
    fn start(&self) -> Self::State;

    /// Counts as the number that it computes in.
    fn increment(&self, moved: i32) -> N;

    /// Takes one sample. The counts `moved` are those since the last sample, through any wrap of the counter. The
    /// *total* `command` acts from this sample to the next, command units. It is limited, and includes feed-forward,
    /// dither and any other addition.
    ///
    /// # Errors
    /// [`StepError`] for an impossible input; the state is then untouched.
    #[inline]
    fn process(
        &self,
        state: &mut Self::State,
        moved: i32,
        command: N,
    ) -> Result<Update<N>, StepError> {
        self.learn(state, self.increment(moved), command)
    }

    /// The same for a sensor that does not count: the increment in position units.
    ///
    /// # Errors
    /// As [`Identify::process`].
    #[inline]
    fn learn(
        &self,
        state: &mut Self::State,
        increment: N,
        command: N,
    ) -> Result<Update<N>, StepError> {
        self.check(increment, command)?;
        Ok(self.update(state, increment, command))
    }

    /// Checks that increment and command are finite and in range.
    ///
    /// # Errors
    /// [`StepError::CountJumped`], [`StepError::CommandNotFinite`].
    fn check(&self, increment: N, command: N) -> Result<(), StepError>;

    /// [`Identify::learn`] for inputs that were checked ([`Identify::check`]); the commands of our
    /// controller always pass. Other inputs can spoil the estimates, but nothing else.
    fn update(&self, state: &mut Self::State, increment: N, command: N) -> Update<N>;

    /// The present estimates in the form in which the identifier computes.
    fn snapshot(&self, state: &Self::State) -> Self::Snapshot;

    /// Estimates that were shown, SI.
    fn estimates_in(&self, shown: &Self::Snapshot) -> ServoParameters;

    /// Which of the estimates that were shown are at a bound: such a value is no result.
    fn at_bounds_in(&self, shown: &Self::Snapshot) -> PerParameter<bool>;

    /// The estimate of an unknown that was shown, SI; none if the model does not have it. For a term
    /// that has not [entered](Report::entered) it is its initial value.
    fn value_in(&self, shown: &Self::Snapshot, unknown: Unknown) -> Option<f64> {
        let parameter = unknown.parameter()?;
        Some(self.estimates_in(shown).get(parameter))
    }

    /// The knowledge besides the estimates, SI: for a PC or the background of a chip.
    fn report(&self, _: &Self::State) -> Report {
        Report::default()
    }

    /// The estimates, SI; none before there are any.
    fn estimates(&self, state: &Self::State) -> Option<ServoParameters> {
        self.report(state)
            .has_estimates
            .then(|| self.estimates_in(&self.snapshot(state)))
    }

    /// Says at which position (position units) the servo is before the first sample, for models that
    /// depend on the angle.
    fn place(&self, _: &mut Self::State, _: N) {}

    /// Work in the background, at most `budget` steps of it: fits. Call it whenever there is time, on
    /// a PC after every sample; without work to do it returns at once.
    fn work(&self, _: &mut Self::State, _: u32) {}

    /// Joins a motion after a gap, before its next sample. The estimates are kept. The model restarts at the servo's
    /// position, moving by `increment` a sample.
    fn resume_moving(&self, state: &mut Self::State, increment: N);
}

/// The estimates as an identifier computes with them. A firmware that shows no others needs no double precision, which
/// a chip computes by software.
///
/// The SI value of an estimate is the machine value times [`MachineEstimates::machine_unit`]. This constant of the
/// configuration may be computed elsewhere.
pub trait MachineEstimates<N: Copy>: Identify<N> {
    /// a, b, Coulomb friction and load in machine units (see [`Units`](crate::units::Units)). In fixed point they are
    /// fractions of their full scales. A parameter that the model does not have is zero.
    fn machine_estimates(&self, state: &Self::State) -> PerParameter<N>;

    /// The SI value of a machine value of one.
    fn machine_unit(&self, parameter: Parameter) -> f64;
}

/// The knowledge of an identifier besides its estimates, SI.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Report {
    /// True once there are estimates. An identifier that starts from initial values has them at once, one that starts
    /// by a fit after that fit.
    pub has_estimates: bool,
    /// The standard error of each unknown, in the order of [`Unknown::ALL`], for estimators that have them.
    pub standard_errors: [Option<f64>; Unknown::COUNT],
    /// The optional terms that are estimated by now.
    pub entered: Terms,
    /// Bandwidth of the model's correction, rad/s, where the identifier chooses it and may change it.
    pub bandwidth: Option<f64>,
    /// Why no first fit has succeeded after a second of motion, or after its record if that is longer. None before that
    /// time, and after a fit has succeeded.
    pub rejection_reason: Option<Reason>,
    /// Standard deviation of the position's noise in motion, position units, by the last accepted first fit. If it is
    /// not clearly more than in the settings, it is that of the settings, rounding alone.
    pub noise: Option<f64>,
    /// The delay from a command to its acceleration besides the hold's, s, where the identifier finds it beside its
    /// unknowns. Its error is among the standard errors.
    pub delay: Option<f64>,
}

impl Default for Report {
    /// That of an identifier that starts from initial values and has no standard errors.
    fn default() -> Self {
        Self {
            has_estimates: true,
            standard_errors: [None; Unknown::COUNT],
            entered: Terms::NONE,
            bandwidth: None,
            rejection_reason: None,
            noise: None,
            delay: None,
        }
    }
}

impl Report {
    /// The standard error of an unknown.
    #[must_use]
    pub fn standard_error_of(&self, unknown: Unknown) -> Option<f64> {
        self.standard_errors[unknown as usize]
    }

    /// The standard errors of the parameters, for estimators that have them. Zero for a parameter that the model lacks.
    #[must_use]
    pub fn errors_of_parameters(&self) -> Option<ServoParameters> {
        Some(ServoParameters::new(
            self.standard_error_of(Unknown::A)?,
            self.standard_error_of(Unknown::B)?,
            self.standard_error_of(Unknown::Coulomb).unwrap_or(0.0),
            self.standard_error_of(Unknown::Load).unwrap_or(0.0),
        ))
    }
}

/// The observation of the identifier in a sample.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Update<N> {
    /// Output error ε = q − q_e before the update, position units.
    pub output_error: N,
    /// The event besides learning.
    pub event: Event,
}

/// The events of a sample besides learning.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum Event {
    /// Nothing else.
    None,
    /// A guard shortened the estimator's step.
    Slowed,
    /// Nothing was learnt: the servo is at standstill.
    Standing,
    /// The model left the range of the number format and was restarted at the servo's position. The estimates are kept.
    Restarted,
    /// A first fit succeeded, and the recursion starts from it.
    Started,
    /// The load has changed by a step: it is estimated anew, and the other estimates are kept
    /// meanwhile.
    LoadStep,
    /// A term that is demanded has entered.
    TermEntered,
    /// The servo moves where the model's friction would hold it: the friction was lowered.
    FrictionLowered,
    /// The servo does not follow its command: amplifier off, or a limit that was not taken into the
    /// recorded command. Nothing is learnt.
    NotFollowing,
    /// No first fit has succeeded after a second of motion: [`Report::rejection_reason`] has the reason.
    FirstFitOverdue,
}

/// Refuses an impossible sample.
#[inline]
pub(crate) fn check<N: Arithmetic>(increment: N, command: N, longest: N) -> Result<(), StepError> {
    // NaN fails both comparisons.
    let moved_within = increment.magnitude() <= longest;
    if !moved_within {
        return Err(StepError::CountJumped);
    }
    // Beyond this the number format overflows.
    let possible = command.magnitude() <= N::REACH;
    if possible {
        Ok(())
    } else {
        Err(StepError::CommandNotFinite)
    }
}
