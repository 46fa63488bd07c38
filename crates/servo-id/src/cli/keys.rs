use comfy_table::{ColumnConstraint, ContentArrangement, Table, presets};
use host_sim::scenario::Scenario;
use host_sim::scenario::keys::KEYS;
use identifier_log::scenario::schema::schema;

use super::fault::Fault;
use super::{standard_output, terminal};
use crate::program;

type Key = identifier_log::scenario::Key<Scenario>;

#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    /// A table, such as `controller`, or a key, such as `controller.kp`; all keys by default.
    #[arg(value_name = "TABLE|KEY")]
    of: Option<String>,
    /// Print a JSON schema (draft 2020-12) of a scenario instead, for editors.
    #[arg(long, conflicts_with = "of")]
    schema: bool,
}

pub(super) fn run(arguments: &Arguments) -> Result<(), Fault> {
    let text = match &arguments.of {
        _ if arguments.schema => format!("{:#}", schema::<Scenario>()),
        None => table(KEYS.iter()),
        Some(of) => terminal::folded(&described(of)?),
    };
    standard_output::result(format_args!("{text}"))
}

fn described(of: &str) -> Result<String, Fault> {
    let Some(key) = Key::at(of) else {
        let near = Key::nearest(of);
        let hint = near.map_or(String::new(), |near| {
            format!("; did you mean {}?", near.path)
        });
        return Err(Fault::Input(format!(
            "{of}: there is no such table or key{hint}\n  `{} keys` lists them all",
            program::NAME
        )));
    };
    let inside = |other: &&Key| other.path.starts_with(&format!("{of}."));
    if KEYS.iter().any(|other| inside(&other)) {
        let children = table(KEYS.iter().filter(inside));
        return Ok(format!("{}  {}\n{children}", key.heading(), key.about));
    }
    Ok(format!(
        "{of}\n  {}\n  allowed: {}\n  default: {}",
        key.description(),
        key.allowed(),
        key.default()
    ))
}

/// The widest table that is read with ease.
const MAX_WIDTH: u16 = 120;

fn table<'k>(keys: impl Iterator<Item = &'k Key>) -> String {
    let mut table = Table::new();
    table
        .load_style(presets::UTF8_FULL_CONDENSED)
        .set_content_arrangement(ContentArrangement::Dynamic)
        .set_width(terminal::width().min(MAX_WIDTH))
        .set_header(["key", "what it is", "allowed", "default"]);
    for key in keys {
        table.add_row([
            key.path.to_owned(),
            key.description(),
            key.allowed(),
            key.default(),
        ]);
    }
    if let Some(paths) = table.column_mut(0) {
        paths.set_constraint(ColumnConstraint::ContentWidth);
    }
    table.to_string()
}
