//! The reports in a browser: plots, keys, colours, widths and print.

use std::time::Duration;

use crate::support::browser::{Browser, SEEN, number};
use crate::support::{folder, scenario, servo_id, standard_error};
use serde_json::{Value, json};

/// Keys by their WebDriver names.
const RIGHT: &str = "\u{e014}";
const TAB: &str = "\u{e004}";
const ENTER: &str = "\u{e007}";

/// The address of a report of a verb.
fn report(test: &str, words: &[&str]) -> String {
    let report = folder(test).join("report.html").display().to_string();
    let mut words = words.to_vec();
    words.extend(["--report", &report]);
    let output = servo_id(&words);
    assert!(output.status.success(), "{}", standard_error(&output));
    format!("file://{report}")
}

/// Colours of each plot that are seen at all.
fn colours(browser: &Browser) -> Value {
    let all = "return plots.map(({ chart }) => seen(chart.ctx.canvas));";
    browser.ask(&format!("{SEEN}{all}"))
}

/// The visible range of the first plot's abscissa.
const SHOWN: &str = "const { min, max } = plots[0].chart.scales.x; return max - min;";

fn assert_drawn(browser: &Browser, plots: usize) {
    let colours = colours(browser);
    let colours = colours.as_array().expect("a list");
    assert_eq!(colours.len(), plots);
    for (place, seen) in colours.iter().enumerate() {
        let count = seen.as_array().map_or(0, Vec::len);
        assert!(count > 3, "plot {place} has {count} colours");
    }
}

#[test]
fn a_report_is_drawn_and_answers_keys_and_pointer() {
    let Some(browser) = Browser::start() else {
        return;
    };
    browser.open(&report("browser-run", &["run", &scenario("friction.toml")]));
    browser.assert_silent();
    assert_drawn(&browser, 7);
    // The last value of the first trace of the second plot is b.
    let b = browser
        .ask("const { data } = plots[1].chart; return data.at(-1).findLast((v) => v != null);");
    assert!((number(&b) - 257.7).abs() < 1.0, "{b}");

    let whole = number(&browser.ask(SHOWN));
    assert!((whole - 8.0).abs() < 0.01, "{whole}");
    browser.ask("document.querySelector('.canvas').focus();");
    browser.press(&[RIGHT, RIGHT]);
    let value = browser.ask("return document.querySelector('.legend output').textContent;");
    assert!(
        value.as_str().is_some_and(|text| text.starts_with("0.2")),
        "{value}"
    );
    browser.press(&["+"]);
    assert!((number(&browser.ask(SHOWN)) - whole / 2.0).abs() < 0.01);
    let others =
        browser.ask("return plots.every(({ chart: { scales: { x } } }) => x.max - x.min < 5);");
    assert_eq!(others, true, "all plots of one time are zoomed together");
    browser.press(&["0"]);
    assert!((number(&browser.ask(SHOWN)) - whole).abs() < 1e-9);

    // From the plot the next stop is the name of its trace, which switches it.
    browser.press(&[TAB, ENTER]);
    let switched = browser.ask(
        "return [document.activeElement.getAttribute('aria-pressed'), plots[0].chart.series.at(-1).show];",
    );
    assert_eq!(switched, json!(["false", false]));
    browser.press(&[ENTER]);
    let switched = browser.ask("return plots[0].chart.series.at(-1).show;");
    assert_eq!(switched, true);
    browser.ask("document.querySelector('[data-zoom=in]').focus();");
    browser.press(&[ENTER]);
    assert!((number(&browser.ask(SHOWN)) - whole / 2.0).abs() < 0.01);
    browser.ask("document.querySelector('[data-zoom=reset]').click();");

    browser.ask("document.querySelector('.canvas').scrollIntoView({ block: 'center' });");
    let place = browser.ask(
        "const { left, top, width, height } = plots[0].chart.over.getBoundingClientRect();
         return [left, top, width, height].map(Math.round);",
    );
    let place: Vec<i64> = serde_json::from_value(place).expect("four numbers");
    let at = |part: f64| {
        [
            place[0] + (part * place[2] as f64) as i64,
            place[1] + place[3] / 2,
        ]
    };
    browser.drag(at(0.25), at(0.5));
    let zoomed = number(&browser.ask(SHOWN));
    assert!((zoomed - whole / 4.0).abs() < 0.1, "{zoomed}");
    browser.assert_silent();
}

#[test]
fn a_report_fits_dark_light_phone_and_paper() {
    let Some(browser) = Browser::start() else {
        return;
    };
    browser.open(&report(
        "browser-looks",
        &["commission", &scenario("commission.toml")],
    ));
    assert_drawn(&browser, 6);
    let paper = "return getComputedStyle(document.body).backgroundColor;";
    let in_scheme = |scheme: &str| {
        browser.prefer(&[["prefers-color-scheme", scheme]]);
        assert_drawn(&browser, 6);
        (browser.ask(paper), colours(&browser))
    };
    let light = in_scheme("light");
    assert_eq!(light.0, "rgb(255, 255, 255)");
    // Plots are drawn anew by an event after the change.
    let mut dark = in_scheme("dark");
    for _ in 0..100 {
        if dark.1 != light.1 {
            break;
        }
        std::thread::sleep(Duration::from_millis(100));
        dark = in_scheme("dark");
    }
    assert_ne!(light.0, dark.0);
    assert!(light.1 != dark.1, "the plots are drawn in the same colours");

    browser.show_on([390, 844], 2);
    std::thread::sleep(Duration::from_millis(300));
    let widths = browser.ask(
        "return [document.documentElement.scrollWidth, ...plots.map(({ chart }) => chart.width)];",
    );
    let widths: Vec<f64> = serde_json::from_value(widths).expect("numbers");
    assert!(widths.iter().all(|width| *width <= 390.0), "{widths:?}");
    assert_drawn(&browser, 6);

    browser.emulate("setEmulatedMedia", &json!({ "media": "print" }));
    let printed = browser.ask(
        "const shown = (part) => getComputedStyle(document.querySelector(part)).display;
         return [shown('.drawing'), shown('.uplot'), shown('.toolbar')];",
    );
    assert_eq!(printed, json!(["block", "none", "none"]));
    browser.assert_silent();
}
