//! Faults are found in the stated time by the right number, and nothing else is.

mod faulty;
mod healthy;
mod stated;
mod support;
