//! Kyte-Doolittle indices around a place.

use protomer_kernel::Vec3;
use rustc_hash::FxHashMap;

/// Averages of the indices of residues near a place.
///
/// The value at a place is the mean of the Kyte-Doolittle indices (J. Mol. Biol. 157, 105 (1982))
/// of all residues with an atom within reach, each counted once; where no residue is within reach,
/// that of the residue of the nearest atom. Residues without an index are skipped.
///
/// ```
/// use protomer_field::voxels::hydropathy::HydropathyMap;
/// use protomer_kernel::Vec3;
/// let isoleucine = (Vec3::zeros(), Some(0));
/// let arginine = (Vec3::new(3.0, 0.0, 0.0), Some(1));
/// let map = HydropathyMap::new([isoleucine, arginine], &[Some(4.5), Some(-4.5)], 2.0);
/// assert_eq!(map.at(&Vec3::new(0.5, 0.0, 0.0)), Some(4.5));
/// assert_eq!(map.at(&Vec3::new(1.5, 0.0, 0.0)), Some(0.0));
/// ```
#[derive(Debug, Clone)]
pub struct HydropathyMap {
    reach: f64,
    /// Atoms of residues with an index.
    atoms: Vec<ResidueAtom>,
    indices: Vec<Option<f64>>,
    /// The same by cells as wide as the reach, those of a residue one after the other.
    cells: FxHashMap<[i32; 3], Vec<ResidueAtom>>,
}

#[derive(Debug, Clone, Copy)]
struct ResidueAtom {
    place: Vec3,
    residue: u32,
}

impl HydropathyMap {
    /// The map of atoms (place in Å, residue) and the index of each residue.
    pub fn new(
        atoms: impl IntoIterator<Item = (Vec3, Option<u32>)>,
        indices: &[Option<f64>],
        reach_angstrom: f64,
    ) -> Self {
        let mut map = Self {
            reach: reach_angstrom,
            atoms: Vec::new(),
            indices: indices.to_vec(),
            cells: FxHashMap::default(),
        };
        for (place, residue) in atoms {
            if let Some(residue) = residue
                && let Some(Some(_)) = indices.get(residue as usize)
            {
                let atom = ResidueAtom { place, residue };
                map.cells.entry(map.cell(&place)).or_default().push(atom);
                map.atoms.push(atom);
            }
        }
        map
    }

    /// The mean index at a place; `None` if no residue has one.
    pub fn at(&self, place: &Vec3) -> Option<f64> {
        let mut residues = self.residues_within_reach(place);
        if residues.is_empty() {
            residues.push(self.nearest_residue(place)?);
        }
        // In the order of the chain, so that rounding does not depend on the cells.
        residues.sort_unstable();
        let mut sum = 0.0;
        for residue in &residues {
            sum += self.indices[*residue as usize].unwrap_or(0.0);
        }
        Some(sum / residues.len() as f64)
    }

    fn residues_within_reach(&self, place: &Vec3) -> Vec<u32> {
        let [x, y, z] = self.cell(place);
        let mut residues = Vec::with_capacity(16);
        for n in 0..27 {
            let cell = [x + n % 3 - 1, y + n / 3 % 3 - 1, z + n / 9 - 1];
            let mut found = None;
            for atom in self.cells.get(&cell).into_iter().flatten() {
                // One atom of a residue is enough; others of it come next.
                if found == Some(atom.residue)
                    || (atom.place - place).norm_squared() > self.reach * self.reach
                {
                    continue;
                }
                found = Some(atom.residue);
                if !residues.contains(&atom.residue) {
                    residues.push(atom.residue);
                }
            }
        }
        residues
    }

    fn nearest_residue(&self, place: &Vec3) -> Option<u32> {
        let mut least = f64::INFINITY;
        let mut nearest = None;
        for atom in &self.atoms {
            let squared = (atom.place - place).norm_squared();
            if squared < least {
                least = squared;
                nearest = Some(atom.residue);
            }
        }
        nearest
    }

    fn cell(&self, place: &Vec3) -> [i32; 3] {
        [place.x, place.y, place.z].map(|x| (x / self.reach).floor() as i32)
    }
}
