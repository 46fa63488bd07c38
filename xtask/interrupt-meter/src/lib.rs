//! A plugin of QEMU that counts the cost of an interrupt handler on a Cortex-M4F: instructions as they
//! are executed, and cycles by the model of `docs/cycles.md`.
//!
//! `cargo xtask interrupt` builds it, passes it to the emulator, and reads a line per interrupt from it.
//!
//! | module | concern |
//! |---|---|
//! | `processor` | cycles of the core, of neighbouring instructions, and of the buses |
//! | `flash` | cycles that the flash adds, with its caches |
//! | `meter` | beginning and end of an interrupt, and the instructions that count |
//! | `request` | the plugin's arguments |
//! | `plugin` | the interface of QEMU, and everything unsafe |

mod flash;
mod meter;
// The emulator defines the functions that this declares: a test does not link with it.
#[cfg(not(test))]
mod plugin;
mod processor;
mod request;
