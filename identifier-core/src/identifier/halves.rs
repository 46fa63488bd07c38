use super::identify::Identify;
use crate::fit::NumberedBlock;
use crate::reason::Reason;

/// The interrupt's half of an identifier that fits: it records, and continues from the fit results.
///
/// A fit takes many samples' time. So on a chip it runs in the background while the interrupt records on. The halves
/// share no memory. The caller provides two queues between them, of one producer and one consumer each. Neither half
/// waits for the other:
///
/// ```text
///   interrupt: RecordBlocks ──► blocks ──► background: FitBlocks
///                           ◄── fitted ◄──
/// ```
///
/// With Gauss–Newton:
///
/// ```
/// # use heapless::spsc::Queue;
/// # use identifier_core::Settings;
/// use identifier_core::identifier::{
///     FitBlocks, GaussNewtonFitter, GaussNewtonRecursion, Identify, RecordBlocks,
/// };
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
/// the queue are recognised by their numbers. Where no interrupt has to be short, [`Combined`](super::Combined) is both
/// in one.
pub trait RecordBlocks<N: Copy>: Identify<N> {
    /// A fit result, prepared so that taking it over needs no division.
    type Fitted: Copy + core::fmt::Debug;

    /// The block that the last sample completed, if it did. One that is not taken before the next is
    /// complete is lost.
    fn take_block(&self, state: &mut Self::State) -> Option<NumberedBlock<N>>;

    /// Takes over a fit result: the next sample continues from it.
    fn take_over(&self, state: &mut Self::State, fitted: &Self::Fitted);
}

/// The background's half of an identifier that fits: see [`RecordBlocks`].
pub trait FitBlocks<N: Copy> {
    /// The record and the fit in progress.
    type State: Clone + core::fmt::Debug;

    /// A fit result for [`RecordBlocks::take_over`].
    type Fitted: Copy + core::fmt::Debug;

    /// The state at the start: an empty record.
    fn start(&self) -> Self::State;

    /// Takes a block, in the order in which they were recorded. One that does not follow the last begins the record
    /// anew and ends the fit in progress.
    fn take(&self, state: &mut Self::State, block: &NumberedBlock<N>);

    /// Forgets the record, and the fit in progress.
    fn begin_anew(&self, state: &mut Self::State);

    /// Continues the fit in progress by at most `budget` blocks, or begins one if it is time. Returns a fit result when
    /// there is one to be taken over.
    fn work(&self, state: &mut Self::State, budget: u32) -> Option<Self::Fitted>;

    /// Why no first fit has succeeded after a second of motion: see
    /// [`Identify::rejection_reason`](super::Identify::rejection_reason).
    fn rejection_reason(&self, state: &Self::State) -> Option<Reason>;

    /// Noise of the position: see [`Identify::noise`](super::Identify::noise).
    fn noise(&self, state: &Self::State) -> Option<f64>;
}
