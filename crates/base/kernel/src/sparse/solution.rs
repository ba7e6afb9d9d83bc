//! Solutions with L and D, front by front.

use super::front::{self, LANES};
use super::numbers::Numbers;
use super::symbolic::{Front, Symbolic};
use crate::vectorised;

vectorised!(
    /// Replaces b by the solution, with the widest vectors that the processor has.
    pub(super) fn solve[solve_avx512, solve_avx2, solve_fronts](
        symbolic: &Symbolic,
        work: &mut Numbers,
        b: &mut [f64],
    )
);

/// Solves L y = P b, z = D⁻¹ y, Lᵀ P x = z.
#[inline(always)]
pub(super) fn solve_fronts(symbolic: &Symbolic, work: &mut Numbers, b: &mut [f64]) {
    let Numbers {
        values,
        inverse,
        permuted: x,
        front_values,
        sums,
        ..
    } = work;
    for (target, unknown) in x.iter_mut().zip(&symbolic.order) {
        *target = b[*unknown as usize];
    }
    for front in &symbolic.fronts {
        let front_values = &mut front_values[..front.shape.tiles()];
        solve_forward(symbolic, front, &values[front.tiles()], x, front_values);
    }
    for (x, inverse) in x.iter_mut().zip(inverse) {
        *x *= *inverse;
    }
    for front in symbolic.fronts.iter().rev() {
        let front_values = &mut front_values[..front.shape.tiles()];
        solve_backward(
            symbolic,
            front,
            &values[front.tiles()],
            x,
            front_values,
            sums,
        );
    }
    for (value, unknown) in x.iter().zip(&symbolic.order) {
        b[*unknown as usize] = *value;
    }
}

/// Solves for the own rows of a front and updates the rows below.
#[inline(always)]
fn solve_forward(
    symbolic: &Symbolic,
    front: &Front,
    panel: &[f64],
    x: &mut [f64],
    front_values: &mut [[f64; LANES]],
) {
    let columns = front.shape.columns;
    let flat = front_values.as_flattened_mut();
    flat[..columns].copy_from_slice(&x[front.own()]);
    // Rows below start at zero, so that what comes back is the change alone.
    flat[columns..].fill(0.0);
    front::solve_forward(panel, front.shape, front_values);
    let flat = front_values.as_flattened();
    x[front.own()].copy_from_slice(&flat[..columns]);
    for (row, value) in symbolic.rows[front.below()].iter().zip(&flat[columns..]) {
        // `solve_forward` subtracts from zero, hence the plus.
        x[*row as usize] += value;
    }
}

/// Solves for the own rows of a front, given those below.
#[inline(always)]
fn solve_backward(
    symbolic: &Symbolic,
    front: &Front,
    panel: &[f64],
    x: &mut [f64],
    front_values: &mut [[f64; LANES]],
    sums: &mut Vec<[f64; LANES]>,
) {
    let columns = front.shape.columns;
    let flat = front_values.as_flattened_mut();
    flat[..columns].copy_from_slice(&x[front.own()]);
    for (row, value) in symbolic.rows[front.below()]
        .iter()
        .zip(&mut flat[columns..])
    {
        *value = x[*row as usize];
    }
    // The padding of the last tile must not hold numbers of an earlier front.
    flat[front.shape.height..].fill(0.0);
    front::solve_backward(panel, front.shape, front_values, sums);
    x[front.own()].copy_from_slice(&front_values.as_flattened()[..columns]);
}
