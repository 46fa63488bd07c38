//! Gains from identified servos, and their promise.

mod closed_forms;
mod properties;
mod support;
