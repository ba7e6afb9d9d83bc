//! Signed distances at many points.
//!
//! A single query waits for one list entry after the other. Points of the same cell of the index see
//! the same lists, so they go through them side by side, [`LANES`] at a time, in single precision about
//! the middle of the cell. Points for which the rounding could matter are asked for alone: those as deep in
//! one ball as in another, of which one may be hidden, and those next to the surface, whose sign counts.

use super::index::{Cell, Entry, Lists};
use super::{BAND_ANGSTROM, SesSolid};
use protomer_kernel::Vec3;
use protomer_kernel::vectorised;

/// Points that are looked at side by side.
const LANES: usize = 16;
/// Entries of a list between two looks at whether the rest of it is too far.
const STRIDE: usize = 4;
/// More than the error of a distance, in units of the radius of the largest ball.
const ERROR_PER_RADIUS: f64 = 4e-6;
/// More than the rounding of a bound, of itself and in Å.
const ROUNDING: f32 = 1e-6;
const ROUNDING_ANGSTROM: f32 = 1e-5;
/// No feature.
const NOTHING: u32 = u32::MAX;
/// Two features between which single precision cannot decide.
const TIE: u32 = u32::MAX - 1;

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
    fn at(&self, lane: usize, probe_radius: f64) -> (f64, Nearest) {
        let value = probe_radius - f64::from(self.squares[lane]).sqrt();
        match (self.arcs[lane], self.vertices[lane]) {
            (NOTHING, NOTHING) => (-BAND_ANGSTROM, Nearest::Nowhere),
            (NOTHING, vertex) => (value, Nearest::Vertex(vertex)),
            (arc, _) => (value, Nearest::Arc(arc)),
        }
    }
}

/// Where the accessible point nearest to a point is.
pub(super) enum Nearest {
    /// At the point itself.
    Here,
    /// Out of reach.
    Nowhere,
    /// At this point.
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
        let mut order = Vec::with_capacity(points.len());
        for (number, point) in (0_u64..).zip(points) {
            match self.index.cell_of(point) {
                Some(cell) => order.push(u64::from(cell.list) << 32 | number),
                None => visit(number as usize, self.largest_value(), Nearest::Here),
            }
        }
        order.sort_unstable();
        let number = |entry: &u64| *entry as u32 as usize;
        let mut at_edges = Vec::new();
        for of_cell in order.chunk_by(|a, b| a >> 32 == b >> 32) {
            let Some(cell) = self.index.cell_of(&points[number(&of_cell[0])]) else {
                continue;
            };
            let lists = self.index.lists(cell.list);
            at_edges.clear();
            for some in of_cell.chunks(LANES) {
                let lanes = Lanes::new(some.iter().map(|entry| &points[number(entry)]), &cell);
                let deepest = self.deepest_of(&lanes, lists.atoms, &cell);
                for (entry, atom) in some.iter().zip(deepest) {
                    let number = number(entry);
                    let point = &points[number];
                    let known = match atom {
                        TIE => Some(self.nearest_alone(point)),
                        _ => self.nearest_on_atom(point, atom),
                    };
                    match known {
                        Some((value, nearest)) => visit(number, value, nearest),
                        None => at_edges.push(number),
                    }
                }
            }
            for some in at_edges.chunks(LANES) {
                let lanes = Lanes::new(some.iter().map(|number| &points[*number]), &cell);
                let edges = self.nearest_edges(&lanes, &lists, &cell);
                for (lane, number) in some.iter().enumerate() {
                    let (mut value, mut nearest) = edges.at(lane, self.probe_radius);
                    if value.abs() < self.error_angstrom() {
                        (value, nearest) = self.nearest_alone(&points[*number]);
                    }
                    visit(*number, value, nearest);
                }
            }
        }
    }

    /// The error of distances of many points is less than this, Å.
    fn error_angstrom(&self) -> f64 {
        ERROR_PER_RADIUS * self.largest_radius
    }

    fn nearest_alone(&self, point: &Vec3) -> (f64, Nearest) {
        let (value, probe) = self.signed_distance_and_probe(point);
        (value, probe.map_or(Nearest::Nowhere, Nearest::At))
    }

    /// What is nearest to a point that lies deepest in the ball of an atom; `None` for an arc or a
    /// vertex.
    fn nearest_on_atom(&self, point: &Vec3, atom: u32) -> Option<(f64, Nearest)> {
        if atom == NOTHING {
            return Some((self.largest_value(), Nearest::Here));
        }
        let depth = self.radii[atom as usize] - (point - self.centres[atom as usize]).norm();
        if let Some(value) = self.value_at_depth(depth) {
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
        deepest_of, deepest_of_any, deepest_of_avx512, deepest_of_avx2,
        (lanes: &Lanes, atoms: &[Entry], cell: &Cell) -> [u32; LANES]
    );

    #[inline(always)]
    fn deepest_of_any(&self, lanes: &Lanes, atoms: &[Entry], cell: &Cell) -> [u32; LANES] {
        let [x, y, z] = &lanes.places;
        // How far outside the two balls a point is in which it is deepest.
        let (mut outside, mut second) = ([f32::INFINITY; LANES], [f32::INFINITY; LANES]);
        let mut deepest = [NOTHING; LANES];
        for some in atoms.chunks(STRIDE) {
            if some[0].is_beyond(lanes.limit(&second)) {
                break;
            }
            for entry in some {
                let atom = entry.number;
                let [cx, cy, cz] = cell.seen(&self.centres[atom as usize]);
                let radius = self.radii[atom as usize] as f32;
                for lane in 0..LANES {
                    let (dx, dy, dz) = (x[lane] - cx, y[lane] - cy, z[lane] - cz);
                    let this = (dx * dx + dy * dy + dz * dz).sqrt() - radius;
                    let is_deeper = this < outside[lane];
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
            let is_tied = second[lane] - outside[lane] < error;
            deepest[lane] = if is_tied { TIE } else { deepest[lane] };
        }
        deepest
    }

    vectorised!(
        /// The arc or the vertex nearest to each point, within reach.
        nearest_edges, nearest_edges_any, nearest_edges_avx512, nearest_edges_avx2,
        (lanes: &Lanes, lists: &Lists, cell: &Cell) -> Edges
    );

    #[inline(always)]
    fn nearest_edges_any(&self, lanes: &Lanes, lists: &Lists, cell: &Cell) -> Edges {
        let [x, y, z] = &lanes.places;
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
                    let along = dx * ax + dy * ay + dz * az;
                    let (ox, oy, oz) = (dx - along * ax, dy - along * ay, dz - along * az);
                    let out = (ox * ox + oy * oy + oz * oz).sqrt();
                    let gap = out - radius;
                    let square = along * along + gap * gap;
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
            from_middle: [f32::MIN; LANES],
        };
        for (lane, point) in points.enumerate() {
            let seen = cell.seen(point);
            for (places, x) in lanes.places.iter_mut().zip(seen) {
                places[lane] = x;
            }
            let [x, y, z] = seen;
            let from_middle = (x * x + y * y + z * z).sqrt();
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
        }
    }
}
