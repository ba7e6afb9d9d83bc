//! Random sequential insertion: a fluid of bodies in a periodic box.
//!
//! Each body gets a uniformly random position and orientation, again and again until it overlaps
//! neither an earlier body nor one of its images. The result is close to the equilibrium of hard
//! bodies while the fluid is dilute; equilibrate a dense one with a run without energies.

use super::placement::Placement;
use crate::{BodyError, Result};
use protomer_kernel::random::{CounterRng, Purpose};
use protomer_kernel::{Boundary, Pose, Vec3};

/// Attempts at one body before the box counts as full.
pub const ATTEMPTS_PER_BODY: u64 = 10_000;

/// The size of a kind of body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InsertedBody {
    /// Volume, Å³.
    pub volume_angstrom3: f64,
    /// Radius of the sphere about its origin that holds it, Å.
    pub radius_angstrom: f64,
}

/// Inserts `counts[k]` bodies of each kind k, one after the other. `overlaps` says whether a body
/// overlaps one of those before it or an image of them.
///
/// # Errors
/// [`BodyError::Invalid`] if counts and kinds differ in number, all counts are zero, or the box is
/// too small; [`BodyError::NoRoom`] if it is too full.
///
/// ```
/// use protomer_body::assembly::Placement;
/// use protomer_body::assembly::insertion::{InsertedBody, insert_at_random};
/// use protomer_kernel::Boundary;
/// let ball = InsertedBody { volume_angstrom3: 4.19, radius_angstrom: 1.0 };
/// let overlaps = |new: &Placement, others: &[Placement], space: &Boundary| {
///     others
///         .iter()
///         .any(|other| space.displacement(&new.1.position, &other.1.position).norm() < 2.0)
/// };
/// let fluid = insert_at_random(&[ball], &[20], [10.0; 3], 1, overlaps)?;
/// assert_eq!(fluid.len(), 20);
/// # Ok::<(), protomer_body::BodyError>(())
/// ```
pub fn insert_at_random(
    kinds: &[InsertedBody],
    counts: &[usize],
    box_angstrom: [f64; 3],
    seed: u64,
    overlaps: impl Fn(&Placement, &[Placement], &Boundary) -> bool,
) -> Result<Vec<Placement>> {
    check_counts(kinds, counts)?;
    let boundary = Boundary::periodic(Vec3::from(box_angstrom))?;
    require_room(kinds, counts, &boundary)?;
    let mut placements: Vec<Placement> = Vec::new();
    for (kind, count) in counts.iter().enumerate() {
        for _ in 0..*count {
            let inserted = placements.len();
            let free = (0..ATTEMPTS_PER_BODY).find_map(|attempt| {
                let trial = (kind, random_pose(seed, inserted, attempt, box_angstrom));
                let is_free = !overlaps(&trial, &placements, &boundary);
                is_free.then_some(trial)
            });
            placements.push(free.ok_or(BodyError::NoRoom {
                inserted,
                attempts: ATTEMPTS_PER_BODY,
            })?);
        }
    }
    Ok(placements)
}

fn check_counts(kinds: &[InsertedBody], counts: &[usize]) -> Result<()> {
    let (cause, remedy) = if counts.len() != kinds.len() {
        let cause = format!("{} counts for {} bodies", counts.len(), kinds.len());
        (cause, "give one per body")
    } else if counts.iter().all(|count| *count == 0) {
        ("every count is zero".into(), "give at least one body")
    } else {
        return Ok(());
    };
    Err(BodyError::Invalid {
        cause,
        remedy: remedy.into(),
    })
}

/// Refuses bodies with a larger total volume than the box. Overlap is tested with the nearest image
/// only, so no body may reach two images of another: an edge must hold two diameters of the
/// largest body. Kinds with a count of zero are ignored.
fn require_room(kinds: &[InsertedBody], counts: &[usize], boundary: &Boundary) -> Result<()> {
    let (mut volume, mut diameter) = (0.0, 0.0_f64);
    for (kind, count) in kinds.iter().zip(counts) {
        if *count > 0 {
            volume += kind.volume_angstrom3 * *count as f64;
            diameter = diameter.max(2.0 * kind.radius_angstrom);
        }
    }
    let edge = boundary.smallest_length_angstrom();
    let (cause, remedy) = if volume > boundary.volume_angstrom3() {
        let cause = format!(
            "the bodies fill {volume:.3e} Å³, and the box has only {:.3e} Å³",
            boundary.volume_angstrom3()
        );
        (cause, "enlarge the box, or ask for fewer bodies")
    } else if edge < 2.0 * diameter {
        let cause = format!(
            "the box has an edge of {edge} Å, and the largest body a diameter of {diameter:.1} Å"
        );
        (cause, "enlarge the box: an edge must hold two diameters")
    } else {
        return Ok(());
    };
    Err(BodyError::Invalid {
        cause,
        remedy: remedy.into(),
    })
}

/// A random pose; each attempt at each body has its own stream of random numbers.
fn random_pose(seed: u64, body: usize, attempt: u64, box_angstrom: [f64; 3]) -> Pose {
    let mut rng = CounterRng::for_purpose(seed, body as u32, attempt, Purpose::Object);
    let position = Vec3::from(box_angstrom.map(|edge| rng.uniform_in(-0.5 * edge, 0.5 * edge)));
    Pose {
        position,
        rotation: rng.rotation(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BALL: InsertedBody = InsertedBody {
        volume_angstrom3: 4.19,
        radius_angstrom: 1.0,
    };

    fn balls_overlap(new: &Placement, others: &[Placement], space: &Boundary) -> bool {
        others.iter().any(|other| {
            let apart = space.displacement(&new.1.position, &other.1.position);
            apart.norm() < 2.0
        })
    }

    fn fluid(counts: &[usize], edge: f64, seed: u64) -> Result<Vec<Placement>> {
        let kinds = vec![BALL; counts.len()];
        insert_at_random(&kinds, counts, [edge; 3], seed, balls_overlap)
    }

    #[test]
    fn no_two_bodies_overlap_and_the_kinds_come_in_order() {
        let placements = fluid(&[20, 0, 15], 14.0, 3).unwrap();
        let kinds: Vec<usize> = placements.iter().map(|placement| placement.0).collect();
        assert_eq!(kinds, [vec![0; 20], vec![2; 15]].concat());
        let space = Boundary::periodic(Vec3::repeat(14.0)).unwrap();
        for (index, placement) in placements.iter().enumerate() {
            assert!(!balls_overlap(placement, &placements[..index], &space));
        }
        assert_eq!(placements, fluid(&[20, 0, 15], 14.0, 3).unwrap());
        assert_ne!(placements, fluid(&[20, 0, 15], 14.0, 4).unwrap());
    }

    #[test]
    fn what_cannot_be_is_refused() {
        let message = |counts: &[usize], edge: f64| fluid(counts, edge, 1).unwrap_err().to_string();
        assert!(message(&[0, 0], 14.0).contains("at least one"));
        assert!(message(&[1000], 10.0).contains("fewer bodies"));
        assert!(message(&[2], 3.0).contains("two diameters"));
        let kinds = [BALL];
        let wrong = insert_at_random(&kinds, &[1, 1], [9.0; 3], 1, balls_overlap).unwrap_err();
        assert!(
            wrong.to_string().contains("2 counts for 1 bodies"),
            "{wrong}"
        );
        let full = fluid(&[200], 10.0, 1).unwrap_err();
        assert!(
            matches!(
                full,
                BodyError::NoRoom {
                    inserted: 60..200,
                    ..
                }
            ),
            "{full}"
        );
    }

    /// A kind with a count of zero may be larger than the box.
    #[test]
    fn kinds_without_a_body_do_not_count() {
        let giant = InsertedBody {
            volume_angstrom3: 1e9,
            radius_angstrom: 1e3,
        };
        let kinds = [BALL, giant];
        assert!(insert_at_random(&kinds, &[2, 0], [9.0; 3], 1, balls_overlap).is_ok());
        assert!(insert_at_random(&kinds, &[2, 1], [9.0; 3], 1, balls_overlap).is_err());
    }
}
