use super::board::Board;
use fixed::types::I16F16;
use identifier_core::fixed_point::{FixedLoop, FixedLoopState};
use identifier_core::measurement::Counter;
use identifier_core::parameters::ServoParameters;
use identifier_core::settings::SettingsError;
use identifier_core::{AB, Settings};

pub(super) fn run(board: &mut Board) -> Result<Option<ServoParameters>, SettingsError> {
    let servo_loop: FixedLoop<AB> = Settings::new(1e-3, 10_000.0)
        .with_pid(9.0, 0.19, 4.0, 2.0)
        .with_servo_range([0.0, 50.0], [110.0, 1000.0])
        .build()?;
    let mut state: FixedLoopState<AB> = servo_loop.start(0);
    let mut encoder = Counter::new(board.encoder());
    while board.waits_for_sample() {
        let count = encoder.read(board.encoder());
        match servo_loop.process(&mut state, board.setpoint(), I16F16::ZERO, count) {
            Ok(step) => board.output(servo_loop.controller().command(step.control.command) as f32),
            Err(_) => board.disable(),
        }
        servo_loop.work(&mut state, 1);
    }
    Ok(servo_loop.estimates(&state))
}
