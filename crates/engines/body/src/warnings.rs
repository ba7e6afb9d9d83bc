//! Warnings about a structure file and the body made from it.

use crate::chemistry::additives::is_crystallisation_additive;
use crate::structure::confidence::{LOW_PERCENT, LowConfidence};
use crate::structure::report::reason;
use crate::structure::{
    Disulfide, DisulfideEvidence, ListedResidue, SelectionReport, Structure, messages::listed,
};
use crate::surface::FilledCavities;
use std::collections::BTreeMap;

/// Warnings about a file and about what was selected from it.
pub fn structure_warnings(structure: &Structure, report: &SelectionReport) -> Vec<String> {
    let mut warnings = reader_warnings(structure);
    warnings.extend(selection_warnings(report));
    warnings
}

/// Warnings of the reader.
pub(crate) fn reader_warnings(structure: &Structure) -> Vec<String> {
    let warnings = &structure.warnings;
    let mut messages = structure.corrections.warnings();
    messages.extend(warnings.messages.iter().cloned());
    if warnings.count > warnings.messages.len() {
        let more = warnings.count - warnings.messages.len();
        messages.push(format!("and {more} more warnings of this kind"));
    }
    messages
}

/// Warnings about the selection: unusual residues and how each was treated, then what is missing.
pub(crate) fn selection_warnings(report: &SelectionReport) -> Vec<String> {
    let mut warnings = model_warning(report);
    warnings.extend(left_out_warnings(report));
    warnings.extend(skipped_warnings(report));
    warnings.extend(report.corrections.iter().cloned());
    if report.repeated_numbers > 0 {
        let count = report.repeated_numbers;
        warnings.push(format!(
            "{count} residues have the chain and number of another residue"
        ));
    }
    let lists = [
        &report.unknown,
        &report.modified,
        &report.microheterogeneous,
        &report.blocked_ends,
    ];
    for listed in lists.into_iter().flatten() {
        warnings.push(describe(listed));
    }
    warnings.extend(ligand_warnings(&report.ligands));
    warnings.extend(disulfide_warnings(&report.disulfides));
    for residue in &report.incomplete {
        let missing = residue.missing_atoms.join(", ");
        warnings.push(format!(
            "{} {} lacks {missing}",
            residue.name, residue.residue
        ));
    }
    for gap in &report.chain_breaks {
        warnings.push(format!(
            "chain break between {} and {}",
            gap.before, gap.after
        ));
    }
    warnings.extend(confidence_warning(&report.low_confidence));
    if report.unobserved > 0 {
        let count = report.unobserved;
        warnings.push(format!("{count} residues are listed as not observed"));
    }
    warnings
}

/// Warning of residues whose places a prediction does not know.
fn confidence_warning(ranges: &[LowConfidence]) -> Option<String> {
    let residues: usize = ranges.iter().map(|range| range.residues).sum();
    let places: Vec<String> = ranges.iter().map(LowConfidence::in_words).collect();
    (residues > 0).then(|| {
        let (are, their) = match residues {
            1 => ("residue has", "its place is"),
            _ => ("residues have", "their places are"),
        };
        format!(
            "{residues} {are} a confidence (pLDDT) below {LOW_PERCENT}: {}; {their} uncertain, and --residues keeps \
             the others",
            listed(&places)
        )
    })
}

/// Warning that one of several models is used, unless the user chose it.
fn model_warning(report: &SelectionReport) -> Vec<String> {
    if report.models < 2 || report.is_model_chosen {
        return Vec::new();
    }
    vec![format!(
        "model {} of {} models is used; --model chooses another one; if the models are the copies of a \
         biological assembly (.pdb1), use --assembly on the deposited entry to have all of them",
        report.model, report.models
    )]
}

/// One line for each reason for which records are no atoms, with their names.
fn left_out_warnings(report: &SelectionReport) -> Vec<String> {
    let mut warnings = Vec::new();
    for (reason, names) in &report.left_out {
        let count: usize = names.values().sum();
        let plural = match count {
            1 => String::new(),
            _ => "s".into(),
        };
        let reason = match reason.split_once(' ') {
            Some(("atom", place)) => format!("atom{plural} {place}"),
            _ => format!("{reason}{plural}"),
        };
        warnings.push(format!("{count} {reason} left out: {}", counted(names)));
    }
    warnings
}

/// One line for the ligands and one for the nucleic acids that are left out, with their names, their
/// chains and the flag that keeps them. They may carry charge and fill space between chains; additives
/// of the crystallisation do not belong to the protein and are only counted.
fn skipped_warnings(report: &SelectionReport) -> Vec<String> {
    let kinds = [
        (reason::LIGAND, "ligands", "--keep-ligands"),
        (
            reason::NUCLEIC_ACID,
            "nucleic acids",
            "--keep-nucleic-acids",
        ),
    ];
    let mut warnings = Vec::new();
    for (why, kind, flag) in kinds {
        let Some(residues) = report.skipped_residues.get(why) else {
            continue;
        };
        let mut names = residues.names.clone();
        names.retain(|name, _| !is_crystallisation_additive(name));
        if names.is_empty() {
            continue;
        }
        let chains: Vec<String> = residues
            .chains
            .iter()
            .filter(|name| !name.is_empty())
            .cloned()
            .collect();
        let place = match chains.as_slice() {
            [] => String::new(),
            [chain] => format!(" of chain {chain}"),
            chains => format!(" of chains {}", listed(chains)),
        };
        warnings.push(format!(
            "{kind}{place} left out: {}; {flag} keeps them",
            counted(&names)
        ));
    }
    warnings
}

/// Names with their numbers, the most frequent first: `4 HEM, 2 PO4`.
fn counted(names: &BTreeMap<String, usize>) -> String {
    let mut names: Vec<(&String, &usize)> = names.iter().collect();
    names.sort_by_key(|(name, count)| (std::cmp::Reverse(**count), *name));
    let names: Vec<String> = names
        .iter()
        .map(|(name, count)| format!("{count} {name}"))
        .collect();
    listed(&names)
}

fn describe(listed: &ListedResidue) -> String {
    let ListedResidue {
        name,
        residue,
        note,
        charge_e,
    } = listed;
    match charge_e {
        Some(charge) => format!("{name} {residue}: {note}; {} e", signed(*charge)),
        None => format!("{name} {residue}: {note}"),
    }
}

/// A charge with two digits and its sign; zero is never negative.
fn signed(charge_e: f64) -> String {
    let rounded = (charge_e * 100.0).round() / 100.0 + 0.0;
    format!("{rounded:+.2}")
}

/// One line for all ligands of a name that are treated alike.
fn ligand_warnings(ligands: &[ListedResidue]) -> Vec<String> {
    let mut alike: BTreeMap<(&str, &str), usize> = BTreeMap::new();
    for ligand in ligands {
        *alike.entry((&ligand.name, &ligand.note)).or_default() += 1;
    }
    let mut warnings = Vec::new();
    for ((name, note), count) in alike {
        warnings.push(format!("{name} ({count} kept): {note}"));
    }
    warnings
}

/// Disagreement between the records of disulfide bonds and the distances between sulfurs.
fn disulfide_warnings(bonds: &[Disulfide]) -> Vec<String> {
    let (mut long, mut unrecorded, mut lone) = (Vec::new(), Vec::new(), Vec::new());
    let mut has_records = false;
    for bond in bonds {
        has_records |= bond.evidence != DisulfideEvidence::Distance;
        let pair = format!("{}-{}", bond.residue, bond.partner);
        match (bond.evidence, bond.distance_angstrom) {
            (DisulfideEvidence::Distance, _) => unrecorded.push(pair),
            (DisulfideEvidence::Record, Some(distance)) => {
                long.push(format!("{pair} ({distance:.2} Å)"));
            }
            _ if !bond.partner_is_selected => lone.push(pair),
            _ => {}
        }
    }
    let mut warnings = Vec::new();
    if !long.is_empty() {
        warnings.push(format!(
            "disulfide bonds recorded in the file but longer than 2.5 Å, counted as bonds: {}",
            listed(&long)
        ));
    }
    // A file without any record says nothing about bonds.
    if has_records && !unrecorded.is_empty() {
        warnings.push(format!(
            "pairs of cysteines within 2.5 Å that the file does not record as bonds, counted as \
             bonds: {}",
            listed(&unrecorded)
        ));
    }
    if !lone.is_empty() {
        warnings.push(format!(
            "disulfide bonds to a cysteine that is not selected (another chain or a symmetry \
             copy), counted as bonds: {}",
            listed(&lone)
        ));
    }
    warnings
}

/// Warnings about the cavities of a surface that were filled or kept.
pub(crate) fn cavity_warnings(
    cavities: &FilledCavities,
    interior_radius_angstrom: f64,
) -> Vec<String> {
    let mut warnings = Vec::new();
    let volume = cavities.filled_volume_angstrom3;
    match cavities.filled {
        0 => {}
        1 => warnings.push(format!(
            "1 internal cavity filled ({volume:.0} Å³); keep it with --cavities keep"
        )),
        count => warnings.push(format!(
            "{count} internal cavities filled ({volume:.0} Å³ in all); keep them with --cavities \
             keep"
        )),
    }
    let volume = cavities.kept_volume_angstrom3;
    let reason = format!(
        "as a ball of {interior_radius_angstrom} Å fits inside; to fill it, state a larger \
         --interior-radius"
    );
    match cavities.kept {
        0 => {}
        1 => warnings.push(format!(
            "1 enclosed interior kept ({volume:.0} Å³), {reason}"
        )),
        count => warnings.push(format!(
            "{count} enclosed interiors kept ({volume:.0} Å³ in all), {reason}"
        )),
    }
    warnings
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::structure::ResidueKey;

    fn key(number: i32) -> ResidueKey {
        ResidueKey {
            chain: "A".into(),
            number,
            insertion_code: "".into(),
        }
    }

    fn bond(evidence: DisulfideEvidence, distance_angstrom: Option<f64>) -> Disulfide {
        Disulfide {
            residue: key(1),
            partner: key(2),
            evidence,
            distance_angstrom,
            partner_is_selected: distance_angstrom.is_some(),
        }
    }

    #[test]
    fn differences_between_records_and_distances_are_reported() {
        use DisulfideEvidence::{Distance, Record, RecordAndDistance};
        let agreed = bond(RecordAndDistance, Some(2.04));
        let unrecorded = bond(Distance, Some(2.1));
        assert!(disulfide_warnings(std::slice::from_ref(&agreed)).is_empty());
        assert!(disulfide_warnings(std::slice::from_ref(&unrecorded)).is_empty());
        let all = disulfide_warnings(&[
            agreed,
            unrecorded,
            bond(Record, Some(2.79)),
            bond(Record, None),
        ]);
        assert_eq!(all.len(), 3);
        assert!(all[0].ends_with("A:1-A:2 (2.79 Å)"), "{}", all[0]);
        assert!(all[1].contains("does not record"), "{}", all[1]);
        assert!(all[2].contains("not selected"), "{}", all[2]);
    }

    #[test]
    fn no_charge_is_printed_as_minus_zero() {
        assert_eq!(
            [signed(-0.001), signed(-1.982), signed(0.0)],
            ["+0.00", "-1.98", "+0.00"]
        );
    }

    #[test]
    fn the_volume_that_was_filled_is_stated() {
        let cavities = FilledCavities {
            filled: 2,
            filled_volume_angstrom3: 61.4,
            kept: 1,
            kept_volume_angstrom3: 5.2e5,
        };
        let [filled, kept] = cavity_warnings(&cavities, 10.0).try_into().unwrap();
        assert!(
            filled.starts_with("2 internal cavities filled (61 Å³ in all)"),
            "{filled}"
        );
        assert!(
            kept.starts_with("1 enclosed interior kept (520000 Å³), as a ball of 10 Å"),
            "{kept}"
        );
        assert!(cavity_warnings(&FilledCavities::default(), 10.0).is_empty());
    }
}
