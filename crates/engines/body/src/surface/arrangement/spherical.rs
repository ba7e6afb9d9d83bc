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
}

/// A closed boundary curve of a region.
pub(crate) type Loop = Vec<Edge>;

/// The sum Σ h φ - Σ ε over one loop.
fn turning(edges: &[Edge]) -> f64 {
    let mut curvature = 0.0;
    for edge in edges {
        curvature += edge.height * edge.angle;
    }
    // A whole circle has no corners.
    if let [only] = edges
        && only.is_whole()
    {
        return curvature;
    }
    let mut corners = 0.0;
    for (arriving, departing) in edges.iter().zip(edges.iter().cycle().skip(1)) {
        corners += exterior_angle(arriving, departing);
    }
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
        // Sine from the cross product, cosine from the scalar one:
        // accurate near 0 and near π, where an arc cosine is not.
        .abs()
        .atan2(before.dot(&after))
}

/// Solid angle of a connected region with these boundary loops.
pub(crate) fn solid_angle(loops: &[&Loop]) -> f64 {
    let mut angle = 0.0;
    for edges in loops {
        angle += turning(edges);
    }
    2.0 * PI * (2.0 - loops.len() as f64) + angle
}

/// ∫ u dΩ over a region with these boundary loops.
pub(crate) fn vector_angle(loops: &[&Loop]) -> Vec3 {
    let mut vector_angle = Vec3::zeros();
    for edge in loops.iter().copied().flatten() {
        vector_angle += edge.vector_angle();
    }
    vector_angle
}

/// Groups loops into the connected regions that they bound: for each region the numbers of its
/// loops.
///
/// Two loops bound the same region exactly if no loop separates them.
pub(crate) fn regions(loops: &[Loop]) -> Vec<Vec<usize>> {
    // The usual case, and no question of sides.
    if let [_] = loops {
        return vec![vec![0]];
    }
    let mut regions: Vec<Vec<usize>> = Vec::new();
    let mut region_of: HashMap<Vec<bool>, usize> = HashMap::new();
    for number in 0..loops.len() {
        let region = *region_of
            .entry(sides(loops, number))
            .or_insert(regions.len());
        if region == regions.len() {
            regions.push(Vec::new());
        }
        regions[region].push(number);
    }
    regions
}

/// Whether the loop `number` lies on the left of each loop; it counts as on the left of itself.
fn sides(loops: &[Loop], number: usize) -> Vec<bool> {
    let mut sides = Vec::with_capacity(loops.len());
    for (other, edges) in loops.iter().enumerate() {
        sides.push(other == number || is_on_left(edges, &loops[number]));
    }
    sides
}

/// Whether a loop lies on the left of the loop `edges`.
///
/// A region lies outside all caps. So a loop has the caps of its own edges on its right, whole, and
/// what holds for a cap of another loop holds for that loop. The loop `edges` turns once about the
/// straight line from the centre of a cap on its left to one on its right, and not at all about a
/// line between two caps on its right. All of the loop keeps the distance of a cap's rim from
/// the cap's centre, so corners that all but coincide, and the edges between them, cannot change the
/// whole number of turns.
fn is_on_left(edges: &[Edge], other: &[Edge]) -> bool {
    let (Some(inside), Some(right)) = (largest_cap(other), largest_cap(edges)) else {
        return false;
    };
    let Some(direction) = (right - inside).try_normalize(0.0) else {
        // The same cap, up to rounding: no direction tells the sides apart.
        return false;
    };
    let line = Line {
        inside,
        right,
        direction,
    };
    let mut angle = 0.0;
    for edge in edges {
        angle += line.turned_by(edge);
    }
    // A loop turns by 0 or ±2π about a line that it does not meet; π is as far from both.
    angle.abs() > PI
}

/// The centre of the largest cap at the edges.
fn largest_cap(edges: &[Edge]) -> Option<Vec3> {
    // The lowest plane cuts off the largest cap, whose centre is farthest from the loop.
    let largest = edges.iter().min_by(|a, b| a.height.total_cmp(&b.height));
    largest.map(|edge| edge.axis)
}

/// Edges shorter than this, in radii, turn by much less than a half turn about any line that is
/// asked about.
const SHORT_EDGE: f64 = 1e-4;

/// A straight line through two points of the unit sphere.
struct Line {
    inside: Vec3,
    right: Vec3,
    direction: Vec3,
}

impl Line {
    /// The angle by which a point that runs along an edge turns about the line.
    ///
    /// Seen along the line the circle of the edge is an ellipse. From outside it no part of it turns
    /// by more than half a turn; about a line through it the angle grows all the way.
    fn turned_by(&self, edge: &Edge) -> f64 {
        let has = |point: &Vec3| edge.axis.dot(point) > edge.height;
        // The chord meets the plane within the
        // circle if its ends are on both sides.
        let is_through = has(&self.inside) != has(&self.right);
        // The edge runs clockwise about its axis.
        let sense = if has(&self.right) { -1.0 } else { 1.0 };
        if edge.is_whole() {
            return if is_through { 2.0 * PI * sense } else { 0.0 };
        }
        let [before, after] = edge
            .ends
            .map(|end| (edge.point(&end) - self.inside).cross(&self.direction));
        let sine = before.cross(&after).dot(&self.direction);
        let angle = sine.atan2(before.dot(&after));
        let is_short = edge.angle * edge.radius < SHORT_EDGE;
        // `atan2` gives the short way round. A long edge about a line
        // through its circle may go the long way; its sense tells.
        if is_through && !is_short && angle * sense < 0.0 {
            angle + 2.0 * PI * sense
        } else {
            angle
        }
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
    let mut boundary = Boundary {
        edges: Vec::new(),
        owners: Vec::new(),
    };
    let mut open = OpenEdges::default();
    let mut arcs = Vec::new();
    for (index, cap) in caps.iter().enumerate() {
        let frame = CircleFrame::new(cap);
        let exposure = exposed_arcs(caps, index, &frame, &mut arcs);
        if exposure == Exposure::Whole {
            let whole = frame.edge([frame.e1; 2], 2.0 * PI);
            boundary.edges.push(vec![whole]);
        }
        if exposure == Exposure::Whole || !arcs.is_empty() {
            boundary.owners.push(cap.owner);
        }
        for arc in &arcs {
            // Never zero: an arc that comes back to its start would be a whole circle.
            let angle = counter_clockwise_angle(&arc.ends[0], &arc.ends[1]);
            let [start, end] = arc.ends.map(|place| frame.direction(place));
            // The cap lies on the right: edges run clockwise, from the arc's end to its start.
            open.add(cap.owner, arc.owners, frame.edge([end, start], angle))?;
        }
    }
    boundary.edges.extend(open.into_loops()?);
    Some(boundary)
}

impl CircleFrame {
    /// A piece of the rim of the cap that the circle belongs to.
    fn edge(&self, ends: [Vec3; 2], angle: f64) -> Edge {
        Edge {
            axis: self.axis,
            height: self.height,
            radius: self.radius,
            ends,
            angle,
        }
    }
}

/// Edges that wait for the edges before and after them.
///
/// An edge runs against the sense of its arc, from the arc's end to its start, where another cap
/// takes over: its arc ends there. So the key of an edge is (cap at the arc's end, its own cap),
/// its successor's is (own cap, cap at the start).
#[derive(Default)]
struct OpenEdges {
    by_key: HashMap<(u32, u32), (Edge, u32)>,
    order: Vec<(u32, u32)>,
}

impl OpenEdges {
    /// Adds an edge of cap `owner`, whose arc is bounded by two others; `None` if there is one with
    /// its key.
    fn add(&mut self, owner: u32, [at_start, at_end]: [u32; 2], edge: Edge) -> Option<()> {
        // Named by the cap where it starts and its own; the next starts here, on `at_start`.
        let key = (at_end, owner);
        self.order.push(key);
        match self.by_key.insert(key, (edge, at_start)) {
            Some(_) => None,
            None => Some(()),
        }
    }

    /// Follows the edges from each to the next; `None` if a chain of them does not close.
    fn into_loops(mut self) -> Option<Vec<Loop>> {
        let mut loops = Vec::new();
        for first in self.order {
            let mut chain = Vec::new();
            let mut key = first;
            while let Some((edge, successor)) = self.by_key.remove(&key) {
                chain.push(edge);
                key = (key.1, successor);
            }
            if chain.is_empty() {
                continue;
            }
            if key != first {
                return None;
            }
            loops.push(chain);
        }
        Some(loops)
    }
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
        let regions = regions(&loops);
        let mut total = 0.0;
        for region in &regions {
            let boundary: Vec<&Loop> = region.iter().map(|&number| &loops[number]).collect();
            total += solid_angle(&boundary);
        }
        (regions.len(), total)
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
