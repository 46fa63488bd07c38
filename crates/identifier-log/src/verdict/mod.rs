//! The verdict on estimates: their reliability by the evidence, and otherwise the reason and a remedy.
//!
//! The truth plays no part in it: a drive does not know it either. Nor does the initial guess: the
//! same evidence leads to the same verdict wherever the estimates began.
//!
//! ```
//! use identifier_log::verdict::{Evidence, Motion, Status, UnknownEvidence, Verdict};
//! use identifier_core::parameters::Unknown;
//!
//! let motion = Motion { samples: 60_000, counts_travelled: 4e5 };
//! let mut evidence = Evidence::from_motion(motion);
//! let gain = UnknownEvidence { estimate: 257.7, std_error: Some(0.01), ..UnknownEvidence::at(257.7) };
//! evidence.add(Unknown::B, gain);
//! assert_eq!(Verdict::on(&evidence).status, Status::Converged);
//!
//! // Nothing that moved b was in the data.
//! evidence.add(Unknown::B, UnknownEvidence { std_error: Some(40.0), ..gain });
//! assert_eq!(Verdict::on(&evidence).status, Status::NoInformation);
//! ```

mod evidence;
mod reason;
mod rules;

pub use evidence::{Evidence, FitEvidence, MissingEffect, Motion, Residual, UnknownEvidence};
pub use log_fit::Cause;
pub use reason::VerdictReason;
pub use rules::{MIN_TRAVEL_COUNTS, State, Status, Verdict};
