//! How a residue that is not one of the twenty is treated, in words.

use super::cofactors::cofactor_of;
use super::ions::ion_charge_e;
use super::protonation::Group;
use super::residue_names::{ModifiedResidue, is_polymer};
use crate::structure::{ResidueClass, SelectedResidue};

/// Description of the residue and of the source of its charge and hydropathy; of no meaning for one
/// of the twenty under its own name.
pub(crate) fn describe(residue: &SelectedResidue) -> String {
    match residue.class {
        ResidueClass::Modified(modified) => describe_modified(modified),
        ResidueClass::AminoAcid(amino_acid) => {
            let name = amino_acid.name();
            format!("name of a force field, counted as {name}: the pH decides its protonation")
        }
        ResidueClass::LikeAminoAcid(amino_acid) if is_polymer(&residue.name) => {
            let name = amino_acid.name();
            format!(
                "has the heavy atoms of {name}, not those that its name means: counted as {name}"
            )
        }
        ResidueClass::LikeAminoAcid(amino_acid) => {
            let name = amino_acid.name();
            format!("in no table; has the heavy atoms of {name}, counted as {name}")
        }
        ResidueClass::UnknownAminoAcid => match formal_charge_e(residue) {
            0 => "in no table, side chain taken as neutral".into(),
            charge => format!("in no table, side chain charged {charge:+} e as the file states"),
        },
        ResidueClass::Ligand => describe_ligand(residue),
        _ => String::new(),
    }
}

fn describe_ligand(residue: &SelectedResidue) -> String {
    let states_charges = residue
        .atoms
        .iter()
        .any(|atom| atom.formal_charge_e.is_some());
    if let (None, Some(cofactor)) = (ion_of(residue), cofactor_of(residue)) {
        return format!(
            "ligand, {}: {:+} e by its name",
            cofactor.description,
            cofactor.charge_e()
        );
    }
    match ion_of(residue) {
        Some(charge) => format!("ligand, {charge:+} e by its name"),
        None if states_charges => format!(
            "ligand, {:+} e, the sum of the formal charges that the file states",
            formal_charge_e(residue)
        ),
        None => "ligand, taken as neutral: the file states no formal charges".into(),
    }
}

/// The charge of an ion by its name, e; `None` for a residue that is no ion.
pub(crate) fn ion_of(residue: &SelectedResidue) -> Option<i32> {
    let heavy_atoms = residue.atoms.iter().filter(|atom| !atom.is_hydrogen());
    ion_charge_e(&residue.name, heavy_atoms.count())
}

fn describe_modified(modified: &ModifiedResidue) -> String {
    let description = modified.description;
    let hydropathy = match modified.parent {
        Some(parent) => format!("hydropathy of {}", parent.name()),
        None => "no hydropathy".into(),
    };
    match (modified.groups, modified.parent) {
        (None, Some(parent)) => format!("{description}, counted as {}", parent.name()),
        (None | Some([]), _) => format!("{description}: {hydropathy}, side chain taken as neutral"),
        (Some(groups), _) => format!("{description}: {hydropathy}, {}", describe_groups(groups)),
    }
}

/// Own titratable groups in words, such as `own groups of pKa 1.0 (acid), 5.6 (acid)`.
fn describe_groups(groups: &[Group]) -> String {
    let mut described = Vec::new();
    for group in groups {
        let kind = if group.protonated_charge_e > 0.5 {
            "base"
        } else {
            "acid"
        };
        described.push(format!("{:.1} ({kind})", group.pka));
    }
    format!("own groups of pKa {}", described.join(", "))
}

/// Sum of the formal charges that the file states for the atoms, e.
pub(crate) fn formal_charge_e(residue: &SelectedResidue) -> i32 {
    let mut sum = 0_i32;
    for atom in &residue.atoms {
        sum = sum.saturating_add(atom.formal_charge_e.unwrap_or(0));
    }
    sum
}
