//! The layout of title, caption, legend, panels and data.

use super::axis::{self, Area, Scale};
use super::canvas::{Align, Canvas, Marker, Nowhere, Rgb, Shape, Style, TextStyle};
use super::measures::{CAPITALS, INK, LINE, MARGIN};
use super::text::{Fitted, fit};
use super::typeface::text_width;
use super::{Figure, Series};

const PALE_INK: Rgb = [0x60, 0x60, 0x60];
const WHITE: Rgb = [0xFF; 3];

const TITLE_SIZE: f64 = 27.0;
const CAPTION_SIZE: f64 = 17.0;
const LABEL_SIZE: f64 = 23.0;
const LEGEND_SIZE: f64 = 20.0;

const PANEL_GAP: f64 = 22.0;
const MARKER_RADIUS: f64 = 6.5;
/// Width of the white rim that separates a point from the line.
const RIM: f64 = 1.8;
/// Radius of the points of single replicas.
const REPLICA_RADIUS: f64 = 4.0;
/// Opacity of the points of single replicas.
const REPLICA_OPACITY: f64 = 0.4;
/// Number of points on a line beyond which markers would hide each other and the line.
const MOST_MARKED: usize = 60;
/// Width of the lines of the series.
const LINE_WIDTH: f64 = 2.5;
/// Width of the lines of error bars.
const ERROR_BAR_WIDTH: f64 = 2.0;
/// Half the length of the caps of error bars.
const ERROR_BAR_CAP: f64 = 7.0;
/// Length of the sample of a line in the legend.
const LEGEND_SAMPLE: f64 = 46.0;
/// Distance between the sample of a line and its name in the legend.
const LEGEND_SPACE: f64 = 10.0;
/// Distance between two entries of the legend.
const LEGEND_GAP: f64 = 34.0;

/// Draws the whole figure.
pub(crate) fn draw(figure: &Figure, shape: Shape, canvas: &mut dyn Canvas) {
    let Shape { width, height, .. } = shape;
    let sheet = [[0.0, 0.0], [width, 0.0], [width, height], [0.0, height]];
    canvas.polygon(&sheet, WHITE);
    let top = draw_heading(figure, shape, canvas);
    let x_label = x_label(figure, shape);
    let bottom = height - below_panels(&x_label);
    let count = figure.panels.len() as f64;
    let panel_height = (bottom - top - PANEL_GAP * (count - 1.0)) / count;
    let axes: Vec<axis::Vertical> = figure
        .panels
        .iter()
        .map(|panel| axis::Vertical::new(panel, panel_height, LABEL_SIZE, shape.least_shrunk))
        // All panels before any is drawn: the widest numbers decide where every panel begins.
        .collect();
    let left = MARGIN + axis::Vertical::room(&axes, LABEL_SIZE);
    let right = width - MARGIN - 12.0;
    let x = Scale::of_x(figure);
    for (index, (panel, vertical)) in figure.panels.iter().zip(&axes).enumerate() {
        let panel_top = top + index as f64 * (panel_height + PANEL_GAP);
        let area = Area {
            left,
            right,
            top: panel_top,
            bottom: panel_top + panel_height,
            x,
            y: vertical.scale,
        };
        // One label for the axis that all panels share.
        let is_last = index + 1 == figure.panels.len();
        axis::draw(&area, vertical, is_last.then_some(&x_label), shape, canvas);
        for series in &panel.series {
            draw_series(series, style_of(figure, series), &area, canvas);
        }
    }
}

/// The height that a figure of this width needs for its panels to have the given height.
pub(crate) fn height_for(figure: &Figure, shape: Shape, panel_height: f64) -> f64 {
    let count = figure.panels.len() as f64;
    let panels = count * panel_height + (count - 1.0) * PANEL_GAP;
    // The heading is laid out on a canvas that draws nothing, to learn its height.
    draw_heading(figure, shape, &mut Nowhere) + panels + below_panels(&x_label(figure, shape))
}

fn x_label(figure: &Figure, shape: Shape) -> Fitted {
    let room = shape.width - 2.0 * MARGIN;
    fit(&figure.x.label, LABEL_SIZE, room, shape.least_shrunk)
}

/// Height of everything below the lowest panel.
fn below_panels(x_label: &Fitted) -> f64 {
    MARGIN + x_label.height(LINE) + 10.0 + axis::TICK_SIZE + axis::TICK_LENGTH
}

/// Style of a series. Series of one name have one style in all panels.
fn style_of(figure: &Figure, series: &Series) -> Style {
    // By name over all panels, so that a series keeps its colour in each.
    let names = figure.series_names();
    let number = names.iter().position(|name| *name == series.name);
    Style::of_series(number.unwrap_or(0))
}

/// Draws title, caption and legend; returns where the panels may begin.
fn draw_heading(figure: &Figure, shape: Shape, canvas: &mut dyn Canvas) -> f64 {
    let mut y = draw_title(&figure.title, &figure.caption, shape, canvas);
    let names = figure.series_names();
    // A single series needs no legend; the title says what it is.
    if names.len() > 1 {
        y = draw_legend(&names, y + 4.0, shape.width, canvas);
    }
    y + 14.0
}

/// Draws title and caption; returns their lower end.
pub(crate) fn draw_title(title: &str, caption: &str, shape: Shape, canvas: &mut dyn Canvas) -> f64 {
    let mut y = MARGIN;
    for (text, size, colour) in [(title, TITLE_SIZE, INK), (caption, CAPTION_SIZE, PALE_INK)] {
        if text.is_empty() {
            continue;
        }
        let fitted = fit(text, size, shape.width - 2.0 * MARGIN, shape.least_shrunk);
        let style = TextStyle::new(fitted.size, colour, Align::Centre);
        for (number, line) in fitted.lines.iter().enumerate() {
            // The first line keeps the height of unshrunk letters, so titles stand in one place.
            y += if number == 0 {
                size
            } else {
                LINE * fitted.size
            };
            canvas.text(line, [shape.width / 2.0, y], style);
        }
        y += size * 0.45;
    }
    y
}

/// The height of title and caption.
pub(crate) fn heading_height(title: &str, caption: &str, shape: Shape) -> f64 {
    draw_title(title, caption, shape, &mut Nowhere)
}

/// A row of the legend: its width, and the number and width of each entry.
struct LegendRow {
    width: f64,
    entries: Vec<(usize, f64)>,
}

/// Draws the names in centred rows above the panels, where they cover no data; returns the lower
/// end.
fn draw_legend(names: &[&str], top: f64, width: f64, canvas: &mut dyn Canvas) -> f64 {
    let mut y = top;
    for row in legend_rows(names, width - 2.0 * MARGIN) {
        y += LEGEND_SIZE * 1.4;
        let mut x = (width - row.width) / 2.0;
        for (number, length) in row.entries {
            draw_legend_entry(names[number], Style::of_series(number), [x, y], canvas);
            x += length + LEGEND_GAP;
        }
    }
    y
}

fn legend_rows(names: &[&str], room: f64) -> Vec<LegendRow> {
    let mut rows: Vec<LegendRow> = Vec::new();
    for (number, name) in names.iter().enumerate() {
        // The label of its axis says what a series without a name is.
        if name.is_empty() {
            continue;
        }
        let length = LEGEND_SAMPLE + LEGEND_SPACE + text_width(name, LEGEND_SIZE);
        match rows.last_mut() {
            // At least one entry a row, however long its name.
            Some(row) if row.width + LEGEND_GAP + length <= room => {
                row.width += LEGEND_GAP + length;
                row.entries.push((number, length));
            }
            _ => rows.push(LegendRow {
                width: length,
                entries: vec![(number, length)],
            }),
        }
    }
    rows
}

fn draw_legend_entry(name: &str, style: Style, [x, y]: [f64; 2], canvas: &mut dyn Canvas) {
    let Style { colour, marker } = style;
    let middle = y - CAPITALS * LEGEND_SIZE / 2.0;
    let sample = [[x, middle], [x + LEGEND_SAMPLE, middle]];
    canvas.line(&sample, LINE_WIDTH, colour);
    let centre = [x + LEGEND_SAMPLE / 2.0, middle];
    canvas.marker(marker, centre, MARKER_RADIUS, colour);
    let start = [x + LEGEND_SAMPLE + LEGEND_SPACE, y];
    canvas.text(name, start, TextStyle::new(LEGEND_SIZE, INK, Align::Left));
}

/// Draws replicas, line, error bars, points and spans, in this order. A line of many points has no
/// markers.
fn draw_series(series: &Series, style: Style, area: &Area, canvas: &mut dyn Canvas) {
    let Style { colour, marker } = style;
    // Replicas first and pale: what is drawn later lies over them.
    for [x, y] in series.replicas.iter().filter(|[_, y]| !y.is_nan()) {
        let centre = area.place(*x, *y);
        canvas.disc(centre, REPLICA_RADIUS, colour, REPLICA_OPACITY);
    }
    let drawn = series.points.iter().filter(|point| !point.y.is_nan());
    let places: Vec<[f64; 2]> = drawn
        .clone()
        .map(|point| area.place(point.x, point.y))
        .collect();
    if series.line && places.len() > 1 {
        // The line breaks nowhere: points without a value were left out before.
        canvas.line(&places, LINE_WIDTH, colour);
    }
    for point in drawn {
        // A bar without an end would run out of the panel.
        if let Some(error) = point.error.filter(|error| error.is_finite()) {
            let ends = [point.y - error, point.y + error].map(|y| area.place(point.x, y));
            draw_bar(ends, [ERROR_BAR_CAP, 0.0], colour, canvas);
        }
    }
    if !series.line || places.len() <= MOST_MARKED {
        for place in places {
            draw_point(marker, place, colour, canvas);
        }
    }
    for span in &series.spans {
        let ends = [span.from, span.to].map(|x| area.place(x, span.y));
        draw_bar(ends, [0.0, ERROR_BAR_CAP], colour, canvas);
        draw_point(marker, area.place(span.x, span.y), colour, canvas);
    }
}

/// A bar with a cap at each end; half a cap is `half_cap`.
fn draw_bar(ends: [[f64; 2]; 2], half_cap: [f64; 2], colour: Rgb, canvas: &mut dyn Canvas) {
    canvas.line(&ends, ERROR_BAR_WIDTH, colour);
    let [half_width, half_height] = half_cap;
    for [x, y] in ends {
        let cap = [
            [x - half_width, y - half_height],
            [x + half_width, y + half_height],
        ];
        canvas.line(&cap, ERROR_BAR_WIDTH, colour);
    }
}

fn draw_point(marker: Marker, place: [f64; 2], colour: Rgb, canvas: &mut dyn Canvas) {
    // A white rim first: points on a crowded line stay apart.
    canvas.marker(marker, place, MARKER_RADIUS + RIM, WHITE);
    canvas.marker(marker, place, MARKER_RADIUS, colour);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn series_without_a_name_are_not_in_the_legend() {
        let rows = legend_rows(&["centres", "", "rotations"], 1000.0);
        let numbers: Vec<usize> = rows[0].entries.iter().map(|(number, _)| *number).collect();
        assert_eq!((rows.len(), numbers), (1, vec![0, 2]));
    }
}
