//! Every key of a scenario file: a line each, in the order in which they are read.
//!
//! A line says where the key stands, what it holds and where that goes in the [`Scenario`], what is
//! the case when it is absent, its unit, and what it is. Reading, messages, help and schema all
//! follow from it.

use identifier_core::ControllerSettings;
use identifier_core::control::Gains;
use identifier_core::error::Allowed;
use identifier_core::excitation::Tone;
use identifier_core::parameters::{Parameter, ServoParameters};
use identifier_core::settings::{BoxSettings, IdentifierSettings, RangeSettings};
use identifier_core::units::Units;
use virtual_servo::faults::{FaultKind, Faults, InjectedFault};
use virtual_servo::{Effects, SensorEffects};

use super::ExcitationSettings::{
    BandLimitedWhiteNoise, Chirp, Multisine, None as Still, Prbs, Square, Steps,
};
use super::key::Absent::{Begins, First, Follows, Is, Required};
use super::key::Holds::{
    Choice as OneOf, Column as ColumnOf, Flag, Limit, Matrix, Number, Numbers, Pair, Pairs,
    Parameters, Reach, Table, Tables, Terms as TermList, Two, Whole,
};
use super::key::Range::{
    BelowNyquist, EvenSamples, Fixed, HalfRadian, Lasting, Late, OfFault, Samples,
};
use super::key::When::{Always, InRun, Simulated, Stated};
use super::key::{Choice, Entries, Key, Range};
use super::{
    Arithmetic, Baseline, BaselineSettings, Column, CommissionOrder, ExcitationSettings, Law,
    LogSettings, PositionUnit, Scenario, TimeUnit, Velocity, parts,
};

/// Sines that a multisine and levels that a staircase may have.
pub(crate) const MOST_ENTRIES: usize = 16;

/// Ranges of time that may be left out of a log.
pub(crate) const MOST_RANGES: usize = 100;

/// The most columns of a log.
pub(crate) const MOST_COLUMNS: u32 = 1000;

/// The paper's cut-off of the velocity filter, rad/s.
const CUTOFF: f64 = 500.0;

const ANY: Range = Fixed(Allowed::Finite);
/// No servo accelerates by more, rad/s² for a unit of command or by itself, or brakes faster, 1/s.
const FASTEST: f64 = 1e12;
const COUNTS: Range = Fixed(Allowed::Within(0.0, 1e9));
const POSITIVE: Range = Fixed(Allowed::Above(0.0));
const NOT_NEGATIVE: Range = Fixed(Allowed::AtLeast(0.0));
const GAIN: Range = Fixed(Allowed::Within(0.0, Gains::LARGEST));
const POSITIVE_GAIN: Range = Fixed(Allowed::PositiveUpTo(Gains::LARGEST));
const SAMPLE_TIME: Range = Fixed(Allowed::Within(
    Units::SAMPLE_TIMES.0,
    Units::SAMPLE_TIMES.1,
));
const ANGULAR: Range = Fixed(Allowed::Within(
    -Effects::LARGEST_ACCELERATION,
    Effects::LARGEST_ACCELERATION,
));
const DRIFT: Range = Fixed(Allowed::Within(
    -Effects::FASTEST_DRIFT,
    Effects::FASTEST_DRIFT,
));
const ABOVE_ONE: Range = Fixed(Allowed::Above(1.0));
const SENSOR_ERROR: Range = Fixed(Allowed::Within(0.0, SensorEffects::LARGEST));
const TYPICAL: BaselineSettings = BaselineSettings::TYPICAL;

macro_rules! keys {
    ($($path:literal: $holds:expr, $absent:expr, $unit:literal, $about:literal;)*) => {
        /// All keys, in the order in which they are read.
        pub static KEYS: &[Key] = &[$(Key {
            path: $path, holds: $holds, absent: $absent, unit: $unit, about: $about,
        }),*];
    };
}

keys! {
"plant": Table(Stated), Follows("required for a run; where it is stated and [log] is not, a log to replay is that of a run of this scenario"), "",
    "the true servo, q'' = -a q' + b u + load - coulomb sign q', with q the position in rad and u the command";
"plant.a": Number(Fixed(Allowed::Within(0.0, FASTEST)), |s, v| plant(s).a = v), Required("0.5"), "1/s",
    "viscous friction over inertia: after a push the speed decays as exp(-a t)";
"plant.b": Number(Fixed(Allowed::PositiveUpTo(FASTEST)), |s, v| plant(s).b = v), Required("200.0"), "rad/s² per command unit",
    "acceleration for one unit of command";
"plant.load": Number(Fixed(Allowed::Within(-FASTEST, FASTEST)), |s, v| plant(s).load = v), Is(0.0), "rad/s²",
    "acceleration by a constant load";
"plant.coulomb": Number(Fixed(Allowed::Within(0.0, FASTEST)), |s, v| plant(s).coulomb = v), Is(0.0), "rad/s²",
    "deceleration by Coulomb friction";
"plant.delay": Number(Late, |s, v| s.effects.delay = v), Is(0.0), "s",
    "time until a command acts, any fraction of a sample";
"plant.current_loop": Number(Fixed(Allowed::Within(0.0, Effects::SLOWEST_CURRENT_LOOP)), |s, v| s.effects.current_loop = v),
    Is(0.0), "s", "time constant of the first-order lag of the acting command; 0 or at least a thousandth of the sample time";
"plant.asymmetry": Number(ANY, |s, v| s.effects.asymmetry = v), Is(0.0), "1/s",
    "viscous friction is a + asymmetry forward and a - asymmetry backward; from -a to a";
"plant.low_speed_friction": Number(ANY, |s, v| s.effects.low_speed_friction = v), Is(0.0), "rad/s²",
    "what Coulomb friction has in addition at low speed, s exp(-(q'/low_speed_velocity)²); at least -coulomb";
"plant.low_speed_velocity": Number(POSITIVE, |s, v| s.effects.low_speed_velocity = v), Follows("none; required with low_speed_friction"), "rad/s",
    "the speed at which 37 % of it are left";
"plant.gravity": Two(ANGULAR, |s, v| s.effects.gravity = v), Follows("none"), "rad/s²",
    "[g_s, g_c]: acceleration by gravity, g_s sin q + g_c cos q, q being 0 where the servo starts";
"plant.ripple": Two(ANGULAR, |s, v| s.effects.ripple = v), Follows("none"), "rad/s²",
    "[r_s, r_c]: acceleration by cogging, r_s sin Nq + r_c cos Nq";
"plant.ripple_order": Whole([1, Effects::HIGHEST_ORDER], |s, v| s.effects.ripple_order = v), Follows("none; required with ripple"), "",
    "its order N, periods per revolution";
"plant.dead_band": Number(NOT_NEGATIVE, |s, v| s.effects.dead_band = v), Is(0.0), "command units",
    "the part of the command, to either side, that the bridge lets pass without effect";
"plant.resonance": Number(Fixed(Allowed::PositiveUpTo(Effects::HIGHEST_RESONANCE)), |s, v| s.effects.resonance = v), Follows("none, one rigid body"), "rad/s",
    "resonance of motor and load on the spring between them, both free; encoder and friction are the motor's";
"plant.resonance_damping": Number(Fixed(Allowed::Within(0.0, 1.0)), |s, v| s.effects.resonance_damping = Some(v)), Follows("0.02 with resonance"), "",
    "its damping ratio";
"plant.inertia_ratio": Number(Fixed(Allowed::Within(Effects::INERTIA_RATIOS[0], Effects::INERTIA_RATIOS[1])), |s, v| s.effects.inertia_ratio = v), Follows("none; required with resonance"), "",
    "the load's share of the inertia";
"plant.backlash": Number(NOT_NEGATIVE, |s, v| s.effects.backlash = v), Is(0.0), "rad",
    "play between the motor and an encoder on the load";
"plant.gain_drift": Number(DRIFT, |s, v| s.effects.gain_drift = v), Is(0.0), "1/s",
    "change of b in a second, of its first value";
"plant.friction_drift": Number(DRIFT, |s, v| s.effects.friction_drift = v), Is(0.0), "1/s",
    "change of all friction in a second, of its first value";
"plant.hidden_limit": Number(POSITIVE, |s, v| s.effects.hidden_limit = v), Follows("none"), "command units",
    "where the amplifier clips although amplifier.limit does not say so";
"plant.load_wander": Two(NOT_NEGATIVE, |s, v| s.effects.load_wander = v), Follows("none"), "rad/s² and s",
    "[standard deviation, time constant] of a load that wanders in addition, seeded by run.seed";

"encoder": Table(Simulated), Follows("10000 counts; in a replay of another log, its own resolution"), "", "the position sensor";
"encoder.counts_per_rev": Number(COUNTS, |s, v| s.counts_per_rev = (v > 0.0).then_some(v)), Is(10_000.0), "",
    "counts of a revolution after fourfold evaluation; 0 is an ideal sensor, in a replay the log's own resolution";
"encoder.noise": Number(SENSOR_ERROR, |s, v| s.sensor.noise = v), Is(0.0), "rad",
    "standard deviation of white noise before counting, in a run, seeded by run.seed";
"encoder.eccentricity": Number(SENSOR_ERROR, |s, v| s.sensor.eccentricity = v), Is(0.0), "rad",
    "amplitude of an error once per turn, in a run";
"encoder.jitter": Number(Fixed(Allowed::Within(0.0, SensorEffects::LARGEST_JITTER)), |s, v| s.sensor.jitter = v), Is(0.0), "",
    "standard deviation of the sampling instant in a run, as a share of the sample time";

"amplifier": Table(Always), Follows("no limit"), "", "what drives the motor";
"amplifier.delay": Number(Fixed(Allowed::Within(0.0, 0.1)), |s, v| told(s).terms.delay = v), Is(0.0), "s",
    "delay from the command to the motor that is known: computation, amplifier and bus; the laws with a model take it into account, and the term delay begins there";
"amplifier.dead_band": Number(NOT_NEGATIVE, |s, v| told(s).terms.dead_band = v), Is(0.0), "command units",
    "command to either side that the bridge swallows, as far as it is known; the term dead-band begins there";
"amplifier.current_loop": Number(Fixed(Allowed::Within(0.0, 0.1)), |s, v| told(s).terms.current_loop = v), Is(0.0), "s",
    "time constant of the current loop, with which the motor's current follows the command, as far as it is known";
"amplifier.limit": Limit(|s, v| pid(s).limit = v), Follows("no limit"), "command units",
    "limit of the controller's command, |u| <= limit or low <= u <= high";

"controller": Table(InRun), Follows("the paper's; in a replay of another log, none"), "",
    "the PID that closes the loop, u = kp e - kd v + ki T times the sum of the earlier e";
"controller.kp": Number(POSITIVE_GAIN, |s, v| pid(s).kp = v), Is(9.0), "command units per rad",
    "proportional gain";
"controller.kd": Number(GAIN, |s, v| pid(s).kd = v), Is(0.19), "command units per rad/s",
    "derivative gain, on the measured velocity";
"controller.ki": Number(GAIN, |s, v| pid(s).ki = v), Is(4.0), "command units per rad s",
    "integral gain";
"controller.sample_time": Number(SAMPLE_TIME, |s, v| s.stated.sample_time = v), Is(1e-3), "s",
    "time from one control sample to the next; in a replay without a controller, the log's own";
"controller.velocity_filter": Table(Always), Follows("low-pass, 500 rad/s; in a replay without a controller, half the sample rate"), "",
    "how the velocity is taken from the counts, { kind = \"low-pass\", cutoff = 500.0 }";
"controller.velocity_filter.kind": OneOf(VELOCITIES), First, "", "kind of velocity estimate";
"controller.velocity_filter.cutoff": Number(BelowNyquist, |s, v| s.stated.cutoff = v), Is(CUTOFF), "rad/s",
    "cut-off of the low-pass";

"excitation": Table(Always), Follows("the paper's"), "", "the reference that the servo follows";
"excitation.kind": OneOf(EXCITATIONS), First, "", "kind of reference";
"excitation.power": Number(POSITIVE, |s, v| if let BandLimitedWhiteNoise { power, .. } = &mut s.excitation { *power = v }),
    Is(0.005), "rad² s", "power of the noise";
"excitation.sample_time": Number(Samples, |s, v| if let BandLimitedWhiteNoise { sample_time, .. } = &mut s.excitation { *sample_time = v }),
    Is(0.1), "s", "time for which a value of the noise is held";
"excitation.seed": Whole([0, u32::MAX], |s, v| if let BandLimitedWhiteNoise { seed, .. } = &mut s.excitation { *seed = v }),
    Is(1_212_121.0), "", "seed of the noise";
"excitation.amplitude": Number(POSITIVE, |s, v| if let Prbs { amplitude, .. } | Chirp { amplitude, .. } | Square { amplitude, .. } = &mut s.excitation { *amplitude = v }),
    Required("0.2"), "rad", "amplitude to either side";
"excitation.hold": Number(Samples, |s, v| if let Prbs { hold, .. } | Steps { hold, .. } = &mut s.excitation { *hold = v }),
    Required("0.1"), "s", "time for which a bit or a level is held";
"excitation.order": Whole([2, 24], |s, v| if let Prbs { order, .. } = &mut s.excitation { *order = v }),
    Is(9.0), "", "bits of the shift register";
"excitation.amplitudes": Numbers(POSITIVE, |s, v| { s.excitation = sines(v); Ok(()) }),
    Required("[0.1, 0.05]"), "rad", "amplitude of each sine";
"excitation.frequencies": Numbers(BelowNyquist, |s, v| tune(&mut s.excitation, &v)),
    Required("[6.0, 20.0]"), "rad/s", "frequency of each sine, as many as amplitudes";
"excitation.from": Number(BelowNyquist, |s, v| if let Chirp { from, .. } = &mut s.excitation { *from = v }),
    Required("2.0"), "rad/s", "frequency at the beginning";
"excitation.to": Number(BelowNyquist, |s, v| if let Chirp { to, .. } = &mut s.excitation { *to = v }),
    Required("40.0"), "rad/s", "frequency at the end";
"excitation.duration": Number(Samples, |s, v| if let Chirp { duration, .. } = &mut s.excitation { *duration = v }),
    Required("5.0"), "s", "time of a sweep, after which it begins again";
"excitation.period": Number(EvenSamples, |s, v| if let Square { period, .. } = &mut s.excitation { *period = v }),
    Required("1.0"), "s", "period of the square wave";
"excitation.levels": Numbers(ANY, |s, v| { if let Steps { levels, .. } = &mut s.excitation { *levels = v } Ok(()) }),
    Required("[0.2, -0.2]"), "rad", "levels, one after the other";

"identifier": Table(Always), Follows("the gradient law"), "", "what is identified, and how";
"identifier.law": OneOf(LAWS), First, "", "the method";
"identifier.parameters": Parameters(choose), Follows("[\"a\", \"b\"], or what the method finds"), "",
    "what is estimated; the others stay at their initial values";
"identifier.arithmetic": OneOf(ARITHMETICS), First, "",
    "number format of the loop; \"fixed\" is there for gradient and pd-gradient";
"identifier.gamma": Matrix(|s, v| weigh(s, &v)), Follows("automatic, from box and reference"), "",
    "how fast each estimate moves, the matrix of (11)";
"identifier.mu": Number(POSITIVE, |s, v| told(s).mu = Some(v)), Follows("automatic, from gains and box"), "1/s",
    "weight of the output error beside its derivative in (11)";
"identifier.initial": Table(Always), Follows("as below"), "", "where the estimates begin, inside bounds";
"identifier.initial.a": Number(ANY, |s, v| told(s).initial.a = Some(v)), Begins(0.0), "1/s", "first estimate of a";
"identifier.initial.b": Number(POSITIVE, |s, v| told(s).initial.b = Some(v)), Begins(50.0), "rad/s² per command unit",
    "first estimate of b; a law that fits needs one only where b is not among parameters";
"identifier.initial.coulomb": Number(ANY, |s, v| told(s).initial.coulomb = Some(v)), Begins(0.0), "rad/s²",
    "first estimate of the Coulomb friction";
"identifier.initial.load": Number(ANY, |s, v| told(s).initial.load = Some(v)), Begins(0.0), "rad/s²",
    "first estimate of the load";
"identifier.bounds": Table(Always), Follows("as below"), "", "where the estimates are kept";
"identifier.bounds.a": Pair(ANY, |s, v| told(s).bounds.a = Some(v)), Follows("as wide as the sample time bears"), "1/s",
    "bounds of a, both within 0.5/sample_time of 0";
"identifier.bounds.b": Pair(POSITIVE, |s, v| told(s).bounds.b = Some(v)),
    Follows("as wide as the sample time and the gains bear"), "rad/s² per command unit", "bounds of b";
"identifier.bounds.coulomb": Pair(NOT_NEGATIVE, |s, v| told(s).bounds.coulomb = Some(v)),
    Follows("from 0 to far beyond any servo; fixed, what plant_box and the command allow"), "rad/s²",
    "bounds of the Coulomb friction";
"identifier.bounds.load": Pair(ANY, |s, v| told(s).bounds.load = Some(v)),
    Follows("far beyond any servo to both sides; fixed, what plant_box and the command allow"), "rad/s²",
    "bounds of the load";
"identifier.plant_box": Table(Stated), Follows("none, and nothing is certified"), "",
    "where the true servo may lie: the loop is certified for all of it";
"identifier.plant_box.a": Pair(NOT_NEGATIVE, |s, v| within(s).a = v), Required("[0.0, 50.0]"), "1/s",
    "lowest and highest a of the servo";
"identifier.plant_box.b": Pair(POSITIVE, |s, v| within(s).b = v), Required("[110.0, 1000.0]"), "rad/s² per command unit",
    "lowest and highest b of the servo";
"identifier.correction": Table(Stated),
    Follows("the controller's gains, which make the model loop the paper's; without one, from plant_box and bandwidth"), "",
    "the gains that pull the model to the servo";
"identifier.correction.kp": Number(POSITIVE_GAIN, |s, v| correction(s)[0] = v), Required("9.0"), "command units per rad",
    "proportional gain of the correction";
"identifier.correction.kd": Number(GAIN, |s, v| correction(s)[1] = v), Required("0.19"), "command units per rad/s",
    "derivative gain of the correction";
"identifier.correction.ki": Number(GAIN, |s, v| correction(s)[2] = v), Required("4.0"), "command units per rad s",
    "integral gain of the correction";
"identifier.bandwidth": Number(HalfRadian, |s, v| told(s).bandwidth = Some(v)),
    Follows("from what the first fit finds; gradient laws, 0.05/sample_time"), "rad/s",
    "bandwidth of the position loop, right within a factor of four; gradient laws use it without controller and correction";
"identifier.max_speed": Number(POSITIVE, |s, v| told(s).max_speed = Some(v)),
    Follows("what the number format counts exactly in a sample"), "rad/s",
    "the fastest that the servo can move; a larger jump of the position ends the run";
"identifier.uncertainty": Table(Always), Follows("nothing is known"), "", "standard deviations of the initial estimates";
"identifier.uncertainty.a": Number(POSITIVE, |s, v| told(s).uncertainty.a = Some(v)), Follows("nothing is known"), "1/s",
    "standard deviation of initial.a";
"identifier.uncertainty.b": Number(POSITIVE, |s, v| told(s).uncertainty.b = Some(v)), Follows("nothing is known"),
    "rad/s² per command unit", "standard deviation of initial.b";
"identifier.uncertainty.coulomb": Number(POSITIVE, |s, v| told(s).uncertainty.coulomb = Some(v)), Follows("nothing is known"),
    "rad/s²", "standard deviation of initial.coulomb";
"identifier.uncertainty.load": Number(POSITIVE, |s, v| told(s).uncertainty.load = Some(v)), Follows("nothing is known"),
    "rad/s²", "standard deviation of initial.load";
"identifier.noise": Number(POSITIVE, |s, v| told(s).noise = Some(v)), Follows("an encoder count over the square root of 12"), "rad",
    "standard deviation of the position noise";
"identifier.start_time": Number(Fixed(Allowed::Within(1e-4, 1e4)), |s, v| told(s).start_time = Some(v)),
    Follows("1; in a replay, no more than the log has"), "s",
    "gauss-newton: the time over which the first fit looks; window: its length, for terms best 2 s";
"identifier.memory": Number(Fixed(Allowed::AtLeast(2.0)), |s, v| told(s).memory = Some(v)), Follows("all that ever was"), "s",
    "how long a sample counts, for a servo that changes";
"identifier.terms": TermList(|s, v| told(s).terms.allowed = v), Follows("none"), "",
    "optional terms of the model, each of which is estimated once there is evidence for it";
"identifier.required_terms": TermList(|s, v| told(s).terms.demanded = v), Follows("none"), "",
    "optional terms of the model that are estimated as soon as the motion allows";
"identifier.low_speed_velocity": Number(POSITIVE, |s, v| told(s).terms.low_speed_velocity = Some(v)),
    Follows("none; required with the term low-speed"), "rad/s", "speed at which the friction of low speeds has faded to 1/e";
"identifier.ripple_order": Number(POSITIVE, |s, v| told(s).terms.ripple_order = Some(v)),
    Follows("none; required with the term ripple"), "", "periods of the ripple to a revolution";
"identifier.revolution": Number(POSITIVE, |s, v| told(s).terms.revolution = v), Is(std::f64::consts::TAU), "rad",
    "travel after which gravity and ripple repeat, for a linear axis a pole pitch";
"identifier.ranges": Table(Stated), Follows("four times what the command limit lets the PID ask for"), "",
    "what the signals stay within in fixed point";
"identifier.ranges.error": Number(POSITIVE, |s, v| ranges(s).error = v), Required("1.0"), "rad", "largest position error";
"identifier.ranges.velocity": Number(POSITIVE, |s, v| ranges(s).velocity = v), Required("100.0"), "rad/s", "largest velocity";
"identifier.ranges.command": Number(POSITIVE, |s, v| ranges(s).command = v), Required("10.0"), "command units",
    "largest command, no smaller than the limit";
"identifier.relay": Number(POSITIVE, |s, v| rival(s, |own| own.relay = v)), Is(TYPICAL.relay), "command units",
    "command of the relay to either side";
"identifier.relay_delay": Number(Fixed(Allowed::Within(0.0, 10.0)), |s, v| rival(s, |own| own.relay_delay = v)),
    Is(TYPICAL.relay_delay), "s", "delay of the relay";
"identifier.forgetting": Number(Fixed(Allowed::PositiveUpTo(1.0)), |s, v| rival(s, |own| own.forgetting = v)),
    Follows("0.999 for relay-least-squares and multi-step-least-squares, 0.9999 for the others"), "", "forgetting factor of a sample";
"identifier.filter_cutoff": Number(BelowNyquist, |s, v| rival(s, |own| own.filter_cutoff = v)), Is(TYPICAL.filter_cutoff), "rad/s",
    "cut-off of the filters of position and command";
"identifier.proportional_gain": Number(POSITIVE, |s, v| rival(s, |own| own.proportional_gain = Some(v))),
    Follows("a twentieth of kp"), "command units per rad", "gain of the proportional loop";
"identifier.block": Number(POSITIVE, |s, v| rival(s, |own| own.block = v)), Is(TYPICAL.block), "s", "sample time of the model";

"run": Table(Always), Follows("60 s"), "", "the simulated experiment";
"run.duration": Number(Lasting, |s, v| s.duration = v), Is(60.0), "s",
    "length of the run";
"run.seed": Whole([0, u32::MAX], |s, v| s.seed = Some(v)), Follows("that of the reference, or 1"), "",
    "seed of what is random in servo and sensor; a sweep draws its own";

"fault": Tables(FAULTS), Follows("none"), "", "what goes wrong while the simulated servo runs, each in a table of its own";
"fault.kind": OneOf(FAULT_KINDS), Required("\"actuator-weak\""), "", "what goes wrong";
"fault.time": Number(NOT_NEGATIVE, |s, v| fault(s).time = v), Required("5.0"), "s", "when, from the first sample";
"fault.duration": Number(POSITIVE, |s, v| fault(s).duration = v), Follows("for good"), "s", "how long";
"fault.size": Number(OfFault, |s, v| fault(s).size = v), Required("0.5"), "",
    "how large: the counts of a jump, the share of the command that still acts, the load, the friction that is added";

"compare": Table(Always), Follows("as below"), "", "what the cases of a comparison are made of";
"compare.load": Number(ANY, |s, v| s.compare.load = Some(v)), Follows("0.08 of plant.b"), "rad/s²", "the load";
"compare.coulomb": Number(NOT_NEGATIVE, |s, v| s.compare.coulomb = Some(v)), Follows("0.04 of plant.b"), "rad/s²", "the friction";
"compare.counts_per_rev": Number(POSITIVE, |s, v| s.compare.counts_per_rev = v), Is(2000.0), "", "the coarse encoder";
"compare.limit": Number(POSITIVE, |s, v| s.compare.limit = Some(v)), Follows("a ninth of kp"), "command units",
    "the amplifier that saturates";

"commission": Table(Stated), Follows("required for a commissioning"), "",
    "what a commissioning may do with the axis, and what it is asked for";
"commission.travel": Reach(|s, v| order(s).travel = v), Required("0.5"), "rad",
    "how far the servo may go from where it stands";
"commission.speed": Number(POSITIVE, |s, v| order(s).speed = v), Required("20.0"), "rad/s", "the largest speed";
"commission.command": Limit(|s, v| order(s).command = Some(v)), Follows("amplifier.limit; required without it"), "command units",
    "the largest command, at most amplifier.limit";
"commission.duration": Number(POSITIVE, |s, v| order(s).duration = v), Is(CommissionOrder::DURATION), "s",
    "the longest time that a motion may take";
"commission.one_way": Flag(|s, v| order(s).one_way = v), Follows("false"), "",
    "whether the servo may only move one way, the one in which there is travel";
"commission.response_time": Number(POSITIVE, |s, v| order(s).response_time = Some(v)), Follows("none"), "s",
    "goal: the time from 10 to 90 % of a step of the reference";
"commission.bandwidth": Number(POSITIVE, |s, v| order(s).bandwidth = Some(v)), Follows("none"), "rad/s",
    "goal: the magnitude of the loop's double pole";
"commission.stiffest": Flag(|s, v| order(s).stiffest = Some(v)), Follows("true without response_time and bandwidth"), "",
    "goal: as stiff as this servo bears";
"commission.max_sensitivity": Number(ABOVE_ONE, |s, v| order(s).most_sensitivity = v), Is(CommissionOrder::MOST_SENSITIVITY), "",
    "the largest sensitivity that the loop may have, its smallest distance from instability being 1/max_sensitivity";
"commission.trial_step": Number(POSITIVE, |s, v| order(s).trial_step = Some(v)), Follows("half of the travel that there is"), "rad",
    "the step of the reference in the trial";
"commission.most_gain": Number(POSITIVE, |s, v| order(s).most_gain = Some(v)), Follows("the highest b of identifier.plant_box; without it nothing is known"),
    "rad/s² per command unit", "the largest b that the servo may have: the first motion is planned for it";
"commission.command_delay": Number(Fixed(Allowed::Within(0.0, 0.1)), |s, v| order(s).command_delay = Some(v)), Follows("amplifier.delay"), "s",
    "from the reading of the encoder to the change of the output, as far as it is known; the rest is identified";
"commission.sample_time": Number(SAMPLE_TIME, |s, v| order(s).sample_time = Some(v)), Follows("controller.sample_time"), "s",
    "time from one sample to the next, for a scenario without [controller]";

"log": Table(Stated), Follows("the columns of the tool's own traces"), "", "the columns of a log to replay, by name or by number from 1";
"log.time": ColumnOf(|s, v| log(s).time = Some(v)), Follows("none: the rows are the samples, and log.sample_time says how long one lasts"), "in time_unit",
    "time of a row";
"log.time_unit": OneOf(TIME_UNITS), First, "", "unit of log.time; \"samples\" is a counter of them";
"log.sample_time": Number(SAMPLE_TIME, |s, v| log(s).sample_time = Some(v)), Follows("controller.sample_time; without a controller, what log.time says"), "s",
    "time from one sample of the log to the next";
"log.reference": ColumnOf(|s, v| log(s).reference = Some(v)), Follows("none; required without log.command"), "in reference_unit",
    "reference position";
"log.reference_unit": OneOf(REFERENCE_UNITS), First, "",
    "unit of log.reference; \"as-position\" takes position_scale, too";
"log.reference_scale": Number(ANY, |s, v| log(s).units.reference_scale = v), Is(1.0), "",
    "reference_unit for one of the column's; below 0 for the other direction";
"log.position": ColumnOf(|s, v| log(s).position = v), Required("\"position_rad\""), "in position_unit", "measured position";
"log.position_unit": OneOf(POSITION_UNITS), First, "",
    "unit of log.position; of a linear axis \"m\" or \"mm\", and m is read for rad everywhere";
"log.angle": OneOf(ANGLES), First, "",
    "whether a position of zero is the same angle in every recording (absolute), or where a counter began; gravity needs an absolute angle";
"log.position_scale": Number(ANY, |s, v| log(s).units.position_scale = v), Is(1.0), "",
    "position_unit for one of the column's, such as \"turns\" and 0.2 for the millimetres of a screw of 5 mm a turn; below 0 for the other direction";
"log.command": ColumnOf(|s, v| log(s).command = Some(v)), Follows("the declared controller's, computed again"), "scaled by command_scale",
    "the whole command that acted from each row to the next";
"log.injection": ColumnOf(|s, v| log(s).injection = Some(v)), Follows("none"), "scaled by command_scale",
    "what was added to the declared controller's command behind its limit";
"log.command_scale": Number(ANY, |s, v| log(s).units.command_scale = v), Is(1.0), "",
    "command units for one of the column's, such as 0.24 for the per cent of a bridge of 24 V; below 0 for the other direction";
"log.bridge_gaps": Whole([0, u32::MAX], |s, v| log(s).bridge = v), Is(0.0), "",
    "the most missing samples in a row that straight lines may bridge";
"log.cut": Pairs(ANY, |s, v| log(s).leave_out(v)), Follows("nothing is left out"), "s",
    "ranges of the log's time that are left out";
}

const fn choice(
    name: &'static str,
    takes: &'static [&'static str],
    set: fn(&mut Scenario),
) -> Choice {
    Choice { name, takes, set }
}

const FAULTS: Entries = Entries {
    most: Faults::MOST,
    begin: |s| {
        s.faults
            .push(InjectedFault::lasting(FaultKind::EncoderStuck, 0.0, 0.0));
    },
    check: |s| s.faults.last().map_or(Ok(()), InjectedFault::check),
};

macro_rules! fault_kinds {
    ($($kind:ident: $takes:expr;)*) => {
        const FAULT_KINDS: &[Choice] = &[$(choice(
            FaultKind::$kind.name(), $takes, |s| fault(s).kind = FaultKind::$kind,
        )),*];
    };
}

fault_kinds! {
    EncoderStuck: &["duration"];
    EncoderLost: &["duration"];
    EncoderJump: &["size"];
    EncoderReversed: &["duration"];
    ActuatorDead: &["duration"];
    ActuatorWeak: &["duration", "size"];
    ActuatorReversed: &["duration"];
    LoadStep: &["duration", "size"];
    FrictionRise: &["duration", "size"];
    Overrun: &["duration"];
    LimitSwitch: &["duration"];
    AmplifierFault: &["duration"];
}

const TIME_UNITS: &[Choice] = &[
    choice("s", &[], |s| log(s).units.time = TimeUnit::Second),
    choice("ms", &[], |s| log(s).units.time = TimeUnit::Millisecond),
    choice("us", &[], |s| log(s).units.time = TimeUnit::Microsecond),
    choice("samples", &[], |s| log(s).units.time = TimeUnit::Sample),
];

const ANGLES: &[Choice] = &[
    choice("relative", &[], |s| log(s).absolute = false),
    choice("absolute", &[], |s| log(s).absolute = true),
];

#[rustfmt::skip]
const POSITION_UNITS: &[Choice] = &[
    choice(PositionUnit::Radian.name(), &[], |s| log(s).units.position = PositionUnit::Radian),
    choice(PositionUnit::Degree.name(), &[], |s| log(s).units.position = PositionUnit::Degree),
    choice(PositionUnit::Turn.name(), &[], |s| log(s).units.position = PositionUnit::Turn),
    choice(PositionUnit::Count.name(), &[], |s| log(s).units.position = PositionUnit::Count),
    choice(PositionUnit::Metre.name(), &[], |s| log(s).units.position = PositionUnit::Metre),
    choice(PositionUnit::Millimetre.name(), &[], |s| log(s).units.position = PositionUnit::Millimetre),
];

#[rustfmt::skip]
const REFERENCE_UNITS: &[Choice] = &[
    choice("as-position", &[], |s| log(s).units.reference = None),
    choice(PositionUnit::Radian.name(), &[], |s| log(s).units.reference = Some(PositionUnit::Radian)),
    choice(PositionUnit::Degree.name(), &[], |s| log(s).units.reference = Some(PositionUnit::Degree)),
    choice(PositionUnit::Turn.name(), &[], |s| log(s).units.reference = Some(PositionUnit::Turn)),
    choice(PositionUnit::Count.name(), &[], |s| log(s).units.reference = Some(PositionUnit::Count)),
    choice(PositionUnit::Metre.name(), &[], |s| log(s).units.reference = Some(PositionUnit::Metre)),
    choice(PositionUnit::Millimetre.name(), &[], |s| log(s).units.reference = Some(PositionUnit::Millimetre)),
];

const VELOCITIES: &[Choice] = &[
    choice("low-pass", &["cutoff"], |s| s.velocity = Velocity::LowPass),
    choice("difference", &[], |s| s.velocity = Velocity::Difference),
    choice("averaged-difference", &[], |s| {
        s.velocity = Velocity::AveragedDifference;
    }),
];

const ARITHMETICS: &[Choice] = &[
    choice("f32", &[], |s| s.identifier.arithmetic = Arithmetic::F32),
    choice("f64", &[], |s| s.identifier.arithmetic = Arithmetic::F64),
    choice("fixed", &["ranges"], |s| {
        s.identifier.arithmetic = Arithmetic::Fixed;
    }),
];

/// The references; their numbers follow, key by key.
#[rustfmt::skip]
const EXCITATIONS: &[Choice] = &[
    choice("band-limited-white-noise", &["power", "sample_time", "seed"], |s| {
        s.excitation = BandLimitedWhiteNoise { power: 0.0, sample_time: 0.0, seed: 0 };
    }),
    choice("prbs", &["amplitude", "hold", "order"], |s| {
        s.excitation = Prbs { amplitude: 0.0, hold: 0.0, order: 0 };
    }),
    choice("multisine", &["amplitudes", "frequencies"], |s| s.excitation = Multisine(Vec::new())),
    choice("chirp", &["amplitude", "from", "to", "duration"], |s| {
        s.excitation = Chirp { amplitude: 0.0, from: 0.0, to: 0.0, duration: 0.0 };
    }),
    choice("square", &["amplitude", "period"], |s| {
        s.excitation = Square { amplitude: 0.0, period: 0.0 };
    }),
    choice("steps", &["levels", "hold"], |s| {
        s.excitation = Steps { levels: Vec::new(), hold: 0.0 };
    }),
    choice("none", &[], |s| s.excitation = Still),
];

const GRADIENT: &[&str] = &[
    "gamma",
    "mu",
    "bounds",
    "plant_box",
    "correction",
    "bandwidth",
    "max_speed",
];

const FITTING: &[&str] = &[
    "bounds",
    "uncertainty",
    "noise",
    "bandwidth",
    "max_speed",
    "start_time",
    "terms",
    "required_terms",
    "low_speed_velocity",
    "ripple_order",
    "revolution",
];

const GAUSS_NEWTON: &[&str] = &[
    "bounds",
    "uncertainty",
    "noise",
    "bandwidth",
    "max_speed",
    "start_time",
    "memory",
    "terms",
    "required_terms",
    "low_speed_velocity",
    "ripple_order",
    "revolution",
];

macro_rules! laws {
    ({ $($law:ident: $takes:expr;)* } rivals { $($baseline:ident: $own:expr;)* }) => {
        /// The laws, and which keys each takes besides those that all take.
        pub(super) const LAWS: &[Choice] = &[
            $(choice(Law::$law.name(), $takes, |s| adopt(s, Law::$law)),)*
            $(choice(Baseline::$baseline.name(), $own, |s| {
                adopt(s, Law::Baseline(Baseline::$baseline, BaselineSettings::of(Baseline::$baseline)));
            }),)*
        ];
    };
}

laws! {
    {
        Gradient: GRADIENT;
        GaussNewton: GAUSS_NEWTON;
        Window: FITTING;
        PdGradient: GRADIENT;
    }
    rivals {
        RelayLeastSquares: &["relay", "forgetting", "filter_cutoff"];
        ProportionalLeastSquares: &["proportional_gain", "filter_cutoff"];
        TwoDegreesOfFreedom: &["filter_cutoff"];
        MultiStepLeastSquares: &["proportional_gain", "forgetting", "block"];
        RelayCycle: &["relay", "relay_delay"];
        TwoRelays: &["relay", "relay_delay"];
        ClosedLoopArx: &["forgetting", "filter_cutoff"];
        MechanicalLeastSquares: &["forgetting", "filter_cutoff"];
    }
}

/// Keys of former versions, with what is to be stated in their place.
const FORMER: &[(&str, &str)] = &[
    (
        "identifier.window",
        "a window is no longer counted in samples: use start_time, its length in seconds",
    ),
    (
        "identifier.fit_every",
        "a fit begins as soon as a quarter of the window is new: use start_time, the length of the window",
    ),
];

/// What is to be stated in place of a key of a former version.
pub(super) fn remedy(path: &str) -> Option<&'static str> {
    let former = FORMER.iter().find(|(former, _)| *former == path);
    former.map(|(_, remedy)| *remedy)
}

fn plant(s: &mut Scenario) -> &mut ServoParameters {
    s.plant.get_or_insert(ServoParameters {
        a: 0.0,
        b: 0.0,
        coulomb: 0.0,
        load: 0.0,
    })
}

/// The fault that is being read.
fn fault(s: &mut Scenario) -> &mut InjectedFault {
    if s.faults.is_empty() {
        (FAULTS.begin)(s);
    }
    let last = s.faults.len() - 1;
    &mut s.faults[last]
}

fn pid(s: &mut Scenario) -> &mut ControllerSettings {
    let none = ControllerSettings::pid(0.0, 0.0, 0.0);
    s.stated.controller.get_or_insert(none)
}

fn told(s: &mut Scenario) -> &mut IdentifierSettings {
    &mut s.stated.identifier
}

fn within(s: &mut Scenario) -> &mut BoxSettings {
    told(s).plant_box.get_or_insert(BoxSettings {
        a: [0.0; 2],
        b: [0.0; 2],
    })
}

fn correction(s: &mut Scenario) -> &mut [f64; 3] {
    told(s).correction.get_or_insert([0.0; 3])
}

fn ranges(s: &mut Scenario) -> &mut RangeSettings {
    told(s).ranges.get_or_insert(RangeSettings {
        error: 0.0,
        velocity: 0.0,
        command: 0.0,
    })
}

fn rival(s: &mut Scenario, set: impl FnOnce(&mut BaselineSettings)) {
    if let Law::Baseline(_, own) = &mut s.identifier.law {
        set(own);
    }
}

/// The limit of the amplifier stands before it in the table.
fn order(s: &mut Scenario) -> &mut CommissionOrder {
    let amplifier = s.stated.controller.map(|controller| controller.limit);
    s.commission
        .get_or_insert_with(|| CommissionOrder::behind(amplifier))
}

fn log(s: &mut Scenario) -> &mut LogSettings {
    s.log
        .get_or_insert_with(|| LogSettings::of_position(Column::Number(1)))
}

fn adopt(s: &mut Scenario, law: Law) {
    s.identifier.parameters = law.default_parameters();
    s.identifier.law = law;
}

fn choose(s: &mut Scenario, parameters: Vec<Parameter>) -> Result<(), String> {
    s.identifier.law.can_estimate(&parameters)?;
    s.identifier.parameters = parameters;
    Ok(())
}

/// Spreads the rows for the chosen parameters over those of all four.
fn weigh(s: &mut Scenario, rows: &[Vec<f64>]) -> Result<(), String> {
    let parameters = &s.identifier.parameters;
    let count = parameters.len();
    if rows.len() != count {
        return Err(format!("{} entries for {count} parameters", rows.len()));
    }
    let mut matrix = parts::identity();
    for (i, (values, of)) in rows.iter().zip(parameters).enumerate() {
        if values.len() != count {
            return Err(format!(
                "row {i} has {} entries for {count} parameters",
                values.len()
            ));
        }
        for (value, beside) in values.iter().zip(parameters) {
            matrix[parts::place(*of)][parts::place(*beside)] = *value;
        }
    }
    s.stated.identifier.gamma = Some(matrix);
    Ok(())
}

fn sines(amplitudes: Vec<f64>) -> ExcitationSettings {
    let sine = |amplitude| Tone {
        amplitude,
        frequency: 0.0,
    };
    Multisine(amplitudes.into_iter().map(sine).collect())
}

fn tune(excitation: &mut ExcitationSettings, frequencies: &[f64]) -> Result<(), String> {
    let Multisine(tones) = excitation else {
        return Ok(());
    };
    if tones.len() != frequencies.len() {
        return Err(format!(
            "{} frequencies for {} amplitudes",
            frequencies.len(),
            tones.len()
        ));
    }
    for (tone, frequency) in tones.iter_mut().zip(frequencies) {
        tone.frequency = *frequency;
    }
    Ok(())
}

/// All keys as a text for the help.
#[must_use]
pub fn listing() -> String {
    let leaves = KEYS.iter().filter(|key| !matches!(key.holds, Table(_)));
    leaves
        .map(|key| {
            let (about, allowed) = (key.description(), key.allowed());
            format!(
                "  {}\n      {about}\n      {allowed}; default {}\n",
                key.path,
                key.default()
            )
        })
        .collect()
}
