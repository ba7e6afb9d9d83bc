//! Drawing on pixels, with smooth edges.

use super::canvas::{Canvas, Direction, Rgb, Shape, TextStyle};
use super::error::{PlotError, Result};
use super::typeface::{PlacedGlyph, typeset};
use ab_glyph::OutlineCurve;
use tiny_skia::{
    Color, FillRule, LineCap, LineJoin, Paint, Path, PathBuilder, Pixmap, Stroke, Transform,
};

/// Draws a figure and returns the bytes of a PNG file.
pub(crate) fn draw(shape: Shape, draw: impl FnOnce(&mut dyn Canvas)) -> Result<Vec<u8>> {
    let (width, height) = (shape.width.round() as u32, shape.height.round() as u32);
    let failed = |cause: String| PlotError::Drawing { cause };
    let mut pixmap = Pixmap::new(width, height)
        .ok_or_else(|| failed(format!("{width} x {height} pixels are too many or too few")))?;
    pixmap.fill(Color::WHITE);
    let mut pixels = Pixels { pixmap };
    draw(&mut pixels);
    pixels
        .pixmap
        .encode_png()
        .map_err(|error| failed(error.to_string()))
}

struct Pixels {
    pixmap: Pixmap,
}

impl Pixels {
    fn fill(&mut self, path: Option<Path>, colour: Rgb, opacity: f64, transform: Transform) {
        // A shape without extent has no path and covers nothing.
        if let Some(path) = path {
            let paint = paint(colour, opacity);
            self.pixmap
                .fill_path(&path, &paint, FillRule::Winding, transform, None);
        }
    }
}

impl Canvas for Pixels {
    fn line(&mut self, points: &[[f64; 2]], width: f64, colour: Rgb) {
        let stroke = Stroke {
            width: width as f32,
            // Butt caps: ends of grid lines must not stick out of the frame.
            line_cap: LineCap::Butt,
            // Round joins: a sharp corner of a curve would throw a spike.
            line_join: LineJoin::Round,
            ..Stroke::default()
        };
        if let Some(path) = polygon(points, false) {
            let paint = paint(colour, 1.0);
            self.pixmap
                .stroke_path(&path, &paint, &stroke, Transform::identity(), None);
        }
    }

    fn disc(&mut self, [x, y]: [f64; 2], radius: f64, colour: Rgb, opacity: f64) {
        let circle = PathBuilder::from_circle(x as f32, y as f32, radius as f32);
        self.fill(circle, colour, opacity, Transform::identity());
    }

    fn polygon(&mut self, corners: &[[f64; 2]], colour: Rgb) {
        self.fill(polygon(corners, true), colour, 1.0, Transform::identity());
    }

    fn run(&mut self, text: &str, [x, y]: [f64; 2], style: TextStyle) {
        let Some(set) = typeset(text) else { return };
        let scale = (style.size / set.units_per_em) as f32;
        let placed = Transform::from_translate(x as f32, y as f32);
        let frame = match style.direction {
            Direction::Right => placed,
            // In pixels y points down, so -90° turns text upwards.
            Direction::Up => placed.pre_rotate(-90.0),
        };
        for glyph in &set.glyphs {
            let offset = (glyph.offset * style.size) as f32;
            // Outlines have y upward.
            let transform = frame.pre_translate(offset, 0.0).pre_scale(scale, -scale);
            self.fill(outline(glyph), style.colour, 1.0, transform);
        }
    }
}

fn paint(colour: Rgb, opacity: f64) -> Paint<'static> {
    let [red, green, blue] = colour;
    let mut paint = Paint::default();
    paint.set_color_rgba8(red, green, blue, (opacity * 255.0).round() as u8);
    paint.anti_alias = true;
    paint
}

fn polygon(points: &[[f64; 2]], closed: bool) -> Option<Path> {
    let mut builder = PathBuilder::new();
    for (number, [x, y]) in points.iter().enumerate() {
        match number {
            0 => builder.move_to(*x as f32, *y as f32),
            _ => builder.line_to(*x as f32, *y as f32),
        }
    }
    if closed {
        builder.close();
    }
    builder.finish()
}

/// The outline of a glyph. The typeface lists curves one by one; a contour ends where the next
/// curve does not begin at the end of the last.
fn outline(glyph: &PlacedGlyph) -> Option<Path> {
    let mut builder = PathBuilder::new();
    let mut end = None;
    for curve in &glyph.curves {
        let start = match curve {
            OutlineCurve::Line(start, _)
            | OutlineCurve::Quad(start, ..)
            | OutlineCurve::Cubic(start, ..) => *start,
        };
        // A contour closes itself when filled, so the start of the next is all that must be told.
        if end != Some(start) {
            builder.move_to(start.x, start.y);
        }
        end = Some(match curve {
            OutlineCurve::Line(_, to) => {
                builder.line_to(to.x, to.y);
                *to
            }
            OutlineCurve::Quad(_, control, to) => {
                builder.quad_to(control.x, control.y, to.x, to.y);
                *to
            }
            OutlineCurve::Cubic(_, first, second, to) => {
                builder.cubic_to(first.x, first.y, second.x, second.y, to.x, to.y);
                *to
            }
        });
    }
    builder.finish()
}
