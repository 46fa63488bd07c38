use drive_chip::disable_outputs;
use embedded_hal::digital::OutputPin;
use embedded_hal::pwm::SetDutyCycle;

use crate::facts::{BREAKS, STEPS};
use crate::model::{Line, Output};
use crate::shared::{drive_again, driving};
use crate::{BOARD, healthy, slow, wired};

/// Duties, and the signal on the pin.
const DUTIES: [(u16, Output); 5] = [
    (0, Output::Low),
    (1, pwm(1)),
    (STEPS / 2, pwm(STEPS as u32 / 2)),
    (STEPS, Output::High),
    (u16::MAX, Output::High),
];

const fn pwm(high: u32) -> Output {
    Output::Pwm {
        high,
        period: STEPS as u32,
    }
}

#[test]
fn a_duty_is_the_high_part_of_twenty_kilohertz() {
    let chip = healthy();
    let mut wired = wired(&chip);
    wired.timer.start(1e-3);
    assert_eq!(wired.pwm.max_duty_cycle(), STEPS);
    assert!(chip.timers.is_edge_aligned());
    for (duty, output) in DUTIES {
        assert_eq!(wired.pwm.set_duty_cycle(duty), Ok(()));
        chip.elapse(50e-6);
        assert_eq!(chip.output(), output, "duty {duty}");
    }
    let processor = chip.clocks.frequencies().high_timers;
    assert!((processor / f64::from(STEPS) - 20e3).abs() < 1e-6);
    // Without a crystal it has fewer steps.
    let slow = slow();
    assert_eq!(crate::wired(&slow).pwm.max_duty_cycle(), 800);
}

#[test]
fn off_is_low_from_the_wiring_on_and_never_floats() {
    let chip = healthy();
    let mut wired = wired(&chip);
    assert_eq!(chip.output(), Output::Low);
    wired.timer.start(1e-3);
    assert_eq!(chip.output(), Output::Low);
    let _ = wired.pwm.set_duty_cycle(STEPS);
    chip.elapse(50e-6);
    assert_eq!(chip.output(), Output::High);
    assert_eq!(chip.timers.drive_what_is_off(), [true, true]);
    // At once, not with the next period.
    assert_eq!(wired.pwm.set_duty_cycle_fully_off(), Ok(()));
    assert_eq!(chip.output(), Output::Low);
    // The duty before does not come back with the next one.
    chip.elapse(50e-6);
    let _ = wired.pwm.set_duty_cycle(100);
    assert_eq!(chip.output(), Output::Low);
    chip.elapse(50e-6);
    assert_eq!(chip.output(), pwm(100));
}

#[test]
fn direction_and_duty_change_with_the_same_period() {
    let chip = healthy();
    let mut wired = wired(&chip);
    wired.timer.start(1e-4);
    assert_eq!(chip.direction(), Output::Low);
    // A period may begin before the direction, between both, and after the duty.
    for between in [[50e-6, 0.0, 0.0], [0.0, 50e-6, 0.0], [0.0, 0.0, 50e-6]] {
        let [before, halfway, after] = between;
        let _ = wired.direction.set_low();
        let _ = wired.pwm.set_duty_cycle(1000);
        chip.elapse(50e-6);
        assert_eq!((chip.direction(), chip.output()), (Output::Low, pwm(1000)));
        chip.elapse(before);
        let _ = wired.direction.set_high();
        chip.elapse(halfway);
        assert_eq!((chip.direction(), chip.output()), (Output::Low, pwm(1000)));
        let _ = wired.pwm.set_duty_cycle(3000);
        assert_eq!((chip.direction(), chip.output()), (Output::Low, pwm(1000)));
        chip.elapse(after);
        chip.elapse(50e-6);
        assert_eq!((chip.direction(), chip.output()), (Output::High, pwm(3000)));
    }
}

#[test]
fn a_direction_without_its_duty_is_void_once_the_output_is_off() {
    let chip = healthy();
    let mut wired = wired(&chip);
    wired.timer.start(1e-3);
    let _ = wired.direction.set_high();
    let _ = wired.pwm.set_duty_cycle(STEPS);
    chip.elapse(50e-6);
    assert_eq!(chip.direction(), Output::High);
    let _ = wired.direction.set_low();
    let _ = wired.pwm.set_duty_cycle_fully_off();
    assert_eq!(
        (chip.direction(), chip.output()),
        (Output::Low, Output::Low)
    );
    // The duty before is forgotten with the next period.
    chip.elapse(50e-6);
    let _ = wired.pwm.set_duty_cycle(100);
    assert_eq!(chip.output(), Output::Low);
}

#[test]
fn a_break_disables_the_output_without_the_processor() {
    let chip = healthy();
    let mut wired = driving(&chip);
    assert!(wired.inputs.amplifier_is_healthy());

    // A broken wire is a break too.
    chip.drive(1, 12, Line::Open);
    assert_eq!(chip.output(), Output::Low);
    assert!(!wired.inputs.amplifier_is_healthy());
    // As long as it lasts no duty comes through.
    let _ = wired.pwm.set_duty_cycle(STEPS);
    assert_eq!(chip.output(), Output::Low);

    // Afterwards it still shows, until the output is switched off.
    chip.drive(1, 12, Line::Ground);
    assert_eq!(chip.output(), Output::Low);
    assert!(!wired.inputs.amplifier_is_healthy());
    let _ = wired.pwm.set_duty_cycle_fully_off();
    assert!(wired.inputs.amplifier_is_healthy());
}

#[test]
fn a_break_that_is_over_before_the_next_duty_keeps_the_output_off_and_shows() {
    let chip = healthy();
    let mut wired = wired(&chip);
    wired.timer.start(1e-3);
    let hold = |pwm: &mut drive_chip::pwm::Pwm<_>| {
        for _ in 0..3 {
            let _ = pwm.set_duty_cycle(STEPS);
            chip.elapse(50e-6);
        }
    };
    hold(&mut wired.pwm);
    assert_eq!(chip.output(), Output::High);
    // Between the look at the lines and the command of the same sample.
    assert!(wired.inputs.amplifier_is_healthy());
    chip.drive(1, 12, Line::Open);
    chip.drive(1, 12, Line::Ground);
    hold(&mut wired.pwm);
    assert_eq!(chip.output(), Output::Low);
    assert!(
        !wired.inputs.amplifier_is_healthy(),
        "the next sample sees it"
    );
    hold(&mut wired.pwm);
    assert_eq!(chip.output(), Output::Low);
    let _ = wired.pwm.set_duty_cycle_fully_off();
    assert!(wired.inputs.amplifier_is_healthy());
    hold(&mut wired.pwm);
    assert_eq!(chip.output(), Output::High);
}

#[test]
fn no_write_takes_the_break_away() {
    let chip = healthy();
    let mut wired = wired(&chip);
    wired.timer.start(1e-3);
    let tim1 = &chip.timers.tim1;
    let address = tim1.address(tim1.bdtr());
    for word in [0, 0xffff, 1 << 15, 1 << 14, 0x3 << 8] {
        let (_, place) = chip.timers.find(address).expect("it is there");
        chip.timers.write(address, place, word);
        let control = tim1.bdtr().read();
        assert!(control.bke().is_enabled() && control.bkp().is_active_high());
        assert!(!control.aoe().bit(), "no output comes back by itself");
    }
    drive_again(&chip, &mut wired);
    chip.drive(1, 12, Line::Open);
    assert_eq!(chip.output(), Output::Low);
}

#[test]
fn switching_off_leaves_the_other_flags() {
    let chip = healthy();
    let mut wired = wired(&chip);
    let timer = &chip.timers.tim1;
    timer.set(timer.sr(), 0xffff);
    let _ = wired.pwm.set_duty_cycle_fully_off();
    assert_eq!(timer.get(timer.sr()), 0xffff & !u32::from(BREAKS));
}

#[test]
fn the_outputs_are_disabled_in_any_state() {
    for disturbance in [None, Some(0), Some(0x8000), Some(0xffff & !0x0300)] {
        let chip = healthy();
        let mut wired = driving(&chip);
        let _ = wired.enable.set_high();
        if let Some(control) = disturbance {
            chip.timers.tim1.set(chip.timers.tim1.bdtr(), control);
        }
        disable_outputs(&chip, &BOARD);
        assert_eq!(chip.output(), Output::Low, "after {disturbance:?}");
        assert_eq!(chip.pins.level(1, 15), crate::model::Level::Low);
        // For good, until it is switched off.
        let _ = wired.pwm.set_duty_cycle(STEPS);
        assert_eq!(chip.output(), Output::Low);
        // The break input still holds.
        drive_again(&chip, &mut wired);
        chip.drive(1, 12, Line::Supply);
        assert_eq!(chip.output(), Output::Low);
    }
    // Before the wiring it has no effect.
    disable_outputs(&healthy(), &BOARD);
}
