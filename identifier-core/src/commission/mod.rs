//! Commissioning: a drive that comes to know its servo in a moment, tunes itself to a promise, proves the
//! promise on the machine, and goes back to what worked when anything is wrong.
//!
//! ```text
//! idle ─► released check ─► wiggle ─► fit ─► refine ─► verify ─► tune ─► trial ─► applied
//!                │             │       │        │         │        │       │
//!                └─────────────┴───────┴────────┴─────────┴────────┴───────┴─► aborted, rolled back
//! ```
//!
//! It has two halves, and data goes one way round. [`Commission`], in the sample interrupt, takes a count and
//! gives a command; it moves the servo, watches over it and never
//! waits. [`Study`], in the background, fits, verifies and tunes in slices. What one tells the other is a
//! [`Finding`] or an [`Answer`]: plain values that a caller carries across, through a queue on the chip and by
//! hand in a simulator. A commissioning whose study gets the same slices in the same samples is the same to
//! the bit wherever it runs.

mod crude;
mod error;
mod fit;
mod gains;
mod holding;
mod machine;
mod message;
mod phase;
mod regression;
mod servo;
mod settings;
mod state;
mod stop;
mod study;
mod trial;
mod wiggle;

pub use crude::Crude;
pub use error::CommissionError;
pub use fit::{
    FitSettings, Motion, MotionBlock, MotionRecorder, Predicting, Prediction, ServoFit, ServoFitter,
};
pub use gains::HoldingGains;
pub use machine::{Commission, CommissionStep, Seen};
pub use message::{Answer, Finding};
pub use phase::Phase;
pub use servo::IdentifiedServo;
pub use settings::{CommissionSettings, Limits};
pub use state::CommissionState;
pub use stop::StopReason;
pub use study::Study;
pub use trial::TrialResult;
pub use wiggle::{LargestMotion, Progress, Wiggle, WiggleSettings, WiggleState, WiggleStep};
