use drive_chip::interrupts::begin;
use drive_chip::line_timer::PERIOD;

use crate::{healthy, slow, wired};

#[test]
fn the_line_is_listened_to_at_its_period_by_any_clock() {
    for chip in [healthy(), slow()] {
        let wired = wired(&chip);
        begin(&chip);
        assert_eq!(chip.systick(), None);
        wired.line_timer.start();
        let (ticks, priority) = chip.systick().expect("it runs");
        let period = f64::from(ticks) / chip.clocks.frequencies().processor;
        assert!((period / PERIOD - 1.0).abs() < 1e-9, "{period} s");
        // As the line's: below the samples, above the background.
        assert_eq!(priority, 0x80);
    }
}
