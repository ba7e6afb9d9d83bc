//! The result of a sweep: its table, what its exchanges did, and where the assembly falls apart.

use super::stability::Stability;
use super::table::{ReplicaResult, SaltRow};
use crate::stability::run::{Exchanged, LogRow, RunSettings};
use protomer_results::Result;
use protomer_results::keys::read_json_if_present;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::path::Path;

/// Name of the file of the result in the directory of a sweep.
pub(super) const RESULT: &str = "sweep.json";

/// The result of a sweep.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SweepResult {
    /// Whether the results are those of an equilibrium: `yes`, `no` or `unknown`.
    #[serde(default = "unknown")]
    pub equilibrium: Cow<'static, str>,
    /// Version of the program.
    pub version: String,
    /// Name of the model whose terms these are, or `own terms`.
    #[serde(default)]
    pub model: Cow<'static, str>,
    /// SHA-256 of the assembly and its bodies.
    pub input_sha256: String,
    /// Number of bodies.
    pub bodies: usize,
    /// Concentration of the bodies, mol/L; zero in open space.
    #[serde(rename = "concentration_M")]
    pub concentration_molar: f64,
    /// Edge lengths of the box, Å; `None` without a box.
    pub box_angstrom: Option<[f64; 3]>,
    /// The resolved settings.
    pub settings: RunSettings,
    /// One row per salt concentration.
    pub salts: Vec<SaltRow>,
    /// The replicas behind each row.
    pub replicas: Vec<Vec<ReplicaResult>>,
    /// Salt at which the assembly falls apart, and whether that is an equilibrium.
    #[serde(flatten)]
    pub stability: Stability,
    /// Statistics of the exchanges between salt concentrations.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub exchanges: Vec<Exchanged>,
    /// Warnings about the energies.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub warnings: Vec<String>,
    /// The log of the only simulation; empty if there are several.
    #[serde(skip)]
    pub time_series: Vec<LogRow>,
}

/// The verdict in results of earlier versions, which had it in `equilibrated` alone.
fn unknown() -> Cow<'static, str> {
    "unknown".into()
}

impl SweepResult {
    /// Reads the result in the directory of a sweep; `None` if the sweep is not finished.
    ///
    /// # Errors
    /// If it is damaged.
    pub fn read(directory: &Path) -> Result<Option<Self>> {
        read_json_if_present(&directory.join(RESULT))
    }

    /// Notes on what cannot be said: one replica has no spread, one concentration no curve.
    pub(super) fn missing_errors(&self) -> Vec<String> {
        let mut lines = Vec::new();
        if self.settings.replicas == 1 {
            lines.push("one replica: no error bar; give --replicas 4".into());
        }
        if self.salts.len() == 1 {
            lines.push(
                "one salt concentration: a point, not a curve; give several, such as \
                 --salt 10mM..300mM/8"
                    .into(),
            );
        }
        lines
    }
}
