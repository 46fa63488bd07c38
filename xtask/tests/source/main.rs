//! Rules for the source itself.

mod lines;
mod locks;
mod modules;
mod public_items;
mod rust;
