//! Which features matter near a point: a hashed grid of small cells with lists of feature numbers.

use protomer_kernel::Vec3;

/// An open-addressed table from cells to lists; only cells near a feature exist.
#[derive(Debug, Clone)]
pub(super) struct FeatureIndex {
    cell_edge: f64,
    /// Cell and list number; `u32::MAX` marks an empty slot. The length is a power of two.
    slots: Vec<([i64; 3], u32)>,
    /// For list l of kind k, entries `starts[3 l + k] .. starts[3 l + k + 1]`.
    starts: Vec<u32>,
    entries: Vec<u32>,
}

/// The lists of one cell.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Nearby<'a> {
    pub(super) atoms: &'a [u32],
    pub(super) arcs: &'a [u32],
    pub(super) vertices: &'a [u32],
}

/// The three kinds of feature, in the order of their lists.
#[derive(Debug, Clone, Copy)]
pub(super) enum Kind {
    Atom = 0,
    Arc = 1,
    Vertex = 2,
}

/// Collects (cell, feature) pairs and sorts them into a [`FeatureIndex`].
pub(super) struct Builder {
    cell_edge: f64,
    slots: Vec<([i64; 3], u32)>,
    lists: u32,
    pairs: Vec<(u32, u32)>,
}

const EMPTY: u32 = u32::MAX;

impl Builder {
    pub(super) fn new(cell_edge: f64) -> Self {
        Self {
            cell_edge,
            slots: vec![([0; 3], EMPTY); 64],
            lists: 0,
            pairs: Vec::new(),
        }
    }

    /// Enters a feature into every cell within `reach` of the ball (centre, radius) that holds it,
    /// unless `is_far` says of a cell, given by the ball about it, that no point of it is within
    /// reach.
    pub(super) fn insert(
        &mut self,
        (kind, feature): (Kind, u32),
        (centre, radius): (&Vec3, f64),
        reach: f64,
        is_far: impl Fn(&Vec3, f64) -> bool,
    ) {
        let edge = self.cell_edge;
        let limit = radius + reach;
        let half_diagonal = 0.5 * 3.0_f64.sqrt() * edge * (1.0 + 1e-9);
        let gap = |n: i64, x: f64| gap(n, x, edge);
        let span = |x: f64, half: f64| cell_number(x - half, edge)..=cell_number(x + half, edge);
        for x in span(centre.x, limit) {
            let square = limit * limit - gap(x, centre.x).powi(2);
            for y in span(centre.y, square.max(0.0).sqrt()) {
                let square = square - gap(y, centre.y).powi(2);
                for z in span(centre.z, square.max(0.0).sqrt()) {
                    let middle = Vec3::new(x as f64 + 0.5, y as f64 + 0.5, z as f64 + 0.5) * edge;
                    if !is_far(&middle, half_diagonal) {
                        let list = self.list([x, y, z]);
                        self.pairs.push((3 * list + kind as u32, feature));
                    }
                }
            }
        }
    }

    /// The list of a cell, a new one if it has none yet.
    fn list(&mut self, cell: [i64; 3]) -> u32 {
        if 2 * self.lists as usize >= self.slots.len() {
            self.grow();
        }
        let slot = find(&self.slots, &cell);
        if self.slots[slot].1 == EMPTY {
            self.slots[slot] = (cell, self.lists);
            self.lists += 1;
        }
        self.slots[slot].1
    }

    fn grow(&mut self) {
        let old = std::mem::take(&mut self.slots);
        self.slots = vec![([0; 3], EMPTY); 2 * old.len()];
        for entry in old {
            if entry.1 != EMPTY {
                let slot = find(&self.slots, &entry.0);
                self.slots[slot] = entry;
            }
        }
    }

    pub(super) fn finish(self) -> FeatureIndex {
        let mut starts = vec![0_u32; 3 * self.lists as usize + 1];
        for (list, _) in &self.pairs {
            starts[*list as usize + 1] += 1;
        }
        for list in 1..starts.len() {
            starts[list] += starts[list - 1];
        }
        let mut filled = starts.clone();
        let mut entries = vec![0; self.pairs.len()];
        for (list, feature) in self.pairs {
            entries[filled[list as usize] as usize] = feature;
            filled[list as usize] += 1;
        }
        FeatureIndex {
            cell_edge: self.cell_edge,
            slots: self.slots,
            starts,
            entries,
        }
    }
}

impl FeatureIndex {
    /// The features within their reach of `point` (and some that are a little farther).
    pub(super) fn nearby(&self, point: &Vec3) -> Nearby<'_> {
        let slot = find(&self.slots, &cell_of(point, self.cell_edge));
        let list = self.slots[slot].1;
        if list == EMPTY {
            return Nearby::default();
        }
        let first = 3 * list as usize;
        let [a, b, c, d] = [0, 1, 2, 3].map(|kind| self.starts[first + kind] as usize);
        Nearby {
            atoms: &self.entries[a..b],
            arcs: &self.entries[b..c],
            vertices: &self.entries[c..d],
        }
    }
}

fn cell_of(point: &Vec3, edge: f64) -> [i64; 3] {
    [point.x, point.y, point.z].map(|x| cell_number(x, edge))
}

fn cell_number(x: f64, edge: f64) -> i64 {
    (x / edge).floor() as i64
}

/// How far a coordinate lies outside the cells numbered `n` along an axis.
fn gap(n: i64, x: f64, edge: f64) -> f64 {
    let (below, above) = (n as f64 * edge - x, x - (n + 1) as f64 * edge);
    below.max(above).max(0.0)
}

/// The slot that holds `cell`, or the empty slot where it belongs.
fn find(slots: &[([i64; 3], u32)], cell: &[i64; 3]) -> usize {
    let mask = slots.len() - 1;
    let mut slot = hash(cell) as usize & mask;
    while slots[slot].1 != EMPTY && slots[slot].0 != *cell {
        slot = (slot + 1) & mask;
    }
    slot
}

fn hash(cell: &[i64; 3]) -> u64 {
    let mixed = (cell[0] as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15)
        ^ (cell[1] as u64)
            .wrapping_mul(0xc2b2_ae3d_27d4_eb4f)
            .rotate_left(21)
        ^ (cell[2] as u64)
            .wrapping_mul(0x1656_67b1_9e37_79f9)
            .rotate_left(42);
    let folded = mixed ^ (mixed >> 32);
    folded.wrapping_mul(0xd6e8_feb8_6659_fd93) >> 20
}
