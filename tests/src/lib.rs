//! Support of the integration tests: seeded random servos and runs of a scenario.

pub mod exact_loop;
pub mod logs;

use std::io::Write;
use std::sync::atomic::{AtomicUsize, Ordering};

use host_sim::identify_run;
use host_sim::scenario::{Purpose, Scenario};
use identifier_core::parameters::ServoParameters;
use identifier_core::settings::ControllerSettings;
use identifier_log::result::Summary;
use virtual_servo::excitation::NormalSource;

/// Reports that a test was skipped, past the capture of the output of tests that pass.
pub fn skipped(reason: &str) {
    // In one piece: others write, too.
    let line = format!("\nskipped: {reason}\n");
    let _ = std::io::stderr().write_all(line.as_bytes());
}

/// The number in a variable of the environment, such as the size of a campaign.
#[must_use]
pub fn environment<T: std::str::FromStr>(variable: &str) -> Option<T> {
    std::env::var(variable).ok()?.parse().ok()
}

/// Factor of a campaign on the usual number of runs: `CAMPAIGN=10` for ten times as many.
#[must_use]
pub fn factor<T: std::str::FromStr + From<u8>>() -> T {
    environment("CAMPAIGN").unwrap_or_else(|| T::from(1))
}

/// A seeded stream of random numbers, the same on every machine.
#[derive(Debug, Clone, Copy)]
pub struct Random(NormalSource);

impl Random {
    /// The stream of a seed.
    #[must_use]
    pub fn new(seed: u32) -> Self {
        Self(NormalSource::new(seed))
    }

    /// Uniform between two bounds.
    pub fn uniform(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.0.next_uniform()
    }

    /// Uniform in the logarithm between two positive bounds.
    pub fn log_uniform(&mut self, low: f64, high: f64) -> f64 {
        low * (high / low).powf(self.0.next_uniform())
    }

    /// Standard normal.
    pub fn normal(&mut self) -> f64 {
        self.0.next_normal()
    }

    /// True with a probability.
    pub fn chance(&mut self, probability: f64) -> bool {
        self.uniform(0.0, 1.0) < probability
    }

    /// One or minus one.
    pub fn sign(&mut self) -> f64 {
        if self.chance(0.5) { 1.0 } else { -1.0 }
    }

    /// A seed for another generator.
    pub fn seed(&mut self) -> u32 {
        self.uniform(1.0, 2e9) as u32
    }
}

/// The true servo of a scenario for a run.
pub fn servo(scenario: &mut Scenario) -> &mut ServoParameters {
    scenario.plant.as_mut().expect("a run has a plant")
}

/// The controller of a scenario for a run.
pub fn controller(scenario: &mut Scenario) -> &mut ControllerSettings {
    scenario
        .stated
        .controller
        .as_mut()
        .expect("a run has a controller")
}

/// A scenario from a text that is known to be right.
#[must_use]
pub fn parse(text: &str) -> Scenario {
    Scenario::parse("test", text, Purpose::Run).expect("a valid scenario")
}

/// Runs a scenario to its summary.
#[must_use]
pub fn run(scenario: &Scenario) -> Summary {
    let found = identify_run(scenario.clone(), &|| true, &mut |_, _| {});
    found.expect("a valid scenario").summary
}

/// Does independent work on all cores, the results in order.
pub fn in_parallel<T: Sync, R: Send>(items: &[T], work: impl Fn(&T) -> R + Sync) -> Vec<R> {
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let next = AtomicUsize::new(0);
    // Some take many times as long as others: each core has the next one that is left.
    let share = || {
        let places = std::iter::repeat_with(|| next.fetch_add(1, Ordering::Relaxed));
        let done = places.map_while(|place| Some((place, work(items.get(place)?))));
        done.collect::<Vec<_>>()
    };
    let mut done = std::thread::scope(|scope| {
        let workers: Vec<_> = (0..threads).map(|_| scope.spawn(share)).collect();
        let shares = workers.into_iter();
        let shares = shares.flat_map(|worker| worker.join().expect("no panic in the work"));
        shares.collect::<Vec<_>>()
    });
    done.sort_by_key(|(place, _)| *place);
    done.into_iter().map(|(_, result)| result).collect()
}
