//! Where a picture goes, and how wide it is.

use std::path::PathBuf;

use crate::render::chart::Size;

/// Where a picture goes, and how wide it is.
#[derive(Debug, Default, clap::Args)]
pub(super) struct Drawing {
    /// Draw what was found into this file, .png or .svg; `-` is standard output, as SVG.
    #[arg(long, value_name = "FILE")]
    pub(super) plot: Option<PathBuf>,
    /// How wide the picture is, in a paper of two columns.
    #[arg(long, value_enum, default_value_t)]
    pub(super) size: Size,
}
