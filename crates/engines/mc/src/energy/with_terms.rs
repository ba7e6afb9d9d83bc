//! Short-ranged terms in addition to any model of the charges.
//!
//! The terms are functions of the pose alone, computed for each trial. Their change is taken from the
//! budget, and the model of the charges decides with what is left: a decision by levels or with
//! certificates keeps its promise.

use super::reach::Reach;
use super::terms::{EnergyParts, Term, Terms};
use super::{Effort, EnergyModel, LevelReport, PairEnergy, Pairs, all_pairs, finite, sum_of_pairs};
use crate::sparse_rows::PairTable;
use crate::system::{Pair, System, Trial};
use crate::{McError, Result};
use protomer_kernel::random::CounterRng;

/// Energies below this end the reach of a term, kT.
const NEGLIGIBLE_KT: f64 = 1e-8;

/// The terms of every pair of body types.
#[derive(Clone, Default)]
pub struct TermsByType {
    types: usize,
    by_types: Vec<Terms>,
}

impl std::fmt::Debug for TermsByType {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(formatter, "terms of {} types", self.types)
    }
}

impl TermsByType {
    /// Asks `terms` for every ordered pair of types of a system.
    ///
    /// # Errors
    /// As `terms`.
    pub fn new<E>(
        types: usize,
        mut terms: impl FnMut(usize, usize) -> std::result::Result<Terms, E>,
    ) -> std::result::Result<Self, E> {
        let mut by_types = Vec::with_capacity(types * types);
        for first in 0..types {
            for second in 0..types {
                by_types.push(terms(first, second)?);
            }
        }
        Ok(Self { types, by_types })
    }

    /// The terms of a pair of types.
    pub fn terms(&self, (first, second): (usize, usize)) -> &Terms {
        &self.by_types[first * self.types + second]
    }

    /// The energies of the terms in a state of a system, kT: of each pair of bodies with an image in
    /// reach, and without the charges.
    pub fn parts_of_pairs(&self, system: &System) -> Vec<(usize, usize, EnergyParts)> {
        let reach = self.reach(system);
        let mut pairs = Vec::new();
        for first in 0..system.len() {
            for second in first + 1..system.len() {
                let pair = system.pair(first, second);
                let terms = self.terms(pair.type_indices());
                let mut parts = None;
                // Image by image, as decisions sum them.
                for displacement in reach.images(&pair) {
                    *parts.get_or_insert_default() +=
                        terms.parts_kt(&pair.relative_image(&displacement));
                }
                pairs.extend(parts.map(|parts| (first, second, parts)));
            }
        }
        pairs
    }

    /// The kinds of terms that act between any bodies.
    pub fn kinds(&self) -> Vec<Term> {
        let mut kinds = Vec::new();
        for term in self.by_types.iter().flat_map(|terms| &terms.0) {
            if !kinds.contains(&term.term()) {
                kinds.push(term.term());
            }
        }
        kinds
    }

    pub(crate) fn reach(&self, system: &System) -> Reach {
        let reach = |terms: &Terms| terms.reach_angstrom(NEGLIGIBLE_KT);
        Reach::of_types(system, self.by_types.iter().map(reach).collect())
    }
}

/// A model of the charges with further terms.
pub struct WithTerms {
    charges: Box<dyn EnergyModel>,
    terms: TermsByType,
    reach: Reach,
    energies: PairTable<f64>,
    proposed: Vec<(usize, usize, f64)>,
}

impl WithTerms {
    /// Adds terms to a model of the charges.
    pub fn new(charges: Box<dyn EnergyModel>, terms: TermsByType) -> Self {
        Self {
            charges,
            terms,
            reach: Reach::default(),
            energies: PairTable::new(0),
            proposed: Vec::new(),
        }
    }

    /// The terms of a pair over all images in reach, kT; `None` if there is none.
    fn energy_kt(&self, pair: &Pair<'_>) -> Result<Option<f64>> {
        let terms = self.terms.terms(pair.type_indices());
        let mut energy_kt = None;
        for displacement in self.reach.images(pair) {
            let image = terms.energy_kt(&pair.relative_image(&displacement));
            *energy_kt.get_or_insert(0.0) += image;
        }
        let checked = |energy_kt| finite(pair.first, pair.second, energy_kt);
        energy_kt.map(checked).transpose()
    }

    /// Proposes the energy of a pair and returns how much it rises, kT.
    fn propose(&mut self, trial: &Trial<'_>, partner: usize) -> Result<f64> {
        let pair = trial.pair(partner);
        let old = self.energies.get(trial.body, partner).unwrap_or(0.0);
        let new = self.energy_kt(&pair)?;
        if let Some(energy_kt) = new {
            self.proposed.push((pair.first, pair.second, energy_kt));
        }
        Ok(new.unwrap_or(0.0) - old)
    }

    fn prepare(&mut self, system: &System) {
        self.reach = self.terms.reach(system);
        self.proposed.clear();
    }
}

impl EnergyModel for WithTerms {
    fn range_angstrom(&self, system: &System) -> f64 {
        let of_terms = self.terms.reach(system).largest_angstrom();
        of_terms.max(self.charges.range_angstrom(system))
    }

    fn reach_angstrom(&self, system: &System) -> f64 {
        let of_terms = self.terms.reach(system).largest_angstrom();
        of_terms.max(self.charges.reach_angstrom(system))
    }

    fn require_room(&self, system: &System) -> Result<()> {
        self.charges.require_room(system)?;
        let range_angstrom = self.terms.reach(system).largest_angstrom();
        let smallest_length_angstrom = system.boundary().smallest_length_angstrom();
        // A whole length, not half of it: the terms are summed over images.
        match range_angstrom > smallest_length_angstrom {
            true => Err(McError::ReachesTooFar {
                range_angstrom,
                smallest_length_angstrom,
                needed_length_angstrom: range_angstrom,
            }),
            false => Ok(()),
        }
    }

    fn reset(&mut self, system: &System) -> Result<()> {
        self.prepare(system);
        self.energies = all_pairs(system, |pair| self.energy_kt(pair))?;
        self.charges.reset(system)
    }

    fn restore(&mut self, system: &System, pairs: &[PairEnergy]) -> Result<()> {
        self.prepare(system);
        self.energies = PairTable::new(system.len());
        let mut of_charges = Vec::with_capacity(pairs.len());
        for pair in pairs {
            // Zero is not stored, as for pairs out of reach.
            if pair.terms_kt != 0.0 {
                let energy_kt = finite(pair.first, pair.second, pair.terms_kt)?;
                self.energies.set(pair.first, pair.second, energy_kt);
            }
            // A pair that only terms know must not enter the model of the charges.
            if !pair.is_of_terms_only {
                of_charges.push(PairEnergy {
                    terms_kt: 0.0,
                    ..pair.clone()
                });
            }
        }
        self.charges.restore(system, &of_charges)
    }

    fn accept(&mut self, trial: &Trial<'_>, partners: &[usize], budget_kt: f64) -> Result<bool> {
        let mut rise_kt = 0.0;
        for &partner in partners {
            rise_kt += self.propose(trial, partner)?;
        }
        // Partners that the body leaves behind.
        for (partner, energy_kt) in self.energies.row(trial.body) {
            // Partners in range were taken as differences; these have an old energy only.
            if partners.binary_search(&partner).is_err() {
                rise_kt -= energy_kt;
            }
        }
        // The terms are exact, so taking them from the budget leaves the decision what it was.
        self.charges.accept(trial, partners, budget_kt - rise_kt)
    }

    fn exceeds(&mut self, trial: &Trial<'_>, partner: usize, threshold_kt: f64) -> Result<bool> {
        let rise_kt = self.propose(trial, partner)?;
        self.charges.exceeds(trial, partner, threshold_kt - rise_kt)
    }

    fn commit(&mut self, bodies: &[usize]) {
        self.energies.take_over(bodies, self.proposed.drain(..));
        self.charges.commit(bodies);
    }

    fn reject(&mut self) {
        self.proposed.clear();
        self.charges.reject();
    }

    fn error_bound_kt(&self, system: &System) -> f64 {
        self.charges.error_bound_kt(system)
    }

    fn levels(&self) -> Option<LevelReport> {
        self.charges.levels()
    }

    fn memory_bytes(&self) -> usize {
        self.charges.memory_bytes()
    }

    fn energy_elsewhere_kt(
        &self,
        system: &System,
        pairs: Pairs<'_>,
        effort: Effort,
    ) -> Result<f64> {
        let of_terms_kt = sum_of_pairs(system, pairs, |pair| self.energy_kt(pair))?;
        Ok(of_terms_kt + self.charges.energy_elsewhere_kt(system, pairs, effort)?)
    }

    fn change_protons(
        &mut self,
        system: &System,
        body: usize,
        partners: &[usize],
        rng: &mut CounterRng,
    ) -> Result<bool> {
        // Terms are functions of the poses, which stay.
        self.charges.change_protons(system, body, partners, rng)
    }

    fn protonation(&self) -> &[Vec<bool>] {
        self.charges.protonation()
    }

    fn take_protonation(&mut self, system: &System, states: &[Vec<bool>]) -> Result<()> {
        self.charges.take_protonation(system, states)
    }

    fn net_charges_e(&self) -> Option<Vec<f64>> {
        self.charges.net_charges_e()
    }

    fn pairs(&self, system: &System) -> Vec<PairEnergy> {
        let mut pairs = self.charges.pairs(system);
        for pair in &mut pairs {
            pair.terms_kt = self.energies.get(pair.first, pair.second).unwrap_or(0.0);
        }
        let has_charges = |first: usize, second: usize, pairs: &[PairEnergy]| {
            let key = |pair: &PairEnergy| (pair.first, pair.second);
            // The model of the charges hands pairs out in ascending order.
            pairs.binary_search_by_key(&(first, second), key).is_ok()
        };
        let of_charges = pairs.len();
        for (first, second, terms_kt) in self.energies.pairs() {
            // Only among those it gave: pairs that are added here stand behind them, unsorted.
            if !has_charges(first, second, &pairs[..of_charges]) {
                pairs.push(PairEnergy {
                    terms_kt,
                    is_of_terms_only: true,
                    ..PairEnergy::new(first, second, 0.0)
                });
            }
        }
        pairs.sort_by_key(|pair| (pair.first, pair.second));
        pairs
    }
}
