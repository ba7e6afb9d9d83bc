//! The settings of a run of hard bodies, as stored in `run.toml`.

use super::start::FLUID;
use anyhow::{Result, bail};
pub use protomer_hpmc::box_moves::{Freedom, Pressure};
pub use protomer_hpmc::field::Gravity;
use protomer_hpmc::reservoir::Depletant;
use protomer_results::Settings;
use serde::{Deserialize, Serialize};

/// Settings of a run. They contain everything that can change a result. Lengths are in the unit of the
/// shape.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct HardBodySettings {
    /// File or name of the shape.
    pub shape: String,
    /// Radius of the ball, or disk, that rounds it.
    pub rounding_radius: f64,
    /// Number of bodies.
    pub bodies: usize,
    /// The part of the box that they fill.
    pub packing_fraction: f64,
    /// Sweeps in which the steps are tuned and nothing is measured.
    pub equilibration: u64,
    /// Sweeps after that.
    pub sweeps: u64,
    /// Seed of the random numbers.
    pub seed: u64,
    /// Sweeps between two measurements.
    pub sample_every: u64,
    /// Sweeps between two frames of the trajectory; zero for no trajectory.
    pub trajectory_every: u64,
    /// Bodies inserted at random per measurement, for the chemical potential.
    pub insertions: usize,
    /// Points per measurement, for the free volume of each depletant; zero for ten per body.
    pub points: usize,
    /// Penetrable hard spheres, or disks, in equilibrium with a reservoir.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub depletants: Vec<Depletant>,
    /// `fluid`, the name of a crystal, or the file of a unit cell.
    #[serde(skip_serializing_if = "is_fluid")]
    pub start: String,
    /// How every body of a crystal is turned first: degrees in a plane, a quaternion in space; empty for
    /// not at all.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub turn: Vec<f64>,
    /// Edges of the box relative to each other; empty for equal ones, and for a crystal.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub box_ratios: Vec<f64>,
    /// A constant pressure, at which the box changes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pressure: Option<Pressure>,
    /// Gravity between hard walls.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gravity: Option<Gravity>,
}

impl Default for HardBodySettings {
    fn default() -> Self {
        Self {
            shape: String::new(),
            rounding_radius: 0.0,
            bodies: 216,
            packing_fraction: 0.3,
            equilibration: 2000,
            sweeps: 10_000,
            seed: 1,
            sample_every: 5,
            trajectory_every: 500,
            insertions: 0,
            points: 0,
            depletants: Vec::new(),
            start: FLUID.into(),
            turn: Vec::new(),
            box_ratios: Vec::new(),
            pressure: None,
            gravity: None,
        }
    }
}

fn is_fluid(start: &str) -> bool {
    start == FLUID
}

impl Settings for HardBodySettings {
    /// More sweeps continue a run.
    fn essential(&self) -> Self {
        Self {
            sweeps: 0,
            ..self.clone()
        }
    }
}

impl HardBodySettings {
    /// Checks what does not depend on the shape.
    ///
    /// # Errors
    /// Names the setting and what it can be.
    pub fn check(&self) -> Result<()> {
        if !(self.packing_fraction > 0.0 && self.packing_fraction < 1.0) {
            bail!(
                "the packing fraction is {}; it must be between 0 and 1",
                self.packing_fraction
            );
        }
        if self.sample_every == 0 {
            bail!("sample_every is 0; give the sweeps between two measurements");
        }
        if self.sweeps < self.sample_every {
            bail!(
                "{} sweeps are too few for a measurement every {}; give at least {}",
                self.sweeps,
                self.sample_every,
                self.sample_every
            );
        }
        for kind in &self.depletants {
            kind.check()?;
        }
        let is_fluid = is_fluid(&self.start);
        if is_fluid && !self.turn.is_empty() {
            bail!(
                "a turn is for crystals, and the start is a fluid; give a crystal or leave it out"
            );
        }
        if !is_fluid && !self.box_ratios.is_empty() {
            bail!("a crystal has the box of its cells; leave the ratios of the edges out");
        }
        if !is_fluid && self.gravity.is_some() {
            bail!("a crystal that fills the box has no room for walls; start from a fluid");
        }
        Ok(())
    }

    /// Points per measurement.
    pub(super) fn resolved_points(&self) -> usize {
        match self.points {
            0 => 10 * self.bodies,
            points => points,
        }
    }
}

/// Depletants as the command line gives them: `RADIUS:FUGACITY`, several with commas between them.
///
/// # Errors
/// Names the part that is not two numbers.
///
/// ```
/// use protomer_convex::hard_bodies::settings::parse_depletants;
/// let kinds = parse_depletants("0.1:20,0.2:1.5")?;
/// assert_eq!((kinds[1].radius, kinds[1].fugacity), (0.2, 1.5));
/// assert!(parse_depletants("0.1").is_err());
/// # Ok::<(), anyhow::Error>(())
/// ```
pub fn parse_depletants(text: &str) -> Result<Vec<Depletant>> {
    let mut kinds = Vec::new();
    for part in text.split(',') {
        let numbers = part.trim().split_once(':').and_then(|(radius, fugacity)| {
            Some(Depletant {
                radius: radius.trim().parse().ok()?,
                fugacity: fugacity.trim().parse().ok()?,
            })
        });
        let Some(kind) = numbers else {
            bail!(
                "'{part}' is not RADIUS:FUGACITY; write the radius and the number density in the \
                 reservoir, such as 0.1:20"
            );
        };
        kind.check()?;
        kinds.push(kind);
    }
    Ok(kinds)
}
