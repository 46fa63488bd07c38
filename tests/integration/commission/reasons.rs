//! The tables of the pages are the core's catalogue.

use identifier_core::reason::Reason;

const CATALOGUE: &str = include_str!("../../../docs/reasons.md");
const MANUAL: &str = include_str!("../../../firmware-stm32/README.md");

/// The rows of the first table below a heading.
fn table_below<'a>(page: &'a str, heading: &str) -> Vec<&'a str> {
    page.lines()
        .skip_while(|line| *line != heading)
        .skip_while(|line| !line.starts_with('|'))
        .skip(2)
        .take_while(|line| line.starts_with('|'))
        .collect()
}

#[test]
fn the_page_has_every_reason_as_the_core_has_it() {
    let rows = Reason::ALL.iter().map(|reason| {
        let (number, name) = (reason.number(), reason.name());
        let (cause, remedy) = (reason.cause(), reason.remedy());
        format!("| {number} | `{name}` | {cause} | {remedy} |")
    });
    let rows: Vec<String> = rows.collect();
    assert_eq!(table_below(CATALOGUE, "## The catalogue"), rows);
}

#[test]
fn the_drive_s_manual_has_every_fault_as_the_core_has_it() {
    let faults = Reason::ALL.iter().filter(|reason| reason.is_fault());
    let rows = faults.map(|fault| {
        let (cause, remedy) = (fault.cause(), fault.remedy());
        format!("| {} | {cause} | {remedy} |", fault.number())
    });
    let rows: Vec<String> = rows.collect();
    assert_eq!(table_below(MANUAL, "## Faults"), rows);
}
