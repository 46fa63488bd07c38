//! Rules for the source itself.

mod modules;
mod rust;
