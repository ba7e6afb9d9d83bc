//! A closed triangle mesh as half-edges, with the three local operations that keep its topology.
//!
//! Half-edge 3t + i runs along side i of triangle t, from corner i to corner i + 1; its twin runs
//! the other way in the neighbouring triangle. Split, flip and collapse take constant time and
//! never change the Euler number.

use crate::{BodyError, Result};
use protomer_kernel::{TriangleMesh, Vec3};

const NONE: u32 = u32::MAX;

/// A closed, oriented mesh under local change. Removed vertices and triangles leave holes in the
/// numbering.
#[derive(Debug, Clone)]
pub(crate) struct HalfEdgeMesh {
    /// Vertex positions, Å.
    pub(crate) positions: Vec<Vec3>,
    /// The shell that each vertex belongs to.
    pub(crate) shell: Vec<u32>,
    /// Number of shells.
    pub(crate) shells: usize,
    origin: Vec<u32>,
    twin: Vec<u32>,
    /// One half-edge that leaves each vertex.
    outgoing: Vec<u32>,
    /// Number of edges at each vertex.
    valence: Vec<u32>,
    /// Scratch for neighbourhood tests: when a vertex was last marked.
    mark: Vec<u32>,
    stamp: u32,
}

fn not_closed() -> BodyError {
    BodyError::Invalid {
        cause: "the first mesh of the surface is not closed".into(),
        remedy: "ask for another base spacing; if that does not help, the solid's distance is not \
                 1-Lipschitz"
            .into(),
    }
}

#[inline]
pub(crate) fn next(half_edge: u32) -> u32 {
    if half_edge % 3 == 2 {
        half_edge - 2
    } else {
        half_edge + 1
    }
}

#[inline]
pub(crate) fn previous(half_edge: u32) -> u32 {
    if half_edge.is_multiple_of(3) {
        half_edge + 2
    } else {
        half_edge - 1
    }
}

impl HalfEdgeMesh {
    /// The half-edges of a closed mesh.
    ///
    /// # Errors
    /// [`BodyError::Invalid`] if an edge is not shared by two triangles of opposite direction.
    pub(crate) fn new(mesh: TriangleMesh) -> Result<Self> {
        let vertices = mesh.vertices.len();
        let origin: Vec<u32> = mesh.triangles.as_flattened().to_vec();
        let Some(twin) = twins(&origin, vertices) else {
            return Err(not_closed());
        };
        let mut outgoing = vec![NONE; vertices];
        let mut valence = vec![0; vertices];
        for (half_edge, &vertex) in (0..).zip(&origin) {
            outgoing[vertex as usize] = half_edge;
            valence[vertex as usize] += 1;
        }
        let (shell, shells) = label_shells(&origin, &twin, &outgoing);
        let mark = vec![0; vertices];
        Ok(Self {
            positions: mesh.vertices,
            shell,
            shells,
            origin,
            twin,
            outgoing,
            valence,
            mark,
            stamp: 0,
        })
    }

    /// The same mesh, numbered without the holes that removed vertices and triangles left.
    pub(crate) fn compacted(&self) -> Self {
        let vertices: Vec<u32> = self.vertices().collect();
        self.renumbered(&vertices, &self.triangles().collect::<Vec<u32>>())
    }

    /// The shells for which `is_kept` is true, in the order of [`Self::to_shells`].
    pub(crate) fn with_shells(&self, is_kept: &[bool]) -> Self {
        let shells = self.triangles_by_shell().into_iter().zip(is_kept);
        let shells = shells.filter(|(_, is_kept)| **is_kept);
        let triangles: Vec<u32> = shells.flat_map(|(triangles, _)| triangles).collect();
        let (mut vertices, mut is_new) = (Vec::new(), vec![true; self.positions.len()]);
        for &triangle in &triangles {
            for vertex in self.triangle(triangle) {
                if std::mem::take(&mut is_new[vertex as usize]) {
                    vertices.push(vertex);
                }
            }
        }
        self.renumbered(&vertices, &triangles)
    }

    /// The mesh of these vertices and triangles alone, in this order. The triangles are all those
    /// at the vertices.
    fn renumbered(&self, vertices: &[u32], triangles: &[u32]) -> Self {
        let mut number = vec![NONE; self.positions.len()];
        for (new, &old) in (0..).zip(vertices) {
            number[old as usize] = new;
        }
        let mut first_of = vec![NONE; self.origin.len() / 3];
        for (new, &old) in (0..).zip(triangles) {
            first_of[old as usize] = 3 * new;
        }
        let mut origin = Vec::with_capacity(3 * triangles.len());
        let mut twin = Vec::with_capacity(3 * triangles.len());
        let mut outgoing = vec![NONE; vertices.len()];
        for &triangle in triangles {
            for old in 3 * triangle..3 * triangle + 3 {
                let from = number[self.origin[old as usize] as usize];
                outgoing[from as usize] = origin.len() as u32;
                origin.push(from);
                let old_twin = self.twin[old as usize];
                // Twins keep their side of the triangle; only the triangle gets another number.
                twin.push(first_of[old_twin as usize / 3] + old_twin % 3);
            }
        }
        let of_vertices = |values: &[u32]| {
            let values = vertices.iter().map(|&old| values[old as usize]);
            values.collect::<Vec<u32>>()
        };
        Self {
            positions: vertices.iter().map(|&old| self.position(old)).collect(),
            shell: of_vertices(&self.shell),
            shells: self.shells,
            valence: of_vertices(&self.valence),
            mark: vec![0; vertices.len()],
            stamp: 0,
            origin,
            twin,
            outgoing,
        }
    }

    /// Each shell as a separate mesh, in the order of their first triangles.
    pub(crate) fn to_shells(&self) -> Vec<TriangleMesh> {
        let mut number = vec![NONE; self.positions.len()];
        let mut shells = Vec::new();
        for triangles in self.triangles_by_shell() {
            let mut shell = TriangleMesh::default();
            for triangle in triangles {
                let corners = self.triangle(triangle).map(|vertex| {
                    let number = &mut number[vertex as usize];
                    if *number == NONE {
                        *number = shell.vertices.len() as u32;
                        shell.vertices.push(self.position(vertex));
                    }
                    *number
                });
                shell.triangles.push(corners);
            }
            shells.push(shell);
        }
        shells
    }

    /// The triangles of each shell, the shells in the order of their first triangles.
    fn triangles_by_shell(&self) -> Vec<Vec<u32>> {
        let mut place = vec![usize::MAX; self.shells];
        let mut triangles_of: Vec<Vec<u32>> = Vec::new();
        for triangle in self.triangles() {
            let [corner, ..] = self.triangle(triangle);
            let place = &mut place[self.shell[corner as usize] as usize];
            if *place == usize::MAX {
                *place = triangles_of.len();
                triangles_of.push(Vec::new());
            }
            triangles_of[*place].push(triangle);
        }
        triangles_of
    }

    /// The mesh without the holes that removed vertices and triangles left.
    pub(crate) fn to_mesh(&self) -> TriangleMesh {
        let mut number = vec![NONE; self.positions.len()];
        let mut mesh = TriangleMesh::default();
        for vertex in self.vertices() {
            number[vertex as usize] = mesh.vertices.len() as u32;
            mesh.vertices.push(self.positions[vertex as usize]);
        }
        for triangle in self.triangles() {
            let corners = self.triangle(triangle);
            mesh.triangles
                .push(corners.map(|vertex| number[vertex as usize]));
        }
        mesh
    }

    /// The existing vertices, in ascending order.
    pub(crate) fn vertices(&self) -> impl Iterator<Item = u32> + '_ {
        (0..self.positions.len() as u32).filter(|&vertex| self.outgoing[vertex as usize] != NONE)
    }

    /// The existing triangles, in ascending order.
    pub(crate) fn triangles(&self) -> impl Iterator<Item = u32> + '_ {
        (0..self.origin.len() as u32 / 3).filter(|&t| self.origin[3 * t as usize] != NONE)
    }

    /// Upper bound of the half-edge numbers.
    pub(crate) fn half_edge_bound(&self) -> u32 {
        self.origin.len() as u32
    }

    /// Whether this half-edge exists and stands for its edge: one of the two does.
    #[inline]
    pub(crate) fn is_edge(&self, half_edge: u32) -> bool {
        // Of two twins the lower number.
        self.origin[half_edge as usize] != NONE && half_edge < self.twin[half_edge as usize]
    }

    /// Corners of a triangle.
    #[inline]
    pub(crate) fn triangle(&self, triangle: u32) -> [u32; 3] {
        let first = 3 * triangle as usize;
        [
            self.origin[first],
            self.origin[first + 1],
            self.origin[first + 2],
        ]
    }

    #[inline]
    pub(crate) fn twin(&self, half_edge: u32) -> u32 {
        self.twin[half_edge as usize]
    }

    /// Start and end of a half-edge.
    #[inline]
    pub(crate) fn ends(&self, half_edge: u32) -> (u32, u32) {
        (
            self.origin[half_edge as usize],
            self.origin[next(half_edge) as usize],
        )
    }

    /// The corner of a half-edge's triangle that is not on it.
    #[inline]
    pub(crate) fn apex(&self, half_edge: u32) -> u32 {
        self.origin[previous(half_edge) as usize]
    }

    #[inline]
    pub(crate) fn position(&self, vertex: u32) -> Vec3 {
        self.positions[vertex as usize]
    }

    #[inline]
    pub(crate) fn length_squared(&self, half_edge: u32) -> f64 {
        let (from, to) = self.ends(half_edge);
        (self.position(from) - self.position(to)).norm_squared()
    }

    /// Twice the area vector of a triangle, pointing out.
    #[inline]
    pub(crate) fn area_vector(&self, triangle: u32) -> Vec3 {
        let [a, b, c] = self.triangle(triangle).map(|vertex| self.position(vertex));
        (b - a).cross(&(c - a))
    }

    /// The half-edges that leave a vertex, clockwise.
    #[inline]
    pub(crate) fn leaving(&self, vertex: u32) -> impl Iterator<Item = u32> + '_ {
        let first = self.outgoing[vertex as usize];
        let mut spoke = first;
        std::iter::from_fn(move || {
            if spoke == NONE {
                return None;
            }
            let current = spoke;
            // Across the spoke and round the neighbouring triangle: clockwise.
            let following = next(self.twin[current as usize]);
            spoke = if following == first { NONE } else { following };
            Some(current)
        })
    }

    /// Number of edges at a vertex.
    #[inline]
    pub(crate) fn valence(&self, vertex: u32) -> u32 {
        self.valence[vertex as usize]
    }

    /// Cuts an edge, and the two triangles next to it, in two at `position`; returns the new
    /// vertex.
    pub(crate) fn split(&mut self, half_edge: u32, position: Vec3) -> u32 {
        let (h, g) = (half_edge, self.twin(half_edge));
        let ((a, b), c, d) = (self.ends(h), self.apex(h), self.apex(g));
        let (h_next, g_next) = (next(h), next(g));
        let middle = self.positions.len() as u32;
        self.positions.push(position);
        self.shell.push(self.shell[a as usize]);
        // h_next starts at the middle once the edge is cut.
        self.outgoing.push(h_next);
        self.mark.push(0);
        self.valence.push(4);
        self.valence[c as usize] += 1;
        self.valence[d as usize] += 1;
        let new = self.origin.len() as u32;
        let (beyond_bc, beyond_ad) = (self.twin(h_next), self.twin(g_next));
        // The new triangles (middle, b, c) and (middle, a, d); the old ones keep a and b.
        self.origin.extend([middle, b, c, middle, a, d]);
        self.twin.extend([NONE; 6]);
        self.origin[h_next as usize] = middle;
        self.origin[g_next as usize] = middle;
        self.join(h, new + 3);
        self.join(g, new);
        self.join(h_next, new + 2);
        self.join(new + 1, beyond_bc);
        self.join(g_next, new + 5);
        self.join(new + 4, beyond_ad);
        // The half-edges that left a and b may now leave the middle.
        self.outgoing[a as usize] = h;
        self.outgoing[b as usize] = g;
        middle
    }

    /// Whether an edge can be turned without making a double edge or a vertex of valence below 3.
    pub(crate) fn can_flip(&mut self, half_edge: u32) -> bool {
        let (a, b) = self.ends(half_edge);
        let (c, d) = (self.apex(half_edge), self.apex(self.twin(half_edge)));
        // One apex: the two triangles close on themselves.
        c != d
            // Both ends lose an edge; with fewer than three a vertex has no disk.
            && self.valence(a) > 3
            && self.valence(b) > 3
            // c and d joined already: the flip would make a second edge between them.
            && self.leaving(c).all(|h| self.ends(h).1 != d)
    }

    /// Turns an edge a-b between triangles (a, b, c) and (b, a, d) into the edge c-d. Only if
    /// [`Self::can_flip`].
    pub(crate) fn flip(&mut self, half_edge: u32) {
        let (h, g) = (half_edge, self.twin(half_edge));
        let ((a, b), c, d) = (self.ends(h), self.apex(h), self.apex(g));
        let [bc, ca, ad, db] =
            [next(h), previous(h), next(g), previous(g)].map(|side| self.twin(side));
        let (first, second) = (h - h % 3, g - g % 3);
        for (lost, gained) in [(a, c), (b, d)] {
            self.valence[lost as usize] -= 1;
            self.valence[gained as usize] += 1;
        }
        for (start, corners) in [(first, [c, a, d]), (second, [d, b, c])] {
            for (i, corner) in corners.into_iter().enumerate() {
                self.origin[start as usize + i] = corner;
                self.outgoing[corner as usize] = start + i as u32;
            }
        }
        self.join(first, ca);
        self.join(first + 1, ad);
        self.join(first + 2, second + 2);
        self.join(second, db);
        self.join(second + 1, bc);
    }

    /// The link condition: collapsing the edge keeps the surface a manifold of the same topology
    /// exactly if its ends have no common neighbours but the two apices, and these keep a valence
    /// of at least 3.
    pub(crate) fn can_collapse(&mut self, half_edge: u32) -> bool {
        let (a, b) = self.ends(half_edge);
        let (c, d) = (self.apex(half_edge), self.apex(self.twin(half_edge)));
        self.mark_neighbours(a);
        let mut common = 0;
        for spoke in self.leaving(b) {
            let neighbour = self.ends(spoke).1;
            // A stamp instead of clearing marks: each test costs only its two neighbourhoods.
            common += u32::from(self.mark[neighbour as usize] == self.stamp);
        }
        c != d && common == 2 && self.valence(c) > 3 && self.valence(d) > 3
    }

    /// Marks the neighbours of a vertex with a new stamp.
    fn mark_neighbours(&mut self, vertex: u32) {
        self.stamp += 1;
        let first = self.outgoing[vertex as usize];
        let mut spoke = first;
        loop {
            let neighbour = self.ends(spoke).1;
            self.mark[neighbour as usize] = self.stamp;
            spoke = next(self.twin(spoke));
            if spoke == first {
                return;
            }
        }
    }

    /// Merges the end of an edge into its start. Only if [`Self::can_collapse`].
    pub(crate) fn collapse(&mut self, half_edge: u32) {
        let (h, g) = (half_edge, self.twin(half_edge));
        let ((a, b), c, d) = (self.ends(h), self.apex(h), self.apex(g));
        let first = self.outgoing[b as usize];
        let mut spoke = first;
        // All spokes of b become spokes of a. By hand, as `leaving` borrows the mesh.
        loop {
            self.origin[spoke as usize] = a;
            spoke = next(self.twin(spoke));
            if spoke == first {
                break;
            }
        }
        let [cb, ac, da, bd] =
            [next(h), previous(h), next(g), previous(g)].map(|side| self.twin(side));
        // The two vanishing triangles are taken out by joining what lay beyond their other sides.
        self.join(cb, ac);
        self.join(da, bd);
        // The half-edges of the removed triangles must not be anyone's `outgoing`.
        self.outgoing[a as usize] = ac;
        self.outgoing[c as usize] = cb;
        self.outgoing[d as usize] = da;
        self.outgoing[b as usize] = NONE;
        // The edge counts at both ends and vanishes, and the edges to c and d fall together: -4.
        self.valence[a as usize] = self.valence[a as usize] + self.valence[b as usize] - 4;
        self.valence[c as usize] -= 1;
        self.valence[d as usize] -= 1;
        for start in [h - h % 3, g - g % 3] {
            for i in 0..3 {
                self.origin[(start + i) as usize] = NONE;
                self.twin[(start + i) as usize] = NONE;
            }
        }
    }

    fn join(&mut self, a: u32, b: u32) {
        self.twin[a as usize] = b;
        self.twin[b as usize] = a;
    }
}

/// The twin of each half-edge: those that lead to a higher vertex are chained by their start, and
/// every other looks for its twin in the chain of its end. `None` for an open mesh.
fn twins(origin: &[u32], vertices: usize) -> Option<Vec<u32>> {
    /// A half-edge of a chain: where it ends, and the one that follows.
    #[derive(Clone, Copy)]
    struct Link {
        end: u32,
        following: u32,
    }
    let mut first = vec![NONE; vertices];
    let nothing = Link {
        end: NONE,
        following: NONE,
    };
    let mut links = vec![nothing; origin.len()];
    let triangles = || origin.as_chunks::<3>().0.iter();
    for (triangle, &[a, b, c]) in triangles().enumerate() {
        for (side, (from, end)) in [(a, b), (b, c), (c, a)].into_iter().enumerate() {
            if from < end {
                let half_edge = 3 * triangle + side;
                let start = &mut first[from as usize];
                let following = std::mem::replace(start, half_edge as u32);
                links[half_edge] = Link { end, following };
            }
        }
    }
    let mut twin = vec![NONE; origin.len()];
    let mut joined = 0;
    for (triangle, &[a, b, c]) in triangles().enumerate() {
        for (side, (from, end)) in [(a, b), (b, c), (c, a)].into_iter().enumerate() {
            if from < end {
                continue;
            }
            let (mut candidate, mut opposite) = (first[end as usize], NONE);
            while candidate != NONE {
                let link = links[candidate as usize];
                if link.end == from {
                    // A second half-edge the same way, or a third
                    // triangle at the edge: not a manifold.
                    if opposite != NONE || twin[candidate as usize] != NONE {
                        return None;
                    }
                    opposite = candidate;
                }
                candidate = link.following;
            }
            if opposite == NONE {
                return None;
            }
            let half_edge = 3 * triangle + side;
            twin[half_edge] = opposite;
            twin[opposite as usize] = half_edge as u32;
            joined += 2;
        }
    }
    // Less than all: some half-edge to a higher vertex was never asked for.
    (joined == origin.len()).then_some(twin)
}

/// The shell of each vertex, and the number of shells.
fn label_shells(origin: &[u32], twin: &[u32], outgoing: &[u32]) -> (Vec<u32>, usize) {
    let mut shell = vec![NONE; outgoing.len()];
    let mut shells = 0;
    let mut stack = Vec::new();
    for seed in 0..outgoing.len() {
        if shell[seed] != NONE || outgoing[seed] == NONE {
            continue;
        }
        shell[seed] = shells;
        stack.push(seed);
        while let Some(vertex) = stack.pop() {
            let first = outgoing[vertex];
            let mut spoke = first;
            loop {
                let neighbour = origin[next(spoke) as usize] as usize;
                if shell[neighbour] == NONE {
                    shell[neighbour] = shells;
                    stack.push(neighbour);
                }
                spoke = next(twin[spoke as usize]);
                if spoke == first {
                    break;
                }
            }
        }
        shells += 1;
    }
    (shell, shells as usize)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn octahedron() -> HalfEdgeMesh {
        HalfEdgeMesh::new(TriangleMesh::octahedron(1.0)).unwrap()
    }

    proptest! {
        /// Whatever is split, flipped and collapsed where it is allowed, the mesh stays a sphere,
        /// and the incremental bookkeeping agrees with one that is made from scratch.
        #[test]
        fn operations_keep_the_topology(choices in prop::collection::vec((0u8..3, any::<prop::sample::Index>()), 1..60)) {
            let mut mesh = octahedron();
            for (kind, index) in choices {
                let edges: Vec<u32> = (0..mesh.half_edge_bound()).filter(|&h| mesh.is_edge(h)).collect();
                let edge = *index.get(&edges);
                let (a, b) = mesh.ends(edge);
                match kind {
                    0 => {
                        let middle = 0.5 * (mesh.position(a) + mesh.position(b));
                        mesh.split(edge, middle);
                    }
                    1 if mesh.can_flip(edge) => mesh.flip(edge),
                    2 if mesh.can_collapse(edge) => mesh.collapse(edge),
                    _ => {}
                }
                let plain = mesh.to_mesh();
                let anew = HalfEdgeMesh::new(plain.clone()).unwrap();
                prop_assert_eq!(anew.shells, 1);
                let compacted = mesh.compacted();
                prop_assert_eq!(&compacted.positions, &anew.positions);
                prop_assert_eq!(&compacted.origin, &anew.origin);
                prop_assert_eq!(&compacted.twin, &anew.twin);
                prop_assert_eq!(&compacted.outgoing, &anew.outgoing);
                prop_assert_eq!(&compacted.valence, &anew.valence);
                prop_assert_eq!(&compacted.shell, &anew.shell);
                let valences = |mesh: &HalfEdgeMesh| mesh.vertices().map(|v| mesh.valence(v)).collect::<Vec<_>>();
                prop_assert_eq!(valences(&mesh), valences(&anew));
                prop_assert!(mesh.vertices().all(|v| mesh.leaving(v).count() == mesh.valence(v) as usize));
                // Orientation and geometry may be degenerate here; the combinatorics may not.
                let edges = plain.triangles.len() * 3 / 2;
                prop_assert_eq!(plain.vertices.len() + plain.triangles.len(), edges + 2);
            }
        }
    }

    /// The slow twin: shells that the plain mesh finds by its edges.
    #[test]
    fn shells_are_those_of_the_plain_mesh() {
        let one = octahedron().to_mesh();
        let mut three = TriangleMesh::default();
        for shift in [0.0, 3.0, 6.0] {
            let moved = one.map_vertices(|vertex| vertex + Vec3::repeat(shift));
            three.vertices.extend(moved.vertices);
        }
        // The triangles of the three take turns, those of the last first.
        for triangle in &one.triangles {
            for first in [12, 0, 6] {
                three.triangles.push(triangle.map(|vertex| vertex + first));
            }
        }
        let mut mesh = HalfEdgeMesh::new(three).unwrap();
        for half_edge in [0, 10, 20, 30] {
            let (a, b) = mesh.ends(half_edge);
            mesh.split(half_edge, 0.5 * (mesh.position(a) + mesh.position(b)));
        }
        assert!(mesh.can_collapse(4));
        mesh.collapse(4);
        let shells = mesh.to_mesh().shells().unwrap();
        assert_eq!(shells.len(), 3);
        assert_eq!(mesh.to_shells(), shells);
        for is_kept in [
            [true, false, true],
            [false, true, false],
            [false, true, true],
        ] {
            let mut kept = TriangleMesh::default();
            for (shell, _) in shells.iter().zip(is_kept).filter(|(_, is_kept)| *is_kept) {
                let first = kept.vertices.len() as u32;
                kept.vertices.extend(&shell.vertices);
                let triangles = shell.triangles.iter();
                kept.triangles
                    .extend(triangles.map(|corners| corners.map(|vertex| vertex + first)));
            }
            let anew = HalfEdgeMesh::new(kept).unwrap();
            let found = mesh.with_shells(&is_kept);
            assert_eq!(found.positions, anew.positions);
            assert_eq!(found.origin, anew.origin);
            assert_eq!(found.twin, anew.twin);
            assert_eq!(found.outgoing, anew.outgoing);
            assert_eq!(found.valence, anew.valence);
        }
    }

    #[test]
    fn an_open_mesh_is_refused() {
        let mut open = octahedron().to_mesh();
        open.triangles.pop();
        assert!(HalfEdgeMesh::new(open).is_err());
    }

    #[test]
    fn a_mesh_with_an_edge_of_four_triangles_is_refused() {
        let mut twice = octahedron().to_mesh();
        twice.triangles.extend(twice.triangles.clone());
        assert!(HalfEdgeMesh::new(twice).is_err());
        let mut turned = octahedron().to_mesh();
        turned.triangles[0].swap(0, 1);
        assert!(HalfEdgeMesh::new(turned).is_err());
        let mut collapsed = octahedron().to_mesh();
        collapsed.triangles[0] = [0, 0, 0];
        assert!(HalfEdgeMesh::new(collapsed).is_err());
    }

    #[test]
    fn a_tetrahedron_cannot_be_collapsed() {
        let vertices = vec![Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::z()];
        let triangles = vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
        let mut mesh = HalfEdgeMesh::new(TriangleMesh {
            vertices,
            triangles,
        })
        .unwrap();
        assert!(
            (0..12).all(|half_edge| !mesh.can_collapse(half_edge) && !mesh.can_flip(half_edge))
        );
    }
}
