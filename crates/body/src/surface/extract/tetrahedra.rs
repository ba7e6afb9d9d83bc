//! Triangles from the signs of a body-centred cubic lattice.
//!
//! The lattice's tetrahedra: every edge between two neighbouring nodes of the same kind (even-even or odd-odd) is ringed
//! by four nodes of the other kind; the edge and two successive nodes of the ring span one tetrahedron. Each has two such
//! edges, one even and one odd, so walking the rings of the even edges finds each tetrahedron once.

use super::lattice::{BLOCK, Block, CELLS, Cell, NODES, SparseLattice, node_index};
use crate::surface::implicit::ImplicitSolid;
use protomer_kernel::{TriangleMesh, Vec3};

/// A vertex keeps this fraction of its edge away from both ends, so that no triangle of the first mesh is degenerate;
/// the vertices are projected to the surface later.
const CLEARANCE: f64 = 0.1;
/// Edges that a cell owns: 3 even-even, 8 even-odd, 3 odd-odd.
const EDGES: usize = 14;
/// Cells along the edge of a block with a rim of one cell.
const RIM: i32 = BLOCK + 2;
const RIM_CELLS: usize = (RIM * RIM * RIM) as usize;
const NOTHING: u32 = u32::MAX;

/// A node as seen from a block: cell counted from the block's first cell, from -1 to `BLOCK`.
#[derive(Clone, Copy)]
struct Node {
    cell: Cell,
    odd: bool,
}

/// One marching pass over all blocks.
struct March<'a> {
    solid: &'a dyn ImplicitSolid,
    lattice: &'a SparseLattice<'a>,
    /// Inside-first even permutations of a tetrahedron's corners, by the set of inside corners.
    orders: [[usize; 4]; 16],
    /// The vertex on each edge, by block, cell and kind of edge.
    vertex_on: Vec<[u32; CELLS * EDGES]>,
    mesh: TriangleMesh,
}

/// The triangles that separate inside nodes from outside nodes.
pub(super) fn march(solid: &dyn ImplicitSolid, lattice: &SparseLattice) -> TriangleMesh {
    let mut march = March {
        solid,
        lattice,
        orders: std::array::from_fn(inside_first),
        vertex_on: vec![[NOTHING; CELLS * EDGES]; lattice.blocks.len()],
        mesh: TriangleMesh::default(),
    };
    for block in &lattice.blocks {
        march.block(block);
    }
    march.mesh
}

impl March<'_> {
    fn block(&mut self, block: &Block) {
        let rim = Rim::of(block, self.lattice);
        if rim.is_uniform() {
            return;
        }
        for i in 0..CELLS as i32 {
            let cell = [i / (BLOCK * BLOCK), i / BLOCK % BLOCK, i % BLOCK];
            for axis in 0..3 {
                self.ring(&rim, cell, axis);
            }
        }
    }

    /// The four tetrahedra around the even edge from `cell` along `axis`.
    fn ring(&mut self, rim: &Rim, cell: Cell, axis: usize) {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        let end = shifted(cell, axis, 1);
        let back = shifted(cell, u, -1);
        let ring = [shifted(back, v, -1), shifted(cell, v, -1), cell, back];
        let edge = [Node { cell, odd: false }, Node { cell: end, odd: false }];
        let ring = ring.map(|cell| Node { cell, odd: true });
        let [from, to] = edge.map(|node| rim.value(node));
        let around = ring.map(|node| rim.value(node));
        let inside = from < 0.0;
        if inside == (to < 0.0) && around.iter().all(|value| inside == (*value < 0.0)) {
            return;
        }
        for i in 0..4 {
            let j = (i + 1) % 4;
            self.tetrahedron(rim, [edge[0], edge[1], ring[i], ring[j]], [from, to, around[i], around[j]]);
        }
    }

    /// The sheet inside one tetrahedron, given in positive orientation: nothing, a triangle, or a quadrangle cut in two
    /// along its shorter diagonal.
    fn tetrahedron(&mut self, rim: &Rim, nodes: [Node; 4], values: [f64; 4]) {
        let mask = (0..4).filter(|&i| values[i] < 0.0).fold(0, |mask, i| mask | 1 << i);
        // A node that is not there belongs to a block that the surface does not come near.
        if mask == 0 || mask == 15 || values.iter().any(|value| value.is_nan()) {
            return;
        }
        let order = self.orders[mask];
        let mut on = |i: usize, j: usize| {
            let (i, j) = (order[i], order[j]);
            self.vertex(rim, (nodes[i], values[i]), (nodes[j], values[j]))
        };
        match mask.count_ones() {
            1 => {
                let triangle = [on(0, 1), on(0, 2), on(0, 3)];
                self.mesh.triangles.push(triangle);
            }
            2 => {
                let [a, b, c, d] = [on(0, 2), on(0, 3), on(1, 3), on(1, 2)];
                let at = |vertex: u32| self.mesh.vertices[vertex as usize];
                // Equal diagonals must be a tie in every orientation of the body, whatever the rounding.
                let cut_ac = (at(a) - at(c)).norm_squared() <= (at(b) - at(d)).norm_squared() * (1.0 + 1e-9);
                let halves = if cut_ac { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] };
                self.mesh.triangles.extend(halves);
            }
            _ => {
                let triangle = [on(0, 3), on(1, 3), on(2, 3)];
                self.mesh.triangles.push(triangle);
            }
        }
    }

    /// The vertex on the edge between an inside and an outside node, made when first asked for.
    fn vertex(&mut self, rim: &Rim, inside: (Node, f64), outside: (Node, f64)) -> u32 {
        let (owner, kind) = owner_of_edge(inside.0, outside.0);
        let (block, cell) = rim.locate(owner);
        let slot = &mut self.vertex_on[block as usize][cell * EDGES + kind];
        if *slot == NOTHING {
            *slot = self.mesh.vertices.len() as u32;
            let [from, to] = [inside.0, outside.0].map(|node| self.lattice.node(rim.global(node.cell), node.odd));
            let exact = |value: f64, point: &Vec3| {
                if value.is_finite() { value } else { self.solid.signed_distance(point) }
            };
            let (low, high) = (exact(inside.1, &from).min(0.0), exact(outside.1, &to).max(0.0));
            let fraction = if high - low > 0.0 { low / (low - high) } else { 0.5 };
            self.mesh.vertices.push(from + (to - from) * fraction.clamp(CLEARANCE, 1.0 - CLEARANCE));
        }
        *slot
    }
}

/// A block's node values with a rim of one cell of its neighbours' around it.
struct Rim {
    place: Cell,
    /// Indices of the 27 blocks around, this one in the middle.
    neighbours: [u32; 27],
    /// Node values, even and odd; not a number in a block that is not there.
    values: [[f64; RIM_CELLS]; 2],
}

impl Rim {
    fn of(block: &Block, lattice: &SparseLattice) -> Self {
        let neighbours = std::array::from_fn(|i| {
            let i = i as i32;
            let place = [block.place[0] + i / 9 - 1, block.place[1] + i / 3 % 3 - 1, block.place[2] + i % 3 - 1];
            lattice.index_of.get(&place).copied().unwrap_or(NOTHING)
        });
        let mut rim = Self { place: block.place, neighbours, values: [[f64::NAN; RIM_CELLS]; 2] };
        for i in 0..RIM_CELLS as i32 {
            let cell = [i / (RIM * RIM) - 1, i / RIM % RIM - 1, i % RIM - 1];
            let (index, local) = rim.locate(cell);
            if let Some(block) = lattice.blocks.get(index as usize) {
                rim.values[0][i as usize] = block.values[local];
                rim.values[1][i as usize] = block.values[local + NODES / 2];
            }
        }
        rim
    }

    /// Whether no sign changes anywhere in the block and its rim.
    fn is_uniform(&self) -> bool {
        let values = self.values.as_flattened();
        !values.iter().any(|value| *value < 0.0) || !values.iter().any(|value| *value >= 0.0)
    }

    fn value(&self, node: Node) -> f64 {
        let [x, y, z] = node.cell.map(|x| x + 1);
        self.values[usize::from(node.odd)][((x * RIM + y) * RIM + z) as usize]
    }

    /// Index of the block that a cell of the rim belongs to, and of the cell in it.
    fn locate(&self, cell: Cell) -> (u32, usize) {
        let [x, y, z] = cell.map(|x| x.div_euclid(BLOCK) + 1);
        let neighbour = self.neighbours[(x * 9 + y * 3 + z) as usize];
        (neighbour, node_index(cell.map(|x| x.rem_euclid(BLOCK)), false))
    }

    fn global(&self, cell: Cell) -> Cell {
        [0, 1, 2].map(|axis| self.place[axis] * BLOCK + cell[axis])
    }
}

/// The cell that owns an edge, and the kind of the edge, 0 to 13.
fn owner_of_edge(a: Node, b: Node) -> (Cell, usize) {
    if a.odd == b.odd {
        let (low, high) = if a.cell < b.cell { (a.cell, b.cell) } else { (b.cell, a.cell) };
        let axis = (0..3).find(|&axis| low[axis] != high[axis]).unwrap_or(0);
        return (low, axis + if a.odd { 11 } else { 0 });
    }
    let (even, odd) = if a.odd { (b.cell, a.cell) } else { (a.cell, b.cell) };
    let kind = (0..3).fold(0, |kind, axis| kind | ((even[axis] - odd[axis]) as usize) << axis);
    (even, 3 + kind)
}

fn shifted(mut cell: Cell, axis: usize, by: i32) -> Cell {
    cell[axis] += by;
    cell
}

/// The corners 0 to 3 with the members of `mask` first, in an order that is an even permutation.
fn inside_first(mask: usize) -> [usize; 4] {
    let mut order = [0, 1, 2, 3];
    order.sort_by_key(|corner| mask >> corner & 1 == 0);
    let inversions = (0..4).flat_map(|i| (0..i).map(move |j| (j, i))).filter(|&(j, i)| order[j] > order[i]).count();
    if inversions % 2 == 1 {
        // Swap two corners of the same side, of which there are always two among four.
        let first = if mask.count_ones() >= 2 { 0 } else { 2 };
        order.swap(first, first + 1);
    }
    order
}
