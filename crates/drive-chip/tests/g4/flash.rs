use drive_chip::flash::FlashError;
use embedded_storage::nor_flash::{NorFlash, ReadNorFlash};

use crate::shared::flash::{AREA, FIRST, OLD, assert_only_this_area_is_erased, written};
use crate::{healthy, wired};

#[test]
fn an_area_is_erased_page_by_page_and_nothing_beside_it() {
    // Two banks with pages of 2 KiB, one with pages of 4 KiB.
    for (banks, size) in [(1, 0x800), (0, 0x1000)] {
        for from in [0, AREA] {
            let chip = written();
            let registers = &chip.memory.flash;
            registers.set(
                registers.optr(),
                registers.get(registers.optr()) & !(1 << 22) | banks << 22,
            );
            assert_only_this_area_is_erased(&chip, from);
            let first = (FIRST + from - 0x0800_0000) / size;
            let pages: Vec<u8> = (first..first + AREA / size)
                .map(|page| page as u8)
                .collect();
            assert_eq!(*chip.memory.erased.borrow(), pages);
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
fn a_record_that_a_loss_of_power_has_damaged_is_refused_and_the_program_continues() {
    let chip = written();
    let mut flash = wired(&chip).flash;
    chip.memory.damage(FIRST + 64);
    let mut bytes = [0; 32];
    assert_eq!(flash.read(48, &mut bytes), Err(FlashError::Hardware));
    // Undamaged words are read as before, and erasing repairs all of them.
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
