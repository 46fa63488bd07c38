//! The keys of a simulated experiment, beside those that a log has.

use std::sync::LazyLock;

use commissioning::Limits;
use identifier_core::error::Allowed;
use identifier_core::parameters::ServoParameters;
use identifier_core::tuning::TuningSettings;
use identifier_log::scenario::Default::{Derived, FirstChoice, Required, Value};
use identifier_log::scenario::Kind::{
    Choice as OneOf, Flag, Limit, Number, Numbers, Reach, Table, Tables, Two, Whole,
};
use identifier_log::scenario::Place::{Checked, Held, Optional};
use identifier_log::scenario::Range::{
    self, BelowNyquist, Described, Duration, EvenSamples, Fixed, Samples,
};
use identifier_log::scenario::When::{Always, Stated};
use identifier_log::scenario::keys::{SAMPLE_TIME, of_log};
use identifier_log::scenario::{Choice, Entries, Key, TABLES};
use virtual_servo::faults::{FaultKind, Faults, InjectedFault};
use virtual_servo::{Effects, SensorEffects, VirtualBrake};

use super::{CommissionOrder, CompareSettings, ExcitationKind, Scenario};

const ANY: Range = Fixed(Allowed::Finite);
/// The largest acceleration of a servo, rad/s² for a unit of command or by itself. Also the largest rate of braking,
/// 1/s.
const MAX_RATE: f64 = 1e12;
const POSITIVE: Range = Fixed(Allowed::Above(0.0));
const NOT_NEGATIVE: Range = Fixed(Allowed::AtLeast(0.0));
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

/// The delay of a command.
const DELAY: Range = Described(Allowed::Within(0.0, Effects::MAX_DELAY), || {
    let (longest, max_samples) = (Effects::MAX_DELAY, Effects::MAX_DELAYED_SAMPLES);
    format!("a number from 0 to {longest}, at most {max_samples} control samples")
});

/// The size of a fault, by its kind.
const FAULT_SIZE: Range = Described(Allowed::Finite, || {
    let most = Effects::LARGEST_ACCELERATION;
    format!(
        "a number: of encoder-jump, counts; of actuator-weak, a share from 0 to 1; of load-step, up to {most:e} \
         rad/s² in either direction; of friction-rise, 0 to {most:e} rad/s²"
    )
});

/// All keys of a scenario, in the order in which they are read.
pub static KEYS: LazyLock<Vec<Key<Scenario>>> = LazyLock::new(|| {
    let mut keys: Vec<_> = of_log().into_iter().chain(of_experiment()).collect();
    keys.sort_by_key(|key| {
        let table = key.path.split('.').next();
        TABLES.iter().position(|one| Some(*one) == table)
    });
    keys
});

#[rustfmt::skip]
fn of_experiment() -> Vec<Key<Scenario>> {
    identifier_log::keys! {
"plant": Table(Stated), Derived("required for a run; with it and without [log], a log to replay is one of a run of \
                                 this scenario"), "",
    "the true servo, q'' = -a q' + b u + load - coulomb sign q', with the position q in rad and the command u";
"plant.a": Number(Fixed(Allowed::Within(0.0, MAX_RATE)), Held(|s| &mut plant(s).a)), Required("0.5"), "1/s",
    "viscous friction over inertia: without command the speed decays as exp(-a t)";
"plant.b": Number(Fixed(Allowed::PositiveUpTo(MAX_RATE)), Held(|s| &mut plant(s).b)), Required("200.0"), "rad/s² per command unit",
    "acceleration per command unit";
"plant.load": Number(Fixed(Allowed::Within(-MAX_RATE, MAX_RATE)), Held(|s| &mut plant(s).load)), Value(0.0), "rad/s²",
    "acceleration by a constant load";
"plant.coulomb": Number(Fixed(Allowed::Within(0.0, MAX_RATE)), Held(|s| &mut plant(s).coulomb)), Value(0.0), "rad/s²",
    "deceleration by Coulomb friction";
"plant.delay": Number(DELAY, Held(|s| &mut s.effects.delay)), Value(0.0), "s",
    "time until a command acts, also fractions of a sample";
"plant.current_loop": Number(Fixed(Allowed::Within(0.0, Effects::SLOWEST_CURRENT_LOOP)), Held(|s| &mut s.effects.current_loop)),
    Value(0.0), "s", "time constant of the first-order lag of the acting command; 0 or at least a thousandth of the sample time";
"plant.asymmetry": Number(ANY, Held(|s| &mut s.effects.asymmetry)), Value(0.0), "1/s",
    "viscous friction is a + asymmetry forwards and a - asymmetry backwards; from -a to a";
"plant.low_speed_friction": Number(ANY, Held(|s| &mut s.effects.low_speed_friction)), Value(0.0), "rad/s²",
    "additional Coulomb friction s at low speed: s exp(-(q'/low_speed_velocity)²); at least -coulomb";
"plant.low_speed_velocity": Number(POSITIVE, Held(|s| &mut s.effects.low_speed_velocity)), Derived("none; required with low_speed_friction"), "rad/s",
    "the speed at which 37 % of it is left";
"plant.quadratic_friction": Number(Fixed(Allowed::Within(0.0, Effects::LARGEST_DRAG)), Held(|s| &mut s.effects.quadratic_friction)), Value(0.0), "1/rad",
    "additional drag, this value times q'², against the motion";
"plant.load_dependent_friction": Number(Fixed(Allowed::Within(0.0, Effects::LARGEST_SHARE)), Held(|s| &mut s.effects.load_dependent_friction)), Value(0.0), "",
    "additional Coulomb friction, as a share of the motor's acceleration |b u|, such as that of a gear under load";
"plant.gravity": Two(ANGULAR, Held(|s| &mut s.effects.gravity)), Derived("none"), "rad/s²",
    "[g_s, g_c]: acceleration by gravity, g_s sin q + g_c cos q, q being 0 where the servo starts";
"plant.ripple": Two(ANGULAR, Held(|s| &mut s.effects.ripple)), Derived("none"), "rad/s²",
    "[r_s, r_c]: acceleration by cogging, r_s sin Nq + r_c cos Nq";
"plant.ripple_order": Whole([1, Effects::HIGHEST_ORDER], Held(|s| &mut s.effects.ripple_order)), Derived("none; required with ripple"), "",
    "its order N, periods per revolution";
"plant.torque_ripple": Two(SHARE, Held(|s| &mut s.effects.torque_ripple)), Derived("none"), "",
    "[t_s, t_c]: b at an angle is b (1 + t_s sin Nq + t_c cos Nq)";
"plant.torque_ripple_order": Whole([1, Effects::HIGHEST_ORDER], Held(|s| &mut s.effects.torque_ripple_order)), Derived("none; required with torque_ripple"), "",
    "its order N, periods per revolution";
"plant.inertia_variation": Two(SHARE, Held(|s| &mut s.effects.inertia_variation)), Derived("none"), "",
    "[j_s, j_c]: the inertia at an angle is its mean times 1 + j_s sin Nq + j_c cos Nq; with two masses that of the \
     load";
"plant.inertia_order": Whole([1, Effects::HIGHEST_ORDER], Held(|s| &mut s.effects.inertia_order)), Derived("none; required with inertia_variation"), "",
    "its order N, periods per revolution";
"plant.gain_asymmetry": Number(SHARE, Held(|s| &mut s.effects.gain_asymmetry)), Value(0.0), "",
    "half the difference of b between positive and negative commands, as a share of b";
"plant.dead_band": Number(NOT_NEGATIVE, Held(|s| &mut s.effects.dead_band)), Value(0.0), "command units",
    "the part of a small command, of either sign, that the power stage does not pass";
"plant.resonance": Number(Fixed(Allowed::PositiveUpTo(Effects::HIGHEST_RESONANCE)), Held(|s| &mut s.effects.resonance)), Derived("none, one rigid body"), "rad/s",
    "resonance of motor and load coupled by a spring, both free; the encoder is on the motor, and so is friction but for load_friction";
"plant.resonance_damping": Number(Fixed(Allowed::Within(0.0, 1.0)), Optional(|s| &mut s.effects.resonance_damping)), Derived("0.02 with resonance"), "",
    "its damping ratio";
"plant.inertia_ratio": Number(Fixed(Allowed::Within(Effects::INERTIA_RATIOS[0], Effects::INERTIA_RATIOS[1])), Held(|s| &mut s.effects.inertia_ratio)), Derived("none; required with resonance"), "",
    "the load's share of the inertia";
"plant.load_friction": Number(NOT_NEGATIVE, Held(|s| &mut s.effects.load_friction)), Value(0.0), "rad/s²",
    "Coulomb friction of the load behind the spring, over the inertia of both; needs resonance";
"plant.backlash": Number(NOT_NEGATIVE, Held(|s| &mut s.effects.backlash)), Value(0.0), "rad",
    "backlash between the motor and an encoder on the load; with a resonance, backlash of the coupling";
"plant.gain_drift": Number(DRIFT, Held(|s| &mut s.effects.gain_drift)), Value(0.0), "1/s",
    "change of b per second, relative to its initial value";
"plant.friction_drift": Number(DRIFT, Held(|s| &mut s.effects.friction_drift)), Value(0.0), "1/s",
    "change of all friction per second, relative to its initial value";
"plant.hidden_limit": Number(POSITIVE, Held(|s| &mut s.effects.hidden_limit)), Derived("none"), "command units",
    "a limit of the amplifier that amplifier.limit does not state";
"plant.load_wander": Two(NOT_NEGATIVE, Held(|s| &mut s.effects.load_wander)), Derived("none"), "rad/s² and s",
    "[standard deviation, time constant] of an additional random load, seeded by run.seed";

"amplifier.brake": Table(Stated), Derived("none"), "",
    "holding brake of the axis, which power opens, at an output of its own; the drive holds the axis while it opens or closes";
"amplifier.brake.opens": Number(BRAKE, Held(|s| &mut brake(s)[0])), Required("0.05"), "s", "the longest that it takes to open";
"amplifier.brake.closes": Number(BRAKE, Held(|s| &mut brake(s)[1])), Required("0.1"), "s", "the longest that it takes to close";

"encoder.noise": Number(SENSOR_ERROR, Held(|s| &mut s.sensor.noise)), Value(0.0), "rad",
    "standard deviation of white noise before quantisation, in a run, seeded by run.seed";
"encoder.eccentricity": Number(SENSOR_ERROR, Held(|s| &mut s.sensor.eccentricity)), Value(0.0), "rad",
    "amplitude of an error once per revolution, in a run";
"encoder.jitter": Number(Fixed(Allowed::Within(0.0, SensorEffects::LARGEST_JITTER)), Held(|s| &mut s.sensor.jitter)), Value(0.0), "",
    "standard deviation of the sampling instant in a run, as a share of the sample time";

"excitation": Table(Always), Derived("the paper's"), "", "the reference that the servo follows";
"excitation.kind": OneOf(ExcitationKind::CHOICES, |s, i| s.excitation.kind = ExcitationKind::ALL[i], |s| s.excitation.kind as usize), FirstChoice, "", "kind of reference";
"excitation.power": Number(POSITIVE, Held(|s| &mut s.excitation.power)),
    Value(0.005), "rad² s", "power of the noise";
"excitation.sample_time": Number(Samples, Held(|s| &mut s.excitation.sample_time)),
    Value(0.1), "s", "time for which a value of the noise is held";
"excitation.seed": Whole([0, u32::MAX], Held(|s| &mut s.excitation.seed)),
    Value(1_212_121.0), "", "seed of the noise";
"excitation.amplitude": Number(POSITIVE, Held(|s| &mut s.excitation.amplitude)),
    Required("0.2"), "rad", "amplitude to either side";
"excitation.hold": Number(Samples, Held(|s| &mut s.excitation.hold)),
    Required("0.1"), "s", "time for which a bit or a level is held";
"excitation.order": Whole([2, 24], Held(|s| &mut s.excitation.order)),
    Value(9.0), "", "bits of the shift register";
"excitation.amplitudes": Numbers(POSITIVE, Held(|s| &mut s.excitation.amplitudes)),
    Required("[0.1, 0.05]"), "rad", "amplitude of each sine";
"excitation.frequencies": Numbers(BelowNyquist, Checked(set_frequencies, |s| Some(s.excitation.frequencies.clone()))),
    Required("[6.0, 20.0]"), "rad/s", "frequency of each sine, as many as amplitudes";
"excitation.from": Number(BelowNyquist, Held(|s| &mut s.excitation.from)),
    Required("2.0"), "rad/s", "start frequency";
"excitation.to": Number(BelowNyquist, Held(|s| &mut s.excitation.to)),
    Required("40.0"), "rad/s", "end frequency";
"excitation.duration": Number(Samples, Held(|s| &mut s.excitation.duration)),
    Required("5.0"), "s", "time of a sweep, after which it repeats";
"excitation.period": Number(EvenSamples, Held(|s| &mut s.excitation.period)),
    Required("1.0"), "s", "period of the square wave";
"excitation.levels": Numbers(ANY, Held(|s| &mut s.excitation.levels)),
    Required("[0.2, -0.2]"), "rad", "levels, one after the other";

"run": Table(Always), Derived("60 s"), "", "the simulated experiment";
"run.duration": Number(Duration, Held(|s| &mut s.duration)), Value(60.0), "s",
    "length of the run";
"run.seed": Whole([0, u32::MAX], Optional(|s| &mut s.seed)), Derived("that of the reference, or 1"), "",
    "seed of the random parts of servo and sensor; a sweep draws its own";

"fault": Tables(FAULTS), Derived("none"), "", "fault injection: each fault of the simulated servo in its own table";
"fault.kind": OneOf(fault_kinds(), |s, i| fault(s).kind = FaultKind::ALL[i], |s| fault(s).kind as usize), Required("\"actuator-weak\""), "", "kind \
                                                                                                                of \
                                                                                                                fault";
"fault.time": Number(NOT_NEGATIVE, Held(|s| &mut fault(s).time)), Required("5.0"), "s", "time from the first sample";
"fault.duration": Number(POSITIVE, Held(|s| &mut fault(s).duration)), Derived("for good"), "s", "how long";
"fault.size": Number(FAULT_SIZE, Held(|s| &mut fault(s).size)), Required("0.5"), "",
    "size: the counts of a jump, the share of the command that still acts, the load, or the added friction";

"compare": Table(Always), Derived("as below"), "", "the cases of a comparison";
"compare.load": Number(ANY, Optional(|s| &mut s.compare.load)), Derived("0.08 of plant.b"), "rad/s²", "the load";
"compare.coulomb": Number(NOT_NEGATIVE, Optional(|s| &mut s.compare.coulomb)), Derived("0.04 of plant.b"), "rad/s²", "the friction";
"compare.counts_per_rev": Number(POSITIVE, Held(|s| &mut s.compare.counts_per_rev)), Value(CompareSettings::COARSE), "", "the coarse encoder";
"compare.limit": Number(POSITIVE, Optional(|s| &mut s.compare.limit)), Derived("a ninth of kp"), "command units",
    "the amplifier that saturates";

"commission": Table(Stated), Derived("required for a commissioning"), "",
    "limits and goal of a commissioning";
"commission.travel": Reach(Held(|s| &mut order(s).settings.limits.travel)), Required("0.5"), "rad",
    "how far the servo may move from its present position";
"commission.speed": Number(POSITIVE, Held(|s| &mut order(s).settings.limits.speed)), Required("20.0"), "rad/s", "the largest speed";
"commission.command": Limit(Optional(|s| &mut order(s).command)), Derived("amplifier.limit; required without it"), "command units",
    "the largest command, at most amplifier.limit";
"commission.duration": Number(POSITIVE, Held(|s| &mut order(s).settings.limits.duration)), Value(Limits::DURATION), "s",
    "the longest time of a motion";
"commission.response_time": Number(POSITIVE, Optional(|s| &mut order(s).response_time)), Derived("none"), "s",
    "goal: the time from 10 to 90 % of a step of the reference";
"commission.bandwidth": Number(POSITIVE, Optional(|s| &mut order(s).bandwidth)), Derived("none"), "rad/s",
    "goal: the magnitude of the loop's poles";
"commission.max_sensitivity": Number(ABOVE_ONE, Held(|s| &mut order(s).settings.max_sensitivity)), Value(TuningSettings::MAX_SENSITIVITY), "",
    "the largest sensitivity of the loop; 1/max_sensitivity is its distance from instability";
"commission.trial_step": Number(POSITIVE, Optional(|s| &mut order(s).settings.trial_step)), Derived("half of the travel"), "rad",
    "the step of the reference in the trial";
"commission.feed_forward": Flag(Held(|s| &mut order(s).settings.feed_forward)), Derived("false"), "",
    "the gains may have a reference model with feed-forward, if the step then rises faster; not with response_time";
"commission.max_gain": Number(POSITIVE, Optional(|s| &mut order(s).settings.max_gain)), Derived("the highest b of \
                                                                                        identifier.servo_range; \
                                                                                        without it unknown"),
    "rad/s² per command unit", "the largest b that the servo may have: the first motion is planned for it";
"commission.command_delay": Number(Fixed(Allowed::Within(0.0, 0.1)), Optional(|s| &mut order(s).command_delay)), Derived("amplifier.delay"), "s",
    "known delay from the encoder reading to the change of the output; the rest is identified";
"commission.sample_time": Number(SAMPLE_TIME, Optional(|s| &mut order(s).sample_time)), Derived("controller.sample_time"), "s",
    "time from one sample to the next, for a scenario without [controller]";
    }
}

const FAULTS: Entries<Scenario> = Entries {
    max: Faults::MAX_FAULTS,
    begin: |s| {
        s.faults
            .push(InjectedFault::lasting(FaultKind::EncoderStuck, 0.0, 0.0));
    },
    check: |s| s.faults.last().map_or(Ok(()), InjectedFault::check),
};

/// The kinds of fault, each with its keys beside its time.
fn fault_kinds() -> &'static [Choice] {
    let choice = |kind: FaultKind| Choice {
        name: kind.name(),
        takes: match kind.sizes() {
            Some(_) if kind == FaultKind::EncoderJump => &["size"],
            Some(_) => &["duration", "size"],
            None => &["duration"],
        },
    };
    FaultKind::ALL.map(choice).to_vec().leak()
}

fn plant(s: &mut Scenario) -> &mut ServoParameters {
    s.plant.get_or_insert_default()
}

/// The fault that is being read.
fn fault(s: &mut Scenario) -> &mut InjectedFault {
    if s.faults.is_empty() {
        (FAULTS.begin)(s);
    }
    let last = s.faults.len() - 1;
    &mut s.faults[last]
}

fn brake(s: &mut Scenario) -> &mut [f64; 2] {
    s.brake.get_or_insert([0.0; 2])
}

/// The limit of the amplifier precedes it in the table.
fn order(s: &mut Scenario) -> &mut CommissionOrder {
    let amplifier = s.stated.controller.map(|controller| controller.limit);
    let limit = amplifier.filter(|limit| limit.iter().all(|end| end.is_finite()));
    s.commission
        .get_or_insert_with(|| CommissionOrder::blank(limit))
}

fn set_frequencies(s: &mut Scenario, frequencies: Vec<f64>) -> Result<(), String> {
    let (count, tones) = (frequencies.len(), s.excitation.amplitudes.len());
    if count != tones {
        return Err(format!("{count} frequencies for {tones} amplitudes"));
    }
    s.excitation.frequencies = frequencies;
    Ok(())
}
