//! The face sum as published: one face of each body, and the energy between all their features.
//!
//! The face of a body is that through which the ray from its centroid to the contact point of the
//! other body leaves. In two dimensions the four terms are the corners of each edge against the other
//! edge; in three the corners of each face against the other face, and all pairs of edges. The terms
//! are added, not averaged: parallel squares have four times, parallel cubes twenty times the energy
//! of one corner on a face.

use super::Placed;
use super::features::{Features, between_segments, on_face};
use super::terms::Terms;
use protomer_kernel::Vec3;
use protomer_kernel::shape::closest::ClosestPoints;

/// Adds the terms of the two faces.
pub fn add(terms: &mut Terms, pair: &Placed, features: &[Features; 2], closest: &ClosestPoints) {
    let targets = [closest.on_second, closest.on_first];
    let faces = [0, 1].map(|n| {
        let ray = targets[n] - pair.poses[n].position;
        let face = pair.bodies[n].face_towards(&(pair.poses[n].rotation.inverse() * ray));
        let corner = |number: &usize| features[n].corners[*number];
        let rim = face.corners.iter().map(corner).collect::<Vec<Vec3>>();
        (pair.poses[n].rotation * face.normal, rim)
    });
    let [(normal, rim), (other_normal, other_rim)] = &faces;
    for corner in rim {
        terms.repel(&ClosestPoints {
            on_first: *corner,
            on_second: on_face(other_normal, other_rim, corner).0,
        });
    }
    for corner in other_rim {
        terms.repel(&ClosestPoints {
            on_first: on_face(normal, rim, corner).0,
            on_second: *corner,
        });
    }
    if pair.bodies[0].dimension == 2 {
        return;
    }
    for first in edges(rim) {
        for second in edges(other_rim) {
            terms.repel(&between_segments(&first, &second));
        }
    }
}

/// The edges of a face.
fn edges(face: &[Vec3]) -> impl Iterator<Item = [Vec3; 2]> {
    let next = face.iter().cycle().skip(1);
    face.iter().zip(next).map(|(from, to)| [*from, *to])
}
