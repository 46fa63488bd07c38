//! The page of a tuning.

use super::{Block, Figure, Page, Section, Tone, Verdict, gains};
use crate::present::number::{figure, plain, sentence};
use crate::tune::Tuned;

/// The page of a tuning: `figures` are what its promise looks like, `doubt` what speaks against the result that it
/// is for.
#[must_use]
pub fn tuning(
    title: &str,
    command: &str,
    tuned: &Tuned,
    figures: Vec<Figure>,
    doubt: Option<&String>,
) -> Page {
    let promise = &tuned.tuning.promise;
    let verdict = Verdict {
        tone: if doubt.is_some() {
            Tone::Doubtful
        } else {
            Tone::Good
        },
        status: "tuned".to_owned(),
        headline: format!(
            "A step will rise in {} ms and overshoot by {} % at most.",
            figure(1e3 * promise.rise_time),
            figure(100.0 * promise.overshoot)
        ),
        detail: match doubt {
            Some(doubt) => sentence(&format!("nothing vouches for it: {doubt}")),
            None => "It is what the identified servo does in simulation.".to_owned(),
        },
    };
    let parameters = &tuned.servo.parameters;
    let settings = &tuned.settings;
    let facts = [
        ("a", parameters.a, "1/s"),
        ("b", parameters.b, "rad/s² per command unit"),
        ("c", parameters.coulomb, "rad/s²"),
        ("d", parameters.load, "rad/s²"),
        ("Delay", tuned.servo.delay + settings.command_delay, "s"),
        ("Encoder", settings.resolution, "rad a count"),
        ("Command", settings.command, "command units beyond the load"),
        ("Sample time", settings.sample_time, "s"),
        ("Sensitivity", settings.max_sensitivity, "at most"),
    ];
    let facts =
        facts.map(|(name, value, unit)| (name.to_owned(), format!("{} {unit}", plain(value))));
    let sections = [
        Section::full("What was found", gains::of(tuned)),
        Section::full("What it looks like", vec![Block::Figures(figures)]),
        Section::full("What it rests on", vec![Block::Facts(facts.into())]),
    ];
    Page::new(title, command, verdict, sections)
}
