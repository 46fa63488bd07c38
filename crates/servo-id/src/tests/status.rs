use drive_link::{BootChecks, Home, Kept, Noticed, State, Status};

/// A status of a state, and nothing else.
pub(crate) fn status(state: State) -> Status {
    Status {
        state,
        order: 0,
        kept: Kept::Nothing,
        simulated: false,
        configured: true,
        ended: None,
        commissioning: None,
        gains: None,
        command_delay: 0.0,
        home: Home::Unknown,
        index_from_edge: None,
        estimates: None,
        rejection_reason: None,
        noise: None,
        servo_change: None,
        noticed: Noticed::default(),
        overruns: 0,
        dropped: 0,
        garbled: 0,
        boot: BootChecks::PASSED,
        disturbed: 0,
        interrupt_cycles: None,
    }
}
