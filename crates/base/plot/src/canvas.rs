//! The shapes that every output can draw, in units of the figure, y downward.

use super::runs::runs;
use super::typeface::text_width;

pub(crate) type Rgb = [u8; 3];

/// Colours that are distinguishable with every kind of colour vision (Okabe and Ito,
/// <https://jfly.uni-koeln.de/color/>).
pub(crate) const PALETTE: [Rgb; 7] = [
    [0x00, 0x72, 0xB2], // blue
    [0xD5, 0x5E, 0x00], // vermilion
    [0x00, 0x9E, 0x73], // bluish green
    [0xCC, 0x79, 0xA7], // reddish purple
    [0xE6, 0x9F, 0x00], // orange
    [0x56, 0xB4, 0xE9], // sky blue
    [0x30, 0x30, 0x30], // black
];

/// Marker shapes, so that series are distinguishable without colour too.
const MARKERS: [Marker; 4] = [
    Marker::Circle,
    Marker::Square,
    Marker::Triangle,
    Marker::Diamond,
];

#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Marker {
    Circle,
    Square,
    Triangle,
    Diamond,
}

/// Colour and marker of a series.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Style {
    pub colour: Rgb,
    pub marker: Marker,
}

impl Style {
    /// The style of the series of this number.
    pub fn of_series(number: usize) -> Self {
        Self {
            colour: PALETTE[number % PALETTE.len()],
            marker: MARKERS[number % MARKERS.len()],
        }
    }
}

/// Size of a figure, and how far long texts may shrink.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Shape {
    pub width: f64,
    pub height: f64,
    /// Part of their size to which texts may shrink before they are broken into lines.
    pub least_shrunk: f64,
}

/// Alignment of a text relative to its position.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Align {
    Left,
    Centre,
    Right,
}

/// The direction of a text.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Direction {
    Right,
    Up,
}

/// Style of a text: the length of an em, colour, alignment and direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct TextStyle {
    pub size: f64,
    pub colour: Rgb,
    pub align: Align,
    pub direction: Direction,
}

impl TextStyle {
    pub fn new(size: f64, colour: Rgb, align: Align) -> Self {
        Self {
            size,
            colour,
            align,
            direction: Direction::Right,
        }
    }

    pub fn upward(self) -> Self {
        Self {
            direction: Direction::Up,
            ..self
        }
    }
}

/// A drawing surface for the layout.
pub(crate) trait Canvas {
    fn line(&mut self, points: &[[f64; 2]], width: f64, colour: Rgb);
    fn disc(&mut self, centre: [f64; 2], radius: f64, colour: Rgb, opacity: f64);
    fn polygon(&mut self, corners: &[[f64; 2]], colour: Rgb);
    /// Draws one run of text whose baseline begins at `start`.
    fn run(&mut self, text: &str, start: [f64; 2], style: TextStyle);

    /// Draws a filled shape of the marker's "radius".
    fn marker(&mut self, marker: Marker, centre: [f64; 2], radius: f64, colour: Rgb) {
        let corners: &[[f64; 2]] = match marker {
            Marker::Circle => return self.disc(centre, radius, colour, 1.0),
            Marker::Square => &[[-0.88, -0.88], [0.88, -0.88], [0.88, 0.88], [-0.88, 0.88]],
            Marker::Triangle => &[[0.0, -1.25], [1.15, 0.75], [-1.15, 0.75]],
            Marker::Diamond => &[[0.0, -1.3], [1.3, 0.0], [0.0, 1.3], [-1.3, 0.0]],
        };
        let [x, y] = centre;
        let placed: Vec<[f64; 2]> = corners
            .iter()
            .map(|[dx, dy]| [x + dx * radius, y + dy * radius])
            .collect();
        self.polygon(&placed, colour);
    }

    /// Draws a text with subscripts and superscripts, its baseline at `position`.
    fn text(&mut self, text: &str, [x, y]: [f64; 2], style: TextStyle) {
        let width = text_width(text, style.size);
        let mut offset = match style.align {
            Align::Left => 0.0,
            Align::Centre => -width / 2.0,
            Align::Right => -width,
        };
        for run in runs(text) {
            let (scale, raise) = run.level.scale_and_raise();
            let start = match style.direction {
                Direction::Right => [x + offset, y - raise * style.size],
                Direction::Up => [x - raise * style.size, y - offset],
            };
            let size = style.size * scale;
            self.run(&run.text, start, TextStyle { size, ..style });
            offset += text_width(&run.text, size);
        }
    }
}

/// Canvas that draws nothing: used to measure the size of something.
pub(crate) struct Nowhere;

impl Canvas for Nowhere {
    fn line(&mut self, _: &[[f64; 2]], _: f64, _: Rgb) {}
    fn disc(&mut self, _: [f64; 2], _: f64, _: Rgb, _: f64) {}
    fn polygon(&mut self, _: &[[f64; 2]], _: Rgb) {}
    fn run(&mut self, _: &str, _: [f64; 2], _: TextStyle) {}
}
