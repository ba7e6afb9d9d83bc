//! Scalar products in single precision, summed in double precision piece by piece: they do not depend on
//! the number of threads.

use rayon::prelude::*;

/// Values of a piece.
pub(super) const PIECE: usize = 1 << 12;
/// Partial sums within a piece.
const LANES: usize = 16;

/// a · b.
pub(super) fn dot(a: &[f32], b: &[f32]) -> f64 {
    // Pieces of fixed length: the sum does not depend on how threads share them.
    let pieces = a.par_chunks(PIECE).zip(b.par_chunks(PIECE));
    let sums: Vec<f64> = pieces.map(|(a, b)| dot_of_piece(a, b)).collect();
    sums.iter().sum()
}

/// a · b of short lists.
pub(super) fn dot_of_piece(a: &[f32], b: &[f32]) -> f64 {
    let (a_chunks, a_rest) = a.as_chunks::<LANES>();
    let (b_chunks, b_rest) = b.as_chunks::<LANES>();
    // Sixteen sums in single precision, each of 256 products: little rounding, full vectors.
    let mut lanes = [0.0; LANES];
    for (a, b) in a_chunks.iter().zip(b_chunks) {
        for lane in 0..LANES {
            lanes[lane] += a[lane] * b[lane];
        }
    }
    let mut remainder = 0.0;
    for (a, b) in a_rest.iter().zip(b_rest) {
        remainder += f64::from(a * b);
    }
    lanes.iter().map(|sum| f64::from(*sum)).sum::<f64>() + remainder
}
