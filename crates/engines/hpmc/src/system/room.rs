//! How large a box must be, and how many bodies fill one.

use crate::reservoir::Depletant;

/// The largest distance at which two bodies of an outer radius meet, with depletants between them.
pub(super) fn range(widest: f64, depletants: &[Depletant]) -> f64 {
    // Depletants in contact with both bodies make them meet at larger distances.
    let radii = depletants.iter().map(|kind| kind.radius);
    2.0 * (widest + radii.fold(0.0, f64::max))
}

/// The smallest length that a box may have. No body reaches an image of itself there. A move of up to half of a
/// length must not bring a body within the reach of where an image of it was either, if there are depletants,
/// because [`depletants`](crate::depletants) compare two places of one body and no images of them.
pub(crate) fn least_edge(widest: f64, depletants: &[Depletant]) -> f64 {
    match depletants {
        [] => range(widest, depletants),
        _ => 2.0 * range(widest, depletants),
    }
}

/// The first number of bodies that works: from one number on, in steps that grow beyond a thousand of them.
pub(crate) fn first_that_works(from: usize, step: usize, works: impl Fn(usize) -> bool) -> usize {
    let mut bodies = from.max(step);
    while bodies < usize::MAX && !works(bodies) {
        // One by one up to a thousand, then in steps of a thousandth: the search stays short.
        let steps = (bodies / (1000 * step)).max(1);
        bodies = bodies.saturating_add(steps * step);
    }
    bodies
}

/// The number of bodies, to within rounding, whose box is so much longer than that of the given number at the
/// same density.
pub(crate) fn bodies_in_longer_box<const D: usize>(bodies: usize, factor: f64) -> usize {
    (bodies as f64 * factor.powi(D as i32) * (1.0 - 1e-9)) as usize
}
