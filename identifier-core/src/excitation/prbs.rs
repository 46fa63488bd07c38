use super::{Excitation, Hold};
use crate::error::{Allowed, OutOfRange};
use crate::number::Number;
use crate::units::Units;

/// A pseudo-random binary sequence of maximal length, 2ⁿ − 1 bits, between −amplitude and
/// +amplitude.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Prbs<N> {
    amplitude: N,
    hold: u32,
    taps: u32,
}

/// Progress of a [`Prbs`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PrbsState {
    register: u32,
    hold: Hold,
}

/// Galois tap masks of primitive polynomials for 2 to 24 bits. Source: Alfke, "Efficient shift
/// registers, LFSR counters, and long pseudo-random sequence generators", Xilinx XAPP 052, 1996.
const TAPS: [u32; 23] = [
    0x3, 0x6, 0xc, 0x14, 0x30, 0x60, 0xb8, 0x110, 0x240, 0x500, 0xe08, 0x1c80, 0x3802, 0x6000,
    0xd008, 0x12000, 0x20400, 0x72000, 0x90000, 0x14_0000, 0x30_0000, 0x42_0000, 0xe1_0000,
];

impl<N: Number> Prbs<N> {
    /// The fewest and the most bits of the shift register.
    const ORDERS: (u32, u32) = (2, 24);

    /// `amplitude` is in rad. `hold` is the time of a bit, s, a whole number of control samples.
    /// `order` is n, 2 to 24.
    ///
    /// # Errors
    /// The parameter out of its range: `amplitude`, `hold` or `order`.
    pub fn new(units: &Units, amplitude: f64, hold: f64, order: u32) -> Result<Self, OutOfRange> {
        Allowed::Above(0.0).check("amplitude", amplitude)?;
        let (fewest, most) = Self::ORDERS;
        Allowed::Within(f64::from(fewest), f64::from(most)).check("order", f64::from(order))?;
        Ok(Self {
            amplitude: N::from_f64(amplitude * units.position()),
            hold: Hold::steps("hold", hold, units.sample_time())?,
            taps: TAPS[(order - fewest) as usize],
        })
    }
}

impl<N: Number> Excitation<N> for Prbs<N> {
    type State = PrbsState;

    fn start(&self) -> PrbsState {
        PrbsState {
            register: 1,
            hold: Hold::EXPIRED,
        }
    }

    #[inline]
    fn process(&self, state: &mut PrbsState) -> N {
        if state.hold.expires(self.hold) {
            let out = state.register & 1;
            state.register >>= 1;
            if out == 1 {
                state.register ^= self.taps;
            }
        }
        if state.register & 1 == 1 {
            self.amplitude
        } else {
            -self.amplitude
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_order_has_maximal_length_and_balance() {
        let units = Units::new(1e-3, 1.0).expect("valid");
        for order in 2..=24 {
            let prbs = Prbs::<f64>::new(&units, 1.0, 1e-3, order).expect("valid");
            let mut state = prbs.start();
            prbs.process(&mut state);
            let first = state.register;
            let length = (1_u64 << order) - 1;
            let mut period = 0_u64;
            let mut balance = 0.0;
            loop {
                balance += prbs.process(&mut state);
                period += 1;
                if state.register == first {
                    break;
                }
            }
            assert_eq!(period, length, "order {order}");
            // One more high than low.
            assert!((balance - 1.0_f64).abs() < 1e-9, "order {order}");
        }
    }

    #[test]
    fn order_out_of_range_is_refused() {
        let units = Units::new(1e-3, 1.0).expect("valid");
        for order in [0, 1, 25, 99] {
            let error = Prbs::<f32>::new(&units, 1.0, 1e-3, order).expect_err("no such order");
            assert_eq!(error.parameter, "order");
        }
    }
}
