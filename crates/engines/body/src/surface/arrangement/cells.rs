//! A hashed cell list: memory grows with the number of atoms, never with the space they span.

use crate::surface::hashing::FastMap;
use protomer_kernel::Vec3;

/// Indices of atoms sorted into cubic cells; only occupied cells are stored.
#[derive(Debug, Clone)]
pub(crate) struct CellList {
    cell_edge: f64,
    ranges: FastMap<[i64; 3], (u32, u32)>,
    atoms: Vec<u32>,
}

impl CellList {
    /// Sorts `members`, indices into `centres`, into cells of this edge, Å.
    pub(crate) fn new(
        centres: &[Vec3],
        members: impl Iterator<Item = u32>,
        cell_edge: f64,
    ) -> Self {
        let mut keyed: Vec<([i64; 3], u32)> = Vec::new();
        for atom in members {
            if let Some(centre) = centres.get(atom as usize) {
                keyed.push((cell_of(centre, cell_edge), atom));
            }
        }
        keyed.sort_unstable();
        let mut ranges: FastMap<[i64; 3], (u32, u32)> = FastMap::default();
        for (position, (key, _)) in (0..).zip(&keyed) {
            let (_, end) = ranges.entry(*key).or_insert((position, position));
            *end = position + 1;
        }
        Self {
            cell_edge,
            ranges,
            atoms: keyed.into_iter().map(|(_, atom)| atom).collect(),
        }
    }

    /// Number of candidates that queries at the places of all members would visit together.
    pub(crate) fn candidate_pairs(&self) -> u64 {
        let mut pairs = 0;
        for (key, (first, last)) in &self.ranges {
            let mut near = 0;
            for cell in around(key) {
                if let Some((first, last)) = self.ranges.get(&cell) {
                    near += u64::from(last - first);
                }
            }
            pairs += u64::from(last - first) * near;
        }
        pairs
    }

    /// Calls `visit` with every member in the cell of `point` and in the 26 cells around it: among
    /// them are all members within one cell edge.
    pub(crate) fn for_each_near(&self, point: &Vec3, mut visit: impl FnMut(u32)) {
        for key in around(&cell_of(point, self.cell_edge)) {
            if let Some(&(first, last)) = self.ranges.get(&key) {
                for &atom in &self.atoms[first as usize..last as usize] {
                    visit(atom);
                }
            }
        }
    }

    /// Members in the order of their cells, so that neighbours in space are near in memory.
    pub(crate) fn members(&self) -> &[u32] {
        &self.atoms
    }
}

fn cell_of(point: &Vec3, edge: f64) -> [i64; 3] {
    [point.x, point.y, point.z].map(|x| (x / edge).floor() as i64)
}

fn around(key: &[i64; 3]) -> impl Iterator<Item = [i64; 3]> + use<> {
    let [x, y, z] = *key;
    (0..27).map(move |n| [x + n / 9 - 1, y + n / 3 % 3 - 1, z + n % 3 - 1])
}
