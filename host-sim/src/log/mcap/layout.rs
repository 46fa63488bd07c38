//! The topic and field of each column, found by reading the file once.

use std::collections::BTreeMap;
use std::path::Path;

use serde_json::Value;

use super::super::LogError;
use super::super::error::shortened;
use super::{Damage, McapRecord, Records};
use crate::nearest;
use crate::scenario::{Column, LogQuantity, LogSettings, TimeUnit};

/// The name of the time at which messages were logged, as a column of time.
const LOG_TIME: &str = "log_time";

/// The columns of a log of messages.
#[derive(Debug, Clone, PartialEq)]
pub(in super::super) struct Layout {
    pub(super) time: TimeSource,
    /// The topics that are read, with their fields. The messages of the first are the samples.
    pub(super) topics: Vec<Topic>,
}

/// The source of a sample's time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum TimeSource {
    /// When its message was logged.
    LogTime,
    /// A field.
    Field,
    /// The count of samples.
    Count,
}

/// The fields of a topic that are read.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Topic {
    pub(super) name: String,
    pub(super) fields: Vec<Field>,
}

/// A field that is read.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Field {
    pub(super) quantity: LogQuantity,
    /// The column's name in messages.
    pub(super) name: String,
    /// Its JSON pointer in a message.
    pub(super) pointer: String,
}

/// The topics of a file.
#[derive(Debug, Default)]
struct Contents(BTreeMap<String, Contained>);

/// A topic of the file: how it is written, and the numbers of its first message.
#[derive(Debug)]
struct Contained {
    encoding: String,
    numbers: Option<Vec<Number>>,
}

/// A number in a message, by its path, `pose.position.x` or `effort[0]`, and its JSON pointer.
#[derive(Debug, Clone)]
struct Number {
    path: String,
    pointer: String,
}

impl Layout {
    /// Reads all of a file, and finds the columns.
    ///
    /// # Errors
    /// The damage of the file, or the column that is missing.
    pub(in super::super) fn detect(path: &Path, settings: &LogSettings) -> Result<Self, LogError> {
        let contents =
            Contents::read(path).map_err(|damage| LogError::in_file(path, damage.to_string()))?;
        let time = match &settings.time {
            None => TimeSource::Count,
            Some(Column::Named(name)) if name == LOG_TIME => TimeSource::LogTime,
            Some(_) => TimeSource::Field,
        };
        if time == TimeSource::LogTime && settings.units.time != TimeUnit::Second {
            let fault = "log_time is in seconds: leave log.time_unit out".to_owned();
            return Err(LogError::in_file(path, fault));
        }
        let mut topics: Vec<Topic> = Vec::new();
        // The topic of the position is the first.
        let (position, others): (Vec<_>, Vec<_>) =
            (settings.columns()).partition(|(quantity, _)| *quantity == LogQuantity::Position);
        for (quantity, column) in position.into_iter().chain(others) {
            if quantity == LogQuantity::Time && time == TimeSource::LogTime {
                continue;
            }
            let (topic, number) = contents.find(column).map_err(|fault| LogError {
                column: Some(column.to_string()),
                ..LogError::in_file(path, fault)
            })?;
            if let Some(samples) = topics.first()
                && quantity == LogQuantity::Time
                && samples.name != topic
            {
                let fault = format!(
                    "the time of a sample must be in the message of its position, which is of {}: \
                     state such a field, or log.time = \"{LOG_TIME}\"",
                    samples.name
                );
                return Err(LogError::in_file(path, fault));
            }
            let field = Field {
                quantity,
                name: column.to_string(),
                pointer: number.pointer.clone(),
            };
            match topics.iter_mut().find(|known| known.name == topic) {
                Some(known) => known.fields.push(field),
                None => topics.push(Topic {
                    name: topic.to_owned(),
                    fields: vec![field],
                }),
            }
        }
        Ok(Self { time, topics })
    }
}

impl Contents {
    fn read(path: &Path) -> Result<Self, Damage> {
        let mut contents = Self::default();
        let mut topics: BTreeMap<u16, String> = BTreeMap::new();
        let mut records = Records::open(path)?;
        while let Some(record) = records.next_record()? {
            match record {
                McapRecord::Channel {
                    id,
                    topic,
                    encoding,
                } => {
                    contents.0.entry(topic.clone()).or_insert(Contained {
                        encoding,
                        numbers: None,
                    });
                    topics.insert(id, topic);
                }
                McapRecord::Message { channel, data, .. } => {
                    let topic = topics.get(&channel).ok_or(Damage::Broken)?;
                    if let Some(Contained { numbers, encoding }) = contents.0.get_mut(topic)
                        && numbers.is_none()
                        && encoding == "json"
                    {
                        let message = serde_json::from_slice(data).unwrap_or(Value::Null);
                        *numbers = Some(Number::all_in(&message));
                    }
                }
                McapRecord::Metadata { .. } => {}
            }
        }
        Ok(contents)
    }

    /// The topic and the number of a column.
    fn find(&self, column: &Column) -> Result<(&str, &Number), String> {
        let Column::Named(name) = column else {
            let known = self.known_names().unwrap_or_default();
            return Err(format!(
                "the columns of an MCAP log go by name, topic.field: this one has {known}"
            ));
        };
        let bare = without_slash(name);
        if let Some((topic, number)) = self
            .numbers()
            .find(|(topic, number)| number.name(topic) == bare)
        {
            return Ok((topic, number));
        }
        let in_topic = |topic: &str| bare.strip_prefix(without_slash(topic))?.strip_prefix('.');
        if let Some((topic, contained)) = self.0.iter().find(|(topic, _)| in_topic(topic).is_some())
            && contained.encoding != "json"
        {
            return Err(format!(
                "the messages of {topic} are written as \"{}\": only \"json\" is read; convert the \
                 log, or save the signals as .csv",
                shortened(&contained.encoding)
            ));
        }
        let mut with_field = self.numbers().filter(|(_, number)| number.path == *name);
        match (with_field.next(), with_field.next()) {
            (Some(found), None) => Ok(found),
            (Some((one, number)), Some((other, _))) => Err(format!(
                "more than one topic has this field: state {} or {}",
                number.name(one),
                number.name(other)
            )),
            (None, _) => Err(self.missing(bare)),
        }
    }

    fn missing(&self, name: &str) -> String {
        let Some(known) = self.known_names() else {
            return "the log has no message written in \"json\" with a number in it, and no other is \
                    read: convert it, or save the signals as .csv"
                .to_owned();
        };
        let names = self.names();
        match nearest::name(name, names.iter().map(String::as_str)) {
            Some(near) => format!(
                "the log has no such field: did you mean {}? It has {known}",
                shortened(near)
            ),
            None => format!(
                "the log has no such field, but {known}: [log] in the scenario says which column is what"
            ),
        }
    }

    fn numbers(&self) -> impl Iterator<Item = (&str, &Number)> {
        self.0.iter().flat_map(|(topic, contained)| {
            (contained.numbers.iter().flatten()).map(move |number| (topic.as_str(), number))
        })
    }

    fn names(&self) -> Vec<String> {
        self.numbers()
            .map(|(topic, number)| number.name(topic))
            .collect()
    }

    fn known_names(&self) -> Option<String> {
        let names = self.names();
        (!names.is_empty()).then(|| shortened(&names.join(", ")))
    }
}

fn without_slash(name: &str) -> &str {
    name.trim_start_matches('/')
}

impl Number {
    /// The most numbers of a message that are known by name.
    const MAX: usize = 1000;

    /// All numbers of a message.
    fn all_in(message: &Value) -> Vec<Self> {
        let root = Self {
            path: String::new(),
            pointer: String::new(),
        };
        let mut found = Vec::new();
        root.collect(message, &mut found);
        found
    }

    fn collect(self, value: &Value, found: &mut Vec<Self>) {
        if found.len() == Self::MAX {
            return;
        }
        let Self { path, pointer } = &self;
        match value {
            Value::Number(_) => found.push(self),
            Value::Array(items) => {
                for (place, item) in items.iter().enumerate() {
                    let inner = Self {
                        path: format!("{path}[{place}]"),
                        pointer: format!("{pointer}/{place}"),
                    };
                    inner.collect(item, found);
                }
            }
            Value::Object(fields) => {
                let dot = if path.is_empty() { "" } else { "." };
                for (name, field) in fields {
                    // As RFC 6901 escapes names.
                    let escaped = name.replace('~', "~0").replace('/', "~1");
                    let inner = Self {
                        path: format!("{path}{dot}{name}"),
                        pointer: format!("{pointer}/{escaped}"),
                    };
                    inner.collect(field, found);
                }
            }
            _ => {}
        }
    }

    /// Its name as a column, `topic.path`.
    fn name(&self, topic: &str) -> String {
        format!("{}.{}", without_slash(topic), self.path)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_found_at_any_depth_by_path_and_pointer() {
        let message: Value = serde_json::from_str(
            r#"{"t":1,"pose":{"x/y":-2.5},"effort":[3,[4e1]],"a.b":5,"name":["a"],"ok":true}"#,
        )
        .expect("JSON");
        let found = Number::all_in(&message);
        let values = found.iter().map(|number| {
            let value = message.pointer(&number.pointer).and_then(Value::as_f64);
            (number.path.as_str(), value.expect("a number"))
        });
        let mut values: Vec<_> = values.collect();
        values.sort_by_key(|(path, _)| *path);
        let expected = [
            ("a.b", 5.0),
            ("effort[0]", 3.0),
            ("effort[1][0]", 40.0),
            ("pose.x/y", -2.5),
            ("t", 1.0),
        ];
        assert_eq!(values, expected);
        let many: Value = (0..2 * Number::MAX).collect();
        assert_eq!(Number::all_in(&many).len(), Number::MAX);
    }

    #[test]
    fn a_number_is_the_one_that_was_written_to_the_last_bit() {
        for number in [
            0.1 + 0.2,
            1.0 / 3.0,
            2.2250738585072014e-308,
            123_456_789.123_456_78,
        ] {
            let message: Value =
                serde_json::from_str(&format!("{{\"q\":{number}}}")).expect("JSON");
            assert_eq!(message.pointer("/q").and_then(Value::as_f64), Some(number));
        }
    }
}
