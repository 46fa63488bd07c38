//! A commissioning: its two halves, the messages between them, and the parts of each.

mod acting_share;
mod conservative_pid;
mod corrected;
mod error;
mod fit;
mod frequency_response;
mod gains;
mod governor;
mod half_cycles;
mod holding;
mod isr;
mod least_motion;
mod limits;
mod message;
mod noise;
mod phase;
mod probing;
mod regression;
mod response;
mod rough_model;
mod settings;
mod solver;
mod standing;
mod state;
mod synchronous;
#[cfg(test)]
mod tests;
mod trial;

pub use error::CommissionError;
pub(crate) use fit::{FittedServo, MotionRecord, ServoFit, ServoFitter};
pub use gains::HoldingGains;
pub use isr::{CommissionInputs, CommissionIsr, CommissionStep};
pub use limits::Limits;
pub use message::{Decision, RecordEvent};
pub use phase::Phase;
pub use probing::{CommandRamp, LargestMotion};
pub(crate) use probing::{Probing, ProbingState};
pub(crate) use rough_model::RoughModel;
pub use settings::CommissionSettings;
pub use solver::CommissionSolver;
pub use state::CommissionState;
pub use synchronous::{CommissionReading, SynchronousCommission};
pub use trial::TrialResult;
