//! Triangles from the patches of a dual surface.
//!
//! Every quadrangle of the dual whose corners belong to three or four patches is a polygon of the
//! mesh.

use super::coarsen::{EdgeCounts, Patches, Widths};
use super::dual::{Dual, NOTHING, Quad};
use super::lattice::{Cell, SparseLattice};
use crate::surface::hashing::FastMap;
use protomer_kernel::{TriangleMesh, Vec3};

/// A patch needs at least this many corners in a triangle mesh.
const FEWEST_CORNERS: u32 = 3;

/// The mesh of a dual surface whose vertices are merged; empty if the dual is not closed.
pub(super) fn triangulate(lattice: &SparseLattice, dual: &Dual, widths: &Widths) -> TriangleMesh {
    // A surface that leaves the lattice has edges with fewer than four tiles.
    for quad in &dual.quads {
        if quad.corners.contains(&NOTHING) {
            return TriangleMesh::default();
        }
    }
    let mut patches = Patches::merged(dual, widths);
    // Each round takes at least one patch apart for good, so the loop ends.
    loop {
        let (edges, is_settled) = count_edges(dual, &mut patches);
        if is_settled {
            return Builder::new(lattice, dual, &patches, edges).mesh();
        }
    }
}

/// The edges of all polygons; takes patches apart that have two common edges, or too few corners.
/// True if there were none.
fn count_edges(dual: &Dual, patches: &mut Patches) -> (EdgeCounts, bool) {
    let mut edges = EdgeCounts::new(dual.tiles.len());
    let mut corners = vec![0; dual.tiles.len()];
    let mut wrong = Vec::new();
    for quad in &dual.quads {
        let (polygon, count) = polygon(quad, patches);
        for i in 0..count {
            corners[polygon[i] as usize] += 1;
            let (a, b) = (polygon[i], polygon[(i + 1) % count]);
            // In a triangle mesh an edge has two polygons; more means a second seam.
            if edges.add(a, b) > 2 {
                wrong.extend([a, b]);
            }
        }
    }
    wrong.extend(patches.with_fewer_corners(&corners, FEWEST_CORNERS));
    let mut is_settled = true;
    for patch in wrong {
        is_settled &= !patches.take_apart(patch);
    }
    (edges, is_settled)
}

/// The patches around a quadrangle, in order: 3 or 4, or 0 if there are fewer.
fn polygon(quad: &Quad, patches: &Patches) -> ([u32; 4], usize) {
    let around = quad.corners.map(|vertex| patches.patch(vertex));
    let (mut polygon, mut count) = ([0; 4], 0);
    for i in 0..4 {
        // Corners with the patch of the one before fall
        // together; the first is compared with the last.
        if around[i] != around[(i + 3) % 4] {
            polygon[count] = around[i];
            count += 1;
        }
    }
    // Fewer than three: a seam's interior, which is no polygon.
    (polygon, if count < 3 { 0 } else { count })
}

/// A diagonal of a quadrangle.
enum Diagonal {
    /// The diagonal from the first corner to the third.
    First,
    /// The diagonal from the second corner to the fourth.
    Second,
}

/// Numbers the vertices and cuts the polygons into triangles.
struct Builder<'a> {
    lattice: &'a SparseLattice<'a>,
    dual: &'a Dual,
    patches: &'a Patches,
    edges: EdgeCounts,
    /// The mesh vertex of each patch.
    number: Vec<u32>,
    /// The vertex in the middle of each edge that two patches have twice: along an ambiguous face
    /// two sheets may meet along two seams. Each seam runs around one outside node, by which both
    /// its ends know it.
    middle: FastMap<(u32, u32, Cell), (u32, f64)>,
    mesh: TriangleMesh,
}

impl<'a> Builder<'a> {
    fn new(
        lattice: &'a SparseLattice<'a>,
        dual: &'a Dual,
        patches: &'a Patches,
        edges: EdgeCounts,
    ) -> Self {
        let (number, middle) = (vec![NOTHING; dual.tiles.len()], FastMap::default());
        Self {
            lattice,
            dual,
            patches,
            edges,
            number,
            middle,
            mesh: TriangleMesh::default(),
        }
    }

    fn mesh(mut self) -> TriangleMesh {
        self.place_vertices();
        for quad in &self.dual.quads {
            let (polygon, count) = polygon(quad, self.patches);
            self.polygon(quad, &polygon[..count]);
        }
        self.mesh
    }

    /// Puts the vertex of every patch at the mean of the crossings around its tiles.
    fn place_vertices(&mut self) {
        let mut sums: Vec<(f64, Vec3)> = Vec::new();
        for (vertex, tile) in (0..).zip(&self.dual.tiles) {
            // The vertex's number is that of its patch, given when the patch is first met.
            let number = &mut self.number[self.patches.patch(vertex) as usize];
            if *number == NOTHING {
                *number = sums.len() as u32;
                sums.push((0.0, Vec3::zeros()));
            }
            // Weighted by crossings: the mean does not depend on how the patch was put together.
            let (count, sum) = &mut sums[*number as usize];
            let crossings = tile.crossings();
            *count += crossings.0;
            *sum += crossings.1;
        }
        self.mesh.vertices.reserve_exact(sums.len());
        for (count, sum) in sums {
            self.mesh
                .vertices
                .push(self.lattice.point((sum / count).into()));
        }
    }

    fn polygon(&mut self, quad: &Quad, polygon: &[u32]) {
        let (mut corners, mut count) = ([0; 8], 0);
        for (i, &patch) in polygon.iter().enumerate() {
            corners[count] = self.number[patch as usize];
            count += 1;
            let next = polygon[(i + 1) % polygon.len()];
            // Patches that cannot be taken apart any further
            // share two seams: each gets its own vertex.
            if self.edges.count(patch, next) > 2 {
                corners[count] = self.middle(patch, next, quad);
                count += 1;
            }
        }
        let corners = &corners[..count];
        match (polygon, corners) {
            ([], _) => {}
            (_, &[a, b, c]) => self.mesh.triangles.push([a, b, c]),
            (&[p, q, r, s], &[a, b, c, d]) => match self.diagonal([p, q, r, s], [a, b, c, d]) {
                Some(Diagonal::First) => {
                    // The diagonal is an edge from now on; the
                    // next quadrangle must not use it again.
                    self.edges.add(p, r);
                    self.mesh.triangles.extend([[a, b, c], [a, c, d]]);
                }
                Some(Diagonal::Second) => {
                    self.edges.add(q, s);
                    self.mesh.triangles.extend([[a, b, d], [b, c, d]]);
                }
                None => self.fan(quad, corners),
            },
            _ => self.fan(quad, corners),
        }
    }

    /// The shorter diagonal of a quadrangle if its patches have no edge yet, or else the other one;
    /// `None` if both are taken.
    fn diagonal(&self, [p, q, r, s]: [u32; 4], corners: [u32; 4]) -> Option<Diagonal> {
        let [a, b, c, d] = corners.map(|vertex| self.mesh.vertices[vertex as usize]);
        // Equal diagonals must be a tie in every orientation of the body, whatever the rounding.
        let first_is_shorter = (a - c).norm_squared() <= (b - d).norm_squared() * (1.0 + 1e-9);
        let first_is_free = self.edges.count(p, r) == 0;
        let second_is_free = self.edges.count(q, s) == 0;
        if first_is_free && (first_is_shorter || !second_is_free) {
            Some(Diagonal::First)
        } else if second_is_free {
            Some(Diagonal::Second)
        } else {
            None
        }
    }

    /// Triangles about the place where the surface crosses the edge of a quadrangle.
    fn fan(&mut self, quad: &Quad, corners: &[u32]) {
        let number = self.mesh.vertices.len() as u32;
        let centre = self.lattice.point(quad.crossing());
        self.mesh.vertices.push(centre);
        // The last corner is joined with the first.
        for (&a, &b) in corners.iter().zip(corners.iter().cycle().skip(1)) {
            self.mesh.triangles.push([a, b, number]);
        }
    }

    /// The vertex in the middle of the seam between two patches that ends at `quad`: the mean of
    /// both ends.
    fn middle(&mut self, a: u32, b: u32, quad: &Quad) -> u32 {
        let new = self.mesh.vertices.len() as u32;
        let (vertex, ends) = self
            .middle
            .entry((a.min(b), a.max(b), quad.outside()))
            .or_insert((new, 0.0));
        // Met first at this end of its seam; the other end moves it to the mean.
        if *vertex == new {
            self.mesh.vertices.push(Vec3::zeros());
        }
        let place = &mut self.mesh.vertices[*vertex as usize];
        let end = self.lattice.point(quad.crossing());
        *place = (*place * *ends + end) / (*ends + 1.0);
        *ends += 1.0;
        *vertex
    }
}
