//! Gains from identified servos, and what they promise.

mod closed_forms;
mod feed_forward;
mod properties;
mod support;
