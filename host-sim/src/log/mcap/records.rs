//! The records of an MCAP file, one after the other.

use std::collections::BTreeMap;
use std::fmt;
use std::fs::File;
use std::io::{self, BufReader, Read};
use std::path::Path;

use mcap::McapError;
use mcap::records::{ChunkHeader, Record as Parsed, op};
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};

/// The longest record, packed and unpacked, bytes, whatever the file states.
const MAX_RECORD: usize = 1 << 28;

/// Bytes before a record: its kind and its length.
const PREFIX: usize = 1 + 8;

/// A record of a file.
#[derive(Debug, Clone, PartialEq)]
pub enum McapRecord<'a> {
    /// A channel begins.
    Channel {
        /// Its number in the file.
        id: u16,
        /// Its name.
        topic: String,
        /// The encoding of its messages.
        encoding: String,
    },
    /// A message of a channel.
    Message {
        /// The channel's number.
        channel: u16,
        /// When it was logged, ns.
        log_time: u64,
        /// Its text or bytes.
        data: &'a [u8],
    },
    /// A description of the file.
    Metadata {
        /// Its name.
        name: String,
        /// Its entries.
        entries: BTreeMap<String, String>,
    },
}

/// Why a file cannot be read to its end.
#[derive(Debug, thiserror::Error)]
pub enum Damage {
    /// It does not begin as an MCAP file does.
    #[error(
        "this is not an MCAP file: a log has the ending .mcap only if it is one, and .csv or .csv.gz otherwise"
    )]
    NoMcap,
    /// It ends too early.
    #[error(
        "the MCAP file ends too early, as one does whose recording broke off: `mcap recover` makes a whole file \
         of what is there"
    )]
    CutOff,
    /// Its chunks are packed in an unknown way.
    #[error(
        "the MCAP file is packed with \"{0}\": it may be unpacked, or packed with lz4 or zstd (`mcap compress` \
         does it)"
    )]
    Packed(String),
    /// Its contents contradict its check sums or lengths.
    #[error(
        "the MCAP file is damaged: what it holds is not what its check sums and lengths say; copy it again, or \
         try `mcap recover`"
    )]
    Broken,
    /// A record is longer than any that is read.
    #[error(
        "the MCAP file has a record of more than {MAX_RECORD} bytes: it is damaged, or holds something else than \
         signals; `mcap filter` leaves topics out"
    )]
    TooLong,
    /// The system cannot read it.
    #[error("the log cannot be read: {0}")]
    Unreadable(io::Error),
}

impl From<McapError> for Damage {
    fn from(error: McapError) -> Self {
        match error {
            McapError::UnexpectedEof | McapError::BadFooter => Self::CutOff,
            McapError::RecordTooLarge { .. } | McapError::ChunkTooLarge(_) => Self::TooLong,
            McapError::Io(error) => Self::Unreadable(error),
            _ => Self::Broken,
        }
    }
}

/// True for an MCAP file, by its name or its first bytes.
#[must_use]
pub fn is_mcap(path: &Path) -> bool {
    let mut first = Vec::new();
    let begins = File::open(path).and_then(|file| {
        file.take(mcap::MAGIC.len() as u64)
            .read_to_end(&mut first)
            .map(|_| first == mcap::MAGIC)
    });
    begins.unwrap_or(false) || path.extension().is_some_and(|end| end == "mcap")
}

/// Reads an MCAP file record by record, packed or not.
pub struct Records<R> {
    source: R,
    reader: LinearReader,
    /// The records of the chunk that is being read, unpacked, and where the next one begins.
    chunk: Vec<u8>,
    at: usize,
    /// The body of the record that was read last.
    body: Vec<u8>,
    /// Bytes that have been read.
    read: usize,
    /// True once a record has been read.
    begun: bool,
    /// True once all data have been read, and only their summary is to come.
    past_data: bool,
}

impl Records<BufReader<File>> {
    /// Opens a file.
    ///
    /// # Errors
    /// If it cannot be opened.
    pub fn open(path: &Path) -> Result<Self, Damage> {
        let file = File::open(path).map_err(Damage::Unreadable)?;
        Ok(Self::new(BufReader::with_capacity(1 << 16, file)))
    }
}

impl<R: Read> Records<R> {
    /// Reads from the beginning of a file.
    pub fn new(source: R) -> Self {
        let options = LinearReaderOptions::default()
            .with_emit_chunks(true)
            .with_record_length_limit(MAX_RECORD);
        Self {
            source,
            reader: LinearReader::new_with_options(options),
            chunk: Vec::new(),
            at: 0,
            body: Vec::new(),
            read: 0,
            begun: false,
            past_data: false,
        }
    }

    /// The next record; none at the end of a whole file.
    ///
    /// # Errors
    /// Why there is no more to be read, although the file does not end here.
    pub fn next_record(&mut self) -> Result<Option<McapRecord<'_>>, Damage> {
        let kind = loop {
            let Some(kind) = self.advance()? else {
                return Ok(None);
            };
            match kind {
                op::DATA_END => self.past_data = true,
                op::CHANNEL | op::MESSAGE | op::METADATA if !self.past_data => break kind,
                _ => {}
            }
        };
        Ok(Some(match mcap::parse_record(kind, &self.body)? {
            Parsed::Channel(channel) => McapRecord::Channel {
                id: channel.id,
                topic: channel.topic,
                encoding: channel.message_encoding,
            },
            Parsed::Metadata(metadata) => McapRecord::Metadata {
                name: metadata.name,
                entries: metadata.metadata,
            },
            Parsed::Message { header, .. } => {
                /// Channel, number, and two times.
                const HEADER: usize = 2 + 4 + 8 + 8;
                McapRecord::Message {
                    channel: header.channel_id,
                    log_time: header.log_time,
                    data: &self.body[HEADER..],
                }
            }
            _ => return Err(Damage::Broken),
        }))
    }

    /// Reads the next record's body, and answers with its kind.
    fn advance(&mut self) -> Result<Option<u8>, Damage> {
        loop {
            if self.at < self.chunk.len() {
                return self.next_of_chunk().map(Some);
            }
            let chunk = loop {
                match self.reader.next_event() {
                    None => return Ok(None),
                    Some(Err(McapError::BadMagic)) if !self.begun => return Err(Damage::NoMcap),
                    Some(Err(McapError::UnexpectedEof)) if self.read < mcap::MAGIC.len() => {
                        return Err(Damage::NoMcap);
                    }
                    Some(Err(error)) => return Err(error.into()),
                    Some(Ok(LinearReadEvent::ReadRequest(wanted))) => {
                        let read = read_some(&mut self.source, self.reader.insert(wanted));
                        let read = read.map_err(Damage::Unreadable)?;
                        self.read = self.read.saturating_add(read);
                        self.reader.notify_read(read);
                    }
                    Some(Ok(LinearReadEvent::Record { opcode, data })) => {
                        self.begun = true;
                        if opcode != op::CHUNK {
                            self.body.clear();
                            self.body.extend_from_slice(data);
                            return Ok(Some(opcode));
                        }
                        break unpacked(data, &mut self.chunk);
                    }
                }
            };
            chunk?;
            self.at = 0;
        }
    }

    fn next_of_chunk(&mut self) -> Result<u8, Damage> {
        let rest = &self.chunk[self.at..];
        let (prefix, rest) = rest.split_at_checked(PREFIX).ok_or(Damage::Broken)?;
        let mut length = [0; 8];
        length.copy_from_slice(&prefix[1..]);
        let length = usize::try_from(u64::from_le_bytes(length)).unwrap_or(usize::MAX);
        let body = rest.get(..length).ok_or(Damage::Broken)?;
        self.body.clear();
        self.body.extend_from_slice(body);
        self.at += PREFIX + length;
        Ok(prefix[0])
    }
}

fn read_some(source: &mut impl Read, room: &mut [u8]) -> io::Result<usize> {
    loop {
        match source.read(room) {
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            done => return done,
        }
    }
}

/// Unpacks a chunk into `records`.
fn unpacked(chunk: &[u8], records: &mut Vec<u8>) -> Result<(), Damage> {
    let Parsed::Chunk { header, data } = mcap::parse_record(op::CHUNK, chunk)? else {
        return Err(Damage::Broken);
    };
    records.clear();
    if header.uncompressed_size > MAX_RECORD as u64 {
        return Err(Damage::TooLong);
    }
    let packed: &[u8] = &data;
    match header.compression.as_str() {
        "" => read_out(packed, &header, records),
        "lz4" => read_out(lz4_flex::frame::FrameDecoder::new(packed), &header, records),
        "zstd" => {
            let decoder = ruzstd::decoding::StreamingDecoder::new(packed);
            read_out(decoder.map_err(|_| Damage::Broken)?, &header, records)
        }
        other => Err(Damage::Packed(other.chars().take(20).collect())),
    }
}

fn read_out(from: impl Read, header: &ChunkHeader, records: &mut Vec<u8>) -> Result<(), Damage> {
    // A byte more than is stated shows that there are more.
    let read = from
        .take(header.uncompressed_size + 1)
        .read_to_end(records)
        .map_err(|_| Damage::Broken)?;
    let sums_up =
        || header.uncompressed_crc == 0 || header.uncompressed_crc == crc32fast::hash(records);
    if read as u64 == header.uncompressed_size && sums_up() {
        return Ok(());
    }
    records.clear();
    Err(Damage::Broken)
}

impl<R: fmt::Debug> fmt::Debug for Records<R> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut shown = f.debug_struct("Records");
        shown.field("source", &self.source);
        shown.field("at", &self.at).finish_non_exhaustive()
    }
}
