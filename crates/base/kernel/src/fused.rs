//! Multiply-add where it is one instruction, for loops that are compiled for several instruction sets.

/// Computes a b + c; `FUSED`: rounded once, which is slow where the processor has no instruction
/// for it.
///
/// ```
/// use protomer_kernel::fused::add;
/// assert_eq!(add::<false>(2.0, 3.0, 1.0), 7.0);
/// assert_eq!(add::<true>(2.0, 3.0, 1.0), 7.0);
/// ```
#[inline(always)]
pub fn add<const FUSED: bool>(a: f32, b: f32, c: f32) -> f32 {
    if FUSED { a.mul_add(b, c) } else { a * b + c }
}

/// Variant of [`add`] in double precision.
#[inline(always)]
pub fn add_f64<const FUSED: bool>(a: f64, b: f64, c: f64) -> f64 {
    if FUSED { a.mul_add(b, c) } else { a * b + c }
}
