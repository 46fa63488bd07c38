use std::path::{Path, PathBuf};

use super::call;
use super::fault::Fault;
use super::files::{self, Files};
use super::output::Drawing;
use super::standard_output::say;
use super::terminal;
use crate::experiment::Sample;
use crate::paper::{self, Case, Method, Run};
use crate::present::{Envelope, Figure, TIME};
use crate::render::chart::Size;
use crate::{present, render, report};

/// Where it goes unless stated. This folder is the program's own.
const FOLDER: &str = "results/paper";

/// The picture's name in the folder.
const PICTURE: &str = "figure-03.png";

#[derive(Debug, Default, clap::Args)]
pub(super) struct Arguments {
    /// The folder for picture, traces and results; by default results/paper, where those of an earlier run are
    /// replaced.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Width of the picture, in a paper of two columns.
    #[arg(long, value_enum, default_value_t)]
    size: Size,
    /// Replace existing files, in a folder of your own too.
    #[arg(long)]
    force: bool,
}

pub(super) fn run(arguments: &Arguments) -> Result<(), Fault> {
    let out = arguments.out.as_deref().unwrap_or(Path::new(FOLDER));
    std::fs::create_dir_all(out).map_err(|error| Fault::unusable(out.display(), &error))?;
    let mut files = Files::reading(&[], arguments.force || arguments.out.is_none());
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
    for (run, (csv, json)) in runs.iter().zip(tables) {
        written.push(csv.map(|csv| csv.table(|file| report::csv::write(file, &run.trace))));
        written.push(json.map(|json| json.document(&run.summary)));
    }
    let title = "Fig. 03: identified parameters over time";
    written.push(picture.map(|picture| picture.figures(title, 2, &figures(&runs))));
    files::commit(written)?;

    let page = present::paper("The paper's experiment", &call::command(), &runs);
    say!("{}", render::terminal::brief(&page, terminal::width()))?;
    say!("\nPicture: {}", out.join(PICTURE).display())?;
    say!(
        "Traces and results: {}",
        out.join("*.csv, *.json").display()
    )?;
    Ok(())
}

/// The eight panels of Fig. 03 in the paper's order: 1–2 proposed and 3–4 least squares without
/// load, 5–6 and 7–8 with it; odd panels â, even panels b̂, each kind on one scale.
fn figures(runs: &[Run; 4]) -> Vec<Figure> {
    /// Scales that the panels share, around the nominal values.
    const SCALE_A: [f64; 2] = [-0.3, 1.0];
    const SCALE_B: [f64; 2] = [0.0, 400.0];

    let mut figures = Vec::new();
    for run in runs {
        let number = figures.len() + 1;
        let method = match run.method {
            Method::Proposed => "proposed",
            Method::LeastSquares => "least squares",
        };
        let case = match run.case {
            Case::Balanced => "d = 0",
            Case::Unbalanced => "d ≠ 0",
        };
        let figure = |number, axis: &str, nominal, range, value: fn(&Sample) -> f64| {
            let points = run.trace.iter().map(|sample| (sample.time, value(sample)));
            let trace = points.collect::<Envelope>().trace("estimate");
            Figure::new(
                &format!("({number}) {method}, {case}"),
                TIME,
                axis,
                vec![trace],
            )
            .within(Some(range))
            .with_level("nominal", nominal)
        };
        figures.push(figure(number, "â [1/s]", paper::NOMINAL_A, SCALE_A, |s| {
            s.estimates.a
        }));
        figures.push(figure(
            number + 1,
            "b̂ [rad/s² per command unit]",
            paper::NOMINAL_B,
            SCALE_B,
            |s| s.estimates.b,
        ));
    }
    figures
}
