//! The figures of pages are those that `cargo xtask budget` accepted.

use std::collections::BTreeMap;

use crate::support::pages::root;

/// Rows of docs/cost.md: the beginning, and the keys of the budget in the order of its numbers.
const ROWS: &str = "
gradient, f32, a and b : SAMPLE gradient-f32-2
gradient, f32, with friction : SAMPLE gradient-f32-friction
gradient, fixed point, a and b : SAMPLE gradient-fixed-2
Gauss–Newton, f32, four parameters : SAMPLE gauss-newton-f32-4
the same while it records for its first fit : SAMPLE gauss-newton-recording
none | 4 : TERM gauss-newton-f32-4
asymmetry | 5 : TERM gauss-newton-with-asymmetry
dead band | 5 : TERM gauss-newton-with-dead-band
delay | 5 : TERM gauss-newton-with-delay
low speed | 5 : TERM gauss-newton-with-low-speed
gravity | 6 : TERM gauss-newton-with-gravity
ripple | 6 : TERM gauss-newton-with-ripple
gradient, a and b : RUN interrupt-gradient
gradient with friction : RUN interrupt-gradient-friction
Gauss–Newton : RUN interrupt-gauss-newton
the same with all terms : RUN interrupt-gauss-newton-terms
1 kHz : COMMISSION interrupt-commission-1-khz
10 kHz : COMMISSION interrupt-commission-10-khz
20 kHz : COMMISSION interrupt-commission-20-khz
`trial` : MEAN commission-trial
";

/// The cells behind the beginning of a row, with the ends of their keys.
const KINDS: [(&str, &str); 5] = [
    (
        "SAMPLE",
        "-mean, -most | -at-s-mean, -at-s-most | -state-bytes",
    ),
    ("TERM", "-mean | -most | -state-bytes"),
    ("RUN", "-typical | -shown | -first | -worst"),
    ("COMMISSION", "-command | -typical | -ninetieth | -worst"),
    ("MEAN", "-mean | -most"),
];

#[test]
fn the_page_of_costs_has_the_figures_of_the_budget() {
    let read = |file: &str| std::fs::read_to_string(root().join(file)).expect("a file");
    let budget = read("firmware-stm32/budget.toml");
    let figures: BTreeMap<&str, &str> = budget
        .lines()
        .filter_map(|line| line.split_once(" = "))
        .collect();
    let page = read("docs/cost.md");
    for row in ROWS.trim().lines() {
        let (begin, keys) = row.split_once(" : ").expect("keys");
        let (kind, key) = keys.split_once(' ').expect("a kind");
        let (_, cells) = KINDS.iter().find(|(name, _)| *name == kind).expect("one");
        let cell = |end: &str| {
            let figure = figures.get(&*format!("{key}{end}")).expect("a figure");
            (*figure).to_owned()
        };
        let words = cells.split_inclusive([',', '|', ' ']);
        let row: String = words
            .map(|word| match word.trim_end_matches([',', '|', ' ']) {
                "" => word.to_owned(),
                end => word.replace(end, &cell(end)),
            })
            .collect();
        let row = format!("\n| {begin} | {row} |\n");
        assert!(page.contains(&row), "docs/cost.md lacks the row{row}");
    }
}
