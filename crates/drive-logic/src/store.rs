//! Records that survive a loss of power at any moment.
//!
//! Two areas of flash that can be erased apart are filled with records in turn, one slot each. The newest whole record
//! holds. A record is written behind the last one, never over it. An area is erased only when the other one holds the
//! newest. After a loss of power at any time, either the record before or the new one is whole. An area of 16 KiB holds
//! 12 records of 1336 bytes, so that 10 000 cycles of erasing last for 240 000 records.
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
//! A store that others maintain was tried first (`sequential-storage` 8.0). Two dozen panics of it survive in the
//! release, which the firmware does not link with.

use crc::{CRC_32_ISO_HDLC, Crc};
use drive_link::Kept;
use embedded_storage::nor_flash::NorFlash;

const CHECK: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

/// "srvo".
const MARK: [u8; 4] = *b"srvo";

/// Bytes of a slot; whatever a flash writes at once divides it.
const SLOT: usize = 1336;

/// Bytes that are read at a time to be compared.
const PART: usize = 8;
const _: () = assert!(SLOT.is_multiple_of(PART));

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
    /// Areas that were erased.
    erasures: u32,
}

/// The newest whole record.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Newest {
    number: u32,
    slot: u32,
}

/// Reasons for which a record was not kept; the one before it still holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum StoreError {
    /// The flash refused to erase, write or read.
    #[error("the flash refused the record: the previous one is still valid")]
    Flash,
    /// The written record does not read back.
    #[error("the flash is worn or damaged: the previous record is still valid")]
    NotWritten,
    /// An area must be erased first, which was not allowed.
    #[error("an area of the flash must be erased first: the previous record is still valid")]
    MustErase,
    /// The record is longer than a slot.
    #[error("the record is longer than a slot of the store")]
    TooLong,
}

impl<F: NorFlash> Store<F> {
    /// Slots of an area.
    const SLOTS: u32 = {
        assert!(F::ERASE_SIZE >= SLOT, "an area holds a record at least");
        (F::ERASE_SIZE / SLOT) as u32
    };

    /// Opens the two areas that begin at `start`, for records of a version. Reads the records, each newer than those before,
    /// and keeps the last of all if it was read: `read` returns false for a version or contents of no use.
    #[inline(never)]
    pub fn open(
        flash: F,
        start: u32,
        version: u16,
        mut read: impl FnMut(u16, &[u8]) -> bool,
    ) -> (Self, Kept) {
        let mut store = Self {
            flash,
            start,
            version,
            newest: None,
            next: 0,
            erasures: 0,
        };
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
                    kept = if read(version, contents) {
                        Kept::Record
                    } else {
                        Kept::OtherVersion
                    };
                }
            }
        }
        (store, kept)
    }

    /// Keeps a record, whose contents are written by a function that returns their length, unless the newest has the same.
    /// It may take as long as the flash takes to erase an area, if that is allowed.
    ///
    /// # Errors
    /// [`StoreError`]; the record before it still holds.
    pub fn keep(
        &mut self,
        may_erase: bool,
        write_contents: impl FnOnce(&mut [u8]) -> Option<usize>,
    ) -> Result<(), StoreError> {
        let mut bytes = [0; SLOT];
        let contents = bytes.get_mut(HEAD..).ok_or(StoreError::TooLong)?;
        let length = write_contents(contents).ok_or(StoreError::TooLong)?;
        if let Some(Newest { number, slot }) = self.newest {
            seal(&mut bytes, self.version, number, length)?;
            if self.holds(slot, &bytes)? {
                return Ok(());
            }
        }
        if !may_erase && self.must_erase() {
            return Err(StoreError::MustErase);
        }
        let number = self.next;
        self.next = number.wrapping_add(1);
        seal(&mut bytes, self.version, number, length)?;
        let slot = self.free_slot()?;
        let place = self.place(slot);
        self.flash
            .write(place, &bytes)
            .map_err(|_| StoreError::Flash)?;
        if !self.holds(slot, &bytes)? {
            return Err(StoreError::NotWritten);
        }
        self.newest = Some(Newest { number, slot });
        Ok(())
    }

    /// Areas that were erased so far.
    pub fn erasures(&self) -> u32 {
        self.erasures
    }

    /// True if an area must be erased for the next record.
    pub fn must_erase(&mut self) -> bool {
        self.blank_slot().is_none()
    }

    /// The next blank slot in the area of the newest record.
    fn blank_slot(&mut self) -> Option<u32> {
        let behind = self.newest.map_or(0, |newest| newest.slot + 1);
        (behind..(self.area() + 1) * Self::SLOTS).find(|&slot| {
            let is_blank = |_, bytes: &[u8]| bytes.iter().all(|&byte| byte == 0xff);
            self.reads(slot, is_blank) == Ok(true)
        })
    }

    /// The area of the newest record.
    fn area(&self) -> u32 {
        self.newest.map_or(0, |newest| newest.slot / Self::SLOTS)
    }

    /// The next blank slot in the area of the newest record. If there is none, the other area is erased, and its first
    /// slot is next.
    fn free_slot(&mut self) -> Result<u32, StoreError> {
        if let Some(slot) = self.blank_slot() {
            return Ok(slot);
        }
        let area = self.area();
        let other = if self.newest.is_some() {
            (area + 1) % AREAS
        } else {
            area
        };
        let first = other * Self::SLOTS;
        let from = self.place(first);
        self.erasures = self.erasures.wrapping_add(1);
        self.flash
            .erase(from, from + F::ERASE_SIZE as u32)
            .map_err(|_| StoreError::Flash)?;
        Ok(first)
    }

    fn place(&self, slot: u32) -> u32 {
        let (area, place) = (slot / Self::SLOTS, slot % Self::SLOTS);
        self.start + area * F::ERASE_SIZE as u32 + place * SLOT as u32
    }

    /// True if a slot has these bytes.
    fn holds(&mut self, slot: u32, bytes: &[u8; SLOT]) -> Result<bool, StoreError> {
        self.reads(slot, |place, read| {
            bytes
                .get(place..)
                .is_some_and(|rest| rest.starts_with(read))
        })
    }

    /// True if all parts of a slot, with their places in it, are as they should be.
    fn reads(
        &mut self,
        slot: u32,
        is_right: impl Fn(usize, &[u8]) -> bool,
    ) -> Result<bool, StoreError> {
        for place in (0..SLOT).step_by(PART) {
            let mut bytes = [0; PART];
            let read = self.flash.read(self.place(slot) + place as u32, &mut bytes);
            read.map_err(|_| StoreError::Flash)?;
            if !is_right(place, &bytes) {
                return Ok(false);
            }
        }
        Ok(true)
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

/// Writes the head of a record before its contents of a length.
fn seal(
    bytes: &mut [u8; SLOT],
    version: u16,
    number: u32,
    length: usize,
) -> Result<(), StoreError> {
    let (head, contents) = bytes
        .split_first_chunk_mut::<HEAD>()
        .ok_or(StoreError::TooLong)?;
    let contents = contents.get(..length).ok_or(StoreError::TooLong)?;
    let length = length as u16;
    let [m0, m1, m2, m3] = MARK;
    let [v0, v1] = version.to_le_bytes();
    let [l0, l1] = length.to_le_bytes();
    let [n0, n1, n2, n3] = number.to_le_bytes();
    let before = [m0, m1, m2, m3, v0, v1, l0, l1, n0, n1, n2, n3];
    let [c0, c1, c2, c3] = check(&before, contents).to_le_bytes();
    *head = [
        m0, m1, m2, m3, v0, v1, l0, l1, n0, n1, n2, n3, c0, c1, c2, c3,
    ];
    Ok(())
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

#[cfg(test)]
mod tests {
    use commissioning::TrialResult;
    use drive_link::{
        Commissioned, Dither, Estimates, Estimator, HoldingBrake, Homing, LoopSettings, Protection,
        Record, ServoChanges, Settings, TargetSource, TermSizes,
    };
    use identifier_core::control::FeedForwardSettings;
    use identifier_core::parameters::PerParameter;
    use identifier_core::parameters::{IdentifiedServo, ServoParameters};
    use identifier_core::settings::{
        ControllerSettings, IdentifierSettings, ParameterRangeSettings, RangeSettings, TermSettings,
    };
    use identifier_core::tuning::Tuning;
    use identifier_core::tuning::{Cap, PredictedResponse};

    use super::*;

    const ANY: f64 = 1.0;

    /// With nothing left out.
    fn settings() -> Settings {
        let identifier = IdentifierSettings {
            initial: PerParameter::from_fn(|_| Some(ANY)),
            known: PerParameter::from_fn(|_| true),
            bounds: PerParameter::from_fn(|_| Some([ANY; 2])),
            uncertainty: PerParameter::from_fn(|_| Some(ANY)),
            noise: Some(ANY),
            parameter_range: Some(ParameterRangeSettings {
                a: [ANY; 2],
                b: [ANY; 2],
            }),
            gamma: Some(PerParameter::all(ANY)),
            mu: Some(ANY),
            correction: Some([ANY; 3]),
            bandwidth: Some(ANY),
            start_time: Some(ANY),
            memory: Some(ANY),
            terms: TermSettings {
                low_speed_velocity: Some(ANY),
                ripple_order: Some(ANY),
                ..TermSettings::NONE
            },
            max_speed: Some(ANY),
            ranges: Some(RangeSettings {
                error: ANY,
                velocity: ANY,
                command: ANY,
            }),
        };
        Settings {
            closed_loop: LoopSettings {
                core: identifier_core::Settings {
                    controller: Some(ControllerSettings {
                        feed_forward: FEED_FORWARD,
                        ..ControllerSettings::pid(ANY, ANY, ANY)
                    }),
                    identifier,
                    ..identifier_core::Settings::new(ANY, ANY)
                },
                law: Estimator::Gradient { friction: true },
            },
            dither: Dither {
                amplitude: ANY,
                hold: ANY,
            },
            protection: Protection {
                following_error: ANY,
                travel: [ANY; 2],
                pace: ANY,
                speed: ANY,
                breakaway: ANY,
                stall_time: ANY,
                overruns: 1,
                duration: ANY,
                link_timeout: ANY,
                stop_time: ANY,
            },
            homing: Some(Homing {
                seek: ANY,
                approach: ANY,
                clearance: ANY,
                index: true,
                offset: ANY,
            }),
            source: TargetSource::Steps { step: ANY },
            servo_changes: ServoChanges::Reported,
            brake: Some(HoldingBrake {
                opens: ANY,
                closes: ANY,
            }),
        }
    }

    const SERVO: ServoParameters = ServoParameters {
        a: ANY,
        b: ANY,
        coulomb: ANY,
        load: ANY,
    };

    const FEED_FORWARD: Option<FeedForwardSettings> = Some(FeedForwardSettings {
        bandwidth: ANY,
        acceleration: ANY,
        velocity: ANY,
        coulomb: ANY,
        coulomb_speed: ANY,
    });

    const TUNING: Tuning = Tuning {
        kp: ANY,
        kd: ANY,
        ki: ANY,
        cutoff: ANY,
        reference_filter: ANY,
        notch: ANY,
        feed_forward: FEED_FORWARD,
        bandwidth: ANY,
        cap: Some(Cap::Delay),
        predicted_response: PredictedResponse {
            step: ANY,
            rise_time: ANY,
            quickest_rise_time: ANY,
            slowest_rise_time: ANY,
            overshoot: ANY,
            settling_time: ANY,
            sensitivity: ANY,
            gain_margins: [ANY; 2],
            command_share: ANY,
            noise: ANY,
            compliance: ANY,
        },
    };

    const TRIAL: TrialResult = TrialResult {
        step: ANY,
        rise_time: Some(ANY),
        overshoot: ANY,
    };

    fn servo() -> IdentifiedServo {
        IdentifiedServo {
            parameters: SERVO,
            delay: ANY,
            covariance: core::array::from_fn(|i| {
                core::array::from_fn(|j| (i * j) as f64 + 1.0 / (i + j + 1) as f64)
            }),
            unexplained: ANY,
        }
    }

    #[test]
    fn the_servo_that_was_found_is_kept_whole() {
        assert_eq!(Commissioned::new(&servo(), TUNING, None).servo(), servo());
    }

    #[test]
    fn a_record_with_nothing_left_out_fits_a_slot() {
        let record = Record {
            settings: settings(),
            estimates: Some(Estimates {
                servo: SERVO,
                at_bounds: PerParameter::from_fn(|_| true),
                standard_errors: Some(SERVO),
                terms: TermSizes::where_known(|_| Some(1.0))
                    .map(|sizes| sizes.with_errors(|_| Some(1.0))),
            }),
            commissioned: Some(Commissioned::new(&servo(), TUNING, Some(TRIAL))),
            under_way: true,
        };
        let mut bytes = [0; MAX_RECORD_BYTES];
        let written = record.to_bytes(0, &mut bytes).expect("it fits");
        assert!(written > MAX_RECORD_BYTES / 2, "{}", written);
    }
}
