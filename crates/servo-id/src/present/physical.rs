//! A servo in physical units, and its feed-forward.

use identifier_log::physical::{PhysicalQuantity, VoltageGains};
use identifier_log::result::Summary;

use super::number::{known_to, with_error};
use super::{Block, Column, Table};

/// The tables of a result whose scale of torques, or whose command in V, is stated.
pub(super) fn tables(summary: &Summary) -> impl Iterator<Item = Block> {
    let physical = summary.physical.as_ref().map(|physical| {
        table(
            "In physical units",
            &[
                ("inertia", Some(physical.inertia)),
                ("viscous friction", Some(physical.viscous)),
                ("Coulomb friction", physical.coulomb),
                ("load", physical.load),
                ("torque per command unit", Some(physical.torque_constant)),
            ],
        )
    });
    let gains = summary.voltage_gains.as_ref().map(|gains| {
        let VoltageGains { ks, kv, ka, kg } = *gains;
        table(
            "Feed-forward kS sign(v) + kV v + kA v̇ + kG",
            &[("kS", ks), ("kV", Some(kv)), ("kA", Some(ka)), ("kG", kg)],
        )
    });
    physical.into_iter().chain(gains).map(Block::Table)
}

/// The quantities that there are, a row each.
fn table(caption: &str, quantities: &[(&str, Option<PhysicalQuantity>)]) -> Table {
    let row = |&(name, quantity): &(&str, Option<PhysicalQuantity>)| {
        let PhysicalQuantity {
            value,
            std_error,
            unit,
        } = quantity?;
        // A stated one has no error, and nothing to be known to.
        let known = std_error.map_or_else(String::new, |error| known_to(value, Some(error)));
        Some(vec![
            name.to_owned(),
            with_error(value, std_error),
            unit.to_owned(),
            known,
        ])
    };
    let columns = vec![
        Column::words("quantity"),
        Column::figures("value"),
        Column::words("unit"),
        Column::figures("95 % interval").drop_order(1),
    ];
    Table::new(
        caption,
        columns,
        quantities.iter().filter_map(row).collect(),
    )
}
