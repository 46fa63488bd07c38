//! Rules for the source itself.

mod lines;
mod modules;
mod public_items;
mod rust;
