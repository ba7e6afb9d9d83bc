//! The settings of a free energy.

use crate::hard_bodies::settings::{check_bodies, check_packing_fraction, check_rounding};
use anyhow::{Result, bail};
use protomer_common::range;
use protomer_common::settings::is_default;
use protomer_results::Settings;
use serde::{Deserialize, Serialize};

protomer_kernel::choices! {
    /// Division of the sweeps among the strengths of the springs.
    pub enum Share, default Errors {
        /// Sweeps go where the error of the integral falls most.
        Errors = "errors",
        /// The same sweeps at each strength, each in its own folder, so that processes can share the strengths.
        Even = "even",
    }
}

/// Settings of a free energy. Lengths are in the unit of the shape.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct FreeEnergySettings {
    /// File or name of the shape.
    pub shape: String,
    /// Radius of the ball, or disk, that rounds the shape.
    pub rounding_radius: f64,
    /// Name of the crystal, or file of its unit cell.
    pub crystal: String,
    /// Rotation of every body in its own frame: degrees in a plane, a quaternion in space; empty
    /// for none.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub turn: Vec<f64>,
    /// Number of bodies.
    pub bodies: usize,
    /// Part of the box that the bodies fill.
    pub packing_fraction: f64,
    /// Sweeps at each point in which steps are tuned and nothing is measured.
    pub equilibration: u64,
    /// Sweeps after the equilibration, per point on average.
    pub sweeps: u64,
    /// Division of the sweeps among the strengths.
    #[serde(skip_serializing_if = "is_default")]
    pub share: Share,
    /// Seed of the random numbers.
    pub seed: u64,
}

impl Default for FreeEnergySettings {
    fn default() -> Self {
        Self {
            shape: String::new(),
            rounding_radius: 0.0,
            crystal: String::new(),
            turn: Vec::new(),
            bodies: 216,
            packing_fraction: 0.6,
            equilibration: 2000,
            sweeps: 20_000,
            share: Share::Errors,
            seed: 1,
        }
    }
}

impl FreeEnergySettings {
    /// Checks what does not depend on the shape.
    ///
    /// # Errors
    /// Names the setting and what it can be.
    pub fn check(&self) -> Result<()> {
        if self.sweeps == 0 {
            bail!("sweeps is 0; give the sweeps per point of the integral");
        }
        range::STEPS.require("sweeps", self.sweeps)?;
        range::STEPS.require("equilibration", self.equilibration)?;
        check_packing_fraction(self.packing_fraction)?;
        check_bodies(self.bodies)?;
        check_rounding(self.rounding_radius)
    }
}

impl Settings for FreeEnergySettings {
    /// Settings without the number of sweeps: more sweeps continue a run.
    fn essential(&self) -> Self {
        Self {
            // Sweeps may grow when a run continues; all else shapes the result.
            sweeps: 0,
            ..self.clone()
        }
    }
}
