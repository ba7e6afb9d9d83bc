//! What is asked.

use crate::export::Viewer;
use crate::stability::run::RunSettings;
use anyhow::{Result, bail};
use std::path::PathBuf;

/// Settings of [`residues`](super::residues()).
#[derive(Debug, Clone)]
pub struct ResiduesSettings {
    /// An assembly file, or the directory of a sweep or a simulation.
    pub input: PathBuf,
    /// The folder of the files; `residues` in the directory of a run if `None`, and no files for an
    /// assembly.
    pub output: Option<PathBuf>,
    /// The salt concentration of a run of several, mol/L.
    pub salt_molar: Option<f64>,
    /// The assembly of a run, if it is no longer where the run was begun with it.
    pub assembly: Option<PathBuf>,
    /// Interaction of the bodies of an assembly file.
    pub pose: PoseSettings,
    /// Residues touch where heavy atoms of them are closer than this, Å.
    pub touching_angstrom: f64,
    /// Frames that are used for each salt concentration, evenly chosen.
    pub most_frames: usize,
    /// Whether exchanges of single charges are scanned.
    pub mutations: bool,
    /// Whether exchanges of residues that touch another body are recommended, too.
    pub recommends_touching: bool,
    /// The viewer that a script is written for.
    pub script: Option<Viewer>,
    /// Whether existing files are replaced.
    pub force: bool,
}

/// The interaction for an assembly file; a run has its own.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PoseSettings {
    /// Medium, effective charges and further terms.
    pub run: RunSettings,
    /// Whether any of these settings was stated, which a run then refuses.
    pub is_stated: bool,
}

impl Default for ResiduesSettings {
    fn default() -> Self {
        Self {
            input: PathBuf::new(),
            output: None,
            salt_molar: None,
            assembly: None,
            pose: PoseSettings::default(),
            touching_angstrom: 5.0,
            most_frames: 200,
            mutations: false,
            recommends_touching: false,
            script: None,
            force: false,
        }
    }
}

impl ResiduesSettings {
    /// Checks what the types cannot express.
    ///
    /// # Errors
    /// Names the setting.
    pub fn check(&self) -> Result<()> {
        let distance = self.touching_angstrom;
        if !(distance > 0.0 && distance <= 20.0) {
            bail!(
                "residues touch where atoms are closer than {distance} Å; give a distance above 0 \
                 and up to 20 Å, such as --touching 5A"
            );
        }
        if self.most_frames == 0 {
            bail!("no frames are to be used; give --frames 200");
        }
        Ok(())
    }
}
