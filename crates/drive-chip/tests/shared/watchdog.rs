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
fn its_timeout_is_ten_milliseconds_of_its_nominal_oscillator() {
    let chip = healthy();
    let wired = wired(&chip);
    wired.watchdog.start();
    let patience = f64::from(chip.watchdog.patience()) / 32e3;
    assert!((patience - 10e-3).abs() < 1e-9, "{patience} s");
}

#[test]
fn an_unfed_watchdog_resets_the_chip() {
    let chip = healthy();
    let wired = wired(&chip);
    wired.watchdog.start();
    chip.elapse(6e-3);
    assert!(!chip.watchdog.bit.get());
    chip.elapse(2e-3);
    assert!(chip.watchdog.bit.get());
}

#[test]
fn a_fed_watchdog_does_not_reset_the_chip() {
    let chip = healthy();
    let wired = wired(&chip);
    wired.watchdog.start();
    for _ in 0..100 {
        chip.elapse(6e-3);
        wired.watchdog.feed();
    }
    assert!(!chip.watchdog.bit.get());
}
