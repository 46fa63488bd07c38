//! The monitor's whole screens. `INSTA_UPDATE=always cargo test -p servo-id
//! --test program monitor_view::` accepts a change; look at it first.

use std::time::Instant;

use crate::support::simulated_drive::{SERVO, built_in};
use crate::support::status::status;
use commissioning::Phase;
use drive_link::{
    Ended, Estimates, Estimator, Fault, Progress, Report, Snapshot, State as Does, Status,
};
use identifier_core::parameters::ServoParameters;
use ratatui::Terminal;
use ratatui::backend::TestBackend;
use servo_id::monitor::{Dialogue, MIN_SIZE, Note, Shown, State, draw};
use virtual_servo::{Encoder, Plant};

const SAMPLE_TIME: f64 = 1e-3;
const COUNTS: f64 = 10_000.0;

fn stands(state: &mut State, status: Status) {
    state.take(&Report::Status { id: None, status }, Instant::now());
}

fn disabled() -> State {
    let port = "tcp:127.0.0.1:5760";
    State::new(
        port,
        built_in(Estimator::GaussNewton),
        status(Does::Disabled),
        1,
        Instant::now(),
    )
}

/// Moves a servo to and fro for `samples`, of which some are lost on the way to the host.
fn running(samples: u32, is_lost: fn(u32) -> bool) -> State {
    let mut state = disabled();
    stands(&mut state, status(Does::Running));
    let mut plant = Plant::at_rest(&SERVO, SAMPLE_TIME);
    let encoder = Encoder::new(COUNTS);
    let resolution = built_in(Estimator::GaussNewton).closed_loop.core.resolution;
    for sample in 1..=samples {
        let reference = match (sample / 400) % 4 {
            1 => 0.25,
            2 => 0.5,
            _ => 0.0,
        };
        let position = encoder.read(plant.position) as f64 * resolution;
        let command = (9.0 * (reference - position) - 0.19 * plant.velocity).clamp(-10.0, 10.0);
        let snapshot = Snapshot {
            sample,
            reference: reference as f32,
            position: position as f32,
            command: command as f32,
            output_error: (position - plant.position) as f32,
            estimates: Estimates {
                servo: ServoParameters {
                    a: 0.2181,
                    b: 257.71,
                    coulomb: 4.998,
                    load: -0.0012,
                },
                ..Estimates::default()
            },
        };
        if !is_lost(sample) {
            state.take(&Report::Snapshot(snapshot), Instant::now());
        }
        plant.advance(f64::from(snapshot.command));
    }
    state
}

fn shown<'a>(state: &'a State, dialogue: &'a Dialogue) -> Shown<'a> {
    Shown {
        state,
        dialogue,
        recording: None,
        commission: None,
        leaves: false,
    }
}

fn screen(width: u16, height: u16, shown: &Shown<'_>) -> String {
    let mut terminal = Terminal::new(TestBackend::new(width, height)).expect("a screen in memory");
    terminal
        .draw(|frame| draw(frame, shown))
        .expect("it takes every drawing");
    terminal.backend().to_string()
}

fn least(shown: &Shown<'_>) -> String {
    screen(MIN_SIZE.width, MIN_SIZE.height, shown)
}

#[test]
fn a_released_drive() {
    insta::assert_snapshot!(least(&shown(&disabled(), &Dialogue::Idle)));
}

#[test]
fn a_screen_that_is_too_small_says_what_it_needs_and_how_to_stop() {
    let state = running(10, |_| false);
    let text = screen(
        MIN_SIZE.width - 1,
        MIN_SIZE.height,
        &shown(&state, &Dialogue::Idle),
    );
    assert!(
        text.contains("80 x 24") && text.contains("Space stops it"),
        "{text}"
    );
}

#[test]
fn a_running_drive_on_the_smallest_screen() {
    let screen = least(&shown(&running(9000, |_| false), &Dialogue::Idle));
    insta::assert_snapshot!(screen);
    // The manual shows it.
    let manual = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/monitor.md");
    let manual = std::fs::read_to_string(manual).expect("readable");
    for row in screen.lines() {
        let row = row.trim_matches('"').trim_end();
        assert!(manual.lines().any(|line| line == row), "not there: {row}");
    }
}

#[test]
fn lost_frames_are_counted() {
    let some: fn(u32) -> bool = |sample| (1500..1507).contains(&sample);
    for is_lost in [|_| false, some] {
        let text = least(&shown(&running(3000, is_lost), &Dialogue::Idle));
        assert_eq!(text.contains("7 LOST"), is_lost(1500), "{text}");
    }
}

#[test]
fn a_command_at_its_limit_is_marked() {
    let mut state = running(100, |_| false);
    let snapshot = Snapshot {
        sample: 101,
        reference: 0.0,
        position: 0.0,
        command: -10.0,
        output_error: 0.0,
        estimates: Estimates::default(),
    };
    state.take(&Report::Snapshot(snapshot), Instant::now());
    let screen = least(&shown(&state, &Dialogue::Idle));
    assert!(screen.contains("-10.0000 AT LIMIT"), "{screen}");
}

#[test]
fn a_commissioning() {
    let mut state = disabled();
    stands(&mut state, status(Does::Commissioning));
    for sample in 1..=400_u16 {
        let time = f64::from(sample) * SAMPLE_TIME;
        let progress = Progress {
            phase: Phase::Probe,
            sample: sample.into(),
            position: (0.1 * time) as f32,
            command: (sample < 300).then_some(0.5),
            recorded: sample / 16,
            gain: (sample > 200).then_some([257.1, 0.4]),
        };
        state.take(&Report::Progress(progress), Instant::now());
    }
    insta::assert_snapshot!(least(&shown(&state, &Dialogue::Idle)));
}

#[test]
fn a_fault_with_its_remedy() {
    let mut state = running(500, |_| false);
    let fault = Fault::EncoderSilent;
    let status = Status {
        ended: Some(Ended::Faulted(fault)),
        ..status(Does::Faulted(fault))
    };
    stands(&mut state, status);
    state.set_note(Note::Failed("the drive refuses: it is a fault".to_owned()));
    insta::assert_snapshot!(least(&shown(&state, &Dialogue::Idle)));
}
