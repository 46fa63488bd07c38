use drive_chip::G4;
use drive_chip::board::Oscillator;
use drive_chip::clock::{Clocks, start};
use drive_link::Fault;

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
fn any_oscillator_becomes_170_megahertz() {
    // Every step is checked by the model: PLL, boost, half of the clock, wait states.
    for megahertz in (4..=48).step_by(4) {
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
                    // Every factor and prescaler as large as its field.
                    let rcc = &chip.clocks.rcc;
                    rcc.set(rcc.pllcfgr(), 0xffff_fffc);
                    rcc.set(rcc.cfgr(), rcc.get(rcc.cfgr()) | 0x3ff0);
                }
                let (clocks, found) = start(&chip, oscillator);
                assert_eq!(found, Ok(()));
                assert!((chip.clocks.frequencies().processor - 170e6).abs() < 1e-6);
                assert_true(&chip, clocks);
                assert!(chip.clocks.is_watched() && chip.clocks.is_boosted.get());
                assert!(chip.memory.is_cached());
                assert_eq!(chip.memory.wait_states(), 4);
            }
        }
    }
}

#[test]
fn a_program_that_a_debugger_restarts_never_runs_beyond_its_limits() {
    // The model panics where one does, at every write and every switch.
    let chip = Chip::new(Source::Crystal(24e6));
    for _ in 0..3 {
        let (clocks, found) = start(&chip, Oscillator::crystal(24_000_000));
        assert_eq!(found, Ok(()));
        assert_true(&chip, clocks);
    }
}

#[test]
fn a_clock_that_does_not_start_leaves_those_after_reset() {
    let dead = Chip::new(Source::Nothing);
    let unlocked = Chip::new(Source::Crystal(24e6));
    unlocked.clocks.pll_fails.set(true);
    let unswitched = Chip::new(Source::Crystal(24e6));
    unswitched.clocks.switch_fails.set(true);
    for chip in [dead, unlocked, unswitched] {
        let (clocks, found) = start(&chip, Oscillator::crystal(24_000_000));
        assert_eq!(found, Err(Fault::ClockNotStable));
        assert_eq!(clocks, Clocks::RESET);
        assert_true(&chip, clocks);
        assert!(chip.clocks.are_reset());
    }
}

#[test]
fn a_crystal_configured_as_an_external_clock_is_a_fault() {
    let crystal = Chip::new(Source::Crystal(24e6));
    let (_, found) = start(&crystal, Oscillator::clock(24_000_000));
    assert_eq!(found, Err(Fault::ClockNotStable));
}

#[test]
fn an_oscillator_outside_the_pll_s_range_is_refused() {
    for frequency in [2_000_000, 6_000_000, 52_000_000] {
        assert!(std::panic::catch_unwind(|| Oscillator::<G4>::crystal(frequency)).is_err());
        assert!(std::panic::catch_unwind(|| Oscillator::<G4>::clock(frequency)).is_err());
    }
}
