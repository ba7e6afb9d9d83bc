//! What shifts a pKa, term by term.
//!
//! An energy of charging E raises the pKa of an acid and lowers that of a base: ΔpKa = -z E / ln 10,
//! with z the charge of the charged form. What desolvation and background leave of the whole shift is
//! that of the neighbours, averaged over their states.

use super::answer::{GroupRow, Neighbour};
use protomer_body::chemistry::titration::{GroupKind, TitratableGroup, TitratableSites};
use protomer_body::structure::Selection;
use protomer_field::titration::{GroupEnergies, TitratingGroups, TitrationModel};
use std::f64::consts::LN_10;

/// Weakest interaction that is named, kT.
const NAMED_ABOVE_KT: f64 = 0.1;

/// A row for each group.
pub(super) fn rows(
    selection: &Selection,
    sites: &TitratableSites,
    energies: &GroupEnergies,
    groups: &TitratingGroups,
    model: &TitrationModel,
    ph: f64,
) -> Vec<GroupRow> {
    let shares = groups.charged_shares(ph);
    let mut rows = Vec::with_capacity(sites.groups.len());
    for (index, (group, pka)) in sites.groups.iter().zip(groups.pka_values()).enumerate() {
        let key = &selection.residues[group.residue].key;
        let desolvation_kt = model.desolvation_kt(energies.desolvation_kt[index]);
        // The background also chooses the tautomer of the neutral form.
        let background_kt =
            model.background * energies.background_kt[index] - groups.neutral_form_kt(index);
        let shift_desolvation = pka_shift(group.charge_e, desolvation_kt);
        let shift_background = pka_shift(group.charge_e, background_kt);
        let model_pka = groups.model_pka[index];
        rows.push(GroupRow {
            chain: key.chain.to_string(),
            residue_number: key.number,
            insertion_code: key.insertion_code.to_string(),
            residue: name(selection, group),
            pka,
            model_pka,
            charge_e: group.charge_e * shares[index],
            shift_desolvation,
            shift_background,
            shift_neighbours: pka.map(|pka| pka - model_pka - shift_desolvation - shift_background),
            strongest_neighbour: strongest_neighbour(selection, sites, groups, index),
        });
    }
    rows
}

/// Shift of a pKa by an energy of charging, units of pKa; `charge_e` is that of the charged form.
fn pka_shift(charge_e: f64, energy_kt: f64) -> f64 {
    -charge_e * energy_kt / LN_10
}

/// Residue name in upper case, or the end of the chain.
fn name(selection: &Selection, group: &TitratableGroup) -> String {
    match group.kind {
        GroupKind::NTerminus => "N-term".into(),
        GroupKind::CTerminus => "C-term".into(),
        GroupKind::SideChain(amino_acid) => amino_acid.name().into(),
        GroupKind::Modified => selection.residues[group.residue].name.to_string(),
    }
}

/// The group with the strongest interaction of the charged forms.
fn strongest_neighbour(
    selection: &Selection,
    sites: &TitratableSites,
    groups: &TitratingGroups,
    index: usize,
) -> Option<Neighbour> {
    let row = &groups.pair_kt[index * groups.len()..(index + 1) * groups.len()];
    let mut strongest: Option<(usize, f64)> = None;
    for (other, energy_kt) in row.iter().enumerate() {
        let is_stronger = strongest.is_none_or(|(_, best_kt)| energy_kt.abs() > best_kt.abs());
        if other != index && is_stronger {
            strongest = Some((other, *energy_kt));
        }
    }
    let (other, energy_kt) = strongest?;
    let group = &sites.groups[other];
    let key = &selection.residues[group.residue].key;
    let name = format!("{} {} {}", key.chain, name(selection, group), key.number);
    (energy_kt.abs() > NAMED_ABOVE_KT).then_some(Neighbour { name, energy_kt })
}

#[cfg(test)]
mod tests {
    use super::*;
    use protomer_body::chemistry::titration::titratable_sites;
    use protomer_body::structure::{SelectionSettings, Structure};

    /// An aspartate alone, which is both ends of its chain.
    fn aspartate() -> Selection {
        let atoms = [
            ("N", "N", [0.0, 0.0, 0.0]),
            ("CA", "C", [1.458, 0.0, 0.0]),
            ("C", "C", [2.009, 1.42, 0.0]),
            ("O", "O", [1.251, 2.39, 0.0]),
            ("CB", "C", [1.988, -0.773, -1.199]),
            ("CG", "C", [3.502, -0.857, -1.227]),
            ("OD1", "O", [4.119, -0.105, -2.009]),
            ("OD2", "O", [4.075, -1.689, -0.493]),
            ("OXT", "O", [3.324, 1.54, 0.0]),
        ];
        let mut text = String::new();
        for (serial, (name, element, [x, y, z])) in (1..).zip(atoms) {
            let place = format!("{x:8.3}{y:8.3}{z:8.3}");
            text += &format!(
                "ATOM  {serial:>5}  {name:<3} ASP A   1    {place}  1.00  0.00           {element}\n"
            );
        }
        let structure = Structure::read("aspartate.pdb", text.as_bytes()).unwrap();
        structure.select(&SelectionSettings::default()).unwrap()
    }

    #[test]
    fn an_energy_of_charging_raises_the_pka_of_an_acid_and_lowers_that_of_a_base() {
        assert_eq!(pka_shift(-1.0, LN_10), 1.0);
        assert_eq!(pka_shift(1.0, LN_10), -1.0);
    }

    #[test]
    fn neighbours_shift_by_what_desolvation_and_background_leave() {
        let selection = aspartate();
        let sites = titratable_sites(&selection);
        let count = sites.groups.len();
        assert_eq!(count, 3);
        let model = TitrationModel::default();
        let mut energies = GroupEnergies {
            desolvation_kt: vec![2.0; count],
            background_kt: vec![-0.5; count],
            tautomer_kt: vec![0.0; count],
            pair_kt: vec![0.0; count * count],
            tautomer_pair_kt: vec![0.0; count * count],
        };
        let table = |energies: &GroupEnergies| {
            let groups = model.groups(&sites, energies, 0.0);
            rows(&selection, &sites, energies, &groups, &model, 6.0)
        };
        let alone = table(&energies);
        let names: Vec<&str> = alone.iter().map(|row| row.residue.as_str()).collect();
        assert_eq!(names, ["N-term", "ASP", "C-term"]);
        for row in &alone {
            assert!(row.shift_neighbours.unwrap().abs() < 1e-4, "{row:?}");
            assert!(row.strongest_neighbour.is_none(), "{row:?}");
            let is_acid = row.charge_e < 0.0;
            assert_eq!(row.shift_desolvation > 0.0, is_acid, "{row:?}");
            assert_eq!(row.shift_background < 0.0, is_acid, "{row:?}");
        }
        // Amine and side chain attract each other.
        energies.pair_kt[1] = -3.0;
        energies.pair_kt[count] = -3.0;
        let paired = table(&energies);
        let energy_kt = -3.0 * model.pair;
        for (row, charge_e) in paired.iter().zip([1.0, -1.0]) {
            let shift = row.shift_neighbours.unwrap();
            let whole = pka_shift(charge_e, energy_kt);
            assert!((shift - whole).abs() < 0.02, "{shift} {whole}");
        }
        let neighbour = paired[1].strongest_neighbour.as_ref().unwrap();
        assert_eq!(neighbour.name, "A N-term 1");
        assert!((neighbour.energy_kt - energy_kt).abs() < 1e-12);
    }
}
