//! Units as headings write them: a prefix, a unit, and perhaps a time that it is per. One is read whole, or not at all.

use crate::scenario::{PositionUnit, TimeUnit};

/// A unit, and how many of it are one of what is written.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Unit {
    Time(TimeUnit),
    Position(PositionUnit, f64),
    /// Of a velocity: that of a position, per s.
    Rate(PositionUnit, f64),
    /// Of a command, in its written form.
    Command(&'static str, f64),
    /// Of the field's revolutions, of which a shaft has so many as poles in pairs.
    Electrical,
    /// Of none of these: an acceleration.
    Foreign,
    /// Something like a unit that is none: what is behind a letter or a number is one.
    Doubtful,
}

/// How a base is written: its words in small letters, those in exactly these letters, and whether prefixes go with it.
struct Base {
    unit: Unit,
    words: &'static [&'static str],
    letters: &'static [&'static str],
    has_prefixes: bool,
}

const fn base(
    unit: Unit,
    words: &'static [&'static str],
    letters: &'static [&'static str],
    has_prefixes: bool,
) -> Base {
    Base {
        unit,
        words,
        letters,
        has_prefixes,
    }
}

const TURN: PositionUnit = PositionUnit::Turn;
const PER_MINUTE: f64 = 1.0 / 60.0;

#[rustfmt::skip]
const BASES: [Base; 21] = [
    base(Unit::Time(TimeUnit::Second), &["sec", "secs", "second", "seconds"], &["s", "S"], true),
    base(Unit::Time(TimeUnit::Minute), &["min", "mins", "minute", "minutes"], &[], false),
    base(Unit::Time(TimeUnit::Hour), &["hr", "hour", "hours"], &["h"], false),
    base(Unit::Position(PositionUnit::Radian, 1.0), &["rad", "rads", "radian", "radians"], &[], true),
    base(Unit::Position(PositionUnit::Degree, 1.0), &["deg", "degs", "degree", "degrees", "°", "grad"], &[], true),
    base(Unit::Position(PositionUnit::Degree, PER_MINUTE), &["arcmin"], &[], false),
    base(Unit::Position(PositionUnit::Degree, PER_MINUTE / 60.0), &["arcsec"], &[], false),
    base(Unit::Position(TURN, 1.0), &["turn", "turns", "rev", "revs", "revolutions", "rotations", "umdr"], &["U"], false),
    base(Unit::Position(PositionUnit::Count, 1.0), &["count", "counts", "cnt", "cts", "ticks", "pulses", "inc"], &[], false),
    base(Unit::Position(PositionUnit::Metre, 1.0), &["metre", "metres", "meter", "meters"], &["m"], true),
    base(Unit::Position(PositionUnit::Millimetre, 1.0), &["mm", "millimetres", "millimeters"], &[], false),
    base(Unit::Position(PositionUnit::Millimetre, 25.4), &["inch", "inches"], &[], false),
    base(Unit::Command("V", 1.0), &["volt", "volts"], &["V"], true),
    base(Unit::Command("A", 1.0), &["amp", "amps", "ampere", "amperes"], &["A"], true),
    base(Unit::Command("N m", 1.0), &["nm", "n·m", "n.m"], &[], true),
    base(Unit::Command("N", 1.0), &["newton", "newtons"], &["N"], true),
    base(Unit::Command("%", 1.0), &["%", "percent"], &[], false),
    base(Unit::Rate(TURN, PER_MINUTE), &["rpm"], &[], true),
    base(Unit::Rate(TURN, 1.0), &["rps", "hz"], &[], false),
    base(Unit::Rate(PositionUnit::Degree, 1.0), &["dps"], &[], false),
    base(Unit::Electrical, &["erpm"], &[], false),
];

/// Prefixes; the words first, since they begin with the letters.
#[rustfmt::skip]
const PREFIXES: [(&str, f64); 12] = [
    ("milli", 1e-3), ("micro", 1e-6), ("nano", 1e-9), ("centi", 1e-2), ("kilo", 1e3),
    ("m", 1e-3), ("u", 1e-6), ("µ", 1e-6), ("μ", 1e-6), ("n", 1e-9), ("c", 1e-2), ("k", 1e3),
];

impl Unit {
    /// The unit that a text is as a whole, or a doubtful one.
    pub(super) fn of_text(text: &str) -> Option<Self> {
        Self::of_whole(text).or_else(|| {
            let unit = text.trim_start_matches(|c: char| c.is_ascii_digit() || "., ".contains(c));
            let is_counted = unit.len() < text.len();
            let unit = match is_counted {
                true => unit,
                // A name may end like a unit of time: rms, bus.
                false => &unit[unit.chars().next()?.len_utf8()..],
            };
            let found = Self::of_whole(unit).filter(|_| unit.chars().count() > 1)?;
            (is_counted || !matches!(found, Self::Time(_))).then_some(Self::Doubtful)
        })
    }

    fn of_whole(text: &str) -> Option<Self> {
        let text = text.trim().replace("⁻¹", "^-1").replace('²', "^2");
        let whole = Self::of_word(&text);
        if whole.is_some() {
            return whole;
        }
        // What is one per minute is a speed in revolutions.
        if let Some(time) = text.strip_suffix("-1") {
            let time = Self::of_word(time.trim_end_matches('^'))?;
            return (time == Self::Time(TimeUnit::Minute)).then_some(Self::Rate(TURN, PER_MINUTE));
        }
        let words: Vec<&str> = text.split([' ', '_', '/', '*']).collect();
        let words: Vec<&str> = words.into_iter().filter(|word| !word.is_empty()).collect();
        match words[..] {
            [one, metre @ "m"] => {
                // A newton times a metre is a torque, and so is one of thousandths.
                Self::of_word(&format!("{one}{metre}")).filter(|_| one.ends_with('N'))
            }
            [one, "per", time] | [one, time] => Self::per(one, time),
            _ => None,
        }
    }

    /// A unit per time.
    fn per(one: &str, time: &str) -> Option<Self> {
        let squared = ["^2", "2"]
            .iter()
            .find_map(|power| time.strip_suffix(power));
        if let Some(time) = squared {
            let is_one = Self::of_word(one).is_some() && Self::of_word(time).is_some();
            return is_one.then_some(Self::Foreign);
        }
        let Self::Time(time) = Self::of_word(time)? else {
            return None;
        };
        let seconds = time.seconds()?;
        match (one, Self::of_word(one)) {
            ("1", _) if time == TimeUnit::Minute => Some(Self::Rate(TURN, PER_MINUTE)),
            (_, Some(Self::Position(unit, factor))) => Some(Self::Rate(unit, factor / seconds)),
            (_, Some(Self::Rate(..))) => Some(Self::Foreign),
            _ => None,
        }
    }

    /// A base with its prefix, or a velocity in one word such as radps.
    fn of_word(word: &str) -> Option<Self> {
        let small = word.to_lowercase();
        let is_base =
            |base: &&Base| base.letters.contains(&word) || base.words.contains(&small.as_str());
        if let Some(base) = BASES.iter().find(is_base) {
            return Some(base.unit);
        }
        let prefixed = PREFIXES.iter().find_map(|(prefix, factor)| {
            let rest = word.strip_prefix(prefix)?;
            let small = rest.to_lowercase();
            // Behind a prefix no other letter is meant by a small one.
            let is_base = |base: &&Base| {
                let letters = base.letters.iter().any(|of| of.eq_ignore_ascii_case(rest));
                base.has_prefixes && (letters || base.words.contains(&small.as_str()))
            };
            BASES.iter().find(is_base)?.unit.times(*factor)
        });
        let in_a_word = || match Self::of_word(word.strip_suffix("ps")?)? {
            Self::Position(unit, factor) => Some(Self::Rate(unit, factor)),
            _ => None,
        };
        prefixed.or_else(in_a_word)
    }

    /// The unit of so many of these; none of a time that no log has.
    fn times(self, factor: f64) -> Option<Self> {
        Some(match self {
            Self::Time(TimeUnit::Second) => {
                let is_it = |unit: &&TimeUnit| unit.seconds() == Some(factor);
                Self::Time(*TimeUnit::ALL.iter().find(is_it)?)
            }
            Self::Position(unit, of) => Self::Position(unit, of * factor),
            Self::Rate(unit, of) => Self::Rate(unit, of * factor),
            Self::Command(unit, of) => Self::Command(unit, of * factor),
            Self::Time(_) | Self::Electrical | Self::Foreign | Self::Doubtful => return None,
        })
    }
}
