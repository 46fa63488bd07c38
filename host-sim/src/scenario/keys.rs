//! Every key of a scenario file: a line each, in the order in which they are read.
//!
//! A line has the key's path, the kind of its value with its place in the [`Scenario`], the default, the unit and the
//! meaning. Reading, messages, help and schema all follow from it.

use commissioning::Limits;
use identifier_core::control::{FeedForwardSettings, Gains};
use identifier_core::error::Allowed;
use identifier_core::parameters::{Parameter, ServoParameters};
use identifier_core::settings::{
    ControllerSettings, IdentifierSettings, ParameterRangeSettings, RangeSettings,
};
use identifier_core::tuning::TuningSettings;
use identifier_core::units::Units;
use virtual_servo::faults::{FaultKind, Faults, InjectedFault};
use virtual_servo::{Effects, SensorEffects, VirtualBrake};

use super::kind::Default::{Derived, FirstChoice, Initial, Required, Value};
use super::kind::Kind::{
    Choice as OneOf, Column as ColumnOf, Flag, Limit, Matrix, Number, Numbers, Pair, Pairs,
    Parameters, Reach, Table, Tables, Terms as TermList, Two, Whole,
};
use super::kind::When::{Always, InRun, Simulated, Stated};
use super::kind::{Choice, Entries, Key, nearest};
use super::range::Range::{
    self, BelowNyquist, Delay, Duration, EvenSamples, FaultSize, Fixed, HalfRadian, Samples,
};
use super::{
    Arithmetic, Column, CommandUnit, CommissionOrder, Estimator, ExcitationKind, InnerLoop,
    Integrator, LogSettings, PositionUnit, RivalSettings, Scenario, TimeUnit, Velocity, parts,
};

/// The paper's cut-off of the velocity filter, rad/s.
const CUTOFF: f64 = 500.0;

const ANY: Range = Fixed(Allowed::Finite);
/// The largest acceleration of a servo, rad/s² for a unit of command or by itself. Also the largest rate of braking,
/// 1/s.
const MAX_RATE: f64 = 1e12;
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
const BRAKE: Range = Fixed(Allowed::Within(0.0, VirtualBrake::MAX_TIME));
const SHARE: Range = Fixed(Allowed::Within(
    -Effects::LARGEST_SHARE,
    Effects::LARGEST_SHARE,
));
const DRIFT: Range = Fixed(Allowed::Within(
    -Effects::FASTEST_DRIFT,
    Effects::FASTEST_DRIFT,
));
const ABOVE_ONE: Range = Fixed(Allowed::Above(1.0));
const SENSOR_ERROR: Range = Fixed(Allowed::Within(0.0, SensorEffects::LARGEST));
const TYPICAL: RivalSettings = RivalSettings::TYPICAL;

macro_rules! keys {
    ($($path:literal: $kind:expr, $default:expr, $unit:literal, $about:literal;)*) => {
        /// All keys, in the order in which they are read.
        pub static KEYS: &[Key] = &[$(Key {
            path: $path, kind: $kind, default: $default, unit: $unit, about: $about,
        }),*];
    };
}

keys! {
"plant": Table(Stated), Derived("required for a run; with it and without [log], a log to replay is one of a run of \
                                 this scenario"), "",
    "the true servo, q'' = -a q' + b u + load - coulomb sign q', with the position q in rad and the command u";
"plant.a": Number(Fixed(Allowed::Within(0.0, MAX_RATE)), |s, v| plant(s).a = v), Required("0.5"), "1/s",
    "viscous friction over inertia: without command the speed decays as exp(-a t)";
"plant.b": Number(Fixed(Allowed::PositiveUpTo(MAX_RATE)), |s, v| plant(s).b = v), Required("200.0"), "rad/s² per command unit",
    "acceleration per command unit";
"plant.load": Number(Fixed(Allowed::Within(-MAX_RATE, MAX_RATE)), |s, v| plant(s).load = v), Value(0.0), "rad/s²",
    "acceleration by a constant load";
"plant.coulomb": Number(Fixed(Allowed::Within(0.0, MAX_RATE)), |s, v| plant(s).coulomb = v), Value(0.0), "rad/s²",
    "deceleration by Coulomb friction";
"plant.delay": Number(Delay, |s, v| s.effects.delay = v), Value(0.0), "s",
    "time until a command acts, also fractions of a sample";
"plant.current_loop": Number(Fixed(Allowed::Within(0.0, Effects::SLOWEST_CURRENT_LOOP)), |s, v| s.effects.current_loop = v),
    Value(0.0), "s", "time constant of the first-order lag of the acting command; 0 or at least a thousandth of the sample time";
"plant.asymmetry": Number(ANY, |s, v| s.effects.asymmetry = v), Value(0.0), "1/s",
    "viscous friction is a + asymmetry forwards and a - asymmetry backwards; from -a to a";
"plant.low_speed_friction": Number(ANY, |s, v| s.effects.low_speed_friction = v), Value(0.0), "rad/s²",
    "additional Coulomb friction s at low speed: s exp(-(q'/low_speed_velocity)²); at least -coulomb";
"plant.low_speed_velocity": Number(POSITIVE, |s, v| s.effects.low_speed_velocity = v), Derived("none; required with low_speed_friction"), "rad/s",
    "the speed at which 37 % of it is left";
"plant.quadratic_friction": Number(Fixed(Allowed::Within(0.0, Effects::LARGEST_DRAG)), |s, v| s.effects.quadratic_friction = v), Value(0.0), "1/rad",
    "additional drag, this value times q'², against the motion";
"plant.load_dependent_friction": Number(Fixed(Allowed::Within(0.0, Effects::LARGEST_SHARE)), |s, v| s.effects.load_dependent_friction = v), Value(0.0), "",
    "additional Coulomb friction, as a share of the motor's acceleration |b u|, such as that of a gear under load";
"plant.gravity": Two(ANGULAR, |s, v| s.effects.gravity = v), Derived("none"), "rad/s²",
    "[g_s, g_c]: acceleration by gravity, g_s sin q + g_c cos q, q being 0 where the servo starts";
"plant.ripple": Two(ANGULAR, |s, v| s.effects.ripple = v), Derived("none"), "rad/s²",
    "[r_s, r_c]: acceleration by cogging, r_s sin Nq + r_c cos Nq";
"plant.ripple_order": Whole([1, Effects::HIGHEST_ORDER], |s, v| s.effects.ripple_order = v), Derived("none; required with ripple"), "",
    "its order N, periods per revolution";
"plant.torque_ripple": Two(SHARE, |s, v| s.effects.torque_ripple = v), Derived("none"), "",
    "[t_s, t_c]: b at an angle is b (1 + t_s sin Nq + t_c cos Nq)";
"plant.torque_ripple_order": Whole([1, Effects::HIGHEST_ORDER], |s, v| s.effects.torque_ripple_order = v), Derived("none; required with torque_ripple"), "",
    "its order N, periods per revolution";
"plant.inertia_variation": Two(SHARE, |s, v| s.effects.inertia_variation = v), Derived("none"), "",
    "[j_s, j_c]: the inertia at an angle is its mean times 1 + j_s sin Nq + j_c cos Nq; with two masses that of the \
     load";
"plant.inertia_order": Whole([1, Effects::HIGHEST_ORDER], |s, v| s.effects.inertia_order = v), Derived("none; required with inertia_variation"), "",
    "its order N, periods per revolution";
"plant.gain_asymmetry": Number(SHARE, |s, v| s.effects.gain_asymmetry = v), Value(0.0), "",
    "half the difference of b between positive and negative commands, as a share of b";
"plant.dead_band": Number(NOT_NEGATIVE, |s, v| s.effects.dead_band = v), Value(0.0), "command units",
    "the part of a small command, of either sign, that the power stage does not pass";
"plant.resonance": Number(Fixed(Allowed::PositiveUpTo(Effects::HIGHEST_RESONANCE)), |s, v| s.effects.resonance = v), Derived("none, one rigid body"), "rad/s",
    "resonance of motor and load coupled by a spring, both free; the encoder is on the motor, and so is friction but for load_friction";
"plant.resonance_damping": Number(Fixed(Allowed::Within(0.0, 1.0)), |s, v| s.effects.resonance_damping = Some(v)), Derived("0.02 with resonance"), "",
    "its damping ratio";
"plant.inertia_ratio": Number(Fixed(Allowed::Within(Effects::INERTIA_RATIOS[0], Effects::INERTIA_RATIOS[1])), |s, v| s.effects.inertia_ratio = v), Derived("none; required with resonance"), "",
    "the load's share of the inertia";
"plant.load_friction": Number(NOT_NEGATIVE, |s, v| s.effects.load_friction = v), Value(0.0), "rad/s²",
    "Coulomb friction of the load behind the spring, over the inertia of both; needs resonance";
"plant.backlash": Number(NOT_NEGATIVE, |s, v| s.effects.backlash = v), Value(0.0), "rad",
    "backlash between the motor and an encoder on the load; with a resonance, backlash of the coupling";
"plant.gain_drift": Number(DRIFT, |s, v| s.effects.gain_drift = v), Value(0.0), "1/s",
    "change of b per second, relative to its initial value";
"plant.friction_drift": Number(DRIFT, |s, v| s.effects.friction_drift = v), Value(0.0), "1/s",
    "change of all friction per second, relative to its initial value";
"plant.hidden_limit": Number(POSITIVE, |s, v| s.effects.hidden_limit = v), Derived("none"), "command units",
    "a limit of the amplifier that amplifier.limit does not state";
"plant.load_wander": Two(NOT_NEGATIVE, |s, v| s.effects.load_wander = v), Derived("none"), "rad/s² and s",
    "[standard deviation, time constant] of an additional random load, seeded by run.seed";

"encoder": Table(Simulated), Derived("10000 counts; in a replay of another log, its own resolution"), "", "the position sensor";
"encoder.counts_per_rev": Number(COUNTS, |s, v| s.counts_per_rev = (v > 0.0).then_some(v)), Value(10_000.0), "",
    "counts per revolution after ×4 quadrature; 0 is an ideal sensor, in a replay the log's own resolution";
"encoder.noise": Number(SENSOR_ERROR, |s, v| s.sensor.noise = v), Value(0.0), "rad",
    "standard deviation of white noise before quantisation, in a run, seeded by run.seed";
"encoder.eccentricity": Number(SENSOR_ERROR, |s, v| s.sensor.eccentricity = v), Value(0.0), "rad",
    "amplitude of an error once per revolution, in a run";
"encoder.jitter": Number(Fixed(Allowed::Within(0.0, SensorEffects::LARGEST_JITTER)), |s, v| s.sensor.jitter = v), Value(0.0), "",
    "standard deviation of the sampling instant in a run, as a share of the sample time";

"amplifier": Table(Always), Derived("no limit"), "", "what drives the motor";
"amplifier.delay": Number(Fixed(Allowed::Within(0.0, 0.1)), |s, v| given(s).terms.delay = v), Value(0.0), "s",
    "known delay from the command to the motor: computation, amplifier and bus; estimators with a model take it into \
     account, and the term delay starts there";
"amplifier.dead_band": Number(NOT_NEGATIVE, |s, v| given(s).terms.dead_band = v), Value(0.0), "command units",
    "known dead band of the power stage, to either side; the term dead-band starts there";
"amplifier.current_loop": Number(Fixed(Allowed::Within(0.0, 0.1)), |s, v| given(s).terms.current_loop = v), Value(0.0), "s",
    "known time constant of the current loop, with which the motor's current follows the command";
"amplifier.brake": Table(Stated), Derived("none"), "",
    "holding brake of the axis, which power opens, at an output of its own; the drive holds the axis while it opens or closes";
"amplifier.brake.opens": Number(BRAKE, |s, v| brake(s)[0] = v), Required("0.05"), "s", "the longest that it takes to open";
"amplifier.brake.closes": Number(BRAKE, |s, v| brake(s)[1] = v), Required("0.1"), "s", "the longest that it takes to close";
"amplifier.limit": Limit(|s, v| pid(s).limit = v), Derived("no limit"), "command units",
    "limit of the controller's command, |u| <= limit or low <= u <= high";

"controller": Table(InRun), Derived("the paper's; in a replay of another log, none"), "",
    "the PID that closes the loop, u = kp e - kd v + ki T times the sum of the earlier e";
"controller.kp": Number(POSITIVE_GAIN, |s, v| pid(s).kp = v), Value(9.0), "command units per rad",
    "proportional gain";
"controller.kd": Number(GAIN, |s, v| pid(s).kd = v), Value(0.19), "command units per rad/s",
    "derivative gain, on the measured velocity";
"controller.ki": Number(GAIN, |s, v| pid(s).ki = v), Value(4.0), "command units per rad s",
    "integral gain";
"controller.reference_filter": Number(NOT_NEGATIVE, |s, v| pid(s).reference_filter = v), Value(0.0), "s",
    "time constant of a first-order filter of the reference before the PID, 0 for none";
"controller.notch": Number(NOT_NEGATIVE, |s, v| pid(s).notch = v), Value(0.0), "rad/s",
    "notch filter of the command, 0 for none";
"controller.feed_forward": Table(Stated), Derived("none"), "",
    "a reference model, y = r/(1 + s/bandwidth)³, with feed-forward; not in fixed point";
"controller.feed_forward.bandwidth": Number(POSITIVE, |s, v| lead(s).bandwidth = v), Required("60.0"), "rad/s",
    "magnitude of the model's three poles, from 1e-5 to 1 per sample";
"controller.feed_forward.acceleration": Number(GAIN, |s, v| lead(s).acceleration = v), Required("0.005"), "command units per rad/s²",
    "command for its acceleration, 1/b";
"controller.feed_forward.velocity": Number(GAIN, |s, v| lead(s).velocity = v), Value(0.0), "command units per rad/s",
    "command for its velocity, a/b; that for kd is added to it";
"controller.feed_forward.coulomb": Number(GAIN, |s, v| lead(s).coulomb = v), Value(0.0), "command units",
    "command for Coulomb friction, with the sign of its velocity";
"controller.feed_forward.coulomb_speed": Number(POSITIVE, |s, v| lead(s).coulomb_speed = v), Value(LEAST_LEAD.coulomb_speed), "rad/s",
    "speed below which that command is linear through zero";
"controller.sample_time": Number(SAMPLE_TIME, |s, v| s.stated.sample_time = v), Value(1e-3), "s",
    "time from one control sample to the next; in a replay without a controller, the log's own";
"controller.velocity_filter": Table(Always), Derived("low-pass, 500 rad/s; in a replay without a controller, half the sample rate"), "",
    "how the velocity is taken from the counts, { kind = \"low-pass\", cutoff = 500.0 }";
"controller.velocity_filter.kind": OneOf(Velocity::CHOICES, |s, i| s.velocity = Velocity::ALL[i]), FirstChoice, "", "kind of velocity estimate";
"controller.velocity_filter.cutoff": Number(BelowNyquist, |s, v| s.stated.cutoff = v), Value(CUTOFF), "rad/s",
    "cut-off of the low-pass; of a slow loop by default half of what is allowed";

"excitation": Table(Always), Derived("the paper's"), "", "the reference that the servo follows";
"excitation.kind": OneOf(ExcitationKind::CHOICES, |s, i| s.excitation.kind = ExcitationKind::ALL[i]), FirstChoice, "", "kind of reference";
"excitation.power": Number(POSITIVE, |s, v| s.excitation.power = v),
    Value(0.005), "rad² s", "power of the noise";
"excitation.sample_time": Number(Samples, |s, v| s.excitation.sample_time = v),
    Value(0.1), "s", "time for which a value of the noise is held";
"excitation.seed": Whole([0, u32::MAX], |s, v| s.excitation.seed = v),
    Value(1_212_121.0), "", "seed of the noise";
"excitation.amplitude": Number(POSITIVE, |s, v| s.excitation.amplitude = v),
    Required("0.2"), "rad", "amplitude to either side";
"excitation.hold": Number(Samples, |s, v| s.excitation.hold = v),
    Required("0.1"), "s", "time for which a bit or a level is held";
"excitation.order": Whole([2, 24], |s, v| s.excitation.order = v),
    Value(9.0), "", "bits of the shift register";
"excitation.amplitudes": Numbers(POSITIVE, |s, v| { s.excitation.amplitudes = v; Ok(()) }),
    Required("[0.1, 0.05]"), "rad", "amplitude of each sine";
"excitation.frequencies": Numbers(BelowNyquist, set_frequencies),
    Required("[6.0, 20.0]"), "rad/s", "frequency of each sine, as many as amplitudes";
"excitation.from": Number(BelowNyquist, |s, v| s.excitation.from = v),
    Required("2.0"), "rad/s", "start frequency";
"excitation.to": Number(BelowNyquist, |s, v| s.excitation.to = v),
    Required("40.0"), "rad/s", "end frequency";
"excitation.duration": Number(Samples, |s, v| s.excitation.duration = v),
    Required("5.0"), "s", "time of a sweep, after which it repeats";
"excitation.period": Number(EvenSamples, |s, v| s.excitation.period = v),
    Required("1.0"), "s", "period of the square wave";
"excitation.levels": Numbers(ANY, |s, v| { s.excitation.levels = v; Ok(()) }),
    Required("[0.2, -0.2]"), "rad", "levels, one after the other";

"identifier": Table(Always), Derived("the gradient estimator"), "", "what is identified, and how";
"identifier.law": OneOf(Estimator::CHOICES, |s, i| s.identifier.set_estimator(Estimator::ALL[i])), FirstChoice, "", "the method";
"identifier.parameters": Parameters(choose), Derived("[\"a\", \"b\"], or those that the method finds"), "",
    "what is estimated; the others stay at their initial values";
"identifier.arithmetic": OneOf(Arithmetic::CHOICES, |s, i| s.identifier.arithmetic = Arithmetic::ALL[i]), FirstChoice, "",
    "number format of the loop; \"fixed\" exists for gradient and pd-gradient";
"identifier.gamma": Matrix(|s, v| weigh(s, &v)), Derived("automatic, from parameter range and reference"), "",
    "adaptation gain of each estimate, the matrix of (11)";
"identifier.mu": Number(POSITIVE, |s, v| given(s).mu = Some(v)), Derived("automatic, from gains and parameter range"), "1/s",
    "weight of the output error against its derivative in (11)";
"identifier.initial": Table(Always), Derived("as below"), "", "initial estimates, inside the bounds";
"identifier.initial.a": Number(ANY, |s, v| given(s).initial.a = Some(v)), Initial(0.0), "1/s", "initial estimate of a";
"identifier.initial.b": Number(POSITIVE, |s, v| given(s).initial.b = Some(v)), Initial(50.0), "rad/s² per command unit",
    "initial estimate of b; an estimator that fits needs one only if b is not among parameters";
"identifier.initial.coulomb": Number(ANY, |s, v| given(s).initial.coulomb = Some(v)), Initial(0.0), "rad/s²",
    "initial estimate of the Coulomb friction";
"identifier.initial.load": Number(ANY, |s, v| given(s).initial.load = Some(v)), Initial(0.0), "rad/s²",
    "initial estimate of the load";
"identifier.bounds": Table(Always), Derived("as below"), "", "bounds of the estimates";
"identifier.bounds.a": Pair(ANY, |s, v| given(s).bounds.a = Some(v)), Derived("as wide as the sample time permits"), "1/s",
    "bounds of a, both within 0.5/sample_time of 0";
"identifier.bounds.b": Pair(POSITIVE, |s, v| given(s).bounds.b = Some(v)),
    Derived("as wide as sample time and gains permit"), "rad/s² per command unit", "bounds of b";
"identifier.bounds.coulomb": Pair(NOT_NEGATIVE, |s, v| given(s).bounds.coulomb = Some(v)),
    Derived("from 0 to far beyond any servo; in fixed point the range that follows from plant_box and command"), "rad/s²",
    "bounds of the Coulomb friction";
"identifier.bounds.load": Pair(ANY, |s, v| given(s).bounds.load = Some(v)),
    Derived("far beyond any servo in both directions; in fixed point the range that follows from plant_box and command"), "rad/s²",
    "bounds of the load";
"identifier.plant_box": Table(Stated), Derived("none, and nothing is certified"), "",
    "the parameter range of the true servo: the loop is certified for all of it";
"identifier.plant_box.a": Pair(NOT_NEGATIVE, |s, v| within(s).a = v), Required("[0.0, 50.0]"), "1/s",
    "lowest and highest a of the servo";
"identifier.plant_box.b": Pair(POSITIVE, |s, v| within(s).b = v), Required("[110.0, 1000.0]"), "rad/s² per command unit",
    "lowest and highest b of the servo";
"identifier.correction": Table(Stated),
    Derived("the controller's gains, as in the paper; without a controller, from plant_box and bandwidth"), "",
    "the gains of the correction, which keeps the model close to the servo";
"identifier.correction.kp": Number(POSITIVE_GAIN, |s, v| correction(s)[0] = v), Required("9.0"), "command units per rad",
    "proportional gain of the correction";
"identifier.correction.kd": Number(GAIN, |s, v| correction(s)[1] = v), Required("0.19"), "command units per rad/s",
    "derivative gain of the correction";
"identifier.correction.ki": Number(GAIN, |s, v| correction(s)[2] = v), Required("4.0"), "command units per rad s",
    "integral gain of the correction";
"identifier.bandwidth": Number(HalfRadian, |s, v| given(s).bandwidth = Some(v)),
    Derived("from the first fit; gradient estimators, 0.05/sample_time"), "rad/s",
    "bandwidth of the position loop, to within a factor of four; gradient estimators use it without controller and \
     correction";
"identifier.max_speed": Number(POSITIVE, |s, v| given(s).max_speed = Some(v)),
    Derived("what the number format represents exactly in a sample"), "rad/s",
    "the highest speed of the servo; a larger jump of the position ends the run";
"identifier.uncertainty": Table(Always), Derived("unknown"), "", "standard deviations of the initial estimates";
"identifier.uncertainty.a": Number(POSITIVE, |s, v| given(s).uncertainty.a = Some(v)), Derived("unknown"), "1/s",
    "standard deviation of initial.a";
"identifier.uncertainty.b": Number(POSITIVE, |s, v| given(s).uncertainty.b = Some(v)), Derived("unknown"),
    "rad/s² per command unit", "standard deviation of initial.b";
"identifier.uncertainty.coulomb": Number(POSITIVE, |s, v| given(s).uncertainty.coulomb = Some(v)), Derived("unknown"),
    "rad/s²", "standard deviation of initial.coulomb";
"identifier.uncertainty.load": Number(POSITIVE, |s, v| given(s).uncertainty.load = Some(v)), Derived("unknown"),
    "rad/s²", "standard deviation of initial.load";
"identifier.noise": Number(POSITIVE, |s, v| given(s).noise = Some(v)), Derived("an encoder count over the square root of 12"), "rad",
    "smallest standard deviation of the position noise; a larger one is estimated";
"identifier.start_time": Number(Fixed(Allowed::Within(1e-4, 1e4)), |s, v| given(s).start_time = Some(v)),
    Derived("1; in a replay, no more than the log has"), "s",
    "the time span of the first fit";
"identifier.memory": Number(Fixed(Allowed::AtLeast(2.0)), |s, v| given(s).memory = Some(v)), Derived("all samples"), "s",
    "memory of the estimates, for a servo that changes";
"identifier.required_terms": TermList(|s, v| given(s).terms.demanded = v), Derived("none"), "",
    "optional terms of the model that are estimated as soon as the motion allows";
"identifier.low_speed_velocity": Number(POSITIVE, |s, v| given(s).terms.low_speed_velocity = Some(v)),
    Derived("none; required with the term low-speed"), "rad/s", "speed at which the low-speed friction has fallen to \
                                                                 1/e";
"identifier.ripple_order": Number(POSITIVE, |s, v| given(s).terms.ripple_order = Some(v)),
    Derived("none; required with the term ripple"), "", "periods of the ripple per revolution";
"identifier.revolution": Number(POSITIVE, |s, v| given(s).terms.revolution = v), Value(std::f64::consts::TAU), "rad",
    "travel after which gravity and ripple repeat, for a linear axis a pole pitch";
"identifier.ranges": Table(Stated), Derived("four times what the PID can demand within the command limit"), "",
    "range of the signals in fixed point";
"identifier.ranges.error": Number(POSITIVE, |s, v| ranges(s).error = v), Required("1.0"), "rad", "largest position error";
"identifier.ranges.velocity": Number(POSITIVE, |s, v| ranges(s).velocity = v), Required("100.0"), "rad/s", "largest velocity";
"identifier.ranges.command": Number(POSITIVE, |s, v| ranges(s).command = v), Required("10.0"), "command units",
    "largest command, at least the limit";
"identifier.relay": Number(POSITIVE, |s, v| s.identifier.rival.relay = v), Value(TYPICAL.relay), "command units",
    "command of the relay to either side";
"identifier.forgetting": Number(Fixed(Allowed::PositiveUpTo(1.0)), |s, v| s.identifier.rival.forgetting = v),
    Value(TYPICAL.forgetting), "", "forgetting factor per sample";
"identifier.filter_cutoff": Number(BelowNyquist, |s, v| s.identifier.rival.filter_cutoff = v), Value(TYPICAL.filter_cutoff), "rad/s",
    "cut-off of the filters of position and command; in a slow loop half of the allowed one by default";

"run": Table(Always), Derived("60 s"), "", "the simulated experiment";
"run.duration": Number(Duration, |s, v| s.duration = v), Value(60.0), "s",
    "length of the run";
"run.seed": Whole([0, u32::MAX], |s, v| s.seed = Some(v)), Derived("that of the reference, or 1"), "",
    "seed of the random parts of servo and sensor; a sweep draws its own";

"fault": Tables(FAULTS), Derived("none"), "", "fault injection: each fault of the simulated servo in its own table";
"fault.kind": OneOf(FAULT_KINDS, |s, i| fault(s).kind = FaultKind::ALL[i]), Required("\"actuator-weak\""), "", "kind \
                                                                                                                of \
                                                                                                                fault";
"fault.time": Number(NOT_NEGATIVE, |s, v| fault(s).time = v), Required("5.0"), "s", "time from the first sample";
"fault.duration": Number(POSITIVE, |s, v| fault(s).duration = v), Derived("for good"), "s", "how long";
"fault.size": Number(FaultSize, |s, v| fault(s).size = v), Required("0.5"), "",
    "size: the counts of a jump, the share of the command that still acts, the load, or the added friction";

"compare": Table(Always), Derived("as below"), "", "the cases of a comparison";
"compare.load": Number(ANY, |s, v| s.compare.load = Some(v)), Derived("0.08 of plant.b"), "rad/s²", "the load";
"compare.coulomb": Number(NOT_NEGATIVE, |s, v| s.compare.coulomb = Some(v)), Derived("0.04 of plant.b"), "rad/s²", "the friction";
"compare.counts_per_rev": Number(POSITIVE, |s, v| s.compare.counts_per_rev = v), Value(2000.0), "", "the coarse encoder";
"compare.limit": Number(POSITIVE, |s, v| s.compare.limit = Some(v)), Derived("a ninth of kp"), "command units",
    "the amplifier that saturates";

"commission": Table(Stated), Derived("required for a commissioning"), "",
    "limits and goal of a commissioning";
"commission.travel": Reach(|s, v| order(s).travel = v), Required("0.5"), "rad",
    "how far the servo may move from its present position";
"commission.speed": Number(POSITIVE, |s, v| order(s).speed = v), Required("20.0"), "rad/s", "the largest speed";
"commission.command": Limit(|s, v| order(s).command = Some(v)), Derived("amplifier.limit; required without it"), "command units",
    "the largest command, at most amplifier.limit";
"commission.duration": Number(POSITIVE, |s, v| order(s).duration = v), Value(Limits::DURATION), "s",
    "the longest time of a motion";
"commission.response_time": Number(POSITIVE, |s, v| order(s).response_time = Some(v)), Derived("none"), "s",
    "goal: the time from 10 to 90 % of a step of the reference";
"commission.bandwidth": Number(POSITIVE, |s, v| order(s).bandwidth = Some(v)), Derived("none"), "rad/s",
    "goal: the magnitude of the loop's poles";
"commission.stiffest": Flag(|s, v| order(s).stiffest = Some(v)), Derived("true without response_time and bandwidth"), "",
    "goal: as stiff as this servo permits";
"commission.max_sensitivity": Number(ABOVE_ONE, |s, v| order(s).max_sensitivity = v), Value(TuningSettings::MAX_SENSITIVITY), "",
    "the largest sensitivity of the loop; 1/max_sensitivity is its distance from instability";
"commission.trial_step": Number(POSITIVE, |s, v| order(s).trial_step = Some(v)), Derived("half of the travel"), "rad",
    "the step of the reference in the trial";
"commission.notch": Flag(|s, v| order(s).notch = Some(v)), Derived("true"), "",
    "the gains may have a notch";
"commission.feed_forward": Flag(|s, v| order(s).feed_forward = v), Derived("false"), "",
    "the gains may have a reference model with feed-forward, if the step then rises faster; not with response_time";
"commission.most_gain": Number(POSITIVE, |s, v| order(s).most_gain = Some(v)), Derived("the highest b of \
                                                                                        identifier.plant_box; \
                                                                                        without it unknown"),
    "rad/s² per command unit", "the largest b that the servo may have: the first motion is planned for it";
"commission.command_delay": Number(Fixed(Allowed::Within(0.0, 0.1)), |s, v| order(s).command_delay = Some(v)), Derived("amplifier.delay"), "s",
    "known delay from the encoder reading to the change of the output; the rest is identified";
"commission.sample_time": Number(SAMPLE_TIME, |s, v| order(s).sample_time = Some(v)), Derived("controller.sample_time"), "s",
    "time from one sample to the next, for a scenario without [controller]";

"inner": Table(Stated), Derived("none: log.command or [controller] gives it"), "",
    "the position loop of a servo that takes goals: it computes the log's command, u = kp (log.reference - q) - kd v";
"inner.kp": Number(POSITIVE_GAIN, |s, v| inner(s).kp = v), Required("40.0"), "command units per rad", "its proportional gain";
"inner.kd": Number(GAIN, |s, v| inner(s).kd = v), Value(0.0), "command units per rad/s", "its derivative gain, on the velocity";
"inner.limit": Limit(|s, v| inner(s).limit = v), Derived("no limit"), "command units", "limit of its command, |u| <= limit or low <= u <= high";
"inner.sample_time": Number(Fixed(Allowed::PositiveUpTo(1.0)), |s, v| inner(s).sample_time = Some(v)), Derived("that of the log"), "s",
    "its own sample time, or a simulator's step; the log's is a whole multiple of it, and the position in between is \
     interpolated";
"inner.integrator": OneOf(Integrator::CHOICES, |s, i| inner(s).integrator = Integrator::ALL[i]), FirstChoice, "",
    "how its command becomes motion: held for a sample as a drive holds it (none), or by MuJoCo's integrator Euler (euler), implicit or implicitfast (implicit)";
"inner.cutoff": Number(POSITIVE, |s, v| inner(s).cutoff = Some(v)), Derived("none: the velocity is log.velocity, or the difference of two positions"), "rad/s",
    "cut-off of the low-pass derivative that is its velocity";

"physical": Table(Stated), Derived("none: a result is ratios"), "", "converts a result into physical units";
"physical.command_unit": OneOf(CommandUnit::CHOICES, |s, i| s.physical.command_unit = CommandUnit::ALL[i]), FirstChoice, "",
    "unit of the command: with \"V\" a result has the feed-forward kS, kV, kA and kG, with \"Nm\" and \"N\" (a linear axis) inertia and friction";
"physical.torque_constant": Number(POSITIVE, |s, v| s.physical.torque_constant = Some(v)), Derived("1 with the command unit \"Nm\" or \"N\", otherwise none"), "N·m per command unit",
    "torque of a unit of command at the joint: torque constant times gear ratio and efficiency";
"physical.inertia": Number(POSITIVE, |s, v| s.physical.inertia = Some(v)), Derived("none"), "kg·m²",
    "total inertia about the joint, if that is known instead";
"physical.payload": Number(POSITIVE, |s, v| s.physical.payload = Some(v)), Derived("none"), "kg·m²",
    "inertia about the joint of an attached payload, if neither is known: it needs bare_gain";
"physical.bare_gain": Two(NOT_NEGATIVE, |s, v| s.physical.bare_gain = Some(v)), Derived("none"), "rad/s² per command unit",
    "b without the payload, and its standard error";

"log": Table(Stated), Derived("the columns of the tool's own traces"), "", "the columns of a log to replay, by name or by number from 1";
"log.time": ColumnOf(|s, v| log(s).time = Some(v)), Derived("none: each row is a sample of log.sample_time"), "in time_unit",
    "time of a row";
"log.time_unit": OneOf(TimeUnit::CHOICES, |s, i| log(s).units.time = TimeUnit::ALL[i]), FirstChoice, "", "unit of log.time; \"samples\" is a counter of them, \"iso-8601\" a time stamp such as 2026-11-22T06:25:00.125Z, or the time of day alone";
"log.sample_time": Number(SAMPLE_TIME, |s, v| log(s).sample_time = Some(v)), Derived("controller.sample_time; \
                                                                                      without a controller, from \
                                                                                      log.time"), "s",
    "time from one sample of the log to the next";
"log.reference": ColumnOf(|s, v| log(s).reference = Some(v)), Derived("none; required without log.command"), "in reference_unit",
    "reference position";
"log.reference_unit": OneOf(REFERENCE_UNITS, |s, i| log(s).units.reference = i.checked_sub(1).map(|i| PositionUnit::ALL[i])), FirstChoice, "",
    "unit of log.reference; \"as-position\" uses position_scale as well";
"log.reference_scale": Number(ANY, |s, v| log(s).units.reference_scale = v), Value(1.0), "",
    "reference_unit per unit of the column; below 0 for the other direction";
"log.position": ColumnOf(|s, v| log(s).position = v), Required("\"position_rad\""), "in position_unit", "measured position";
"log.measured": OneOf(MEASURED, |s, i| log(s).is_velocity = i == 1), FirstChoice, "",
    "whether log.position is the position, or the velocity, which is then integrated";
"log.position_unit": OneOf(PositionUnit::CHOICES, |s, i| log(s).units.position = PositionUnit::ALL[i]), FirstChoice, "",
    "unit of log.position; for a linear axis \"m\" or \"mm\": read m for rad everywhere; \"own\", or \"counts\" without \
     encoder.counts_per_rev: the result is in that unit, and nothing is in physical units";
"log.angle": OneOf(ANGLES, |s, i| log(s).absolute = i == 1), FirstChoice, "",
    "whether position zero is the same angle in every recording (absolute), or the start of a counter; gravity needs \
     an absolute angle";
"log.position_scale": Number(ANY, |s, v| log(s).units.position_scale = v), Value(1.0), "",
    "position_unit per unit of the column, such as \"turns\" and 0.2 for mm on a screw with 5 mm per revolution; \
     below 0 for the other direction";
"log.command": ColumnOf(|s, v| log(s).command = Some(v)), Derived("the declared controller's, computed again"), "scaled by command_scale",
    "the total command that acted from each row to the next";
"log.injection": ColumnOf(|s, v| log(s).injection = Some(v)), Derived("none"), "scaled by command_scale",
    "injection: added to the declared controller's command after its limit";
"log.known_torque": ColumnOf(|s, v| log(s).known_torque = Some(v)), Derived("none"), "N·m, of a linear axis N",
    "known torque that acts on the joint beside the command, positive if it moves the position up, such as gravity by a model; needs the torque of a unit of command";
"log.command_scale": Number(ANY, |s, v| log(s).units.command_scale = v), Value(1.0), "",
    "command units per unit of the column, such as 0.24 for percent of a 24 V power stage; below 0 for the other \
     direction";
"log.velocity": ColumnOf(|s, v| log(s).velocity = Some(v)), Derived("none"), "position_unit per s, times position_scale",
    "measured velocity, on which [inner] acts";
"log.bridge_gaps": Whole([0, u32::MAX], |s, v| log(s).bridge = v), Value(0.0), "",
    "largest number of missing samples in a row that are interpolated linearly";
"log.cut": Pairs(ANY, |s, v| log(s).leave_out(&v)), Derived("nothing is left out"), "s",
    "ranges of the log's time that are left out";
"log.wrap": Number(NOT_NEGATIVE, |s, v| log(s).wrap = Some(v)), Derived("detected: a position that wraps after a \
                                                                         revolution is unwrapped"), "in position_unit, before position_scale",
    "period after which the position wraps, such as 360 for degrees; 0 if it does not wrap";
}

const FAULTS: Entries = Entries {
    max: Faults::MAX_FAULTS,
    begin: |s| {
        s.faults
            .push(InjectedFault::lasting(FaultKind::EncoderStuck, 0.0, 0.0));
    },
    check: |s| s.faults.last().map_or(Ok(()), InjectedFault::check),
};

const FAULT_KINDS: &[Choice] = &{
    let mut kinds = [PLAIN; FaultKind::ALL.len()];
    let mut i = 0;
    while i < kinds.len() {
        kinds[i] = fault_kind(FaultKind::ALL[i]);
        i += 1;
    }
    kinds
};

/// A kind of fault with its keys beside its time.
const fn fault_kind(kind: FaultKind) -> Choice {
    Choice {
        name: kind.name(),
        takes: match kind {
            FaultKind::EncoderJump => &["size"],
            FaultKind::ActuatorWeak | FaultKind::LoadStep | FaultKind::FrictionRise => {
                &["duration", "size"]
            }
            _ => &["duration"],
        },
    }
}

/// The units of a reference, that of the position first.
const REFERENCE_UNITS: &[Choice] = &{
    const UNITS: &[Choice] = PositionUnit::CHOICES;
    let mut units = [PLAIN; 1 + UNITS.len()];
    units[0].name = "as-position";
    let mut i = 0;
    while i < UNITS.len() {
        units[i + 1] = UNITS[i];
        i += 1;
    }
    units
};

const MEASURED: &[Choice] = &[
    Choice {
        name: "position",
        ..PLAIN
    },
    Choice {
        name: "velocity",
        ..PLAIN
    },
];
const ANGLES: &[Choice] = &[
    Choice {
        name: "relative",
        ..PLAIN
    },
    Choice {
        name: "absolute",
        ..PLAIN
    },
];

const PLAIN: Choice = Choice {
    name: "",
    takes: &[],
};

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

/// Before its keys are read.
const LEAST_LEAD: FeedForwardSettings = FeedForwardSettings {
    bandwidth: 0.0,
    acceleration: 0.0,
    velocity: 0.0,
    coulomb: 0.0,
    coulomb_speed: 0.1,
};

fn lead(s: &mut Scenario) -> &mut FeedForwardSettings {
    pid(s).feed_forward.get_or_insert(LEAST_LEAD)
}

fn given(s: &mut Scenario) -> &mut IdentifierSettings {
    &mut s.stated.identifier
}

fn within(s: &mut Scenario) -> &mut ParameterRangeSettings {
    given(s)
        .parameter_range
        .get_or_insert(ParameterRangeSettings {
            a: [0.0; 2],
            b: [0.0; 2],
        })
}

fn correction(s: &mut Scenario) -> &mut [f64; 3] {
    given(s).correction.get_or_insert([0.0; 3])
}

fn ranges(s: &mut Scenario) -> &mut RangeSettings {
    given(s).ranges.get_or_insert(RangeSettings {
        error: 0.0,
        velocity: 0.0,
        command: 0.0,
    })
}

fn brake(s: &mut Scenario) -> &mut [f64; 2] {
    s.brake.get_or_insert([0.0; 2])
}

/// The limit of the amplifier precedes it in the table.
fn order(s: &mut Scenario) -> &mut CommissionOrder {
    let amplifier = s.stated.controller.map(|controller| controller.limit);
    s.commission.get_or_insert_with(|| CommissionOrder {
        amplifier: amplifier.filter(|limit| limit.iter().all(|end| end.is_finite())),
        ..CommissionOrder::default()
    })
}

fn inner(s: &mut Scenario) -> &mut InnerLoop {
    s.inner.get_or_insert(InnerLoop::proportional(0.0))
}

fn log(s: &mut Scenario) -> &mut LogSettings {
    s.log
        .get_or_insert_with(|| LogSettings::with_position(Column::Number(1)))
}

fn choose(s: &mut Scenario, parameters: Vec<Parameter>) -> Result<(), String> {
    s.identifier.law.check_parameters(&parameters)?;
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
            matrix[*of as usize][*beside as usize] = *value;
        }
    }
    s.stated.identifier.gamma = Some(matrix);
    Ok(())
}

fn set_frequencies(s: &mut Scenario, frequencies: Vec<f64>) -> Result<(), String> {
    let (count, tones) = (frequencies.len(), s.excitation.amplitudes.len());
    if count != tones {
        return Err(format!("{count} frequencies for {tones} amplitudes"));
    }
    s.excitation.frequencies = frequencies;
    Ok(())
}

impl Key {
    /// The line of a path.
    #[must_use]
    pub fn at(path: &str) -> Option<&'static Self> {
        KEYS.iter().find(|key| key.path == path)
    }

    /// The most likely key for a name or a path, in any table.
    #[must_use]
    pub fn nearest(word: &str) -> Option<&'static Self> {
        let named = KEYS.iter().find(|key| key.place().1 == word);
        named.or_else(|| Self::at(nearest(word, KEYS.iter().map(|key| key.path))?))
    }

    /// The keys of a table; for the empty path, the tables.
    pub fn children(table: &str) -> impl Iterator<Item = &'static Self> {
        KEYS.iter().filter(move |key| key.place().0 == table)
    }

    /// The names, of a key beside, that it belongs to; empty for a key that always holds.
    #[must_use]
    pub fn belongs_to(&self) -> Vec<&'static str> {
        let (table, name) = self.place();
        Self::children(table)
            .flat_map(|key| key.kind.choices())
            .filter(|choice| choice.takes.contains(&name))
            .map(|choice| choice.name)
            .collect()
    }

    /// Its meaning, and the choices that it belongs to.
    #[must_use]
    pub fn description(&self) -> String {
        match self.belongs_to() {
            owners if owners.is_empty() => self.about.to_owned(),
            owners => format!("{} ({})", self.about, owners.join(", ")),
        }
    }
}
