//! From clipped circles to arcs that share vertices.

use super::balls::Balls;
use super::circle::{Cap, CircleArc, CircleFrame, Exposure, counter_clockwise_angle, exposed_arcs};
use super::{Arc, Vertex};
use protomer_kernel::Vec3;

/// Arcs and vertices that know each other, and the atoms that are exposed without any arc.
#[derive(Debug, Clone)]
pub(crate) struct Joined {
    pub(crate) arcs: Vec<Arc>,
    pub(crate) vertices: Vec<Vertex>,
    pub(crate) free_atoms: Vec<u32>,
}

/// The name of a vertex: three atoms in increasing order and on which side of their plane it lies.
type Name = ([u32; 3], bool);

/// One end of one arc, under the name of the vertex there.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct ArcEnd {
    name: Name,
    arc: u32,
    end: u8,
}

/// Clips every circle and joins the arcs; `None` if rounding made two circles disagree about a
/// vertex.
pub(crate) fn join(balls: &Balls) -> Option<Joined> {
    let (mut arcs, ends, free_atoms) = clip_circles(balls);
    let vertices = join_ends(&mut arcs, ends)?;
    Some(Joined {
        arcs,
        vertices,
        free_atoms,
    })
}

/// The arcs that the balls leave of every circle, their ends, and the atoms without any circle.
fn clip_circles(balls: &Balls) -> (Vec<Arc>, Vec<ArcEnd>, Vec<u32>) {
    let (mut arcs, mut ends, mut free_atoms) = (Vec::new(), Vec::new(), Vec::new());
    let (mut caps, mut pieces): (Vec<Cap>, _) = (Vec::new(), Vec::new());
    for &atom in balls.members() {
        if balls.caps(atom, &mut caps).is_none() {
            continue;
        }
        // No cap at all: the whole ball is exposed.
        if caps.is_empty() {
            free_atoms.push(atom);
        }
        for (index, cap) in caps.iter().enumerate() {
            if cap.owner < atom {
                continue; // clipped with the other atom
            }
            let frame = CircleFrame::new(cap);
            let circle = circle(balls, atom, cap.owner, &frame);
            if exposed_arcs(&caps, index, &frame, &mut pieces) == Exposure::Whole {
                arcs.push(circle);
            }
            for piece in &pieces {
                // Each end is where a third ball cuts the circle.
                for (end, &third) in piece.owners.iter().enumerate() {
                    ends.push(ArcEnd {
                        name: vertex_name(atom, cap.owner, third, end == 0),
                        arc: arcs.len() as u32,
                        end: end as u8,
                    });
                }
                arcs.push(part_of(&circle, piece, &frame));
            }
        }
    }
    (arcs, ends, free_atoms)
}

/// The whole circle in which the balls of two atoms meet.
fn circle(balls: &Balls, atom: u32, other: u32, frame: &CircleFrame) -> Arc {
    let (centre, radius) = (balls.centres[atom as usize], balls.radii[atom as usize]);
    let height = frame.height * radius;
    Arc {
        atoms: [atom, other],
        centre: centre + frame.axis * height,
        axis: frame.axis,
        radius: frame.radius * radius,
        height,
        ends: [frame.e1; 2],
        middle: -frame.e1,
        angle: std::f64::consts::TAU,
        vertices: None,
    }
}

/// A part of a circle, its vertices not known yet.
fn part_of(circle: &Arc, piece: &CircleArc, frame: &CircleFrame) -> Arc {
    let angle = counter_clockwise_angle(&piece.ends[0], &piece.ends[1]);
    let ([x, y], (sine, cosine)) = (piece.ends[0], (0.5 * angle).sin_cos());
    Arc {
        ends: piece.ends.map(|end| frame.direction(end)),
        middle: frame.direction([x * cosine - y * sine, y * cosine + x * sine]),
        angle,
        vertices: Some([u32::MAX; 2]),
        ..*circle
    }
}

/// The name of the vertex where an arc of circle (i, j), i < j, is bounded by ball k.
///
/// At the start of an arc the circle leaves ball k, and det(c_j - c_i, c_k - c_i, v - c_i) > 0; at
/// the end it is negative. Sorting the atoms changes the sign with the parity of the permutation.
fn vertex_name(i: u32, j: u32, k: u32, is_start: bool) -> Name {
    // Sorting the three indices is a permutation; an odd one reverses the sense about the plane.
    if k > j {
        ([i, j, k], is_start)
    } else if k > i {
        ([i, k, j], !is_start)
    } else {
        ([k, i, j], is_start)
    }
}

/// Makes one vertex of each three arc ends of the same name.
fn join_ends(arcs: &mut [Arc], mut ends: Vec<ArcEnd>) -> Option<Vec<Vertex>> {
    ends.sort_unstable();
    let mut vertices = Vec::with_capacity(ends.len() / 3);
    // Each vertex is the end of three arcs, one on each circle of its three balls.
    if !ends.len().is_multiple_of(3) {
        return None;
    }
    for three in ends.chunks_exact(3) {
        let name = three[0].name;
        let [a, b, c] = name.0;
        // One circle found the vertex and another did not: rounding decided differently.
        if three.iter().any(|end| end.name != name) {
            return None;
        }
        let mut slots = [u32::MAX; 3];
        let mut position = Vec3::zeros();
        for end in three {
            let arc = &mut arcs[end.arc as usize];
            let slot = [[a, b], [a, c], [b, c]]
                .iter()
                .position(|pair| *pair == arc.atoms)?;
            slots[slot] = end.arc;
            arc.vertices.as_mut()?[end.end as usize] = vertices.len() as u32;
            // Any of the three ends will do: they agree to rounding.
            position = arc.point(&arc.ends[end.end as usize]);
        }
        // Three ends on fewer than three circles.
        if slots.contains(&u32::MAX) {
            return None;
        }
        vertices.push(Vertex {
            atoms: name.0,
            position,
            arcs: slots,
        });
    }
    Some(vertices)
}
