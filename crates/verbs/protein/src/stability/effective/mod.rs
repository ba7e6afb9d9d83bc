//! Effective charges of bodies: what stands in the place of their charges in a medium.
//!
//! | module | one idea |
//! |---|---|
//! | `problem` | one body in one medium: what shapes its effective charges, and their fit |
//! | `range` | where effective charges hold, and what is said where they do not |
//! | `store` | each fit once, shared by whoever asks, kept on the disk for the next run |

mod problem;
pub(crate) mod range;
mod store;

pub use range::{LEAST_GAP_ANGSTROM, near_contact_warning, run_warning};
pub use store::EffectiveStore;

use crate::stability::interaction::ScreenedCoulomb;
use anyhow::{Result, bail};
use problem::Problem;
use protomer_body::Body;
use protomer_field::effective_charges::{EffectiveCharges, LARGEST_RELATIVE_RESIDUAL};
use protomer_field::{DielectricModel, IonModel, SaltValence};
use protomer_kernel::{Electrolyte, null};
use serde::{Deserialize, Serialize};

/// The inside of bodies, for effective charges.
///
/// ```
/// use protomer_kernel::Electrolyte;
/// use protomer_protein_verbs::stability::effective::SoluteModel;
/// let solute = SoluteModel { inner_permittivity: 10.0, ..SoluteModel::default() };
/// let dielectric = solute.dielectric(Electrolyte::in_water(298.15, 0.1)?);
/// assert_eq!((dielectric.inner_permittivity, dielectric.ion_radius_angstrom), (10.0, 2.0));
/// # Ok::<(), anyhow::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SoluteModel {
    /// Relative permittivity inside the surface.
    pub inner_permittivity: f64,
    /// The centres of ions keep this distance from the atoms, Å.
    pub ion_radius_angstrom: f64,
    /// Response of the ions, of one charge each, to the potential.
    #[serde(default, skip_serializing_if = "is_linear")]
    pub ions: IonModel,
    /// Whether charges follow the potential of other bodies, with the response of the solvent.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub regulation: bool,
}

fn is_linear(ions: &IonModel) -> bool {
    *ions == IonModel::Linear
}

impl SoluteModel {
    /// A body with this inside in an electrolyte.
    pub fn dielectric(&self, electrolyte: Electrolyte) -> DielectricModel {
        DielectricModel {
            inner_permittivity: self.inner_permittivity,
            ion_radius_angstrom: self.ion_radius_angstrom,
            ion_response: self.ions.with(SaltValence::ONE_TO_ONE),
            ..DielectricModel::new(electrolyte)
        }
    }
}

impl Default for SoluteModel {
    /// Permittivity 4, which stands for a protein whose side chains may turn a little, and ions of
    /// 2 Å.
    fn default() -> Self {
        Self {
            inner_permittivity: 4.0,
            ion_radius_angstrom: 2.0,
            ions: IonModel::Linear,
            regulation: false,
        }
    }
}

/// The effective charges of a body in a medium, fitted at every call. [`EffectiveStore`] keeps
/// them.
///
/// ```no_run
/// use protomer_protein_verbs::bodies::body_file;
/// use protomer_protein_verbs::stability::effective::{SoluteModel, effective_charges_of};
/// use protomer_protein_verbs::stability::interaction::InteractionSettings;
/// use std::path::Path;
/// let (body, _) = body_file::read(Path::new("4lzt.body"))?;
/// let saline = InteractionSettings::default().interaction(Some(0.1))?;
/// let charges = effective_charges_of(&body, &saline, &SoluteModel::default())?;
/// println!("{:+.2} e look like {:+.2} e", charges.net_charge_e, charges.net_effective_charge_e);
/// # Ok::<(), anyhow::Error>(())
/// ```
///
/// # Errors
/// As [`require_electrolyte`] and [`protomer_field::effective_charges::effective_charges`].
pub fn effective_charges_of(
    body: &Body,
    interaction: &ScreenedCoulomb,
    solute: &SoluteModel,
) -> Result<EffectiveCharges> {
    Problem::new(body, interaction, solute)?.solve()
}

/// Checks that a choice of `--interaction` has this medium: the Poisson-Boltzmann equation needs salt
/// and permittivity themselves, and what stands for a body does so at all distances.
///
/// # Errors
/// Without salt, where the medium was stated by lengths, and with a cut-off: says what to give.
pub fn require_electrolyte(interaction: &ScreenedCoulomb, choice: &str) -> Result<()> {
    // Of two ways to compute one length.
    const ROUNDING: f64 = 1e-9;
    let electrolyte = &interaction.electrolyte;
    let permittivity = electrolyte.relative_permittivity();
    let salt_molar = electrolyte.salt_molar();
    // Water's permittivity at this temperature is what the equation would take.
    let plain = Electrolyte::new(
        electrolyte.temperature_kelvin(),
        salt_molar.unwrap_or(0.0),
        permittivity,
    )?;
    let ratio = electrolyte.bjerrum_length_angstrom() / plain.bjerrum_length_angstrom();
    // A Bjerrum length that was set by hand names no permittivity to solve with.
    let Some(salt_molar) = salt_molar.filter(|_| (ratio - 1.0).abs() < ROUNDING) else {
        bail!(
            "--interaction {choice} needs the salt and the permittivity, not a Debye or Bjerrum length; \
             give --salt 100mM, and --permittivity if it is not that of water"
        );
    };
    if salt_molar <= 0.0 {
        bail!("--interaction {choice} is that in an electrolyte; give --salt above zero");
    }
    if interaction.cutoff_angstrom.is_finite() {
        bail!(
            "--interaction {choice} stands for a body at all distances; leave out --cutoff, or use \
             --interaction bare"
        );
    }
    Ok(())
}

/// Effective charges of one kind of body in one medium.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct EffectiveBody {
    /// Name of the body.
    pub name: String,
    /// Sum of the charges of the body, e.
    pub net_charge_e: f64,
    /// Charge that the body looks like from afar, on average over directions, e; null where that is
    /// an extrapolation too far ([`EffectiveCharges::charge_from_afar_e`]).
    pub net_effective_charge_e: Option<f64>,
    /// Number of effective charges.
    pub effective_charges: usize,
    /// Root mean square error of the fitted potential, each layer of points relative to its own
    /// root mean square.
    #[serde(deserialize_with = "null::as_nan")]
    pub relative_residual: f64,
    /// Condition of the regularised equations of the fit.
    #[serde(deserialize_with = "null::as_infinity")]
    pub condition: f64,
    /// Warning about a bad fit, and what to do.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub warning: Option<String>,
}

impl EffectiveBody {
    /// Summary of the effective charges of a body.
    pub fn new(body: &Body, charges: &EffectiveCharges) -> Self {
        Self {
            name: body.name.clone(),
            net_charge_e: charges.net_charge_e,
            net_effective_charge_e: charges.charge_from_afar_e(),
            effective_charges: charges.charges.len(),
            relative_residual: charges.relative_residual,
            condition: charges.condition,
            warning: warning(body, charges),
        }
    }

    /// Description of the effective charges in one line.
    pub fn describe(&self) -> String {
        let from_afar = match self.net_effective_charge_e {
            Some(charge_e) => format!("which looks like {charge_e:+.2} e from afar"),
            None => {
                "whose size from afar cannot be told: the salt screens the body too strongly".into()
            }
        };
        format!(
            "effective charges of '{}': {} for a net charge of {:+.2} e, {from_afar}; potential \
             fitted to {:.2} %",
            self.name,
            self.effective_charges,
            self.net_charge_e,
            100.0 * self.relative_residual
        )
    }
}

/// The warnings of these kinds of bodies, each once.
pub fn warnings<'a>(bodies: impl IntoIterator<Item = &'a EffectiveBody>) -> Vec<String> {
    let mut warnings: Vec<String> = Vec::new();
    for warning in bodies.into_iter().filter_map(|body| body.warning.as_ref()) {
        if !warnings.contains(warning) {
            warnings.push(warning.clone());
        }
    }
    warnings
}

/// A warning if a fit stands badly for the potential.
pub fn warning(body: &Body, charges: &EffectiveCharges) -> Option<String> {
    (charges.relative_residual > LARGEST_RELATIVE_RESIDUAL).then(|| {
        format!(
            "warning: the effective charges of '{}' miss the potential around it by {:.1} %; \
             compare with --interaction bare, and check that its charges lie below its surface",
            body.name,
            100.0 * charges.relative_residual
        )
    })
}
