//! The result of a sweep: its table, what its exchanges did, and where the assembly falls apart.

use super::stability::Stability;
use super::table::{ReplicaResult, SaltRow};
use crate::stability::run::{Exchanged, RunSettings};
use serde::Serialize;

/// The result of a sweep.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SweepResult {
    /// Version of the program.
    pub version: String,
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
    /// Where it falls apart, and whether that is an equilibrium.
    #[serde(flatten)]
    pub stability: Stability,
    /// What the exchanges between salt concentrations did.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub exchanges: Vec<Exchanged>,
}
