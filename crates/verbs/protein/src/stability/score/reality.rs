//! Chance that a contact of a crystal is one of a biological assembly.
//!
//! ```text
//! p = 1 / (1 + exp(-(c + a A + r R)))
//! ```
//!
//! A is the affinity by contacts, -ΔG° in kcal/mol; R is 1 for equal chains that make a ring, -1 for equal chains that
//! make an endless row, and 0 for chains that differ. The three numbers were fitted to the contacts of 258 crystals, one of each
//! cluster of sequences (docs/validation/interfaces.md).

use super::StatedComplex;
use super::complex::Pose;
use super::record::number;
use serde_json::Value;

/// Constant c.
const CONSTANT: f64 = -6.341;
/// Weight a of the affinity, mol/kcal.
const AFFINITY_PER_KCAL_PER_MOL: f64 = 0.652;
/// Weight r of a ring.
const RING: f64 = 0.932;

/// The chance, and the more probable of the two.
pub(super) fn columns(complex: &StatedComplex, pose: &Pose) -> Vec<(String, Value)> {
    let contacts = pose.interface.affinity(&pose.partners);
    let chance = chance(contacts.delta_g_kcal_per_mol(), ring(complex));
    let verdict = if chance > 0.5 { "assembly" } else { "packing" };
    vec![
        number("assembly_chance", chance),
        ("verdict".to_owned(), Value::from(verdict)),
    ]
}

fn chance(delta_g_kcal_per_mol: f64, ring: f64) -> f64 {
    let exponent = CONSTANT - AFFINITY_PER_KCAL_PER_MOL * delta_g_kcal_per_mol + RING * ring;
    1.0 / (1.0 + (-exponent).exp())
}

/// R of a complex.
fn ring(complex: &StatedComplex) -> f64 {
    let closed = complex.further.iter().find(|(name, _)| name == "closed");
    match closed.map(|(_, answer)| answer.as_str()) {
        Some("yes") => 1.0,
        Some("no") => -1.0,
        _ => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strong_rings_are_assemblies_and_weak_rows_are_packing() {
        assert!(chance(-14.0, 1.0) > 0.95);
        assert!(chance(-7.0, -1.0) < 0.1);
        // By hand: -6.341 + 0.652 * 10 + 0.932 = 1.111.
        assert!((chance(-10.0, 1.0) - 1.0 / (1.0 + (-1.111_f64).exp())).abs() < 1e-12);
    }
}
