//! The manual says of every fault what the drive says.

use drive_link::Fault;

#[test]
fn every_fault_stands_in_the_manual() {
    let manual = include_str!("../../../firmware-stm32/README.md");
    for fault in Fault::ALL {
        let row = format!(
            "| {} | {} | {} |",
            fault.number(),
            fault.cause(),
            fault.remedy()
        );
        assert!(manual.contains(&row), "missing: {row}");
    }
}
