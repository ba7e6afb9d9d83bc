//! Selects the part of a structure that becomes a body, and counts the rest.

use super::alternates::{self, Conformer};
use super::assembled::apply_assembly;
use super::biological_assembly::BiologicalAssembly;
use super::classes::ResidueClass;
use super::completeness;
use super::contents::{Atom, Model, Structure, UnobservedResidue};
use super::disulfides::mark_disulfides;
use super::ends::mark_chain_ends;
use super::messages::listed;
use super::report::{ListedResidue, SelectionReport, reason};
use super::residues::{AtomGroup, group, in_chain};
use super::selected::{SelectedResidue, Selection, atom_count};
use crate::chemistry::AminoAcid;
use crate::chemistry::treatment;
use crate::{BodyError, Result};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeSet, HashSet};
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
    /// Refuse the structure, also for chain breaks.
    Fail,
}

/// Which part of a structure becomes a body.
///
/// The default: first model, every chain, deposited coordinates, highest occupancy; no ligands,
/// waters, hydrogens or nucleic acids; incomplete residues as they are.
///
/// ```
/// use protomer_body::structure::{MissingAtoms, SelectionSettings};
/// let settings = SelectionSettings {
///     chains: vec!["A".into()],
///     missing: MissingAtoms::Fail,
///     ..SelectionSettings::default()
/// };
/// assert!(!settings.keep_waters);
/// ```
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

impl Structure {
    /// Selects one conformer of one model, and decides which residues are charged as ends of chains
    /// and which cysteines are bonded.
    ///
    /// ```
    /// use protomer_body::structure::{SelectionSettings, Structure};
    /// let text = "\
    /// ATOM      1  N   LYS A   1      11.104   6.134  -6.504  1.00 10.00           N
    /// ATOM      2  CA  LYS A   1      11.639   6.071  -5.147  1.00 10.00           C";
    /// let structure = Structure::read("lysine.pdb", text.as_bytes())?;
    /// let selection = structure.select(&SelectionSettings::default())?;
    /// assert!(selection.residues[0].n_terminus);
    /// assert_eq!(selection.report.incomplete[0].missing_atoms[..2], ["C", "O"]);
    /// # Ok::<(), protomer_body::BodyError>(())
    /// ```
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
        let mut residues = select_residues(model, settings, &mut report);
        // Ends are those of the chains in the file, before anything is left out or copied.
        report.blocked_ends = mark_chain_ends(&mut residues, &self.header.unobserved, &model.atoms);
        if let Some(id) = &settings.assembly {
            residues = apply_assembly(residues, self.assembly(id)?, &mut report)?;
        }
        treat_gaps(&mut residues, settings.missing, &mut report)?;
        report.disulfides = mark_disulfides(&mut residues, &self.disulfides);
        count_rest(&residues, &self.header.unobserved, &mut report);
        if residues.is_empty() {
            return Err(nothing_selected(&self.source, &report));
        }
        Ok(Selection { residues, report })
    }

    fn model(&self, number: Option<i32>) -> Result<&Model> {
        let found = match number {
            None => self.models.first(),
            Some(number) => self.models.iter().find(|model| model.number == number),
        };
        if let Some(model) = found {
            return Ok(model);
        }
        let mut numbers = Vec::new();
        for model in &self.models {
            numbers.push(model.number.to_string());
        }
        Err(BodyError::Invalid {
            cause: format!("no model {} in {}", number.unwrap_or(1), self.source),
            remedy: format!("the file has models {}", listed(&numbers)),
        })
    }

    fn assembly(&self, id: &str) -> Result<&BiologicalAssembly> {
        let mut known = Vec::new();
        for assembly in &self.assemblies {
            if assembly.id == id {
                return Ok(assembly);
            }
            known.push(assembly.id.clone());
        }
        Err(BodyError::Invalid {
            cause: format!("no biological assembly {id} in {}", self.source),
            remedy: if known.is_empty() {
                "the file describes none".into()
            } else {
                format!("the file describes {}", listed(&known))
            },
        })
    }
}

fn check_chains(model: &Model, wanted: &[String]) -> Result<()> {
    if wanted.is_empty() {
        return Ok(());
    }
    let chains: BTreeSet<&str> = model.atoms.iter().map(|atom| &*atom.chain).collect();
    for chain in wanted {
        if !chains.contains(chain.as_str()) {
            let known: Vec<String> = chains.iter().map(|chain| format!("`{chain}`")).collect();
            return Err(BodyError::Invalid {
                cause: format!("no chain {chain} in model {}", model.number),
                remedy: format!("the model has chains {}", listed(&known)),
            });
        }
    }
    Ok(())
}

/// Conformers, classes and filters, residue by residue.
fn select_residues(
    model: &Model,
    settings: &SelectionSettings,
    report: &mut SelectionReport,
) -> Vec<SelectedResidue> {
    let wanted: HashSet<&str> = settings.chains.iter().map(String::as_str).collect();
    let groups = group(&model.atoms);
    let in_chain = in_chain(&groups);
    let mut residues = Vec::new();
    for (group, is_in_chain) in groups.iter().zip(in_chain) {
        if !wanted.is_empty() && !wanted.contains(&*group.key.chain) {
            report.skip(reason::CHAIN, group.atoms.len());
            continue;
        }
        let conformer = alternates::choose(&group.atoms, settings.alternate);
        report.skip(reason::ALTERNATE, conformer.alternates);
        report.skip(reason::DUPLICATE, conformer.duplicates);
        let class = ResidueClass::of(&conformer.name, &conformer.atoms, is_in_chain);
        if let Some(why_not) = why_not(class, settings) {
            report.skip(why_not, conformer.atoms.len());
            let name = conformer.name.to_string();
            *report.skipped_residues.entry(name).or_default() += 1;
            continue;
        }
        let atoms = kept_atoms(&conformer, class, settings.keep_hydrogens);
        report.skip(reason::HYDROGEN, conformer.atoms.len() - atoms.len());
        let residue = selected(group, &conformer, class, atoms);
        list(report, &residue, &conformer);
        if !residue.atoms.is_empty() {
            report.repeated_numbers += usize::from(group.is_repeated);
            residues.push(residue);
        }
    }
    residues
}

/// Why residues of this class are left out; `None` if they are kept.
fn why_not(class: ResidueClass, settings: &SelectionSettings) -> Option<&'static str> {
    match class {
        ResidueClass::Water if !settings.keep_waters => Some(reason::WATER),
        ResidueClass::Ligand if !settings.keep_ligands => Some(reason::LIGAND),
        ResidueClass::Nucleotide if !settings.keep_nucleic_acids => Some(reason::NUCLEIC_ACID),
        _ => None,
    }
}

/// The atoms of a conformer under the names used in the tables, without hydrogens unless they are
/// kept.
fn kept_atoms(conformer: &Conformer, class: ResidueClass, keep_hydrogens: bool) -> Vec<Atom> {
    let amino_acid = class.amino_acid();
    let mut atoms = Vec::with_capacity(conformer.atoms.len());
    for &atom in &conformer.atoms {
        if keep_hydrogens || !atom.is_hydrogen() {
            let mut atom = atom.clone();
            use_standard_name(&mut atom, amino_acid);
            atoms.push(atom);
        }
    }
    atoms
}

/// The Protein Data Bank's name of an atom: simulation programs have their own for a few atoms.
fn use_standard_name(atom: &mut Atom, amino_acid: Option<AminoAcid>) {
    let name = match (amino_acid, &*atom.name) {
        (Some(AminoAcid::Ile), "CD") => "CD1",
        (Some(_), "OT1" | "OC1") => "O",
        (Some(_), "OT2" | "OC2") => "OXT",
        _ => return,
    };
    atom.name = Arc::from(name);
}

fn selected(
    group: &AtomGroup,
    conformer: &Conformer,
    class: ResidueClass,
    atoms: Vec<Atom>,
) -> SelectedResidue {
    SelectedResidue {
        key: group.key.clone(),
        source_chain: group.key.chain.clone(),
        name: conformer.name.clone(),
        class,
        atoms,
        n_terminus: false,
        c_terminus: false,
        in_disulfide: false,
        mutated_from: None,
    }
}

/// Lists a residue that is not one of the twenty, or that shares its place with another.
fn list(report: &mut SelectionReport, residue: &SelectedResidue, conformer: &Conformer) {
    let entry = |note: String| ListedResidue {
        residue: residue.key.clone(),
        name: residue.name.clone(),
        note,
        charge_e: None,
    };
    let treatment = entry(treatment::describe(residue));
    match residue.class {
        ResidueClass::Modified(_) => report.modified.push(treatment),
        ResidueClass::LikeAminoAcid(_) | ResidueClass::UnknownAminoAcid => {
            report.unknown.push(treatment);
        }
        ResidueClass::Ligand => report.ligands.push(treatment),
        _ => {}
    }
    if !conformer.other_names.is_empty() && residue.class.is_protein() {
        let others: Vec<&str> = conformer.other_names.iter().map(|name| &**name).collect();
        let chosen = entry(format!("chosen over {}", others.join(", ")));
        report.microheterogeneous.push(chosen);
    }
}

/// Lists missing atoms and chain breaks, and does what `missing` says.
fn treat_gaps(
    residues: &mut Vec<SelectedResidue>,
    missing: MissingAtoms,
    report: &mut SelectionReport,
) -> Result<()> {
    report.chain_breaks = completeness::chain_breaks(residues);
    report.incomplete = completeness::incomplete_residues(residues);
    match missing {
        MissingAtoms::Keep => Ok(()),
        MissingAtoms::Skip => {
            let before = atom_count(residues);
            residues.retain(|residue| completeness::missing_atoms(residue).is_empty());
            report.skip(reason::INCOMPLETE, before - atom_count(residues));
            Ok(())
        }
        MissingAtoms::Fail => refuse_gaps(report),
    }
}

fn refuse_gaps(report: &SelectionReport) -> Result<()> {
    let mut gaps = Vec::new();
    for residue in &report.incomplete {
        let missing = residue.missing_atoms.join(" ");
        gaps.push(format!(
            "{} {} lacks {missing}",
            residue.name, residue.residue
        ));
    }
    for gap in &report.chain_breaks {
        gaps.push(format!("chain break {} to {}", gap.before, gap.after));
    }
    if gaps.is_empty() {
        return Ok(());
    }
    Err(BodyError::Invalid {
        cause: format!("incomplete structure: {}", listed(&gaps)),
        remedy: "complete the structure, or keep or skip incomplete residues".into(),
    })
}

/// Counts atoms, unobserved residues and atoms of zero occupancy.
fn count_rest(
    residues: &[SelectedResidue],
    unobserved: &[UnobservedResidue],
    report: &mut SelectionReport,
) {
    let mut chains: HashSet<&str> = HashSet::new();
    for residue in residues {
        chains.insert(&residue.source_chain);
        for atom in &residue.atoms {
            report.zero_occupancy += usize::from(atom.occupancy <= 0.0);
        }
    }
    for residue in unobserved {
        report.unobserved += usize::from(chains.contains(&*residue.key.chain));
    }
    report.atoms = atom_count(residues);
}

fn nothing_selected(source: &str, report: &SelectionReport) -> BodyError {
    let mut skipped = Vec::new();
    for (why, count) in &report.skipped {
        skipped.push(format!("{count} {why}"));
    }
    BodyError::Invalid {
        cause: format!("no atoms selected from {source} ({})", skipped.join(", ")),
        remedy: "keep ligands, waters or nucleic acids if they are what you want".into(),
    }
}
