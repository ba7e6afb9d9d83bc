//! How near the second body comes along a direction.

use super::orientation::Orientation;
use super::{BodyPair, Core};
use protomer_kernel::bisection::narrowed;
use protomer_kernel::overlap::separation_bound;

/// A bound on the separation is not requested beyond this, Å.
const CEILING_ANGSTROM: f64 = 8.0;
/// The least step towards contact, Å. Overlaps thinner than this may be passed over: they are those
/// of bodies that graze each other to within some 10⁻⁴ Å.
const LEAST_STEP_ANGSTROM: f64 = 0.1;
/// The step of bodies that only their energy keeps apart, Å: a fraction of a bead's core.
const SOFT_STEP_ANGSTROM: f64 = 0.5;
/// The interval in which the bodies touch is halved down to this, Å; its middle counts.
const PRECISION_ANGSTROM: f64 = 1e-3;

/// The distance of the origins at which the second body, coming from far away, first touches the
/// first; zero if it passes through the origin untouched. Å.
///
/// The body advances by a lower bound on the separation, so nothing is met on the way; bodies
/// without hard surfaces advance by a fixed step.
pub fn contact_distance_angstrom(pair: &BodyPair, orientation: &Orientation) -> f64 {
    let (first, second) = (&pair.first.shape, &pair.second.shape);
    let step_angstrom = |distance: f64| {
        let pose = orientation.relative_pose(distance);
        match pair.core {
            Core::Surfaces => separation_bound(first, second, &pose, CEILING_ANGSTROM),
            Core::Energy => (!pair.excludes(&pose)).then_some(SOFT_STEP_ANGSTROM),
        }
    };
    // Farther than any contact, so the first step starts from a safe place.
    let mut apart = pair.outer_distance_angstrom() + LEAST_STEP_ANGSTROM;
    let mut touching = apart;
    while let Some(step) = step_angstrom(touching) {
        // Passed through the origin: nothing was in the way.
        if touching <= 0.0 {
            return 0.0;
        }
        apart = touching;
        // At least a step, or grazing surfaces would be approached for ever.
        touching = (apart - step.max(LEAST_STEP_ANGSTROM)).max(0.0);
    }
    // The bracket: no contact at `apart`, overlap at `touching`.
    let touches = |distance: f64| pair.excludes(&orientation.relative_pose(distance));
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
            assert!((contact - scanned).abs() < 0.0016, "{contact} {scanned}");
        }
    }
}
