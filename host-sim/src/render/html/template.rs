//! How a page is set.

use maud::{DOCTYPE, Markup, PreEscaped, html};

use serde_json::{Map, Value, json};

use super::{
    Block, Figure, Page, Progress, Section, Stretch, Stroke, Table, Tone, Verdict, data, drawing,
};

const STYLE: &str = include_str!("page.css");
const SCRIPT: &str = include_str!("page.js");
const FOLLOWING: &str = include_str!("live.js");
const PLOT_STYLE: &str = include_str!("vendor/uPlot-1.6.32/uPlot.min.css");
const PLOT_SCRIPT: &str = include_str!("vendor/uPlot-1.6.32/uPlot.iife.min.js");

/// Nothing is loaded from anywhere, whatever the page says; a page that follows a run asks its own server.
const POLICY: &str =
    "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src data:";

impl Page {
    /// The page as one file of HTML.
    #[must_use]
    pub fn html(&self) -> String {
        self.set(None)
    }

    /// The page of a run that a server shows.
    #[must_use]
    pub fn live_html(&self, stage: Progress) -> String {
        self.set(Some(stage))
    }

    /// What a browser that shows an earlier page of the run must change, JSON.
    #[must_use]
    pub fn change(&self, stage: Progress) -> String {
        if stage == Progress::Over {
            return json!({ "over": true }).to_string();
        }
        let texts = self
            .sections
            .iter()
            .filter(|section| !section.has_figures());
        let mut parts: Map<String, Value> = texts
            .map(|section| {
                (
                    text_anchor(section),
                    self.text(section).into_string().into(),
                )
            })
            .collect();
        parts.insert(
            "verdict".to_owned(),
            verdict(&self.verdict).into_string().into(),
        );
        let figures: Vec<&Figure> = self.figures().collect();
        let parts = Value::from(parts);
        format!(
            r#"{{"over":false,"parts":{parts},"figures":{}}}"#,
            data::json(&figures)
        )
    }

    fn set(&self, stage: Option<Progress>) -> String {
        let connect = match stage {
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
                    title { (self.title) }
                    link rel="icon" href="data:,";
                    style { (PreEscaped(PLOT_STYLE)) (PreEscaped(STYLE)) }
                }
                body { (self.body(stage)) }
            }
        }
        .into_string()
    }

    fn body(&self, stage: Option<Progress>) -> Markup {
        let figures: Vec<&Figure> = self.figures().collect();
        html! {
            a.skip href="#main" { "To the result" }
            header {
                h1 { (self.title) }
                @match stage {
                    Some(Progress::Underway) => p #stage role="status" { "The run goes on; this page follows it." },
                    Some(Progress::Over) => p #stage role="status" { "The run is over; this page stays." },
                    None => {}
                }
                div #verdict { (verdict(&self.verdict)) }
                nav aria-label="Sections" {
                    @for section in &self.sections {
                        a href=(format!("#{}", anchor(section))) { (section.heading) }
                    }
                }
            }
            main #main {
                @for section in &self.sections {
                    section #(anchor(section)) {
                        h2 { (section.heading) }
                        div #(text_anchor(section)) { (self.text(section)) }
                    }
                }
            }
            footer {
                p { "Version " (crate::VERSION) ", called as" }
                pre tabindex="0" { code { (self.command) } }
                p { "Plots by uPlot 1.6.32, MIT licence, © 2022 Leon Sorokin." }
            }
            @if !figures.is_empty() {
                script type="application/json" id="figures" { (PreEscaped(data::json(&figures))) }
                script { (PreEscaped(PLOT_SCRIPT)) }
                script { (PreEscaped(SCRIPT)) }
            }
            @if stage == Some(Progress::Underway) { script { (PreEscaped(FOLLOWING)) } }
        }
    }

    fn figures(&self) -> impl Iterator<Item = &Figure> {
        let blocks = self.sections.iter().flat_map(|section| &section.blocks);
        blocks.flat_map(|block| match block {
            Block::Figures(figures) => figures.as_slice(),
            _ => &[],
        })
    }

    fn text(&self, section: &Section) -> Markup {
        html! { @for block in &section.blocks { (self.block(block)) } }
    }

    fn block(&self, block: &Block) -> Markup {
        match block {
            Block::Text(text) => html! { p { (text) } },
            Block::Warning(text) => html! { p { strong { "Warning: " } (text) } },
            Block::List(items) => html! { ul { @for item in items { li { (item) } } } },
            Block::Facts(facts) => html! {
                dl { @for (name, text) in facts { div { dt { (name) } dd { (text) } } } }
            },
            Block::Table(table) => self::table(table),
            Block::Code { caption, text } => html! {
                figure.code { figcaption { (caption) } pre tabindex="0" { code { (text) } } }
            },
            Block::Figures(figures) => html! {
                (toolbar())
                noscript { p { "Without scripts the plots are drawings: they neither zoom nor switch traces." } }
                (stretches(figures))
                div.figures { @for figure in figures { (plot(figure)) } }
            },
        }
    }
}

/// The name that a section is found by.
fn anchor(section: &Section) -> String {
    section.heading.to_lowercase().replace(' ', "-")
}

/// The name that what it says is found by.
fn text_anchor(section: &Section) -> String {
    format!("{}-text", anchor(section))
}

fn verdict(verdict: &Verdict) -> Markup {
    let tone = match verdict.tone {
        Tone::Good => "good",
        Tone::Doubtful => "doubtful",
        Tone::Failed => "failed",
        Tone::Underway => "underway",
    };
    html! {
        div.verdict.(tone) {
            p.status { (verdict.status) }
            p.headline { (verdict.headline) }
            p { (verdict.detail) }
        }
    }
}

fn table(table: &Table) -> Markup {
    let class = |place: usize| table.columns.get(place).filter(|column| column.is_figures);
    let class = |place: usize| class(place).map(|_| "figures");
    html! {
        div.table tabindex="0" role="region" aria-label=(table.caption) {
            table {
                caption { (table.caption) }
                thead { tr {
                    @for (place, column) in table.columns.iter().enumerate() {
                        th scope="col" class=[class(place)] { (column.name) }
                    }
                } }
                tbody { @for (number, row) in table.rows.iter().enumerate() { tr {
                    @for (place, cell) in row.iter().enumerate() {
                        @if place == 0 { th scope="row" { (cell) } }
                        @else {
                            td class=[class(place)] data-level=[level(table, number, place)] { (cell) }
                        }
                    }
                } } }
            }
        }
    }
}

fn level(table: &Table, row: usize, place: usize) -> Option<u8> {
    table.levels.get(row)?.get(place).copied()
}

/// What zooms every plot; of use where there is a script alone.
fn toolbar() -> Markup {
    html! {
        div.toolbar role="toolbar" aria-label="Zoom of the plots" hidden {
            button type="button" data-zoom="in" { "Zoom in" }
            button type="button" data-zoom="out" { "Zoom out" }
            button type="button" data-zoom="left" aria-label="To the left" { "←" }
            button type="button" data-zoom="right" aria-label="To the right" { "→" }
            button type="button" data-zoom="reset" { "Reset" }
            span.hint {
                "Drag across a plot, or pinch it, to zoom; a double click shows all again. A plot that has the focus \
                 takes the keys + − ← → 0, and with Shift ← → moves what is shown. Names switch their traces."
            }
        }
    }
}

fn plot(figure: &Figure) -> Markup {
    html! {
        figure.plot {
            figcaption {
                span.title { (figure.title) }
                span.axis { (figure.axis) }
                output.place aria-live="off" {}
            }
            div.canvas { (drawing::drawing(figure)) }
            ul.legend {
                @for (name, stroke, traces) in names(figure) {
                    li { button type="button" data-traces=(traces) aria-pressed="true"
                        class=(drawing::stroke(stroke)) {
                        span.sample aria-hidden="true" {}
                        (name)
                        output aria-live="off" {}
                    } }
                }
                @if let Some(name) = figure.band
                    && figure.traces.iter().any(|trace| !trace.band.is_empty()) {
                    li.key { span.sample aria-hidden="true" {} (name) }
                }
            }
        }
    }
}

/// The traces by name, with their places: two limits are one.
fn names(figure: &Figure) -> Vec<(&str, Stroke, String)> {
    let mut names: Vec<(&str, Stroke, String)> = Vec::new();
    for (place, trace) in figure.traces.iter().enumerate() {
        match names.iter_mut().find(|(name, ..)| *name == trace.name) {
            Some((.., places)) => *places += &format!(" {place}"),
            None => names.push((&trace.name, trace.stroke, place.to_string())),
        }
    }
    names
}

/// What the shades of the plots mean.
fn stretches(figures: &[Figure]) -> Markup {
    let mut stretches: Vec<&Stretch> = Vec::new();
    for stretch in figures.iter().flat_map(|figure| &figure.stretches) {
        if stretches.iter().all(|known| known.name != stretch.name) {
            stretches.push(stretch);
        }
    }
    html! {
        @if !stretches.is_empty() {
            ul.legend {
                @for stretch in stretches {
                    li.key { span.sample.(format!("stretch-{}", stretch.colour)) aria-hidden="true" {}
                        (stretch.name) }
                }
            }
        }
    }
}
