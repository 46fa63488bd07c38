//! Files that are no scenario are refused: with place and remedy, and within bounds.

use crate::support::readable::assert_readable;
use crate::support::{own_folder, standard_error, table};
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
    assert_names("[plant]\n", &["s.toml:1: plant.a: "]);
    assert_names("[plant]\na = 2.0\n", &["s.toml:1: plant.b: "]);
    // The lines that the messages advise are enough.
    let advice = refusal("");
    let (_, lines) = advice.split_once(":\n").expect("an example");
    Scenario::parse("s.toml", lines, Purpose::Run).expect("the example is a scenario");
    let replay = |text| Scenario::parse("s.toml", text, Purpose::Replay);
    let columns = "[log]\ntime = \"t\"\nposition = \"q\"\n";
    let advice = replay(columns).expect_err("no command").to_string();
    assert!(advice.contains("log.command"), "{advice}");
}

#[test]
fn a_misspelt_key_is_answered_with_the_nearest_name() {
    let long = format!("\"{}\\u0007\" = 1", "x".repeat(5000));
    for (line, parts) in [
        ("laod = 1.0", ["s.toml:4: plant.laod: ", "load?"]),
        ("[contoller]", ["s.toml:4: contoller", "controller?"]),
        ("kp = 1.0", ["plant.kp", "controller.kp?"]),
        (
            "[identifier]\nlaw = \"gaus-newton\"",
            ["s.toml:5", "\"gauss-newton\"?"],
        ),
        ("[identifier]\nrelay = 1.0", ["identifier.relay", "gamma"]),
        (&long, ["s.toml:4: plant.xxxx", ""]),
    ] {
        assert_names(&format!("{PLANT}{line}\n"), &parts);
    }
    let unlike = refusal(&format!("{PLANT}zzzzzz = 1\n"));
    assert!(!unlike.contains('?'), "{unlike}");
}

/// A table below the servo, and the key to state and the default that the message names.
const DEFAULTS: &str = r#"
[excitation]; kind = "none" | s.toml:5: excitation.kind |
[controller]; sample_time = 0.3 | sample_time = 0.1 | 0.6
[excitation]; kind = "square"; amplitude = 0.1; period = 0.001 | 0.002 |
"#;

#[test]
fn messages_name_a_default_as_such() {
    for row in table(DEFAULTS) {
        assert_names(&format!("{PLANT}{}\n", row[0]), &[&row[1], &row[2]]);
    }
}

#[test]
fn a_number_without_a_digit_before_its_point_is_shown_how() {
    for value in [".3", "-.3", "+.3", " .3"] {
        let text = format!("[plant]\na = 1\nb ={value}\n");
        assert_names(&text, &["s.toml:3: ", "0.5"]);
    }
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
    let folder = own_folder();
    let huge = std::fs::File::create(folder.join("huge.toml")).expect("created");
    huge.set_len(100 << 20).expect("100 MB");
    std::fs::create_dir(folder.join("folder")).expect("created");
    let brackets = ["[", "]"].map(|bracket| bracket.repeat(100_000));
    let deep = format!("{PLANT}load = {}\n", brackets.join("1"));
    let dots = format!("{PLANT}{}x = 1\n", "x.".repeat(100_000));
    let numbers = "1,".repeat(500_000);
    let list = format!("{PLANT}[excitation]\nkind = \"steps\"\nhold = 0.1\nlevels = [{numbers}]\n");
    let files: [(&str, &[u8], &str); 7] = [
        ("empty.toml", b"", "plant: "),
        ("latin.toml", b"[plant]\n# \xb5\n", "latin.toml:2: "),
        ("wide.toml", b"\xff\xfe[\0p\0", "wide.toml:1: "),
        ("nul.toml", b"[plant]\n\0", "nul.toml:2: "),
        ("deep.toml", deep.as_bytes(), "deep.toml:4: "),
        ("dots.toml", dots.as_bytes(), "dots.toml:4: "),
        ("list.toml", list.as_bytes(), "list.toml:7: "),
    ];
    for (name, bytes, _) in files {
        folder.write(name, bytes);
    }
    let written = files.map(|(name, _, place)| (name, place));
    let others = [("folder", "folder"), ("huge.toml", "1048576")];
    for (name, place) in written.into_iter().chain(others) {
        let path = folder.join(name);
        let error = Scenario::load(&path, Purpose::Run).expect_err(name);
        let answer = error.to_string();
        assert!(answer.contains(place), "{place}: {answer}");
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
    let folder = own_folder();
    folder.write("s.toml", "[plant]\na = 3.1\nb = 850000\n");
    let output = folder.call("run s.toml");
    let answer = standard_error(&output);
    assert_eq!(output.status.code(), Some(1), "{answer}");
    assert!(!answer.contains("encoder"), "{answer}");
}
