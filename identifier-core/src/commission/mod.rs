//! Commissioning: a drive identifies its axis, tunes its PID to a specification, validates it on the axis, and
//! restores the old gains when anything is wrong.
//!
//! ```text
//! idle ─► released check ─► probing ─► fit ─► refine ─► verify ─► slide ─► tune ─► trial ─► applied
//!                │             │        │        │         │         │        │       │
//!                └─────────────┴────────┴────────┴─────────┴─────────┴────────┴───────┴─► aborted, rolled back
//! ```
//!
//! It has two halves, and data goes one way round. [`CommissionIsr`], in the sample interrupt, takes a count and
//! gives a command; it moves the servo, monitors it and never waits. [`CommissionSolver`], in the background, fits,
//! verifies and tunes in slices. They exchange [`RecordEvent`]s and [`Decision`]s: plain values that a caller carries
//! across, through a queue on the chip and by hand in a simulator. A commissioning whose solver gets the same slices
//! in the same samples is the same to the bit wherever it runs.
//!
//! Both halves in step, here with a motor without friction that an encoder with 10 000 counts watches:
//!
//! ```
//! use identifier_core::commission::{CommissionSettings, SynchronousCommission, Limits, Phase, CommissionInputs};
//! use identifier_core::tuning::Goal;
//!
//! let resolution = core::f64::consts::TAU / 10_000.0;
//! let settings = CommissionSettings {
//!     goal: Goal::ResponseTime(0.03),
//!     ..CommissionSettings::new(1e-3, resolution, Limits::new([-0.3, 0.3], 15.0, [-10.0, 10.0]))
//! };
//! let mut commission = SynchronousCommission::<f32>::new(&settings, None, None).expect("limits that can be kept");
//! let (mut position, mut velocity) = (0.0, 0.0);
//! let mut phase = Phase::Idle;
//! while !phase.is_end() {
//!     let done = commission.sample(&CommissionInputs {
//!         count: Some((position / resolution).floor() as i32),
//!         late: false,
//!         stop: None,
//!     });
//!     phase = done.phase;
//!     // The unknown servo.
//!     let acceleration = 257.7 * done.command.unwrap_or(0.0);
//!     position += velocity * 1e-3 + acceleration * 0.5e-6;
//!     velocity += acceleration * 1e-3;
//! }
//! let state = commission.state().expect("it began");
//! assert_eq!(phase, Phase::Applied, "{:?}", state.reason());
//! let servo = state.servo().expect("it was identified");
//! assert!((servo.parameters.b / 257.7 - 1.0).abs() < 0.01);
//! let rise = state.trial().and_then(|trial| trial.rise_time).expect("it was tried");
//! assert!((rise / 0.03 - 1.0).abs() < 0.15, "{rise}");
//! ```

mod acting_share;
mod conservative_pid;
mod error;
mod fit;
mod gains;
mod holding;
mod isr;
mod message;
mod noise;
mod phase;
mod probing;
mod regression;
mod response;
mod rough_model;
mod settings;
mod sliding;
mod solver;
mod standing;
mod state;
mod swings;
mod synchronous;
#[cfg(test)]
mod tests;
mod trial;

pub(crate) use crate::parameters::IdentifiedServo;
pub use crate::reason::Reason;
pub use error::CommissionError;
pub(crate) use fit::{
    Diagnosis, EffectSearch, FitSettings, MotionRecord, PredictionErrors, PredictionRun, ServoFit,
    ServoFitter,
};
pub use gains::HoldingGains;
pub use isr::{CommissionInputs, CommissionIsr, CommissionStep};
pub use message::{Decision, RecordEvent};
pub use phase::Phase;
pub use probing::LargestMotion;
pub(crate) use probing::{Probing, ProbingProgress, ProbingSettings, ProbingState};
pub(crate) use rough_model::RoughModel;
pub use settings::{CommissionSettings, Limits};
pub use solver::CommissionSolver;
pub use state::CommissionState;
pub use synchronous::{CommissionReading, SynchronousCommission};
pub use trial::TrialResult;
