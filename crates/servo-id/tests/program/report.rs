//! The reports: self-contained, small and safe.

use std::fs;
use std::path::Path;

use crate::support::{folder, scenario, servo_id, standard_error};

/// Runs a command that must succeed, with a report; the report.
fn reported(folder: &Path, words: &[&str]) -> String {
    let report = folder.join("report.html");
    let mut words = words.to_vec();
    let name = report.display().to_string();
    words.extend(["--report", &name, "--force"]);
    let output = servo_id(&words);
    assert!(
        output.status.success(),
        "{words:?}: {}",
        standard_error(&output)
    );
    fs::read_to_string(report).expect("the report is written")
}

/// A page is complete and small, and loads nothing from elsewhere.
fn assert_self_contained(page: &str) {
    /// Bytes of a report at most.
    const MAX_PAGE_BYTES: usize = 2_000_000;
    assert!(page.starts_with("<!DOCTYPE html>") && page.ends_with("</html>"));
    assert!(page.len() < MAX_PAGE_BYTES, "{} bytes", page.len());
    assert!(page.contains("default-src 'none'"));
    // A drawing refers to its own clips.
    let page = page.replace("url(#", "");
    for reference in ["src=", "@import", "url(", "href=\"http", "<base", "<form"] {
        assert!(!page.contains(reference), "{reference}");
    }
}

#[test]
fn every_verb_reports() {
    let folder = folder("report-verbs");
    let path = |name: &str| folder.join(name).display().to_string();
    let log =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../../host-sim/logs/simulated-servo.csv.gz");
    let log = log.display().to_string();
    let (result, csv) = (path("result.json"), path("rows.csv"));
    let [friction, sweep, commission, logged] = [
        "friction.toml",
        "sweep.toml",
        "commission.toml",
        "replay.toml",
    ]
    .map(scenario);
    for words in [
        &["run", &friction, "--json", &result, "--csv", &csv][..],
        &["identify", &log, "--scenario", &logged],
        &["commission", &commission],
        &["tune", &result, "--scenario", &friction],
        &["sweep", &sweep, "--runs", "3"],
    ] {
        let page = reported(&folder, words);
        assert_self_contained(&page);
        // A sweep is a table.
        for part in ["<svg class=\"drawing\"", "<noscript>"] {
            assert_eq!(page.contains(part), words[0] != "sweep", "{words:?}");
        }
    }
}

#[test]
fn a_comparison_is_reported() {
    let folder = folder("report-compare");
    let text = fs::read_to_string(scenario("compare.toml")).expect("the scenario");
    let short = folder.join("short.toml");
    let text = text.replace("duration = 60.0", "duration = 2.0");
    fs::write(&short, text).expect("the scenario is written");
    let page = reported(&folder, &["compare", &short.display().to_string()]);
    assert_self_contained(&page);
    assert!(page.contains("relay-least-squares"));
}

#[test]
fn user_text_is_escaped() {
    let folder = folder("report-escape");
    let evil = "<img src=x onerror=alert(1)>&\"'.toml";
    let text = fs::read_to_string(scenario("friction.toml")).expect("the scenario");
    let path = folder.join(evil);
    fs::write(&path, text).expect("the scenario is written");
    let page = reported(&folder, &["run", &path.display().to_string()]);
    assert!(!page.contains("<img"), "a name became markup");
    assert!(page.contains("&lt;img src=x onerror=alert(1)&gt;&amp;"));
}

#[test]
fn a_failed_result_shows_its_remedy_and_no_gains() {
    let folder = folder("report-none");
    let text = fs::read_to_string(scenario("friction.toml")).expect("the scenario");
    let short = folder.join("short.toml");
    fs::write(&short, text.replace("duration = 8.0", "duration = 0.3")).expect("it is written");
    let page = reported(&folder, &["run", &short.display().to_string()]);
    assert!(page.contains("no-information") && !page.contains("kp = "));
}

#[test]
fn a_report_to_a_dash_is_standard_output() {
    let output = servo_id(&["run", &scenario("friction.toml"), "--report", "-"]);
    assert!(output.status.success(), "{}", standard_error(&output));
    assert_self_contained(&String::from_utf8(output.stdout).expect("text"));
}
