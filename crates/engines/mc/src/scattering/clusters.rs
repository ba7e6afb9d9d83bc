//! Bodies that touch, in one piece.

use crate::System;
use protomer_kernel::Vec3;
use std::collections::VecDeque;

/// Bodies joined by contacts.
#[derive(Debug, Clone, PartialEq)]
pub struct Cluster {
    /// Indices of the bodies, the first of them the smallest.
    pub members: Vec<usize>,
    /// The positions of the members in one piece, Å: across the borders of a periodic box too.
    pub positions_angstrom: Vec<Vec3>,
    /// Whether it touches its own image: such a cluster has no end, and no radius.
    pub is_endless: bool,
}

/// The clusters that these contacts form, by their smallest member. Single bodies count.
///
/// ```
/// # use protomer_kernel::{Boundary, Pose, TriangleMesh, Vec3};
/// # use protomer_mc::{BodyType, System, scattering::clusters::clusters};
/// # use std::sync::Arc;
/// # let mesh = TriangleMesh::tetrahedron(5.0);
/// # let body = Arc::new(BodyType::new("tetrahedron", &mesh, &[])?);
/// let pose = |x| Pose { position: Vec3::new(x, 0.0, 0.0), ..Pose::identity() };
/// let space = Boundary::periodic(Vec3::repeat(100.0))?;
/// let system = System::new(vec![body], &[(0, pose(-45.0)), (0, pose(0.0)), (0, pose(45.0))], space)?;
/// let found = clusters(&system, &[(0, 2)]);
/// assert_eq!(found[0].members, [0, 2]);
/// // The nearest image of the second is across the border.
/// assert_eq!(found[0].positions_angstrom[1].x, -55.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn clusters(system: &System, contacts: &[(usize, usize)]) -> Vec<Cluster> {
    let mut neighbours = vec![Vec::new(); system.len()];
    for &(first, second) in contacts {
        neighbours[first].push(second);
        neighbours[second].push(first);
    }
    let mut place: Vec<Option<Vec3>> = vec![None; system.len()];
    let mut clusters = Vec::new();
    for start in 0..system.len() {
        if place[start].is_some() {
            continue;
        }
        let first = system.pose(start).position;
        place[start] = Some(first);
        let mut cluster = Cluster {
            members: vec![start],
            positions_angstrom: vec![first],
            is_endless: false,
        };
        let mut waiting = VecDeque::from([(start, first)]);
        while let Some((body, body_place)) = waiting.pop_front() {
            for &next in &neighbours[body] {
                let (position, next_position) =
                    (system.pose(body).position, system.pose(next).position);
                let next_place =
                    body_place + system.boundary().displacement(&position, &next_position);
                match place[next] {
                    // Where two ways to a body end a box length apart, the cluster has no end.
                    Some(other_place) => {
                        cluster.is_endless |= (other_place - next_place).norm() > 1e-3
                    }
                    None => {
                        place[next] = Some(next_place);
                        cluster.members.push(next);
                        cluster.positions_angstrom.push(next_place);
                        waiting.push_back((next, next_place));
                    }
                }
            }
        }
        clusters.push(cluster);
    }
    clusters
}
