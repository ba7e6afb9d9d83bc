//! The signed distance to the solvent-excluded surface.
//!
//! Let A be the space that probe centres may occupy, closed: the complement of the union of the
//! expanded balls. The solvent-excluded solid is what no probe reaches, {x : d(x) > p} with d(x)
//! the distance from x to A, so f = p - d is zero exactly on the surface (Richards, Annu. Rev.
//! Biophys. Bioeng. 6, 151 (1977)). The nearest point of A is one of
//!
//! * the radial projection onto a face, which can only belong to the ball in which x lies deepest:
//!   d ≥ max (R - |x - c|) for every ball, with equality there;
//! * the point of an arc in the half-plane of x through the circle's axis;
//! * a vertex.
//!
//! Inside the solid and between both surfaces f is the signed distance itself, cut off at a fixed
//! depth.

mod batch;
mod exposure;
mod index;
mod project;

use super::arrangement::{Arc, Arrangement};
use super::implicit::{Ball, ImplicitSolid};
use batch::Nearest;
use exposure::Exposure;
use index::{Entry, Feature, FeatureIndex, Kind, Lists, Nearby, limit};
use protomer_kernel::Vec3;

/// Distance to which the function is followed inside and outside the excluded surface, Å. Deeper
/// inside it keeps the value it has there; outside it is followed to the accessible surface if that
/// is farther.
const BAND_ANGSTROM: f64 = 1.0;
/// Edge of the index cells in units of the largest reach of an atom, which then is listed in a few
/// dozen cells; the lists are sorted by distance, so that long ones cost little more than short ones.
const CELL_EDGE_PER_REACH: f64 = 0.6;

/// Distance from the axis of a circle below which all points of the circle count as equally near,
/// Å.
const ON_AXIS_ANGSTROM: f64 = 1e-12;

/// Compact form of an arc for the computation of distances.
#[derive(Debug, Clone, Copy)]
struct CompactArc {
    centre: Vec3,
    axis: Vec3,
    middle: Vec3,
    radius: f64,
    /// Cosine of half the arc's angle: a direction ρ lies on the arc if ρ·middle is at least this.
    cosine_half_angle: f64,
}

/// The solid bounded by the solvent-excluded surface.
///
/// ```
/// use protomer_body::surface::{Arrangement, ImplicitSolid, SesSolid};
/// use protomer_kernel::Vec3;
/// let accessible = Arrangement::new(&[Vec3::zeros()], &[1.7], 1.4)?;
/// let solid = SesSolid::new(&accessible);
/// assert!((solid.signed_distance(&Vec3::new(1.5, 0.0, 0.0)) + 0.2).abs() < 1e-7);
/// # Ok::<(), protomer_body::BodyError>(())
/// ```
#[derive(Debug, Clone)]
pub struct SesSolid {
    probe_radius: f64,
    centres: Vec<Vec3>,
    radii: Vec<f64>,
    exposure: Exposure,
    arcs: Vec<CompactArc>,
    vertices: Vec<Vec3>,
    cover: Vec<(Vec3, f64)>,
    bounds: (Vec3, Vec3),
    /// Largest radius of the expanded balls, Å.
    largest_radius: f64,
    index: FeatureIndex,
}

/// A point of the accessible surface and its distance from the given point.
#[derive(Debug, Clone, Copy)]
struct NearestPoint {
    point: Vec3,
    distance: f64,
}

impl SesSolid {
    /// The solid of an accessible surface.
    pub fn new(accessible: &Arrangement) -> Self {
        let arcs: Vec<CompactArc> = accessible.arcs().iter().map(CompactArc::from_arc).collect();
        let mut vertices = Vec::with_capacity(accessible.vertices().len());
        for vertex in accessible.vertices() {
            vertices.push(vertex.position);
        }
        let (cover, bounds) = cover_of(accessible);
        let radii = accessible.expanded_radii_angstrom();
        let members = accessible.members().iter();
        let largest_radius = members.fold(1e-3, |largest: f64, atom| {
            largest.max(radii[*atom as usize])
        });
        let mut solid = Self {
            probe_radius: accessible.probe_radius_angstrom(),
            centres: accessible.centres().to_vec(),
            radii: radii.to_vec(),
            exposure: Exposure::from_arrangement(accessible),
            arcs,
            vertices,
            cover,
            bounds,
            largest_radius,
            // Empty until the solid exists, since the distances to its arcs are asked of itself.
            index: FeatureIndex::new(1.0, &[], 0.0, |_, _| 0.0),
        };
        solid.index = solid.build_index(accessible.members());
        solid
    }

    fn build_index(&self, members: &[u32]) -> FeatureIndex {
        let reach = self.reach();
        // Outside the balls the value is the probe's radius less
        // the depth; so far out it has reached its largest.
        let beyond = self.largest_value() - self.probe_radius;
        let mut features = Vec::with_capacity(members.len() + self.arcs.len());
        for &number in members {
            features.push(Feature {
                kind: Kind::Atom,
                number,
                centre: self.centres[number as usize],
                radius: self.radii[number as usize] + beyond,
                depth_radius: self.radii[number as usize],
            });
        }
        for (number, arc) in (0..).zip(&self.arcs) {
            let (centre, radius) = arc.ball();
            features.push(Feature {
                kind: Kind::Arc,
                number,
                centre,
                radius: radius + reach,
                depth_radius: 0.0,
            });
        }
        for (number, vertex) in (0..).zip(&self.vertices) {
            features.push(Feature {
                kind: Kind::Vertex,
                number,
                centre: *vertex,
                radius: reach,
                depth_radius: 0.0,
            });
        }
        let distance = |arc: u32, point: &Vec3| {
            let arc = &self.arcs[arc as usize];
            let (centre, radius) = arc.ball();
            let from_ball = (point - centre).norm() - radius;
            // Both bounds hold: from the whole circle, and from the ball
            // about the arc alone, which tells the sides of the circle apart.
            arc.distance_from_circle(point).max(from_ball)
        };
        let cell_edge = CELL_EDGE_PER_REACH * (self.largest_radius + BAND_ANGSTROM);
        FeatureIndex::new(cell_edge, &features, reach, distance)
    }

    /// Distances up to this are found exactly, Å.
    fn reach(&self) -> f64 {
        self.probe_radius + BAND_ANGSTROM
    }

    /// The value far outside, Å.
    fn largest_value(&self) -> f64 {
        self.probe_radius.max(BAND_ANGSTROM)
    }

    /// The ball in which `point` lies deepest, and how deep, Å (negative outside all balls).
    fn deepest(&self, point: &Vec3, atoms: &[Entry], from_middle: f64) -> Option<(u32, f64)> {
        let mut best = None;
        let mut depth = f64::NEG_INFINITY;
        let mut beyond = f32::INFINITY;
        for entry in atoms {
            // Entries are sorted by bound: none behind this one can be deeper.
            if entry.is_beyond(beyond) {
                break;
            }
            let atom = entry.number;
            let radius = self.radii[atom as usize];
            let square = (point - self.centres[atom as usize]).norm_squared();
            // Deeper means nearer to the centre than this; most atoms need no root.
            // Once depth exceeds the radius, no point of this ball is deep
            // enough; the square of a negative number would hide that.
            let nearer_than = radius - depth;
            if nearer_than > 0.0 && square < nearer_than * nearer_than {
                let this = radius - square.sqrt();
                if this > depth {
                    // A depth is at most `from_middle` less the bound: beyond this none is deeper.
                    (depth, beyond) = (this, limit(-this, from_middle));
                    best = Some(atom);
                }
            }
        }
        best.map(|atom| (atom, depth))
    }

    /// The radial projection onto the ball of `atom`, if it is exposed there.
    fn on_face(&self, point: &Vec3, atom: u32) -> Option<Vec3> {
        let atom = atom as usize;
        // A buried atom has no half-spaces, which `is_exposed` would read as all exposed.
        if !self.exposure.atoms[atom] {
            return None;
        }
        let offset = point - self.centres[atom];
        let length = offset.norm();
        let direction = if length > 0.0 {
            offset / length
        } else {
            // At the centre all directions are equally near; any exposed one will do.
            Vec3::x()
        };
        let onto = direction * self.radii[atom];
        let is_exposed = self.exposure.is_exposed(atom, &onto);
        is_exposed.then(|| self.centres[atom] + onto)
    }

    /// The nearest point on the arcs and vertices listed, nearer than `farthest`, to a point this far from
    /// the middle of the cell that they are listed for.
    fn nearest_edge(
        &self,
        point: &Vec3,
        arcs: impl Iterator<Item = Entry>,
        vertices: impl Iterator<Item = Entry>,
        (farthest, from_middle): (f64, f64),
    ) -> Option<NearestPoint> {
        let mut best = farthest * farthest;
        let mut distance = farthest;
        let mut beyond = limit(distance, from_middle);
        let mut nearest_vertex = None;
        // Vertices first: one distance each is cheap, and a good limit spares arcs.
        for entry in vertices {
            if entry.is_beyond(beyond) {
                break;
            }
            let vertex = entry.number;
            let square = (point - self.vertices[vertex as usize]).norm_squared();
            if square < best {
                (best, distance) = (square, square.sqrt());
                beyond = limit(distance, from_middle);
                nearest_vertex = Some(vertex);
            }
        }
        let mut nearest_arc = None;
        for entry in arcs {
            if entry.is_beyond(beyond) {
                break;
            }
            let arc = entry.number;
            let square = self.arcs[arc as usize].distance_squared(point);
            // Strictly less: an arc's end is its vertex, and rounding decides nothing then.
            if square < best {
                (best, distance) = (square, square.sqrt());
                beyond = limit(distance, from_middle);
                nearest_arc = Some(arc);
            }
        }
        // An arc was nearer than every vertex before it.
        let nearest = match (nearest_arc, nearest_vertex) {
            (Some(arc), _) => self.arcs[arc as usize].nearest(point),
            (None, Some(vertex)) => self.vertices[vertex as usize],
            (None, None) => return None,
        };
        Some(NearestPoint {
            point: nearest,
            distance,
        })
    }

    /// The nearest point on the arcs and vertices near `point`, if it is within reach.
    fn nearest_edge_within_reach(&self, point: &Vec3, nearby: &Nearby) -> Option<NearestPoint> {
        let Lists { arcs, vertices, .. } = nearby.lists;
        let (arcs, vertices) = (arcs.iter().copied(), vertices.iter().copied());
        let limit = (self.reach(), nearby.from_middle);
        self.nearest_edge(point, arcs, vertices, limit)
    }

    /// The nearest point of the accessible surface from a point inside it; searches everything if
    /// nothing is near.
    fn nearest_accessible(&self, point: &Vec3) -> Option<NearestPoint> {
        let nearby = self.index.nearby(point);
        if let Some((atom, depth)) = self.deepest(point, nearby.lists.atoms, nearby.from_middle)
            && let Some(onto) = self.on_face(point, atom)
        {
            return Some(NearestPoint {
                point: onto,
                distance: depth,
            });
        }
        let near = self.nearest_edge_within_reach(point, &nearby);
        if near.is_some() {
            return near;
        }
        // Far inside nothing is listed. Rare, so the search without bounds may be slow.
        let arcs = (0..self.arcs.len() as u32).map(Entry::unknown);
        let vertices = (0..self.vertices.len() as u32).map(Entry::unknown);
        self.nearest_edge(point, arcs, vertices, (f64::INFINITY, 0.0))
    }

    /// The ball in which `point` lies deepest, and how deep, Å: a lower bound of its depth in the
    /// accessible solid. Searches everything if nothing is near.
    fn deepest_anywhere(&self, point: &Vec3) -> Option<(u32, f64)> {
        let nearby = self.index.nearby(point);
        let near = self.deepest(point, nearby.lists.atoms, nearby.from_middle);
        if near.is_some() {
            return near;
        }
        let mut exposed = Vec::new();
        for (atom, is_exposed) in self.exposure.atoms.iter().enumerate() {
            if *is_exposed {
                exposed.push(Entry::unknown(atom as u32));
            }
        }
        self.deepest(point, &exposed, 0.0)
    }

    /// The signed distance, Å, of a point at this depth in a ball, if the depth decides it: a probe
    /// centred at the point touches nothing, or the point is too deep inside. `None` otherwise.
    fn value_at_depth(&self, depth: f64) -> Option<f64> {
        if depth <= 0.0 {
            Some((self.probe_radius - depth).min(self.largest_value()))
        } else if depth >= self.reach() {
            // Deeper in a ball than probe and band together: whatever is nearest is beyond reach.
            Some(-BAND_ANGSTROM)
        } else {
            None
        }
    }

    /// The signed distance, and the nearest accessible point if it is within reach.
    fn signed_distance_and_probe(&self, point: &Vec3) -> (f64, Option<Vec3>) {
        let nearby = self.index.nearby(point);
        let Some((atom, depth)) = self.deepest(point, nearby.lists.atoms, nearby.from_middle)
        else {
            return (self.largest_value(), Some(*point));
        };
        if let Some(value) = self.value_at_depth(depth) {
            return (value, (depth <= 0.0).then_some(*point));
        }
        if let Some(onto) = self.on_face(point, atom) {
            return (self.probe_radius - depth, Some(onto));
        }
        match self.nearest_edge_within_reach(point, &nearby) {
            Some(nearest) => (self.probe_radius - nearest.distance, Some(nearest.point)),
            None => (-BAND_ANGSTROM, None),
        }
    }
}

impl ImplicitSolid for SesSolid {
    fn signed_distance(&self, point: &Vec3) -> f64 {
        self.signed_distance_and_probe(point).0
    }

    /// The empty ball is the probe at the nearest accessible point.
    fn signed_distance_and_empty_ball(&self, point: &Vec3) -> (f64, Option<Ball>) {
        let (value, centre) = self.signed_distance_and_probe(point);
        (value, centre.map(|centre| (centre, self.probe_radius)))
    }

    fn signed_distances(&self, points: &[Vec3], values: &mut Vec<f64>) {
        values.clear();
        values.resize(points.len(), 0.0);
        self.for_each_nearest(points, |number, value, _| values[number] = value);
    }

    fn signed_distances_and_empty_balls(
        &self,
        points: &[Vec3],
        results: &mut Vec<(f64, Option<Ball>)>,
    ) {
        results.clear();
        results.resize(points.len(), (0.0, None));
        self.for_each_nearest(points, |number, value, nearest| {
            let centre = match nearest {
                Nearest::Nowhere => None,
                Nearest::Here => Some(points[number]),
                Nearest::At(place) => Some(place),
                Nearest::Arc(arc) => Some(self.arcs[arc as usize].nearest(&points[number])),
                Nearest::Vertex(vertex) => Some(self.vertices[vertex as usize]),
            };
            results[number] = (value, centre.map(|centre| (centre, self.probe_radius)));
        });
    }

    /// Adds balls of the atoms, which are inside the solid.
    fn add_inner_balls(&self, point: &Vec3, reach_angstrom: f64, balls: &mut Vec<Ball>) {
        // These hold for certain: a ball of the atom itself, without the probe, is never outside.
        for entry in self.index.nearby(point).lists.atoms {
            let atom = entry.number;
            let centre = self.centres[atom as usize];
            let radius = self.radii[atom as usize] - self.probe_radius;
            let limit = radius + reach_angstrom;
            if (point - centre).norm_squared() < limit * limit {
                balls.push((centre, radius));
            }
        }
    }

    fn project(&self, point: &Vec3) -> (Vec3, Vec3) {
        project::project(self, point)
    }

    fn pull(&self, point: &Vec3) -> (Vec3, Vec3) {
        project::pull(self, point)
    }

    fn bounds(&self) -> (Vec3, Vec3) {
        self.bounds
    }

    fn cover(&self) -> Vec<Ball> {
        self.cover.clone()
    }
}

impl CompactArc {
    fn from_arc(arc: &Arc) -> Self {
        Self {
            centre: arc.centre,
            axis: arc.axis,
            middle: arc.middle,
            radius: arc.radius,
            // A whole circle holds every direction.
            cosine_half_angle: match arc.vertices {
                Some(_) => (0.5 * arc.angle).cos(),
                None => -2.0,
            },
        }
    }

    /// Square of the distance from `point` to the nearest point of the circle if that lies on the
    /// arc, infinite otherwise. Without branches: most of them would go either way as often.
    #[inline]
    fn distance_squared(&self, point: &Vec3) -> f64 {
        let offset = point - self.centre;
        let projection = offset.dot(&self.axis);
        let height = projection * projection;
        // Rounding may leave a tiny negative square for a point on the axis.
        let out = (offset.norm_squared() - height).max(0.0).sqrt();
        let gap = out - self.radius;
        // The tolerance lets points on the axis, to which all of the arc is equally near, count.
        let on_arc = offset.dot(&self.middle) >= self.cosine_half_angle * out - ON_AXIS_ANGSTROM;
        let square = height + gap * gap;
        if on_arc { square } else { f64::INFINITY }
    }

    /// The nearest point of the circle.
    fn nearest(&self, point: &Vec3) -> Vec3 {
        let offset = point - self.centre;
        let out = offset - self.axis * offset.dot(&self.axis);
        // On the axis there is no direction out: the arc's middle stands for all.
        let direction = out.try_normalize(10.0 * ON_AXIS_ANGSTROM);
        self.centre + direction.unwrap_or(self.middle) * self.radius
    }

    fn distance_from_circle(&self, point: &Vec3) -> f64 {
        let offset = point - self.centre;
        let projection = offset.dot(&self.axis);
        let out = (offset.norm_squared() - projection * projection)
            .max(0.0)
            .sqrt();
        (projection * projection + (out - self.radius).powi(2)).sqrt()
    }

    /// A ball that holds the arc.
    fn ball(&self) -> (Vec3, f64) {
        // More than half the circle: no smaller ball holds it than that about the centre.
        if self.cosine_half_angle <= 0.0 {
            return (self.centre, self.radius);
        }
        // About the middle of the chord; half the chord is radius sin(angle / 2).
        let half_chord = self.radius * (1.0 - self.cosine_half_angle.powi(2)).max(0.0).sqrt();
        (
            self.centre + self.middle * (self.radius * self.cosine_half_angle),
            half_chord,
        )
    }
}

/// Balls that hold the surface, and the bounding box of the exposed atoms.
///
/// A surface point lies on a segment from its nearest accessible point c towards the atoms that
/// touch the probe at c, and as long as it does not pass their centres it lies in one of their
/// expanded balls. Only a probe at a vertex that reaches through the plane of its three atoms can
/// touch beyond; it is covered by a separate ball.
fn cover_of(accessible: &Arrangement) -> (Vec<(Vec3, f64)>, (Vec3, Vec3)) {
    let (centres, radii) = (accessible.centres(), accessible.expanded_radii_angstrom());
    let probe = accessible.probe_radius_angstrom();
    let mut cover = Vec::new();
    let mut low = Vec3::repeat(f64::INFINITY);
    let mut high = Vec3::repeat(-f64::INFINITY);
    for atom in accessible.exposed_atoms() {
        let (centre, radius) = (centres[atom as usize], radii[atom as usize]);
        cover.push((centre, radius));
        // Without the probe: the surface lies on the atoms' own balls or between them.
        let tight = Vec3::repeat(radius - probe);
        (low, high) = (low.inf(&(centre - tight)), high.sup(&(centre + tight)));
    }
    for vertex in accessible.vertices() {
        let [a, b, c] = vertex.atoms.map(|atom| centres[atom as usize]);
        // No plane through the centres: the probe's piece may be anything, so its ball is kept.
        let height = match (b - a).cross(&(c - a)).try_normalize(0.0) {
            Some(normal) => normal.dot(&(vertex.position - a)).abs(),
            None => 0.0,
        };
        if height < probe {
            cover.push((vertex.position, probe));
        }
    }
    let margin = Vec3::repeat(1e-6);
    (cover, (low - margin, high + margin))
}

#[cfg(test)]
mod tests;
