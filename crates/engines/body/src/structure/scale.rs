//! Coordinates in another unit than Å.
//!
//! Programs for molecular dynamics use nanometres, quantum chemistry Bohr radii. Such a file reads
//! like one of a protein of another size; the bonds of the backbone show the unit.

use super::messages::parse_error;
use super::selected::SelectedResidue;
use crate::Result;
use protomer_kernel::statistics::median;

/// Units by the length of the bonds N-CA (1.46 Å) and CA-C (1.52 Å) in them: smallest, largest, name,
/// the factor to Å.
const UNITS: [(f64, f64, &str, &str); 3] = [
    (0.11, 0.19, "nm", "10"),
    (2.5, 3.1, "Bohr radii", "0.529177"),
    (110.0, 190.0, "pm", "0.01"),
];

/// Refuses residues in another unit.
pub(crate) fn check(source: &str, residues: &[SelectedResidue]) -> Result<()> {
    /// Least number of bonds for a verdict: fewer may be bad ones.
    const FEWEST: usize = 4;
    let mut lengths = Vec::new();
    for residue in residues {
        if !residue.class.is_protein() {
            continue;
        }
        for [first, second] in [["N", "CA"], ["CA", "C"]] {
            if let (Some(first), Some(second)) = (residue.atom(first), residue.atom(second)) {
                lengths.push((first.position - second.position).norm());
            }
        }
    }
    if lengths.len() < FEWEST {
        return Ok(());
    }
    refuse_unit(source, &mut lengths)
}

/// Refuses bonds of the backbone whose median length is one of another unit.
pub(crate) fn refuse_unit(source: &str, lengths: &mut [f64]) -> Result<()> {
    let Some(length) = median(lengths, f64::total_cmp) else {
        return Ok(());
    };
    for (smallest, largest, unit, factor) in UNITS {
        if (smallest..=largest).contains(&length) {
            let cause = format!(
                "the coordinates are in {unit}, not in Å: bonds N-CA and CA-C have a length of \
                 {length:.3}, and 1.5 Å was expected"
            );
            let remedy = format!("multiply the coordinates by {factor}");
            return Err(parse_error(source, 0, cause, remedy));
        }
    }
    Ok(())
}
