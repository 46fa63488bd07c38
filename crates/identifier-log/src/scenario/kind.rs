//! The kinds of value of a key. Each is read, described, and written in a JSON schema here.

use identifier_core::control::CommandLimit;
use identifier_core::error::{Allowed, OutOfRange};
use identifier_core::interval::Interval;
use identifier_core::parameters::{Parameter, Term, Terms};
use serde_json::{Value as Json, json};
use toml::Spanned;
use toml::de::{DeArray, DeValue};

use super::error::{Fault, shown};
use super::range::Range;
use super::{Column, Document};

pub(super) type Value<'a> = Spanned<DeValue<'a>>;

/// Sines that a multisine and levels that a staircase may have.
pub const MAX_ENTRIES: usize = 16;

/// Ranges of time that may be left out of a log.
const MAX_RANGES: usize = 100;

/// The most columns of a log.
pub const MAX_COLUMNS: u32 = 1000;

/// The place of a value in a document. To reach for a value in a part that a document lacks adds that part.
#[derive(Debug)]
pub enum Place<S, T> {
    /// It always has a value.
    Held(fn(&mut S) -> &mut T),
    /// It may have none.
    Optional(fn(&mut S) -> &mut Option<T>),
    /// It takes a value that it allows, and gives it back.
    Checked(fn(&mut S, T) -> Result<(), String>, fn(&mut S) -> Option<T>),
}

impl<S, T: Clone> Place<S, T> {
    fn set(&self, to: &mut S, value: T) -> Result<(), String> {
        match self {
            Self::Held(place) => *place(to) = value,
            Self::Optional(place) => *place(to) = Some(value),
            Self::Checked(set, _) => set(to, value)?,
        }
        Ok(())
    }

    fn get(&self, from: &mut S) -> Option<T> {
        match self {
            Self::Held(place) => Some(place(from).clone()),
            Self::Optional(place) => place(from).clone(),
            Self::Checked(_, get) => get(from),
        }
    }
}

/// The kind of value of a key, with the place of the value in the scenario.
#[derive(Debug)]
pub enum Kind<S> {
    /// Further keys.
    Table(When),
    /// Further keys in each of many tables.
    Tables(Entries<S>),
    /// One of these names; it is set and given back by its index.
    Choice(&'static [Choice], fn(&mut S, usize), fn(&mut S) -> usize),
    /// A number.
    Number(Range, Place<S, f64>),
    /// Lowest and highest.
    Pair(Range, Place<S, [f64; 2]>),
    /// Two numbers of which neither bounds the other.
    Two(Range, Place<S, [f64; 2]>),
    /// A list of numbers, at most [`MAX_ENTRIES`].
    Numbers(Range, Place<S, Vec<f64>>),
    /// A list of pairs of lowest and highest, at most a hundred.
    Pairs(Range, Place<S, Vec<[f64; 2]>>),
    /// A whole number from the first to the second.
    Whole([u32; 2], Place<S, u32>),
    /// The name of a column, or its number.
    Column(Place<S, Column>),
    /// The limit of the command: a number, or lowest and highest.
    Limit(Place<S, [f64; 2]>),
    /// Travel to either side: a number, or lowest and highest, one of which may be zero.
    Reach(Place<S, [f64; 2]>),
    /// True or false.
    Flag(Place<S, bool>),
    /// A list of parameters.
    Parameters(Place<S, Vec<Parameter>>),
    /// A list of optional terms of the model.
    Terms(Place<S, Terms>),
}

/// Tables of which there may be many.
#[derive(Debug)]
pub struct Entries<S> {
    /// The most of them.
    pub max: usize,
    /// Makes room for the keys of the next table.
    pub begin: fn(&mut S),
    /// Checks that the keys of the last table go together.
    pub check: fn(&S) -> Result<(), OutOfRange>,
}

/// The cases in which the defaults of a table's keys hold.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum When {
    /// Wherever it is not stated.
    Always,
    /// In a run and in the replay of its own log, and otherwise where the table is stated.
    InRun,
    /// Likewise, and in a commissioning too.
    Simulated,
    /// Only where the table is stated.
    Stated,
}

/// A name that a key can hold, and the keys of its table that belong to it.
#[derive(Debug, Clone, Copy)]
pub struct Choice {
    /// The name.
    pub name: &'static str,
    /// Keys beside that other choices do not take, unless they name them too.
    pub takes: &'static [&'static str],
}

impl Choice {
    /// One that takes no keys.
    pub(super) const fn plain(name: &'static str) -> Self {
        Self { name, takes: &[] }
    }
}

/// A key: a line of the table.
#[derive(Debug)]
pub struct Key<S> {
    /// Its path, table and key.
    pub path: &'static str,
    /// The kind of its value, and the place of the value in the scenario.
    pub kind: Kind<S>,
    /// The default.
    pub default: Default,
    /// Its unit; empty where it has none.
    pub unit: &'static str,
    /// Its meaning, in one sentence.
    pub about: &'static str,
}

/// The value of an absent key.
#[derive(Debug, Clone, Copy)]
pub enum Default {
    /// Nothing: the key is required; this value is shown as an example.
    Required(&'static str),
    /// This number.
    Value(f64),
    /// This initial estimate; the estimators that fit need none.
    Initial(f64),
    /// The first choice.
    FirstChoice,
    /// A value that is derived from something else.
    Derived(&'static str),
}

impl<S: Document> Kind<S> {
    /// The choices of a key that has some.
    #[must_use]
    pub fn choices(&self) -> &'static [Choice] {
        match self {
            Self::Choice(choices, ..) => choices,
            _ => &[],
        }
    }

    /// Reads a value into the scenario; tables and choices are the reader's own.
    pub(super) fn read(&self, key: &Key<S>, value: &Value<'_>, to: &mut S) -> Result<(), Fault> {
        let stored = match self {
            Self::Table(_) | Self::Tables(_) | Self::Choice(..) => Ok(()),
            Self::Number(range, place) => place.set(to, number(key, value, range.fixed())?),
            Self::Pair(range, place) => place.set(to, interval(key, value, range.fixed())?),
            Self::Two(range, place) => {
                let two = pair(key, value, range.fixed(), "a list of two numbers")?;
                place.set(to, two)
            }
            Self::Numbers(range, place) => {
                let entries = list(key, value, MAX_ENTRIES)?.iter();
                let numbers = entries.map(|entry| number(key, entry, range.fixed()));
                place.set(to, numbers.collect::<Result<_, _>>()?)
            }
            Self::Pairs(range, place) => {
                let entries = list(key, value, MAX_RANGES)?.iter();
                let pairs = entries.map(|entry| interval(key, entry, range.fixed()));
                place.set(to, pairs.collect::<Result<_, _>>()?)
            }
            Self::Whole(range, place) => place.set(to, whole(key, value, *range)?),
            Self::Column(place) => place.set(to, column(key, value)?),
            Self::Limit(place) => place.set(to, limit(key, value)?),
            Self::Reach(place) => place.set(to, reach(key, value)?),
            Self::Flag(place) => match value.get_ref() {
                DeValue::Boolean(flag) => place.set(to, *flag),
                _ => return Err(other(key, value, "true or false")),
            },
            Self::Terms(place) => place.set(to, terms(key, value)?),
            Self::Parameters(place) => place.set(to, parameters(key, value)?),
        };
        stored.map_err(|fault| refused(key, value, fault))
    }

    /// The value in a document, as a text states it; none where it has none.
    pub(super) fn text(&self, from: &mut S) -> Option<String> {
        Some(match self {
            Self::Table(_) | Self::Tables(_) => return None,
            Self::Choice(choices, _, get) => format!("{:?}", choices[get(from)].name),
            Self::Number(_, place) => format!("{:?}", meant(place.get(from)?)),
            Self::Pair(_, place)
            | Self::Two(_, place)
            | Self::Limit(place)
            | Self::Reach(place) => format!("{:?}", place.get(from)?.map(meant)),
            Self::Numbers(_, place) => {
                let numbers = place.get(from)?.into_iter().map(meant);
                format!("{:?}", numbers.collect::<Vec<_>>())
            }
            Self::Pairs(_, place) => {
                let pairs = place.get(from)?.into_iter().map(|pair| pair.map(meant));
                format!("{:?}", pairs.collect::<Vec<_>>())
            }
            Self::Whole(_, place) => place.get(from)?.to_string(),
            Self::Column(place) => match place.get(from)? {
                Column::Number(number) => number.to_string(),
                // A string of JSON is one of TOML.
                Column::Named(name) => json!(name).to_string(),
            },
            Self::Flag(place) => place.get(from)?.to_string(),
            Self::Terms(place) => {
                let terms = place.get(from)?;
                let names = Term::ALL.into_iter().filter(|term| terms.has(*term));
                format!("{:?}", names.map(Term::name).collect::<Vec<_>>())
            }
            Self::Parameters(place) => {
                let names = place.get(from)?.into_iter().map(Parameter::name);
                format!("{:?}", names.collect::<Vec<_>>())
            }
        })
    }

    /// Checks the numbers that a document has at a key of this name.
    pub(super) fn check(&self, name: &'static str, from: &mut S) -> Result<(), OutOfRange> {
        let (range, numbers) = match self {
            Self::Number(range, place) => (range, Vec::from_iter(place.get(from))),
            Self::Pair(range, place) | Self::Two(range, place) => {
                (range, place.get(from).map_or_else(Vec::new, Vec::from))
            }
            Self::Numbers(range, place) => (range, place.get(from).unwrap_or_default()),
            Self::Pairs(range, place) => {
                let pairs = place.get(from).unwrap_or_default();
                (range, pairs.into_flattened())
            }
            _ => return Ok(()),
        };
        let mut numbers = numbers.into_iter();
        numbers.try_for_each(|number| range.fixed().check(name, number).map(drop))
    }

    /// Puts a number into the scenario.
    pub(super) fn set_number(&self, number: f64, to: &mut S) {
        // A default is allowed.
        let _ = match self {
            Self::Number(_, place) => place.set(to, number),
            Self::Whole(_, place) => place.set(to, number as u32),
            _ => Ok(()),
        };
    }

    /// The allowed values, in words, of a key.
    pub(super) fn allowed(&self, key: &Key<S>) -> String {
        let unit = |text: String| match key.unit {
            "" => text,
            unit => format!("{text}, {unit}"),
        };
        let names = || {
            let names: Vec<_> = Key::<S>::children(key.path)
                .map(|key| key.place().1)
                .collect();
            names.join(", ")
        };
        match self {
            Self::Table(_) => format!("a table with {}", names()),
            Self::Tables(Entries { max, .. }) => {
                format!("1 to {max} tables, each under [[{}]], with {}", key.path, names())
            }
            Self::Choice(choices, ..) => either(choices.iter().map(|choice| choice.name)),
            Self::Number(range, _) => unit(range.to_string()),
            Self::Pair(range, _) => unit(format!("[min, max], each {range}")),
            Self::Two(range, _) => unit(format!("two numbers [.., ..], each {range}")),
            Self::Numbers(range, _) => unit(format!("a list of 1 to {MAX_ENTRIES}, each {range}")),
            Self::Pairs(range, _) => unit(format!(
                "a list of 1 to {MAX_RANGES} pairs [min, max], each {range}"
            )),
            Self::Whole([low, high], _) => format!("a whole number from {low} to {high}"),
            Self::Column(_) => {
                unit("the name of a column, 1 to 80 characters, or its number from 1".to_owned())
            }
            Self::Limit(_) => {
                unit("a number above 0, or [low, high] with low below 0 and high above 0".to_owned())
            }
            Self::Reach(_) => unit(
                "a number above 0, or [low, high] with low at most 0 and high at least 0".to_owned(),
            ),
            Self::Flag(_) => "true or false".to_owned(),
            Self::Parameters(_) => {
                "a list of \"a\", \"b\", \"coulomb\" and \"load\", each once, such as [\"a\", \"b\"]"
                    .to_owned()
            }
            Self::Terms(_) => {
                let names = either(Term::ALL.iter().map(|term| term.name()));
                format!("a list of {names}").replace(" or ", " and ")
            }
        }
    }

    /// The allowed values as a JSON schema; `table` is that of the keys below.
    pub(super) fn schema(&self, table: impl FnOnce() -> Json) -> Json {
        let any = || json!({ "type": "number" });
        let unique = |names: &[&str]| {
            let mut list = list_of(json!({ "enum": names }), names.len());
            list["uniqueItems"] = json!(true);
            list
        };
        match self {
            Self::Table(_) => table(),
            Self::Tables(entries) => list_of(table(), entries.max),
            Self::Choice(choices, ..) => {
                let names: Vec<_> = choices.iter().map(|choice| choice.name).collect();
                json!({ "enum": names })
            }
            Self::Number(range, _) => range.schema(),
            Self::Pair(range, _) | Self::Two(range, _) => pair_of(range.schema()),
            Self::Numbers(range, _) => list_of(range.schema(), MAX_ENTRIES),
            Self::Pairs(range, _) => list_of(pair_of(range.schema()), MAX_RANGES),
            Self::Whole([low, high], _) => {
                json!({ "type": "integer", "minimum": low, "maximum": high })
            }
            Self::Column(_) => json!({ "anyOf": [
                { "type": "string", "minLength": 1, "maxLength": MAX_NAME },
                { "type": "integer", "minimum": 1, "maximum": MAX_COLUMNS },
            ] }),
            Self::Limit(_) | Self::Reach(_) => {
                json!({ "anyOf": [{ "type": "number", "exclusiveMinimum": 0 }, pair_of(any())] })
            }
            Self::Flag(_) => json!({ "type": "boolean" }),
            Self::Parameters(_) => unique(&Parameter::ALL.map(Parameter::name)),
            Self::Terms(_) => unique(&Term::ALL.map(Term::name)),
        }
    }
}

/// Characters of a column's name, few enough for messages to show it.
const MAX_NAME: usize = 80;

fn list_of(items: Json, most: usize) -> Json {
    json!({ "type": "array", "items": items, "minItems": 1, "maxItems": most })
}

fn pair_of(items: Json) -> Json {
    json!({ "type": "array", "items": items, "minItems": 2, "maxItems": 2 })
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

fn refused<S>(key: &Key<S>, value: &Value<'_>, why: impl std::fmt::Display) -> Fault {
    Fault::new(key.path, why).at(value.span().start)
}

/// A value of another kind than belongs there.
pub(super) fn other<S>(key: &Key<S>, value: &Value<'_>, belongs: &str) -> Fault {
    let stands = match value.get_ref() {
        DeValue::String(_) => "this is a text",
        DeValue::Integer(_) | DeValue::Float(_) => "this is a number",
        DeValue::Boolean(_) => "this is true or false",
        DeValue::Datetime(_) => "this is a date",
        DeValue::Array(_) => "this is a list",
        DeValue::Table(_) => "this is a table",
    };
    refused(key, value, format!("{stands} instead of {belongs}"))
}

/// A name that is not among those known.
fn unknown<'n, S>(
    key: &Key<S>,
    value: &Value<'_>,
    what: &str,
    name: &str,
    known: impl Iterator<Item = &'n str>,
) -> Fault {
    let near = nearest(name, known);
    refused(key, value, format!("there is no {what}\"{}\"", shown(name)))
        .advising(near.map_or(String::new(), |near| format!("did you mean \"{near}\"?")))
}

/// A number as it is written: that of nine digits from which it differs by rounding alone, as 0.001 from
/// 0.0009999999999999996, or itself.
fn meant(number: f64) -> f64 {
    /// Relative error of a number that was computed in double precision.
    const ROUNDING: f64 = 1e-12;
    let short = format!("{number:.8e}").parse().unwrap_or(number);
    if (number - short).abs() <= ROUNDING * number.abs() {
        short
    } else {
        number
    }
}

fn text<'v, S>(key: &Key<S>, value: &'v Value<'_>, belongs: &str) -> Result<&'v str, Fault> {
    value
        .get_ref()
        .as_str()
        .ok_or_else(|| other(key, value, belongs))
}

fn number<S>(key: &Key<S>, value: &Value<'_>, allowed: Allowed) -> Result<f64, Fault> {
    let number = match value.get_ref() {
        DeValue::Float(float) => float.as_str().parse().ok(),
        DeValue::Integer(integer) if integer.radix() == 10 => integer.as_str().parse().ok(),
        DeValue::Integer(integer) => u64::from_str_radix(integer.as_str(), integer.radix())
            .ok()
            .map(|number| number as f64),
        _ => return Err(other(key, value, "a number")),
    };
    let number = number.ok_or_else(|| too_large(key, value))?;
    let checked = allowed.check(key.place().1, number);
    checked.map_err(|error| refused(key, value, error))
}

fn too_large<S>(key: &Key<S>, value: &Value<'_>) -> Fault {
    refused(key, value, "this number has too many digits")
}

fn whole<S>(key: &Key<S>, value: &Value<'_>, [low, high]: [u32; 2]) -> Result<u32, Fault> {
    let DeValue::Integer(integer) = value.get_ref() else {
        return Err(other(key, value, "a whole number"));
    };
    let number = i64::from_str_radix(integer.as_str(), integer.radix());
    let number = number.map_err(|_| too_large(key, value))?;
    match u32::try_from(number) {
        Ok(number) if (low..=high).contains(&number) => Ok(number),
        _ => {
            let name = key.place().1;
            Err(refused(
                key,
                value,
                format!("{name} = {number} is not allowed"),
            ))
        }
    }
}

/// The entries of a list, at least one and at most `max`.
pub(super) fn list<'v, 'a, S>(
    key: &Key<S>,
    value: &'v Value<'a>,
    max: usize,
) -> Result<&'v DeArray<'a>, Fault> {
    let DeValue::Array(list) = value.get_ref() else {
        return Err(other(key, value, "a list"));
    };
    if list.is_empty() || list.len() > max {
        let fault = format!("{} entries: 1 to {max} are allowed", list.len());
        return Err(refused(key, value, fault));
    }
    Ok(list)
}

fn pair<S>(
    key: &Key<S>,
    value: &Value<'_>,
    allowed: Allowed,
    belongs: &str,
) -> Result<[f64; 2], Fault> {
    let DeValue::Array(list) = value.get_ref() else {
        return Err(other(key, value, belongs));
    };
    let [low, high] = &list[..] else {
        let fault = format!("{} numbers instead of two", list.len());
        return Err(refused(key, value, fault));
    };
    Ok([number(key, low, allowed)?, number(key, high, allowed)?])
}

/// A pair of which the first is no larger than the second.
fn interval<S>(key: &Key<S>, value: &Value<'_>, allowed: Allowed) -> Result<[f64; 2], Fault> {
    let [low, high] = pair(key, value, allowed, "[min, max]")?;
    Interval::new(key.place().1, low, high).map_err(|error| refused(key, value, error))?;
    Ok([low, high])
}

fn limit<S>(key: &Key<S>, value: &Value<'_>) -> Result<[f64; 2], Fault> {
    let limit = match value.get_ref() {
        DeValue::Array(_) => {
            let [low, high] = pair(key, value, Allowed::Finite, "[low, high]")?;
            CommandLimit::asymmetric(low, high)
        }
        _ => CommandLimit::symmetric(number(key, value, Allowed::Above(0.0))?),
    };
    let limit = limit.map_err(|error| Fault::new(key.path, error))?;
    Ok([limit.low(), limit.high()])
}

fn reach<S>(key: &Key<S>, value: &Value<'_>) -> Result<[f64; 2], Fault> {
    let DeValue::Array(_) = value.get_ref() else {
        let reach = number(key, value, Allowed::Above(0.0))?;
        return Ok([-reach, reach]);
    };
    let [low, high] = pair(key, value, Allowed::Finite, "[low, high]")?;
    if low > 0.0 || high < 0.0 || low >= high {
        let fault = format!("[{low}, {high}] does not contain 0, the servo's position");
        return Err(refused(key, value, fault));
    }
    Ok([low, high])
}

fn column<S>(key: &Key<S>, value: &Value<'_>) -> Result<Column, Fault> {
    if let DeValue::Integer(_) = value.get_ref() {
        return Ok(Column::Number(whole(key, value, [1, MAX_COLUMNS])?));
    }
    let name = text(key, value, "the name or the number of a column")?;
    if name.is_empty() || name.chars().nth(MAX_NAME).is_some() || name.chars().any(char::is_control)
    {
        return Err(refused(key, value, "this is not a valid column name"));
    }
    Ok(Column::named(name))
}

/// The index of the choice that a value names.
pub(super) fn choice<S>(
    key: &Key<S>,
    value: &Value<'_>,
    choices: &[Choice],
) -> Result<usize, Fault> {
    let name = text(key, value, "a text")?;
    let index = choices.iter().position(|choice| choice.name == name);
    let names = choices.iter().map(|choice| choice.name);
    index.ok_or_else(|| unknown(key, value, "", name, names))
}

fn parameters<S>(key: &Key<S>, value: &Value<'_>) -> Result<Vec<Parameter>, Fault> {
    let mut parameters = Vec::new();
    for entry in list(key, value, Parameter::ALL.len())? {
        let name = text(key, entry, "the name of a parameter")?;
        let Some(parameter) = Parameter::ALL
            .into_iter()
            .find(|known| known.name() == name)
        else {
            let fault = format!("there is no parameter \"{}\"", shown(name));
            return Err(refused(key, entry, fault));
        };
        if parameters.contains(&parameter) {
            return Err(refused(key, entry, format!("\"{name}\" is listed twice")));
        }
        parameters.push(parameter);
    }
    Ok(parameters)
}

fn terms<S>(key: &Key<S>, value: &Value<'_>) -> Result<Terms, Fault> {
    let mut terms = Terms::NONE;
    for entry in list(key, value, Term::ALL.len())? {
        let name = text(key, entry, "the name of a term")?;
        let term = Term::ALL.into_iter().find(|known| known.name() == name);
        let names = Term::ALL.iter().map(|term| term.name());
        terms = terms.with(term.ok_or_else(|| unknown(key, entry, "term ", name, names))?);
    }
    Ok(terms)
}

/// The name that a word is most likely meant to be.
pub(super) fn nearest<'n>(word: &str, names: impl Iterator<Item = &'n str>) -> Option<&'n str> {
    crate::nearest::name(&shown(word), names)
}

#[cfg(test)]
mod tests {
    use super::meant;

    #[test]
    fn a_number_is_written_without_its_rounding() {
        let turn = std::f64::consts::TAU / 10_000.0;
        for (number, written) in [
            (0.000_999_999_999_999_999_6, "0.001"),
            (0.1 + 0.2, "0.3"),
            (5000.0, "5000.0"),
            (f64::INFINITY, "inf"),
            (0.0, "0.0"),
            (turn, &*format!("{turn:?}")),
        ] {
            assert_eq!(format!("{:?}", meant(number)), written);
        }
    }
}
