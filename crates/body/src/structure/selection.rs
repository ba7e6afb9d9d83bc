//! What of a structure becomes a body, and the count of what does not.

use super::alternates::{self, Conformer};
use super::assembled::apply_assembly;
use super::completeness::{self, ChainBreak, IncompleteResidue};
use super::residues::{AtomGroup, group};
use super::{Atom, BiologicalAssembly, Model, ResidueClass, ResidueKey, Structure};
use crate::chemistry::AminoAcid;
use crate::{BodyError, Result};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet, HashSet};
use std::sync::Arc;

/// What to do with residues that lack heavy atoms.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum MissingAtoms {
    /// Keep the residue as it is.
    #[default]
    Keep,
    /// Leave the whole residue out.
    Skip,
    /// Refuse the structure, and for chain breaks too.
    Fail,
}

/// Which part of a structure becomes a body. The default: first model, every chain, deposited
/// coordinates, highest occupancy; no ligands, waters, hydrogens or nucleic acids; incomplete
/// residues as they are.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SelectionSettings {
    /// Model number; `None` for the first.
    pub model: Option<i32>,
    /// Chains by the authors' names; empty for all.
    pub chains: Vec<String>,
    /// Biological assembly by its identifier; `None` for the deposited coordinates.
    pub assembly: Option<String>,
    /// Alternate location to prefer; `None` for the highest occupancy.
    pub alternate: Option<char>,
    /// Keep ligands, ions and sugars.
    pub keep_ligands: bool,
    /// Keep waters.
    pub keep_waters: bool,
    /// Keep hydrogens and deuteriums.
    pub keep_hydrogens: bool,
    /// Keep nucleic acids.
    pub keep_nucleic_acids: bool,
    /// What to do with residues that lack heavy atoms.
    pub missing: MissingAtoms,
}

/// The selected residues in file order.
#[derive(Debug, Clone, PartialEq)]
pub struct Selection {
    /// Residues, each with at least one atom.
    pub residues: Vec<SelectedResidue>,
    /// What was selected and what was not.
    pub report: SelectionReport,
}

/// One residue in one conformer.
#[derive(Debug, Clone, PartialEq)]
pub struct SelectedResidue {
    /// Chain, number, insertion code. The second copy of chain A in an assembly is chain `A-2`.
    pub key: ResidueKey,
    /// Residue name; after a mutation that of the new residue.
    pub name: Arc<str>,
    /// What it is; after a mutation the new residue.
    pub class: ResidueClass,
    /// Its atoms.
    pub atoms: Vec<Atom>,
    /// Author's chain in the file.
    pub source_chain: Arc<str>,
    /// Whether it carries a free amine as the beginning of a chain.
    pub n_terminus: bool,
    /// Whether it carries a free carboxylate as the end of a chain.
    pub c_terminus: bool,
    /// Whether it is a cysteine in a disulfide bond.
    pub in_disulfide: bool,
    /// The amino acid before a mutation.
    pub mutated_from: Option<AminoAcid>,
}

impl SelectedResidue {
    /// The atom of a name.
    pub fn atom(&self, name: &str) -> Option<&Atom> {
        self.atoms.iter().find(|atom| &*atom.name == name)
    }
}

/// A residue that deserves a line in the report.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ListedResidue {
    /// Which residue.
    pub residue: ResidueKey,
    /// Its name.
    pub name: Arc<str>,
    /// What about it.
    pub note: String,
}

/// What was selected, what was left out and why, and what is amiss.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct SelectionReport {
    /// Model used.
    pub model: i32,
    /// Models in the file.
    pub models: usize,
    /// Biological assembly used.
    pub assembly: Option<String>,
    /// Atom records of the model.
    pub records: usize,
    /// Atoms selected, over all copies of an assembly.
    pub atoms: usize,
    /// Atom records left out, by reason. With `atoms` they add up to `records` unless an assembly
    /// is applied.
    pub skipped: BTreeMap<&'static str, usize>,
    /// Residues left out, by name.
    pub skipped_residues: BTreeMap<String, usize>,
    /// Modified residues with what they are and what they count as.
    pub modified: Vec<ListedResidue>,
    /// Residues of a chain that are in no table: kept, neutral.
    pub unknown: Vec<ListedResidue>,
    /// Residues with other residues in the same place.
    pub microheterogeneous: Vec<ListedResidue>,
    /// Residues that lack heavy atoms.
    pub incomplete: Vec<IncompleteResidue>,
    /// Breaks of chains.
    pub chain_breaks: Vec<ChainBreak>,
    /// Residues that the file lists as not observed, of the chains selected.
    pub unobserved: usize,
    /// Selected residues that bear the chain and number of an earlier one, as in files without
    /// chain identifiers.
    pub repeated_numbers: usize,
    /// Selected atoms with zero occupancy.
    pub zero_occupancy: usize,
}

/// Reasons in [`SelectionReport::skipped`].
pub mod reason {
    /// Another chain.
    pub const CHAIN: &str = "other chain";
    /// Another conformer of the residue.
    pub const ALTERNATE: &str = "alternate location";
    /// The same atom again.
    pub const DUPLICATE: &str = "duplicate atom";
    /// Water.
    pub const WATER: &str = "water";
    /// Ligands, ions, sugars.
    pub const LIGAND: &str = "ligand";
    /// Nucleic acids.
    pub const NUCLEIC_ACID: &str = "nucleic acid";
    /// Hydrogen and deuterium.
    pub const HYDROGEN: &str = "hydrogen";
    /// Residues that lack atoms, where they are to be skipped.
    pub const INCOMPLETE: &str = "incomplete residue";
    /// Chains that are not part of the biological assembly.
    pub const ASSEMBLY: &str = "not in the assembly";
}

impl Structure {
    /// Selects one conformer of one model.
    ///
    /// # Errors
    /// [`BodyError::Invalid`] for a model, chain or assembly that the file does not have, an
    /// improper operator, nothing selected, and with [`MissingAtoms::Fail`] for the first
    /// incomplete residues.
    pub fn select(&self, settings: &SelectionSettings) -> Result<Selection> {
        let model = self.model(settings.model)?;
        check_chains(model, &settings.chains)?;
        let mut report = SelectionReport {
            model: model.number,
            models: self.models.len(),
            records: model.atoms.len(),
            assembly: settings.assembly.clone(),
            ..SelectionReport::default()
        };
        let mut residues = select_residues(&group(&model.atoms), settings, &mut report);
        if let Some(id) = &settings.assembly {
            residues = apply_assembly(residues, self.assembly(id)?, &mut report)?;
        }
        report_gaps(&mut residues, settings.missing, &mut report)?;
        completeness::mark_chain_ends(&mut residues, &self.header.unobserved);
        completeness::mark_disulfides(&mut residues);
        let chains: HashSet<&str> = residues
            .iter()
            .map(|residue| &*residue.source_chain)
            .collect();
        report.unobserved = self
            .header
            .unobserved
            .iter()
            .filter(|r| chains.contains(&*r.key.chain))
            .count();
        report.atoms = residues.iter().map(|residue| residue.atoms.len()).sum();
        let atoms = residues.iter().flat_map(|residue| &residue.atoms);
        report.zero_occupancy = atoms.filter(|atom| atom.occupancy <= 0.0).count();
        if residues.is_empty() {
            let skipped: Vec<String> = report
                .skipped
                .iter()
                .map(|(why, count)| format!("{count} {why}"))
                .collect();
            return Err(BodyError::Invalid {
                cause: format!(
                    "no atoms selected from {} ({})",
                    self.source,
                    skipped.join(", ")
                ),
                remedy: "keep ligands, waters or nucleic acids if they are what you want".into(),
            });
        }
        Ok(Selection { residues, report })
    }

    fn model(&self, number: Option<i32>) -> Result<&Model> {
        let found = match number {
            None => self.models.first(),
            Some(number) => self.models.iter().find(|model| model.number == number),
        };
        found.ok_or_else(|| {
            let numbers = listed(self.models.iter().map(|model| model.number.to_string()));
            BodyError::Invalid {
                cause: format!("no model {} in {}", number.unwrap_or(1), self.source),
                remedy: format!("the file has models {numbers}"),
            }
        })
    }

    fn assembly(&self, id: &str) -> Result<&BiologicalAssembly> {
        self.assemblies
            .iter()
            .find(|assembly| assembly.id == id)
            .ok_or_else(|| BodyError::Invalid {
                cause: format!("no biological assembly {id} in {}", self.source),
                remedy: match self.assemblies.as_slice() {
                    [] => "the file describes none".into(),
                    some => format!(
                        "the file describes {}",
                        listed(some.iter().map(|assembly| assembly.id.clone()))
                    ),
                },
            })
    }
}

/// The first few of a list, for a message.
fn listed(items: impl Iterator<Item = String>) -> String {
    const SHOWN: usize = 20;
    let all: Vec<String> = items.collect();
    let more = if all.len() > SHOWN {
        format!(" and {} more", all.len() - SHOWN)
    } else {
        String::new()
    };
    format!("{}{more}", all[..all.len().min(SHOWN)].join(", "))
}

fn check_chains(model: &Model, wanted: &[String]) -> Result<()> {
    if wanted.is_empty() {
        return Ok(());
    }
    let chains: BTreeSet<&str> = model.atoms.iter().map(|atom| &*atom.chain).collect();
    match wanted.iter().find(|chain| !chains.contains(chain.as_str())) {
        None => Ok(()),
        Some(chain) => Err(BodyError::Invalid {
            cause: format!("no chain {chain} in model {}", model.number),
            remedy: format!(
                "the model has chains {}",
                listed(chains.iter().map(|chain| format!("`{chain}`")))
            ),
        }),
    }
}

/// Conformers, classes and filters, residue by residue.
fn select_residues(
    groups: &[AtomGroup],
    settings: &SelectionSettings,
    report: &mut SelectionReport,
) -> Vec<SelectedResidue> {
    let wanted: HashSet<&str> = settings.chains.iter().map(String::as_str).collect();
    let mut residues = Vec::new();
    for (index, group) in groups.iter().enumerate() {
        if !wanted.is_empty() && !wanted.contains(&*group.key.chain) {
            *report.skipped.entry(reason::CHAIN).or_default() += group.atoms.len();
            continue;
        }
        let conformer = alternates::choose(&group.atoms, settings.alternate);
        count(report, reason::ALTERNATE, conformer.alternates);
        count(report, reason::DUPLICATE, conformer.duplicates);
        let class = ResidueClass::of(
            &conformer.name,
            &conformer.atoms,
            is_in_chain(groups, index),
        );
        let why_not = match class {
            ResidueClass::Water if !settings.keep_waters => Some(reason::WATER),
            ResidueClass::Ligand if !settings.keep_ligands => Some(reason::LIGAND),
            ResidueClass::Nucleotide if !settings.keep_nucleic_acids => Some(reason::NUCLEIC_ACID),
            _ => None,
        };
        if let Some(why_not) = why_not {
            count(report, why_not, conformer.atoms.len());
            *report
                .skipped_residues
                .entry(conformer.name.to_string())
                .or_default() += 1;
            continue;
        }
        list(report, &group.key, &conformer, class);
        let is_kept = |atom: &&&Atom| settings.keep_hydrogens || !atom.is_hydrogen();
        let mut atoms: Vec<Atom> = conformer
            .atoms
            .iter()
            .filter(is_kept)
            .map(|atom| (*atom).clone())
            .collect();
        atoms
            .iter_mut()
            .for_each(|atom| use_standard_name(atom, class.amino_acid()));
        count(
            report,
            reason::HYDROGEN,
            conformer.atoms.len() - atoms.len(),
        );
        if !atoms.is_empty() {
            report.repeated_numbers += usize::from(group.is_repeated);
            residues.push(SelectedResidue {
                key: group.key.clone(),
                source_chain: group.key.chain.clone(),
                name: conformer.name,
                class,
                atoms,
                n_terminus: false,
                c_terminus: false,
                in_disulfide: false,
                mutated_from: None,
            });
        }
    }
    residues
}

/// Simulation programs have names of their own for a few atoms; the tables know those of the
/// Protein Data Bank.
fn use_standard_name(atom: &mut Atom, amino_acid: Option<AminoAcid>) {
    let name = match (amino_acid, &*atom.name) {
        (Some(AminoAcid::Ile), "CD") => "CD1",
        (Some(_), "OT1" | "OC1") => "O",
        (Some(_), "OT2" | "OC2") => "OXT",
        _ => return,
    };
    atom.name = Arc::from(name);
}

pub(crate) fn count(report: &mut SelectionReport, why: &'static str, atoms: usize) {
    if atoms > 0 {
        *report.skipped.entry(why).or_default() += atoms;
    }
}

fn list(
    report: &mut SelectionReport,
    key: &ResidueKey,
    conformer: &Conformer,
    class: ResidueClass,
) {
    let entry = |note: String| ListedResidue {
        residue: key.clone(),
        name: conformer.name.clone(),
        note,
    };
    match class {
        ResidueClass::Modified(modified) => {
            let parent = modified.parent.map_or(String::new(), |parent| {
                format!(", counted as {}", parent.name())
            });
            report
                .modified
                .push(entry(format!("{}{parent}", modified.what)));
        }
        ResidueClass::UnknownAminoAcid => report.unknown.push(entry("kept as neutral".into())),
        _ => {}
    }
    if !conformer.other_names.is_empty() && class.is_protein() {
        let others: Vec<&str> = conformer.other_names.iter().map(|name| &**name).collect();
        report
            .microheterogeneous
            .push(entry(format!("chosen over {}", others.join(", "))));
    }
}

/// Whether the residue is bonded to a neighbour in the file as residues of a chain are (N-C or
/// O3'-P), or stands in the file as an ordinary ATOM.
fn is_in_chain(groups: &[AtomGroup], index: usize) -> bool {
    const BOND_ANGSTROM: f64 = 2.0;
    let group = &groups[index];
    let atom = |group: &AtomGroup, names: [&str; 2]| {
        group
            .atoms
            .iter()
            .find(|atom| names.contains(&&*atom.name))
            .map(|atom| atom.position)
    };
    let bonded = |before: &AtomGroup, after: &AtomGroup| {
        let pair =
            |end, start| Some((atom(before, end)? - atom(after, start)?).norm() < BOND_ANGSTROM);
        before.key.chain == after.key.chain
            && (pair(["C", "C3"], ["N", "N1"]) == Some(true)
                || pair(["O3'", "O3*"], ["P", "P"]) == Some(true))
    };
    let before = index.checked_sub(1).and_then(|i| groups.get(i));
    let after = groups.get(index + 1);
    group.atoms.iter().any(|atom| !atom.hetero)
        || before.is_some_and(|before| bonded(before, group))
        || after.is_some_and(|after| bonded(group, after))
}

/// Lists missing atoms and chain breaks, and does with them what is asked.
fn report_gaps(
    residues: &mut Vec<SelectedResidue>,
    missing: MissingAtoms,
    report: &mut SelectionReport,
) -> Result<()> {
    report.chain_breaks = completeness::chain_breaks(residues);
    for residue in residues.iter() {
        let missing_atoms = completeness::missing_atoms(residue);
        if !missing_atoms.is_empty() {
            let (key, name) = (residue.key.clone(), residue.name.clone());
            report.incomplete.push(IncompleteResidue {
                residue: key,
                name,
                missing_atoms,
            });
        }
    }
    match missing {
        MissingAtoms::Keep => {}
        MissingAtoms::Skip => {
            let before: usize = residues.iter().map(|residue| residue.atoms.len()).sum();
            residues.retain(|residue| completeness::missing_atoms(residue).is_empty());
            let after: usize = residues.iter().map(|residue| residue.atoms.len()).sum();
            count(report, reason::INCOMPLETE, before - after);
        }
        MissingAtoms::Fail => {
            let incomplete = report.incomplete.iter().map(|r| {
                format!(
                    "{} {} lacks {}",
                    r.name,
                    r.residue,
                    r.missing_atoms.join(" ")
                )
            });
            let breaks = report
                .chain_breaks
                .iter()
                .map(|gap| format!("chain break {} to {}", gap.before, gap.after));
            let all = listed(incomplete.chain(breaks));
            if !all.is_empty() {
                let remedy = "complete the structure, or keep or skip incomplete residues".into();
                return Err(BodyError::Invalid {
                    cause: format!("incomplete structure: {all}"),
                    remedy,
                });
            }
        }
    }
    Ok(())
}
