use drive_chip::flash::FlashError;
use embedded_storage::nor_flash::{NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash};

use crate::facts::{FLASH_ERRORS, FLASH_FLAGS, WORD};
use crate::model::Chip;
use crate::{healthy, wired};

/// The areas 1 and 2.
pub(crate) const FIRST: u32 = 0x0800_4000;
pub(crate) const SECOND: u32 = 0x0800_8000;
pub(crate) const AREA: u32 = 0x4000;

pub(crate) const OLD: [u8; 8] = [1, 2, 3, 4, 5, 6, 7, 8];

/// A chip with data in both areas and around them.
pub(crate) fn written() -> Chip {
    let chip = healthy();
    let mut flash = wired(&chip).flash;
    for address in [FIRST - 8, FIRST, SECOND - 8, SECOND, SECOND + AREA - 8] {
        chip.memory.put(address, &OLD);
    }
    let mut bytes = [0; 8];
    for offset in [0, AREA - 8, AREA, 2 * AREA - 8] {
        flash.read(offset, &mut bytes).expect("inside");
        assert_eq!(bytes, OLD);
    }
    chip
}

/// Erases an area, and checks that nothing beside it was, and that no cache holds what it had.
pub(crate) fn assert_only_this_area_is_erased(chip: &Chip, from: u32) {
    let mut flash = wired(chip).flash;
    assert_eq!(flash.erase(from, from + AREA), Ok(()));
    let erased = FIRST + from..FIRST + from + AREA;
    for address in [FIRST - 8, FIRST, SECOND - 8, SECOND, SECOND + AREA - 8] {
        let wanted = if erased.contains(&address) {
            [0xff; 8]
        } else {
            OLD
        };
        assert_eq!(chip.memory.bytes(address, 8), wanted, "{address:#x}");
    }
    let mut bytes = [0; 8];
    flash.read(from, &mut bytes).expect("inside");
    assert_eq!(bytes, [0xff; 8]);
    assert!(!chip.memory.is_stale());
    assert!(chip.memory.is_cached());
    assert!(chip.memory.is_locked());
}

#[test]
fn bytes_are_read_at_any_alignment() {
    let chip = written();
    let mut flash = wired(&chip).flash;
    assert_eq!(flash.capacity(), 0x8000);
    let mut bytes = [0; 5];
    flash.read(2, &mut bytes).expect("inside");
    assert_eq!(bytes, [3, 4, 5, 6, 7]);
    flash.read(AREA - 3, &mut bytes).expect("inside");
    assert_eq!(bytes, [6, 7, 8, 1, 2]);
}

#[test]
fn an_erasure_is_chosen_before_it_is_started() {
    let chip = written();
    wired(&chip).flash.erase(0, AREA).expect("erased");
    let flash = &chip.memory.flash;
    let control = chip.written_to(flash.address(flash.cr()));
    let start = 1 << 16;
    let started = control.iter().position(|word| word & start != 0);
    let started = started.expect("started");
    assert_eq!(control[started - 1] | start, control[started]);
}

#[test]
fn erasing_and_writing_feed_the_watchdog_meanwhile() {
    let chip = written();
    let wired = wired(&chip);
    let mut flash = wired.flash;
    wired.watchdog.start();
    // 24.5 ms to half a second each, with a timeout of seven milliseconds.
    assert_eq!(flash.erase(0, 2 * AREA), Ok(()));
    assert!(!chip.watchdog.bit.get());
    // A record of a kibibyte takes 12 or 26 ms.
    assert_eq!(flash.write(0, &[0; 1024]), Ok(()));
    assert!(!chip.watchdog.bit.get());
}

#[test]
fn searching_the_records_feeds_the_watchdog_too() {
    let chip = written();
    let wired = wired(&chip);
    let mut flash = wired.flash;
    wired.watchdog.start();
    for slot in 0..32 {
        flash.read(1024 * slot, &mut [0; 1024]).expect("inside");
        assert!(!chip.watchdog.bit.get());
    }
}

#[test]
fn a_failure_is_reported_once_and_locks_as_well() {
    for &error in FLASH_ERRORS {
        let chip = written();
        let mut flash = wired(&chip).flash;
        chip.memory.fails.set(1 << error);
        assert_eq!(flash.erase(0, AREA), Err(FlashError::Hardware));
        assert!(chip.memory.is_locked());
        assert_eq!(flash.erase(0, AREA), Ok(()));
        chip.memory.fails.set(1 << error);
        assert_eq!(flash.write(0, &[1; 2 * WORD]), Err(FlashError::Hardware));
        assert!(chip.memory.is_locked());
        // The word after a failure is not written.
        assert_eq!(chip.memory.bytes(FIRST + WORD as u32, WORD), [0xff; WORD]);
        assert_eq!(flash.write(2 * WORD as u32, &[1; 2 * WORD]), Ok(()));
    }
}

#[test]
fn an_earlier_error_flag_does_not_fail_this_step() {
    let chip = written();
    let mut flash = wired(&chip).flash;
    let registers = &chip.memory.flash;
    registers.set(registers.sr(), FLASH_FLAGS);
    assert!(registers.sr().read().wrperr().bit());
    assert_eq!(flash.erase(0, AREA), Ok(()));
}

#[test]
fn an_unlocked_flash_is_not_unlocked_again() {
    let chip = written();
    let mut flash = wired(&chip).flash;
    chip.memory.flash.set(chip.memory.flash.cr(), 0);
    assert!(!chip.memory.is_locked());
    assert_eq!(flash.erase(0, AREA), Ok(()));
    assert!(chip.memory.is_locked());
}

#[test]
fn a_step_that_never_ends_times_out() {
    let chip = written();
    let mut flash = wired(&chip).flash;
    chip.memory.hangs.set(true);
    assert_eq!(flash.erase(0, AREA), Err(FlashError::Hardware));
    let steps = chip.memory.erased.borrow().len();
    assert_eq!(flash.erase(0, AREA), Err(FlashError::Hardware));
    assert_eq!(flash.write(0, &[0; WORD]), Err(FlashError::Hardware));
    assert_eq!(chip.memory.erased.borrow().len(), steps);
    // Not before an erasure had all the time that it may take.
    assert!(chip.watchdog.meals.get() > 20_000_000);
}

#[test]
fn addresses_outside_or_not_aligned_are_refused() {
    let chip = written();
    let mut flash = wired(&chip).flash;
    let outside = FlashError::Misplaced(NorFlashErrorKind::OutOfBounds);
    let between = FlashError::Misplaced(NorFlashErrorKind::NotAligned);
    assert_eq!(flash.erase(AREA, 3 * AREA), Err(outside));
    assert_eq!(flash.erase(WORD as u32, AREA), Err(between));
    assert_eq!(flash.write(2 * AREA, &[0; WORD]), Err(outside));
    assert_eq!(flash.write(WORD as u32 / 2, &[0; WORD]), Err(between));
    assert_eq!(flash.write(0, &[0; WORD - 1]), Err(between));
    assert_eq!(flash.write(0, &[0; WORD / 2]), Err(between));
    assert_eq!(flash.read(2 * AREA - 1, &mut [0; 2]), Err(outside));
    assert!(chip.memory.erased.borrow().is_empty());
    assert_eq!(chip.memory.bytes(FIRST, 8), OLD);
    assert_eq!(outside.kind(), NorFlashErrorKind::OutOfBounds);
    assert_eq!(FlashError::Hardware.kind(), NorFlashErrorKind::Other);
}
