//! Hydropathy indices around a place.

use protomer_kernel::Vec3;
use rayon::prelude::*;
use rustc_hash::FxHashMap;

/// Averages of the indices of residues near a place.
///
/// The value at a place is the mean of the indices of all residues with an atom within reach, each counted
/// once; where no residue is within reach, that of the residue of the nearest atom. Residues without an
/// index are skipped.
///
/// ```
/// use protomer_field::voxels::hydropathy::HydropathyMap;
/// use protomer_kernel::Vec3;
/// let isoleucine = (Vec3::zeros(), Some(0));
/// let arginine = (Vec3::new(3.0, 0.0, 0.0), Some(1));
/// let map = HydropathyMap::new([isoleucine, arginine], &[Some(4.5), Some(-4.5)], 2.0);
/// assert_eq!(map.value_at(&Vec3::new(0.5, 0.0, 0.0)), Some(4.5));
/// assert_eq!(map.value_at(&Vec3::new(1.5, 0.0, 0.0)), Some(0.0));
/// ```
#[derive(Debug, Clone)]
pub struct HydropathyMap {
    reach: f64,
    /// Atoms of residues with an index.
    atoms: Vec<ResidueAtom>,
    indices: Vec<Option<f64>>,
    /// Atoms of residues with an index, by cells as wide as the reach.
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
    ///
    /// ```
    /// use protomer_field::voxels::hydropathy::HydropathyMap;
    /// use protomer_kernel::Vec3;
    /// let atoms = [(Vec3::zeros(), Some(0)), (Vec3::x(), Some(1))];
    /// let leucine_and_ligand = HydropathyMap::new(atoms, &[Some(3.8), None], 2.0);
    /// assert_eq!(leucine_and_ligand.value_at(&Vec3::x()), Some(3.8), "the ligand has no index");
    /// assert_eq!(HydropathyMap::new(atoms, &[None, None], 2.0).value_at(&Vec3::x()), None);
    /// ```
    pub fn value_at(&self, place: &Vec3) -> Option<f64> {
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

    /// [`Self::value_at`] for many places: those in a cell share their candidates.
    ///
    /// ```
    /// use protomer_field::voxels::hydropathy::HydropathyMap;
    /// use protomer_kernel::Vec3;
    /// let map = HydropathyMap::new([(Vec3::zeros(), Some(0))], &[Some(4.5)], 5.0);
    /// assert_eq!(map.at_all(&[Vec3::x(), Vec3::y() * 9.0]), [Some(4.5), Some(4.5)]);
    /// ```
    pub fn at_all(&self, places: &[Vec3]) -> Vec<Option<f64>> {
        // Sorted by cell: places of one cell are neighbours and share their candidates.
        let mut by_cell: Vec<([i32; 3], usize)> = Vec::with_capacity(places.len());
        by_cell.extend(places.iter().map(|place| self.cell(place)).zip(0..));
        by_cell.sort_unstable();
        let groups: Vec<_> = by_cell.chunk_by(|a, b| a.0 == b.0).collect();
        let of_group = |group: &&[([i32; 3], usize)]| {
            let places: Vec<Vec3> = group.iter().map(|(_, number)| places[*number]).collect();
            let candidates = self.candidates(group[0].0, &places);
            let mean = |place| self.mean_among(&candidates, place);
            places.iter().map(mean).collect::<Vec<Option<f64>>>()
        };
        let of_groups: Vec<Vec<Option<f64>>> = groups.par_iter().map(of_group).collect();
        let mut all = vec![None; places.len()];
        // Back into the order of the places.
        for ((_, number), mean) in by_cell.iter().zip(of_groups.into_iter().flatten()) {
            all[*number] = mean;
        }
        all
    }

    /// The atoms within reach of the box around places of a cell, by residue.
    fn candidates(&self, cell: [i32; 3], places: &[Vec3]) -> Vec<ResidueAtom> {
        // The box of these places, not the whole cell: fewer candidates.
        let (mut low, mut high) = (places[0], places[0]);
        for place in places {
            (low, high) = (low.inf(place), high.sup(place));
        }
        let mut candidates = Vec::with_capacity(128);
        for cell in around(cell) {
            for atom in self.cells.get(&cell).into_iter().flatten() {
                let beyond = atom.place - atom.place.sup(&low).inf(&high);
                if beyond.norm_squared() <= self.reach * self.reach {
                    candidates.push(*atom);
                }
            }
        }
        candidates.sort_by_key(|atom| atom.residue);
        candidates
    }

    /// The mean index at a place with these atoms near, by residue.
    fn mean_among(&self, candidates: &[ResidueAtom], place: &Vec3) -> Option<f64> {
        let (mut sum, mut count, mut last) = (0.0, 0, None);
        for atom in candidates {
            // Candidates are by residue, so one comparison counts each residue once.
            if last != Some(atom.residue)
                && (atom.place - place).norm_squared() <= self.reach * self.reach
            {
                last = Some(atom.residue);
                sum += self.indices[atom.residue as usize].unwrap_or(0.0);
                count += 1;
            }
        }
        // No atom is within reach: the nearest residue, found among all.
        if count == 0 {
            return self.value_at(place);
        }
        Some(sum / f64::from(count))
    }

    fn residues_within_reach(&self, place: &Vec3) -> Vec<u32> {
        let mut residues = Vec::with_capacity(16);
        for cell in around(self.cell(place)) {
            for atom in self.cells.get(&cell).into_iter().flatten() {
                let within = (atom.place - place).norm_squared() <= self.reach * self.reach;
                if within && !residues.contains(&atom.residue) {
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

/// A cell and its 26 neighbours.
fn around([x, y, z]: [i32; 3]) -> impl Iterator<Item = [i32; 3]> {
    // n in base 3 gives the three steps.
    (0..27).map(move |n| [x + n % 3 - 1, y + n / 3 % 3 - 1, z + n / 9 - 1])
}

#[cfg(test)]
mod tests {
    use super::*;
    use protomer_kernel::random::CounterRng;

    /// The slow twin: each place by itself.
    #[test]
    fn many_places_get_what_each_gets() {
        let mut rng = CounterRng::new(12, 0, 0);
        let indices: Vec<Option<f64>> = (0..60)
            .map(|residue| (residue % 7 != 0).then(|| rng.uniform_in(-4.5, 4.5)))
            .collect();
        let atoms: Vec<(Vec3, Option<u32>)> = (0..400)
            .map(|atom| {
                (
                    rng.vector_in_ball(15.0),
                    (atom % 9 != 0).then_some(atom / 7),
                )
            })
            .collect();
        let map = HydropathyMap::new(atoms, &indices, 4.0);
        let places: Vec<Vec3> = (0..500).map(|_| rng.vector_in_ball(25.0)).collect();
        let slow: Vec<Option<f64>> = places.iter().map(|place| map.value_at(place)).collect();
        assert_eq!(map.at_all(&places), slow);
        assert_eq!(map.at_all(&[]), []);
    }
}
