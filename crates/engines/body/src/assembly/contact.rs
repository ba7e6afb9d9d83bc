//! The parameter at which placements touch.

use protomer_kernel::bisection::narrowed;

/// Factor between successive values in the search for the first overlap.
const STEPS: u32 = 128;

/// The smallest value above which nothing overlaps. Doubles `start` until all values up to four
/// times as large are free too, walks inward to the first overlap, and bisects to `tolerance`. The
/// value returned is free of overlap. `None` if nothing is free up to 2⁴⁰ times the start.
pub(super) fn from_outside(
    start: f64,
    tolerance: f64,
    overlaps: impl Fn(f64) -> bool,
) -> Option<f64> {
    let mut free = outside(start, &overlaps)?;
    let step = free / f64::from(STEPS);
    let mut inner = free;
    for _ in 0..STEPS {
        inner = (inner - step).max(0.0);
        if overlaps(inner) {
            return Some(narrowed([inner, free], tolerance, overlaps)[1]);
        }
        free = inner;
    }
    Some(free)
}

/// The first of start, 2 start, 4 start ... that is free together with all values up to four times
/// as large.
fn outside(start: f64, overlaps: impl Fn(f64) -> bool) -> Option<f64> {
    const MOST_DOUBLINGS: u32 = 40;
    const PROBES: u32 = 12;
    let is_outside =
        |value: f64| (0..=PROBES).all(|k| !overlaps(value * (1.0 + 0.25 * f64::from(k))));
    let mut value = start;
    for _ in 0..=MOST_DOUBLINGS {
        if is_outside(value) {
            return Some(value);
        }
        value *= 2.0;
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_outer_of_two_boundaries_is_found() {
        let overlaps = |x: f64| x < 3.0 || (4.0..5.5).contains(&x);
        let contact = from_outside(0.1, 1e-9, overlaps).unwrap();
        assert!((contact - 5.5).abs() < 1e-8 && !overlaps(contact));
        assert_eq!(from_outside(1.0, 1e-9, |_| true), None);
        assert_eq!(from_outside(1.0, 1e-9, |_| false), Some(0.0));
    }
}
