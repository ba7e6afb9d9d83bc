//! States that the benchmark makes itself: sixteen bodies close to contact, and many bodies spread
//! through a box.

use anyhow::{Context, Result};
use protomer_kernel::overlap::overlaps;
use protomer_kernel::pose::RelativePose;
use protomer_kernel::random::{CounterRng, Purpose};
use protomer_kernel::{Boundary, Pose, Vec3};
use protomer_mc::hard::overlapping_pairs;
use protomer_mc::{BodyType, McError, System};
use std::sync::Arc;

/// Bodies of the cluster.
pub const CLUSTER_BODIES: usize = 16;
/// Box of the cluster, Å.
const CLUSTER_BOX_ANGSTROM: f64 = 600.0;
/// Distance from which a body comes in, Å.
const FROM_ANGSTROM: f64 = 140.0;
/// Length of the steps of a body that comes in, Å.
const STEP_ANGSTROM: f64 = 1.0;
/// Number of ways in that a body tries; it takes the one that leads it nearest to the middle.
const WAYS: usize = 24;
/// Rounds of shaking, in which every body tries a small move towards the middle.
const SHAKES: usize = 300;
/// Largest turn of a body in a shake for each Å of its largest displacement, rad.
const RAD_PER_ANGSTROM: f64 = 0.1;
/// Factor by which all places are drawn apart in the end, so that neighbours have about a tenth of
/// an Å between them.
const LOOSENED: f64 = 1.004;
/// Largest number of places tried for each body of a spread state.
const MOST_PLACES: u32 = 10_000;

/// Sixteen bodies of alternating kinds, each close to contact with its neighbours, none
/// overlapping, in a large box.
///
/// # Errors
/// If the bodies of this seed do not come apart.
pub fn cluster(types: &[Arc<BodyType>], seed: u64) -> Result<System> {
    let mut rng = CounterRng::for_purpose(seed, 0, 0, Purpose::BenchmarkCluster);
    let mut bodies: Vec<(usize, Pose)> = Vec::with_capacity(CLUSTER_BODIES);
    for index in 0..CLUSTER_BODIES {
        let kind = index % types.len();
        let ways = (0..WAYS).map(|_| way_in(types, &bodies, kind, &mut rng));
        let nearest = ways.min_by(|a, b| {
            a.position
                .norm_squared()
                .total_cmp(&b.position.norm_squared())
        });
        bodies.push((kind, nearest.unwrap_or(Pose::identity())));
    }
    for round in 0..SHAKES {
        let step = 1.0 - round as f64 / SHAKES as f64;
        shake(types, &mut bodies, step, &mut rng);
    }
    for (_, pose) in &mut bodies {
        pose.position *= LOOSENED;
    }
    system(types, &bodies, CLUSTER_BOX_ANGSTROM)
}

/// Pose in which a body comes to rest on its way to the middle from a random direction, in a random
/// orientation.
fn way_in(
    types: &[Arc<BodyType>],
    bodies: &[(usize, Pose)],
    kind: usize,
    rng: &mut CounterRng,
) -> Pose {
    let (direction, rotation) = (rng.unit_vector(), rng.rotation());
    let pose = |distance: f64| Pose {
        position: direction * distance,
        rotation,
    };
    let free =
        |distance: f64| is_free(types, &Boundary::Open, bodies.iter(), kind, &pose(distance));
    let mut distance = FROM_ANGSTROM;
    while distance > 0.0 && free((distance - STEP_ANGSTROM).max(0.0)) {
        distance = (distance - STEP_ANGSTROM).max(0.0);
    }
    pose(distance)
}

/// Lets every body try one small move (of at most `step` Å, and in proportion rad), which it takes
/// if that leads towards the middle.
fn shake(types: &[Arc<BodyType>], bodies: &mut [(usize, Pose)], step: f64, rng: &mut CounterRng) {
    for index in 0..bodies.len() {
        let (kind, old) = bodies[index];
        let new = Pose {
            position: old.position + rng.vector_in_ball(step),
            rotation: rng.small_rotation(RAD_PER_ANGSTROM * step) * old.rotation,
        };
        let others = bodies
            .iter()
            .enumerate()
            .filter(|(other, _)| *other != index)
            .map(|(_, body)| body);
        if new.position.norm_squared() < old.position.norm_squared()
            && is_free(types, &Boundary::Open, others, kind, &new)
        {
            bodies[index].1 = new;
        }
    }
}

/// Whether a body of this kind can stand there without overlapping the others.
fn is_free<'a>(
    types: &[Arc<BodyType>],
    boundary: &Boundary,
    mut others: impl Iterator<Item = &'a (usize, Pose)>,
    kind: usize,
    pose: &Pose,
) -> bool {
    others.all(|(other_kind, other)| {
        let (shape, other_shape) = (&types[kind].shape, &types[*other_kind].shape);
        let displacement = boundary.displacement(&pose.position, &other.position);
        let reach = shape.bounding_radius_angstrom() + other_shape.bounding_radius_angstrom();
        displacement.norm_squared() >= reach * reach
            || !overlaps(
                shape,
                other_shape,
                &RelativePose::new(pose, other, &displacement),
            )
    })
}

/// Bodies of alternating kinds at random places of a periodic cube, none overlapping.
///
/// # Errors
/// If the cube is too full for random places.
pub fn spread(
    types: &[Arc<BodyType>],
    count: usize,
    box_angstrom: f64,
    seed: u64,
) -> Result<System> {
    let mut rng = CounterRng::for_purpose(seed, 0, count as u64, Purpose::BenchmarkSpread);
    let boundary = Boundary::periodic(Vec3::repeat(box_angstrom))?;
    let mut bodies: Vec<(usize, Pose)> = Vec::with_capacity(count);
    for index in 0..count {
        let kind = index % types.len();
        let mut places = (0..MOST_PLACES).map(|_| {
            let half = 0.5 * box_angstrom;
            let position = Vec3::from([0, 1, 2].map(|_| rng.uniform_in(-half, half)));
            Pose {
                position,
                rotation: rng.rotation(),
            }
        });
        let pose = places
            .find(|pose| is_free(types, &boundary, bodies.iter(), kind, pose))
            .with_context(|| format!("{count} bodies do not fit a cube of {box_angstrom:.0} Å"))?;
        bodies.push((kind, pose));
    }
    system(types, &bodies, box_angstrom)
}

/// The system, if nothing overlaps.
fn system(types: &[Arc<BodyType>], bodies: &[(usize, Pose)], box_angstrom: f64) -> Result<System> {
    let system = System::new(
        types.to_vec(),
        bodies,
        Boundary::periodic(Vec3::repeat(box_angstrom))?,
    )?;
    let pairs = overlapping_pairs(&system);
    if !pairs.is_empty() {
        return Err(McError::OverlappingStart { pairs })
            .context("the benchmark's own state of this seed overlaps; choose another --seed");
    }
    Ok(system)
}

#[cfg(test)]
mod tests {
    use super::super::bodies::two_kinds;
    use super::*;
    use protomer_mc::observables::contacts;

    #[test]
    fn the_cluster_is_near_contact_and_made_by_its_seed() {
        let types = two_kinds(20, 14, 1).unwrap();
        let system = cluster(&types, 1).unwrap();
        assert_eq!(system.len(), CLUSTER_BODIES);
        assert_eq!(overlapping_pairs(&system), []);
        // Every body touches its neighbours, as in a tight cluster of sixteen.
        let near = contacts(&system, 3.0);
        assert!(
            (0..CLUSTER_BODIES).all(|body| near.iter().any(|(i, j)| *i == body || *j == body)),
            "{near:?}"
        );
        assert!(near.len() > 30, "{}", near.len());
        let again = cluster(&types, 1).unwrap();
        assert_eq!(system.poses(), again.poses());
    }

    #[test]
    fn spread_bodies_are_apart_or_do_not_fit() {
        let types = two_kinds(5, 6, 1).unwrap();
        let system = spread(&types, 60, 180.0, 2).unwrap();
        assert_eq!(overlapping_pairs(&system), []);
        assert!(
            spread(&types, 60, 90.0, 2)
                .unwrap_err()
                .to_string()
                .contains("do not fit")
        );
    }
}
