//! Which residue a place of a body belongs to.

use crate::energy::terms::Term;
use protomer_body::Body;
use protomer_body::residue_contacts::{Bead, beads_of};
use protomer_kernel::Vec3;
use std::collections::HashMap;
use std::sync::{PoisonError, RwLock};

/// The residues of a body by their places: a bead is its own residue's, any other place that of the
/// residue of the nearest atom.
#[derive(Debug)]
pub struct ResiduePlaces {
    residues: usize,
    atoms: Vec<(Vec3, usize)>,
    beads: Vec<Bead>,
    /// Residues of places already met: terms hand out the same places again and again.
    residues_by_place: RwLock<HashMap<[u64; 3], Option<usize>>>,
}

impl ResiduePlaces {
    /// The places of a body.
    pub fn from_body(body: &Body) -> Self {
        let mut atoms = Vec::with_capacity(body.sites.len());
        for site in &body.sites {
            if let Some(residue) = site.residue {
                atoms.push((site.position, residue as usize));
            }
        }
        Self {
            residues: body.residues.len(),
            atoms,
            beads: beads_of(body),
            residues_by_place: RwLock::default(),
        }
    }

    /// Number of residues.
    pub fn len(&self) -> usize {
        self.residues
    }

    /// Whether the body has no residues.
    pub fn is_empty(&self) -> bool {
        self.residues == 0
    }

    /// The residue of a place that a term of the energy hands out, in the body's frame (Å); `None`
    /// for a body without residues.
    pub fn of_term(&self, term: Term, place: &Vec3) -> Option<usize> {
        if term == Term::Contacts {
            return self.nearest_bead(place);
        }
        let key = [place.x.to_bits(), place.y.to_bits(), place.z.to_bits()];
        let residues = self
            .residues_by_place
            .read()
            .unwrap_or_else(PoisonError::into_inner);
        if let Some(residue) = residues.get(&key) {
            return *residue;
        }
        drop(residues);
        let residue = self.nearest(place);
        let mut residues = self
            .residues_by_place
            .write()
            .unwrap_or_else(PoisonError::into_inner);
        residues.insert(key, residue);
        residue
    }

    /// The residue of the atom whose centre is nearest to a place in the body's frame (Å).
    pub fn nearest(&self, place: &Vec3) -> Option<usize> {
        let mut nearest = (f64::INFINITY, None);
        for (position, residue) in &self.atoms {
            let square = (position - place).norm_squared();
            if square < nearest.0 {
                nearest = (square, Some(*residue));
            }
        }
        nearest.1
    }

    fn nearest_bead(&self, place: &Vec3) -> Option<usize> {
        let square = |bead: &&Bead| (bead.position - place).norm_squared();
        let nearest = self
            .beads
            .iter()
            .min_by(|a, b| square(a).total_cmp(&square(b)));
        nearest.map(|bead| bead.residue)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contributions::tests::body_of;

    #[test]
    fn a_place_belongs_to_the_residue_of_the_nearest_atom() {
        let mut body = body_of(&[("LYS", 0.0, 1.0), ("GLU", 10.0, -1.0)]);
        let nearest =
            |body: &Body, x: f64| ResiduePlaces::from_body(body).nearest(&Vec3::new(x, 3.0, 0.0));
        assert_eq!(
            [-20.0, 4.9, 5.1, 30.0].map(|x| nearest(&body, x)),
            [0, 0, 1, 1].map(Some)
        );
        // A bare charge has no residue.
        body.sites[1].residue = None;
        assert_eq!(nearest(&body, 30.0), Some(0));
    }
}
