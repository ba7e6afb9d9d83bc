//! Which features matter near a point: a grid of small cells with lists of feature numbers, kept in
//! chunks of 4 x 4 x 4 cells found by a hash.

use protomer_kernel::Vec3;

/// Binary logarithm of [`CHUNK`].
const CHUNK_BITS: u32 = 2;
/// Cells along a chunk's edge.
const CHUNK: i32 = 1 << CHUNK_BITS;
/// Cells in a chunk.
const CELLS: usize = (CHUNK * CHUNK * CHUNK) as usize;
/// Upper bound of the rounding of a bound, Å.
const ROUNDING_ANGSTROM: f64 = 1e-5;
/// Lists of a cell, one for each [`Kind`].
const KINDS: usize = 3;

/// An open-addressed table from chunks to their cells' lists; only chunks near an atom exist.
#[derive(Debug, Clone)]
pub(super) struct FeatureIndex {
    cell_edge: f64,
    cells_per_angstrom: f64,
    table: ChunkTable,
    /// Starts of entries: those of kind k in list l are `starts[3 l + k] .. starts[3 l + k + 1]`.
    starts: Vec<u32>,
    entries: Vec<Entry>,
}

/// A feature in a list.
#[derive(Debug, Clone, Copy)]
pub(super) struct Entry {
    /// Lower bound of the distance of the feature from the middle of the cell, Å; for an atom, the
    /// distance of its expanded sphere, negative inside.
    bound: f32,
    pub(super) number: u32,
}

/// The lists of a cell, nearest first.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Lists<'a> {
    pub(super) atoms: &'a [Entry],
    pub(super) arcs: &'a [Entry],
    pub(super) vertices: &'a [Entry],
}

/// The lists of the cell that a point is in.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Nearby<'a> {
    pub(super) lists: Lists<'a>,
    /// Distance of the point from the middle of the cell, Å, and what rounding of the bounds may add.
    pub(super) from_middle: f64,
}

impl Entry {
    /// An entry of which nothing is known.
    pub(super) fn unknown(number: u32) -> Self {
        Self {
            // Never beyond: lists without bounds are searched to the end.
            bound: f32::NEG_INFINITY,
            number,
        }
    }

    /// Orders entries by bound and then by number.
    fn key(&self) -> u64 {
        let bits = self.bound.to_bits();
        // Negative numbers are in reverse order, and after the others.
        // Floats of one sign order like their bits; flipped so that integers compare as floats do.
        let ordered = if bits >> 31 == 1 {
            !bits
        } else {
            bits | 1 << 31
        };
        // The number as tie-break makes the order of equals independent of the sort.
        u64::from(ordered) << 32 | u64::from(self.number)
    }

    /// The entry with this key.
    fn of_key(key: u64) -> Self {
        let ordered = (key >> 32) as u32;
        let bits = if ordered >> 31 == 1 {
            ordered & !(1 << 31)
        } else {
            !ordered
        };
        Self {
            bound: f32::from_bits(bits),
            number: key as u32,
        }
    }

    /// Whether the feature, and so all that follow in its list, is beyond [`limit`].
    #[inline]
    pub(super) fn is_beyond(&self, limit: f32) -> bool {
        self.bound >= limit
    }
}

/// The bound of features that are at least this far from a point `from_middle` from the middle of the
/// cell. Single precision rounds it by far less than `from_middle` has to spare.
#[inline]
pub(super) fn limit(distance: f64, from_middle: f64) -> f32 {
    // Rounding in f32 is relative, 6e-8; `from_middle` holds 1e-5 Å to spare.
    (distance + from_middle) as f32
}

/// The kinds of feature, in the order of their lists.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Atom = 0,
    Arc = 1,
    Vertex = 2,
}

/// A feature and the ball about it in whose cells it may be listed.
pub(super) struct Feature {
    pub(super) kind: Kind,
    pub(super) number: u32,
    pub(super) centre: Vec3,
    pub(super) radius: f64,
    /// Radius of the expanded ball of an atom, in which depth is measured, Å.
    pub(super) depth_radius: f64,
}

impl FeatureIndex {
    /// Lists the features of each cell: the atoms that may be the ones in whose balls a point of the
    /// cell lies deepest, and, in cells with points of depth 0 to `reach`, the arcs and vertices that
    /// may be within `reach` of it; `distance` is a lower bound of that of an arc from a point. Atoms
    /// come first among `features`.
    pub(super) fn new(
        cell_edge: f64,
        features: &[Feature],
        reach: f64,
        distance: impl Fn(u32, &Vec3) -> f64,
    ) -> Self {
        // No point of a cell is farther from its middle than this; the factor covers rounding.
        let half_diagonal = 0.5 * 3.0_f64.sqrt() * cell_edge * (1.0 + 1e-9);
        let mut grid = Grid {
            cell_edge,
            cells_per_angstrom: cell_edge.recip(),
            table: ChunkTable::new(),
        };
        // The greatest depth of each cell's middle.
        let mut deepest: Vec<f64> = Vec::new();
        // Atoms come first, since the cells near them are the only ones that exist.
        let atoms = features.iter().take_while(|f| f.kind == Kind::Atom);
        for atom in atoms {
            grid.add_chunks(atom);
            deepest.resize(grid.table.chunks * CELLS, f64::NEG_INFINITY);
            grid.for_each_cell(atom, |cell, middle| {
                let depth = atom.depth_radius - (middle - atom.centre).norm();
                deepest[cell] = deepest[cell].max(depth);
            });
        }
        // A lower bound of the distance from the middle of a cell, if that shows that the feature may
        // matter there; depths and distances change by the way at most.
        let bound = |feature: &Feature, cell: usize, middle: &Vec3| {
            let from_centre = || (middle - feature.centre).norm();
            let (bound, limit) = match feature.kind {
                Kind::Atom => {
                    // At a point of the cell the deepest ball reaches at least
                    // deepest - h, with h half the diagonal, and this ball at
                    // most -bound + h: it matters only if bound <= 2 h - deepest.
                    let limit = 2.0 * half_diagonal - deepest[cell];
                    (from_centre() - feature.depth_radius, limit)
                }
                // No point of the cell has a depth between 0
                // and the reach, where edges can be nearest.
                _ if deepest[cell] < -half_diagonal || deepest[cell] > reach + half_diagonal => {
                    return None;
                }
                // A point of the cell is at most h from the
                // middle, so its distance is at least bound - h.
                Kind::Arc => (distance(feature.number, middle), reach + half_diagonal),
                Kind::Vertex => (from_centre(), reach + half_diagonal),
            };
            (bound <= limit).then_some(bound as f32)
        };
        let mut pairs: Vec<(u32, Entry)> = Vec::new();
        for feature in features {
            grid.for_each_cell(feature, |cell, middle| {
                if let Some(bound) = bound(feature, cell, &middle) {
                    let list = KINDS * cell + feature.kind as usize;
                    let number = feature.number;
                    pairs.push((list as u32, Entry { bound, number }));
                }
            });
        }
        // A counting sort by list: count, sum up, place. Then each list is sorted for itself.
        let mut starts = vec![0_u32; KINDS * deepest.len() + 1];
        for (list, _) in &pairs {
            starts[*list as usize + 1] += 1;
        }
        for list in 1..starts.len() {
            starts[list] += starts[list - 1];
        }
        // This copy moves on as the lists fill; `starts` is kept.
        let mut filled = starts.clone();
        let mut keys = vec![0; pairs.len()];
        for (list, entry) in pairs {
            let place = &mut filled[list as usize];
            keys[*place as usize] = entry.key();
            *place += 1;
        }
        // As integers: a key holds bound and number, so sorting moves one word each.
        for ends in starts.windows(2) {
            keys[ends[0] as usize..ends[1] as usize].sort_unstable();
        }
        let entries = keys.into_iter().map(Entry::of_key).collect();
        Self {
            cell_edge,
            cells_per_angstrom: grid.cells_per_angstrom,
            table: grid.table,
            starts,
            entries,
        }
    }

    /// The features that matter at `point` (and some others).
    pub(super) fn nearby(&self, point: &Vec3) -> Nearby<'_> {
        let Some(cell) = self.cell_of(point) else {
            return Nearby::default();
        };
        Nearby {
            lists: self.lists(cell.list),
            from_middle: cell.distance_from_middle(point),
        }
    }

    /// Coordinates of the cell of a point among all cells.
    #[inline]
    pub(super) fn place_of(&self, point: &Vec3) -> [i32; 3] {
        [point.x, point.y, point.z].map(|x| cell_number(x * self.cells_per_angstrom))
    }

    /// The number of the lists of the cell at a place, if it has any.
    #[inline]
    pub(super) fn list_at(&self, place: &[i32; 3]) -> Option<u32> {
        let chunk = self.table.get(&chunk_of(*place))?;
        Some(chunk * CELLS as u32 + cell_in_chunk(*place) as u32)
    }

    /// The cell of a point, if it has lists.
    #[inline]
    pub(super) fn cell_of(&self, point: &Vec3) -> Option<Cell> {
        let place = self.place_of(point);
        let list = self.list_at(&place)?;
        let middle = place.map(|n| (f64::from(n) + 0.5) * self.cell_edge);
        let middle = Vec3::from(middle);
        Some(Cell { list, middle })
    }

    /// The lists of a cell.
    #[inline]
    pub(super) fn lists(&self, list: u32) -> Lists<'_> {
        let first = KINDS * list as usize;
        let [a, b, c, d] = [0, 1, 2, 3].map(|kind| self.starts[first + kind] as usize);
        Lists {
            atoms: &self.entries[a..b],
            arcs: &self.entries[b..c],
            vertices: &self.entries[c..d],
        }
    }
}

/// A cell that has lists.
pub(super) struct Cell {
    /// Number of the lists of the cell.
    pub(super) list: u32,
    middle: Vec3,
}

impl Cell {
    /// Distance of a point from the middle, Å, and what rounding of the bounds may add.
    #[inline]
    pub(super) fn distance_from_middle(&self, point: &Vec3) -> f64 {
        (point - self.middle).norm() + ROUNDING_ANGSTROM
    }

    /// A point seen from the middle.
    #[inline]
    pub(super) fn seen(&self, point: &Vec3) -> [f32; 3] {
        let offset = point - self.middle;
        [offset.x as f32, offset.y as f32, offset.z as f32]
    }
}

/// Cells of one size, some of which exist.
struct Grid {
    cell_edge: f64,
    cells_per_angstrom: f64,
    table: ChunkTable,
}

impl Grid {
    /// Makes the chunks that the ball of a feature may reach.
    fn add_chunks(&mut self, feature: &Feature) {
        let [low, high] = self.cells_about(feature).map(chunk_of);
        for x in low[0]..=high[0] {
            for y in low[1]..=high[1] {
                for z in low[2]..=high[2] {
                    self.table.add([x, y, z]);
                }
            }
        }
    }

    /// Visits the number and the middle of each cell that the ball of a feature reaches.
    fn for_each_cell(&self, feature: &Feature, mut visit: impl FnMut(usize, Vec3)) {
        let [low, high] = self.cells_about(feature);
        let [first, last] = [chunk_of(low), chunk_of(high)];
        for x in first[0]..=last[0] {
            for y in first[1]..=last[1] {
                for z in first[2]..=last[2] {
                    let Some(chunk) = self.table.get(&[x, y, z]) else {
                        continue;
                    };
                    // Saturating: a place near the end of i32 must not wrap to the other side.
                    let least = [x, y, z].map(|x| x.saturating_mul(CHUNK));
                    let greatest = least.map(|x| x.saturating_add(CHUNK - 1));
                    let from = [0, 1, 2].map(|axis| least[axis].max(low[axis]));
                    let to = [0, 1, 2].map(|axis| greatest[axis].min(high[axis]));
                    self.for_each_cell_between(feature, from, to, |cell, middle| {
                        visit(chunk as usize * CELLS + cell_in_chunk(cell), middle);
                    });
                }
            }
        }
    }

    fn for_each_cell_between(
        &self,
        feature: &Feature,
        from: [i32; 3],
        to: [i32; 3],
        mut visit: impl FnMut([i32; 3], Vec3),
    ) {
        let (edge, centre) = (self.cell_edge, feature.centre);
        let square = feature.radius * feature.radius;
        let middle = |n: i32| (f64::from(n) + 0.5) * edge;
        for x in from[0]..=to[0] {
            // What a ball of the radius has left for y and z; negative if x
            // alone is too far, and then no z satisfies the last comparison.
            let square = square - gap(x, centre.x, edge).powi(2);
            for y in from[1]..=to[1] {
                let square = square - gap(y, centre.y, edge).powi(2);
                for z in from[2]..=to[2] {
                    if gap(z, centre.z, edge).powi(2) <= square {
                        visit([x, y, z], Vec3::new(middle(x), middle(y), middle(z)));
                    }
                }
            }
        }
    }

    /// The lowest and the highest cell of the box about a feature's ball.
    fn cells_about(&self, feature: &Feature) -> [[i32; 3]; 2] {
        [-1.0, 1.0].map(|side| {
            let corner = feature.centre.add_scalar(side * feature.radius);
            [corner.x, corner.y, corner.z].map(|x| cell_number(x * self.cells_per_angstrom))
        })
    }
}

fn chunk_of(cell: [i32; 3]) -> [i32; 3] {
    // Shift and mask are floor division and remainder for negative cells too.
    cell.map(|x| x >> CHUNK_BITS)
}

fn cell_in_chunk(cell: [i32; 3]) -> usize {
    let [x, y, z] = cell.map(|x| x & (CHUNK - 1));
    ((x * CHUNK + y) * CHUNK + z) as usize
}

/// The floor of a coordinate in cells, without the call that `f64::floor` is on processors without
/// SSE 4.1.
fn cell_number(cells: f64) -> i32 {
    let towards_zero = cells as i32;
    // The cast rounds towards zero: one less where that was upwards.
    towards_zero.saturating_sub(i32::from(f64::from(towards_zero) > cells))
}

/// Distance by which a coordinate lies outside the cells numbered `n` along an axis.
fn gap(n: i32, x: f64, edge: f64) -> f64 {
    // At most one of the two is positive.
    let (below, above) = (f64::from(n) * edge - x, x - (f64::from(n) + 1.0) * edge);
    below.max(above).max(0.0)
}

/// The numbers of chunks by their place, in an open-addressed table.
#[derive(Debug, Clone)]
struct ChunkTable {
    /// Place and number; [`EMPTY`] marks an empty slot. The length is a power of two.
    slots: Vec<([i32; 3], u32)>,
    chunks: usize,
}

const EMPTY: u32 = u32::MAX;

impl ChunkTable {
    fn new() -> Self {
        Self {
            slots: vec![([0; 3], EMPTY); 64],
            chunks: 0,
        }
    }

    fn get(&self, place: &[i32; 3]) -> Option<u32> {
        let number = self.slots[self.find(place)].1;
        (number != EMPTY).then_some(number)
    }

    /// Adds a chunk, if it is not there yet.
    fn add(&mut self, place: [i32; 3]) {
        // Half full at most: chains of occupied slots stay
        // short, and `find` always meets an empty one.
        if 2 * self.chunks >= self.slots.len() {
            self.grow();
        }
        let slot = self.find(&place);
        if self.slots[slot].1 == EMPTY {
            self.slots[slot] = (place, self.chunks as u32);
            self.chunks += 1;
        }
    }

    fn grow(&mut self) {
        let old = std::mem::take(&mut self.slots);
        self.slots = vec![([0; 3], EMPTY); 2 * old.len()];
        for entry in old {
            if entry.1 != EMPTY {
                let slot = self.find(&entry.0);
                self.slots[slot] = entry;
            }
        }
    }

    /// The slot that holds `place`, or the empty slot where it belongs.
    fn find(&self, place: &[i32; 3]) -> usize {
        let mask = self.slots.len() - 1;
        // The mask is a remainder, as the length is a power of two.
        let mut slot = hash(place) as usize & mask;
        while self.slots[slot].1 != EMPTY && self.slots[slot].0 != *place {
            slot = (slot + 1) & mask;
        }
        slot
    }
}

fn hash(place: &[i32; 3]) -> u64 {
    // Neighbouring chunks differ by 1 in one coordinate: each gets its own odd
    // multiplier, turned so that the three do not cancel in the exclusive or.
    let [x, y, z] = place.map(|x| u64::from(x as u32));
    let mixed = x.wrapping_mul(0x9e37_79b9_7f4a_7c15)
        ^ y.wrapping_mul(0xc2b2_ae3d_27d4_eb4f).rotate_left(21)
        ^ z.wrapping_mul(0x1656_67b1_9e37_79f9).rotate_left(42);
    let folded = mixed ^ (mixed >> 32);
    // The low bits choose the slot, so the well mixed high ones are brought down.
    folded.wrapping_mul(0xd6e8_feb8_6659_fd93) >> 20
}
