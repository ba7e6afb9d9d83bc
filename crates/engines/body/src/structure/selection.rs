//! Selects the part of a structure that becomes a body, and counts the rest.

use super::alternates::{self, Conformer};
use super::assembled::apply_assembly;
use super::biological_assembly::BiologicalAssembly;
use super::classes::ResidueClass;
use super::completeness;
use super::confidence::low_confidence;
use super::contents::{Atom, Model, Structure, UnobservedResidue};
use super::disulfides::mark_disulfides;
use super::ends::mark_chain_ends;
use super::links::Links;
use super::messages::listed;
use super::records::{Sifted, exact, sift};
use super::report::{ListedResidue, SelectionReport, reason};
use super::residue_key::ResidueKey;
use super::residue_range::{ResidueRange, keep_ranges};
use super::residues::{AtomGroup, group};
use super::scale;
use super::selected::{SelectedResidue, Selection, atom_count};
use super::strands::{Placed, Strands};
use crate::chemistry::AminoAcid;
use crate::chemistry::{residue_names, treatment};
use crate::{BodyError, Result};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeSet, HashSet};
use std::sync::Arc;

protomer_kernel::choices! {
    /// Treatment of residues that lack heavy atoms.
    pub enum MissingAtoms, default Keep {
        /// Keep the residue as it is.
        Keep = "keep",
        /// Leave the residue out.
        Skip = "skip",
        /// Refuse the structure, also for chain breaks.
        Fail = "fail",
    }
}

/// Selection of the part of a structure that becomes a body.
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
    /// Ranges of residues of the chains that they name; empty for whole chains.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub residues: Vec<ResidueRange>,
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
    /// Treatment of residues that lack heavy atoms.
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
    /// incomplete residues; [`BodyError::Parse`] for coordinates in another unit than Å.
    pub fn select(&self, settings: &SelectionSettings) -> Result<Selection> {
        let model = self.model(settings.model)?;
        let mut report = SelectionReport {
            model: model.number,
            models: self.models.len(),
            is_model_chosen: settings.model.is_some(),
            records: model.atoms.len(),
            assembly: settings.assembly.clone(),
            ..SelectionReport::default()
        };
        let sifted = sift(&model.atoms, &mut report);
        let mut residues = select_residues(&sifted, settings, &mut report)?;
        scale::check(&self.source, &residues)?;
        // Ends are those of the chains in the file, before anything is left out or copied.
        let unobserved = &self.header.unobserved;
        report.blocked_ends = mark_chain_ends(&mut residues, unobserved, &sifted.atoms);
        residues = keep_ranges(residues, &settings.residues, &mut report)?;
        if let Some(id) = &settings.assembly {
            residues = apply_assembly(residues, self.assembly(id)?, &mut report)?;
        }
        treat_gaps(&mut residues, settings.missing, &mut report)?;
        report.disulfides = mark_disulfides(&mut residues, &self.disulfides);
        count_rest(&residues, &self.header.unobserved, &mut report);
        report.low_confidence = low_confidence(&self.header, &residues);
        if residues.is_empty() {
            return Err(nothing_selected(&self.source, &report));
        }
        Ok(Selection { residues, report })
    }

    fn model(&self, number: Option<i32>) -> Result<&Model> {
        let choice = match number {
            None => self.models.first(),
            Some(number) => self.models.iter().find(|model| model.number == number),
        };
        if let Some(model) = choice {
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
        let mut ids = Vec::new();
        for assembly in &self.assemblies {
            if assembly.id == id {
                return Ok(assembly);
            }
            ids.push(assembly.id.clone());
        }
        Err(BodyError::Invalid {
            cause: format!("no biological assembly {id} in {}", self.source),
            remedy: if ids.is_empty() {
                "the file describes none".into()
            } else {
                format!("the file describes {}", listed(&ids))
            },
        })
    }
}

/// The chains that the user named, by their names in the file or by those given to them here.
struct WantedChains<'s>(HashSet<&'s str>);

impl<'s> WantedChains<'s> {
    fn new(
        names: &'s [String],
        model: i32,
        drafts: &[Placed],
        keys: &[ResidueKey],
    ) -> Result<Self> {
        let mut chains: BTreeSet<&str> = keys.iter().map(|key| &*key.chain).collect();
        let of_file = drafts.iter().map(|draft| &*draft.group.key.chain);
        let is_known = |name: &str| {
            chains.contains(name) || drafts.iter().any(|draft| *draft.group.key.chain == *name)
        };
        let absent = names.iter().find(|name| !is_known(name));
        if let Some(chain) = absent {
            chains.extend(of_file);
            let chain_names: Vec<String> =
                chains.iter().map(|chain| format!("`{chain}`")).collect();
            return Err(BodyError::Invalid {
                cause: format!("no chain {chain} in model {model}"),
                remedy: format!("the model has chains {}", listed(&chain_names)),
            });
        }
        Ok(Self(names.iter().map(String::as_str).collect()))
    }

    fn has(&self, key: &ResidueKey, in_file: &ResidueKey) -> bool {
        let has = |chain: &str| self.0.contains(chain);
        self.0.is_empty() || has(&key.chain) || has(&in_file.chain)
    }
}

/// Derives the residues of a model from its atoms: finds the atoms of each residue, its chain,
/// conformer and class, and whether it is kept.
fn select_residues(
    sifted: &Sifted,
    settings: &SelectionSettings,
    report: &mut SelectionReport,
) -> Result<Vec<SelectedResidue>> {
    let groups = group(&sifted.atoms);
    let links = Links::from_groups(&groups);
    let mut conformers: Vec<Conformer> = groups
        .iter()
        .map(|group| alternates::choose(group, settings.alternate))
        .collect();
    if sifted.has_coincidences {
        leave_out_coincident(&mut conformers, report);
    }
    let mut drafts = Vec::with_capacity(groups.len());
    let mut drafted = Vec::with_capacity(groups.len());
    for &index in &links.order {
        let conformer = &conformers[index];
        report.skip(reason::ALTERNATE, conformer.alternates);
        report.skip(reason::DUPLICATE, conformer.duplicates);
        if conformer.atoms.is_empty() {
            continue;
        }
        let is_in_chain = links.in_chain[index];
        drafts.push(Placed {
            group: &groups[index],
            class: ResidueClass::classify(&conformer.name, &conformer.atoms, is_in_chain),
            host: links.host[index].map(|host| &groups[host]),
        });
        drafted.push(conformer);
    }
    let strands = Strands::from_residues(&drafts);
    let wanted = WantedChains::new(&settings.chains, report.model, &drafts, &strands.keys)?;
    report.corrections.extend(strands.notes);
    let mut residues = Vec::new();
    for (place, (draft, key)) in drafts.iter().zip(strands.keys).enumerate() {
        let conformer = drafted[place];
        if !wanted.has(&key, &draft.group.key) {
            report.skip(reason::CHAIN, conformer.atoms.len());
            continue;
        }
        let identity = Identity {
            key,
            strand: strands.strand[place],
        };
        residues.extend(select_residue(draft, conformer, identity, settings, report));
    }
    Ok(residues)
}

/// Leaves out atoms that are exactly where an earlier one is, in whatever residue.
fn leave_out_coincident(conformers: &mut [Conformer], report: &mut SelectionReport) {
    let mut taken = HashSet::new();
    for conformer in conformers {
        conformer.atoms.retain(|atom| {
            let is_free = taken.insert(exact(&atom.position));
            if !is_free {
                report.leave_out(reason::COINCIDENT, atom);
            }
            is_free
        });
    }
}

/// Key and strand of a residue.
struct Identity {
    key: ResidueKey,
    strand: Option<usize>,
}

/// One residue, with everything that is left out of it counted; `None` if it is left out.
fn select_residue(
    draft: &Placed,
    conformer: &Conformer,
    identity: Identity,
    settings: &SelectionSettings,
    report: &mut SelectionReport,
) -> Option<SelectedResidue> {
    if let Some(why_not) = why_not(draft.class, settings) {
        let chain = &identity.key.chain;
        report.skip_residue(why_not, &conformer.name, chain, conformer.atoms.len());
        return None;
    }
    let atoms = kept_atoms(conformer, draft.class, settings.keep_hydrogens);
    report.skip(reason::HYDROGEN, conformer.atoms.len() - atoms.len());
    let mut residue = selected(draft, conformer, identity, atoms);
    list(report, &residue, conformer, draft.group);
    if residue.atoms.is_empty() {
        return None;
    }
    if let Some(name) = name_by_atoms(&residue) {
        residue.name = name;
    }
    Some(residue)
}

/// The name of a residue whose own name its atoms contradict.
fn name_by_atoms(residue: &SelectedResidue) -> Option<Arc<str>> {
    let ResidueClass::LikeAminoAcid(amino_acid) = residue.class else {
        return None;
    };
    residue_names::is_polymer(&residue.name).then(|| Arc::from(amino_acid.name()))
}

/// Reason to leave out residues of this class; `None` if they are kept.
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
    draft: &Placed,
    conformer: &Conformer,
    identity: Identity,
    atoms: Vec<Atom>,
) -> SelectedResidue {
    let in_file = &draft.group.key;
    SelectedResidue {
        key: identity.key,
        source_chain: in_file.chain.clone(),
        source_number: in_file.number,
        strand: identity.strand,
        name: conformer.name.clone(),
        class: draft.class,
        atoms,
        n_terminus: false,
        c_terminus: false,
        in_disulfide: false,
        mutated_from: None,
    }
}

/// Lists a residue that is not one of the twenty, or that shares its place with another.
fn list(
    report: &mut SelectionReport,
    residue: &SelectedResidue,
    conformer: &Conformer,
    group: &AtomGroup,
) {
    let entry = |note: String| ListedResidue {
        residue: residue.key.clone(),
        name: residue.name.clone(),
        note,
        charge_e: None,
    };
    let treatment = entry(treatment::describe(residue));
    match residue.class {
        ResidueClass::Modified(_) => report.modified.push(treatment),
        ResidueClass::AminoAcid(amino_acid) if *residue.name != *amino_acid.name() => {
            report.modified.push(treatment);
        }
        ResidueClass::LikeAminoAcid(_) | ResidueClass::UnknownAminoAcid => {
            report.unknown.push(treatment);
        }
        ResidueClass::Ligand => report.ligands.push(treatment),
        _ => {}
    }
    if !group.fragments.is_empty() {
        let names: Vec<String> = group
            .fragments
            .iter()
            .map(|name| name.to_string())
            .collect();
        let (name, key, names) = (&residue.name, &residue.key, names.join(", "));
        report.corrections.push(format!(
            "{name} {key}: the file has a part of its atoms under the name {names}; they are one residue"
        ));
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
    let mut keys: HashSet<&ResidueKey> = HashSet::with_capacity(residues.len());
    for residue in residues {
        chains.insert(&residue.source_chain);
        report.repeated_numbers += usize::from(!keys.insert(&residue.key));
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
