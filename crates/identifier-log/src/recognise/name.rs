//! The quantity and unit of a column by its name.

use super::unit::Unit;
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

/// A column's quantity and unit by its name.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Named {
    pub(super) quantity: Quantity,
    pub(super) unit: Option<Unit>,
    /// True if it says that it turns.
    pub(super) turns: bool,
    /// True if it says that this was measured, or that it is what should be.
    pub(super) is_measured: bool,
    pub(super) is_wanted: bool,
}

// Small letters without accents. What is of another script stands for every word that contains it.
#[rustfmt::skip]
const TIMES: &[&str] = &[
    "t", "time", "times", "timestamp", "stamp", "datetime", "date", "clock", "elapsed", "seconds", "millis", "micros",
    "zeit", "uhrzeit", "zeitstempel", "temps", "tiempo", "tempo", "时间", "時間", "时刻", "時刻", "시간", "врем",
];
#[rustfmt::skip]
const COUNTERS: &[&str] = &[
    "sample", "samples", "index", "idx", "n", "k", "row", "tick", "nr", "no", "seq", "cycle", "frame", "iteration",
];
#[rustfmt::skip]
const POSITIONS: &[&str] = &[
    "position", "positions", "pos", "q", "x", "lage", "posn", "count", "counts", "ticks", "actpos", "posicion", "posicao",
    "posizione", "位置", "위치", "положени", "позици",
];
/// Words for an angle, which is in no unit of length.
#[rustfmt::skip]
const ANGLES: &[&str] = &[
    "angle", "theta", "phi", "winkel", "angular", "rotation", "angulo", "angolo", "角度", "각도", "угол",
];
/// Words for what measures a shaft, or a length.
const ENCODERS: &[&str] = &["encoder", "enc"];
#[rustfmt::skip]
const REFERENCES: &[&str] = &[
    "reference", "ref", "r", "setpoint", "set", "sp", "sv", "target", "tgt", "desired", "des", "demand", "demanded", "goal",
    "soll", "consigna", "referencia", "objetivo", "consigne", "cible", "riferimento", "obiettivo", "alvo", "目标", "目標", "设定",
    "给定", "设定", "목표", "задан", "уставк", "цел",
];
#[rustfmt::skip]
const COMMANDS: &[&str] = &[
    "command", "commands", "cmd", "u", "voltage", "volt", "volts", "current", "cur", "i", "iq", "amps", "torque", "trq", "tau",
    "pwm", "duty", "effort", "control", "ctrl", "force", "output", "out", "mv", "input", "drive", "actuation", "stellgrosse",
    "stellgroesse", "stellwert", "spannung", "strom", "moment", "drehmoment", "corriente", "par", "tension", "comando", "courant",
    "couple", "commande", "corrente", "coppia", "tensione", "tensao", "binario", "电流", "電流", "转矩", "扭矩", "力矩", "トルク", "电压",
    "電圧", "指令", "전류", "토크", "전압", "지령", "ток", "момент", "напряжени", "команд",
];
/// Words that mark a position or a velocity as commanded.
#[rustfmt::skip]
const COMMANDED: &[&str] = &[
    "command", "commands", "commanded", "cmd", "comando", "commande", "指令", "지령", "команд",
];
/// Words that mark a value as measured.
#[rustfmt::skip]
const MEASURED: &[&str] = &[
    "actual", "act", "measured", "meas", "feedback", "fb", "filtered", "raw", "ist", "pv", "实际", "実際", "실제",
];
#[rustfmt::skip]
const VELOCITIES: &[&str] = &[
    "velocity", "vel", "velo", "speed", "omega", "w", "v", "qd", "dq", "qdot", "rpm", "tach", "tacho", "drehzahl",
    "geschwindigkeit", "velocidad", "velocidade", "vitesse", "velocita", "速度", "转速", "속도", "скорост",
];
#[rustfmt::skip]
const OTHERS: &[&str] = &[
    "acceleration", "acc", "accel", "qdd", "ddq", "jerk", "error", "err", "e", "deviation", "temperature", "temp", "status", "state", "flag",
    "mode", "fault", "enable", "enabled", "bus", "supply", "vbus", "per", "std", "id", "regelabweichung", "temperatur",
    "temperatura", "beschleunigung", "加速度", "误差", "誤差", "温度", "가속", "오차", "ошибк", "ускорен",
];

/// True for words of which one is in a table.
fn is_among(words: &[String], table: &[&str]) -> bool {
    words.iter().any(|word| {
        table
            .iter()
            .any(|of| word == of || (!of.is_ascii() && word.contains(of)))
    })
}

/// The words of a name as the tables have them: small, without accents, and the German for what is wanted by itself.
fn folded(name: &str) -> Vec<String> {
    let letter = |letter: char| match letter {
        'á' | 'à' | 'â' | 'ã' | 'ä' => 'a',
        'é' | 'è' | 'ê' => 'e',
        'í' | 'ì' => 'i',
        'ó' | 'ò' | 'ô' | 'õ' | 'ö' => 'o',
        'ú' | 'ù' | 'ü' => 'u',
        'ç' => 'c',
        other => other,
    };
    let mut folded = Vec::new();
    for word in words(name) {
        let word: String = word
            .to_lowercase()
            .replace('ß', "ss")
            .chars()
            .map(letter)
            .collect();
        let compound = ["soll", "ist"]
            .into_iter()
            .find_map(|of| Some((of, word.strip_prefix(of)?)));
        match compound {
            Some((of, rest)) => folded.extend([of.to_owned(), rest.to_owned()]),
            None => folded.push(word),
        }
    }
    folded
}

/// The quantity and unit of a column with a name, and perhaps a cell in a row of units.
pub(super) fn of_column(name: &str, unit_cell: &str) -> Named {
    let (rest, stated) = bracketed(name);
    let stated = if unit_cell.is_empty() {
        stated
    } else {
        Some(unit_cell)
    };
    let (rest, unit) = match stated.map(|text| text.trim_matches(['[', ']', '(', ')', ' '])) {
        Some("" | "-") => (rest, None),
        Some(text) => {
            let is_rate = text.contains('/') || text.contains("per") || text.contains('^');
            let unit = Unit::of_text(text).or(is_rate.then_some(Unit::Foreign));
            (rest, unit)
        }
        None => with_unit(rest),
    };
    let words = folded(rest);
    let has = |table: &[&str]| is_among(&words, table);
    let by_name = quantity(
        rest,
        &words,
        unit.or_else(|| Unit::of_text(name).filter(|unit| *unit != Unit::Time(TimeUnit::Hour))),
    );
    // A column with another unit, as rad/s², is none of these quantities, and a position in rad/s none.
    let quantity = match (unit, by_name) {
        (Some(Unit::Foreign), _) if !has(OTHERS) => Quantity::Velocity,
        (Some(Unit::Rate(..) | Unit::Electrical), Quantity::Position | Quantity::Unknown) => {
            Quantity::Velocity
        }
        _ => by_name,
    };
    let fits = |unit: &Unit| match unit {
        Unit::Time(_) => matches!(quantity, Quantity::Time | Quantity::Counter),
        Unit::Position(PositionUnit::Metre | PositionUnit::Millimetre, _) if has(ANGLES) => false,
        Unit::Position(..) => matches!(quantity, Quantity::Position | Quantity::Reference),
        Unit::Rate(..) => matches!(quantity, Quantity::Velocity | Quantity::Reference),
        Unit::Command(..) => quantity == Quantity::Command,
        Unit::Electrical | Unit::Doubtful => true,
        Unit::Foreign => false,
    };
    Named {
        quantity,
        unit: unit.filter(fits),
        turns: has(ANGLES) || has(ENCODERS),
        is_measured: has(MEASURED),
        is_wanted: has(REFERENCES) || has(COMMANDED),
    }
}

/// A name without the unit at its end, and that: the longest that is one, behind a word of the name.
fn with_unit(name: &str) -> (&str, Option<Unit>) {
    /// Words of the longest unit: rad per s.
    const LONGEST: usize = 3;
    let is_between = |c: char| c.is_whitespace() || "_-.:".contains(c);
    let ends: Vec<usize> = (name.match_indices(is_between))
        .map(|(place, _)| place)
        .collect();
    for &place in ends.iter().skip(ends.len().saturating_sub(LONGEST)) {
        let (rest, unit) = name.split_at(place);
        let unit = unit.trim_start_matches(is_between);
        if let Some(unit) = Unit::of_text(unit).filter(|_| !rest.is_empty()) {
            return (rest, Some(unit));
        }
    }
    // As in posDeg, but a letter before a unit would be a prefix.
    let last = name.rsplit(is_between).next().unwrap_or_default();
    let pieces = words(last);
    if let [.., before, unit] = &pieces[..]
        && before.chars().count() > 1
        && let Some(found) = Unit::of_text(unit)
        && let Some(rest) = name.strip_suffix(unit.as_str())
    {
        return (rest, Some(found));
    }
    // A velocity in one word, as rpm.
    let whole = Unit::of_text(name).filter(|unit| matches!(unit, Unit::Rate(..)));
    (name, whole)
}

/// True for a word that says of a value what it is for, not which joint has it.
pub(super) fn is_role(word: &str) -> bool {
    let word = folded(word);
    [REFERENCES, COMMANDED, MEASURED]
        .iter()
        .any(|table| is_among(&word, table))
}

fn quantity(name: &str, words: &[String], unit: Option<Unit>) -> Quantity {
    let has = |table: &[&str]| is_among(words, table);
    let is_time = has(TIMES);
    // V by itself is a voltage, v a velocity; N may be a counter.
    if let Some(Unit::Command(unit, _)) = unit
        && name == unit
        && name != "N"
    {
        return Quantity::Command;
    }
    if has(OTHERS) {
        return Quantity::Other;
    }
    // A position command is a reference, and so is a target position; an output angle is none.
    let is_wanted = has(REFERENCES) || has(COMMANDED);
    let is_position = !is_time && [POSITIONS, ANGLES, ENCODERS].iter().any(|table| has(table));
    if has(VELOCITIES) || is_position {
        return match (is_wanted, has(VELOCITIES)) {
            (true, _) => Quantity::Reference,
            (false, true) => Quantity::Velocity,
            (false, false) => Quantity::Position,
        };
    }
    // A set-point of the current is a command of the servo.
    if has(COMMANDS) {
        return Quantity::Command;
    }
    if has(REFERENCES) {
        return match unit {
            Some(Unit::Command(..)) => Quantity::Command,
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
        Some(Unit::Position(..)) => Quantity::Position,
        Some(Unit::Rate(..) | Unit::Electrical) => Quantity::Velocity,
        Some(Unit::Command(..)) => Quantity::Command,
        Some(Unit::Foreign | Unit::Doubtful) | None => Quantity::Unknown,
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

#[cfg(test)]
mod tests {
    use super::Quantity::{Command, Counter, Other, Position, Reference, Time, Unknown, Velocity};
    use super::{Unit, of_column};
    use crate::scenario::{PositionUnit, TimeUnit};

    #[test]
    fn names_as_drives_and_loggers_write_them_are_known() {
        let of_command = |name| Some(Unit::Command(name, 1.0));
        let time = |unit| Some(Unit::Time(unit));
        let angle = |unit| Some(Unit::Position(unit, 1.0));
        let rate = |unit| Some(Unit::Rate(unit, 1.0));
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
            ("omega_rad_s", Velocity, rate(PositionUnit::Radian)),
            ("output_velocity", Velocity, None),
            ("torque_enable", Other, None),
            ("velocity [rad/s]", Velocity, rate(PositionUnit::Radian)),
            ("angle [rad/s]", Velocity, rate(PositionUnit::Radian)),
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

    #[test]
    fn a_unit_is_read_whole_or_not_at_all() {
        let angle = |part| Some(Unit::Position(PositionUnit::Radian, part));
        let degree = |part| Some(Unit::Position(PositionUnit::Degree, part));
        let metre = |part| Some(Unit::Position(PositionUnit::Metre, part));
        let millimetre = |part| Some(Unit::Position(PositionUnit::Millimetre, part));
        let turns = |part| Some(Unit::Rate(PositionUnit::Turn, part));
        let rate = |part| Some(Unit::Rate(PositionUnit::Radian, part));
        let command = |unit, part| Some(Unit::Command(unit, part));
        let time = |unit| Some(Unit::Time(unit));
        /// Of each quantity: names in several languages, units as written, and what they are.
        type Family<'a> = (&'a [&'a str], &'a [(&'a str, Option<Unit>)]);
        let families: [Family<'_>; 5] = [
            (
                &["torque", "tau", "effort", "Drehmoment", "cmd_torque"],
                &[
                    ("Nm", command("N m", 1.0)),
                    ("mNm", command("N m", 1e-3)),
                    ("cNm", command("N m", 1e-2)),
                    ("kNm", command("N m", 1e3)),
                    ("uNm", command("N m", 1e-6)),
                    ("xNm", Some(Unit::Doubtful)),
                    ("lbft", None),
                ],
            ),
            (
                &["current", "iq", "Strom", "motor_current", "u"],
                &[
                    ("A", command("A", 1.0)),
                    ("mA", command("A", 1e-3)),
                    ("cA", command("A", 1e-2)),
                    ("uA", command("A", 1e-6)),
                    ("mV", command("V", 1e-3)),
                    ("kV", command("V", 1e3)),
                    ("millivolts", command("V", 1e-3)),
                    ("mX", None),
                ],
            ),
            (
                &["time", "t", "Zeit", "temps", "tiempo"],
                &[
                    ("s", time(TimeUnit::Second)),
                    ("ms", time(TimeUnit::Millisecond)),
                    ("us", time(TimeUnit::Microsecond)),
                    ("µs", time(TimeUnit::Microsecond)),
                    ("ns", time(TimeUnit::Nanosecond)),
                    ("min", time(TimeUnit::Minute)),
                    ("h", time(TimeUnit::Hour)),
                    ("milliseconds", time(TimeUnit::Millisecond)),
                    ("ks", None),
                    ("0.1ms", Some(Unit::Doubtful)),
                ],
            ),
            (
                &["pos", "x", "Lage", "position", "q"],
                &[
                    ("rad", angle(1.0)),
                    ("mrad", angle(1e-3)),
                    ("urad", angle(1e-6)),
                    ("deg", degree(1.0)),
                    ("mdeg", degree(1e-3)),
                    ("arcsec", degree(1.0 / 3600.0)),
                    ("arcmin", degree(1.0 / 60.0)),
                    ("mm", millimetre(1.0)),
                    ("cm", metre(1e-2)),
                    ("µm", metre(1e-6)),
                    ("um", metre(1e-6)),
                    ("inch", millimetre(25.4)),
                    ("furlong", None),
                ],
            ),
            (
                &["omega", "speed", "Drehzahl", "vel", "geschwindigkeit"],
                &[
                    ("rad/s", rate(1.0)),
                    ("mrad/s", rate(1e-3)),
                    ("rad per s", rate(1.0)),
                    ("rad/min", rate(1.0 / 60.0)),
                    ("rpm", turns(1.0 / 60.0)),
                    ("krpm", turns(1e3 / 60.0)),
                    ("U/min", turns(1.0 / 60.0)),
                    ("1/min", turns(1.0 / 60.0)),
                    ("min^-1", turns(1.0 / 60.0)),
                    ("min⁻¹", turns(1.0 / 60.0)),
                    ("rev/s", turns(1.0)),
                    ("mm/s", Some(Unit::Rate(PositionUnit::Millimetre, 1.0))),
                    ("erpm", Some(Unit::Electrical)),
                    ("rad/s^2", None),
                    ("1/s", None),
                ],
            ),
        ];
        let part = |unit: Option<Unit>| match unit {
            Some(Unit::Position(_, part) | Unit::Rate(_, part) | Unit::Command(_, part)) => part,
            _ => 1.0,
        };
        let bare = |unit: Option<Unit>| match unit {
            Some(Unit::Position(unit, _)) => Some(Unit::Position(unit, 1.0)),
            Some(Unit::Rate(unit, _)) => Some(Unit::Rate(unit, 1.0)),
            Some(Unit::Command(unit, _)) => Some(Unit::Command(unit, 1.0)),
            other => other,
        };
        let mut headings = 0;
        for (names, units) in families {
            for name in names {
                for &(written, expected) in units {
                    let joined = written.replace(['/', ' '], "_");
                    for heading in [
                        format!("{name} [{written}]"),
                        format!("{name} ({written})"),
                        format!("{name}_{joined}"),
                        format!("{name} in {written}"),
                    ] {
                        let is_power = written.contains(['^', '1', '⁻', '.']);
                        if heading.contains('_') && is_power && !heading.contains('[') {
                            continue;
                        }
                        headings += 1;
                        let found = of_column(&heading, "").unit;
                        let off = part(found) / part(expected) - 1.0;
                        assert!(
                            bare(found) == bare(expected) && off.abs() < 1e-12,
                            "{heading}: {found:?} instead of {expected:?}"
                        );
                    }
                }
            }
        }
        assert!(headings > 800, "{headings}");
    }

    #[test]
    fn names_in_ten_languages_are_known() {
        /// Time, position, goal, command, velocity.
        #[rustfmt::skip]
        const HEADINGS: [[&str; 5]; 14] = [
            ["time", "position", "target position", "torque command", "velocity"],
            ["t", "PosAct", "PosCmd", "TrqCmd", "velo"],
            ["Zeit", "Istposition", "Sollwert", "Stellgröße", "Drehzahl"],
            ["Uhrzeit", "Lage", "Sollwinkel", "Sollstrom", "Geschwindigkeit"],
            ["temps", "position", "consigne de position", "consigne de courant", "vitesse"],
            ["tiempo", "posición", "consigna", "corriente", "velocidad"],
            ["tempo", "posizione", "riferimento", "coppia", "velocità"],
            ["tempo", "posição", "referência", "tensão", "velocidade"],
            ["时间", "实际位置", "目标位置", "电流指令", "速度"],
            ["時間", "位置", "目標位置", "トルク指令", "速度"],
            ["시간", "위치", "목표 위치", "전류 지령", "속도"],
            ["время", "положение", "заданное положение", "момент", "скорость"],
            ["Time", "angle", "SP", "MV", "tacho_V"],
            ["timestamp", "encoder", "set", "Cur", "speed"],
        ];
        let expected = [Time, Position, Reference, Command, Velocity];
        for names in HEADINGS {
            let found = names.map(|name| of_column(name, "").quantity);
            assert_eq!(found, expected, "{names:?}");
        }
        for name in ["加速度", "误差", "Regelabweichung", "ошибка"] {
            assert_eq!(of_column(name, "").quantity, Other, "{name}");
        }
    }

    #[test]
    fn a_letter_is_a_unit_only_of_the_quantity_that_the_name_says() {
        for heading in [
            "theta_m", "i_a", "u_m", "u_s", "q_h", "v_A", "angle_mm", "pos_V",
        ] {
            assert_eq!(of_column(heading, "").unit, None, "{heading}");
        }
        let of = |unit| Some(Unit::Position(unit, 1.0));
        assert_eq!(of_column("posDeg", "").unit, of(PositionUnit::Degree));
        assert_eq!(of_column("posMDeg", "").unit, Some(Unit::Doubtful));
        assert_eq!(of_column("h", "").quantity, Unknown);
        // A scale of glass is an encoder in mm.
        assert_eq!(
            of_column("encoder_mm", "").unit,
            of(PositionUnit::Millimetre)
        );
    }
}
