//! Unknown servos, and their users' limits.

use host_sim::scenario::{Purpose, Scenario};
use integration_tests::{Random, environment};

use crate::verdict::campaign::{self as verdict, KINDS as KNOWN};

/// A random servo, unknown to the commissioning.
#[derive(Debug, Clone)]
pub(super) struct Drawn {
    /// Its class: sample rate and encoder.
    pub(super) class: String,
    pub(super) text: String,
}

/// Sample times, s.
const SAMPLE_TIMES: [(f64, &str); 3] = [(1e-3, "1 kHz"), (2.5e-4, "4 kHz"), (1e-4, "10 kHz")];

/// Encoders, counts per revolution.
const COUNTS: [u32; 7] = [1000, 2000, 4096, 10_000, 20_000, 65_536, 131_072];

/// The command limit of all of them, and the gain of the weakest.
const LIMIT: f64 = 10.0;
const WEAKEST: f64 = 50.0;

/// Friction a over gain b of the paper's servo, command units s/rad.
const NOMINAL: f64 = 0.2174 / 257.7;

/// An effect that a machine adds to a rigid axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Effect {
    /// 5 to 25 % of the full command, from any angle on.
    Gravity,
    /// 2 to 12 % of the full command, 6 to 84 periods a revolution.
    Cogging,
    /// 0.3 to 1.5 of Coulomb friction in addition, within 0.05 to 2 rad/s.
    Stribeck,
}

impl Effect {
    pub(super) const ALL: [(&'static str, Self); 3] = [
        ("gravity", Self::Gravity),
        ("cogging", Self::Cogging),
        ("stribeck", Self::Stribeck),
    ];

    /// Its lines in [plant], for a servo of so much push and Coulomb friction, rad/s².
    fn drawn(self, random: &mut Random, push: f64, coulomb: f64) -> String {
        let waves = |random: &mut Random, name: &str, part: f64| {
            let (sine, cosine) = random.uniform(0.0, std::f64::consts::TAU).sin_cos();
            format!(
                "{name} = [{:?}, {:?}]\n",
                part * push * sine,
                part * push * cosine
            )
        };
        match self {
            Self::Gravity => {
                let part = random.uniform(0.05, 0.25);
                waves(random, "gravity", part)
            }
            Self::Cogging => {
                let part = random.uniform(0.02, 0.12);
                let order = random.log_uniform(6.0, 84.0).round();
                format!("{}ripple_order = {order}\n", waves(random, "ripple", part))
            }
            Self::Stribeck => format!(
                "low_speed_friction = {:?}\nlow_speed_velocity = {:?}\n",
                coulomb * random.uniform(0.3, 1.5),
                random.log_uniform(0.05, 2.0)
            ),
        }
    }
}

/// Random unknown servos: b over 100:1, a/b of 0 to 10 times the paper's, Coulomb friction of up to 20 % and
/// load of up to 30 % of the limit, 1000 to 131 072 counts, three sample rates, delays of up to two samples.
/// Travel and speed are the limits of a user who knows only the strength of the servo's class: half a decade.
/// Every second is held by gains that were tuned with care; the others rest and coast.
pub(super) fn unknown(random: &mut Random, place: usize, effects: &[Effect]) -> Drawn {
    let (sample_time, rate) = SAMPLE_TIMES[place % SAMPLE_TIMES.len()];
    let b = random.log_uniform(WEAKEST, 100.0 * WEAKEST);
    let a = b * NOMINAL * random.uniform(0.0, 10.0);
    let coulomb = b * LIMIT * random.uniform(0.0, 0.2);
    let load = b * LIMIT * random.uniform(-0.3, 0.3);
    let counts = f64::from(COUNTS[random.seed() as usize % COUNTS.len()]);
    let delay = sample_time
        * match random.uniform(0.0, 6.0) {
            whole if whole < 3.0 => whole.floor(),
            _ => random.uniform(0.0, 2.0),
        };
    let class = (2.0 * (b / WEAKEST).log10()).floor().min(3.0);
    let scale = 10.0_f64.powf(0.25 * class);
    let (travel, speed) = (0.16 * scale, 15.0 * scale);
    let held = (place / SAMPLE_TIMES.len()).is_multiple_of(2);
    let before = match held {
        true => gains(b, sample_time),
        false => format!("[commission]\nsample_time = {sample_time:?}"),
    };
    let seed = random.seed();
    let effects: String = (effects.iter())
        .map(|effect| effect.drawn(random, b * LIMIT, coulomb))
        .collect();
    let feed_forward = environment::<u8>("CAMPAIGN_FEED_FORWARD").is_some_and(|on| on > 0);
    let text = format!(
        "
[plant]
a = {a:?}
b = {b:?}
coulomb = {coulomb:?}
load = {load:?}
delay = {delay:?}
{effects}[encoder]
counts_per_rev = {counts:?}
[amplifier]
limit = {LIMIT:?}
{before}
travel = {travel:?}
speed = {speed:?}
feed_forward = {feed_forward}
[run]
seed = {seed}
"
    );
    let encoder = if counts < 4096.0 { "< 4096" } else { ">= 4096" };
    let held = if held { "held" } else { "coasting" };
    Drawn {
        class: format!("{rate:>6}, {encoder:>7} counts, {held}"),
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
    /// The scenario of its commissioning, or the message of a refusal before any motion.
    pub(super) fn scenario(&self) -> Result<Scenario, String> {
        Scenario::parse("drawn", &self.text, Purpose::Commission)
            .map_err(|error| error.fault.clone())
    }
}

/// A known servo, and its user's limits.
#[derive(Debug, Clone, Copy)]
pub(super) struct Kind {
    pub(super) name: &'static str,
    pub(super) sample_time: f64,
    a: f64,
    pub(super) b: f64,
    pub(super) coulomb: f64,
    pub(super) counts: f64,
    pub(super) limit: f64,
    travel: f64,
    pub(super) speed: f64,
}

/// The servos of the verdict's campaign, and their users' limits.
pub(super) const KINDS: [Kind; 3] = [
    Kind::allowed(&KNOWN[0], 1.5, 40.0),
    Kind::allowed(&KNOWN[1], 0.5, 40.0),
    Kind::allowed(&KNOWN[2], 1.0, 10.0),
];

impl Kind {
    const fn allowed(known: &verdict::Kind, travel: f64, speed: f64) -> Self {
        Self {
            name: known.name,
            sample_time: known.sample_time,
            a: known.a,
            b: known.b,
            coulomb: known.coulomb,
            counts: known.counts,
            limit: known.limit,
            travel,
            speed,
        }
    }

    /// The scenario of its commissioning from rest, with further lines of its plant. The seed draws a load
    /// that friction can hold.
    pub(super) fn scenario(&self, plant: &str, seed: u32) -> Scenario {
        let Self {
            sample_time,
            a,
            b,
            coulomb,
            counts,
            limit,
            travel,
            speed,
            ..
        } = self;
        let load = Random::new(seed).uniform(-0.5, 0.5) * coulomb;
        let text = format!(
            "
[plant]
a = {a:?}
b = {b:?}
coulomb = {coulomb:?}
load = {load:?}
{plant}
[encoder]
counts_per_rev = {counts:?}
[amplifier]
limit = {limit:?}
[commission]
travel = {travel:?}
speed = {speed:?}
sample_time = {sample_time:?}
[run]
seed = {seed}
"
        );
        Scenario::parse(self.name, &text, Purpose::Commission).expect("a valid scenario")
    }
}
