//! The titratable groups of a selection, as changes of charge.

use super::super::amino_acid::AminoAcid;
use super::super::charges::{
    atom_capacitances_e2, neutral_charges_e, side_chain_change_e, side_groups, tautomer_change_e,
};
use super::super::protonation::{C_TERMINUS, N_TERMINUS, ResidueProtonation};
use super::super::templates;
use crate::structure::{ResidueClass, SelectedResidue, Selection};

/// Kind of a titratable group.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum GroupKind {
    /// Side chain of an amino acid.
    SideChain(AminoAcid),
    /// Side chain of a modified residue.
    Modified,
    /// Amine at the beginning of a chain.
    NTerminus,
    /// Carboxylate at the end of a chain.
    CTerminus,
}

/// A titratable group: the change of its atoms' charges between its neutral and its charged form.
#[derive(Debug, Clone, PartialEq)]
pub struct TitratableGroup {
    /// Index of the residue in the selection.
    pub residue: usize,
    /// Kind of a titratable group.
    pub kind: GroupKind,
    /// pKa in water.
    pub model_pka: f64,
    /// Charge of the charged form, e: 1 for a base, -1 for an acid.
    pub charge_e: f64,
    /// Changes of charge by index of the site, e: the charged minus the neutral form. They add up to
    /// [`charge_e`](Self::charge_e).
    pub change_e: Vec<(usize, f64)>,
    /// Half the difference of the two neutral tautomers of histidine, Nδ-H minus Nε-H, e; empty for
    /// other groups.
    pub tautomer_e: Vec<(usize, f64)>,
}

impl TitratableGroup {
    /// Whether the group is mostly charged in water at a pH of 7.
    pub(super) fn is_charged_in_water(&self) -> bool {
        (self.charge_e > 0.0) == (self.model_pka > 7.0)
    }
}

/// Protonation of every residue of a selection, from the charged share and the capacitance (e²) of each
/// group.
pub fn protonation_of_residues(
    selection: &Selection,
    groups: &[TitratableGroup],
    charged_shares: &[f64],
    capacitances_e2: &[f64],
) -> Vec<ResidueProtonation> {
    let mut residues = Vec::with_capacity(selection.residues.len());
    for residue in &selection.residues {
        residues.push(ResidueProtonation {
            side: Vec::with_capacity(side_groups(residue).len()),
            n_terminus: 1.0,
            c_terminus: 0.0,
            capacitance_e2: vec![0.0; side_groups(residue).len() + 2],
        });
    }
    for ((group, share), capacitance_e2) in groups.iter().zip(charged_shares).zip(capacitances_e2) {
        let protonated = if group.charge_e > 0.0 {
            *share
        } else {
            1.0 - share
        };
        let residue = &mut residues[group.residue];
        let last = residue.capacitance_e2.len() - 1;
        let place = match group.kind {
            GroupKind::NTerminus => {
                residue.n_terminus = protonated;
                last - 1
            }
            GroupKind::CTerminus => {
                residue.c_terminus = protonated;
                last
            }
            // Groups of a side chain follow each other in their order.
            GroupKind::SideChain(_) | GroupKind::Modified => {
                residue.side.push(protonated);
                residue.side.len() - 1
            }
        };
        residue.capacitance_e2[place] = *capacitance_e2;
    }
    residues
}

/// Changes of charge of each group in the formal model: the whole charge on the atoms of the group, by index of the atom in the
/// selection, e.
pub fn formal_changes_e(selection: &Selection, groups: &[TitratableGroup]) -> Vec<Vec<(u32, f64)>> {
    let mut firsts = Vec::with_capacity(selection.residues.len());
    let mut atoms = 0;
    for residue in &selection.residues {
        firsts.push(atoms);
        atoms += residue.atoms.len();
    }
    let mut changes = Vec::with_capacity(groups.len());
    let (mut present, mut side_groups_met) = (usize::MAX, 0);
    for group in groups {
        let residue = &selection.residues[group.residue];
        if group.residue != present {
            (present, side_groups_met) = (group.residue, 0);
        }
        let side = side_groups(residue).len();
        let place = match group.kind {
            GroupKind::NTerminus => side,
            GroupKind::CTerminus => side + 1,
            GroupKind::SideChain(_) | GroupKind::Modified => {
                side_groups_met += 1;
                side_groups_met - 1
            }
        };
        let mut of_group = ResidueProtonation::in_water(side_groups(residue), 7.0);
        of_group.capacitance_e2 = vec![0.0; side + 2];
        // Capacitances stand on the atoms that carry the formal charge.
        of_group.capacitance_e2[place] = 1.0;
        let shares = atom_capacitances_e2(residue, &of_group);
        let first = firsts[group.residue];
        let charged = shares
            .iter()
            .enumerate()
            .filter(|(_, share)| **share != 0.0);
        let change = charged.map(|(atom, share)| ((first + atom) as u32, group.charge_e * share));
        changes.push(change.collect());
    }
    changes
}

/// Titratable groups of a residue; `first` is the index of its first atom among the sites.
pub(super) fn groups_of_residue(
    residue: &SelectedResidue,
    index: usize,
    first: usize,
) -> Vec<TitratableGroup> {
    let mut groups = Vec::new();
    let mut push = |kind, model_pka, charge_e: f64, change: Vec<f64>, tautomer: Vec<f64>| {
        groups.push(TitratableGroup {
            residue: index,
            kind,
            model_pka,
            charge_e,
            change_e: sparse(change, first),
            tautomer_e: sparse(tautomer, first),
        });
    };
    if residue.n_terminus {
        let change = terminal_change(residue, &templates::N_TERMINUS, 1.0);
        push(
            GroupKind::NTerminus,
            N_TERMINUS.pka,
            1.0,
            change,
            Vec::new(),
        );
    }
    let is_standard = !matches!(residue.class, ResidueClass::Modified(_));
    for (place, group) in side_groups(residue).iter().enumerate() {
        let kind = match residue.class.amino_acid() {
            Some(amino_acid) if is_standard => GroupKind::SideChain(amino_acid),
            _ => GroupKind::Modified,
        };
        let charge_e = if group.protonated_charge_e > 0.5 {
            1.0
        } else {
            -1.0
        };
        let change = side_chain_change_e(residue, place);
        push(
            kind,
            group.pka,
            charge_e,
            change,
            tautomer_change_e(residue),
        );
    }
    if residue.c_terminus {
        let change = terminal_change(residue, &templates::C_TERMINUS, -1.0);
        push(
            GroupKind::CTerminus,
            C_TERMINUS.pka,
            -1.0,
            change,
            Vec::new(),
        );
    }
    groups
}

/// Charges of the neutral form of a residue, e.
pub(super) fn background_e(residue: &SelectedResidue) -> Vec<f64> {
    neutral_charges_e(residue)
}

/// Charges that an end of a chain adds, scaled to `total` where atoms are missing.
fn terminal_change(residue: &SelectedResidue, shares: &[(&str, f64)], total: f64) -> Vec<f64> {
    let mut change = vec![0.0; residue.atoms.len()];
    let mut sum = 0.0;
    for (atom, value) in residue.atoms.iter().zip(&mut change) {
        if let Some((_, share)) = shares.iter().find(|(name, _)| *name == &*atom.name) {
            *value = *share;
            sum += share;
        }
    }
    let missing = (total - sum) / change.len().max(1) as f64;
    for value in &mut change {
        *value += missing;
    }
    change
}

fn sparse(values: Vec<f64>, first: usize) -> Vec<(usize, f64)> {
    let mut changes = Vec::new();
    for (index, value) in values.into_iter().enumerate() {
        if value.abs() > 1e-9 {
            changes.push((first + index, value));
        }
    }
    changes
}
