//! sin Nq and cos Nq of a sample, of all orders that the columns of a pass have.

use super::{Column, Effect};

/// The waves of a sample up to the highest order of some columns.
pub(super) struct Waves {
    table: [[f64; 2]; Self::ORDERS],
    /// Orders in the table.
    count: usize,
}

impl Waves {
    /// Orders from zero that have a place. A column of a higher one is rare.
    const ORDERS: usize = Effect::MAX_ORDER as usize + 1;

    /// For some columns.
    pub(super) fn new(columns: &[Column]) -> Self {
        let orders = columns.iter().filter(|column| column.effect.is_wave());
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn waves_are_sine_and_cosine_of_their_orders_up_to_the_highest_of_a_column() {
        let column = |effect, setting| Column { effect, setting };
        let highest = column(Effect::RippleCosine, 40.0);
        let mut waves = Waves::new(&[column(Effect::RippleSine, 3.0), highest]);
        for angle in [-2.9_f64, -0.4, 0.0, 0.7, 3.1] {
            waves.place([angle.sin(), angle.cos()]);
            for order in 0..=40 {
                let order = f64::from(order);
                let [sine, cosine] = waves.get(order).expect("an order of the table");
                assert!((sine - (order * angle).sin()).abs() < 1e-12, "{order}");
                assert!((cosine - (order * angle).cos()).abs() < 1e-12, "{order}");
            }
            assert!(waves.get(41.0).is_none());
        }
        assert!(Waves::new(&[highest]).get(40.0).is_some());
        let other = [column(Effect::InertiaSine, 2.0), Effect::A.into()];
        assert!(Waves::new(&other).get(3.0).is_none());
        // One without a place is computed by the record.
        let rare = [column(Effect::TorqueRippleSine, 300.0)];
        assert!(Waves::new(&rare).get(300.0).is_none());
    }
}
