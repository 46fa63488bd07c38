//! Gains from an identified servo, and their predicted performance.
//!
//! A bandwidth gives the gains by pole placement. They are allowed or refused by noise and
//! largest command in closed form, and by the exact frequency response of the sampled loop with all its delay,
//! for the identified servo and the corners of its confidence ellipsoid. The largest allowed
//! bandwidth is found by bisection. The promise of the gains is the simulated behaviour of the same sampled loop.
//!
//! ```text
//! goal ─► placement ─► margins of every possible servo ─► prediction ─► tuning
//!             ▲                  │
//!             └──── search ◄─────┘
//! ```

mod closed_loop;
mod goal;
mod margins;
mod placement;
mod possible_servos;
mod prediction;
mod promise;
mod response_time;
mod sampled_response;
mod search;
mod settings;
mod step_measure;
mod tuner;

pub use closed_loop::PredictedSample;
pub use goal::{Cap, Goal};
pub use promise::{Promise, Tuning};
pub use settings::{TuningError, TuningSettings};
pub use step_measure::StepMeasure;
pub use tuner::{Tuner, TunerState};
