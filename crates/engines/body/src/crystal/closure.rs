//! Whether copies by a motion close to a ring, or go on for ever.
//!
//! Two equal chains in contact make a complex of finite size only if the motion from one to the other is a rotation by
//! 360°/n: by a translation or a screw the next copy touches in the same way, and so on through the whole crystal.

use crate::assembly::superpose;
use protomer_kernel::{Pose, Vec3};
use std::collections::BTreeMap;

/// Largest translation along the axis of a ring, Å; copies within an asymmetric unit are not exact.
const RISE_ANGSTROM: f64 = 2.0;
/// Largest difference of the angle from 360°/n, degrees.
const ANGLE_DEGREE: f64 = 8.0;
/// Largest ring.
const MOST_COPIES: u32 = 12;
/// Equal chains share this part of the residues of the longer one.
const LEAST_SHARE: f64 = 0.8;
/// Equal chains superpose to this, Å.
const MOST_DISTANT_ANGSTROM: f64 = 3.0;

/// Places of the Cα atoms of a chain by residue number and name.
pub(super) type Backbone = BTreeMap<(i32, String), Vec3>;

/// Whether a copy of the second chain in a pose makes a closed ring with the first; `None` for chains that are not
/// equal.
pub(super) fn is_closed(first: &Backbone, second: &Backbone, pose: &Pose) -> Option<bool> {
    let (mut moving, mut fixed) = (Vec::new(), Vec::new());
    for (residue, place) in first {
        if let Some(other) = second.get(residue) {
            moving.push(*place);
            fixed.push(*other);
        }
    }
    let shared = moving.len() as f64 / first.len().max(second.len()).max(1) as f64;
    if shared < LEAST_SHARE {
        return None;
    }
    let best = superpose(&moving, &fixed).ok()?;
    let is_alike = best.rmsd_angstrom < MOST_DISTANT_ANGSTROM;
    is_alike.then(|| is_ring(&best.pose.then(pose)))
}

/// Whether a motion is a rotation by 360°/n or a multiple of it.
fn is_ring(motion: &Pose) -> bool {
    let Some((axis, angle)) = motion.rotation.axis_angle() else {
        return false;
    };
    let rise_angstrom = motion.position.dot(&axis).abs();
    let angle_degree = angle.to_degrees();
    let is_turn = |n: u32| (angle_degree - 360.0 / f64::from(n)).abs() < ANGLE_DEGREE;
    rise_angstrom < RISE_ANGSTROM && (2..=MOST_COPIES).any(is_turn)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn motion(angle_degree: f64, rise_angstrom: f64) -> Pose {
        let half = angle_degree.to_radians() / 2.0;
        let position = Vec3::new(12.0, -3.0, rise_angstrom);
        Pose::from_wxyz(position, [half.cos(), 0.0, 0.0, half.sin()])
    }

    #[test]
    fn rotations_close_and_screws_and_translations_do_not() {
        for (angle, rise, closes) in [
            (180.0, 0.0, true),
            (120.0, 0.0, true),
            (-120.0, 0.0, true),
            (60.0, 0.5, true),
            (180.0, 20.0, false),
            (0.0, 20.0, false),
            (140.0, 0.0, false),
        ] {
            assert_eq!(is_ring(&motion(angle, rise)), closes, "{angle}° {rise} Å");
        }
    }

    #[test]
    fn chains_that_differ_have_no_ring() {
        let backbone = |first: i32| -> Backbone {
            let residues = first..first + 20;
            residues
                .map(|number| {
                    let t = f64::from(number);
                    let place = Vec3::new(t.cos() * 3.0, t.sin() * 3.0, 1.5 * t);
                    ((number, "ALA".to_owned()), place)
                })
                .collect()
        };
        let half_turn = motion(180.0, 0.0);
        assert_eq!(
            is_closed(&backbone(1), &backbone(1), &half_turn),
            Some(true)
        );
        assert_eq!(is_closed(&backbone(1), &backbone(60), &half_turn), None);
    }
}
