//! Durations of the sample interrupt, ns, by the share of samples, %, that take no longer.

use super::machine::Reception;

/// A share of the samples, %, and the longest of them, ns.
type Share = (u32, u64);

/// The figures of `cargo xtask budget`, counted on the emulated drive.
const BUDGET: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../firmware-stm32/budget.toml");

/// Ticks of the processor in a microsecond.
const CLOCK: u64 = 168;

const LAWS: [&str; 4] = ["fixed", "gauss-newton", "gradient", "gradient-friction"];

/// Durations of the sample interrupt.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Durations {
    /// While the servo is disabled.
    pub(super) at_rest: Vec<Share>,
    /// Of a run that shows every sample.
    pub(super) run: Vec<Share>,
    /// Of a commissioning.
    pub(super) commissioning: Vec<Share>,
}

impl Durations {
    /// Those of the drive that has this receiver, at a rate, Hz.
    pub(super) fn of(reception: Reception, rate: u32) -> Self {
        match reception {
            Reception::Dma => Self::counted(rate),
            Reception::Register => Self::audited(rate),
        }
    }

    /// Those of the drive as it is, by the model of `docs/cycles.md`: of the dearest law, and of the commissioning at the next
    /// rate that is counted, of which the slower takes longer.
    fn counted(rate: u32) -> Self {
        let budget = std::fs::read_to_string(BUDGET).expect("the budget is committed");
        let time = |name: &str| time(&budget, name);
        let of_laws = |which: &str| {
            let cycles = LAWS.map(|law| time(&format!("interrupt-{law}-{which}-cycles")));
            cycles.into_iter().max().unwrap_or(0)
        };
        let counted = match rate {
            20_000.. => 20,
            10_000.. => 10,
            _ => 1,
        };
        let commissioning = |which: &str| {
            time(&format!(
                "interrupt-commission-{counted}-khz-{which}-cycles"
            ))
        };
        Self {
            at_rest: vec![(100, time("interrupt-at-rest-worst-cycles"))],
            run: vec![(90, of_laws("shown")), (100, of_laws("worst"))],
            commissioning: vec![
                (50, commissioning("typical")),
                (90, commissioning("ninetieth")),
                (100, commissioning("worst")),
            ],
        }
    }

    /// Those of the drive at 8ea5838, whose receiver held one byte, by an audit with the same meter: a commissioning took 14
    /// to 20 µs in the mean, 43 µs at the 90th percentile, 62 µs and 93 % of a sample at most.
    fn audited(rate: u32) -> Self {
        let most = 1_000_000_000 / u64::from(rate) * 93 / 100;
        let bounded = |shares: &[Share]| {
            let shares = shares.iter();
            shares
                .map(|&(share, time)| (share, time.min(most)))
                .collect()
        };
        Self {
            at_rest: bounded(&[(100, 3_000)]),
            run: bounded(&[(90, 5_300), (99, 6_000), (100, 9_700)]),
            commissioning: bounded(&[(70, 9_000), (90, 30_000), (98, 43_000), (100, 62_000)]),
        }
    }
}

/// The time of a number of cycles in the budget, ns.
fn time(budget: &str, name: &str) -> u64 {
    let value = budget
        .lines()
        .find_map(|line| line.strip_prefix(name)?.strip_prefix(" = ")?.parse().ok());
    let cycles: u64 = value.unwrap_or_else(|| panic!("the budget has no {name}"));
    (1000 * cycles).div_ceil(CLOCK)
}
