//! The servos of the campaigns.

use host_sim::scenario::Scenario;
use integration_tests::parse;

/// A kind of servo, with its usual motion.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Kind {
    pub(crate) name: &'static str,
    pub(crate) sample_time: f64,
    pub(crate) a: f64,
    pub(crate) b: f64,
    pub(crate) coulomb: f64,
    pub(crate) counts: f64,
    pub(crate) gains: [f64; 3],
    pub(crate) limit: f64,
    /// Power of the noise reference, rad² s, and the time for which a value is held, s.
    pub(crate) noise: [f64; 2],
    pub(crate) duration: f64,
    /// A usual command, and velocity, rad/s.
    pub(crate) command: f64,
    pub(crate) velocity: f64,
}

pub(crate) const KINDS: [Kind; 3] = [
    Kind {
        name: "paper",
        sample_time: 1e-3,
        a: 0.2174,
        b: 257.7,
        coulomb: 5.0,
        counts: 10_000.0,
        gains: [9.0, 0.19, 4.0],
        limit: 10.0,
        noise: [0.05, 0.1],
        duration: 20.0,
        command: 3.0,
        velocity: 10.0,
    },
    Kind {
        name: "axis",
        sample_time: 1e-4,
        a: 1.5,
        b: 3000.0,
        coulomb: 150.0,
        counts: 20_000.0,
        gains: [30.0, 0.14, 60.0],
        limit: 5.0,
        noise: [0.002, 0.05],
        duration: 5.0,
        command: 2.0,
        velocity: 20.0,
    },
    Kind {
        name: "geared",
        sample_time: 1e-3,
        a: 3.1,
        b: 120.0,
        coulomb: 10.0,
        counts: 4096.0,
        gains: [6.0, 0.25, 4.0],
        limit: 3.0,
        noise: [0.1, 0.15],
        duration: 20.0,
        command: 1.5,
        velocity: 6.0,
    },
];

impl Kind {
    /// The tables of its encoder, which may have further lines, and of its loop.
    pub(super) fn control_loop(&self, encoder: &str) -> String {
        let Self {
            sample_time,
            counts,
            gains: [kp, kd, ki],
            limit,
            ..
        } = self;
        let cutoff = 0.5 / sample_time;
        format!(
            "[encoder]
counts_per_rev = {counts:?}
{encoder}
[amplifier]
limit = {limit:?}
[controller]
kp = {kp:?}
kd = {kd:?}
ki = {ki:?}
sample_time = {sample_time:?}
velocity_filter = {{ kind = \"low-pass\", cutoff = {cutoff:?} }}
"
        )
    }

    /// A run of it, with further lines of its plant, encoder and identifier.
    pub(super) fn run(&self, seed: u32, plant: &str, encoder: &str, identifier: &str) -> Scenario {
        let Self {
            a,
            b,
            coulomb,
            noise: [power, hold],
            duration,
            ..
        } = self;
        let control_loop = self.control_loop(encoder);
        parse(&format!(
            "
[plant]
a = {a:?}
b = {b:?}
coulomb = {coulomb:?}
{plant}
{control_loop}[excitation]
kind = \"band-limited-white-noise\"
power = {power:?}
sample_time = {hold:?}
seed = {seed}
[identifier]
{identifier}
[run]
duration = {duration:?}
"
        ))
    }
}

/// Gauss–Newton that finds all four parameters.
pub(super) const ALL_FOUR: &str =
    "law = \"gauss-newton\"\nparameters = [\"a\", \"b\", \"coulomb\", \"load\"]";
