//! The programs of the README and of `docs/core.md`, on simulated servos, and that the pages show them.

mod board;
mod declared_amplifier;
mod log;
mod own_controller;
mod own_set;
mod pid_and_gradient;
#[cfg(feature = "fixed")]
mod without_fpu;

use board::Board;
use identifier_core::Settings;
use identifier_core::identifier::Identify;
use identifier_core::parameters::{ServoParameters, Term, Unknown};

const TRUTH: ServoParameters = ServoParameters::new(2.0, 257.7, 10.0, 20.0);

#[track_caller]
fn assert_within(found: f64, truth: f64, part: f64) {
    assert!((found / truth - 1.0).abs() < part, "{found} for {truth}");
}

#[test]
fn pid_and_gradient() {
    let found = pid_and_gradient::run(&mut Board::new(&TRUTH, 60_000)).expect("certified");
    assert_within(found.expect("an estimate").b, TRUTH.b, 0.01);
}

#[test]
fn own_controller() {
    let found = own_controller::run(&mut Board::new(&TRUTH, 20)).expect("valid");
    assert!(found.is_none(), "{found:?}");
    let found = own_controller::run(&mut Board::new(&TRUTH, 20_000)).expect("valid");
    assert_within(found.expect("a fit").b, TRUTH.b, 0.002);
}

#[cfg(feature = "fixed")]
#[test]
fn without_fpu() {
    let truth = ServoParameters {
        coulomb: 0.0,
        ..TRUTH
    };
    let found = without_fpu::run(&mut Board::new(&truth, 60_000)).expect("it fits");
    assert_within(found.expect("an estimate").b, truth.b, 0.01);
}

#[test]
fn log() {
    let resolution = 1e-6;
    let mut board = Board::new(&TRUTH, 3000);
    let mut log = Vec::new();
    while board.waits_for_sample() {
        let command = board.cascade();
        log.push((board.position() as f32, command));
        board.output(command);
    }
    let settings = Settings {
        resolution,
        ..Settings::new(1e-3, 1.0)
    };
    let identifier = settings.build().expect("valid");
    let found = log::identify(&identifier, resolution as f32, &log).expect("possible");
    let found = found.expect("a fit");
    assert_within(found.b, TRUTH.b, 0.002);
    assert_within(found.coulomb, TRUTH.coulomb, 0.01);
    assert_within(found.load, TRUTH.load, 0.01);
}

#[test]
fn own_set() {
    let identifier = own_set::build().expect("valid");
    let mut state = identifier.start();
    let truth = ServoParameters { load: 0.0, ..TRUTH };
    let mut board = Board::new(&truth, 20_000);
    let (mut before, mut last) = ([0.0_f32; 2], 0);
    while board.waits_for_sample() {
        let (count, command) = (board.count(), board.cascade());
        let moved = count - last;
        last = count;
        board.output(before[1]);
        before = [command, before[0]];
        identifier
            .process(&mut state, moved, command)
            .expect("possible");
        identifier.work(&mut state, 1000);
    }
    assert!(identifier.report(&state).entered.has(Term::Delay));
    let delay = identifier.value_in(&identifier.snapshot(&state), Unknown::Delay);
    assert_within(delay.expect("in the set"), 2e-3, 0.01);
    assert_within(
        identifier.estimates(&state).expect("a fit").b,
        truth.b,
        0.005,
    );
}

#[test]
fn declared_amplifier() {
    let built = declared_amplifier::build().expect("valid");
    let (amplifier, identifier) = &built;
    let mut state = (amplifier.start(), identifier.start());
    let mut board = Board::new(&TRUTH, 20_000);
    let mut last = 0;
    let mut before = [0.0_f32; 2];
    while board.waits_for_sample() {
        let (count, command) = (board.count(), board.cascade());
        let dead = command - command.clamp(-0.02, 0.02);
        declared_amplifier::sample(&built, &mut state, count - last, command).expect("possible");
        last = count;
        board.output(before[0]);
        before = [before[1], dead];
        identifier.work(&mut state.1, 1000);
    }
    let found = identifier.estimates(&state.1).expect("a fit");
    assert_within(found.b, TRUTH.b, 0.01);
}

#[test]
fn the_programs_are_those_of_the_pages() {
    let readme = include_str!("../../README.md");
    let page = include_str!("../../../docs/core.md");
    for (page, program) in [
        (readme, include_str!("pid_and_gradient.rs")),
        (readme, include_str!("own_controller.rs")),
        (readme, include_str!("without_fpu.rs")),
        (page, include_str!("log.rs")),
        (page, include_str!("own_set.rs")),
        (page, include_str!("declared_amplifier.rs")),
    ] {
        let shown = program
            .replace("use super::board::Board;\n", "")
            .replace("pub(super) ", "");
        let block = format!("```rust,ignore\n{shown}```\n");
        assert!(page.contains(&block), "not on its page:\n{shown}");
    }
}
