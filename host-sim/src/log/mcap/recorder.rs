//! Writes an MCAP file, message by message.

use std::collections::BTreeMap;
use std::fmt::{self, Write as _};
use std::io::{self, Write};

use mcap::records::MessageHeader;
use mcap::write::{Metadata, NoSeek};
use mcap::{McapError, WriteOptions, Writer};
use serde_json::Value;

use super::Channel;
use super::channel::{JOINT, JOINTS, joint_states};

/// Nanoseconds of a second.
const NANOSECONDS: f64 = 1e9;

/// An MCAP file that is being written, to anything that takes bytes. It is not packed: `mcap compress`
/// does that where room is short.
pub struct Recorder<W: Write> {
    writer: Writer<NoSeek<W>>,
    channels: Vec<(&'static Channel, u16)>,
    joints: u16,
    sequence: u32,
    text: String,
}

impl<W: Write> Recorder<W> {
    /// Begins a file with these channels beside the joint states.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn new(out: W, channels: &[&'static Channel]) -> io::Result<Self> {
        let options = WriteOptions::new()
            .compression(None)
            .disable_seeking(true)
            .library(format!("servo-id {}", crate::VERSION));
        let mut writer = options.create(NoSeek::new(out)).map_err(io_error)?;
        let mut begin = |topic: &str, schema: &str, text: &Value| {
            let schema = writer.add_schema(schema, "jsonschema", text.to_string().as_bytes())?;
            writer.add_channel(schema, topic, "json", &BTreeMap::new())
        };
        let joints = begin(JOINTS, "sensor_msgs/JointState", &joint_states()).map_err(io_error)?;
        let begun = channels.iter().map(|channel| {
            let id = begin(channel.topic, channel.schema, &channel.schema())?;
            Ok((*channel, id))
        });
        let channels = begun.collect::<Result<_, McapError>>().map_err(io_error)?;
        Ok(Self {
            writer,
            channels,
            joints,
            sequence: 0,
            text: String::new(),
        })
    }

    /// The next sample: all messages until the next are of it.
    pub fn begin_sample(&mut self) {
        self.sequence = self.sequence.wrapping_add(1);
    }

    /// A message of a channel, s; values in the order of its fields. Values that are unknown or not finite are left
    /// out.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn numbers(
        &mut self,
        channel: &'static Channel,
        time: f64,
        values: impl IntoIterator<Item = Option<f64>>,
    ) -> io::Result<()> {
        let known = self.channels.iter().find(|(known, _)| *known == channel);
        let Some((_, id)) = known.copied() else {
            return Ok(());
        };
        self.text.clear();
        self.text.push('{');
        for ((name, _), value) in channel.fields.iter().zip(values) {
            if let Some(value) = value.filter(|value| value.is_finite()) {
                let comma = if self.text.len() > 1 { "," } else { "" };
                // Writing into memory cannot fail.
                let _ = write!(self.text, "{comma}\"{name}\":{value}");
            }
        }
        self.text.push('}');
        self.message(id, time)
    }

    /// The joint's state, s, rad, rad/s and command units; an unknown value is an empty list.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn joint(
        &mut self,
        time: f64,
        position: Option<f64>,
        velocity: Option<f64>,
        effort: Option<f64>,
    ) -> io::Result<()> {
        let stamp = nanoseconds(time);
        let (sec, nanosec) = (stamp / 1_000_000_000, stamp % 1_000_000_000);
        self.text.clear();
        let _ = write!(
            self.text,
            "{{\"header\":{{\"stamp\":{{\"sec\":{sec},\"nanosec\":{nanosec}}},\"frame_id\":\"\"}},\
             \"name\":[\"{JOINT}\"]"
        );
        for (name, value) in [
            ("position", position),
            ("velocity", velocity),
            ("effort", effort),
        ] {
            let _ = match value.filter(|value| value.is_finite()) {
                Some(value) => write!(self.text, ",\"{name}\":[{value}]"),
                None => write!(self.text, ",\"{name}\":[]"),
            };
        }
        self.text.push('}');
        self.message(self.joints, time)
    }

    fn message(&mut self, channel_id: u16, time: f64) -> io::Result<()> {
        let log_time = nanoseconds(time);
        let header = MessageHeader {
            channel_id,
            sequence: self.sequence,
            log_time,
            publish_time: log_time,
        };
        self.writer
            .write_to_known_channel(&header, self.text.as_bytes())
            .map_err(io_error)
    }

    /// A description of the file.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn about(&mut self, name: &str, entries: BTreeMap<String, String>) -> io::Result<()> {
        let metadata = Metadata {
            name: name.to_owned(),
            metadata: entries,
        };
        self.writer.write_metadata(&metadata).map_err(io_error)
    }

    /// Ends the file and gives back its writer.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn finish(mut self) -> io::Result<W> {
        self.writer.finish().map_err(io_error)?;
        Ok(self.writer.into_inner().into_inner())
    }
}

fn nanoseconds(time: f64) -> u64 {
    (time * NANOSECONDS).round() as u64
}

fn io_error(error: McapError) -> io::Error {
    match error {
        McapError::Io(error) => error,
        other => io::Error::other(other),
    }
}

impl<W: Write + fmt::Debug> fmt::Debug for Recorder<W> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut shown = f.debug_struct("Recorder");
        shown.field("channels", &self.channels);
        shown
            .field("sequence", &self.sequence)
            .finish_non_exhaustive()
    }
}
