mod load_step;
mod start;

pub use start::Start;

use core::marker::PhantomData;

use load_step::{LoadStepTest, Suspicion};

use super::IdentifierError;
use super::fit::{Blocking, Fitter, Found};
use super::identify::{Event, Identify, Seen, check};
use super::settings::{Listening, MOST_PER_SAMPLE, place};
use crate::adaptation::{GaussNewton, GaussNewtonConfig, GaussNewtonState, GaussNewtonStep};
use crate::error::StepError;
use crate::model::{
    FrictionStep, Innovation, ListeningModel, Phase, Response, ServoParameters, Tangents,
};
use crate::number::Number;
use crate::parameters::{ModelParameters, Parameter, ParameterSet};
use crate::settings::{FromSettings, PerParameter, Settings};
use crate::units::Units;

/// The fast identifier: recursive Gauss–Newton on a model driven by the command that acted, for the
/// parameter set S. Its first fit uses a record of W blocks.
///
/// It begins by recording. Once the record tells enough, a fit in the background
/// ([`Identify::work`]) finds the servo without a first guess, and the recursion goes
/// on from there.
///
/// When an estimate moves, the model's state moves with it to where it would have been, to first
/// order, had the estimate always been the new one. The output error then is what the *present*
/// estimates leave unexplained, and nothing has to wait for the model to forget the old ones.
///
/// A step of the load is noticed by the mean of the output error. The recursion then pauses, and
/// the model itself, with an integral and a correction that is fast at first, finds the load; the
/// other estimates are not disturbed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GaussNewtonIdentifier<N, S, const P: usize, const W: usize = 256> {
    law: GaussNewton<N, P>,
    fitter: Fitter<N>,
    blocking: Blocking<N>,
    step: FrictionStep<N>,
    load_step: LoadStepTest<N>,
    units: Units,
    longest: N,
    /// ω T that was given.
    bandwidth: Option<N>,
    slowest: N,
    fastest: N,
    first: N,
    narrowing: N,
    alongside: u32,
    search: u32,
    standing: u32,
    stood: u32,
    release: u32,
    alarm: u32,
    waiting: u32,
    reversal: u32,
    widening: N,
    unexplained: N,
    explained: N,
    bounded: N,
    widest: N,
    second: N,
    has_load: bool,
    free: [bool; P],
    initial: [f64; P],
    set: PhantomData<S>,
}

/// What the identifier remembers between samples.
///
/// What every sample needs comes first: a Cortex-M4F loads a float from within a kilobyte of a base
/// in one instruction, and from beyond it in two.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C)]
pub struct GaussNewtonIdentifierState<N: Number, const P: usize, const W: usize = 256> {
    recursion: Recursion<N, P>,
    start: Start<N, W>,
}

/// What runs every sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Recursion<N: Number, const P: usize> {
    model: ListeningModel<N>,
    tangents: Tangents<N, P>,
    law: GaussNewtonState<N, P>,
    /// That of the model's step; it changes when the estimates do.
    response: Response<N>,
    /// ω T once nothing is being sought.
    omega: N,
    /// ω T that was measured or given.
    measured: N,
    /// ω T of this sample.
    quick: N,
    suspicion: Suspicion<N>,
    mode: Mode,
    /// Samples since the servo last moved.
    still: u32,
    last_move: N,
    /// Samples for which friction has held the model, and how far the servo went meanwhile.
    held: u32,
    slid: N,
    /// Grows with every step of the load and falls with time, samples.
    alarm: u32,
    /// The load before the steps of the present alarm.
    trusted_load: N,
    /// Mean square of the blocks' output error over a second.
    mean_square: N,
    /// What the fit that the estimates began with left unexplained.
    usual: N,
    /// Whether a new fit was no better: the model lacks something that the servo has.
    lacking: bool,
    /// Samples since friction last stopped or turned the model.
    straight: u32,
    /// Whether the load that is sought may as well be friction.
    ambiguous: bool,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Mode {
    /// There is no model yet.
    Recording,
    /// The model joins the servo's motion for so many samples more; nothing is learnt.
    Joining(u32),
    /// The load is sought for so many samples more.
    Searching(u32),
    /// Everything is learnt.
    Learning,
    /// The servo does not follow the command; nothing is learnt for so many samples more.
    Waiting(u32),
}

impl<N, S, const P: usize, const W: usize> FromSettings for GaussNewtonIdentifier<N, S, P, W>
where
    N: Number,
    S: ParameterSet<P>,
{
    /// # Errors
    /// See [`IdentifierError`]; every value out of range is named.
    fn from_settings(settings: &Settings) -> Result<Self, IdentifierError> {
        const { assert!(W >= 32, "a record of fewer blocks tells too little") };
        let config = Listening::new(settings)?;
        let units = config.units;
        let sample_time = units.sample_time();
        let fitter = config.fitter::<S, P>(W)?;
        let places = S::PARAMETERS.map(place);
        let samples = |time: f64| libm::ceil(time / sample_time).max(2.0) as u32;
        let low = places.map(|i| {
            if fitter.free[i] {
                fitter.low[i]
            } else {
                fitter.initial[i].unwrap_or(0.0)
            }
        });
        let high = places.map(|i| {
            if fitter.free[i] {
                fitter.high[i]
            } else {
                fitter.initial[i].unwrap_or(0.0)
            }
        });
        let law = GaussNewton::new(&GaussNewtonConfig {
            sample_time,
            noise: fitter.noise,
            dead_zone: Self::DEAD_ZONE,
            memory: config.memory(),
            low,
            high,
        })?;
        let per_sample = |omega: f64, most: f64| N::from_f64((omega * sample_time).min(most));
        Ok(Self {
            law,
            blocking: Blocking::of(fitter.block),
            fitter: Fitter::new(&fitter),
            step: FrictionStep::new(),
            load_step: LoadStepTest::new(sample_time, fitter.noise),
            units,
            longest: config.longest_increment()?,
            bandwidth: fitter.bandwidth.map(N::from_f64),
            slowest: per_sample(Self::SLOWEST, Self::WIDEST),
            fastest: N::from_f64(Self::WIDEST),
            first: per_sample(Self::FASTEST, MOST_PER_SAMPLE),
            narrowing: N::from_f64(1.0 / 6.0),
            alongside: samples(Self::JOINING),
            search: samples(Self::SEARCH),
            standing: samples(Self::STANDING),
            stood: samples(0.7 * Self::SEARCH),
            release: samples(Self::HELD),
            alarm: samples(Self::ALARM),
            waiting: samples(Self::WAITING),
            reversal: samples(Self::REVERSAL),
            widening: N::from_f64(
                f64::from(GaussNewton::<N, P>::BLOCK) * sample_time / Self::WIDENING,
            ),
            unexplained: N::from_f64(4.0 * fitter.noise),
            explained: N::from_f64(1.5 * fitter.noise),
            bounded: N::from_f64(12.0 * fitter.noise),
            widest: N::from_f64(Self::UNEXPLAINED_WIDEST),
            second: N::from_f64((f64::from(GaussNewton::<N, P>::BLOCK) * sample_time).min(0.1)),
            has_load: S::PARAMETERS.last() == Some(&Parameter::Load)
                && fitter.free[place(Parameter::Load)],
            free: places.map(|i| fitter.free[i]),
            initial: places.map(|i| fitter.initial[i].unwrap_or(0.0)),
            set: PhantomData,
        })
    }
}

impl<N, S, const P: usize, const W: usize> GaussNewtonIdentifier<N, S, P, W>
where
    N: Number,
    S: ParameterSet<P>,
{
    /// Velocity below which the model counts as standing, counts per sample.
    pub const DEAD_ZONE: f64 = 0.02;

    /// The largest ω T of the correction: the output error then stays within a few per cent of
    /// the encoder's.
    pub const WIDEST: f64 = 0.05;

    /// The slowest correction, rad/s.
    pub const SLOWEST: f64 = 3.0;

    /// The measured bandwidth is multiplied by this.
    pub const BANDWIDTH: f64 = 1.0;

    /// The correction when the model is put beside a moving servo or the load is sought, rad/s. It
    /// narrows as 1/ω = 1/ω₀ + t/6.
    pub const FASTEST: f64 = 300.0;

    /// The time in which the model joins the servo's motion, s.
    pub const JOINING: f64 = 0.1;

    /// The time for which the load is sought after a step, s.
    pub const SEARCH: f64 = 0.1;

    /// The time without a count after which the servo stands, s.
    pub const STANDING: f64 = 0.005;

    /// The time for which friction may hold the model while the servo moves, s.
    pub const HELD: f64 = 0.02;

    /// The time after which a step of the load is an event by itself, s. More than four within
    /// that time each are no steps of the load.
    pub const ALARM: f64 = 0.5;

    /// The time after a reversal in which a step of the load may as well be friction, s.
    pub const REVERSAL: f64 = 0.1;

    /// The time constant with which the correction widens where the output error is more than twice
    /// the encoder's, s: what the model lacks must not add up.
    pub const WIDENING: f64 = 0.5;

    /// The largest ω T of the correction then. The encoder's noise no longer matters.
    pub const UNEXPLAINED_WIDEST: f64 = 0.15;

    /// The time to wait before a servo that did not follow is believed again, s.
    pub const WAITING: f64 = 0.5;

    /// Bytes that the recursion itself keeps; the rest of the state is the record of the first fit
    /// and that fit.
    pub const RECURSION_BYTES: usize = size_of::<Recursion<N, P>>();

    /// Whether the recursion runs: a first fit has been found.
    #[must_use]
    pub fn is_running(&self, state: &GaussNewtonIdentifierState<N, P, W>) -> bool {
        !matches!(state.recursion.mode, Mode::Recording)
    }

    /// The bandwidth of the correction, rad/s; zero before there is a model.
    #[must_use]
    pub fn bandwidth(&self, state: &GaussNewtonIdentifierState<N, P, W>) -> f64 {
        state.recursion.omega.to_f64() / self.units.sample_time()
    }

    /// The recursion from what a fit has found.
    fn recursion(&self, found: &Found<N>, velocity: N) -> Recursion<N, P> {
        /// The fit's covariance counts this many times: it was found far from the truth, and not
        /// from white noise.
        const DOUBT: f64 = 4.0;
        let places = S::PARAMETERS.map(place);
        let estimates = places.map(|i| found.parameters[i]);
        let scale = found.acceleration.to_f64();
        // Of a motion in one direction only d − c sign(q̇) is known, not which of the two it is.
        let ambiguity = |i: usize| match S::PARAMETERS[i] {
            Parameter::Coulomb => scale * 0.5,
            Parameter::Load => scale * 0.5 * found.only_direction.to_f64(),
            Parameter::A | Parameter::B => 0.0,
        };
        let one_way = S::HAS_COULOMB && found.only_direction != N::ZERO;
        let covariance: [[f64; P]; P] = core::array::from_fn(|i| {
            core::array::from_fn(|j| {
                let known = DOUBT * found.covariance[places[i]][places[j]].to_f64();
                if one_way && self.free[i] && self.free[j] {
                    known + ambiguity(i) * ambiguity(j)
                } else {
                    known
                }
            })
        });
        // As uncertain as it may become: b by a factor, a by the bandwidth, friction and load by
        // what the command does.
        let gain = found.parameters[1].to_f64();
        let omega = self.bandwidth_of(found);
        let most = S::PARAMETERS.map(|parameter| {
            let deviation = match parameter {
                Parameter::A => 2.0 * (omega.to_f64() + found.parameters[0].to_f64()),
                Parameter::B => 2.0 * gain,
                Parameter::Coulomb | Parameter::Load => scale,
            };
            deviation * deviation
        });
        let most = core::array::from_fn(|i| {
            let certain = covariance[i][i];
            if certain > 0.0 {
                f64::max(most[i], certain)
            } else {
                0.0
            }
        });
        Recursion {
            model: ListeningModel::alongside(velocity),
            tangents: Tangents::NONE,
            law: self.law.start(&estimates, &covariance, &most),
            response: self.step.step.response(found.parameters[0]),
            omega: if self.bandwidth.is_none() && found.unexplained > self.bounded {
                self.widest
            } else {
                omega
            },
            measured: omega,
            quick: self.first,
            suspicion: self.load_step.start(found.unexplained),
            mode: Mode::Joining(self.alongside),
            still: 0,
            last_move: N::ZERO,
            held: 0,
            slid: N::ZERO,
            alarm: 0,
            trusted_load: N::ZERO,
            mean_square: N::ZERO,
            usual: found.unexplained,
            lacking: false,
            straight: 0,
            ambiguous: false,
        }
    }

    fn bandwidth_of(&self, found: &Found<N>) -> N {
        self.bandwidth.unwrap_or_else(|| {
            (N::from_f64(Self::BANDWIDTH) * found.bandwidth).limited(self.slowest, self.fastest)
        })
    }

    /// One sample of a running recursion.
    #[inline]
    fn run(&self, state: &mut Recursion<N, P>, increment: N, command: N) -> Seen<N> {
        let mut event = Event::None;
        state.model.observe(increment);
        let output_error = state.model.error;

        let correction = match state.mode {
            Mode::Learning => {
                let step = self.law.update(
                    &mut state.law,
                    &state.tangents.position,
                    output_error,
                    state.model.velocity,
                );
                match step {
                    GaussNewtonStep::None => {}
                    GaussNewtonStep::Moved(steps) => {
                        state.follow(&steps);
                        let x = ModelParameters::of_set::<S, P>(&state.law.estimates()).x;
                        state.response = self.step.step.response(x);
                    }
                    GaussNewtonStep::Gathered { mean, predicted } => {
                        if self.in_trouble(state, mean) {
                            event = Event::Restarted;
                        }
                        let inflated = state.law.inflated();
                        if self.has_load
                            && self.load_step.suspects(
                                &mut state.suspicion,
                                mean,
                                predicted,
                                inflated,
                            )
                        {
                            event = self.search(state);
                        }
                    }
                }
                let correction = Innovation::critically_damped(state.quick);
                if state.quick > state.omega {
                    state.quick = self.narrowed(state);
                }
                correction
            }
            Mode::Searching(left) => {
                if left == 1 && state.still >= self.stood {
                    // The load of a servo that stands cannot be known.
                    event = self.wait(state);
                    Innovation::critically_damped(state.quick)
                } else {
                    self.seek(state, output_error, left)
                }
            }
            Mode::Joining(left) => self.approach(state, left),
            Mode::Waiting(left) => self.stay(state, left),
            Mode::Recording => Innovation::critically_damped(state.omega),
        };

        let parameters = ModelParameters::of_set::<S, P>(&state.law.estimates());
        let (way, phase) = state.model.advance::<S, P>(
            &self.step,
            &state.response,
            &parameters,
            command,
            &correction,
        );
        state
            .tangents
            .advance::<S, P>(parameters.x, command, &correction, way, phase);
        if self.stand(state, increment, phase) {
            event = Event::FrictionLowered;
        }
        // What is not a number fails the comparison too.
        let near = state.model.error.magnitude() <= N::REACH;
        if !(near && state.model.velocity.is_finite()) {
            self.rejoin(state, N::ZERO);
            event = Event::Restarted;
        }
        Seen {
            output_error,
            event,
        }
    }

    /// Whether the output error has been above the encoder's for so long that a new fit is due. If
    /// that was no better, the model lacks something, and the correction widens.
    #[inline]
    fn in_trouble(&self, state: &mut Recursion<N, P>, mean: N) -> bool {
        if state.alarm > 0 {
            state.alarm = state
                .alarm
                .saturating_sub(u32::from(GaussNewton::<N, P>::BLOCK));
            return false;
        }
        // Bounded, so that only what lasts counts.
        let square = (mean * mean).limited(N::ZERO, self.bounded);
        state.mean_square += self.second * (square - state.mean_square);
        if state.mean_square > self.unexplained {
            if !state.lacking {
                return true;
            }
            if state.omega < self.widest && self.bandwidth.is_none() {
                state.omega += state.omega * self.widening;
                if state.quick < state.omega {
                    state.quick = state.omega;
                }
            }
        } else if state.mean_square < self.explained && state.omega > state.measured {
            state.omega = state.omega - state.omega * self.widening;
            state.quick = state.omega;
        }
        false
    }

    /// The load has changed in a step. Where it does so again and again it is no load: the servo
    /// does not follow the command.
    #[cold]
    fn search(&self, state: &mut Recursion<N, P>) -> Event {
        if state.alarm == 0 {
            state.trusted_load = last(&state.law.estimates());
        }
        state.alarm += self.alarm;
        if state.alarm > 4 * self.alarm {
            return self.wait(state);
        }
        // Right after a reversal too large or too small a friction looks like a step of the load.
        state.ambiguous = S::HAS_COULOMB && state.straight < self.reversal;
        state.mode = Mode::Searching(self.search);
        state.quick = self.first;
        state.suspicion.sought_from = last(&state.law.estimates());
        state.law.drop_block();
        state.law.forgive();
        Event::LoadStep
    }

    #[cold]
    fn wait(&self, state: &mut Recursion<N, P>) -> Event {
        state.law.replace_last(state.trusted_load, N::ZERO);
        state.law.drop_block();
        state.mode = Mode::Waiting(self.waiting);
        state.quick = self.first;
        Event::NotFollowing
    }

    /// A sample of waiting: until the servo moves, and then for a while.
    #[cold]
    fn stay(&self, state: &mut Recursion<N, P>, left: u32) -> Innovation<N> {
        if state.still >= self.standing {
            state.model = ListeningModel::alongside(N::ZERO);
        } else if left > 1 {
            state.mode = Mode::Waiting(left - 1);
        } else {
            state.mode = Mode::Joining(self.alongside);
        }
        Innovation::critically_damped(state.quick)
    }

    /// A sample of the search for the load: 2ω, 2ω², ω³ on position, velocity and load, all three
    /// poles at ω, which narrows from sample to sample as a growing memory does.
    #[cold]
    fn seek(&self, state: &mut Recursion<N, P>, error: N, left: u32) -> Innovation<N> {
        let omega = state.quick;
        let square = omega * omega;
        state.law.add_to_last(square * omega * error);
        state.quick = self.narrowed(state);
        if left > 1 {
            state.mode = Mode::Searching(left - 1);
        } else {
            let load = last(&state.law.estimates());
            let moved = (load - state.suspicion.sought_from) * N::from_f64(0.25);
            state.law.replace_last(load, moved * moved);
            if state.ambiguous {
                // Where the load is a parameter, friction stands before it.
                state.law.raise(P - 2, moved * moved);
            }
            self.resume(state);
        }
        Innovation {
            position: omega + omega,
            velocity: square + square,
        }
    }

    /// A sample in which the model joins the servo's motion.
    #[cold]
    fn approach(&self, state: &mut Recursion<N, P>, left: u32) -> Innovation<N> {
        let omega = state.quick;
        state.quick = self.narrowed(state);
        if left > 1 {
            state.mode = Mode::Joining(left - 1);
        } else {
            self.resume(state);
        }
        Innovation::critically_damped(omega)
    }

    fn narrowed(&self, state: &Recursion<N, P>) -> N {
        let narrower = state.quick - state.quick * state.quick * self.narrowing;
        if narrower > state.omega {
            narrower
        } else {
            state.omega
        }
    }

    fn resume(&self, state: &mut Recursion<N, P>) {
        state.mode = Mode::Learning;
        state.tangents = Tangents::NONE;
        state.law.drop_block();
        state.suspicion.clear();
    }

    /// Standing, decided by the servo's own counts: where servo and model both stand, the model is
    /// put beside the servo. Where friction holds the model while the servo moves on, the friction
    /// is too large; it is lowered, since from a model that stands nothing could be learnt. Answers
    /// whether it was.
    #[inline]
    fn stand(&self, state: &mut Recursion<N, P>, increment: N, phase: Phase<N>) -> bool {
        // A single count back over the edge that was just crossed is no motion.
        if increment == N::ZERO
            || (increment.magnitude() <= N::ONE && increment == -state.last_move)
        {
            state.still = state.still.saturating_add(1);
        } else {
            state.still = 0;
        }
        if increment != N::ZERO {
            state.last_move = increment;
        }
        state.straight = if matches!(phase, Phase::Slid { .. }) {
            state.straight.saturating_add(1)
        } else {
            0
        };
        if !matches!(phase, Phase::Stuck) {
            state.held = 0;
            state.slid = N::ZERO;
            return false;
        }
        if state.still >= self.standing {
            state.model.error = N::ZERO;
            state.tangents = Tangents::NONE;
            state.held = 0;
            state.slid = N::ZERO;
            return false;
        }
        state.held += 1;
        state.slid += increment;
        state.held >= self.release && self.release_model(state)
    }

    /// Whether a new fit shows that the estimates have gone astray: it explains the servo, or at least
    /// twice as much as the fit before. One over a motion one way sees half of the friction, and always
    /// explains that better than the estimates explain all that they have seen: it must find another b.
    fn corrects(&self, state: &Recursion<N, P>, found: &Found<N>) -> bool {
        /// The part of b by which it is another.
        const APART: f64 = 0.2;
        let better = found.unexplained < self.unexplained
            || found.unexplained + found.unexplained < state.usual;
        let gain = ModelParameters::of_set::<S, P>(&state.law.estimates()).gain;
        let apart = (found.parameters[1] - gain).magnitude() > N::from_f64(APART) * gain;
        better && (apart || found.only_direction == N::ZERO)
    }

    /// The model restarts alongside the servo; estimates are kept.
    #[cold]
    fn rejoin(&self, state: &mut Recursion<N, P>, velocity: N) {
        state.model = ListeningModel::alongside(velocity);
        state.tangents = Tangents::NONE;
        state.law.drop_block();
        state.quick = self.first;
        state.mode = Mode::Joining(self.alongside);
    }

    #[cold]
    fn release_model(&self, state: &mut Recursion<N, P>) -> bool {
        /// Counts that the servo must have gone meanwhile.
        const GONE: f64 = 4.0;
        /// What is left of the friction.
        const LEFT: f64 = 0.7;
        let slid = state.slid;
        let held = core::mem::take(&mut state.held);
        state.slid = N::ZERO;
        if slid.magnitude() < N::from_f64(GONE) {
            return false;
        }
        for (i, parameter) in S::PARAMETERS.iter().enumerate() {
            if *parameter == Parameter::Coulomb {
                let lowered = state.law.estimates()[i] * N::from_f64(LEFT);
                state.law.replace(i, lowered);
            }
        }
        state.law.doubt(N::from_f64(4.0));
        state.model = ListeningModel::alongside(
            slid * N::from_count(held.clamp(1, 1 << 20) as i32).reciprocal(),
        );
        state.tangents = Tangents::NONE;
        true
    }
}

impl<N: Number, const P: usize> Recursion<N, P> {
    /// Moves the model with the estimates.
    #[inline]
    fn follow(&mut self, steps: &[N; P]) {
        for i in 0..P {
            self.model.error = self.model.error - self.tangents.position[i] * steps[i];
            self.model.velocity += self.tangents.velocity[i] * steps[i];
        }
    }
}

impl<N, S, const P: usize, const W: usize> Identify<N> for GaussNewtonIdentifier<N, S, P, W>
where
    N: Number,
    S: ParameterSet<P>,
{
    type State = GaussNewtonIdentifierState<N, P, W>;

    fn start(&self) -> Self::State {
        GaussNewtonIdentifierState {
            recursion: Recursion {
                model: ListeningModel::alongside(N::ZERO),
                tangents: Tangents::NONE,
                law: self
                    .law
                    .start(&self.initial.map(N::from_f64), &[[0.0; P]; P], &[0.0; P]),
                response: self.step.step.response(N::ZERO),
                omega: N::ZERO,
                measured: N::ZERO,
                quick: N::ZERO,
                suspicion: self.load_step.start(N::ZERO),
                mode: Mode::Recording,
                still: 0,
                last_move: N::ZERO,
                held: 0,
                slid: N::ZERO,
                alarm: 0,
                trusted_load: N::ZERO,
                mean_square: N::ZERO,
                usual: N::ZERO,
                lacking: false,
                straight: 0,
                ambiguous: false,
            },
            start: Start::new(),
        }
    }

    #[inline]
    fn increment(&self, moved: i32) -> N {
        N::from_count(moved)
    }

    #[inline]
    fn check(&self, increment: N, command: N) -> Result<(), StepError> {
        check(increment, command, self.longest)
    }

    #[inline]
    fn follow(&self, state: &mut Self::State, increment: N, command: N) -> Seen<N> {
        let GaussNewtonIdentifierState { recursion, start } = state;
        let mut event = Event::None;
        if start.is_recording() {
            event = start.record(&self.blocking, increment, command);
            if let Some(found) = start.take_found() {
                if matches!(recursion.mode, Mode::Recording) || self.corrects(recursion, &found) {
                    *recursion = self.recursion(&found, start.velocity(&self.blocking));
                    event = Event::Started;
                    start.stop();
                    let _ = self.run(recursion, N::ZERO, command);
                    return Seen {
                        output_error: N::ZERO,
                        event,
                    };
                }
                start.stop();
                recursion.lacking = true;
            }
        }
        if matches!(recursion.mode, Mode::Recording) {
            return Seen {
                output_error: N::ZERO,
                event,
            };
        }
        let seen = self.run(recursion, increment, command);
        if seen.event == Event::Restarted {
            if start.is_recording() {
                return Seen {
                    event: Event::None,
                    ..seen
                };
            }
            start.clear();
        }
        seen
    }

    fn estimates(&self, state: &Self::State) -> ServoParameters {
        ModelParameters::of_set::<S, P>(&state.recursion.law.estimates()).to_si(&self.units)
    }

    fn standard_errors(&self, state: &Self::State) -> Option<ServoParameters> {
        if matches!(state.recursion.mode, Mode::Recording) && state.recursion.omega == N::ZERO {
            return None;
        }
        let errors = self.law.standard_errors(&state.recursion.law);
        Some(ModelParameters::of_set::<S, P>(&errors.map(N::from_f64)).to_si(&self.units))
    }

    fn at_bounds(&self, state: &Self::State) -> PerParameter<bool> {
        let at = self.law.at_bound(&state.recursion.law);
        PerParameter::from_fn(|wanted| {
            let own = S::PARAMETERS.iter().position(|&own| own == wanted);
            own.is_some_and(|i| at[i] && self.free[i])
        })
    }

    fn join(&self, state: &mut Self::State, increment: N) {
        if state.start.is_recording() {
            state.start.clear();
        }
        if !matches!(state.recursion.mode, Mode::Recording) {
            self.rejoin(&mut state.recursion, increment);
        }
    }

    fn work(&self, state: &mut Self::State, budget: u32) {
        if state.start.is_recording() {
            state.start.work(&self.fitter, budget);
        }
    }
}

fn last<N: Number, const P: usize>(values: &[N; P]) -> N {
    values.last().copied().unwrap_or(N::ZERO)
}
