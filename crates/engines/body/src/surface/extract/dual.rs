//! The quadrangles dual to the crossed edges of the lattice.
//!
//! Every sheet in a cell is a tile of the surface, every crossed edge a quadrangle of the tiles in
//! the four cells around it (dual marching cubes: Nielson, IEEE Visualization 2004, 489). In a
//! plain [`cube`] all sheets are one tile, so that only the crossed edges on the edges of such cubes
//! have three tiles around them or more: others need no quadrangle.

use super::cube;
use super::cycles::{self, Cycles, EDGES, NOT_CROSSED, lower_corner};
use super::lattice::{BLOCK, Cell, SparseLattice, bits, node_at, node_index};
use crate::surface::hashing::{FastMap, Mixer};
use protomer_kernel::Vec3;
use std::hash::{Hash, Hasher};

/// Crossings lie in the middle of their edge, displaced by up to this fraction of it, in a way fixed
/// to the lattice: rounding would otherwise decide between shapes that are equal. The vertices are
/// projected to the surface later.
const DISPLACEMENT: f64 = 0.05;
/// Nodes along the edge of a block with the first nodes of the blocks after it.
const RIM: i32 = BLOCK + 1;
/// Cubes of a block.
const CUBES: usize = 8;
/// Edges of cells on the edges of the cubes of a block.
const CUBE_EDGES: usize = 48;
/// The number that stands for no block, slot or quadrangle.
pub(super) const NOTHING: u32 = u32::MAX;

/// A closed surface of quadrangles.
#[derive(Default)]
pub(super) struct Dual {
    pub(super) tiles: Vec<Tile>,
    pub(super) quads: Vec<Quad>,
}

/// A vertex of the dual: a disk of the surface in a cell or a plain cube.
pub(super) struct Tile {
    /// The cell, or the lowest of the cube.
    pub(super) cell: Cell,
    /// Number of crossed edges at the tile, and the sum of the places of their middles in halves of a
    /// cell from the lowest node of `cell`.
    pub(super) crossings: (u16, [u16; 3]),
}

impl Tile {
    /// Number of crossed edges, and the sum of the places of their middles in cells from the origin.
    pub(super) fn crossings(&self) -> (f64, Vec3) {
        let (count, sum) = self.crossings;
        let count = f64::from(count);
        let from_cell = Vec3::from(sum.map(f64::from)) * 0.5;
        (
            count,
            from_cell + Vec3::from(self.cell.map(f64::from)) * count,
        )
    }
}

/// The quadrangle dual to a crossed edge.
pub(super) struct Quad {
    /// The tiles around the edge, counter-clockwise seen from outside; a cube's tile may be there
    /// twice.
    pub(super) corners: [u32; 4],
    /// The lower end of the edge.
    node: Cell,
    axis: u8,
    is_low_inside: bool,
}

impl Quad {
    /// The outside end of the edge.
    pub(super) fn outside(&self) -> Cell {
        let mut outside = self.node;
        outside[usize::from(self.axis)] += i32::from(self.is_low_inside);
        outside
    }

    /// Approximate place where the surface crosses the edge, in cells.
    pub(super) fn crossing(&self) -> [f64; 3] {
        let mut crossing = self.node.map(f64::from);
        let axis = usize::from(self.axis);
        crossing[axis] += 0.5 + DISPLACEMENT * noise(&self.node, axis);
        crossing
    }
}

/// The quadrangles of a lattice.
pub(super) fn quadrangles(lattice: &SparseLattice) -> Dual {
    let mut march = March {
        lattice,
        table: cycles::table(),
        blocks: Vec::new(),
        block_at: vec![NOTHING; lattice.kept_blocks()],
        other_quads: FastMap::default(),
        dual: Dual::default(),
    };
    march.find_blocks();
    march.mark_beside_cells();
    // All tiles of cells before those of cubes: a cube enters the edges
    // inside its faces only if a cell beside it has made a quadrangle there.
    for block in 0..march.blocks.len() {
        march.tile_cells(block);
    }
    for block in 0..march.blocks.len() {
        march.tile_cubes(block);
    }
    march.dual
}

/// Passes over all blocks.
struct March<'a> {
    lattice: &'a SparseLattice<'a>,
    table: Vec<Cycles>,
    blocks: Vec<Block>,
    /// Place in `blocks` of each block that the lattice keeps.
    block_at: Vec<u32>,
    /// The quadrangles of crossed edges that are not on edges of cubes.
    other_quads: FastMap<(Cell, usize), u32>,
    dual: Dual,
}

/// A block whose cells the surface crosses.
struct Block {
    place: Cell,
    /// The region that it belongs to.
    region: u32,
    rim: Rim,
    /// Cubes that are one tile, as bits, and those that are tiled by their cells.
    plain: u8,
    cellwise: u8,
    /// Cubes with a neighbour that is tiled by its cells.
    beside_cells: u8,
    /// The quadrangles of edges on the edges of cubes.
    quads: [u32; CUBE_EDGES],
}

/// The inside nodes of a block and of the seven blocks after it that its cells need: rows along z,
/// as bits.
struct Rim([u8; (RIM * RIM) as usize]);

/// A block, by its place, and the numbers of it and of the seven after it.
struct After {
    place: Cell,
    blocks: [u32; 8],
}

impl After {
    /// Slot of the quadrangle of the edge from a node of the block along `axis`.
    fn slot(&self, node: Cell, axis: usize) -> Option<Slot> {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        if (node[u] | node[v]) & 1 == 1 {
            return Some(Slot::Other(global(self.place, node), axis));
        }
        // The nodes of a block are 0 to 3; 4 is the first node of the block after it.
        let [x, y, z] = node.map(|x| usize::from(x == BLOCK));
        let block = self.blocks[x | y << 1 | z << 2];
        let node = node.map(|x| (x % BLOCK) as usize);
        // On a cube's edge u and v are even: u + v / 2 takes 0 to 3, so each axis has 16 slots.
        let slot = 16 * axis + 4 * node[axis] + node[u] + node[v] / 2;
        (block != NOTHING).then_some(Slot::OnCubeEdge(block, slot))
    }
}

/// An edge of a cell.
struct CellEdge {
    /// Lower end of the edge, from the first node of the block.
    node: Cell,
    axis: usize,
    /// Place of the edge among those of the cell along the axis.
    place: usize,
    is_low_inside: bool,
}

/// Place where a quadrangle is kept.
#[derive(Clone, Copy)]
enum Slot {
    /// Block, by number, and place among its `quads`.
    OnCubeEdge(u32, usize),
    Other(Cell, usize),
}

impl March<'_> {
    /// Finds the blocks with cells that the surface crosses, and how their cubes are tiled.
    fn find_blocks(&mut self) {
        let mut count = 0;
        for (number, region) in (0..).zip(&self.lattice.regions) {
            let after = Neighbours::from_cell(region.place, self.lattice);
            for block in bits(region.blocks) {
                count += 1;
                let words = after.words(node_at(block));
                let Some(rim) = Rim::from_words(words) else {
                    continue;
                };
                let (mut plain, mut cellwise) = (0, 0);
                for cube in 0..CUBES {
                    let nodes = rim.cube(cube);
                    // All on one side: no tile at all.
                    if nodes == 0 || nodes == cube::ALL {
                        continue;
                    }
                    let is_plain = cube::is_plain(nodes, &self.table);
                    let kind = if is_plain { &mut plain } else { &mut cellwise };
                    *kind |= 1 << cube;
                }
                // `block_at` counts the blocks that the lattice
                // keeps, `blocks` only those that are crossed.
                self.block_at[count - 1] = self.blocks.len() as u32;
                let [x, y, z] = node_at(block);
                self.blocks.push(Block {
                    place: [
                        region.place[0] * BLOCK + x,
                        region.place[1] * BLOCK + y,
                        region.place[2] * BLOCK + z,
                    ],
                    region: number,
                    rim,
                    plain,
                    cellwise,
                    beside_cells: 0,
                    quads: [NOTHING; CUBE_EDGES],
                });
            }
        }
    }

    /// The block at a place near `from`, if the surface crosses it.
    fn block(&self, place: Cell, from: usize) -> Option<u32> {
        let regions = &self.lattice.regions;
        let region_place = place.map(|x| x.div_euclid(BLOCK));
        // Most are in the same region.
        let mut region = self.blocks[from].region;
        if regions[region as usize].place != region_place {
            region = self.lattice.index(&region_place)?;
        }
        let number =
            regions[region as usize].number(node_index(place.map(|x| x.rem_euclid(BLOCK))))?;
        let block = self.block_at[number as usize];
        (block != NOTHING).then_some(block)
    }

    /// Marks the cubes that share a face with one that is tiled by its cells.
    fn mark_beside_cells(&mut self) {
        for block in 0..self.blocks.len() {
            let Block {
                place, cellwise, ..
            } = self.blocks[block];
            for cube in bits(u64::from(cellwise)) {
                // The neighbour in the same block differs in one bit; the one beyond
                // the block's face has the same bit flipped, in the next block.
                for axis in 0..3 {
                    self.blocks[block].beside_cells |= 1 << (cube ^ 1 << axis);
                    let is_second = cube >> axis & 1 == 1;
                    let mut beyond = place;
                    beyond[axis] += if is_second { 1 } else { -1 };
                    if let Some(beyond) = self.block(beyond, block) {
                        self.blocks[beyond as usize].beside_cells |= 1 << (cube ^ 1 << axis);
                    }
                }
            }
        }
    }

    /// A block and the seven after it, as [`Self::block`] knows them.
    fn block_and_after(&self, block: usize) -> After {
        let place = self.blocks[block].place;
        let blocks = std::array::from_fn(|after| match after {
            0 => block as u32,
            _ => self
                .block(at_corner(place, after), block)
                .unwrap_or(NOTHING),
        });
        After { place, blocks }
    }

    /// Makes the tiles of the cubes that are tiled by their cells, and enters them into the
    /// quadrangles of all their edges.
    fn tile_cells(&mut self, block: usize) {
        if self.blocks[block].cellwise == 0 {
            return;
        }
        let after = self.block_and_after(block);
        for cube in bits(u64::from(self.blocks[block].cellwise)) {
            let nodes = self.blocks[block].rim.cube(cube);
            for cell in 0..8 {
                let inside = cube::corners(nodes, cube::first_node(cell));
                let cycles = self.table[inside];
                // An entry for each edge is a whole row of work; most cells of a cube are empty.
                if cycles.count == 0 {
                    continue;
                }
                let local = cell_in_block(cube, cell);
                let first = self.dual.tiles.len() as u32;
                self.add_tiles(block, local, &cycles);
                for (edge, &cycle) in cycles.of_edge.iter().enumerate() {
                    if cycle == NOT_CROSSED {
                        continue;
                    }
                    let lower = lower_corner(edge);
                    let edge = CellEdge {
                        node: at_corner(local, lower),
                        axis: edge / 4,
                        place: edge % 4,
                        is_low_inside: inside >> lower & 1 == 1,
                    };
                    self.enter(&after, edge, first + u32::from(cycle), true);
                }
            }
        }
    }

    /// One tile for each sheet in a cell.
    fn add_tiles(&mut self, block: usize, local: Cell, cycles: &Cycles) {
        let cell = global(self.blocks[block].place, local);
        for sheet in 0..cycles.count {
            let (mut count, mut sum) = (0, [0; 3]);
            for edge in 0..EDGES {
                if cycles.of_edge[edge] == sheet {
                    let low = lower_corner(edge);
                    count += 1;
                    for (axis, sum) in sum.iter_mut().enumerate() {
                        // In halves of a cell, to stay in integers: 2 for a corner's
                        // coordinate of 1, and 1 for the middle along the edge's own axis.
                        *sum += 2 * (low >> axis & 1) as u16;
                    }
                    sum[edge / 4] += 1;
                }
            }
            let crossings = (count, sum);
            self.dual.tiles.push(Tile { cell, crossings });
        }
    }

    /// Makes the tiles of plain cubes, and enters them into the quadrangles of their edges and of
    /// those crossed edges of their cells that have one.
    fn tile_cubes(&mut self, block: usize) {
        let Block {
            place,
            plain,
            beside_cells,
            ..
        } = self.blocks[block];
        if plain == 0 {
            return;
        }
        let after = self.block_and_after(block);
        for cube in bits(u64::from(plain)) {
            let nodes = self.blocks[block].rim.cube(cube);
            let tile = self.dual.tiles.len() as u32;
            let first = cell_in_block(cube, 0);
            let crossings = cube::crossings(nodes);
            self.dual.tiles.push(Tile {
                cell: global(place, first),
                crossings,
            });
            let is_beside = beside_cells >> cube & 1 == 1;
            for axis in 0..3 {
                for low in bits(u64::from(cube::crossed(nodes, axis, is_beside))) {
                    let is_low_inside = nodes >> low & 1 == 1;
                    let edge = (cube::node(low), axis, is_low_inside);
                    self.enter_around(&after, first, edge, tile);
                }
            }
        }
    }

    /// Enters the tile of a cube, whose lowest cell is `first`, into the quadrangle of an edge from one
    /// of its nodes, for each of the cube's cells around the edge. An edge that is not on one of the
    /// cube has a quadrangle only if a neighbour has made it.
    fn enter_around(
        &mut self,
        after: &After,
        first: Cell,
        (low, axis, is_low_inside): (Cell, usize, bool),
        tile: u32,
    ) {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        let is_on_cube_edge = (low[u] | low[v]) & 1 == 0;
        let node = [0, 1, 2].map(|axis| first[axis] + low[axis]);
        // A cell has the edge at place (i, j) if its lowest node is that far before the edge's along
        // u and v.
        for i in 0..2 {
            for j in 0..2 {
                // The other cells around the edge belong to
                // other cubes, which enter their own tiles.
                let is_in_cube = (0..2).contains(&(low[u] - i)) && (0..2).contains(&(low[v] - j));
                if is_in_cube {
                    let edge = CellEdge {
                        node,
                        axis,
                        place: (i + 2 * j) as usize,
                        is_low_inside,
                    };
                    self.enter(after, edge, tile, is_on_cube_edge);
                }
            }
        }
    }

    /// Enters a tile of a cell into the quadrangle of one of its edges. Without `may_make`, only if
    /// the quadrangle exists.
    fn enter(&mut self, after: &After, edge: CellEdge, tile: u32, may_make: bool) {
        let Some(slot) = after.slot(edge.node, edge.axis) else {
            return;
        };
        let entry = match slot {
            Slot::OnCubeEdge(block, slot) => self.blocks[block as usize].quads[slot],
            Slot::Other(node, axis) => *self.other_quads.get(&(node, axis)).unwrap_or(&NOTHING),
        };
        let quad = match entry {
            NOTHING if !may_make => return,
            // The low end's side is the same seen from every
            // cell, so whoever comes first may make it.
            NOTHING => {
                let node = global(after.place, edge.node);
                self.make_quad(slot, node, edge.axis, edge.is_low_inside)
            }
            entry => entry,
        };
        // The cells around an edge, counter-clockwise seen from its upper end, have it at these
        // places.
        let place = [0, 1, 3, 2][edge.place];
        // Reversed where the outside is at the lower end: all quadrangles face outwards.
        let corner = if edge.is_low_inside { place } else { 3 - place };
        self.dual.quads[quad as usize].corners[corner] = tile;
    }

    fn make_quad(&mut self, slot: Slot, node: Cell, axis: usize, is_low_inside: bool) -> u32 {
        let number = self.dual.quads.len() as u32;
        match slot {
            Slot::OnCubeEdge(block, slot) => self.blocks[block as usize].quads[slot] = number,
            Slot::Other(node, axis) => {
                self.other_quads.insert((node, axis), number);
            }
        }
        self.dual.quads.push(Quad {
            corners: [NOTHING; 4],
            node,
            axis: axis as u8,
            is_low_inside,
        });
        number
    }
}

/// A region and the seven after it, by the axes along which they come after it.
struct Neighbours<'a> {
    lattice: &'a SparseLattice<'a>,
    regions: [Option<u32>; 8],
}

impl<'a> Neighbours<'a> {
    fn from_cell(place: Cell, lattice: &'a SparseLattice) -> Self {
        let regions = std::array::from_fn(|after| lattice.index(&at_corner(place, after)));
        Self { lattice, regions }
    }

    /// The inside nodes of a block and of the seven after it.
    fn words(&self, block: Cell) -> [Option<u64>; 8] {
        std::array::from_fn(|after| {
            let block = at_corner(block, after);
            let mut beyond = 0;
            // Blocks past the end of a region are in the next one along those axes.
            for (axis, x) in block.into_iter().enumerate() {
                beyond |= usize::from(x == BLOCK) << axis;
            }
            let block = node_index(block.map(|x| x % BLOCK));
            self.lattice.inside(self.regions[beyond]?, block)
        })
    }
}

impl Rim {
    /// The rows of a block, given with the seven after it; `None` if all nodes are on one side. The
    /// nodes of a block that is not there are on the side of their neighbours in this block, since
    /// no cell with a corner there is crossed.
    fn from_words(words: [Option<u64>; 8]) -> Option<Self> {
        let block_word = words[0]?;
        let is_uniform = block_word == 0 || block_word == u64::MAX;
        // Uniform with neighbours of the same side: nothing
        // is crossed, and most blocks are of this kind.
        if is_uniform && words.iter().flatten().all(|word| *word == block_word) {
            return None;
        }
        let mut rows = [0; (RIM * RIM) as usize];
        for x in 0..RIM {
            for y in 0..RIM {
                let after = usize::from(x == BLOCK) | usize::from(y == BLOCK) << 1;
                let start = |x: i32, y: i32| node_index([x, y, 0]);
                let shift = start(x % BLOCK, y % BLOCK);
                let nearest = start(x.min(BLOCK - 1), y.min(BLOCK - 1));
                let row = match words[after] {
                    // Each row holds four nodes of its block and
                    // the first one of the block after it along z.
                    Some(word) => word >> shift & 0b1111,
                    None => block_word >> nearest & 0b1111,
                };
                let last = match words[after | 4] {
                    Some(word) => word >> shift & 1,
                    None => block_word >> (nearest + 3) & 1,
                };
                rows[(x * RIM + y) as usize] = (row | last << BLOCK) as u8;
            }
        }
        Some(Self(rows))
    }

    /// The nodes of the cube that comes second along the axes in the bits of `cube`.
    fn cube(&self, cube: usize) -> u32 {
        let [x, y, z] = at_corner([0; 3], cube).map(|x| 2 * x as usize);
        let mut nodes = 0;
        for i in 0..3 {
            for j in 0..3 {
                // Node (i, j, k) of a cube is the bit 9 i + 3 j + k.
                let row = self.0[(x + i) * RIM as usize + y + j] >> z & 0b111;
                nodes |= u32::from(row) << (9 * i + 3 * j);
            }
        }
        nodes
    }
}

/// A cell of a cube of a block, in cells from the first of the block.
fn cell_in_block(cube: usize, cell: usize) -> Cell {
    at_corner(at_corner([0; 3], cube).map(|x| 2 * x), cell)
}

fn global(block: Cell, local: Cell) -> Cell {
    [0, 1, 2].map(|axis| block[axis] * BLOCK + local[axis])
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
