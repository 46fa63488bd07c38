//! Everything of a drive that needs no pin, so that all of it runs and is tested on a PC.
//!
//! Two halves and a queue each way between them, and a listener. The *interrupt* half, [`Sampler`], owns the servo:
//! it measures, controls, learns, protects and never waits. The *background* half, [`Supervisor`],
//! owns everything slow: it takes requests, builds loops, converts to SI, reports and keeps
//! records. The *listener*, [`LineListener`], hears stops in the bytes of the line, whatever the
//! background does. The firmware adds the pins.
//!
//! ```text
//!   requests ──► Supervisor ──► orders ──► Sampler ──► actuator
//!   reports  ◄──     │      ◄── events ◄──    │    ◄── sensor, lines
//!                    ▼
//!                  Store
//! ```
//!
//! A servo is driven by one *mode* at a time: a run, which controls and identifies, or a commissioning. The supervisor
//! builds it and lends it to the sampler, which returns it at its end. The loop of a run is computed in single precision.
#![no_std]
#![forbid(unsafe_code)]
#![deny(missing_docs)]

mod background_watch;
mod brake;
mod built;
mod channel;
mod chip;
mod closed_loop;
mod commissioning;
mod conversation;
mod conversion;
mod ending;
mod first_motion;
mod guide;
mod homing;
mod image;
mod index_watch;
mod limits;
mod listener;
mod messages;
mod outside;
mod paced_watch;
mod protection;
mod reference;
mod run;
mod sampler;
mod self_test;
mod store;
mod supervisor;
mod telemetry;
mod time;

pub use channel::{BackgroundEnd, Channel, InterruptEnd, LineEnd};
pub use chip::{Chip, Lines, OutputStage};
pub use conversation::Conversation;
pub use image::{UNSEALED, check_image, seal};
pub use listener::{LineListener, PolledLine};
pub use run::{MIN_SAMPLE_TIME, MIN_SAMPLE_TIME_WITH_TERMS};
pub use sampler::Sampler;
pub use self_test::{BOARD_TEST_INSTRUCTIONS, self_test};
pub use store::{Store, StoreError};
pub use supervisor::{Memory, Records, Supervisor};
