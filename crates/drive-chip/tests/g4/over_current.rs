use drive_chip::g4::OverCurrent;
use drive_chip::pins::{Pin, Port};
use embedded_hal::pwm::SetDutyCycle;

use crate::facts::STEPS;
use crate::model::{Chip, Output};
use crate::shared::{drive_again, driving};
use crate::{healthy, wired};

/// Sets the voltage of the current, V.
fn sense(chip: &Chip, voltage: f64) {
    chip.supply.sensed.set(voltage);
    chip.look_at_breaks();
}

#[test]
fn a_current_beyond_its_limit_disables_the_output_without_the_processor() {
    let chip = healthy();
    let mut wired = driving(&chip);
    let threshold = chip.supply.threshold().expect("a threshold");
    assert!((threshold - 2.5).abs() < 1e-3, "{threshold} V");
    sense(&chip, threshold - 0.01);
    assert_eq!(chip.output(), Output::High);
    assert!(wired.inputs.amplifier_is_healthy());
    sense(&chip, threshold + 0.01);
    assert_eq!(chip.output(), Output::Low);
    // It stays a fault of the amplifier once it is over, until the output is switched off.
    sense(&chip, 0.1);
    assert_eq!(chip.output(), Output::Low);
    assert!(!wired.inputs.amplifier_is_healthy());
    drive_again(&chip, &mut wired);
    assert!(wired.inputs.amplifier_is_healthy());
}

#[test]
fn no_duty_comes_through_while_the_current_is_beyond_its_limit() {
    let chip = healthy();
    chip.supply.sensed.set(3.0);
    let mut wired = wired(&chip);
    wired.timer.start(1e-3);
    let _ = wired.pwm.set_duty_cycle_fully_off();
    let _ = wired.pwm.set_duty_cycle(STEPS);
    assert_eq!(chip.output(), Output::Low);
    assert!(!wired.inputs.amplifier_is_healthy());
}

#[test]
fn a_sag_and_a_locked_up_processor_disable_it_without_the_processor() {
    let events: [fn(&Chip, bool); 2] = [
        |chip, begins| chip.supply.set(if begins { 2.85 } else { 3.3 }),
        |chip, begins| chip.supply.is_locked_up.set(begins),
    ];
    for event in events {
        let chip = healthy();
        let mut wired = driving(&chip);
        event(&chip, true);
        chip.look_at_breaks();
        assert_eq!(chip.output(), Output::Low);
        assert!(!wired.inputs.amplifier_is_healthy());
        // As long as its flag is set no duty comes through, and it cannot be cleared meanwhile.
        let _ = wired.pwm.set_duty_cycle_fully_off();
        let _ = wired.pwm.set_duty_cycle(STEPS);
        assert_eq!(chip.output(), Output::Low);
        event(&chip, false);
        chip.look_at_breaks();
        let _ = wired.pwm.set_duty_cycle(STEPS);
        assert_eq!(chip.output(), Output::Low);
        drive_again(&chip, &mut wired);
        assert!(wired.inputs.amplifier_is_healthy());
    }
}

#[test]
fn a_threshold_outside_the_reference_is_refused() {
    let above = |millivolts| OverCurrent::above(Pin::new(Port::A, 0), millivolts);
    for millivolts in [0, 3_300, 5_000] {
        assert!(std::panic::catch_unwind(|| above(millivolts)).is_err());
    }
    assert_ne!(above(1), above(3_299));
}
