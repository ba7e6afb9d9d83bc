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
///
/// ```
/// use protomer_kernel::fused::add_f64;
/// // (1 + ε)² = 1 + 2ε + ε²: the product alone loses the last term.
/// let a = 1.0 + f64::EPSILON;
/// let c = -(1.0 + 2.0 * f64::EPSILON);
/// assert_eq!(add_f64::<false>(a, a, c), 0.0);
/// assert_eq!(add_f64::<true>(a, a, c), f64::EPSILON * f64::EPSILON);
/// ```
#[inline(always)]
pub fn add_f64<const FUSED: bool>(a: f64, b: f64, c: f64) -> f64 {
    if FUSED { a.mul_add(b, c) } else { a * b + c }
}
