use crc::{CRC_32_ISO_HDLC, Crc};
use heapless::Vec;
use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::message::{Command, PROTOCOL, Refusal, Report, Request, STOP};

/// Bytes of the longest message before framing, its check included: settings with nothing left out
/// take some 750.
pub const MAX_MESSAGE_BYTES: usize = 768;

/// Bytes of the longest frame: one more in 254 for COBS, and the zero at the end.
pub const MAX_FRAME_BYTES: usize = MAX_MESSAGE_BYTES + MAX_MESSAGE_BYTES / 254 + 2;

const CHECK: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

/// Bytes of the check at the end of a message.
const CHECK_BYTES: usize = 4;

/// A message of one direction. The check begins from its seed, so that an echo on the line is no message of the other
/// direction.
pub trait Message: Serialize + Sized {
    /// The value that the CRC-32 begins from.
    const SEED: u32;

    /// The message of a version up to 21, in which both directions had the seed of requests, if it is still understood.
    fn of_earlier_version(_message: &[u8]) -> Option<Self> {
        None
    }
}

impl Message for Request {
    /// That of CRC-32 itself: the bytes of a stop are the same in every version from 18 on.
    const SEED: u32 = u32::MAX;
}

impl Message for Report {
    const SEED: u32 = u32::from_le_bytes(*b"rprt");

    fn of_earlier_version(message: &[u8]) -> Option<Self> {
        // What a stop is answered with, and any other request.
        whole(message).filter(|report| {
            matches!(
                report,
                Self::Done { .. }
                    | Self::Refused {
                        refusal: Refusal::NotUnderstood { .. },
                        ..
                    }
            )
        })
    }
}

/// Failures of framing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[error("the message is of another version of the protocol")]
#[non_exhaustive]
pub enum FrameError {
    /// Longer than any message: a zero was lost, or the other end speaks something else.
    #[error("a frame is longer than any message: is this the drive's port?")]
    TooLong,
    /// The bytes between two zeros are no COBS.
    #[error("bytes were lost on the line: what came is no frame")]
    NotFramed,
    /// The check does not fit: bytes were lost or changed.
    #[error("bytes were damaged on the line: the checksum is wrong")]
    Damaged,
    /// Undamaged, but no message of this version.
    Unknown,
    /// The same of a request, which is to be refused.
    NoRequest {
        /// Its number.
        id: u8,
        /// The byte in the place of [`PROTOCOL`].
        given: u8,
        /// Its bytes.
        bytes: u16,
    },
}

/// A message as the bytes of a frame, the zero at its end included.
///
/// # Errors
/// [`FrameError::TooLong`].
pub fn frame<T: Message>(message: &T) -> Result<Vec<u8, MAX_FRAME_BYTES>, FrameError> {
    let mut plain = [0; MAX_MESSAGE_BYTES];
    let room = MAX_MESSAGE_BYTES - CHECK_BYTES;
    let used = plain
        .get_mut(..room)
        .and_then(|room| postcard::to_slice(message, room).ok())
        .map(|bytes| (bytes.len(), check(bytes, T::SEED)));
    let (length, check) = used.ok_or(FrameError::TooLong)?;
    for (place, byte) in plain.iter_mut().skip(length).zip(check.to_le_bytes()) {
        *place = byte;
    }
    let mut framed = Vec::new();
    framed
        .resize(MAX_FRAME_BYTES, 0)
        .map_err(|_| FrameError::TooLong)?;
    let mut encoder = cobs::CobsEncoder::new(&mut framed);
    let whole = plain
        .get(..length + CHECK_BYTES)
        .ok_or(FrameError::TooLong)?;
    encoder.push(whole).map_err(|_| FrameError::TooLong)?;
    let end = encoder.finalize();
    // The rest is zero already: its first byte ends the frame.
    framed.truncate(end + 1);
    Ok(framed)
}

impl Report {
    /// Its frame; see [`frame`].
    ///
    /// # Errors
    /// [`FrameError::TooLong`].
    // Not generic: it is compiled here, and once.
    #[inline(never)]
    pub fn framed(&self) -> Result<Vec<u8, MAX_FRAME_BYTES>, FrameError> {
        frame(self)
    }
}

/// Assembles messages from received bytes, in any state.
#[derive(Debug, Default)]
pub struct Receiver {
    bytes: Vec<u8, MAX_FRAME_BYTES>,
    overflowed: bool,
}

impl Receiver {
    /// Waits for the beginning of a frame.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            bytes: Vec::new(),
            overflowed: false,
        }
    }

    /// Takes a byte. The end of a frame gives its message or an error, which costs that frame and no other.
    pub fn take<T: Message + DeserializeOwned>(
        &mut self,
        byte: u8,
    ) -> Option<Result<T, FrameError>> {
        self.take_as(byte, |framed, plain| {
            match checked(framed, plain, T::SEED) {
                Ok(message) => whole(message).ok_or(FrameError::Unknown),
                Err(error) => checked(framed, plain, Request::SEED)
                    .ok()
                    .and_then(T::of_earlier_version)
                    .ok_or(error),
            }
        })
    }

    fn take_as<T>(
        &mut self,
        byte: u8,
        read: impl FnOnce(&[u8], &mut [u8]) -> Result<T, FrameError>,
    ) -> Option<Result<T, FrameError>> {
        if byte != 0 {
            self.overflowed |= self.bytes.push(byte).is_err();
            return None;
        }
        let read = if self.overflowed {
            Some(Err(FrameError::TooLong))
        } else if self.bytes.is_empty() {
            // Two zeros in a row: the sender begins anew.
            None
        } else {
            Some(read(&self.bytes, &mut [0; MAX_FRAME_BYTES]))
        };
        self.bytes.clear();
        self.overflowed = false;
        read
    }

    /// The same of requests.
    // Not generic: it is compiled here, and once.
    #[inline(never)]
    pub fn take_request(&mut self, byte: u8) -> Option<Result<Request, FrameError>> {
        self.take_as(byte, |framed, plain| {
            checked(framed, plain, Request::SEED).and_then(request)
        })
    }
}

/// The request of these bytes.
fn request(message: &[u8]) -> Result<Request, FrameError> {
    let [id, given, ref command @ ..] = *message else {
        return Err(FrameError::Unknown);
    };
    let understood = match given {
        STOP if command.is_empty() => Some((0, Command::Stop)),
        PROTOCOL => whole(command),
        _ => None,
    };
    let bytes = message.len() as u16;
    understood
        .map(|(order, command)| Request { id, order, command })
        .ok_or(FrameError::NoRequest { id, given, bytes })
}

/// A message that takes all of these bytes.
fn whole<T: DeserializeOwned>(bytes: &[u8]) -> Option<T> {
    let (read, rest) = postcard::take_from_bytes(bytes).ok()?;
    rest.is_empty().then_some(read)
}

/// Detects stops alone, byte by byte as received. A stop therefore need not wait for the answers to earlier requests.
#[derive(Debug, Clone, Copy, Default)]
pub struct StopListener {
    bytes: [u8; STOP_BYTES],
    length: usize,
    last: [u8; STOP_BYTES],
    is_resent: bool,
}

/// Bytes of the frame of a stop, without the zero at its end: two of its own, the check, and one for COBS.
const STOP_BYTES: usize = 2 + CHECK_BYTES + 1;

impl StopListener {
    /// Waits for the beginning of a frame.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            bytes: [0; STOP_BYTES],
            length: 0,
            last: [0; STOP_BYTES],
            is_resent: false,
        }
    }

    /// Takes a byte; true at the end of a whole stop.
    pub fn take(&mut self, byte: u8) -> bool {
        if byte != 0 {
            if let Some(place) = self.bytes.get_mut(self.length) {
                *place = byte;
            }
            self.length = self.length.saturating_add(1);
            return false;
        }
        let is_as_long = core::mem::take(&mut self.length) == STOP_BYTES;
        let is_whole = is_as_long && is_stop(&self.bytes);
        if is_whole {
            self.is_resent = self.last == self.bytes;
            self.last = self.bytes;
        }
        is_whole
    }

    /// True if the last stop has the number of the one before: it was sent again, and is no second one.
    #[must_use]
    pub const fn is_resent(&self) -> bool {
        self.is_resent
    }
}

/// True for the frame of a stop. Compared by its bytes: the listener interrupts the background, on top of whose stack a
/// whole decoder would be.
fn is_stop(framed: &[u8; STOP_BYTES]) -> bool {
    let mut plain = [0; STOP_BYTES];
    matches!(checked(framed, &mut plain, Request::SEED), Ok([_, STOP]))
}

/// The check of a message.
fn check(message: &[u8], seed: u32) -> u32 {
    let mut digest = CHECK.digest_with_initial(seed);
    digest.update(message);
    digest.finalize()
}

/// The bytes of the message of a frame, if they are undamaged and of this direction.
fn checked<'a>(bytes: &[u8], plain: &'a mut [u8], seed: u32) -> Result<&'a [u8], FrameError> {
    let mut decoder = cobs::CobsDecoder::new(plain);
    for &byte in bytes {
        match decoder.feed(byte) {
            Ok(None) => {}
            Ok(Some(_)) | Err(_) => return Err(FrameError::NotFramed),
        }
    }
    let length = match decoder.feed(0) {
        Ok(Some(length)) => length,
        Ok(None) | Err(_) => return Err(FrameError::NotFramed),
    };
    let whole = plain.get(..length).ok_or(FrameError::NotFramed)?;
    let (message, given) = whole
        .split_last_chunk::<CHECK_BYTES>()
        .ok_or(FrameError::Damaged)?;
    if check(message, seed) != u32::from_le_bytes(*given) {
        return Err(FrameError::Damaged);
    }
    Ok(message)
}
