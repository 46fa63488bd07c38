use crate::facts::SAMPLING;
use crate::{healthy, wired};

/// The voltage of the pin for one of the command, V.
fn pin(voltage: f64) -> f64 {
    // The three resistors, as the page of the driver has them.
    let conductance = 1.0 / 66.5 + 1.0 / 20.0 + 1.0 / 28.7;
    (voltage / 66.5 + 3.3 / 20.0) / conductance
}

#[test]
fn a_command_is_read_through_its_resistors_within_two_percent() {
    let chip = healthy();
    let input = wired(&chip).analogue;
    for tenths in -100..=100 {
        let voltage = f64::from(tenths) / 10.0;
        chip.adc.pin.set(pin(voltage));
        let read = input.voltage().expect("valid");
        assert!(
            (f64::from(read) - voltage / 10.0).abs() < 0.02,
            "{read} at {voltage} V"
        );
    }
}

#[test]
fn a_voltage_beyond_its_range_is_none() {
    let chip = healthy();
    let input = wired(&chip).analogue;
    for voltage in [-10.8, 10.8] {
        chip.adc.pin.set(pin(voltage));
        assert_eq!(input.voltage(), None, "{voltage} V");
    }
    // As where the supply of the resistors, or the pin itself, is gone.
    for rail in [0.0, 3.3] {
        chip.adc.pin.set(rail);
        assert_eq!(input.voltage(), None);
    }
}

#[test]
fn it_samples_for_longer_than_the_resistors_need() {
    let chip = healthy();
    let _wired = wired(&chip);
    let (ticks, frequency) = chip.adc.sampling(&chip.clocks);
    assert!((ticks / frequency - SAMPLING).abs() < 1e-9);
    // 10 kΩ and 4 pF to half of a code.
    let needed = 10e3 * 4e-12 * (2.0 * 4096.0_f64).ln();
    assert!(ticks / frequency > 10.0 * needed);
}
