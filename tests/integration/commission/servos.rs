//! Unknown servos, and what their users would allow.

use host_sim::scenario::{Purpose, Scenario};
use integration_tests::Random;

/// A servo that nobody knows, drawn.
#[derive(Debug, Clone)]
pub(super) struct Drawn {
    /// Its class: sample rate and encoder.
    pub(super) class: String,
    pub(super) text: String,
}

/// Sample times, s.
const SAMPLE_TIMES: [(f64, &str); 3] = [(1e-3, "1 kHz"), (2.5e-4, "4 kHz"), (1e-4, "10 kHz")];

/// Friction a over gain b of the paper's servo, command units s/rad.
const NOMINAL: f64 = 0.2174 / 257.7;

/// Servos of the issue: b over 100:1, a/b of 0 to 10 times the paper's, Coulomb friction of up to 20 % and
/// load of up to 30 % of the limit, 1000 to 131 072 counts, three sample rates, delays of up to two samples.
/// Every third is held by gains that somebody tuned with care; the others stand let go.
pub(super) fn unknown(random: &mut Random, place: usize) -> Drawn {
    let (sample_time, rate) = SAMPLE_TIMES[place % SAMPLE_TIMES.len()];
    let limit = 1.0;
    let b = random.log_uniform(20.0, 2000.0);
    let a = b * NOMINAL * random.uniform(0.0, 10.0);
    let coulomb = b * limit * random.uniform(0.0, 0.2);
    let load = b * limit * random.uniform(-0.3, 0.3);
    let counts = random.log_uniform(1000.0, 131_072.0).round();
    let delay = sample_time * random.uniform(0.0, 2.0);
    let travel = random.log_uniform(0.3, 3.0);
    let speed = random.log_uniform(5.0, 50.0);
    let held = (place / SAMPLE_TIMES.len()).is_multiple_of(3);
    let before = match held {
        true => gains(b, sample_time),
        false => format!("[commission]\nsample_time = {sample_time:?}"),
    };
    let text = format!(
        "
[plant]
a = {a:?}
b = {b:?}
coulomb = {coulomb:?}
load = {load:?}
delay = {delay:?}
[encoder]
counts_per_rev = {counts:?}
[amplifier]
limit = {limit:?}
{before}
travel = {travel:?}
speed = {speed:?}
"
    );
    let encoder = if counts < 4096.0 { "< 4096" } else { ">= 4096" };
    Drawn {
        class: format!("{rate:>6}, {encoder:>7} counts"),
        text,
    }
}

/// A PID that is far from the fastest, with a double pole at ω and one at ω/5.
fn gains(b: f64, sample_time: f64) -> String {
    let omega = (0.02 / sample_time).min(40.0);
    let (kp, kd, ki) = (
        1.4 * omega * omega / b,
        2.2 * omega / b,
        0.2 * omega * omega * omega / b,
    );
    let cutoff = 8.0 * omega;
    format!(
        "
[controller]
kp = {kp:?}
kd = {kd:?}
ki = {ki:?}
sample_time = {sample_time:?}
velocity_filter = {{ kind = \"low-pass\", cutoff = {cutoff:?} }}
[commission]"
    )
}

impl Drawn {
    /// To be commissioned; none if that is refused before anything moves, with what was said.
    pub(super) fn scenario(&self) -> Result<Scenario, String> {
        Scenario::parse("drawn", &self.text, Purpose::Commission)
            .map_err(|error| error.fault.clone())
    }
}
