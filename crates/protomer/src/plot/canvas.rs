//! Lines, markers and text, in units of the figure, on SVG or on pixels.
//!
//! Both are drawn several times too large, because the drawing library has whole coordinates: the
//! SVG is scaled by its view box, the pixels are averaged, which also smooths their edges.

use super::Shape;
use super::text::runs;
use ab_glyph::{Font, FontRef, GlyphId, PxScale, ScaleFont, point};
use anyhow::{Context, Result, anyhow};
use plotters::prelude::{BitMapBackend, DrawingBackend, SVGBackend};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{Color, FontTransform, IntoFont, RGBAColor, TextStyle};

/// How many times too large.
const OVERSIZE: u32 = 3;

/// Where the registered typeface is missing, a viewer of the SVG takes the next one of the list.
const TYPEFACE: &str = "DejaVu Sans, Verdana, Helvetica, Arial, sans-serif";

pub(super) type Rgb = [u8; 3];

/// Colours that are told apart with every kind of colour vision (Okabe and Ito,
/// <https://jfly.uni-koeln.de/color/>).
pub(super) const PALETTE: [Rgb; 7] = [
    [0x00, 0x72, 0xB2], // blue
    [0xD5, 0x5E, 0x00], // vermilion
    [0x00, 0x9E, 0x73], // bluish green
    [0xCC, 0x79, 0xA7], // reddish purple
    [0xE6, 0x9F, 0x00], // orange
    [0x56, 0xB4, 0xE9], // sky blue
    [0x30, 0x30, 0x30], // black
];

/// Shapes of points, so that series are told apart without colour too.
const MARKERS: [Marker; 4] = [
    Marker::Circle,
    Marker::Square,
    Marker::Triangle,
    Marker::Diamond,
];

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Marker {
    Circle,
    Square,
    Triangle,
    Diamond,
}

/// Colour and marker of the series of this number.
pub(super) fn style(series: usize) -> (Rgb, Marker) {
    (
        PALETTE[series % PALETTE.len()],
        MARKERS[series % MARKERS.len()],
    )
}

/// Where a text stands relative to its position.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Align {
    Left,
    Centre,
    Right,
}

/// Which way a text runs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Direction {
    Right,
    Up,
}

/// What the layout draws on; positions and lengths are in units of the figure, y downward.
pub(super) trait Canvas {
    /// Its size, and what may be done to long texts.
    fn shape(&self) -> Shape;
    fn line(&mut self, points: &[[f64; 2]], width: f64, colour: Rgb) -> Result<()>;
    fn disc(&mut self, centre: [f64; 2], radius: f64, colour: Rgb, opacity: f64) -> Result<()>;
    fn polygon(&mut self, corners: &[[f64; 2]], colour: Rgb) -> Result<()>;
    /// One run of text whose baseline begins at `position`; `size` is the length of an em.
    fn run(
        &mut self,
        text: &str,
        position: [f64; 2],
        size: f64,
        colour: Rgb,
        direction: Direction,
    ) -> Result<()>;

    /// A point: a filled shape of the marker's "radius".
    fn marker(&mut self, marker: Marker, centre: [f64; 2], radius: f64, colour: Rgb) -> Result<()> {
        let [x, y] = centre;
        let corners: &[[f64; 2]] = match marker {
            Marker::Circle => return self.disc(centre, radius, colour, 1.0),
            Marker::Square => &[[-0.88, -0.88], [0.88, -0.88], [0.88, 0.88], [-0.88, 0.88]],
            Marker::Triangle => &[[0.0, -1.25], [1.15, 0.75], [-1.15, 0.75]],
            Marker::Diamond => &[[0.0, -1.3], [1.3, 0.0], [0.0, 1.3], [-1.3, 0.0]],
        };
        let corners: Vec<_> = corners
            .iter()
            .map(|[dx, dy]| [x + dx * radius, y + dy * radius])
            .collect();
        self.polygon(&corners, colour)
    }

    /// A text with subscripts and superscripts, its baseline at `position`.
    fn text(
        &mut self,
        text: &str,
        position: [f64; 2],
        size: f64,
        colour: Rgb,
        align: Align,
        direction: Direction,
    ) -> Result<()> {
        let mut along = match align {
            Align::Left => 0.0,
            Align::Centre => -text_width(text, size)? / 2.0,
            Align::Right => -text_width(text, size)?,
        };
        for run in runs(text) {
            let (scale, raise) = run.level.scale_and_raise();
            let [x, y] = position;
            let start = match direction {
                Direction::Right => [x + along, y - raise * size],
                Direction::Up => [x - raise * size, y - along],
            };
            self.run(&run.text, start, size * scale, colour, direction)?;
            along += run_width(&run.text, size * scale)?;
        }
        Ok(())
    }
}

/// Width of a text with subscripts and superscripts.
pub(super) fn text_width(text: &str, size: f64) -> Result<f64> {
    runs(text)
        .iter()
        .map(|run| run_width(&run.text, size * run.level.scale_and_raise().0))
        .sum()
}

fn run_width(text: &str, size: f64) -> Result<f64> {
    Ok(Typeset::new(text, size)?.width)
}

/// A run of text in glyphs of the built-in typeface.
struct Typeset {
    font: FontRef<'static>,
    scale: PxScale,
    /// The glyphs, each with its distance from the beginning of the baseline.
    glyphs: Vec<(GlyphId, f32)>,
    /// Length of the run.
    width: f64,
}

impl Typeset {
    fn new(text: &str, size: f64) -> Result<Self> {
        let font = FontRef::try_from_slice(dejavu::sans::regular())
            .context("the built-in typeface cannot be read")?;
        // The font library scales by the height from descent to ascent, not by the em.
        let em = font
            .units_per_em()
            .context("the built-in typeface has no em")?;
        let scale = PxScale::from(size as f32 * font.height_unscaled() / em);
        let scaled = font.as_scaled(scale);
        let mut glyphs: Vec<(GlyphId, f32)> = Vec::new();
        let mut along = 0.0;
        for character in text.chars() {
            let glyph = scaled.glyph_id(character);
            along += glyphs
                .last()
                .map_or(0.0, |(previous, _)| scaled.kern(*previous, glyph));
            glyphs.push((glyph, along));
            along += scaled.h_advance(glyph);
        }
        Ok(Self {
            font,
            scale,
            glyphs,
            width: f64::from(along),
        })
    }

    /// Calls `draw` with each pixel that the run covers, relative to the beginning of the baseline,
    /// and how much of it.
    fn rasterize(&self, mut draw: impl FnMut(i32, i32, f32)) {
        for (glyph, along) in &self.glyphs {
            let glyph = glyph.with_scale_and_position(self.scale, point(*along, 0.0));
            if let Some(outline) = self.font.outline_glyph(glyph) {
                let corner = outline.px_bounds().min;
                outline.draw(|x, y, cover| {
                    draw(
                        corner.x as i32 + x as i32,
                        corner.y as i32 + y as i32,
                        cover,
                    )
                });
            }
        }
    }
}

/// Draws on SVG and returns its text.
pub(super) fn draw_svg(
    shape: Shape,
    draw: impl FnOnce(&mut dyn Canvas) -> Result<()>,
) -> Result<String> {
    let mut svg = String::new();
    let size = (shape.width * OVERSIZE, shape.height * OVERSIZE);
    {
        let backend = SVGBackend::with_string(&mut svg, size);
        let mut surface = Surface {
            backend,
            text: Text::Element,
            shape,
        };
        draw(&mut surface)?;
        surface
            .backend
            .present()
            .map_err(|error| anyhow!("cannot draw SVG: {error}"))?;
    }
    let start = format!("<svg width=\"{}\" height=\"{}\"", size.0, size.1);
    let begin = svg
        .find(&start)
        .context("the drawing library has written an unknown kind of SVG")?;
    Ok(format!(
        "<svg width=\"{}\" height=\"{}\"{}",
        shape.width,
        shape.height,
        &svg[begin + start.len()..]
    ))
}

/// Draws on pixels and returns the bytes of a PNG file.
pub(super) fn draw_png(
    shape: Shape,
    draw: impl FnOnce(&mut dyn Canvas) -> Result<()>,
) -> Result<Vec<u8>> {
    let size = (shape.width * OVERSIZE, shape.height * OVERSIZE);
    let mut pixels = vec![255; size.0 as usize * size.1 as usize * 3];
    {
        let backend = BitMapBackend::with_buffer(&mut pixels, size);
        let mut surface = Surface {
            backend,
            text: Text::Pixels,
            shape,
        };
        draw(&mut surface)?;
        surface
            .backend
            .present()
            .map_err(|error| anyhow!("cannot draw pixels: {error}"))?;
    }
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, shape.width, shape.height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder
        .write_header()?
        .write_image_data(&average(&pixels, shape))?;
    Ok(bytes)
}

/// Each pixel the mean of the oversized pixels it covers.
fn average(pixels: &[u8], shape: Shape) -> Vec<u8> {
    let (width, height, oversize) = (
        shape.width as usize,
        shape.height as usize,
        OVERSIZE as usize,
    );
    let mut averaged = Vec::with_capacity(width * height * 3);
    for y in 0..height {
        for x in 0..width {
            for channel in 0..3 {
                let column = |row: usize| (row * width * oversize + x * oversize) * 3 + channel;
                let rows = (y * oversize..(y + 1) * oversize).map(column);
                let sum: usize = rows
                    .flat_map(|start| (0..oversize).map(move |i| start + 3 * i))
                    .map(|i| usize::from(pixels[i]))
                    .sum();
                averaged.push(((sum + oversize * oversize / 2) / (oversize * oversize)) as u8);
            }
        }
    }
    averaged
}

/// How text gets on a surface.
#[derive(Clone, Copy, PartialEq)]
enum Text {
    /// As text, left to the viewer.
    Element,
    /// As pixels.
    Pixels,
}

struct Surface<B: DrawingBackend> {
    backend: B,
    text: Text,
    shape: Shape,
}

/// Leaves nothing behind: to learn how much room something takes.
pub(super) struct Nowhere(pub Shape);

impl Canvas for Nowhere {
    fn shape(&self) -> Shape {
        self.0
    }

    fn line(&mut self, _: &[[f64; 2]], _: f64, _: Rgb) -> Result<()> {
        Ok(())
    }

    fn disc(&mut self, _: [f64; 2], _: f64, _: Rgb, _: f64) -> Result<()> {
        Ok(())
    }

    fn polygon(&mut self, _: &[[f64; 2]], _: Rgb) -> Result<()> {
        Ok(())
    }

    fn run(&mut self, _: &str, _: [f64; 2], _: f64, _: Rgb, _: Direction) -> Result<()> {
        Ok(())
    }
}

fn enlarge([x, y]: [f64; 2]) -> (i32, i32) {
    let enlarge = |coordinate: f64| (coordinate * f64::from(OVERSIZE)).round() as i32;
    (enlarge(x), enlarge(y))
}

fn colour_of([red, green, blue]: Rgb, opacity: f64) -> RGBAColor {
    RGBAColor(red, green, blue, opacity)
}

fn failed(error: impl std::fmt::Display) -> anyhow::Error {
    anyhow!("cannot draw: {error}")
}

impl<B: DrawingBackend> Canvas for Surface<B> {
    fn shape(&self) -> Shape {
        self.shape
    }

    fn line(&mut self, points: &[[f64; 2]], width: f64, colour: Rgb) -> Result<()> {
        let stroke = (width * f64::from(OVERSIZE)).round().max(1.0) as u32;
        let style = plotters::style::ShapeStyle {
            color: colour_of(colour, 1.0),
            filled: false,
            stroke_width: stroke,
        };
        self.backend
            .draw_path(points.iter().copied().map(enlarge), &style)
            .map_err(failed)
    }

    fn disc(&mut self, centre: [f64; 2], radius: f64, colour: Rgb, opacity: f64) -> Result<()> {
        let radius = (radius * f64::from(OVERSIZE)).round() as u32;
        self.backend
            .draw_circle(enlarge(centre), radius, &colour_of(colour, opacity), true)
            .map_err(failed)
    }

    fn polygon(&mut self, corners: &[[f64; 2]], colour: Rgb) -> Result<()> {
        self.backend
            .fill_polygon(
                corners.iter().copied().map(enlarge),
                &colour_of(colour, 1.0),
            )
            .map_err(failed)
    }

    fn run(
        &mut self,
        text: &str,
        position: [f64; 2],
        size: f64,
        colour: Rgb,
        direction: Direction,
    ) -> Result<()> {
        match self.text {
            Text::Element => self.text_element(text, position, size, colour, direction),
            Text::Pixels => self.text_pixels(text, position, size, colour, direction),
        }
    }
}

impl<B: DrawingBackend> Surface<B> {
    fn text_element(
        &mut self,
        text: &str,
        [x, y]: [f64; 2],
        size: f64,
        colour: Rgb,
        direction: Direction,
    ) -> Result<()> {
        // SVG drops spaces at the ends of a run, but not those that do not break.
        let text = text.replace(' ', "\u{a0}");
        // The library divides sizes by 1.24 to have the em, and puts the baseline 0.76 em below a
        // text's top.
        let drop = 0.76 * size;
        let (position, transform) = match direction {
            Direction::Right => ([x, y - drop], FontTransform::None),
            Direction::Up => ([x - drop, y], FontTransform::Rotate270),
        };
        let font = (TYPEFACE, (size * f64::from(OVERSIZE)).round() * 1.24)
            .into_font()
            .transform(transform);
        let colour = colour_of(colour, 1.0);
        let style = TextStyle::from(font)
            .color(&colour)
            .pos(Pos::new(HPos::Left, VPos::Top));
        self.backend
            .draw_text(&text, &style, enlarge(position))
            .map_err(failed)
    }

    fn text_pixels(
        &mut self,
        text: &str,
        position: [f64; 2],
        size: f64,
        colour: Rgb,
        direction: Direction,
    ) -> Result<()> {
        let (left, baseline) = enlarge(position);
        let mut result = Ok(());
        Typeset::new(text, size * f64::from(OVERSIZE))?.rasterize(|x, y, cover| {
            let pixel = match direction {
                Direction::Right => (left + x, baseline + y),
                Direction::Up => (left + y, baseline - x),
            };
            let colour = colour_of(colour, f64::from(cover.clamp(0.0, 1.0)));
            if let Err(error) = self.backend.draw_pixel(pixel, colour.to_backend_color()) {
                result = Err(failed(error));
            }
        });
        result
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn widths_grow_with_the_text_and_its_size() {
        let width = |text: &str, size| text_width(text, size).unwrap();
        assert!(width("ii", 20.0) < width("mm", 20.0));
        assert!((width("salt", 40.0) / width("salt", 20.0) - 2.0).abs() < 0.05);
        assert!(width("R_g", 20.0) < width("Rg", 20.0));
    }
}
