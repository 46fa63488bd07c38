//! Wrapping hardware counters.

/// The register of a quadrature counter as the hardware gives it.
pub trait CounterRegister: Copy + core::fmt::Debug + PartialEq {
    /// Counts moved since an earlier reading, through any wrap of the register.
    ///
    /// Right as long as the servo moves less than half the register's range between two readings.
    fn moved_since(self, earlier: Self) -> i32;
}

impl CounterRegister for u16 {
    #[inline]
    fn moved_since(self, earlier: Self) -> i32 {
        i32::from(self.wrapping_sub(earlier).cast_signed())
    }
}

impl CounterRegister for u32 {
    #[inline]
    fn moved_since(self, earlier: Self) -> i32 {
        self.wrapping_sub(earlier).cast_signed()
    }
}

/// A count of 32 bits kept over a register of any width. It may wrap any number of times: only
/// differences of counts enter a loop.
///
/// A 32-bit register needs none of this: its value, read as `i32`, is such a count.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Counter<R> {
    register: R,
    count: i32,
}

impl<R: CounterRegister> Counter<R> {
    /// Starts at count zero, whatever the register holds.
    #[must_use]
    pub fn new(register: R) -> Self {
        Self { register, count: 0 }
    }

    /// Takes a reading of the register and returns the counts moved since the last one.
    #[inline]
    pub fn moved(&mut self, register: R) -> i32 {
        let moved = register.moved_since(self.register);
        self.register = register;
        self.count = self.count.wrapping_add(moved);
        moved
    }

    /// Takes a reading of the register and returns the count.
    #[inline]
    pub fn read(&mut self, register: R) -> i32 {
        self.moved(register);
        self.count
    }

    /// The count at which the register has a value, within half of its range from the last reading.
    #[inline]
    #[must_use]
    pub fn at(&self, register: R) -> i32 {
        self.count.wrapping_add(register.moved_since(self.register))
    }

    /// The count at the last reading.
    #[must_use]
    pub fn count(&self) -> i32 {
        self.count
    }
}

#[cfg(test)]
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "the wrap under test"
)]
mod tests {
    use super::Counter;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn sixteen_bits_follow_any_walk(
            start: i64,
            moves in prop::collection::vec(-32_768_i64..32_768, 0..500),
        ) {
            let start = start >> 2;
            let mut counter = Counter::new(start as u16);
            let mut true_count = start;
            for step in moves {
                true_count += step;
                prop_assert_eq!(counter.read(true_count as u16), (true_count - start) as i32);
            }
        }

        #[test]
        fn thirty_two_bits_follow_any_walk(
            start: i64,
            moves in prop::collection::vec(-2_147_483_648_i64..2_147_483_648, 0..500),
        ) {
            let start = start >> 2;
            let mut counter = Counter::new(start as u32);
            let mut true_count = start;
            for step in moves {
                true_count += step;
                prop_assert_eq!(i64::from(counter.moved(true_count as u32)), step);
                prop_assert_eq!(counter.count(), (true_count - start) as i32);
            }
        }
    }
}
