//! Rules for the source itself.

mod modules;
mod public_items;
mod rust;
