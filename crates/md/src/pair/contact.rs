//! The repulsion between the closest points alone.

use super::repulsion::Repulsion;
use super::terms::Terms;
use protomer_kernel::shape::closest::ClosestPoints;

/// Adds U(d) with the distance d of the bodies. Where two faces are parallel, the closest points are
/// not unique, and the torque jumps.
pub fn add(terms: &mut Terms, repulsion: &Repulsion, closest: &ClosestPoints) {
    terms.repel(repulsion, closest);
}
