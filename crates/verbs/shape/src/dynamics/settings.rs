//! The settings of a run: the resolved configuration, as stored in `run.toml`.

use anyhow::{Result, bail};
use protomer_common::range::{Count, NOT_NEGATIVE, POSITIVE, Range, STEPS};
use protomer_common::settings::{Declared, Words, is_default};
use protomer_kernel::height_energy::HeightTable;
use protomer_kernel::pair_energy::Term;
use protomer_md::added::Added;
use protomer_md::bath::Ensemble;
use protomer_md::pair::central::Central;
use protomer_md::pair::radial::Attraction;
use protomer_md::pair::{Form, Interaction};
use protomer_results::Settings;

const TIME_STEP: Range = Range::new(1e-12, 1.0, "");

protomer_kernel::choices! {
    /// Energy between the centroids of bodies in motion.
    pub enum CentralName {
        /// No energy between the centroids.
        None = "none",
        /// Energy of the published potential with epsilon_s = epsilon.
        Conservative = "conservative",
    }
}

protomer_kernel::choices! {
    /// Bath that keeps the temperature, and the pressure.
    pub enum EnsembleName {
        /// No bath: the energy is kept.
        Nve = "nve",
        /// Stochastic rescaling of all momenta together; dynamics stay those of the bodies.
        Nvt = "nvt",
        /// Rescaling as for nvt, at constant pressure: now and then the box is scaled at random.
        Npt = "npt",
        /// Friction and noise on each body.
        Langevin = "langevin",
        /// Overdamped motion.
        Brownian = "brownian",
    }
}

protomer_common::settings! {
    /// Settings of a run. They contain everything that can change a result, and nothing else. Reduced
    /// units: bodies of area or volume one (unless their size is kept) and density one, energy ε.
    ///
    /// ```
    /// use protomer_shape_verbs::dynamics::settings::DynamicsSettings;
    /// let dense = DynamicsSettings { packing_fraction: 1.2, ..DynamicsSettings::default() };
    /// assert!(dense.check().is_err());
    /// ```
    pub struct DynamicsSettings {
        /// File or name of the shape, as for `shape`; also disk, ball, ellipse:A,B or ellipsoid:A,B,C;
        /// convex parts of a concave body joined by +. Several times for a mixture.
        shape: Words = "polygon:4";
        /// Relative number of bodies of each shape: once for each --shape.
        share: Vec<f64>, in POSITIVE, otherwise "equal numbers", omit "is_default";
        /// Radius by which the shapes are rounded, in the unit of their points, before they are scaled.
        rounding: f64 = 0.0, in NOT_NEGATIVE;
        /// Keep the size of the shape instead of scaling it to area or volume one.
        keep_size: bool;
        /// Let no body turn: its orientation stays that of the start.
        fixed_orientations: bool, omit "is_default";
        /// Number of bodies.
        bodies: usize = 1000_usize, in Count::new(2, 1 << 30);
        /// Part of the space that bodies with their layer fill.
        packing_fraction: f64 = 0.5, in POSITIVE;
        /// Points of the bodies that repel each other.
        potential: Form = Form::Smooth;
        /// Strength of the attraction: 0 for the repulsion alone, 1 for Lennard-Jones.
        attraction: f64 = 0.0, in NOT_NEGATIVE;
        /// Cut-off of the attraction, in units of sigma_c (of sigma for the central term); it is
        /// switched off smoothly from 0.8 of that on.
        attraction_cut_off: f64 = Attraction::NONE.cut_off, in Range::new(1.5, 1e3, "");
        /// Energy between the centroids.
        central: CentralName = CentralName::None;
        /// Time step.
        time_step: f64 = 1e-4, in TIME_STEP;
        /// Run to this many steps after the preparation.
        steps: u64 = 10_000_u64, in STEPS;
        /// Bath that keeps the temperature, and the pressure.
        ensemble: EnsembleName = EnsembleName::Nve;
        /// kT at the start and of the bath, in units of epsilon.
        temperature: f64 = 1.0, in POSITIVE;
        /// Pressure of npt, in units of epsilon per area or volume.
        pressure: Option<f64>, in POSITIVE, omit "is_default";
        /// Relaxation time of the bath of nvt and npt.
        relaxation_time: f64 = 0.5, in POSITIVE;
        /// Friction of langevin and brownian, an inverse time.
        friction: f64 = 1.0, in POSITIVE;
        /// Seed of the random numbers.
        seed: u64 = 1_u64, in Count::new(0, i64::MAX as u64);
        /// State to start from instead of a lattice: a GSD file of any program, or the directory of a run. Bodies and
        /// packing fraction are those of the state, unless a larger packing fraction is given. Velocities that it
        /// has are kept.
        start: Option<String>, otherwise "a lattice", omit "is_default";
        /// Frame of the GSD file to start from, counted from 0.
        frame: Option<u64>, in Count::new(0, i64::MAX as u64), otherwise "the last", omit "is_default";
        /// Packing fraction of the lattice at the start.
        compress_from: Option<f64>, in Range::new(1e-9, 1.0, ""), otherwise "the densest without forces",
            omit "is_default";
        /// Steps of the compression.
        compress_steps: u64 = 10_000_u64, in STEPS;
        /// Steps with a bath after the compression.
        equilibrate_steps: u64 = 8000_u64, in STEPS;
        /// Time step of compression and equilibration.
        preparation_time_step: f64 = 5e-4, in TIME_STEP;
        /// Steps between rows of the log.
        log_every: u64 = 100_u64, in STEPS.at_least(1);
        /// Steps between frames of the trajectory; 0 for none.
        trajectory_every: u64 = 1000_u64, in STEPS;
        /// Energies of pairs of bodies in addition to their contacts, in kT of the temperature. Lengths are those of the
        /// shapes.
        pair_potential: Vec<Term>, omit "is_default", from file;
        /// Energy of each body by its last coordinate, from the lower end of the box, in kT of the temperature.
        field: Option<HeightTable>, omit "is_default", from file;
    }
}

impl DynamicsSettings {
    /// Checks the numbers, and what depends on several of them.
    ///
    /// ```
    /// use protomer_shape_verbs::dynamics::settings::{DynamicsSettings, EnsembleName};
    /// let settings = DynamicsSettings {
    ///     shape: "cube".into(),
    ///     ensemble: EnsembleName::Npt,
    ///     ..DynamicsSettings::default()
    /// };
    /// let message = settings.check().map_err(|error| error.to_string());
    /// assert_eq!(message, Err("--ensemble npt needs a --pressure".to_owned()));
    /// ```
    ///
    /// # Errors
    /// Names the setting and what it may be.
    pub fn check(&self) -> Result<()> {
        self.check_ranges()?;
        let (shapes, shares) = (self.shape.len(), self.share.len());
        if shapes == 0 {
            bail!("there is no --shape; give one or several");
        }
        if shares != 0 && shares != shapes {
            bail!("--shape: {shapes}, --share: {shares}; give a --share for each --shape, or none");
        }
        match (self.ensemble, self.pressure) {
            (EnsembleName::Npt, None) => bail!("--ensemble npt needs a --pressure"),
            (EnsembleName::Npt, Some(_)) | (_, None) => {}
            (_, Some(pressure)) => bail!(
                "--pressure is {pressure}, and the volume is constant; give --ensemble npt, or leave \
                 it out"
            ),
        }
        if self.ensemble == EnsembleName::Npt && self.field.is_some() {
            bail!(
                "--field has its heights in a box of constant size, and --ensemble npt changes it; give another ensemble, or \
                 leave the field out"
            );
        }
        if self.start.is_none() && self.frame.is_some() {
            bail!("--frame is for a GSD file to --start from; give one, or leave it out");
        }
        if self.start.is_some() && self.compress_from.is_some() {
            bail!("--compress-from is for a lattice; leave it out with --start");
        }
        let target = self.packing_fraction;
        if target >= 1.0 {
            bail!(
                "--packing-fraction is {target}; bodies cannot fill all of the space, give less than 1"
            );
        }
        if let Some(from) = self.compress_from.filter(|from| *from > target) {
            bail!(
                "--compress-from is {from}, denser than --packing-fraction {target}; begin with less"
            );
        }
        Ok(())
    }

    /// Interaction of the bodies.
    pub fn interaction(&self) -> Interaction {
        Interaction {
            form: self.potential,
            attraction: Attraction {
                strength: self.attraction,
                cut_off: self.attraction_cut_off,
            },
            central: match self.central {
                CentralName::None => Central::None,
                CentralName::Conservative => Central::Conservative,
            },
        }
    }

    /// Whether there are energies in addition to the contacts.
    pub fn has_added(&self) -> bool {
        !self.pair_potential.is_empty() || self.field.is_some()
    }

    /// The energies in addition to the contacts, of bodies in a plane (dimension 2) or in space (3).
    ///
    /// # Errors
    /// For terms without a force, and for numbers that cannot be.
    pub fn added(&self, dimension: usize) -> Result<Added> {
        let (terms, heights) = (&self.pair_potential, self.field.as_ref());
        Ok(Added::new(terms, heights, dimension, self.temperature)?)
    }

    /// The ensemble of the run.
    ///
    /// ```
    /// use protomer_md::bath::Ensemble;
    /// use protomer_shape_verbs::dynamics::settings::{DynamicsSettings, EnsembleName};
    /// let settings = DynamicsSettings {
    ///     ensemble: EnsembleName::Langevin,
    ///     temperature: 0.5,
    ///     ..DynamicsSettings::default()
    /// };
    /// assert_eq!(settings.ensemble(), Ensemble::Langevin { temperature: 0.5, friction: 1.0 });
    /// ```
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
    /// Settings without the number of steps: a run may be continued to more steps.
    fn essential(&self) -> Self {
        Self {
            steps: 0,
            ..self.clone()
        }
    }
}

#[cfg(test)]
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
            "steps is 18446744073709551615; give a whole number from 0 to 1000000000000"
        );
        let repelled = DynamicsSettings {
            attraction: -1.0,
            ..settings
        };
        assert!(complaint(repelled).contains("attraction is -1"));
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
                "temperature is 1e308; give 1e-9 to 1000000000",
            ),
            (
                DynamicsSettings {
                    rounding: 1e100,
                    ..settings()
                },
                "rounding is 1e100",
            ),
            (
                DynamicsSettings {
                    time_step: 1e300,
                    ..settings()
                },
                "time_step is 1e300",
            ),
            (
                DynamicsSettings {
                    attraction: 1e300,
                    ..settings()
                },
                "attraction is 1e300",
            ),
            (
                DynamicsSettings {
                    attraction_cut_off: 1.0,
                    ..settings()
                },
                "attraction_cut_off is 1",
            ),
            (
                DynamicsSettings {
                    share: vec![1e308],
                    ..settings()
                },
                "share is 1e308; give 1e-9",
            ),
            (
                DynamicsSettings {
                    bodies: 1,
                    ..settings()
                },
                "bodies is 1; give a whole number from 2",
            ),
            (
                DynamicsSettings {
                    packing_fraction: 1e-308,
                    ..settings()
                },
                "packing_fraction is 1e-308",
            ),
            (
                DynamicsSettings {
                    packing_fraction: f64::NAN,
                    ..settings()
                },
                "packing_fraction is NaN",
            ),
        ] {
            let error = wrong.check().unwrap_err().to_string();
            assert!(error.contains(words), "{error}");
        }
    }
}
