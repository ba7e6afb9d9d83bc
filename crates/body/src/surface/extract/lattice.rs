//! Node values of a body-centred cubic lattice, kept only in blocks near the surface.

use crate::surface::frame::Frame;
use crate::surface::implicit::ImplicitSolid;
use crate::{BodyError, Result};
use protomer_kernel::Vec3;
use std::collections::{HashMap, HashSet};

/// Cells along a block's edge.
pub(super) const BLOCK: i32 = 4;
/// Cells of a block.
pub(super) const CELLS: usize = (BLOCK * BLOCK * BLOCK) as usize;
/// Nodes of a block: an even one at the corner and an odd one at the centre of every cell.
pub(super) const NODES: usize = 2 * CELLS;
/// At most this many blocks are looked at, and this many kept; a protein of 50 000 atoms keeps about 100 000.
const MOST_CANDIDATES: usize = 30_000_000;
const MOST_BLOCKS: usize = 1_000_000;

/// Lattice coordinates of a cell or a block.
pub(super) type Cell = [i32; 3];

/// A lattice of cubic cells with nodes at the corners (even) and centres (odd) of the cells.
pub(super) struct SparseLattice<'a> {
    frame: &'a Frame,
    spacing: f64,
    /// The blocks that hold a node with a neighbour of the other sign, and some others near the surface.
    pub(super) blocks: Vec<Block>,
    /// Where in `blocks` a block is.
    pub(super) index_of: HashMap<Cell, u32>,
}

/// The node values of one block.
pub(super) struct Block {
    /// Coordinates, in blocks.
    pub(super) place: Cell,
    /// Node values, Å, even nodes first; negative is inside. A node too far from the surface to need its value holds
    /// an infinity of the right sign.
    pub(super) values: [f64; NODES],
}

impl<'a> SparseLattice<'a> {
    /// Fills every block of the lattice that the surface may cross.
    pub(super) fn around(solid: &dyn ImplicitSolid, frame: &'a Frame, spacing: f64) -> Result<Self> {
        let mut lattice = Self { frame, spacing, blocks: Vec::new(), index_of: HashMap::new() };
        for place in lattice.candidates(&solid.cover())? {
            if let Some(block) = lattice.fill(solid, place) {
                lattice.index_of.insert(place, lattice.blocks.len() as u32);
                lattice.blocks.push(block);
                if lattice.blocks.len() > MOST_BLOCKS {
                    return Err(too_large(spacing));
                }
            }
        }
        Ok(lattice)
    }

    /// Position of a node in input coordinates, Å; `odd` nodes sit at the centres of their cells.
    pub(super) fn node(&self, cell: Cell, odd: bool) -> Vec3 {
        let shift = if odd { 0.5 } else { 0.0 };
        self.point(cell.map(|x| f64::from(x) + shift))
    }

    fn point(&self, cells: [f64; 3]) -> Vec3 {
        self.frame.to_input(&(Vec3::from(cells) * self.spacing))
    }

    /// The blocks within a lattice edge of the cover, sorted, so that the mesh does not depend on a hash.
    fn candidates(&self, cover: &[(Vec3, f64)]) -> Result<Vec<Cell>> {
        let edge = self.spacing * f64::from(BLOCK);
        let mut seen = HashSet::new();
        let mut work = 0.0;
        for (centre, radius) in cover {
            let centre = self.frame.to_lattice(centre) / edge;
            // A node's block must be there if the node has an edge that crosses the surface.
            let reach = (radius + 1.5 * self.spacing) / edge;
            let extent = centre.amax() + reach;
            work += (2.0 * reach + 1.0).powi(3);
            if !(extent.is_finite() && extent < 1e8 && work < 4.0 * MOST_CANDIDATES as f64) {
                return Err(too_large(self.spacing));
            }
            let [low, high] = [-reach, reach].map(|r| centre.map(|x| (x + r).floor() as i32));
            for x in low.x..=high.x {
                for y in low.y..=high.y {
                    for z in low.z..=high.z {
                        let nearest = Vec3::new(f64::from(x), f64::from(y), f64::from(z))
                            .zip_map(&centre, |corner, c| c - c.clamp(corner, corner + 1.0));
                        if nearest.norm_squared() <= reach * reach {
                            seen.insert([x, y, z]);
                        }
                    }
                }
            }
            if seen.len() > MOST_CANDIDATES {
                return Err(too_large(self.spacing));
            }
        }
        let mut candidates: Vec<Cell> = seen.into_iter().collect();
        candidates.sort_unstable();
        Ok(candidates)
    }

    /// The node values of a block, or `None` if the distance at its centre shows that no edge of its nodes crosses the
    /// surface: |f(centre)| > radius of the block's nodes about it + longest edge, for a 1-Lipschitz f.
    fn fill(&self, solid: &dyn ImplicitSolid, place: Cell) -> Option<Block> {
        let first = place.map(|x| x * BLOCK);
        let at = |offset: f64| self.point(first.map(|x| f64::from(x) + offset));
        let half = 0.5 * (f64::from(BLOCK) - 0.5);
        let far = (half * 3f64.sqrt() + 1.0) * self.spacing;
        if solid.signed_distance(&at(half)).abs() > far {
            return None;
        }
        let mut block = Block { place, values: [0.0; NODES] };
        for octant in 0..8 {
            let corner = [0, 1, 2].map(|axis| (octant >> axis & 1) * (BLOCK / 2));
            self.fill_octant(solid, first, corner, &mut block.values);
        }
        Some(block)
    }

    /// Fills 2 x 2 x 2 cells of a block; a value is computed only where no value nearby already fixes its sign.
    fn fill_octant(&self, solid: &dyn ImplicitSolid, first: Cell, corner: Cell, values: &mut [f64; NODES]) {
        let in_cells = |cell: Cell, odd: bool| cell.map(|x| f64::from(x) + if odd { 0.5 } else { 0.0 });
        let value_at = |cells: [f64; 3]| {
            solid.signed_distance(&self.point([0, 1, 2].map(|axis| f64::from(first[axis]) + cells[axis])))
        };
        let centre = corner.map(|x| f64::from(x) + 0.75);
        let mut known = [(centre, value_at(centre)); 9];
        let mut count = 1;
        for odd in [true, false] {
            for i in 0..8 {
                let cell = [0, 1, 2].map(|axis| corner[axis] + (i >> axis & 1));
                let here = in_cells(cell, odd);
                let sign = known[..count].iter().find(|(there, value)| {
                    let square: f64 = (0..3).map(|axis| (here[axis] - there[axis]).powi(2)).sum();
                    value * value > square * self.spacing * self.spacing * (1.0 + 1e-9)
                });
                let value = match sign {
                    Some((_, value)) => f64::INFINITY.copysign(*value),
                    None => {
                        let value = value_at(here);
                        if count < known.len() {
                            known[count] = (here, value);
                            count += 1;
                        }
                        value
                    }
                };
                values[node_index(cell, odd)] = value;
            }
        }
    }
}

/// Index of a node in its block; `cell` counts from the block's first cell.
pub(super) fn node_index(cell: Cell, odd: bool) -> usize {
    let cell = (cell[0] * BLOCK + cell[1]) * BLOCK + cell[2];
    cell as usize + if odd { CELLS } else { 0 }
}

fn too_large(spacing: f64) -> BodyError {
    BodyError::Invalid {
        cause: format!("the surface is too large, or too far from its own centre, for a lattice of {spacing} Å"),
        remedy: "check the coordinates and radii for stray values, or ask for a coarser base spacing".into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two balls whose surfaces nearly touch.
    struct Pair;

    impl ImplicitSolid for Pair {
        fn signed_distance(&self, point: &Vec3) -> f64 {
            self.cover().iter().map(|(centre, radius)| (point - centre).norm() - radius).fold(f64::INFINITY, f64::min)
        }
        fn project(&self, point: &Vec3) -> (Vec3, Vec3) {
            (*point, Vec3::x())
        }
        fn bounds(&self) -> (Vec3, Vec3) {
            (Vec3::repeat(-4.0), Vec3::repeat(4.0))
        }
        fn cover(&self) -> Vec<(Vec3, f64)> {
            vec![(Vec3::new(-1.2, 0.1, 0.0), 1.3), (Vec3::new(1.6, 0.2, 0.3), 1.45)]
        }
    }

    /// The slow twin: every node of the box, evaluated. Signs agree wherever a block is kept, and both ends of every
    /// edge that changes sign are in blocks that are kept.
    #[test]
    fn the_sparse_lattice_sees_what_a_dense_one_sees() {
        let frame = Frame::of_points(&Pair.cover().iter().map(|ball| ball.0).collect::<Vec<_>>());
        for spacing in [0.6, 0.31] {
            let lattice = SparseLattice::around(&Pair, &frame, spacing).unwrap();
            let kept = |cell: Cell, odd: bool| {
                let index = lattice.index_of.get(&cell.map(|x| x.div_euclid(BLOCK)))?;
                Some(lattice.blocks[*index as usize].values[node_index(cell.map(|x| x.rem_euclid(BLOCK)), odd)])
            };
            let inside = |cell: Cell, odd: bool| Pair.signed_distance(&lattice.node(cell, odd)) < 0.0;
            let reach = (5.0 / spacing) as i32;
            let mut crossings = 0;
            for i in 0..(2 * reach).pow(3) {
                let side = 2 * reach;
                let cell = [i / side / side - reach, i / side % side - reach, i % side - reach];
                for odd in [false, true] {
                    if let Some(value) = kept(cell, odd) {
                        assert_eq!(value < 0.0, inside(cell, odd));
                    }
                    for to in [[1, 0, 0], [0, 1, 0], [0, 0, 1]].map(|d| [0, 1, 2].map(|axis| cell[axis] + d[axis])) {
                        if inside(cell, odd) != inside(to, odd) {
                            assert!(kept(cell, odd).is_some() && kept(to, odd).is_some());
                            crossings += 1;
                        }
                    }
                    if !odd && inside(cell, false) != inside(cell, true) {
                        assert!(kept(cell, false).is_some() && kept(cell, true).is_some());
                    }
                }
            }
            assert!(crossings > 100);
        }
    }

    #[test]
    fn a_cover_beyond_all_bounds_is_refused() {
        struct Huge(f64);
        impl ImplicitSolid for Huge {
            fn signed_distance(&self, point: &Vec3) -> f64 {
                point.norm() - self.0
            }
            fn project(&self, point: &Vec3) -> (Vec3, Vec3) {
                (*point, Vec3::x())
            }
            fn bounds(&self) -> (Vec3, Vec3) {
                (Vec3::repeat(-self.0), Vec3::repeat(self.0))
            }
            fn cover(&self) -> Vec<(Vec3, f64)> {
                vec![(Vec3::zeros(), self.0)]
            }
        }
        for radius in [1e4, 1e300, f64::NAN, f64::INFINITY] {
            let frame = Frame::of_points(&[Vec3::zeros()]);
            let error = SparseLattice::around(&Huge(radius), &frame, 0.6).err().unwrap();
            assert!(error.to_string().contains("too large"), "{error}");
        }
    }
}
