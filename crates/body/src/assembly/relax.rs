//! The smallest uniform expansion without overlaps.

use super::contact::bisect;
use super::placement::Placement;
use crate::{BodyError, Result};
use protomer_kernel::Vec3;

/// An assembly after expansion.
#[derive(Debug, Clone, PartialEq)]
pub struct Expansion {
    /// Factor by which every position moved away from the common centre; one where nothing
    /// overlapped.
    pub factor: f64,
    /// The largest displacement of a body, Å.
    pub largest_displacement_angstrom: f64,
    /// The placements, free of overlap.
    pub placements: Vec<Placement>,
}

/// Scales the positions about their mean by the smallest factor found at which nothing overlaps.
/// Orientations stay. The factor grows from one in steps of a quarter of the expansion until
/// nothing overlaps, and is then bisected, so a free gap narrower than that may be passed over.
///
/// ```
/// use protomer_body::assembly::expand_until_free;
/// use protomer_kernel::{Pose, Vec3};
/// let at = |x| (0, Pose { position: Vec3::new(x, 0.0, 0.0), ..Pose::identity() });
/// let spheres_overlap = |p: &[(usize, Pose)]| (p[0].1.position - p[1].1.position).norm() < 2.0;
/// let expansion = expand_until_free(&[at(-0.8), at(0.8)], 1e-9, spheres_overlap)?;
/// assert!((expansion.factor - 1.25).abs() < 1e-8);
/// # Ok::<(), protomer_body::BodyError>(())
/// ```
///
/// # Errors
/// [`BodyError::Invalid`] if no expansion up to a hundredfold helps, as for two bodies in one
/// place.
pub fn expand_until_free(
    placements: &[Placement],
    tolerance: f64,
    overlaps: impl Fn(&[Placement]) -> bool,
) -> Result<Expansion> {
    let overlaps_at = |factor: f64| overlaps(&expanded(placements, factor));
    let factor = if overlaps_at(1.0) {
        smallest_free(tolerance, overlaps_at)?
    } else {
        1.0
    };
    let centre = centre(placements);
    let mut largest = 0.0_f64;
    for (_, pose) in placements {
        largest = largest.max((pose.position - centre).norm());
    }
    Ok(Expansion {
        factor,
        largest_displacement_angstrom: (factor - 1.0) * largest,
        placements: expanded(placements, factor),
    })
}

fn smallest_free(tolerance: f64, overlaps_at: impl Fn(f64) -> bool) -> Result<f64> {
    const FIRST_STEP: f64 = 1e-4;
    const LARGEST: f64 = 100.0;
    let (mut overlapping, mut expansion) = (1.0, FIRST_STEP);
    while expansion < LARGEST {
        if !overlaps_at(1.0 + expansion) {
            return Ok(bisect(overlapping, 1.0 + expansion, tolerance, overlaps_at));
        }
        overlapping = 1.0 + expansion;
        expansion *= 1.25;
    }
    Err(BodyError::Invalid {
        cause: "the bodies overlap at any expansion".into(),
        remedy: "place no two bodies at the same position".into(),
    })
}

fn centre(placements: &[Placement]) -> Vec3 {
    let mut sum = Vec3::zeros();
    for (_, pose) in placements {
        sum += pose.position;
    }
    sum / placements.len().max(1) as f64
}

fn expanded(placements: &[Placement], factor: f64) -> Vec<Placement> {
    let centre = centre(placements);
    let mut expanded = placements.to_vec();
    for (_, pose) in &mut expanded {
        pose.position = centre + (pose.position - centre) * factor;
    }
    expanded
}

#[cfg(test)]
mod tests {
    use super::*;
    use protomer_kernel::Pose;

    #[test]
    fn free_placements_stay_and_hopeless_ones_are_an_error() {
        let at = |x| {
            (
                0,
                Pose {
                    position: Vec3::new(x, 0.0, 0.0),
                    ..Pose::identity()
                },
            )
        };
        let free = expand_until_free(&[at(0.0), at(3.0)], 1e-9, |_| false).unwrap();
        assert_eq!(
            (free.factor, free.placements),
            (1.0, vec![at(0.0), at(3.0)])
        );
        assert!(expand_until_free(&[at(1.0), at(1.0)], 1e-9, |_| true).is_err());
    }
}
