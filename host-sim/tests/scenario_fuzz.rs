//! Any file is read as a scenario or refused. A program of its own: it measures the memory of
//! the reader alone.

#[path = "support/readable.rs"]
mod readable;

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::time::{Duration, Instant};

use host_sim::scenario::keys::KEYS;
use host_sim::scenario::{Purpose, Scenario};
use readable::assert_readable;
use virtual_servo::SplitMix64;

const SCENARIOS: &str = "compare|drift|emps|fast_axis|friction|geared_axis|gravity_link|minimal|\
    paper-least-squares|paper|replay|sweep";

/// Numbers that look random, the same in every run.
struct Dice(SplitMix64);

impl Dice {
    fn below(&mut self, most: usize) -> usize {
        (self.0.next_word() % most.max(1) as u64) as usize
    }

    fn word_of<'t>(&mut self, from: &'t str) -> &'t str {
        let words: Vec<&str> = from.split('|').collect();
        words[self.below(words.len())]
    }

    fn letters(&mut self, most: usize) -> String {
        let count = 1 + self.below(most);
        let letter = |dice: &mut Self| char::from(b'a' + dice.below(26) as u8);
        (0..count).map(|_| letter(self)).collect()
    }

    /// An unexpected value.
    fn value(&mut self) -> String {
        const PLAIN: &str = "nan|-nan|inf|-inf|0|-0.0|1e-300|1e300|-1e300|1e999|-1|0.5|1e-7|1e-9|1e9|1e10|4294967295\
            |4294967296|9223372036854775807|0x7fffffffffffffff|0b1|true|false|2026-01-01|\"\"\
            |\"\\u0007\\u001b[31m\"|[]|{}|[0.0, 0.0]|[1.0, -1.0]|[-1e300, 1e300]|[1e-300, 1e300]\
            |[[1.0, 0.0], [0.0, 1.0]]|[[1.0], [nan]]|{ kind = \"low-pass\", cutoff = 1e-300 }\
            |{ kind = \"difference\" }|{ a = [0.0, 1e9], b = [1e-9, 1e9] }|{ kp = 1e9, kd = 1e9, ki = 1e9 }\
            |[\"a\", \"b\", \"coulomb\", \"load\"]|[\"load\", \"a\"]|\"f64\"|\"fixed\"|'''\nx\n'''|1_000.0\
            |+1.0||\"|[|{|1.|.5";
        const NAMES: &str = "band-limited-white-noise|prbs|multisine|chirp|square|steps|none|gradient|gauss-newton\
            |paper|pd-gradient|relay-least-squares|low-pass|averaged-difference";
        match self.below(12) {
            0 => format!("\"{}\"", self.letters(3000)),
            which @ 1..=2 => {
                let (depth, (open, close)) =
                    (self.below(3000), [("[", "]"), ("{x=", "}")][which - 1]);
                format!("{}1{}", open.repeat(depth), close.repeat(depth))
            }
            3 => format!("[{}]", "1.0,".repeat(self.below(30_000))),
            4 => "9".repeat(1 + self.below(500)),
            5 | 6 => format!("\"{}\"", self.word_of(NAMES)),
            7 => {
                let size = self.0.next_word() as f64 / 2e19 - 0.3;
                format!("{:e}", size * 10_f64.powi(self.below(40) as i32 - 20))
            }
            8 => format!("[{}e0, {}e0]", self.below(100), self.below(10_000)),
            _ => self.word_of(PLAIN).to_owned(),
        }
    }

    /// A line whose numbers are of another size.
    fn other_numbers(&mut self, line: &str) -> String {
        let number = |c: char| c.is_ascii_digit() || c == '.';
        let mut other = String::new();
        let mut rest = line;
        while let Some(begin) = rest.find(|c: char| c.is_ascii_digit()) {
            let (before, from) = rest.split_at(begin);
            let end = from.find(|c| !number(c)).unwrap_or(from.len());
            other.push_str(before);
            match from[..end].parse::<f64>() {
                Ok(value) => {
                    let factor = 2.0_f64.powi(self.below(9) as i32 - 4);
                    let value = value * factor;
                    let whole = !from[..end].contains('.') && factor >= 1.0;
                    other += &if whole {
                        format!("{value}")
                    } else {
                        format!("{value:?}")
                    };
                }
                Err(_) => other.push_str(&from[..end]),
            }
            rest = &from[end..];
        }
        other + rest
    }

    /// A scenario of the repository, damaged in some places.
    fn scenario(&mut self) -> Vec<u8> {
        let path = format!("scenarios/{}.toml", self.word_of(SCENARIOS));
        let text = std::fs::read_to_string(path).expect("a scenario");
        let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
        for _ in 0..=self.below(3) {
            let place = self.below(lines.len());
            let stated = lines[place].split_once('=');
            let stated = stated.map(|(name, _)| name.trim().to_owned());
            match (self.below(14), stated) {
                (8.., Some(_)) => lines[place] = self.other_numbers(&lines[place]),
                (0..=2, Some(name)) => lines[place] = format!("{name} = {}", self.value()),
                (3, Some(_)) => lines.insert(place, lines[place].clone()),
                (4, Some(name)) => {
                    let mut slipped = name.clone();
                    if let Some((slip, _)) = name.char_indices().nth(self.below(name.len())) {
                        slipped.remove(slip);
                    }
                    lines[place] = lines[place].replacen(&name, &slipped, 1);
                }
                (5, _) => lines.insert(place, format!("{} = {}", self.letters(200), self.value())),
                (6, _) => {
                    let key = &KEYS[self.below(KEYS.len())];
                    let (table, name) = key.place();
                    let line = format!("{name} = {}", self.value());
                    let head = format!("[{table}]");
                    match lines.iter().position(|line| line.starts_with(&head)) {
                        Some(place) => lines.insert(place + 1, line),
                        None => lines.push(format!("{head}\n{line}")),
                    }
                }
                _ => {
                    lines.remove(place);
                }
            }
            if lines.is_empty() {
                break;
            }
        }
        let mut bytes = lines.join("\n").into_bytes();
        match self.below(20) {
            0 => bytes.truncate(self.below(bytes.len())),
            1 => {
                for _ in 0..1 + self.below(10) {
                    let place = self.below(bytes.len());
                    if let Some(byte) = bytes.get_mut(place) {
                        *byte = self.0.next_word() as u8;
                    }
                }
            }
            2 => {
                bytes.resize(self.below(2000), 0);
                bytes.fill_with(|| self.0.next_word() as u8);
            }
            _ => {}
        }
        bytes
    }
}

/// Peak memory of this process, bytes; `None` where the system does not report it.
fn peak_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let mut lines = status.lines();
    let line = lines.find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kilobytes: u64 = line.trim().strip_suffix(" kB")?.trim().parse().ok()?;
    Some(kilobytes << 10)
}

/// Reads the longest file that is made of such pieces.
fn largest_of(piece: impl Fn(usize) -> String) {
    const MAX_SCENARIO_BYTES: usize = 1 << 20;
    const MAX_READ_TIME: Duration = Duration::from_secs(20);
    let mut text = String::new();
    for i in 0.. {
        let next = piece(i);
        if text.len() + next.len() > MAX_SCENARIO_BYTES {
            break;
        }
        text.push_str(&next);
    }
    let begun = Instant::now();
    let outcome = Scenario::parse("s.toml", &text, Purpose::Run);
    let taken = begun.elapsed();
    println!("{:?}: {taken:?}, {:?}", &piece(1), peak_memory());
    assert!(taken < MAX_READ_TIME, "{:?}: {taken:?}", piece(1));
    let answer = outcome.expect_err("it is no scenario").to_string();
    assert!(answer.starts_with("s.toml:"), "{answer}");
}

/// Any file is read or refused: no panic, no long wait, little memory, and a message that helps. With
/// `FUZZED_SCENARIOS=10000` in the environment it reads 10 000 instead of a thousand.
#[test]
fn damaged_scenarios_are_read_or_refused() {
    const MAX_READ_TIME: Duration = Duration::from_secs(10);
    const MEMORY: u64 = 200 << 20;
    let asked = std::env::var("FUZZED_SCENARIOS").ok();
    let count = asked.map_or(1000, |count| count.parse().expect("a number of scenarios"));
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("fuzzed-bytes.toml");
    let (mut read, mut refused, mut slowest) = (0, 0, Duration::ZERO);
    for seed in 0..count {
        let bytes = Dice(SplitMix64::new(seed)).scenario();
        for purpose in [Purpose::Run, Purpose::Replay, Purpose::Commission] {
            let begun = Instant::now();
            let text = std::str::from_utf8(&bytes);
            let outcome = catch_unwind(AssertUnwindSafe(|| match text {
                Ok(text) => Scenario::parse("s.toml", text, purpose),
                Err(_) => {
                    std::fs::write(&path, &bytes).expect("written");
                    Scenario::load(&path, purpose)
                }
            }));
            let taken = begun.elapsed();
            slowest = slowest.max(taken);
            assert!(taken < MAX_READ_TIME, "seed {seed}: {taken:?}");
            match (outcome.unwrap_or_else(|_| panic!("seed {seed}")), text) {
                (Ok(scenario), _) => {
                    read += 1;
                    assert!(scenario.samples() > 0, "seed {seed}");
                }
                (Err(error), Ok(text)) => {
                    refused += 1;
                    let answer = error.to_string();
                    let checked = catch_unwind(|| assert_readable(&answer, text));
                    assert!(checked.is_ok(), "seed {seed}");
                }
                (Err(error), Err(_)) => {
                    refused += 1;
                    assert!(error.line.is_some(), "seed {seed}: {error}");
                }
            }
        }
    }
    // Files as long as they may be, of all that takes room.
    for piece in ["a.a.a.b", "[[run]]\n", "x = 1\n", "# \u{3b1}\n", "'"] {
        largest_of(|_| piece.to_owned());
    }
    largest_of(|i| format!("x{i} = 1\n"));
    largest_of(|i| format!("[x{i}]\n"));
    largest_of(|i| format!("{}1,", if i == 0 { "x = [" } else { "" }));
    largest_of(|i| format!("{}\"\\n\",", if i == 0 { "x = [" } else { "" }));
    let memory = peak_memory();
    println!("{read} read, {refused} refused, slowest {slowest:?}, memory {memory:?}");
    assert!(read * 20 > refused && refused * 20 > read);
    assert!(memory.is_none_or(|most| most < MEMORY), "{memory:?}");
}
