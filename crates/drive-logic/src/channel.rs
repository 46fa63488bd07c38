//! What goes between the two halves: orders one way, events the other; what is recorded for a first fit,
//! and what it found; what a commissioning finds, and what its study answers; and beside the queues what
//! must never wait for room.

use core::fmt;
use core::sync::atomic::{AtomicU32, Ordering};

use heapless::spsc::{Consumer, Producer, Queue};
use identifier_core::commission;
use identifier_core::identifier::NumberedBlock;

use crate::first_fit::Fitted;
use crate::messages::{Event, Order};

/// Orders and events that may be on their way at once, and one more; powers of two, so that a queue
/// masks where it would divide.
const ORDERS: usize = 4;
const EVENTS: usize = 8;

/// Blocks of a record that may be on their way: each is some 16 ms long.
const BLOCKS_UNDER_WAY: usize = 8;

/// Fits on their way back, and one more.
const FITS: usize = 2;

/// Findings of a commissioning that may be on their way, and one more.
const FINDINGS: usize = 16;

/// Answers of its study, and one more.
const ANSWERS: usize = 2;

type Block = NumberedBlock<f32>;
type RecordEvent = commission::RecordEvent<f32>;
type Decision = commission::Decision<f32>;

/// Everything between the two halves of a drive.
#[derive(Debug)]
pub struct Channel {
    orders: Queue<Stamped, ORDERS>,
    events: Queue<Event, EVENTS>,
    blocks: Queue<Block, BLOCKS_UNDER_WAY>,
    fits: Queue<Fitted, FITS>,
    findings: Queue<RecordEvent, FINDINGS>,
    answers: Queue<Decision, ANSWERS>,
    signals: Signals,
}

/// An order, and how many stops had been asked for before it: one that a stop overtook is void.
#[derive(Debug)]
struct Stamped {
    stops: u32,
    order: Order,
}

/// Counters that the background raises and the interrupt reads: nothing can fill them.
#[derive(Debug)]
struct Signals {
    /// Raised with everything below but the last, and with every order: while it stands still, there is
    /// nothing to obey.
    asked: AtomicU32,
    stops: AtomicU32,
    mode_changes: AtomicU32,
    heard: AtomicU32,
    alive: AtomicU32,
    /// No counter: samples for which the background may be missed while the servo is let go.
    released_patience: AtomicU32,
}

/// The background's end of a [`Channel`].
pub struct BackgroundEnd<'a> {
    orders: Producer<'a, Stamped, ORDERS>,
    events: Consumer<'a, Event, EVENTS>,
    blocks: Consumer<'a, Block, BLOCKS_UNDER_WAY>,
    fits: Producer<'a, Fitted, FITS>,
    findings: Consumer<'a, RecordEvent, FINDINGS>,
    answers: Producer<'a, Decision, ANSWERS>,
    signals: &'a Signals,
}

/// The interrupt's end of a [`Channel`].
pub struct InterruptEnd<'a> {
    orders: Consumer<'a, Stamped, ORDERS>,
    events: Producer<'a, Event, EVENTS>,
    blocks: Producer<'a, Block, BLOCKS_UNDER_WAY>,
    fits: Consumer<'a, Fitted, FITS>,
    findings: Producer<'a, RecordEvent, FINDINGS>,
    answers: Consumer<'a, Decision, ANSWERS>,
    signals: &'a Signals,
}

impl fmt::Debug for BackgroundEnd<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("BackgroundEnd").finish_non_exhaustive()
    }
}

impl fmt::Debug for InterruptEnd<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("InterruptEnd").finish_non_exhaustive()
    }
}

impl Channel {
    /// Empty.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            orders: Queue::new(),
            events: Queue::new(),
            blocks: Queue::new(),
            fits: Queue::new(),
            findings: Queue::new(),
            answers: Queue::new(),
            signals: Signals {
                asked: AtomicU32::new(0),
                stops: AtomicU32::new(0),
                mode_changes: AtomicU32::new(0),
                heard: AtomicU32::new(0),
                alive: AtomicU32::new(0),
                released_patience: AtomicU32::new(1),
            },
        }
    }

    /// Both ends.
    pub fn split(&mut self) -> (BackgroundEnd<'_>, InterruptEnd<'_>) {
        let Self {
            orders,
            events,
            blocks,
            fits,
            findings,
            answers,
            signals,
        } = self;
        let (give, take) = orders.split();
        let (tell, hear) = events.split();
        let (record, fit_to) = blocks.split();
        let (hand_over, go_on_from) = fits.split();
        let (find, study) = findings.split();
        let (answer, accept) = answers.split();
        let background = BackgroundEnd {
            orders: give,
            events: hear,
            blocks: fit_to,
            fits: hand_over,
            findings: study,
            answers: answer,
            signals,
        };
        let interrupt = InterruptEnd {
            orders: take,
            events: tell,
            blocks: record,
            fits: go_on_from,
            findings: find,
            answers: accept,
            signals,
        };
        (background, interrupt)
    }
}

impl Default for Channel {
    fn default() -> Self {
        Self::new()
    }
}

/// Raises a counter that nobody else writes. Cores without an atomic addition have this too.
fn raise(counter: &AtomicU32) {
    let next = counter.load(Ordering::Relaxed).wrapping_add(1);
    counter.store(next, Ordering::Release);
}

impl BackgroundEnd<'_> {
    /// Gives an order, or gives it back if the interrupt has not done the ones before it.
    pub(crate) fn order(&mut self, order: Order) -> Result<(), Order> {
        let stops = self.stops();
        let given = self
            .orders
            .enqueue(Stamped { stops, order })
            .map_err(|back| back.order);
        raise(&self.signals.asked);
        given
    }

    /// The next event.
    pub(crate) fn event(&mut self) -> Option<Event> {
        self.events.dequeue()
    }

    /// The next block of a record.
    pub(crate) fn block(&mut self) -> Option<Block> {
        self.blocks.dequeue()
    }

    /// Hands a fit over, or gives it back.
    pub(crate) fn fitted(&mut self, fitted: Fitted) -> Result<(), Fitted> {
        self.fits.enqueue(fitted)
    }

    /// The next finding of a commissioning.
    pub(crate) fn finding(&mut self) -> Option<RecordEvent> {
        self.findings.dequeue()
    }

    /// Hands an answer of its study over; false if it finds no room.
    pub(crate) fn answer(&mut self, answer: &Decision) -> bool {
        self.answers.enqueue(*answer).is_ok()
    }

    /// Ends a commissioning for another mode.
    pub(crate) fn change_mode(&self) {
        raise(&self.signals.mode_changes);
        raise(&self.signals.asked);
    }

    /// Stops whatever runs and makes void every order that was not done yet.
    pub(crate) fn stop(&self) {
        raise(&self.signals.stops);
        raise(&self.signals.asked);
    }

    /// How often that was asked for.
    pub(crate) fn stops(&self) -> u32 {
        self.signals.stops.load(Ordering::Relaxed)
    }

    /// Somebody was heard on the line who speaks our language.
    pub(crate) fn heard(&self) {
        raise(&self.signals.heard);
        raise(&self.signals.asked);
    }

    /// Says how many samples the background may be missed while the servo is let go.
    pub(crate) fn set_released_patience(&self, samples: u32) {
        let place = &self.signals.released_patience;
        place.store(samples, Ordering::Relaxed);
    }

    /// The background goes round.
    pub(crate) fn is_alive(&self) {
        raise(&self.signals.alive);
    }
}

impl InterruptEnd<'_> {
    /// How often a stop or an order was asked for, or the host heard.
    #[inline]
    pub(crate) fn times_asked(&self) -> u32 {
        self.signals.asked.load(Ordering::Acquire)
    }

    /// The next order that no stop has overtaken since it was given, and those that one has overtaken
    /// as errors.
    pub(crate) fn order(&mut self) -> Option<Result<Order, Order>> {
        let Stamped { stops, order } = self.orders.dequeue()?;
        Some(if stops == self.stops() {
            Ok(order)
        } else {
            Err(order)
        })
    }

    /// Tells, or gives back what finds no room.
    #[inline]
    pub(crate) fn tell(&mut self, event: Event) -> Result<(), Event> {
        self.events.enqueue(event)
    }

    /// Hands on a block of a record. One that finds no room is lost, which the fit will see.
    #[inline]
    pub(crate) fn block(&mut self, block: Block) {
        let _ = self.blocks.enqueue(block);
    }

    /// Hands a finding over; false if it finds no room.
    #[inline]
    pub(crate) fn finding(&mut self, finding: RecordEvent) -> bool {
        self.findings.enqueue(finding).is_ok()
    }

    /// An answer of the study.
    #[inline]
    pub(crate) fn answer(&mut self) -> Option<Decision> {
        self.answers.dequeue()
    }

    /// A fit to go on from.
    #[inline]
    pub(crate) fn fitted(&mut self) -> Option<Fitted> {
        self.fits.dequeue()
    }

    pub(crate) fn stops(&self) -> u32 {
        self.signals.stops.load(Ordering::Acquire)
    }

    pub(crate) fn mode_changes(&self) -> u32 {
        self.signals.mode_changes.load(Ordering::Relaxed)
    }

    pub(crate) fn times_heard(&self) -> u32 {
        self.signals.heard.load(Ordering::Relaxed)
    }

    pub(crate) fn released_patience(&self) -> u32 {
        self.signals.released_patience.load(Ordering::Relaxed)
    }

    #[inline]
    pub(crate) fn times_alive(&self) -> u32 {
        self.signals.alive.load(Ordering::Relaxed)
    }
}
