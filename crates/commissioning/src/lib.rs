#![doc = include_str!("../README.md")]
#![no_std]
#![forbid(unsafe_code)]
#![deny(missing_docs)]

#[cfg(test)]
#[macro_use]
extern crate std;

mod commission;
pub mod servo_change;
pub mod watch;

pub use commission::{
    CommandRamp, CommissionError, CommissionInputs, CommissionIsr, CommissionReading,
    CommissionSettings, CommissionSolver, CommissionState, CommissionStep, Decision, HoldingGains,
    LargestMotion, Limits, Phase, RecordEvent, SynchronousCommission, TrialResult,
};
