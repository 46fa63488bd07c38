mod fit;
mod found;
mod storage;

pub use found::Found;
pub use storage::{Recorded, Window};

use core::marker::PhantomData;

use fit::{Best, FIRST_DAMPING, Fit};

use super::config::Promise;
use super::{IdentifierConfig, IdentifierError, Uncertainty};
use crate::adaptation::NormalEquations;
use crate::control::{ControlState, Controller};
use crate::error::Allowed;
use crate::measurement::velocity::VelocityEstimate;
use crate::model::{ModelLoop, ModelState, Sensitivity, ServoParameters};
use crate::number::Number;
use crate::parameters::{ModelParameters, ParameterSet};
use crate::stability::certificate;
use crate::units::Units;

/// Standard deviation of a count's rounding, √(1/12).
const ROUNDING_DEVIATION: f64 = 0.288_675_134_594_812_9;

/// The windowed identifier: Levenberg–Marquardt passes of the model loop over the last samples, for
/// the parameter set S, with a free initial position and velocity of the model (Q = P + 2
/// unknowns).
///
/// A window knows the servo after a wiggle of a sixth of a second, from a start a factor of ten
/// away, because it can look at the same samples again. The work is cut into slices: a fit is begun
/// in the background and done a few samples at a time, and never delays a control sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WindowIdentifier<N, V, S, const P: usize, const Q: usize> {
    controller: Controller<N, V>,
    model: ModelLoop<N, V>,
    low: [N; P],
    high: [N; P],
    initial: [N; P],
    prior: [N; P],
    known: [N; P],
    units: Units,
    promise: Option<Promise>,
    set: PhantomData<S>,
}

/// What the identifier remembers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WindowState<N: Number, F, const P: usize, const Q: usize> {
    start: ControlState<N, F>,
    from_rest: bool,
    missed: bool,
    found: Found<N, F, P>,
    fit: Option<Fit<N, F, Q>>,
}

impl<N, V, S, const P: usize, const Q: usize> WindowIdentifier<N, V, S, P, Q>
where
    N: Number,
    V: VelocityEstimate<N>,
    S: ParameterSet<P>,
{
    /// The most passes over the same samples.
    pub const PASSES: u32 = 12;

    /// Samples that the very first fit begins with. It then goes on with twice as many until it has
    /// them all: over a short time even a model that is far off has not gone far astray.
    pub const FIRST_SAMPLES: usize = 64;

    /// The factor by which a pass that helps, or does not, changes the damping.
    const CHANGE: f64 = 10.0;

    /// A pass that lowers the cost by less than this fraction is the last.
    const ENOUGH: f64 = 1e-4;

    /// Standard deviation of the initial position, counts: that of its rounding.
    const POSITION: f64 = ROUNDING_DEVIATION;

    /// Standard deviations of the initial velocity, counts per sample, from rest and in motion,
    /// where the velocity estimate lags behind.
    const VELOCITY: (f64, f64) = (1e-3, 10.0);

    /// Builds the identifier for a velocity estimate, the same that the controller uses; `frozen`
    /// parameters are known and stay at their initial values.
    ///
    /// # Errors
    /// See [`IdentifierError`].
    pub fn new(
        config: &IdentifierConfig,
        uncertainty: &Uncertainty,
        frozen: [bool; P],
        velocity: V,
    ) -> Result<Self, IdentifierError> {
        const {
            assert!(
                Q == P + 2,
                "Q counts the parameters and the two initial states"
            )
        };
        config.check::<S, P>()?;
        let mu = certificate::automatic_mu(&config.gains, &config.assumed_box());
        let bounds = config.bounds_of::<S, P>();
        let mut prior = [0.0; P];
        for i in (0..P).filter(|&i| !frozen[i]) {
            let parameter = S::PARAMETERS[i];
            let deviation = Allowed::Above(0.0)
                .check("uncertainty", uncertainty.of(parameter, config))?
                * parameter.scale(&config.units);
            prior[i] = ROUNDING_DEVIATION / deviation;
        }
        Ok(Self {
            controller: config.controller(velocity),
            model: config.model_loop(velocity),
            low: bounds.map(|bound| N::from_f64(bound.min())),
            high: bounds.map(|bound| N::from_f64(bound.max())),
            initial: config.initial_of::<S, P>().map(N::from_f64),
            prior: prior.map(N::from_f64),
            known: frozen.map(|frozen| if frozen { N::ZERO } else { N::ONE }),
            units: config.units,
            promise: config.certify(mu, &velocity.transfer())?,
            set: PhantomData,
        })
    }

    /// The gain margin of the sampled loop over the box, where a box was given and certified.
    #[must_use]
    pub fn gain_margin(&self) -> Option<f64> {
        self.promise.map(|promise| promise.gain_margin)
    }

    /// The state at the start, with the initial estimates.
    #[must_use]
    pub fn start(&self) -> WindowState<N, V::State, P, Q> {
        WindowState {
            start: ControlState::at_rest(N::ZERO),
            from_rest: false,
            missed: false,
            found: Found {
                model: ModelState::at_rest(),
                sensitivity: Sensitivity::none(),
                estimates: self.initial,
                covariance: [[N::ZERO; P]; P],
                load_command: N::ZERO,
                output_error: N::ZERO,
                unexplained: N::ZERO,
                fits: 0,
            },
            fit: None,
        }
    }

    /// Records a sample: what the controller is about to be given, and its state before that.
    ///
    /// While a fit is under way a full window stands still; it then begins anew with the sample
    /// after the fit.
    #[inline]
    pub fn record<const W: usize>(
        &self,
        state: &mut WindowState<N, V::State, P, Q>,
        window: &mut Window<N, W>,
        before: &ControlState<N, V::State>,
        sample: Recorded<N>,
    ) {
        if state.missed && state.fit.is_none() {
            window.clear();
            state.missed = false;
        }
        if window.is_full() {
            if state.fit.is_some() {
                state.missed = true;
                return;
            }
            if let Some(oldest) = window.get(0).copied() {
                // It was accepted when it was live; the state is the same again.
                let _ =
                    self.controller
                        .process(&mut state.start, oldest.reference, oldest.position);
            }
            window.drop_first();
            state.from_rest = false;
        }
        if window.is_empty() {
            state.start = *before;
            state.from_rest = before.is_fresh();
        }
        window.push(sample);
    }

    /// Follows a move of the origin by `moved`, with the controller.
    pub fn shift_origin<const W: usize>(
        &self,
        state: &mut WindowState<N, V::State, P, Q>,
        window: &mut Window<N, W>,
        moved: N,
    ) {
        state.start.shift_origin(moved);
        if let Some(fit) = &mut state.fit {
            fit.control.shift_origin(moved);
        }
        window.shift_origin(moved);
    }

    /// Begins a fit over what the window holds, from the last estimates.
    pub fn begin<const W: usize>(
        &self,
        state: &mut WindowState<N, V::State, P, Q>,
        window: &Window<N, W>,
    ) {
        let mut trial = [N::ZERO; Q];
        for (slot, estimate) in trial.iter_mut().zip(state.found.estimates) {
            *slot = estimate;
        }
        let mut fit = Fit {
            next: 0,
            samples: if state.found.fits == 0 {
                window.len().min(Self::FIRST_SAMPLES)
            } else {
                window.len()
            },
            pass: 0,
            damping: N::from_f64(FIRST_DAMPING),
            trial,
            best: None,
            control: state.start,
            model: ModelState::at_rest(),
            sensitivity: Sensitivity::none(),
            equations: NormalEquations::empty(),
            lag_one: N::ZERO,
            last_error: N::ZERO,
            load_command: N::ZERO,
            lost: false,
        };
        self.begin_pass(&state.start, state.from_rest, &mut fit);
        state.fit = (window.len() > Q).then_some(fit);
    }

    /// Whether a fit is under way.
    #[must_use]
    pub fn is_fitting(&self, state: &WindowState<N, V::State, P, Q>) -> bool {
        state.fit.is_some()
    }

    /// Does at most `budget` samples of the fit that is under way; true once there is none.
    pub fn work<const W: usize>(
        &self,
        state: &mut WindowState<N, V::State, P, Q>,
        window: &Window<N, W>,
        budget: u32,
    ) -> bool {
        let Some(mut fit) = state.fit else {
            return true;
        };
        for _ in 0..budget {
            if fit.next < fit.samples && !fit.lost {
                if let Some(sample) = window.get(fit.next) {
                    self.pass_sample(&mut fit, sample);
                }
                fit.next += 1;
            } else if self.end_pass(&mut fit) {
                if fit.samples < window.len() {
                    fit.grow(window.len());
                    self.begin_pass(&state.start, state.from_rest, &mut fit);
                    continue;
                }
                self.finish(&mut state.found, &fit);
                state.fit = None;
                return true;
            } else {
                self.begin_pass(&state.start, state.from_rest, &mut fit);
            }
        }
        state.fit = Some(fit);
        false
    }

    fn begin_pass(
        &self,
        start: &ControlState<N, V::State>,
        from_rest: bool,
        fit: &mut Fit<N, V::State, Q>,
    ) {
        let (position, velocity) = initial_state(&fit.trial);
        fit.next = 0;
        fit.lost = false;
        fit.control = *start;
        fit.model = ModelState::alongside(start).displaced(position, velocity);
        fit.sensitivity = Sensitivity::of_initial_state();
        fit.equations = NormalEquations::empty();
        fit.lag_one = N::ZERO;
        fit.last_error = N::ZERO;
        // What is known of the initial state, as two more measurements.
        let deviation = if from_rest {
            Self::VELOCITY.0
        } else {
            Self::VELOCITY.1
        };
        for (place, value, deviation) in [
            (Q - 2, position, Self::POSITION),
            (Q - 1, velocity, deviation),
        ] {
            let weight = N::from_f64(ROUNDING_DEVIATION / deviation);
            let mut row = [N::ZERO; Q];
            row[place] = weight;
            fit.equations.add(&row, -(value * weight));
        }
        self.add_prior(&mut fit.equations, &fit.trial, N::ONE);
    }

    /// What is known of the parameters before: what a motion in one direction cannot tell apart
    /// stays near where it was thought to be. Weighed against errors of `weight` times a count's
    /// rounding.
    fn add_prior(&self, equations: &mut NormalEquations<N, Q>, unknowns: &[N; Q], weight: N) {
        for i in 0..P {
            let mut row = [N::ZERO; Q];
            row[i] = weight * self.prior[i] * self.known[i];
            equations.add(&row, (self.initial[i] - unknowns[i]) * row[i]);
        }
    }

    #[inline]
    fn pass_sample(&self, fit: &mut Fit<N, V::State, Q>, sample: &Recorded<N>) {
        let Ok(mut real) =
            self.controller
                .process(&mut fit.control, sample.reference, sample.position)
        else {
            fit.lost = true;
            return;
        };
        real.injection = sample.injection;
        let Fit {
            model,
            sensitivity,
            equations,
            lag_one,
            last_error,
            ..
        } = fit;
        self.model.observe(model, &real);
        self.model.observe_tangents(sensitivity);
        let mut row = sensitivity.position();
        for (entry, known) in row.iter_mut().zip(self.known) {
            *entry = *entry * known;
        }
        let error = model.output_error();
        equations.add(&row, error);
        *lag_one += error * *last_error;
        *last_error = error;
        let parameters = ModelParameters::of_set::<S, P>(&parameters_of(&fit.trial));
        let command = self.model.command(model, &real);
        self.model.command_tangents(sensitivity, &command);
        let velocity = model.velocity();
        let phase = self.model.advance::<S, P>(model, &command, &parameters);
        self.model
            .advance_tangents::<S, P, Q>(sensitivity, &command, &parameters, velocity, phase);
        if self.model.stand_together(model, &real, &parameters, phase) {
            self.model.stand_still(sensitivity);
        }
        fit.load_command = command.load;
        fit.lost = self.model.restart_if_lost(model);
    }

    /// Judges the pass and sets the next trial; true when the fit has ended.
    fn end_pass(&self, fit: &mut Fit<N, V::State, Q>) -> bool {
        let cost = fit.equations.cost();
        let factor = N::from_f64(Self::CHANGE);
        let valid = !fit.lost && cost.is_finite();
        let (better, little) = match &fit.best {
            None => (valid, false),
            Some(best) => {
                let before = best.equations.cost();
                let gain = before - cost;
                (
                    valid && cost < before,
                    valid && gain.magnitude() <= N::from_f64(Self::ENOUGH) * before,
                )
            }
        };
        if better {
            fit.best = Some(Best {
                model: fit.model,
                sensitivity: fit.sensitivity,
                unknowns: fit.trial,
                equations: fit.equations,
                lag_one: fit.lag_one,
                load_command: fit.load_command,
                output_error: fit.model.output_error(),
            });
            fit.damping = fit.damping * factor.reciprocal();
        } else {
            fit.damping = fit.damping * factor;
        }
        fit.pass += 1;
        let Some(best) = &fit.best else {
            return true;
        };
        if little || fit.pass >= Self::PASSES {
            return true;
        }
        fit.trial = self.next_trial(&best.unknowns, &best.equations, fit.damping);
        false
    }

    /// A trial and a step from it. A parameter that stands at a bound and would leave it is
    /// kept there and the step taken without it: the others must not make up for what it may not do.
    fn next_trial(
        &self,
        unknowns: &[N; Q],
        equations: &NormalEquations<N, Q>,
        damping: N,
    ) -> [N; Q] {
        let mut free = [true; Q];
        let mut step = equations.solve(damping, &free);
        for _ in 0..P {
            let mut held = false;
            for i in 0..P {
                let at = unknowns[i];
                let outward = (at <= self.low[i] && step[i] < N::ZERO)
                    || (at >= self.high[i] && step[i] > N::ZERO);
                if free[i] && outward {
                    free[i] = false;
                    held = true;
                }
            }
            if !held {
                break;
            }
            step = equations.solve(damping, &free);
        }
        core::array::from_fn(|i| {
            let moved = unknowns[i] + step[i];
            if i < P {
                moved.limited(self.low[i], self.high[i])
            } else {
                moved
            }
        })
    }

    fn finish(&self, found: &mut Found<N, V::State, P>, fit: &Fit<N, V::State, Q>) {
        /// The largest correlation from sample to sample that can be told from one.
        const MOST_CORRELATED: f64 = 0.999;
        let Some(best) = &fit.best else {
            return;
        };
        let freedom = fit.samples.saturating_sub(Q).max(1) as f64;
        let variance =
            (best.equations.cost().to_f64() / freedom).max(ROUNDING_DEVIATION * ROUNDING_DEVIATION);
        // Errors that go on from sample to sample as ρᵏ tell less than white ones.
        let cost = best.equations.cost().to_f64();
        let correlation = if cost > 0.0 {
            (best.lag_one.to_f64() / cost).clamp(0.0, MOST_CORRELATED)
        } else {
            0.0
        };
        let coloured = variance * (1.0 + correlation) / (1.0 - correlation);
        // The passes held what was thought before against errors of a count's rounding. It weighs
        // more against what the errors turned out to be.
        let mut equations = best.equations;
        let more =
            libm::sqrt((coloured / (ROUNDING_DEVIATION * ROUNDING_DEVIATION) - 1.0).max(0.0));
        self.add_prior(&mut equations, &best.unknowns, N::from_f64(more));
        let unknowns = self.next_trial(&best.unknowns, &equations, N::ZERO);
        let covariance = equations.covariance();
        let change: [N; Q] = core::array::from_fn(|i| unknowns[i] - best.unknowns[i]);
        let mut model = best.model;
        self.model.follow(&mut model, &best.sensitivity, &change);
        *found = Found {
            model,
            sensitivity: best.sensitivity.of_first(),
            estimates: parameters_of(&unknowns),
            covariance: core::array::from_fn(|i| {
                core::array::from_fn(|j| {
                    N::from_f64(coloured * covariance[i][j].to_f64())
                        * self.known[i]
                        * self.known[j]
                })
            }),
            load_command: best.load_command,
            output_error: best.output_error,
            unexplained: N::from_f64(libm::sqrt(variance)),
            fits: found.fits.saturating_add(1),
        };
    }

    /// Fits that have ended with a result.
    #[must_use]
    pub fn fits(&self, state: &WindowState<N, V::State, P, Q>) -> u32 {
        state.found.fits
    }

    /// The output error of the last sample of the last fit, machine units.
    #[must_use]
    pub fn output_error(&self, state: &WindowState<N, V::State, P, Q>) -> N {
        state.found.output_error
    }

    /// The standard deviation of what the last fit could not explain, rad; at least a count's
    /// rounding.
    #[must_use]
    pub fn unexplained(&self, state: &WindowState<N, V::State, P, Q>) -> f64 {
        state.found.unexplained.to_f64() / self.units.position()
    }

    /// The last fit as it is, machine units: what a recursive identifier takes over.
    #[must_use]
    pub fn found<'a>(
        &self,
        state: &'a WindowState<N, V::State, P, Q>,
    ) -> &'a Found<N, V::State, P> {
        &state.found
    }

    /// The estimates of the last fit in SI.
    #[must_use]
    pub fn estimates(&self, state: &WindowState<N, V::State, P, Q>) -> ServoParameters {
        ModelParameters::of_set::<S, P>(&state.found.estimates)
            .to_si(&self.units)
            .with_load_of(state.found.load_command.to_f64())
    }

    /// The standard errors of the last fit in SI, from its normal equations; zero for what the
    /// model has not got.
    #[must_use]
    pub fn standard_errors(&self, state: &WindowState<N, V::State, P, Q>) -> ServoParameters {
        ModelParameters::of_set::<S, P>(&state.found.deviations()).to_si(&self.units)
    }
}

fn parameters_of<N: Number, const P: usize, const Q: usize>(unknowns: &[N; Q]) -> [N; P] {
    core::array::from_fn(|i| unknowns[i])
}

/// The initial position and velocity among the unknowns.
fn initial_state<N: Number, const Q: usize>(unknowns: &[N; Q]) -> (N, N) {
    (unknowns[Q - 2], unknowns[Q - 1])
}
