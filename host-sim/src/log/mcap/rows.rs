//! The samples of a log of messages, one at a time.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use serde_json::Value;

use super::super::error::shortened;
use super::super::row::{MAX_ROWS, Row, Rows, check_magnitude};
use super::super::{Found, LogError};
use super::layout::{Layout, TimeSource, Topic};
use super::{McapRecord, Records};
use crate::scenario::LogSettings;

/// Seconds of a nanosecond.
const SECONDS: f64 = 1e-9;

/// The topic whose messages are the samples.
const SAMPLES: usize = 0;

/// Reads a log message by message. Samples before the first value of every topic are passed over.
pub(in super::super) struct MessageRows<'a> {
    path: &'a Path,
    settings: &'a LogSettings,
    layout: &'a Layout,
    sample_time: f64,
    records: Records<BufReader<File>>,
    /// The topic of every channel, where it is read.
    channels: Vec<Option<usize>>,
    /// The fields of each topic.
    held: Vec<Vec<Held>>,
    /// The sample that is complete when the next one comes.
    pending: Option<Pending>,
    /// When the first sample was logged, ns, and the last but one before the pending one.
    first: Option<u64>,
    step: u64,
    /// Messages of the topic of the samples.
    read: u64,
    /// Samples that were left out.
    left_out: u64,
}

/// A field of another topic than that of the samples.
#[derive(Debug, Clone, Copy, Default)]
struct Held {
    /// The value that acts while the pending sample does.
    now: Option<f64>,
    /// A value that came too late for it.
    next: Option<f64>,
}

/// A sample and the numbers of its message.
#[derive(Debug, Clone)]
struct Pending {
    number: u64,
    log_time: u64,
    values: Vec<Option<f64>>,
}

impl<'a> MessageRows<'a> {
    /// Opens a file whose layout is known. Samples without a time, and those of a counter, are
    /// `sample_time` (s) apart.
    ///
    /// # Errors
    /// If it cannot be opened.
    pub(in super::super) fn open(
        path: &'a Path,
        settings: &'a LogSettings,
        layout: &'a Layout,
        sample_time: f64,
    ) -> Result<Self, LogError> {
        let records =
            Records::open(path).map_err(|damage| LogError::in_file(path, damage.to_string()))?;
        let held = |topic: &Topic| vec![Held::default(); topic.fields.len()];
        Ok(Self {
            path,
            settings,
            layout,
            sample_time,
            records,
            channels: Vec::new(),
            held: layout.topics.iter().map(held).collect(),
            pending: None,
            first: None,
            step: 0,
            read: 0,
            left_out: 0,
        })
    }

    /// Reads on to the next sample; answers with the one that is complete then. False at the end.
    fn advance(&mut self) -> Result<(bool, Option<Pending>), LogError> {
        let broken = |fault: String| LogError::in_file(self.path, fault);
        loop {
            let record = self.records.next_record();
            let (index, log_time, data) =
                match record.map_err(|damage| broken(damage.to_string()))? {
                    None => return Ok((false, self.pending.take())),
                    Some(McapRecord::Channel { id, topic, .. }) => {
                        let mut topics = self.layout.topics.iter();
                        let index = topics.position(|read| read.name == topic);
                        let id = usize::from(id);
                        if self.channels.len() <= id {
                            self.channels.resize(id + 1, None);
                        }
                        self.channels[id] = index;
                        continue;
                    }
                    Some(McapRecord::Metadata { .. }) => continue,
                    Some(McapRecord::Message {
                        channel,
                        log_time,
                        data,
                    }) => match self.channels.get(usize::from(channel)).copied().flatten() {
                        Some(index) => (index, log_time, data),
                        None => continue,
                    },
                };
            let topic = &self.layout.topics[index];
            self.read += u64::from(index == SAMPLES);
            let message: Value = serde_json::from_slice(data).map_err(|_| {
                let text = shortened(&String::from_utf8_lossy(data));
                let fault = format!("a message of {} is no JSON: {text}", topic.name);
                LogError::at_line(self.path, self.read, None, fault)
            })?;
            let numbers = (topic.fields.iter())
                .map(|field| message.pointer(&field.pointer).and_then(Value::as_f64));
            if index != SAMPLES {
                self.hold(index, log_time, numbers);
                continue;
            }
            let complete = self.pending.take();
            if let Some(last) = &complete {
                self.step = log_time.saturating_sub(last.log_time);
            }
            self.first.get_or_insert(log_time);
            self.pending = Some(Pending {
                number: self.read,
                log_time,
                values: numbers.collect(),
            });
            return Ok((true, complete));
        }
    }

    /// Keeps the values of another topic. A command that comes behind a position acts from then on: in the
    /// first half of a sample it counts as that sample's, otherwise as the next one's.
    fn hold(&mut self, topic: usize, log_time: u64, values: impl Iterator<Item = Option<f64>>) {
        let late = |pending: &Pending| log_time > pending.log_time.saturating_add(self.step / 2);
        let is_late = self.pending.as_ref().is_some_and(late);
        for (held, value) in self.held[topic].iter_mut().zip(values) {
            let place = if is_late {
                &mut held.next
            } else {
                &mut held.now
            };
            *place = value.or(*place);
        }
    }

    /// Values that came too late for the last sample act now.
    fn renew(&mut self) {
        for held in self.held.iter_mut().flatten() {
            held.now = held.next.take().or(held.now);
        }
    }

    /// The sample that a message makes; none where it is left out, or before the first value of another
    /// topic.
    fn sample(&mut self, of: &Pending) -> Result<Option<Row>, LogError> {
        let time = match self.layout.time {
            TimeSource::LogTime => {
                let since = of.log_time as i128 - self.first.unwrap_or_default() as i128;
                since as f64 * SECONDS
            }
            TimeSource::Field | TimeSource::Count => (of.number - 1) as f64 * self.sample_time,
        };
        let mut sample = Row::at(of.number, time);
        let mut fault = None;
        for (index, topic) in self.layout.topics.iter().enumerate() {
            for (place, field) in topic.fields.iter().enumerate() {
                let value = match index {
                    SAMPLES => of.values[place],
                    _ => self.held[index][place].now,
                };
                let Some(logged) = value else {
                    if index != SAMPLES {
                        return Ok(None);
                    }
                    fault.get_or_insert((field, "the message has no number there".to_owned()));
                    continue;
                };
                let units = &self.settings.units;
                let value = units.scale(field.quantity, self.sample_time) * logged;
                if let Err(why) = check_magnitude(value) {
                    fault.get_or_insert((field, format!("{logged} is not allowed: {why}")));
                }
                sample.set(field.quantity, value);
            }
        }
        if self.settings.leaves_out(sample.time) {
            self.left_out += 1;
            return Ok(None);
        }
        match fault {
            None => Ok(Some(sample)),
            Some((field, fault)) => {
                let fault = format!("{fault}; correct it, or leave its time out with log.cut");
                let column = Some(field.name.as_str());
                Err(LogError::at_line(self.path, of.number, column, fault))
            }
        }
    }
}

impl Rows for MessageRows<'_> {
    fn describe(&self, found: &mut Found) {
        found.left_out = self.left_out;
    }
}

impl Iterator for MessageRows<'_> {
    type Item = Result<Row, LogError>;

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            let (more, complete) = match self.advance() {
                Ok(advanced) => advanced,
                Err(error) => return Some(Err(error)),
            };
            if self.read > MAX_ROWS {
                let fault = format!("the log has more than {MAX_ROWS} samples: divide it");
                return Some(Err(LogError::in_file(self.path, fault)));
            }
            let sample = complete.map(|complete| self.sample(&complete));
            self.renew();
            match sample.and_then(Result::transpose) {
                Some(sample) => return Some(sample),
                None if !more => return None,
                None => {}
            }
        }
    }
}
