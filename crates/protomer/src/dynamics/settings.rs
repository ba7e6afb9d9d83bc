//! The settings of a run: the resolved configuration, as stored in `run.toml`.

use anyhow::{Result, bail};
use protomer_md::bath::Ensemble;
use protomer_md::pair::Form;
use protomer_results::Settings;
use serde::{Deserialize, Serialize};

/// Which points of two bodies repel each other.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Potential {
    /// The closest points alone.
    Contact,
    /// Corners and edges of the faces that look at each other, as published.
    FaceSum,
    /// Corners and edges of both bodies, with forces that are the exact gradient.
    Smooth,
}

impl From<Potential> for Form {
    fn from(potential: Potential) -> Self {
        match potential {
            Potential::Contact => Form::Contact,
            Potential::FaceSum => Form::FaceSum,
            Potential::Smooth => Form::Smooth,
        }
    }
}

/// What keeps the temperature.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum EnsembleName {
    /// Nothing: the energy is kept.
    Nve,
    /// Stochastic rescaling of all momenta together.
    Nvt,
    /// Friction and noise on each body.
    Langevin,
    /// Overdamped motion.
    Brownian,
}

/// Settings of a run. They contain everything that can change a result, and nothing else. Reduced
/// units: bodies of area or volume one (unless their size is kept) and density one, energy ε.
///
/// ```
/// use protomer::dynamics::settings::DynamicsSettings;
/// let settings = DynamicsSettings { bodies: 64, ..DynamicsSettings::default() };
/// settings.check()?;
/// assert!(DynamicsSettings { packing_fraction: 1.2, ..settings }.check().is_err());
/// # Ok::<(), anyhow::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct DynamicsSettings {
    /// File or name of the shape; `disk` and `ball` are shapes too.
    pub shape: String,
    /// Whether the shape keeps its size, instead of being scaled to area or volume one.
    pub keep_size: bool,
    /// Number of bodies.
    pub bodies: usize,
    /// Part of the space that bodies with a layer of σ_c/2 fill.
    pub packing_fraction: f64,
    /// Which points repel each other.
    pub potential: Potential,
    /// Time step.
    pub time_step: f64,
    /// Run to this many steps, after the preparation.
    pub steps: u64,
    /// What keeps the temperature.
    pub ensemble: EnsembleName,
    /// kT in units of ε, at the start and of the bath.
    pub temperature: f64,
    /// Relaxation time of the global bath.
    pub relaxation_time: f64,
    /// Friction of Langevin and Brownian motion, an inverse time.
    pub friction: f64,
    /// Seed of the random numbers.
    pub seed: u64,
    /// Packing fraction of the lattice at the start; by default the densest at which no body feels
    /// another.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub compress_from: Option<f64>,
    /// Steps of the compression.
    pub compress_steps: u64,
    /// Steps with a bath after the compression.
    pub equilibrate_steps: u64,
    /// Time step of the preparation.
    pub preparation_time_step: f64,
    /// Steps between two rows of the log.
    pub log_every: u64,
    /// Steps between two frames of the trajectory; zero for no trajectory.
    pub trajectory_every: u64,
}

impl Default for DynamicsSettings {
    fn default() -> Self {
        Self {
            shape: "polygon:4".into(),
            keep_size: false,
            bodies: 1000,
            packing_fraction: 0.5,
            potential: Potential::Smooth,
            time_step: 1e-4,
            steps: 10_000,
            ensemble: EnsembleName::Nve,
            temperature: 1.0,
            relaxation_time: 0.5,
            friction: 1.0,
            seed: 1,
            compress_from: None,
            compress_steps: 10_000,
            equilibrate_steps: 8000,
            preparation_time_step: 5e-4,
            log_every: 100,
            trajectory_every: 1000,
        }
    }
}

impl DynamicsSettings {
    /// Checks the numbers.
    ///
    /// # Errors
    /// Names the setting and what it may be.
    pub fn check(&self) -> Result<()> {
        for (name, value) in [
            ("packing-fraction", self.packing_fraction),
            ("time-step", self.time_step),
            ("temperature", self.temperature),
            ("relaxation-time", self.relaxation_time),
            ("friction", self.friction),
            ("preparation-time-step", self.preparation_time_step),
            ("compress-from", self.compress_from.unwrap_or(1.0)),
        ] {
            if !(value.is_finite() && value > 0.0) {
                bail!("--{name} is {value}; give a positive number");
            }
        }
        if self.packing_fraction >= 1.0 {
            bail!(
                "--packing-fraction is {}; bodies cannot fill all of the space, give less than 1",
                self.packing_fraction
            );
        }
        if self.bodies == 0 {
            bail!("--bodies is 0; give at least 1");
        }
        if self.log_every == 0 {
            bail!("--log-every is 0; give at least 1");
        }
        if let Some(from) = self.compress_from
            && from > self.packing_fraction
        {
            bail!(
                "--compress-from is {from}, denser than --packing-fraction {}; begin with less",
                self.packing_fraction
            );
        }
        Ok(())
    }

    /// The ensemble of the run.
    pub fn ensemble(&self) -> Ensemble {
        let (temperature, friction) = (self.temperature, self.friction);
        match self.ensemble {
            EnsembleName::Nve => Ensemble::Nve,
            EnsembleName::Nvt => Ensemble::Nvt {
                temperature,
                relaxation_time: self.relaxation_time,
            },
            EnsembleName::Langevin => Ensemble::Langevin {
                temperature,
                friction,
            },
            EnsembleName::Brownian => Ensemble::Brownian {
                temperature,
                friction,
            },
        }
    }

    /// Steps before the run proper.
    pub fn preparation_steps(&self) -> u64 {
        self.compress_steps + self.equilibrate_steps
    }
}

impl Settings for DynamicsSettings {
    /// A run may be continued to more steps.
    fn essential(&self) -> Self {
        Self {
            steps: 0,
            ..self.clone()
        }
    }
}
