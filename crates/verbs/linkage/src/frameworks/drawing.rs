//! Several cells of a network as SVG, the loaded one drawn over the unloaded one.
//!
//! Two-dimensional networks are viewed along x, with y to the right and z up. Three-dimensional
//! ones are drawn in the oblique projection with x coming towards the reader.

use protomer_linkage::framework::{Framework, Neighbour};
use protomer_plot::escaped;
use std::fmt::Write;

pub(super) const WIDTH: f64 = 1200.0;
pub(super) const HEIGHT: f64 = 800.0;
pub(super) const MARGIN: f64 = 50.0;
/// Room for title and legend.
pub(super) const HEAD: f64 = 70.0;
pub(super) const BEFORE: &str = "#b4b4b4";
pub(super) const AFTER: &str = "#0072b2";
/// Number of cells along the longer direction of the patch.
const CELLS: f64 = 3.0;
/// Largest number of nodes drawn.
const MOST_NODES: usize = 4000;

/// A network under load.
#[derive(Debug, Clone, Copy)]
pub struct LoadedNetwork<'a> {
    /// The deformed nodes and cell.
    pub network: &'a Framework,
    /// Index of the loading axis.
    pub axis: usize,
    /// Whether the load is compressive.
    pub pushed: bool,
    /// Description of the load for the legend.
    pub label: &'a str,
}

/// The text of an SVG file.
pub fn svg(title: &str, unloaded: &Framework, loaded: Option<LoadedNetwork>) -> String {
    let counts = cell_counts(unloaded);
    let before = Patch::new(unloaded, &counts);
    let after = loaded.map(|loaded| Patch::new(loaded.network, &counts));
    // Both patches share one scale, so that the strain is seen as it is.
    let view = View::new([Some(&before), after.as_ref()].into_iter().flatten());
    let place = |point: &[f64; 2]| view.place(point);
    let mut text = format!(
        "<svg width=\"{WIDTH}\" height=\"{HEIGHT}\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" xmlns=\"http://www.w3.org/2000/svg\" \
         font-family=\"DejaVu Sans, sans-serif\">\n<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n<text x=\"{MARGIN}\" \
         y=\"36\" font-size=\"24\">{}</text>\n",
        escaped(title)
    );
    let legend = match loaded {
        None => String::new(),
        Some(loaded) => format!(
            "<text x=\"{MARGIN}\" y=\"62\" font-size=\"18\"><tspan fill=\"{BEFORE}\">unloaded</tspan> <tspan dx=\"16\" \
             fill=\"{AFTER}\">{}</tspan></text>\n",
            escaped(loaded.label)
        ),
    };
    text += &legend;
    draw(
        &mut text,
        &before,
        &place,
        BEFORE,
        if loaded.is_some() { 3.0 } else { 4.0 },
    );
    if let (Some(patch), Some(loaded)) = (&after, loaded) {
        // The loaded network over the unloaded one.
        draw(&mut text, patch, &place, AFTER, 4.0);
        arrows(&mut text, &view.half.map(|x| view.scale * x), loaded);
    }
    text += "</svg>\n";
    text
}

/// Places of points of the drawing plane on the picture.
pub(super) struct View {
    centre: [f64; 2],
    half: [f64; 2],
    scale: f64,
}

impl View {
    /// A view of all these patches.
    pub(super) fn new<'a>(patches: impl Iterator<Item = &'a Patch>) -> Self {
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for point in patches.flat_map(|patch| patch.lines.iter().flatten()) {
            for axis in 0..2 {
                (low[axis], high[axis]) = (low[axis].min(point[axis]), high[axis].max(point[axis]));
            }
        }
        let half = [0, 1].map(|axis| 0.5 * (high[axis] - low[axis]));
        let room = [0.5 * WIDTH - MARGIN, 0.5 * (HEIGHT - HEAD) - MARGIN];
        // A patch without width must not divide by zero.
        let [scale_x, scale_y] = [0, 1].map(|axis| room[axis] / half[axis].max(1e-9));
        Self {
            centre: [0, 1].map(|axis| 0.5 * (low[axis] + high[axis])),
            half,
            scale: scale_x.min(scale_y),
        }
    }

    pub(super) fn place(&self, point: &[f64; 2]) -> [f64; 2] {
        let [x, y] = [0, 1].map(|axis| self.scale * (point[axis] - self.centre[axis]));
        // SVG counts downwards.
        [0.5 * WIDTH + x, HEAD + 0.5 * (HEIGHT - HEAD) - y]
    }
}

/// Number of cells to draw along each vector, so that the patch is about as long in each direction.
pub(super) fn cell_counts(network: &Framework) -> Vec<usize> {
    let mut lengths = Vec::new();
    for vector in &network.cell_angstrom {
        lengths.push(vector.iter().map(|x| x * x).sum::<f64>().sqrt());
    }
    let longest = lengths.iter().copied().fold(0.0, f64::max);
    let cells = if network.dimension() == 2 { CELLS } else { 2.0 };
    let mut counts = Vec::new();
    for length in lengths {
        let count: f64 = cells * longest / length;
        counts.push(count.round().clamp(1.0, 12.0) as usize);
    }
    let nodes = network.nodes_angstrom.len();
    // Halved along all vectors at once, which keeps the shape of the patch.
    while counts.iter().product::<usize>() * nodes > MOST_NODES && counts.iter().any(|c| *c > 1) {
        for count in &mut counts {
            *count = (*count / 2).max(1);
        }
    }
    counts
}

/// The rods of several cells as lines in the drawing plane, centred on the mean of their ends.
pub(super) struct Patch {
    pub(super) lines: Vec<[[f64; 2]; 2]>,
}

impl Patch {
    pub(super) fn new(network: &Framework, counts: &[usize]) -> Self {
        let mut lines = Vec::new();
        for number in 0..counts.iter().product() {
            let cell = cell_of(number, counts);
            for rod in &network.rods {
                let from = projected(network, &Neighbour::in_own_cell(rod.from), &cell);
                lines.push([from, projected(network, &rod.to, &cell)]);
            }
        }
        let mut sum = [0.0; 2];
        for point in lines.iter().flatten() {
            sum = [sum[0] + point[0], sum[1] + point[1]];
        }
        // Each line has two ends.
        let ends = 2.0 * lines.len() as f64;
        let middle = sum.map(|sum| sum / ends);
        for point in lines.iter_mut().flatten() {
            *point = [point[0] - middle[0], point[1] - middle[1]];
        }
        Self { lines }
    }
}

/// The indices of a cell from its number, the first index running fastest.
fn cell_of(mut number: usize, counts: &[usize]) -> Vec<usize> {
    let mut cell = Vec::with_capacity(counts.len());
    for count in counts {
        cell.push(number % count);
        number /= count;
    }
    cell
}

/// A node of a cell in the drawing plane.
fn projected(network: &Framework, neighbour: &Neighbour, cell: &[usize]) -> [f64; 2] {
    let dimension = network.dimension();
    let mut place = [0.0; 3];
    for (component, x) in place.iter_mut().enumerate().take(dimension) {
        *x = network.nodes_angstrom[neighbour.node][component];
        // Node plus the images of its cell: n + Σ (image + cell) a.
        for (axis, vector) in network.cell_angstrom.iter().enumerate() {
            let image = neighbour.image.get(axis).copied().unwrap_or(0);
            *x += (f64::from(image) + cell[axis] as f64) * vector[component];
        }
    }
    match dimension {
        2 => [place[0], place[1]],
        // The x axis points down and to the left.
        _ => [place[1] - 0.35 * place[0], place[2] - 0.22 * place[0]],
    }
}

fn draw(
    text: &mut String,
    patch: &Patch,
    place: &dyn Fn(&[f64; 2]) -> [f64; 2],
    colour: &str,
    width: f64,
) {
    // Writing to a string cannot fail.
    let _ = write!(
        text,
        "<g stroke=\"{colour}\" fill=\"{colour}\" stroke-width=\"{width}\" stroke-linecap=\"round\">\n<path d=\""
    );
    for [from, to] in &patch.lines {
        let ([x1, y1], [x2, y2]) = (place(from), place(to));
        let _ = write!(text, "M{x1:.1} {y1:.1}L{x2:.1} {y2:.1}");
    }
    text.push_str("\"/>\n</g>\n");
}

/// Two arrows outside the patch that show the direction of the load.
fn arrows(text: &mut String, half: &[f64; 2], loaded: LoadedNetwork) {
    let direction = match (loaded.network.dimension(), loaded.axis) {
        (2, 0) | (3, 1) => [1.0, 0.0],
        (2, _) | (3, 2) => [0.0, -1.0],
        _ => [-0.85, 0.53],
    };
    let (x, y) = (0.5 * WIDTH, HEAD + 0.5 * (HEIGHT - HEAD));
    for side in [1.0, -1.0] {
        let [u, v] = direction.map(|component: f64| side * component);
        let (near, far) = (8.0, 40.0);
        let reach = [x + u * half[0], y + v * half[1]];
        let (tail, tip) = if loaded.pushed {
            (far, near)
        } else {
            (near, far)
        };
        let position = |longitudinal: f64, transverse: f64| {
            (
                reach[0] + u * longitudinal - v * transverse,
                reach[1] + v * longitudinal + u * transverse,
            )
        };
        let back = tip + if loaded.pushed { 14.0 } else { -14.0 };
        let points = [
            position(tail, 0.0),
            position(tip, 0.0),
            position(back, 8.0),
            position(tip, 0.0),
            position(back, -8.0),
        ];
        let points = points.map(|(x, y)| format!("{x:.1},{y:.1}"));
        let _ = writeln!(
            text,
            "<polyline points=\"{}\" fill=\"none\" stroke=\"black\" stroke-width=\"3\"/>",
            points.join(" ")
        );
    }
}
