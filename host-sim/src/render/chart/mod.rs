//! Pictures, as SVG and as PNG.

mod axes;
mod canvas;
pub mod heat_map;
mod legend;
pub mod plot;
pub(crate) mod scale;
pub mod timeline;
