//! The native part of the Python package `servo_id`. It takes scenarios as text and columns of numbers, and returns
//! results as JSON and columns. The package's Python half gives them names, types and pictures.
//!
//! A call releases Python's global lock while it computes. A fault of the caller's is a `ValueError` with the remedy.

mod columns;
mod commission;
mod export;
mod fault;
mod identify;
mod online;
mod origin;
mod picture;
mod predict;
mod simulate;
mod simulated_servo;
mod sweep;
mod tune;

#[pyo3::pymodule]
mod _native {
    #[pymodule_export]
    use super::commission::commission;
    #[pymodule_export]
    use super::export::export;
    #[pymodule_export]
    use super::identify::{identify_log, page, read_log, reading, recognise_log};
    #[pymodule_export]
    use super::online::Online;
    #[pymodule_export]
    use super::predict::predict;
    #[pymodule_export]
    use super::simulate::simulate;
    #[pymodule_export]
    use super::simulated_servo::SimulatedServo;
    #[pymodule_export]
    use super::sweep::sweep;
    #[pymodule_export]
    use super::tune::tune;

    #[pymodule_export]
    const VERSION: &str = servo_id::VERSION;
    #[pymodule_export]
    const LOG_OPTIONS: &[(&str, &str)] = identifier_log::recognise::LogOptions::HELP;
    #[pymodule_export]
    const CONDITIONS: &[(&str, &str)] = identifier_log::tune::Conditions::HELP;
}
