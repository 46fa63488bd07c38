//! Records that survive a loss of power at any moment.
//!
//! Two areas of flash that can be erased apart are filled with records in turn, one slot each; the
//! newest whole record holds. A record is written behind the last one, never over it, and an area is
//! erased only when the other one holds the newest: so whenever the power goes, either the record
//! before or the new one is whole. 13 records of 1256 bytes fill an area of 16 KiB, so that 10 000
//! cycles of erasing last for 260 000 records.
//!
//! | bytes | what |
//! |---|---|
//! | 0–3 | mark |
//! | 4–5 | version of the contents |
//! | 6–7 | their length |
//! | 8–11 | number of the record, counting up |
//! | 12–15 | CRC-32 of the twelve bytes before and the contents |
//! | 16–… | contents, postcard |
//!
//! A store that others maintain was tried first (`sequential-storage` 8.0): two dozen panics of it
//! survive in the release, which the firmware does not link with.

use core::fmt;

use crc::{CRC_32_ISO_HDLC, Crc};
use drive_link::Kept;
use embedded_storage::nor_flash::NorFlash;
use serde::Serialize;
use serde::de::DeserializeOwned;

const CHECK: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

/// "srvo".
const MARK: [u8; 4] = *b"srvo";

/// Bytes of a slot; whatever a flash writes at once divides it.
const SLOT: usize = 1256;

/// Bytes before the contents.
const HEAD: usize = 16;

/// Bytes of the longest contents.
#[cfg(test)]
pub(crate) const MAX_RECORD_BYTES: usize = SLOT - HEAD;

/// The areas.
const AREAS: u32 = 2;

/// Records of one type in a flash.
#[derive(Debug)]
pub struct Store<F> {
    flash: F,
    start: u32,
    version: u16,
    newest: Option<Newest>,
    /// The number of the next attempt: one that failed may still have left a whole record.
    next: u32,
}

/// The newest whole record.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Newest {
    number: u32,
    slot: u32,
}

/// Reasons for which a record was not kept; the one before it still holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum StoreError {
    /// The flash refused to erase, write or read.
    Flash,
    /// The written record does not read back.
    NotWritten,
    /// The record is longer than a slot.
    TooLong,
}

impl fmt::Display for StoreError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Flash => "the flash refused: the record before still holds",
            Self::NotWritten => "the flash is worn or damaged: the record before still holds",
            Self::TooLong => "the record is longer than a slot of the store",
        })
    }
}

impl core::error::Error for StoreError {}

impl<F: NorFlash> Store<F> {
    /// Slots of an area.
    const SLOTS: u32 = {
        assert!(F::ERASE_SIZE >= SLOT, "an area holds a record at least");
        (F::ERASE_SIZE / SLOT) as u32
    };

    /// Opens the two areas that begin at `start`, and reads the newest record of a version.
    pub fn open<T: DeserializeOwned>(
        flash: F,
        start: u32,
        version: u16,
    ) -> (Self, Option<T>, Kept) {
        let mut store = Self {
            flash,
            start,
            version,
            newest: None,
            next: 0,
        };
        let mut read = None;
        let mut kept = Kept::Nothing;
        for slot in 0..AREAS * Self::SLOTS {
            let mut bytes = [0; SLOT];
            match store.read(slot, &mut bytes) {
                Slot::Blank => {}
                Slot::Damaged => {
                    if kept == Kept::Nothing {
                        kept = Kept::Damaged;
                    }
                }
                Slot::Whole {
                    version,
                    number,
                    contents,
                } => {
                    if store.newest.is_some_and(|newest| newest.number >= number) {
                        continue;
                    }
                    store.newest = Some(Newest { number, slot });
                    store.next = number.wrapping_add(1);
                    read = (version == store.version)
                        .then(|| postcard::from_bytes(contents).ok())
                        .flatten();
                    kept = if read.is_some() {
                        Kept::Record
                    } else {
                        Kept::OtherVersion
                    };
                }
            }
        }
        (store, read, kept)
    }

    /// Keeps a record. It may take as long as the flash takes to erase an area.
    ///
    /// # Errors
    /// [`StoreError`]; the record before it still holds.
    pub fn keep<T: Serialize>(&mut self, record: &T) -> Result<(), StoreError> {
        let number = self.next;
        self.next = number.wrapping_add(1);
        let bytes = whole(record, self.version, number)?;
        let slot = self.free_slot()?;
        self.flash
            .write(self.place(slot), &bytes)
            .map_err(|_| StoreError::Flash)?;
        let mut again = [0; SLOT];
        self.flash
            .read(self.place(slot), &mut again)
            .map_err(|_| StoreError::Flash)?;
        if again != bytes {
            return Err(StoreError::NotWritten);
        }
        self.newest = Some(Newest { number, slot });
        Ok(())
    }

    /// The next blank slot in the area of the newest record, or the first of the other area once that
    /// is erased.
    fn free_slot(&mut self) -> Result<u32, StoreError> {
        let (area, behind) = match self.newest {
            Some(Newest { slot, .. }) => (slot / Self::SLOTS, slot + 1),
            None => (0, 0),
        };
        let mut scratch = [0; SLOT];
        for slot in behind..(area + 1) * Self::SLOTS {
            if matches!(self.read(slot, &mut scratch), Slot::Blank) {
                return Ok(slot);
            }
        }
        let other = if self.newest.is_some() {
            (area + 1) % AREAS
        } else {
            area
        };
        let first = other * Self::SLOTS;
        let from = self.place(first);
        self.flash
            .erase(from, from + F::ERASE_SIZE as u32)
            .map_err(|_| StoreError::Flash)?;
        Ok(first)
    }

    fn place(&self, slot: u32) -> u32 {
        let (area, place) = (slot / Self::SLOTS, slot % Self::SLOTS);
        self.start + area * F::ERASE_SIZE as u32 + place * SLOT as u32
    }

    fn read<'a>(&mut self, slot: u32, bytes: &'a mut [u8; SLOT]) -> Slot<'a> {
        if self.flash.read(self.place(slot), bytes).is_err() {
            return Slot::Damaged;
        }
        if bytes.iter().all(|&byte| byte == 0xff) {
            return Slot::Blank;
        }
        understood(bytes).unwrap_or(Slot::Damaged)
    }
}

/// Contents of a slot.
enum Slot<'a> {
    Blank,
    Damaged,
    Whole {
        version: u16,
        number: u32,
        contents: &'a [u8],
    },
}

/// A record as the bytes of a slot.
fn whole<T: Serialize>(record: &T, version: u16, number: u32) -> Result<[u8; SLOT], StoreError> {
    let mut bytes = [0; SLOT];
    let (head, contents) = bytes
        .split_first_chunk_mut::<HEAD>()
        .ok_or(StoreError::TooLong)?;
    let contents = postcard::to_slice(record, contents).map_err(|_| StoreError::TooLong)?;
    let length = contents.len() as u16;
    let [m0, m1, m2, m3] = MARK;
    let [v0, v1] = version.to_le_bytes();
    let [l0, l1] = length.to_le_bytes();
    let [n0, n1, n2, n3] = number.to_le_bytes();
    let before = [m0, m1, m2, m3, v0, v1, l0, l1, n0, n1, n2, n3];
    let [c0, c1, c2, c3] = check(&before, contents).to_le_bytes();
    *head = [
        m0, m1, m2, m3, v0, v1, l0, l1, n0, n1, n2, n3, c0, c1, c2, c3,
    ];
    Ok(bytes)
}

fn understood(bytes: &[u8; SLOT]) -> Option<Slot<'_>> {
    let (before, rest) = bytes.split_first_chunk::<12>()?;
    let (given, rest) = rest.split_first_chunk::<4>()?;
    let [m0, m1, m2, m3, v0, v1, l0, l1, n0, n1, n2, n3] = *before;
    let contents = rest.get(..usize::from(u16::from_le_bytes([l0, l1])))?;
    let is_whole =
        [m0, m1, m2, m3] == MARK && check(before, contents) == u32::from_le_bytes(*given);
    is_whole.then_some(Slot::Whole {
        version: u16::from_le_bytes([v0, v1]),
        number: u32::from_le_bytes([n0, n1, n2, n3]),
        contents,
    })
}

fn check(before: &[u8; 12], contents: &[u8]) -> u32 {
    let mut digest = CHECK.digest();
    digest.update(before);
    digest.update(contents);
    digest.finalize()
}
