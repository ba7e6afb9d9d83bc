//! Confidence of predicted models, which their files hold in the place of B factors.
//!
//! A file is taken for a prediction if its header says so, or if it states no experimental method and all
//! atoms of a residue have the same B factor, as AlphaFold 2, ColabFold and ESMFold write it (pLDDT, 0 to 100
//! or 0 to 1).

use super::contents::Header;
use super::residue_key::ResidueKey;
use super::selected::SelectedResidue;
use serde::Serialize;
use std::collections::BTreeSet;

/// Residues below this confidence may be anywhere, in percent.
pub(crate) const LOW_PERCENT: f64 = 70.0;
/// Share of the residues whose atoms must have one B factor.
const LEAST_UNIFORM: f64 = 0.95;
/// Different confidences that a prediction has at least; masks of designed residues have two.
const LEAST_VALUES: usize = 5;

/// Consecutive residues of low confidence.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LowConfidence {
    /// First of the residues.
    pub first: ResidueKey,
    /// Last of the residues.
    pub last: ResidueKey,
    /// Number of residues.
    pub residues: usize,
    /// Mean confidence, percent.
    pub mean_percent: f64,
}

impl LowConfidence {
    /// The range as `--residues` takes it, such as `A:1-15`.
    pub(crate) fn in_words(&self) -> String {
        let key = &self.first;
        let chain = match key.chain.is_empty() {
            true => String::new(),
            false => format!("{}:", key.chain),
        };
        match self.residues {
            1 => format!("{chain}{}", key.number),
            _ => format!("{chain}{}-{}", key.number, self.last.number),
        }
    }
}

/// The residues of low confidence of a predicted model; none for other structures.
pub(crate) fn low_confidence(header: &Header, residues: &[SelectedResidue]) -> Vec<LowConfidence> {
    let Some(percent_per_unit) = percent_per_unit(header, residues) else {
        return Vec::new();
    };
    let mut ranges: Vec<LowConfidence> = Vec::new();
    let mut last_is_low = false;
    for residue in residues.iter().filter(|each| each.class.is_protein()) {
        let mean_percent = percent_per_unit * mean_b_factor(residue);
        let is_low = mean_percent < LOW_PERCENT;
        match ranges.last_mut() {
            Some(range) if is_low && last_is_low && range.last.chain == residue.key.chain => {
                let count = range.residues as f64;
                range.mean_percent = (range.mean_percent * count + mean_percent) / (count + 1.0);
                range.residues += 1;
                range.last = residue.key.clone();
            }
            _ if is_low => ranges.push(LowConfidence {
                first: residue.key.clone(),
                last: residue.key.clone(),
                residues: 1,
                mean_percent,
            }),
            _ => {}
        }
        last_is_low = is_low;
    }
    ranges
}

/// Percent for each unit of the B factors; `None` if these are no confidences.
fn percent_per_unit(header: &Header, residues: &[SelectedResidue]) -> Option<f64> {
    let method = header.method.to_uppercase();
    let is_theoretical = method.contains("THEORETICAL");
    if !(method.is_empty() || is_theoretical) {
        return None;
    }
    let is_named = header.title.to_uppercase().contains("ALPHAFOLD")
        || header.entry.to_uppercase().starts_with("AF-");
    let protein: Vec<&SelectedResidue> = residues
        .iter()
        .filter(|each| each.class.is_protein() && !each.atoms.is_empty())
        .collect();
    let uniform = protein.iter().filter(|each| is_uniform(each)).count();
    let is_uniform = uniform as f64 >= LEAST_UNIFORM * protein.len() as f64;
    if !(is_named || is_uniform) {
        return None;
    }
    let values: Vec<f64> = protein.iter().map(|each| mean_b_factor(each)).collect();
    // Hundredths, as files write them.
    let different: BTreeSet<i64> = values.iter().map(|value| (100.0 * value) as i64).collect();
    let largest = values.iter().copied().fold(0.0, f64::max);
    let smallest = values.iter().copied().fold(f64::INFINITY, f64::min);
    if different.len() < LEAST_VALUES || smallest < 0.0 || largest > 100.0 {
        return None;
    }
    Some(if largest <= 1.0 { 100.0 } else { 1.0 })
}

/// Whether all atoms of a residue, two at least, have the same B factor.
fn is_uniform(residue: &SelectedResidue) -> bool {
    let first = residue.atoms[0].b_factor_angstrom2;
    residue.atoms.len() > 1
        && residue
            .atoms
            .iter()
            .all(|atom| (atom.b_factor_angstrom2 - first).abs() < 5e-3)
}

fn mean_b_factor(residue: &SelectedResidue) -> f64 {
    let sum: f64 = residue
        .atoms
        .iter()
        .map(|atom| atom.b_factor_angstrom2)
        .sum();
    sum / residue.atoms.len().max(1) as f64
}

#[cfg(test)]
mod tests {
    use crate::structure::{SelectionSettings, Structure};
    use crate::warnings::structure_warnings;

    /// Glycines with these B factors of their atoms, N and CA.
    fn glycines(header: &str, b_factors: &[[f64; 2]]) -> (Vec<String>, usize) {
        let mut text = header.to_owned();
        for (number, values) in b_factors.iter().enumerate() {
            for (atom, (name, b)) in ["N ", "CA"].iter().zip(values).enumerate() {
                text += &format!(
                    "ATOM  {:>5}  {name}  GLY A{:>4}    {:>8.3}{:>8.3}{:>8.3}  1.00{b:>6.2}           {}\n",
                    2 * number + atom + 1,
                    number + 1,
                    3.8 * number as f64,
                    1.4 * atom as f64,
                    0.0,
                    &name[..1]
                );
            }
        }
        let structure = Structure::read("model.pdb", text.as_bytes()).unwrap();
        let selection = structure.select(&SelectionSettings::default()).unwrap();
        let warnings = structure_warnings(&structure, &selection.report);
        let ranges = selection.report.low_confidence;
        let of_confidence = warnings
            .into_iter()
            .filter(|warning| warning.contains("confidence"))
            .collect();
        (
            of_confidence,
            ranges.iter().map(|range| range.residues).sum(),
        )
    }

    const PREDICTED: [f64; 8] = [31.5, 48.0, 92.0, 95.5, 91.0, 66.0, 93.0, 40.0];

    #[test]
    fn residues_of_low_confidence_are_named() {
        let uniform = PREDICTED.map(|value| [value, value]);
        let (warnings, residues) = glycines("", &uniform);
        assert_eq!(residues, 4);
        assert!(
            warnings.len() == 1 && warnings[0].contains("A:1-2, A:6, A:8"),
            "{warnings:?}"
        );
        // The same from 0 to 1.
        let shares = PREDICTED.map(|value| [0.01 * value; 2]);
        assert_eq!(glycines("", &shares).1, 4);
        // AlphaFold 3 has a confidence for each atom, and a header.
        let by_atom = PREDICTED.map(|value| [value - 2.0, value + 2.0]);
        let title = "TITLE     ALPHAFOLD MONOMER PREDICTION\n";
        assert_eq!(glycines(title, &by_atom).1, 4);
        assert_eq!(
            glycines("", &by_atom).1,
            0,
            "without a header these are B factors"
        );
    }

    #[test]
    fn experiments_and_masks_have_no_confidence() {
        let uniform = PREDICTED.map(|value| [value, value]);
        let header = "EXPDTA    X-RAY DIFFRACTION\n";
        assert_eq!(glycines(header, &uniform).1, 0);
        let mask = [1.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0, 1.0].map(|value| [value; 2]);
        assert_eq!(glycines("", &mask).1, 0);
    }
}
