use embedded_storage::nor_flash::{NorFlash, ReadNorFlash};

use crate::shared::flash::{AREA, FIRST, SECOND, assert_only_this_area_is_erased, written};
use crate::wired;

#[test]
fn a_sector_is_erased_and_nothing_beside_it() {
    for (number, from) in [(1, 0), (2, AREA)] {
        let chip = written();
        assert_only_this_area_is_erased(&chip, from);
        assert_eq!(*chip.memory.erased.borrow(), [number]);
    }
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
    assert_eq!(flash.write(AREA, &[0; 4]), Ok(()));
    assert_eq!(chip.memory.bytes(SECOND, 4), [0; 4]);
}
