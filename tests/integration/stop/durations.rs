//! Durations of the sample interrupt, ns, by the share of samples, %, that take no longer.

/// A share of the samples, %, and the longest of them, ns.
type Share = (u32, u64);

/// The figures of `cargo xtask budget`, counted on the emulated drive.
const BUDGET: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../firmware-stm32/budget.toml");

/// Ticks of the processor in a microsecond, and for an instruction: the manuals of core and flash give 1.9 to 2.14 for this
/// code.
const CLOCK: f64 = 168.0;
const TICKS: f64 = 2.2;

const ESTIMATORS: [&str; 3] = ["gauss-newton", "gradient", "gradient-friction"];

/// Durations of the sample interrupt.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Durations {
    /// While the servo is disabled.
    pub(super) at_rest: Vec<Share>,
    /// For a run that shows every sample.
    pub(super) run: Vec<Share>,
    /// Of a commissioning.
    pub(super) commissioning: Vec<Share>,
}

impl Durations {
    /// Those at a rate, Hz: of the most expensive estimator, and of the commissioning at the next rate that is counted,
    /// of which the slower takes longer.
    pub(super) fn at(rate: u32) -> Self {
        let budget = std::fs::read_to_string(BUDGET).expect("the budget is committed");
        let time = |name: &str| time(&budget, name);
        let of_estimators = |which: &str| {
            let times = ESTIMATORS.map(|law| time(&format!("interrupt-{law}-{which}")));
            times.into_iter().max().unwrap_or(0)
        };
        let counted = match rate {
            20_000.. => 20,
            10_000.. => 10,
            _ => 1,
        };
        let commissioning =
            |which: &str| time(&format!("interrupt-commission-{counted}-khz-{which}"));
        Self {
            at_rest: vec![(100, time("interrupt-at-rest-worst"))],
            run: vec![(90, of_estimators("shown")), (100, of_estimators("worst"))],
            commissioning: vec![
                (50, commissioning("typical")),
                (90, commissioning("ninetieth")),
                (100, commissioning("worst")),
            ],
        }
    }
}

/// The time of a number of instructions in the budget, ns.
fn time(budget: &str, name: &str) -> u64 {
    let value = budget
        .lines()
        .find_map(|line| line.strip_prefix(name)?.strip_prefix(" = ")?.parse().ok());
    let instructions: f64 = value.unwrap_or_else(|| panic!("the budget has no {name}"));
    (1000.0 * TICKS / CLOCK * instructions).ceil() as u64
}
