//! The face sum as published: one face of each body, and the repulsion between all their features.
//!
//! The face of a body is that through which the ray from its centroid to the contact point of the
//! other body leaves. In two dimensions the four terms are the corners of each edge against the other
//! edge; in three the corners of each face against the other face, and all pairs of edges. The terms
//! are added, not averaged: parallel squares have four times, parallel cubes twenty times the energy
//! of one corner on a face.

use super::Placed;
use super::repulsion::Repulsion;
use super::terms::Terms;
use protomer_kernel::Vec3;
use protomer_kernel::shape::closest::{ClosestPoints, closest_points};

/// Adds the terms of the two faces.
pub fn add(
    terms: &mut Terms,
    repulsion: &Repulsion,
    pair: &Placed,
    corners: &[Vec<Vec3>; 2],
    closest: &ClosestPoints,
) {
    let targets = [closest.on_second, closest.on_first];
    let faces = [0, 1].map(|n| {
        let ray = targets[n] - pair.poses[n].position;
        let face = pair.bodies[n].face_towards(&(pair.poses[n].rotation.inverse() * ray));
        let corner = |number: &usize| corners[n][*number];
        face.corners.iter().map(corner).collect::<Vec<Vec3>>()
    });
    let mut add = |first: &[Vec3], second: &[Vec3]| {
        if let Some(points) = closest_points(first, second) {
            terms.repel(repulsion, &points);
        }
    };
    for corner in &faces[0] {
        add(std::slice::from_ref(corner), &faces[1]);
    }
    for corner in &faces[1] {
        add(&faces[0], std::slice::from_ref(corner));
    }
    if pair.bodies[0].dimension == 2 {
        return;
    }
    for first in edges(&faces[0]) {
        for second in edges(&faces[1]) {
            add(&first, &second);
        }
    }
}

/// The edges of a face.
fn edges(face: &[Vec3]) -> impl Iterator<Item = [Vec3; 2]> {
    let next = face.iter().cycle().skip(1);
    face.iter().zip(next).map(|(from, to)| [*from, *to])
}
