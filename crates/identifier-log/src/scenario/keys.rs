//! The keys of a log's tables: a line each, in the order in which they are read.
//!
//! A line has the key's path, the kind of its value with its place in the document, the default, the unit and the
//! meaning. Reading, messages, help and schema all follow from it.

use std::sync::LazyLock;

use identifier_core::control::{FeedForwardSettings, Gains};
use identifier_core::error::Allowed;
use identifier_core::parameters::{Parameter, PerParameter};
use identifier_core::settings::{
    ControllerSettings, IdentifierSettings, ParameterRangeSettings, RangeSettings,
};
use identifier_core::units::Units;

use super::kind::Default::{Derived, FirstChoice, Initial, Required, Value};
use super::kind::Kind::{
    Choice as OneOf, Column as ColumnOf, Limit, Number, Numbers, Pair, Pairs, Parameters, Table,
    Terms as TermList, Two, Whole,
};
use super::kind::Place::{Checked, Held, Optional};
use super::kind::When::{Always, InRun, Simulated, Stated};
use super::kind::{Choice, Key, When, nearest};
use super::range::Range::{self, BelowNyquist, Fixed, HalfRadian};
use super::{
    Arithmetic, Column, CommandUnit, Document, Estimator, InnerLoop, Integrator, LogSettings,
    Options, PositionUnit, RivalSettings, TimeUnit, Velocity,
};

/// The paper's cut-off of the velocity filter, rad/s.
const CUTOFF: f64 = 500.0;

const ANY: Range = Fixed(Allowed::Finite);
const COUNTS: Range = Fixed(Allowed::Within(0.0, 1e9));
const POSITIVE: Range = Fixed(Allowed::Above(0.0));
const NOT_NEGATIVE: Range = Fixed(Allowed::AtLeast(0.0));
const GAIN: Range = Fixed(Allowed::Within(0.0, Gains::LARGEST));
const POSITIVE_GAIN: Range = Fixed(Allowed::PositiveUpTo(Gains::LARGEST));
/// From the shortest to the longest sample time.
pub const SAMPLE_TIME: Range = Fixed(Allowed::Within(
    Units::SAMPLE_TIMES.0,
    Units::SAMPLE_TIMES.1,
));
const TYPICAL: RivalSettings = RivalSettings::TYPICAL;

/// Keys, a line each.
#[macro_export]
macro_rules! keys {
    ($($path:literal: $kind:expr, $default:expr, $unit:literal, $about:literal;)*) => {
        vec![$($crate::scenario::Key {
            path: $path, kind: $kind, default: $default, unit: $unit, about: $about,
        }),*]
    };
}

/// The keys of a log's tables.
#[must_use]
#[rustfmt::skip]
pub fn of_log<S: AsMut<Options>>() -> Vec<Key<S>> {
    keys! {
"encoder": Table(Simulated), Derived("10000 counts; in a replay of another log, its own resolution"), "", "the position sensor";
"encoder.counts_per_rev": Number(COUNTS, Checked(set_counts, |s| Some(s.as_mut().counts_per_rev.unwrap_or(0.0)))), Value(10_000.0), "",
    "counts per revolution after ×4 quadrature; 0 is an ideal sensor, in a replay the log's own resolution";

"amplifier": Table(Always), Derived("no limit"), "", "what drives the motor";
"amplifier.delay": Number(Fixed(Allowed::Within(0.0, 0.1)), Held(|s| &mut given(s).terms.delay)), Value(0.0), "s",
    "known delay from the command to the motor: computation, amplifier and bus; estimators with a model take it into \
     account, and the term delay starts there";
"amplifier.dead_band": Number(NOT_NEGATIVE, Held(|s| &mut given(s).terms.dead_band)), Value(0.0), "command units",
    "known dead band of the power stage, to either side; the term dead-band starts there";
"amplifier.current_loop": Number(Fixed(Allowed::Within(0.0, 0.1)), Held(|s| &mut given(s).terms.current_loop)), Value(0.0), "s",
    "known time constant of the current loop, with which the motor's current follows the command";
"amplifier.limit": Limit(Held(|s| &mut pid(s).limit)), Derived("no limit"), "command units",
    "limit of the controller's command, |u| <= limit or low <= u <= high";

"controller": Table(InRun), Derived("the paper's; in a replay of another log, none"), "",
    "the PID that closes the loop, u = kp e - kd v + ki T times the sum of the earlier e";
"controller.kp": Number(POSITIVE_GAIN, Held(|s| &mut pid(s).kp)), Value(9.0), "command units per rad",
    "proportional gain";
"controller.kd": Number(GAIN, Held(|s| &mut pid(s).kd)), Value(0.19), "command units per rad/s",
    "derivative gain, on the measured velocity";
"controller.ki": Number(GAIN, Held(|s| &mut pid(s).ki)), Value(4.0), "command units per rad s",
    "integral gain";
"controller.reference_filter": Number(NOT_NEGATIVE, Held(|s| &mut pid(s).reference_filter)), Value(0.0), "s",
    "time constant of a first-order filter of the reference before the PID, 0 for none";
"controller.notch": Number(NOT_NEGATIVE, Held(|s| &mut pid(s).notch)), Value(0.0), "rad/s",
    "notch filter of the command, 0 for none";
"controller.feed_forward": Table(Stated), Derived("none"), "",
    "a reference model, y = r/(1 + s/bandwidth)³, with feed-forward; not in fixed point";
"controller.feed_forward.bandwidth": Number(POSITIVE, Held(|s| &mut lead(s).bandwidth)), Required("60.0"), "rad/s",
    "magnitude of the model's three poles, from 1e-5 to 1 per sample";
"controller.feed_forward.acceleration": Number(GAIN, Held(|s| &mut lead(s).acceleration)), Required("0.005"), "command units per rad/s²",
    "command for its acceleration, 1/b";
"controller.feed_forward.velocity": Number(GAIN, Held(|s| &mut lead(s).velocity)), Value(0.0), "command units per rad/s",
    "command for its velocity, a/b; that for kd is added to it";
"controller.feed_forward.coulomb": Number(GAIN, Held(|s| &mut lead(s).coulomb)), Value(0.0), "command units",
    "command for Coulomb friction, with the sign of its velocity";
"controller.feed_forward.coulomb_speed": Number(POSITIVE, Held(|s| &mut lead(s).coulomb_speed)), Value(LEAST_LEAD.coulomb_speed), "rad/s",
    "speed below which that command is linear through zero";
"controller.sample_time": Number(SAMPLE_TIME, Held(|s| &mut loop_of(s).stated.sample_time)), Value(1e-3), "s",
    "time from one control sample to the next; in a replay without a controller, the log's own";
"controller.velocity_filter": Table(Always), Derived("low-pass, 500 rad/s; in a replay without a controller, half the sample rate"), "",
    "how the velocity is taken from the counts, { kind = \"low-pass\", cutoff = 500.0 }";
"controller.velocity_filter.kind": OneOf(Velocity::CHOICES, |s, i| loop_of(s).velocity = Velocity::ALL[i], |s| loop_of(s).velocity as usize), FirstChoice, "", "kind of velocity estimate";
"controller.velocity_filter.cutoff": Number(BelowNyquist, Held(|s| &mut loop_of(s).stated.cutoff)), Value(CUTOFF), "rad/s",
    "cut-off of the low-pass; of a slow loop by default half of what is allowed";

"identifier": Table(Always), Derived("the gradient estimator"), "", "what is identified, and how";
"identifier.law": OneOf(Estimator::CHOICES, |s, i| s.as_mut().identifier.set_estimator(Estimator::ALL[i]), |s| s.as_mut().identifier.law as usize), FirstChoice, "", "the method";
"identifier.parameters": Parameters(Checked(choose, chosen)), Derived("[\"a\", \"b\"], or those that the method finds"), "",
    "what is estimated; the others stay at their initial values";
"identifier.arithmetic": OneOf(Arithmetic::CHOICES, |s, i| s.as_mut().identifier.arithmetic = Arithmetic::ALL[i], |s| s.as_mut().identifier.arithmetic as usize), FirstChoice, "",
    "number format of the loop; \"fixed\" exists for gradient, paper and pd-gradient";
"identifier.gamma": Numbers(POSITIVE, Checked(weigh, weights)), Derived("automatic, from parameter range and reference"), "",
    "adaptation gain of each of the parameters, the diagonal of the matrix of (11)";
"identifier.mu": Number(POSITIVE, Optional(|s| &mut given(s).mu)), Derived("automatic, from gains and parameter range"), "1/s",
    "weight of the output error against its derivative in (11)";
"identifier.initial": Table(Always), Derived("as below"), "", "initial estimates, inside the bounds";
"identifier.initial.a": Number(ANY, Optional(|s| &mut given(s).initial.a)), Initial(0.0), "1/s", "initial estimate of a";
"identifier.initial.b": Number(POSITIVE, Optional(|s| &mut given(s).initial.b)), Initial(50.0), "rad/s² per command unit",
    "initial estimate of b; an estimator that fits needs one only if b is not among parameters";
"identifier.initial.coulomb": Number(ANY, Optional(|s| &mut given(s).initial.coulomb)), Initial(0.0), "rad/s²",
    "initial estimate of the Coulomb friction";
"identifier.initial.load": Number(ANY, Optional(|s| &mut given(s).initial.load)), Initial(0.0), "rad/s²",
    "initial estimate of the load";
"identifier.bounds": Table(Always), Derived("as below"), "", "bounds of the estimates";
"identifier.bounds.a": Pair(ANY, Optional(|s| &mut given(s).bounds.a)), Derived("as wide as the sample time permits"), "1/s",
    "bounds of a, both within 0.5/sample_time of 0";
"identifier.bounds.b": Pair(POSITIVE, Optional(|s| &mut given(s).bounds.b)),
    Derived("as wide as sample time and gains permit"), "rad/s² per command unit", "bounds of b";
"identifier.bounds.coulomb": Pair(NOT_NEGATIVE, Optional(|s| &mut given(s).bounds.coulomb)),
    Derived("from 0 to far beyond any servo; in fixed point the range that follows from servo_range and command"), "rad/s²",
    "bounds of the Coulomb friction";
"identifier.bounds.load": Pair(ANY, Optional(|s| &mut given(s).bounds.load)),
    Derived("far beyond any servo in both directions; in fixed point the range that follows from servo_range and command"), "rad/s²",
    "bounds of the load";
"identifier.servo_range": Table(Stated), Derived("none, and nothing is certified"), "",
    "the parameter range of the true servo: the loop is certified for all of it";
"identifier.servo_range.a": Pair(NOT_NEGATIVE, Held(|s| &mut within(s).a)), Required("[0.0, 50.0]"), "1/s",
    "lowest and highest a of the servo";
"identifier.servo_range.b": Pair(POSITIVE, Held(|s| &mut within(s).b)), Required("[110.0, 1000.0]"), "rad/s² per command unit",
    "lowest and highest b of the servo";
"identifier.correction": Table(Stated),
    Derived("the controller's gains, as in the paper; without a controller, from servo_range and bandwidth"), "",
    "the gains of the correction, which keeps the model close to the servo";
"identifier.correction.kp": Number(POSITIVE_GAIN, Held(|s| &mut correction(s)[0])), Required("9.0"), "command units per rad",
    "proportional gain of the correction";
"identifier.correction.kd": Number(GAIN, Held(|s| &mut correction(s)[1])), Required("0.19"), "command units per rad/s",
    "derivative gain of the correction";
"identifier.correction.ki": Number(GAIN, Held(|s| &mut correction(s)[2])), Required("4.0"), "command units per rad s",
    "integral gain of the correction";
"identifier.bandwidth": Number(HalfRadian, Optional(|s| &mut given(s).bandwidth)),
    Derived("from the first fit; gradient estimators, 0.05/sample_time"), "rad/s",
    "bandwidth of the position loop, to within a factor of four; gradient estimators use it without controller and \
     correction";
"identifier.max_speed": Number(POSITIVE, Optional(|s| &mut given(s).max_speed)),
    Derived("what the number format represents exactly in a sample"), "rad/s",
    "the highest speed of the servo; a larger jump of the position ends the run";
"identifier.noise": Number(POSITIVE, Optional(|s| &mut given(s).noise)), Derived("an encoder count over the square root of 12"), "rad",
    "smallest standard deviation of the position noise; a larger one is estimated";
"identifier.start_time": Number(Fixed(Allowed::Within(1e-4, 1e4)), Optional(|s| &mut given(s).start_time)),
    Derived("1; in a replay, no more than the log has"), "s",
    "the time span of the first fit";
"identifier.memory": Number(Fixed(Allowed::AtLeast(2.0)), Optional(|s| &mut given(s).memory)), Derived("all samples"), "s",
    "memory of the estimates, for a servo that changes";
"identifier.required_terms": TermList(Held(|s| &mut given(s).terms.demanded)), Derived("none"), "",
    "optional terms of the model that are estimated as soon as the motion allows";
"identifier.low_speed_velocity": Number(POSITIVE, Optional(|s| &mut given(s).terms.low_speed_velocity)),
    Derived("none; required with the term low-speed"), "rad/s", "speed at which the low-speed friction has fallen to \
                                                                 1/e";
"identifier.ripple_order": Number(POSITIVE, Optional(|s| &mut given(s).terms.ripple_order)),
    Derived("none; required with the term ripple"), "", "periods of the ripple per revolution";
"identifier.revolution": Number(POSITIVE, Held(|s| &mut given(s).terms.revolution)), Value(std::f64::consts::TAU), "rad",
    "travel after which gravity and ripple repeat, for a linear axis a pole pitch";
"identifier.ranges": Table(Stated), Derived("four times what the PID can demand within the command limit"), "",
    "range of the signals in fixed point";
"identifier.ranges.error": Number(POSITIVE, Held(|s| &mut ranges(s).error)), Required("1.0"), "rad", "largest position error";
"identifier.ranges.velocity": Number(POSITIVE, Held(|s| &mut ranges(s).velocity)), Required("100.0"), "rad/s", "largest velocity";
"identifier.ranges.command": Number(POSITIVE, Held(|s| &mut ranges(s).command)), Required("10.0"), "command units",
    "largest command, at least the limit";
"identifier.relay": Number(POSITIVE, Held(|s| &mut s.as_mut().identifier.rival.relay)), Value(TYPICAL.relay), "command units",
    "command of the relay to either side";
"identifier.forgetting": Number(Fixed(Allowed::PositiveUpTo(1.0)), Held(|s| &mut s.as_mut().identifier.rival.forgetting)),
    Value(TYPICAL.forgetting), "", "forgetting factor per sample";
"identifier.filter_cutoff": Number(BelowNyquist, Held(|s| &mut s.as_mut().identifier.rival.filter_cutoff)), Value(TYPICAL.filter_cutoff), "rad/s",
    "cut-off of the filters of position and command; in a slow loop half of the allowed one by default";

"inner": Table(Stated), Derived("none: log.command or [controller] gives it"), "",
    "the position loop of a servo that takes goals: it computes the log's command, u = kp (log.reference - q) - kd v";
"inner.kp": Number(POSITIVE_GAIN, Held(|s| &mut inner(s).kp)), Required("40.0"), "command units per rad", "its proportional gain";
"inner.kd": Number(GAIN, Held(|s| &mut inner(s).kd)), Value(0.0), "command units per rad/s", "its derivative gain, on the velocity";
"inner.limit": Limit(Held(|s| &mut inner(s).limit)), Derived("no limit"), "command units", "limit of its command, |u| <= limit or low <= u <= high";
"inner.sample_time": Number(Fixed(Allowed::PositiveUpTo(1.0)), Optional(|s| &mut inner(s).sample_time)), Derived("that of the log"), "s",
    "its own sample time, or a simulator's step; the log's is a whole multiple of it, and the position in between is \
     interpolated";
"inner.integrator": OneOf(Integrator::CHOICES, |s, i| inner(s).integrator = Integrator::ALL[i], |s| inner(s).integrator as usize), FirstChoice, "",
    "how its command becomes motion: held for a sample as a drive holds it (none), or by MuJoCo's integrator Euler (euler), implicit or implicitfast (implicit)";
"inner.cutoff": Number(POSITIVE, Optional(|s| &mut inner(s).cutoff)), Derived("none: the velocity is log.velocity, or the difference of two positions"), "rad/s",
    "cut-off of the low-pass derivative that is its velocity";

"physical": Table(Stated), Derived("none: a result is ratios"), "", "converts a result into physical units";
"physical.command_unit": OneOf(CommandUnit::CHOICES, |s, i| s.as_mut().physical.command_unit = CommandUnit::ALL[i], |s| s.as_mut().physical.command_unit as usize), FirstChoice, "",
    "unit of the command: with \"V\" a result has the feed-forward kS, kV, kA and kG, with \"Nm\" and \"N\" (a linear axis) inertia and friction";
"physical.torque_constant": Number(POSITIVE, Optional(|s| &mut s.as_mut().physical.torque_constant)), Derived("1 with the command unit \"Nm\" or \"N\", otherwise none"), "N·m per command unit",
    "torque of a unit of command at the joint: torque constant times gear ratio and efficiency";
"physical.inertia": Number(POSITIVE, Optional(|s| &mut s.as_mut().physical.inertia)), Derived("none"), "kg·m²",
    "total inertia about the joint, if that is known instead";
"physical.payload": Number(POSITIVE, Optional(|s| &mut s.as_mut().physical.payload)), Derived("none"), "kg·m²",
    "inertia about the joint of an attached payload, if neither is known: it needs bare_gain";
"physical.bare_gain": Two(NOT_NEGATIVE, Optional(|s| &mut s.as_mut().physical.bare_gain)), Derived("none"), "rad/s² per command unit",
    "b without the payload, and its standard error";

"log": Table(Stated), Derived("the columns of the tool's own traces"), "", "the columns of a log to replay, by name or by number from 1";
"log.time": ColumnOf(Optional(|s| &mut log(s).time)), Derived("none: each row is a sample of log.sample_time"), "in time_unit",
    "time of a row";
"log.time_unit": OneOf(TimeUnit::CHOICES, |s, i| log(s).units.time = TimeUnit::ALL[i], |s| log(s).units.time as usize), FirstChoice, "", "unit of log.time; \"samples\" is a counter of them, \"iso-8601\" a time stamp such as 2026-11-22T06:25:00.125Z, or the time of day alone";
"log.sample_time": Number(SAMPLE_TIME, Optional(|s| &mut log(s).sample_time)), Derived("controller.sample_time; \
                                                                                      without a controller, from \
                                                                                      log.time"), "s",
    "time from one sample of the log to the next";
"log.reference": ColumnOf(Optional(|s| &mut log(s).reference)), Derived("none; required without log.command"), "in reference_unit",
    "reference position";
"log.reference_unit": OneOf(REFERENCE_UNITS, |s, i| log(s).units.reference = i.checked_sub(1).map(|i| PositionUnit::ALL[i]),
    |s| log(s).units.reference.map_or(0, |unit| 1 + unit as usize)), FirstChoice, "",
    "unit of log.reference; \"as-position\" uses position_scale as well";
"log.reference_scale": Number(ANY, Held(|s| &mut log(s).units.reference_scale)), Value(1.0), "",
    "reference_unit per unit of the column; below 0 for the other direction";
"log.position": ColumnOf(Held(|s| &mut log(s).position)), Required("\"position_rad\""), "in position_unit", "measured position";
"log.measured": OneOf(MEASURED, |s, i| log(s).is_velocity = i == 1, |s| usize::from(log(s).is_velocity)), FirstChoice, "",
    "whether log.position is the position, or the velocity, which is then integrated";
"log.position_unit": OneOf(PositionUnit::CHOICES, |s, i| log(s).units.position = PositionUnit::ALL[i], |s| log(s).units.position as usize), FirstChoice, "",
    "unit of log.position; for a linear axis \"m\" or \"mm\": read m for rad everywhere";
"log.angle": OneOf(ANGLES, |s, i| log(s).absolute = i == 1, |s| usize::from(log(s).absolute)), FirstChoice, "",
    "whether position zero is the same angle in every recording (absolute), or the start of a counter; gravity needs \
     an absolute angle";
"log.position_scale": Number(ANY, Held(|s| &mut log(s).units.position_scale)), Value(1.0), "",
    "position_unit per unit of the column, such as \"turns\" and 0.2 for mm on a screw with 5 mm per revolution; \
     below 0 for the other direction";
"log.command": ColumnOf(Optional(|s| &mut log(s).command)), Derived("the declared controller's, computed again"), "scaled by command_scale",
    "the total command that acted from each row to the next";
"log.known_torque": ColumnOf(Optional(|s| &mut log(s).known_torque)), Derived("none"), "N·m, of a linear axis N",
    "known torque that acts on the joint beside the command, positive if it moves the position up, such as gravity by a model; needs the torque of a unit of command";
"log.command_scale": Number(ANY, Held(|s| &mut log(s).units.command_scale)), Value(1.0), "",
    "command units per unit of the column, such as 0.24 for percent of a 24 V power stage; below 0 for the other \
     direction";
"log.velocity": ColumnOf(Optional(|s| &mut log(s).velocity)), Derived("none"), "position_unit per s, times position_scale",
    "measured velocity, on which [inner] acts";
"log.bridge_gaps": Whole([0, u32::MAX], Held(|s| &mut log(s).bridge)), Value(0.0), "",
    "largest number of missing samples in a row that are interpolated linearly";
"log.cut": Pairs(ANY, Checked(|s, v| log(s).leave_out(&v), |s| Some(log(s).cut.clone()).filter(|cut| !cut.is_empty()))), Derived("nothing is left out"), "s",
    "ranges of the log's time that are left out";
"log.wrap": Number(NOT_NEGATIVE, Optional(|s| &mut log(s).wrap)), Derived("detected: a position that wraps after a \
                                                                         revolution is unwrapped"), "in position_unit, before position_scale",
    "period after which the position wraps, such as 360 for degrees; 0 if it does not wrap";
    }
}

/// The units of a reference, that of the position first.
const REFERENCE_UNITS: &[Choice] = &{
    const UNITS: &[Choice] = PositionUnit::CHOICES;
    let mut units = [Choice::plain("as-position"); 1 + UNITS.len()];
    let mut i = 0;
    while i < UNITS.len() {
        units[i + 1] = UNITS[i];
        i += 1;
    }
    units
};

const MEASURED: &[Choice] = &[Choice::plain("position"), Choice::plain("velocity")];
const ANGLES: &[Choice] = &[Choice::plain("relative"), Choice::plain("absolute")];

fn pid<S: AsMut<Options>>(s: &mut S) -> &mut ControllerSettings {
    let none = ControllerSettings::pid(0.0, 0.0, 0.0);
    s.as_mut().stated.controller.get_or_insert(none)
}

/// The options of a declared controller.
fn loop_of<S: AsMut<Options>>(s: &mut S) -> &mut Options {
    pid(s);
    s.as_mut()
}

fn set_counts<S: AsMut<Options>>(s: &mut S, counts: f64) -> Result<(), String> {
    s.as_mut().counts_per_rev = (counts > 0.0).then_some(counts);
    Ok(())
}

/// Before its keys are read.
const LEAST_LEAD: FeedForwardSettings = FeedForwardSettings {
    bandwidth: 0.0,
    acceleration: 0.0,
    velocity: 0.0,
    coulomb: 0.0,
    coulomb_speed: 0.1,
};

fn lead<S: AsMut<Options>>(s: &mut S) -> &mut FeedForwardSettings {
    pid(s).feed_forward.get_or_insert(LEAST_LEAD)
}

fn given<S: AsMut<Options>>(s: &mut S) -> &mut IdentifierSettings {
    &mut s.as_mut().stated.identifier
}

fn within<S: AsMut<Options>>(s: &mut S) -> &mut ParameterRangeSettings {
    given(s)
        .parameter_range
        .get_or_insert(ParameterRangeSettings {
            a: [0.0; 2],
            b: [0.0; 2],
        })
}

fn correction<S: AsMut<Options>>(s: &mut S) -> &mut [f64; 3] {
    given(s).correction.get_or_insert([0.0; 3])
}

fn ranges<S: AsMut<Options>>(s: &mut S) -> &mut RangeSettings {
    given(s).ranges.get_or_insert(RangeSettings {
        error: 0.0,
        velocity: 0.0,
        command: 0.0,
    })
}

fn inner<S: AsMut<Options>>(s: &mut S) -> &mut InnerLoop {
    s.as_mut().inner.get_or_insert(InnerLoop::proportional(0.0))
}

fn log<S: AsMut<Options>>(s: &mut S) -> &mut LogSettings {
    s.as_mut()
        .log
        .get_or_insert_with(|| LogSettings::with_position(Column::Number(1)))
}

fn choose<S: AsMut<Options>>(s: &mut S, parameters: Vec<Parameter>) -> Result<(), String> {
    s.as_mut().identifier.law.check_parameters(&parameters)?;
    s.as_mut().identifier.parameters = parameters;
    Ok(())
}

/// The chosen parameters, if they are not those that the estimator finds by default.
fn chosen<S: AsMut<Options>>(s: &mut S) -> Option<Vec<Parameter>> {
    let own = &s.as_mut().identifier;
    (own.parameters != own.law.default_parameters()).then(|| own.parameters.clone())
}

/// Spreads the entries for the chosen parameters over all four.
fn weigh<S: AsMut<Options>>(s: &mut S, entries: Vec<f64>) -> Result<(), String> {
    let parameters = &s.as_mut().identifier.parameters;
    let (given, count) = (entries.len(), parameters.len());
    if given != count {
        return Err(format!("{given} entries for {count} parameters"));
    }
    let entry = |of| {
        let place = parameters.iter().position(|&chosen| chosen == of);
        place.map_or(1.0, |place| entries[place])
    };
    let gamma = PerParameter::from_fn(entry);
    s.as_mut().stated.identifier.gamma = Some(gamma);
    Ok(())
}

/// The entries for the chosen parameters.
fn weights<S: AsMut<Options>>(s: &mut S) -> Option<Vec<f64>> {
    let gamma = s.as_mut().stated.identifier.gamma?;
    let parameters = s.as_mut().identifier.parameters.iter();
    Some(parameters.map(|&of| gamma.get(of)).collect())
}

/// All keys as a text for the help.
#[must_use]
pub fn listing<S: Document>() -> String {
    let leaves = S::keys().iter().filter(|key| !key.is_table());
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

impl<S: Document> Key<S> {
    /// The line of a path.
    #[must_use]
    pub fn at(path: &str) -> Option<&'static Self> {
        S::keys().iter().find(|key| key.path == path)
    }

    /// The most likely key for a name or a path, in any table.
    #[must_use]
    pub fn nearest(word: &str) -> Option<&'static Self> {
        let named = S::keys().iter().find(|key| key.place().1 == word);
        named.or_else(|| Self::at(nearest(word, S::keys().iter().map(|key| key.path))?))
    }

    /// The keys of a table; for the empty path, the tables.
    pub fn children(table: &str) -> impl Iterator<Item = &'static Self> {
        S::keys().iter().filter(move |key| key.place().0 == table)
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

impl Document for Options {
    fn keys() -> &'static [Key<Self>] {
        static KEYS: LazyLock<Vec<Key<Options>>> = LazyLock::new(of_log);
        &KEYS
    }

    fn holds(&self, when: When, _: &dyn Fn(&str) -> bool) -> bool {
        when == Always
    }
}
