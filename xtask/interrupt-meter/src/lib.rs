//! A plugin of QEMU that counts what an interrupt handler takes on a Cortex-M4F: instructions as they
//! are executed, and cycles by the model that `docs/cycles.md` describes.
//!
//! `cargo xtask interrupt` builds it, hands it to the emulator, and reads a line an interrupt from it.
//!
//! | module | concern |
//! |---|---|
//! | `thumb` | what an instruction is, from its bytes |
//! | `processor` | cycles of the core, with its neighbours and the buses |
//! | `flash` | cycles that the flash adds, with its caches |
//! | `meter` | where an interrupt begins and ends, and what of it counts |
//! | `request` | what the plugin is asked for |
//! | `plugin` | the interface of QEMU, and everything unsafe |

mod flash;
mod meter;
// The emulator defines the functions that this declares, so a test could not be linked with it.
#[cfg(not(test))]
mod plugin;
mod processor;
mod request;
mod thumb;
