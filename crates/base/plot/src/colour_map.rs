//! A table of numbers above and below zero as coloured cells.

use super::canvas::{Align, Canvas, Rgb, Shape, TextStyle};
use super::error::{PlotError, Result};
use super::measures::{CAPITALS, INK, LINE, MARGIN};
use super::output::{NARROW_WIDTH, WIDE};
use super::text::{Fitted, fit};
use super::ticks;
use super::typeface::text_width;
use super::{layout, pixels, svg};
use protomer_io::atomic::write_bytes;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Numbers over two axes of a few values each, coloured on a scale that is symmetric about zero:
/// red below it, blue above. A thick line runs between neighbours of opposite sign.
///
/// ```
/// use protomer_plot::ColourMap;
/// let map = ColourMap {
///     title: "B22 of lysozyme".into(),
///     caption: "4LZT, effective charges".into(),
///     x: "salt (mM)".into(),
///     columns: vec!["100".into(), "500".into()],
///     y: "pH".into(),
///     rows: vec!["4.5".into(), "7".into()],
///     quantity: "B22 (10⁻⁴ mol mL/g²)".into(),
///     values: vec![Some(2.5), Some(-2.0), Some(1.0), None],
/// };
/// assert_eq!(map.limit(), 2.5);
/// assert!(map.to_svg()?.starts_with("<svg"));
/// # Ok::<(), protomer_plot::PlotError>(())
/// ```
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ColourMap {
    /// Title; may be empty.
    pub title: String,
    /// A line in small print below the title; may be empty.
    pub caption: String,
    /// Quantity and unit along the x axis.
    pub x: String,
    /// The values of the columns from left to right.
    pub columns: Vec<String>,
    /// Quantity and unit along the y axis.
    pub y: String,
    /// The values of the rows from bottom to top.
    pub rows: Vec<String>,
    /// Quantity and unit of the colours.
    pub quantity: String,
    /// The numbers, row after row from the bottom; `None` where there is none.
    pub values: Vec<Option<f64>>,
}

/// Colour of the lower end; this colour and the next two are those of the charge in reports.
const LOW: Rgb = [0xC0, 0x28, 0x2D];
/// Colour of zero.
const ZERO: Rgb = [0xF7, 0xF7, 0xF7];
/// Colour of the upper end.
const HIGH: Rgb = [0x24, 0x57, 0xB8];
/// Colour of a cell without a number.
const NOTHING: Rgb = [0xD0, 0xD0, 0xD0];
/// Colour of the sheet, of the lines between cells, and of numbers in dark cells.
const WHITE: Rgb = [0xFF; 3];
/// Lightness below which colours have white numbers.
const DARK: f64 = 140.0;

const LABEL_SIZE: f64 = 23.0;
const TICK_SIZE: f64 = 20.0;
/// Least size of the numbers; smaller ones cannot be read on a phone, and the cells then have none.
const LEAST_NUMBER_SIZE: f64 = 13.0;
/// Largest size of the numbers.
const NUMBER_SIZE: f64 = 22.0;
/// The part of a cell that its number may take.
const NUMBER_ROOM: f64 = 0.86;
/// Distance between the numbers along an axis and what they belong to.
const GAP: f64 = 8.0;
/// Width of the white line between cells.
const CELL_LINE: f64 = 1.5;
/// Width of the line where the sign changes.
const SIGN_LINE: f64 = 3.5;
/// Width of the colour bar.
const BAR_WIDTH: f64 = 26.0;
/// Distance between the cells and the colour bar.
const BAR_GAP: f64 = 26.0;
/// Number of steps of colour in the bar.
const BAR_STEPS: usize = 64;
/// Number of ticks at the bar.
const BAR_TICKS: usize = 6;
/// Height of a row of cells on a narrow screen.
const NARROW_ROW_HEIGHT: f64 = 60.0;

impl ColourMap {
    /// The end of the scale of colours: the largest magnitude.
    ///
    /// ```
    /// use protomer_plot::ColourMap;
    /// let map = ColourMap { values: vec![Some(1.0), None, Some(-4.0)], ..ColourMap::default() };
    /// assert_eq!(map.limit(), 4.0);
    /// ```
    pub fn limit(&self) -> f64 {
        let sizes = self.values.iter().flatten().map(|value| value.abs());
        let largest = sizes.filter(|size| size.is_finite()).fold(0.0, f64::max);
        // All zero, or nothing: any scale serves, but not one of zero.
        match largest > 0.0 {
            true => largest,
            false => 1.0,
        }
    }

    /// The text of an SVG file.
    ///
    /// ```
    /// use protomer_plot::ColourMap;
    /// let [rows, columns] = [vec!["ALA".to_owned()], vec!["7".to_owned(), "8".to_owned()]];
    /// let map = ColourMap { rows, columns, values: vec![Some(1.0), Some(-2.0)], ..ColourMap::default() };
    /// assert!(map.to_svg()?.contains("ALA"));
    /// let too_few = ColourMap { values: vec![Some(1.0)], ..map };
    /// assert!(too_few.to_svg().is_err(), "there are two cells");
    /// # Ok::<(), protomer_plot::PlotError>(())
    /// ```
    ///
    /// # Errors
    /// [`PlotError::Drawing`] for a map without cells or with too few numbers, and for a number
    /// that is not finite.
    pub fn to_svg(&self) -> Result<String> {
        self.check()?;
        Ok(svg::draw(WIDE, |canvas| self.draw(WIDE, canvas)))
    }

    /// Variant of [`ColourMap::to_svg`] for a narrow screen, with larger letters relative to the
    /// width.
    ///
    /// # Errors
    /// As [`ColourMap::to_svg`].
    pub fn to_narrow_svg(&self) -> Result<String> {
        self.check()?;
        // At least four rows: the label of the axis needs the height.
        let cells = NARROW_ROW_HEIGHT * self.rows.len().max(4) as f64;
        let shape = Shape {
            width: NARROW_WIDTH,
            height: 0.0,
            least_shrunk: 1.0,
        };
        // Laid out once without cells, to learn what stands around them.
        let around = layout::heading_height(&self.title, &self.caption, shape) + self.below();
        let height = (around + cells).round();
        let shape = Shape { height, ..shape };
        Ok(svg::draw(shape, |canvas| self.draw(shape, canvas)))
    }

    /// The bytes of a PNG file of [`WIDTH`](super::WIDTH) x [`HEIGHT`](super::HEIGHT) pixels.
    ///
    /// ```
    /// use protomer_plot::ColourMap;
    /// let [rows, columns] = [vec!["ALA".to_owned()], vec!["7".to_owned()]];
    /// let map = ColourMap { rows, columns, values: vec![None], ..ColourMap::default() };
    /// assert!(map.to_png()?.starts_with(b"\x89PNG"), "cells may be without a number");
    /// # Ok::<(), protomer_plot::PlotError>(())
    /// ```
    ///
    /// # Errors
    /// As [`ColourMap::to_svg`].
    pub fn to_png(&self) -> Result<Vec<u8>> {
        self.check()?;
        pixels::draw(WIDE, |canvas| self.draw(WIDE, canvas))
    }

    /// Writes an SVG file atomically.
    ///
    /// # Errors
    /// As [`ColourMap::to_svg`], and if the file cannot be written.
    pub fn write_svg(&self, path: &Path) -> Result<()> {
        let svg = self.to_svg()?;
        Ok(write_bytes(path, svg.as_bytes())?)
    }

    /// Writes a PNG file atomically.
    ///
    /// # Errors
    /// As [`ColourMap::to_png`], and if the file cannot be written.
    pub fn write_png(&self, path: &Path) -> Result<()> {
        let png = self.to_png()?;
        Ok(write_bytes(path, &png)?)
    }

    fn check(&self) -> Result<()> {
        let cells = self.rows.len() * self.columns.len();
        let failed = |cause: String| Err(PlotError::Drawing { cause });
        if cells == 0 || cells != self.values.len() {
            return failed(format!(
                "the map {:?} has {} rows, {} columns and {} numbers",
                self.title,
                self.rows.len(),
                self.columns.len(),
                self.values.len()
            ));
        }
        match self
            .values
            .iter()
            .flatten()
            .find(|value| !value.is_finite())
        {
            Some(value) => failed(format!("the map {:?} holds {value}", self.title)),
            None => Ok(()),
        }
    }

    fn value(&self, row: usize, column: usize) -> Option<f64> {
        self.values[row * self.columns.len() + column]
    }

    /// Height of what stands below the cells.
    fn below(&self) -> f64 {
        MARGIN + LABEL_SIZE + GAP + TICK_SIZE + GAP
    }

    fn draw(&self, shape: Shape, canvas: &mut dyn Canvas) {
        let Shape { width, height, .. } = shape;
        let sheet = [[0.0, 0.0], [width, 0.0], [width, height], [0.0, height]];
        canvas.polygon(&sheet, WHITE);
        let top = layout::draw_title(&self.title, &self.caption, shape, canvas) + GAP;
        let bottom = height - self.below();
        // The ticks of the scale before the cells: the room beside them depends on their width.
        let ticks = ticks::linear([-self.limit(), self.limit()], BAR_TICKS);
        let marks: Vec<&str> = ticks
            .iter()
            .filter_map(|tick| tick.label.as_deref())
            .collect();
        let quantity = fit(&self.quantity, LABEL_SIZE, bottom - top, shape.least_shrunk);
        let beside_bar = GAP + widest(&marks) + GAP + quantity.height(LINE);
        let rows: Vec<&str> = self.rows.iter().map(String::as_str).collect();
        let area = Cells {
            left: MARGIN + LABEL_SIZE + 2.0 * GAP + widest(&rows),
            right: width - MARGIN - beside_bar - BAR_WIDTH - BAR_GAP,
            top,
            bottom,
            rows: self.rows.len(),
            columns: self.columns.len(),
        };
        self.draw_cells(&area, canvas);
        self.draw_sign_changes(&area, canvas);
        self.draw_axes(&area, shape, canvas);
        let bar = Bar {
            left: area.right + BAR_GAP,
            top,
            bottom,
            limit: self.limit(),
        };
        bar.draw(&ticks, widest(&marks), &quantity, canvas);
    }

    fn draw_cells(&self, area: &Cells, canvas: &mut dyn Canvas) {
        let numbers = self.numbers(area);
        for row in 0..area.rows {
            for column in 0..area.columns {
                let value = self.value(row, column);
                let colour = value.map_or(NOTHING, |value| colour(value / self.limit()));
                canvas.polygon(&area.corners(row, column), colour);
                if let (Some(size), Some(value)) = (numbers, value) {
                    // White on dark cells, ink on light ones, by the luma.
                    let ink = match lightness(colour) < DARK {
                        true => WHITE,
                        false => INK,
                    };
                    let [x, y] = area.middle(row, column);
                    let position = [x, y + CAPITALS * size / 2.0];
                    let style = TextStyle::new(size, ink, Align::Centre);
                    canvas.text(&self.written(value), position, style);
                }
            }
        }
        // Lines over the cells, so that rounding leaves no hair of another colour between them.
        for column in 1..area.columns {
            let x = area.x(column as f64);
            canvas.line(&[[x, area.top], [x, area.bottom]], CELL_LINE, WHITE);
        }
        for row in 1..area.rows {
            let y = area.y(row as f64);
            canvas.line(&[[area.left, y], [area.right, y]], CELL_LINE, WHITE);
        }
    }

    /// The size of the numbers in the cells; `None` where there is no room for them.
    fn numbers(&self, area: &Cells) -> Option<f64> {
        let values = self.values.iter().flatten();
        // At size 1; widths grow in proportion to the letters.
        let texts = values.map(|value| text_width(&self.written(*value), 1.0));
        let widest = texts.fold(0.0, f64::max);
        let [width, height] = area.cell();
        let size = NUMBER_SIZE
            // The longest number decides for all: one size in all cells.
            .min(NUMBER_ROOM * width / widest.max(1e-9))
            .min(NUMBER_ROOM * height);
        (size >= LEAST_NUMBER_SIZE).then_some(size)
    }

    /// A number to the second digit of the scale's end.
    fn written(&self, value: f64) -> String {
        let decimals = (1.0 - self.limit().log10().floor()).clamp(0.0, 8.0) as usize;
        ticks::decimal(value, decimals)
    }

    /// Draws a line between neighbours of which one is below zero and one is not.
    fn draw_sign_changes(&self, area: &Cells, canvas: &mut dyn Canvas) {
        let changes = |a: Option<f64>, b: Option<f64>| match (a, b) {
            // Zero counts with the positive numbers.
            (Some(a), Some(b)) => (a < 0.0) != (b < 0.0),
            _ => false,
        };
        for row in 0..area.rows {
            for column in 0..area.columns {
                let value = self.value(row, column);
                let [x, y] = [area.x(column as f64), area.y(row as f64)];
                let [right, above] = [area.x(column as f64 + 1.0), area.y(row as f64 + 1.0)];
                // Each border once: left and lower neighbours only.
                if column > 0 && changes(value, self.value(row, column - 1)) {
                    canvas.line(&[[x, y], [x, above]], SIGN_LINE, INK);
                }
                if row > 0 && changes(value, self.value(row - 1, column)) {
                    canvas.line(&[[x, y], [right, y]], SIGN_LINE, INK);
                }
            }
        }
    }

    fn draw_axes(&self, area: &Cells, shape: Shape, canvas: &mut dyn Canvas) {
        let baseline = area.bottom + GAP + TICK_SIZE * 0.85;
        let style = TextStyle::new(TICK_SIZE, INK, Align::Centre);
        let mut free_from = f64::NEG_INFINITY;
        for (column, label) in self.columns.iter().enumerate() {
            let [x, _] = area.middle(0, column);
            let half = text_width(label, TICK_SIZE) / 2.0;
            // A number that would touch the previous one is omitted.
            if x - half >= free_from {
                canvas.text(label, [x, baseline], style);
                free_from = x + half + 0.4 * TICK_SIZE;
            }
        }
        let style = TextStyle::new(TICK_SIZE, INK, Align::Right);
        for (row, label) in self.rows.iter().enumerate() {
            let [_, y] = area.middle(row, 0);
            let position = [area.left - GAP, y + CAPITALS * TICK_SIZE / 2.0];
            canvas.text(label, position, style);
        }
        let style = TextStyle::new(LABEL_SIZE, INK, Align::Centre);
        let middle = [(area.left + area.right) / 2.0, shape.height - MARGIN + 4.0];
        canvas.text(&self.x, middle, style);
        let beside = [
            MARGIN + CAPITALS * LABEL_SIZE,
            (area.top + area.bottom) / 2.0,
        ];
        canvas.text(&self.y, beside, style.upward());
    }
}

/// The place of the cells.
struct Cells {
    left: f64,
    right: f64,
    top: f64,
    bottom: f64,
    rows: usize,
    columns: usize,
}

impl Cells {
    /// Width and height of a cell.
    fn cell(&self) -> [f64; 2] {
        let width = (self.right - self.left) / self.columns as f64;
        [width, (self.bottom - self.top) / self.rows as f64]
    }

    fn x(&self, column: f64) -> f64 {
        self.left + column * self.cell()[0]
    }

    fn y(&self, row: f64) -> f64 {
        self.bottom - row * self.cell()[1]
    }

    fn corners(&self, row: usize, column: usize) -> [[f64; 2]; 4] {
        let (row, column) = (row as f64, column as f64);
        let [left, right] = [self.x(column), self.x(column + 1.0)];
        let [bottom, top] = [self.y(row), self.y(row + 1.0)];
        [[left, top], [right, top], [right, bottom], [left, bottom]]
    }

    fn middle(&self, row: usize, column: usize) -> [f64; 2] {
        [self.x(column as f64 + 0.5), self.y(row as f64 + 0.5)]
    }
}

/// The colour bar.
struct Bar {
    left: f64,
    top: f64,
    bottom: f64,
    limit: f64,
}

impl Bar {
    fn y(&self, value: f64) -> f64 {
        // The scale is symmetric about zero, which lies in the middle.
        let fraction = 0.5 + 0.5 * value / self.limit;
        self.bottom - fraction * (self.bottom - self.top)
    }

    fn draw(&self, ticks: &[ticks::Tick], widest: f64, quantity: &Fitted, canvas: &mut dyn Canvas) {
        let right = self.left + BAR_WIDTH;
        for step in 0..BAR_STEPS {
            let end = |step: usize| -1.0 + 2.0 * step as f64 / BAR_STEPS as f64;
            let (low, high) = (end(step), end(step + 1));
            // Each step reaches to the upper end, so that no seam shows between them.
            let [y, top] = [self.y(low * self.limit), self.top];
            let corners = [[self.left, top], [right, top], [right, y], [self.left, y]];
            canvas.polygon(&corners, colour(0.5 * (low + high)));
        }
        let style = TextStyle::new(TICK_SIZE, INK, Align::Right);
        for tick in ticks {
            let y = self.y(tick.value);
            canvas.line(&[[right - 6.0, y], [right, y]], CELL_LINE, INK);
            if let Some(label) = &tick.label {
                let position = [right + GAP + widest, y + CAPITALS * TICK_SIZE / 2.0];
                canvas.text(label, position, style);
            }
        }
        let style = TextStyle::new(quantity.size, INK, Align::Centre).upward();
        let middle = (self.top + self.bottom) / 2.0;
        for (number, line) in quantity.lines.iter().enumerate() {
            let offset = (CAPITALS + number as f64 * LINE) * quantity.size;
            canvas.text(line, [right + 2.0 * GAP + widest + offset, middle], style);
        }
    }
}

fn widest(texts: &[&str]) -> f64 {
    let widths = texts.iter().map(|text| text_width(text, TICK_SIZE));
    widths.fold(0.0, f64::max)
}

/// The colour of a number from -1 to 1.
fn colour(part: f64) -> Rgb {
    // A number beyond the scale by rounding has the colour of its end.
    let part = part.clamp(-1.0, 1.0);
    let end = match part < 0.0 {
        true => LOW,
        false => HIGH,
    };
    let mixed = |channel: usize| {
        let (zero, end) = (f64::from(ZERO[channel]), f64::from(end[channel]));
        (zero + part.abs() * (end - zero)).round() as u8
    };
    [0, 1, 2].map(mixed)
}

/// Lightness of a colour, 0 to 255 (the luma of Rec. 601).
fn lightness([red, green, blue]: Rgb) -> f64 {
    0.299 * f64::from(red) + 0.587 * f64::from(green) + 0.114 * f64::from(blue)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two rows of three; a change of sign along the upper row and one next to the gap.
    fn example() -> ColourMap {
        ColourMap {
            title: "B22 against salt and pH".into(),
            caption: "a protein".into(),
            x: "salt (mM)".into(),
            columns: ["30", "100", "300"].map(str::to_owned).to_vec(),
            y: "pH".into(),
            rows: ["4.5", "7"].map(str::to_owned).to_vec(),
            quantity: "B22 (10⁻⁴ mol mL/g²)".into(),
            values: vec![Some(8.0), Some(2.0), None, Some(4.0), Some(1.0), Some(-8.0)],
        }
    }

    #[test]
    fn colours_diverge_from_zero_to_both_sides_alike() {
        assert_eq!([-1.0, 0.0, 1.0].map(colour), [LOW, ZERO, HIGH]);
        assert_eq!([-3.0, 3.0].map(colour), [LOW, HIGH]);
        for sign in [-1.0, 1.0] {
            let steps: Vec<f64> = (0..=10).map(|k| f64::from(k) / 10.0).collect();
            let light: Vec<f64> = steps.iter().map(|k| lightness(colour(sign * k))).collect();
            assert!(light.is_sorted_by(|a, b| a > b), "{light:?}");
        }
    }

    #[test]
    fn every_cell_has_its_colour_and_number_and_the_rest_is_labelled() {
        let map = example();
        let svg = map.to_svg().unwrap();
        assert!(svg.starts_with("<svg width=\"1200\" height=\"800\""));
        let hex = |[r, g, b]: Rgb| format!("fill=\"#{r:02X}{g:02X}{b:02X}\"");
        for value in map.values.iter().flatten() {
            let cell = format!("{}/>", hex(colour(value / 8.0)));
            assert!(svg.contains(&cell), "{value}");
        }
        assert_eq!(svg.matches(&hex(NOTHING)).count(), 1);
        for text in [
            ">8.0<", ">2.0<", ">−8.0<", ">30<", ">300<", ">4.5<", ">7<", ">pH<",
        ] {
            assert!(svg.contains(text), "{text}");
        }
        for text in ["salt\u{a0}(mM)", "B22\u{a0}(10⁻⁴\u{a0}mol"] {
            assert!(svg.contains(text), "{text}");
        }
        // One step from 1 to -8; the cell below -8 is empty.
        assert_eq!(svg.matches("stroke-width=\"3.5\"").count(), 1);
        let all = ColourMap {
            values: [-1.0, 1.0, 1.0, 1.0, 1.0, 1.0].map(Some).to_vec(),
            ..map
        };
        let svg = all.to_svg().unwrap();
        assert_eq!(svg.matches("stroke-width=\"3.5\"").count(), 2);
    }

    #[test]
    fn rows_rise_and_columns_go_right() {
        let svg = example().to_svg().unwrap();
        let place = |number: &str| -> [f64; 2] {
            let end = svg.find(&format!(">{number}<")).unwrap();
            let start = svg[..end].rfind("<text").unwrap();
            ["x=\"", "y=\""].map(|name| {
                let rest = svg[start..end].split(name).nth(1).unwrap();
                rest.split('"').next().unwrap().parse().unwrap()
            })
        };
        let ([x, y], [right, same], [_, above]) = (place("8.0"), place("2.0"), place("4.0"));
        assert!(x < right && y == same && above < y);
    }

    #[test]
    fn a_png_has_its_size_and_its_colours() {
        let bytes = example().to_png().unwrap();
        let decoder = png::Decoder::new(std::io::Cursor::new(&bytes));
        let mut reader = decoder.read_info().unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut pixels).unwrap();
        assert_eq!((info.width, info.height), (crate::WIDTH, crate::HEIGHT));
        for sought in [LOW, HIGH, NOTHING, colour(0.25)] {
            let found = pixels.chunks_exact(4).any(|pixel| pixel[..3] == sought);
            assert!(found, "{sought:?}");
        }
        if let Some(path) = std::env::var_os("PROTOMER_EXAMPLE_MAP") {
            let path = Path::new(&path);
            example().write_png(path).unwrap();
            example().write_svg(&path.with_extension("svg")).unwrap();
            let narrow = example().to_narrow_svg().unwrap();
            std::fs::write(path.with_extension("narrow.svg"), narrow).unwrap();
        }
    }

    #[test]
    fn letters_on_a_narrow_screen_can_be_read() {
        let mut map = example();
        map.columns = (0..12).map(|k| (10 + k).to_string()).collect();
        map.values = (0..24).map(|k| Some(f64::from(k) - 12.25)).collect();
        let narrow = map.to_narrow_svg().unwrap();
        assert!(narrow.starts_with("<svg width=\"520\" height="));
        let sizes = narrow.split("font-size=\"").skip(1);
        let sizes: Vec<f64> = sizes
            .map(|rest| rest.split('"').next().unwrap().parse().unwrap())
            .collect();
        assert!(sizes.len() > 10 && sizes.iter().all(|size| size * 344.0 / 520.0 >= 8.0));
        // There is no room for numbers in the cells.
        assert!(!narrow.contains(">−12.2<") && map.to_svg().unwrap().contains(">−12<"));
    }

    #[test]
    fn what_is_no_map_is_refused() {
        let refused = |map: ColourMap| map.to_svg().unwrap_err().to_string();
        let mut map = example();
        map.values.pop();
        assert!(refused(map).contains("2 rows, 3 columns and 5 numbers"));
        assert!(refused(ColourMap::default()).contains("0 rows"));
        let mut map = example();
        map.values[0] = Some(f64::NAN);
        assert!(refused(map).contains("holds NaN"));
        // All zero is a map, too.
        let mut map = example();
        map.values.fill(Some(0.0));
        assert!(map.to_svg().is_ok() && map.limit() == 1.0);
    }
}
