//! Queues and counters between the two halves and the line. Orders go one way, events the other, with the record of a
//! motion and the background's results from it. Counters are for everything that must never wait for room.

use core::fmt;
use core::sync::atomic::{AtomicU32, Ordering};

use commissioning::{Decision, RecordEvent};
use drive_link::InterruptCycles;
use heapless::spsc::{Consumer, Producer, Queue};

use crate::built::Part;
use crate::closed_loop::{Learning, MotionPart};
use crate::messages::{Event, Order};

/// Orders and events that may be pending at once, and one more. They are powers of two, so that a queue masks and does
/// not divide.
const ORDERS: usize = 4;
const EVENTS: usize = 8;

/// Pieces of a record that may be pending, and one more. A block of a run is some 16 ms long.
const RECORD: usize = 16;

/// Solutions on their way back, and one more.
const SOLUTIONS: usize = 2;

/// A piece of the record of a motion.
#[derive(Debug)]
pub(crate) enum Recorded {
    /// A part of the motion of a run.
    Motion(MotionPart),
    /// An event of a commissioning's record.
    Event(RecordEvent<f32>),
}

/// A result of the background's work on a record.
#[derive(Debug, Clone, Copy)]
#[cfg_attr(
    feature = "commissioning",
    expect(
        clippy::large_enum_variant,
        reason = "one is on its way at a time, and there is no heap to put it on"
    )
)]
pub(crate) enum Solution {
    /// What a run's estimator continues from.
    Run(Learning),
    /// A decision of a commissioning's solver.
    Decision(Part<Decision<f32>>),
}

/// Everything between the two halves of a drive and its line.
#[derive(Debug)]
pub struct Channel {
    orders: Queue<Stamped, ORDERS>,
    events: Queue<Event, EVENTS>,
    record: Queue<Recorded, RECORD>,
    solutions: Queue<Solution, SOLUTIONS>,
    signals: Signals,
}

/// An order, and the number of stops before it: one that a stop has overtaken is void.
#[derive(Debug)]
struct Stamped {
    stops: u32,
    order: Order,
}

/// Counters of one writer each, which the other two read: nothing can fill them.
#[derive(Debug)]
struct Signals {
    /// Stops in the bytes of the line, and disturbances of it. The line's interrupt raises them.
    stops_heard: AtomicU32,
    stops_resent: AtomicU32,
    disturbances: AtomicU32,
    /// Raised with every order, stop of its own and change of mode. The background raises it and those below.
    requests: AtomicU32,
    own_stops: AtomicU32,
    mode_changes: AtomicU32,
    host_frames: AtomicU32,
    background_turns: AtomicU32,
    /// Samples that ended too late since the start. The interrupt raises it and sets the next one.
    overruns: AtomicU32,
    /// No counters: cycles of the last interrupt, and of the longest since the start. The interrupt sets them.
    cycles: AtomicU32,
    longest: AtomicU32,
    /// No counters: the count of the last sample, and that where a run has started or would start; samples for which the axis has stood while it was disabled, and the
    /// counts that it has coasted in a [window](crate::ending::Coasting).
    count: AtomicU32,
    started_at: AtomicU32,
    standstill: AtomicU32,
    coasted: AtomicU32,
    /// No counter: samples for which the background may not run while the servo is disabled.
    disabled_patience: AtomicU32,
    /// No counter: samples over which the motion of the disabled axis is seen.
    coasting_window: AtomicU32,
}

/// The background's end of a [`Channel`].
pub struct BackgroundEnd<'a> {
    orders: Producer<'a, Stamped, ORDERS>,
    events: Consumer<'a, Event, EVENTS>,
    record: Consumer<'a, Recorded, RECORD>,
    solutions: Producer<'a, Solution, SOLUTIONS>,
    signals: &'a Signals,
    /// The part of what was heard on the line that lies before the request in hand.
    decoded: Heard,
}

/// The interrupt's end of a [`Channel`].
pub struct InterruptEnd<'a> {
    orders: Consumer<'a, Stamped, ORDERS>,
    events: Producer<'a, Event, EVENTS>,
    record: Producer<'a, Recorded, RECORD>,
    solutions: Consumer<'a, Solution, SOLUTIONS>,
    signals: &'a Signals,
}

/// The line's end of a [`Channel`].
#[derive(Debug)]
pub struct LineEnd<'a> {
    signals: &'a Signals,
}

/// Counts of events in the bytes of the line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Heard {
    stops: u32,
    disturbances: u32,
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
            record: Queue::new(),
            solutions: Queue::new(),
            signals: Signals {
                stops_heard: AtomicU32::new(0),
                stops_resent: AtomicU32::new(0),
                disturbances: AtomicU32::new(0),
                requests: AtomicU32::new(0),
                own_stops: AtomicU32::new(0),
                mode_changes: AtomicU32::new(0),
                host_frames: AtomicU32::new(0),
                background_turns: AtomicU32::new(0),
                overruns: AtomicU32::new(0),
                cycles: AtomicU32::new(0),
                longest: AtomicU32::new(0),
                count: AtomicU32::new(0),
                started_at: AtomicU32::new(0),
                standstill: AtomicU32::new(0),
                coasted: AtomicU32::new(0),
                disabled_patience: AtomicU32::new(1),
                coasting_window: AtomicU32::new(1),
            },
        }
    }

    /// The ends of the background, of the sample interrupt and of the line.
    pub fn split(&mut self) -> (BackgroundEnd<'_>, InterruptEnd<'_>, LineEnd<'_>) {
        let (orders_in, orders_out) = self.orders.split();
        let (events_in, events_out) = self.events.split();
        let (record_in, record_out) = self.record.split();
        let (solutions_in, solutions_out) = self.solutions.split();
        let signals = &self.signals;
        let background = BackgroundEnd {
            orders: orders_in,
            events: events_out,
            record: record_out,
            solutions: solutions_in,
            signals,
            decoded: signals.heard(),
        };
        let interrupt = InterruptEnd {
            orders: orders_out,
            events: events_in,
            record: record_in,
            solutions: solutions_out,
            signals,
        };
        (background, interrupt, LineEnd { signals })
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

impl Signals {
    fn heard(&self) -> Heard {
        Heard {
            stops: self.stops_heard.load(Ordering::Acquire),
            disturbances: self.disturbances.load(Ordering::Acquire),
        }
    }

    /// Stops of the line and of the background.
    fn stops(&self) -> u32 {
        let own = self.own_stops.load(Ordering::Acquire);
        own.wrapping_add(self.stops_heard.load(Ordering::Acquire))
    }
}

impl LineEnd<'_> {
    /// Stops every mode and makes void every order that was not done yet.
    pub(crate) fn stop(&self, is_resent: bool) {
        if is_resent {
            raise(&self.signals.stops_resent);
        }
        raise(&self.signals.stops_heard);
    }

    /// Counts a disturbance: bytes were lost, which may have been a stop.
    pub(crate) fn count_disturbance(&self) {
        raise(&self.signals.disturbances);
    }
}

impl BackgroundEnd<'_> {
    /// Gives an order, or returns it if the interrupt has not done the ones before it.
    #[allow(
        clippy::result_large_err,
        reason = "an order that finds no room is given again"
    )]
    pub(crate) fn order(&mut self, order: Order) -> Result<(), Order> {
        let own = self.signals.own_stops.load(Ordering::Relaxed);
        let stops = own.wrapping_add(self.decoded.stops);
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

    /// The next piece of a record.
    pub(crate) fn recorded(&mut self) -> Option<Recorded> {
        self.record.dequeue()
    }

    /// Drops what is left of the record of a mode before.
    pub(crate) fn discard_record(&mut self) {
        while self.recorded().is_some() {}
    }

    /// Hands a solution over; false if it finds no room.
    pub(crate) fn hand_over(&mut self, solution: &Solution) -> bool {
        self.solutions.enqueue(*solution).is_ok()
    }

    /// Ends a commissioning for another mode.
    pub(crate) fn change_mode(&self) {
        raise(&self.signals.mode_changes);
        raise(&self.signals.requests);
    }

    /// Stops every mode and makes void every order that was not done yet.
    pub(crate) fn stop(&self) {
        raise(&self.signals.own_stops);
        raise(&self.signals.requests);
    }

    /// The number of stops so far.
    pub(crate) fn stops(&self) -> u32 {
        self.signals.stops()
    }

    /// All that was heard on the line so far.
    pub(crate) fn heard(&self) -> Heard {
        self.signals.heard()
    }

    /// Takes in that every byte was decoded in which this was heard.
    pub(crate) fn set_decoded(&mut self, heard: Heard) {
        self.decoded = heard;
    }

    /// Takes in that a stop was decoded: false if the line has not heard it.
    pub(crate) fn decode_stop(&mut self) -> bool {
        let is_heard = self.is_overtaken();
        if is_heard {
            self.decoded.stops = self.decoded.stops.wrapping_add(1);
        }
        is_heard
    }

    /// True if a stop has come after the request in hand.
    pub(crate) fn is_overtaken(&self) -> bool {
        self.heard().stops != self.decoded.stops
    }

    /// True if the line was disturbed around the request in hand or after it.
    pub(crate) fn is_uncertain(&self) -> bool {
        self.heard().disturbances != self.decoded.disturbances
    }

    /// The number of disturbances so far.
    pub(crate) fn disturbances(&self) -> u32 {
        self.heard().disturbances
    }

    /// Counts a frame of the host that drives.
    pub(crate) fn count_host_frame(&self) {
        raise(&self.signals.host_frames);
    }

    /// The samples that ended too late since the start.
    pub(crate) fn overruns(&self) -> u32 {
        self.signals.overruns.load(Ordering::Relaxed)
    }

    /// Cycles of the interrupts since the start; none where no counter runs.
    pub(crate) fn interrupt_cycles(&self) -> Option<InterruptCycles> {
        let [last, longest] =
            [&self.signals.cycles, &self.signals.longest].map(|of| of.load(Ordering::Relaxed));
        (longest > 0).then_some(InterruptCycles { last, longest })
    }

    /// The count of the last sample.
    pub(crate) fn count(&self) -> i32 {
        self.signals.count.load(Ordering::Relaxed).cast_signed()
    }

    /// The count at which the last run has started, or would start now.
    pub(crate) fn started_at(&self) -> i32 {
        let started_at = self.signals.started_at.load(Ordering::Relaxed);
        started_at.cast_signed()
    }

    /// The counts that the disabled axis has coasted in a window.
    pub(crate) fn coasted(&self) -> u32 {
        self.signals.coasted.load(Ordering::Relaxed)
    }

    /// The samples for which the axis has stood while it was disabled.
    pub(crate) fn standstill(&self) -> u32 {
        self.signals.standstill.load(Ordering::Relaxed)
    }

    /// Sets the samples for which the background may not run while the servo is disabled, and those over which its motion is
    /// seen then.
    pub(crate) fn set_disabled_times(&self, patience: u32, coasting_window: u32) {
        let signals = &self.signals;
        signals.disabled_patience.store(patience, Ordering::Relaxed);
        signals
            .coasting_window
            .store(coasting_window, Ordering::Relaxed);
    }

    /// Counts a turn of the background.
    pub(crate) fn count_turn(&self) {
        raise(&self.signals.background_turns);
    }
}

impl InterruptEnd<'_> {
    /// The number of requests of any kind so far. While it is constant, there is nothing to obey.
    #[inline]
    pub(crate) fn requests(&self) -> u32 {
        let requests = self.signals.requests.load(Ordering::Acquire);
        requests.wrapping_add(self.signals.stops_heard.load(Ordering::Acquire))
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

    /// Hands on a piece of a record; false if it finds no room, and is lost.
    #[inline]
    pub(crate) fn record(&mut self, piece: Recorded) -> bool {
        self.record.enqueue(piece).is_ok()
    }

    /// A solution to continue from, in its place: it is too large to be copied in a sample.
    #[inline]
    pub(crate) fn solution(&self) -> Option<&Solution> {
        self.solutions.peek()
    }

    /// Frees the place of the solution; false if there is none.
    #[inline]
    pub(crate) fn drop_solution(&mut self) -> bool {
        self.solutions.dequeue().is_some()
    }

    /// Sets the samples for which the disabled axis has stood, and the counts that it has coasted.
    pub(crate) fn set_standstill(&self, samples: u32, coasted: u32) {
        self.signals.standstill.store(samples, Ordering::Relaxed);
        self.signals.coasted.store(coasted, Ordering::Relaxed);
    }

    /// Sets the count of the disabled axis, where a run would start.
    pub(crate) fn set_start(&self, count: i32) {
        self.set_count(count);
        let place = &self.signals.started_at;
        place.store(count.cast_unsigned(), Ordering::Relaxed);
    }

    /// Sets the count of a sample.
    #[inline]
    fn set_count(&self, count: i32) {
        let place = &self.signals.count;
        place.store(count.cast_unsigned(), Ordering::Relaxed);
    }

    /// Counts late samples from zero, and looks for the longest interrupt anew.
    pub(crate) fn start_overruns(&self) {
        self.signals.overruns.store(0, Ordering::Relaxed);
        self.signals.longest.store(0, Ordering::Relaxed);
    }

    /// Sets the cycles of an interrupt.
    #[inline]
    pub(crate) fn set_cycles(&self, taken: u32) {
        self.signals.cycles.store(taken, Ordering::Relaxed);
        if taken > self.signals.longest.load(Ordering::Relaxed) {
            self.signals.longest.store(taken, Ordering::Relaxed);
        }
    }

    /// Ends a sample that drove the servo at this count: counts it if it ended too late.
    #[inline]
    pub(crate) fn end_sample(&self, late: bool, count: i32) -> bool {
        self.set_count(count);
        if late {
            raise(&self.signals.overruns);
        }
        late
    }

    pub(crate) fn stops(&self) -> u32 {
        self.signals.stops()
    }

    /// The same without those that were sent again.
    pub(crate) fn new_stops(&self) -> u32 {
        let resent = self.signals.stops_resent.load(Ordering::Acquire);
        self.stops().wrapping_sub(resent)
    }

    pub(crate) fn mode_changes(&self) -> u32 {
        self.signals.mode_changes.load(Ordering::Relaxed)
    }

    pub(crate) fn host_frames(&self) -> u32 {
        self.signals.host_frames.load(Ordering::Relaxed)
    }

    pub(crate) fn disabled_patience(&self) -> u32 {
        self.signals.disabled_patience.load(Ordering::Relaxed)
    }

    pub(crate) fn coasting_window(&self) -> u32 {
        self.signals.coasting_window.load(Ordering::Relaxed)
    }

    #[inline]
    pub(crate) fn background_turns(&self) -> u32 {
        self.signals.background_turns.load(Ordering::Relaxed)
    }
}
