//! The settings of a run: the resolved configuration, as stored in `run.toml`.

use anyhow::{Result, bail};
use protomer_common::range;
use protomer_kernel::Number;
use protomer_md::bath::Ensemble;
use protomer_md::pair::central::Central;
use protomer_md::pair::radial::Attraction;
use protomer_md::pair::{Form, Interaction};
use protomer_results::Settings;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// Most bodies.
const MOST_BODIES: usize = 1 << 30;

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

/// The energy between the centroids of bodies in motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum CentralName {
    /// None.
    None,
    /// That of the published potential with the same strength as that of points.
    Conservative,
}

impl From<CentralName> for Central {
    fn from(name: CentralName) -> Self {
        match name {
            CentralName::None => Central::None,
            CentralName::Conservative => Central::Conservative,
        }
    }
}

/// What keeps the temperature, and the pressure.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum EnsembleName {
    /// Nothing: the energy is kept.
    Nve,
    /// Stochastic rescaling of all momenta together.
    Nvt,
    /// The same, and trials of the volume.
    Npt,
    /// Friction and noise on each body.
    Langevin,
    /// Overdamped motion.
    Brownian,
}

/// Settings of a run. They contain everything that can change a result, and nothing else. Reduced
/// units: bodies of area or volume one (unless their size is kept) and density one, energy ε.
///
/// ```
/// use protomer_convex::dynamics::settings::DynamicsSettings;
/// let settings = DynamicsSettings { bodies: 64, ..DynamicsSettings::default() };
/// settings.check()?;
/// assert!(DynamicsSettings { packing_fraction: 1.2, ..settings }.check().is_err());
/// # Ok::<(), anyhow::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct DynamicsSettings {
    /// Files or names of the shapes, one for each kind of body; one is written as a word, several as
    /// a list.
    #[serde(serialize_with = "write_words", deserialize_with = "read_words")]
    pub shape: Vec<String>,
    /// How many bodies of each kind there are, in proportion; empty for equal numbers.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub share: Vec<f64>,
    /// The radius by which the shapes are rounded, in the unit of their points.
    pub rounding: f64,
    /// Whether the shape keeps its size, instead of being scaled to area or volume one.
    pub keep_size: bool,
    /// Number of bodies.
    pub bodies: usize,
    /// Part of the space that bodies with a layer of σ_c/2 fill.
    pub packing_fraction: f64,
    /// Which points repel each other.
    pub potential: Potential,
    /// Strength of the attraction: 0 for the repulsion alone, 1 for Lennard-Jones.
    pub attraction: f64,
    /// Where the attraction ends, over the length of the repulsion.
    pub attraction_cut_off: f64,
    /// The energy between the centroids.
    pub central: CentralName,
    /// Time step.
    pub time_step: f64,
    /// Run to this many steps, after the preparation.
    pub steps: u64,
    /// What keeps the temperature.
    pub ensemble: EnsembleName,
    /// kT in units of ε, at the start and of the bath.
    pub temperature: f64,
    /// Pressure of `npt`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pressure: Option<f64>,
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
            shape: vec!["polygon:4".into()],
            share: Vec::new(),
            rounding: 0.0,
            keep_size: false,
            bodies: 1000,
            packing_fraction: 0.5,
            potential: Potential::Smooth,
            attraction: 0.0,
            attraction_cut_off: Attraction::NONE.cut_off,
            central: CentralName::None,
            time_step: 1e-4,
            steps: 10_000,
            ensemble: EnsembleName::Nve,
            temperature: 1.0,
            pressure: None,
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
        // Beyond these ranges products and powers of the numbers are no numbers any more.
        for (name, value, from, to) in [
            ("packing-fraction", self.packing_fraction, 1e-9, f64::MAX),
            ("time-step", self.time_step, 1e-12, 1.0),
            ("temperature", self.temperature, 1e-9, 1e9),
            ("relaxation-time", self.relaxation_time, 1e-9, 1e9),
            ("friction", self.friction, 1e-9, 1e9),
            (
                "preparation-time-step",
                self.preparation_time_step,
                1e-12,
                1.0,
            ),
            (
                "compress-from",
                self.compress_from.unwrap_or(1.0),
                1e-9,
                1.0,
            ),
            ("pressure", self.pressure.unwrap_or(1.0), 1e-9, 1e9),
            ("rounding", self.rounding, 0.0, 1e6),
            ("attraction", self.attraction, 0.0, 1e6),
            ("attraction-cut-off", self.attraction_cut_off, 1.5, 1e3),
        ] {
            if !(from..=to).contains(&value) {
                let (value, from) = (Number(value), Number(from));
                match to == f64::MAX {
                    true => bail!("--{name} is {value}; give a number of at least {from}"),
                    false => bail!(
                        "--{name} is {value}; give a number from {from} to {}",
                        Number(to)
                    ),
                }
            }
        }
        self.check_kinds()?;
        match (self.ensemble, self.pressure) {
            (EnsembleName::Npt, None) => bail!("--ensemble npt needs a --pressure"),
            (EnsembleName::Npt, Some(_)) | (_, None) => {}
            (_, Some(pressure)) => bail!(
                "--pressure is {pressure}, and the volume is constant; give --ensemble npt, or leave \
                 it out"
            ),
        }
        if self.packing_fraction >= 1.0 {
            bail!(
                "--packing-fraction is {}; bodies cannot fill all of the space, give less than 1",
                self.packing_fraction
            );
        }
        // The momentum of the whole is zero, so one body alone does not move.
        if !(2..=MOST_BODIES).contains(&self.bodies) {
            bail!(
                "--bodies is {}; give a number from 2 to {MOST_BODIES}",
                self.bodies
            );
        }
        self.check_steps()?;
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

    fn check_steps(&self) -> Result<()> {
        for (name, steps) in [
            ("--steps", self.steps),
            ("--compress-steps", self.compress_steps),
            ("--equilibrate-steps", self.equilibrate_steps),
            ("--log-every", self.log_every),
            ("--trajectory-every", self.trajectory_every),
        ] {
            range::STEPS.require(name, steps)?;
        }
        if self.log_every == 0 {
            bail!("--log-every is 0; give at least 1");
        }
        Ok(())
    }

    fn check_kinds(&self) -> Result<()> {
        if self.shape.is_empty() {
            bail!("there is no --shape; give one or several");
        }
        if !self.share.is_empty() && self.share.len() != self.shape.len() {
            bail!(
                "--shape: {}, --share: {}; give a --share for each --shape, or none",
                self.shape.len(),
                self.share.len()
            );
        }
        if let Some(share) = self
            .share
            .iter()
            .find(|share| !(1e-9..=1e9).contains(*share))
        {
            bail!(
                "--share is {}; give a number from 1e-9 to 1e9",
                Number(*share)
            );
        }
        Ok(())
    }

    /// What bodies feel of each other.
    pub fn interaction(&self) -> Interaction {
        Interaction {
            form: self.potential.into(),
            attraction: Attraction {
                strength: self.attraction,
                cut_off: self.attraction_cut_off,
            },
            central: self.central.into(),
        }
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
            EnsembleName::Npt => Ensemble::Npt {
                temperature,
                relaxation_time: self.relaxation_time,
                // Checked to be there.
                pressure: self.pressure.unwrap_or(f64::NAN),
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

/// One word, or a list of them.
#[derive(Deserialize)]
#[serde(untagged)]
enum Words {
    One(String),
    Several(Vec<String>),
}

fn read_words<'de, D: Deserializer<'de>>(from: D) -> Result<Vec<String>, D::Error> {
    Ok(match Words::deserialize(from)? {
        Words::One(word) => vec![word],
        Words::Several(words) => words,
    })
}

fn write_words<S: Serializer>(words: &[String], to: S) -> Result<S::Ok, S::Error> {
    match words {
        [word] => word.serialize(to),
        _ => words.serialize(to),
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn one_shape_is_a_word_and_several_are_a_list() {
        for words in ["shape = \"disk\"", "shape = [\"disk\", \"polygon:3\"]"] {
            let settings: DynamicsSettings = toml::from_str(words).unwrap();
            let text = toml::to_string(&settings).unwrap();
            assert!(text.contains(words), "{text}");
            let again: DynamicsSettings = toml::from_str(&text).unwrap();
            assert_eq!(settings, again);
        }
    }

    #[test]
    fn what_does_not_fit_says_what_to_give() {
        let settings = DynamicsSettings::default();
        let complaint = |settings: DynamicsSettings| settings.check().unwrap_err().to_string();
        let npt = DynamicsSettings {
            ensemble: EnsembleName::Npt,
            ..settings.clone()
        };
        assert!(complaint(npt).contains("needs a --pressure"));
        let nve = DynamicsSettings {
            pressure: Some(1.0),
            ..settings.clone()
        };
        assert!(complaint(nve).contains("--ensemble npt"));
        let shares = DynamicsSettings {
            share: vec![1.0, 2.0],
            ..settings.clone()
        };
        assert!(complaint(shares).contains("--shape: 1, --share: 2"));
        let endless = DynamicsSettings {
            steps: u64::MAX,
            ..settings.clone()
        };
        assert_eq!(
            complaint(endless),
            "--steps is 18446744073709551615; give a whole number from 0 to 1000000000000"
        );
        let repelled = DynamicsSettings {
            attraction: -1.0,
            ..settings
        };
        assert!(complaint(repelled).contains("--attraction is -1"));
    }

    #[test]
    fn numbers_out_of_range_are_named_with_their_range() {
        let settings = DynamicsSettings::default;
        for (wrong, words) in [
            (
                DynamicsSettings {
                    temperature: 1e308,
                    ..settings()
                },
                "--temperature is 1e308; give a number from 1e-9 to 1e9",
            ),
            (
                DynamicsSettings {
                    rounding: 1e100,
                    ..settings()
                },
                "--rounding is 1e100",
            ),
            (
                DynamicsSettings {
                    time_step: 1e300,
                    ..settings()
                },
                "--time-step is 1e300",
            ),
            (
                DynamicsSettings {
                    attraction: 1e300,
                    ..settings()
                },
                "--attraction is 1e300",
            ),
            (
                DynamicsSettings {
                    attraction_cut_off: 1.0,
                    ..settings()
                },
                "--attraction-cut-off is 1",
            ),
            (
                DynamicsSettings {
                    share: vec![1e308],
                    ..settings()
                },
                "--share is 1e308; give a number from",
            ),
            (
                DynamicsSettings {
                    bodies: 1,
                    ..settings()
                },
                "--bodies is 1; give a number from 2",
            ),
            (
                DynamicsSettings {
                    packing_fraction: 1e-308,
                    ..settings()
                },
                "--packing-fraction is 1e-308",
            ),
            (
                DynamicsSettings {
                    packing_fraction: f64::NAN,
                    ..settings()
                },
                "--packing-fraction is NaN",
            ),
        ] {
            let error = wrong.check().unwrap_err().to_string();
            assert!(error.contains(words), "{error}");
        }
    }
}
