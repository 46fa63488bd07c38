//! Gains for an identified servo, and what they promise.

use super::{Block, Column, Table};
use crate::present::number::sentence;
use crate::report::promise::{self, FeedForwardDocument};
use crate::scenario::Scenario;
use crate::tune::{Conditions, IdentifiedResult, NoGains, Tuned};

/// The gains that make a servo as stiff as it bears, for the encoder and the limit of its scenario; or
/// why there are none.
#[must_use]
pub(super) fn advice(result: &IdentifiedResult, scenario: &Scenario) -> Vec<Block> {
    let settings = match Conditions::STIFFEST.settings(result, Some(scenario)) {
        Ok(settings) => settings,
        Err(error) => {
            return vec![Block::Text(sentence(&format!(
                "there are no gains: {error}"
            )))];
        }
    };
    match Tuned::of(result, &settings) {
        Ok(tuned) => of(&tuned),
        Err(NoGains::Error(error)) => {
            vec![Block::Text(sentence(&format!(
                "there are no gains: {error}"
            )))]
        }
        // Who asks for as much as there is cannot ask for too much.
        Err(NoGains::TooFast { .. }) => Vec::new(),
    }
}

/// Gains that were found: the controller, its promise, the feed-forward.
#[must_use]
pub(super) fn of(tuned: &Tuned) -> Vec<Block> {
    let remarks = promise::remarks(tuned);
    let mut remarks = remarks.lines();
    let cap = remarks.next().unwrap_or_default();
    let mut blocks = vec![
        Block::Text(format!(
            "Take these gains. With them the loop is {cap}; what they promise is simulated on the identified \
             servo, and at worst on those that it may be as well."
        )),
        Block::Code {
            caption: "Controller, as a scenario has it".to_owned(),
            text: promise::controller(&tuned.tuning, tuned.settings.sample_time)
                .trim_end()
                .to_owned(),
        },
        Block::Table(Table::new(
            "What these gains promise",
            vec![
                Column::words("response"),
                Column::figures("promised"),
                Column::words("unit"),
            ],
            promise::rows(&tuned.tuning)
                .into_iter()
                .map(|(name, promised, unit)| vec![name.to_owned(), promised, unit.to_owned()])
                .collect(),
        )),
    ];
    blocks.extend(remarks.map(|remark| Block::Text(sentence(remark))));
    blocks.push(Block::Text(sentence(&promise::feed_forward(
        &FeedForwardDocument::new(tuned),
    ))));
    blocks
}
