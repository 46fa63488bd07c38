use drive_chip::sample_timer::{LEAD, acknowledge, is_due};
use embedded_hal::pwm::SetDutyCycle;

use crate::facts::STEPS;
use crate::model::{Chip, Output};
use crate::{healthy, slow, wired};

/// A tick of the fastest timer is 6 ns.
const TICK: f64 = 1e-9;

/// From an update of TIM5 to the next one of TIM1, s, by their counts.
fn lead(chip: &Chip) -> f64 {
    let [pwm, sample] = chip.timers.until_update(&chip.clocks);
    (pwm - sample).rem_euclid(50e-6)
}

#[test]
fn a_sample_leads_the_pwm_by_twelve_and_a_half_microseconds() {
    assert!((LEAD - 12.5e-6).abs() < 1e-15);
    for chip in [healthy(), slow()] {
        let wired = wired(&chip);
        assert_eq!(chip.timers.counting(), [false, false]);
        for sample_time in [50e-6, 100e-6, 1e-3, 250e-6] {
            wired.timer.start(sample_time);
            assert_eq!(chip.timers.counting(), [true, true]);
            assert!((lead(&chip) - LEAD).abs() < TICK);
            // It stays so from any counts at which they are started again.
            for _ in 0..5 {
                chip.elapse(130e-6);
                assert!((lead(&chip) - LEAD).abs() < TICK);
            }
        }
    }
}

#[test]
fn both_timers_start_with_one_write() {
    let chip = healthy();
    let wired = wired(&chip);
    wired.timer.start(1e-3);
    // Between two writes an interrupt may come.
    let enabled = |words: Vec<u32>| words.iter().filter(|&word| word & 1 != 0).count();
    let (tim1, tim5) = (&chip.timers.tim1, &chip.timers.tim5);
    assert_eq!(enabled(chip.written_to(tim1.address(tim1.cr1()))), 0);
    assert_eq!(enabled(chip.written_to(tim5.address(tim5.cr1()))), 1);
}

#[test]
fn a_sample_is_due_every_sample_time_and_not_at_the_start() {
    for chip in [healthy(), slow()] {
        let wired = wired(&chip);
        for (sample_time, runs_with) in
            [(1e-3, 1e-3), (50e-6, 50e-6), (1.01e-4, 1e-4), (0.0, 50e-6)]
        {
            wired.timer.start(sample_time);
            assert!(!is_due(&chip));
            chip.elapse(runs_with - 1e-6);
            assert!(!is_due(&chip) && !chip.timers.interrupts());
            chip.elapse(1e-6);
            assert!(is_due(&chip) && chip.timers.interrupts());
            acknowledge(&chip);
            assert!(!is_due(&chip) && !chip.timers.interrupts());
        }
    }
}

#[test]
fn a_new_start_is_no_sample() {
    let chip = healthy();
    let wired = wired(&chip);
    wired.timer.start(1e-3);
    chip.elapse(1.5e-3);
    assert!(is_due(&chip));
    assert_eq!(chip.timers.asked.get(), 1);
    wired.timer.start(1e-3);
    assert!(!is_due(&chip));
    // Not even for a moment, which the interrupt controller would remember.
    assert_eq!(chip.timers.asked.get(), 1);
}

#[test]
fn an_acknowledgement_leaves_the_other_flags() {
    let chip = healthy();
    let _wired = wired(&chip);
    let timer = &chip.timers.tim5;
    timer.set(timer.sr(), 0xffff);
    acknowledge(&chip);
    assert_eq!(timer.get(timer.sr()), 0xfffe);
}

#[test]
fn a_command_holds_from_its_lead_on() {
    let chip = healthy();
    let mut wired = wired(&chip);
    wired.timer.start(1e-4);
    let _ = wired.pwm.set_duty_cycle(0);
    let mut before = Output::Low;
    for duty in [1000, 8000, 2000] {
        chip.elapse(1e-4);
        assert!(is_due(&chip));
        acknowledge(&chip);
        let _ = wired.pwm.set_duty_cycle(duty);
        chip.elapse(LEAD - 0.1e-6);
        assert_eq!(chip.output(), before);
        chip.elapse(0.1e-6);
        before = Output::Pwm {
            high: duty.into(),
            period: STEPS.into(),
        };
        assert_eq!(chip.output(), before);
        // The rest of the sample.
        chip.elapse(1e-4 - LEAD);
        assert!(is_due(&chip));
        acknowledge(&chip);
    }
}
