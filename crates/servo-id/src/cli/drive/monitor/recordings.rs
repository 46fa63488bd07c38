//! Recordings as files: each has its name when it is complete, with a scenario beside it.

use std::io::Write;
use std::path::{Path, PathBuf};

use drive_link::Settings;

use crate::cli::fault::Fault;
use crate::cli::files::{self, Files};
use crate::cli::output_file::Output;
use crate::monitor::{Frame, FrameRecording, Taken};

/// Extension of the scenario beside a log.
const SCENARIO: &str = "toml";

/// The recordings of a session.
#[derive(Debug)]
pub(super) struct Recordings {
    wanted: PathBuf,
    under_way: Option<UnderWay>,
}

#[derive(Debug)]
struct UnderWay {
    name: String,
    log: FrameRecording<Output>,
    scenario: Output,
}

impl Recordings {
    /// The first of them under this name, if it is free.
    pub(super) fn to(wanted: &Path) -> Self {
        Self {
            wanted: wanted.to_owned(),
            under_way: None,
        }
    }

    /// The name of the one that is under way, and its rows so far.
    pub(super) fn under_way(&self) -> Option<(&str, u64)> {
        let under_way = self.under_way.as_ref()?;
        Some((&under_way.name, under_way.log.rows()))
    }

    /// Begins one; the drive sends a frame every `every` samples.
    ///
    /// # Errors
    /// If its files cannot be written there.
    pub(super) fn begin(&mut self, settings: &Settings, every: u16) -> Result<(), Fault> {
        let path = self.free_name();
        let mut files = Files::reading(&[], false);
        let log = files.output(Some(&path))?;
        let scenario = files.output(Some(&path.with_extension(SCENARIO)))?;
        self.under_way = log.zip(scenario).map(|(log, scenario)| UnderWay {
            name: path.display().to_string(),
            log: FrameRecording::new(log, *settings, every),
            scenario,
        });
        Ok(())
    }

    /// Adds a frame to the recording that is under way; returns a message if that ends it.
    ///
    /// # Errors
    /// If it cannot be written: then it has ended, and nothing is kept of it.
    pub(super) fn add(&mut self, frame: &Frame) -> Result<Option<String>, Fault> {
        let Some(under_way) = &mut self.under_way else {
            return Ok(None);
        };
        match under_way.log.add(frame) {
            Ok(Taken::Row) => Ok(None),
            Ok(Taken::Over) => self.end(),
            Err(error) => {
                let fault = Fault::unwritable(&under_way.name, &error);
                self.under_way = None;
                Err(ended_without(&fault))
            }
        }
    }

    /// Ends the one that is under way; returns a message.
    ///
    /// # Errors
    /// If it cannot be written: then nothing is kept of it.
    pub(super) fn end(&mut self) -> Result<Option<String>, Fault> {
        let Some(UnderWay {
            name,
            log,
            scenario,
        }) = self.under_way.take()
        else {
            return Ok(None);
        };
        let rows = log.rows();
        let beside = scenario.name().display().to_string();
        let Some((log, text)) = log.finish() else {
            return Ok(Some(format!(
                "{name} is not written: the servo did not move"
            )));
        };
        kept(log, scenario, &text).map_err(|fault| ended_without(&fault))?;
        Ok(Some(format!(
            "{rows} rows: servo-id identify {name} --scenario {beside}"
        )))
    }

    /// The wanted name, or the same with a number, so that nothing is replaced.
    fn free_name(&self) -> PathBuf {
        let taken = |path: &PathBuf| path.exists() || path.with_extension(SCENARIO).exists();
        let stem = self.wanted.file_stem().unwrap_or_default();
        let numbered = |number: u32| {
            let mut name = stem.to_owned();
            name.push(format!("-{number}"));
            if let Some(extension) = self.wanted.extension() {
                name.push(".");
                name.push(extension);
            }
            self.wanted.with_file_name(name)
        };
        let names = std::iter::once(self.wanted.clone()).chain((2..).map(numbered));
        names
            .into_iter()
            .find(|path| !taken(path))
            .unwrap_or_else(|| self.wanted.clone())
    }
}

/// Completes both before either gets its name.
fn kept(mut log: Output, mut scenario: Output, text: &str) -> Result<(), Fault> {
    let flushed = log.flush();
    flushed.map_err(|error| log.unwritable(&error))?;
    scenario.bytes(text.as_bytes())?;
    let flushed = scenario.flush();
    flushed.map_err(|error| scenario.unwritable(&error))?;
    files::commit([Some(Ok(log)), Some(Ok(scenario))]).map(drop)
}

fn ended_without(fault: &Fault) -> Fault {
    Fault::Other(format!(
        "{fault}: the recording has ended and is discarded; the servo is unaffected"
    ))
}
