//! Stops at any moment of a run, a commissioning, a write and an erasure of the flash, amid garbage, cut frames and full
//! telemetry: the drive's own receiver, flash driver and logic on a chip with time.

mod broken_wire;
mod durations;
mod host;
mod machine;
/// The bench of the drive's own tests.
#[allow(dead_code, reason = "stops need a part of it")]
#[path = "../../../crates/drive-logic/tests/drive/support/mod.rs"]
mod support;

use commissioning::CommissionSettings;
use drive_link::{Command, Settings};
use integration_tests::{environment, in_parallel};

use host::Host;
use machine::BYTE;
use support::commission::ORDER;
use support::first_contact;

/// The longest time from the first byte of a stop on the wire until the output is off, ns.
const LIMIT: u64 = 2_000_000;

/// Rates of the samples, Hz.
const RATES: [u32; 5] = [1_000, 2_000, 4_000, 10_000, 20_000];

/// Settings of a drive at a rate, Hz.
fn settings(rate: u32) -> Settings {
    let mut settings = first_contact();
    settings.closed_loop.core.sample_time = 1.0 / f64::from(rate);
    settings.dither.amplitude = 0.05;
    settings.protection.stall_time = 1.0;
    settings
}

/// The activity that a stop comes into.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Activity {
    /// A run.
    Run,
    /// A commissioning from rest, which writes a record first, and every sixteenth time erases a sector.
    Commissioning,
    /// A commissioning instead of a run, which resumes.
    Beside,
    /// A save at rest, and a start right after it.
    Save,
}

const ACTIVITIES: [Activity; 4] = [
    Activity::Run,
    Activity::Commissioning,
    Activity::Beside,
    Activity::Save,
];

impl Activity {
    /// Longest times until the stop, ms: of most of the attempts, and of the others.
    fn spans(self) -> [u32; 2] {
        match self {
            Self::Run => [20, 20],
            // A write takes up to 26 ms, and an erasure half a second.
            Self::Commissioning => [60, 700],
            Self::Beside => [400, 1500],
            Self::Save => [40, 600],
        }
    }

    /// The requests that begin it.
    fn requests(self, order: CommissionSettings) -> Vec<Command> {
        let commission = Command::Commission(order);
        match self {
            Self::Run => vec![Command::Start],
            Self::Commissioning => vec![commission],
            Self::Beside => vec![Command::Start, commission],
            Self::Save => vec![Command::Save, Command::Start],
        }
    }
}

/// The outcome of the stops at one rate in one activity.
#[derive(Debug, Default, Clone, Copy)]
struct Tally {
    stops: u32,
    /// The servo was driven when the stop began.
    driven: u32,
    /// It was driven later than it may be.
    late: u32,
    /// The longest time of those in time, ns.
    worst: u64,
}

/// Stops one drive again and again.
fn stop_again_and_again(rate: u32, activity: Activity, stops: u32) -> Tally {
    let settings = settings(rate);
    let order = CommissionSettings {
        sample_time: settings.closed_loop.core.sample_time,
        ..ORDER
    };
    let mut host = Host::new(rate);
    host.request(Command::Configure(settings));
    host.request(Command::Watch(1));
    host.pass(50_000_000);
    let mut tally = Tally::default();
    for number in 0..stops {
        host.come_to_rest();
        if activity != Activity::Run {
            host.expect_commissioning();
        }
        for (k, request) in activity.requests(order).into_iter().enumerate() {
            if k > 0 && activity == Activity::Beside {
                host.leave_idle(3_000_000);
            }
            host.request(request);
        }
        let [most, rest] = activity.spans();
        let span = if number % 4 == 3 { rest } else { most };
        // Every place in the span in turn, to a byte.
        let bytes = u64::from(span) * 1_000_000 / BYTE;
        let place = u64::from(number) * bytes / u64::from(stops.max(1));
        let within = host.below(BYTE as u32);
        host.leave_idle(place * BYTE + u64::from(within));
        host.garble();
        let began = host.stop();
        host.flood();
        host.run_to(began + LIMIT);
        // Until nothing is left of the requests, the write and the erasure.
        host.pass(5_000_000);
        let was_driven = host.was_driven();
        tally.stops += 1;
        tally.driven += u32::from(was_driven);
        let last = host.last_driven();
        if last > began + LIMIT {
            tally.late += 1;
        } else if was_driven {
            tally.worst = tally.worst.max(last.saturating_sub(began));
        }
    }
    tally
}

/// Stops drives at every rate in every activity, and prints the outcome.
fn campaign(stops: u32) -> Vec<(u32, Tally)> {
    let each = stops / (RATES.len() * ACTIVITIES.len()) as u32;
    let cases: Vec<_> = RATES
        .into_iter()
        .flat_map(|rate| ACTIVITIES.map(|activity| (rate, activity)))
        .collect();
    in_parallel(&cases, |&(rate, activity)| {
        let tally = stop_again_and_again(rate, activity, each);
        println!(
            "{:>2} kHz, {activity:?}: {} stops, {} of a driven servo, {} late, worst {:.3} ms",
            rate / 1000,
            tally.stops,
            tally.driven,
            tally.late,
            tally.worst as f64 * 1e-6
        );
        (rate, tally)
    })
}

/// Number of stops: `STOPS`, or as many as take some seconds.
fn stops() -> u32 {
    environment("STOPS").unwrap_or(2_000)
}

#[test]
fn requests_without_a_pause_do_not_hide_a_stop() {
    let mut host = Host::configured(4_000, 0.0);
    for flood in [100, 300, 1000, 3000] {
        host.start();
        // More than all the queues hold, each with a long answer.
        for _ in 0..flood {
            host.request(Command::Show);
        }
        let began = host.stop();
        for _ in 0..100 {
            host.request(Command::Show);
        }
        host.run_to(began + LIMIT);
        assert!(host.was_driven() && !host.is_driven(), "{flood} before it");
        host.pass(4_000_000_000);
        assert!(!host.is_driven());
        host.refusals();
    }
}

#[test]
fn a_stop_at_any_moment_turns_the_output_off_within_two_milliseconds() {
    let found = campaign(stops());
    for (rate, tally) in &found {
        assert_eq!(tally.late, 0, "{rate} Hz: {tally:?}");
        assert!(tally.worst < LIMIT);
    }
    let driven: u32 = found.iter().map(|(_, tally)| tally.driven).sum();
    assert!(3 * driven > stops(), "{driven} stops of a driven servo");
}
