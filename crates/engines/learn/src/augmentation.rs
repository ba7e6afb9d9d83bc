//! The 24 rotations of the cube, exact on voxels: indices move, nothing is interpolated.
//!
//! Reflections are left out: they would turn a protein into its mirror image, which does not exist.

use crate::SparseGrid;

/// A rotation that maps the cube to itself: the coordinate a of the turned grid is ± the coordinate
/// `axes[a]` of the grid before.
///
/// ```
/// use protomer_learn::SparseGrid;
/// use protomer_learn::augmentation::CubeRotation;
///
/// let grid = SparseGrid { size: 2, channels: 1, index: vec![0], values: vec![1.0] };
/// let mut visits = [0; 8];
/// for turn in CubeRotation::all() {
///     visits[turn.sparse(&grid).index[0] as usize] += 1;
/// }
/// assert_eq!(visits, [3; 8], "each corner is reached by three rotations");
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CubeRotation {
    axes: [usize; 3],
    reversed: [bool; 3],
}

impl CubeRotation {
    /// Number of rotations that map the cube to itself.
    pub const COUNT: usize = 24;

    /// All rotations, the identity first.
    ///
    /// ```
    /// use protomer_learn::augmentation::CubeRotation;
    /// let turns = CubeRotation::all();
    /// assert_eq!(turns.len(), CubeRotation::COUNT);
    /// assert_eq!(turns[0].matrix(), [[1, 0, 0], [0, 1, 0], [0, 0, 1]]);
    /// ```
    pub fn all() -> Vec<Self> {
        const ORDERS: [[usize; 3]; 6] = [
            [0, 1, 2],
            [1, 2, 0],
            [2, 0, 1],
            [0, 2, 1],
            [1, 0, 2],
            [2, 1, 0],
        ];
        let mut proper = Vec::with_capacity(Self::COUNT);
        // All 48 signed permutations; half of them, with determinant -1, are reflections.
        for axes in ORDERS {
            for bits in 0..8_u8 {
                let reversed = [bits & 1 != 0, bits & 2 != 0, bits & 4 != 0];
                let turn = Self { axes, reversed };
                if turn.determinant() == 1 {
                    proper.push(turn);
                }
            }
        }
        proper
    }

    /// The matrix, rows for the coordinates (z, y, x) after the turn.
    pub fn matrix(&self) -> [[i32; 3]; 3] {
        let mut matrix = [[0; 3]; 3];
        for (row, (axis, reversed)) in matrix.iter_mut().zip(self.axes.iter().zip(self.reversed)) {
            row[*axis] = if reversed { -1 } else { 1 };
        }
        matrix
    }

    fn determinant(&self) -> i32 {
        let m = self.matrix();
        m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1])
            - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0])
            + m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0])
    }

    /// Index after the turn of the voxel with the index (z size + y) size + x before it.
    ///
    /// ```
    /// use protomer_learn::augmentation::CubeRotation;
    /// let turns = CubeRotation::all();
    /// assert_eq!(turns[0].voxel(4, 17), 17);
    /// // The middle of an odd grid stays where it is.
    /// assert!(turns.iter().all(|turn| turn.voxel(3, 13) == 13));
    /// ```
    pub fn voxel(&self, size: usize, voxel: usize) -> usize {
        // Coordinates z, y, x, as the index counts them.
        let before = [voxel / (size * size), voxel / size % size, voxel % size];
        let mut after = 0;
        for (axis, reversed) in self.axes.iter().zip(self.reversed) {
            let coordinate = if reversed {
                size - 1 - before[*axis]
            } else {
                before[*axis]
            };
            after = after * size + coordinate;
        }
        after
    }

    /// The grid turned, its voxels ascending again. The grid must pass [`SparseGrid::check`].
    ///
    /// ```
    /// use protomer_learn::SparseGrid;
    /// use protomer_learn::augmentation::CubeRotation;
    /// let grid = SparseGrid { size: 3, channels: 1, index: vec![0, 13], values: vec![2.0, 5.0] };
    /// let images: Vec<SparseGrid> = CubeRotation::all().iter().map(|turn| turn.sparse(&grid)).collect();
    /// assert_eq!(images[0], grid);
    /// // The middle stays, and the corner goes to another one.
    /// assert!(images.iter().all(|image| image.index.contains(&13) && image.check().is_ok()));
    /// ```
    pub fn sparse(&self, grid: &SparseGrid) -> SparseGrid {
        // Voxels after the turn, with their places before it.
        // The voxels must ascend again, and every channel is permuted in the same way: sort once.
        let mut order: Vec<(u32, usize)> = Vec::with_capacity(grid.index.len());
        for (place, voxel) in grid.index.iter().enumerate() {
            order.push((self.voxel(grid.size, *voxel as usize) as u32, place));
        }
        order.sort_unstable();
        let mut values = Vec::with_capacity(grid.values.len());
        for channel in grid.values.chunks_exact(grid.index.len().max(1)) {
            values.extend(order.iter().map(|(_, place)| channel[*place]));
        }
        SparseGrid {
            size: grid.size,
            channels: grid.channels,
            index: order.into_iter().map(|(voxel, _)| voxel).collect(),
            values,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn product(a: [[i32; 3]; 3], b: [[i32; 3]; 3]) -> [[i32; 3]; 3] {
        let mut product = [[0; 3]; 3];
        for (row, out) in product.iter_mut().enumerate() {
            for (column, out) in out.iter_mut().enumerate() {
                *out = (0..3).map(|k| a[row][k] * b[k][column]).sum();
            }
        }
        product
    }

    /// A grid of two channels in which no two voxels are alike.
    fn grid(size: usize) -> SparseGrid {
        let index: Vec<u32> = (0..size.pow(3) as u32)
            .filter(|voxel| voxel % 3 != 1)
            .collect();
        let values = (0..2 * index.len())
            .map(|value| value as f32 + 0.5)
            .collect();
        SparseGrid {
            size,
            channels: 2,
            index,
            values,
        }
    }

    #[test]
    fn they_are_a_group_of_proper_rotations() {
        let all = CubeRotation::all();
        assert_eq!(all.len(), CubeRotation::COUNT);
        let matrices: Vec<_> = all.iter().map(CubeRotation::matrix).collect();
        assert_eq!(matrices[0], [[1, 0, 0], [0, 1, 0], [0, 0, 1]]);
        for a in &all {
            assert_eq!(a.determinant(), 1);
            for b in &all {
                let c = product(a.matrix(), b.matrix());
                let c = all[matrices.iter().position(|matrix| *matrix == c).unwrap()];
                // The voxels compose as the matrices do.
                assert!((0..27).all(|voxel| a.voxel(3, b.voxel(3, voxel)) == c.voxel(3, voxel)));
            }
        }
    }

    #[test]
    fn no_two_agree_on_an_asymmetric_grid() {
        let grid = grid(4);
        let turned: Vec<_> = CubeRotation::all()
            .iter()
            .map(|turn| turn.sparse(&grid))
            .collect();
        for (place, first) in turned.iter().enumerate() {
            first.check().unwrap();
            assert!(turned[..place].iter().all(|second| second != first));
        }
    }

    #[test]
    fn the_matrix_says_where_voxels_go() {
        // Coordinates from the centre, doubled to stay integers.
        for size in [3_i32, 4] {
            let centred = |voxel: i32| {
                [voxel / (size * size), voxel / size % size, voxel % size]
                    .map(|place| 2 * place - (size - 1))
            };
            for turn in CubeRotation::all() {
                for voxel in 0..size.pow(3) {
                    let (before, m) = (centred(voxel), turn.matrix());
                    let expected = m.map(|row| (0..3).map(|k| row[k] * before[k]).sum::<i32>());
                    assert_eq!(
                        centred(turn.voxel(size as usize, voxel as usize) as i32),
                        expected
                    );
                }
            }
        }
    }

    /// The obvious way to turn a grid: every voxel of every channel moves.
    fn turn_dense(turn: &CubeRotation, size: usize, grid: &[f32]) -> Vec<f32> {
        let voxels = size.pow(3);
        let mut turned = vec![0.0; grid.len()];
        for (place, value) in grid.iter().enumerate() {
            let channel = place / voxels;
            turned[channel * voxels + turn.voxel(size, place % voxels)] = *value;
        }
        turned
    }

    #[test]
    fn sparse_and_dense_grids_turn_alike() {
        let grid = grid(5);
        let mut before = vec![0.0; 250];
        grid.write_dense(&mut before).unwrap();
        for turn in CubeRotation::all() {
            let mut turned = vec![0.0; 250];
            turn.sparse(&grid).write_dense(&mut turned).unwrap();
            assert_eq!(turned, turn_dense(&turn, 5, &before));
        }
    }

    #[test]
    fn an_empty_grid_stays_empty() {
        let grid = SparseGrid {
            size: 4,
            channels: 2,
            ..SparseGrid::default()
        };
        assert_eq!(CubeRotation::all()[7].sparse(&grid), grid);
    }
}
