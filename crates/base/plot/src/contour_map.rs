//! Lines of equal value in a plane, in panels side by side.

use super::canvas::{Align, Canvas, PALETTE, Rgb, Shape, TextStyle};
use super::contours::Grid;
use super::error::{PlotError, Result};
use super::measures::{CAPITALS, INK, MARGIN};
use super::output::WIDE;
use super::text::fit;
use super::typeface::text_width;
use super::{layout, pixels, svg, ticks};

/// Lines of equal value of numbers on a grid in a plane, whose axes have one scale.
///
/// ```
/// use protomer_plot::{ContourMap, ContourPanel};
/// let distances = |k: i32| Some(f64::from((k % 5 - 2).pow(2) + (k / 5 - 2).pow(2)).sqrt());
/// let panel = ContourPanel { title: "disk".into(), values: (0..25).map(distances).collect(), ..ContourPanel::default() };
/// let map = ContourMap {
///     title: "distance".into(),
///     caption: String::new(),
///     x: "x".into(),
///     y: "y".into(),
///     ends: [-2.0, 2.0],
///     points: 5,
///     levels: vec![1.0, 1.5],
///     panels: vec![panel],
/// };
/// assert!(map.to_svg()?.starts_with("<svg"));
/// # Ok::<(), protomer_plot::PlotError>(())
/// ```
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ContourMap {
    /// Title; may be empty.
    pub title: String,
    /// A line in small print below the title; may be empty.
    pub caption: String,
    /// Quantity and unit along the x axes.
    pub x: String,
    /// Quantity and unit along the y axis.
    pub y: String,
    /// First and last coordinate of the grid along both axes.
    pub ends: [f64; 2],
    /// Number of points of the grid along each axis.
    pub points: usize,
    /// Values of the lines, in the order of the legend; at most seven, each with its colour.
    pub levels: Vec<f64>,
    /// Panels from left to right.
    pub panels: Vec<ContourPanel>,
}

/// A panel of a contour map.
///
/// ```
/// use protomer_plot::ContourPanel;
/// let values = vec![Some(1.0), None, Some(0.5), Some(0.0)];
/// let panel = ContourPanel { title: "a corner inside a body".into(), values, outline: Vec::new() };
/// assert_eq!(panel.values.len(), 4);
/// ```
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ContourPanel {
    /// Title above the panel.
    pub title: String,
    /// Numbers, row after row from the bottom; `None` where there is none, which is grey.
    pub values: Vec<Option<f64>>,
    /// Corners of an outline, drawn filled and closed; may be empty.
    pub outline: Vec<[f64; 2]>,
}

const WHITE: Rgb = [0xFF; 3];
/// Colour of places without a number.
const NOTHING: Rgb = [0xDC, 0xDC, 0xDC];
/// Colour of the inside of the outline.
const INSIDE: Rgb = [0xA8, 0xA8, 0xA8];
const LABEL_SIZE: f64 = 22.0;
const TICK_SIZE: f64 = 18.0;
const LEGEND_SIZE: f64 = 19.0;
const LINE_WIDTH: f64 = 2.4;
const FRAME_WIDTH: f64 = 1.5;
const GAP: f64 = 8.0;
/// Length of the sample of a line in the legend.
const SAMPLE: f64 = 34.0;
/// Distance between two entries of the legend.
const ENTRY_GAP: f64 = 26.0;
/// Number of ticks along an axis.
const TICKS: usize = 5;

impl ContourMap {
    /// The text of an SVG file.
    ///
    /// # Errors
    /// [`PlotError::Drawing`] for no panel or level, more than seven levels, a grid without cells, or a panel with
    /// another number of values.
    pub fn to_svg(&self) -> Result<String> {
        self.check()?;
        Ok(svg::draw(WIDE, |canvas| self.draw(WIDE, canvas)))
    }

    /// The bytes of a PNG file of [`WIDTH`](super::WIDTH) x [`HEIGHT`](super::HEIGHT) pixels.
    ///
    /// # Errors
    /// As [`ContourMap::to_svg`].
    pub fn to_png(&self) -> Result<Vec<u8>> {
        self.check()?;
        pixels::draw(WIDE, |canvas| self.draw(WIDE, canvas))
    }

    fn check(&self) -> Result<()> {
        let failed = |cause: String| Err(PlotError::Drawing { cause });
        let [from, to] = self.ends;
        if self.points < 2 || !(from.is_finite() && to.is_finite() && from < to) {
            return failed(format!(
                "the grid of the map {:?} has {} points from {from} to {to}",
                self.title, self.points
            ));
        }
        if self.panels.is_empty() || self.levels.is_empty() || self.levels.len() > PALETTE.len() {
            return failed(format!(
                "the map {:?} has {} panels and {} levels; give one to {} levels",
                self.title,
                self.panels.len(),
                self.levels.len(),
                PALETTE.len()
            ));
        }
        if let Some(level) = self.levels.iter().find(|level| !level.is_finite()) {
            return failed(format!("the map {:?} has the level {level}", self.title));
        }
        let cells = self.points * self.points;
        for panel in &self.panels {
            if panel.values.len() != cells {
                return failed(format!(
                    "the panel {:?} has {} numbers for {cells} points",
                    panel.title,
                    panel.values.len()
                ));
            }
            if let Some(value) = panel
                .values
                .iter()
                .flatten()
                .find(|value| !value.is_finite())
            {
                return failed(format!("the panel {:?} holds {value}", panel.title));
            }
        }
        Ok(())
    }

    fn draw(&self, shape: Shape, canvas: &mut dyn Canvas) {
        let Shape { width, height, .. } = shape;
        let sheet = [[0.0, 0.0], [width, 0.0], [width, height], [0.0, height]];
        canvas.polygon(&sheet, WHITE);
        let heading = layout::draw_title(&self.title, &self.caption, shape, canvas);
        let top = self.draw_legend(heading + GAP, width, canvas) + GAP + LABEL_SIZE + GAP;
        let marks = ticks::linear(self.ends, TICKS);
        let widest = marks
            .iter()
            .filter_map(|tick| tick.label.as_deref())
            .map(|label| text_width(label, TICK_SIZE))
            .fold(0.0, f64::max);
        let left = MARGIN + LABEL_SIZE + 2.0 * GAP + widest;
        let below = MARGIN + LABEL_SIZE + 2.0 * GAP + TICK_SIZE;
        let count = self.panels.len() as f64;
        let room = (width - MARGIN - left - (count - 1.0) * MARGIN) / count;
        // One scale for both axes: a square may look like nothing else.
        let edge = room.min(height - top - below);
        let free = (width - MARGIN - left - count * edge - (count - 1.0) * MARGIN) / 2.0;
        for (number, panel) in self.panels.iter().enumerate() {
            let square = Square {
                left: left + free + number as f64 * (edge + MARGIN),
                top,
                edge,
                ends: self.ends,
                points: self.points,
            };
            self.draw_panel(panel, &square, canvas);
            square.draw_axes(&marks, number == 0, canvas);
            let style = TextStyle::new(LABEL_SIZE, INK, Align::Centre);
            let middle = square.left + edge / 2.0;
            let title = fit(&panel.title, LABEL_SIZE, edge, shape.least_shrunk);
            let style = TextStyle {
                size: title.size,
                ..style
            };
            canvas.text(&title.lines.join(" "), [middle, top - GAP], style);
            let style = TextStyle::new(LABEL_SIZE, INK, Align::Centre);
            let baseline = top + edge + 2.0 * GAP + TICK_SIZE + LABEL_SIZE;
            canvas.text(&self.x, [middle, baseline], style);
            if number == 0 {
                let beside = square.left - 2.0 * GAP - widest;
                canvas.text(&self.y, [beside, top + edge / 2.0], style.upward());
            }
        }
    }

    /// Draws one entry for each level; returns the lower end.
    fn draw_legend(&self, top: f64, width: f64, canvas: &mut dyn Canvas) -> f64 {
        let names: Vec<String> = self.levels.iter().map(|level| written(*level)).collect();
        let widths = names
            .iter()
            .map(|name| SAMPLE + GAP + text_width(name, LEGEND_SIZE));
        let whole: f64 = widths.clone().sum::<f64>() + ENTRY_GAP * (names.len() - 1) as f64;
        let mut x = (width - whole) / 2.0;
        let baseline = top + LEGEND_SIZE;
        for (number, (name, entry)) in names.iter().zip(widths).enumerate() {
            let y = baseline - CAPITALS * LEGEND_SIZE / 2.0;
            canvas.line(&[[x, y], [x + SAMPLE, y]], LINE_WIDTH, PALETTE[number]);
            let style = TextStyle::new(LEGEND_SIZE, INK, Align::Left);
            canvas.text(name, [x + SAMPLE + GAP, baseline], style);
            x += entry + ENTRY_GAP;
        }
        baseline
    }

    fn draw_panel(&self, panel: &ContourPanel, square: &Square, canvas: &mut dyn Canvas) {
        square.draw_gaps(&panel.values, canvas);
        if panel.outline.len() > 2 {
            let corners: Vec<[f64; 2]> = panel.outline.iter().map(|p| square.place(*p)).collect();
            canvas.polygon(&corners, INSIDE);
        }
        let grid = Grid {
            columns: self.points,
            rows: self.points,
            values: &panel.values,
        };
        for (level, colour) in self.levels.iter().zip(PALETTE) {
            for line in grid.lines(*level) {
                let places: Vec<[f64; 2]> = line.iter().map(|node| square.node(*node)).collect();
                canvas.line(&places, LINE_WIDTH, colour);
            }
        }
    }
}

/// A number with the sign of print, without needless digits.
fn written(value: f64) -> String {
    value.to_string().replace('-', "−")
}

/// The place of a panel.
struct Square {
    left: f64,
    top: f64,
    edge: f64,
    ends: [f64; 2],
    points: usize,
}

impl Square {
    /// The place of a node, or of a point between nodes, by column and row.
    fn node(&self, [column, row]: [f64; 2]) -> [f64; 2] {
        let step = self.edge / (self.points - 1) as f64;
        [self.left + column * step, self.top + self.edge - row * step]
    }

    /// The place of a point of the plane.
    fn place(&self, point: [f64; 2]) -> [f64; 2] {
        let [from, to] = self.ends;
        let [x, y] = point.map(|x| ((x - from) / (to - from)).clamp(0.0, 1.0) * self.edge);
        [self.left + x, self.top + self.edge - y]
    }

    /// Draws places without a number: a bar for each run of them in a row, half a step around its nodes.
    fn draw_gaps(&self, values: &[Option<f64>], canvas: &mut dyn Canvas) {
        let last = (self.points - 1) as f64;
        for (row, values) in values.chunks_exact(self.points).enumerate() {
            let mut column = 0;
            while column < self.points {
                let run = values[column..].iter().take_while(|v| v.is_none()).count();
                if run > 0 {
                    let [low, high] = [-0.5, 0.5].map(|half| (row as f64 + half).clamp(0.0, last));
                    let from = (column as f64 - 0.5).max(0.0);
                    let to = ((column + run) as f64 - 0.5).min(last);
                    let corners = [[from, low], [to, low], [to, high], [from, high]];
                    canvas.polygon(&corners.map(|corner| self.node(corner)), NOTHING);
                }
                column += run.max(1);
            }
        }
    }

    fn draw_axes(&self, marks: &[ticks::Tick], is_first: bool, canvas: &mut dyn Canvas) {
        let (right, bottom) = (self.left + self.edge, self.top + self.edge);
        let frame = [
            [self.left, self.top],
            [right, self.top],
            [right, bottom],
            [self.left, bottom],
            [self.left, self.top],
        ];
        canvas.line(&frame, FRAME_WIDTH, INK);
        for tick in marks {
            let [x, y] = self.place([tick.value; 2]);
            canvas.line(&[[x, bottom], [x, bottom - 6.0]], FRAME_WIDTH, INK);
            canvas.line(&[[self.left, y], [self.left + 6.0, y]], FRAME_WIDTH, INK);
            let Some(label) = &tick.label else { continue };
            let style = TextStyle::new(TICK_SIZE, INK, Align::Centre);
            canvas.text(label, [x, bottom + GAP + TICK_SIZE * 0.85], style);
            if is_first {
                let style = TextStyle::new(TICK_SIZE, INK, Align::Right);
                let position = [self.left - GAP, y + CAPITALS * TICK_SIZE / 2.0];
                canvas.text(label, position, style);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn example() -> ContourMap {
        let values = |k: i32| {
            let [x, y] = [k % 21 - 10, k / 21 - 10].map(f64::from);
            (x.hypot(y) > 3.0).then(|| x.hypot(y))
        };
        let panel = |title: &str| ContourPanel {
            title: title.into(),
            values: (0..441).map(values).collect(),
            outline: vec![[-2.0, -2.0], [2.0, -2.0], [2.0, 2.0], [-2.0, 2.0]],
        };
        ContourMap {
            title: "distances".into(),
            caption: "of two disks".into(),
            x: "x".into(),
            y: "y".into(),
            ends: [-10.0, 10.0],
            points: 21,
            levels: vec![-1.0, 5.0, 8.0],
            panels: vec![panel("left"), panel("right")],
        }
    }

    #[test]
    fn every_level_is_in_the_legend_and_as_lines_in_every_panel() {
        let svg = example().to_svg().unwrap();
        for text in [">−1<", ">5<", ">8<", ">left<", ">right<", ">distances<"] {
            assert!(svg.contains(text), "{text}");
        }
        let lines = |colour: &str| svg.matches(&format!("stroke=\"{colour}\"")).count();
        // The legend, and a closed line in each panel; no line where no number is so low.
        assert_eq!(
            [lines("#0072B2"), lines("#D55E00"), lines("#009E73")],
            [1, 3, 3]
        );
    }

    #[test]
    fn a_png_is_drawn_from_the_same_content() {
        let png = example().to_png().unwrap();
        assert!(png.starts_with(b"\x89PNG"));
        if let Some(path) = std::env::var_os("PROTOMER_EXAMPLE_CONTOURS") {
            std::fs::write(path, png).unwrap();
        }
    }

    #[test]
    fn what_is_no_map_is_refused() {
        let refused = |map: ContourMap| map.to_svg().unwrap_err().to_string();
        let mut map = example();
        map.levels = vec![1.0; 8];
        assert!(refused(map).contains("8 levels"));
        let mut map = example();
        map.panels[1].values.pop();
        assert!(refused(map).contains("440 numbers for 441"));
        let mut map = example();
        map.panels[0].values[0] = Some(f64::INFINITY);
        assert!(refused(map).contains("holds inf"));
        let mut map = example();
        map.ends = [1.0, 1.0];
        assert!(refused(map).contains("from 1 to 1"));
    }
}
