use std::path::{Path, PathBuf};

use super::fault::Fault;
use super::files::{self, Drawing, Files};
use super::standard_output::show;
use super::{call, terminal};
use crate::render::chart::Size;
use crate::{csv, paper, present, program, render};

/// Where it goes unless stated.
const FOLDER: &str = "results/paper";

/// The title of its page.
const TITLE: &str = "The paper's experiment";

/// The picture's name in the folder.
const PICTURE: &str = "figure-03.png";

#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    /// The folder for picture, traces and results; by default results/paper.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Width of the picture, in a paper of two columns.
    #[arg(long, value_enum, default_value_t)]
    size: Size,
    /// Replace what this program did not write, too.
    #[arg(long)]
    force: bool,
}

/// Runs the experiment for its table alone: nothing is written.
pub(super) fn show() -> Result<(), Fault> {
    let runs = paper::experiment().map_err(|fault| Fault::Other(fault.to_string()))?;
    let page = present::paper(TITLE, &call::command(), &runs);
    show!("{}", render::terminal::brief(&page, terminal::width()))?;
    show!(
        "\n`{0} paper` draws Fig. 03 and writes the traces; `{0} identify LOG` identifies your own servo",
        program::NAME
    )
}

pub(super) fn run(arguments: &Arguments) -> Result<(), Fault> {
    let out = arguments.out.as_deref().unwrap_or(Path::new(FOLDER));
    std::fs::create_dir_all(out).map_err(|error| Fault::unusable(out.display(), &error))?;
    let mut files = Files::reading(&[], arguments.force);
    let mut begin = |name: &str| files.output(Some(&out.join(name)));
    let mut tables = Vec::new();
    for (method, case) in paper::EXPERIMENT {
        let stem = paper::file_stem(method, case);
        tables.push((
            begin(&format!("{stem}.csv"))?,
            begin(&format!("{stem}.json"))?,
        ));
    }
    let picture = files.picture(&Drawing {
        plot: Some(out.join(PICTURE)),
        size: arguments.size,
    })?;

    let runs = paper::experiment().map_err(|fault| Fault::Other(fault.to_string()))?;
    let mut written = Vec::new();
    for (run, (rows, json)) in runs.iter().zip(tables) {
        written.push(rows.map(|rows| rows.table(|file| csv::trace(file, &run.trace))));
        written.push(json.map(|json| json.document(&run.summary)));
    }
    let page = present::paper(TITLE, &call::command(), &runs);
    let title = "Fig. 03: identified parameters over time";
    written.push(picture.map(|picture| picture.figures(title, 2, &page)));
    files::commit(written)?;
    show!("{}", render::terminal::brief(&page, terminal::width()))?;
    show!("\nPicture: {}", out.join(PICTURE).display())?;
    show!(
        "Traces and results: {}",
        out.join("*.csv, *.json").display()
    )?;
    Ok(())
}
