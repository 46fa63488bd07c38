//! The quantity and unit of a column by its name.

use crate::scenario::{PositionUnit, TimeUnit};

/// The quantity in a column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Quantity {
    Time,
    /// A counter of samples.
    Counter,
    Position,
    Reference,
    Command,
    Velocity,
    /// A quantity that no fit takes: error, temperature, estimates.
    Other,
    /// Nothing in the name says which.
    Unknown,
}

/// A unit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Unit {
    Time(TimeUnit),
    Position(PositionUnit),
    /// The unit of a command in its written form.
    Command(&'static str),
}

/// A column's quantity and unit by its name.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Named {
    pub(super) quantity: Quantity,
    pub(super) unit: Option<Unit>,
}

#[rustfmt::skip]
const TIMES: &[&str] = &[
    "t", "time", "times", "timestamp", "stamp", "datetime", "date", "clock", "elapsed", "seconds", "millis", "micros",
    "zeit", "uhrzeit", "zeitstempel", "temps", "tiempo", "tempo",
];
const COUNTERS: &[&str] = &[
    "sample", "samples", "index", "idx", "n", "k", "row", "tick", "nr", "no",
];
#[rustfmt::skip]
const POSITIONS: &[&str] = &[
    "position", "positions", "pos", "angle", "theta", "phi", "encoder", "enc", "q", "x", "winkel", "lage", "posn", "count",
    "counts", "ticks", "angular", "rotation", "actpos",
];
#[rustfmt::skip]
const REFERENCES: &[&str] = &[
    "reference", "ref", "r", "setpoint", "set", "sp", "target", "tgt", "desired", "des", "demand", "demanded", "goal",
    "soll", "sollwert", "sollposition",
];
#[rustfmt::skip]
const COMMANDS: &[&str] = &[
    "command", "commands", "cmd", "u", "voltage", "volt", "volts", "current", "i", "iq", "amps", "torque", "tau", "pwm", "duty",
    "effort", "control", "ctrl", "force", "output", "input", "drive", "actuation", "stellgroesse", "spannung", "strom",
    "moment", "drehmoment",
];
/// Words that mark a position or a velocity as commanded.
const COMMANDED: [&str; 4] = ["command", "commands", "commanded", "cmd"];
/// Words that mark a value as measured.
const MEASURED: &[&str] = &[
    "actual", "act", "measured", "meas", "feedback", "fb", "filtered", "raw", "ist",
];
#[rustfmt::skip]
const VELOCITIES: &[&str] = &[
    "velocity", "vel", "speed", "omega", "w", "v", "qd", "dq", "qdot", "rpm", "drehzahl", "geschwindigkeit",
];
#[rustfmt::skip]
const OTHERS: &[&str] = &[
    "acceleration", "acc", "accel", "qdd", "ddq", "jerk", "error", "err", "e", "deviation", "temperature", "temp", "status", "state", "flag",
    "mode", "fault", "enable", "enabled", "bus", "supply", "vbus", "per", "std", "id",
];

/// The quantity and unit of a column with a name, and perhaps a cell in a row of units.
pub(super) fn of_column(name: &str, unit_cell: &str) -> Named {
    let (rest, stated) = bracketed(name);
    let is_number = |word: &str| word.starts_with(|c: char| c.is_ascii_digit());
    let mut words = words(rest);
    words.retain(|word| !is_number(word));
    let stated = if unit_cell.is_empty() {
        stated
    } else {
        Some(unit_cell)
    };
    // A column with another unit, as rad/s, is none of these quantities.
    let (unit, is_foreign) = match stated.map(|text| text.trim_matches(['[', ']', '(', ')', ' '])) {
        Some("" | "-") => (None, false),
        Some(text) => {
            let unit = unit(text);
            let is_rate = text.contains('/') || text.contains("per") || text.contains('^');
            (unit, unit.is_none() && is_rate)
        }
        None if words.len() > 1 => {
            // M1 is a motor, no metre.
            let is_numbered = |word: &String| rest.split(word.as_str()).skip(1).any(is_number);
            let last = words.last().filter(|last| !is_numbered(last));
            let unit = last.and_then(|last| unit(last));
            if unit.is_some() {
                words.pop();
            }
            (unit, false)
        }
        None => (None, false),
    };
    let quantity = match is_foreign {
        true if words
            .iter()
            .any(|word| OTHERS.contains(&word.to_lowercase().as_str())) =>
        {
            Quantity::Other
        }
        true => Quantity::Velocity,
        false => quantity(&words, unit.or_else(|| self::unit(name.trim()))),
    };
    let fits = match unit {
        Some(Unit::Time(_)) => matches!(quantity, Quantity::Time | Quantity::Counter),
        Some(Unit::Position(_)) => matches!(quantity, Quantity::Position | Quantity::Reference),
        Some(Unit::Command(_)) => quantity == Quantity::Command,
        None => true,
    };
    let unit = unit.filter(|_| fits);
    Named { quantity, unit }
}

/// The unit of a velocity by the name of its column or a cell of units: that of a position per s, how many of these are
/// one of it, and the evidence.
pub(super) fn rate(name: &str, unit_cell: &str) -> Option<(PositionUnit, f64, &'static str)> {
    /// Units that a name may hold anywhere, and those that end it: in its middle they may be letters of a word.
    type Rates = (
        PositionUnit,
        f64,
        &'static str,
        &'static [&'static str],
        &'static [&'static str],
    );
    #[rustfmt::skip]
    const RATES: [Rates; 7] = [
        (PositionUnit::Turn, 1.0 / 60.0, "from rpm, by name", &["rpm", "rev/min", "1/min"], &[]),
        (PositionUnit::Turn, 1.0, "by name", &["rev/s", "turn/s", "turns/s"], &["rps", "hz"]),
        (PositionUnit::Degree, 1.0, "by name", &["deg/s", "deg_s", "°/s", "degps"], &["dps"]),
        (PositionUnit::Radian, 1.0, "by name", &["rad/s", "rad_s", "radps", "rad_per_s"], &["rads"]),
        (PositionUnit::Count, 1.0, "by name", &["counts/s", "counts_s", "counts_per_s", "ticks/s"], &[]),
        (PositionUnit::Millimetre, 1.0, "by name", &["mm/s"], &["mm_s"]),
        (PositionUnit::Metre, 1.0, "by name", &[], &["m/s", "m_s"]),
    ];
    let texts = [name, unit_cell].map(|text| {
        let text = text.to_lowercase();
        text.trim_end_matches([']', ')', '}', ' ']).to_owned()
    });
    let ends = |text: &str, word: &str| {
        text.strip_suffix(word)
            .is_some_and(|rest| !rest.ends_with(char::is_alphanumeric))
    };
    let holds = |(_, _, _, within, at_end): &&Rates| {
        texts.iter().any(|text| {
            within.iter().any(|word| text.contains(word))
                || at_end.iter().any(|word| ends(text, word))
        })
    };
    RATES
        .iter()
        .find(holds)
        .map(|(unit, scale, evidence, ..)| (*unit, *scale, *evidence))
}

/// True for a word that says of a value what it is for, not which joint has it.
pub(super) fn is_role(word: &str) -> bool {
    let word = word.to_lowercase();
    [REFERENCES, &COMMANDED, MEASURED]
        .iter()
        .any(|words| words.contains(&word.as_str()))
}

fn quantity(words: &[String], unit: Option<Unit>) -> Quantity {
    let has = |of: &[&str]| {
        words
            .iter()
            .any(|word| of.contains(&word.to_lowercase().as_str()))
    };
    let is_time = has(TIMES);
    // V by itself is a voltage, v a velocity; N may be a counter.
    if let ([only], Some(Unit::Command(unit))) = (words, unit)
        && only == unit
        && only != "N"
    {
        return Quantity::Command;
    }
    if has(OTHERS) {
        return Quantity::Other;
    }
    if has(VELOCITIES) {
        return match has(REFERENCES) || has(&COMMANDED) {
            true => Quantity::Reference,
            false => Quantity::Velocity,
        };
    }
    if has(POSITIONS) && !is_time {
        // A position command is a reference, and so is a target position; an output angle is none.
        return match has(REFERENCES) || has(&COMMANDED) {
            true => Quantity::Reference,
            false => Quantity::Position,
        };
    }
    // A set-point of the current is a command of the servo.
    if has(COMMANDS) {
        return Quantity::Command;
    }
    if has(REFERENCES) {
        return match unit {
            Some(Unit::Command(_)) => Quantity::Command,
            _ => Quantity::Reference,
        };
    }
    if is_time {
        return Quantity::Time;
    }
    if has(COUNTERS) {
        return Quantity::Counter;
    }
    match unit {
        Some(Unit::Time(_)) => Quantity::Time,
        Some(Unit::Position(_)) => Quantity::Position,
        Some(Unit::Command(_)) => Quantity::Command,
        None => Quantity::Unknown,
    }
}

/// A name without the unit in brackets at its end, and that unit.
fn bracketed(name: &str) -> (&str, Option<&str>) {
    let end = name.trim_end();
    for (open, close) in [('[', ']'), ('(', ')'), ('{', '}')] {
        if let Some(inside) = end.strip_suffix(close)
            && let Some((rest, unit)) = inside.rsplit_once(open)
        {
            return (rest, Some(unit.trim()));
        }
    }
    match end.rsplit_once(" in ") {
        Some((rest, unit)) => (rest, Some(unit.trim())),
        None => (end, None),
    }
}

/// The words and numbers of a name: divided where a letter follows none, and where a capital follows a small letter.
pub(super) fn words(name: &str) -> Vec<String> {
    let kind = |letter: char| match letter {
        _ if letter.is_alphabetic() || "°%µ".contains(letter) => 'a',
        _ if letter.is_ascii_digit() => '0',
        _ => ' ',
    };
    let mut words: Vec<String> = Vec::new();
    let mut last = ' ';
    for letter in name.chars() {
        let begins = kind(letter) != kind(last) || (letter.is_uppercase() && last.is_lowercase());
        if begins {
            words.push(String::new());
        }
        if let Some(word) = words.last_mut() {
            word.push(letter);
        }
        last = letter;
    }
    words.retain(|word| word.chars().all(|letter| kind(letter) != ' '));
    words
}

/// The unit of a word.
fn unit(word: &str) -> Option<Unit> {
    if let Some(unit) = TimeUnit::of_word(word) {
        return Some(Unit::Time(unit));
    }
    if let Some(unit) = PositionUnit::of_word(word) {
        return Some(Unit::Position(unit));
    }
    let of_command = match word {
        "V" | "volt" | "volts" | "Volt" | "Volts" => "V",
        "mV" => "mV",
        "A" | "amp" | "amps" | "Ampere" | "ampere" => "A",
        "mA" => "mA",
        "Nm" | "nm" | "N m" | "N·m" | "N.m" => "N m",
        "N" => "N",
        "%" | "percent" => "%",
        _ => return None,
    };
    Some(Unit::Command(of_command))
}

#[cfg(test)]
mod tests {
    use super::Quantity::{Command, Counter, Other, Position, Reference, Time, Unknown, Velocity};
    use super::{Unit, of_column};
    use crate::scenario::{PositionUnit, TimeUnit};

    #[test]
    fn names_as_drives_and_loggers_write_them_are_known() {
        let of_command = |name| Some(Unit::Command(name));
        let time = |unit| Some(Unit::Time(unit));
        let angle = |unit| Some(Unit::Position(unit));
        for (name, quantity, unit) in [
            ("t", Time, None),
            ("t_s", Time, time(TimeUnit::Second)),
            ("Time (ms)", Time, time(TimeUnit::Millisecond)),
            ("timestamp_us", Time, time(TimeUnit::Microsecond)),
            ("sample", Counter, None),
            ("q_m", Position, angle(PositionUnit::Metre)),
            ("q_ref_m", Reference, angle(PositionUnit::Metre)),
            ("vir_V", Command, of_command("V")),
            ("position_rad", Position, angle(PositionUnit::Radian)),
            ("reference_rad", Reference, angle(PositionUnit::Radian)),
            ("actualPosition", Position, None),
            ("output_angle", Position, None),
            ("Position Command", Reference, None),
            ("/position_controller/commands[0]", Reference, None),
            ("/effort_controller/commands[0]", Command, None),
            ("feedback.positions", Position, None),
            ("error.positions", Other, None),
            ("enc counts", Position, angle(PositionUnit::Count)),
            ("motor current [A]", Command, of_command("A")),
            ("iq_ref", Command, None),
            ("duty %", Command, of_command("%")),
            ("u", Command, None),
            ("omega_rad_s", Velocity, None),
            ("output_velocity", Velocity, None),
            ("torque_enable", Other, None),
            ("velocity [rad/s]", Velocity, None),
            ("angle [rad/s]", Velocity, None),
            ("acceleration [rad/s^2]", Other, None),
            ("output_error_rad", Other, None),
            ("a_std_error", Other, None),
            ("b_rad_per_s2_per_command", Other, None),
            ("channel1", Unknown, None),
            ("A1", Unknown, None),
            ("pos_M1", Position, None),
            ("V", Command, None),
            ("deg", Position, None),
            ("goal [deg]", Reference, angle(PositionUnit::Degree)),
        ] {
            let found = of_column(name, "");
            assert_eq!((found.quantity, found.unit), (quantity, unit), "{name}");
        }
        assert_eq!(of_column("q", "deg").unit, angle(PositionUnit::Degree));
        assert_eq!(of_column("ch3", "V").quantity, Command);
    }
}
