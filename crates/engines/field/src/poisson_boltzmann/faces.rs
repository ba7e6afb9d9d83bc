//! The potential on the faces of a grid.
//!
//! The sum over screened atoms is smooth there: no charge is nearer than the margin. Faces are cut
//! into patches whose half edge is 0.6 of their distance d from the nearest charge. On a patch with more
//! than 7 x 7 points the sum is taken at 7 x 7 Chebyshev points and interpolated, which leaves some
//! ρ⁻⁷ = 1.3 · 10⁻⁴ of what the nearest charges contribute ([`protomer_kernel::chebyshev`], with
//! ρ = 5/3 + √(1 + 25/9)). Far charges are seen as clusters (`charge_tree`), and sums are taken in
//! single precision (`screened_sum`). In the tests, with random charges that largely cancel, the error
//! stays below 3 · 10⁻⁴ of the largest potential on the faces.

use crate::debye_huckel::Superposition;
use crate::grid::{Grid, set_points};
use protomer_kernel::Vec3;
use protomer_kernel::chebyshev::Interpolation;
use rayon::prelude::*;
use std::ops::Range;

/// Chebyshev points along the edges of a patch.
const POINTS: usize = 7;
/// Half the edge of a patch over its distance from the nearest charge.
const HALF_EDGE: f64 = 0.6;

/// Zero at inner points, the given potential at each point of the faces.
pub(super) fn point_by_point(grid: &Grid, potential: impl Fn(&Vec3) -> f64 + Sync) -> Vec<f64> {
    let mut values = vec![0.0; grid.len()];
    set_points(grid.shape, &mut values, |place, value| {
        let [i, j, k] = place;
        // Inner points stay at zero, from which the solve starts.
        let on_face = (0..3).any(|axis| place[axis] == 0 || place[axis] + 1 == grid.shape[axis]);
        if on_face {
            *value = potential(&grid.point(i, j, k));
        }
    });
    values
}

/// Zero at inner points, the sum of screened potentials on the faces.
pub(super) fn superposed(grid: &Grid, atoms: &Superposition) -> Vec<f64> {
    let patches = patches(grid, atoms);
    let of_patches: Vec<Vec<f64>> = patches
        .par_iter()
        .map(|patch| patch.values(grid, atoms))
        .collect();
    let mut values = vec![0.0; grid.len()];
    for (patch, of_patch) in patches.iter().zip(of_patches) {
        for (number, value) in of_patch.into_iter().enumerate() {
            values[patch.index(grid, number)] = value;
        }
    }
    values
}

/// A rectangle of points on a face.
struct Patch {
    /// The axis that the face is perpendicular to, and its place along it.
    axis: usize,
    layer: usize,
    /// Points along the two axes that follow.
    points: [Range<usize>; 2],
}

/// The patches of all faces.
fn patches(grid: &Grid, atoms: &Superposition) -> Vec<Patch> {
    let mut patches = Vec::new();
    for axis in 0..3 {
        let other_axes = [(axis + 1) % 3, (axis + 2) % 3];
        for layer in [0, grid.shape[axis] - 1] {
            let mut on_face = [0; 3];
            on_face[axis] = layer;
            let place = grid.point(on_face[0], on_face[1], on_face[2])[axis];
            let distance = atoms.distance_from_plane(axis, place);
            let [rows, columns] = other_axes.map(|axis| grid.shape[axis]);
            let longest = (2.0 * HALF_EDGE * distance / grid.spacing_angstrom) as usize;
            // The longest patch whose half edge is 0.6 of the distance; at least one point.
            let longest = longest.min(rows.max(columns)) + 1;
            for row in (0..rows).step_by(longest) {
                for column in (0..columns).step_by(longest) {
                    let ends = [(row + longest).min(rows), (column + longest).min(columns)];
                    let points = [row..ends[0], column..ends[1]];
                    patches.push(Patch {
                        axis,
                        layer,
                        points,
                    });
                }
            }
        }
    }
    patches
}

impl Patch {
    /// Rows and columns of points.
    fn shape(&self) -> [usize; 2] {
        [self.points[0].len(), self.points[1].len()]
    }

    /// The coordinates on the grid of a point, counted along the columns first.
    fn coordinates(&self, number: usize) -> [usize; 3] {
        let columns = self.points[1].len();
        let mut indices = [0; 3];
        indices[self.axis] = self.layer;
        indices[(self.axis + 1) % 3] = self.points[0].start + number / columns;
        indices[(self.axis + 2) % 3] = self.points[1].start + number % columns;
        indices
    }

    fn index(&self, grid: &Grid, number: usize) -> usize {
        let [i, j, k] = self.coordinates(number);
        grid.index(i, j, k)
    }

    fn place(&self, grid: &Grid, number: usize) -> Vec3 {
        let [i, j, k] = self.coordinates(number);
        grid.point(i, j, k)
    }

    /// The values at the points.
    fn values(&self, grid: &Grid, atoms: &Superposition) -> Vec<f64> {
        let [rows, columns] = self.shape();
        let last = rows * columns - 1;
        let (low, high) = (self.place(grid, 0), self.place(grid, last));
        let merged_charges = atoms.seen_from(&low, &high);
        // Interpolation would take as many sums as there are points.
        if rows * columns <= POINTS * POINTS {
            let places = (0..=last).map(|number| self.place(grid, number));
            return places
                .map(|place| merged_charges.value_at(&place))
                .collect();
        }
        let other_axes = [(self.axis + 1) % 3, (self.axis + 2) % 3];
        let ends = other_axes.map(|axis| Interpolation::<POINTS>::new(low[axis], high[axis]));
        let mut sampled = [[0.0; POINTS]; POINTS];
        let mut place = low;
        // Samples at the Chebyshev points of both axes; the third coordinate is that of the face.
        for (along_columns, first) in sampled.iter_mut().zip(ends[0].points) {
            place[other_axes[0]] = first;
            for (value, second) in along_columns.iter_mut().zip(ends[1].points) {
                place[other_axes[1]] = second;
                *value = merged_charges.value_at(&place);
            }
        }
        let h = grid.spacing_angstrom;
        let weights_at = |column| ends[1].weights_at(low[other_axes[1]] + h * column as f64);
        let of_columns: Vec<[f64; POINTS]> = (0..columns).map(weights_at).collect();
        let mut values = Vec::with_capacity(rows * columns);
        for row in 0..rows {
            let of_row = ends[0].weights_at(low[other_axes[0]] + h * row as f64);
            // Along one axis for the whole row, then along
            // the other for each point: 7 + 7 products.
            let mut between = [0.0; POINTS];
            for (along_columns, weight) in sampled.iter().zip(of_row) {
                for (value, sample) in between.iter_mut().zip(along_columns) {
                    *value += weight * sample;
                }
            }
            for weights in &of_columns {
                let terms = weights.iter().zip(between);
                values.push(terms.map(|(weight, value)| weight * value).sum());
            }
        }
        values
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{ChargedSphere, DielectricModel};
    use protomer_kernel::Electrolyte;
    use protomer_kernel::random::CounterRng;

    #[test]
    fn faces_have_the_sums_over_all_atoms() {
        let mut rng = CounterRng::new(18, 2, 0);
        let saline = DielectricModel::new(Electrolyte::in_water(298.15, 0.15).unwrap());
        for (count, radius, margin, spacing) in [
            (1, 0.1, 10.0, 0.5),
            (800, 16.0, 10.0, 1.0),
            (800, 16.0, 2.0, 0.7),
            (3000, 25.0, 6.0, 1.0),
        ] {
            let mut spheres = Vec::new();
            for _ in 0..count {
                spheres.push(ChargedSphere {
                    centre: rng.vector_in_ball(radius),
                    radius_angstrom: 1.5,
                    charge_e: rng.uniform_in(-0.5, 0.5),
                });
            }
            let corner = Vec3::repeat(radius + 1.5 + margin);
            let grid = Grid::around(&-corner, &corner, spacing, 16).unwrap();
            let atoms = Superposition::new(&spheres, &saline);
            let exact = point_by_point(&grid, |place| atoms.value_at(place));
            let found = superposed(&grid, &atoms);
            let mut worst = 0.0_f64;
            let largest = exact
                .iter()
                .fold(0.0_f64, |most, value| most.max(value.abs()));
            for (found, exact) in found.iter().zip(&exact) {
                let error = (found - exact).abs() / largest;
                worst = worst.max(error);
            }
            assert!(worst < 3e-4, "{count} {margin} {spacing}: {worst}");
        }
    }
}
