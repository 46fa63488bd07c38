//! The files of one call: inputs that are protected, and outputs that appear complete or not at all.

use std::fs::{self, File, Metadata};
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use same_file::Handle;

use super::fault::Fault;
use super::output_file::Output;
use super::place::Place;
use crate::present::Page;
use crate::render::chart::{self, Format, Size};

/// The files of one call. Every output is claimed before any work is done.
#[derive(Debug)]
pub(super) struct Files {
    /// Files of others may be replaced, too.
    force: bool,
    inputs: Vec<Identity>,
    outputs: Vec<(Identity, PathBuf)>,
    standard_output: bool,
}

/// The options of a picture.
#[derive(Debug, Default, clap::Args)]
pub(super) struct Drawing {
    /// Draw the result into this file, .png or .svg; `-` is standard output, as SVG.
    #[arg(long, value_name = "FILE")]
    pub(super) plot: Option<PathBuf>,
    /// Width of the picture, in a paper of two columns.
    #[arg(long, value_enum, default_value_t)]
    pub(super) size: Size,
}

/// A picture that is requested.
#[derive(Debug)]
pub(super) struct Picture {
    format: Format,
    size: Size,
    output: Output,
}

/// The identity of a file, under all of its names if it exists.
#[derive(Debug, PartialEq, Eq)]
enum Identity {
    Existing(Handle),
    Named(PathBuf),
}

impl Files {
    /// The files of a call that reads these.
    pub(super) fn reading(inputs: &[&Path], force: bool) -> Self {
        let identity = |name: &&Path| {
            fs::metadata(name).ok().filter(Metadata::is_file)?;
            Some(Identity::new(&name.canonicalize().ok()?))
        };
        Self {
            force,
            inputs: inputs.iter().filter_map(identity).collect(),
            outputs: Vec::new(),
            standard_output: false,
        }
    }

    /// Begins an output, if one is requested; `-` is standard output.
    ///
    /// # Errors
    /// Bad input, if it is also read or written, is a file that this program did not write, or cannot be written.
    pub(super) fn output(&mut self, name: Option<&Path>) -> Result<Option<Output>, Fault> {
        name.map(|name| self.begin(name)).transpose()
    }

    /// Begins a picture, if one is requested. Its name ends with the format; on standard output it is SVG.
    ///
    /// # Errors
    /// As [`output`](Self::output), and if the name ends in no known format.
    pub(super) fn picture(&mut self, drawing: &Drawing) -> Result<Option<Picture>, Fault> {
        let Some(name) = drawing.plot.as_deref() else {
            return Ok(None);
        };
        let format = if Place::is_standard_output(name) {
            Format::Svg
        } else {
            Format::of_file(name).ok_or_else(|| {
                let name = name.display();
                Fault::Input(format!("{name}: a picture's name must end in .png or .svg"))
            })?
        };
        let output = self.begin(name)?;
        Ok(Some(Picture {
            format,
            size: drawing.size,
            output,
        }))
    }

    /// Begins the description beside a trace in CSV, if it is a file of its own.
    ///
    /// # Errors
    /// As [`output`](Self::output).
    pub(super) fn description_of(&mut self, csv: Option<&Path>) -> Result<Option<Output>, Fault> {
        let Some(csv) = csv else { return Ok(None) };
        match Place::follow(csv) {
            Ok(Place::File { .. }) => {
                let mut name = csv.as_os_str().to_owned();
                name.push("-metadata.json");
                self.output(Some(Path::new(&name)))
            }
            _ => Ok(None),
        }
    }

    fn begin(&mut self, name: &Path) -> Result<Output, Fault> {
        let unusable = |error: io::Error| Fault::unusable(name.display(), &error);
        let place = Place::follow(name).map_err(unusable)?;
        self.claim(name, &place)
            .map_err(|why| Fault::of_file(name, why))?;
        Output::begin(name, place).map_err(unusable)
    }

    /// Reserves a place for one output, or returns why it cannot be one.
    fn claim(&mut self, name: &Path, place: &Place) -> Result<(), String> {
        match place {
            Place::StandardOutput if self.standard_output => {
                Err("two results cannot both go to standard output: write one to a file".to_owned())
            }
            Place::StandardOutput => {
                self.standard_output = true;
                Ok(())
            }
            Place::Device(_) => Ok(()),
            Place::File { path, existing } => {
                let identity = Identity::new(path);
                if self.inputs.contains(&identity) {
                    return Err("this file is an input: write to another one".to_owned());
                }
                if let Some((_, other)) = self.outputs.iter().find(|(known, _)| *known == identity)
                {
                    let other = other.display();
                    return Err(format!(
                        "this is the same file as {other}: write to two files"
                    ));
                }
                if existing.is_some() && !self.force && !is_own(path) {
                    let why = "the file exists and is none that this program wrote: name another, or state --force";
                    return Err(why.to_owned());
                }
                self.outputs.push((identity, name.to_owned()));
                Ok(())
            }
        }
    }

    /// Standard output holds a result, so that nothing else may be printed there.
    pub(super) fn own_standard_output(&self) -> bool {
        self.standard_output
    }
}

/// Commits results under their names, and returns those of files; none, if one of them could not be written.
pub(super) fn commit(
    written: impl IntoIterator<Item = Option<Result<Output, Fault>>>,
) -> Result<Vec<PathBuf>, Fault> {
    let outputs: Vec<Output> = written.into_iter().flatten().collect::<Result<_, _>>()?;
    let files = outputs.into_iter().map(Output::commit);
    Ok(files
        .collect::<Result<Vec<_>, _>>()?
        .into_iter()
        .flatten()
        .collect())
}

/// True for a file that this program wrote, by its beginning, or an empty one.
fn is_own(path: &Path) -> bool {
    /// What the beginnings of its results, tables, pictures, pages, scenarios and exports have, and no other file.
    const MARKS: [&str; 20] = [
        "\n  \"law\": \"",
        "\n  \"cases\": [\n    {\n      \"case\": ",
        "\n  \"predicted_response\": ",
        "\n  \"gains_before\": ",
        "\n  \"servo_on_chip\": ",
        "\n  \"index_from_edge\": ",
        "\n  \"origin\": {\n    \"version\": ",
        "\n  \"joints\": [\n    {\n      \"armature\": {",
        "\n  \"servo_id\": {\n    \"errors\": ",
        ",command,output_error_",
        ",residual_",
        ",command,phase",
        ",load_found,",
        "<metadata>servo-id</metadata>",
        "name=\"generator\" content=\"servo-id\"",
        "Software\0servo-id",
        "as `servo-id identify` took it:",
        "recording of `servo-id drive monitor`",
        "identified by servo-id ",
        "Written by servo-id ",
    ];
    /// The length of a beginning.
    const BEGINNING: u64 = 4096;
    let mut begins = Vec::new();
    let read = File::open(path).and_then(|file| file.take(BEGINNING).read_to_end(&mut begins));
    let begins = String::from_utf8_lossy(&begins);
    read.is_ok() && (begins.is_empty() || MARKS.iter().any(|mark| begins.contains(mark)))
}

impl Picture {
    /// Draws the figures of a page, row by row.
    pub(super) fn figures(
        mut self,
        title: &str,
        columns: usize,
        page: &Page,
    ) -> Result<Output, Fault> {
        let canvas = chart::figures(self.size, title, columns, page.figures());
        self.output.bytes(&canvas.bytes(self.format))?;
        Ok(self.output)
    }
}

impl Identity {
    /// For a file under its name without links.
    fn new(path: &Path) -> Self {
        Handle::from_path(path).map_or_else(|_| Self::Named(path.to_owned()), Self::Existing)
    }
}
