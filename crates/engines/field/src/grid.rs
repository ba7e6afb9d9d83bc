//! Points in space, and values between them.

use crate::{FieldError, Result};
use protomer_kernel::Vec3;
use rayon::prelude::*;
use serde::Serialize;
use std::ops::Range;

/// The largest number of points: no machine holds more, and up to here no product overflows.
const MOST_POINTS: f64 = 1e13;

/// A regular grid of points. Values on it are stored with x running fastest, then y, then z.
///
/// ```
/// use protomer_field::Grid;
/// use protomer_kernel::Vec3;
/// let grid = Grid::around(&Vec3::zeros(), &Vec3::new(1.0, 2.0, 3.0), 0.5, 1)?;
/// assert_eq!(grid.shape, [3, 5, 7]);
/// assert_eq!(grid.point(1, 0, 2), Vec3::new(0.5, 0.0, 1.0));
/// # Ok::<(), protomer_field::FieldError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Grid {
    /// The lowest corner, Å.
    pub origin_angstrom: [f64; 3],
    /// Distance between neighbouring points, Å.
    pub spacing_angstrom: f64,
    /// Points along x, y and z.
    pub shape: [usize; 3],
}

impl Grid {
    /// The smallest grid of this spacing that holds a box (lowest and highest corner, Å) and has
    /// `multiple` · n + 1 points along each axis, centred on the box.
    ///
    /// ```
    /// use protomer_field::Grid;
    /// use protomer_kernel::Vec3;
    /// let grid = Grid::around(&Vec3::zeros(), &Vec3::repeat(3.0), 1.0, 4)?;
    /// assert_eq!(grid.shape, [5; 3], "the next multiple of four cells");
    /// assert_eq!(grid.origin_angstrom, [-0.5; 3]);
    /// # Ok::<(), protomer_field::FieldError>(())
    /// ```
    ///
    /// # Errors
    /// [`FieldError::BadSetting`] for a spacing that is not positive, [`FieldError::BadInput`] for
    /// more points than any machine holds.
    pub fn around(low: &Vec3, high: &Vec3, spacing_angstrom: f64, multiple: usize) -> Result<Self> {
        if !(spacing_angstrom.is_finite() && spacing_angstrom > 0.0) {
            return Err(FieldError::BadSetting {
                setting: "spacing",
                value: spacing_angstrom,
                requirement: "positive, Å",
            });
        }
        let extent = high - low;
        let points = (extent / spacing_angstrom).add_scalar(1.0).product();
        if points.is_nan() || points > MOST_POINTS {
            return Err(FieldError::BadInput(format!(
                "a box of {:.0} x {:.0} x {:.0} Å at a spacing of {spacing_angstrom} Å has \
                 {points:.1e} points: look for atoms far from the others, or use a larger spacing",
                extent.x, extent.y, extent.z
            )));
        }
        let middle = 0.5 * (low + high);
        let mut shape = [0; 3];
        let mut origin_angstrom = [0.0; 3];
        for axis in 0..3 {
            // Rounding must not add a whole multiple of cells to a box that fits exactly.
            let needed = (extent[axis] / spacing_angstrom - 1e-9).ceil().max(1.0) as usize;
            let cells = needed.div_ceil(multiple) * multiple;
            shape[axis] = cells + 1;
            origin_angstrom[axis] = middle[axis] - 0.5 * cells as f64 * spacing_angstrom;
        }
        Ok(Self {
            origin_angstrom,
            spacing_angstrom,
            shape,
        })
    }

    /// Points of the same spacing at whole multiples of it, one in each cell of this grid.
    ///
    /// ```
    /// use protomer_field::Grid;
    /// let grid = Grid { origin_angstrom: [-0.7, 0.2, 1.0], spacing_angstrom: 0.5, shape: [5, 4, 3] };
    /// let multiples = grid.on_multiples();
    /// assert_eq!(multiples.origin_angstrom, [-0.5, 0.5, 1.0]);
    /// assert_eq!(multiples.shape, [4, 3, 2]);
    /// ```
    pub fn on_multiples(&self) -> Self {
        let h = self.spacing_angstrom;
        Self {
            origin_angstrom: self.origin_angstrom.map(|origin| (origin / h).ceil() * h),
            spacing_angstrom: h,
            shape: self.shape.map(|points| points - 1),
        }
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.shape.iter().product()
    }

    /// Whether there are no points.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Index of the value of point (i, j, k) in a list of values.
    ///
    /// ```
    /// use protomer_field::Grid;
    /// let grid = Grid { origin_angstrom: [0.0; 3], spacing_angstrom: 1.0, shape: [4, 3, 2] };
    /// assert_eq!(grid.len(), 24);
    /// assert_eq!(grid.index(1, 2, 1), 1 + 4 * 2 + 12);
    /// assert_eq!(grid.strides(), [1, 4, 12]);
    /// ```
    #[inline]
    pub fn index(&self, i: usize, j: usize, k: usize) -> usize {
        (k * self.shape[1] + j) * self.shape[0] + i
    }

    /// The place of point (i, j, k), Å.
    ///
    /// ```
    /// use protomer_field::Grid;
    /// use protomer_kernel::Vec3;
    /// let grid = Grid { origin_angstrom: [-1.0; 3], spacing_angstrom: 0.5, shape: [5; 3] };
    /// assert_eq!(grid.point(0, 2, 4), Vec3::new(-1.0, 0.0, 1.0));
    /// ```
    #[inline]
    pub fn point(&self, i: usize, j: usize, k: usize) -> Vec3 {
        let h = self.spacing_angstrom;
        let o = &self.origin_angstrom;
        Vec3::new(
            o[0] + h * i as f64,
            o[1] + h * j as f64,
            o[2] + h * k as f64,
        )
    }

    /// The place of the point whose value is at this index, Å.
    #[inline]
    pub(crate) fn point_at(&self, index: usize) -> Vec3 {
        let [i, j, k] = self.coordinates(index);
        self.point(i, j, k)
    }

    /// The point (i, j, k) whose value is at this index.
    #[inline]
    pub(crate) fn coordinates(&self, index: usize) -> [usize; 3] {
        let [nx, ny, _] = self.shape;
        [index % nx, index / nx % ny, index / (nx * ny)]
    }

    /// All points, in blocks of at most `edge` points along each axis.
    pub(crate) fn blocks(&self, edge: usize) -> Vec<Block> {
        let [nx, ny, nz] = self.shape;
        let mut blocks = Vec::new();
        for k in (0..nz).step_by(edge) {
            for j in (0..ny).step_by(edge) {
                for i in (0..nx).step_by(edge) {
                    let end = [(i + edge).min(nx), (j + edge).min(ny), (k + edge).min(nz)];
                    blocks.push(Block {
                        first: [i, j, k],
                        end,
                    });
                }
            }
        }
        blocks
    }

    /// The distance between neighbours along each axis in a list of values.
    pub fn strides(&self) -> [usize; 3] {
        [1, self.shape[0], self.shape[0] * self.shape[1]]
    }

    /// The cell that a place lies in, and where in it, (0..1)³; `None` outside the grid.
    ///
    /// ```
    /// use protomer_field::Grid;
    /// use protomer_kernel::Vec3;
    /// let grid = Grid { origin_angstrom: [0.0; 3], spacing_angstrom: 2.0, shape: [3; 3] };
    /// assert_eq!(grid.locate(&Vec3::new(1.0, 3.5, 4.0)), Some(([0, 1, 1], [0.5, 0.75, 1.0])));
    /// assert_eq!(grid.locate(&Vec3::repeat(4.1)), None);
    /// ```
    pub fn locate(&self, place: &Vec3) -> Option<([usize; 3], [f64; 3])> {
        let mut cell = [0; 3];
        let mut part = [0.0; 3];
        for axis in 0..3 {
            let t = (place[axis] - self.origin_angstrom[axis]) / self.spacing_angstrom;
            let last = self.shape[axis] - 1;
            if t.is_nan() || t < 0.0 || t > last as f64 {
                return None;
            }
            // A place on the last point belongs to the last cell, with part 1.
            cell[axis] = (t as usize).min(last - 1);
            part[axis] = t - cell[axis] as f64;
        }
        Some((cell, part))
    }

    /// Trilinear interpolation at a place: the eight corners of its cell. `None` outside the grid.
    pub(crate) fn trilinear(&self, place: &Vec3) -> Option<Stencil<8>> {
        let (cell, part) = self.locate(place)?;
        Some(self.corners(cell, part))
    }

    /// Trilinear interpolation in a cell.
    pub(crate) fn corners(&self, cell: [usize; 3], part: [f64; 3]) -> Stencil<8> {
        self.stencil(cell, part.map(|t| [1.0 - t, t]))
    }

    /// Interpolation in a cell by cubic polynomials through four points along each axis. `None`
    /// where the cell lies at the edge of the grid.
    pub(crate) fn tricubic(&self, cell: [usize; 3], part: [f64; 3]) -> Option<Stencil<64>> {
        for (axis, first) in cell.iter().enumerate() {
            // A cubic needs one point more on either side.
            if *first == 0 || first + 2 >= self.shape[axis] {
                return None;
            }
        }
        let first = cell.map(|index| index - 1);
        Some(self.stencil(first, part.map(lagrange_weights)))
    }

    /// The points of a block of M³ = N points and the products of their weights along the axes.
    fn stencil<const M: usize, const N: usize>(
        &self,
        first: [usize; 3],
        [x, y, z]: [[f64; M]; 3],
    ) -> Stencil<N> {
        let [i, j, k] = first;
        let mut points = [0; N];
        let mut weights = [0.0; N];
        // n = di + M (dj + M dk), x fastest as in the values.
        for n in 0..N {
            let (di, dj, dk) = (n % M, n / M % M, n / (M * M));
            points[n] = self.index(i + di, j + dj, k + dk);
            weights[n] = x[di] * y[dj] * z[dk];
        }
        Stencil { points, weights }
    }
}

/// Points of a grid that lie together.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Block {
    first: [usize; 3],
    /// One past the last point along each axis.
    end: [usize; 3],
}

impl Block {
    /// Ranges of the values of each row of points along x.
    pub fn rows(&self, grid: &Grid) -> impl Iterator<Item = Range<usize>> + use<> {
        let (Self { first, end }, grid) = (*self, *grid);
        let length = end[0].saturating_sub(first[0]);
        let rows = (first[2]..end[2]).flat_map(move |k| (first[1]..end[1]).map(move |j| (j, k)));
        rows.map(move |(j, k)| {
            let start = grid.index(first[0], j, k);
            start..start + length
        })
    }

    /// The points that are not on a face of the grid.
    pub fn without_faces(&self, grid: &Grid) -> Self {
        Self {
            first: self.first.map(|index| index.max(1)),
            end: [0, 1, 2].map(|axis| self.end[axis].min(grid.shape[axis] - 1)),
        }
    }

    /// The lowest and the highest corner of the box between the points and those that follow, Å.
    pub fn corners(&self, grid: &Grid) -> (Vec3, Vec3) {
        let ([i, j, k], [next_i, next_j, next_k]) = (self.first, self.end);
        (grid.point(i, j, k), grid.point(next_i, next_j, next_k))
    }
}

/// Weights at t of Lagrange's polynomials through points at -1, 0, 1, 2.
fn lagrange_weights(t: f64) -> [f64; 4] {
    [
        -t * (t - 1.0) * (t - 2.0) / 6.0,
        (t + 1.0) * (t - 1.0) * (t - 2.0) / 2.0,
        -(t + 1.0) * t * (t - 2.0) / 2.0,
        (t + 1.0) * t * (t - 1.0) / 6.0,
    ]
}

/// Points of a grid around a place, and the weight of each in the value there.
pub(crate) struct Stencil<const N: usize> {
    pub(crate) points: [usize; N],
    weights: [f64; N],
}

impl<const N: usize> Stencil<N> {
    /// The points with their weights.
    pub(crate) fn weighted(&self) -> impl Iterator<Item = (usize, f64)> + '_ {
        self.points.iter().copied().zip(self.weights)
    }

    /// The weighted sum of values at the points. Points without weight are not evaluated.
    pub(crate) fn interpolate(&self, value_at: impl Fn(usize) -> f64) -> f64 {
        let mut sum = 0.0;
        for (point, weight) in self.points.iter().zip(self.weights) {
            // A weight of zero may stand at a point outside, where values have no meaning.
            if weight != 0.0 {
                sum += weight * value_at(*point);
            }
        }
        sum
    }
}

/// Calls `set` with the coordinates and the value of every point of a grid of this shape, planes in
/// parallel.
pub(crate) fn set_points<T: Send>(
    shape: [usize; 3],
    values: &mut [T],
    set: impl Fn([usize; 3], &mut T) + Sync,
) {
    let [nx, ny, _] = shape;
    // A plane per task: large enough to pay, many enough to spread.
    let set_plane = |(k, plane): (usize, &mut [T])| {
        for (j, row) in plane.chunks_mut(nx).enumerate() {
            for (i, value) in row.iter_mut().enumerate() {
                set([i, j, k], value);
            }
        }
    };
    values
        .par_chunks_mut(nx * ny)
        .enumerate()
        .for_each(set_plane);
}

/// Values on a grid.
///
/// ```
/// use protomer_field::{Grid, ScalarField};
/// let grid = Grid { origin_angstrom: [0.0; 3], spacing_angstrom: 1.0, shape: [2, 2, 2] };
/// let field = ScalarField { grid, values: (0..8).map(f64::from).collect() };
/// assert_eq!(field.values[grid.index(1, 0, 1)], 5.0);
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct ScalarField {
    /// The points.
    pub grid: Grid,
    /// The value at each point, x fastest.
    pub values: Vec<f64>,
}

impl ScalarField {
    /// The value at a place by trilinear interpolation; `None` outside the grid.
    ///
    /// ```
    /// use protomer_field::{Grid, ScalarField};
    /// use protomer_kernel::Vec3;
    /// let grid = Grid { origin_angstrom: [0.0; 3], spacing_angstrom: 1.0, shape: [2, 2, 2] };
    /// let field = ScalarField { grid, values: vec![0.0, 1.0, 0.0, 1.0, 0.0, 1.0, 0.0, 1.0] };
    /// assert_eq!(field.value_at(&Vec3::new(0.25, 0.5, 0.5)), Some(0.25));
    /// assert_eq!(field.value_at(&Vec3::new(1.5, 0.5, 0.5)), None);
    /// ```
    pub fn value_at(&self, place: &Vec3) -> Option<f64> {
        let corners = self.grid.trilinear(place)?;
        Some(corners.interpolate(|point| self.values[point]))
    }
}
