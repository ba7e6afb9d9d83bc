//! Where everything goes: title, caption, legend, panels, axes, data.

use super::canvas::{self, Align, Canvas, Direction, Rgb};
use super::text::{Fitted, fit};
use super::ticks::{self, Tick};
use super::{Axis, Figure, Panel, Shape};
use anyhow::Result;

const INK: Rgb = [0x22, 0x22, 0x22];
const PALE_INK: Rgb = [0x60, 0x60, 0x60];
const FRAME: Rgb = [0x55, 0x55, 0x55];
const GRID: Rgb = [0xE4, 0xE4, 0xE4];
const WHITE: Rgb = [0xFF; 3];

const TITLE_SIZE: f64 = 27.0;
const CAPTION_SIZE: f64 = 17.0;
const LABEL_SIZE: f64 = 23.0;
const TICK_SIZE: f64 = 20.0;
const LEGEND_SIZE: f64 = 20.0;

const MARGIN: f64 = 28.0;
const PANEL_GAP: f64 = 22.0;
const TICK_LENGTH: f64 = 7.0;
const MARKER_RADIUS: f64 = 6.5;
const REPLICA_RADIUS: f64 = 4.0;
const REPLICA_OPACITY: f64 = 0.4;
/// On a line of more points, markers would cover each other and the line.
const MOST_MARKED: usize = 60;
const LEGEND_SAMPLE: f64 = 46.0;
/// Height of capital letters in em, to centre text on a line.
const CAPITALS: f64 = 0.73;

/// From line to line of a text, in em.
const LINE: f64 = 1.2;

/// Draws the whole figure.
pub(super) fn draw(figure: &Figure, canvas: &mut dyn Canvas) -> Result<()> {
    let shape = canvas.shape();
    let (width, height) = (f64::from(shape.width), f64::from(shape.height));
    canvas.polygon(
        &[[0.0, 0.0], [width, 0.0], [width, height], [0.0, height]],
        WHITE,
    )?;
    let x_range = x_range(figure);
    let y_ranges: Vec<[f64; 2]> = figure.panels.iter().map(y_range).collect();
    let count = figure.panels.len() as f64;
    let top = draw_heading(figure, canvas)?;
    let x_label = fit(
        &figure.x.label,
        LABEL_SIZE,
        width - 2.0 * MARGIN,
        shape.least_shrunk,
    )?;
    let bottom = height - MARGIN - x_label.height(LINE) - 10.0 - TICK_SIZE - TICK_LENGTH;
    let panel_height = (bottom - top - PANEL_GAP * (count - 1.0)) / count;
    let y_ticks: Vec<Vec<Tick>> = figure
        .panels
        .iter()
        .zip(&y_ranges)
        .map(|(panel, range)| {
            axis_ticks(
                &panel.y,
                *range,
                (panel_height / 55.0).round().max(2.0) as usize,
            )
        })
        .collect();
    let y_label = |panel: &Panel| fit(&panel.y.label, LABEL_SIZE, panel_height, shape.least_shrunk);
    let y_labels = figure
        .panels
        .iter()
        .map(y_label)
        .collect::<Result<Vec<_>>>()?;
    let lines = y_labels
        .iter()
        .map(|label| label.lines.len())
        .max()
        .unwrap_or(1);
    let label_width = LABEL_SIZE * (1.0 + LINE * (lines.max(1) - 1) as f64);
    let left = MARGIN + label_width + 20.0 + widest_label(&y_ticks)? + TICK_LENGTH + 6.0;
    let names = figure.series_names();
    for (index, panel) in figure.panels.iter().enumerate() {
        let panel_top = top + index as f64 * (panel_height + PANEL_GAP);
        let area = Area {
            left,
            right: width - MARGIN - 12.0,
            top: panel_top,
            bottom: panel_top + panel_height,
            x: Scale {
                range: x_range,
                log: figure.x.log,
            },
            y: Scale {
                range: y_ranges[index],
                log: panel.y.log,
            },
        };
        let last = index + 1 == figure.panels.len();
        let labels = Labels {
            x: last.then_some(&x_label),
            y: &y_labels[index],
        };
        draw_axes(figure, &labels, &area, &y_ticks[index], canvas)?;
        for series in &panel.series {
            let number = names
                .iter()
                .position(|name| *name == series.name)
                .unwrap_or(0);
            draw_series(series, canvas::style(number), &area, canvas)?;
        }
    }
    Ok(())
}

/// How high a figure of this width has to be, so that its panels have the height.
pub(super) fn height_for(figure: &Figure, shape: Shape, panel_height: f64) -> Result<f64> {
    let room = f64::from(shape.width) - 2.0 * MARGIN;
    let x_label = fit(&figure.x.label, LABEL_SIZE, room, shape.least_shrunk)?.height(LINE);
    let below = MARGIN + x_label + 10.0 + TICK_SIZE + TICK_LENGTH;
    let count = figure.panels.len() as f64;
    let panels = count * panel_height + (count - 1.0) * PANEL_GAP;
    Ok(draw_heading(figure, &mut canvas::Nowhere(shape))? + panels + below)
}

/// Title, caption and legend; returns where the panels may begin.
fn draw_heading(figure: &Figure, canvas: &mut dyn Canvas) -> Result<f64> {
    let shape = canvas.shape();
    let width = f64::from(shape.width);
    let mut y = MARGIN;
    for (text, size, colour) in [
        (&figure.title, TITLE_SIZE, INK),
        (&figure.caption, CAPTION_SIZE, PALE_INK),
    ] {
        if !text.is_empty() {
            let fitted = fit(text, size, width - 2.0 * MARGIN, shape.least_shrunk)?;
            for (number, line) in fitted.lines.iter().enumerate() {
                y += if number == 0 {
                    size
                } else {
                    LINE * fitted.size
                };
                canvas.text(
                    line,
                    [width / 2.0, y],
                    fitted.size,
                    colour,
                    Align::Centre,
                    Direction::Right,
                )?;
            }
            y += size * 0.45;
        }
    }
    let names = figure.series_names();
    if names.len() > 1 {
        y = draw_legend(&names, y + 4.0, canvas)?;
    }
    Ok(y + 14.0)
}

/// The names in centred rows above the panels, where they cover no data; returns the lower end.
fn draw_legend(names: &[&str], top: f64, canvas: &mut dyn Canvas) -> Result<f64> {
    const SPACE: f64 = 34.0;
    let width = f64::from(canvas.shape().width);
    let available = width - 2.0 * MARGIN;
    let mut rows: Vec<(f64, Vec<(usize, f64)>)> = Vec::new();
    for (number, name) in names.iter().enumerate() {
        let length = LEGEND_SAMPLE + 10.0 + canvas::text_width(name, LEGEND_SIZE)?;
        match rows
            .last_mut()
            .filter(|(used, _)| used + SPACE + length <= available)
        {
            Some((used, entries)) => {
                *used += SPACE + length;
                entries.push((number, length));
            }
            None => rows.push((length, vec![(number, length)])),
        }
    }
    let mut y = top;
    for (used, entries) in rows {
        y += LEGEND_SIZE * 1.4;
        let mut x = (width - used) / 2.0;
        for (number, length) in entries {
            let (colour, marker) = canvas::style(number);
            let middle = y - CAPITALS * LEGEND_SIZE / 2.0;
            canvas.line(&[[x, middle], [x + LEGEND_SAMPLE, middle]], 2.5, colour)?;
            canvas.marker(
                marker,
                [x + LEGEND_SAMPLE / 2.0, middle],
                MARKER_RADIUS,
                colour,
            )?;
            let start = [x + LEGEND_SAMPLE + 10.0, y];
            canvas.text(
                names[number],
                start,
                LEGEND_SIZE,
                INK,
                Align::Left,
                Direction::Right,
            )?;
            x += length + SPACE;
        }
    }
    Ok(y)
}

/// A panel's place on the canvas and its scales.
struct Area {
    left: f64,
    right: f64,
    top: f64,
    bottom: f64,
    x: Scale,
    y: Scale,
}

impl Area {
    fn x(&self, value: f64) -> f64 {
        self.left + self.x.fraction(value) * (self.right - self.left)
    }

    fn y(&self, value: f64) -> f64 {
        self.bottom - self.y.fraction(value) * (self.bottom - self.top)
    }
}

struct Scale {
    range: [f64; 2],
    log: bool,
}

impl Scale {
    /// 0 at the lower end, 1 at the upper; values beyond stay at the ends, so that nothing is drawn
    /// outside the frame.
    fn fraction(&self, value: f64) -> f64 {
        let [from, to] = self.range;
        let fraction = if self.log {
            (value / from).ln() / (to / from).ln()
        } else {
            (value - from) / (to - from)
        };
        if fraction.is_nan() {
            0.0
        } else {
            fraction.clamp(0.0, 1.0)
        }
    }
}

fn x_range(figure: &Figure) -> [f64; 2] {
    let values = figure.panels.iter().flat_map(Panel::values).map(|[x, _]| x);
    figure
        .x
        .range
        .unwrap_or_else(|| padded(values, figure.x.log, 0.04))
}

fn y_range(panel: &Panel) -> [f64; 2] {
    let values = panel.values().map(|[_, y]| y).chain(panel.error_ends());
    panel
        .y
        .range
        .unwrap_or_else(|| padded(values, panel.y.log, 0.07))
}

/// The range of the values with some room at both ends.
fn padded(values: impl Iterator<Item = f64>, log: bool, room: f64) -> [f64; 2] {
    let transformed = values.map(|value| if log { value.ln() } else { value });
    let [low, high] = transformed.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| {
        [low.min(v), high.max(v)]
    });
    let spread = high - low;
    // A single value gets a range of its own size around it.
    let pad = if spread > 1e-12 * low.abs().max(high.abs()) {
        spread * room
    } else {
        (0.1 * high.abs()).max(0.5)
    };
    [low - pad, high + pad].map(|end| if log { end.exp() } else { end })
}

fn axis_ticks(axis: &Axis, range: [f64; 2], count: usize) -> Vec<Tick> {
    if axis.log {
        ticks::logarithmic(range)
    } else {
        ticks::linear(range, count)
    }
}

fn widest_label(ticks: &[Vec<Tick>]) -> Result<f64> {
    let mut widest: f64 = 0.0;
    for label in ticks
        .iter()
        .flatten()
        .filter_map(|tick| tick.label.as_deref())
    {
        widest = widest.max(canvas::text_width(label, TICK_SIZE)?);
    }
    Ok(widest)
}

/// The labels of the axes of a panel; the x axis is labelled below the last one only.
struct Labels<'a> {
    x: Option<&'a Fitted>,
    y: &'a Fitted,
}

/// Grid, frame, ticks and labels.
fn draw_axes(
    figure: &Figure,
    labels: &Labels<'_>,
    area: &Area,
    y_ticks: &[Tick],
    canvas: &mut dyn Canvas,
) -> Result<()> {
    let shape = canvas.shape();
    let x_ticks = axis_ticks(
        &figure.x,
        area.x.range,
        (f64::from(shape.width) / 150.0).round().max(4.0) as usize,
    );
    for tick in y_ticks.iter().filter(|tick| tick.label.is_some()) {
        let y = area.y(tick.value);
        canvas.line(&[[area.left, y], [area.right, y]], 1.0, GRID)?;
    }
    for tick in x_ticks.iter().filter(|tick| tick.label.is_some()) {
        let x = area.x(tick.value);
        canvas.line(&[[x, area.top], [x, area.bottom]], 1.0, GRID)?;
    }
    let length = |tick: &Tick| {
        if tick.label.is_some() {
            TICK_LENGTH
        } else {
            TICK_LENGTH * 0.55
        }
    };
    for tick in y_ticks {
        let y = area.y(tick.value);
        canvas.line(&[[area.left - length(tick), y], [area.left, y]], 1.5, FRAME)?;
        if let Some(label) = &tick.label {
            let end = [
                area.left - TICK_LENGTH - 6.0,
                y + CAPITALS * TICK_SIZE / 2.0,
            ];
            canvas.text(label, end, TICK_SIZE, INK, Align::Right, Direction::Right)?;
        }
    }
    let mut free_from = f64::NEG_INFINITY;
    for tick in &x_ticks {
        let x = area.x(tick.value);
        canvas.line(
            &[[x, area.bottom], [x, area.bottom + length(tick)]],
            1.5,
            FRAME,
        )?;
        if let Some(label) = tick.label.as_ref().filter(|_| labels.x.is_some()) {
            let half = canvas::text_width(label, TICK_SIZE)? / 2.0;
            if x - half >= free_from {
                let middle = [x, area.bottom + TICK_LENGTH + 5.0 + TICK_SIZE * 0.85];
                canvas.text(
                    label,
                    middle,
                    TICK_SIZE,
                    INK,
                    Align::Centre,
                    Direction::Right,
                )?;
                free_from = x + half + 0.4 * TICK_SIZE;
            }
        }
    }
    let corners = [
        [area.left, area.top],
        [area.right, area.top],
        [area.right, area.bottom],
        [area.left, area.bottom],
    ];
    for side in 0..4 {
        canvas.line(&[corners[side], corners[(side + 1) % 4]], 1.5, FRAME)?;
    }
    if let Some(label) = labels.x {
        let (width, lowest) = (
            f64::from(shape.width),
            f64::from(shape.height) - MARGIN + 4.0,
        );
        for (above, line) in label.lines.iter().rev().enumerate() {
            // A label longer than the panel keeps off the edges.
            let half = canvas::text_width(line, label.size)? / 2.0 + MARGIN;
            let middle = ((area.left + area.right) / 2.0).min(width - half).max(half);
            let place = [middle, lowest - above as f64 * LINE * label.size];
            canvas.text(
                line,
                place,
                label.size,
                INK,
                Align::Centre,
                Direction::Right,
            )?;
        }
    }
    for (number, line) in labels.y.lines.iter().enumerate() {
        let x = MARGIN + LABEL_SIZE * CAPITALS + number as f64 * LINE * labels.y.size;
        let middle = [x, (area.top + area.bottom) / 2.0];
        canvas.text(
            line,
            middle,
            labels.y.size,
            INK,
            Align::Centre,
            Direction::Up,
        )?;
    }
    Ok(())
}

/// Replicas behind, then line, error bars and points, each point set off by a white rim; a line of
/// many points stands alone.
fn draw_series(
    series: &super::Series,
    (colour, marker): (Rgb, canvas::Marker),
    area: &Area,
    canvas: &mut dyn Canvas,
) -> Result<()> {
    for [x, y] in series.replicas.iter().filter(|[_, y]| !y.is_nan()) {
        canvas.disc(
            [area.x(*x), area.y(*y)],
            REPLICA_RADIUS,
            colour,
            REPLICA_OPACITY,
        )?;
    }
    let points: Vec<_> = series
        .points
        .iter()
        .filter(|point| !point.y.is_nan())
        .collect();
    if series.line && points.len() > 1 {
        let path: Vec<_> = points
            .iter()
            .map(|point| [area.x(point.x), area.y(point.y)])
            .collect();
        canvas.line(&path, 2.5, colour)?;
    }
    for point in &points {
        let Some(error) = point.error.filter(|error| error.is_finite()) else {
            continue;
        };
        let (x, low, high) = (
            area.x(point.x),
            area.y(point.y - error),
            area.y(point.y + error),
        );
        canvas.line(&[[x, low], [x, high]], 2.0, colour)?;
        for end in [low, high] {
            canvas.line(&[[x - 7.0, end], [x + 7.0, end]], 2.0, colour)?;
        }
    }
    if series.line && points.len() > MOST_MARKED {
        return Ok(());
    }
    for point in &points {
        let centre = [area.x(point.x), area.y(point.y)];
        canvas.marker(marker, centre, MARKER_RADIUS + 1.8, WHITE)?;
        canvas.marker(marker, centre, MARKER_RADIUS, colour)?;
    }
    Ok(())
}
