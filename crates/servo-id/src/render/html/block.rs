//! The blocks of a page.

use maud::{Markup, PreEscaped, html};

use crate::present::number::sentence;
use crate::present::{Block, Figure, Table, TimeSpan, Tone, Verdict};
use crate::render::chart;

/// A block; `name` is unlike those of the other blocks of a page.
pub(super) fn block(block: &Block, name: &str) -> Markup {
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
            (time_spans(figures))
            div.figures {
                @for (place, figure) in figures.iter().enumerate() {
                    (plot(figure, &format!("{name}-{place}-")))
                }
            }
        },
    }
}

pub(super) fn verdict(verdict: &Verdict) -> Markup {
    let tone = match verdict.tone {
        Tone::Good => "good",
        Tone::Doubtful => "doubtful",
        Tone::Failed => "failed",
    };
    html! {
        div.verdict.(tone) {
            p.status { (verdict.status) }
            p.headline { (verdict.headline) }
            p { (sentence(&verdict.detail)) }
        }
    }
}

fn table(table: &Table) -> Markup {
    /// Columns from which on a phone shows each row as lines.
    const WIDE: usize = 4;
    let class = |place: usize| table.columns.get(place).filter(|column| column.is_figures);
    let class = |place: usize| class(place).map(|_| "figures");
    html! {
        div.table.wide[table.columns.len() >= WIDE] tabindex="0" role="region" aria-label=[named(&table.caption)] {
            table {
                @if let Some(caption) = named(&table.caption) { caption { (caption) } }
                thead { tr {
                    @for (place, column) in table.columns.iter().enumerate() {
                        th scope="col" class=[class(place)] { (column.name) }
                    }
                } }
                tbody { @for row in &table.rows { tr {
                    @for (place, cell) in row.iter().enumerate() {
                        @if place == 0 { th scope="row" { (cell) } }
                        @else {
                            td class=[class(place)]
                                data-column=(table.columns.get(place).map_or("", |column| &column.name)) { (cell) }
                        }
                    }
                } } }
            }
        }
    }
}

/// A caption, where there is one: the heading of the section names the only table.
fn named(caption: &str) -> Option<&str> {
    (!caption.is_empty()).then_some(caption)
}

/// Buttons that zoom every plot; hidden where there is no script.
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

fn plot(figure: &Figure, name: &str) -> Markup {
    html! {
        figure.plot {
            figcaption {
                span.title { (figure.title) }
                span.axis { (figure.vertical.name) }
                output.place aria-live="off" {}
            }
            div.canvas { (PreEscaped(chart::embedded(figure).embedded_svg(name, &figure.title))) }
            ul.legend {
                @for (name, class, lines) in lines_by_name(figure) {
                    li { button type="button" data-traces=(lines) aria-pressed="true" class=(class) {
                        span.sample aria-hidden="true" {}
                        (name)
                        output aria-live="off" {}
                    } }
                }
            }
        }
    }
}

/// The names of traces and levels with their classes and their places among the lines of the plot. Two limits are one.
fn lines_by_name(figure: &Figure) -> Vec<(&str, String, String)> {
    let traces = figure.traces.iter().enumerate();
    let traces = traces.map(|(place, trace)| {
        let colour = place % chart::TRACE_COLOURS;
        (trace.name.as_str(), format!("trace-{colour}"))
    });
    let levels = figure.levels.iter();
    let levels = levels.map(|level| (level.name.as_str(), "trace-dashed".to_owned()));
    let mut lines: Vec<(&str, String, String)> = Vec::new();
    for (place, (name, class)) in traces.chain(levels).enumerate() {
        match lines.iter_mut().find(|(known, ..)| *known == name) {
            Some((.., places)) => *places += &format!(" {place}"),
            None => lines.push((name, class, place.to_string())),
        }
    }
    lines
}

/// Meaning of the shades.
fn time_spans(figures: &[Figure]) -> Markup {
    let mut time_spans: Vec<&TimeSpan> = Vec::new();
    for time_span in figures.iter().flat_map(|figure| &figure.time_spans) {
        if time_spans.iter().all(|known| known.name != time_span.name) {
            time_spans.push(time_span);
        }
    }
    let class =
        |time_span: &TimeSpan| format!("stretch-{}", time_span.colour % chart::SPAN_COLOURS);
    html! {
        @if !time_spans.is_empty() {
            ul.legend {
                @for time_span in time_spans {
                    li.key { span.sample.(class(time_span)) aria-hidden="true" {} (time_span.name) }
                }
            }
        }
    }
}
