//! Regions of a unit sphere bounded by circular edges: solid angle, vector angle, connected parts.
//!
//! An edge runs along the rim of a cap with the cap on its right, that is clockwise about the cap's
//! axis. With the region on the left, its geodesic curvature integrates to -h φ (height h of the
//! plane, angle φ of the edge), corners turn by their exterior angle ε, and the Gauss-Bonnet
//! theorem gives the solid angle of a connected region with L boundary loops: Ω = 2π (2 - L) + Σ h
//! φ - Σ ε. Stokes' theorem gives ∫ u dΩ = ½ ∮ u × du.

use super::circle::{Cap, CircleFrame, Exposure, counter_clockwise_angle, exposed_arcs};
use protomer_kernel::Vec3;
use std::collections::HashMap;
use std::f64::consts::PI;

/// A piece of the rim of a cap, run through clockwise about the cap's axis.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Edge {
    /// Axis of the cap.
    pub(crate) axis: Vec3,
    /// Distance of its plane from the sphere's centre, in radii.
    pub(crate) height: f64,
    /// Radius of its rim, in radii of the sphere.
    pub(crate) radius: f64,
    /// Unit vectors from the rim's centre to the start and the end of the edge.
    pub(crate) ends: [Vec3; 2],
    /// Unit vector from the rim's centre to the middle of the edge.
    pub(crate) middle: Vec3,
    /// Angle run through, radians.
    pub(crate) angle: f64,
}

impl Edge {
    /// Whether the edge is a whole circle.
    fn is_whole(&self) -> bool {
        self.ends[0] == self.ends[1]
    }

    /// The point of the unit sphere in this direction from the rim's centre.
    fn point(&self, direction: &Vec3) -> Vec3 {
        self.axis * self.height + direction * self.radius
    }

    /// ½ ∫ u × du along the edge.
    fn vector_angle(&self) -> Vec3 {
        let swept = self.axis.cross(&(self.ends[1] - self.ends[0]));
        (swept * (self.height * self.radius) - self.axis * (self.radius * self.radius * self.angle))
            * 0.5
    }

    /// Where the plane through the sphere's centre with normal `normal` meets the edge's circle:
    /// directions.
    fn meets(&self, normal: &Vec3) -> Option<[Vec3; 2]> {
        let along = normal.dot(&self.axis);
        let in_plane = normal - self.axis * along;
        let length = in_plane.norm();
        let cosine = -self.height * along / (self.radius * length);
        if cosine.is_nan() || cosine.abs() > 1.0 {
            return None;
        }
        let direction = in_plane / length;
        let sideways = self.axis.cross(&direction) * (1.0 - cosine * cosine).sqrt();
        Some([direction * cosine + sideways, direction * cosine - sideways])
    }
}

/// A closed boundary curve of a region.
pub(crate) type Loop = Vec<Edge>;

/// Σ h φ - Σ ε over one loop.
fn turning(edges: &[Edge]) -> f64 {
    let curvature: f64 = edges.iter().map(|edge| edge.height * edge.angle).sum();
    if let [only] = edges
        && only.is_whole()
    {
        return curvature;
    }
    let next = edges.iter().cycle().skip(1);
    let corners: f64 = edges
        .iter()
        .zip(next)
        .map(|(arriving, departing)| exterior_angle(arriving, departing))
        .sum();
    curvature - corners
}

/// The angle between the directions of travel before and after a corner, within [0, π]: where two
/// caps meet, the region outside both has a convex corner. At a spike the sign that rounding gives
/// must not turn π into -π.
fn exterior_angle(arriving: &Edge, departing: &Edge) -> f64 {
    let before = arriving.ends[1].cross(&arriving.axis);
    let after = departing.ends[0].cross(&departing.axis);
    let corner = departing.point(&departing.ends[0]);
    before
        .cross(&after)
        .dot(&corner)
        .abs()
        .atan2(before.dot(&after))
}

/// Solid angle of a connected region with these boundary loops.
pub(crate) fn solid_angle(loops: &[&Loop]) -> f64 {
    2.0 * PI * (2.0 - loops.len() as f64) + loops.iter().map(|edges| turning(edges)).sum::<f64>()
}

/// ∫ u dΩ over a region with these boundary loops.
pub(crate) fn vector_angle(loops: &[&Loop]) -> Vec3 {
    loops
        .iter()
        .flat_map(|edges| edges.iter())
        .map(Edge::vector_angle)
        .sum()
}

/// Groups loops into the connected regions that they bound: for each loop the number of its region.
///
/// Two loops bound the same region exactly if no loop separates them.
pub(crate) fn regions(loops: &[Loop]) -> Vec<usize> {
    if loops.len() < 2 {
        return vec![0; loops.len()];
    }
    let places: Vec<Vec3> = loops
        .iter()
        .map(|edges| longest(edges).map_or(Vec3::x(), |e| e.point(&e.middle)))
        .collect();
    let mut numbers: HashMap<Vec<bool>, usize> = HashMap::new();
    places
        .iter()
        .enumerate()
        .map(|(index, place)| {
            let sides = loops
                .iter()
                .enumerate()
                .map(|(other, edges)| other == index || on_left(edges, place))
                .collect();
            let next = numbers.len();
            *numbers.entry(sides).or_insert(next)
        })
        .collect()
}

fn longest(edges: &[Edge]) -> Option<&Edge> {
    edges
        .iter()
        .max_by(|a, b| (a.angle * a.radius).total_cmp(&(b.angle * b.radius)))
}

/// Most paths that vote about the side of a point.
const MOST_PATHS: usize = 8;

/// Whether a point of the sphere lies on the left of a loop, the side of the region. Several paths
/// vote, each with the sine of the angle at which it leaves the loop: a path along an edge decides
/// nothing.
fn on_left(edges: &[Edge], place: &Vec3) -> bool {
    if let [only] = edges
        && only.is_whole()
    {
        return only.axis.dot(place) < only.height;
    }
    let stride = edges.len().div_ceil(MOST_PATHS).max(1);
    (0..edges.len())
        .step_by(stride)
        .map(|start| vote(edges, start, place))
        .sum::<f64>()
        > 0.0
}

/// Walks from the middle of edge `start` straight to `place` and counts the edges crossed: positive
/// on the left.
fn vote(edges: &[Edge], start: usize, place: &Vec3) -> f64 {
    let Some(first) = edges.get(start) else {
        return 0.0;
    };
    let origin = first.point(&first.middle);
    let normal = origin.cross(place);
    let departure = -normal.cross(&origin).dot(&first.axis);
    let mut crossings = 0;
    for (index, edge) in edges.iter().enumerate() {
        let Some(directions) = edge.meets(&normal) else {
            continue;
        };
        let half = (0.5 * edge.angle).cos();
        let nearer = |a: &Vec3, b: &Vec3| a.dot(&first.middle) > b.dot(&first.middle);
        for (direction, twin) in [
            (directions[0], directions[1]),
            (directions[1], directions[0]),
        ] {
            if index == start && nearer(&direction, &twin) {
                continue; // the origin of the path itself
            }
            let point = edge.point(&direction);
            let on_path =
                origin.cross(&point).dot(&normal) > 0.0 && point.cross(place).dot(&normal) > 0.0;
            if on_path && direction.dot(&edge.middle) >= half {
                crossings += 1;
            }
        }
    }
    if crossings % 2 == 0 {
        departure
    } else {
        -departure
    }
}

/// The boundary of a unit sphere less caps.
pub(crate) struct Boundary {
    pub(crate) edges: Vec<Loop>,
    /// Owners of the caps that the edges belong to, each once.
    pub(crate) owners: Vec<u32>,
}

/// Clips the rims of all caps and joins the pieces; `None` if they do not close. Owners must be
/// different.
pub(crate) fn boundary_loops(caps: &[Cap]) -> Option<Boundary> {
    let mut edges: Vec<Loop> = Vec::new();
    let mut owners = Vec::new();
    // An edge runs against the sense of its arc, from the arc's end to its start, where another cap
    // takes over: its arc ends there. So the key of an edge is (cap at the arc's end, its own cap),
    // its successor's is (own cap, cap at the start).
    let mut open: HashMap<(u32, u32), (Edge, u32)> = HashMap::new();
    let mut arcs = Vec::new();
    let mut order = Vec::new();
    for (index, cap) in caps.iter().enumerate() {
        let frame = CircleFrame::new(cap);
        let edge = |ends: [Vec3; 2], middle: Vec3, angle: f64| Edge {
            axis: cap.axis,
            height: cap.height,
            radius: frame.radius,
            ends,
            middle,
            angle,
        };
        let exposure = exposed_arcs(caps, index, &frame, &mut arcs);
        if exposure == Exposure::Whole {
            edges.push(vec![edge([frame.e1; 2], -frame.e1, 2.0 * PI)]);
        }
        if exposure == Exposure::Whole || !arcs.is_empty() {
            owners.push(cap.owner);
        }
        for arc in &arcs {
            let angle = counter_clockwise_angle(&arc.ends[0], &arc.ends[1]);
            let ([x, y], (sine, cosine)) = (arc.ends[0], (0.5 * angle).sin_cos());
            let middle = frame.direction([x * cosine - y * sine, y * cosine + x * sine]);
            let [start, end] = arc.ends.map(|place| frame.direction(place));
            let key = (arc.owners[1], cap.owner);
            order.push(key);
            if open
                .insert(key, (edge([end, start], middle, angle), arc.owners[0]))
                .is_some()
            {
                return None;
            }
        }
    }
    for first in order {
        let mut chain = Vec::new();
        let mut key = first;
        while let Some((edge, successor)) = open.remove(&key) {
            chain.push(edge);
            key = (key.1, successor);
        }
        if !chain.is_empty() {
            (key == first).then_some(())?;
            edges.push(chain);
        }
    }
    Some(Boundary { edges, owners })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cap(axis: Vec3, height: f64, owner: u32) -> Cap {
        Cap {
            axis: axis.normalize(),
            height,
            owner,
        }
    }

    fn area(caps: &[Cap]) -> (usize, f64) {
        let loops = boundary_loops(caps).unwrap().edges;
        let numbers = regions(&loops);
        let parts = numbers.iter().max().map_or(0, |last| last + 1);
        let part = |n: usize| {
            loops
                .iter()
                .zip(&numbers)
                .filter(|(_, m)| **m == n)
                .map(|(l, _)| l)
                .collect::<Vec<_>>()
        };
        (parts, (0..parts).map(|n| solid_angle(&part(n))).sum())
    }

    #[test]
    fn an_octant_with_a_hole_is_one_region() {
        // The hole lies on the octant's mirror planes, where paths between loops run through the
        // seam of its circle.
        let planes = [
            cap(-Vec3::x(), 0.0, 0),
            cap(-Vec3::y(), 0.0, 1),
            cap(-Vec3::z(), 0.0, 2),
        ];
        assert!((area(&planes).1 - PI / 2.0).abs() < 1e-12);
        for axis in [
            Vec3::repeat(1.0),
            Vec3::new(1.0, 1.0, 1.2),
            Vec3::new(1.0, 0.9, 1.0),
            Vec3::new(1.3, 1.0, 1.0),
        ] {
            for height in [0.9, 0.95, 0.99] {
                let caps = [planes[0], planes[1], planes[2], cap(axis, height, 3)];
                let (parts, solid_angle) = area(&caps);
                assert_eq!(parts, 1);
                assert!((solid_angle - (PI / 2.0 - 2.0 * PI * (1.0 - height))).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn a_band_falls_apart_when_it_is_cut_through_twice() {
        let band = [cap(Vec3::z(), 0.3, 0), cap(-Vec3::z(), 0.3, 1)];
        let (parts, whole) = area(&band);
        assert_eq!(parts, 1);
        assert!((whole - 4.0 * PI * 0.3).abs() < 1e-12);
        let once = [band[0], band[1], cap(Vec3::x(), 0.8, 2)];
        assert_eq!(area(&once).0, 1);
        let twice = [
            band[0],
            band[1],
            cap(Vec3::x(), 0.8, 2),
            cap(-Vec3::x(), 0.8, 3),
        ];
        let (parts, rest) = area(&twice);
        assert_eq!(parts, 2);
        assert!((whole - rest - 2.0 * (whole - area(&once).1)).abs() < 1e-12);
    }
}
