use crate::{healthy, wired};

#[test]
fn the_reset_below_the_voltage_that_is_needed_is_looked_up() {
    // Levels 3, 2 and 1, and off (RM0090, 3.6.1).
    for (level, is_in_time) in [(0b00, true), (0b01, false), (0b10, false), (0b11, false)] {
        let chip = healthy();
        let flash = &chip.memory.flash;
        flash.set(flash.optcr(), 0x0fff_aae1 | level << 2);
        assert_eq!(u32::from(flash.optcr().read().bor_lev().bits()), level);
        assert_eq!(wired(&chip).resets_in_time, is_in_time, "{level:#b}");
    }
}
