//! The reports: self-contained, small and safe.

use crate::support::{Folder, own_folder, packed_log, scenario_text};

/// The report of a call that must succeed.
fn reported(folder: &Folder, words: &str) -> String {
    folder.done(&format!("{words} --report report.html --force"));
    folder.read("report.html")
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

/// The title of a figure that only an axis has on which gravity or cogging acts.
const LOAD_BY_ANGLE: &str = "Load by the angle";

#[test]
fn every_verb_reports() {
    let folder = own_folder();
    for name in [
        "friction.toml",
        "sweep.toml",
        "commission.toml",
        "commission_gravity.toml",
        "replay.toml",
    ] {
        folder.write(name, scenario_text(name));
    }
    folder.write("log.csv.gz", packed_log());
    folder.write_scenario("compare.toml", "duration = 60.0", "duration = 2.0");
    for (words, part) in [
        ("run friction.toml --json result.json --csv rows.csv", ""),
        ("identify log.csv.gz --scenario replay.toml", ""),
        ("commission commission.toml", "of the trial"),
        ("commission commission_gravity.toml", LOAD_BY_ANGLE),
        (
            "tune result.json --scenario friction.toml --resonance inf",
            "",
        ),
        ("sweep sweep.toml --runs 3", ""),
        ("compare compare.toml", "relay-least-squares"),
    ] {
        let page = reported(&folder, words);
        assert_self_contained(&page);
        assert!(page.contains(part), "{words}");
        assert_eq!(page.contains(LOAD_BY_ANGLE), part == LOAD_BY_ANGLE);
        // A sweep and a comparison are tables.
        let is_drawn = !words.starts_with("sweep") && !words.starts_with("compare");
        for part in ["<svg class=\"drawing\"", "<noscript>"] {
            assert_eq!(page.contains(part), is_drawn, "{words}");
        }
    }
    // To a dash it is standard output.
    assert_self_contained(&folder.done("run friction.toml --report -"));
}

#[test]
fn user_text_is_escaped() {
    let folder = own_folder();
    folder.write(
        "<img src=x onerror=alert(1)>&\"'.toml",
        scenario_text("friction.toml"),
    );
    let mut call = folder.program("run --report report.html");
    let output = call.arg("<img src=x onerror=alert(1)>&\"'.toml").output();
    crate::support::assert_done(&output.expect("the program starts"));
    let page = folder.read("report.html");
    assert!(!page.contains("<img"), "a name became markup");
    assert!(page.contains("&lt;img src=x onerror=alert(1)&gt;&amp;"));
}

#[test]
fn a_failed_result_shows_its_remedy_and_no_gains() {
    let folder = own_folder();
    folder.write_scenario("friction.toml", "duration = 8.0", "duration = 0.3");
    let page = reported(&folder, "run friction.toml");
    assert!(page.contains("no-information") && !page.contains("kp = "));
}
