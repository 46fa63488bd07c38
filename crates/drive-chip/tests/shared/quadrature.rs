use drive_chip::quadrature::max_count_rate;
use embedded_storage::nor_flash::NorFlash;
use identifier_core::drive::PositionSensor;

use crate::facts::ENCODER_FILTER;
use crate::{Family, healthy, slow, wired};

#[test]
fn every_edge_counts_through_any_wrap() {
    let chip = healthy();
    let mut encoder = wired(&chip).encoder;
    assert_eq!(encoder.count(), Ok(0));
    let mut count = 0;
    for edges in [1, 1, -3, 32_000, 32_000, 32_000, -30_000, -32_000, -20_000] {
        chip.timers.turn(edges);
        count += edges;
        assert_eq!(encoder.count(), Ok(count));
    }
}

#[test]
fn an_erasure_may_take_longer_than_a_round_of_the_counter_of_which_the_next_sample_knows_nothing() {
    let chip = healthy();
    let wired = wired(&chip);
    let (mut encoder, mut flash) = (wired.encoder, wired.flash);
    for (edges, counted) in [(32_000, 32_000), (40_000, 40_000 - 65_536)] {
        let before = encoder.count().unwrap_or_default();
        chip.in_a_step(if edges == 40_000 {
            |chip| chip.timers.turn(40_000)
        } else {
            |chip| chip.timers.turn(32_000)
        });
        assert_eq!(flash.erase(0, 0x4000), Ok(()));
        assert_eq!(encoder.count(), Ok(before + counted));
    }
}

#[test]
fn the_index_captures_the_count_of_its_edge() {
    let chip = healthy();
    let mut encoder = wired(&chip).encoder;
    assert_eq!(encoder.index(), None);
    for (turned, on) in [
        (100, 30),
        (-40, -7),
        (32_000, 500),
        (32_000, 500),
        (32_000, 500),
    ] {
        let before = encoder.count().unwrap_or_default();
        chip.timers.turn(turned);
        chip.timers.index();
        chip.timers.turn(on);
        // Before the sample reads the count, and after it.
        if turned > 0 {
            assert_eq!(encoder.count(), Ok(before + turned + on));
        }
        assert_eq!(encoder.index(), Some(before + turned));
        assert_eq!(encoder.index(), None, "once");
    }
}

#[test]
fn the_input_filters_give_the_stated_count_rate() {
    let chip = healthy();
    let _wired = wired(&chip);
    let filters = chip.timers.encoder_filters(&chip.clocks);
    for filter in filters {
        assert!((filter - ENCODER_FILTER).abs() < 1e-12, "{filter} s");
    }
    let most: f64 = filters[..2].iter().map(|filter| 1.0 / filter).sum();
    assert!((max_count_rate::<Family>() - most).abs() < 1.0);
    // More than the 1 MHz of an encoder of 10 000 counts at 6000 revolutions a minute.
    const { assert!(max_count_rate::<Family>() > 1e6) };
    let slow = slow();
    let _wired = wired(&slow);
    assert!(slow.timers.encoder_filters(&slow.clocks)[0] > 1e-6);
}
