//! The plots of a page as its script reads them: short numbers, no finer than anybody can see.

use serde::Serialize;

use super::{Figure, Stroke};

/// A plot for the script.
#[derive(Debug, Serialize)]
struct FigureData<'a> {
    abscissa: &'a str,
    logarithmic_abscissa: bool,
    range: Option<(f64, f64)>,
    traces: Vec<TraceData>,
    stretches: Vec<StretchData>,
}

/// A trace for the script.
#[derive(Debug, Serialize)]
struct TraceData {
    /// The number of its colour; none for a dashed line to compare with.
    colour: Option<usize>,
    places: Vec<f64>,
    values: Vec<f64>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    band: Vec<f64>,
}

/// A named stretch for the script.
#[derive(Debug, Serialize)]
struct StretchData {
    extent: [f64; 2],
    colour: usize,
}

/// The parts that a range is divided into: far more than a zoomed plot has pixels.
const FINENESS: f64 = 1e6;

/// Plots as JSON that may stand in a page: `<` is escaped.
#[must_use]
pub(super) fn json(figures: &[&Figure]) -> String {
    let figures: Vec<FigureData<'_>> = figures.iter().map(|figure| data(figure)).collect();
    // Nothing in it can fail to be written: numbers that are none are null.
    let text = serde_json::to_string(&figures).unwrap_or_default();
    text.replace('<', "\\u003c")
}

fn data(figure: &Figure) -> FigureData<'_> {
    let (begin, end) = figure.extent();
    let (low, high) = figure.shown();
    let place = if figure.logarithmic_abscissa {
        Rounding::NONE
    } else {
        Rounding::of(end - begin)
    };
    let value = Rounding::of(high - low);
    FigureData {
        abscissa: &figure.abscissa,
        logarithmic_abscissa: figure.logarithmic_abscissa,
        range: figure.range,
        traces: figure
            .traces
            .iter()
            .map(|trace| TraceData {
                colour: match trace.stroke {
                    Stroke::Colour(colour) => Some(colour),
                    Stroke::Dashed => None,
                },
                places: trace
                    .points
                    .iter()
                    .map(|(at, _)| place.short(*at))
                    .collect(),
                values: trace
                    .points
                    .iter()
                    .map(|(_, of)| value.short(*of))
                    .collect(),
                band: trace.band.iter().map(|half| value.short(*half)).collect(),
            })
            .collect(),
        stretches: figure
            .stretches
            .iter()
            .map(|stretch| StretchData {
                extent: stretch.extent,
                colour: stretch.colour,
            })
            .collect(),
    }
}

/// Decimal places that are kept.
#[derive(Debug, Clone, Copy)]
struct Rounding {
    /// A power of ten; infinite where all are.
    scale: f64,
}

impl Rounding {
    const NONE: Self = Self {
        scale: f64::INFINITY,
    };

    /// As many as it takes to tell the parts of a range apart.
    fn of(range: f64) -> Self {
        if range > 0.0 && range.is_finite() {
            Self {
                scale: 10_f64.powf((FINENESS / range).log10().ceil()),
            }
        } else {
            Self::NONE
        }
    }

    fn short(self, value: f64) -> f64 {
        let scaled = value * self.scale;
        if scaled.is_finite() {
            scaled.round() / self.scale
        } else {
            value
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::present::Trace;

    fn figure(points: Vec<(f64, f64)>) -> Figure {
        Figure {
            title: String::new(),
            abscissa: "</script><b>".to_owned(),
            axis: String::new(),
            logarithmic_abscissa: false,
            range: Some((0.2, 0.3)),
            band: None,
            traces: vec![Trace {
                name: String::new(),
                stroke: Stroke::Colour(1),
                points,
                band: vec![f64::INFINITY, 0.012_345_678_9],
            }],
            stretches: Vec::new(),
        }
    }

    #[test]
    fn numbers_are_short_and_what_is_none_is_null() {
        let text = json(&[&figure(vec![(0.0, 1.0 / 3.0), (60.0, 5000.0 / 3.0)])]);
        assert!(text.contains(r#""places":[0.0,60.0]"#), "{text}");
        assert!(
            text.contains(r#""values":[0.3333333,1666.6666667]"#),
            "{text}"
        );
        assert!(text.contains(r#""band":[null,0.0123457]"#), "{text}");
    }

    #[test]
    fn no_text_ends_the_script_that_it_stands_in() {
        let text = json(&[&figure(Vec::new())]);
        assert!(!text.contains('<'), "{text}");
        let read: serde_json::Value = serde_json::from_str(&text).expect("JSON");
        assert_eq!(read[0]["abscissa"], "</script><b>");
    }
}
