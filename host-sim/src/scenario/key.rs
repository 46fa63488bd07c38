//! What a key of a scenario is: the columns of the table [`KEYS`](super::keys::KEYS).

use std::fmt;

use identifier_core::error::{Allowed, OutOfRange};
use identifier_core::parameters::{Parameter, Term, Terms};
use virtual_servo::Effects;

use super::error::shown;
use super::keys::{KEYS, MOST_RANGES};
use super::{Column, Scenario};

/// A key: a line of the table.
#[derive(Debug, Clone, Copy)]
pub struct Key {
    /// Its path, table and key.
    pub path: &'static str,
    /// What it holds, and where that goes in the settings.
    pub(super) holds: Holds,
    /// What is the case when it is absent.
    pub(super) absent: Absent,
    /// Its unit; empty where it has none.
    pub unit: &'static str,
    /// What it is, in one sentence.
    pub about: &'static str,
}

type Set<T> = fn(&mut Scenario, T);
type TrySet<T> = fn(&mut Scenario, T) -> Result<(), String>;

/// What a key holds, and where it is written.
#[derive(Debug, Clone, Copy)]
pub(super) enum Holds {
    /// Further keys.
    Table(When),
    /// Further keys in each of many tables.
    Tables(Entries),
    /// A number.
    Number(Range, Set<f64>),
    /// Lowest and highest.
    Pair(Range, Set<[f64; 2]>),
    /// Two numbers of which neither bounds the other.
    Two(Range, Set<[f64; 2]>),
    /// A list of numbers, at most [`MOST_ENTRIES`](super::keys::MOST_ENTRIES).
    Numbers(Range, TrySet<Vec<f64>>),
    /// A list of pairs of lowest and highest, at most [`MOST_RANGES`](super::keys::MOST_RANGES).
    Pairs(Range, TrySet<Vec<[f64; 2]>>),
    /// A whole number from the first to the second.
    Whole([u32; 2], Set<u32>),
    /// The name of a column, or its number.
    Column(Set<Column>),
    /// One of these names.
    Choice(&'static [Choice]),
    /// The limit of the command: a number, or lowest and highest.
    Limit(Set<[f64; 2]>),
    /// How far to either side: a number, or lowest and highest, one of which may be zero.
    Reach(Set<[f64; 2]>),
    /// True or false.
    Flag(Set<bool>),
    /// A list of parameters.
    Parameters(TrySet<Vec<Parameter>>),
    /// A list of optional terms of the model.
    Terms(Set<Terms>),
    /// The rows of a matrix, or its diagonal.
    Matrix(TrySet<Vec<Vec<f64>>>),
}

/// What becomes of tables of which there may be many.
#[derive(Debug, Clone, Copy)]
pub(super) struct Entries {
    /// The most that there may be.
    pub(super) most: usize,
    /// A table begins: its keys go where this makes room for them.
    pub(super) begin: fn(&mut Scenario),
    /// Whether the keys of the last table go together.
    pub(super) check: fn(&Scenario) -> Result<(), OutOfRange>,
}

/// When the defaults of a table's keys hold.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum When {
    Always,
    /// In a run and in the replay of its own log, and otherwise where the table is there.
    InRun,
    /// Likewise, and in a commissioning too.
    Simulated,
    /// Only where the table is there.
    Stated,
}

/// The range of a number.
#[derive(Debug, Clone, Copy)]
pub(super) enum Range {
    /// A fixed one.
    Fixed(Allowed),
    /// Above 0 and below half the sample rate, rad/s.
    BelowNyquist,
    /// Above 0 and at most half a radian a sample.
    HalfRadian,
    /// As long as a run may be.
    Lasting,
    /// As late as a command may act.
    Late,
    /// As large as a fault of its kind may be.
    OfFault,
    /// A whole number of control samples, or of pairs of them.
    Samples,
    EvenSamples,
}

impl Range {
    /// What a number must be whatever the sample time; the rest is the core's to check.
    pub(super) fn fixed(self) -> Allowed {
        match self {
            Self::Fixed(allowed) => allowed,
            Self::Late => Allowed::Within(0.0, Effects::LONGEST_DELAY),
            Self::OfFault => Allowed::Finite,
            _ => Allowed::Above(0.0),
        }
    }
}

impl fmt::Display for Range {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Fixed(allowed) => allowed.fmt(f),
            Self::BelowNyquist => f.write_str("a number above 0 and below pi/sample_time"),
            Self::HalfRadian => f.write_str("a number above 0 and at most 0.5/sample_time"),
            Self::Lasting => f.write_str("a time of 1 to 1e10 control samples"),
            Self::Late => {
                let (longest, most) = (Effects::LONGEST_DELAY, Effects::MAX_DELAYED_SAMPLES);
                write!(
                    f,
                    "a number from 0 to {longest}, at most {most} control samples"
                )
            }
            Self::OfFault => {
                let most = Effects::LARGEST_ACCELERATION;
                write!(
                    f,
                    "a number: of encoder-jump, counts; of actuator-weak, a share from 0 to 1; of \
                     load-step, up to {most:e} rad/s² either way; of friction-rise, 0 to {most:e} rad/s²"
                )
            }
            Self::Samples => f.write_str("a whole number of control samples"),
            Self::EvenSamples => f.write_str("an even number of control samples"),
        }
    }
}

/// A name that a key can hold, what it stands for, and which of its table's keys belong to it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Choice {
    pub(super) name: &'static str,
    /// Keys beside that other choices do not take, unless they name them too.
    pub(super) takes: &'static [&'static str],
    pub(super) set: fn(&mut Scenario),
}

/// What is the case when a key is absent.
#[derive(Debug, Clone, Copy)]
pub(super) enum Absent {
    /// It must not be; such a value is shown as an example.
    Required(&'static str),
    /// This number holds.
    Is(f64),
    /// An estimate begins here; the laws that fit need no beginning.
    Begins(f64),
    /// The first choice holds.
    First,
    /// What holds follows from something else.
    Follows(&'static str),
}

impl Key {
    /// The line of a path.
    #[must_use]
    pub fn of(path: &str) -> Option<&'static Self> {
        KEYS.iter().find(|key| key.path == path)
    }

    /// The key that a name or a path is most likely meant to be, wherever it stands.
    #[must_use]
    pub fn nearest(word: &str) -> Option<&'static Self> {
        let named = KEYS.iter().find(|key| key.place().1 == word);
        named.or_else(|| Self::of(nearest(word, KEYS.iter().map(|key| key.path))?))
    }

    /// The path of its table, empty for a table of the file, and its name in it.
    #[must_use]
    pub fn place(&self) -> (&'static str, &'static str) {
        self.path.rsplit_once('.').unwrap_or(("", self.path))
    }

    /// What its table begins with in a file, for a key that is one.
    #[must_use]
    pub fn heading(&self) -> String {
        match self.holds {
            Holds::Tables(_) => format!("[[{}]]", self.path),
            _ => format!("[{}]", self.path),
        }
    }

    /// The keys of a table; for the empty path, the tables.
    pub fn children(table: &str) -> impl Iterator<Item = &'static Self> {
        KEYS.iter().filter(move |key| key.place().0 == table)
    }

    /// What it may hold.
    #[must_use]
    pub fn allowed(&self) -> String {
        let unit = |text: String| match self.unit {
            "" => text,
            unit => format!("{text}, {unit}"),
        };
        match self.holds {
            Holds::Table(_) => {
                let names: Vec<_> = Self::children(self.path).map(|key| key.place().1).collect();
                format!("a table with {}", names.join(", "))
            }
            Holds::Tables(entries) => {
                let names: Vec<_> = Self::children(self.path).map(|key| key.place().1).collect();
                let (path, most) = (self.path, entries.most);
                format!("1 to {most} tables, each under [[{path}]], with {}", names.join(", "))
            }
            Holds::Number(range, _) => unit(range.to_string()),
            Holds::Pair(range, _) => unit(format!("[min, max], each {range}")),
            Holds::Two(range, _) => unit(format!("two numbers [.., ..], each {range}")),
            Holds::Numbers(range, _) => unit(format!("a list of 1 to 16, each {range}")),
            Holds::Pairs(range, _) => unit(format!(
                "a list of 1 to {MOST_RANGES} pairs [min, max], each {range}"
            )),
            Holds::Whole([low, high], _) => format!("a whole number from {low} to {high}"),
            Holds::Column(_) => {
                unit("the name of a column, 1 to 80 characters, or its number from 1".to_owned())
            }
            Holds::Choice(choices) => either(choices.iter().map(|choice| choice.name)),
            Holds::Limit(_) => {
                unit("a number above 0, or [low, high] with low below 0 and high above 0".to_owned())
            }
            Holds::Reach(_) => unit(
                "a number above 0, or [low, high] with low at most 0 and high at least 0".to_owned(),
            ),
            Holds::Flag(_) => "true or false".to_owned(),
            Holds::Parameters(_) => {
                "a list of \"a\", \"b\", \"coulomb\" and \"load\", each once, such as [\"a\", \"b\"]"
                    .to_owned()
            }
            Holds::Terms(_) => format!("a list of {}", either(Term::ALL.iter().map(|term| term.name())))
                .replace(" or ", " and "),
            Holds::Matrix(_) => "the diagonal [g_a, g_b, ..] or the full symmetric positive \
                definite matrix [[..], ..], in the order of parameters"
                .to_owned(),
        }
    }

    /// What holds when it is absent.
    #[must_use]
    pub fn default(&self) -> String {
        match (self.absent, self.holds) {
            (Absent::Required(_), _) => "none, it is required".to_owned(),
            (Absent::Is(number), _) => number.to_string(),
            (Absent::Begins(number), _) => format!("{number}; a law that fits needs none"),
            (Absent::First, Holds::Choice([first, ..])) => format!("\"{}\"", first.name),
            (Absent::First, _) => String::new(),
            (Absent::Follows(text), _) => text.to_owned(),
        }
    }

    /// The names, of a key beside, that it belongs to; empty for a key that always holds.
    #[must_use]
    pub fn belongs_to(&self) -> Vec<&'static str> {
        let (table, name) = self.place();
        Self::children(table)
            .flat_map(|key| key.choices())
            .filter(|choice| choice.takes.contains(&name))
            .map(|choice| choice.name)
            .collect()
    }

    /// What it is, and what it belongs to.
    #[must_use]
    pub fn description(&self) -> String {
        match self.belongs_to() {
            owners if owners.is_empty() => self.about.to_owned(),
            owners => format!("{} ({})", self.about, owners.join(", ")),
        }
    }

    pub(super) fn choices(&self) -> &'static [Choice] {
        match self.holds {
            Holds::Choice(choices) => choices,
            _ => &[],
        }
    }

    /// Whether a choice of a key beside this one leaves it without meaning.
    pub(super) fn is_foreign_to(&self, choice: &Choice, choices: &[Choice]) -> bool {
        let takes = |choice: &Choice| choice.takes.contains(&self.place().1);
        !takes(choice) && choices.iter().any(takes)
    }

    /// A line to copy, for a key that is required.
    pub(super) fn example(&self) -> Option<String> {
        let Absent::Required(example) = self.absent else {
            return None;
        };
        let unit = match self.unit {
            "" => String::new(),
            unit => format!("{unit}; "),
        };
        let (_, name) = self.place();
        Some(format!("{name} = {example}   # {unit}{}", self.about))
    }
}

/// Lines to copy, for those of some keys that are required; empty if none is.
pub(super) fn examples(keys: impl Iterator<Item = &'static Key>) -> String {
    let lines: String = keys
        .filter_map(Key::example)
        .map(|line| format!("  {line}\n"))
        .collect();
    match lines.is_empty() {
        true => lines,
        false => format!("write, for example:\n{lines}"),
    }
}

/// Names in quotes, the last after "or".
fn either(names: impl Iterator<Item = &'static str>) -> String {
    let mut names: Vec<_> = names.map(|name| format!("\"{name}\"")).collect();
    match names.pop() {
        Some(last) if names.is_empty() => last,
        Some(last) => format!("{} or {last}", names.join(", ")),
        None => String::new(),
    }
}

/// The name that a word is most likely meant to be.
pub(super) fn nearest<'n>(word: &str, names: impl Iterator<Item = &'n str>) -> Option<&'n str> {
    crate::nearest::name(&shown(word), names)
}
