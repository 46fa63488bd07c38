//! sin Nq and cos Nq of a sample, of all orders that the columns of a pass have.

use super::{Column, Effect};

/// The waves of a sample up to the highest order of some columns.
pub(super) struct Waves {
    table: [[f64; 2]; Self::ORDERS],
    /// Orders in the table.
    count: usize,
}

impl Waves {
    /// Orders from zero that have a place: those of usual motors. A column of a higher one is rare.
    const ORDERS: usize = 41;

    /// For some columns.
    pub(super) fn new(columns: &[Column]) -> Self {
        let orders = columns.iter().filter(|column| is_wave(column.effect));
        let highest = orders.fold(0.0, |most, column| f64::max(most, column.setting));
        Self {
            table: [[0.0, 1.0]; Self::ORDERS],
            count: (highest as usize + 1).min(Self::ORDERS),
        }
    }

    /// The waves at an angle with this sine and cosine.
    #[inline]
    pub(super) fn place(&mut self, [sine, cosine]: [f64; 2]) {
        let mut before = [0.0, 1.0];
        for wave in self.table.iter_mut().take(self.count).skip(1) {
            let [s, c] = before;
            before = [s * cosine + c * sine, c * cosine - s * sine];
            *wave = before;
        }
    }

    /// The wave of an order; none of one without a place.
    #[inline]
    pub(super) fn get(&self, order: f64) -> Option<[f64; 2]> {
        let order = order as usize;
        self.table
            .get(order)
            .copied()
            .filter(|_| order < self.count)
    }
}

const fn is_wave(effect: Effect) -> bool {
    matches!(
        effect,
        Effect::RippleSine
            | Effect::RippleCosine
            | Effect::TorqueRippleSine
            | Effect::TorqueRippleCosine
            | Effect::InertiaSine
            | Effect::InertiaCosine
    )
}
