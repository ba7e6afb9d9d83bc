//! Energies of symmetric arrangements.
//!
//!   E = Σ over orbits |orbit| · ½ Σ_j U(representative, j)
//!
//! Symmetry makes every body of an orbit equal, and each pair belongs to two bodies.

use protomer_body::assembly::Placement;
use protomer_body::assembly::orbits::Orbit;
use protomer_kernel::pose::RelativePose;
use protomer_mc::energy::terms::{EnergyParts, Term, TermsOfKinds};
use std::collections::BTreeMap;

/// Terms of the energy of each two kinds of bodies.
pub(super) struct PairEnergies(pub TermsOfKinds);

impl PairEnergies {
    /// The energy of an arrangement by terms, kT.
    pub fn energy(&self, placements: &[Placement], orbits: &[Orbit]) -> EnergyParts {
        let mut sum = EnergyParts::default();
        for orbit in orbits {
            let share = 0.5 * orbit.bodies as f64;
            for other in (0..placements.len()).filter(|other| *other != orbit.representative) {
                let pair = self.pair(&placements[orbit.representative], &placements[other]);
                for (term, energy_kt) in pair {
                    sum.add(term, share * energy_kt);
                }
            }
        }
        sum
    }

    /// The parts of an energy by the names of the terms that act, kT.
    pub fn by_name(&self, energy: &EnergyParts) -> BTreeMap<&'static str, f64> {
        let terms = self.0.values().flat_map(|all| &all.0);
        terms
            .map(|term| (term.term().name(), energy.part_kt(term.term())))
            .collect()
    }

    /// The energies of two placed bodies, kT.
    fn pair(&self, a: &Placement, b: &Placement) -> Vec<(Term, f64)> {
        // Terms are made for the lower kind first.
        let (a, b) = if a.0 <= b.0 { (a, b) } else { (b, a) };
        let displacement = b.1.position - a.1.position;
        let relative = RelativePose::new(&a.1, &b.1, &displacement);
        let terms = self.0.get(&(a.0, b.0)).into_iter().flat_map(|all| &all.0);
        terms
            .map(|term| (term.term(), term.energy_kt(&relative)))
            .collect()
    }
}
