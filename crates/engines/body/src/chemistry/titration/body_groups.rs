//! The titratable groups of a body, for simulations in which its charges respond.

use super::TitratableSites;
use serde::{Deserialize, Serialize};

/// Titratable groups of a body and the energies of their states, in the salt and at the temperature for which they were
/// solved.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BodyTitration {
    /// pH at which the body was charged.
    pub ph: f64,
    /// Concentration of a 1:1 salt, mol/L.
    #[serde(rename = "salt_M")]
    pub salt_molar: f64,
    /// Temperature, K.
    #[serde(rename = "temperature_K")]
    pub temperature_kelvin: f64,
    /// Groups in the order of the residues.
    #[serde(skip)]
    pub groups: Vec<BodyGroup>,
    /// Interaction of the charged forms of two groups, `groups × groups`, kT; zero on the diagonal.
    #[serde(skip)]
    pub pair_kt: Vec<f64>,
    /// Interaction of half the tautomer difference of a group (row) with the charged form of another, kT.
    #[serde(skip)]
    pub tautomer_pair_kt: Vec<f64>,
}

/// A titratable group of a body.
#[derive(Debug, Clone, PartialEq)]
pub struct BodyGroup {
    /// Charge of the charged form, e: 1 for a base, -1 for an acid.
    pub charge_e: f64,
    /// pKa in water.
    pub model_pka: f64,
    /// Free energy of the charged form in the body less that in water, all other groups neutral, kT.
    pub shift_kt: f64,
    /// Half the free energy difference of two neutral tautomers, Nδ-H less Nε-H, kT; `None` for a group with one
    /// neutral form.
    pub tautomer_kt: Option<f64>,
    /// Mean share of the charged form in the charges of the body, 0 to 1.
    pub charged_share: f64,
    /// Changes of charge by index of the site of the body, e: the charged less the neutral form.
    pub change_e: Vec<(u32, f64)>,
}

/// Changes of charge of a group (by its number) on the atoms alone: those of added hydrogens are put back on the nearest atom
/// of the group.
pub fn change_on_atoms_e(sites: &TitratableSites, group: usize) -> Vec<(u32, f64)> {
    let changes = &sites.groups[group].change_e;
    let mut on_atoms: Vec<(u32, f64)> = Vec::new();
    for &(site, charge_e) in changes.iter().filter(|change| change.0 < sites.atoms) {
        on_atoms.push((site as u32, charge_e));
    }
    let places = &sites.positions_angstrom;
    for &(hydrogen, charge_e) in changes.iter().filter(|change| change.0 >= sites.atoms) {
        let distance = |atom: u32| (places[atom as usize] - places[hydrogen]).norm();
        let nearest = on_atoms
            .iter_mut()
            .min_by(|one, other| distance(one.0).total_cmp(&distance(other.0)));
        if let Some(atom) = nearest {
            atom.1 += charge_e;
        }
    }
    on_atoms
}
