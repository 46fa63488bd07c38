//! Words and files of earlier states of the program that this one rejects, each with its replacement. Every rejection
//! of such a word or file is from this one list.

/// Where a word stood.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Place {
    /// A key of a scenario, by its path.
    Key,
    /// A value of a key, as `key = value`.
    Value,
    /// A verb of the command line.
    Verb,
    /// An option of the command line.
    Option,
    /// A file, by the name in its beginning.
    File,
}

use Place::{File, Key, Option as Flag, Value, Verb};

/// For a method that was only compared with.
const RIVAL: &str =
    "use \"relay-least-squares\" for comparison, \"fit\" or \"gauss-newton\" to identify";

/// For the compensation of known forces.
const FORCES: &str = "no loop compensates known forces: add the feed_forward that tune prints to the command of your \
                      own controller";

/// For the rounds of frequency-response motions.
const ROUNDS: &str = "a commissioning measures the frequency response of every axis, and again where it shows too little";

const GONE: &[(Place, &str, &str)] = &[
    (
        File,
        "MCAP",
        "MCAP is no longer read: convert the recording to .csv, in Python with the package mcap",
    ),
    (Key, "controller.feed_forward.constant", FORCES),
    (Key, "controller.feed_forward.gravity", FORCES),
    (Key, "controller.feed_forward.ripple", FORCES),
    (Key, "controller.feed_forward.ripple_order", FORCES),
    (Key, "controller.feed_forward.revolution", FORCES),
    (Key, "controller.feed_forward.dead_band", FORCES),
    (Key, "controller.feed_forward.delay", FORCES),
    (
        Key,
        "log.scan",
        "logs are no longer checked for plausibility: the verdict of the fit judges them",
    ),
    (
        Flag,
        "--scan",
        "logs are no longer checked for plausibility: the verdict of the fit judges them",
    ),
    (
        Key,
        "commission.one_way",
        "an axis that must not reverse cannot be commissioned: identify its a and b from a log, with \
         identifier.parameters = [\"a\", \"b\", \"load\"]",
    ),
    (Key, "commission.slide_rounds", ROUNDS),
    (Flag, "--quick", ROUNDS),
    (Flag, "--thorough", ROUNDS),
    (
        Key,
        "identifier.terms",
        "terms are no longer added automatically: state them in required_terms, or use law = \"fit\", which finds \
         them in a whole log",
    ),
    (
        Value,
        "identifier.required_terms = wandering-load",
        "law = \"fit\" detects a drifting load in a whole log",
    ),
    (
        Value,
        "identifier.law = window",
        "law = \"gauss-newton\" starts with a fit to a short motion; with start_time = 0.25 after a quarter of a \
         second",
    ),
    (Value, "identifier.law = proportional-least-squares", RIVAL),
    (Value, "identifier.law = two-degrees-of-freedom", RIVAL),
    (Value, "identifier.law = multi-step-least-squares", RIVAL),
    (Value, "identifier.law = relay-cycle", RIVAL),
    (Value, "identifier.law = two-relays", RIVAL),
    (Value, "identifier.law = closed-loop-arx", RIVAL),
    (Value, "identifier.law = mechanical-least-squares", RIVAL),
    (Flag, "--mcap", "--csv writes the same samples"),
    (
        Flag,
        "--live",
        "--report writes the page of a run at its end",
    ),
    (
        Verb,
        "check",
        "run prints margins and reachable accuracy with the result, tune the margins of its gains",
    ),
    (Verb, "drift", "run SCENARIO --formats prints its table"),
    (Verb, "manual", "VERB --help prints the same"),
    (
        Verb,
        "replay",
        "identify LOG --scenario SCENARIO does the same",
    ),
    (Verb, "rerun", "reproduce does the same"),
];

/// The replacement of a word that is gone, a sentence without an end.
#[must_use]
pub fn replacement(place: Place, word: &str) -> Option<&'static str> {
    let mut gone = GONE.iter();
    gone.find_map(|(at, name, what)| (*at == place && *name == word).then_some(*what))
}

/// The replacement of a kind of file whose name follows the first byte.
#[must_use]
pub fn file(beginning: &[u8]) -> Option<&'static str> {
    let name = beginning
        .get(1..5)
        .and_then(|name| str::from_utf8(name).ok())?;
    replacement(File, name)
}
