//! The contributions of residues and of pairs of residues in one state.

use super::kind::{OwnedCharges, ResiduesOfKind};
use crate::System;
use crate::energy::reach::Reach;
use crate::energy::terms::{EnergyParts, PairParts};
use crate::energy::{SitePotential, TermsByType};
use crate::system::Pair;
use protomer_kernel::pose::RelativePose;
use protomer_kernel::potential::Yukawa;

/// Shares out the energies of states of a system.
pub struct Contributions {
    pub(super) kinds: Vec<ResiduesOfKind>,
    pub(super) potential: Yukawa,
    pub(super) reach_of_charges: Reach,
    terms: Option<(TermsByType, Reach)>,
    reach_of_touch: Reach,
    touching_angstrom: f64,
}

/// Contribution of one residue of one copy.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ResidueContribution {
    /// Energy of the residue with all others, each pair in full, kT.
    pub parts: EnergyParts,
    /// Whether it touches a residue of another body.
    pub touches: bool,
}

/// Contribution of one pair of residues, over all pairs of bodies of its kinds.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PairContribution {
    /// The energy by terms.
    pub parts: PairParts,
    /// Number of such pairs that touch.
    pub touching: f64,
}

/// The pairs of residues of two kinds of bodies. Of one kind, a pair stands where the first residue
/// is not after the second.
#[derive(Debug, Clone, PartialEq)]
pub struct ResiduePairs {
    /// The kinds, the smaller number first.
    pub kinds: (usize, usize),
    /// Residues of the second kind: the length of a row.
    pub columns: usize,
    /// The pairs, row after row by the residue of the first kind.
    pub pairs: Vec<PairContribution>,
}

/// Energies that hold the bodies together in one state.
#[derive(Debug, Clone, PartialEq)]
pub struct StateEnergies {
    /// The energy, kT.
    pub parts: EnergyParts,
    /// Contributions of the residues of each copy, in their order.
    pub residues: Vec<Vec<ResidueContribution>>,
    /// Contributions of the pairs of residues of each pair of kinds.
    pub pairs: Vec<ResiduePairs>,
    /// The part of the energy of the charges that comes from residues that touch nothing, kT: half
    /// of each pair with each of its residues.
    pub outside_kt: f64,
    /// The part of the energy of the charges between residues that do not touch each other, kT.
    pub apart_kt: f64,
}

/// A pair of bodies: what the pairs of residues contribute, row after row.
struct OfBodies {
    pairs: Vec<PairContribution>,
    /// Terms that belong to single residues of both bodies: solvent that a residue displaces, and the
    /// response of the solvent to its charges and its volume.
    single: [Vec<EnergyParts>; 2],
}

impl Contributions {
    /// Contributions for systems of these kinds of bodies; `kinds` are in the order of the types.
    /// Residues touch where heavy atoms are closer than `touching_angstrom`.
    pub fn new(
        system: &System,
        kinds: Vec<ResiduesOfKind>,
        potential: Yukawa,
        terms: Option<TermsByType>,
        touching_angstrom: f64,
    ) -> Self {
        let mut touch = Vec::new();
        for first in &kinds {
            for second in &kinds {
                touch.push(first.radius() + second.radius() + touching_angstrom);
            }
        }
        let reach_of_charges = Reach::new(system, &potential);
        Self {
            reach_of_charges,
            terms: terms.map(|terms| {
                let reach = terms.reach(system);
                (terms, reach)
            }),
            reach_of_touch: Reach::of_types(system, touch),
            kinds,
            potential,
            touching_angstrom,
        }
    }

    /// The residues of each kind.
    pub fn kinds(&self) -> &[ResiduesOfKind] {
        &self.kinds
    }

    /// The contributions in a state of the system.
    pub fn evaluate(&self, system: &System) -> StateEnergies {
        let mut state = self.nothing(system);
        for first in 0..system.len() {
            for second in first + 1..system.len() {
                let pair = system.pair(first, second);
                let energies = self.of_bodies(&pair);
                state.add(&pair, &energies, self.columns(&pair));
            }
        }
        // Touching is known once all pairs are: now half of each energy goes to each residue.
        for residue in state.residues.iter().flatten() {
            if !residue.touches {
                state.outside_kt += 0.5 * residue.parts.charges_kt;
            }
        }
        state
    }

    fn columns(&self, pair: &Pair<'_>) -> usize {
        self.kinds[pair.type_indices().1].len()
    }

    fn nothing(&self, system: &System) -> StateEnergies {
        let mut pairs = Vec::new();
        for (first, rows) in self.kinds.iter().enumerate() {
            for (second, columns) in self.kinds.iter().enumerate().skip(first) {
                pairs.push(ResiduePairs {
                    kinds: (first, second),
                    columns: columns.len(),
                    pairs: vec![PairContribution::default(); rows.len() * columns.len()],
                });
            }
        }
        let of_copy = |copy: usize| {
            let residues = self.kinds[system.type_index(copy)].len();
            vec![ResidueContribution::default(); residues]
        };
        StateEnergies {
            parts: EnergyParts::default(),
            residues: (0..system.len()).map(of_copy).collect(),
            pairs,
            outside_kt: 0.0,
            apart_kt: 0.0,
        }
    }

    fn of_bodies(&self, pair: &Pair<'_>) -> OfBodies {
        let (first, second) = pair.type_indices();
        let (ours, theirs) = (&self.kinds[first], &self.kinds[second]);
        let mut energies = OfBodies {
            pairs: vec![PairContribution::default(); ours.len() * theirs.len()],
            single: [ours, theirs].map(|kind| vec![EnergyParts::default(); kind.len()]),
        };
        for displacement in self.reach_of_charges.images(pair) {
            let relative = pair.relative_image(&displacement);
            self.add_charges(ours, theirs, &relative, &mut energies);
        }
        if let Some((terms, reach)) = &self.terms {
            for displacement in reach.images(pair) {
                let relative = pair.relative_image(&displacement);
                self.add_terms(terms, (first, second), &relative, &mut energies);
            }
        }
        let columns = theirs.len();
        for displacement in self.reach_of_touch.images(pair) {
            let relative = pair.relative_image(&displacement);
            ours.touching(theirs, &relative, self.touching_angstrom, |a, b| {
                energies.pairs[a * columns + b].touching = 1.0;
            });
        }
        energies
    }

    fn add_charges(
        &self,
        ours: &ResiduesOfKind,
        theirs: &ResiduesOfKind,
        relative: &RelativePose,
        energies: &mut OfBodies,
    ) {
        let columns = theirs.len();
        let their_charges = theirs.charges.moved(relative);
        let mut potentials = vec![0.0; their_charges.len()];
        for index in 0..ours.charges.len() {
            let place = ours.charges.place(index);
            let charge_e = ours.charges.charge_e[index];
            self.potentials_at(&place, &their_charges, &mut potentials);
            let row = &mut energies.pairs[ours.charges.residue[index] * columns..][..columns];
            for (residue, potential) in their_charges.residue.iter().zip(&potentials) {
                row[*residue].parts.charges_kt += charge_e * potential;
            }
        }
    }

    /// The potential (kT/e) of each of these charges at a place.
    pub(super) fn potentials_at(
        &self,
        place: &protomer_kernel::Vec3,
        charges: &OwnedCharges,
        potentials: &mut [f64],
    ) {
        let places = charges
            .x
            .iter()
            .zip(&charges.y)
            .zip(&charges.z)
            .zip(&charges.charge_e);
        for ((((x, y), z), charge_e), potential) in places.zip(potentials) {
            let (dx, dy, dz) = (x - place.x, y - place.y, z - place.z);
            *potential = charge_e * self.potential.at_square(dx * dx + dy * dy + dz * dz);
        }
    }

    fn add_terms(
        &self,
        terms: &TermsByType,
        (first, second): (usize, usize),
        relative: &RelativePose,
        energies: &mut OfBodies,
    ) {
        let places = [&self.kinds[first].places, &self.kinds[second].places];
        let columns = places[1].len();
        for term in &terms.terms((first, second)).0 {
            let kind = term.term();
            if !kind.is_sum_over_pairs() {
                term.shares(relative, &mut |body, place, energy_kt| {
                    if let Some(residue) = places[body].of_term(kind, place) {
                        energies.single[body][residue].add(kind, energy_kt);
                    }
                });
                continue;
            }
            term.pair_shares(relative, &mut |of_first, of_second, energy_kt| {
                let residues = (
                    places[0].of_term(kind, of_first),
                    places[1].of_term(kind, of_second),
                );
                if let (Some(a), Some(b)) = residues {
                    energies.pairs[a * columns + b].parts.add(kind, energy_kt);
                }
            });
        }
    }
}

impl ResiduesOfKind {
    /// Radius of the sphere around the body's origin that holds all heavy atoms, Å.
    fn radius(&self) -> f64 {
        let reach = self
            .atoms
            .iter()
            .map(|residue| residue.centre.norm() + residue.radius_angstrom);
        reach.fold(0.0, f64::max)
    }
}

impl StateEnergies {
    fn add(&mut self, bodies: &Pair<'_>, contributions: &OfBodies, columns: usize) {
        let (first, second) = bodies.type_indices();
        let kinds = (first.min(second), first.max(second));
        let Some(table) = self.pairs.iter_mut().find(|pairs| pairs.kinds == kinds) else {
            return;
        };
        for (index, pair) in contributions.pairs.iter().enumerate() {
            let (a, b) = (index / columns, index % columns);
            let place = match first.cmp(&second) {
                std::cmp::Ordering::Less => a * table.columns + b,
                std::cmp::Ordering::Equal => a.min(b) * table.columns + a.max(b),
                std::cmp::Ordering::Greater => b * table.columns + a,
            };
            table.pairs[place].add(pair);
            let touches = pair.touching > 0.0;
            self.residues[bodies.first][a].add(pair, touches);
            self.residues[bodies.second][b].add(pair, touches);
            self.parts += pair.parts;
            if !touches {
                self.apart_kt += pair.parts.charges_kt;
            }
        }
        for (copy, energies) in [bodies.first, bodies.second]
            .into_iter()
            .zip(&contributions.single)
        {
            for (residue, parts) in self.residues[copy].iter_mut().zip(energies) {
                residue.parts += *parts;
                self.parts += *parts;
            }
        }
    }
}

impl ResidueContribution {
    fn add(&mut self, pair: &PairContribution, touches: bool) {
        self.parts += pair.parts;
        self.touches |= touches;
    }
}

impl PairContribution {
    fn add(&mut self, other: &Self) {
        self.parts += other.parts;
        self.touching += other.touching;
    }

    /// The sum of the terms, kT.
    pub fn total_kt(&self) -> f64 {
        self.parts.total_kt()
    }
}

impl ResiduePairs {
    /// The contribution of a pair, by the residues of the first and the second kind; of one kind, in
    /// either order.
    pub fn pair(&self, first: usize, second: usize) -> &PairContribution {
        let is_one_kind = self.kinds.0 == self.kinds.1;
        let (row, column) = match is_one_kind && second < first {
            true => (second, first),
            false => (first, second),
        };
        &self.pairs[row * self.columns + column]
    }
}
