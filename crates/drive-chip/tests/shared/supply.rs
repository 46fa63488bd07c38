use drive_chip::flash::FlashError;
use drive_chip::{disable_for_sag, interrupts};
use embedded_hal::digital::OutputPin;
use embedded_hal::pwm::SetDutyCycle;
use embedded_storage::nor_flash::NorFlash;

use crate::facts::{PVD, WORD};
use crate::model::{Chip, Level, Output};
use crate::{BOARD, healthy, wired};

#[test]
fn a_sag_disables_the_output_at_once_and_is_known_until_a_sample_has_seen_it() {
    let chip = healthy();
    let mut wired = wired(&chip);
    interrupts::begin(&chip);
    // A sample is not interrupted: it would drive the output again.
    assert_eq!(chip.unmasked(PVD), Some(0));
    wired.timer.start(1e-3);
    let Ok(()) = wired.pwm.set_duty_cycle(100);
    let Ok(()) = wired.enable.set_high();
    assert!(wired.inputs.supply_is_healthy() && !chip.supply.interrupts());
    chip.supply.set(2.95);
    assert!(wired.inputs.supply_is_healthy() && !chip.supply.interrupts());
    chip.supply.set(2.85);
    assert!(chip.supply.interrupts());
    disable_for_sag(&chip, &BOARD);
    assert_eq!(chip.output(), Output::Low);
    assert_eq!(chip.pins.driven(1, 15), Level::Low);
    // Not again and again.
    assert!(!chip.supply.interrupts());
    // It may be over before the sample: that sees it all the same.
    for voltage in [3.3, 2.5] {
        chip.supply.set(voltage);
        assert!(!wired.inputs.supply_is_healthy());
    }
    // While it lasts, disabling the output does not acknowledge it.
    let Ok(()) = wired.pwm.set_duty_cycle_fully_off();
    assert!(!wired.inputs.supply_is_healthy());
    chip.supply.set(3.3);
    let Ok(()) = wired.pwm.set_duty_cycle_fully_off();
    assert!(wired.inputs.supply_is_healthy() && !chip.supply.interrupts());
    chip.supply.set(2.5);
    assert!(chip.supply.interrupts());
}

#[test]
fn a_supply_that_is_low_from_the_beginning_is_noticed() {
    let chip = healthy();
    chip.supply.set(2.7);
    let wired = wired(&chip);
    assert!(!wired.inputs.supply_is_healthy());
    assert!(chip.supply.interrupts());
}

#[test]
fn nothing_is_written_to_the_flash_below_the_threshold() {
    let chip = healthy();
    let mut wired = wired(&chip);
    let flash = &mut wired.flash;
    chip.supply.set(2.5);
    assert_eq!(flash.write(0, &[1; 8]), Err(FlashError::SupplyLow));
    assert_eq!(flash.erase(0, 0x4000), Err(FlashError::SupplyLow));
    assert!(chip.memory.erased.borrow().is_empty());
    assert_eq!(chip.memory.bytes(0x0800_4000, 8), [0xff; 8]);
    assert!(chip.memory.is_locked());
    chip.supply.set(3.3);
    // As a sample at rest does.
    let Ok(()) = wired.pwm.set_duty_cycle_fully_off();
    assert_eq!(wired.flash.write(0, &[1; 8]), Ok(()));
}

#[test]
fn a_sag_that_is_over_before_the_step_ends_fails_it_all_the_same() {
    let chip = healthy();
    let mut wired = wired(&chip);
    let sags = |chip: &Chip| {
        chip.supply.set(2.5);
        chip.supply.set(3.3);
    };
    chip.in_a_step(sags);
    assert_eq!(wired.flash.erase(0, 0x4000), Err(FlashError::SupplyLow));
    // Until a sample has seen it.
    let low = Err(FlashError::SupplyLow);
    assert_eq!(wired.flash.write(0, &[1; 16]), low);
    let Ok(()) = wired.pwm.set_duty_cycle_fully_off();
    chip.in_a_step(sags);
    assert_eq!(wired.flash.write(0, &[1; 16]), low);
    assert_eq!(chip.memory.bytes(0x0800_4008, 8), [0xff; 8]);
    // In the last step of a record too.
    let Ok(()) = wired.pwm.set_duty_cycle_fully_off();
    chip.in_a_step(sags);
    assert_eq!(wired.flash.write(0x10, &[1; WORD]), low);
    let Ok(()) = wired.pwm.set_duty_cycle_fully_off();
    assert_eq!(wired.flash.write(0x20, &[1; 16]), Ok(()));
}

#[test]
fn a_halted_processor_leaves_the_watchdog_and_the_pwm_running() {
    let chip = healthy();
    chip.supply.freeze();
    let _wired = wired(&chip);
    assert_eq!(chip.supply.is_frozen(), [false; 2]);
}
