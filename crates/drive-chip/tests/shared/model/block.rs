//! A peripheral's registers in memory, read through the vendor's description of their bits.

use std::cell::Cell;
use std::ops::Deref;

/// The registers of one peripheral.
pub(crate) struct Block<T> {
    base: u32,
    registers: Box<Padded<T>>,
}

/// A last register of half a word takes a whole one.
#[repr(C)]
struct Padded<T>(T, u32);

impl<T> Block<T> {
    /// All zero, at an address of the vendor's description.
    pub(crate) fn at(place: *const T) -> Self {
        Self {
            base: place.addr() as u32,
            // SAFETY: a register block is plain words, for which zero is a value.
            registers: unsafe { Box::<Padded<T>>::new_zeroed().assume_init() },
        }
    }

    fn cells(&self) -> &[Cell<u32>] {
        let first = std::ptr::from_ref(&*self.registers).cast();
        // SAFETY: a register block is cells of words, which are read and written through them only.
        unsafe { std::slice::from_raw_parts(first, size_of::<T>().div_ceil(4)) }
    }

    /// The word at an address, if it is one of this peripheral.
    pub(crate) fn word(&self, address: u32) -> Option<&Cell<u32>> {
        let offset = address.checked_sub(self.base)? as usize;
        self.cells().get(offset / 4)
    }

    /// The address of a register of this block.
    pub(crate) fn address<R>(&self, register: &R) -> u32 {
        let start = std::ptr::from_ref(&*self.registers).addr();
        self.base + (std::ptr::from_ref(register).addr() - start) as u32
    }

    /// Writes a register of this block.
    pub(crate) fn set<R>(&self, register: &R, word: u32) {
        if let Some(cell) = self.word(self.address(register)) {
            cell.set(word);
        }
    }

    /// Reads a register of this block.
    pub(crate) fn get<R>(&self, register: &R) -> u32 {
        self.word(self.address(register)).map_or(0, Cell::get)
    }

    /// Writes zeros.
    pub(crate) fn clear(&self) {
        for cell in self.cells() {
            cell.set(0);
        }
    }
}

impl<T> Deref for Block<T> {
    type Target = T;

    fn deref(&self) -> &T {
        &self.registers.0
    }
}
