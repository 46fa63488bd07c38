//! From options to the text that states them, the other direction of `read`; and the ranges of their numbers.

use super::error::Fault;
use super::kind::{Choice, Default, Kind, When};
use super::{Document, Options};

type Key = super::kind::Key<Options>;

impl Options {
    /// The text of a scenario that states these options, table by table, where they differ from the defaults.
    #[must_use]
    pub fn text(&self) -> String {
        let blank = Self::blank();
        let tables = Key::children("").filter_map(|table| {
            let lines = self.lines(table, &blank)?;
            Some(format!("{}\n{}", table.heading(), lines.concat()))
        });
        tables.collect::<Vec<_>>().join("\n")
    }

    /// These options if their numbers are in the ranges of the keys, as those of a text are.
    ///
    /// # Errors
    /// The key whose number is not allowed.
    pub fn in_range(self) -> Result<Self, Fault> {
        for key in Self::keys() {
            let checked = self.reached(|at| key.kind.check(key.place().1, at));
            let checked = checked.unwrap_or(Ok(()));
            checked.map_err(|error| Fault::new(key.path, error))?;
        }
        Ok(self)
    }

    /// The lines of a table; none where the options are the same without it.
    fn lines(&self, table: &Key, blank: &Self) -> Option<Vec<String>> {
        let mut made: Vec<(&Choice, &[Choice])> = Vec::new();
        let mut lines = Vec::new();
        for key in Key::children(table.path) {
            if made
                .iter()
                .any(|(choice, all)| key.is_foreign_to(choice, all))
            {
                continue;
            }
            if let Kind::Choice(choices, _, get) = &key.kind {
                made.push((&choices[get(&mut self.clone())], choices));
            }
            let value = match key.kind {
                Kind::Table(_) => self.lines(key, blank).map(|lines| {
                    let entries: Vec<_> = lines.iter().map(|line| line.trim_end()).collect();
                    format!("{{ {} }}", entries.join(", "))
                }),
                _ => (self.value(key)).filter(|own| !is_default(key, own, blank)),
            };
            lines.extend(value.map(|value| format!("{} = {value}\n", key.place().1)));
        }
        let is_needed = match table.kind {
            Kind::Table(When::Always) => !lines.is_empty(),
            _ => self.differs(table.path, blank),
        };
        is_needed.then_some(lines)
    }

    /// True if a value of a table, or of one in it, is another than of other options.
    fn differs(&self, table: &str, other: &Self) -> bool {
        Key::children(table)
            .any(|key| self.value(key) != other.value(key) || self.differs(key.path, other))
    }

    /// The value of a key; none where the part that has it is missing.
    fn value(&self, key: &Key) -> Option<String> {
        self.reached(|at| key.kind.text(at)).flatten()
    }

    /// What is found at a place; none where the part that has it is missing, and is added on the way there.
    fn reached<T>(&self, find: impl FnOnce(&mut Self) -> T) -> Option<T> {
        let mut reached = self.clone();
        let found = find(&mut reached);
        // A number that is none differs from itself, but not in words.
        let is_same = || format!("{reached:?}") == format!("{self:?}");
        (reached == *self || is_same()).then_some(found)
    }
}

/// True if a text says no more with this value of a key than without it. Blank options may hold another value than the
/// default.
fn is_default(key: &Key, stated: &str, blank: &Options) -> bool {
    if blank.value(key).is_some_and(|blank| blank != stated) {
        return false;
    }
    let mut options = blank.clone();
    match key.default {
        Default::Required(_) => return false,
        Default::Value(number) | Default::Initial(number) => {
            key.kind.set_number(number, &mut options);
        }
        Default::FirstChoice => {
            if let Kind::Choice(_, set, _) = key.kind {
                set(&mut options, 0);
            }
        }
        Default::Derived(_) => {}
    }
    key.kind.text(&mut options).is_some_and(|of| of == stated)
}
