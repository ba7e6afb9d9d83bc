//! How near the second body comes along a direction.

use super::orientation::Orientation;
use super::{BodyPair, Core};
use nalgebra::Unit;
use protomer_kernel::bisection::narrowed;
use protomer_kernel::overlap::free_travel;

/// Distance beyond any contact from which a body approaches, Å.
const MARGIN_ANGSTROM: f64 = 0.1;
/// The step of bodies that only their energy keeps apart, Å: a fraction of a bead's core.
const SOFT_STEP_ANGSTROM: f64 = 0.5;
/// The interval in which such bodies touch is halved down to this, Å; its middle counts.
const PRECISION_ANGSTROM: f64 = 1e-3;

/// The distance of the origins at which the second body, coming from far away, first touches the
/// first; zero if it passes through the origin untouched. Å.
pub fn contact_distance_angstrom(pair: &BodyPair, orientation: &Orientation) -> f64 {
    let start_angstrom = pair.outer_distance_angstrom() + MARGIN_ANGSTROM;
    match pair.core {
        Core::Surfaces => {
            let (first, second) = (&pair.first.shape, &pair.second.shape);
            let pose = orientation.relative_pose(start_angstrom);
            let inwards = Unit::new_unchecked(-orientation.direction);
            free_travel(first, second, &pose, &inwards, start_angstrom)
                .map_or(0.0, |travel| start_angstrom - travel)
        }
        Core::Energy => soft_contact_angstrom(pair, orientation, start_angstrom),
    }
}

/// Contact distance of bodies without hard surfaces, Å, found in steps of fixed length.
fn soft_contact_angstrom(pair: &BodyPair, orientation: &Orientation, start_angstrom: f64) -> f64 {
    let touches = |distance: f64| pair.excludes(&orientation.relative_pose(distance));
    let mut apart = start_angstrom;
    let mut touching = apart;
    while !touches(touching) {
        // Passed through the origin: nothing was in the way.
        if touching <= 0.0 {
            return 0.0;
        }
        apart = touching;
        touching = (apart - SOFT_STEP_ANGSTROM).max(0.0);
    }
    let [touching, apart] = narrowed([touching, apart], PRECISION_ANGSTROM, touches);
    0.5 * (apart + touching)
}

#[cfg(test)]
mod tests {
    use super::super::Terms;
    use super::*;
    use crate::BodyType;
    use crate::test_support;
    use protomer_kernel::overlap::overlaps;
    use protomer_kernel::random::CounterRng;
    use std::sync::Arc;

    fn tetrahedron(size: f64) -> Arc<BodyType> {
        let mesh = test_support::tetrahedron(size);
        Arc::new(BodyType::new("tetrahedron", &mesh, &[]).unwrap())
    }

    #[test]
    fn it_is_where_a_scan_from_outside_first_overlaps() {
        let pair = BodyPair {
            first: tetrahedron(5.0),
            second: tetrahedron(3.0),
            potential: Terms::default(),
            core: Core::Surfaces,
            contact_gap_angstrom: 5.0,
        };
        for case in 0..40 {
            let mut rng = CounterRng::new(5, 0, case);
            let orientation = Orientation {
                direction: rng.unit_vector(),
                rotation: rng.rotation(),
            };
            let contact = contact_distance_angstrom(&pair, &orientation);
            let mut scanned = 15.0;
            while !overlaps(
                &pair.first.shape,
                &pair.second.shape,
                &orientation.relative_pose(scanned),
            ) {
                scanned -= 0.001;
            }
            assert!(
                (-1e-9..0.001 + 1e-9).contains(&(contact - scanned)),
                "{contact} {scanned}"
            );
        }
    }
}
