//! Kyte-Doolittle indices around a place.

use protomer_kernel::Vec3;
use std::collections::HashMap;

/// Averages of residues' indices over those near a place.
///
/// The value at a place is the mean of the Kyte-Doolittle indices (J. Mol. Biol. 157, 105 (1982))
/// of all residues with an atom within the reach of it, each counted once; where there is none,
/// that of the residue of the nearest atom. Residues that the scale has no value for are passed
/// over.
#[derive(Debug, Clone)]
pub struct HydropathyMap {
    reach: f64,
    /// Atoms of residues with a value: where, and which residue.
    atoms: Vec<(Vec3, u32)>,
    values: Vec<Option<f64>>,
    /// Atoms by cells of the reach's edge.
    cells: HashMap<[i32; 3], Vec<u32>>,
}

impl HydropathyMap {
    /// The map of atoms (place in Å, residue) and their residues' indices.
    pub fn new(
        atoms: impl Iterator<Item = (Vec3, Option<u32>)>,
        values: &[Option<f64>],
        reach_angstrom: f64,
    ) -> Self {
        let has_value = |residue: &u32| matches!(values.get(*residue as usize), Some(Some(_)));
        let atoms: Vec<(Vec3, u32)> = atoms
            .filter_map(|(place, residue)| Some((place, residue.filter(has_value)?)))
            .collect();
        let mut cells: HashMap<[i32; 3], Vec<u32>> = HashMap::new();
        for (number, (place, _)) in atoms.iter().enumerate() {
            cells
                .entry(cell(place, reach_angstrom))
                .or_default()
                .push(number as u32);
        }
        Self {
            reach: reach_angstrom,
            atoms,
            values: values.to_vec(),
            cells,
        }
    }

    /// The mean index at a place; `None` if no residue has one.
    pub fn at(&self, place: &Vec3) -> Option<f64> {
        let mut near: Vec<u32> = Vec::with_capacity(16);
        let middle = cell(place, self.reach);
        let around = (0..27).map(|n| {
            [
                middle[0] + n % 3 - 1,
                middle[1] + n / 3 % 3 - 1,
                middle[2] + n / 9 - 1,
            ]
        });
        for (position, residue) in around
            .filter_map(|at| self.cells.get(&at))
            .flatten()
            .map(|n| self.atoms[*n as usize])
        {
            if (position - place).norm_squared() <= self.reach * self.reach
                && !near.contains(&residue)
            {
                near.push(residue);
            }
        }
        if near.is_empty() {
            let distance = |atom: &&(Vec3, u32)| (atom.0 - place).norm_squared();
            near.extend(
                self.atoms
                    .iter()
                    .min_by(|a, b| distance(a).total_cmp(&distance(b)))
                    .map(|atom| atom.1),
            );
        }
        // In the order of the chain, so that rounding does not depend on the cells.
        near.sort_unstable();
        let sum: f64 = near
            .iter()
            .filter_map(|residue| self.values[*residue as usize])
            .sum();
        (!near.is_empty()).then(|| sum / near.len() as f64)
    }
}

fn cell(place: &Vec3, edge: f64) -> [i32; 3] {
    [place.x, place.y, place.z].map(|x| (x / edge).floor() as i32)
}
