use crate::{healthy, wired};

#[test]
fn it_sleeps_until_it_is_started() {
    let chip = healthy();
    let wired = wired(&chip);
    wired.watchdog.feed();
    chip.elapse(1.0);
    assert!(!chip.watchdog.is_awake() && !chip.watchdog.bit.get());
    wired.watchdog.start();
    assert!(chip.watchdog.is_awake());
}

#[test]
fn its_patience_is_ten_milliseconds_of_its_nominal_oscillator() {
    let chip = healthy();
    let wired = wired(&chip);
    wired.watchdog.start();
    let patience = f64::from(chip.watchdog.patience()) / 32e3;
    assert!((patience - 10e-3).abs() < 1e-9, "{patience} s");
}

#[test]
fn who_does_not_feed_it_is_reset() {
    let chip = healthy();
    let wired = wired(&chip);
    wired.watchdog.start();
    chip.elapse(6e-3);
    assert!(!chip.watchdog.bit.get());
    chip.elapse(2e-3);
    assert!(chip.watchdog.bit.get());
}

#[test]
fn who_feeds_it_is_not() {
    let chip = healthy();
    let wired = wired(&chip);
    wired.watchdog.start();
    for _ in 0..100 {
        chip.elapse(6e-3);
        wired.watchdog.feed();
    }
    assert!(!chip.watchdog.bit.get());
}
