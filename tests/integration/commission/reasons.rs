//! The page's table of reasons is the core's.

use identifier_core::commission::StopReason;

const PAGE: &str = include_str!("../../../docs/commissioning.md");

#[test]
fn the_page_has_every_reason_as_the_core_tells_it() {
    let rows: Vec<&str> = PAGE
        .lines()
        .skip_while(|line| !line.starts_with("## Why it ended"))
        .take_while(|line| !line.starts_with("## What it is worth"))
        .filter(|line| line.starts_with("| 1"))
        .collect();
    let told: Vec<String> = StopReason::ALL
        .into_iter()
        .map(|reason| {
            format!(
                "| {} | `{}` | {} | {} |",
                reason.number(),
                reason.name(),
                reason.cause(),
                reason.remedy()
            )
        })
        .collect();
    assert_eq!(rows, told);
}
