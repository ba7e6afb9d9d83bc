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
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) protonation: Vec<Vec<bool>>,
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

    /// Lengths of the lists that have an entry for each type of body.
    fn lists_by_type(&self) -> [usize; 3] {
        [
            self.tuners.len(),
            self.statistics.translation.len(),
            self.statistics.rotation.len(),
        ]
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
        } else if self
            .lists_by_type()
            .iter()
            .any(|length| *length != system.types().len())
        {
            "it has another number of body types".into()
        } else if !self.poses.iter().all(is_finite) {
            "a pose in it is not finite".into()
        } else if !self
            .native_contacts
            .iter()
            .all(|pair| names_two(pair, system.len()))
        {
            "its contacts name bodies that do not exist".into()
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

/// Whether a pose is made of numbers.
fn is_finite(pose: &Pose) -> bool {
    let rotation = pose.rotation.coords.iter();
    pose.position.iter().chain(rotation).all(|x| x.is_finite())
}

/// Whether a pair names two of so many bodies, the smaller number first.
fn names_two((first, second): &(usize, usize), bodies: usize) -> bool {
    first < second && *second < bodies
}

/// The type of each body, by name.
pub(crate) fn type_names(system: &System) -> Vec<String> {
    (0..system.len())
        .map(|body| system.body_type(body).name.clone())
        .collect()
}
