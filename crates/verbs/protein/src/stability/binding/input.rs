//! Two bodies in one frame: from two files, or from the chains of one.

use super::settings::BindingSettings;
use crate::bodies::body_file;
use crate::bodies::chain_groups::{ChainGroup, ChainNames, chains_of, stated_groups, ungrouped};
use crate::bodies::ingest::read_and_build;
use anyhow::{Context, Result, bail};
use protomer_body::structure::{Format, IncompleteResidue, Selection, Structure};
use protomer_body::{Body, BodySettings, Draft, Source, structure_warnings};
use protomer_common::input::{InputFile, stem};
use protomer_field::ChargedSphere;
use protomer_field::titration::SolvedProtonation;
use protomer_kernel::{Pose, Vec3};
use std::path::Path;
use std::sync::Arc;

/// The two bodies before they are charged.
pub(in crate::stability) struct Inputs {
    pub(super) inputs: [Input; 2],
    settings: BodySettings,
    /// The pH values; `None` for the charges of the files.
    pub ph: Vec<Option<f64>>,
    /// Warnings about the files.
    pub warnings: Vec<String>,
}

/// One body before it is charged.
pub(super) struct Input {
    name: String,
    pub(super) file: String,
    pub(super) content: Content,
}

/// Source of the charges of a body.
pub(super) enum Content {
    /// Residues of a structure file, with its hash.
    Residues(Box<Selection>, String),
    /// A body file or a PQR file, with its own charges.
    Charged(Arc<Body>),
}

/// Shortcomings of the files of both bodies.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(in crate::stability) struct FileQuality {
    /// Residues that lack heavy atoms.
    pub incomplete_residues: usize,
    /// Breaks of chains.
    pub chain_breaks: usize,
    /// Residues of a predicted model that may be anywhere.
    pub residues_of_low_confidence: usize,
}

/// The two bodies at one pH.
pub(in crate::stability) struct Partners {
    pub bodies: [Arc<Body>; 2],
    /// Residues that lack atoms, of the files.
    pub incomplete: [Vec<IncompleteResidue>; 2],
    /// The files.
    pub files: [String; 2],
}

/// A file that was read.
enum File {
    Structure {
        input: InputFile,
        selection: Box<Selection>,
    },
    Charged(Arc<Body>, String),
}

impl Inputs {
    /// Reads the files and finds the two bodies.
    ///
    /// # Errors
    /// For a file that cannot be read, other than two bodies, and a pH for charges that are fixed.
    pub fn read(settings: &BindingSettings) -> Result<Self> {
        let paths: Vec<&Path> = std::iter::once(settings.receptor.as_path())
            .chain(settings.ligand.as_deref())
            .collect();
        let mut body = BodySettings {
            selection: settings.selection.clone(),
            ..settings.model.body_settings()
        };
        body.sites.structure = settings.protonation();
        let (mut files, mut warnings) = (Vec::new(), Vec::new());
        for path in &paths {
            files.push(read_file(path, &body, &mut warnings)?);
        }
        let groups = groups(&files, settings, &mut warnings)?;
        let names = names(&paths, &groups);
        let input =
            |number: usize| files[groups[number].file].input(&groups[number], &names[number]);
        let mut inputs = [input(0), input(1)];
        if let Some(motion) = &settings.ligand_motion {
            inputs[1].move_by(motion);
        }
        Ok(Self {
            ph: ph_values(settings, &inputs, &body)?,
            inputs,
            settings: body,
            warnings,
        })
    }

    /// The pH at which structure files are charged where none is stated.
    pub fn usual_ph(&self) -> f64 {
        self.settings.sites.ph
    }

    /// Shortcomings of the files of both bodies.
    pub fn quality(&self) -> FileQuality {
        let (mut quality, mut met) = (FileQuality::default(), None);
        for input in &self.inputs {
            if let Content::Residues(selection, sha256) = &input.content {
                // A report is that of the whole file, which both bodies may come from.
                if met.replace(sha256) == Some(sha256) {
                    continue;
                }
                let report = &selection.report;
                quality.incomplete_residues += report.incomplete.len();
                quality.chain_breaks += report.chain_breaks.len();
                let low = report.low_confidence.iter().map(|range| range.residues);
                quality.residues_of_low_confidence += low.sum::<usize>();
            }
        }
        quality
    }

    /// The bodies at one pH.
    ///
    /// # Errors
    /// Names the file of a body that cannot be made.
    pub fn partners(&self, ph: Option<f64>) -> Result<Partners> {
        let [first, second] = &self.inputs;
        Ok(Partners {
            bodies: [
                first.body(ph, &self.settings)?,
                second.body(ph, &self.settings)?,
            ],
            incomplete: [first.incomplete(), second.incomplete()],
            files: [first.file.clone(), second.file.clone()],
        })
    }
}

impl Partners {
    /// Atoms in the frame of the files.
    pub fn spheres(&self) -> [Vec<ChargedSphere>; 2] {
        self.bodies.each_ref().map(|body| {
            let sites = body.sites.iter().map(|site| ChargedSphere {
                centre: in_frame(body, &site.position),
                radius_angstrom: site.radius_angstrom,
                charge_e: site.charge_e,
            });
            sites.collect()
        })
    }
}

/// A place of a body in the frame of its file, Å.
pub(in crate::stability) fn in_frame(body: &Body, place: &Vec3) -> Vec3 {
    place + body.provenance.origin_angstrom
}

impl Input {
    /// Moves the residues of a structure file.
    fn move_by(&mut self, motion: &Pose) {
        self.name += "-copy";
        if let Content::Residues(selection, _) = &mut self.content {
            let residues = selection.residues.iter_mut();
            for atom in residues.flat_map(|residue| &mut residue.atoms) {
                atom.position = motion.transform_point(&atom.position);
            }
        }
    }

    fn body(&self, ph: Option<f64>, settings: &BodySettings) -> Result<Arc<Body>> {
        let (selection, sha256) = match &self.content {
            Content::Charged(body) => return Ok(Arc::clone(body)),
            Content::Residues(selection, sha256) => (selection, sha256),
        };
        let mut settings = settings.clone();
        settings.sites.ph = ph.unwrap_or(settings.sites.ph);
        let source = Source {
            file: &self.file,
            sha256,
        };
        let selection = (**selection).clone();
        let solved = &SolvedProtonation;
        let name = &self.name;
        let built = Draft::of_protonated_selection(name, source, selection, &settings, solved)
            .and_then(Draft::build);
        Ok(Arc::new(built.with_context(|| self.file.clone())?.body))
    }

    fn incomplete(&self) -> Vec<IncompleteResidue> {
        match &self.content {
            Content::Residues(selection, _) => selection.report.incomplete.clone(),
            Content::Charged(_) => Vec::new(),
        }
    }
}

fn read_file(path: &Path, settings: &BodySettings, warnings: &mut Vec<String>) -> Result<File> {
    let named = |warning: &String| format!("warning: {}: {warning}", path.display());
    if path.extension().is_some_and(|ending| ending == "body") {
        let (body, _) = body_file::read(path)?;
        return Ok(File::Charged(Arc::new(body), path.display().to_string()));
    }
    let input = InputFile::read(path)?;
    if Format::of_file(&input.name, &input.bytes)? == Format::Pqr {
        let built = read_and_build(path, &stem(path), settings)?;
        warnings.extend(built.warnings.iter().map(named));
        return Ok(File::Charged(Arc::new(built.body), input.name));
    }
    let structure = Structure::read(&input.name, &input.bytes)?;
    let selection = structure
        .select(&settings.selection)
        .with_context(|| input.name.clone())?;
    let of_file = structure_warnings(&structure, &selection.report);
    warnings.extend(of_file.iter().map(named));
    Ok(File::Structure {
        input,
        selection: Box::new(selection),
    })
}

impl File {
    /// Names of the chains of the file.
    fn chains(&self) -> Vec<String> {
        match self {
            File::Structure { selection, .. } => chains_of(selection),
            File::Charged(body, _) => {
                let mut chains: Vec<String> = Vec::new();
                for residue in &body.residues {
                    if !chains.contains(&residue.chain) {
                        chains.push(residue.chain.clone());
                    }
                }
                chains
            }
        }
    }

    /// A body of some chains of the file.
    fn input(&self, group: &ChainGroup, name: &str) -> Input {
        let name = name.to_owned();
        match self {
            File::Structure { input, selection } => {
                let selection = selection.only_chains(&group.chains);
                Input {
                    name,
                    file: input.name.clone(),
                    content: Content::Residues(Box::new(selection), input.sha256.clone()),
                }
            }
            File::Charged(body, file) => Input {
                name,
                file: file.clone(),
                content: Content::Charged(Arc::clone(body)),
            },
        }
    }
}

/// The chains of the two bodies.
fn groups(
    files: &[File],
    settings: &BindingSettings,
    warnings: &mut Vec<String>,
) -> Result<Vec<ChainGroup>> {
    let chains: Vec<Vec<String>> = files.iter().map(File::chains).collect();
    let whole = |file: usize| ChainGroup {
        file,
        chains: chains[file].clone(),
    };
    let stated = &settings.bodies;
    if settings.ligand_motion.is_some() {
        // A chain and its own copy are two bodies.
        let group = |names: &ChainNames| ChainGroup {
            file: 0,
            chains: names.0.clone(),
        };
        return Ok(stated.iter().map(group).collect());
    }
    if stated.is_empty() {
        return match (files, chains[0].as_slice()) {
            ([_, _], _) => Ok(vec![whole(0), whole(1)]),
            ([File::Structure { .. }], [first, second]) => Ok([first, second]
                .map(|chain| ChainGroup {
                    file: 0,
                    chains: vec![chain.clone()],
                })
                .to_vec()),
            (_, chains) => Err(unclear(chains)),
        };
    }
    if files.iter().any(|file| matches!(file, File::Charged(..))) {
        bail!(
            "--body names chains of structure files; leave it out: a PQR or body file is one body"
        );
    }
    if stated.len() != 2 {
        bail!(
            "binding is that of two bodies, and --body states {}; give it twice, such as --body H,L --body A",
            stated.len()
        );
    }
    let groups = stated_groups(stated, &chains)?;
    let ungrouped_chains: Vec<String> = ungrouped(&groups, &chains)
        .into_iter()
        .map(|(_, chain)| chain)
        .collect();
    if !ungrouped_chains.is_empty() {
        warnings.push(match &*ungrouped_chains {
            [chain] => format!("warning: chain {chain} belongs to no body and is left out"),
            chains => format!(
                "warning: chains {} belong to no body and are left out",
                chains.join(", ")
            ),
        });
    }
    Ok(groups)
}

/// Error for one file whose chains do not say which two bodies are meant.
fn unclear(chains: &[String]) -> anyhow::Error {
    match chains {
        [] | [_] => anyhow::anyhow!(
            "this is one body, and binding is that of two; give the ligand as the second file, or the \
             biological assembly with --assembly 1"
        ),
        [first, .., last] => anyhow::anyhow!(
            "the file has the chains {}; say which make up each body, such as --body {first} --body {last}",
            chains.join(", ")
        ),
    }
}

/// Names of the bodies: that of the file, with the chains where both are from one.
fn names(paths: &[&Path], groups: &[ChainGroup]) -> Vec<String> {
    let name = |group: &ChainGroup| {
        let stem = stem(paths[group.file]);
        match paths.len() {
            1 => format!("{stem}_{}", group.chains.concat()),
            _ => stem,
        }
    };
    groups.iter().map(name).collect()
}

fn ph_values(
    settings: &BindingSettings,
    inputs: &[Input; 2],
    body: &BodySettings,
) -> Result<Vec<Option<f64>>> {
    let is_fixed = |input: &Input| matches!(input.content, Content::Charged(_));
    if inputs.iter().all(is_fixed) {
        if !settings.ph.is_empty() {
            bail!(
                "--ph applies to structure files only, but {} and {} have charges of their own; give the \
                 structure files",
                inputs[0].file,
                inputs[1].file
            );
        }
        return Ok(vec![None]);
    }
    if settings.ph.is_empty() {
        return Ok(vec![Some(body.sites.ph)]);
    }
    Ok(settings.ph.iter().copied().map(Some).collect())
}
