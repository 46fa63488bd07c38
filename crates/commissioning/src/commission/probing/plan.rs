use super::super::CommissionSettings;
use super::super::noise::{EDGE_COUNTS, QUANTISATION_SIGMA};
use super::CommandRamp;
use identifier_core::number::Number;

/// Commands that may be under way.
pub(super) const COMMANDS: usize = 16;

/// The plan before anything moves, counts and samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Plan<N> {
    /// The travel that is allowed, and counts that rounding adds.
    pub(super) travel: [N; 2],
    pub(super) command: [N; 2],
    /// The part of it that is used, to either side.
    pub(super) half_room: N,
    pub(super) usable_speed: N,
    /// Delay from a decision to its latest effect.
    pub(super) horizon: N,
    /// Samples by which a command is thought to be delayed.
    pub(super) delay: usize,
    /// The travel by which the first motion is noticed.
    pub(super) noticed: N,
    /// A travel at which it is noticed at once.
    pub(super) much: N,
    pub(super) ramp: CommandRamp<N>,
    /// The reciprocal of its growth.
    pub(super) per_growth: N,
    /// The least b of a servo whose break-away command is measurable. Such a servo passes a count, q = b u̇ t³/6,
    /// before the steepest command has grown by much.
    pub(super) timed_gain: N,
    /// The square of half a half-cycle's time, over two: amplitude over acceleration.
    pub(super) half_cycle: N,
    /// Speed over acceleration for such a half-cycle.
    pub(super) half_cycle_speed: N,
    /// The shortest informative half-cycle, counts.
    pub(super) least_half_cycle: N,
    /// Samples without an edge after which a servo that should be slow is at standstill.
    pub(super) standing: u32,
    /// Samples.
    pub(super) longest: u32,
    /// Samples within which a motion that is to end must be at rest.
    pub(super) settling: u32,
    pub(super) first_direction: N,
    /// Samples for which a servo that holds must not move to be at rest.
    pub(super) quiet: u32,
    /// Stiffness and damping with which it is held, per sample² and per sample.
    pub(super) hold: [N; 2],
    /// Samples between two turns of an oscillation as fast as the holding loop.
    pub(super) hold_half_cycle: u32,
    /// Speed, counts a sample, and bandwidth, ω T, that separate the relay's half-cycles from unplanned ones. The
    /// latter are faster and shorter.
    pub(super) ringing: [N; 2],
    /// Viscous friction that is usual, 1/sample.
    pub(super) usual_viscous: N,
    /// Error of the rough model, counts.
    pub(super) off: N,
    /// Samples after which braking should show.
    pub(super) reaction: u32,
    /// Samples for which a disabled servo must be at standstill.
    pub(super) released: u32,
    /// Samples within which a ramp does not catch a fall if it must be noticed first.
    pub(super) soon: N,
}

impl<N: Number> Plan<N> {
    /// The part of travel and speed that is planned with.
    const USED_TRAVEL: f64 = 0.8;
    const USED_SPEED: f64 = 0.75;

    /// Samples by which a command may be later than known.
    const UNKNOWN_DELAY: f64 = 2.0;

    /// The shortest half-cycle of the relay, in known delays. Also the phase, rad, that the known delay costs the
    /// holding loop.
    const HALF_CYCLE_DELAYS: f64 = 4.0;
    const HOLD_PHASE: f64 = 0.4;

    /// Parts of the planned speed and of the shortest half-cycle. A half-cycle above the first and within the second is
    /// not the relay's.
    const RINGING: [f64; 2] = [0.1, 0.5];

    /// The part of the command that may grow from a break-away to the count that shows it.
    const TIMED: f64 = 0.2;

    /// Time for which a disabled servo must be at standstill, s.
    const RELEASED: f64 = 0.02;

    /// The time that a ramp takes to catch a servo, s, and samples.
    const SOON: (f64, f64) = (0.06, 32.0);

    /// A first motion is noticed after this part of the room, one in so many, and after the fewest to the most counts.
    const NOTICED: (f64, f64, f64) = (12.0, 3.0, 20.0);

    /// The error of the rough model beside the rounding, a part of the room.
    const OFF: f64 = 0.003;

    /// The time within which a motion that is to end must be at rest, s.
    const SETTLING: f64 = 1.0;

    pub(super) fn new(settings: &CommissionSettings) -> Self {
        let time = settings.sample_time;
        let counts = 1.0 / settings.resolution;
        let limits = &settings.limits;
        let known_delay = settings.command_delay / time;
        let travel = limits.travel.map(|end| end * counts);
        // The present position is the middle of the half-cycles.
        let room = travel[1].min(-travel[0]);
        let (part, fewest, most_noticed) = Self::NOTICED;
        let share = room / part;
        let noticed = libm::floor(share).clamp(fewest, most_noticed);
        let most = limits.command[1].min(-limits.command[0]);
        let number = N::from_f64;
        let samples = |seconds: f64| libm::ceil(seconds / time);
        let half_of_cycle = 0.042_f64
            .max(16.0 * time)
            .max(Self::HALF_CYCLE_DELAYS * settings.command_delay);
        // The steepest of a push that does not move the servo.
        let pushed = 2.0 * CommandRamp::<N>::STEEPEST * time * most;
        let usable_speed = Self::USED_SPEED * limits.speed * time * counts;
        let [ringing_speed, ringing_time] = Self::RINGING;
        let bandwidth = 60.0_f64.min(0.1 / time);
        let stiffness = match settings.command_delay {
            0.0 => bandwidth,
            delay => bandwidth.min(Self::HOLD_PHASE / delay),
        } * time;
        Self {
            // At an edge of the encoder a servo at standstill may show a count.
            travel: [
                number(travel[0] - EDGE_COUNTS),
                number(travel[1] + EDGE_COUNTS),
            ],
            command: limits.command.map(number),
            half_room: number(room * Self::USED_TRAVEL),
            usable_speed: number(usable_speed),
            horizon: number(1.0 + known_delay + Self::UNKNOWN_DELAY),
            delay: (libm::round(known_delay + 0.5 * Self::UNKNOWN_DELAY) as usize)
                .min(COMMANDS - 2),
            noticed: number(noticed),
            much: number(share.max(fewest)),
            ramp: CommandRamp::new(most, time),
            per_growth: number(1.0 / CommandRamp::<N>::growth(time)),
            timed_gain: number(6.0 * pushed * pushed / libm::pow(Self::TIMED * most, 3.0)),
            half_cycle: number(half_of_cycle * half_of_cycle / (8.0 * time * time)),
            half_cycle_speed: number(half_of_cycle / (2.0 * time)),
            least_half_cycle: number(40.0),
            standing: samples(0.005).max(3.0) as u32,
            longest: samples(limits.duration) as u32,
            settling: samples(Self::SETTLING) as u32,
            first_direction: number(if travel[1] >= -travel[0] { 1.0 } else { -1.0 }),
            quiet: samples(0.004).max(4.0) as u32,
            usual_viscous: number(20.0 * time),
            off: number(QUANTISATION_SIGMA + Self::OFF * room),
            reaction: (libm::ceil(known_delay + Self::UNKNOWN_DELAY) + samples(0.001)) as u32,
            released: (Self::RELEASED / time) as u32,
            soon: number((Self::SOON.0 / time).max(Self::SOON.1)),
            hold: [number(stiffness * stiffness), number(2.0 * stiffness)],
            hold_half_cycle: (core::f64::consts::PI / stiffness) as u32,
            ringing: [
                number(ringing_speed * usable_speed),
                number(core::f64::consts::PI * time / (ringing_time * half_of_cycle)),
            ],
        }
    }
}
