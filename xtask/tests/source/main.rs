//! What the source itself must keep to.

mod modules;
mod rust;
