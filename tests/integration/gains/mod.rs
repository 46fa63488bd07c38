//! Gains against the servo that they are for: the [exact loop](integration_tests::exact_loop) shares no code with the tuner.

mod campaign;
mod from_log;
mod resonances;
