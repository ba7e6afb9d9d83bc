//! What two bodies do together, one row per salt and pH.

use super::input::PairBodies;
use super::settings::{PairRunSettings, label};
use crate::stability::interaction::ScreenedCoulomb;
use anyhow::Result;
use protomer_body::Body;
use protomer_io::csv::{Cell, Table};
use protomer_kernel::pose::RelativePose;
use protomer_kernel::units::AVOGADRO_PER_MOL;
use protomer_mc::pair::profile::MeanForceRow;
use protomer_mc::pair::{BodyPair, EnergyParts, PairThermodynamics, Well};
use serde::{Deserialize, Serialize};
use std::f64::consts::LN_10;

/// Å³ in a litre.
const ANGSTROM3_PER_LITRE: f64 = 1e27;
/// Å³ in a millilitre.
const ANGSTROM3_PER_MILLILITRE: f64 = 1e24;

/// The thermodynamics of a pair over salt and pH.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PairResult {
    /// Version of the program.
    pub version: String,
    /// Name of the model whose terms these are, or `own terms`.
    #[serde(default)]
    pub model: String,
    /// SHA-256 of the two files.
    pub input_sha256: String,
    /// Names of the two bodies.
    pub bodies: [String; 2],
    /// The resolved settings.
    pub settings: PairRunSettings,
    /// One entry per pH and salt.
    pub conditions: Vec<ConditionResult>,
}

/// Two bodies in one medium.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ConditionResult {
    /// pH at which the bodies were made, if it was stated.
    pub ph: Option<f64>,
    /// Salt, mol/L; null if a Debye length was stated.
    #[serde(rename = "salt_M")]
    pub salt_molar: Option<f64>,
    /// Debye length, Å; null without salt.
    pub debye_length_angstrom: Option<f64>,
    /// Bjerrum length, Å.
    pub bjerrum_length_angstrom: f64,
    /// B₂ (B₁₂ of two different bodies), Å³.
    pub b2_angstrom3: f64,
    /// Standard error of B₂, Å³.
    pub b2_error_angstrom3: f64,
    /// B₂ of the surfaces alone, Å³.
    pub b2_hard_angstrom3: f64,
    /// Standard error of B₂ of the surfaces, Å³.
    pub b2_hard_error_angstrom3: f64,
    /// B₂ in the units of scattering experiments, mol mL/g²: N_A B₂/(M₁ M₂); null where the molar
    /// mass of a body is not known.
    pub b22_mol_ml_per_g2: Option<f64>,
    /// Standard error of B₂₂, mol mL/g².
    pub b22_error_mol_ml_per_g2: Option<f64>,
    /// Dissociation constant of the poses in contact, mol/L; null if contacts are not favoured.
    pub kd_molar: Option<f64>,
    /// Standard error of the dissociation constant, mol/L.
    pub kd_error_molar: Option<f64>,
    /// ∫ exp(-U) over poses in contact, Å³.
    pub association_volume_angstrom3: f64,
    /// The same without energies, Å³.
    pub contact_volume_angstrom3: f64,
    /// Net charges of the bodies, e.
    pub net_charge_e: [f64; 2],
    /// Net effective charges of the bodies, e; null for bare charges, and in the place of a charge
    /// that is an extrapolation too far.
    pub net_effective_charge_e: Option<[Option<f64>; 2]>,
    /// Bound poses, the lowest energy first.
    pub poses: Vec<PoseResult>,
    /// Whether the energies of residues are those of plain charges in the place of the effective ones
    /// that interact.
    #[serde(default)]
    pub residues_by_plain_charges: bool,
    /// Warnings.
    pub warnings: Vec<String>,
    /// Directions that were sampled with energies.
    pub directions: u64,
    /// The potential of mean force.
    pub mean_force: Vec<MeanForceRow>,
}

/// A bound pose.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PoseResult {
    /// Energy, kT.
    pub energy_kt: f64,
    /// The same, term by term.
    #[serde(flatten)]
    pub parts: EnergyParts,
    /// Position of the second body in the frame of the first, Å.
    pub position_angstrom: [f64; 3],
    /// Orientation of the second body, a quaternion, scalar first.
    pub orientation_wxyz: [f64; 4],
    /// Share of its well in the association constant; null where wells were not integrated one by one.
    #[serde(default)]
    pub share: Option<f64>,
    /// log₁₀ of the dissociation constant of its well alone, in mol/L.
    #[serde(default)]
    pub log10_kd_molar: Option<f64>,
    /// Standard error of that logarithm.
    #[serde(default)]
    pub log10_kd_error: Option<f64>,
}

/// Conversion of integrals over poses in contact to constants of association.
#[derive(Debug, Clone, Copy)]
pub(super) struct Association {
    /// N/2 · N pairs of equal bodies stand for N · N of different ones.
    pairs: f64,
    /// ∫ exp(-U) over all poses in contact, Å³.
    volume_angstrom3: f64,
}

impl Association {
    pub fn new(are_equal: bool, found: &PairThermodynamics) -> Self {
        Self {
            pairs: if are_equal { 0.5 } else { 1.0 },
            volume_angstrom3: found.association_volume_angstrom3,
        }
    }

    /// Dissociation constant of poses with this ∫ exp(-U), mol/L.
    fn kd_molar(&self, volume_angstrom3: f64) -> f64 {
        ANGSTROM3_PER_LITRE / (self.pairs * volume_angstrom3 * AVOGADRO_PER_MOL)
    }
}

impl ConditionResult {
    pub(super) fn new(
        bodies: [&Body; 2],
        are_equal: bool,
        ph: Option<f64>,
        interaction: ScreenedCoulomb,
        found: PairThermodynamics,
        poses: Vec<PoseResult>,
    ) -> Self {
        let electrolyte = &interaction.electrolyte;
        let debye = electrolyte.debye_length_angstrom();
        let per_b2 = b22_per_b2(bodies);
        let association = Association::new(are_equal, &found);
        let is_bound = found.association_volume_angstrom3 > found.contact_volume_angstrom3;
        let kd_molar = is_bound.then(|| association.kd_molar(association.volume_angstrom3));
        let relative_error =
            found.association_volume_error_angstrom3 / found.association_volume_angstrom3;
        Self {
            ph,
            salt_molar: electrolyte.salt_molar(),
            debye_length_angstrom: debye.is_finite().then_some(debye),
            bjerrum_length_angstrom: electrolyte.bjerrum_length_angstrom(),
            b2_angstrom3: found.b2_angstrom3,
            b2_error_angstrom3: found.b2_error_angstrom3,
            b2_hard_angstrom3: found.b2_hard_angstrom3,
            b2_hard_error_angstrom3: found.b2_hard_error_angstrom3,
            b22_mol_ml_per_g2: per_b2.map(|factor| factor * found.b2_angstrom3),
            b22_error_mol_ml_per_g2: per_b2.map(|factor| factor * found.b2_error_angstrom3),
            kd_molar,
            kd_error_molar: kd_molar.map(|kd| kd * relative_error),
            association_volume_angstrom3: found.association_volume_angstrom3,
            contact_volume_angstrom3: found.contact_volume_angstrom3,
            net_charge_e: bodies.map(Body::net_charge_e),
            net_effective_charge_e: None,
            poses,
            residues_by_plain_charges: false,
            warnings: Vec::new(),
            directions: found.directions,
            mean_force: found.mean_force,
        }
    }

    pub(super) fn cells(&self) -> Vec<(&'static str, Cell)> {
        vec![
            ("ph", optional(self.ph)),
            ("salt_M", optional(self.salt_molar)),
            (
                "debye_length_angstrom",
                optional(self.debye_length_angstrom),
            ),
            ("b2_angstrom3", Cell::Number(self.b2_angstrom3)),
            ("b2_error_angstrom3", Cell::Number(self.b2_error_angstrom3)),
            ("b2_hard_angstrom3", Cell::Number(self.b2_hard_angstrom3)),
            ("b22_mol_ml_per_g2", optional(self.b22_mol_ml_per_g2)),
            (
                "b22_error_mol_ml_per_g2",
                optional(self.b22_error_mol_ml_per_g2),
            ),
            ("kd_molar", optional(self.kd_molar)),
            ("kd_error_molar", optional(self.kd_error_molar)),
            (
                "lowest_energy_kt",
                optional(self.poses.first().map(|pose| pose.energy_kt)),
            ),
        ]
    }
}

impl PoseResult {
    pub(super) fn new(pair: &BodyPair, found: &Well, association: &Association) -> Self {
        let bound = found.pose;
        let pose = bound.pose;
        let integral = found.integral.as_ref();
        let volume = integral.map(|integral| integral.association_volume_angstrom3);
        let relative = RelativePose::from(&pose);
        Self {
            energy_kt: bound.energy_kt,
            parts: pair.potential.parts_kt(&relative),
            position_angstrom: pose.position.into(),
            orientation_wxyz: pose.wxyz(),
            share: volume.map(|volume| volume / association.volume_angstrom3),
            log10_kd_molar: volume.map(|volume| association.kd_molar(volume).log10()),
            log10_kd_error: integral.map(|integral| integral.relative_error / LN_10),
        }
    }
}

/// From Å³ per pair to mol mL/g².
pub(super) fn b22_per_b2([first, second]: [&Body; 2]) -> Option<f64> {
    let masses = first.molar_mass_g_per_mol()? * second.molar_mass_g_per_mol()?;
    Some(AVOGADRO_PER_MOL / ANGSTROM3_PER_MILLILITRE / masses)
}

fn optional(value: Option<f64>) -> Cell {
    value.map_or(Cell::Empty, Cell::Number)
}

impl PairResult {
    pub(super) fn new(
        bodies: &PairBodies,
        settings: &PairRunSettings,
        conditions: Vec<ConditionResult>,
    ) -> Self {
        Self {
            version: env!("CARGO_PKG_VERSION").into(),
            model: settings.model_name(&bodies.first_pair()).into(),
            input_sha256: bodies.sha256.clone(),
            bodies: bodies.names().map(str::to_owned),
            settings: settings.clone(),
            conditions,
        }
    }

    /// The names of the folders of the conditions, in their order.
    pub fn folders(&self) -> Vec<String> {
        let mut phs: Vec<Option<f64>> = self.settings.ph.iter().copied().map(Some).collect();
        if phs.is_empty() {
            phs.push(None);
        }
        let salts = self.settings.salts();
        let of_ph = |ph: &Option<f64>| -> Vec<String> {
            salts.iter().map(|salt| label(*ph, *salt)).collect()
        };
        phs.iter().flat_map(of_ph).collect()
    }
}

/// The table of a potential of mean force.
pub(super) fn mean_force_to_csv(rows: &[MeanForceRow]) -> Result<String> {
    let mut table = Table::new(["distance_angstrom", "w_kt", "w_error_kt"]);
    for row in rows {
        let numbers = [row.distance_angstrom, row.w_kt, row.w_error_kt];
        table.push(numbers.map(Cell::Number))?;
    }
    Ok(table.to_csv()?)
}
