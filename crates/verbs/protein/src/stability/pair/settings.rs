//! The settings of a pair, as stored in `run.toml`.

use crate::stability::contacts::{ContactCore, ContactTerm};
use crate::stability::effective::{SoluteModel, require_electrolyte};
use crate::stability::interaction::{ContactDefinition, InteractionSettings};
use crate::stability::model::name_of_terms;
use crate::stability::run::salt_label;
use crate::stability::terms::{FurtherTerms, StatedTerms};
use anyhow::{Result, bail};
use protomer_body::Body;
use protomer_body::chemistry::StructureTitration;
use protomer_mc::pair::{Core, Estimator, PairSettings, Wells};
use protomer_results::Settings;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

protomer_kernel::choices! {
    /// Interactions of two bodies in addition to their surfaces.
    pub enum Energies {
        /// No interaction besides the surfaces.
        Hard = "hard",
        /// The charges of the bodies, screened by salt.
        Bare = "bare",
        /// Effective charges: those that give the potential around bodies of low permittivity that salt
        /// does not enter; from 3 Å on.
        Effective = "effective",
        /// The charges of the bodies, and to first order the response of the salt water that both
        /// displace; for native contacts.
        Response = "response",
    }
}

impl Energies {
    /// The choice of `--interaction`, where bodies have an inside.
    fn with_inside(self) -> Option<&'static str> {
        match self {
            Self::Hard | Self::Bare => None,
            Self::Effective => Some("effective"),
            Self::Response => Some("response"),
        }
    }
}

/// Everything that shapes the thermodynamics of a pair, apart from the bodies.
///
/// ```
/// use protomer_protein_verbs::stability::pair::{Energies, PairRunSettings};
/// let settings = PairRunSettings {
///     salt_molar: vec![0.1, 0.3],
///     energies: Energies::Bare,
///     ..PairRunSettings::default()
/// };
/// settings.check()?;
/// # Ok::<(), anyhow::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct PairRunSettings {
    /// Salt concentrations, mol/L; none where the Debye length is stated.
    #[serde(rename = "salt_M")]
    pub salt_molar: Vec<f64>,
    /// pH values at which structure files are made into bodies; none for body files.
    pub ph: Vec<f64>,
    /// Titration of structure files at each salt; pKa values in water for `None`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub protonation: Option<StructureTitration>,
    /// Interaction of the bodies.
    pub energies: Energies,
    /// Two bodies whose surfaces are closer than this are bound, Å.
    pub contact_gap_angstrom: f64,
    /// Definition of that gap; `None` only in the settings of earlier versions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub contact_definition: Option<ContactDefinition>,
    /// Settings of the sampling.
    pub sampling: PairSettings,
    /// The wanted standard error of B₂₂, mol mL/g², in the place of a relative one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub b22_error_mol_ml_per_g2: Option<f64>,
    /// The inside of the bodies, for effective charges and the response of the solvent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub solute: Option<SoluteModel>,
    /// Whether charges lose solvent to the other body; with effective charges only.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub desolvation: bool,
    /// Attraction between residues.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub contacts: Option<ContactTerm>,
    /// The medium between the bodies.
    pub medium: InteractionSettings,
}

impl Default for PairRunSettings {
    fn default() -> Self {
        Self {
            salt_molar: vec![0.1],
            ph: Vec::new(),
            protonation: None,
            energies: Energies::Bare,
            contact_gap_angstrom: protomer_mc::DEFAULT_CONTACT_GAP_ANGSTROM,
            contact_definition: Some(ContactDefinition::BetweenSurfaces),
            sampling: PairSettings::default(),
            b22_error_mol_ml_per_g2: None,
            solute: None,
            desolvation: false,
            contacts: None,
            medium: InteractionSettings::default(),
        }
    }
}

impl Settings for PairRunSettings {}

/// Each condition has a folder.
const MOST_CONDITIONS: usize = 10_000;

impl PairRunSettings {
    /// Refuses settings that make no sense.
    ///
    /// # Errors
    /// Names the setting and says what to give instead.
    pub fn check(&self) -> Result<()> {
        self.sampling.check()?;
        if self.salt_molar.is_empty() && self.needs_salt() {
            bail!("no salt concentration is given; add --salt 10mM,100mM,300mM or --debye 9.6A");
        }
        if self.needs_salt() && self.salt_molar.contains(&0.0) {
            bail!(
                "without salt the virial coefficient of charged bodies has no value; give --salt \
                 above zero, or --interaction hard"
            );
        }
        if self.protonation.is_some() && self.salt_molar.is_empty() {
            bail!("--protonation structure depends on the salt; add --salt 10mM,100mM");
        }
        for ph in &self.ph {
            if !(0.0..=14.0).contains(ph) {
                bail!("the pH is {ph}; give one from 0 to 14");
            }
        }
        if let Some(error) = self.b22_error_mol_ml_per_g2
            && !(error.is_finite() && error > 0.0)
        {
            bail!(
                "the wanted error of B22 is {error} mol mL/g²; give a positive one, such as 3e-5"
            );
        }
        let gap = self.contact_gap_angstrom;
        if !(0.0..=1000.0).contains(&gap) {
            bail!("the contact gap is {gap} Å; give one from 0 to 1000 Å");
        }
        if self.energies.with_inside().is_none() && self.solute.is_some() {
            bail!(
                "--inner-permittivity, --ion-radius, --ions and --regulation apply to bodies with an inside only; add \
                 --interaction effective or --interaction response, or leave them out"
            );
        }
        if self.desolvation && self.energies != Energies::Effective {
            bail!("desolvation is that of effective charges; add --interaction effective");
        }
        if let Some(contacts) = &self.contacts {
            contacts.potential(self.medium.temperature_kelvin)?;
        }
        let conditions = self.salts().len() * self.ph.len().max(1);
        if conditions > MOST_CONDITIONS {
            bail!("{conditions} conditions are too many; ask for at most {MOST_CONDITIONS}");
        }
        for salt_molar in self.salts() {
            let interaction = self.medium.interaction(salt_molar)?;
            if let Some(choice) = self.energies.with_inside() {
                require_electrolyte(&interaction, choice)?;
            }
        }
        Ok(())
    }

    fn needs_salt(&self) -> bool {
        self.energies != Energies::Hard && self.medium.debye_length_angstrom.is_none()
    }

    /// Terms in addition to the charges.
    pub(super) fn further_terms(&self) -> FurtherTerms {
        let terms = StatedTerms {
            contacts: self.contacts,
            desolvation: self.desolvation,
        };
        let response = self.energies == Energies::Response;
        let response = response.then(|| self.solute.unwrap_or_default());
        terms.with_insides(self.solute, response)
    }

    /// Sets the terms in addition to the charges.
    pub fn set_terms(&mut self, terms: StatedTerms) {
        self.contacts = terms.contacts;
        self.desolvation = terms.desolvation;
    }

    /// Name of the model whose terms these are.
    pub(super) fn model_name(&self, bodies: &[Arc<Body>]) -> &'static str {
        let has_own_charges = matches!(self.energies, Energies::Bare | Energies::Response);
        name_of_terms(&self.further_terms(), has_own_charges, bodies)
    }

    /// Core that keeps the bodies apart.
    pub(super) fn core(&self) -> Core {
        match self.contacts.map(|contacts| contacts.core) {
            Some(ContactCore::Beads) => Core::Energy,
            _ => Core::Surfaces,
        }
    }

    /// The salt of each condition, mol/L; `None` where it is not stated.
    pub fn salts(&self) -> Vec<Option<f64>> {
        match (self.salt_molar.is_empty(), self.needs_salt()) {
            (false, _) => self.salt_molar.iter().copied().map(Some).collect(),
            (true, _) if self.medium.debye_length_angstrom.is_some() => vec![None],
            // Hard bodies do not feel salt.
            (true, _) => vec![Some(0.0)],
        }
    }

    /// Steps of one condition.
    pub(super) fn steps(&self) -> u64 {
        Estimator::steps(&self.sampling) + Wells::steps(&self.sampling)
    }
}

/// The name of the directory of a condition.
pub(super) fn label(ph: Option<f64>, salt_molar: Option<f64>) -> String {
    let salt = salt_molar.map(salt_label);
    match (ph, salt) {
        (None, None) => "condition".into(),
        (None, Some(salt)) => salt,
        (Some(ph), None) => format!("ph_{ph:.2}"),
        (Some(ph), Some(salt)) => format!("ph_{ph:.2}_{salt}"),
    }
}
