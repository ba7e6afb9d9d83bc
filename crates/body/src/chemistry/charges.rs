//! One residue's charge on its atoms.
//!
//! The residue's charge is the sum of the mean charges of its titratable groups at the pH
//! ([`residue_charge_e`]). The models differ in where it sits ([`atom_charges_e`]); in each of them
//! the atoms' charges add up to it exactly:
//!
//! * force field: template charges, hydrogens folded on their heavy atom, interpolated between the
//!   protonated and the deprotonated form; what missing or unknown atoms leave over is spread
//!   evenly over the heavy atoms present;
//! * formal: the groups' charges on the atoms of the groups, nothing else.
//!
//! Hydrogens that are kept carry no charge of their own: their heavy atom carries it.

use super::amino_acid::{AminoAcid, BACKBONE};
use super::protonation::{C_TERMINUS, Group, N_TERMINUS, protonated_fraction, side_chain_groups};
use super::residue_names::ion_charge_e;
use super::templates::{self, Template, forms};
use crate::structure::{ResidueClass, SelectedResidue};
use serde::{Deserialize, Serialize};

/// Where the charges of a residue sit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ChargeModel {
    /// AMBER ff94 partial charges on every heavy atom.
    #[default]
    ForceField,
    /// Formal charges on the charged groups.
    Formal,
    /// No charges.
    None,
}

/// The titratable groups of the side chain.
pub fn side_groups(residue: &SelectedResidue) -> &'static [Group] {
    match residue.class {
        ResidueClass::Modified(modified) if modified.groups.is_some() => {
            modified.groups.unwrap_or(&[])
        }
        _ if residue.in_disulfide => &[],
        class => class.amino_acid().map_or(&[], side_chain_groups),
    }
}

/// Net charge of a residue at a pH, e: side chain, ends of the chain, and the formal charge of
/// ions, ligands and phosphates.
pub fn residue_charge_e(residue: &SelectedResidue, ph: f64) -> f64 {
    let side: f64 = side_groups(residue)
        .iter()
        .map(|group| group.charge_e(ph))
        .sum();
    let n_terminus = if residue.n_terminus {
        N_TERMINUS.charge_e(ph)
    } else {
        0.0
    };
    let c_terminus = if residue.c_terminus {
        C_TERMINUS.charge_e(ph)
    } else {
        0.0
    };
    side + n_terminus + c_terminus + fixed_charge_e(residue)
}

/// Charges that no pH changes: one per phosphate of a nucleic acid, ions by their name, ligands as
/// the file states.
fn fixed_charge_e(residue: &SelectedResidue) -> f64 {
    match residue.class {
        ResidueClass::Nucleotide if residue.atom("P").is_some() => -1.0,
        ResidueClass::Ligand => f64::from(ion_charge_e(&residue.name).unwrap_or_else(|| {
            let stated = residue.atoms.iter().filter_map(|atom| atom.formal_charge_e);
            stated.fold(0, i32::saturating_add)
        })),
        _ => 0.0,
    }
}

/// The charges of the residue's atoms, e, in their order.
pub fn atom_charges_e(residue: &SelectedResidue, ph: f64, model: ChargeModel) -> Vec<f64> {
    let mut charges = Charges {
        residue,
        values: vec![0.0; residue.atoms.len()],
    };
    match model {
        ChargeModel::None => return charges.values,
        ChargeModel::Formal => charges.formal(ph),
        ChargeModel::ForceField => charges.force_field(ph),
    }
    charges.spread_remainder(residue_charge_e(residue, ph));
    charges.values
}

struct Charges<'a> {
    residue: &'a SelectedResidue,
    values: Vec<f64>,
}

impl Charges<'_> {
    fn formal(&mut self, ph: f64) {
        for group in side_groups(self.residue) {
            self.place_group(group, group.charge_e(ph));
        }
        if self.residue.n_terminus {
            self.place(N_TERMINUS.atoms, N_TERMINUS.charge_e(ph));
        }
        if self.residue.c_terminus {
            self.place(C_TERMINUS.atoms, C_TERMINUS.charge_e(ph));
        }
        self.fixed();
    }

    fn force_field(&mut self, ph: f64) {
        match (self.residue.class, self.residue.mutated_from) {
            (ResidueClass::AminoAcid(amino_acid), None) => self.template(amino_acid, ph),
            (ResidueClass::AminoAcid(amino_acid), Some(_)) => self.mutated(amino_acid, ph),
            (ResidueClass::Modified(modified), _) => {
                if let Some(parent) = modified.parent {
                    match modified.groups {
                        None => self.template(parent, ph),
                        Some(groups) => {
                            self.neutral_template(parent);
                            for group in groups {
                                self.place_group(group, group.charge_e(ph));
                            }
                        }
                    }
                }
            }
            _ => self.fixed(),
        }
        self.termini(ph);
    }

    /// The residue's template at the pH.
    fn template(&mut self, amino_acid: AminoAcid, ph: f64) {
        let forms = forms(amino_acid, self.residue.in_disulfide);
        let groups = if self.residue.in_disulfide {
            &[]
        } else {
            side_chain_groups(amino_acid)
        };
        let Some(group) = groups.first() else {
            return self.add(forms.protonated, 1.0);
        };
        let protonated = protonated_fraction(group.pka, ph);
        if forms.deprotonated.is_empty() {
            self.add(forms.protonated, 1.0);
            self.place_group(group, protonated - 1.0);
        } else {
            self.add(forms.protonated, protonated);
            self.add(forms.deprotonated, 1.0 - protonated);
        }
    }

    /// The form of the parent without charge, for residues whose groups are their own.
    fn neutral_template(&mut self, parent: AminoAcid) {
        let forms = forms(parent, false);
        let is_base = side_chain_groups(parent)
            .first()
            .is_some_and(|group| group.protonated_charge_e > 0.5);
        self.add(
            if is_base && !forms.deprotonated.is_empty() {
                forms.deprotonated
            } else {
                forms.protonated
            },
            1.0,
        );
    }

    /// A residue that stands on another's atoms: the new residue's template on the backbone, and
    /// its side chain's net charge on the outermost atoms there are.
    fn mutated(&mut self, amino_acid: AminoAcid, ph: f64) {
        self.template(amino_acid, ph);
        for (atom, value) in self.residue.atoms.iter().zip(&mut self.values) {
            if !BACKBONE.contains(&&*atom.name) {
                *value = 0.0;
            }
        }
        let net: f64 = side_groups(self.residue)
            .iter()
            .map(|group| group.charge_e(ph))
            .sum();
        let backbone: f64 = self.values.iter().sum();
        self.place_outermost(net - backbone);
    }

    fn termini(&mut self, ph: f64) {
        if self.residue.n_terminus {
            let charge = N_TERMINUS.charge_e(ph);
            templates::N_TERMINUS
                .iter()
                .for_each(|(atom, share)| self.add_to(atom, charge * share));
        }
        if self.residue.c_terminus {
            let charge = -C_TERMINUS.charge_e(ph);
            templates::C_TERMINUS
                .iter()
                .for_each(|(atom, share)| self.add_to(atom, charge * share));
        }
    }

    /// Phosphates, ions and ligands.
    fn fixed(&mut self) {
        match self.residue.class {
            ResidueClass::Nucleotide if self.residue.atom("P").is_some() => {
                self.place(&["OP1", "OP2", "O1P", "O2P"], -1.0);
            }
            ResidueClass::Ligand if ion_charge_e(&self.residue.name).is_none() => {
                for (atom, value) in self.residue.atoms.iter().zip(&mut self.values) {
                    *value = f64::from(atom.formal_charge_e.unwrap_or(0));
                }
            }
            _ => {}
        }
    }

    fn add(&mut self, templates: &[Template], weight: f64) {
        let share = weight / templates.len() as f64;
        for (name, own, hydrogens) in templates.iter().copied().flatten() {
            self.add_to(name, share * (own + hydrogens));
        }
    }

    fn add_to(&mut self, name: &str, charge: f64) {
        if let Some(index) = self
            .residue
            .atoms
            .iter()
            .position(|atom| &*atom.name == name)
        {
            self.values[index] += charge;
        }
    }

    /// Puts a group's charge on its atoms; in a mutated residue, which lacks them, on the outermost
    /// atoms.
    fn place_group(&mut self, group: &Group, charge: f64) {
        if self.residue.mutated_from.is_some() {
            self.place_outermost(charge);
        } else {
            self.place(group.atoms, charge);
        }
    }

    /// Shares a charge equally between those of the named atoms that are present, or puts it on the
    /// outermost atoms.
    fn place(&mut self, names: &[&str], charge: f64) {
        let is_named = |index: &usize| names.contains(&&*self.residue.atoms[*index].name);
        let present: Vec<usize> = (0..self.values.len()).filter(is_named).collect();
        if present.is_empty() {
            self.place_outermost(charge)
        } else {
            self.share(&present, charge)
        }
    }

    fn place_outermost(&mut self, charge: f64) {
        self.share(&outermost(self.residue), charge);
    }

    fn share(&mut self, atoms: &[usize], charge: f64) {
        for &index in atoms {
            self.values[index] += charge / atoms.len() as f64;
        }
    }

    /// Spreads what is left of the residue's charge evenly over its heavy atoms.
    fn spread_remainder(&mut self, charge: f64) {
        let is_heavy = |index: &usize| !self.residue.atoms[*index].is_hydrogen();
        let heavy: Vec<usize> = (0..self.values.len()).filter(is_heavy).collect();
        let atoms = if heavy.is_empty() {
            (0..self.values.len()).collect()
        } else {
            heavy
        };
        let remainder = charge - self.values.iter().sum::<f64>();
        self.share(&atoms, remainder);
    }
}

/// The heavy atoms of the side chain farthest from the backbone by the letter of their names (B, G,
/// D, E, Z, H); CA, or any heavy atom, where there is no side chain.
fn outermost(residue: &SelectedResidue) -> Vec<usize> {
    let remoteness = |index: usize| {
        let atom = &residue.atoms[index];
        let is_side =
            !BACKBONE.contains(&&*atom.name) && &*atom.name != "OXT" && !atom.is_hydrogen();
        let letter = atom
            .name
            .chars()
            .nth(1)
            .and_then(|letter| "BGDEZH".find(letter));
        match letter {
            Some(rank) if is_side => 2 + rank,
            _ if &*atom.name == "CA" => 1,
            _ => 0,
        }
    };
    let farthest = (0..residue.atoms.len()).map(remoteness).max().unwrap_or(0);
    (0..residue.atoms.len())
        .filter(|index| remoteness(*index) == farthest)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::structure::{SelectionSettings, Structure};

    /// A residue with all its heavy atoms, in the middle of a chain.
    fn whole(amino_acid: AminoAcid) -> SelectedResidue {
        let names = BACKBONE.iter().chain(amino_acid.side_chain());
        let line = |name: &&str| {
            format!(
                "ATOM      1  {name:<3} {} A   1       0.000   0.000   0.000\n",
                amino_acid.name()
            )
        };
        let text: String = names.map(line).collect();
        let structure = Structure::read("test.pdb", text.as_bytes()).unwrap();
        let mut residue = structure
            .select(&SelectionSettings::default())
            .unwrap()
            .residues
            .remove(0);
        (residue.n_terminus, residue.c_terminus) = (false, false);
        residue
    }

    /// Far from the pKa a whole residue has exactly the charges of the published template.
    #[test]
    fn a_whole_residue_has_its_template() {
        for amino_acid in AminoAcid::all() {
            let residue = whole(amino_acid);
            let forms = forms(amino_acid, false);
            for (ph, templates) in [(-10.0, forms.protonated), (30.0, forms.deprotonated)] {
                let charges = atom_charges_e(&residue, ph, ChargeModel::ForceField);
                for (atom, charge) in residue.atoms.iter().zip(charges) {
                    let of = |template: &Template| {
                        template
                            .iter()
                            .find(|entry| entry.0 == &*atom.name)
                            .unwrap()
                    };
                    let sum: f64 = templates
                        .iter()
                        .map(of)
                        .map(|entry| entry.1 + entry.2)
                        .sum();
                    if !templates.is_empty() {
                        assert!(
                            (charge - sum / templates.len() as f64).abs() < 1e-6,
                            "{amino_acid:?} {}",
                            atom.name
                        );
                    }
                }
            }
        }
    }

    #[test]
    fn without_a_template_the_lost_proton_is_on_the_group() {
        for (amino_acid, group) in [(AminoAcid::Tyr, "OH"), (AminoAcid::Arg, "NH1")] {
            let residue = whole(amino_acid);
            let at = |ph| atom_charges_e(&residue, ph, ChargeModel::ForceField);
            let change: Vec<f64> = at(30.0).iter().zip(at(-10.0)).map(|(a, b)| a - b).collect();
            let index = residue
                .atoms
                .iter()
                .position(|atom| &*atom.name == group)
                .unwrap();
            assert!(change[index] < -0.49 && (change.iter().sum::<f64>() + 1.0).abs() < 1e-9);
        }
    }

    #[test]
    fn outermost_atoms_by_their_letters() {
        for (amino_acid, names) in [
            (AminoAcid::Lys, &["NZ"][..]),
            (AminoAcid::Arg, &["NH1", "NH2"]),
            (AminoAcid::Gly, &["CA"]),
            (AminoAcid::Ser, &["OG"]),
        ] {
            let residue = whole(amino_acid);
            let outermost: Vec<&str> = outermost(&residue)
                .iter()
                .map(|index| &*residue.atoms[*index].name)
                .collect();
            assert_eq!(outermost, names);
        }
    }
}
