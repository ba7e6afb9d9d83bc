//! Node values of a cubic lattice, kept only in blocks near the surface.

use crate::surface::frame::Frame;
use crate::surface::implicit::ImplicitSolid;
use crate::{BodyError, Result};
use protomer_kernel::Vec3;
use std::collections::{HashMap, HashSet};
use std::hash::{BuildHasherDefault, Hasher};

/// Nodes along a block's edge.
pub(super) const BLOCK: i32 = 4;
/// Nodes of a block.
pub(super) const NODES: usize = (BLOCK * BLOCK * BLOCK) as usize;
/// At most this many blocks are looked at, and this many kept; a protein of 50 000 atoms keeps
/// about 1 000 000.
const MOST_CANDIDATES: usize = 30_000_000;
const MOST_BLOCKS: usize = 4_000_000;

/// Lattice coordinates of a node or a block. A cell has those of its lowest node.
pub(super) type Cell = [i32; 3];

/// A cubic lattice near a surface.
pub(super) struct SparseLattice<'a> {
    frame: &'a Frame,
    spacing: f64,
    /// The blocks that hold a corner of a cell that the surface crosses, and some others near the
    /// surface.
    pub(super) blocks: Vec<Block>,
    /// Where in `blocks` a block is.
    index_of: HashMap<Cell, u32, BuildHasherDefault<Mixer>>,
}

/// The node values of one block.
pub(super) struct Block {
    /// Coordinates, in blocks.
    pub(super) place: Cell,
    /// Node values, Å; negative is inside. A node whose sign is fixed by the value of a point
    /// nearby holds that value.
    pub(super) values: [f64; NODES],
    /// Whether all nodes are inside, or all outside; `None` if there are both.
    pub(super) side: Option<bool>,
}

impl<'a> SparseLattice<'a> {
    /// Fills every block of the lattice that the surface may cross.
    pub(super) fn around(
        solid: &dyn ImplicitSolid,
        frame: &'a Frame,
        spacing: f64,
    ) -> Result<Self> {
        let mut lattice = Self {
            frame,
            spacing,
            blocks: Vec::new(),
            index_of: HashMap::default(),
        };
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

    /// Where in `blocks` the block at `place` is.
    pub(super) fn index(&self, place: &Cell) -> Option<u32> {
        self.index_of.get(place).copied()
    }

    /// A point given in cells from the origin of the lattice, in input coordinates, Å.
    pub(super) fn point(&self, cells: [f64; 3]) -> Vec3 {
        self.frame.to_input(&(Vec3::from(cells) * self.spacing))
    }

    /// The blocks within the diagonal of a cell of the cover, sorted, so that the mesh does not
    /// depend on a hash.
    fn candidates(&self, cover: &[(Vec3, f64)]) -> Result<Vec<Cell>> {
        let edge = self.spacing * f64::from(BLOCK);
        let mut seen: HashSet<Cell, BuildHasherDefault<Mixer>> = HashSet::default();
        let mut work = 0.0;
        for (centre, radius) in cover {
            let centre = self.frame.to_lattice(centre) / edge;
            let reach = (radius + 1.8 * self.spacing) / edge;
            let extent = centre.amax() + reach;
            work += (2.0 * reach + 1.0).powi(3);
            if !(extent.is_finite() && extent < 1e8 && work < 4.0 * MOST_CANDIDATES as f64) {
                return Err(too_large(self.spacing));
            }
            insert_blocks_near(&mut seen, &centre, reach);
            if seen.len() > MOST_CANDIDATES {
                return Err(too_large(self.spacing));
            }
        }
        let mut candidates: Vec<Cell> = seen.into_iter().collect();
        candidates.sort_unstable();
        Ok(candidates)
    }

    /// The node values of a block, or `None` if the distance at its centre shows that no cell with
    /// a corner here crosses the surface: |f(centre)| > radius of the block's nodes about it +
    /// diagonal of a cell, for a 1-Lipschitz f.
    fn fill(&self, solid: &dyn ImplicitSolid, place: Cell) -> Option<Block> {
        let first = place.map(|x| f64::from(x * BLOCK));
        let half = 0.5 * f64::from(BLOCK - 1);
        let value = solid.signed_distance(&self.point(first.map(|x| x + half)));
        let diagonal = 3f64.sqrt() * self.spacing;
        if value.abs() > (half + 1.0) * diagonal {
            return None;
        }
        let mut block = Block {
            place,
            values: [value; NODES],
            side: Some(value < 0.0),
        };
        if value.abs() <= half * diagonal * (1.0 + 1e-9) {
            for octant in 0..8 {
                let corner = [0, 1, 2].map(|axis| (octant >> axis & 1) * (BLOCK / 2));
                self.fill_octant(solid, first, corner, &mut block.values);
            }
            block.side = common_side(&block.values);
        }
        Some(block)
    }

    /// Fills 2 x 2 x 2 nodes of a block; a value is computed only where no value nearby already
    /// fixes its sign.
    fn fill_octant(
        &self,
        solid: &dyn ImplicitSolid,
        first: [f64; 3],
        corner: Cell,
        values: &mut [f64; NODES],
    ) {
        let value_at = |cells: [f64; 3]| {
            let place = [0, 1, 2].map(|axis| first[axis] + cells[axis]);
            solid.signed_distance(&self.point(place))
        };
        let centre = corner.map(|x| f64::from(x) + 0.5);
        let mut known = [(centre, value_at(centre)); 9];
        let mut count = 1;
        for i in 0..8 {
            let node = [0, 1, 2].map(|axis| corner[axis] + (i >> axis & 1));
            let here = node.map(f64::from);
            let value = match self.fixed_value(&known[..count], here) {
                Some(value) => value,
                None => {
                    let value = value_at(here);
                    known[count] = (here, value);
                    count += 1;
                    value
                }
            };
            values[node_index(node)] = value;
        }
    }

    /// The first of the known values, each at its place, that fixes the sign at `here`: it is larger
    /// than the distance, for a 1-Lipschitz function.
    fn fixed_value(&self, known: &[([f64; 3], f64)], here: [f64; 3]) -> Option<f64> {
        for (there, value) in known {
            let mut square = 0.0;
            for axis in 0..3 {
                square += (here[axis] - there[axis]).powi(2);
            }
            if value * value > square * self.spacing * self.spacing * (1.0 + 1e-9) {
                return Some(*value);
            }
        }
        None
    }
}

/// Whether all values are inside (true) or all outside (false); `None` if there are both.
fn common_side(values: &[f64]) -> Option<bool> {
    let is_inside = values.first().is_some_and(|value| *value < 0.0);
    let is_common = values.iter().all(|value| (*value < 0.0) == is_inside);
    is_common.then_some(is_inside)
}

/// Inserts the blocks within `reach` of a point, both in units of a block's edge.
fn insert_blocks_near(
    seen: &mut HashSet<Cell, BuildHasherDefault<Mixer>>,
    centre: &Vec3,
    reach: f64,
) {
    let [low, high] = [-reach, reach].map(|r| centre.map(|x| (x + r).floor() as i32));
    for x in low.x..=high.x {
        for y in low.y..=high.y {
            for z in low.z..=high.z {
                let block = Vec3::new(f64::from(x), f64::from(y), f64::from(z));
                let nearest = block.zip_map(centre, |corner, c| c - c.clamp(corner, corner + 1.0));
                if nearest.norm_squared() <= reach * reach {
                    seen.insert([x, y, z]);
                }
            }
        }
    }
}

/// Index of a node in its block, counted from the block's first node.
pub(super) fn node_index(node: Cell) -> usize {
    ((node[0] * BLOCK + node[1]) * BLOCK + node[2]) as usize
}

/// A fast hash of lattice coordinates, which nobody chooses to collide: multiply and rotate.
#[derive(Default)]
pub(super) struct Mixer(u64);

impl Hasher for Mixer {
    fn write(&mut self, bytes: &[u8]) {
        for chunk in bytes.chunks(8) {
            let mut word = [0; 8];
            word[..chunk.len()].copy_from_slice(chunk);
            let mixed = self.0.rotate_left(23) ^ u64::from_le_bytes(word);
            self.0 = mixed.wrapping_mul(0x9e37_79b9_7f4a_7c15);
        }
    }

    fn finish(&self) -> u64 {
        self.0 ^ (self.0 >> 29)
    }
}

fn too_large(spacing: f64) -> BodyError {
    BodyError::Invalid {
        cause: format!(
            "the surface is too large, or too far from its own centre, for a lattice of {spacing} Å"
        ),
        remedy:
            "check the coordinates and radii for stray values, or ask for a coarser base spacing"
                .into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two balls whose surfaces nearly touch.
    struct Pair;

    impl ImplicitSolid for Pair {
        fn signed_distance(&self, point: &Vec3) -> f64 {
            self.cover()
                .iter()
                .map(|(centre, radius)| (point - centre).norm() - radius)
                .fold(f64::INFINITY, f64::min)
        }
        fn project(&self, point: &Vec3) -> (Vec3, Vec3) {
            (*point, Vec3::x())
        }
        fn bounds(&self) -> (Vec3, Vec3) {
            (Vec3::repeat(-4.0), Vec3::repeat(4.0))
        }
        fn cover(&self) -> Vec<(Vec3, f64)> {
            vec![
                (Vec3::new(-1.2, 0.1, 0.0), 1.3),
                (Vec3::new(1.6, 0.2, 0.3), 1.45),
            ]
        }
    }

    /// The slow twin: every node of the box, evaluated. Signs agree wherever a block is kept, and
    /// all corners of every cell that the surface crosses are in blocks that are kept.
    #[test]
    fn the_sparse_lattice_sees_what_a_dense_one_sees() {
        let frame = Frame::of_points(&Pair.cover().iter().map(|ball| ball.0).collect::<Vec<_>>());
        for spacing in [0.6, 0.31] {
            let lattice = SparseLattice::around(&Pair, &frame, spacing).unwrap();
            let kept = |node: Cell| {
                let index = lattice.index_of.get(&node.map(|x| x.div_euclid(BLOCK)))?;
                Some(
                    lattice.blocks[*index as usize].values
                        [node_index(node.map(|x| x.rem_euclid(BLOCK)))],
                )
            };
            let inside =
                |node: Cell| Pair.signed_distance(&lattice.point(node.map(f64::from))) < 0.0;
            let reach = (5.0 / spacing) as i32;
            let mut crossings = 0;
            for i in 0..(2 * reach).pow(3) {
                let side = 2 * reach;
                let cell = [
                    i / side / side - reach,
                    i / side % side - reach,
                    i % side - reach,
                ];
                if let Some(value) = kept(cell) {
                    assert_eq!(value < 0.0, inside(cell));
                }
                let corners: [Cell; 8] = std::array::from_fn(|corner| {
                    [0, 1, 2].map(|a| cell[a] + (corner >> a & 1) as i32)
                });
                if corners.iter().any(|corner| inside(*corner) != inside(cell)) {
                    assert!(corners.iter().all(|corner| kept(*corner).is_some()));
                    crossings += 1;
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
            let error = SparseLattice::around(&Huge(radius), &frame, 0.6)
                .err()
                .unwrap();
            assert!(error.to_string().contains("too large"), "{error}");
        }
    }
}
