//! Signs at the nodes of a cubic lattice, kept only near the surface.

use crate::surface::frame::Frame;
use crate::surface::hashing::FastMap;
use crate::surface::implicit::{Ball, ImplicitSolid};
use crate::{BodyError, Result};
use protomer_kernel::Vec3;

/// Nodes along a block's edge, and blocks along a region's.
pub(super) const BLOCK: i32 = 4;
/// Nodes of a block, and blocks of a region: as many as a word has bits.
pub(super) const NODES: usize = (BLOCK * BLOCK * BLOCK) as usize;
/// Distance from the first node of a block to its centre along each axis, in cells.
const HALF: f64 = 0.5 * (BLOCK - 1) as f64;
/// Largest number of blocks that the balls of the cover look at.
const MOST_LOOKS: f64 = 1e9;
/// Largest number of regions that are kept; a protein of 50 000 atoms has about 40 000.
const MOST_REGIONS: usize = 4_000_000;
/// A ball settles the nodes whose squared distance from its centre is within this factor of its
/// squared radius, so that rounding settles nothing wrongly.
const WELL_WITHIN: f64 = 1.0 - 1e-9;

/// Lattice coordinates of a node, a block or a region. A cell has those of its lowest node.
pub(super) type Cell = [i32; 3];

/// A cubic lattice near a surface.
pub(super) struct SparseLattice<'a> {
    frame: &'a Frame,
    spacing: f64,
    /// Regions with blocks near the surface.
    pub(super) regions: Vec<Region>,
    /// Place in `regions` of each region.
    index_of: FastMap<Cell, u32>,
    /// The inside nodes of each block that is kept, as bits.
    inside: Vec<u64>,
}

/// 4 x 4 x 4 blocks of 4 x 4 x 4 nodes. Blocks are numbered as nodes are ([`node_index`]).
pub(super) struct Region {
    /// Coordinates, in regions.
    pub(super) place: Cell,
    /// The blocks that are kept, as bits: those that hold a corner of a cell that the surface
    /// crosses, and some others near the surface.
    pub(super) blocks: u64,
    /// Number of blocks that the regions before this one keep.
    kept_before: u32,
}

impl Region {
    /// The number of a block among all that the lattice keeps, if it is kept.
    pub(super) fn number(&self, block: usize) -> Option<u32> {
        // The bits below are the blocks kept before it: their count is its offset.
        let before = self.blocks & ((1 << block) - 1);
        let is_kept = self.blocks >> block & 1 == 1;
        is_kept.then(|| self.kept_before + before.count_ones())
    }
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
            regions: Vec::new(),
            index_of: FastMap::default(),
            inside: Vec::new(),
        };
        let mut buffers = Buffers::default();
        for (place, candidates) in lattice.candidates(&solid.cover())? {
            let kept_before = lattice.inside.len() as u32;
            // Blocks are pushed in the order of their bits, which `Region::number` counts on.
            let blocks = lattice.fill(solid, place, candidates, &mut buffers);
            if blocks != 0 {
                lattice.index_of.insert(place, lattice.regions.len() as u32);
                lattice.regions.push(Region {
                    place,
                    blocks,
                    kept_before,
                });
            }
        }
        Ok(lattice)
    }

    /// Place in `regions` of the region at `place`.
    pub(super) fn index(&self, place: &Cell) -> Option<u32> {
        self.index_of.get(place).copied()
    }

    /// Number of blocks that are kept.
    pub(super) fn kept_blocks(&self) -> usize {
        self.inside.len()
    }

    /// The inside nodes of a block of a region, as bits, if it is kept.
    pub(super) fn inside(&self, region: u32, block: usize) -> Option<u64> {
        let number = self.regions[region as usize].number(block)?;
        Some(self.inside[number as usize])
    }

    /// A point given in cells from the origin of the lattice, in input coordinates, Å.
    pub(super) fn point(&self, cells: [f64; 3]) -> Vec3 {
        self.frame.to_input(&(Vec3::from(cells) * self.spacing))
    }

    /// The blocks within the diagonal of a cell of the cover, by region; the regions are sorted, so
    /// that the mesh does not depend on a hash.
    fn candidates(&self, cover: &[Ball]) -> Result<Vec<(Cell, u64)>> {
        let edge = self.spacing * f64::from(BLOCK);
        let mut blocks: FastMap<Cell, u64> = FastMap::default();
        let mut looks = 0.0;
        for (centre, radius) in cover {
            let centre = self.frame.to_lattice(centre) / edge;
            // The diagonal of a cell is √3 = 1.73 spacings; 1.8 leaves room for rounding.
            let reach = (radius + 1.8 * self.spacing) / edge;
            let extent = centre.amax() + reach;
            // A ball much larger than the spacing asks for a number of blocks that
            // never ends; refused before it starts. NaN fails the comparison too.
            looks += (2.0 * reach + 1.0).powi(3);
            if !(extent.is_finite() && extent < 1e8 && looks < MOST_LOOKS) {
                return Err(too_large(self.spacing));
            }
            add_blocks_near(&mut blocks, &centre, reach);
            if blocks.len() > MOST_REGIONS {
                return Err(too_large(self.spacing));
            }
        }
        let mut candidates: Vec<(Cell, u64)> = blocks.into_iter().collect();
        candidates.sort_unstable();
        Ok(candidates)
    }

    /// Fills those candidates among the blocks of a region that the surface may cross, and says which
    /// these are, as bits.
    fn fill(
        &mut self,
        solid: &dyn ImplicitSolid,
        region: Cell,
        candidates: u64,
        buffers: &mut Buffers,
    ) -> u64 {
        let Buffers {
            blocks,
            points,
            at_centres,
            values,
            nodes,
            balls,
        } = buffers;
        blocks.clear();
        points.clear();
        for block in bits(candidates) {
            let filling = Filling::new(region, block);
            points.push(self.point(filling.first.map(|x| x + HALF)));
            blocks.push(filling);
        }
        // One call for the centres of a region's blocks: the solid answers many points at a time.
        solid.signed_distances_and_empty_balls(points, at_centres);
        for ((block, centre), (value, empty)) in blocks.iter_mut().zip(&*points).zip(&*at_centres) {
            balls.clear();
            // Balls farther than the corners of the block hold none of its nodes.
            solid.add_inner_balls(centre, HALF * self.diagonal(), balls);
            self.settle_by_balls(block, *value, empty.as_ref(), balls);
        }
        points.clear();
        nodes.clear();
        for (number, block) in (0..).zip(&*blocks) {
            // Only what the balls left open is asked for: a small share of the nodes.
            for node in bits(block.unknown()) {
                let offset = node_at(node).map(f64::from);
                points.push(self.point([0, 1, 2].map(|axis| block.first[axis] + offset[axis])));
                nodes.push((number, node));
            }
        }
        solid.signed_distances(points, values);
        for ((number, node), value) in nodes.iter().zip(&*values) {
            blocks[*number].settle(1 << node, *value < 0.0);
        }
        let mut mask = 0;
        for block in blocks.iter().filter(|block| block.is_kept) {
            mask |= 1 << block.number;
            self.inside.push(block.inside);
        }
        mask
    }

    /// Decides by the signed distance at its centre whether a block is kept, and settles what nodes that
    /// and the balls outside and inside the solid can.
    ///
    /// No cell with a corner in a block crosses the surface if |f(centre)| > radius of the block's nodes
    /// about it + diagonal of a cell, for a 1-Lipschitz f.
    fn settle_by_balls(
        &self,
        block: &mut Filling,
        value: f64,
        empty: Option<&Ball>,
        inner: &[Ball],
    ) {
        let diagonal = self.diagonal();
        // f changes by at most the distance moved. A node of the block may
        // belong to a cell in the next one, so a cell's diagonal is added.
        block.is_kept = value.abs() <= (HALF + 1.0) * diagonal;
        // No node of the block is so far from the centre: all have its sign.
        if value.abs() > HALF * diagonal * (1.0 + 1e-9) {
            block.settle(u64::MAX, value < 0.0);
            return;
        }
        // Within |f| of the centre the sign is the same.
        block.settle(self.nodes_in([HALF; 3], value), value < 0.0);
        if let Some(ball) = empty {
            // The probe at its nearest place: all of it is outside.
            block.settle(self.nodes_in_ball(block.first, ball), false);
        }
        // The atoms' own balls: all of them inside.
        for ball in inner {
            block.settle(self.nodes_in_ball(block.first, ball), true);
        }
    }

    /// Diagonal of a cell, Å.
    fn diagonal(&self) -> f64 {
        3f64.sqrt() * self.spacing
    }

    /// The nodes of a block with the first node `first` that lie in a ball.
    fn nodes_in_ball(&self, first: [f64; 3], (centre, radius): &Ball) -> u64 {
        let centre = self.frame.to_lattice(centre) / self.spacing;
        let centre = [0, 1, 2].map(|axis| centre[axis] - first[axis]);
        self.nodes_in(centre, *radius)
    }

    /// The nodes of a block within `radius` Å of a point given in cells from its first node.
    fn nodes_in(&self, centre: [f64; 3], radius: f64) -> u64 {
        let radius = radius / self.spacing;
        ball_bits(centre, radius * radius * WELL_WITHIN, |node, centre| {
            node - centre
        })
    }
}

/// Buffers of [`SparseLattice::fill`], kept from one region to the next.
#[derive(Default)]
struct Buffers {
    blocks: Vec<Filling>,
    points: Vec<Vec3>,
    at_centres: Vec<(f64, Option<Ball>)>,
    values: Vec<f64>,
    /// Place in `blocks` of the block of each point, and the point's node in that block.
    nodes: Vec<(usize, usize)>,
    balls: Vec<Ball>,
}

/// A block that is being filled. Nodes are bits.
struct Filling {
    /// Number of the block in the region.
    number: usize,
    /// First node of the block, in cells from the origin.
    first: [f64; 3],
    is_kept: bool,
    settled: u64,
    inside: u64,
}

impl Filling {
    fn new(region: Cell, number: usize) -> Self {
        let place = node_at(number);
        let first = [0, 1, 2].map(|axis| (region[axis] * BLOCK + place[axis]) * BLOCK);
        Self {
            number,
            first: first.map(f64::from),
            is_kept: false,
            settled: 0,
            inside: 0,
        }
    }

    /// Settles those of `nodes` that are not settled yet.
    fn settle(&mut self, nodes: u64, is_inside: bool) {
        // Settled nodes keep their sign: it was certain.
        if is_inside {
            self.inside |= nodes & !self.settled;
        }
        self.settled |= nodes;
    }

    /// The nodes that are not settled.
    fn unknown(&self) -> u64 {
        !self.settled
    }
}

/// The bits of those of 4 x 4 x 4 things whose squared distance from `centre` is less than
/// `square`; `gap` is the distance of the i-th from a coordinate along an axis.
fn ball_bits(centre: [f64; 3], square: f64, gap: impl Fn(f64, f64) -> f64) -> u64 {
    let [x, y, z]: [[f64; 4]; 3] = centre.map(|c| [0.0, 1.0, 2.0, 3.0].map(|i| gap(i, c).powi(2)));
    let mut bits = 0;
    // Node (i, j, k) is the bit 16 i + 4 j + k; whole planes and rows fall away early.
    for (i, x) in x.into_iter().enumerate() {
        if x >= square {
            continue;
        }
        for (j, y) in y.into_iter().enumerate() {
            let remainder = square - x - y;
            if remainder > 0.0 {
                // Four comparisons without a branch fill four bits.
                let [a, b, c, d] = z.map(|z| u64::from(z < remainder));
                bits |= (a | b << 1 | c << 2 | d << 3) << (16 * i + 4 * j);
            }
        }
    }
    bits
}

/// Adds the blocks within `reach` of a point, both in units of a block's edge, to those of each
/// region.
fn add_blocks_near(regions: &mut FastMap<Cell, u64>, centre: &Vec3, reach: f64) {
    let size = f64::from(BLOCK);
    let [low, high] = [-reach, reach].map(|r| centre.map(|x| ((x + r) / size).floor() as i32));
    for x in low.x..=high.x {
        for y in low.y..=high.y {
            for z in low.z..=high.z {
                let region = [x, y, z];
                let from_first =
                    [0, 1, 2].map(|axis| centre[axis] - f64::from(region[axis]) * size);
                // Rounded up here, as a block too many costs little and one too few a hole.
                let square = reach * reach * (1.0 + 1e-12);
                let blocks = ball_bits(from_first, square, |block, c| {
                    // The distance to the interval [block, block + 1], zero inside.
                    c - c.clamp(block, block + 1.0)
                });
                if blocks != 0 {
                    *regions.entry(region).or_insert(0) |= blocks;
                }
            }
        }
    }
}

/// Index of a node in its block, counted from the block's first node; also of a block in its region.
pub(super) fn node_index(node: Cell) -> usize {
    ((node[0] * BLOCK + node[1]) * BLOCK + node[2]) as usize
}

/// The node with this index.
pub(super) fn node_at(index: usize) -> Cell {
    let index = index as i32;
    [
        index / (BLOCK * BLOCK),
        index / BLOCK % BLOCK,
        index % BLOCK,
    ]
}

/// The numbers of the bits that are set, in ascending order.
pub(super) fn bits(mut word: u64) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let bit = word.trailing_zeros() as usize;
        // Clears the lowest bit; wrapping, as a word of zeros comes by once.
        word &= word.wrapping_sub(1);
        (bit < NODES).then_some(bit)
    })
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
                let block = node.map(|x| x.div_euclid(BLOCK));
                let index = lattice.index(&block.map(|x| x.div_euclid(BLOCK)))?;
                let block = node_index(block.map(|x| x.rem_euclid(BLOCK)));
                let bit = node_index(node.map(|x| x.rem_euclid(BLOCK)));
                Some(lattice.inside(index, block)? >> bit & 1 == 1)
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
                if let Some(is_inside) = kept(cell) {
                    assert_eq!(is_inside, inside(cell));
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
