use drive_chip::board::Oscillator;
use drive_chip::clock::{Clocks, start};
use drive_link::Fault;

use crate::model::{Chip, Source};

/// What the driver says that the clocks are, against what they are.
fn assert_told(chip: &Chip, told: Clocks) {
    let true_ones = chip.clocks.frequencies();
    for (told, is) in [
        (told.low_bus, true_ones.low_bus),
        (told.low_timers, true_ones.low_timers),
        (told.high_timers, true_ones.high_timers),
    ] {
        assert!((f64::from(told) - is).abs() < 1e-6, "{told} told for {is}");
    }
}

#[test]
fn any_oscillator_becomes_168_megahertz() {
    // Every step is checked by the model: PLL, wait states, buses.
    for megahertz in (4..=26).step_by(2) {
        let frequency = megahertz * 1_000_000;
        let crystal = (
            Source::Crystal(frequency.into()),
            Oscillator::crystal(frequency),
        );
        let clock = (
            Source::Clock(frequency.into()),
            Oscillator::clock(frequency),
        );
        for ((source, oscillator), used_before) in [
            (crystal, false),
            (clock, false),
            (crystal, true),
            (clock, true),
        ] {
            let chip = Chip::new(source);
            if used_before {
                chip.clocks.leave_factors();
                chip.memory.leave_wait_states();
            }
            let (told, found) = start(&chip, oscillator);
            assert_eq!(found, Ok(()));
            assert!((chip.clocks.frequencies().processor - 168e6).abs() < 1e-6);
            assert_told(&chip, told);
            assert!(chip.clocks.is_watched());
            assert!(chip.memory.is_cached());
            assert_eq!(chip.memory.wait_states(), 5);
        }
    }
}

#[test]
fn what_does_not_become_ready_leaves_the_clocks_of_the_reset() {
    let dead = Chip::new(Source::Nothing);
    let unlocked = Chip::new(Source::Crystal(8e6));
    unlocked.clocks.pll_fails.set(true);
    let unswitched = Chip::new(Source::Crystal(8e6));
    unswitched.clocks.switch_fails.set(true);
    for chip in [dead, unlocked, unswitched] {
        let (told, found) = start(&chip, Oscillator::crystal(8_000_000));
        assert_eq!(found, Err(Fault::ClockNotStable));
        assert_eq!(told, Clocks::RESET);
        assert_told(&chip, told);
        assert!(chip.clocks.are_reset());
    }
    let clock = Chip::new(Source::Nothing);
    let (_, found) = start(&clock, Oscillator::clock(8_000_000));
    assert_eq!(found, Err(Fault::ClockNotStable));
    assert!(clock.clocks.are_reset());
}

#[test]
fn a_crystal_is_not_taken_for_a_clock() {
    let crystal = Chip::new(Source::Crystal(8e6));
    let (_, found) = start(&crystal, Oscillator::clock(8_000_000));
    assert_eq!(found, Err(Fault::ClockNotStable));
}

#[test]
fn an_oscillator_that_the_pll_does_not_take_is_none() {
    for frequency in [2_000_000, 5_000_000, 28_000_000] {
        assert!(std::panic::catch_unwind(|| Oscillator::crystal(frequency)).is_err());
        assert!(std::panic::catch_unwind(|| Oscillator::clock(frequency)).is_err());
    }
}
