//! From the text of a scenario to its settings, key by key.

use identifier_core::control::CommandLimit;
use identifier_core::error::{Allowed, OutOfRange};
use identifier_core::interval::Interval;
use identifier_core::parameters::{Parameter, Term, Terms};
use toml::Spanned;
use toml::de::{DeArray, DeTable, DeValue};

use super::error::{Fault, shown};
use super::key::{Absent, Choice, Entries, Holds, Key, When, examples, nearest};
use super::keys::{KEYS, MOST_COLUMNS, MOST_ENTRIES, MOST_RANGES};
use super::source::Source;
use super::{Column, Purpose, Scenario, keys};
use crate::program;

type Value<'a> = Spanned<DeValue<'a>>;

/// What a file states, written into a scenario; what it does not state is as the keys say.
pub(super) fn scenario(source: &Source<'_>, purpose: Purpose) -> Result<Scenario, Fault> {
    refuse_unknown(&source.root, "")?;
    let mut reading = Reading {
        source,
        purpose,
        scenario: Scenario::blank(),
        tables: vec![""],
        choices: Vec::new(),
        entry: None,
    };
    for key in KEYS {
        reading.read(key)?;
    }
    if !reading.tables.contains(&"controller") {
        reading.scenario.stated.controller = None;
    }
    Ok(reading.scenario)
}

/// Half of a file read.
struct Reading<'a, 'b> {
    source: &'b Source<'a>,
    purpose: Purpose,
    scenario: Scenario,
    /// Tables whose keys hold.
    tables: Vec<&'static str>,
    /// What was chosen, by the table it was chosen in.
    choices: Vec<(&'static str, &'static Choice, &'static [Choice])>,
    /// Of tables of which there may be many, the one that is being read, and its path.
    entry: Option<(&'static str, &'b DeTable<'a>)>,
}

impl<'a, 'b> Reading<'a, 'b> {
    fn read(&mut self, key: &'static Key) -> Result<(), Fault> {
        if !self.tables.contains(&key.place().0) {
            return Ok(());
        }
        match (self.refusing(key), self.value(key)) {
            (Some(choice), Some(value)) => Err(stranger(key, choice).at(value.span().start)),
            (Some(_), None) => Ok(()),
            (None, Some(value)) => self.take(key, value),
            (None, None) => self.leave(key),
        }
    }

    /// What the file states of a key.
    fn value(&self, key: &Key) -> Option<&'b Value<'a>> {
        let (table, name) = key.place();
        match self.entry {
            Some((path, entry)) if path == table => entry.get(name),
            _ => self.source.value(key.path),
        }
    }

    /// Tables of which there may be many, one after the other.
    fn entries(
        &mut self,
        key: &'static Key,
        value: &'b Value<'a>,
        entries: &Entries,
    ) -> Result<(), Fault> {
        if let DeValue::Table(_) = value.get_ref() {
            return Err(other(key, value, "a list of tables")
                .advising(format!("write {}, in double brackets", key.heading())));
        }
        for entry in list(key, value, entries.most)? {
            let DeValue::Table(table) = entry.get_ref() else {
                return Err(other(key, entry, "a table"));
            };
            (entries.begin)(&mut self.scenario);
            self.tables.push(key.path);
            self.entry = Some((key.path, table));
            for key in Key::children(key.path) {
                self.read(key)
                    .map_err(|fault| fault.or_at(entry.span().start))?;
            }
            (entries.check)(&self.scenario).map_err(|error| {
                let stated = table.get(error.parameter).unwrap_or(entry);
                let key = format!("{}.{}", key.path, error.parameter);
                Fault::new(key, error).at(stated.span().start)
            })?;
            self.entry = None;
            self.tables.retain(|&path| path != key.path);
            self.choices.retain(|(path, ..)| *path != key.path);
        }
        Ok(())
    }

    /// The choice that leaves a key without meaning, if one does.
    fn refusing(&self, key: &Key) -> Option<&'static Choice> {
        let mut made = self.choices.iter();
        made.find_map(|(table, choice, choices)| {
            let foreign = *table == key.place().0 && key.is_foreign_to(choice, choices);
            foreign.then_some(*choice)
        })
    }

    /// A key that the file states.
    fn take(&mut self, key: &'static Key, value: &'b Value<'a>) -> Result<(), Fault> {
        let scenario = &mut self.scenario;
        let fault = |fault: String| Fault::new(key.path, fault).at(value.span().start);
        match key.holds {
            Holds::Table(_) => {
                table(key, value)?;
                self.tables.push(key.path);
            }
            Holds::Tables(entries) => self.entries(key, value, &entries)?,
            Holds::Number(range, set) => set(scenario, number(key, value, range.fixed())?),
            Holds::Pair(range, set) => set(scenario, interval(key, value, range.fixed())?),
            Holds::Two(range, set) => {
                set(
                    scenario,
                    pair(key, value, range.fixed(), "a list of two numbers")?,
                );
            }
            Holds::Numbers(range, set) => {
                let list = list(key, value, MOST_ENTRIES)?;
                let numbers = list.iter().map(|entry| number(key, entry, range.fixed()));
                set(scenario, numbers.collect::<Result<_, _>>()?).map_err(fault)?;
            }
            Holds::Pairs(range, set) => {
                let list = list(key, value, MOST_RANGES)?;
                let pairs = list.iter().map(|entry| interval(key, entry, range.fixed()));
                set(scenario, pairs.collect::<Result<_, _>>()?).map_err(fault)?;
            }
            Holds::Whole(range, set) => set(scenario, whole(key, value, range)?),
            Holds::Column(set) => set(scenario, column(key, value)?),
            Holds::Choice(choices) => self.choose(key, chosen(key, value, choices)?, choices),
            Holds::Limit(set) => set(scenario, limit(key, value)?),
            Holds::Reach(set) => set(scenario, reach(key, value)?),
            Holds::Flag(set) => set(scenario, flag(key, value)?),
            Holds::Terms(set) => set(scenario, terms(key, value)?),
            Holds::Parameters(set) => set(scenario, parameters(key, value)?).map_err(fault)?,
            Holds::Matrix(set) => set(scenario, matrix(key, value)?).map_err(fault)?,
        }
        Ok(())
    }

    /// A key that the file does not state.
    fn leave(&mut self, key: &'static Key) -> Result<(), Fault> {
        let scenario = &mut self.scenario;
        match (key.absent, key.holds) {
            (Absent::Required(_), _) => return Err(self.missing(key)),
            (Absent::Begins(_), _) if scenario.identifier.law.fits() => {}
            (Absent::Is(value) | Absent::Begins(value), Holds::Number(_, set)) => {
                set(scenario, value);
            }
            (Absent::Is(value), Holds::Whole(_, set)) => set(scenario, value as u32),
            (_, Holds::Choice(choices)) => self.choose(key, &choices[0], choices),
            (_, Holds::Table(when)) => {
                let holds = match when {
                    When::Always => true,
                    When::Simulated if self.purpose == Purpose::Commission => true,
                    When::InRun if self.purpose == Purpose::Commission => false,
                    // A run's own log is what the run took for granted.
                    When::InRun | When::Simulated => {
                        let columns = self.source.value("log");
                        self.purpose == Purpose::Run
                            || scenario.plant.is_some() && columns.is_none()
                    }
                    When::Stated => false,
                };
                if holds {
                    self.tables.push(key.path);
                }
            }
            _ => {}
        }
        Ok(())
    }

    /// A value that cannot be left out, with all those beside it that cannot and are.
    fn missing(&self, key: &'static Key) -> Fault {
        let (table, name) = key.place();
        let mut made = self.choices.iter();
        let owner =
            made.find(|(within, choice, _)| *within == table && choice.takes.contains(&name));
        let needed = match owner {
            Some((_, choice, _)) => format!("\"{}\"", choice.name),
            None => Key::of(table).map_or(String::new(), Key::heading),
        };
        let beside = Key::children(table)
            .filter(|other| self.value(other).is_none())
            .filter(|other| self.refusing(other).is_none());
        let fault = format!("this value is missing: {needed} needs it");
        Fault::new(key.path, fault).advising(examples(beside))
    }

    fn choose(&mut self, key: &Key, choice: &'static Choice, choices: &'static [Choice]) {
        (choice.set)(&mut self.scenario);
        self.choices.push((key.place().0, choice, choices));
    }
}

/// Refuses the first key of a table, in the order of the file, that no line of [`KEYS`] has.
fn refuse_unknown(table: &DeTable<'_>, path: &str) -> Result<(), Fault> {
    let inside = |name: &str| match path {
        "" => name.to_owned(),
        path => format!("{path}.{name}"),
    };
    let mut entries: Vec<_> = table.iter().collect();
    entries.sort_by_key(|(name, _)| name.span().start);
    for (name, value) in entries {
        let full = inside(name.get_ref());
        match (Key::of(&full), value.get_ref()) {
            (Some(_), DeValue::Table(inner)) => refuse_unknown(inner, &full)?,
            (Some(key), DeValue::Array(list)) if matches!(key.holds, Holds::Tables(_)) => {
                for inner in list.iter().filter_map(|entry| entry.get_ref().as_table()) {
                    refuse_unknown(inner, &full)?;
                }
            }
            (Some(_), _) => {}
            (None, _) => {
                let fault = keys::remedy(&full).unwrap_or("there is no such key");
                return Err(Fault::new(inside(&shown(name.get_ref())), fault)
                    .at(name.span().start)
                    .advising(advice(path, name.get_ref())));
            }
        }
    }
    Ok(())
}

/// The nearest key to an unknown one, and what its table knows.
fn advice(table: &str, unknown: &str) -> String {
    let names: Vec<_> = Key::children(table).map(|key| key.place().1).collect();
    let near = nearest(unknown, names.iter().copied());
    let meant = near.or_else(|| Key::nearest(unknown).map(|key| key.path));
    let mut lines = meant.map_or(String::new(), |meant| format!("did you mean {meant}?\n"));
    if !names.is_empty() {
        lines += &format!("allowed: the keys {}\n", names.join(", "));
        let keys = format!("{} keys {table}", program::NAME);
        lines += &format!("`{}` explains them", keys.trim_end());
    }
    lines
}

/// A key that exists but means nothing beside a choice: a silent one would be a setting that the user
/// believes in and that does nothing.
fn stranger(key: &Key, choice: &Choice) -> Fault {
    let takes = match choice.takes {
        [] => "and no others of its kind".to_owned(),
        takes => format!("but {}", takes.join(", ")),
    };
    Fault::new(
        key.path,
        format!("\"{}\" does not take this key, {takes}", choice.name),
    )
}

fn refused(key: &Key, error: OutOfRange) -> Fault {
    Fault::new(key.path, error)
}

/// A value of another kind than belongs there.
fn other(key: &Key, value: &Value<'_>, belongs: &str) -> Fault {
    let stands = match value.get_ref() {
        DeValue::String(_) => "a text stands",
        DeValue::Integer(_) | DeValue::Float(_) => "a number stands",
        DeValue::Boolean(_) => "true or false stands",
        DeValue::Datetime(_) => "a date stands",
        DeValue::Array(_) => "a list stands",
        DeValue::Table(_) => "a table stands",
    };
    Fault::new(key.path, format!("{stands} where {belongs} belongs")).at(value.span().start)
}

fn table(key: &Key, value: &Value<'_>) -> Result<(), Fault> {
    match value.get_ref() {
        DeValue::Table(_) => Ok(()),
        DeValue::Array(_) => Err(other(key, value, "one table")
            .advising(format!("write [{}] once, in single brackets", key.path))),
        _ => Err(other(key, value, "a table")),
    }
}

fn number(key: &Key, value: &Value<'_>, allowed: Allowed) -> Result<f64, Fault> {
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
    checked.map_err(|error| refused(key, error).at(value.span().start))
}

fn too_large(key: &Key, value: &Value<'_>) -> Fault {
    Fault::new(key.path, "this number has too many digits").at(value.span().start)
}

fn whole(key: &Key, value: &Value<'_>, [low, high]: [u32; 2]) -> Result<u32, Fault> {
    let DeValue::Integer(integer) = value.get_ref() else {
        return Err(other(key, value, "a whole number"));
    };
    let number = i64::from_str_radix(integer.as_str(), integer.radix());
    let number = number.map_err(|_| too_large(key, value))?;
    match u32::try_from(number) {
        Ok(number) if (low..=high).contains(&number) => Ok(number),
        _ => {
            let name = key.place().1;
            let fault = format!("{name} = {number} is not allowed");
            Err(Fault::new(key.path, fault).at(value.span().start))
        }
    }
}

fn list<'v, 'a>(key: &Key, value: &'v Value<'a>, most: usize) -> Result<&'v DeArray<'a>, Fault> {
    let DeValue::Array(list) = value.get_ref() else {
        return Err(other(key, value, "a list"));
    };
    if list.is_empty() || list.len() > most {
        let fault = format!("{} entries, where 1 to {most} belong", list.len());
        return Err(Fault::new(key.path, fault).at(value.span().start));
    }
    Ok(list)
}

fn pair(key: &Key, value: &Value<'_>, allowed: Allowed, belongs: &str) -> Result<[f64; 2], Fault> {
    let DeValue::Array(list) = value.get_ref() else {
        return Err(other(key, value, belongs));
    };
    let [low, high] = &list[..] else {
        let fault = format!("{} numbers where two belong", list.len());
        return Err(Fault::new(key.path, fault).at(value.span().start));
    };
    Ok([number(key, low, allowed)?, number(key, high, allowed)?])
}

/// A pair of which the first is no larger than the second.
fn interval(key: &Key, value: &Value<'_>, allowed: Allowed) -> Result<[f64; 2], Fault> {
    let [low, high] = pair(key, value, allowed, "[min, max]")?;
    Interval::new(key.place().1, low, high)
        .map_err(|error| refused(key, error).at(value.span().start))?;
    Ok([low, high])
}

fn limit(key: &Key, value: &Value<'_>) -> Result<[f64; 2], Fault> {
    let limit = match value.get_ref() {
        DeValue::Array(_) => {
            let [low, high] = pair(key, value, Allowed::Finite, "[low, high]")?;
            CommandLimit::asymmetric(low, high)
        }
        _ => {
            let limit = number(key, value, Allowed::Above(0.0))?;
            CommandLimit::symmetric(limit)
        }
    };
    let limit = limit.map_err(|error| refused(key, error))?;
    Ok([limit.low(), limit.high()])
}

fn reach(key: &Key, value: &Value<'_>) -> Result<[f64; 2], Fault> {
    let DeValue::Array(_) = value.get_ref() else {
        let reach = number(key, value, Allowed::Above(0.0))?;
        return Ok([-reach, reach]);
    };
    let [low, high] = pair(key, value, Allowed::Finite, "[low, high]")?;
    if low > 0.0 || high < 0.0 || low >= high {
        let fault = format!("[{low}, {high}] does not reach from where the servo stands");
        return Err(Fault::new(key.path, fault).at(value.span().start));
    }
    Ok([low, high])
}

fn flag(key: &Key, value: &Value<'_>) -> Result<bool, Fault> {
    match value.get_ref() {
        DeValue::Boolean(flag) => Ok(*flag),
        _ => Err(other(key, value, "true or false")),
    }
}

fn column(key: &Key, value: &Value<'_>) -> Result<Column, Fault> {
    /// Characters that a name may have, so that messages can show it.
    const LONGEST: usize = 80;
    if let DeValue::Integer(_) = value.get_ref() {
        return Ok(Column::Number(whole(key, value, [1, MOST_COLUMNS])?));
    }
    let DeValue::String(name) = value.get_ref() else {
        return Err(other(key, value, "the name or the number of a column"));
    };
    if name.is_empty() || name.chars().nth(LONGEST).is_some() || name.chars().any(char::is_control)
    {
        let fault = "this cannot be the name of a column";
        return Err(Fault::new(key.path, fault).at(value.span().start));
    }
    Ok(Column::named(name))
}

fn chosen(
    key: &Key,
    value: &Value<'_>,
    choices: &'static [Choice],
) -> Result<&'static Choice, Fault> {
    let DeValue::String(name) = value.get_ref() else {
        return Err(other(key, value, "a text"));
    };
    let known = choices.iter().find(|choice| choice.name == name);
    known.ok_or_else(|| {
        let near = nearest(name, choices.iter().map(|choice| choice.name));
        Fault::new(key.path, format!("there is no \"{}\"", shown(name)))
            .at(value.span().start)
            .advising(near.map_or(String::new(), |near| format!("did you mean \"{near}\"?")))
    })
}

fn parameters(key: &Key, value: &Value<'_>) -> Result<Vec<Parameter>, Fault> {
    const ALL: [Parameter; 4] = [
        Parameter::A,
        Parameter::B,
        Parameter::Coulomb,
        Parameter::Load,
    ];
    let mut parameters = Vec::new();
    for entry in list(key, value, ALL.len())? {
        let fault = |fault: String| Err(Fault::new(key.path, fault).at(entry.span().start));
        let DeValue::String(name) = entry.get_ref() else {
            return Err(other(key, entry, "the name of a parameter"));
        };
        let Some(parameter) = ALL.into_iter().find(|known| known.name() == name) else {
            return fault(format!("there is no parameter \"{}\"", shown(name)));
        };
        if parameters.contains(&parameter) {
            return fault(format!("\"{name}\" stands there twice"));
        }
        parameters.push(parameter);
    }
    Ok(parameters)
}

fn terms(key: &Key, value: &Value<'_>) -> Result<Terms, Fault> {
    let mut terms = Terms::NONE;
    for entry in list(key, value, Term::ALL.len())? {
        let DeValue::String(name) = entry.get_ref() else {
            return Err(other(key, entry, "the name of a term"));
        };
        let Some(term) = Term::ALL.into_iter().find(|known| known.name() == name) else {
            let near = nearest(name, Term::ALL.iter().map(|term| term.name()));
            let fault = format!("there is no term \"{}\"", shown(name));
            return Err(Fault::new(key.path, fault)
                .at(entry.span().start)
                .advising(near.map_or(String::new(), |near| format!("did you mean \"{near}\"?"))));
        };
        terms = terms.with(term);
    }
    Ok(terms)
}

/// The rows of a matrix; of a diagonal, with zeros beside it.
fn matrix(key: &Key, value: &Value<'_>) -> Result<Vec<Vec<f64>>, Fault> {
    /// Parameters that there are.
    const MOST: usize = 4;
    let entries = list(key, value, MOST)?;
    let mut rows = Vec::new();
    for (i, entry) in entries.iter().enumerate() {
        rows.push(match entry.get_ref() {
            DeValue::Array(_) => {
                let row = list(key, entry, MOST)?.iter();
                let numbers = row.map(|entry| number(key, entry, Allowed::Finite));
                numbers.collect::<Result<_, _>>()?
            }
            _ => {
                let mut row = vec![0.0; entries.len()];
                row[i] = number(key, entry, Allowed::Finite)?;
                row
            }
        });
    }
    Ok(rows)
}
