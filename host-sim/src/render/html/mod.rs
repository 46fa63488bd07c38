//! Pages of HTML, each whole in one file, for a browser that has no network. Texts that a user wrote, names of files
//! and of scenarios, are escaped.

mod block;

use maud::{DOCTYPE, Markup, PreEscaped, html};
use serde_json::{Map, Value, json};

use crate::present::{Figure, Page, Progress, Section};

const STYLE: &str = include_str!("page.css");
const SCRIPT: &str = include_str!("page.js");
const FOLLOWING: &str = include_str!("live.js");
const PLOT_STYLE: &str = include_str!("vendor/uPlot-1.6.32/uPlot.min.css");
const PLOT_SCRIPT: &str = include_str!("vendor/uPlot-1.6.32/uPlot.iife.min.js");

/// Nothing is loaded from anywhere, whatever the page contains; a page that follows a run asks its own server.
const POLICY: &str =
    "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src data:";

/// A page as one file.
#[must_use]
pub fn page(page: &Page) -> String {
    document(page, None)
}

/// A page of a run, as its server shows it.
#[must_use]
pub fn live_page(page: &Page, progress: Progress) -> String {
    document(page, Some(progress))
}

/// Changes to an earlier page of the run that a browser shows, JSON.
#[must_use]
pub fn changes(page: &Page, progress: Progress) -> String {
    if progress == Progress::Over {
        return json!({ "over": true }).to_string();
    }
    let texts = page
        .sections
        .iter()
        .filter(|section| !section.has_figures());
    let texts = texts.map(|section| (text_anchor(section), text(section).into_string()));
    let verdict = block::verdict(&page.verdict).into_string();
    let parts = texts.chain([("verdict".to_owned(), verdict)]);
    let parts: Map<String, Value> = parts.map(|(id, html)| (id, html.into())).collect();
    let parts = Value::from(parts);
    format!(
        r#"{{"over":false,"parts":{parts},"figures":{}}}"#,
        figures_json(page)
    )
}

fn document(page: &Page, progress: Option<Progress>) -> String {
    let connect = match progress {
        Some(Progress::Underway) => "; connect-src 'self'",
        _ => "",
    };
    html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta http-equiv="Content-Security-Policy" content=(format!("{POLICY}{connect}"));
                meta name="color-scheme" content="light dark";
                title { (page.title) }
                link rel="icon" href="data:,";
                style { (PreEscaped(PLOT_STYLE)) (PreEscaped(STYLE)) }
            }
            body { (body(page, progress)) }
        }
    }
    .into_string()
}

fn body(page: &Page, progress: Option<Progress>) -> Markup {
    html! {
        a.skip href="#main" { "To the result" }
        header {
            h1 { (page.title) }
            @match progress {
                Some(Progress::Underway) => p #stage role="status" { "The run goes on; this page follows it." },
                Some(Progress::Over) => p #stage role="status" { "The run is over; this page stays." },
                None => {}
            }
            div #verdict { (block::verdict(&page.verdict)) }
            nav aria-label="Sections" {
                @for section in &page.sections {
                    a href=(format!("#{}", anchor(section))) { (section.heading) }
                }
            }
        }
        main #main {
            @for section in &page.sections {
                section #(anchor(section)) {
                    h2 { (section.heading) }
                    div #(text_anchor(section)) { (text(section)) }
                }
            }
        }
        footer {
            p { "Version " (crate::VERSION) ", called as" }
            pre tabindex="0" { code { (page.command) } }
            p { "Plots by uPlot 1.6.32, MIT licence, © 2022 Leon Sorokin." }
        }
        @if !page.figures().is_empty() {
            script type="application/json" id="figures" { (PreEscaped(figures_json(page))) }
            script { (PreEscaped(PLOT_SCRIPT)) }
            script { (PreEscaped(SCRIPT)) }
        }
        @if progress == Some(Progress::Underway) { script { (PreEscaped(FOLLOWING)) } }
    }
}

/// The figures as JSON that may stand in a page: `<` is escaped.
fn figures_json(page: &Page) -> String {
    let figures: Vec<Figure> = page.figures().iter().map(Figure::shortened).collect();
    // Writing into memory cannot fail: undefined numbers are null.
    let text = serde_json::to_string(&figures).unwrap_or_default();
    text.replace('<', "\\u003c")
}

fn text(section: &Section) -> Markup {
    let blocks = section.blocks.iter().enumerate();
    html! {
        @for (place, block) in blocks {
            (block::block(block, &format!("{}-{place}", anchor(section))))
        }
    }
}

/// Name of a section's place in the page.
fn anchor(section: &Section) -> String {
    section.heading.to_lowercase().replace(' ', "-")
}

/// Name of the place of its content.
fn text_anchor(section: &Section) -> String {
    format!("{}-text", anchor(section))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::present::{Block, TIME, Tone, Verdict};

    #[test]
    fn no_text_ends_the_script_that_it_stands_in() {
        let figure = Figure::new("</script><b>", TIME, "", Vec::new());
        let verdict = Verdict {
            tone: Tone::Good,
            status: String::new(),
            headline: String::new(),
            detail: String::new(),
        };
        let section = Section::full("Over time", vec![Block::Figures(vec![figure])]);
        let text = figures_json(&Page::new("", "", verdict, [section]));
        assert!(!text.contains('<'), "{text}");
        let read: Value = serde_json::from_str(&text).expect("JSON");
        assert_eq!(read[0]["title"], "</script><b>");
    }
}
