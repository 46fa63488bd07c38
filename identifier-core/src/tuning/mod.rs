//! Gains from an identified servo, and their predicted performance.
//!
//! A bandwidth gives the gains by pole placement. They are allowed or refused by noise and
//! largest command in closed form, and by the exact frequency response of the sampled loop with all its delay,
//! for the identified servo and the corners of its confidence ellipsoid, and, where a response was measured, for servos
//! with its resonance, on each of its lines and with a resonance that these show between them. The largest allowed
//! bandwidth is found by bisection. The promise of the gains is the simulated behaviour of the same sampled loop.
//!
//! ```text
//! goal ─► placement ─► margins of every possible servo ─► prediction ─► tuning
//!             ▲                  │
//!             └──── search ◄─────┘
//! ```

mod closed_loop;
mod goal;
mod lead;
mod margins;
mod measured_line;
mod modal_motion;
mod placement;
mod possible_servos;
mod prediction;
mod promise;
mod resonance;
mod response_time;
mod sampled_mode;
mod sampled_response;
mod search;
mod settings;
mod step_measure;
mod tuner;
mod unseen_resonance;

pub use closed_loop::PredictedSample;
pub use goal::{Cap, Goal};
pub use measured_line::MeasuredLine;
pub use possible_servos::PossibleServo;
pub use promise::{Promise, Tuning};
pub use resonance::{Mode, Resonance};
pub use sampled_response::SampledServo;
pub use settings::{TuningError, TuningSettings};
pub use step_measure::StepMeasure;
pub use tuner::{Tuner, TunerState};
