use drive_chip::F4;
use drive_chip::board::Oscillator;
use drive_chip::clock::{Clocks, start};
use drive_link::Fault;

use crate::model::{Chip, Source};

/// Compares the frequencies that the driver returns with those of the chip.
fn assert_true(chip: &Chip, found: Clocks) {
    let frequencies = chip.clocks.frequencies();
    for (found, is) in [
        (found.low_bus, frequencies.low_bus),
        (found.low_timers, frequencies.low_timers),
        (found.high_timers, frequencies.high_timers),
    ] {
        assert!((f64::from(found) - is).abs() < 1e-6, "{found} for {is}");
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
                // Every factor, prescaler and wait state as large as its field.
                let (rcc, flash) = (&chip.clocks.rcc, &chip.memory.flash);
                rcc.set(rcc.pllcfgr(), rcc.get(rcc.pllcfgr()) | 0x0f43_7fff);
                rcc.set(rcc.cfgr(), rcc.get(rcc.cfgr()) | 0xfcf0);
                flash.set(flash.acr(), 0b111);
            }
            let (clocks, found) = start(&chip, oscillator);
            assert_eq!(found, Ok(()));
            assert!((chip.clocks.frequencies().processor - 168e6).abs() < 1e-6);
            assert_true(&chip, clocks);
            assert!(chip.clocks.is_watched());
            assert!(chip.memory.is_cached());
            assert_eq!(chip.memory.wait_states(), 5);
        }
    }
}

#[test]
fn a_program_that_a_debugger_restarts_never_runs_a_bus_beyond_its_limit() {
    // The model panics where one does, at every write and every switch.
    let chip = Chip::new(Source::Crystal(8e6));
    for _ in 0..3 {
        let (clocks, found) = start(&chip, Oscillator::crystal(8_000_000));
        assert_eq!(found, Ok(()));
        assert_true(&chip, clocks);
    }
}

#[test]
fn a_clock_that_does_not_start_leaves_those_after_reset() {
    let dead = Chip::new(Source::Nothing);
    let unlocked = Chip::new(Source::Crystal(8e6));
    unlocked.clocks.pll_fails.set(true);
    let unswitched = Chip::new(Source::Crystal(8e6));
    unswitched.clocks.switch_fails.set(true);
    for chip in [dead, unlocked, unswitched] {
        let (clocks, found) = start(&chip, Oscillator::crystal(8_000_000));
        assert_eq!(found, Err(Fault::ClockNotStable));
        assert_eq!(clocks, Clocks::RESET);
        assert_true(&chip, clocks);
        assert!(chip.clocks.are_reset());
    }
    let clock = Chip::new(Source::Nothing);
    let (_, found) = start(&clock, Oscillator::clock(8_000_000));
    assert_eq!(found, Err(Fault::ClockNotStable));
    assert!(clock.clocks.are_reset());
}

#[test]
fn a_crystal_configured_as_an_external_clock_is_a_fault() {
    let crystal = Chip::new(Source::Crystal(8e6));
    let (_, found) = start(&crystal, Oscillator::clock(8_000_000));
    assert_eq!(found, Err(Fault::ClockNotStable));
}

#[test]
fn an_oscillator_outside_the_pll_s_range_is_refused() {
    for frequency in [2_000_000, 5_000_000, 28_000_000] {
        assert!(std::panic::catch_unwind(|| Oscillator::<F4>::crystal(frequency)).is_err());
        assert!(std::panic::catch_unwind(|| Oscillator::<F4>::clock(frequency)).is_err());
    }
}

#[test]
fn an_oscillator_that_fails_ends_the_program() {
    assert!(!Chip::new(Source::Crystal(8e6)).non_maskable_interrupt());
}
