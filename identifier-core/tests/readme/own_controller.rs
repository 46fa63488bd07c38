use super::board::Board;
use identifier_core::identifier::Identify;
use identifier_core::measurement::Counter;
use identifier_core::parameters::{ServoParameters, Tolerance, Unknown};
use identifier_core::settings::SettingsError;
use identifier_core::{GaussNewton, GaussNewtonState, Settings};

pub(super) fn run(board: &mut Board) -> Result<Option<ServoParameters>, SettingsError> {
    let identifier: GaussNewton = Settings::new(1e-3, 10_000.0).build()?;
    let mut state: GaussNewtonState = identifier.start();
    let mut encoder = Counter::new(board.encoder());
    while board.waits_for_sample() {
        let moved = encoder.moved(board.encoder());
        let command = board.cascade(); // your controller, with every limit
        board.output(command);
        if identifier.process(&mut state, moved, command).is_err() {
            board.disable();
        }
        identifier.work(&mut state, 8); // a slice of the first fit, in the time that is left
    }
    let error = identifier.report(&state).standard_error_of(Unknown::B);
    let is_known = |found: &ServoParameters| {
        let limit = Tolerance::STD_ERROR.limit(Unknown::B, found.b, 0.0);
        error.is_some_and(|error| error <= limit)
    };
    Ok(identifier.estimates(&state).filter(is_known))
}
