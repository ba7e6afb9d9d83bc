//! The numbers of L and D, front by front.

use super::front::{self, LANES};
use super::numbers::Numbers;
use super::symbolic::{Front, Symbolic};
use crate::vectorised;

/// A pivot that is not safely positive.
#[derive(Debug)]
pub(super) struct BadPivot {
    /// The step of elimination.
    pub step: usize,
    pub pivot: f64,
    /// The diagonal entry before any elimination.
    pub diagonal: f64,
}

vectorised!(
    /// Factors a matrix with the widest vectors that the processor has.
    pub(super) fn factor[factor_avx512, factor_avx2, factor_fronts](
        symbolic: &Symbolic,
        work: &mut Numbers,
        numbers: &[f64],
    ) -> Result<(), BadPivot>
);

/// Factors all fronts. Each takes its entries of A and what its children left, is factored, and
/// leaves the rest to its parent.
#[inline(always)]
pub(super) fn factor_fronts(
    symbolic: &Symbolic,
    work: &mut Numbers,
    numbers: &[f64],
) -> Result<(), BadPivot> {
    let Numbers {
        values,
        pivots,
        inverse,
        left_overs,
        packed,
        ..
    } = work;
    // Children before parents: their left-overs are complete when the parent asks for them.
    for front in &symbolic.fronts {
        let shape = front.shape;
        let panel = &mut values[front.tiles()];
        assemble(symbolic, front, numbers, left_overs, panel);
        let diagonal = |column: usize| numbers[symbolic.diagonal[front.first + column] as usize];
        let (pivots, inverse) = (&mut pivots[front.own()], &mut inverse[front.own()]);
        if let Err((column, pivot)) =
            front::factor_panel(panel, shape, diagonal, pivots, inverse, packed)
        {
            let step = front.first + column;
            let diagonal = diagonal(column);
            return Err(BadPivot {
                step,
                pivot,
                diagonal,
            });
        }
        // The root has no rows below and leaves nothing.
        if shape.below() > 0 {
            front::start_left(
                panel,
                shape,
                pivots,
                &mut left_overs[front.left_over()],
                packed,
            );
            // After `start_left`, which overwrites: the
            // place still holds numbers of earlier fronts.
            for child in &symbolic.children[front.children.clone()] {
                add_to_left(
                    symbolic,
                    &symbolic.fronts[*child as usize],
                    front,
                    left_overs,
                );
            }
        }
        // Only now: the panel's triangles were needed as they are for the rows below.
        front::invert_triangles(panel, shape);
    }
    Ok(())
}

/// Fills the tiles of a front with its entries of A and what its children left.
#[inline(always)]
fn assemble(
    symbolic: &Symbolic,
    front: &Front,
    numbers: &[f64],
    left_overs: &[f64],
    panel: &mut [f64],
) {
    // Entries that A does not have are zeros of the front.
    panel.fill(0.0);
    for &(entry, place) in &symbolic.assembly[front.assembly.clone()] {
        panel[place as usize] = numbers[entry as usize];
    }
    for child in &symbolic.children[front.children.clone()] {
        let child = &symbolic.fronts[*child as usize];
        add_to_panel(symbolic, child, front.shape.columns, left_overs, panel);
    }
}

/// Adds what a child left in the rows that are the parent's own to the tiles of the parent.
#[inline(always)]
fn add_to_panel(
    symbolic: &Symbolic,
    child: &Front,
    columns: usize,
    left_overs: &[f64],
    panel: &mut [f64],
) {
    let seats = &symbolic.seats[child.below()];
    // The left-over's rows are counted from its first
    // tile, of which the child's own rows fill a part.
    let (stride, skip) = (child.shape.left_stride(), child.shape.columns % LANES);
    let left_over = &left_overs[child.left_over()];
    // Rows ascend, so the first row beyond the parent's own columns ends this part.
    for (index, (seat, column)) in seats.iter().zip(left_over.chunks_exact(stride)).enumerate() {
        let target = seat.row as usize;
        if target >= columns {
            break;
        }
        // From the diagonal down: the left-over is symmetric, and only its lower part is kept.
        for (seat, value) in seats[index..].iter().zip(&column[skip + index..]) {
            panel[seat.tile as usize + LANES * target] += value;
        }
    }
}

/// Adds what a child left in its other rows to what the parent leaves.
#[inline(always)]
fn add_to_left(symbolic: &Symbolic, child: &Front, parent: &Front, left_overs: &mut [f64]) {
    let seats = &symbolic.seats[child.below()];
    let (stride, skip) = (child.shape.left_stride(), child.shape.columns % LANES);
    let columns = parent.shape.columns;
    let parent_stride = parent.shape.left_stride();
    let base = LANES * parent.shape.first_left_tile();
    // The rows before belong to the parent's own columns and are in its panel.
    let first = seats.partition_point(|seat| (seat.row as usize) < columns);
    // The two places do not overlap, and either may come first.
    let (source, target) = if child.left_over_start < parent.left_over_start {
        let (low, high) = left_overs.split_at_mut(parent.left_over_start);
        (&low[child.left_over()], high)
    } else {
        let (low, high) = left_overs.split_at_mut(child.left_over_start);
        (
            &high[..child.shape.left_size()],
            &mut low[parent.left_over_start..],
        )
    };
    for index in first..seats.len() {
        let column = &source[index * stride..(index + 1) * stride];
        let row = seats[index].row as usize - columns;
        let target = &mut target[row * parent_stride..(row + 1) * parent_stride];
        for (seat, value) in seats[index..].iter().zip(&column[skip + index..]) {
            target[seat.row as usize - base] += value;
        }
    }
}
