//! The quadrangles dual to the crossed edges of the lattice.
//!
//! Every sheet in a cell is a vertex, every crossed edge a quadrangle of the sheets in the four
//! cells around it (dual marching cubes: Nielson, IEEE Visualization 2004, 489).

use super::cycles::{self, Cycles, NOT_CROSSED, lower_corner};
use super::lattice::{BLOCK, Block, Cell, Mixer, NODES, SparseLattice, node_index};
use protomer_kernel::Vec3;
use std::hash::{Hash, Hasher};

/// A crossing keeps at least this fraction of its edge away from both ends, so that the smallest
/// shells keep a size; the vertices are projected to the surface later.
const CLEARANCE: f64 = 0.2;
/// Crossings are displaced by up to this fraction of their edge, in a way fixed to the lattice.
/// Where node values are only bounds, crossings would otherwise repeat from cell to cell, and
/// rounding would decide between shapes that are equal.
const DISPLACEMENT: f64 = 0.05;
/// Nodes along the edge of a block with the first nodes of the blocks after it.
const RIM: i32 = BLOCK + 1;
const RIM_NODES: usize = (RIM * RIM * RIM) as usize;
pub(super) const NOTHING: u32 = u32::MAX;

/// A closed surface of quadrangles.
#[derive(Default)]
pub(super) struct Dual {
    /// The cell of each vertex.
    pub(super) cells: Vec<Cell>,
    /// The quadrangles.
    pub(super) quads: Vec<Quad>,
}

/// The quadrangle dual to a crossed edge.
pub(super) struct Quad {
    /// The vertices around the edge, counter-clockwise seen from outside.
    pub(super) corners: [u32; 4],
    /// The outside end of the edge.
    pub(super) outside: Cell,
    /// Where the surface crosses the edge, about, in input coordinates, Å.
    pub(super) point: Vec3,
}

/// The quadrangles of a lattice.
pub(super) fn quadrangles(lattice: &SparseLattice) -> Dual {
    let slot_of_block = vec![NOTHING; lattice.blocks.len()];
    let mut march = March {
        lattice,
        table: cycles::table(),
        slot_of_block,
        slots: Vec::new(),
        dual: Dual::default(),
    };
    for block in &lattice.blocks {
        march.block(block);
    }
    march.dual
}

/// One pass over all blocks.
struct March<'a> {
    lattice: &'a SparseLattice<'a>,
    table: Vec<Cycles>,
    /// Where in `slots` the quadrangles of a block's edges are, for blocks that have any.
    slot_of_block: Vec<u32>,
    /// The quadrangle of each edge of a block, by lower node and axis.
    slots: Vec<[u32; 3 * NODES]>,
    dual: Dual,
}

impl March<'_> {
    fn block(&mut self, block: &Block) {
        let blocks: [u32; 8] = std::array::from_fn(|after| {
            let place = at_corner(block.place, after);
            self.lattice.index(&place).unwrap_or(NOTHING)
        });
        if block.side.is_some() && self.are_on_side(&blocks, block.side) {
            return;
        }
        let rim = Rim::of(block.place, blocks, self.lattice);
        for i in 0..NODES as i32 {
            self.cell(&rim, [i / (BLOCK * BLOCK), i / BLOCK % BLOCK, i % BLOCK]);
        }
    }

    /// Whether all of these blocks that are there lie on one side of the surface.
    fn are_on_side(&self, blocks: &[u32; 8], side: Option<bool>) -> bool {
        for &index in blocks {
            if let Some(block) = self.lattice.blocks.get(index as usize)
                && block.side != side
            {
                return false;
            }
        }
        true
    }

    /// Makes the vertices of a cell and enters them into the quadrangles of its edges.
    fn cell(&mut self, rim: &Rim, cell: Cell) {
        let mut values = [0.0; 8];
        let mut mask = 0;
        for (corner, value) in values.iter_mut().enumerate() {
            *value = rim.value(at_corner(cell, corner));
            mask |= usize::from(*value < 0.0) << corner;
        }
        // A node that is not there belongs to a block whose cells the surface does not cross.
        if mask == 0 || mask == 255 || values.iter().any(|value| value.is_nan()) {
            return;
        }
        let cycles = self.table[mask];
        let first = self.dual.cells.len() as u32;
        for _ in 0..cycles.count {
            self.dual.cells.push(rim.global(cell));
        }
        for (edge, &cycle) in cycles.of_edge.iter().enumerate() {
            if cycle == NOT_CROSSED {
                continue;
            }
            let (axis, low) = (edge / 4, lower_corner(edge));
            let ends = [values[low], values[low | 1 << axis]];
            let quad = self.quad(rim, at_corner(cell, low), axis, ends);
            // The cells around an edge, counter-clockwise seen from its upper end, have it at these
            // places.
            let place = [0, 1, 3, 2][edge % 4];
            let turned = if values[low] < 0.0 { place } else { 3 - place };
            quad.corners[turned] = first + u32::from(cycle);
        }
    }

    /// The quadrangle of the edge from `node` along `axis`, made when first asked for.
    fn quad(&mut self, rim: &Rim, node: Cell, axis: usize, [low, high]: [f64; 2]) -> &mut Quad {
        let (block, local) = rim.locate(node);
        let slot = &mut self.slot_of_block[block as usize];
        if *slot == NOTHING {
            *slot = self.slots.len() as u32;
            self.slots.push([NOTHING; 3 * NODES]);
        }
        let quad = &mut self.slots[*slot as usize][3 * local + axis];
        if *quad == NOTHING {
            *quad = self.dual.quads.len() as u32;
            let mut outside = rim.global(node);
            let mut crossing = outside.map(f64::from);
            let fraction = low / (low - high) + DISPLACEMENT * noise(&outside, axis);
            crossing[axis] += CLEARANCE + (1.0 - 2.0 * CLEARANCE) * fraction.clamp(0.0, 1.0);
            outside[axis] += i32::from(low < 0.0);
            let point = self.lattice.point(crossing);
            self.dual.quads.push(Quad {
                corners: [NOTHING; 4],
                outside,
                point,
            });
        }
        &mut self.dual.quads[*quad as usize]
    }
}

/// A block's node values with those of the seven blocks after it that its cells need.
struct Rim {
    place: Cell,
    /// Indices of the block and the seven after it, by the axes along which they come after it.
    blocks: [u32; 8],
    /// Node values; not a number in a block that is not there.
    values: [f64; RIM_NODES],
}

impl Rim {
    fn of(place: Cell, blocks: [u32; 8], lattice: &SparseLattice) -> Self {
        let mut rim = Self {
            place,
            blocks,
            values: [f64::NAN; RIM_NODES],
        };
        for i in 0..RIM_NODES as i32 {
            let (index, local) = rim.locate([i / (RIM * RIM), i / RIM % RIM, i % RIM]);
            if let Some(block) = lattice.blocks.get(index as usize) {
                rim.values[i as usize] = block.values[local];
            }
        }
        rim
    }

    fn value(&self, [x, y, z]: Cell) -> f64 {
        self.values[((x * RIM + y) * RIM + z) as usize]
    }

    /// Index of the block that a node belongs to, and of the node in it.
    fn locate(&self, node: Cell) -> (u32, usize) {
        let mut after = 0;
        for (axis, x) in node.into_iter().enumerate() {
            after |= usize::from(x == BLOCK) << axis;
        }
        (self.blocks[after], node_index(node.map(|x| x % BLOCK)))
    }

    fn global(&self, node: Cell) -> Cell {
        [0, 1, 2].map(|axis| self.place[axis] * BLOCK + node[axis])
    }
}

/// The corner of a cell, or the block, that comes after along the axes in the bits of `corner`.
fn at_corner(cell: Cell, corner: usize) -> Cell {
    [0, 1, 2].map(|axis| cell[axis] + (corner >> axis & 1) as i32)
}

/// A fixed number between -1 and 1 for each edge of the lattice.
fn noise(node: &Cell, axis: usize) -> f64 {
    let mut mixer = Mixer::default();
    (node, axis).hash(&mut mixer);
    (mixer.finish() >> 32) as f64 / f64::from(1_u32 << 31) - 1.0
}
