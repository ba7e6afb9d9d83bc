//! Drawing on SVG. Text stays text.

use super::canvas::{Canvas, Direction, Rgb, Shape, TextStyle};
use super::typeface::FAMILY;
use protomer_io::written::printable;
use std::fmt::Write;

/// Characters with a meaning in SVG, and what stands for them. `&` comes first.
pub(crate) const ESCAPES: [(&str, &str); 3] = [("&", "&amp;"), ("<", "&lt;"), (">", "&gt;")];

/// Draws a figure and returns the text of the SVG.
pub(crate) fn draw(shape: Shape, draw: impl FnOnce(&mut dyn Canvas)) -> String {
    let Shape { width, height, .. } = shape;
    let mut svg = Svg {
        text: format!(
            "<svg width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {width} {height}\" \
             xmlns=\"http://www.w3.org/2000/svg\" font-family=\"{FAMILY}\">\n"
        ),
    };
    draw(&mut svg);
    svg.text.push_str("</svg>\n");
    svg.text
}

struct Svg {
    text: String,
}

impl Svg {
    fn element(&mut self, element: std::fmt::Arguments<'_>) {
        // Writing to a string cannot fail.
        let _ = self.text.write_fmt(element);
        self.text.push('\n');
    }
}

impl Canvas for Svg {
    fn line(&mut self, points: &[[f64; 2]], width: f64, colour: Rgb) {
        self.element(format_args!(
            "<polyline points=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"{}\"/>",
            coordinates(points),
            hex(colour),
            number(width)
        ));
    }

    fn disc(&mut self, [x, y]: [f64; 2], radius: f64, colour: Rgb, opacity: f64) {
        let faint = match opacity < 1.0 {
            true => format!(" opacity=\"{opacity}\""),
            false => String::new(),
        };
        self.element(format_args!(
            "<circle cx=\"{}\" cy=\"{}\" r=\"{}\" fill=\"{}\"{faint}/>",
            number(x),
            number(y),
            number(radius),
            hex(colour)
        ));
    }

    fn polygon(&mut self, corners: &[[f64; 2]], colour: Rgb) {
        let points = coordinates(corners);
        self.element(format_args!(
            "<polygon points=\"{points}\" fill=\"{}\"/>",
            hex(colour)
        ));
    }

    fn run(&mut self, text: &str, [x, y]: [f64; 2], style: TextStyle) {
        let (x, y) = (number(x), number(y));
        let turn = match style.direction {
            Direction::Right => String::new(),
            Direction::Up => format!(" transform=\"rotate(-90 {x} {y})\""),
        };
        // SVG drops spaces at the ends of a run, but not those that do not break.
        let text = escaped(text).replace(' ', "\u{a0}");
        self.element(format_args!(
            "<text x=\"{x}\" y=\"{y}\" font-size=\"{}\" fill=\"{}\"{turn}>{text}</text>",
            number(style.size),
            hex(style.colour)
        ));
    }
}

/// Text of an element of an SVG; XML has no control characters.
///
/// ```
/// assert_eq!(protomer_plot::escaped("E < 1 & rising"), "E &lt; 1 &amp; rising");
/// ```
pub fn escaped(text: &str) -> String {
    ESCAPES
        .iter()
        .fold(printable(text).into_owned(), |text, (sign, written)| {
            text.replace(sign, written)
        })
}

fn coordinates(points: &[[f64; 2]]) -> String {
    let pairs = points
        .iter()
        .map(|[x, y]| format!("{},{}", number(*x), number(*y)));
    pairs.collect::<Vec<String>>().join(" ")
}

/// Formats a number to a hundredth of a unit, without trailing zeros.
fn number(value: f64) -> String {
    // Adding zero turns -0 into 0.
    let rounded = (value * 100.0).round() / 100.0 + 0.0;
    rounded.to_string()
}

fn hex([red, green, blue]: Rgb) -> String {
    format!("#{red:02X}{green:02X}{blue:02X}")
}
