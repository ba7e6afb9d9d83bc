//! From partition functions to yields: the law of mass action, with errors and half yields.
//!
//! ```text
//! c_S N_A^(n-1) = q_S/σ_S Π c_k^n_k        yield = n c_whole / Σ_k T_k
//! ```
//!
//! Errors come from curves drawn within the errors of the partition functions. Each body that was attached has its own
//! error, which all larger parts inherit.

use super::condition::PartFound;
use super::plan::Plan;
use protomer_kernel::bisection::narrowed;
use protomer_kernel::random::{CounterRng, Purpose};
use protomer_kernel::units::NUMBER_DENSITY_PER_MOLAR;
use protomer_mc::parts::{PartKind, Species, free_concentrations, species_concentrations};
use serde::{Deserialize, Serialize};

/// Draws behind errors and intervals.
const DRAWS: u64 = 200;
/// Share of the draws beyond each end of an interval.
const TAIL: f64 = 0.025;
/// Concentrations between which that of half yield is sought, mol/L.
const CONCENTRATIONS_MOLAR: (f64, f64) = (1e-60, 100.0);

/// An assembly and its parts at one total concentration.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Mixture {
    /// Total concentration of the bodies, mol/L.
    #[serde(rename = "concentration_M")]
    pub concentration_molar: f64,
    /// Share of the bodies that are in whole assemblies.
    #[serde(rename = "yield")]
    pub whole: f64,
    /// Standard error of the yield.
    #[serde(rename = "yield_error")]
    pub whole_error: f64,
    /// Share of the bodies in each part, in the order of the parts.
    pub shares: Vec<f64>,
}

/// A value with its interval of 95 %.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Interval {
    /// The value.
    pub value: f64,
    /// Ends of the interval; `None` where the curves that the errors allow do not reach one half.
    pub interval: [Option<f64>; 2],
}

/// Bodies whose share falls to one half.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Counted {
    /// Bodies in whole assemblies.
    Whole,
    /// Bodies in parts of any size but one.
    Bound,
}

/// Parts at one condition with their logarithms of partition functions.
pub(super) struct PartLogs<'a> {
    parts: &'a [PartKind],
    compositions: Vec<Vec<usize>>,
    /// Logarithms of q in Å³ to the power n - 1; minus infinity for parts without room.
    ln_partition: Vec<f64>,
    /// Error of the logarithm that attaching the last body added.
    added_error: Vec<f64>,
    /// Error of the change from the salt whose samples all share; `None` for parts with samples of their own.
    change_error: Vec<Option<f64>>,
    /// Number of the salt, which tells random numbers apart.
    salt: u32,
}

impl<'a> PartLogs<'a> {
    /// Parts at a salt, by its number.
    pub fn new(plan: &'a Plan, found: &[Vec<PartFound>], salt: usize) -> Self {
        let parts = &plan.parts.parts;
        let composition = |part: &PartKind| plan.arrangement.composition(&part.bodies);
        let sampling_error = |number: usize| {
            found[number][salt].map_or(0.0, |part| {
                let change_error = part.change_error.unwrap_or(0.0);
                let square = part.attached.ln_partition_error.powi(2) - change_error.powi(2);
                square.max(0.0).sqrt()
            })
        };
        let added = |(number, part): (usize, &PartKind)| {
            let before = part.grown_from.map_or(0.0, sampling_error);
            (sampling_error(number).powi(2) - before.powi(2))
                .max(0.0)
                .sqrt()
        };
        let ln_partition = |part: &Vec<PartFound>| {
            part[salt].map_or(f64::NEG_INFINITY, |part| part.attached.ln_partition)
        };
        Self {
            parts,
            compositions: parts.iter().map(composition).collect(),
            ln_partition: found.iter().map(ln_partition).collect(),
            added_error: parts.iter().enumerate().map(added).collect(),
            change_error: found
                .iter()
                .map(|part| part[salt].and_then(|part| part.change_error))
                .collect(),
            salt: salt as u32,
        }
    }

    /// Logarithms that the errors allow. All salts share the errors of the samples that they share.
    fn drawn(&self, seed: u64, draw: u64) -> Vec<f64> {
        let stream = |number: u32| CounterRng::for_purpose(seed, number, draw, Purpose::Bootstrap);
        let (mut shared, mut own) = (stream(0), stream(1 + self.salt));
        let (mut shifts, mut logs): (Vec<f64>, Vec<f64>) = (Vec::new(), Vec::new());
        for (number, part) in self.parts.iter().enumerate() {
            let before = part.grown_from.map_or(0.0, |before| shifts[before]);
            // Both are drawn for every part, so that streams stay in step.
            let (common, single) = (shared.normal(), own.normal());
            let (sampling, change) = match self.change_error[number] {
                Some(error) => (common, error * single),
                None => (single, 0.0),
            };
            shifts.push(before + self.added_error[number] * sampling);
            logs.push(self.ln_partition[number] + shifts[number] + change);
        }
        logs
    }

    /// Standard free energy of each part against free bodies at 1 mol/L, kT; `None` without room.
    pub fn free_energies_kt(&self) -> Vec<Option<f64>> {
        let ln_constants = self.species(&self.ln_partition);
        let kt = |one: &Species| one.ln_constant.is_finite().then_some(-one.ln_constant);
        ln_constants.iter().map(kt).collect()
    }

    fn species(&self, ln_partition: &[f64]) -> Vec<Species> {
        let species = |(number, part): (usize, &PartKind)| {
            let bodies = part.bodies.len() as f64;
            Species {
                composition: self.compositions[number].clone(),
                ln_constant: ln_partition[number] - (part.symmetry_number as f64).ln()
                    + (bodies - 1.0) * NUMBER_DENSITY_PER_MOLAR.ln(),
            }
        };
        self.parts.iter().enumerate().map(species).collect()
    }

    /// Share of the bodies in each part at a total concentration; the kinds are in the proportion of the assembly.
    fn shares(&self, ln_partition: &[f64], concentration_molar: f64) -> Vec<f64> {
        let species = self.species(ln_partition);
        let whole = &self.compositions[self.compositions.len() - 1];
        let bodies = whole.iter().sum::<usize>() as f64;
        let totals: Vec<f64> = whole
            .iter()
            .map(|count| concentration_molar * *count as f64 / bodies)
            .collect();
        let ln_free = free_concentrations(&species, &totals);
        let concentrations = species_concentrations(&species, &ln_free);
        let share = |(part, molar): (&PartKind, f64)| {
            part.bodies.len() as f64 * molar / concentration_molar
        };
        self.parts.iter().zip(concentrations).map(share).collect()
    }

    fn share(&self, counted: Counted, ln_partition: &[f64], concentration_molar: f64) -> f64 {
        let shares = self.shares(ln_partition, concentration_molar);
        match counted {
            Counted::Whole => shares.last().copied().unwrap_or_default(),
            Counted::Bound => {
                let parts = self.parts.iter().zip(shares);
                let bound = parts.filter(|(part, _)| part.bodies.len() > 1);
                bound.map(|(_, share)| share).sum()
            }
        }
    }

    fn whole(&self, ln_partition: &[f64], concentration_molar: f64) -> f64 {
        self.share(Counted::Whole, ln_partition, concentration_molar)
    }

    /// The mixture at a total concentration.
    pub fn mixture(&self, concentration_molar: f64, seed: u64) -> Mixture {
        let shares = self.shares(&self.ln_partition, concentration_molar);
        let (mut sum, mut squares) = (0.0, 0.0);
        for draw in 0..DRAWS {
            let logs = self.drawn(seed, draw);
            let whole = self.whole(&logs, concentration_molar);
            sum += whole;
            squares += whole * whole;
        }
        let count = DRAWS as f64;
        let variance = (squares / count - (sum / count).powi(2)).max(0.0);
        Mixture {
            concentration_molar,
            whole: shares.last().copied().unwrap_or_default(),
            whole_error: variance.sqrt(),
            shares,
        }
    }

    /// Total concentration at which half of the bodies are in whole assemblies, mol/L.
    pub fn half_concentration(&self, seed: u64) -> Option<Interval> {
        let value = self.crossing_molar(&self.ln_partition)?;
        let drawn = (0..DRAWS).map(|draw| {
            self.crossing_molar(&self.drawn(seed, draw))
                .unwrap_or(f64::INFINITY)
        });
        Some(Interval {
            value,
            interval: ends(drawn.collect()),
        })
    }

    fn crossing_molar(&self, ln_partition: &[f64]) -> Option<f64> {
        let (low, high) = CONCENTRATIONS_MOLAR;
        // The yield of the largest part rises with the concentration.
        let whole = |ln_molar: f64| self.whole(ln_partition, ln_molar.exp());
        let ends = [low.ln(), high.ln()];
        if whole(ends[1]) < 0.5 || whole(ends[0]) > 0.5 {
            return None;
        }
        let [low, high] = narrowed(ends, 1e-6, |ln_molar| whole(ln_molar) < 0.5);
        Some((0.5 * (low + high)).exp())
    }
}

/// Salt at which half of the bodies are in whole assemblies, or bound, mol/L, by the partition functions at several salts in
/// rising order, whose logarithms are linear in that of the salt between them.
pub(super) fn half_salt(
    conditions: &[(f64, PartLogs<'_>)],
    counted: Counted,
    concentration_molar: f64,
    seed: u64,
) -> Option<Interval> {
    let logs = |condition: &(f64, PartLogs<'_>)| condition.1.ln_partition.clone();
    let present: Vec<Vec<f64>> = conditions.iter().map(logs).collect();
    let value = crossing_salt(conditions, counted, &present, concentration_molar)?;
    let drawn = (0..DRAWS).map(|draw| {
        let logs: Vec<Vec<f64>> = conditions
            .iter()
            .map(|(_, parts)| parts.drawn(seed, draw))
            .collect();
        match crossing_salt(conditions, counted, &logs, concentration_molar) {
            Some(salt_molar) => salt_molar,
            // On the side to which the first salt points.
            None => {
                let share = |number: usize| {
                    let parts: &PartLogs<'_> = &conditions[number].1;
                    parts.share(counted, &logs[number], concentration_molar)
                };
                let falls = share(0) >= share(conditions.len() - 1);
                let is_high = share(0) > 0.5;
                if is_high == falls {
                    f64::INFINITY
                } else {
                    f64::NEG_INFINITY
                }
            }
        }
    });
    Some(Interval {
        value,
        interval: ends(drawn.collect()),
    })
}

fn crossing_salt(
    conditions: &[(f64, PartLogs<'_>)],
    counted: Counted,
    logs: &[Vec<f64>],
    concentration_molar: f64,
) -> Option<f64> {
    let share = |number: usize| {
        let parts: &PartLogs<'_> = &conditions[number].1;
        parts.share(counted, &logs[number], concentration_molar)
    };
    let shares: Vec<f64> = (0..conditions.len()).map(share).collect();
    let between = (0..conditions.len().saturating_sub(1))
        .find(|number| (shares[*number] < 0.5) != (shares[number + 1] < 0.5))?;
    let parts = &conditions[between].1;
    let mixed = |part: f64| -> Vec<f64> {
        let both = logs[between].iter().zip(&logs[between + 1]);
        both.map(|(a, b)| match a.is_finite() && b.is_finite() {
            true => a + part * (b - a),
            false => f64::NEG_INFINITY,
        })
        .collect()
    };
    let starts_low = shares[between] < 0.5;
    let is_before = |part: f64| {
        let share = parts.share(counted, &mixed(part), concentration_molar);
        (share < 0.5) == starts_low
    };
    let [low, high] = narrowed([0.0, 1.0], 1e-6, is_before);
    let (from, to) = (conditions[between].0, conditions[between + 1].0);
    Some(from * (to / from).powf(0.5 * (low + high)))
}

/// The ends of the interval that holds 95 % of the values; `None` for an infinite one.
fn ends(mut values: Vec<f64>) -> [Option<f64>; 2] {
    values.sort_by(f64::total_cmp);
    let quantile = |part: f64| {
        let index = (part * (values.len() - 1) as f64).round() as usize;
        values.get(index).copied().filter(|value| value.is_finite())
    };
    [quantile(TAIL), quantile(1.0 - TAIL)]
}
