use drive_chip::flash::FlashError;
use embedded_storage::nor_flash::{NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash};

use crate::model::Chip;
use crate::{healthy, wired};

/// The sectors 1 and 2 (RM0090, table 5).
const FIRST: u32 = 0x0800_4000;
const SECOND: u32 = 0x0800_8000;
const SECTOR: u32 = 0x4000;

const OLD: [u8; 8] = [1, 2, 3, 4, 5, 6, 7, 8];

/// A chip with data in both sectors and around them.
fn written() -> Chip {
    let chip = healthy();
    let mut flash = wired(&chip).flash;
    for address in [FIRST - 8, FIRST, SECOND - 8, SECOND, SECOND + SECTOR - 8] {
        chip.memory.put(address, &OLD);
    }
    let mut bytes = [0; 8];
    for offset in [0, SECTOR - 8, SECTOR, 2 * SECTOR - 8] {
        flash.read(offset, &mut bytes).expect("inside");
        assert_eq!(bytes, OLD);
    }
    chip
}

#[test]
fn bytes_are_read_at_any_alignment() {
    let chip = written();
    let mut flash = wired(&chip).flash;
    assert_eq!(flash.capacity(), 0x8000);
    let mut bytes = [0; 5];
    flash.read(2, &mut bytes).expect("inside");
    assert_eq!(bytes, [3, 4, 5, 6, 7]);
    flash.read(SECTOR - 3, &mut bytes).expect("inside");
    assert_eq!(bytes, [6, 7, 8, 1, 2]);
}

#[test]
fn a_sector_is_erased_and_nothing_beside_it() {
    for (number, from, erased) in [(1, 0, FIRST), (2, SECTOR, SECOND)] {
        let chip = written();
        let mut flash = wired(&chip).flash;
        assert_eq!(flash.erase(from, from + SECTOR), Ok(()));
        assert_eq!(*chip.memory.erased.borrow(), [number]);
        for address in [FIRST - 8, FIRST, SECOND - 8, SECOND, SECOND + SECTOR - 8] {
            let gone = (erased..erased + SECTOR).contains(&address);
            let wanted = if gone { [0xff; 8] } else { OLD };
            assert_eq!(chip.memory.bytes(address, 8), wanted, "{address:#x}");
        }
        // No cache holds the old contents, and both are on again.
        let mut bytes = [0; 8];
        flash.read(from, &mut bytes).expect("inside");
        assert_eq!(bytes, [0xff; 8]);
        assert!(!chip.memory.is_stale());
        assert!(chip.memory.is_cached());
        assert!(chip.memory.is_locked());
    }
}

#[test]
fn both_sectors_are_erased_one_after_the_other() {
    let chip = written();
    assert_eq!(wired(&chip).flash.erase(0, 2 * SECTOR), Ok(()));
    assert_eq!(*chip.memory.erased.borrow(), [1, 2]);
}

#[test]
fn an_erasure_is_chosen_before_it_is_started() {
    let chip = written();
    wired(&chip).flash.erase(0, SECTOR).expect("erased");
    let flash = &chip.memory.flash;
    let control = chip.written_to(flash.address(flash.cr()));
    let start = 1 << 16;
    let started = control.iter().position(|word| word & start != 0);
    let started = started.expect("started");
    assert_eq!(control[started - 1] | start, control[started]);
}

#[test]
fn a_write_lowers_bits_and_is_read_back() {
    let chip = written();
    let mut flash = wired(&chip).flash;
    assert_eq!(
        flash.write(4, &[0xf4, 0xff, 0xf3, 0xf2, 9, 8, 7, 6]),
        Ok(())
    );
    let wanted = [1, 2, 3, 4, 4, 6, 3, 0, 9, 8, 7, 6];
    assert_eq!(chip.memory.bytes(FIRST, 12), wanted);
    let mut bytes = [0; 12];
    flash.read(0, &mut bytes).expect("inside");
    assert_eq!(bytes, wanted);
    assert!(!chip.memory.is_stale());
    assert!(chip.memory.is_locked() && chip.memory.is_cached());
    assert_eq!(flash.write(SECTOR, &[0; 4]), Ok(()));
    assert_eq!(chip.memory.bytes(SECOND, 4), [0; 4]);
}

#[test]
fn an_erasure_feeds_the_watchdog_meanwhile() {
    let chip = written();
    let wired = wired(&chip);
    let mut flash = wired.flash;
    wired.watchdog.start();
    // Half a second each, with a timeout of seven milliseconds.
    assert_eq!(flash.erase(0, 2 * SECTOR), Ok(()));
    assert!(!chip.watchdog.bit.get());
    // A record of a kibibyte takes 26 ms.
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
    // Protected, misaligned, wrong width, wrong order, and any other error.
    for error in [1 << 1, 1 << 4, 1 << 5, 1 << 6, 1 << 7, 1 << 8] {
        let chip = written();
        let mut flash = wired(&chip).flash;
        chip.memory.fails.set(error);
        assert_eq!(flash.erase(0, SECTOR), Err(FlashError::Hardware));
        assert!(chip.memory.is_locked());
        assert_eq!(flash.erase(0, SECTOR), Ok(()));
        chip.memory.fails.set(error);
        assert_eq!(flash.write(0, &[1; 8]), Err(FlashError::Hardware));
        assert!(chip.memory.is_locked());
        // The word after a failure is not written.
        assert_eq!(chip.memory.bytes(FIRST + 4, 4), [0xff; 4]);
        assert_eq!(flash.write(8, &[1; 8]), Ok(()));
    }
}

#[test]
fn an_earlier_error_flag_does_not_fail_this_step() {
    let chip = written();
    let mut flash = wired(&chip).flash;
    let registers = &chip.memory.flash;
    registers.set(registers.sr(), 0xf2);
    assert!(registers.sr().read().wrperr().bit());
    assert_eq!(flash.erase(0, SECTOR), Ok(()));
}

#[test]
fn an_unlocked_flash_is_not_unlocked_again() {
    let chip = written();
    let mut flash = wired(&chip).flash;
    chip.memory.flash.set(chip.memory.flash.cr(), 0);
    assert!(!chip.memory.is_locked());
    assert_eq!(flash.erase(0, SECTOR), Ok(()));
    assert!(chip.memory.is_locked());
}

#[test]
fn a_step_that_never_ends_times_out() {
    let chip = written();
    let mut flash = wired(&chip).flash;
    chip.memory.hangs.set(true);
    assert_eq!(flash.erase(0, SECTOR), Err(FlashError::Hardware));
    let steps = chip.memory.erased.borrow().len();
    assert_eq!(flash.erase(0, SECTOR), Err(FlashError::Hardware));
    assert_eq!(flash.write(0, &[0; 4]), Err(FlashError::Hardware));
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
    assert_eq!(flash.erase(SECTOR, 3 * SECTOR), Err(outside));
    assert_eq!(flash.erase(4, SECTOR), Err(between));
    assert_eq!(flash.write(2 * SECTOR, &[0; 4]), Err(outside));
    assert_eq!(flash.write(2, &[0; 4]), Err(between));
    assert_eq!(flash.write(0, &[0; 3]), Err(between));
    assert_eq!(flash.read(2 * SECTOR - 1, &mut [0; 2]), Err(outside));
    assert!(chip.memory.erased.borrow().is_empty());
    assert_eq!(chip.memory.bytes(FIRST, 8), OLD);
    assert_eq!(outside.kind(), NorFlashErrorKind::OutOfBounds);
    assert_eq!(FlashError::Hardware.kind(), NorFlashErrorKind::Other);
}
