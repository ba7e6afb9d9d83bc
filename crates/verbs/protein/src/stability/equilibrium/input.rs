//! The assembly at each pH: from its file, or from the chains of structure files.

use super::StabilitySettings;
use crate::assemblies::assembly_file::Assembly;
use crate::assemblies::structure::{CopyShapes, StructureSettings, structure_in_memory};
use crate::bodies::chain_groups::ChainNames;
use crate::file_kind::FileKind;
use crate::stability::pair::protonations;
use anyhow::{Result, bail};
use protomer_body::BodySettings;
use protomer_io::atomic::sha256_hex;
use protomer_kernel::Boundary;
use std::path::{Path, PathBuf};

/// Most bodies of an assembly whose parts are sought.
const MOST_BODIES: usize = 240;

/// The bodies of an equilibrium at every pH and salt.
#[derive(Debug, Clone)]
pub struct StabilityBodies {
    /// SHA-256 of what the bodies are made of.
    pub sha256: String,
    /// Names of the placed bodies.
    pub names: Vec<String>,
    /// Warnings of the making of bodies.
    pub warnings: Vec<String>,
    /// Assemblies by pH: one for all salts, or one for each.
    assemblies: Vec<Vec<Assembly>>,
}

/// Choices with which structure files become bodies.
#[derive(Debug, Clone, Default)]
pub struct StructureChoices {
    /// Settings with which bodies are made.
    pub body: BodySettings,
    /// Chains that make up one body; the others are a body each.
    pub joined: Vec<ChainNames>,
}

impl StabilityBodies {
    /// Reads an assembly file, or structure files in one frame, whose chains are made into bodies at each pH.
    ///
    /// # Errors
    /// For a file that cannot be read, a single body, and a pH or a protonation for an assembly, whose charges
    /// are fixed.
    pub fn read(
        inputs: &[PathBuf],
        settings: &StabilitySettings,
        choices: &StructureChoices,
    ) -> Result<Self> {
        let bodies = match inputs {
            [file] if is_assembly(file) => Self::of_assembly(file, settings)?,
            _ => Self::of_structure(inputs, settings, choices)?,
        };
        let count = bodies.names.len();
        if count < 2 {
            bail!(
                "{} holds one body, and an equilibrium is that of several; give a structure with several chains, or \
                 the biological assembly with --assembly 1",
                inputs[0].display()
            );
        }
        if count > MOST_BODIES {
            bail!(
                "the assembly has {count} bodies, and parts of at most {MOST_BODIES} are sought; join chains with \
                 --body, such as the dimers of a capsid"
            );
        }
        Ok(bodies)
    }

    fn of_assembly(file: &Path, settings: &StabilitySettings) -> Result<Self> {
        if !settings.ph.is_empty() || settings.protonation.is_some() {
            bail!(
                "--ph and --protonation apply to structure files only, but {} has bodies, whose charges are fixed; \
                 give the structure, or ingest its bodies at this pH",
                file.display()
            );
        }
        let mut assembly = Assembly::read(file)?;
        // Parts are sought in open space; the concentration says how far they are from each other.
        assembly.boundary = Boundary::Open;
        let name = |(number, kind): (usize, &usize)| {
            format!("{} ({})", assembly.bodies[*kind].name, number + 1)
        };
        Ok(Self {
            sha256: assembly.sha256.clone(),
            names: assembly.kinds.iter().enumerate().map(name).collect(),
            warnings: Vec::new(),
            assemblies: vec![vec![assembly]],
        })
    }

    fn of_structure(
        inputs: &[PathBuf],
        settings: &StabilitySettings,
        choices: &StructureChoices,
    ) -> Result<Self> {
        let (mut assemblies, mut warnings, mut names) = (Vec::new(), Vec::new(), Vec::new());
        let mut hashes = String::new();
        for ph in settings.ph_values() {
            let mut at_salts = Vec::new();
            let kelvin = settings.medium.temperature_kelvin;
            let protonations = protonations(settings.protonation, &settings.salt_molar, kelvin);
            for protonation in protonations {
                let mut body = choices.body.clone();
                body.sites.ph = ph.unwrap_or(body.sites.ph);
                body.sites.structure = protonation;
                let made = structure_in_memory(
                    inputs,
                    &StructureSettings {
                        body,
                        joined: choices.joined.clone(),
                        shapes: CopyShapes::Fitting,
                        relax: false,
                        box_angstrom: None,
                        force: false,
                    },
                )?;
                hashes += &made.assembly.sha256;
                warnings.extend(made.warnings);
                names = made.names;
                at_salts.push(made.assembly);
            }
            assemblies.push(at_salts);
        }
        // Once for all pH values and salts.
        warnings.sort();
        warnings.dedup();
        Ok(Self {
            sha256: sha256_hex(hashes.as_bytes()),
            names,
            warnings,
            assemblies,
        })
    }

    /// The assembly at a pH and a salt, by their numbers.
    pub(super) fn assembly(&self, ph: usize, salt: usize) -> &Assembly {
        let at_salts = &self.assemblies[ph];
        // One serves all salts unless its charges depend on them.
        &at_salts[salt.min(at_salts.len() - 1)]
    }

    /// The assembly at the first pH and salt.
    pub fn first(&self) -> &Assembly {
        self.assembly(0, 0)
    }
}

fn is_assembly(file: &Path) -> bool {
    matches!(FileKind::from_path(file), Some(FileKind::Assembly))
}
