//! The forms in which a result is shown: text on a [`terminal`], a page of HTML ([`html`]), and pictures ([`chart`]).
//!
//! Each reads what [`present`](crate::present) puts together, and computes nothing of the result.

pub mod chart;
pub mod html;
pub mod terminal;
