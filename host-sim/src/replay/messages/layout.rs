//! Which field of which topic is what: found out by reading the file once.

use std::collections::BTreeMap;
use std::path::Path;

use serde_json::Value;

use super::super::error::{LogError, shortened};
use super::field::FieldPath;
use crate::log_file::{Damage, Record, Records};
use crate::nearest;
use crate::scenario::{Column, LogSettings, TimeUnit};

/// The name of the time at which messages were logged, where a column of time is stated.
const LOG_TIME: &str = "log_time";

/// Fields of a topic that are known by name.
const MOST_FIELDS: usize = 1000;

/// Which field of which topic is what.
#[derive(Debug, Clone, PartialEq)]
pub(in super::super) struct Layout {
    pub(super) time: TimeFrom,
    /// The topic whose messages are the samples.
    pub(super) topic: String,
    /// The topics that are read, that of the samples among them, with their fields.
    pub(super) topics: Vec<Topic>,
}

/// What tells the time of a sample.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum TimeFrom {
    /// When its message was logged.
    Log,
    /// A field.
    Field,
    /// The samples are counted.
    Count,
}

/// The fields of a topic that are read.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Topic {
    pub(super) name: String,
    pub(super) fields: Vec<Field>,
    /// Their paths, in the same order.
    pub(super) paths: Vec<FieldPath>,
}

/// A field that is read.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Field {
    pub(super) is: Role,
    /// As messages call it.
    pub(super) name: String,
    /// SI units for one of the field's.
    pub(super) scale: f64,
}

/// What a field is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Role {
    Time,
    Reference,
    Position,
    Command,
    Injection,
}

/// What the file has: topics with their encoding, and the paths of the first message of each.
#[derive(Debug, Default)]
struct Contents(BTreeMap<String, Contained>);

#[derive(Debug)]
struct Contained {
    encoding: String,
    paths: Option<Vec<String>>,
}

impl Layout {
    /// Reads all of a file, and finds the columns.
    ///
    /// # Errors
    /// What is wrong with the file, or the column that it has not got.
    pub(in super::super) fn of_file(path: &Path, settings: &LogSettings) -> Result<Self, LogError> {
        let contents = Contents::of_file(path)
            .map_err(|damage| LogError::of_file(path, damage.to_string()))?;
        let mut layout = Self {
            time: match &settings.time {
                None => TimeFrom::Count,
                Some(Column::Named(name)) if name == LOG_TIME => TimeFrom::Log,
                Some(_) => TimeFrom::Field,
            },
            topic: String::new(),
            topics: Vec::new(),
        };
        if layout.time == TimeFrom::Log && settings.units.time != TimeUnit::Second {
            let fault = "log_time is in seconds: leave log.time_unit out".to_owned();
            return Err(LogError::of_file(path, fault));
        }
        let units = &settings.units;
        for (is, column, scale) in [
            (Role::Position, Some(&settings.position), units.position()),
            (
                Role::Time,
                (settings.time.as_ref()).filter(|_| layout.time == TimeFrom::Field),
                // Of a counter, the samples.
                units.seconds(1.0),
            ),
            (
                Role::Reference,
                settings.reference.as_ref(),
                units.reference(),
            ),
            (
                Role::Command,
                settings.command.as_ref(),
                units.command_scale,
            ),
            (
                Role::Injection,
                settings.injection.as_ref(),
                units.command_scale,
            ),
        ] {
            let Some(column) = column else { continue };
            let (topic, field) = contents.find(column).map_err(|fault| LogError {
                column: Some(column.to_string()),
                ..LogError::of_file(path, fault)
            })?;
            if is == Role::Position {
                layout.topic = topic.to_owned();
            }
            if is == Role::Time && topic != layout.topic {
                let fault = format!(
                    "the time of a sample must be in the message of its position, which is of {}: \
                     state such a field, or log.time = \"{LOG_TIME}\"",
                    layout.topic
                );
                return Err(LogError::of_file(path, fault));
            }
            layout.add(
                topic,
                field,
                Field {
                    is,
                    name: column.to_string(),
                    scale,
                },
            );
        }
        Ok(layout)
    }

    fn add(&mut self, topic: &str, path: FieldPath, field: Field) {
        let known = self.topics.iter().position(|known| known.name == topic);
        let index = known.unwrap_or_else(|| {
            self.topics.push(Topic {
                name: topic.to_owned(),
                fields: Vec::new(),
                paths: Vec::new(),
            });
            self.topics.len() - 1
        });
        self.topics[index].fields.push(field);
        self.topics[index].paths.push(path);
    }
}

impl Contents {
    fn of_file(path: &Path) -> Result<Self, Damage> {
        let mut contents = Self::default();
        let mut topics: BTreeMap<u16, String> = BTreeMap::new();
        let mut records = Records::open(path)?;
        while let Some(record) = records.next_record()? {
            match record {
                Record::Channel {
                    id,
                    topic,
                    encoding,
                } => {
                    let paths = None;
                    let contained = Contained { encoding, paths };
                    contents.0.entry(topic.clone()).or_insert(contained);
                    topics.insert(id, topic);
                }
                Record::Message { channel, data, .. } => {
                    let topic = topics.get(&channel).ok_or(Damage::Broken)?;
                    if let Some(Contained { paths, encoding }) = contents.0.get_mut(topic)
                        && paths.is_none()
                        && encoding == "json"
                    {
                        let message = serde_json::from_slice(data).unwrap_or(Value::Null);
                        *paths = Some(FieldPath::all_of(&message, MOST_FIELDS));
                    }
                }
                Record::Metadata { .. } => {}
            }
        }
        Ok(contents)
    }

    /// The topic and the field of a column.
    fn find(&self, column: &Column) -> Result<(&str, FieldPath), String> {
        let Column::Named(name) = column else {
            let known = self.known_names().unwrap_or_default();
            return Err(format!(
                "the columns of an MCAP log go by name, topic.field: this one has {known}"
            ));
        };
        let bare = name.trim_start_matches('/');
        let mut of_topics = self.0.iter().filter_map(|(topic, contained)| {
            let field = bare.strip_prefix(topic.trim_start_matches('/'))?;
            Some((topic, contained, FieldPath::read(field.strip_prefix('.')?)?))
        });
        if let Some((topic, contained, path)) = of_topics.next() {
            return match contained.encoding.as_str() {
                "json" if contained.has(bare, topic) => Ok((topic, path)),
                "json" => Err(self.missing(name)),
                other => Err(format!(
                    "the messages of {topic} are written as \"{}\": only \"json\" is read; convert the \
                     log, or save the signals as .csv",
                    shortened(other)
                )),
            };
        }
        let mut with_field = self
            .0
            .iter()
            .filter(|(_, contained)| contained.paths().any(|path| path == name));
        match (with_field.next(), with_field.next(), FieldPath::read(name)) {
            (Some((topic, _)), None, Some(path)) => Ok((topic, path)),
            (Some((one, _)), Some((other, _)), _) => {
                let of = |topic: &str| format!("{}.{name}", topic.trim_start_matches('/'));
                Err(format!(
                    "more than one topic has this field: state {} or {}",
                    of(one),
                    of(other)
                ))
            }
            _ => Err(self.missing(name)),
        }
    }

    fn missing(&self, name: &str) -> String {
        let names: Vec<String> = self.names().collect();
        let Some(known) = self.known_names() else {
            return "the log has no message written in \"json\" with a number in it, and no other is \
                    read: convert it, or save the signals as .csv"
                .to_owned();
        };
        match nearest::name(
            name.trim_start_matches('/'),
            names.iter().map(String::as_str),
        ) {
            Some(near) => format!(
                "the log has no such field: did you mean {}? It has {known}",
                shortened(near)
            ),
            None => format!(
                "the log has no such field, but {known}: [log] in the scenario says which column is what"
            ),
        }
    }

    fn names(&self) -> impl Iterator<Item = String> + '_ {
        self.0.iter().flat_map(|(topic, contained)| {
            let topic = topic.trim_start_matches('/');
            contained.paths().map(move |path| format!("{topic}.{path}"))
        })
    }

    fn known_names(&self) -> Option<String> {
        let names: Vec<String> = self.names().collect();
        (!names.is_empty()).then(|| shortened(&names.join(", ")))
    }
}

impl Contained {
    fn paths(&self) -> impl Iterator<Item = &String> {
        self.paths.iter().flatten()
    }

    /// Whether the first message has the field that a column names behind its topic.
    fn has(&self, column: &str, topic: &str) -> bool {
        let topic = topic.trim_start_matches('/');
        let field = column
            .strip_prefix(topic)
            .and_then(|rest| rest.strip_prefix('.'));
        self.paths().any(|path| Some(path.as_str()) == field)
    }
}
