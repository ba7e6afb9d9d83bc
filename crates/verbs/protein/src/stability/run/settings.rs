//! The settings of a run: the resolved configuration, as stored in `run.toml`.

use crate::stability::contacts::{ContactCore, ContactTerm};
use crate::stability::effective::{SoluteModel, require_electrolyte};
use crate::stability::interaction::{ContactDefinition, InteractionSettings};
use crate::stability::model::name_of_terms;
use crate::stability::terms::{FurtherTerms, StatedTerms};
use anyhow::{Result, bail};
use protomer_body::Body;
use protomer_common::range::{self, CONTACT_GAP, Count, Range, STEPS, TOLERANCE};
use protomer_common::settings::{Declared, is_default};
use protomer_kernel::setting::Choices;
use protomer_mc::Depletants;
use protomer_results::Settings;
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Upper limit for the number of runs, each of which has a folder.
const LARGEST_NUMBER_OF_SIMULATIONS: u64 = 100_000;
/// Range of the number of replicas.
const SIMULATIONS: Count = Count::new(1, LARGEST_NUMBER_OF_SIMULATIONS);
/// Range of the number of moves of one kind per sweep: runs stop between sweeps only.
const MOVES_PER_SWEEP: Count = Count::new(0, 100_000);
/// Range of the radius of depletants: with smaller ones a sweep would draw more points than anybody waits for.
const DEPLETANT_RADIUS: Range = Range::new(0.1, 1e4, "Å");
/// Range of the part of the reservoir that depletants fill.
const DEPLETANT_FRACTION: Range = Range::new(0.0, 10.0, "");

protomer_common::settings! {
    /// Settings of a simulation or of each simulation of a sweep. They contain everything that can
    /// change a result, and nothing else: two runs with equal settings on equal input give equal
    /// results on any number of threads.
    ///
    /// ```
    /// use protomer_protein_verbs::stability::run::{EnergyMode, RunSettings};
    /// let settings = RunSettings {
    ///     salt_molar: vec![0.01, 0.1],
    ///     replicas: 3,
    ///     energy: Some(EnergyMode::Calibrated),
    ///     ..RunSettings::default()
    /// };
    /// assert_eq!(settings.simulations(), 6);
    /// settings.check()?;
    /// # Ok::<(), anyhow::Error>(())
    /// ```
    pub struct RunSettings {
        /// Salt concentrations, mol/L; a single simulation uses the first.
        #[serde(rename = "salt_M")]
        salt_molar: Vec<f64> = vec![0.1_f64], from file;
        /// Independent replicas per salt concentration.
        replicas: u32 = 5_u32, in SIMULATIONS, from sweep;
        /// Total number of production sweeps (each one trial move per body, plus the cluster moves).
        sweeps: u64 = 2000_u64, in STEPS.at_least(1);
        /// Sweeps before production, in which step sizes are tuned and then frozen.
        equilibration_sweeps: u64 = 500_u64, in STEPS, flag "equilibration";
        /// Geometric cluster moves per sweep.
        cluster_moves_per_sweep: u32 = 1_u32, in MOVES_PER_SWEEP, flag "cluster-moves";
        /// Moves per sweep that form and dissolve contacts: bodies put next to others or far from
        /// them, turns about contacts, groups, swaps.
        binding_moves_per_sweep: u32, in MOVES_PER_SWEEP, flag "binding-moves", omit "is_default";
        /// Moves per sweep in which groups of one body take up or lose protons, at the pH of the bodies, which have their
        /// groups (ingest --titratable); 0 for fixed charges.
        proton_moves_per_sweep: u32, in MOVES_PER_SWEEP, flag "proton-moves", omit "is_default";
        /// Radius of depletants, Å: penetrable hard spheres, such as coils of a polymer, in equilibrium with a reservoir.
        depletant_radius_angstrom: Option<f64>, in DEPLETANT_RADIUS, otherwise "no depletants", flag "depletant-radius",
            value "ANGSTROM", omit "is_default";
        /// Part of the reservoir that the depletants fill.
        depletant_fraction: Option<f64>, in DEPLETANT_FRACTION, otherwise "no depletants", value "FRACTION",
            omit "is_default";
        /// Sweeps between two exchanges of states between neighbouring salt concentrations; 0 for
        /// none.
        exchange_every: u64, in STEPS, value "SWEEPS", omit "is_default", from sweep;
        /// Starting states of the replicas.
        starts: Starts, omit "is_default", from sweep;
        /// GSD file with the first poses of all bodies, such as the trajectory of another run.
        state: Option<String>, otherwise "the assembly", value "FILE", omit "is_default", from simulate;
        /// Frame of that file, counted from 0.
        frame: Option<u64>, in STEPS, otherwise "the last", omit "is_default", from simulate;
        /// Seed of the random numbers.
        seed: u64 = 1_u64;
        /// Surfaces closer than this are in contact, Å.
        contact_gap_angstrom: f64 = protomer_mc::DEFAULT_CONTACT_GAP_ANGSTROM, in CONTACT_GAP, flag "contact-gap";
        /// Definition of the contact gap; stated in the settings of every run that
        /// [`Engine::resolved`](super::Engine::resolved) has seen.
        contact_definition: Option<ContactDefinition>, omit "is_default", from file;
        /// Sweeps between rows of the log.
        log_every: u64 = 10_u64, in STEPS.at_least(1);
        /// Sweeps between frames of the trajectory; 0 for none.
        trajectory_every: u64 = 100_u64, in STEPS;
        /// Energy model.
        energy: Option<EnergyMode>, otherwise "the fastest that makes the decisions of the direct sum",
            omit "is_default";
        /// Largest likely error of the energy of two bodies, kT, with --energy approximate.
        tolerance_kt: Option<f64>, in TOLERANCE, otherwise "0.001", flag "tolerance", value "KT", omit "is_default";
        /// Inside of the bodies, whose effective charges then interact; `None` for the charges of
        /// the bodies themselves, as in all runs of earlier versions.
        effective_charges: Option<SoluteModel>, omit "is_default", from file;
        /// Inside of the bodies, whose displaced salt water responds to the charges of both; `None`
        /// for charges in salt water everywhere.
        solvent_response: Option<SoluteModel>, omit "is_default", from file;
        /// Attraction between residues.
        contacts: Option<ContactTerm>, omit "is_default", from file;
        /// Whether charges lose solvent to other bodies; with effective charges only.
        desolvation: bool, omit "is_default", from file;
        /// Medium between the bodies.
        medium: InteractionSettings, from file;
    }
}

protomer_kernel::choices! {
    /// Starts of the replicas of a sweep.
    pub enum Starts, default Assembly {
        /// All replicas from the assembly.
        Assembly = "assembly",
        /// All replicas from bodies scattered at random, each from others.
        Fluid = "fluid",
        /// Replicas 0, 2, ... from the assembly, 1, 3, ... from the fluid: whether they come to
        /// agree shows whether they are in equilibrium.
        Both = "both",
    }
}

/// Start of one replica.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Start {
    /// The poses of the assembly.
    Assembly,
    /// Random poses.
    Fluid,
}

impl Starts {
    /// The start of a replica.
    pub fn of_replica(self, replica: u32) -> Start {
        match self {
            Starts::Assembly => Start::Assembly,
            Starts::Fluid => Start::Fluid,
            Starts::Both if replica.is_multiple_of(2) => Start::Assembly,
            Starts::Both => Start::Fluid,
        }
    }
}

/// Default of the largest error of the energy of two bodies, kT, for approximate energies.
pub const DEFAULT_TOLERANCE_KT: f64 = 1e-3;

protomer_kernel::choices! {
    /// Modes of computing pair energies.
    pub enum EnergyMode {
        /// The direct sum over all pairs of charges.
        Direct = "direct",
        /// Intervals that surely hold the sum, refined until they decide: the decisions of the direct
        /// sum, proven. Slower than calibrated energies.
        Certified = "certified",
        /// Levels of rising accuracy, the plain sum last: the decisions of the plain sum, by a
        /// variance model of the errors that is calibrated at the start.
        Calibrated = "calibrated",
        /// Levels of rising accuracy, for each pair of bodies the first whose error is likely below
        /// a tolerance.
        Approximate = "approximate",
        /// Hard bodies without charges.
        None = "none",
    }
}

/// Basis of the claim that decisions are those of the direct sum.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Promise {
    /// Construction, or proven bounds.
    Certified,
    /// A variance model of the errors, calibrated at the start.
    Calibrated,
    /// No such claim.
    None,
}

impl EnergyMode {
    /// Whether energies have no cut-off and are computed no further than a decision needs.
    pub fn is_by_levels(self) -> bool {
        !matches!(self, EnergyMode::Direct | EnergyMode::None)
    }

    /// Basis of the claim that the decisions of this mode are those of the direct sum.
    pub fn promise(self) -> Promise {
        match self {
            EnergyMode::Direct | EnergyMode::Certified => Promise::Certified,
            EnergyMode::Calibrated => Promise::Calibrated,
            EnergyMode::Approximate | EnergyMode::None => Promise::None,
        }
    }

    /// The tolerance of energies in this mode, kT per pair of bodies: the requested one or the
    /// default; `None` for modes without a tolerance.
    ///
    /// # Errors
    /// For a tolerance that is not positive, or given to a mode without one.
    pub fn tolerance_kt(self, asked_for: Option<f64>) -> Result<Option<f64>> {
        match (self, asked_for) {
            (EnergyMode::Approximate, None) => Ok(Some(DEFAULT_TOLERANCE_KT)),
            (EnergyMode::Approximate, Some(tolerance))
                if tolerance.is_finite() && tolerance > 0.0 =>
            {
                Ok(asked_for)
            }
            (EnergyMode::Approximate, Some(tolerance)) => {
                bail!(
                    "the tolerance is {tolerance} kT; give a positive one, such as --tolerance 1e-3"
                )
            }
            (_, None) => Ok(None),
            (mode, Some(tolerance)) => bail!(
                "a tolerance ({tolerance} kT) applies to approximate energies only, but energies are {}; add \
                 --energy approximate, or omit the tolerance",
                mode.name()
            ),
        }
    }
}

/// The folder name of a salt concentration.
///
/// ```
/// assert_eq!(protomer_protein_verbs::stability::run::salt_label(0.1), "salt_0.100000M");
/// ```
pub fn salt_label(salt_molar: f64) -> String {
    format!("salt_{salt_molar:.6}M")
}

/// The directory of one simulation in that of its sweep.
pub fn replica_directory(directory: &Path, salt_molar: f64, replica: u32) -> PathBuf {
    directory
        .join(salt_label(salt_molar))
        .join(format!("replica_{replica}"))
}

impl Settings for RunSettings {
    /// Excludes the number of sweeps: a run of 1000 sweeps can be continued to 2000.
    fn essential(&self) -> Self {
        Self {
            sweeps: 0,
            ..self.clone()
        }
    }

    /// A single simulation has a directory like that of a sweep.
    fn name(&self) -> Option<&'static str> {
        (self.simulations() == 1).then_some("a simulation")
    }

    fn objection(&self, present: &Self) -> Option<String> {
        (present.sweeps > self.sweeps).then(|| {
            format!(
                "is meant to run to {} sweeps, which is more than {}; ask for at least as many",
                present.sweeps, self.sweeps
            )
        })
    }
}

impl RunSettings {
    /// Description of what holds bodies together in this model, and of what it therefore cannot
    /// answer.
    pub fn what_attracts(&self) -> String {
        let mut attractions = Vec::new();
        if self.energy != Some(EnergyMode::None) {
            attractions.push("opposite charges".to_owned());
        }
        if let Some(ContactTerm {
            scale, strength, ..
        }) = &self.contacts
        {
            let name = scale.name();
            attractions.push(format!("contacts between residues ({name} x {strength})"));
        }
        if self
            .depletant_fraction
            .is_some_and(|fraction| fraction > 0.0)
        {
            attractions.push("depletants".to_owned());
        }
        if attractions.is_empty() {
            return "nothing attracts in this model: that hard bodies come apart says nothing of a \
                    complex"
                .into();
        }
        let attractions = attractions.join(" and ");
        let limitation = match &self.contacts {
            None => {
                "a complex held by hydrophobic contacts, hydrogen bonds or metal ions falls apart in \
                 it; --contacts adds an attraction between residues"
            }
            Some(_) => "hydrogen bonds, metal ions and changes of shape are not in it",
        };
        format!("nothing attracts in this model but {attractions}: {limitation}")
    }

    /// Whether every replica starts from the assembly.
    pub fn is_from_assembly(&self) -> bool {
        self.starts == Starts::Assembly && self.state.is_none()
    }

    /// Number of simulations of a sweep: salt concentrations times replicas.
    pub fn simulations(&self) -> u64 {
        (self.salt_molar.len() as u64).saturating_mul(u64::from(self.replicas))
    }

    /// The tolerance of energies, kT per pair of bodies; `None` where decisions are those of the
    /// direct sum.
    ///
    /// # Errors
    /// As [`EnergyMode::tolerance_kt`].
    pub fn tolerance_of_energy_kt(&self) -> Result<Option<f64>> {
        let energy = self.energy.unwrap_or(EnergyMode::Direct);
        energy.tolerance_kt(self.tolerance_kt)
    }

    /// Trial moves of all replicas at one salt concentration. A cluster move, which may move half of
    /// the bodies, counts as half a sweep.
    pub fn trial_moves_per_salt(&self, bodies: usize) -> f64 {
        let sweeps = f64::from(self.replicas) * self.total_sweeps() as f64;
        sweeps * bodies as f64 * (1.0 + 0.5 * f64::from(self.cluster_moves_per_sweep))
    }

    /// Sweeps of equilibration and production together.
    pub fn total_sweeps(&self) -> u64 {
        self.equilibration_sweeps.saturating_add(self.sweeps)
    }

    /// The next sweep, counted from the start, at which an exchange, a row or a frame is due or the
    /// run ends.
    pub fn next_stop(&self, sweep: u64) -> u64 {
        self.next_output(sweep).min(self.next_exchange(sweep))
    }

    fn next_exchange(&self, sweep: u64) -> u64 {
        match self.exchange_every {
            0 => u64::MAX,
            every => (sweep / every).saturating_add(1).saturating_mul(every),
        }
    }

    fn next_output(&self, sweep: u64) -> u64 {
        if sweep < self.equilibration_sweeps {
            return self.equilibration_sweeps;
        }
        let production = sweep - self.equilibration_sweeps;
        let after = |interval: u64| match interval {
            0 => u64::MAX,
            _ => (production / interval)
                .saturating_add(1)
                .saturating_mul(interval),
        };
        let next = after(self.log_every).min(after(self.trajectory_every));
        self.equilibration_sweeps
            .saturating_add(next)
            .min(self.total_sweeps())
    }

    /// Checks what the types cannot express.
    ///
    /// # Errors
    /// Names the invalid setting.
    pub fn check(&self) -> Result<()> {
        if self.salt_molar.is_empty() {
            bail!("no salt concentration is given; add --salt 10mM,100mM,300mM");
        }
        if self.medium.debye_length_angstrom.is_some() && self.salt_molar.len() > 1 {
            bail!(
                "a given Debye length makes all salt concentrations equivalent; omit --debye, or give one salt concentration"
            );
        }
        for salt in &self.salt_molar {
            range::SALT.require("a concentration of salt_M", *salt)?;
        }
        for (index, salt) in self.salt_molar.iter().enumerate() {
            let same = |near: &f64| salt_label(*near) == salt_label(*salt);
            if let Some(first) = self.salt_molar[..index].iter().position(same) {
                bail!(
                    "salt concentrations {} and {} of the list are the same to 1 µM; list each once, and \
                     raise --replicas for more simulations of it",
                    first + 1,
                    index + 1
                );
            }
        }
        if self.energy.is_some_and(EnergyMode::is_by_levels)
            && self.medium.cutoff_angstrom.is_some()
        {
            bail!("energies by levels have no cut-off; leave out --cutoff, or add --energy direct");
        }
        if self.simulations() > LARGEST_NUMBER_OF_SIMULATIONS {
            bail!(
                "{} salt concentrations with {} replicas each are too many; ask for at most \
                 {LARGEST_NUMBER_OF_SIMULATIONS} simulations",
                self.salt_molar.len(),
                self.replicas
            );
        }
        self.check_ranges()?;
        if self.sweeps < self.log_every {
            bail!(
                "sweeps is {} and log_every {}, so the log would have no rows; raise --sweeps, or lower --log-every",
                self.sweeps,
                self.log_every
            );
        }
        self.tolerance_of_energy_kt()?;
        self.depletants()?;
        self.check_state()?;
        self.check_equilibration()?;
        self.check_terms()?;
        self.check_proton_moves()?;
        self.check_interaction()
    }

    /// The depletants; `None` without.
    ///
    /// # Errors
    /// If one of their two numbers is missing.
    pub fn depletants(&self) -> Result<Option<Depletants>> {
        match (self.depletant_radius_angstrom, self.depletant_fraction) {
            (None, None) => Ok(None),
            (Some(radius_angstrom), Some(reservoir_fraction)) => Ok(Some(Depletants {
                radius_angstrom,
                reservoir_fraction,
            })),
            (Some(_), None) => bail!(
                "depletants need the part of the reservoir that they fill; add --depletant-fraction, such as 0.1"
            ),
            (None, Some(_)) => {
                bail!("depletants need a radius; add --depletant-radius, such as 20, in Å")
            }
        }
    }

    fn check_state(&self) -> Result<()> {
        if self.state.is_some() && self.starts != Starts::Assembly {
            bail!(
                "a state and starts = \"{}\" are two starts; leave out one of them",
                self.starts.name()
            );
        }
        if self.state.is_none() && self.frame.is_some() {
            bail!("--frame is that of a file to start from; add --state FILE.gsd");
        }
        Ok(())
    }

    fn check_equilibration(&self) -> Result<()> {
        if self.starts == Starts::Both && self.replicas < 2 {
            bail!(
                "starts from both the assembly and the fluid need two replicas; add --replicas 2 or \
                 more"
            );
        }
        if self.exchange_every == 0 {
            return Ok(());
        }
        if self.salt_molar.len() < 2 {
            bail!(
                "states are exchanged between salt concentrations, and there is one; list several, \
                 or leave out --exchange-every"
            );
        }
        if self.energy == Some(EnergyMode::None) {
            bail!(
                "hard bodies are the same at every salt concentration; leave out --exchange-every, \
                 or choose another --energy than none"
            );
        }
        Ok(())
    }

    fn check_terms(&self) -> Result<()> {
        if self.desolvation && self.effective_charges.is_none() {
            bail!("desolvation is that of effective charges; add --interaction effective");
        }
        if let Some(contacts) = &self.contacts {
            if contacts.core == ContactCore::Beads {
                bail!(
                    "bodies of a simulation repel each other by their surfaces; leave out core = \
                     \"beads\" of the contact term"
                );
            }
            contacts.potential(self.medium.temperature_kelvin)?;
        }
        Ok(())
    }

    /// Terms of the energy in addition to the charges.
    pub fn further_terms(&self) -> FurtherTerms {
        self.stated_terms()
            .with_insides(self.effective_charges, self.solvent_response)
    }

    /// Terms in addition to the charges, as they are stated.
    pub fn stated_terms(&self) -> StatedTerms {
        StatedTerms {
            contacts: self.contacts,
            desolvation: self.desolvation,
        }
    }

    /// Sets the terms in addition to the charges.
    pub fn set_terms(&mut self, terms: StatedTerms) {
        self.contacts = terms.contacts;
        self.desolvation = terms.desolvation;
    }

    /// Name of the model of these bodies with these terms.
    pub fn model_name(&self, bodies: &[Arc<Body>]) -> &'static str {
        let has_own_charges =
            self.effective_charges.is_none() && self.energy != Some(EnergyMode::None);
        name_of_terms(&self.further_terms(), has_own_charges, bodies)
    }

    /// Choice of `--interaction`; `None` for the bare charges.
    fn choice(&self) -> Option<&'static str> {
        match (self.effective_charges, self.solvent_response) {
            (Some(_), _) => Some("effective"),
            (None, Some(_)) => Some("response"),
            (None, None) => None,
        }
    }

    fn check_interaction(&self) -> Result<()> {
        let Some(choice) = self.choice() else {
            return Ok(());
        };
        if self.effective_charges.is_some() && self.solvent_response.is_some() {
            bail!(
                "effective charges hold the response of the solvent already; leave out one of \
                 effective_charges and solvent_response"
            );
        }
        if self.energy == Some(EnergyMode::None) {
            bail!(
                "hard bodies feel no charges; leave out --interaction {choice}, or choose another \
                 --energy than none"
            );
        }
        for salt_molar in &self.salt_molar {
            require_electrolyte(&self.medium.interaction(Some(*salt_molar))?, choice)?;
        }
        Ok(())
    }
}
