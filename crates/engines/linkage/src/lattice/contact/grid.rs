//! Points sorted into cells at least as wide as the reach.

use crate::lattice::cell::Cell;
use crate::plane::{Vector, norm};
use std::ops::RangeInclusive;

/// A point and the number of one of its periodic images, in cells along x and y.
pub(super) type Image = (usize, [i32; 2]);

pub(super) struct Grid {
    /// The points, with the lean of the cell taken out.
    places: Vec<Vector>,
    /// H_xy/H_yy.
    lean: f64,
    reach: f64,
    low: Vector,
    counts: [usize; 2],
    width: Vector,
    /// Edges of the periodic cell.
    periodic: Option<Vector>,
    /// The first point of every cell, and the points cell by cell.
    starts: Vec<usize>,
    points: Vec<usize>,
}

impl Grid {
    /// The grid of these points, for neighbours within `reach`. In x - y H_xy/H_yy and y the cell
    /// has a right angle; distances there are longer by at most the norm of (1, H_xy/H_yy).
    pub fn new(places: &[Vector], reach: f64, cell: Option<Cell>) -> Self {
        let lean = cell.map_or(0.0, |cell| cell.xy / cell.yy);
        let reach = reach * norm([1.0, lean]);
        let places: Vec<Vector> = places.iter().map(|place| upright(*place, lean)).collect();
        let periodic = cell.map(|cell| [cell.xx, cell.yy]);
        let (low, extent) = extent(&places, periodic);
        // Squares that have flown far apart must not ask for more cells than there are points.
        let most = 2.0 * (places.len() as f64).sqrt().ceil() + 1.0;
        // Cells are at least as wide as the reach.
        let counts = extent.map(|extent| (extent / reach).floor().clamp(1.0, most) as usize);
        let width = [extent[0] / counts[0] as f64, extent[1] / counts[1] as f64];
        let mut grid = Self {
            points: vec![0; places.len()],
            places,
            lean,
            reach,
            low,
            counts,
            width,
            periodic,
            starts: Vec::new(),
        };
        grid.sort_points();
        grid
    }

    /// Counting sort of the points by their cells.
    fn sort_points(&mut self) {
        // Points of a cell lie together: `starts` says where.
        let mut starts = vec![0; self.counts[0] * self.counts[1] + 1];
        for place in &self.places {
            starts[self.cell(*place) + 1] += 1;
        }
        for cell in 1..starts.len() {
            starts[cell] += starts[cell - 1];
        }
        let mut next = starts.clone();
        for (point, place) in self.places.iter().enumerate() {
            let cell = self.cell(*place);
            self.points[next[cell]] = point;
            next[cell] += 1;
        }
        self.starts = starts;
    }

    fn column(&self, place: f64, axis: usize) -> usize {
        let index = ((place - self.low[axis]) / self.width[axis]).floor();
        let count = self.counts[axis];
        if self.periodic.is_some() {
            // Below the count: the remainder of two whole numbers is exact.
            index.rem_euclid(count as f64) as usize
        } else {
            index.clamp(0.0, (count - 1) as f64) as usize
        }
    }

    fn cell(&self, place: Vector) -> usize {
        self.column(place[1], 1) * self.counts[0] + self.column(place[0], 0)
    }

    /// The columns (or rows) next to that of a place, and its own.
    fn columns_around(&self, place: f64, axis: usize) -> Vec<usize> {
        let (count, middle) = (self.counts[axis], self.column(place, axis));
        if self.periodic.is_none() {
            return (middle.saturating_sub(1)..=(middle + 1).min(count - 1)).collect();
        }
        // Fewer than three cells: neighbours would be named twice.
        if count < 3 {
            return (0..count).collect();
        }
        vec![(middle + count - 1) % count, middle, (middle + 1) % count]
    }

    /// Collects the points, with the numbers of their images, that may be within reach of a place.
    pub fn near(&self, place: Vector, out: &mut Vec<Image>) {
        let place = upright(place, self.lean);
        out.clear();
        let columns = self.columns_around(place[0], 0);
        for row in self.columns_around(place[1], 1) {
            for column in &columns {
                let cell = row * self.counts[0] + column;
                for point in &self.points[self.starts[cell]..self.starts[cell + 1]] {
                    self.add_images(*point, place, out);
                }
            }
        }
    }

    fn add_images(&self, point: usize, place: Vector, out: &mut Vec<Image>) {
        let Some(edges) = self.periodic else {
            out.push((point, [0; 2]));
            return;
        };
        let point_place = self.places[point];
        for right in self.images_within(point_place[0] - place[0], edges[0]) {
            for up in self.images_within(point_place[1] - place[1], edges[1]) {
                out.push((point, [right, up]));
            }
        }
    }

    /// The images of a point this far away, in cells of this edge, that are within reach.
    fn images_within(&self, away: f64, edge: f64) -> RangeInclusive<i32> {
        // Whole numbers of edges within the reach.
        let low = ((-self.reach - away) / edge).ceil() as i32;
        let high = ((self.reach - away) / edge).floor() as i32;
        low..=high
    }
}

/// A point in coordinates in which the cell has a right angle.
fn upright([x, y]: Vector, lean: f64) -> Vector {
    [x - lean * y, y]
}

/// The lowest coordinates and the extent of the points, or of the periodic cell.
fn extent(places: &[Vector], periodic: Option<Vector>) -> (Vector, Vector) {
    let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    for place in places {
        for axis in 0..2 {
            low[axis] = low[axis].min(place[axis]);
            high[axis] = high[axis].max(place[axis]);
        }
    }
    let of_points = [high[0] - low[0], high[1] - low[1]];
    let extent = periodic.unwrap_or(of_points);
    (low, extent.map(|length| length.max(1e-9)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_next_to_the_edges_of_a_periodic_cell_have_a_column() {
        let places = [[0.0, 0.0], [2.9, 2.9], [0.5, 1.5]];
        let cell = Cell {
            xx: 3.0,
            yy: 3.0,
            xy: 0.0,
        };
        let grid = Grid::new(&places, 1.0, Some(cell));
        assert_eq!(grid.counts, [3, 3]);
        for (place, column) in [(-1e-20, 2), (0.0, 0), (3.0, 0), (2.999, 2), (-3e9, 0)] {
            assert_eq!(grid.column(place, 0), column, "{place}");
        }
    }
}
