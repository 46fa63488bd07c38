//! The program in a terminal: width, colours, quiet, names, suggestions and completions.

use std::process::Output;

use crate::support::terminal::Terminal;
use crate::support::{
    Folder, folder_with_paper, own_folder, printed, scenario_text, standard_error,
};

/// Accents that take no room of their own.
fn marks(line: &str) -> usize {
    line.matches('\u{302}').count()
}

/// A call with a variable of the environment.
fn called(variable: &str, value: &str, folder: &Folder, words: &str) -> Output {
    let output = folder.program(words).env(variable, value).output();
    output.expect("the program starts")
}

/// Its output.
fn with(variable: &str, value: &str, folder: &Folder, words: &str) -> String {
    printed(&called(variable, value, folder, words))
}

/// Asserts that a text keeps to a number of characters a line, but for a word, which is not divided.
fn assert_fits(words: &str, text: &str) {
    let room: usize = WIDTH.parse().expect("a number");
    for line in text.lines() {
        let fits = line.chars().count() <= room + marks(line);
        assert!(
            fits || !line.trim().contains(' '),
            "{words} at {WIDTH}:\n{line}"
        );
    }
}

const WIDTH: &str = "60";

#[test]
fn tables_fit_the_width_and_list_omitted_columns() {
    let folder = own_folder();
    // A table is the lines above and below a rule.
    let table = |text: &str| -> Vec<String> {
        let lines: Vec<_> = text.lines().collect();
        let rule = lines
            .iter()
            .position(|line| line.starts_with('─'))
            .expect("a table");
        lines[rule - 1..]
            .iter()
            .take_while(|line| !line.starts_with("Nominal"))
            .map(ToString::to_string)
            .collect()
    };
    let mut headings = Vec::new();
    for (columns, left_out) in [("80", true), ("100", true), ("200", false)] {
        let text = with("COLUMNS", columns, &folder, "");
        let table = table(&text);
        let room: usize = columns.parse().expect("a number");
        assert!(
            table
                .iter()
                .all(|line| line.chars().count() <= room + marks(line)),
            "{text}"
        );
        assert_eq!(text.contains("(narrow terminal: "), left_out, "{text}");
        assert!(
            table
                .iter()
                .filter(|line| line.contains("converged"))
                .count()
                >= 3,
            "{text}"
        );
        headings.push(table[0].trim_end().chars().count());
    }
    // In a file or a pipe there is no terminal.
    assert!(!folder.done("").contains("narrow terminal"));
    assert!(
        headings.is_sorted() && headings[0] < headings[2],
        "{headings:?}"
    );
}

/// Verbs with all that they need, in a folder with a scenario, a short comparison, a log and a result.
const VERBS: [&str; 18] = [
    "",
    "paper --out paper --force",
    "export result.json --format json --torque-constant 0.1",
    "run scenario.toml",
    "identify log.csv",
    "identify log.csv --torque-constant 0.1 --command-unit V",
    "identify log.csv --scenario scenario.toml",
    "tune result.json --resonance inf",
    "commission commission.toml",
    "compare compare.toml",
    "sweep scenario.toml --runs 3",
    "run scenario.toml --formats",
    "keys",
    "keys plant",
    "keys identifier.law",
    "run --help",
    "drive configure --help",
    "completions --help",
];

/// Calls that are refused, in that folder.
const WRONG: [&str; 15] = [
    "identifi",
    "run missing.toml",
    "run scenario.toml --jsn x",
    "run scenario.toml --csv scenario.toml",
    "identify scenario.toml",
    "identify .",
    "identify log.csv --scenario nothing.toml",
    "tune scenario.toml",
    "commission scenario.toml",
    "sweep scenario.toml --runs 0",
    "reproduce result.json",
    "export result.json --format mjcf",
    "keys plant.deley",
    "drive status",
    "drive --port tcp:127.0.0.1:1 status",
];

#[test]
fn every_verb_keeps_to_the_width_of_the_terminal_and_writes_nothing_of_its_own() {
    let folder = folder_with_paper("terminal-widths", "3.0");
    folder.write("commission.toml", scenario_text("commission.toml"));
    folder.write_scenario("compare.toml", "60.0", "1.0");
    folder.done("run scenario.toml --csv log.csv --json result.json");
    folder.done(VERBS[1]);
    let before = folder.names();
    for words in VERBS {
        let text = with("COLUMNS", WIDTH, &folder, words);
        assert!(!text.is_empty(), "{words}");
        assert_fits(words, &text);
    }
    for words in WRONG {
        let output = called("COLUMNS", WIDTH, &folder, words);
        assert!(!output.status.success(), "{words}");
        assert_fits(words, &standard_error(&output));
    }
    assert_eq!(folder.names(), before);
}

#[test]
fn only_terminals_get_colours() {
    let folder = folder_with_paper("terminal-colours", "3.0");
    let plain = with("CLICOLOR", "1", &folder, "run scenario.toml");
    assert!(!plain.contains('\u{1b}'), "{plain}");
    let coloured = with("CLICOLOR_FORCE", "1", &folder, "run scenario.toml");
    assert!(coloured.contains('\u{1b}'), "{coloured}");
    let bare = anstream::adapter::strip_str(&coloured).to_string();
    assert_eq!(bare, plain);
}

#[test]
fn a_terminal_shows_colours_unless_they_are_disabled() {
    let folder = folder_with_paper("terminal-no-colour", "3.0");
    for (setting, is_coloured) in [("CLICOLOR=1", true), ("NO_COLOR=1", false)] {
        let words = [
            "env",
            "-u",
            "NO_COLOR",
            setting,
            env!("CARGO_BIN_EXE_servo-id"),
            "run",
            "scenario.toml",
        ];
        let mut terminal = Terminal::start(&words, &folder, 100, 40);
        // The status, which has a colour, is the last line.
        terminal.shows("converged: all estimates");
        assert_eq!(terminal.is_coloured(), is_coloured, "{setting}");
        terminal.ends();
    }
}

#[test]
fn quiet_prints_only_errors_and_requested_output() {
    let folder = folder_with_paper("terminal-quiet", "3.0");
    let run = |words: &str| with("LANG", "C", &folder, words);
    assert_eq!(run("run scenario.toml --quiet"), "");
    assert_eq!(run("--quiet run scenario.toml"), "");
    assert!(run("run scenario.toml -q --json -").starts_with('{'));
    assert!(run("keys -q").contains("plant.a"));
}
