//! Every key of a scenario file, what it may hold and what holds when it is absent.

/// One key.
#[derive(Debug, Clone, Copy)]
pub struct Key {
    /// Its path, table and key.
    pub path: &'static str,
    /// What is allowed.
    pub allowed: &'static str,
    /// What holds when it is absent.
    pub default: &'static str,
}

const fn key(path: &'static str, allowed: &'static str, default: &'static str) -> Key {
    Key {
        path,
        allowed,
        default,
    }
}

/// All keys, in the order of the documentation.
pub const KEYS: &[Key] = &[
    key(
        "plant",
        "a table with the true servo's a and b",
        "required to run; in a replay it says that the log is that of a run of this scenario",
    ),
    key("plant.a", "a number of at least 0, 1/s", "required"),
    key(
        "plant.b",
        "a number above 0, rad/s² per command unit",
        "required",
    ),
    key("plant.load", "any finite number, rad/s²", "0"),
    key("plant.coulomb", "a number of at least 0, rad/s²", "0"),
    key(
        "encoder",
        "a table with counts_per_rev",
        "10 000 counts; in a replay, the log's own resolution",
    ),
    key(
        "encoder.counts_per_rev",
        "a number of at least 0; 0 is an ideal sensor, in a replay the log's own resolution",
        "10000",
    ),
    key("amplifier", "a table with limit", "no limit"),
    key(
        "amplifier.limit",
        "of the controller's command: a number above 0 for |u| <= limit, or [low, high] with low below 0 and high above 0, \
         command units",
        "no limit",
    ),
    key(
        "controller",
        "a table with the PID",
        "the paper's; in a replay with log.command, none",
    ),
    key("controller.kp", "a number above 0 and at most 1e9", "9"),
    key("controller.kd", "a number from 0 to 1e9", "0.19"),
    key("controller.ki", "a number from 0 to 1e9", "4"),
    key(
        "controller.sample_time",
        "a number from 1e-7 to 10, s",
        "0.001; in a replay without a controller, the log's own",
    ),
    key(
        "controller.velocity_filter",
        "{ kind = \"low-pass\", cutoff = rad/s }, { kind = \"difference\" } or \
         { kind = \"averaged-difference\" }",
        "low-pass, 500 rad/s; in a replay without a controller, half the sample rate",
    ),
    key(
        "controller.velocity_filter.kind",
        "\"low-pass\", \"difference\" or \"averaged-difference\"",
        "\"low-pass\"",
    ),
    key(
        "controller.velocity_filter.cutoff",
        "with kind = \"low-pass\" only: a number above 0 and below pi/sample_time, rad/s",
        "500",
    ),
    key("excitation", "a table with the reference", "the paper's"),
    key(
        "excitation.kind",
        "\"band-limited-white-noise\", \"prbs\", \"multisine\", \"chirp\", \"square\", \"steps\" \
         or \"none\"",
        "\"band-limited-white-noise\"",
    ),
    key(
        "excitation.power",
        "a number above 0, rad² s (white noise)",
        "0.005",
    ),
    key(
        "excitation.sample_time",
        "a whole number of control samples, s (white noise)",
        "0.1",
    ),
    key(
        "excitation.seed",
        "a whole number from 0 to 4294967295 (white noise)",
        "1212121",
    ),
    key(
        "excitation.amplitude",
        "a number above 0, rad (prbs, chirp, square)",
        "required there",
    ),
    key(
        "excitation.hold",
        "a whole number of control samples, s (prbs, steps)",
        "required there",
    ),
    key(
        "excitation.order",
        "a whole number from 2 to 24 (prbs)",
        "9",
    ),
    key(
        "excitation.amplitudes",
        "1 to 16 numbers above 0, rad (multisine)",
        "required there",
    ),
    key(
        "excitation.frequencies",
        "as many numbers above 0 and below pi/sample_time, rad/s (multisine)",
        "required there",
    ),
    key(
        "excitation.from",
        "a number above 0 and below pi/sample_time, rad/s (chirp)",
        "required there",
    ),
    key(
        "excitation.to",
        "a number above 0 and below pi/sample_time, rad/s (chirp)",
        "required there",
    ),
    key(
        "excitation.duration",
        "a whole number of control samples, s (chirp)",
        "required there",
    ),
    key(
        "excitation.period",
        "an even number of control samples, s (square)",
        "required there",
    ),
    key(
        "excitation.levels",
        "1 to 16 finite numbers, rad (steps)",
        "required there",
    ),
    key("identifier", "a table with the law", "the Γ-gradient law"),
    key(
        "identifier.law",
        "\"gradient\", \"gauss-newton\", \"window\", \"pd-gradient\", \"relay-least-squares\", \
         \"proportional-least-squares\", \"two-degrees-of-freedom\", \
         \"multi-step-least-squares\", \"relay-cycle\", \"two-relays\", \"closed-loop-arx\" or \
         \"mechanical-least-squares\"",
        "\"gradient\"",
    ),
    key(
        "identifier.gamma",
        "the diagonal [g_a, g_b, ..] or the full symmetric positive definite matrix [[..], ..], in \
         the order of parameters (gradient)",
        "automatic",
    ),
    key(
        "identifier.mu",
        "a number above 0, 1/s (gradient)",
        "automatic",
    ),
    key(
        "identifier.parameters",
        "one or more of \"a\", \"b\", \"coulomb\" and \"load\", each once; the others stay at their \
         initial values; relay-least-squares: [\"a\", \"b\"]",
        "[\"a\", \"b\"]",
    ),
    key(
        "identifier.initial",
        "{ a = 1/s, b = rad/s² per command unit, coulomb = rad/s², load = rad/s² }, inside bounds",
        "{ a = 0, b = 50, coulomb = 0, load = 0 }; gauss-newton and window need none",
    ),
    key("identifier.initial.a", "a number inside bounds.a, 1/s", "0"),
    key(
        "identifier.initial.b",
        "a number above 0 inside bounds.b, rad/s² per command unit",
        "50; gauss-newton and window need none, unless b is not among parameters",
    ),
    key(
        "identifier.initial.coulomb",
        "a number inside bounds.coulomb, rad/s²",
        "0",
    ),
    key(
        "identifier.initial.load",
        "a number inside bounds.load, rad/s²",
        "0",
    ),
    key(
        "identifier.bounds",
        "{ a = [min, max], b = [min, max], coulomb = [min, max], load = [min, max] }",
        "as below",
    ),
    key(
        "identifier.bounds.a",
        "[min, max], both within 0.5/sample_time of 0, 1/s",
        "as wide as the sample time bears",
    ),
    key(
        "identifier.bounds.b",
        "[min, max] with min above 0, rad/s² per command unit",
        "as wide as the sample time and the gains bear",
    ),
    key(
        "identifier.bounds.coulomb",
        "[min, max] with min of at least 0, rad/s²",
        "from 0 to far beyond any servo; fixed, what plant_box and the command allow",
    ),
    key(
        "identifier.bounds.load",
        "[min, max], rad/s²",
        "far beyond any servo to both sides; fixed, what plant_box and the command allow",
    ),
    key(
        "identifier.plant_box",
        "{ a = [min, max], b = [min, max] } (gradient, pd-gradient)",
        "none: nothing is certified",
    ),
    key(
        "identifier.plant_box.a",
        "[min, max] with min of at least 0, 1/s",
        "required in plant_box",
    ),
    key(
        "identifier.plant_box.b",
        "[min, max] with min above 0, rad/s² per command unit",
        "required in plant_box",
    ),
    key(
        "identifier.correction",
        "{ kp, kd, ki }: the gains that pull the model to the servo (gradient, pd-gradient)",
        "the controller's, which make the model loop the paper's; without one, from plant_box and \
         bandwidth",
    ),
    key(
        "identifier.correction.kp",
        "a number above 0 and at most 1e9, command units per rad",
        "required in correction",
    ),
    key(
        "identifier.correction.kd",
        "a number from 0 to 1e9, command units per rad/s",
        "required in correction",
    ),
    key(
        "identifier.correction.ki",
        "a number from 0 to 1e9, command units per rad s",
        "required in correction",
    ),
    key(
        "identifier.bandwidth",
        "a number above 0 and at most 0.5/sample_time, rad/s: of the position loop, right within a \
         factor of four (gauss-newton, window; the gradient laws without controller and correction)",
        "from what the first fit finds; gradient laws, 0.05/sample_time",
    ),
    key(
        "identifier.max_speed",
        "a number above 0, rad/s: the fastest that the servo can move; a larger jump of the position \
         ends the run (gradient, pd-gradient, gauss-newton, window)",
        "what the number format counts exactly in a sample",
    ),
    key(
        "identifier.uncertainty",
        "{ a, b, coulomb, load }: standard deviations of the initial estimates (gauss-newton, window)",
        "nothing is known",
    ),
    key(
        "identifier.uncertainty.a",
        "a number above 0, 1/s",
        "nothing is known",
    ),
    key(
        "identifier.uncertainty.b",
        "a number above 0, rad/s² per command unit",
        "nothing is known",
    ),
    key(
        "identifier.uncertainty.coulomb",
        "a number above 0, rad/s²",
        "nothing is known",
    ),
    key(
        "identifier.uncertainty.load",
        "a number above 0, rad/s²",
        "nothing is known",
    ),
    key(
        "identifier.noise",
        "a number above 0, rad: standard deviation of the position noise (gauss-newton, window)",
        "an encoder count over the square root of 12",
    ),
    key(
        "identifier.start_time",
        "a number from 1e-4 to 1e4, s: the time over which the first fit looks (gauss-newton), the \
         length of the window (window)",
        "1; in a replay, no more than the log has",
    ),
    key(
        "identifier.memory",
        "a number of at least 2, s: how long a sample counts, for a servo that changes (gauss-newton)",
        "all that ever was",
    ),
    key(
        "identifier.arithmetic",
        "\"f32\", \"f64\" or \"fixed\" (gradient, pd-gradient)",
        "\"f32\"",
    ),
    key(
        "identifier.ranges",
        "{ error, velocity, command }: what the signals stay within (fixed)",
        "four times what the command limit lets the PID ask for",
    ),
    key(
        "identifier.ranges.error",
        "a number above 0, rad",
        "required in ranges",
    ),
    key(
        "identifier.ranges.velocity",
        "a number above 0, rad/s",
        "required in ranges",
    ),
    key(
        "identifier.ranges.command",
        "a number of at least the limit, command units",
        "required in ranges",
    ),
    key(
        "identifier.relay",
        "a number above 0, command units (laws with a relay)",
        "1",
    ),
    key(
        "identifier.relay_delay",
        "a number from 0 to 10, s (relay-cycle, two-relays)",
        "0.005",
    ),
    key(
        "identifier.forgetting",
        "a number above 0 and at most 1 (recursive least squares)",
        "0.999 for relay-least-squares and multi-step-least-squares, 0.9999 for the others",
    ),
    key(
        "identifier.filter_cutoff",
        "a number above 0 and below pi/sample_time, rad/s (least squares on filtered signals)",
        "50",
    ),
    key(
        "identifier.proportional_gain",
        "a number above 0, command units per rad (laws in a proportional loop)",
        "a twentieth of kp",
    ),
    key(
        "identifier.block",
        "a number above 0, s: the sample time of the model (multi-step-least-squares)",
        "0.02",
    ),
    key("run", "a table with duration", "60 s"),
    key(
        "run.duration",
        "a number of at least one and at most 10^10 control samples, s",
        "60",
    ),
    key(
        "compare",
        "a table with what the cases of a comparison are made of",
        "each has a default",
    ),
    key("compare.load", "a number, rad/s²", "0.08 of plant.b"),
    key(
        "compare.coulomb",
        "a number of at least 0, rad/s²",
        "0.04 of plant.b",
    ),
    key("compare.counts_per_rev", "a number above 0", "2000"),
    key(
        "compare.limit",
        "a number above 0, command units",
        "a ninth of kp",
    ),
    key(
        "log",
        "a table with the columns of a log",
        "those of the tool's own traces",
    ),
    key("log.time", "the name of a column, s", "required in log"),
    key(
        "log.reference",
        "the name of a column, rad",
        "none; required without log.command",
    ),
    key(
        "log.position",
        "the name of a column, rad",
        "required in log",
    ),
    key(
        "log.command",
        "the name of a column, command units: the whole command that acted from each row to the next",
        "the declared controller's, computed again",
    ),
    key(
        "log.injection",
        "the name of a column, command units: what was added to the declared controller's command \
         behind its limit",
        "none",
    ),
    key(
        "log.bridge_gaps",
        "a whole number: the most missing samples in a row that straight lines may bridge",
        "0",
    ),
];

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
#[must_use]
pub fn remedy(path: &str) -> Option<&'static str> {
    FORMER
        .iter()
        .find(|(former, _)| *former == path)
        .map(|(_, remedy)| *remedy)
}

/// What a key may hold.
#[must_use]
pub fn allowed(path: &str) -> Option<&'static str> {
    KEYS.iter()
        .find(|key| key.path == path)
        .map(|key| key.allowed)
}

/// The names of the keys of a table; of the tables for the empty path.
#[must_use]
pub fn children(table: &str) -> Vec<&'static str> {
    KEYS.iter()
        .filter_map(|key| match key.path.rsplit_once('.') {
            Some((parent, name)) => (parent == table).then_some(name),
            None => table.is_empty().then_some(key.path),
        })
        .collect()
}

/// All keys as a text for the help.
#[must_use]
pub fn listing() -> String {
    KEYS.iter()
        .filter(|key| key.path.contains('.'))
        .map(|key| {
            format!(
                "  {}\n      {}; default {}\n",
                key.path, key.allowed, key.default
            )
        })
        .collect()
}
