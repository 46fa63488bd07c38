//! Transfers values that are made in `main` to an interrupt.

use core::cell::Cell;

use cortex_m::interrupt::{Mutex, free};

/// A value on its way, once.
pub struct HandOff<T>(Mutex<Cell<Option<T>>>);

impl<T> HandOff<T> {
    /// Empty.
    #[must_use]
    pub const fn new() -> Self {
        Self(Mutex::new(Cell::new(None)))
    }

    /// Hands it over.
    pub fn give(&self, thing: T) {
        free(|section| self.0.borrow(section).set(Some(thing)));
    }

    /// Takes it, if it is there.
    pub fn take(&self) -> Option<T> {
        free(|section| self.0.borrow(section).take())
    }
}

impl<T> Default for HandOff<T> {
    fn default() -> Self {
        Self::new()
    }
}
