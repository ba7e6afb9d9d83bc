//! The axes of a panel: scales, grid, frame, ticks and labels.

use super::canvas::{Align, Canvas, Rgb, Shape, TextStyle};
use super::measures::{CAPITALS, INK, LINE, MARGIN, y_values};
use super::text::{Fitted, fit};
use super::ticks::{self, Tick};
use super::typeface::text_width;
use super::{Axis, Figure, Panel};

const FRAME: Rgb = [0x55, 0x55, 0x55];
const GRID: Rgb = [0xE4, 0xE4, 0xE4];
const GRID_WIDTH: f64 = 1.0;
const FRAME_WIDTH: f64 = 1.5;

pub(crate) const TICK_SIZE: f64 = 20.0;
pub(crate) const TICK_LENGTH: f64 = 7.0;
/// Length of a minor tick, as a part of that of a major one.
const MINOR_TICK: f64 = 0.55;
/// Distance between a tick and its label.
const TICK_GAP: f64 = 6.0;
/// Approximate distance between the ticks of a linear y axis.
const Y_TICK_DISTANCE: f64 = 55.0;
/// Approximate distance between the ticks of a linear x axis.
const X_TICK_DISTANCE: f64 = 150.0;

/// Mapping of values to positions between the two ends of an axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Scale {
    range: [f64; 2],
    log: bool,
    whole: bool,
}

impl Scale {
    /// The scale of the x axis that all panels share.
    pub fn of_x(figure: &Figure) -> Self {
        let values = figure.panels.iter().flat_map(Panel::values).map(|[x, _]| x);
        Self::from_axis(&figure.x, values, 0.04)
    }

    fn from_axis(axis: &Axis, values: impl Iterator<Item = f64>, room: f64) -> Self {
        let range = axis.range.unwrap_or_else(|| padded(values, axis.log, room));
        Self {
            range,
            log: axis.log,
            whole: axis.whole,
        }
    }

    /// Position of a value: 0 at the lower end, 1 at the upper. Values beyond stay at the ends, so
    /// that nothing is drawn outside the frame.
    fn fraction(&self, value: f64) -> f64 {
        let [from, to] = self.range;
        // ln(v / from) / ln(to / from): one logarithm less to cancel than with differences.
        let fraction = match self.log {
            true => (value / from).ln() / (to / from).ln(),
            false => (value - from) / (to - from),
        };
        // A range without extent, or a value that is none: the lower end.
        if fraction.is_nan() {
            return 0.0;
        }
        fraction.clamp(0.0, 1.0)
    }

    fn ticks(&self, count: usize) -> Vec<Tick> {
        match self.log {
            true => ticks::logarithmic(self.range),
            false if self.whole => ticks::whole(self.range, count),
            false => ticks::linear(self.range, count),
        }
    }
}

/// The range of the values with margins at both ends.
fn padded(values: impl Iterator<Item = f64>, log: bool, room: f64) -> [f64; 2] {
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for value in values {
        // Margins are added where the axis is linear.
        let value = if log { value.ln() } else { value };
        (low, high) = (low.min(value), high.max(value));
    }
    let spread = high - low;
    // A single value gets a range as large as itself around it.
    // Relative: a spread that is only rounding counts as none.
    let pad = match spread > 1e-12 * low.abs().max(high.abs()) {
        true => spread * room,
        false => (0.1 * high.abs()).max(0.5),
    };
    // Back from logarithms to values.
    [low - pad, high + pad].map(|end| if log { end.exp() } else { end })
}

/// A panel's place on the canvas and its scales.
pub(crate) struct Area {
    pub left: f64,
    pub right: f64,
    pub top: f64,
    pub bottom: f64,
    pub x: Scale,
    pub y: Scale,
}

impl Area {
    /// The position of a point of the data.
    pub fn place(&self, x: f64, y: f64) -> [f64; 2] {
        [self.x(x), self.y(y)]
    }

    fn x(&self, value: f64) -> f64 {
        self.left + self.x.fraction(value) * (self.right - self.left)
    }

    fn y(&self, value: f64) -> f64 {
        self.bottom - self.y.fraction(value) * (self.bottom - self.top)
    }
}

/// The y axis of a panel.
pub(crate) struct Vertical {
    pub scale: Scale,
    ticks: Vec<Tick>,
    label: Fitted,
}

impl Vertical {
    /// The axis of a panel of this height, its label in letters of this size.
    pub fn new(panel: &Panel, height: f64, label_size: f64, least_shrunk: f64) -> Self {
        let scale = Scale::from_axis(&panel.y, y_values(panel), 0.07);
        // Two ticks at least, or an axis has no scale to read.
        let count = (height / Y_TICK_DISTANCE).round().max(2.0) as usize;
        Self {
            scale,
            ticks: scale.ticks(count),
            label: fit(&panel.y.label, label_size, height, least_shrunk),
        }
    }

    /// The room that all y axes of a figure need next to the panels.
    pub fn room(axes: &[Self], label_size: f64) -> f64 {
        let lines = axes.iter().map(|axis| axis.label.lines.len()).max();
        // The first line stands in the room of the letters' own size.
        let further_lines = lines.unwrap_or(1).max(1) - 1;
        let labels = label_size * (1.0 + LINE * further_lines as f64);
        let numbers = axes.iter().map(Self::widest_number).fold(0.0, f64::max);
        labels + 20.0 + numbers + TICK_LENGTH + TICK_GAP
    }

    fn widest_number(&self) -> f64 {
        let labels = self.ticks.iter().filter_map(|tick| tick.label.as_deref());
        labels
            .map(|label| text_width(label, TICK_SIZE))
            .fold(0.0, f64::max)
    }
}

/// Draws the axes of a panel; only the lowest panel has a label of the x axis.
pub(crate) fn draw(
    area: &Area,
    vertical: &Vertical,
    x_label: Option<&Fitted>,
    shape: Shape,
    canvas: &mut dyn Canvas,
) {
    let count = (shape.width / X_TICK_DISTANCE).round().max(4.0) as usize;
    let x_ticks = area.x.ticks(count);
    // The grid first, so that ticks and frame lie over it.
    draw_grid(area, &x_ticks, &vertical.ticks, canvas);
    draw_y_ticks(area, &vertical.ticks, canvas);
    draw_x_ticks(area, &x_ticks, x_label.is_some(), canvas);
    draw_frame(area, canvas);
    if let Some(label) = x_label {
        draw_x_label(area, label, shape, canvas);
    }
    draw_y_label(area, &vertical.label, canvas);
}

fn draw_grid(area: &Area, x_ticks: &[Tick], y_ticks: &[Tick], canvas: &mut dyn Canvas) {
    // Minor ticks have no line: a logarithmic grid would turn grey.
    for tick in y_ticks.iter().filter(|tick| tick.label.is_some()) {
        let y = area.y(tick.value);
        canvas.line(&[[area.left, y], [area.right, y]], GRID_WIDTH, GRID);
    }
    for tick in x_ticks.iter().filter(|tick| tick.label.is_some()) {
        let x = area.x(tick.value);
        canvas.line(&[[x, area.top], [x, area.bottom]], GRID_WIDTH, GRID);
    }
}

fn tick_length(tick: &Tick) -> f64 {
    match tick.label {
        Some(_) => TICK_LENGTH,
        None => TICK_LENGTH * MINOR_TICK,
    }
}

fn draw_y_ticks(area: &Area, ticks: &[Tick], canvas: &mut dyn Canvas) {
    let style = TextStyle::new(TICK_SIZE, INK, Align::Right);
    for tick in ticks {
        let y = area.y(tick.value);
        let mark = [[area.left - tick_length(tick), y], [area.left, y]];
        canvas.line(&mark, FRAME_WIDTH, FRAME);
        if let Some(label) = &tick.label {
            let end = [
                area.left - TICK_LENGTH - TICK_GAP,
                y + CAPITALS * TICK_SIZE / 2.0,
            ];
            canvas.text(label, end, style);
        }
    }
}

/// Draws the ticks of the x axis. A number that would touch the previous one is omitted.
fn draw_x_ticks(area: &Area, ticks: &[Tick], with_numbers: bool, canvas: &mut dyn Canvas) {
    let style = TextStyle::new(TICK_SIZE, INK, Align::Centre);
    let mut free_from = f64::NEG_INFINITY;
    for tick in ticks {
        let x = area.x(tick.value);
        let mark = [[x, area.bottom], [x, area.bottom + tick_length(tick)]];
        canvas.line(&mark, FRAME_WIDTH, FRAME);
        let Some(label) = tick.label.as_ref().filter(|_| with_numbers) else {
            continue;
        };
        let half = text_width(label, TICK_SIZE) / 2.0;
        // Room is measured in drawn widths, not in numbers: exponents are wide.
        if x - half >= free_from {
            let baseline = area.bottom + TICK_LENGTH + 5.0 + TICK_SIZE * 0.85;
            canvas.text(label, [x, baseline], style);
            free_from = x + half + 0.4 * TICK_SIZE;
        }
    }
}

fn draw_frame(area: &Area, canvas: &mut dyn Canvas) {
    let corners = [
        [area.left, area.top],
        [area.right, area.top],
        [area.right, area.bottom],
        [area.left, area.bottom],
    ];
    for side in 0..4 {
        let ends = [corners[side], corners[(side + 1) % 4]];
        canvas.line(&ends, FRAME_WIDTH, FRAME);
    }
}

/// Draws the label of the x axis. A label longer than the panel stays clear of the edges of the
/// figure.
fn draw_x_label(area: &Area, label: &Fitted, shape: Shape, canvas: &mut dyn Canvas) {
    let style = TextStyle::new(label.size, INK, Align::Centre);
    let lowest = shape.height - MARGIN + 4.0;
    // From the lowest line upwards, as its place is fixed by the edge of the figure.
    for (above, line) in label.lines.iter().rev().enumerate() {
        let half = text_width(line, label.size) / 2.0 + MARGIN;
        let centre = (area.left + area.right) / 2.0;
        // Centred below the panel if that leaves the margin; `max` last, so the left edge wins.
        let middle = centre.min(shape.width - half).max(half);
        let y = lowest - above as f64 * LINE * label.size;
        canvas.text(line, [middle, y], style);
    }
}

fn draw_y_label(area: &Area, label: &Fitted, canvas: &mut dyn Canvas) {
    let style = TextStyle::new(label.size, INK, Align::Centre).upward();
    let middle = (area.top + area.bottom) / 2.0;
    for (number, line) in label.lines.iter().enumerate() {
        let x = MARGIN + (CAPITALS + number as f64 * LINE) * label.size;
        canvas.text(line, [x, middle], style);
    }
}
