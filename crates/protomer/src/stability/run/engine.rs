//! From an assembly and an interaction to a system with an energy model: what all replicas of a
//! sweep share.

use crate::assemblies::assembly_file::Assembly;
use crate::stability::energy_tables::EnergyTables;
use crate::stability::interaction::ScreenedCoulomb;
use crate::stability::run::{DEFAULT_TOLERANCE_KT, EnergyMode, RunSettings};
use anyhow::{Context, Result, bail};
use protomer_kernel::potential::Yukawa;
use protomer_mc::energy::{DirectSum, EnergyModel, NoCharges};
use protomer_mc::hard::overlapping_pairs;
use protomer_mc::{BodyType, McError, Settings, System};
use std::sync::Arc;

/// Body types prepared once and shared by every simulation of an assembly.
#[derive(Debug, Clone)]
pub struct Engine {
    assembly: Assembly,
    types: Vec<Arc<BodyType>>,
    tables: Arc<EnergyTables>,
}

impl Engine {
    /// Prepares the bodies of an assembly for simulation.
    ///
    /// # Errors
    /// Names the body whose mesh does not bound a solid.
    pub fn new(assembly: Assembly) -> Result<Self> {
        let prepare = |body: &Arc<protomer_body::Body>| {
            let kind =
                BodyType::from_body(body).with_context(|| format!("body '{}'", body.name))?;
            Ok(Arc::new(kind))
        };
        let types = assembly.bodies.iter().map(prepare).collect::<Result<_>>()?;
        Ok(Self {
            assembly,
            types,
            tables: Arc::default(),
        })
    }

    /// The same engine with energy tables from elsewhere.
    pub fn with_tables(self, tables: Arc<EnergyTables>) -> Self {
        Self { tables, ..self }
    }

    /// The assembly.
    pub fn assembly(&self) -> &Assembly {
        &self.assembly
    }

    /// The bodies at their places.
    ///
    /// # Errors
    /// If a placement lies outside a wall.
    pub fn system(&self) -> Result<System> {
        let placed: Vec<_> = self
            .assembly
            .kinds
            .iter()
            .copied()
            .zip(self.assembly.poses.iter().copied())
            .collect();
        Ok(System::new(
            self.types.clone(),
            &placed,
            self.assembly.boundary,
        )?)
    }

    /// A model of the energies for one salt concentration; models of one engine share their tables.
    ///
    /// # Errors
    /// If the interaction makes no sense, or its tables take more memory than is allowed.
    pub fn energy_model(
        &self,
        run: &RunSettings,
        interaction: &ScreenedCoulomb,
    ) -> Result<Box<dyn EnergyModel>> {
        let levels = |yukawa: Yukawa| self.tables.levels(&self.system()?, yukawa);
        Ok(match self.settings(run, interaction)?.interaction {
            protomer_mc::Interaction::YukawaCalibrated(yukawa) => Box::new(levels(yukawa)?),
            protomer_mc::Interaction::YukawaApproximate {
                yukawa,
                tolerance_kt,
            } => Box::new(levels(yukawa)?.with_tolerance(tolerance_kt)),
            other => other.model(&self.system()?),
        })
    }

    /// The fastest way to compute energies that makes the decisions of the direct sum: levels where
    /// a body has so many charges that their tables pay, and there is no cut-off.
    pub fn fastest_energy(&self, interaction: &ScreenedCoulomb) -> EnergyMode {
        const CHARGES: usize = 200;
        let charges = self.types.iter().map(|kind| kind.charges.len()).max();
        let is_cut = interaction.cutoff_angstrom.is_finite();
        match charges.unwrap_or(0) >= CHARGES && !is_cut {
            true => EnergyMode::Calibrated,
            false => EnergyMode::Direct,
        }
    }

    /// Checks what would stop every simulation at its start: an overlap, or a box too small for an
    /// interaction.
    ///
    /// # Errors
    /// Lists the overlapping pairs; says which box is needed.
    pub fn check(&self, run: &RunSettings, interactions: &[ScreenedCoulomb]) -> Result<()> {
        let system = self.system()?;
        let pairs = overlapping_pairs(&system);
        if !pairs.is_empty() {
            return Err(McError::OverlappingStart { pairs }.into());
        }
        for interaction in interactions {
            // Without tables: what counts is the reach of the charges.
            let model: Box<dyn EnergyModel> = match run.energy {
                EnergyMode::None => Box::new(NoCharges),
                _ => Box::new(DirectSum::new(interaction.yukawa()?)),
            };
            require_room(&system, model.as_ref(), interaction)?;
        }
        Ok(())
    }

    /// The engine's settings for one salt concentration.
    ///
    /// # Errors
    /// If the interaction makes no sense.
    pub fn settings(&self, run: &RunSettings, interaction: &ScreenedCoulomb) -> Result<Settings> {
        let interaction = match run.energy {
            EnergyMode::None => protomer_mc::Interaction::HardOnly,
            EnergyMode::Calibrated | EnergyMode::Approximate
                if interaction.cutoff_angstrom.is_finite() =>
            {
                bail!(
                    "energies by levels have no cut-off; leave out --cutoff, or add --energy direct"
                )
            }
            EnergyMode::Calibrated => {
                protomer_mc::Interaction::YukawaCalibrated(interaction.yukawa()?)
            }
            EnergyMode::Direct => protomer_mc::Interaction::YukawaDirect(interaction.yukawa()?),
            EnergyMode::Approximate => protomer_mc::Interaction::YukawaApproximate {
                yukawa: interaction.yukawa()?,
                tolerance_kt: run
                    .energy
                    .tolerance_kt(run.tolerance_kt)?
                    .unwrap_or(DEFAULT_TOLERANCE_KT),
            },
        };
        Ok(Settings {
            equilibration_sweeps: run.equilibration_sweeps,
            cluster_moves_per_sweep: run.cluster_moves_per_sweep,
            contact_gap_angstrom: run.contact_gap_angstrom,
            ..Settings::new(interaction)
        })
    }
}

/// Checks that the box is large enough for the bodies and for the interaction.
///
/// # Errors
/// Says how large the box must be, and for which interaction.
pub fn require_room(
    system: &System,
    model: &dyn EnergyModel,
    interaction: &ScreenedCoulomb,
) -> Result<()> {
    protomer_mc::simulation::require_room(system, model).with_context(|| {
        format!(
            "the box does not suit the interaction ({})",
            interaction.describe()
        )
    })
}
