use drive_chip::flash::FlashError;
use embedded_storage::nor_flash::{NorFlash, NorFlashErrorKind, ReadNorFlash};

use crate::model::Chip;
use crate::{healthy, wired};

/// The areas 1 and 2.
const FIRST: u32 = 0x0800_4000;
const SECOND: u32 = 0x0800_8000;
const AREA: u32 = 0x4000;

const OLD: [u8; 8] = [1, 2, 3, 4, 5, 6, 7, 8];

/// A chip with data in both areas and around them.
fn written() -> Chip {
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

#[test]
fn an_area_is_erased_page_by_page_and_nothing_beside_it() {
    // Two banks with pages of 2 KiB, one with pages of 4 KiB.
    for (banks, size) in [(1, 0x800), (0, 0x1000)] {
        for (from, erased) in [(0, FIRST), (AREA, SECOND)] {
            let chip = written();
            let mut flash = wired(&chip).flash;
            let registers = &chip.memory.flash;
            registers.set(
                registers.optr(),
                registers.get(registers.optr()) & !(1 << 22) | banks << 22,
            );
            assert_eq!(flash.erase(from, from + AREA), Ok(()));
            let first = (erased - 0x0800_0000) / size;
            let pages: Vec<u8> = (first..first + AREA / size)
                .map(|page| page as u8)
                .collect();
            assert_eq!(*chip.memory.erased.borrow(), pages);
            for address in [FIRST - 8, FIRST, SECOND - 8, SECOND, SECOND + AREA - 8] {
                let gone = (erased..erased + AREA).contains(&address);
                let wanted = if gone { [0xff; 8] } else { OLD };
                assert_eq!(chip.memory.bytes(address, 8), wanted, "{address:#x}");
            }
            // No cache holds the old contents, and both are on again.
            let mut bytes = [0; 8];
            flash.read(from, &mut bytes).expect("inside");
            assert_eq!(bytes, [0xff; 8]);
            assert!(!chip.memory.is_stale() && chip.memory.is_cached());
            assert!(chip.memory.is_locked());
        }
    }
}

#[test]
fn double_words_are_written_and_read_back() {
    let chip = written();
    let mut flash = wired(&chip).flash;
    let new: [u8; 16] = std::array::from_fn(|k| k as u8 + 10);
    assert_eq!(flash.write(8, &new), Ok(()));
    assert_eq!(chip.memory.bytes(FIRST, 8), OLD);
    assert_eq!(chip.memory.bytes(FIRST + 8, 16), new);
    let mut bytes = [0; 5];
    flash.read(10, &mut bytes).expect("inside");
    assert_eq!(bytes, [12, 13, 14, 15, 16]);
    assert!(!chip.memory.is_stale());
    assert!(chip.memory.is_locked() && chip.memory.is_cached());
}

#[test]
fn an_erasure_and_a_write_feed_the_watchdog_meanwhile() {
    let chip = written();
    let wired = wired(&chip);
    let mut flash = wired.flash;
    wired.watchdog.start();
    // 24.5 ms a page, with a timeout of seven milliseconds.
    assert_eq!(flash.erase(0, 2 * AREA), Ok(()));
    assert!(!chip.watchdog.bit.get());
    assert_eq!(flash.write(0, &[0; 1024]), Ok(()));
    assert!(!chip.watchdog.bit.get());
    for slot in 0..32 {
        flash.read(1024 * slot, &mut [0; 1024]).expect("inside");
        assert!(!chip.watchdog.bit.get());
    }
}

#[test]
fn a_failure_is_reported_once_and_locks_as_well() {
    // Every error of the status (RM0440, FLASH).
    for error in [1, 3, 4, 5, 6, 7, 8, 9, 14, 15].map(|bit| 1 << bit) {
        let chip = written();
        let mut flash = wired(&chip).flash;
        chip.memory.fails.set(error);
        assert_eq!(flash.erase(0, AREA), Err(FlashError::Hardware));
        assert!(chip.memory.is_locked());
        assert_eq!(flash.erase(0, AREA), Ok(()));
        chip.memory.fails.set(error);
        assert_eq!(flash.write(0, &[1; 16]), Err(FlashError::Hardware));
        assert!(chip.memory.is_locked());
        // The double word after a failure is not written.
        assert_eq!(chip.memory.bytes(FIRST + 8, 8), [0xff; 8]);
        assert_eq!(flash.write(16, &[1; 16]), Ok(()));
    }
}

#[test]
fn an_earlier_error_flag_does_not_fail_this_step() {
    let chip = written();
    let mut flash = wired(&chip).flash;
    let registers = &chip.memory.flash;
    registers.set(registers.sr(), 0xc3fb);
    assert_eq!(flash.erase(0, AREA), Ok(()));
}

#[test]
fn a_step_that_never_ends_times_out() {
    let chip = written();
    let mut flash = wired(&chip).flash;
    chip.memory.hangs.set(true);
    assert_eq!(flash.erase(0, AREA), Err(FlashError::Hardware));
    let steps = chip.memory.erased.borrow().len();
    assert_eq!(flash.erase(0, AREA), Err(FlashError::Hardware));
    assert_eq!(flash.write(0, &[0; 8]), Err(FlashError::Hardware));
    assert_eq!(chip.memory.erased.borrow().len(), steps);
}

#[test]
fn a_record_that_a_loss_of_power_has_damaged_is_refused_and_the_program_continues() {
    let chip = written();
    let mut flash = wired(&chip).flash;
    chip.memory.damage(FIRST + 64);
    let mut bytes = [0; 32];
    assert_eq!(flash.read(48, &mut bytes), Err(FlashError::Hardware));
    // What is whole is read as before, and erasing makes all of it whole.
    assert_eq!(flash.read(0, &mut bytes), Ok(()));
    assert_eq!(bytes[..8], OLD);
    assert!(!chip.memory.has_found_damage());
    assert_eq!(flash.read(48, &mut bytes), Err(FlashError::Hardware));
    assert_eq!(flash.erase(0, AREA), Ok(()));
    assert_eq!(flash.read(48, &mut bytes), Ok(()));
}

#[test]
fn an_interrupt_that_nothing_masks_ends_the_program() {
    let chip = healthy();
    let _wired = wired(&chip);
    // A failed oscillator; and damage, which no record has that is being read.
    assert!(!chip.non_maskable_interrupt());
    let flash = &chip.memory.flash;
    for damage in [1 << 29, 1 << 31] {
        flash.set(flash.eccr(), damage);
        assert!(chip.memory.has_found_damage());
        assert!(!chip.non_maskable_interrupt());
    }
}

#[test]
fn a_double_word_that_only_reads_as_blank_is_zeroed() {
    let chip = written();
    let mut flash = wired(&chip).flash;
    chip.memory.write_blank(FIRST + 16);
    assert_eq!(flash.write(16, &[7; 16]), Err(FlashError::Hardware));
    // The next record passes it over: it reads as blank no more.
    let mut bytes = [0xff; 8];
    assert_eq!(flash.read(16, &mut bytes), Ok(()));
    assert_eq!(bytes, [0; 8]);
    assert_eq!(chip.memory.bytes(FIRST + 24, 8), [0xff; 8]);
    assert_eq!(flash.write(32, &[7; 16]), Ok(()));
}

#[test]
fn addresses_outside_or_not_aligned_are_refused() {
    let chip = written();
    let mut flash = wired(&chip).flash;
    let outside = FlashError::Misplaced(NorFlashErrorKind::OutOfBounds);
    let between = FlashError::Misplaced(NorFlashErrorKind::NotAligned);
    assert_eq!(flash.erase(AREA, 3 * AREA), Err(outside));
    assert_eq!(flash.erase(8, AREA), Err(between));
    assert_eq!(flash.write(2 * AREA, &[0; 8]), Err(outside));
    assert_eq!(flash.write(4, &[0; 8]), Err(between));
    assert_eq!(flash.write(0, &[0; 4]), Err(between));
    assert_eq!(flash.read(2 * AREA - 1, &mut [0; 2]), Err(outside));
    assert!(chip.memory.erased.borrow().is_empty());
    assert_eq!(chip.memory.bytes(FIRST, 8), OLD);
}
