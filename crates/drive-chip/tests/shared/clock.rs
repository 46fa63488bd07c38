use std::panic::catch_unwind;

use drive_chip::board::Oscillator;
use drive_chip::clock::{Clocks, start};
use drive_link::Fault;

use crate::Family;
use crate::facts::{
    CLOCK, MEGAHERTZ, NO_OSCILLATORS, OSCILLATOR, PROCESSOR, SOURCE, WAIT_STATES, use_every_field,
};
use crate::model::{Chip, Source};

/// Compares the frequencies that the driver returns with those of the chip.
fn assert_true(chip: &Chip, found: Clocks) {
    let frequencies = chip.clocks.frequencies();
    for (found, is) in [
        (found.processor, frequencies.processor),
        (found.low_bus, frequencies.low_bus),
        (found.low_timers, frequencies.low_timers),
        (found.high_timers, frequencies.high_timers),
    ] {
        assert!((f64::from(found) - is).abs() < 1e-6, "{found} for {is}");
    }
}

#[test]
fn any_oscillator_becomes_the_clock_of_the_family() {
    // Every step is checked by the model: PLL, wait states, buses, the core's voltage.
    for megahertz in MEGAHERTZ {
        let frequency = megahertz * 1_000_000;
        for (source, oscillator) in [
            (
                Source::Crystal(frequency.into()),
                Oscillator::crystal(frequency),
            ),
            (
                Source::Clock(frequency.into()),
                Oscillator::clock(frequency),
            ),
        ] {
            for used_before in [false, true] {
                let chip = Chip::new(source);
                if used_before {
                    use_every_field(&chip);
                }
                let (clocks, found) = start(&chip, oscillator);
                assert_eq!(found, Ok(()));
                assert!((chip.clocks.frequencies().processor - PROCESSOR).abs() < 1e-6);
                assert_true(&chip, clocks);
                assert!(chip.clocks.is_watched());
                assert!(chip.memory.is_cached());
                assert_eq!(chip.memory.wait_states(), WAIT_STATES);
            }
        }
    }
}

#[test]
fn a_program_that_a_debugger_restarts_never_runs_beyond_its_limits() {
    // The model panics where one does, at every write and every switch.
    let chip = Chip::new(SOURCE);
    for _ in 0..3 {
        let (clocks, found) = start(&chip, OSCILLATOR);
        assert_eq!(found, Ok(()));
        assert_true(&chip, clocks);
    }
}

#[test]
fn a_clock_that_does_not_start_leaves_those_after_reset() {
    let dead = Chip::new(Source::Nothing);
    let unlocked = Chip::new(SOURCE);
    unlocked.clocks.pll_fails.set(true);
    let unswitched = Chip::new(SOURCE);
    unswitched.clocks.switch_fails.set(true);
    for chip in [dead, unlocked, unswitched] {
        let (clocks, found) = start(&chip, OSCILLATOR);
        assert_eq!(found, Err(Fault::ClockNotStable));
        assert_eq!(clocks, Clocks::RESET);
        assert_true(&chip, clocks);
        assert!(chip.clocks.are_reset());
    }
    let clock = Chip::new(Source::Nothing);
    let (_, found) = start(&clock, CLOCK);
    assert_eq!(found, Err(Fault::ClockNotStable));
    assert!(clock.clocks.are_reset());
}

#[test]
fn a_crystal_configured_as_an_external_clock_is_a_fault() {
    let crystal = Chip::new(SOURCE);
    let (_, found) = start(&crystal, CLOCK);
    assert_eq!(found, Err(Fault::ClockNotStable));
}

#[test]
fn an_oscillator_outside_the_pll_s_range_is_refused() {
    for frequency in NO_OSCILLATORS {
        assert!(catch_unwind(|| Oscillator::<Family>::crystal(frequency)).is_err());
        assert!(catch_unwind(|| Oscillator::<Family>::clock(frequency)).is_err());
    }
}

#[test]
fn an_oscillator_that_fails_ends_the_program() {
    assert!(!Chip::new(SOURCE).non_maskable_interrupt());
}
