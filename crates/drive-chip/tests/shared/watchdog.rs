use crate::{healthy, wired};

#[test]
fn once_started_it_resets_a_chip_that_does_not_feed_it_for_ten_milliseconds() {
    let chip = healthy();
    let wired = wired(&chip);
    wired.watchdog.feed();
    chip.elapse(1.0);
    assert!(!chip.watchdog.is_awake() && !chip.watchdog.bit.get());
    wired.watchdog.start();
    assert!(chip.watchdog.is_awake());
    // Of its nominal oscillator; the fastest is half as fast again.
    let patience = f64::from(chip.watchdog.patience()) / 32e3;
    assert!((patience - 10e-3).abs() < 1e-9, "{patience} s");
    for _ in 0..100 {
        chip.elapse(6e-3);
        wired.watchdog.feed();
    }
    chip.elapse(6e-3);
    assert!(!chip.watchdog.bit.get());
    chip.elapse(2e-3);
    assert!(chip.watchdog.bit.get());
}
