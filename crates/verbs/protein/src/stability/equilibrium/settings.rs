//! The settings of an equilibrium, as stored in `run.toml`.

use crate::stability::contacts::ContactTerm;
use crate::stability::effective::{SoluteModel, require_electrolyte};
use crate::stability::inspect::inspection_settings;
use crate::stability::interaction::InteractionSettings;
use crate::stability::model::Model;
use crate::stability::run::{EnergyMode, RunSettings};
use anyhow::{Result, bail};
use protomer_body::Body;
use protomer_body::chemistry::StructureTitration;
use protomer_common::range;
use protomer_mc::parts::GrowthSettings;
use protomer_results::Settings;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Everything that shapes the equilibrium of an assembly, apart from its bodies.
///
/// ```
/// use protomer_protein_verbs::stability::equilibrium::StabilitySettings;
/// use protomer_protein_verbs::stability::model::Model;
/// let settings = StabilitySettings {
///     salt_molar: vec![0.05, 0.5],
///     concentration_molar: vec![1e-6, 1e-5],
///     ..StabilitySettings::of_model(Model::Natural1)
/// };
/// settings.check()?;
/// # Ok::<(), anyhow::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct StabilitySettings {
    /// Salt concentrations, mol/L.
    #[serde(rename = "salt_M")]
    pub salt_molar: Vec<f64>,
    /// pH values at which structure files are made into bodies; none for the usual one, and for assemblies.
    pub ph: Vec<f64>,
    /// Total concentrations of all bodies, free and bound, mol/L.
    #[serde(rename = "concentration_M")]
    pub concentration_molar: Vec<f64>,
    /// Titration of structure files at each salt; pKa values in water for `None`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub protonation: Option<StructureTitration>,
    /// Inside of the bodies, whose displaced salt water responds to the charges of both.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub solvent_response: Option<SoluteModel>,
    /// Attraction between residues.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub contacts: Option<ContactTerm>,
    /// Bodies whose surfaces are closer than this may hold a part together, Å.
    pub contact_gap_angstrom: f64,
    /// Parts of each number of bodies at most; those of the lowest energies are kept.
    pub parts_of_a_size: usize,
    /// Sampling of the parts.
    pub sampling: GrowthSettings,
    /// Medium between the bodies.
    pub medium: InteractionSettings,
}

impl Default for StabilitySettings {
    fn default() -> Self {
        Self {
            salt_molar: Self::SALTS_MOLAR.to_vec(),
            ph: Vec::new(),
            concentration_molar: vec![Self::CONCENTRATION_MOLAR],
            protonation: None,
            solvent_response: None,
            contacts: None,
            contact_gap_angstrom: protomer_mc::DEFAULT_CONTACT_GAP_ANGSTROM,
            parts_of_a_size: Self::PARTS_OF_A_SIZE,
            sampling: GrowthSettings::default(),
            medium: InteractionSettings::default(),
        }
    }
}

impl Settings for StabilitySettings {
    /// Concentrations only weigh what was sampled, so a finished directory answers for others too.
    fn essential(&self) -> Self {
        Self {
            concentration_molar: Vec::new(),
            ..self.clone()
        }
    }
}

protomer_kernel::choices! {
    /// A way to the partition functions of parts.
    pub enum Way, default MassAction {
        /// Nested sampling of each part, body by body.
        MassAction = "mass-action",
        /// Simulations in windows, in which the last body of each part is taken away and comes back.
        Biased = "biased",
    }
}

/// Conditions of salt and pH at most.
const MOST_CONDITIONS: usize = 10_000;

impl StabilitySettings {
    /// Salts of an equilibrium where none is stated, mol/L.
    pub const SALTS_MOLAR: [f64; 3] = [0.05, 0.15, 0.5];
    /// Total concentration of the bodies where none is stated, mol/L.
    pub const CONCENTRATION_MOLAR: f64 = 1e-6;
    /// The default of [`Self::parts_of_a_size`].
    pub const PARTS_OF_A_SIZE: usize = 12;

    /// Settings with the terms of a model; the default has the charges of the bodies alone.
    pub fn of_model(model: Model) -> Self {
        Self {
            solvent_response: model.solvent_response(),
            contacts: model.contacts(),
            protonation: model.titration(),
            ..Self::default()
        }
    }

    /// Refuses settings that make no sense.
    ///
    /// # Errors
    /// Names the setting and says what to give instead.
    pub fn check(&self) -> Result<()> {
        self.sampling.check()?;
        if self.salt_molar.is_empty() {
            bail!("no salt concentration is given; add --salt 50mM,150mM,500mM");
        }
        if self.salt_molar.iter().any(|salt| *salt <= 0.0) {
            bail!(
                "without salt charges reach over all distances, and a part has no partition function; give \
                 --salt above zero"
            );
        }
        if self.concentration_molar.is_empty() {
            bail!("no concentration is given; add --concentration 1uM");
        }
        for concentration in &self.concentration_molar {
            if !(concentration.is_finite() && *concentration > 0.0) {
                bail!(
                    "the concentration is {concentration} M, and without bodies there is no equilibrium; give a \
                     positive one, such as --concentration 1uM"
                );
            }
        }
        for ph in &self.ph {
            range::PH.require("ph", *ph)?;
        }
        range::CONTACT_GAP.require("contact_gap_angstrom", self.contact_gap_angstrom)?;
        if let Some(contacts) = &self.contacts {
            contacts.potential(self.medium.temperature_kelvin)?;
        }
        let conditions = self.salt_molar.len() * self.ph.len().max(1);
        if conditions > MOST_CONDITIONS {
            bail!("{conditions} conditions are too many; ask for at most {MOST_CONDITIONS}");
        }
        for salt_molar in &self.salt_molar {
            let interaction = self.medium.interaction(Some(*salt_molar))?;
            if self.solvent_response.is_some() {
                require_electrolyte(&interaction, "response")?;
            }
        }
        Ok(())
    }

    /// The pH of each group of conditions; `None` where none is stated.
    pub(super) fn ph_values(&self) -> Vec<Option<f64>> {
        match self.ph.is_empty() {
            true => vec![None],
            false => self.ph.iter().copied().map(Some).collect(),
        }
    }

    /// The terms of the energy, as simulations have them.
    pub(super) fn run(&self) -> RunSettings {
        RunSettings {
            solvent_response: self.solvent_response,
            contacts: self.contacts,
            medium: self.medium.clone(),
            ..inspection_settings(EnergyMode::Direct, None, self.contact_gap_angstrom)
        }
    }

    /// The way to the partition functions.
    pub(super) fn way(&self) -> Way {
        match self.sampling.windows {
            None => Way::MassAction,
            Some(_) => Way::Biased,
        }
    }

    /// Name of the model whose terms these are.
    pub(super) fn model_name(&self, bodies: &[Arc<Body>]) -> &'static str {
        self.run().model_name(bodies)
    }
}

/// The name of the directory of a condition.
pub(super) fn label(ph: Option<f64>) -> String {
    match ph {
        None => "condition".into(),
        Some(ph) => format!("ph_{ph:.2}"),
    }
}
