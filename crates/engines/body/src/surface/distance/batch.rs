//! Signed distances at many points.
//!
//! A search for the feature nearest to one point is mostly waiting: each entry of a list decides whether
//! the next one matters. Points in the same cell of the index have the same lists, so they go through them
//! side by side, [`LANES`] at a time, in single precision about the middle of the cell. Points for which
//! rounding could matter are searched for alone, in double precision: those as deep in one ball as in
//! another, since one of the balls may be hidden, and those next to the surface, since their sign counts.

use super::index::{Cell, Entry, Lists};
use super::{BAND_ANGSTROM, SesSolid};
use protomer_kernel::{Vec3, vectorised};
use std::ops::Range;

/// Points that go through the lists side by side.
const LANES: usize = 16;
/// Number of entries of a list after which a search checks whether the rest is too far away to
/// matter.
const STRIDE: usize = 4;
/// Upper bound of the error of a distance, in units of the radius of the largest ball.
const ERROR_PER_RADIUS: f64 = 4e-6;
/// Upper bound of the relative rounding of a bound.
const ROUNDING: f32 = 1e-6;
/// Upper bound of the rounding of a bound in addition to that, Å.
const ROUNDING_ANGSTROM: f32 = 1e-5;
/// No feature.
const NOTHING: u32 = u32::MAX;
/// Two features between which single precision cannot decide.
const TIE: u32 = u32::MAX - 1;

/// Points that follow each other and are in one cell.
struct Run {
    /// The number of the cell's lists.
    list: u32,
    /// The numbers of the points.
    points: Range<u32>,
}

/// Points about the middle of a cell.
pub(super) struct Lanes {
    places: [[f32; LANES]; 3],
    /// Distances from the middle of the cell, Å; those of unused lanes end every search.
    from_middle: [f32; LANES],
}

/// The nearest vertices, the arcs that are nearer, and the squared distances, Å².
#[derive(Debug, PartialEq)]
pub(super) struct Edges {
    vertices: [u32; LANES],
    arcs: [u32; LANES],
    squares: [f32; LANES],
}

impl Edges {
    /// The signed distance of a point, Å, and what it is nearest to.
    fn nearest(&self, lane: usize, probe_radius: f64) -> (f64, Nearest) {
        let value = probe_radius - f64::from(self.squares[lane]).sqrt();
        // Vertices were searched first, so an arc that is noted was nearer than all of them.
        match (self.arcs[lane], self.vertices[lane]) {
            // Nothing within reach: deeper inside than the band.
            (NOTHING, NOTHING) => (-BAND_ANGSTROM, Nearest::Nowhere),
            (NOTHING, vertex) => (value, Nearest::Vertex(vertex)),
            (arc, _) => (value, Nearest::Arc(arc)),
        }
    }
}

/// Accessible point nearest to a point.
pub(super) enum Nearest {
    /// The point itself.
    Here,
    /// A point out of reach.
    Nowhere,
    /// The point at this place.
    At(Vec3),
    Arc(u32),
    Vertex(u32),
}

impl SesSolid {
    /// Visits the number, the signed distance and the nearest accessible point of many points, in the
    /// order of the cells. Distances are right within [`SesSolid::error_angstrom`], and their signs are
    /// those of [`SesSolid::signed_distance_and_probe`].
    pub(super) fn for_each_nearest(
        &self,
        points: &[Vec3],
        mut visit: impl FnMut(usize, f64, Nearest),
    ) {
        let runs = self.runs_in_cells(points, &mut visit);
        let (mut of_cell, mut at_edges) = (Vec::new(), Vec::new());
        // Runs were sorted by list: those of one cell now follow each
        // other, so its lists are read while they are in the cache.
        for in_cell in runs.chunk_by(|a, b| a.list == b.list) {
            of_cell.clear();
            for run in in_cell {
                of_cell.extend(run.points.clone().map(|number| number as usize));
            }
            if let Some(cell) = self.index.cell_of(&points[of_cell[0]]) {
                at_edges.clear();
                self.visit_at_faces(points, &of_cell, &cell, &mut visit, &mut at_edges);
                self.visit_at_edges(points, &at_edges, &cell, &mut visit);
            }
        }
    }

    /// Runs of points by cells; points in cells without lists, which are outside, are visited.
    fn runs_in_cells(
        &self,
        points: &[Vec3],
        visit: &mut impl FnMut(usize, f64, Nearest),
    ) -> Vec<Run> {
        let mut runs: Vec<Run> = Vec::new();
        let (mut last, mut list) = (None, None);
        for (number, point) in (0_u32..).zip(points) {
            // Points come in rows; most are in the cell of the one before, which saves the hash.
            let place = self.index.place_of(point);
            if last != Some(place) {
                (last, list) = (Some(place), self.index.list_at(&place));
                if let Some(list) = list {
                    let points = number..number;
                    runs.push(Run { list, points });
                }
            }
            match runs.last_mut() {
                Some(run) if list.is_some() => run.points.end = number + 1,
                // No list: no atom is near enough to matter here.
                _ => visit(number as usize, self.largest_value(), Nearest::Here),
            }
        }
        // List first, then number: in a cell the points keep their order.
        runs.sort_unstable_by_key(|run| u64::from(run.list) << 32 | u64::from(run.points.start));
        runs
    }

    /// Visits those points of a cell whose depth in a ball tells their distance; the numbers of the others
    /// are added to `at_edges`.
    fn visit_at_faces(
        &self,
        points: &[Vec3],
        of_cell: &[usize],
        cell: &Cell,
        visit: &mut impl FnMut(usize, f64, Nearest),
        at_edges: &mut Vec<usize>,
    ) {
        let atoms = self.index.lists(cell.list).atoms;
        for some in of_cell.chunks(LANES) {
            let lanes = Lanes::new(some.iter().map(|number| &points[*number]), cell);
            for (number, atom) in some.iter().zip(self.deepest_of(&lanes, atoms, cell)) {
                let point = &points[*number];
                let surface_point = match atom {
                    // One of the two balls may be hidden where the point projects to; double
                    // precision decides which is deeper, and exposure is asked of that one.
                    TIE => Some(self.nearest_alone(point)),
                    _ => self.nearest_on_atom(point, atom),
                };
                match surface_point {
                    Some((value, nearest)) => visit(*number, value, nearest),
                    // The projection onto the deepest ball is not
                    // exposed: the nearest point is on an edge.
                    None => at_edges.push(*number),
                }
            }
        }
    }

    /// Visits points of a cell that are nearest to an arc or a vertex.
    fn visit_at_edges(
        &self,
        points: &[Vec3],
        at_edges: &[usize],
        cell: &Cell,
        visit: &mut impl FnMut(usize, f64, Nearest),
    ) {
        let lists = self.index.lists(cell.list);
        for some in at_edges.chunks(LANES) {
            let lanes = Lanes::new(some.iter().map(|number| &points[*number]), cell);
            let edges = self.nearest_edges(&lanes, &lists, cell);
            for (lane, number) in some.iter().enumerate() {
                let (mut value, mut nearest) = edges.nearest(lane, self.probe_radius);
                // So near to the surface the sign could be wrong, and signs decide the topology.
                if value.abs() < self.error_angstrom() {
                    (value, nearest) = self.nearest_alone(&points[*number]);
                }
                visit(*number, value, nearest);
            }
        }
    }

    /// Distances found side by side err by less than this, Å.
    pub(super) fn error_angstrom(&self) -> f64 {
        ERROR_PER_RADIUS * self.largest_radius
    }

    fn nearest_alone(&self, point: &Vec3) -> (f64, Nearest) {
        let (value, probe) = self.signed_distance_and_probe(point);
        (value, probe.map_or(Nearest::Nowhere, Nearest::At))
    }

    /// Signed distance, Å, and nearest accessible point of a point that lies deepest in the ball of
    /// an atom; `None` if an arc or a vertex is nearest.
    fn nearest_on_atom(&self, point: &Vec3, atom: u32) -> Option<(f64, Nearest)> {
        if atom == NOTHING {
            // No atom is near the cell.
            return Some((self.largest_value(), Nearest::Here));
        }
        let depth = self.radii[atom as usize] - (point - self.centres[atom as usize]).norm();
        if let Some(value) = self.value_at_depth(depth) {
            // Depth exactly 0 is on the accessible surface: the probe itself may stand there.
            let is_outside = depth <= 0.0;
            let nearest = if is_outside {
                Nearest::Here
            } else {
                Nearest::Nowhere
            };
            return Some((value, nearest));
        }
        let onto = self.on_face(point, atom)?;
        Some((self.probe_radius - depth, Nearest::At(onto)))
    }

    vectorised!(
        /// The ball in which each point lies deepest, [`NOTHING`] or [`TIE`].
        fn deepest_of[deepest_of_avx512, deepest_of_avx2, deepest_of_any](self: &Self, lanes: &Lanes, atoms: &[Entry], cell: &Cell) -> [u32; LANES]
    );

    #[inline(always)]
    fn deepest_of_any(&self, lanes: &Lanes, atoms: &[Entry], cell: &Cell) -> [u32; LANES] {
        let [x, y, z] = &lanes.places;
        // How far outside the two balls a point is in which it is deepest.
        let (mut outside, mut second) = ([f32::INFINITY; LANES], [f32::INFINITY; LANES]);
        let mut deepest = [NOTHING; LANES];
        for some in atoms.chunks(STRIDE) {
            // The chunk's first entry has its smallest bound. The second
            // best counts, not the best: a tie must be seen from both balls.
            if some[0].is_beyond(lanes.limit(&second)) {
                break;
            }
            for entry in some {
                let atom = entry.number;
                let [cx, cy, cz] = cell.seen(&self.centres[atom as usize]);
                let radius = self.radii[atom as usize] as f32;
                // Selects, not branches: the compiler turns the loop into vector code of 16 lanes.
                for lane in 0..LANES {
                    let (dx, dy, dz) = (x[lane] - cx, y[lane] - cy, z[lane] - cz);
                    let this = (dx * dx + dy * dy + dz * dz).sqrt() - radius;
                    let is_deeper = this < outside[lane];
                    // The loser of this comparison is a candidate for second place.
                    let other = if is_deeper { outside[lane] } else { this };
                    second[lane] = if other < second[lane] {
                        other
                    } else {
                        second[lane]
                    };
                    outside[lane] = if is_deeper { this } else { outside[lane] };
                    deepest[lane] = if is_deeper { atom } else { deepest[lane] };
                }
            }
        }
        let error = self.error_angstrom() as f32;
        for lane in 0..LANES {
            // The true order of two depths is certain only if they differ by more than the error.
            let is_tied = second[lane] - outside[lane] < error;
            deepest[lane] = if is_tied { TIE } else { deepest[lane] };
        }
        deepest
    }

    vectorised!(
        /// The arc or the vertex nearest to each point, within reach.
        fn nearest_edges[nearest_edges_avx512, nearest_edges_avx2, nearest_edges_any](self: &Self, lanes: &Lanes, lists: &Lists, cell: &Cell) -> Edges
    );

    #[inline(always)]
    fn nearest_edges_any(&self, lanes: &Lanes, lists: &Lists, cell: &Cell) -> Edges {
        let [x, y, z] = &lanes.places;
        // Starts at the reach: what is farther counts as nothing.
        let reach = self.reach() as f32;
        let mut best = [reach * reach; LANES];
        let mut vertices = [NOTHING; LANES];
        for some in lists.vertices.chunks(STRIDE) {
            if some[0].is_beyond(lanes.limit(&roots(&best))) {
                break;
            }
            for entry in some {
                let [vx, vy, vz] = cell.seen(&self.vertices[entry.number as usize]);
                for lane in 0..LANES {
                    let (dx, dy, dz) = (x[lane] - vx, y[lane] - vy, z[lane] - vz);
                    let square = dx * dx + dy * dy + dz * dz;
                    let is_nearer = square < best[lane];
                    best[lane] = if is_nearer { square } else { best[lane] };
                    vertices[lane] = if is_nearer {
                        entry.number
                    } else {
                        vertices[lane]
                    };
                }
            }
        }
        // With the squares that the vertices left: an arc wins only if it is nearer than those.
        let mut arcs = [NOTHING; LANES];
        for some in lists.arcs.chunks(STRIDE) {
            if some[0].is_beyond(lanes.limit(&roots(&best))) {
                break;
            }
            for entry in some {
                let this = &self.arcs[entry.number as usize];
                let [cx, cy, cz] = cell.seen(&this.centre);
                let [ax, ay, az] = [0, 1, 2].map(|axis| this.axis[axis] as f32);
                let [mx, my, mz] = [0, 1, 2].map(|axis| this.middle[axis] as f32);
                let (radius, cosine) = (this.radius as f32, this.cosine_half_angle as f32);
                for lane in 0..LANES {
                    let (dx, dy, dz) = (x[lane] - cx, y[lane] - cy, z[lane] - cz);
                    // Cylindrical coordinates about the circle's axis: along it, and out from it.
                    let projection = dx * ax + dy * ay + dz * az;
                    let (ox, oy, oz) = (
                        dx - projection * ax,
                        dy - projection * ay,
                        dz - projection * az,
                    );
                    let out = (ox * ox + oy * oy + oz * oz).sqrt();
                    // Squared distance from the circle; the nearest
                    // point lies in the half-plane of the point.
                    let gap = out - radius;
                    let square = projection * projection + gap * gap;
                    // The direction ρ = o / |o| is on the arc if ρ·middle >= cosine;
                    // times |o|, so that a point on the axis divides nothing. The
                    // middle is normal to the axis, so d·middle = o·middle.
                    let is_on_arc = dx * mx + dy * my + dz * mz >= cosine * out;
                    let is_nearer = is_on_arc & (square < best[lane]);
                    best[lane] = if is_nearer { square } else { best[lane] };
                    arcs[lane] = if is_nearer { entry.number } else { arcs[lane] };
                }
            }
        }
        Edges {
            vertices,
            arcs,
            squares: best,
        }
    }
}

impl Lanes {
    fn new<'a>(points: impl Iterator<Item = &'a Vec3>, cell: &Cell) -> Self {
        let mut lanes = Self {
            places: [[0.0; LANES]; 3],
            // Unused lanes sit at the middle of the cell with a
            // limit of -∞, nearly: they never keep a search going.
            from_middle: [f32::MIN; LANES],
        };
        for (lane, point) in points.enumerate() {
            let coordinates = cell.seen(point);
            for (places, x) in lanes.places.iter_mut().zip(coordinates) {
                places[lane] = x;
            }
            let [x, y, z] = coordinates;
            let from_middle = (x * x + y * y + z * z).sqrt();
            // Rounded up: a limit too large costs a few entries, one too small a wrong neighbour.
            lanes.from_middle[lane] = from_middle * (1.0 + ROUNDING) + ROUNDING_ANGSTROM;
        }
        lanes
    }

    /// The bound of features that are farther from every point than the best found.
    #[inline(always)]
    fn limit(&self, best: &[f32; LANES]) -> f32 {
        let mut limits = [0.0; LANES];
        for lane in 0..LANES {
            limits[lane] = best[lane] + self.from_middle[lane];
        }
        // The maximum by halves: log₂ 16 = 4 steps, each a vector operation.
        let mut half = LANES / 2;
        while half > 0 {
            for lane in 0..half {
                let (a, b) = (limits[lane], limits[lane + half]);
                limits[lane] = if a > b { a } else { b };
            }
            half /= 2;
        }
        limits[0]
    }
}

#[inline(always)]
fn roots(squares: &[f32; LANES]) -> [f32; LANES] {
    let mut roots = [0.0; LANES];
    for lane in 0..LANES {
        roots[lane] = squares[lane].sqrt();
    }
    roots
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::surface::ImplicitSolid;

    pub(in super::super) fn lanes_do_not_depend_on_the_processor(solid: &SesSolid) {
        let (low, high) = solid.bounds();
        for step in 0..200 {
            let point = low + (high - low) * (f64::from(step) / 200.0);
            let Some(cell) = solid.index.cell_of(&point) else {
                continue;
            };
            let lists = solid.index.lists(cell.list);
            let points = [0.0, 0.1, 0.2].map(|aside| point + Vec3::new(aside, -aside, 0.0));
            let lanes = Lanes::new(points.iter(), &cell);
            assert_eq!(
                solid.deepest_of(&lanes, lists.atoms, &cell),
                solid.deepest_of_any(&lanes, lists.atoms, &cell)
            );
            assert_eq!(
                solid.nearest_edges(&lanes, &lists, &cell),
                solid.nearest_edges_any(&lanes, &lists, &cell)
            );
            for entry in lists.atoms {
                let atom = entry.number as usize;
                let onto = (point - solid.centres[atom]).normalize() * solid.radii[atom];
                assert_eq!(
                    solid.exposure.is_exposed(atom, &onto),
                    solid.exposure.is_exposed_any(atom, &onto)
                );
            }
        }
    }
}
