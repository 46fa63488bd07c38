//! What is no scenario is refused: with its place, with what to do, and within bounds.

mod support;

use std::fmt::Write;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::{Duration, Instant};

use host_sim::scenario::keys::KEYS;
use host_sim::scenario::{Purpose, Scenario};
use support::{folder, host_sim, standard_error};

const SCENARIOS: [&str; 8] = [
    include_str!("../scenarios/compare.toml"),
    include_str!("../scenarios/drift.toml"),
    include_str!("../scenarios/friction.toml"),
    include_str!("../scenarios/minimal.toml"),
    include_str!("../scenarios/paper-least-squares.toml"),
    include_str!("../scenarios/paper.toml"),
    include_str!("../scenarios/replay.toml"),
    include_str!("../scenarios/sweep.toml"),
];

const PLANT: &str = "[plant]\na = 0.5\nb = 200.0\n";

/// What a text is answered with when it is read for a run.
fn refusal(text: &str) -> String {
    let error = Scenario::parse("s.toml", text, Purpose::Run).expect_err("it is wrong");
    let answer = error.to_string();
    assert_readable(&answer, text);
    answer
}

fn assert_says(text: &str, parts: &[&str]) {
    let answer = refusal(text);
    for part in parts {
        assert!(answer.contains(part), "{part:?} is missing:\n{answer}");
    }
}

/// A message names file and line, in words that are no programmer's, and shows little of the file.
fn assert_readable(answer: &str, text: &str) {
    /// Characters of the input that a message may show in a row.
    const MOST: usize = 80;
    let line = answer
        .strip_prefix("s.toml:")
        .and_then(|rest| rest.split_once(':'));
    let line: Option<usize> = line.and_then(|(line, _)| line.parse().ok());
    let lines = text.split('\n').count();
    assert!(
        line.is_some_and(|line| (1..=lines).contains(&line)),
        "no line: {answer}"
    );
    assert!(
        !answer.contains(|c: char| c.is_control() && c != '\n'),
        "a control character: {answer:?}"
    );
    for word in [
        "expected f64",
        "expected u",
        "expected i",
        "expected a ",
        "struct",
        "invalid type",
        "missing field",
        "unknown field",
        "variant",
        "visitor",
        "NaN %",
        "Some(",
        "None",
    ] {
        assert!(
            !answer.contains(word),
            "{word:?} is no user's word: {answer}"
        );
    }
    let shown: Vec<char> = answer.chars().collect();
    for piece in shown.windows(MOST + 1) {
        let piece: String = piece.iter().collect();
        assert!(!text.contains(&piece), "too much is shown: {piece}");
    }
}

#[test]
fn a_first_file_is_led_to_a_run() {
    assert_says(
        "",
        &[
            "s.toml:1: plant: a run needs",
            "write, for example:",
            "[plant]",
            "a = ",
            "b = ",
        ],
    );
    assert_says("[plant]\n", &["s.toml:1: plant.a: ", "1/s", "a = 0.5 "]);
    assert_says(
        "[plant]\na = 2.0\n",
        &["s.toml:1: plant.b: ", "b = 200.0 ", "acceleration"],
    );
    // What the messages say to write is enough.
    let advice = refusal("");
    let lines = advice
        .split_once("write, for example:\n")
        .expect("an example")
        .1;
    Scenario::parse("s.toml", lines, Purpose::Run).expect("the example is a scenario");
    let replay = |text| Scenario::parse("s.toml", text, Purpose::Replay);
    let columns = "[log]\ntime = \"t\"\nposition = \"q\"\n";
    let advice = replay(columns).expect_err("no command").to_string();
    assert!(advice.contains("log.command"), "{advice}");
}

#[test]
fn what_is_misspelt_is_answered_with_the_nearest_name() {
    let with = |line: &str| format!("{PLANT}{line}\n");
    assert_says(
        &with("laod = 1.0"),
        &[
            "s.toml:4: plant.laod: there is no such key",
            "did you mean load?",
        ],
    );
    assert_says(
        &with("[contoller]"),
        &["s.toml:4: contoller", "did you mean controller?"],
    );
    assert_says(
        &with("kp = 1.0"),
        &["plant.kp", "did you mean controller.kp?"],
    );
    assert_says(
        &with("[identifier]\nlaw = \"gaus-newton\""),
        &["s.toml:5", "did you mean \"gauss-newton\"?"],
    );
    assert_says(
        &with("[identifier]\nrelay = 1.0"),
        &["\"gradient\" does not take this key", "gamma"],
    );
    let long = "x".repeat(5000);
    assert_says(
        &with(&format!("\"{long}\\u0007\" = 1")),
        &["s.toml:4: plant.xxxx"],
    );
    let unlike = refusal(&with("zzzzzz = 1"));
    assert!(!unlike.contains("did you mean"), "{unlike}");
}

#[test]
fn what_is_of_another_kind_is_named_as_people_do() {
    let with = |line: &str| format!("{PLANT}{line}\n");
    for (line, says) in [
        ("load = \"heavy\"", "a text stands where a number belongs"),
        ("load = true", "true or false stands where a number belongs"),
        ("load = [1.0]", "a list stands where a number belongs"),
        ("load = { x = 1 }", "there is no such key"),
        ("load = 2026-01-01", "a date stands where a number belongs"),
        ("load = nan", "load = NaN is not allowed"),
        ("load = -inf", "load = -inf is not allowed"),
        ("load = 1e999", "load = inf is not allowed"),
        ("coulomb = -1e300", "coulomb = -1e300 is not allowed"),
        ("load = 0xffffffffffffffffffffffffffff", "too many digits"),
        ("run = 5", "did you mean"),
        ("[run]\nduration = 1e300", "from 0.001 to 1e7"),
        ("[run]\nduration = 1e-300", "duration = 1e-300"),
        ("[[run]]\nduration = 1.0", "write [run] once"),
        (
            "[excitation]\nseed = 1.5",
            "a number stands where a whole number belongs",
        ),
        (
            "[excitation]\nseed = 4294967296",
            "a whole number from 0 to 4294967295",
        ),
        (
            "[excitation]\nkind = 3",
            "a number stands where a text belongs",
        ),
        (
            "[excitation]\nkind = \"steps\"\nhold = 0.1\nlevels = []",
            "0 entries, where 1 to 16 belong",
        ),
        (
            "[identifier]\nparameters = \"a\"",
            "a text stands where a list belongs",
        ),
        (
            "[identifier]\ngamma = [[1.0], 2.0]",
            "row 0 has 1 entries for 2 parameters",
        ),
        ("[amplifier]\nlimit = [1.0]", "1 numbers where two belong"),
        (
            "[encoder]\ncounts_per_rev = 1e300",
            "encoder.counts_per_rev",
        ),
        (
            "[controller]\nsample_time = 1e-300",
            "controller.sample_time",
        ),
        ("load = 1.0\nload = 2.0", "load: this is stated twice"),
        ("load =", "a value is missing behind ="),
        ("load = heavy", "quotes"),
        ("load", "not TOML"),
    ] {
        assert_says(&with(line), &[says]);
    }
}

/// What nobody wrote is nobody's fault: the message says which key to state, and what is its default.
#[test]
fn no_key_is_blamed_that_nobody_wrote() {
    let still = refusal(&format!("{PLANT}[excitation]\nkind = \"none\"\n"));
    assert!(still.contains("s.toml:5: excitation.kind"), "{still}");
    assert!(
        still.contains("does not move the servo") && !still.contains("NaN"),
        "{still}"
    );
    let slow = refusal(&format!("{PLANT}[controller]\nsample_time = 0.01\n"));
    assert!(
        slow.contains("cutoff = 500") && slow.contains("below 314"),
        "{slow}"
    );
    assert!(
        slow.contains("the file does not state it: the default is 500"),
        "{slow}"
    );
    let between = refusal(&format!(
        "{PLANT}[excitation]\nkind = \"square\"\namplitude = 0.1\nperiod = 0.001\n"
    ));
    assert!(between.contains("a whole multiple of 0.002"), "{between}");
    assert!(!between.contains(" from "), "{between}");
}

#[test]
fn files_that_are_no_text_are_refused_by_name() {
    let folder = folder("no-text");
    let write = |name: &str, bytes: &[u8]| {
        let path = folder.join(name);
        std::fs::write(&path, bytes).expect("written");
        path.display().to_string()
    };
    let huge = folder.join("huge.toml");
    let file = std::fs::File::create(&huge).expect("created");
    file.set_len(100 << 20).expect("100 MB");
    let deep = format!(
        "{PLANT}load = {}1{}\n",
        "[".repeat(100_000),
        "]".repeat(100_000)
    );
    let dots = format!("{PLANT}{}x = 1\n", "x.".repeat(100_000));
    let list = format!(
        "{PLANT}[excitation]\nkind = \"steps\"\nhold = 0.1\nlevels = [{}]\n",
        "1,".repeat(500_000)
    );
    for (path, says) in [
        (folder.display().to_string(), "a folder"),
        (huge.display().to_string(), "at most 1048576 bytes"),
        (
            write("empty.toml", b""),
            "plant: a run needs the true servo",
        ),
        (
            write("latin.toml", b"[plant]\n# \xb5\n"),
            "latin.toml:2: this is not text in UTF-8",
        ),
        (
            write("wide.toml", b"\xff\xfe[\0p\0"),
            "wide.toml:1: this is not text in UTF-8",
        ),
        (write("nul.toml", b"[plant]\n\0"), "nul.toml:2: at column"),
        (
            write("deep.toml", deep.as_bytes()),
            "deep.toml:4: tables or lists are nested too deeply",
        ),
        (
            write("dots.toml", dots.as_bytes()),
            "dots.toml:4: tables or lists are nested too deeply",
        ),
        (
            write("list.toml", list.as_bytes()),
            "list.toml:7: excitation.levels: 500000 entries",
        ),
    ] {
        let output = host_sim(&["run", &path]);
        let answer = standard_error(&output);
        assert_eq!(output.status.code(), Some(2), "{answer}");
        assert!(answer.contains(says), "{says:?} is missing: {answer}");
        assert!(output.stdout.is_empty());
    }
}

#[test]
fn marks_of_other_editors_do_no_harm() {
    let marked = format!("\u{feff}{PLANT}");
    let returns = PLANT.replace('\n', "\r\n");
    for text in [&marked, &returns] {
        Scenario::parse("s.toml", text, Purpose::Run).expect("a scenario");
    }
    assert_says(&format!("{returns}laod = 1\r\n"), &["s.toml:4: plant.laod"]);
}

/// Numbers that look random, the same in every run.
struct Dice(u64);

impl Dice {
    /// SplitMix64 (Steele, Lea, Flood 2014).
    fn roll(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let x = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        x ^ (x >> 31)
    }

    fn below(&mut self, most: usize) -> usize {
        (self.roll() % most.max(1) as u64) as usize
    }

    fn of<'t>(&mut self, from: &[&'t str]) -> &'t str {
        from[self.below(from.len())]
    }

    fn letters(&mut self, most: usize) -> String {
        let count = 1 + self.below(most);
        let letter = |dice: &mut Self| char::from(b'a' + dice.below(26) as u8);
        (0..count).map(|_| letter(self)).collect()
    }

    /// A value as nobody expects it.
    fn value(&mut self) -> String {
        const PLAIN: &[&str] = &[
            "nan",
            "-nan",
            "inf",
            "-inf",
            "0",
            "-0.0",
            "1e-300",
            "1e300",
            "-1e300",
            "1e999",
            "-1",
            "0.5",
            "1e-7",
            "1e-9",
            "1e9",
            "1e10",
            "4294967295",
            "4294967296",
            "9223372036854775807",
            "0x7fffffffffffffff",
            "0b1",
            "true",
            "false",
            "2026-01-01",
            "\"\"",
            "\"\\u0007\\u001b[31m\"",
            "[]",
            "{}",
            "[0.0, 0.0]",
            "[1.0, -1.0]",
            "[-1e300, 1e300]",
            "[1e-300, 1e300]",
            "[[1.0, 0.0], [0.0, 1.0]]",
            "[[1.0], [nan]]",
            "{ kind = \"low-pass\", cutoff = 1e-300 }",
            "{ kind = \"difference\" }",
            "{ a = [0.0, 1e9], b = [1e-9, 1e9] }",
            "{ kp = 1e9, kd = 1e9, ki = 1e9 }",
            "[\"a\", \"b\", \"coulomb\", \"load\"]",
            "[\"load\", \"a\"]",
            "\"f64\"",
            "\"fixed\"",
            "'''\nx\n'''",
            "1_000.0",
            "+1.0",
            "",
            "\"",
            "[",
            "{",
            "1.",
            ".5",
        ];
        const NAMES: &[&str] = &[
            "band-limited-white-noise",
            "prbs",
            "multisine",
            "chirp",
            "square",
            "steps",
            "none",
            "gradient",
            "gauss-newton",
            "window",
            "pd-gradient",
            "relay-least-squares",
            "proportional-least-squares",
            "two-degrees-of-freedom",
            "multi-step-least-squares",
            "relay-cycle",
            "two-relays",
            "closed-loop-arx",
            "mechanical-least-squares",
            "low-pass",
            "averaged-difference",
        ];
        match self.below(12) {
            0 => format!("\"{}\"", self.letters(3000)),
            1 => {
                let depth = self.below(3000);
                format!("{}1{}", "[".repeat(depth), "]".repeat(depth))
            }
            2 => {
                let depth = self.below(3000);
                format!("{}1{}", "{x=".repeat(depth), "}".repeat(depth))
            }
            3 => format!("[{}]", "1.0,".repeat(self.below(30_000))),
            4 => "9".repeat(1 + self.below(500)),
            5 | 6 => format!("\"{}\"", self.of(NAMES)),
            7 => format!(
                "{:e}",
                (self.roll() as f64 / 2e19 - 0.3) * 10_f64.powi(self.below(40) as i32 - 20)
            ),
            8 => format!(
                "[{:e}, {:e}]",
                self.below(100) as f64,
                self.below(10_000) as f64
            ),
            _ => self.of(PLAIN).to_owned(),
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
                    let whole = !from[..end].contains('.') && factor >= 1.0;
                    other += &if whole {
                        format!("{}", value * factor)
                    } else {
                        format!("{:?}", value * factor)
                    };
                }
                Err(_) => other.push_str(&from[..end]),
            }
            rest = &from[end..];
        }
        other + rest
    }

    /// A scenario of the repository that was hurt in some places.
    fn scenario(&mut self) -> Vec<u8> {
        let mut lines: Vec<String> = self.of(&SCENARIOS).lines().map(str::to_owned).collect();
        for _ in 0..=self.below(3) {
            let place = self.below(lines.len());
            let stated = lines[place]
                .split_once('=')
                .map(|(name, _)| name.trim().to_owned());
            match (self.below(14), stated) {
                (8.., Some(_)) => lines[place] = self.other_numbers(&lines[place]),
                (0..=2, Some(name)) => lines[place] = format!("{name} = {}", self.value()),
                (3, Some(_)) => lines.insert(place, lines[place].clone()),
                (4, Some(name)) => {
                    let slip = self.below(name.len());
                    let slipped: String = name
                        .chars()
                        .enumerate()
                        .filter(|(i, _)| *i != slip)
                        .map(|(_, c)| c)
                        .collect();
                    lines[place] = lines[place].replacen(&name, &slipped, 1);
                }
                (5, _) => lines.insert(place, format!("{} = {}", self.letters(200), self.value())),
                (6, _) => {
                    let key = &KEYS[self.below(KEYS.len())];
                    let (table, name) = key.place();
                    let line = format!("{name} = {}", self.value());
                    match lines
                        .iter()
                        .position(|line| line.starts_with(&format!("[{table}]")))
                    {
                        Some(head) => lines.insert(head + 1, line),
                        None => lines.push(format!("[{table}]\n{line}")),
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
                        *byte = self.roll() as u8;
                    }
                }
            }
            2 => bytes = (0..self.below(2000)).map(|_| self.roll() as u8).collect(),
            _ => {}
        }
        bytes
    }
}

/// Largest memory that this process has had, bytes; none where the system does not tell.
fn most_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status
        .lines()
        .find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kilobytes: u64 = line.trim().strip_suffix(" kB")?.trim().parse().ok()?;
    Some(kilobytes << 10)
}

/// Reads the longest file that is made of such pieces.
fn largest_of(piece: impl Fn(usize) -> String) {
    const LONGEST: usize = 1 << 20;
    const PATIENCE: Duration = Duration::from_secs(20);
    let mut text = String::new();
    for i in 0.. {
        let next = piece(i);
        if text.len() + next.len() > LONGEST {
            break;
        }
        text.push_str(&next);
    }
    let begun = Instant::now();
    let outcome = Scenario::parse("s.toml", &text, Purpose::Run);
    let taken = begun.elapsed();
    println!("{:?}: {taken:?}, {:?}", &piece(1), most_memory());
    assert!(taken < PATIENCE, "{:?}: {taken:?}", piece(1));
    let answer = outcome.expect_err("it is no scenario").to_string();
    assert!(answer.starts_with("s.toml:"), "{answer}");
}

/// Any file is read or refused: no panic, no long wait, little memory, and a message that helps. With
/// `FUZZED_SCENARIOS=10000` in the environment it takes so many in place of a thousand.
#[test]
fn hurt_scenarios_are_read_or_refused() {
    const LONGEST: Duration = Duration::from_secs(10);
    const MEMORY: u64 = 200 << 20;
    let asked = std::env::var("FUZZED_SCENARIOS").ok();
    let count = asked.map_or(1000, |count| count.parse().expect("a number of scenarios"));
    let folder = folder("fuzz");
    let path = folder.join("bytes.toml");
    let (mut read, mut refused, mut slowest) = (0, 0, Duration::ZERO);
    for seed in 0..count {
        let bytes = Dice(seed).scenario();
        for purpose in [Purpose::Run, Purpose::Replay] {
            let begun = Instant::now();
            let text = std::str::from_utf8(&bytes);
            let outcome = catch_unwind(AssertUnwindSafe(|| match text {
                Ok(text) => Scenario::parse("s.toml", text, purpose),
                Err(_) => {
                    std::fs::write(&path, &bytes).expect("written");
                    Scenario::load(&path, purpose)
                }
            }));
            slowest = slowest.max(begun.elapsed());
            assert!(
                begun.elapsed() < LONGEST,
                "seed {seed}: {:?}",
                begun.elapsed()
            );
            match (outcome.unwrap_or_else(|_| panic!("seed {seed}")), text) {
                (Ok(scenario), _) => {
                    read += 1;
                    assert!(scenario.samples() > 0, "seed {seed}");
                }
                (Err(error), Ok(text)) => {
                    refused += 1;
                    let mut answer = String::new();
                    write!(answer, "{error}").expect("written");
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
    let memory = most_memory();
    println!("{read} read, {refused} refused, slowest {slowest:?}, memory {memory:?}");
    assert!(
        read * 20 > refused && refused * 20 > read,
        "{read} read, {refused} refused"
    );
    assert!(memory.is_none_or(|most| most < MEMORY), "{memory:?}");
}

#[test]
fn an_unstable_loop_is_not_the_encoders_fault() {
    let path = folder("unstable").join("s.toml");
    std::fs::write(&path, "[plant]\na = 3.1\nb = 850000\n").expect("written");
    let output = host_sim(&["run", &path.display().to_string()]);
    let answer = standard_error(&output);
    assert_eq!(output.status.code(), Some(1), "{answer}");
    assert!(answer.contains("the sampled loop is unstable"), "{answer}");
    assert!(!answer.contains("encoder"), "{answer}");
}
