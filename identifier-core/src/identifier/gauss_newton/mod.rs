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
    block_narrowing: N,
    alongside: u16,
    search: u16,
    standing: u16,
    stood: u16,
    release: u16,
    alarm: u16,
    waiting: u16,
    reversal: u8,
    widening: N,
    unexplained: N,
    explained: N,
    bounded: N,
    widest: N,
    second: N,
    has_friction: bool,
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
    /// The largest deviation of friction and load: the acceleration that the command gave in the
    /// record of the fit.
    scale: N,
    suspicion: Suspicion<N>,
    /// Mean square of the blocks' output error over a second.
    mean_square: N,
    /// The load before the steps of the present alarm.
    trusted_load: N,
    last_move: N,
    /// How far the servo went while friction held the model.
    slid: N,
    /// Samples for which friction has held the model.
    held: u16,
    /// Samples since the servo last moved; counted only where it matters, see
    /// [`Recursion::watch`].
    still: u16,
    /// Grows with every step of the load and falls with time, blocks.
    alarm: u16,
    /// Samples that the mode has left.
    left: u16,
    /// Blocks since friction last stopped or turned the model.
    straight: u8,
    mode: Mode,
    /// Whether a new fit was no better: the model lacks something that the servo has.
    lacking: bool,
    /// Whether the load that is sought may as well be friction.
    ambiguous: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Mode {
    /// There is no model yet.
    Recording,
    /// The model joins the servo's motion for a while; nothing is learnt.
    Joining,
    /// The load is sought for a while.
    Searching,
    /// Everything is learnt.
    Learning,
    /// The servo does not follow the command; nothing is learnt for a while.
    Waiting,
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
        let fitter = config.fitter::<S, P>(W, Self::START_TIME)?;
        let places = S::PARAMETERS.map(place);
        let samples = |time: f64| libm::ceil(time / sample_time).max(2.0) as u16;
        let block_time = f64::from(GaussNewton::<N, P>::BLOCK) * sample_time;
        let blocks = |time: f64| libm::ceil(time / block_time);
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
            narrowing: N::from_f64(Self::NARROWING),
            block_narrowing: N::from_f64(f64::from(GaussNewton::<N, P>::BLOCK) * Self::NARROWING),
            alongside: samples(Self::JOINING),
            search: samples(Self::SEARCH),
            standing: samples(Self::STANDING),
            stood: samples(0.7 * Self::SEARCH),
            release: samples(Self::HELD),
            alarm: blocks(Self::ALARM) as u16,
            waiting: samples(Self::WAITING),
            reversal: blocks(Self::REVERSAL) as u8,
            widening: N::from_f64(block_time / Self::WIDENING),
            unexplained: N::from_f64(4.0 * fitter.noise),
            explained: N::from_f64(1.5 * fitter.noise),
            bounded: N::from_f64(12.0 * fitter.noise),
            widest: N::from_f64(Self::UNEXPLAINED_WIDEST),
            second: N::from_f64(block_time.min(0.1)),
            has_friction: S::HAS_COULOMB && fitter.free[place(Parameter::Coulomb)],
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
    /// The time over which the first fit looks where nobody says, s.
    pub const START_TIME: f64 = 1.0;

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

    /// 1/ω T grows by so much a sample then.
    const NARROWING: f64 = 1.0 / 6.0;

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
        let omega = self.bandwidth_of(found);
        Recursion {
            model: ListeningModel::alongside(velocity),
            tangents: Tangents::NONE,
            law: self.law.start(&estimates, &covariance),
            response: self.step.step.response(found.parameters[0]),
            omega: if self.bandwidth.is_none() && found.unexplained > self.bounded {
                self.widest
            } else {
                omega
            },
            measured: omega,
            quick: self.first,
            scale: found.acceleration,
            suspicion: self.load_step.start(found.unexplained),
            mean_square: N::ZERO,
            trusted_load: N::ZERO,
            last_move: N::ZERO,
            slid: N::ZERO,
            held: 0,
            still: 0,
            alarm: 0,
            left: self.alongside,
            straight: 0,
            mode: Mode::Joining,
            lacking: false,
            ambiguous: false,
        }
    }

    /// The variances beyond which forgetting makes no estimate uncertain: a by the bandwidth, b by a
    /// factor, friction and load by what the command does.
    #[inline]
    fn most(omega: N, scale: N, estimates: &[N; P]) -> [N; P] {
        let model = ModelParameters::of_set::<S, P>(estimates);
        S::PARAMETERS.map(|parameter| {
            let deviation = match parameter {
                Parameter::A => omega + omega + model.x + model.x,
                Parameter::B => model.gain + model.gain,
                Parameter::Coulomb | Parameter::Load => scale,
            };
            deviation * deviation
        })
    }

    fn bandwidth_of(&self, found: &Found<N>) -> N {
        self.bandwidth.unwrap_or_else(|| {
            (N::from_f64(Self::BANDWIDTH) * found.bandwidth).limited(self.slowest, self.fastest)
        })
    }

    /// A sample that is recorded too, for a fit.
    #[cold]
    #[inline(never)]
    fn record(
        &self,
        state: &mut GaussNewtonIdentifierState<N, P, W>,
        increment: N,
        command: N,
    ) -> Seen<N> {
        let GaussNewtonIdentifierState { recursion, start } = state;
        let event = start.record(&self.blocking, increment, command);
        if let Some(found) = start.take_found() {
            if recursion.mode == Mode::Recording || self.corrects(recursion, start, &found) {
                *recursion = self.recursion(&found, start.velocity(&self.blocking));
                start.go_on(&found);
                let _ = self.run(recursion, N::ZERO, command);
                return Seen {
                    output_error: N::ZERO,
                    event: Event::Started,
                };
            }
            start.stop();
            recursion.lacking = true;
        }
        if recursion.mode == Mode::Recording {
            return Seen {
                output_error: N::ZERO,
                event,
            };
        }
        let seen = self.run(recursion, increment, command);
        Seen {
            output_error: seen.output_error,
            event: match seen.event {
                Event::Restarted => Event::None,
                event => event,
            },
        }
    }

    /// One sample of a running recursion.
    #[inline]
    fn run(&self, state: &mut Recursion<N, P>, increment: N, command: N) -> Seen<N> {
        state.model.observe(increment);
        let output_error = state.model.error;
        if state.mode != Mode::Learning {
            let event = self.run_aside(state, increment, command);
            return Seen {
                output_error,
                event,
            };
        }
        let correction = Innovation::critically_damped(state.quick);
        let parameters = ModelParameters::of_set::<S, P>(&state.law.estimates());
        let slid = state
            .model
            .slide::<S, P>(&state.response, &parameters, command, &correction);
        if let Some((way, direction)) = slid {
            state
                .tangents
                .slide::<S, P>(parameters.x, command, &correction, way, direction);
        } else if let Some(event) = self.run_through_rest(state, increment, command) {
            return Seen {
                output_error,
                event,
            };
        }
        Seen {
            output_error,
            event: self.learn_from(state, output_error),
        }
    }

    /// The law's share of a sample, and what goes with it once a block.
    #[inline]
    fn learn_from(&self, state: &mut Recursion<N, P>, output_error: N) -> Event {
        let (omega, scale) = (state.measured, state.scale);
        let step = self.law.update(
            &mut state.law,
            output_error,
            &state.tangents.position,
            &state.tangents.velocity,
            state.model.velocity,
            |estimates| Self::most(omega, scale, estimates),
        );
        match step {
            GaussNewtonStep::Working => {}
            GaussNewtonStep::Moved(steps) => {
                state.follow(&steps);
                let x = ModelParameters::of_set::<S, P>(&state.law.estimates()).x;
                state.response = self.step.step.response(x);
            }
            GaussNewtonStep::Ready => {
                state.straight = state.straight.saturating_add(1);
                state.quick = state.narrowed(self.block_narrowing);
                return self.keep_in_reach(state);
            }
            GaussNewtonStep::Gathered { mean, predicted } => {
                let inflated = state.law.inflated();
                if self.has_load
                    && self
                        .load_step
                        .suspects(&mut state.suspicion, mean, predicted, inflated)
                {
                    return self.search(state);
                }
                if self.in_trouble(state, mean) {
                    return Event::Restarted;
                }
            }
        }
        Event::None
    }

    /// The model's part of a sample in which it may stand, stop or turn. One in which it stops or
    /// turns teaches nothing, and the law's work waits for the next: then what happened.
    #[cold]
    #[inline(never)]
    fn run_through_rest(
        &self,
        state: &mut Recursion<N, P>,
        increment: N,
        command: N,
    ) -> Option<Event> {
        let correction = Innovation::critically_damped(state.quick);
        let parameters = ModelParameters::of_set::<S, P>(&state.law.estimates());
        if state.model.rest::<S, P>(&parameters, command, &correction) {
            state.tangents.rest(&correction);
            state.watch(increment);
            return self
                .stand(state, increment)
                .then_some(Event::FrictionLowered);
        }
        state.move_on();
        match self.advance(state, command, &correction) {
            Phase::Slid { .. } | Phase::Stuck => None,
            Phase::Stopped { .. } | Phase::Turned { .. } => {
                state.straight = 0;
                state.still = 0;
                Some(Event::None)
            }
        }
    }

    /// A sample in which nothing is learnt, but perhaps the load.
    #[cold]
    #[inline(never)]
    fn run_aside(&self, state: &mut Recursion<N, P>, increment: N, command: N) -> Event {
        state.watch(increment);
        let mut event = Event::None;
        let correction = match state.mode {
            Mode::Searching if state.left == 1 && state.still >= self.stood => {
                // The load of a servo that stands cannot be known.
                event = self.wait(state);
                Innovation::critically_damped(state.quick)
            }
            Mode::Searching => self.seek(state),
            Mode::Waiting => self.stay(state),
            _ => self.approach(state),
        };
        match self.advance(state, command, &correction) {
            Phase::Stuck if self.stand(state, increment) => event = Event::FrictionLowered,
            Phase::Stuck => {}
            _ => state.move_on(),
        }
        match self.keep_in_reach(state) {
            Event::None => event,
            restarted => restarted,
        }
    }

    /// Moves the model and its tangents through any sample.
    #[inline(never)]
    fn advance(
        &self,
        state: &mut Recursion<N, P>,
        command: N,
        correction: &Innovation<N>,
    ) -> Phase<N> {
        let parameters = ModelParameters::of_set::<S, P>(&state.law.estimates());
        let (way, phase) = state.model.advance::<S, P>(
            &self.step,
            &state.response,
            &parameters,
            command,
            correction,
        );
        state
            .tangents
            .advance::<S, P>(parameters.x, command, correction, way, phase);
        phase
    }

    /// A model that ran away starts again. Within a block it gets nowhere that the number format
    /// could not follow.
    #[inline]
    fn keep_in_reach(&self, state: &mut Recursion<N, P>) -> Event {
        // What is not a number fails the comparison too.
        let near = state.model.error.magnitude() + state.model.velocity.magnitude() <= N::REACH;
        if near {
            Event::None
        } else {
            self.rejoin(state, N::ZERO);
            Event::Restarted
        }
    }

    /// Whether the output error has been above the encoder's for so long that a new fit is due. If
    /// that was no better, the model lacks something, and the correction widens.
    #[inline]
    fn in_trouble(&self, state: &mut Recursion<N, P>, mean: N) -> bool {
        if state.alarm > 0 {
            state.alarm -= 1;
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
        state.alarm = state.alarm.saturating_add(self.alarm);
        if state.alarm > 4 * self.alarm {
            return self.wait(state);
        }
        // Right after a reversal too large or too small a friction looks like a step of the load.
        state.ambiguous = self.has_friction && state.straight < self.reversal;
        state.mode = Mode::Searching;
        state.left = self.search;
        state.still = 0;
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
        state.mode = Mode::Waiting;
        state.left = self.waiting;
        state.still = 0;
        state.quick = self.first;
        Event::NotFollowing
    }

    /// A sample of waiting: until the servo moves, and then for a while.
    fn stay(&self, state: &mut Recursion<N, P>) -> Innovation<N> {
        if state.still >= self.standing {
            state.model = ListeningModel::alongside(N::ZERO);
        } else if state.is_over() {
            state.mode = Mode::Joining;
            state.left = self.alongside;
        }
        Innovation::critically_damped(state.quick)
    }

    /// A sample of the search for the load: 2ω, 2ω², ω³ on position, velocity and load, all three
    /// poles at ω, which narrows from sample to sample as a growing memory does.
    fn seek(&self, state: &mut Recursion<N, P>) -> Innovation<N> {
        let omega = state.quick;
        let square = omega * omega;
        state.law.add_to_last(square * omega * state.model.error);
        state.quick = state.narrowed(self.narrowing);
        if state.is_over() {
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
    fn approach(&self, state: &mut Recursion<N, P>) -> Innovation<N> {
        let omega = state.quick;
        state.quick = state.narrowed(self.narrowing);
        if state.is_over() {
            self.resume(state);
        }
        Innovation::critically_damped(omega)
    }

    fn resume(&self, state: &mut Recursion<N, P>) {
        state.mode = Mode::Learning;
        state.tangents = Tangents::NONE;
        state.law.drop_block();
        state.suspicion.clear();
    }

    /// A sample in which friction held the model. Standing is decided by the servo's own counts:
    /// where the servo stands too, the model is put beside it. Where the servo moves on, the friction
    /// is too large; it is lowered, since from a model that stands nothing could be learnt. Answers
    /// whether it was.
    #[inline]
    fn stand(&self, state: &mut Recursion<N, P>, increment: N) -> bool {
        if state.still >= self.standing {
            state.model.error = N::ZERO;
            state.tangents = Tangents::NONE;
            state.move_on();
            return false;
        }
        state.held += 1;
        state.slid += increment;
        state.held >= self.release && self.release_model(state)
    }

    /// Whether a new fit shows that the estimates have gone astray: it explains the servo, or at least
    /// twice as much as the fit before. One over a motion one way sees half of the friction, and always
    /// explains that better than the estimates explain all that they have seen: it must find another b.
    fn corrects(&self, state: &Recursion<N, P>, start: &Start<N, W>, found: &Found<N>) -> bool {
        /// The part of b by which it is another.
        const APART: f64 = 0.2;
        let better = found.unexplained < self.unexplained || start.is_better(found);
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
        state.mode = Mode::Joining;
        state.left = self.alongside;
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
        let most = Self::most(state.measured, state.scale, &state.law.estimates());
        state.law.doubt(N::from_f64(4.0), &most);
        state.model = ListeningModel::alongside(slid * N::from_count(i32::from(held)).reciprocal());
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

    /// Counts the samples for which the servo has not moved. A single count back over the edge that
    /// was just crossed is no motion. While model and servo move this is of no interest.
    fn watch(&mut self, increment: N) {
        let back = increment == -self.last_move && increment.magnitude() <= N::ONE;
        if increment == N::ZERO || back {
            self.still = self.still.saturating_add(1);
        } else {
            self.still = 0;
        }
        if increment != N::ZERO {
            self.last_move = increment;
        }
    }

    /// Friction does not hold the model against the servo.
    #[inline]
    fn move_on(&mut self) {
        self.held = 0;
        self.slid = N::ZERO;
    }

    /// Counts a sample of the mode; whether it was the last.
    fn is_over(&mut self) -> bool {
        self.left = self.left.saturating_sub(1);
        self.left == 0
    }

    /// The correction after `narrowing`, the growth of 1/ω.
    #[inline]
    fn narrowed(&self, narrowing: N) -> N {
        let narrower = self.quick - self.quick * self.quick * narrowing;
        if narrower > self.omega {
            narrower
        } else {
            self.omega
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
                    .start(&self.initial.map(N::from_f64), &[[0.0; P]; P]),
                response: self.step.step.response(N::ZERO),
                omega: N::ZERO,
                measured: N::ZERO,
                quick: N::ZERO,
                scale: N::ZERO,
                suspicion: self.load_step.start(N::ZERO),
                mean_square: N::ZERO,
                trusted_load: N::ZERO,
                last_move: N::ZERO,
                slid: N::ZERO,
                held: 0,
                still: 0,
                alarm: 0,
                left: 0,
                straight: 0,
                mode: Mode::Recording,
                lacking: false,
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
        if state.start.is_recording() {
            return self.record(state, increment, command);
        }
        let seen = self.run(&mut state.recursion, increment, command);
        if seen.event == Event::Restarted {
            state.start.clear();
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

    /// None before there is a model.
    fn bandwidth(&self, state: &Self::State) -> Option<f64> {
        let omega = state.recursion.omega.to_f64() / self.units.sample_time();
        (omega > 0.0).then_some(omega)
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
