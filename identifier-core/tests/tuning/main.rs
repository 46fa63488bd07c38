//! Gains from identified servos, and their promise.

mod closed_forms;
mod feed_forward;
mod properties;
mod support;
mod two_masses;
