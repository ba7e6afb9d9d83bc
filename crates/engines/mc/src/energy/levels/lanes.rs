//! Arithmetic on sixteen numbers at once, as vector units like it.

/// Points evaluated together.
pub(super) const BLOCK: usize = 16;

/// Asks for a value that will be read soon.
#[inline(always)]
pub(super) fn prefetch<T>(value: &T) {
    #[cfg(target_arch = "x86_64")]
    for line in 0..size_of::<T>().div_ceil(LINE) {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        let start = std::ptr::from_ref(value).cast::<i8>();
        // SAFETY: a hint, which reads nothing and fails for no address; every x86-64 processor has it.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(start.wrapping_add(line * LINE)) };
    }
}

/// Bytes that come from memory together.
#[cfg(target_arch = "x86_64")]
const LINE: usize = 64;

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
