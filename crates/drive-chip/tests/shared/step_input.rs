use drive_chip::step_input::{StepInput, max_step_rate};

use crate::model::Chip;
use crate::{Family, healthy, wired};

/// The input of a chip whose direction line is pulled up.
fn input(chip: &Chip) -> StepInput<&Chip> {
    let mut steps = wired(chip).steps;
    assert_eq!(steps.steps(), Some(0));
    steps
}

#[test]
fn steps_count_by_the_direction_that_they_had() {
    let chip = healthy();
    let mut steps = input(&chip);
    chip.step(5);
    assert_eq!(steps.steps(), Some(5));
    chip.direct(false);
    chip.step(3);
    assert_eq!(steps.steps(), Some(-3));
    // A change between two calls, steps on both sides of it.
    chip.step(4);
    chip.direct(true);
    chip.step(10);
    assert_eq!(steps.steps(), Some(6));
    chip.step(7);
    chip.direct(false);
    assert_eq!(steps.steps(), Some(7));
    chip.step(1);
    assert_eq!(steps.steps(), Some(-1));
}

#[test]
fn they_count_through_any_wrap() {
    let chip = healthy();
    let mut steps = input(&chip);
    for _ in 0..10 {
        chip.step(30_000);
        assert_eq!(steps.steps(), Some(30_000));
    }
    chip.step(20_000);
    chip.direct(false);
    chip.step(5_000);
    assert_eq!(steps.steps(), Some(15_000));
}

#[test]
fn an_edge_while_it_is_read_loses_no_step() {
    let chip = healthy();
    let mut steps = input(&chip);
    chip.step(5);
    // Between the reads of counter and flag: two more up, then four down.
    chip.while_reading(|chip| {
        chip.step(2);
        chip.direct(false);
        chip.step(4);
    });
    let first = steps.steps().expect("clear");
    let second = steps.steps().expect("clear");
    assert_eq!(first + second, 5 + 2 - 4);
    chip.step(1);
    assert_eq!(steps.steps(), Some(-1));
}

#[test]
fn two_changes_of_direction_between_two_calls_are_unclear_once() {
    let chip = healthy();
    let mut steps = input(&chip);
    chip.step(5);
    chip.direct(false);
    chip.step(5);
    chip.direct(true);
    chip.step(5);
    assert_eq!(steps.steps(), None);
    chip.step(2);
    assert_eq!(steps.steps(), Some(2));
    chip.direct(false);
    chip.step(1);
    assert_eq!(steps.steps(), Some(-1));
}

#[test]
fn a_level_without_an_edge_is_unclear_unless_the_filter_explains_it() {
    let chip = healthy();
    let mut steps = input(&chip);
    // The edge is on its way through the filter.
    chip.level_of_direction(false);
    assert_eq!(steps.steps(), Some(0));
    chip.direct(false);
    chip.step(1);
    assert_eq!(steps.steps(), Some(-1));
    // This one never comes.
    chip.level_of_direction(true);
    assert_eq!(steps.steps(), Some(0));
    assert_eq!(steps.steps(), None);
    chip.step(1);
    assert_eq!(steps.steps(), Some(1));
}

#[test]
fn the_filters_of_both_lines_give_the_stated_rate() {
    let chip = healthy();
    let _wired = wired(&chip);
    let filters = chip.timers.step_filters(&chip.clocks);
    assert!((filters[0] - filters[1]).abs() < 1e-12, "one line is later");
    assert!((max_step_rate::<Family>() - 0.5 / filters[0]).abs() < 1.0);
    const { assert!(max_step_rate::<Family>() > 3e6) };
}
