//! Faces: the loops of arcs on each ball, grouped into connected parts, and the shells these make
//! up.

use super::balls::Balls;
use super::join::Joined;
use super::spherical::{self, Edge, Loop};
use super::{Arc, Face};
use protomer_kernel::Vec3;
use protomer_kernel::disjoint_sets::DisjointSets;
use std::f64::consts::PI;

/// A solid angle may leave [0, 4π] by this much through rounding.
const SOLID_ANGLE_TOLERANCE: f64 = 1e-6;

/// The faces of an arrangement and what is known of them as a whole.
#[derive(Debug, Clone)]
pub(crate) struct Traced {
    pub(crate) faces: Vec<Face>,
    pub(crate) shells: u32,
    pub(crate) arc_shells: Vec<u32>,
    pub(crate) defects: u32,
}

/// Half-arc 2 a + s is arc a seen from its atom s: each arc bounds one face on each of its two
/// balls.
pub(crate) fn trace(balls: &Balls, joined: &Joined) -> Traced {
    let next = successors(joined);
    let mut faces: Vec<Face> = Vec::new();
    let mut face_of_half_arc = vec![u32::MAX; next.len()];
    let mut defects = 0;
    // Sorted by atom: each group holds the half-arcs on one ball.
    for group in half_arcs_by_atom(&joined.arcs).chunk_by(|a, b| a.0 == b.0) {
        let (loops, members) = loops_of(group, &next, &joined.arcs, balls);
        for region in spherical::regions(&loops) {
            let mut boundary: Vec<&Loop> = Vec::with_capacity(region.len());
            for number in region {
                boundary.push(&loops[number]);
                for &half_arc in &members[number] {
                    face_of_half_arc[half_arc as usize] = faces.len() as u32;
                }
            }
            let solid_angle = spherical::solid_angle(&boundary);
            let possible = -SOLID_ANGLE_TOLERANCE..=4.0 * PI + SOLID_ANGLE_TOLERANCE;
            // A solid angle beyond 0 to 4π means that loops
            // were grouped wrongly or an arc is missing.
            defects += u32::from(!possible.contains(&solid_angle));
            faces.push(Face {
                atom: group[0].0,
                shell: 0,
                solid_angle: solid_angle.clamp(0.0, 4.0 * PI),
                vector_angle: spherical::vector_angle(&boundary),
            });
        }
    }
    // Nothing touches these: the whole ball is one face without a boundary.
    for &atom in &joined.free_atoms {
        faces.push(Face {
            atom,
            shell: 0,
            solid_angle: 4.0 * PI,
            vector_angle: Vec3::zeros(),
        });
    }
    let (shells, arc_shells) = number_shells(&mut faces, &face_of_half_arc);
    // After the shells were numbered: numbers follow the faces in the order of tracing.
    faces.sort_by_key(|face| face.atom);
    Traced {
        faces,
        shells,
        arc_shells,
        defects,
    }
}

/// The half-arc that follows each half-arc around its face. On the first atom's ball the cap lies
/// on the right if the arc is run through clockwise about the axis, from its end to its start; on
/// the second atom's ball the other way.
fn successors(joined: &Joined) -> Vec<u32> {
    // A whole circle follows itself, so each half-arc does until a vertex says otherwise.
    let mut next: Vec<u32> = (0..2 * joined.arcs.len() as u32).collect();
    for (number, vertex) in joined.vertices.iter().enumerate() {
        for atom in vertex.atoms {
            let (mut arriving, mut departing) = (None, None);
            for arc_number in vertex.arcs {
                let arc = &joined.arcs[arc_number as usize];
                let Some(side) = arc.atoms.iter().position(|a| *a == atom) else {
                    continue;
                };
                let starts_here = arc.vertices.is_some_and(|v| v[0] == number as u32);
                let half = 2 * arc_number + side as u32;
                // On the first ball an arc is run through from
                // its end to its start, on the second forwards.
                if (side == 0) == starts_here {
                    arriving = Some(half)
                } else {
                    departing = Some(half)
                }
            }
            if let (Some(arriving), Some(departing)) = (arriving, departing) {
                next[arriving as usize] = departing;
            }
        }
    }
    next
}

/// Atom and half-arc, sorted.
fn half_arcs_by_atom(arcs: &[Arc]) -> Vec<(u32, u32)> {
    let mut by_atom: Vec<(u32, u32)> = Vec::with_capacity(2 * arcs.len());
    for (number, arc) in (0..).zip(arcs) {
        let [first, second] = arc.atoms;
        by_atom.extend([(first, 2 * number), (second, 2 * number + 1)]);
    }
    by_atom.sort_unstable();
    by_atom
}

/// The loops on one ball, as edges on the unit sphere and as half-arcs.
fn loops_of(
    group: &[(u32, u32)],
    next: &[u32],
    arcs: &[Arc],
    balls: &Balls,
) -> (Vec<Loop>, Vec<Vec<u32>>) {
    let (mut loops, mut members) = (Vec::new(), Vec::new());
    let mut visited = vec![false; group.len()];
    for first in 0..group.len() {
        let (mut edges, mut half_arcs) = (Vec::new(), Vec::new());
        let mut place = first;
        while !visited[place] {
            visited[place] = true;
            let half = group[place].1;
            half_arcs.push(half);
            edges.push(edge(&arcs[half as usize / 2], half as usize % 2, balls));
            let following = next[half as usize];
            // Half-arcs of one atom ascend within its group.
            let Ok(index) = group.binary_search_by_key(&following, |entry| entry.1) else {
                // Not on this ball: the loop stays open, and its solid angle shows it as a defect.
                break;
            };
            place = index;
        }
        if !edges.is_empty() {
            loops.push(edges);
            members.push(half_arcs);
        }
    }
    (loops, members)
}

/// An arc as the edge of a region on the unit sphere about its atom `side`.
fn edge(arc: &Arc, side: usize, balls: &Balls) -> Edge {
    let [first, second] = arc.atoms.map(|atom| atom as usize);
    let [start, end] = arc.ends;
    if side == 0 {
        let scale = balls.radii[first].recip();
        let (height, radius) = (arc.height * scale, arc.radius * scale);
        return Edge {
            axis: arc.axis,
            height,
            radius,
            ends: [end, start],
            angle: arc.angle,
        };
    }
    let scale = balls.radii[second].recip();
    // Seen from the other ball the plane lies at the distance of the centres less its height.
    let distance = (balls.centres[second] - balls.centres[first]).norm();
    let (height, radius) = ((distance - arc.height) * scale, arc.radius * scale);
    Edge {
        axis: -arc.axis,
        height,
        radius,
        ends: arc.ends,
        angle: arc.angle,
    }
}

/// Numbers the connected components: an arc joins the two faces that it bounds.
fn number_shells(faces: &mut [Face], face_of_half_arc: &[u32]) -> (u32, Vec<u32>) {
    let mut sets = DisjointSets::new(faces.len());
    for pair in face_of_half_arc.chunks_exact(2) {
        sets.join(pair[0], pair[1]);
    }
    let mut numbers = vec![u32::MAX; faces.len()];
    let mut shells = 0;
    for (number, face) in faces.iter_mut().enumerate() {
        let representative = sets.root(number as u32) as usize;
        if numbers[representative] == u32::MAX {
            numbers[representative] = shells;
            shells += 1;
        }
        face.shell = numbers[representative];
    }
    let mut arc_shells = Vec::with_capacity(face_of_half_arc.len() / 2);
    for pair in face_of_half_arc.chunks_exact(2) {
        // Both faces of an arc are in one shell.
        arc_shells.push(faces[pair[0] as usize].shell);
    }
    (shells, arc_shells)
}
