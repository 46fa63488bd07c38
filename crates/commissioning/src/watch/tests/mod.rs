//! Faults are found in the stated time by the right number, without false alarms.

mod faulty;
mod healthy;
mod stated;
mod support;
