use drive_chip::disable_outputs;
use drive_chip::flash::Areas;
use drive_chip::pins::{Pin, Port};
use embedded_hal::digital::OutputPin;

use crate::facts::{TIM1_FUNCTION, UNUSED};
use crate::model::{Level, Mode, Output, Pull};
use crate::{BOARD, healthy, wired};

#[test]
fn every_pin_has_the_function_of_its_board() {
    let chip = healthy();
    let pins = [
        ((0, 2), Mode::Alternate(7), Pull::None),
        ((0, 3), Mode::Alternate(7), Pull::Up),
        ((0, 8), Mode::Alternate(TIM1_FUNCTION), Pull::None),
        ((1, 6), Mode::Alternate(2), Pull::Up),
        ((1, 7), Mode::Alternate(2), Pull::Up),
        ((1, 12), Mode::Alternate(TIM1_FUNCTION), Pull::Up),
        ((1, 14), Mode::Alternate(TIM1_FUNCTION), Pull::None),
        ((1, 13), Mode::Output, Pull::None),
        ((1, 15), Mode::Output, Pull::None),
        ((2, 0), Mode::Input, Pull::Up),
        ((2, 1), Mode::Input, Pull::Up),
        ((2, 2), Mode::Input, Pull::Up),
        ((2, 6), Mode::Alternate(2), Pull::Up),
        ((2, 7), Mode::Alternate(2), Pull::Up),
        ((2, 8), Mode::Alternate(2), Pull::Up),
    ];
    for ((port, number), mode, _) in pins {
        if mode != Mode::Output {
            chip.pins.leave_used(port, number);
        }
        if let Mode::Alternate(_) = mode {
            chip.pins.leave_open_drain(port, number);
        }
    }
    let _wired = wired(&chip);
    for ((port, number), mode, pull) in pins {
        assert_eq!(chip.pins.mode(port, number), mode, "{port} {number}");
        assert_eq!(chip.pins.pull(port, number), pull, "{port} {number}");
        assert!(mode == Mode::Input || chip.pins.is_push_pull(port, number));
    }
    // A debugger's pins stay its own.
    for (port, number) in [(0, 13), (0, 14), (0, 15), (1, 3), (1, 4)] {
        assert_eq!(chip.pins.mode(port, number), Mode::Alternate(0));
    }
    for (port, number) in [(0, 1), (0, 4), (0, 7), (1, 11), (2, 5), (2, 9)] {
        assert_eq!(chip.pins.mode(port, number), UNUSED);
        assert_eq!(chip.pins.pull(port, number), Pull::None);
    }
}

#[test]
fn enable_is_an_output_of_its_own() {
    let chip = healthy();
    let mut wired = wired(&chip);
    assert_eq!(chip.pins.level(1, 15), Level::Low);
    assert_eq!(wired.enable.set_high(), Ok(()));
    assert_eq!(chip.pins.level(1, 15), Level::High);
    assert_eq!(chip.direction(), Output::Low);
    assert_eq!(wired.enable.set_low(), Ok(()));
    assert_eq!(chip.pins.level(1, 15), Level::Low);
}

#[test]
fn the_brake_is_an_output_of_its_own_that_closes_with_the_outputs() {
    let chip = healthy();
    let mut wired = wired(&chip);
    assert_eq!(chip.pins.level(1, 13), Level::Low);
    assert_eq!(wired.brake.set_high(), Ok(()));
    assert_eq!(chip.pins.level(1, 13), Level::High);
    assert_eq!(chip.pins.level(1, 15), Level::Low);
    disable_outputs(&chip, &BOARD);
    assert_eq!(chip.pins.level(1, 13), Level::Low);
}

#[test]
fn there_are_sixteen_pins_and_two_areas() {
    assert!(std::panic::catch_unwind(|| Pin::new(Port::A, 16)).is_err());
    assert_ne!(Pin::new(Port::A, 15), Pin::new(Port::B, 15));
    for first in [0, 3] {
        assert!(std::panic::catch_unwind(move || Areas::starting_at(first)).is_err());
    }
    assert_ne!(Areas::starting_at(1), Areas::starting_at(2));
}
