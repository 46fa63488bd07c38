//! The samples of a log of messages, one at a time.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use super::super::columns::within_bounds;
use super::super::error::{LogError, shortened};
use super::super::rows::{MOST_ROWS, Record as Sample};
use super::field;
use super::layout::{Layout, Role, TimeFrom, Topic};
use crate::log_file::{Record, Records};
use crate::scenario::LogSettings;

/// Seconds of a nanosecond.
const SECONDS: f64 = 1e-9;

/// Reads a log message by message. Samples in ranges of time that are left out are passed over, and so are
/// those at the beginning of which not all is known yet.
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
    /// The numbers of the message that is read.
    taken: Vec<Option<f64>>,
    /// The sample that is complete when the next one comes.
    pending: Option<Pending>,
    /// When the first sample was logged, ns, and the last but one before the pending one.
    first: Option<u64>,
    step: u64,
    /// Messages of the topic of the samples.
    read: u64,
    /// Samples that were left out.
    pub(in super::super) left_out: u64,
}

/// A field of another topic than that of the samples.
#[derive(Debug, Clone, Copy, Default)]
struct Held {
    /// What acts while the pending sample does.
    now: Option<f64>,
    /// What was told too late for it.
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
            Records::open(path).map_err(|damage| LogError::of_file(path, damage.to_string()))?;
        let held = |topic: &Topic| vec![Held::default(); topic.fields.len()];
        Ok(Self {
            path,
            settings,
            layout,
            sample_time,
            records,
            channels: Vec::new(),
            held: layout.topics.iter().map(held).collect(),
            taken: Vec::new(),
            pending: None,
            first: None,
            step: 0,
            read: 0,
            left_out: 0,
        })
    }

    /// Reads on to the next sample, and answers with the one that is complete then; false at the end.
    fn advance(&mut self) -> Result<(bool, Option<Pending>), LogError> {
        let broken = |fault: String| LogError::of_file(self.path, fault);
        loop {
            let record = self.records.next_record();
            let (topic, log_time, data) =
                match record.map_err(|damage| broken(damage.to_string()))? {
                    None => return Ok((false, self.pending.take())),
                    Some(Record::Channel { id, topic, .. }) => {
                        let mut topics = self.layout.topics.iter();
                        let read = topics.position(|read| read.name == topic);
                        let id = usize::from(id);
                        if self.channels.len() <= id {
                            self.channels.resize(id + 1, None);
                        }
                        self.channels[id] = read;
                        continue;
                    }
                    Some(Record::Metadata { .. }) => continue,
                    Some(Record::Message {
                        channel,
                        log_time,
                        data,
                    }) => match self.channels.get(usize::from(channel)).copied().flatten() {
                        Some(topic) => (topic, log_time, data),
                        None => continue,
                    },
                };
            let read = &self.layout.topics[topic];
            let is_sample = read.name == self.layout.topic;
            self.read += u64::from(is_sample);
            self.taken.clear();
            self.taken.resize(read.fields.len(), None);
            field::take(data, &read.paths, &mut self.taken).map_err(|_| {
                let text = shortened(&String::from_utf8_lossy(data));
                let fault = format!("a message of {} is no JSON: {text}", read.name);
                LogError::of_line(self.path, self.read, None, fault)
            })?;
            if !is_sample {
                self.hold(topic, log_time);
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
                values: self.taken.clone(),
            });
            return Ok((true, complete));
        }
    }

    /// Keeps what another topic tells. A command that is told behind a position acts from then on: told in
    /// the first half of a sample it counts as that sample's, otherwise as the next one's.
    fn hold(&mut self, topic: usize, log_time: u64) {
        let late = |pending: &Pending| log_time > pending.log_time.saturating_add(self.step / 2);
        let is_late = self.pending.as_ref().is_some_and(late);
        for (held, taken) in self.held[topic].iter_mut().zip(&self.taken) {
            let place = if is_late {
                &mut held.next
            } else {
                &mut held.now
            };
            *place = taken.or(*place);
        }
    }

    /// What was told too late for the last sample acts now.
    fn renew(&mut self) {
        for held in self.held.iter_mut().flatten() {
            held.now = held.next.take().or(held.now);
        }
    }

    /// The sample that a message makes; nothing where it is left out, or where what it needs of other topics
    /// has not been told yet.
    fn sample(&mut self, of: &Pending) -> Result<Option<Sample>, LogError> {
        let mut sample = Sample {
            line: of.number,
            time: match self.layout.time {
                TimeFrom::Log => {
                    let since = of.log_time as i128 - self.first.unwrap_or_default() as i128;
                    since as f64 * SECONDS
                }
                TimeFrom::Field | TimeFrom::Count => (of.number - 1) as f64 * self.sample_time,
            },
            reference: None,
            position: 0.0,
            command: None,
            injection: 0.0,
            bridged: false,
            begins: false,
        };
        let mut fault = None;
        for (index, topic) in self.layout.topics.iter().enumerate() {
            let own = topic.name == self.layout.topic;
            for (place, field) in topic.fields.iter().enumerate() {
                let told = if own {
                    of.values[place]
                } else {
                    self.held[index][place].now
                };
                let Some(told) = told else {
                    if !own {
                        return Ok(None);
                    }
                    fault.get_or_insert((field, "the message has no number there".to_owned()));
                    continue;
                };
                let scale = match field.is {
                    Role::Time => self.settings.units.seconds(self.sample_time),
                    _ => field.scale,
                };
                let value = scale * told;
                if let Err(why) = within_bounds(value) {
                    fault.get_or_insert((field, format!("{told} is not allowed: {why}")));
                }
                match field.is {
                    Role::Time => sample.time = value,
                    Role::Reference => sample.reference = Some(value),
                    Role::Position => sample.position = value,
                    Role::Command => sample.command = Some(value),
                    Role::Injection => sample.injection = value,
                }
            }
        }
        let mut ranges = self.settings.cut.iter();
        if ranges.any(|[from, to]| (from..=to).contains(&&sample.time)) {
            self.left_out += 1;
            return Ok(None);
        }
        match fault {
            None => Ok(Some(sample)),
            Some((field, fault)) => {
                let fault = format!("{fault}; correct it, or leave its time out with log.cut");
                Err(LogError::of_line(
                    self.path,
                    of.number,
                    Some(&field.name),
                    fault,
                ))
            }
        }
    }
}

impl Iterator for MessageRows<'_> {
    type Item = Result<Sample, LogError>;

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            let (goes_on, complete) = match self.advance() {
                Ok(advanced) => advanced,
                Err(error) => return Some(Err(error)),
            };
            if self.read > MOST_ROWS {
                let fault = format!("the log has more than {MOST_ROWS} samples: divide it");
                return Some(Err(LogError::of_file(self.path, fault)));
            }
            let sample = complete.map(|complete| self.sample(&complete));
            self.renew();
            match sample.and_then(Result::transpose) {
                Some(sample) => return Some(sample),
                None if !goes_on => return None,
                None => {}
            }
        }
    }
}
