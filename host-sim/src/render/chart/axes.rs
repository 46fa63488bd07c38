//! One panel on a sheet: its name above, its axes, its curves, and what their colours mean between name and
//! curves.

use super::canvas::{Align, BLACK, Frame, GRID, LETTER, SMALL, Sheet, Stroke};
use super::legend::{self, BAND, Entry, Mark};
use super::plot::{Curve, Panel};
use super::scale::Scale;
use super::timeline::{LIMIT, Shade, shade};

/// Colours of the curves, in their order; the line to compare with is black. (Okabe and Ito, "Color
/// universal design", 2008: told apart by colour-blind readers too.)
const COLOURS: [&str; 4] = ["#0072B2", "#E69F00", "#009E73", "#CC79A7"];

/// Widths of the curves in their order, points: what lies under the first is seen beside it.
const WIDTHS: [f64; 4] = [0.7, 1.4, 2.2, 0.7];

const NOMINAL: Stroke = Stroke {
    colour: BLACK,
    width: 0.8,
    dashes: Some((3.0, 2.0)),
};
const AXIS: Stroke = Stroke::solid(BLACK, 0.6);
const GRID_LINE: Stroke = Stroke::solid(GRID, 0.5);

/// Room to the left of the curves for what stands at the ticks, and to the right for half of it; points.
pub(super) const LEFT: f64 = 30.0;
pub(super) const RIGHT: f64 = 9.0;

/// Height of the name, and below the curves of nothing, and of ticks with their figures and the axis's name.
const NAME: f64 = 15.0;
const GAP: f64 = 8.0;
const ABSCISSA: f64 = 27.0;

/// Length of a tick.
const TICK: f64 = 2.5;

/// A panel with what lies behind its curves.
#[derive(Debug, Clone, Copy)]
pub(super) struct Axes<'a> {
    pub(super) panel: &'a Panel,
    pub(super) stretches: &'a [Shade],
    pub(super) limits: &'a [f64],
    /// Height of the curves, points.
    pub(super) height: f64,
}

/// What is the same for panels side by side.
#[derive(Debug, Clone, Copy)]
pub(super) struct Row {
    /// Lines that the legends take.
    pub(super) legend: usize,
    /// Whether the horizontal axis has figures and a name.
    pub(super) abscissa: bool,
}

impl Row {
    fn above(self) -> f64 {
        NAME + self.legend as f64 * legend::LINE
    }

    /// What panels of this height take.
    pub(super) fn height(self, curves: f64) -> f64 {
        self.above() + curves + if self.abscissa { ABSCISSA } else { GAP }
    }
}

impl<'a> Axes<'a> {
    /// A panel alone.
    pub(super) fn plain(panel: &'a Panel, height: f64) -> Self {
        Self {
            panel,
            stretches: &[],
            limits: &[],
            height,
        }
    }

    /// Whether two have one horizontal axis.
    pub(super) fn continues(&self, above: &Self) -> bool {
        let one = (self.panel, above.panel);
        one.0.abscissa == one.1.abscissa && horizontal(one.0, 1.0) == horizontal(one.1, 1.0)
    }

    /// What its colours mean, but for those of stretches and limits; empty where there is nothing to be told apart.
    pub(super) fn legend(&self) -> Vec<Entry> {
        let curves = self
            .panel
            .curves
            .iter()
            .enumerate()
            .filter_map(|(place, curve)| {
                let stroke = stroke(place);
                Some(Entry {
                    mark: match is_banded(curve) {
                        true => Mark::Banded(stroke),
                        false => Mark::Line(stroke),
                    },
                    words: curve.name.clone()?,
                })
            });
        let nominal = self.panel.nominal.iter().map(|(name, _)| Entry {
            mark: Mark::Line(NOMINAL),
            words: name.clone(),
        });
        curves.chain(nominal).collect()
    }

    /// Draws it with its left upper corner there, so wide.
    pub(super) fn draw(
        &self,
        sheet: &mut Sheet,
        (left, top): (f64, f64),
        width: f64,
        row: Row,
        entries: &[Entry],
    ) {
        let frame = Frame {
            left: left + LEFT,
            top: top + row.above(),
            width: width - LEFT - RIGHT,
            height: self.height,
        };
        let (across, up) = (horizontal(self.panel, frame.width), self.vertical());
        let name = up.named(&named(self.panel));
        sheet.words((left, top + 8.0), &name, LETTER, Align::Left, BLACK);
        legend::draw(sheet, (frame.left, top + NAME - 2.0), frame.width, entries);
        self.behind(sheet, frame, &across, &up);
        sheet.inside(frame, |sheet| self.curves(sheet, frame, &across, &up));
        self.axes(sheet, frame, &across, &up, row.abscissa);
    }

    fn vertical(&self) -> Scale {
        /// Steps of the vertical axis.
        const STEPS: u32 = 5;
        let panel = self.panel;
        let values = panel.curves.iter().flat_map(|curve| &curve.points);
        let ends = |ends: (f64, f64), value: f64| (ends.0.min(value), ends.1.max(value));
        let seen = panel.range.unwrap_or_else(|| {
            values
                .map(|point| point.1)
                .fold((f64::INFINITY, f64::NEG_INFINITY), ends)
        });
        let nominal = panel.nominal.iter().map(|(_, value)| *value);
        let (low, high) = nominal.filter(|value| value.is_finite()).fold(seen, ends);
        match (low <= high, panel.range) {
            (true, None) => Scale::around(low, high, STEPS),
            (true, Some(_)) => Scale::between(low, high, STEPS),
            (false, _) => Scale::around(0.0, 1.0, STEPS),
        }
    }

    fn behind(&self, sheet: &mut Sheet, frame: Frame, across: &Scale, up: &Scale) {
        for stretch in self.stretches {
            let [begin, end] = stretch.time.map(|time| across.part(time).clamp(0.0, 1.0));
            let part = Frame {
                left: frame.left + begin * frame.width,
                width: (end - begin) * frame.width,
                ..frame
            };
            sheet.rectangle(part, shade(stretch), super::timeline::OPACITY);
        }
        for (part, _) in up.ticks() {
            let y = frame.bottom() - part * frame.height;
            sheet.line((frame.left, y), (frame.right(), y), GRID_LINE);
        }
        for (part, _) in across.ticks() {
            let x = frame.left + part * frame.width;
            sheet.line((x, frame.top), (x, frame.bottom()), GRID_LINE);
        }
    }

    fn curves(&self, sheet: &mut Sheet, frame: Frame, across: &Scale, up: &Scale) {
        let x = |place: f64| frame.left + across.part(place) * frame.width;
        // What is far outside would be drawn for nothing.
        let y = |value: f64| frame.bottom() - up.part(value).clamp(-1.0, 2.0) * frame.height;
        let level = |sheet: &mut Sheet, value: f64, stroke| {
            sheet.line((frame.left, y(value)), (frame.right(), y(value)), stroke);
        };
        for limit in self.limits.iter().filter(|limit| limit.is_finite()) {
            level(sheet, *limit, LIMIT);
        }
        for (place, curve) in self.panel.curves.iter().enumerate().rev() {
            let stroke = stroke(place);
            if is_banded(curve) {
                let edge = |sign: f64| {
                    let points = curve.points.iter().zip(&curve.band);
                    points.map(move |((place, value), half)| (x(*place), y(value + sign * half)))
                };
                let mut outline: Vec<_> = edge(1.0).collect();
                let lower: Vec<_> = edge(-1.0).collect();
                outline.extend(lower.into_iter().rev());
                sheet.area(&outline, stroke.colour, BAND);
            }
            let points = curve.points.iter();
            sheet.curve(
                points.map(|&(place, value)| (x(place), y(value))).collect(),
                stroke,
            );
        }
        if let Some((_, value)) = self
            .panel
            .nominal
            .as_ref()
            .filter(|(_, value)| value.is_finite())
        {
            level(sheet, *value, NOMINAL);
        }
    }

    fn axes(&self, sheet: &mut Sheet, frame: Frame, across: &Scale, up: &Scale, abscissa: bool) {
        let (left, bottom) = (frame.left, frame.bottom());
        sheet.line((left, frame.top), (left, bottom), AXIS);
        sheet.line((left, bottom), (frame.right(), bottom), AXIS);
        for (part, figure) in up.ticks() {
            let y = bottom - part * frame.height;
            sheet.line((left - TICK, y), (left, y), AXIS);
            sheet.words(
                (left - TICK - 2.0, y + 2.5),
                &figure,
                SMALL,
                Align::Right,
                BLACK,
            );
        }
        for (part, figure) in across.ticks() {
            let x = left + part * frame.width;
            sheet.line((x, bottom), (x, bottom + TICK), AXIS);
            if abscissa {
                sheet.words(
                    (x, bottom + TICK + 7.5),
                    &figure,
                    SMALL,
                    Align::Middle,
                    BLACK,
                );
            }
        }
        if abscissa {
            let middle = left + 0.5 * frame.width;
            let name = across.named(&self.panel.abscissa);
            sheet.words((middle, bottom + 20.0), &name, LETTER, Align::Middle, BLACK);
        }
    }
}

/// Title and axis in one line.
fn named(panel: &Panel) -> String {
    match panel.title.is_empty() {
        true => panel.axis.clone(),
        false => format!("{}: {}", panel.title, panel.axis),
    }
}

fn horizontal(panel: &Panel, width: f64) -> Scale {
    /// The least length of a step, points.
    const STEP: f64 = 32.0;
    let places = panel.curves.iter().flat_map(|curve| &curve.points);
    let (first, last) = places.fold((f64::INFINITY, 0.0_f64), |(first, last), &(place, _)| {
        (first.min(place), last.max(place))
    });
    match panel.logarithmic_abscissa && first > 0.0 && first <= last {
        true => Scale::decades(first, last),
        false => Scale::between(0.0, last, (width / STEP).max(1.0) as u32),
    }
}

fn is_banded(curve: &Curve) -> bool {
    curve.band.len() == curve.points.len() && !curve.band.is_empty()
}

fn stroke(place: usize) -> Stroke {
    Stroke::solid(COLOURS[place % COLOURS.len()], WIDTHS[place % WIDTHS.len()])
}
