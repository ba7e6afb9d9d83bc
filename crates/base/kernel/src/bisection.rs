//! Intervals in which a condition changes once, halved until they are short.

/// The ends of an interval after so many halvings: the condition holds at the first and not at the second, as at the ends
/// that are given.
///
/// ```
/// use protomer_kernel::bisection::halved;
/// let [below, above] = halved([0.0, 2.0], 40, |x| x * x < 2.0);
/// assert!(below < above && (below - 2.0_f64.sqrt()).abs() < 1e-11);
/// ```
pub fn halved(mut ends: [f64; 2], times: u32, holds: impl Fn(f64) -> bool) -> [f64; 2] {
    for _ in 0..times {
        let middle = f64::midpoint(ends[0], ends[1]);
        ends[usize::from(!holds(middle))] = middle;
    }
    ends
}

/// Variant of [`halved`] that ends when the interval is not longer than a width, or has no number between its ends.
///
/// ```
/// use protomer_kernel::bisection::narrowed;
/// let [above, below] = narrowed([3.0, 0.0], 1e-6, |x| x * x > 2.0);
/// assert!(above - below <= 1e-6 && above * above > 2.0);
/// ```
pub fn narrowed(mut ends: [f64; 2], width: f64, mut holds: impl FnMut(f64) -> bool) -> [f64; 2] {
    while (ends[1] - ends[0]).abs() > width {
        let middle = f64::midpoint(ends[0], ends[1]);
        if ends.contains(&middle) {
            break;
        }
        ends[usize::from(!holds(middle))] = middle;
    }
    ends
}
