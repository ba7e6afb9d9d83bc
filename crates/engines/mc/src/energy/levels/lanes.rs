//! Arithmetic on sixteen numbers at once, as vector units like it.

/// Points evaluated together.
pub(super) const BLOCK: usize = 16;

/// The sum, by halves.
#[inline(always)]
pub(super) fn sum_of_lanes(lanes: &[f32; BLOCK]) -> f32 {
    let mut eight = [0.0; BLOCK / 2];
    for lane in 0..BLOCK / 2 {
        eight[lane] = lanes[lane] + lanes[lane + BLOCK / 2];
    }
    let mut four = [0.0; BLOCK / 4];
    for lane in 0..BLOCK / 4 {
        four[lane] = eight[lane] + eight[lane + BLOCK / 4];
    }
    (four[0] + four[1]) + (four[2] + four[3])
}
