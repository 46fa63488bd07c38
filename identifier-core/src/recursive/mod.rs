//! Recursive Gauss–Newton: the estimator and the identifier that begins by a fit, in its two halves.

mod beginning;
mod first_fit;
mod fitted;
mod interrupt;
mod known;
mod law;
mod learning;
mod load_step;
mod recursion;
mod standing;
mod suspended;
mod terms;
mod uncertainty;
mod wait;
mod whole;

pub use first_fit::{GaussNewtonFitter, GaussNewtonFitterState};
pub use fitted::GaussNewtonFitted;
pub use interrupt::SettledEstimates;
pub use known::{ExpectedMotion, PreparedServo};
pub use whole::GaussNewtonIdentifier;

use core::marker::PhantomData;

pub(crate) use law::{GaussNewton, GaussNewtonConfig};
pub(crate) use load_step::LoadStepTest;
pub(crate) use wait::PATIENCE;

use crate::constants::{Encode, encode};
use crate::fit::Blocking;
use crate::measurement::angle::AngleSettings;
use crate::model::{FrictionStep, IdentifiableSet};
use crate::number::Number;
use crate::parameters::{Terms, unknowns_fingerprint};
use crate::units::Units;

/// The interrupt's half of the fast identifier: the recursion, and the recording for the fit. The [`GaussNewtonFitter`]
/// makes that fit over W blocks.
///
/// When an estimate moves, the model's state moves with it. To first order it is then the state that the new estimate
/// would always have had. So the output error is the residual of the *present* estimates, and no settling of the model
/// is needed.
///
/// A step of the load is detected by the mean of the output error. The recursion then pauses. The model estimates the
/// load by an integral and a correction that is fast at first. The other estimates are not disturbed.
///
/// A fit takes many samples' time. So on a chip it runs in the background while the interrupt records on. The halves
/// share no memory. The caller provides two queues between them, of one producer and one consumer each. Neither half
/// waits for the other:
///
/// ```text
///   interrupt: GaussNewtonRecursion ──► blocks ──► background: GaussNewtonFitter
///                                   ◄── fitted ◄──
/// ```
///
/// ```
/// # use heapless::spsc::Queue;
/// # use identifier_core::Settings;
/// use identifier_core::identifier::{GaussNewtonFitter, GaussNewtonRecursion, Identify};
/// use identifier_core::parameters::Unknowns;
///
/// # let settings = Settings::new(1e-3, 10_000.0);
/// # let (moved, command) = (0, 0.0);
/// let identifier: GaussNewtonRecursion<f32, Unknowns<4>, 4, 64> = settings.build()?;
/// let fitter: GaussNewtonFitter<f32, Unknowns<4>, 4, 64> = settings.build()?;
/// let (mut state, mut fitting) = (identifier.start(), fitter.start());
/// # let (mut there, mut back) = (Queue::<_, 8>::new(), Queue::<_, 2>::new());
/// # let (mut send_block, mut next_block) = there.split();
/// # let (mut send_fitted, mut next_fitted) = back.split();
///
/// // In the interrupt, every sample:
/// if let Some(fitted) = next_fitted.dequeue() {
///     identifier.take_over(&mut state, &fitted);
/// }
/// let seen = identifier.process(&mut state, moved, command)?;
/// if let Some(block) = identifier.take_block(&mut state) {
///     let _ = send_block.enqueue(block);
/// }
///
/// // In the background, again and again:
/// while let Some(block) = next_block.dequeue() {
///     fitter.take(&mut fitting, &block);
/// }
/// if let Some(fitted) = fitter.work(&mut fitting, 8) {
///     let _ = send_fitted.enqueue(fitted);
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// **Losses are harmless.** If the queue has no space, a block is lost. The fitter notices the missing number and
/// begins a new record. A fit result of a recording that has ended is not taken over. A lost fit result is computed
/// again. The queue of blocks needs space for those that come while the background is busy.
///
/// Both halves are built from the same settings and start together. Blocks of an earlier recording that are still in
/// the queue are recognised by their numbers. Where no interrupt has to be short, [`GaussNewtonIdentifier`] is both
/// in one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GaussNewtonRecursion<N, S, const P: usize, const W: usize = 256> {
    pub(crate) law: GaussNewton<N, P>,
    pub(crate) blocking: Blocking<N>,
    pub(crate) step: FrictionStep<N>,
    pub(crate) load_step: LoadStepTest<N>,
    pub(crate) angle: AngleSettings<N>,
    /// ρ/(T v_s).
    pub(crate) per_low_speed_velocity: N,
    pub(crate) demanded: Terms,
    /// The largest standard deviation of a delay, samples.
    pub(crate) max_delay_deviation: N,
    /// Blocks that the model must have moved in each direction before a term enters.
    pub(crate) min_motion_blocks: u16,
    pub(crate) units: Units,
    pub(crate) longest: N,
    /// ω T that was given.
    pub(crate) bandwidth: Option<N>,
    pub(crate) min_omega: N,
    pub(crate) max_omega: N,
    pub(crate) joining_omega: N,
    pub(crate) narrowing: N,
    pub(crate) block_narrowing: N,
    pub(crate) joining_samples: u16,
    pub(crate) search_samples: u16,
    pub(crate) standstill_samples: u16,
    pub(crate) search_standstill_samples: u16,
    pub(crate) max_held_samples: u16,
    pub(crate) alarm_blocks: u16,
    pub(crate) waiting_samples: u16,
    pub(crate) reversal_blocks: u8,
    pub(crate) widening: N,
    pub(crate) unexplained_variance: N,
    pub(crate) explained_variance: N,
    pub(crate) max_square: N,
    pub(crate) max_unexplained_omega: N,
    pub(crate) mean_square_weight: N,
    pub(crate) has_friction: bool,
    /// The place of friction in the set.
    pub(crate) friction: usize,
    pub(crate) has_load: bool,
    pub(crate) free: [bool; P],
    pub(crate) initial: [f64; P],
    pub(crate) set: PhantomData<S>,
}

encode! {
    [N: Encode, S: IdentifiableSet<P>, const P: usize, const W: usize]
    GaussNewtonRecursion<N, S, P, W> as "GaussNewtonRecursion" {
        law, blocking, step, load_step, angle, per_low_speed_velocity, demanded,
        max_delay_deviation, min_motion_blocks, units, longest, bandwidth, min_omega, max_omega,
        joining_omega, narrowing, block_narrowing, joining_samples, search_samples,
        standstill_samples, search_standstill_samples, max_held_samples, alarm_blocks,
        waiting_samples, reversal_blocks, widening, unexplained_variance, explained_variance,
        max_square, max_unexplained_omega, mean_square_weight, has_friction, friction, has_load,
        free, initial, set,
    }
    also unknowns_fingerprint(&S::UNKNOWNS, W)
}

impl<N, S, const P: usize, const W: usize> GaussNewtonRecursion<N, S, P, W>
where
    N: Number,
    S: IdentifiableSet<P>,
{
    /// The default time span of the first fit, s.
    pub const START_TIME: f64 = 1.0;

    /// Velocity below which the model counts as at rest, counts per sample.
    pub const DEAD_ZONE: f64 = 0.02;

    /// The largest ω T of the correction: the output error then stays within a few per cent of
    /// the encoder's.
    pub const MAX_OMEGA: f64 = 0.05;

    /// The slowest correction, rad/s.
    pub const MIN_BANDWIDTH: f64 = 3.0;

    /// The measured bandwidth is multiplied by this.
    pub const BANDWIDTH: f64 = 1.0;

    /// The bandwidth of the correction when the model joins a moving servo or the load is estimated
    /// anew, rad/s. It narrows as 1/ω = 1/ω₀ + t/6.
    pub const JOINING_BANDWIDTH: f64 = 300.0;

    /// 1/ω T grows by this per sample then.
    pub(crate) const NARROWING_PER_SAMPLE: f64 = 1.0 / 6.0;

    /// The time in which the model joins the servo's motion, s.
    pub const JOINING_TIME: f64 = 0.1;

    /// The time for which the load is estimated anew after a step, s.
    pub const SEARCH_TIME: f64 = Self::JOINING_TIME;

    /// The time without a count after which the servo is at standstill, s.
    pub const STANDSTILL_TIME: f64 = 0.005;

    /// The time for which friction may hold the model while the servo moves, s.
    pub const MAX_HELD_TIME: f64 = 0.02;

    /// The time after which a step of the load is an event by itself, s. More than four, each within
    /// that time of the last, are not steps of the load.
    pub const ALARM_TIME: f64 = 0.5;

    /// The time after a reversal in which a deviation may be friction or a step of the load, s.
    pub const REVERSAL_TIME: f64 = 0.1;

    /// The time constant with which the correction widens if the output error is more than twice the encoder's, s. The
    /// error of an incomplete model must not accumulate.
    pub const WIDENING_TIME: f64 = 0.5;

    /// The largest ω T of the correction then. The encoder's noise no longer matters.
    pub const MAX_UNEXPLAINED_OMEGA: f64 = 0.15;

    /// The largest standard deviation of a delay, s; at least four samples.
    pub const MAX_DELAY_DEVIATION: f64 = 4e-3;

    /// The time for which the model must move in each direction before a term enters, s. The next term needs it again.
    pub const MIN_MOTION_TIME: f64 = 0.5;

    /// The time after which a servo that did not follow its command is learnt from again, s.
    pub const WAITING_TIME: f64 = 0.5;
}
