//! Arithmetic on sixteen numbers at once, as vector units like it.

/// Points evaluated together.
pub(super) const BLOCK: usize = 16;

/// a b + c.
#[inline(always)]
pub(super) fn add<const FUSED: bool>(a: f32, b: f32, c: f32) -> f32 {
    if FUSED { a.mul_add(b, c) } else { a * b + c }
}

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

/// Whether the processor has the vectors that the fast paths of tables are compiled for.
#[cfg(target_arch = "x86_64")]
pub(super) fn has_wide_vectors() -> bool {
    is_x86_feature_detected!("avx512f")
        && is_x86_feature_detected!("avx512dq")
        && is_x86_feature_detected!("avx512vl")
        && is_x86_feature_detected!("avx512bw")
        && is_x86_feature_detected!("fma")
}
