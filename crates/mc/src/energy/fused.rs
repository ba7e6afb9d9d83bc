//! Multiply-add where it is one instruction.

/// a b + c; `FUSED`: rounded once.
#[inline(always)]
pub(super) fn add<const FUSED: bool>(a: f32, b: f32, c: f32) -> f32 {
    if FUSED { a.mul_add(b, c) } else { a * b + c }
}

/// The same in double precision.
#[inline(always)]
pub(super) fn add_f64<const FUSED: bool>(a: f64, b: f64, c: f64) -> f64 {
    if FUSED { a.mul_add(b, c) } else { a * b + c }
}
