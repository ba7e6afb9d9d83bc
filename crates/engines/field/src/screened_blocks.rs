//! Screened potentials of charges at all points of a grid, block by block.
//!
//! The charges far from a block of points have a smooth potential there. It is summed at 5³
//! Chebyshev points of the block and interpolated, so that only near charges are summed at each of
//! its 8³ points. A charge is far at [`FARTHER`](crate::charge_tree::FARTHER) half-diagonals from
//! the middle of the block. The kernel is symmetric, so the error is that of a cluster of charges
//! that is seen from there ([`crate::charge_tree`]).

use crate::debye_huckel::Superposition;
use crate::grid::{Block, Grid};
use crate::screened_sum::ScreenedSum;
use protomer_kernel::Vec3;
use protomer_kernel::chebyshev::Interpolation;
use rayon::prelude::*;

/// Points along each edge of a block.
const EDGE: usize = 8;
/// Chebyshev points along each edge of a block.
const POINTS: usize = 5;
/// Blocks with fewer points than this are summed point by point.
const FEWEST: usize = 2 * POINTS.pow(3);

/// The potential at each point of a grid, kT/e, with x running fastest.
pub(crate) fn tabulate(charges: &Superposition, grid: &Grid) -> Vec<f64> {
    let blocks = grid.blocks(EDGE);
    let of_blocks: Vec<Vec<f64>> = blocks
        .par_iter()
        .map(|block| potential_in_block(charges, grid, block))
        .collect();
    let mut values = vec![0.0; grid.len()];
    for (block, of_block) in blocks.iter().zip(of_blocks) {
        let mut found = &of_block[..];
        for row in block.rows(grid) {
            let (of_row, rest) = found.split_at(row.len());
            values[row].copy_from_slice(of_row);
            found = rest;
        }
    }
    values
}

/// The potential at the points of a block, row by row.
fn potential_in_block(charges: &Superposition, grid: &Grid, block: &Block) -> Vec<f64> {
    let (low, high) = block.corners(grid);
    let points: Vec<usize> = block.rows(grid).flatten().collect();
    let sums = |charges: &ScreenedSum| -> Vec<f64> {
        let places = points.iter().map(|point| grid.point_at(*point));
        places.map(|place| charges.value_at(&place)).collect()
    };
    if points.len() < FEWEST {
        return sums(&charges.seen_from(&low, &high));
    }
    let [near, far] = charges.near_and_far(&low, &high);
    let mut values = sums(&near);
    let smooth = Smooth::new(&far, &low, &high);
    let mut place_in_block = 0;
    for row in block.rows(grid) {
        smooth.add_to_row(grid, row.start, &mut values[place_in_block..][..row.len()]);
        place_in_block += row.len();
    }
    values
}

/// A polynomial in each coordinate, by its values at the Chebyshev points of a box.
struct Smooth {
    axes: [Interpolation<POINTS>; 3],
    /// Values, with x running fastest.
    values: [[[f64; POINTS]; POINTS]; POINTS],
}

impl Smooth {
    /// The potential of charges far from the box.
    fn new(far: &ScreenedSum, low: &Vec3, high: &Vec3) -> Self {
        let axes = [0, 1, 2].map(|axis| Interpolation::<POINTS>::new(low[axis], high[axis]));
        let [xs, ys, zs] = axes.map(|axis| axis.points);
        let values = zs.map(|z| ys.map(|y| xs.map(|x| far.value_at(&Vec3::new(x, y, z)))));
        Self { axes, values }
    }

    /// Adds the polynomial at the points of a row along x that starts at this point.
    fn add_to_row(&self, grid: &Grid, first: usize, row: &mut [f64]) {
        let start = grid.point_at(first);
        let [of_y, of_z] = [1, 2].map(|axis| self.axes[axis].weights_at(start[axis]));
        // Along z and y once for the row; what is left for a point is one sum along x.
        let mut along_x = [0.0; POINTS];
        for (plane, of_plane) in self.values.iter().zip(of_z) {
            for (line, of_line) in plane.iter().zip(of_y) {
                for (sum, value) in along_x.iter_mut().zip(line) {
                    *sum += of_plane * of_line * value;
                }
            }
        }
        for (step, value) in row.iter_mut().enumerate() {
            let weights = self.axes[0].weights_at(start.x + grid.spacing_angstrom * step as f64);
            let terms = weights.iter().zip(&along_x);
            *value += terms.map(|(weight, sum)| weight * sum).sum::<f64>();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{ChargedSphere, DielectricModel};
    use protomer_kernel::Electrolyte;
    use protomer_kernel::random::CounterRng;

    /// The slow twin: every charge at every point, in double precision.
    #[test]
    fn potentials_are_those_of_the_direct_sum() {
        let mut rng = CounterRng::new(11, 0, 0);
        // The density of the charges of a protein, in a ball of 18 Å.
        let charges: Vec<ChargedSphere> = (0..1200)
            .map(|_| ChargedSphere {
                centre: rng.vector_in_ball(18.0),
                radius_angstrom: 1.0,
                charge_e: rng.uniform_in(-1.0, 1.0),
            })
            .collect();
        for salt_molar in [0.05, 1.0] {
            let saline = Electrolyte::in_water(298.15, salt_molar).unwrap();
            let superposition = Superposition::new(&charges, &DielectricModel::new(saline));
            let grid = Grid {
                origin_angstrom: [-21.3, -22.1, 2.4],
                spacing_angstrom: 1.0,
                shape: [50, 49, 23],
            };
            let bjerrum = saline.bjerrum_length_angstrom();
            let exact = superposition.tabulate(grid).values;
            for (point, found) in tabulate(&superposition, &grid).into_iter().enumerate() {
                let place = grid.point_at(point);
                let distance = |charge: &ChargedSphere| (charge.centre - place).norm().max(1.0);
                let size = charges
                    .iter()
                    .map(|charge| charge.charge_e.abs() / distance(charge));
                let size = bjerrum * size.sum::<f64>();
                let error = (found - exact[point]).abs();
                assert!(error < 3e-6 * size, "{salt_molar} M: {error} {size}");
            }
        }
    }

    #[test]
    fn thin_grids_and_no_charges_are_no_trouble() {
        let saline = Electrolyte::in_water(298.15, 0.1).unwrap();
        let ion = ChargedSphere {
            centre: Vec3::new(0.3, 0.2, 0.1),
            radius_angstrom: 1.0,
            charge_e: 1.0,
        };
        for charges in [vec![], vec![ion]] {
            let superposition = Superposition::new(&charges, &DielectricModel::new(saline));
            let grid = Grid {
                origin_angstrom: [0.0; 3],
                spacing_angstrom: 0.5,
                shape: [1, 30, 2],
            };
            let exact = superposition.tabulate(grid).values;
            for (found, exact) in tabulate(&superposition, &grid).iter().zip(exact) {
                assert!((found - exact).abs() <= 1e-5 * exact, "{found} {exact}");
            }
        }
    }
}
