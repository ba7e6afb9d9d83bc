//! The energy model that makes the direct sum's decisions without summing.

use super::pair::{ChargeTable, EnergyInterval};
use crate::Result;
use crate::energy::reach::Reach;
use crate::energy::{EnergyModel, PairEnergy, all_pairs, finite, pair_energy_kt};
use crate::sparse_rows::PairTable;
use crate::system::{Pair, System, Trial};
use protomer_kernel::pose::RelativePose;
use protomer_kernel::potential::Yukawa;
use std::sync::Arc;

/// Energies as intervals that contain the direct sum's value. A decision whose interval is on one
/// side of its threshold is the direct sum's; while it is open the widest interval is replaced by
/// the direct sum itself, computed by the same function for the same relative pose. So every
/// decision equals that of [`DirectSum`](crate::energy::DirectSum).
///
/// With a tolerance, decisions go by the intervals' middles; a pair whose likely error is larger
/// gets the direct sum.
#[derive(Debug, Clone)]
pub struct CertifiedSum {
    yukawa: Yukawa,
    tolerance_kt: Option<f64>,
    tables: Vec<Arc<ChargeTable>>,
    energies: PairTable<Known>,
    proposed: Vec<(usize, usize, Known)>,
    counts: Counts,
    largest_error_kt: f64,
}

/// How often each path was taken.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Counts {
    /// Decisions made.
    pub decisions: u64,
    /// Pair intervals computed.
    pub intervals: u64,
    /// Decisions that the intervals left open.
    pub open: u64,
    /// Direct sums that open decisions asked for.
    pub direct_sums: u64,
}

/// What is known of one pair of bodies.
#[derive(Debug, Clone, Copy)]
struct Known {
    /// Where the energy was asked for, so that a later refinement gives the bits that the direct
    /// sum had then.
    relative: RelativePose,
    energy: EnergyInterval,
    /// The middle found first: what is reported, whatever decisions asked for since.
    reported_kt: f64,
    exact: bool,
}

/// An energy in a decision: one of the moved body's pairs, before or after the move.
#[derive(Debug, Clone, Copy)]
struct Term {
    partner: usize,
    known: Known,
    new: bool,
}

impl CertifiedSum {
    /// The model for this potential; its tables are made when it first meets a system.
    pub fn new(yukawa: Yukawa) -> Self {
        Self::with_tables(yukawa, Vec::new())
    }

    /// The model with tables from elsewhere, one per body type of the system, shared.
    pub fn with_tables(yukawa: Yukawa, tables: Vec<Arc<ChargeTable>>) -> Self {
        Self {
            yukawa,
            tolerance_kt: None,
            tables,
            energies: PairTable::new(0),
            proposed: Vec::new(),
            counts: Counts::default(),
            largest_error_kt: 0.0,
        }
    }

    /// The same tables without the certainty: each pair's energy with a
    /// [likely error](EnergyInterval::likely_error_kt) of at most `tolerance_kt`.
    pub fn with_tolerance(mut self, tolerance_kt: f64) -> Self {
        self.tolerance_kt = Some(tolerance_kt);
        self
    }

    /// The tables, one per body type.
    pub fn tables(&self) -> &[Arc<ChargeTable>] {
        &self.tables
    }

    /// How often each path was taken.
    pub fn counts(&self) -> Counts {
        self.counts
    }

    /// What the tables say of a pair; `None` beyond the range of the charges.
    fn known(&mut self, pair: &Pair<'_>) -> Result<Option<Known>> {
        let (first, second) = pair.types();
        let reach = first.charge_radius_angstrom()
            + second.charge_radius_angstrom()
            + self.yukawa.cutoff_angstrom;
        if first.charges.is_empty()
            || second.charges.is_empty()
            || pair.displacement.norm_squared() >= reach * reach
        {
            return Ok(None);
        }
        self.known_at(pair, pair.relative()).map(Some)
    }

    /// What the tables say of the bodies of a pair for this relative pose.
    fn known_at(&mut self, pair: &Pair<'_>, relative: RelativePose) -> Result<Known> {
        let (a, b) = pair.type_indices();
        self.counts.intervals += 1;
        let interval = self.tables[a].energy_interval(&self.tables[b], &relative);
        let tolerance = self.tolerance_kt.unwrap_or(f64::INFINITY);
        let known = match interval.filter(|interval| interval.likely_error_kt <= tolerance) {
            Some(energy) => Known {
                relative,
                energy,
                reported_kt: energy.middle_kt,
                exact: false,
            },
            None => {
                let energy = self.exactly(pair, &relative)?;
                Known {
                    relative,
                    energy,
                    reported_kt: energy.middle_kt,
                    exact: true,
                }
            }
        };
        let energy = &known.energy;
        let error_kt = if self.tolerance_kt.is_some() {
            energy.likely_error_kt
        } else {
            energy.error_kt
        };
        self.largest_error_kt = self.largest_error_kt.max(error_kt);
        Ok(known)
    }

    /// The direct sum for this relative pose of the pair's bodies.
    fn exactly(&mut self, pair: &Pair<'_>, relative: &RelativePose) -> Result<EnergyInterval> {
        self.counts.direct_sums += 1;
        let (first, second) = pair.types();
        let energy = pair_energy_kt(&self.yukawa, &first.charges, &second.charges, relative);
        let middle_kt = finite(pair.first, pair.second, energy)?;
        Ok(EnergyInterval {
            middle_kt,
            ..EnergyInterval::default()
        })
    }

    /// Makes the tables that are missing and forgets what was proposed.
    fn prepare(&mut self, system: &System) {
        if self.tables.len() != system.types().len() {
            let yukawa = &self.yukawa;
            self.tables = std::thread::scope(|scope| {
                let table =
                    |kind: &Arc<crate::BodyType>| Arc::new(ChargeTable::new(&kind.charges, yukawa));
                let jobs: Vec<_> = system
                    .types()
                    .iter()
                    .map(|kind| scope.spawn(move || table(kind)))
                    .collect();
                let done = jobs.into_iter().zip(system.types());
                // A thread that could not finish is replaced by doing its work here.
                done.map(|(job, kind)| job.join().unwrap_or_else(|_| table(kind)))
                    .collect()
            });
        }
        self.proposed.clear();
    }

    fn old_terms(&self, body: usize) -> Vec<Term> {
        self.energies
            .row(body)
            .map(|(partner, known)| Term {
                partner,
                known,
                new: false,
            })
            .collect()
    }

    /// Whether the new energies less the old ones lie below (`true`) or not below `threshold_kt`,
    /// as the direct sum would find. `above` answers the mirrored question, "above or not above".
    fn decide(
        &mut self,
        trial: &Trial<'_>,
        terms: &mut [Term],
        threshold_kt: f64,
        above: bool,
    ) -> Result<bool> {
        self.counts.decisions += 1;
        if self.tolerance_kt.is_some() {
            return Ok(compare_middles(terms, threshold_kt, above));
        }
        let mut first = true;
        loop {
            let (mut middle, mut error, mut size) = (0.0, 0.0, 0.0);
            for term in terms.iter() {
                let energy = term.known.energy;
                middle += if term.new {
                    energy.middle_kt
                } else {
                    -energy.middle_kt
                };
                error += energy.error_kt;
                size += energy.middle_kt.abs() + energy.error_kt;
            }
            // The direct sum's additions round, and so do these.
            error += 4.0 * (terms.len() + 2) as f64 * f64::EPSILON * (size + threshold_kt.abs());
            if middle + error < threshold_kt {
                return Ok(!above);
            }
            if middle - error > threshold_kt {
                return Ok(above);
            }
            self.counts.open += u64::from(first);
            first = false;
            let widest = terms.iter_mut().filter(|term| !term.known.exact);
            let Some(term) =
                widest.max_by(|a, b| a.known.energy.error_kt.total_cmp(&b.known.energy.error_kt))
            else {
                return Ok(compare_middles(terms, threshold_kt, above));
            };
            let pair = trial.pair(term.partner);
            term.known.energy = self.exactly(&pair, &term.known.relative)?;
            term.known.exact = true;
            if !term.new {
                self.energies.set(trial.body, term.partner, term.known);
            }
        }
    }

    fn propose(&mut self, trial: &Trial<'_>, terms: &[Term]) {
        let ordered = |partner: usize| (trial.body.min(partner), trial.body.max(partner));
        self.proposed
            .extend(terms.iter().filter(|term| term.new).map(|term| {
                let (first, second) = ordered(term.partner);
                (first, second, term.known)
            }));
    }
}

/// The direct sum's comparison: new energies less old ones, each added up in the order of the
/// partners.
fn compare_middles(terms: &[Term], threshold_kt: f64, above: bool) -> bool {
    let sum = |new: bool| -> f64 {
        terms
            .iter()
            .filter(|term| term.new == new)
            .fold(0.0, |sum, term| sum + term.known.energy.middle_kt)
    };
    let change = sum(true) - sum(false);
    if above {
        change > threshold_kt
    } else {
        change < threshold_kt
    }
}

impl EnergyModel for CertifiedSum {
    fn range_angstrom(&self, system: &System) -> f64 {
        Reach::new(system, &self.yukawa).largest_angstrom()
    }

    fn require_room(&self, system: &System) -> Result<()> {
        Ok(protomer_kernel::cells::require_minimum_image(
            system.boundary(),
            self.range_angstrom(system),
        )?)
    }

    fn reset(&mut self, system: &System) -> Result<()> {
        self.prepare(system);
        self.energies = all_pairs(system, |pair| self.known(pair))?;
        Ok(())
    }

    /// Each interval is found anew where it was found first. What is reported goes on from what
    /// was, and so does the middle that decisions under a tolerance go by: another machine may
    /// round it otherwise.
    fn restore(&mut self, system: &System, pairs: &[PairEnergy]) -> Result<()> {
        self.prepare(system);
        self.energies = PairTable::new(system.len());
        for saved in pairs {
            let pair = system.pair(saved.first, saved.second);
            let mut known =
                self.known_at(&pair, saved.computed_at.unwrap_or_else(|| pair.relative()))?;
            known.reported_kt = finite(saved.first, saved.second, saved.energy_kt)?;
            if self.tolerance_kt.is_some() {
                known.energy.middle_kt = known.reported_kt;
            }
            self.energies.set(saved.first, saved.second, known);
        }
        Ok(())
    }

    fn accept(&mut self, trial: &Trial<'_>, partners: &[usize], budget_kt: f64) -> Result<bool> {
        let mut terms = self.old_terms(trial.body);
        for &partner in partners {
            if let Some(known) = self.known(&trial.pair(partner))? {
                terms.push(Term {
                    partner,
                    known,
                    new: true,
                });
            }
        }
        let accepted = self.decide(trial, &mut terms, budget_kt, false)?;
        self.propose(trial, &terms);
        Ok(accepted)
    }

    fn exceeds(&mut self, trial: &Trial<'_>, partner: usize, threshold_kt: f64) -> Result<bool> {
        let mut terms: Vec<Term> = self
            .old_terms(trial.body)
            .into_iter()
            .filter(|term| term.partner == partner)
            .collect();
        if let Some(known) = self.known(&trial.pair(partner))? {
            terms.push(Term {
                partner,
                known,
                new: true,
            });
        }
        let exceeds = self.decide(trial, &mut terms, threshold_kt, true)?;
        self.propose(trial, &terms);
        Ok(exceeds)
    }

    fn commit(&mut self, moved: &[usize]) {
        self.energies.take_over(moved, self.proposed.drain(..));
    }

    fn reject(&mut self) {
        self.proposed.clear();
    }

    fn error_bound_kt(&self) -> f64 {
        self.largest_error_kt
    }

    fn memory_bytes(&self) -> usize {
        self.tables.iter().map(|table| table.memory_bytes()).sum()
    }

    fn pairs(&self) -> Vec<PairEnergy> {
        let pairs = self.energies.pairs();
        let saved = |(first, second, known): (usize, usize, Known)| PairEnergy {
            computed_at: Some(known.relative),
            ..PairEnergy::new(first, second, known.reported_kt)
        };
        pairs.map(saved).collect()
    }
}
