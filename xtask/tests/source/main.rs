//! Rules for the source itself.

mod lines;
mod locks;
mod magnitudes;
mod modules;
mod public_items;
mod rust;
mod variants;
