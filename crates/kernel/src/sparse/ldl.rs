//! Factorisation and solution.

use super::front::{self, BLOCK, LANES};
use super::symbolic::{Front, Symbolic};

/// What stops a factorisation.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SparseError {
    /// A pivot that is not safely positive: the row depends on others.
    #[error("row {row} depends linearly on other rows (pivot {pivot:e})")]
    Dependent {
        /// The row, in the caller's numbering.
        row: usize,
        /// The pivot, relative to the diagonal entry.
        pivot: f64,
    },
    /// A number that is not finite.
    #[error("row {row} has an entry that is not finite")]
    NotFinite {
        /// The row, in the caller's numbering.
        row: usize,
    },
}

/// L D Lᵀ of a symmetric positive definite matrix with a fixed pattern, by the multifrontal method
/// with supernodes (Duff and Reid, ACM Trans. Math. Softw. 9, 302 (1983)).
///
/// Results are the same on every processor, and do not depend on what was factored before.
///
/// ```
/// use protomer_kernel::sparse::LdlFactor;
/// // 4 x + y = 6, x + 3 y = 7
/// let mut factor = LdlFactor::new(2, &[(0, 0), (1, 0), (1, 1)], &[[0.0; 3]; 2]);
/// factor.factor(&[4.0, 1.0, 3.0])?;
/// let mut x = [6.0, 7.0];
/// factor.solve(&mut x);
/// assert!((x[0] - 1.0).abs() < 1e-15 && (x[1] - 2.0).abs() < 1e-15);
/// # Ok::<(), protomer_kernel::sparse::SparseError>(())
/// ```
#[derive(Debug, Clone)]
pub struct LdlFactor {
    symbolic: Symbolic,
    numbers: Numbers,
}

#[derive(Debug, Clone)]
struct Numbers {
    /// The tiles of all fronts.
    values: Vec<f64>,
    pivots: Vec<f64>,
    inverse: Vec<f64>,
    /// What fronts leave for their parents.
    left: Vec<f64>,
    packed: Vec<[f64; BLOCK]>,
    /// A right-hand side in the order of elimination, and what of it a front sees.
    permuted: Vec<f64>,
    seen: Vec<[f64; LANES]>,
    sums: Vec<[f64; LANES]>,
}

impl LdlFactor {
    /// Prepares for matrices of this dimension with entries at these places of the lower triangle
    /// (row ≥ column), each place once, every diagonal place among them. `places` says where each
    /// unknown is, for the order of elimination.
    pub fn new(dimension: usize, entries: &[(usize, usize)], places: &[[f64; 3]]) -> Self {
        let symbolic = Symbolic::new(dimension, entries, places);
        let numbers = Numbers {
            values: vec![0.0; symbolic.values_size],
            pivots: vec![0.0; dimension],
            inverse: vec![0.0; dimension],
            left: vec![0.0; symbolic.left_size],
            packed: Vec::new(),
            permuted: vec![0.0; dimension],
            seen: vec![[0.0; LANES]; symbolic.tallest],
            sums: Vec::new(),
        };
        Self { symbolic, numbers }
    }

    /// Number of unknowns.
    pub fn dimension(&self) -> usize {
        self.symbolic.order.len()
    }

    /// Entries of L below its diagonal, with the zeros that fronts hold.
    pub fn fill(&self) -> usize {
        let below = |front: &Front| {
            let (k, m) = (front.shape.columns, front.shape.height);
            k * (m - k) + k * (k - 1) / 2
        };
        self.symbolic.fronts.iter().map(below).sum()
    }

    /// Multiplications (each with an addition) of one factorisation.
    pub fn multiplications(&self) -> f64 {
        let of_column = |below: usize| below as f64 * (below as f64 + 1.0) / 2.0;
        let of_front = |front: &Front| {
            (1..=front.shape.columns)
                .map(|j| of_column(front.shape.height - j))
                .sum::<f64>()
        };
        self.symbolic.fronts.iter().map(of_front).sum()
    }

    /// Number of fronts.
    pub fn fronts(&self) -> usize {
        self.symbolic.fronts.len()
    }

    /// Factors the matrix with these numbers, in the order of the entries given at the start.
    ///
    /// # Errors
    /// [`SparseError::Dependent`] names the row whose pivot vanishes; [`SparseError::NotFinite`] a
    /// row with a number that is not finite. The factor must not be used then.
    pub fn factor(&mut self, numbers: &[f64]) -> Result<(), SparseError> {
        let result = factor(&self.symbolic, &mut self.numbers, numbers);
        result.map_err(|(step, pivot, own)| {
            let row = self.symbolic.order[step] as usize;
            if pivot.is_finite() && own.is_finite() {
                SparseError::Dependent {
                    row,
                    pivot: pivot / own,
                }
            } else {
                SparseError::NotFinite { row }
            }
        })
    }

    /// Replaces b by the solution x of the last matrix factored.
    pub fn solve(&mut self, b: &mut [f64]) {
        solve(&self.symbolic, &mut self.numbers, b);
    }

    /// ln det A of the last matrix factored.
    pub fn log_determinant(&self) -> f64 {
        self.numbers.pivots.iter().map(|pivot| pivot.ln()).sum()
    }
}

/// The step of elimination, its pivot and the diagonal entry it began as.
type BadPivot = (usize, f64, f64);

fn factor(symbolic: &Symbolic, work: &mut Numbers, numbers: &[f64]) -> Result<(), BadPivot> {
    #[cfg(target_arch = "x86_64")]
    {
        if is_x86_feature_detected!("avx512f") && is_x86_feature_detected!("avx512dq") {
            // SAFETY: the processor has the two features the function is compiled for.
            return unsafe { factor_avx512(symbolic, work, numbers) };
        }
        if is_x86_feature_detected!("avx2") {
            // SAFETY: the processor has the feature the function is compiled for.
            return unsafe { factor_avx2(symbolic, work, numbers) };
        }
    }
    factor_fronts(symbolic, work, numbers)
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512dq")]
fn factor_avx512(symbolic: &Symbolic, work: &mut Numbers, numbers: &[f64]) -> Result<(), BadPivot> {
    factor_fronts(symbolic, work, numbers)
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn factor_avx2(symbolic: &Symbolic, work: &mut Numbers, numbers: &[f64]) -> Result<(), BadPivot> {
    factor_fronts(symbolic, work, numbers)
}

fn solve(symbolic: &Symbolic, work: &mut Numbers, b: &mut [f64]) {
    #[cfg(target_arch = "x86_64")]
    {
        if is_x86_feature_detected!("avx512f") && is_x86_feature_detected!("avx512dq") {
            // SAFETY: the processor has the two features the function is compiled for.
            return unsafe { solve_avx512(symbolic, work, b) };
        }
        if is_x86_feature_detected!("avx2") {
            // SAFETY: the processor has the feature the function is compiled for.
            return unsafe { solve_avx2(symbolic, work, b) };
        }
    }
    solve_fronts(symbolic, work, b);
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512dq")]
fn solve_avx512(symbolic: &Symbolic, work: &mut Numbers, b: &mut [f64]) {
    solve_fronts(symbolic, work, b);
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn solve_avx2(symbolic: &Symbolic, work: &mut Numbers, b: &mut [f64]) {
    solve_fronts(symbolic, work, b);
}

/// Front by front: entries of A and what the children left, then the front's own columns, then what
/// it leaves.
#[inline(always)]
fn factor_fronts(symbolic: &Symbolic, work: &mut Numbers, numbers: &[f64]) -> Result<(), BadPivot> {
    let Numbers {
        values,
        pivots,
        inverse,
        left,
        packed,
        ..
    } = work;
    for front in &symbolic.fronts {
        let shape = front.shape;
        let panel = &mut values[front.values..front.values + shape.panel_size()];
        panel.fill(0.0);
        for &(entry, at) in &symbolic.assembly[front.assembly.0..front.assembly.1] {
            panel[at as usize] = numbers[entry as usize];
        }
        let children = &symbolic.children[front.children.0..front.children.1];
        for child in children {
            add_to_panel(
                symbolic,
                &symbolic.fronts[*child as usize],
                shape.columns,
                left,
                panel,
            );
        }
        let own_columns = front.first..front.first + shape.columns;
        let own = |column: usize| numbers[symbolic.diagonal[front.first + column] as usize];
        let (pivots, inverse) = (&mut pivots[own_columns.clone()], &mut inverse[own_columns]);
        front::factor_panel(panel, shape, own, pivots, inverse, packed)
            .map_err(|(column, pivot)| (front.first + column, pivot, own(column)))?;
        if shape.height > shape.columns {
            let own_left = &mut left[front.left..front.left + shape.left_size()];
            front::start_left(panel, shape, pivots, own_left, packed);
            for child in children {
                add_to_left(symbolic, &symbolic.fronts[*child as usize], front, left);
            }
        }
        front::invert_triangles(panel, shape);
    }
    Ok(())
}

/// The rows of a child that are the parent's own: what the child left there goes to the parent's
/// tiles.
#[inline(always)]
fn add_to_panel(
    symbolic: &Symbolic,
    child: &Front,
    columns: usize,
    left: &[f64],
    panel: &mut [f64],
) {
    let shape = child.shape;
    let seats = &symbolic.seats[child.rows..child.rows + shape.height - shape.columns];
    let (stride, skip) = (shape.left_stride(), shape.columns % LANES);
    let left = &left[child.left..child.left + shape.left_size()];
    for (at, (seat, column)) in seats.iter().zip(left.chunks_exact(stride)).enumerate() {
        let target = seat.row as usize;
        if target >= columns {
            break;
        }
        for (seat, value) in seats[at..].iter().zip(&column[skip + at..]) {
            panel[seat.tile as usize + LANES * target] += value;
        }
    }
}

/// The other rows of a child: what it left there goes to what the parent leaves.
#[inline(always)]
fn add_to_left(symbolic: &Symbolic, child: &Front, parent: &Front, left: &mut [f64]) {
    let shape = child.shape;
    let seats = &symbolic.seats[child.rows..child.rows + shape.height - shape.columns];
    let (stride, skip) = (shape.left_stride(), shape.columns % LANES);
    let columns = parent.shape.columns;
    let (parent_stride, base) = (
        parent.shape.left_stride(),
        LANES * parent.shape.first_left_tile(),
    );
    let begin = seats.partition_point(|seat| (seat.row as usize) < columns);
    let (source, target) = if child.left < parent.left {
        let (low, high) = left.split_at_mut(parent.left);
        (&low[child.left..child.left + shape.left_size()], high)
    } else {
        let (low, high) = left.split_at_mut(child.left);
        (&high[..shape.left_size()], &mut low[parent.left..])
    };
    for at in begin..seats.len() {
        let column = &source[at * stride..(at + 1) * stride];
        let target =
            &mut target[(seats[at].row as usize - columns) * parent_stride..][..parent_stride];
        for (seat, value) in seats[at..].iter().zip(&column[skip + at..]) {
            target[seat.row as usize - base] += value;
        }
    }
}

#[inline(always)]
fn solve_fronts(symbolic: &Symbolic, work: &mut Numbers, b: &mut [f64]) {
    let Numbers {
        values,
        inverse,
        permuted: x,
        seen,
        sums,
        ..
    } = work;
    for (target, unknown) in x.iter_mut().zip(&symbolic.order) {
        *target = b[*unknown as usize];
    }
    for front in &symbolic.fronts {
        let shape = front.shape;
        let panel = &values[front.values..front.values + shape.panel_size()];
        let seen = &mut seen[..shape.tiles()];
        let flat = seen.as_flattened_mut();
        let own = &mut x[front.first..front.first + shape.columns];
        flat[..shape.columns].copy_from_slice(own);
        flat[shape.columns..].fill(0.0);
        front::solve_forward(panel, shape, seen);
        let flat = seen.as_flattened();
        own.copy_from_slice(&flat[..shape.columns]);
        let rows = &symbolic.rows[front.rows..front.rows + shape.height - shape.columns];
        for (row, value) in rows.iter().zip(&flat[shape.columns..]) {
            x[*row as usize] += value;
        }
    }
    for (x, inverse) in x.iter_mut().zip(inverse.iter()) {
        *x *= inverse;
    }
    for front in symbolic.fronts.iter().rev() {
        let shape = front.shape;
        let panel = &values[front.values..front.values + shape.panel_size()];
        let seen = &mut seen[..shape.tiles()];
        let flat = seen.as_flattened_mut();
        flat[..shape.columns].copy_from_slice(&x[front.first..front.first + shape.columns]);
        let rows = &symbolic.rows[front.rows..front.rows + shape.height - shape.columns];
        for (row, value) in rows.iter().zip(&mut flat[shape.columns..]) {
            *value = x[*row as usize];
        }
        flat[shape.height..].fill(0.0);
        front::solve_backward(panel, shape, seen, sums);
        x[front.first..front.first + shape.columns]
            .copy_from_slice(&seen.as_flattened()[..shape.columns]);
    }
    for (value, unknown) in x.iter().zip(&symbolic.order) {
        b[*unknown as usize] = *value;
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::super::up_looking::UpLooking;
    use super::*;
    use crate::random::CounterRng;
    use nalgebra::{DMatrix, DVector};

    #[test]
    fn solutions_are_those_of_dense_elimination() {
        let mut rng = CounterRng::new(5, 0, 0);
        for dimension in [1, 2, 7, 30, 90] {
            let places: Vec<[f64; 3]> = (0..dimension)
                .map(|_| rng.vector_in_ball(1.0).into())
                .collect();
            let mut entries: Vec<(usize, usize)> = (0..dimension).map(|i| (i, i)).collect();
            for row in 1..dimension {
                for column in 0..row {
                    if rng.uniform_in(0.0, 1.0) < 4.0 / dimension as f64 {
                        entries.push((row, column));
                    }
                }
            }
            let mut factor = LdlFactor::new(dimension, &entries, &places);
            // The same pattern with other numbers, twice.
            for _ in 0..2 {
                let numbers: Vec<f64> = entries
                    .iter()
                    .map(|(i, j)| {
                        if i == j {
                            12.0 + rng.uniform_in(0.0, 1.0)
                        } else {
                            rng.uniform_in(-1.0, 1.0)
                        }
                    })
                    .collect();
                let mut dense = DMatrix::zeros(dimension, dimension);
                for (&(i, j), number) in entries.iter().zip(&numbers) {
                    dense[(i, j)] = *number;
                    dense[(j, i)] = *number;
                }
                let b = DVector::from_fn(dimension, |_, _| rng.uniform_in(-1.0, 1.0));
                let mut x = b.as_slice().to_vec();
                factor.factor(&numbers).unwrap();
                factor.solve(&mut x);
                let residual = &dense * DVector::from_vec(x) - &b;
                assert!(residual.amax() < 1e-13, "{dimension}: {}", residual.amax());
                assert!((factor.log_determinant() - dense.determinant().ln()).abs() < 1e-9);
            }
        }
    }

    /// Nodes on a grid with `unknowns` each, coupled to their neighbours in all directions, around
    /// the edges along x.
    fn grid(size: [usize; 3], unknowns: usize) -> (Vec<(usize, usize)>, Vec<[f64; 3]>) {
        let node = |i: usize, j: usize, k: usize| (i * size[1] + j) * size[2] + k;
        let (mut entries, mut places) = (Vec::new(), Vec::new());
        for (i, j, k) in cells(size) {
            let here = node(i, j, k);
            let around = node((i + 1) % size[0], j, k);
            let mut others = vec![here, around];
            if j + 1 < size[1] {
                others.extend([node(i, j + 1, k), node((i + 1) % size[0], j + 1, k)]);
            }
            if k + 1 < size[2] {
                others.push(node(i, j, k + 1));
            }
            for other in others {
                for a in 0..unknowns {
                    for b in 0..unknowns {
                        let (row, column) = (unknowns * here + a, unknowns * other + b);
                        entries.push((row.max(column), row.min(column)));
                    }
                }
            }
            places.extend(vec![[i as f64, j as f64, k as f64]; unknowns]);
        }
        entries.sort_unstable();
        entries.dedup();
        (entries, places)
    }

    fn cells(size: [usize; 3]) -> impl Iterator<Item = (usize, usize, usize)> {
        (0..size[0] * size[1] * size[2]).map(move |index| {
            (
                index / (size[1] * size[2]),
                index / size[2] % size[1],
                index % size[2],
            )
        })
    }

    #[test]
    fn planar_and_spatial_networks_are_solved_as_row_by_row() {
        let mut rng = CounterRng::new(6, 0, 0);
        for (size, unknowns) in [
            ([3, 1, 1], 1),
            ([23, 17, 1], 1),
            ([30, 41, 1], 2),
            ([7, 8, 9], 3),
            ([500, 1, 1], 3),
        ] {
            let (entries, places) = grid(size, unknowns);
            let dimension = places.len();
            let mut factor = LdlFactor::new(dimension, &entries, &places);
            let mut twin = UpLooking::new(dimension, &entries, &places);
            assert!(
                factor.fill() >= twin.fill()
                    && factor.multiplications() > 0.0
                    && factor.fronts() <= dimension
            );
            // A sum of squares of differences, weakly held in place: the smallest eigenvalues are
            // near 0.01.
            let mut numbers = vec![0.0; entries.len()];
            let mut own = vec![0.01; dimension];
            for (&(row, column), number) in entries
                .iter()
                .zip(&mut numbers)
                .filter(|((row, column), _)| row != column)
            {
                let stiffness = rng.uniform_in(0.0, 1.0);
                *number = -stiffness;
                own[row] += stiffness;
                own[column] += stiffness;
            }
            for (&(row, column), number) in entries.iter().zip(&mut numbers) {
                if row == column {
                    *number = own[row];
                }
            }
            factor.factor(&numbers).unwrap();
            twin.factor(&numbers).unwrap();
            let b: Vec<f64> = (0..dimension).map(|_| rng.uniform_in(-1.0, 1.0)).collect();
            let (mut x, mut y) = (b.clone(), b.clone());
            factor.solve(&mut x);
            twin.solve(&mut y);
            let largest = y.iter().fold(0.0_f64, |largest, y| largest.max(y.abs()));
            let worst = x
                .iter()
                .zip(&y)
                .map(|(x, y)| (x - y).abs())
                .fold(0.0, f64::max);
            assert!(worst < 1e-12 * largest, "{size:?}: {worst} of {largest}");
            let (found, expected) = (factor.log_determinant(), twin.log_determinant());
            assert!(
                (found - expected).abs() < 1e-13 * dimension as f64,
                "{size:?}: {found} {expected}"
            );
            // The same bits again, whatever was factored in between.
            let other: Vec<f64> = numbers.iter().map(|number| 2.0 * number).collect();
            factor.factor(&other).unwrap();
            factor.factor(&numbers).unwrap();
            let mut again = b.clone();
            factor.solve(&mut again);
            assert_eq!(again, x);
        }
    }

    #[test]
    fn every_instruction_set_gives_the_same_bits() {
        let (entries, places) = grid([19, 14, 1], 2);
        let mut rng = CounterRng::new(7, 0, 0);
        let numbers: Vec<f64> = entries
            .iter()
            .map(|(row, column)| {
                if row == column {
                    25.0
                } else {
                    rng.uniform_in(-1.0, 1.0)
                }
            })
            .collect();
        let mut factor = LdlFactor::new(places.len(), &entries, &places);
        factor.factor(&numbers).unwrap();
        let mut x: Vec<f64> = (0..places.len())
            .map(|_| rng.uniform_in(-1.0, 1.0))
            .collect();
        let mut portable = x.clone();
        factor.solve(&mut x);
        factor_fronts(&factor.symbolic, &mut factor.numbers, &numbers).unwrap();
        solve_fronts(&factor.symbolic, &mut factor.numbers, &mut portable);
        assert_eq!(x, portable);
    }

    #[test]
    fn a_dependent_row_is_named() {
        let mut factor = LdlFactor::new(2, &[(0, 0), (1, 0), (1, 1)], &[[0.0; 3]; 2]);
        let error = factor.factor(&[1.0, 2.0, 4.0]).unwrap_err();
        assert!(
            matches!(error, SparseError::Dependent { row: 0 | 1, .. }),
            "{error}"
        );
        assert!(matches!(
            factor.factor(&[1.0, f64::NAN, 4.0]).unwrap_err(),
            SparseError::NotFinite { .. }
        ));
        factor.factor(&[2.0, 1.0, 2.0]).unwrap();
    }
}
