//! The state from which a run continues bit for bit.

use crate::energy::PairEnergy;
use crate::moves::step_sizes::Tuner;
use crate::statistics::Statistics;
use crate::system::System;
use crate::{McError, Result, Settings};
use protomer_kernel::{Boundary, Pose};
use serde::{Deserialize, Serialize};

/// Everything that a continued run needs besides the system itself (body types and boundary).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Checkpoint {
    pub(crate) version: u32,
    pub(crate) settings: Settings,
    pub(crate) seed: u64,
    pub(crate) replica: u32,
    pub(crate) sweep: u64,
    pub(crate) type_names: Vec<String>,
    pub(crate) boundary: Boundary,
    pub(crate) poses: Vec<Pose>,
    pub(crate) energies: Vec<PairEnergy>,
    pub(crate) tuners: Vec<Tuner>,
    pub(crate) statistics: Statistics,
    pub(crate) native_contacts: Vec<(usize, usize)>,
}

impl Checkpoint {
    pub(crate) const VERSION: u32 = 1;

    /// Sweeps done.
    pub fn sweep(&self) -> u64 {
        self.sweep
    }

    /// The settings of the run.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// # Errors
    /// [`McError::ForeignCheckpoint`] if it was written from another system.
    pub(crate) fn check_system(&self, system: &System) -> Result<()> {
        let difference = if self.version != Checkpoint::VERSION {
            format!(
                "it has version {}, this program writes {}",
                self.version,
                Checkpoint::VERSION
            )
        } else if self.type_names != type_names(system) || self.poses.len() != system.len() {
            "its bodies are others".into()
        } else if self.boundary != *system.boundary() {
            "its box is another".into()
        } else if self.tuners.len() != system.types().len() {
            "it has another number of body types".into()
        } else if self
            .energies
            .iter()
            .any(|pair| pair.first >= pair.second || pair.second >= system.len())
        {
            "its energies name bodies that do not exist".into()
        } else {
            return Ok(());
        };
        Err(McError::ForeignCheckpoint(difference))
    }
}

/// The type of each body, by name.
pub(crate) fn type_names(system: &System) -> Vec<String> {
    (0..system.len())
        .map(|body| system.body_type(body).name.clone())
        .collect()
}
