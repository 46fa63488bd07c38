//! Pages of HTML, each whole in one file, for a browser that has no network. Texts that a user wrote, names of files
//! and of scenarios, are escaped.

mod block;

use maud::{DOCTYPE, Markup, PreEscaped, html};

use crate::present::{Figure, Page, Section};
use crate::program;

const STYLE: &str = include_str!("page.css");
const SCRIPT: &str = include_str!("page.js");
const PLOT_STYLE: &str = include_str!("vendor/uPlot-1.6.32/uPlot.min.css");
const PLOT_SCRIPT: &str = include_str!("vendor/uPlot-1.6.32/uPlot.iife.min.js");

/// Nothing is loaded from anywhere, whatever the page contains.
const POLICY: &str =
    "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src data:";

/// A page as one file.
#[must_use]
pub fn page(page: &Page) -> String {
    html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="generator" content=(program::NAME);
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta http-equiv="Content-Security-Policy" content=(POLICY);
                meta name="color-scheme" content="light dark";
                title { (page.title) }
                link rel="icon" href="data:,";
                style { (PreEscaped(PLOT_STYLE)) (PreEscaped(STYLE)) }
            }
            body { (body(page)) }
        }
    }
    .into_string()
}

fn body(page: &Page) -> Markup {
    html! {
        a.skip href="#main" { "To the result" }
        header {
            h1 { (page.title) }
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
                    (text(section))
                }
            }
        }
        footer {
            p { "Version " (crate::VERSION) ", called as" }
            pre tabindex="0" { code { (page.command) } }
            p { "The page docs/report.md explains its parts, docs/results.md its figures and their uncertainty." }
            p { "Plots by uPlot 1.6.32, MIT licence, © 2022 Leon Sorokin." }
        }
        @if !page.figures().is_empty() {
            script type="application/json" id="figures" { (PreEscaped(figures_json(page))) }
            script { (PreEscaped(PLOT_SCRIPT)) }
            script { (PreEscaped(SCRIPT)) }
        }
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

#[cfg(test)]
mod tests {
    use serde_json::Value;

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
