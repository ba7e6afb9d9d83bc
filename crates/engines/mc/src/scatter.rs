//! Bodies scattered at random through their space: the start of a run from the fluid.

use crate::hard::HardBodies;
use crate::system::{System, Trial};
use crate::{McError, Result};
use protomer_kernel::random::{CounterRng, Purpose};
use protomer_kernel::{Boundary, Pose, Vec3};

/// Random poses tried for one body before the space counts as full.
const ATTEMPTS_PER_BODY: u64 = 20_000;

/// The same bodies at random positions and orientations without overlaps, inserted one after
/// another. The same seed and replica give the same poses.
///
/// ```
/// use protomer_kernel::{Boundary, Pose};
/// use protomer_mc::{BodyType, System, hard::overlapping_pairs, scatter::scattered};
/// # use protomer_kernel::{TriangleMesh, Vec3};
/// # use std::sync::Arc;
/// # let mesh = TriangleMesh::cuboid(&Vec3::repeat(-5.0), &Vec3::repeat(5.0));
/// # let cube = Arc::new(BodyType::new("cube", &mesh, &[])?);
/// let space = Boundary::periodic(Vec3::repeat(100.0))?;
/// let all_in_one_place = System::new(vec![cube], &[(0, Pose::identity()); 5], space)?;
/// let fluid = scattered(&all_in_one_place, 1, 0)?;
/// assert!(overlapping_pairs(&fluid).is_empty());
/// assert_eq!(fluid.poses(), scattered(&all_in_one_place, 1, 0)?.poses());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`McError::BadSystem`] in open space, or if no place is found for a body.
pub fn scattered(system: &System, seed: u64, replica: u32) -> Result<System> {
    if matches!(system.boundary(), Boundary::Open) {
        return Err(McError::BadSystem(
            "in open space bodies cannot be scattered; give the assembly a box".into(),
        ));
    }
    let mut scattered = system.clone();
    let mut hard = HardBodies::new(system.len());
    for body in 0..system.len() {
        let placed: Vec<usize> = (0..body).collect();
        let mut poses = (0..ATTEMPTS_PER_BODY).map(|attempt| {
            let step = body as u64 * ATTEMPTS_PER_BODY + attempt;
            let mut rng = CounterRng::for_purpose(seed, replica, step, Purpose::Scatter);
            scattered.tidy(random_pose(system.boundary(), &mut rng))
        });
        let free = poses.find(|pose| {
            let trial = Trial {
                system: &scattered,
                body,
                pose: *pose,
            };
            !hard.blocks(&trial, &placed)
        });
        let Some(pose) = free else {
            return Err(McError::BadSystem(format!(
                "after {body} of {} bodies the space has no room for another at random; start from \
                 the assembly, or enlarge the box",
                system.len()
            )));
        };
        scattered.set_pose(body, pose);
    }
    Ok(scattered)
}

fn random_pose(boundary: &Boundary, rng: &mut CounterRng) -> Pose {
    let position = match boundary {
        Boundary::Periodic { lengths_angstrom } => {
            lengths_angstrom.map(|edge| rng.uniform_in(-0.5 * edge, 0.5 * edge))
        }
        Boundary::SphereWall { radius_angstrom } => rng.vector_in_ball(*radius_angstrom),
        Boundary::Open => Vec3::zeros(),
    };
    Pose {
        position,
        rotation: rng.rotation(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::BodyType;
    use crate::hard::overlapping_pairs;
    use protomer_kernel::TriangleMesh;
    use std::sync::Arc;

    fn tetrahedra(number: usize, space: Boundary) -> System {
        let mesh = TriangleMesh::tetrahedron(5.0);
        let kind = Arc::new(BodyType::new("tetrahedron", &mesh, &[]).unwrap());
        // Where they are does not matter: all in one place.
        System::new(vec![kind], &vec![(0, Pose::identity()); number], space).unwrap()
    }

    #[test]
    fn scattered_bodies_do_not_overlap_and_each_replica_is_another() {
        let spaces = [
            Boundary::periodic(Vec3::new(40.0, 50.0, 60.0)).unwrap(),
            Boundary::SphereWall {
                radius_angstrom: 40.0,
            },
        ];
        for space in spaces {
            let system = tetrahedra(20, space);
            let fluid = scattered(&system, 4, 0).unwrap();
            assert!(overlapping_pairs(&fluid).is_empty());
            assert!(
                fluid
                    .poses()
                    .iter()
                    .all(|pose| space.contains(&pose.position))
            );
            assert_eq!(fluid.poses(), scattered(&system, 4, 0).unwrap().poses());
            assert_ne!(fluid.poses(), scattered(&system, 4, 1).unwrap().poses());
        }
    }

    #[test]
    fn full_and_open_spaces_are_refused() {
        let small = Boundary::periodic(Vec3::repeat(36.0)).unwrap();
        let full = scattered(&tetrahedra(400, small), 1, 0)
            .unwrap_err()
            .to_string();
        assert!(full.contains("no room"), "{full}");
        let open = scattered(&tetrahedra(2, Boundary::Open), 1, 0)
            .unwrap_err()
            .to_string();
        assert!(open.contains("box"), "{open}");
    }
}
