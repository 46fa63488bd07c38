//! Gains from identified servos, and what they promise.

mod closed_forms;
mod properties;
mod support;
