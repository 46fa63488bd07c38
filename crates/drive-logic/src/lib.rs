//! Everything of a drive that needs no pin, so that all of it runs and is tested on a PC.
//!
//! Two halves and a queue each way between them. The *interrupt* half, [`Sampler`], owns the servo:
//! it measures, controls, learns, watches and never waits. The *background* half, [`Supervisor`],
//! owns everything slow: it takes requests, builds loops, converts to SI, reports and keeps
//! records. What the firmware adds is pins.
//!
//! ```text
//!   requests ──► Supervisor ──► orders ──► Sampler ──► actuator
//!   reports  ◄──     │      ◄── events ◄──    │    ◄── sensor, lines
//!                    ▼
//!                  Store
//! ```
#![no_std]
#![forbid(unsafe_code)]
#![deny(missing_docs)]

mod background_alive;
mod channel;
mod chip;
mod closed_loop;
mod commissioning;
mod conversation;
mod ending;
mod first_fit;
mod fixed_loop;
mod held;
mod line_watch;
mod memory;
mod messages;
mod parts;
mod protection;
mod reference;
mod rest;
mod run;
mod sampler;
mod self_test;
mod silence;
mod spare;
mod store;
mod studying;
mod supervisor;
mod time;
mod watch;

pub use channel::{BackgroundEnd, Channel, InterruptEnd};
pub use chip::{Chip, Lines, Stage};
pub use conversation::Conversation;
pub use memory::Memory;
pub use sampler::Sampler;
pub use self_test::self_test;
pub use store::{Store, StoreError};
pub use supervisor::Supervisor;
