//! A canvas as pixels.

use zeno::{Join, Mask, PathData, Style, Transform};

use super::font;
use super::surface::{Colour, Frame, Label, Stroke, Surface};
use crate::program;

/// Pixels to a point: 216 to an inch.
const SCALE: f64 = 3.0;

/// Colours of pixels, row by row.
pub(super) struct Pixels {
    width: usize,
    height: usize,
    rgb: Vec<[u8; 3]>,
    /// The first and the last column and row to be drawn in, the last excluded.
    columns: [i32; 2],
    rows: [i32; 2],
}

impl Pixels {
    /// An empty canvas of a width and a height, points.
    pub(super) fn new(width: f64, height: f64) -> Self {
        let [width, height] = [width, height].map(|length| (SCALE * length).round());
        Self {
            width: width as usize,
            height: height as usize,
            rgb: vec![Colour::Paper.rgb(); (width * height) as usize],
            columns: [0, width as i32],
            rows: [0, height as i32],
        }
    }

    fn path(&mut self, path: &str, style: Style<'_>, colour: Colour, opacity: f64) {
        let scale = SCALE as f32;
        let mut mask = Mask::new(path);
        mask.style(style)
            .transform(Some(Transform::scale(scale, scale)));
        self.blend(&mask, colour, opacity);
    }

    fn blend(&mut self, mask: &Mask<'_, '_, impl PathData>, colour: Colour, opacity: f64) {
        let (coverage, place) = mask.render();
        let colour = colour.rgb();
        for (row, line) in (place.top..).zip(coverage.chunks(place.width.max(1) as usize)) {
            if !(self.rows[0]..self.rows[1]).contains(&row) {
                continue;
            }
            for (column, &covered) in (place.left..).zip(line) {
                if covered == 0 || !(self.columns[0]..self.columns[1]).contains(&column) {
                    continue;
                }
                let part = opacity * f64::from(covered) / 255.0;
                let pixel = &mut self.rgb[row as usize * self.width + column as usize];
                for (below, above) in pixel.iter_mut().zip(colour) {
                    let (old, new) = (f64::from(*below), f64::from(above));
                    *below = (old + part * (new - old)).round() as u8;
                }
            }
        }
    }

    /// The bytes of a file of PNG.
    pub(super) fn png(&self) -> Vec<u8> {
        const METRES_PER_POINT: f64 = 0.0254 / 72.0;
        let per_metre = (SCALE / METRES_PER_POINT).round() as u32;
        let mut file = Vec::new();
        let mut encoder = png::Encoder::new(&mut file, self.width as u32, self.height as u32);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_pixel_dims(Some(png::PixelDimensions {
            xppu: per_metre,
            yppu: per_metre,
            unit: png::Unit::Meter,
        }));
        // Writing into memory cannot fail.
        let _ = (encoder.add_text_chunk("Software".to_owned(), program::NAME.to_owned()))
            .and_then(|()| encoder.write_header())
            .and_then(|mut writer| writer.write_image_data(self.rgb.as_flattened()));
        file
    }
}

impl Surface for Pixels {
    fn area(&mut self, path: &str, colour: Colour, opacity: f64) {
        self.path(path, Style::default(), colour, opacity);
    }

    fn line(&mut self, path: &str, stroke: Stroke) {
        let mut style = zeno::Stroke::new(stroke.width as f32);
        style.join(Join::Round);
        if let Some(dashes) = &stroke.dashes {
            style.dash(dashes, 0.0);
        }
        self.path(path, style.into(), stroke.colour, 1.0);
    }

    fn text(&mut self, label: &Label) {
        let ((x, y), size) = (label.at, label.size);
        let left = x - label.align.part() * font::width(&label.text, size);
        let outlines = font::outlines((left, y), &label.text, size, SCALE);
        self.blend(&Mask::new(outlines.as_slice()), Colour::Ink, 1.0);
    }

    fn cut(&mut self, frame: Option<Frame>) {
        let pixel = |length: f64| (SCALE * length).round() as i32;
        (self.columns, self.rows) = match frame {
            Some(frame) => (
                [pixel(frame.left), pixel(frame.right())],
                [pixel(frame.top), pixel(frame.bottom())],
            ),
            None => ([0, self.width as i32], [0, self.height as i32]),
        };
    }
}

#[cfg(test)]
mod tests {
    use super::super::canvas::Canvas;
    use super::*;

    fn canvas() -> Canvas {
        Canvas::new(40.0, 20.0)
    }

    fn drawn(canvas: &Canvas) -> Pixels {
        canvas.on(Pixels::new(canvas.width, canvas.height))
    }

    #[test]
    fn lines_dashes_and_cuts_are_where_svg_has_them() {
        let mut canvas = canvas();
        let frame = Frame {
            left: 10.0,
            top: 0.0,
            width: 20.0,
            height: 20.0,
        };
        let dashed = Stroke {
            colour: Colour::Ink,
            width: 2.0,
            dashes: Some([5.0, 5.0]),
        };
        canvas.inside(frame, |canvas| {
            canvas.line((0.0, 10.0), (40.0, 10.0), dashed)
        });
        let pixels = drawn(&canvas);
        let at = |x: usize, y: usize| pixels.rgb[3 * y * pixels.width + 3 * x];
        let (black, white) = ([0; 3], [255; 3]);
        assert_eq!([at(12, 10), at(17, 10), at(22, 10)], [black, white, black]);
        assert_eq!([at(2, 10), at(32, 10), at(12, 12)], [white; 3], "outside");
    }

    #[test]
    fn an_area_lets_through_what_lies_below() {
        let mut canvas = canvas();
        let frame = Frame {
            left: 0.0,
            top: 0.0,
            width: 40.0,
            height: 20.0,
        };
        canvas.rectangle(frame, Colour::Ink, 0.2);
        assert_eq!(drawn(&canvas).rgb[500], [204; 3]);
    }

    #[test]
    fn a_file_has_its_size_and_resolution() {
        let file = canvas().png();
        assert!(file.starts_with(b"\x89PNG\r\n\x1a\n\0\0\0\x0dIHDR\0\0\0\x78\0\0\0\x3c\x08\x02"));
        let per_metre = 8504_u32.to_be_bytes();
        let resolution = [&b"pHYs"[..], &per_metre, &per_metre, &[1]].concat();
        assert!(
            file.windows(resolution.len())
                .any(|part| part == resolution)
        );
        assert!(file.ends_with(b"\0\0\0\0IEND\xae\x42\x60\x82"));
    }
}
