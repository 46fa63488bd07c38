//! Logs of an even drive whose rows were stamped late, or were lost, identified without a scenario.
//!
//! ```sh
//! cargo test --release -p host-sim --test clock -- --ignored --nocapture
//! ```

use host_sim::scenario::{Purpose, Scenario};
use host_sim::simulate;
use identifier_log::log::{Clock, Log, Table};
use identifier_log::recognise::{LogOptions, recognise};
use identifier_log::scenario::Options;
use virtual_servo::SplitMix64;

const STEP: f64 = 1e-3;
const B: f64 = 281.25;

/// How stamps deviate from the clock.
#[derive(Debug, Clone, Copy)]
enum Deviation {
    Normal,
    Uniform,
    /// Exponential.
    Late,
    /// The same, in a queue: no row overtakes another.
    Queued,
    /// A third of the rows is late by a sample.
    Third,
}

fn uniform(random: &mut SplitMix64) -> f64 {
    (random.next_word() >> 11) as f64 / (1_u64 << 53) as f64
}

impl Deviation {
    /// A deviation whose root mean square is `rms`.
    fn draw(self, rms: f64, random: &mut SplitMix64) -> f64 {
        let one = 1.0 - uniform(random);
        match self {
            Self::Normal => {
                rms * (-2.0 * one.ln()).sqrt() * (std::f64::consts::TAU * uniform(random)).cos()
            }
            Self::Uniform => rms * 12_f64.sqrt() * (one - 0.5),
            Self::Late | Self::Queued => -rms * one.ln(),
            Self::Third => f64::from(u8::from(one < 1.0 / 3.0)),
        }
    }
}

/// Time, position and command of a servo in closed loop, 1 ms apart.
fn moved(seed: u64) -> [Vec<f64>; 3] {
    let (next, hold) = (seed + 1, 0.15 + 0.01 * seed as f64);
    let excitation = match seed % 2 {
        0 => format!("kind = \"band-limited-white-noise\", power = 0.01, seed = {next}"),
        _ => format!("kind = \"prbs\", amplitude = 0.5, hold = {hold}"),
    };
    let text = format!(
        "plant = {{ a = 1.875, b = {B}, coulomb = 56.25, load = -18.75 }}
         encoder = {{ counts_per_rev = 2000 }}
         amplifier = {{ limit = 4.0 }}
         controller = {{ kp = 9.0, kd = 0.19, ki = 4.0, sample_time = {STEP} }}
         excitation = {{ {excitation} }}
         run = {{ duration = 8.0 }}"
    );
    let scenario = Scenario::parse("clock", &text, Purpose::Run).expect("a scenario");
    let mut columns = [const { Vec::new() }; 3];
    simulate::run(&scenario, &mut |sample| {
        let values = [sample.time, sample.position, sample.command];
        (columns.iter_mut().zip(values)).for_each(|(column, value)| column.push(value));
    })
    .expect("a run");
    columns
}

/// The log of a motion whose stamps deviate and whose rows are lost by chance.
fn stamped(
    motion: &[Vec<f64>; 3],
    seed: u64,
    stamps: &mut dyn FnMut(f64, &mut SplitMix64) -> f64,
    lost: f64,
) -> [Vec<f64>; 3] {
    let mut random = SplitMix64::new(seed);
    let mut columns = [const { Vec::new() }; 3];
    for row in 0..motion[0].len() {
        let time = stamps(motion[0][row], &mut random);
        if uniform(&mut random) >= lost {
            let values = [time, motion[1][row], motion[2][row]];
            (columns.iter_mut().zip(values)).for_each(|(column, value)| column.push(value));
        }
    }
    columns
}

/// What is found in a log.
#[derive(Debug)]
struct Outcome {
    log: Log,
    /// b and its interval of 95 %, parts of the truth; none where it is not known.
    b: Option<[f64; 2]>,
    is_converged: bool,
}

fn read(columns: &[Vec<f64>; 3], sample_time: Option<f64>) -> Result<(Options, Log), String> {
    let names = ["t_s", "q_rad", "u_A"];
    let columns = names.iter().zip(columns);
    let columns = columns.map(|(name, column)| ((*name).to_owned(), column.clone()));
    let table = Table::of_columns("log", columns.collect()).map_err(|error| error.to_string())?;
    let stated = LogOptions {
        sample_time,
        ..LogOptions::default()
    };
    let recognised = recognise(&table, &stated).map_err(|error| format!("{error:?}"))?;
    let options = recognised.options().map_err(|fault| fault.to_string())?;
    let log = Log::new(&table, &options.log_columns(), options.log_sample_time());
    Ok((options, log.map_err(|error| error.to_string())?))
}

fn identified(columns: &[Vec<f64>; 3], sample_time: Option<f64>) -> Result<Outcome, String> {
    let (options, log) = read(columns, sample_time)?;
    let found = identifier_log::identify(std::slice::from_ref(&log), &[], &options, &|| true);
    let summary = found.map_err(|fault| fault.to_string())?.summary;
    let b = &summary.estimates.b;
    let error = b
        .std_error
        .filter(|error| error.is_finite() && b.value.is_finite());
    Ok(Outcome {
        log,
        b: error.map(|error| [b.value / B, 2.0 * error / B]),
        is_converged: summary.status().name() == "converged",
    })
}

#[derive(Debug, Default)]
struct Count {
    all: u32,
    even: u32,
    inside: u32,
    converged: u32,
    far: u32,
    worst: f64,
    widest: f64,
}

impl Count {
    fn add(&mut self, found: &Outcome, rms: f64) {
        let [b, interval] = found.b.unwrap_or([f64::NAN, f64::INFINITY]);
        let off = (b - 1.0).abs();
        self.all += 1;
        self.even += u32::from(found.log.found.clock == Clock::Even);
        self.converged += u32::from(found.is_converged);
        self.inside += u32::from(off <= interval || off.is_nan());
        self.far += u32::from(off > 0.01 && rms < 0.3);
        self.worst = self.worst.max(off);
        self.widest = self.widest.max(interval);
    }
}

fn campaign(seeds: u64, sizes: &[f64], losses: &[f64]) -> Count {
    let mut total = Count::default();
    for deviation in [
        Deviation::Normal,
        Deviation::Uniform,
        Deviation::Late,
        Deviation::Queued,
    ] {
        for (lost, rms) in losses
            .iter()
            .flat_map(|lost| sizes.iter().map(move |rms| (*lost, *rms)))
        {
            let mut count = Count::default();
            for seed in 0..seeds {
                let motion = moved(seed);
                let mut last = f64::NEG_INFINITY;
                let mut stamps = |time: f64, random: &mut SplitMix64| {
                    let late = time + STEP * deviation.draw(rms, random);
                    last = match deviation {
                        Deviation::Queued => late.max(last + 1e-2 * STEP),
                        _ => late,
                    };
                    last
                };
                let columns = stamped(&motion, seed + 100, &mut stamps, lost);
                let found = identified(&columns, None).expect("a log");
                count.add(&found, rms);
                total.add(&found, rms);
            }
            println!("{deviation:?} {rms}, lost {lost}: {count:?}");
        }
    }
    println!("{total:?}");
    total
}

#[test]
fn stamps_that_jitter_and_lost_rows_leave_b_right() {
    let count = campaign(1, &[0.25], &[0.0, 0.03]);
    assert_eq!([count.far, count.inside], [0, count.all]);
}

#[test]
#[ignore = "minutes"]
fn jitter_of_every_kind_and_size() {
    let sizes = [0.05, 0.1, 0.15, 0.18, 0.2, 0.22, 0.25, 0.3, 0.4];
    let count = campaign(6, &sizes, &[0.0, 0.01, 0.03]);
    assert_eq!(count.far, 0);
    assert!(f64::from(count.inside) >= 0.93 * f64::from(count.all));
}

#[test]
fn coarse_stamps_a_stated_sample_time_and_rows_late_by_a_sample() {
    let motion = moved(1);
    type Stamps<'a> = &'a mut dyn FnMut(f64, &mut SplitMix64) -> f64;
    let milliseconds = |time: f64| (1e3 * time).floor() / 1e3;
    let cases: [(&str, Option<f64>, f64, Stamps<'_>); 6] = [
        // Milliseconds cut to integers, of samples of 1 ms and of 1.003 ms.
        ("whole ms", None, 1.0, &mut |time, random| {
            milliseconds(time + 3e-4 * STEP * Deviation::Normal.draw(1.0, random))
        }),
        ("whole ms of 1.003", None, 1.003, &mut |time, _| {
            milliseconds(1.003 * time)
        }),
        ("steps of 5 ms", None, 1.0, &mut |time, _| {
            (200.0 * time + 1e-9).floor() / 200.0
        }),
        ("stated", Some(STEP), 1.0, &mut |time, random| {
            time + STEP * Deviation::Normal.draw(0.25, random)
        }),
        ("stated, 2 % fast", Some(STEP), 1.0, &mut |time, _| {
            1.02 * time
        }),
        ("a third late", None, 1.0, &mut |time, random| {
            time + STEP * Deviation::Third.draw(1.0, random)
        }),
    ];
    for (name, stated, rate, stamps) in cases {
        let columns = stamped(&motion, 5, stamps, 0.0);
        let found = identified(&columns, stated).unwrap_or_else(|why| panic!("{name}: {why}"));
        assert_eq!(found.log.found.clock, Clock::Even, "{name}");
        assert_eq!(found.log.found.bridged, 0, "{name}");
        let off = found.log.sample_time / STEP / rate - 1.0;
        assert!(off.abs() < 1e-4, "{name}");
        // b of samples that are longer is smaller by the square.
        let [b, _] = found.b.unwrap_or_else(|| panic!("{name}: no b"));
        assert!((b * rate * rate - 1.0).abs() < 0.01, "{name}: {b}");
    }
}

#[test]
fn the_jitter_that_is_reported_is_that_of_the_stamps() {
    let motion = moved(0);
    for rms in [0.1, 0.25] {
        for deviation in [Deviation::Normal, Deviation::Uniform, Deviation::Late] {
            let mut stamps =
                |time: f64, random: &mut SplitMix64| time + STEP * deviation.draw(rms, random);
            let columns = stamped(&motion, 3, &mut stamps, 0.01);
            let (_, log) = read(&columns, None).expect("a log");
            let lost = (motion[0].len() - columns[0].len()) as f64;
            let [jitter, bridged] = [log.found.jitter.rms / rms, log.found.bridged as f64 / lost];
            assert!((jitter - 1.0).abs() < 0.1, "{deviation:?} {rms}: {jitter}");
            assert!(
                (bridged - 1.0).abs() < 0.1,
                "{deviation:?} {rms}: {bridged}"
            );
        }
    }
}
