use super::board::Board;
use identifier_core::measurement::Counter;
use identifier_core::parameters::ServoParameters;
use identifier_core::settings::SettingsError;
use identifier_core::{GradientLoop, GradientLoopState, Settings};

pub(super) fn run(board: &mut Board) -> Result<Option<ServoParameters>, SettingsError> {
    let servo_loop: GradientLoop = Settings::new(1e-3, 10_000.0) // sample time (s), counts per revolution
        .with_pid(9.0, 0.19, 4.0, 2.0) // kp, kd, ki, largest command
        .with_servo_range([0.0, 50.0], [110.0, 1000.0]) // a (1/s), b (rad/s² per command unit)
        .build()?;
    let mut state: GradientLoopState = servo_loop.start(0);
    let mut encoder = Counter::new(board.encoder());
    while board.waits_for_sample() {
        let count = encoder.read(board.encoder());
        match servo_loop.process(&mut state, board.setpoint(), 0.0, count) {
            Ok(step) => board.output(step.control.command),
            Err(_) => board.disable(),
        }
        servo_loop.work(&mut state, 1); // the memory, in the time that is left
    }
    Ok(servo_loop.estimates(&state))
}
