//! The options of a picture.

use std::path::PathBuf;

use crate::render::chart::Size;

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
