//! Files that are no scenario are refused: with place and remedy, and within bounds.

use crate::support::readable::assert_readable;
use crate::support::{folder, servo_id, standard_error};
use host_sim::scenario::{Purpose, Scenario};

const PLANT: &str = "[plant]\na = 0.5\nb = 200.0\n";

/// Message about a text that is read for a run.
fn refusal(text: &str) -> String {
    let error = Scenario::parse("s.toml", text, Purpose::Run).expect_err("it is wrong");
    let answer = error.to_string();
    assert_readable(&answer, text);
    answer
}

fn assert_names(text: &str, parts: &[&str]) {
    let answer = refusal(text);
    for part in parts {
        assert!(answer.contains(part), "{part:?} is missing:\n{answer}");
    }
}

#[test]
fn following_the_messages_turns_an_empty_file_into_a_run() {
    assert_names(
        "",
        &[
            "s.toml:1: plant: a run needs",
            "write, for example:",
            "[plant]",
            "a = ",
            "b = ",
        ],
    );
    assert_names("[plant]\n", &["s.toml:1: plant.a: ", "1/s", "a = 0.5 "]);
    assert_names(
        "[plant]\na = 2.0\n",
        &["s.toml:1: plant.b: ", "b = 200.0 ", "acceleration"],
    );
    // The lines that the messages advise are enough.
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
fn a_misspelt_key_is_answered_with_the_nearest_name() {
    let with = |line: &str| format!("{PLANT}{line}\n");
    assert_names(
        &with("laod = 1.0"),
        &[
            "s.toml:4: plant.laod: there is no such key",
            "did you mean load?",
        ],
    );
    assert_names(
        &with("[contoller]"),
        &["s.toml:4: contoller", "did you mean controller?"],
    );
    assert_names(
        &with("kp = 1.0"),
        &["plant.kp", "did you mean controller.kp?"],
    );
    assert_names(
        &with("[identifier]\nlaw = \"gaus-newton\""),
        &["s.toml:5", "did you mean \"gauss-newton\"?"],
    );
    assert_names(
        &with("[identifier]\nrelay = 1.0"),
        &["\"gradient\" does not take this key", "gamma"],
    );
    let long = "x".repeat(5000);
    assert_names(
        &with(&format!("\"{long}\\u0007\" = 1")),
        &["s.toml:4: plant.xxxx"],
    );
    let unlike = refusal(&with("zzzzzz = 1"));
    assert!(!unlike.contains("did you mean"), "{unlike}");
}

#[test]
fn a_wrong_type_is_named_in_plain_words() {
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
        assert_names(&with(line), &[says]);
    }
}

/// A message about a default names the key to state and the default.
#[test]
fn messages_name_a_default_as_such() {
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
fn a_number_without_a_digit_before_its_point_is_shown_how() {
    for value in [".3", "-.3", "+.3", " .3"] {
        assert_names(
            &format!("[plant]\na = 1\nb ={value}\n"),
            &["s.toml:3: ", "0.5, not .5"],
        );
    }
    assert_names("[plant]\na =\n", &["a value is missing behind ="]);
}

/// A terminal obeys control characters, which a text may spell.
#[test]
fn a_message_shows_no_control_character() {
    for text in [
        "[identifier]\nlaw = \"\\u001b[31mgradient\"\n",
        "[identifier]\nparameters = [\"\\u0007\"]\n",
        "\"\\u001b]0;title\" = 1\n",
        "[plant]\na = 1\nb = 2\n\"b\\r\" = 2\n",
    ] {
        assert_names(text, &["\u{fffd}"]);
    }
}

#[test]
fn binary_files_are_refused_by_name() {
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
        let output = servo_id(&["run", &path]);
        let answer = standard_error(&output);
        assert_eq!(output.status.code(), Some(2), "{answer}");
        assert!(answer.contains(says), "{says:?} is missing: {answer}");
        assert!(output.stdout.is_empty());
    }
}

#[test]
fn byte_order_marks_and_carriage_returns_do_no_harm() {
    let marked = format!("\u{feff}{PLANT}");
    let returns = PLANT.replace('\n', "\r\n");
    for text in [&marked, &returns] {
        Scenario::parse("s.toml", text, Purpose::Run).expect("a scenario");
    }
    assert_names(&format!("{returns}laod = 1\r\n"), &["s.toml:4: plant.laod"]);
}

#[test]
fn an_unstable_loop_is_not_the_encoders_fault() {
    let path = folder("unstable").join("s.toml");
    std::fs::write(&path, "[plant]\na = 3.1\nb = 850000\n").expect("written");
    let output = servo_id(&["run", &path.display().to_string()]);
    let answer = standard_error(&output);
    assert_eq!(output.status.code(), Some(1), "{answer}");
    assert!(answer.contains("the sampled loop is unstable"), "{answer}");
    assert!(!answer.contains("encoder"), "{answer}");
}
