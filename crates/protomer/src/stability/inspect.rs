//! The state of an assembly: overlaps, pair energies, radius of gyration.

use crate::stability::effective::{self, EffectiveBody};
use crate::stability::interaction::ScreenedCoulomb;
use crate::stability::run::{EnergyMode, Engine, RunSettings, require_room};
use anyhow::Result;
use protomer_common::answer::Answer;
use protomer_kernel::units::kilojoule_per_mol_per_kt;
use protomer_mc::hard::overlapping_pairs;
use protomer_mc::observables::{contacts, r_g_angstrom};
use serde::Serialize;

/// The result of [`inspect`].
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Inspection {
    /// Number of bodies.
    pub bodies: usize,
    /// Pairs of bodies that overlap.
    pub overlaps: Vec<(usize, usize)>,
    /// Total energy, kT; `None` if no medium was stated.
    #[serde(rename = "energy_kT")]
    pub energy_kt: Option<f64>,
    /// Total energy, kJ/mol.
    #[serde(rename = "energy_kJ_per_mol")]
    pub energy_kilojoule_per_mol: Option<f64>,
    /// Energies of the pairs in range: first body, second body, kT.
    pub pair_energies: Vec<(usize, usize, f64)>,
    /// The largest error bound of one of these energies, kT; zero for direct sums.
    pub error_bound_kt_per_pair: f64,
    /// Pairs whose surfaces are closer than the contact gap.
    pub contacts: Vec<(usize, usize)>,
    /// Radius of gyration of the body positions, Å.
    pub r_g_angstrom: f64,
    /// Concentration of the bodies, mol/L; zero in open space.
    #[serde(rename = "concentration_M")]
    pub concentration_molar: f64,
    /// The medium, if one was stated.
    #[serde(flatten)]
    pub interaction: Option<ScreenedCoulomb>,
    /// Each kind of body, where its effective charges interact.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub effective_bodies: Option<Vec<EffectiveBody>>,
    /// What a user should know of these energies.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub warnings: Vec<String>,
}

/// Inspects the present state of an assembly. Without a medium there are no energies.
///
/// # Errors
/// If a setting is invalid, the interaction reaches further than the box allows, an energy is not
/// finite, or effective charges cannot be fitted.
///
/// ```no_run
/// use protomer_common::answer::Answer;
/// use protomer::assemblies::assembly_file::Assembly;
/// use protomer::stability::inspect::{inspect, inspection_settings};
/// use protomer::stability::interaction::InteractionSettings;
/// use protomer::stability::run::{EnergyMode, Engine};
/// use std::path::Path;
/// let engine = Engine::new(Assembly::read(Path::new("6mdr/assembly.json"))?)?;
/// let settings = inspection_settings(EnergyMode::Direct, None, 5.0);
/// let interaction = InteractionSettings::default().interaction(Some(0.1))?;
/// println!("{}", inspect(&engine, &settings, Some(interaction))?.text());
/// # Ok::<(), anyhow::Error>(())
/// ```
pub fn inspect(
    engine: &Engine,
    settings: &RunSettings,
    interaction: Option<ScreenedCoulomb>,
) -> Result<Inspection> {
    settings.check()?;
    let Some(interaction) = interaction else {
        return without_energies(engine, settings);
    };
    let engine = &engine.in_medium(settings, &interaction)?;
    let system = engine.system()?;
    let mut model = engine.energy_model(settings, &interaction)?;
    require_room(&system, model.as_ref(), &interaction)?;
    model.reset(&system)?;
    let pairs = model.pairs(&system);
    let energy_kt = model.total_kt(&system);
    let mut warnings = effective::warnings(engine.effective_bodies().into_iter().flatten());
    warnings.extend(effective::near_contact_warning(&system, settings));
    let temperature_kelvin = interaction.electrolyte.temperature_kelvin();
    Ok(Inspection {
        bodies: system.len(),
        overlaps: overlapping_pairs(&system),
        energy_kt: Some(energy_kt),
        energy_kilojoule_per_mol: Some(energy_kt * kilojoule_per_mol_per_kt(temperature_kelvin)),
        pair_energies: pairs
            .iter()
            .map(|pair| (pair.first, pair.second, pair.total_kt()))
            .collect(),
        error_bound_kt_per_pair: model.error_bound_kt(&system),
        contacts: contacts(&system, settings.contact_gap_angstrom),
        r_g_angstrom: r_g_angstrom(&system, |_| 1.0),
        concentration_molar: engine.assembly().concentration_molar(),
        interaction: Some(interaction),
        effective_bodies: engine.effective_bodies().map(<[_]>::to_vec),
        warnings,
    })
}

/// What the surfaces say.
fn without_energies(engine: &Engine, settings: &RunSettings) -> Result<Inspection> {
    let system = engine.system()?;
    Ok(Inspection {
        bodies: system.len(),
        overlaps: overlapping_pairs(&system),
        energy_kt: None,
        energy_kilojoule_per_mol: None,
        pair_energies: Vec::new(),
        error_bound_kt_per_pair: 0.0,
        contacts: contacts(&system, settings.contact_gap_angstrom),
        r_g_angstrom: r_g_angstrom(&system, |_| 1.0),
        concentration_molar: engine.assembly().concentration_molar(),
        interaction: None,
        effective_bodies: None,
        warnings: Vec::new(),
    })
}

impl Answer for Inspection {
    fn text(&self) -> String {
        let overlaps = match self.overlaps.as_slice() {
            [] => "none".to_owned(),
            pairs => pairs
                .iter()
                .map(|(i, j)| format!("{i}-{j}"))
                .collect::<Vec<_>>()
                .join(", "),
        };
        let mut effective = String::new();
        for body in self.effective_bodies.iter().flatten() {
            effective.push_str(&body.describe());
            effective.push('\n');
        }
        let mut energy = "energy: not computed; state the salt for it, such as --salt 100mM".into();
        if let (Some(interaction), Some(kt), Some(kilojoule_per_mol)) = (
            &self.interaction,
            self.energy_kt,
            self.energy_kilojoule_per_mol,
        ) {
            energy = format!(
                "medium: {}\n{effective}energy: {kt:.6} kT ({kilojoule_per_mol:.4} kJ/mol) over {} \
                 pairs in range{}",
                interaction.describe(),
                self.pair_energies.len(),
                error_bound(self.error_bound_kt_per_pair)
            );
        }
        format!(
            "{} bodies, {} contacts, overlaps: {overlaps}\n{energy}\nradius of gyration: {:.3} Å",
            self.bodies,
            self.contacts.len(),
            self.r_g_angstrom
        )
    }
}

/// The error bound (kT per pair of bodies) in words, to follow an energy; empty for a direct sum.
pub(crate) fn error_bound(error_bound_kt_per_pair: f64) -> String {
    match error_bound_kt_per_pair > 0.0 {
        true => format!(", each to within {error_bound_kt_per_pair:.2e} kT"),
        false => String::new(),
    }
}

/// The settings relevant to [`inspect`]: the energy mode and the contact gap.
pub fn inspection_settings(
    energy: EnergyMode,
    tolerance_kt: Option<f64>,
    contact_gap_angstrom: f64,
) -> RunSettings {
    RunSettings {
        energy: Some(energy),
        tolerance_kt,
        contact_gap_angstrom,
        ..RunSettings::default()
    }
}
