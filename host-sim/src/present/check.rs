//! A check of a scenario.

use super::noise::sensor_noise;
use super::number::{DASH, figure, fixed, rough};
use super::{Block, Column, Page, Section, Table, Tone, Verdict};
use crate::result::{CheckResult, Known, LoopFigures};

/// The page of a check.
#[must_use]
pub fn check(title: &str, command: &str, result: &CheckResult) -> Page {
    let warnings = result.warnings.iter().cloned().map(Block::Warning);
    let (tone, headline) = match result.warnings.len() {
        0 => (Tone::Good, "No problems found.".to_owned()),
        1 => (Tone::Doubtful, "There is one problem.".to_owned()),
        count => (Tone::Doubtful, format!("There are {count} problems.")),
    };
    let none = (tone == Tone::Good).then(|| Block::Text(headline.clone()));
    let facts = [
        ("Servo", servo(result)),
        ("Loop", closed_loop(result.closed_loop.as_ref())),
        ("Certificate", certificate(result)),
        ("Encoder", encoder(result)),
    ];
    let found = [Block::facts(facts), Block::Table(known(&result.known))];
    let verdict = Verdict {
        tone,
        status: "checked".to_owned(),
        headline,
        detail: "The accuracy is the best that the motion of the simulated run allows.".to_owned(),
    };
    let sections = [
        Section::brief("What was found", found.into()),
        Section::brief("What to do next", warnings.chain(none).collect()),
    ];
    Page::new(title, command, verdict, sections)
}

fn servo(result: &CheckResult) -> String {
    let servo = &result.servo;
    let mut text = format!(
        "a = {} 1/s, b = {} rad/s² per command unit",
        figure(servo.a),
        figure(servo.b)
    );
    if let Some(time) = servo.time_constant {
        text += &format!("; time constant {} s", figure(time));
    }
    if let Some(speed) = servo.top_speed {
        text += &format!("; top speed {} rad/s", figure(speed));
    }
    if servo.breakaway > 0.0 {
        let breakaway = figure(servo.breakaway);
        text += &format!("; friction and load take {breakaway} of the command");
    }
    text
}

fn closed_loop(figures: Option<&LoopFigures>) -> String {
    let Some(figures) = figures else {
        return "not a PID's: the law closes one of its own".to_owned();
    };
    if !figures.stable {
        return "unstable".to_owned();
    }
    let or_dash = |value: Option<f64>, places| {
        value.map_or_else(|| DASH.to_owned(), |value| fixed(value, places))
    };
    let [fall, rise] = figures.gain_margins;
    format!(
        "bandwidth {} rad/s, crossover {} rad/s; phase margin {}°, gain may fall to {} and rise to {} times, modulus \
         margin {}",
        or_dash(figures.bandwidth, 1),
        or_dash(figures.crossover, 1),
        or_dash(figures.phase_margin, 0),
        fall.map_or_else(|| "any".to_owned(), |fall| fixed(fall, 2)),
        or_dash(rise, 1),
        or_dash(figures.modulus_margin, 2)
    )
}

fn certificate(result: &CheckResult) -> String {
    let certificate = &result.certificate;
    match (certificate.certified, certificate.gain_margin) {
        (true, Some(margin)) => format!(
            "every servo of the box is stable; the gain may rise by {} at least",
            fixed(margin, 1)
        ),
        (true, None) => "every servo of the box is stable".to_owned(),
        (false, _) => "none: no identifier.plant_box is stated, or the law needs none".to_owned(),
    }
}

fn encoder(result: &CheckResult) -> String {
    let encoder = &result.encoder;
    let moves = encoder.command_per_count.map(figure);
    let moves = moves.map(|step| format!("; a count moves the command by {step}"));
    let noise = sensor_noise(&encoder.noise).map(|noise| format!("; noise {noise}"));
    format!(
        "{} rad per count; the servo moves by {} counts rms{}{}",
        figure(encoder.resolution),
        fixed(encoder.motion, 0),
        moves.unwrap_or_default(),
        noise.unwrap_or_default()
    )
}

fn known(known: &[Known]) -> Table {
    let row = |known: &Known| {
        let or = |value: Option<f64>, none: &str| value.map_or_else(|| none.to_owned(), rough);
        let never = match known.std_error {
            Some(_) => "not when it breaks off",
            None => "never: no information",
        };
        vec![
            known.unknown.to_owned(),
            rough(known.needed),
            or(known.from, never),
            or(known.std_error, DASH),
            known.unit.to_owned(),
        ]
    };
    let columns = vec![
        Column::words("quantity"),
        Column::figures("known to"),
        Column::figures("after [s]"),
        Column::figures("at the end, at best"),
        Column::words("unit"),
    ];
    let caption = "Standard errors that the motion allows";
    Table::new(caption, columns, known.iter().map(row).collect())
}
