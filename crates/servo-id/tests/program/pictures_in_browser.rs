//! Pictures and reports in a browser, looked at for cut text, overlap and empty figures.

use std::fs;
use std::path::{Path, PathBuf};

use crate::support::browser::Browser;
use crate::support::{folder, scenario, servo_id, standard_error};
use serde_json::{Value, json};

/// Faults of a picture: text outside it, text on text, and frames without a trace.
const FAULTS_OF_PICTURE: &str = "
    const SLACK = 0.5;
    const faults = [];
    const box = (element) => element.getBoundingClientRect();
    const whole = box(document.documentElement);
    const texts = [...document.querySelectorAll('text')].filter((text) => text.textContent !== 'ˆ');
    if (texts.length < 5) faults.push('hardly any text');
    // A line of text is higher than its letters.
    const letters = texts.map((text) => {
        const { left, right, top, height } = box(text);
        return { left, right, top: top + 0.2 * height, bottom: top + 0.8 * height, text: text.textContent };
    });
    for (const { left, right, top, bottom, text } of letters)
        if (left < whole.left - SLACK || right > whole.right + SLACK || top < whole.top || bottom > whole.bottom)
            faults.push(`cut: ${text}`);
    letters.forEach((one, place) => letters.slice(place + 1).forEach((other) => {
        const apart = one.right < other.left + SLACK || other.right < one.left + SLACK
            || one.bottom < other.top + SLACK || other.bottom < one.top + SLACK;
        if (!apart) faults.push(`overlap: ${one.text} and ${other.text}`);
    }));
    for (const group of document.querySelectorAll('g[clip-path]')) {
        const name = group.getAttribute('clip-path').slice(5, -1);
        const rectangle = document.getElementById(name).firstChild;
        const [left, top, width, height] = ['x', 'y', 'width', 'height'].map((of) => Number(rectangle.getAttribute(of)));
        // Dashes are levels, and areas have no stroke.
        const traces = [...group.querySelectorAll('path[stroke]:not([stroke-dasharray])')];
        const seen = traces.some((trace) => {
            const of = trace.getBBox();
            const across = Math.min(of.x + of.width, left + width) - Math.max(of.x, left);
            const down = Math.min(of.y + of.height, top + height) - Math.max(of.y, top);
            return across > 0.2 * width && down >= 0;
        });
        if (!seen) faults.push(`empty: frame ${name}`);
    }
    return faults;";

/// Faults of the plots of a report: figures at an axis that have too little room, or stand on one another; plots
/// without a trace.
const FAULTS_OF_PLOTS: &str = "
    const faults = [];
    plots.forEach(({ chart }, number) => {
        const [across, down] = chart.axes;
        const { x, y } = chart.scales;
        const is_seen = (trace) => trace.some((value, place) => value != null && value >= y.min && value <= y.max
            && chart.data[0][place] >= x.min && chart.data[0][place] <= x.max);
        if (!chart.data.slice(1).some(is_seen)) faults.push(`plot ${number} is empty`);
        const width = (text, { font }) => {
            [chart.ctx.font] = font;
            return chart.ctx.measureText(text).width / devicePixelRatio;
        };
        const written = (axis) => axis._values.map((text, place) => [text, axis._splits[place]]).filter(([text]) => text);
        if (written(down).length < 2) faults.push(`plot ${number} has ${written(down).length} figures at its left`);
        for (const [text] of written(down))
            if (width(text, down) + down.ticks.size + down.gap > down._size) faults.push(`plot ${number}: ${text} is cut`);
        const twice = written(down).map(([text]) => text);
        if (new Set(twice).size < twice.length) faults.push(`plot ${number}: equal figures ${twice}`);
        let end = 0;
        for (const [text, at] of written(across)) {
            const middle = chart.valToPos(at, 'x') + chart.over.offsetLeft;
            const half = width(text, across) / 2;
            if (middle - half < end) faults.push(`plot ${number}: ${text} stands on another figure or is cut`);
            end = middle + half;
        }
        if (end > chart.width) faults.push(`plot ${number}: the last figure below is cut`);
    });
    return faults;";

/// Faults of a report on a phone: parts that are wider than the screen.
const FAULTS_ON_PHONE: &str = "
    const faults = [];
    for (const { scrollWidth, clientWidth, textContent } of document.querySelectorAll('.table'))
        if (scrollWidth > clientWidth) faults.push(`${scrollWidth} of ${clientWidth}: ${textContent.slice(0, 40)}`);
    return faults;";

/// Lower ends, from the top of the page, of the first true value and of the first error.
const TRUTH_AND_ERROR: &str = "
    return ['true', 'off by'].map((name) => {
        const { bottom, right } = document.querySelector(`td[data-column='${name}']`).getBoundingClientRect();
        return right <= innerWidth ? bottom + scrollY : Infinity;
    });";

const PHONE: [u32; 2] = [360, 740];

/// The verbs whose result is a table.
const TABLES: [&str; 2] = ["compare", "sweep"];

fn assert_faultless(browser: &Browser, question: &str, of: &str) {
    let faults = browser.ask(question);
    assert_eq!(faults, json!([]), "{of}");
}

/// Runs the program, with a picture as SVG, if the verb draws one, and a report; their addresses.
fn drawn(folder: &Path, name: &str, words: &[&str]) -> [String; 2] {
    let file = |end: &str| folder.join(format!("{name}.{end}")).display().to_string();
    let (picture, report) = (file("svg"), file("html"));
    let mut words = [words, &["--report", &report]].concat();
    if !TABLES.contains(&words[0]) {
        words.extend(["--plot", &picture]);
    }
    let output = servo_id(&words);
    assert!(output.status.success(), "{}", standard_error(&output));
    [picture, report].map(|file| format!("file://{file}"))
}

/// A comparison of two seconds, which has all that the long one has but good estimates.
fn short_comparison(folder: &Path) -> PathBuf {
    let text = fs::read_to_string(scenario("compare.toml")).expect("readable");
    let short = text.replace("duration = 60.0", "duration = 2.0");
    assert_ne!(short, text);
    let file = folder.join("compare.toml");
    fs::write(&file, short).expect("written");
    file
}

#[test]
fn pictures_and_reports_have_no_cut_text_no_overlap_and_no_empty_figure() {
    let Some(browser) = Browser::start() else {
        return;
    };
    let folder = folder("pictures-in-browser");
    let result = folder.join("result.json").display().to_string();
    let [friction, paper, sweep, commission] = [
        "friction.toml",
        "paper.toml",
        "sweep.toml",
        "commission_gravity.toml",
    ]
    .map(scenario);
    let log =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../../host-sim/logs/simulated-servo.csv.gz");
    let log = log.display().to_string();
    let comparison = short_comparison(&folder).display().to_string();
    let cases: [(&str, &[&str]); 9] = [
        ("run", &["run", &friction, "--json", &result]),
        ("tune", &["tune", &result, "--resonance", "inf"]),
        ("identify", &["identify", &log]),
        ("identify-column", &["identify", &log, "--size", "column"]),
        ("column", &["run", &friction, "--size", "column"]),
        ("long", &["run", &paper]),
        ("commission", &["commission", &commission]),
        ("sweep", &["sweep", &sweep, "--runs", "20"]),
        ("compare", &["compare", &comparison]),
    ];
    for (name, words) in cases {
        let [picture, report] = drawn(&folder, name, words);
        if !TABLES.contains(&words[0]) {
            browser.open(&picture);
            assert_faultless(&browser, FAULTS_OF_PICTURE, &picture);
        }
        for (screen, dots) in [([1280, 1000], 1), (PHONE, 2)] {
            browser.show_on(screen, dots);
            browser.open(&report);
            let of = format!("{report} on {screen:?}");
            if browser.ask("return typeof plots") == "object" {
                assert_faultless(&browser, FAULTS_OF_PLOTS, &of);
            }
        }
        assert_faultless(&browser, FAULTS_ON_PHONE, &report);
        if name == "run" {
            let ends: Vec<Value> =
                serde_json::from_value(browser.ask(TRUTH_AND_ERROR)).expect("two");
            let are_seen = |end: &Value| end.as_f64().is_some_and(|end| end <= f64::from(PHONE[1]));
            assert!(ends.iter().all(are_seen), "{ends:?}");
        }
    }
}
