//! Queues and counters between the two halves: orders one way, events the other; blocks for a first fit, and the fit;
//! events of a commissioning's record, and decisions of its solver; and counters for what must never wait for room.

use core::fmt;
use core::sync::atomic::{AtomicU32, Ordering};

use heapless::spsc::{Consumer, Producer, Queue};
use identifier_core::commission;
use identifier_core::identifier::NumberedBlock;

use crate::closed_loop::Fitted;
use crate::messages::{Event, Order};

/// Orders and events that may be on their way at once, and one more; powers of two, so that a queue
/// masks where it would divide.
const ORDERS: usize = 4;
const EVENTS: usize = 8;

/// Blocks of a record that may be on their way: each is some 16 ms long.
const BLOCKS: usize = 8;

/// Fits on their way back, and one more.
const FITS: usize = 2;

/// Record events of a commissioning that may be on their way, and one more.
const RECORD_EVENTS: usize = 16;

/// Decisions of its solver, and one more.
const DECISIONS: usize = 2;

type Block = NumberedBlock<f32>;
type RecordEvent = commission::RecordEvent<f32>;
type Decision = commission::Decision<f32>;

/// Everything between the two halves of a drive.
#[derive(Debug)]
pub struct Channel {
    orders: Queue<Stamped, ORDERS>,
    events: Queue<Event, EVENTS>,
    blocks: Queue<Block, BLOCKS>,
    fits: Queue<Fitted, FITS>,
    record_events: Queue<RecordEvent, RECORD_EVENTS>,
    decisions: Queue<Decision, DECISIONS>,
    signals: Signals,
}

/// An order, and the number of stops before it: one that a stop overtook is void.
#[derive(Debug)]
struct Stamped {
    stops: u32,
    order: Order,
}

/// Counters that the background raises and the interrupt reads: nothing can fill them.
#[derive(Debug)]
struct Signals {
    /// Raised with every order, stop, change of mode and frame of the host: while it stands still, there is nothing to
    /// obey.
    requests: AtomicU32,
    stops: AtomicU32,
    mode_changes: AtomicU32,
    host_heard: AtomicU32,
    background_turns: AtomicU32,
    /// No counter: samples for which the background may not run while the servo is disabled.
    disabled_patience: AtomicU32,
}

/// The background's end of a [`Channel`].
pub struct BackgroundEnd<'a> {
    orders: Producer<'a, Stamped, ORDERS>,
    events: Consumer<'a, Event, EVENTS>,
    blocks: Consumer<'a, Block, BLOCKS>,
    fits: Producer<'a, Fitted, FITS>,
    record_events: Consumer<'a, RecordEvent, RECORD_EVENTS>,
    decisions: Producer<'a, Decision, DECISIONS>,
    signals: &'a Signals,
}

/// The interrupt's end of a [`Channel`].
pub struct InterruptEnd<'a> {
    orders: Consumer<'a, Stamped, ORDERS>,
    events: Producer<'a, Event, EVENTS>,
    blocks: Producer<'a, Block, BLOCKS>,
    fits: Consumer<'a, Fitted, FITS>,
    record_events: Producer<'a, RecordEvent, RECORD_EVENTS>,
    decisions: Consumer<'a, Decision, DECISIONS>,
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
            record_events: Queue::new(),
            decisions: Queue::new(),
            signals: Signals {
                requests: AtomicU32::new(0),
                stops: AtomicU32::new(0),
                mode_changes: AtomicU32::new(0),
                host_heard: AtomicU32::new(0),
                background_turns: AtomicU32::new(0),
                disabled_patience: AtomicU32::new(1),
            },
        }
    }

    /// Both ends.
    pub fn split(&mut self) -> (BackgroundEnd<'_>, InterruptEnd<'_>) {
        let (orders_in, orders_out) = self.orders.split();
        let (events_in, events_out) = self.events.split();
        let (blocks_in, blocks_out) = self.blocks.split();
        let (fits_in, fits_out) = self.fits.split();
        let (record_events_in, record_events_out) = self.record_events.split();
        let (decisions_in, decisions_out) = self.decisions.split();
        let signals = &self.signals;
        let background = BackgroundEnd {
            orders: orders_in,
            events: events_out,
            blocks: blocks_out,
            fits: fits_in,
            record_events: record_events_out,
            decisions: decisions_in,
            signals,
        };
        let interrupt = InterruptEnd {
            orders: orders_out,
            events: events_in,
            blocks: blocks_in,
            fits: fits_out,
            record_events: record_events_in,
            decisions: decisions_out,
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

/// Raises a counter of one writer. Cores without an atomic addition have this too.
fn raise(counter: &AtomicU32) {
    let next = counter.load(Ordering::Relaxed).wrapping_add(1);
    counter.store(next, Ordering::Release);
}

impl BackgroundEnd<'_> {
    /// Gives an order, or returns it if the interrupt has not done the ones before it.
    pub(crate) fn order(&mut self, order: Order) -> Result<(), Order> {
        let stops = self.stops();
        let given = self
            .orders
            .enqueue(Stamped { stops, order })
            .map_err(|back| back.order);
        raise(&self.signals.requests);
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

    /// Hands a fit over, or returns it.
    pub(crate) fn fitted(&mut self, fitted: Fitted) -> Result<(), Fitted> {
        self.fits.enqueue(fitted)
    }

    /// The next event of a commissioning's record.
    pub(crate) fn record_event(&mut self) -> Option<RecordEvent> {
        self.record_events.dequeue()
    }

    /// Hands a decision of its solver over; false if it finds no room.
    pub(crate) fn decide(&mut self, decision: &Decision) -> bool {
        self.decisions.enqueue(*decision).is_ok()
    }

    /// Ends a commissioning for another mode.
    pub(crate) fn change_mode(&self) {
        raise(&self.signals.mode_changes);
        raise(&self.signals.requests);
    }

    /// Stops every mode and makes void every order that was not done yet.
    pub(crate) fn stop(&self) {
        raise(&self.signals.stops);
        raise(&self.signals.requests);
    }

    /// The number of stops so far.
    pub(crate) fn stops(&self) -> u32 {
        self.signals.stops.load(Ordering::Relaxed)
    }

    /// A host of the same protocol was heard on the line.
    pub(crate) fn host_heard(&self) {
        raise(&self.signals.host_heard);
        raise(&self.signals.requests);
    }

    /// Sets the samples for which the background may not run while the servo is disabled.
    pub(crate) fn set_disabled_patience(&self, samples: u32) {
        let place = &self.signals.disabled_patience;
        place.store(samples, Ordering::Relaxed);
    }

    /// Counts a turn of the background.
    pub(crate) fn count_turn(&self) {
        raise(&self.signals.background_turns);
    }
}

impl InterruptEnd<'_> {
    /// The number of requests of any kind so far.
    #[inline]
    pub(crate) fn requests(&self) -> u32 {
        self.signals.requests.load(Ordering::Acquire)
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

    /// Reports an event, or returns one that finds no room.
    #[inline]
    pub(crate) fn report(&mut self, event: Event) -> Result<(), Event> {
        self.events.enqueue(event)
    }

    /// Hands on a block of a record. One that finds no room is lost, which the fit detects.
    #[inline]
    pub(crate) fn block(&mut self, block: Block) {
        let _ = self.blocks.enqueue(block);
    }

    /// Hands an event of a commissioning's record over; false if it finds no room.
    #[inline]
    pub(crate) fn record_event(&mut self, event: RecordEvent) -> bool {
        self.record_events.enqueue(event).is_ok()
    }

    /// A decision of the commissioning's solver.
    #[inline]
    pub(crate) fn decision(&mut self) -> Option<Decision> {
        self.decisions.dequeue()
    }

    /// A fit to resume from.
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

    pub(crate) fn times_host_heard(&self) -> u32 {
        self.signals.host_heard.load(Ordering::Relaxed)
    }

    pub(crate) fn disabled_patience(&self) -> u32 {
        self.signals.disabled_patience.load(Ordering::Relaxed)
    }

    #[inline]
    pub(crate) fn background_turns(&self) -> u32 {
        self.signals.background_turns.load(Ordering::Relaxed)
    }
}
