//! The energy of the closest points alone.

use super::terms::Terms;
use protomer_kernel::shape::closest::ClosestPoints;

/// Adds U(d) with the distance d of the bodies. Where two faces are parallel, the closest points are
/// not unique, and the torque jumps.
pub fn add(terms: &mut Terms, closest: &ClosestPoints) {
    terms.repel(closest);
}
