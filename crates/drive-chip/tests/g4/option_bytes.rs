use crate::{healthy, wired};

#[test]
fn the_reset_below_the_voltage_that_is_needed_is_looked_up() {
    // Levels 0 to 4: 1.7, 2.0, 2.2, 2.5 and 2.8 V, of which the first is below 1.71 V; the others are reserved (RM0440,
    // FLASH).
    for (level, is_in_time) in (0_u32..8).zip([false, true, true, true, true, false, false, false])
    {
        let chip = healthy();
        let flash = &chip.memory.flash;
        flash.set(flash.optr(), 0xffef_f8aa & !0x700 | level << 8);
        assert_eq!(u32::from(flash.optr().read().bor_lev().bits()), level);
        assert_eq!(wired(&chip).resets_in_time, is_in_time, "{level:#b}");
    }
}
