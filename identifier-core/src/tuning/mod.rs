//! Gains from an identified servo, and their predicted performance.
//!
//! A bandwidth gives the gains by pole placement. Noise and largest command limit them in closed form. The exact
//! frequency response of the sampled loop, with all its delay, limits them too. It is computed for the identified servo
//! and for the corners of its confidence ellipsoid. A measured response limits them further. The limits hold on each of
//! its lines, for servos with its resonance, and for a resonance that the lines show between them. The largest allowed
//! bandwidth is found by bisection. The predicted response is the simulated one of the same sampled loop.
//!
//! ```text
//! goal ─► placement ─► margins of every possible servo ─► prediction ─► tuning
//!             ▲                  │
//!             └──── search ◄─────┘
//! ```

mod axis_forces;
mod closed_loop;
mod feed_forward_limits;
mod goal;
mod hidden_resonance;
mod margins;
mod measured_line;
mod modal_motion;
mod placement;
mod possible_servos;
mod predicted_response;
mod prediction;
mod resonance;
mod response_time;
mod sampled_mode;
mod sampled_response;
mod search;
mod settings;
mod shown;
mod step_measure;
mod tuner;
mod unseen_resonance;

pub use axis_forces::AxisForces;
pub use closed_loop::PredictedSample;
pub use goal::{Cap, Goal};
pub use measured_line::MeasuredLine;
pub use possible_servos::PossibleServo;
pub use predicted_response::{PredictedResponse, Tuning};
pub use resonance::{Mode, Resonance};
pub use sampled_response::SampledServo;
pub use settings::{EncoderSide, TuningError, TuningSettings};
pub use shown::{HiddenMode, Shown};
pub use step_measure::StepMeasure;
pub use tuner::{Tuner, TunerState};
