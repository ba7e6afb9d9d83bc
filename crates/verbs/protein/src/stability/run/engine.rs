//! From an assembly and an interaction to a system with an energy model: what all replicas of a
//! sweep share.

use crate::assemblies::assembly_file::Assembly;
use crate::stability::effective::{EffectiveBody, EffectiveStore, SoluteModel};
use crate::stability::energy_tables::{EnergyTables, PotentialTable};
use crate::stability::interaction::{ContactDefinition, Definition, ScreenedCoulomb};
use crate::stability::run::titratable;
use crate::stability::run::{
    DEFAULT_TOLERANCE_KT, EnergyCosts, EnergyMode, Promise, RunSettings, Starts,
};
use crate::stability::terms::FurtherTerms;
use anyhow::{Context, Result, bail};
use protomer_kernel::potential::Yukawa;
use protomer_kernel::{Boundary, Pose, Vec3};
use protomer_mc::energy::terms::TermsOfKinds;
use protomer_mc::energy::{DirectSum, EnergyModel, NoCharges, TermsByType, WithTerms};
use protomer_mc::hard::overlapping_pairs;
use protomer_mc::pair::{BodyPair, Charged, Core, Terms};
use protomer_mc::{BodyType, Interaction, McError, Settings, System};
use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::sync::Arc;

/// Body types prepared once and shared by every simulation of an assembly.
#[derive(Debug, Clone)]
pub struct Engine {
    assembly: Assembly,
    types: Vec<Arc<BodyType>>,
    tables: Arc<EnergyTables>,
    terms: Option<TermsByType>,
    effective_store: Arc<EffectiveStore>,
    /// Effective charges of each kind of body, if they stand in the place of those of the bodies.
    effective_bodies: Option<Vec<EffectiveBody>>,
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
            terms: None,
            effective_store: Arc::default(),
            effective_bodies: None,
        })
    }

    /// The same engine with energy tables from elsewhere.
    pub fn with_tables(self, tables: Arc<EnergyTables>) -> Self {
        Self { tables, ..self }
    }

    /// The same engine with effective charges from elsewhere, for
    /// [`in_medium`](Self::in_medium).
    pub fn with_effective_store(self, effective_store: Arc<EffectiveStore>) -> Self {
        Self {
            effective_store,
            ..self
        }
    }

    /// The same engine with effective charges in the place of the charges of each body, in this
    /// medium.
    ///
    /// # Errors
    /// As [`EffectiveStore::charges`].
    pub fn with_effective_charges(
        mut self,
        interaction: &ScreenedCoulomb,
        solute: &SoluteModel,
    ) -> Result<Self> {
        let (mut types, mut bodies) = (Vec::new(), Vec::new());
        for body in &self.assembly.bodies {
            let charges = self.effective_store.charges(body, interaction, solute)?;
            bodies.push(EffectiveBody::new(body, &charges));
            let kind = BodyType::from_body(body)?.with_charges(&charges.charges);
            types.push(Arc::new(kind));
        }
        self.types = types;
        self.effective_bodies = Some(bodies);
        Ok(self)
    }

    /// The engine for one medium of a run: with effective charges and further terms if the run has
    /// them.
    ///
    /// # Errors
    /// As [`with_effective_charges`](Self::with_effective_charges) and
    /// [`with_terms`](Self::with_terms).
    pub fn in_medium(&self, run: &RunSettings, interaction: &ScreenedCoulomb) -> Result<Self> {
        let engine = self.clone();
        let engine = match &run.effective_charges {
            Some(solute) => engine.with_effective_charges(interaction, solute)?,
            None => engine,
        };
        engine.with_terms(&run.further_terms(), interaction)
    }

    /// Properties of the effective charges of each kind of body; `None` where the charges of the
    /// bodies themselves interact.
    pub fn effective_bodies(&self) -> Option<&[EffectiveBody]> {
        self.effective_bodies.as_deref()
    }

    /// The same engine with further terms in addition to the charges, in this medium.
    ///
    /// # Errors
    /// As [`FurtherTerms::prepare`].
    pub fn with_terms(
        mut self,
        further: &FurtherTerms,
        interaction: &ScreenedCoulomb,
    ) -> Result<Self> {
        if !further.is_none() {
            let kinds: Vec<&BodyType> = self.types.iter().map(AsRef::as_ref).collect();
            let bodies = self.assembly.bodies.iter().zip(&kinds);
            let charged: Vec<_> = bodies
                .map(|(body, kind)| (body.as_ref(), *kind, &kind.charges))
                .collect();
            let prepared = further.prepare(&charged, interaction)?;
            let pair_terms =
                |first, second| Ok::<_, McError>(prepared.terms(&kinds, first, second));
            self.terms = Some(TermsByType::new(kinds.len(), pair_terms)?);
        }
        Ok(self)
    }

    /// The assembly.
    pub fn assembly(&self) -> &Assembly {
        &self.assembly
    }

    /// The kinds of bodies as simulations know them.
    pub fn body_types(&self) -> &[Arc<BodyType>] {
        &self.types
    }

    /// The first two bodies and what acts between them, for integrals over their poses; with tables of their charges
    /// where many energies are needed.
    ///
    /// # Errors
    /// If the charges have no screening.
    pub fn body_pair(
        &self,
        interaction: &ScreenedCoulomb,
        contact_gap_angstrom: f64,
        with_tables: bool,
    ) -> Result<BodyPair> {
        let kind = |number: usize| Arc::clone(&self.types[self.assembly.kinds[number]]);
        let (first, second) = (kind(0), kind(1));
        let charged = Charged::new(interaction.yukawa()?, &first.charges, &second.charges)?;
        let charged = match with_tables {
            // Bodies of one kind have one table; `ptr_eq` tells it without comparing charges.
            true => charged.with_tables(Arc::ptr_eq(&first, &second)),
            false => charged,
        };
        let mut potential = Terms(vec![Arc::new(charged)]);
        if let Some(terms) = &self.terms {
            let kinds = &self.assembly.kinds;
            // The further terms act beside the charges and have no tables.
            potential
                .0
                .extend(terms.terms((kinds[0], kinds[1])).0.iter().cloned());
        }
        Ok(BodyPair {
            first,
            second,
            potential,
            core: Core::Surfaces,
            contact_gap_angstrom,
        })
    }

    /// Terms of the energy of each two kinds of bodies, for energies of poses that have nothing to do with each
    /// other: by pairs of kinds, the lower first, with tables that all pairs share.
    ///
    /// # Errors
    /// If the charges have no screening, or the tables take more memory than is allowed.
    pub fn pair_potentials(&self, interaction: &ScreenedCoulomb) -> Result<TermsOfKinds> {
        let yukawa = interaction.yukawa()?;
        let mut charged = BTreeMap::new();
        for (second, second_type) in self.types.iter().enumerate() {
            for (first, first_type) in self.types[..=second].iter().enumerate() {
                let pair = Charged::new(yukawa, &first_type.charges, &second_type.charges)?;
                charged.insert((first, second), pair);
            }
        }
        let reaches = charged.values().filter_map(Charged::table_reach_angstrom);
        let reach_angstrom = reaches.fold(0.0, f64::max);
        let tables = self.tables.tables(&self.types, &yukawa, reach_angstrom)?;
        let with_terms = |(kinds, pair): ((usize, usize), Charged)| {
            let pair = match pair.table_reach_angstrom() {
                Some(_) => pair
                    .with_shared_tables([kinds.0, kinds.1].map(|kind| Arc::clone(&tables[kind]))),
                None => pair,
            };
            let mut potential = Terms(vec![Arc::new(pair)]);
            if let Some(terms) = &self.terms {
                potential.0.extend(terms.terms(kinds).0.iter().cloned());
            }
            (kinds, potential)
        };
        Ok(charged.into_iter().map(with_terms).collect())
    }

    /// Terms of the energy in addition to the charges; `None` if there are none.
    pub fn terms(&self) -> Option<&TermsByType> {
        self.terms.as_ref()
    }

    /// The system with the bodies at other places.
    ///
    /// # Errors
    /// If there is not a pose for each body, or one lies outside a wall.
    pub fn system_at(&self, poses: &[Pose]) -> Result<System> {
        let kinds = &self.assembly.kinds;
        if poses.len() != kinds.len() {
            bail!(
                "{} poses were given for {} bodies",
                poses.len(),
                kinds.len()
            );
        }
        let placed: Vec<_> = kinds.iter().copied().zip(poses.iter().copied()).collect();
        let types = self.types.clone();
        Ok(System::new(types, &placed, self.assembly.boundary)?)
    }

    /// The system with the bodies at their places.
    ///
    /// # Errors
    /// If a placement lies outside a wall.
    pub fn system(&self) -> Result<System> {
        self.system_at(&self.assembly.poses)
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
        if run.proton_moves_per_sweep > 0 {
            let groups = titratable::groups_of_bodies(&self.assembly.bodies, interaction)?;
            let charges = Box::new(DirectSum::regulated(interaction.yukawa()?, groups));
            return Ok(match &self.terms {
                Some(terms) => Box::new(WithTerms::new(charges, terms.clone())),
                None => charges,
            });
        }
        let levels = |yukawa: Yukawa| self.tables.levels(&self.system()?, yukawa);
        let charges: Box<dyn EnergyModel> = match self.settings(run, interaction)?.interaction {
            Interaction::YukawaCertified(yukawa) => {
                Box::new(self.tables.certified(&self.system()?, yukawa))
            }
            Interaction::YukawaCalibrated(yukawa) => Box::new(levels(yukawa)?),
            Interaction::YukawaApproximate {
                yukawa,
                tolerance_kt,
            } => Box::new(levels(yukawa)?.with_tolerance(tolerance_kt)),
            other => other.model(&self.system()?),
        };
        Ok(match &self.terms {
            Some(terms) => Box::new(WithTerms::new(charges, terms.clone())),
            None => charges,
        })
    }

    /// The settings with everything chosen that they leave open. A directory that was begun keeps
    /// its energy mode, as long as that makes the decisions of the direct sum.
    ///
    /// # Errors
    /// As [`costs_of`](Self::costs_of).
    pub fn resolved(&self, run: &RunSettings, begun: Option<EnergyMode>) -> Result<RunSettings> {
        // Only the direct sum holds for charges that change.
        let is_cut = run.medium.cutoff_angstrom.is_some() || run.proton_moves_per_sweep > 0;
        let energy = match (run.energy, begun) {
            (Some(energy), _) => energy,
            (None, _) if is_cut => EnergyMode::Direct,
            (None, Some(begun)) if begun.promise() != Promise::None => begun,
            (None, _) => self.costs_of(run)?.fastest(),
        };
        Ok(with_energy(run, energy))
    }

    /// The settings as [`resolved`](Self::resolved) gives them where a run goes on, without the costs of
    /// energies, for which charges may have to be fitted.
    pub(crate) fn resolved_as_begun(run: &RunSettings, begun: Option<EnergyMode>) -> RunSettings {
        let is_cut = run.medium.cutoff_angstrom.is_some() || run.proton_moves_per_sweep > 0;
        let usual = run.energy.or(is_cut.then_some(EnergyMode::Direct));
        with_energy(run, usual.or(begun).unwrap_or(EnergyMode::Direct))
    }

    /// Estimates the cost of energies in this run at one salt concentration. Effective charges are
    /// those at the first: their number hardly depends on the salt.
    ///
    /// # Errors
    /// As [`with_effective_charges`](Self::with_effective_charges).
    pub fn costs_of(&self, run: &RunSettings) -> Result<EnergyCosts> {
        let trials = run.trial_moves_per_salt(self.assembly.len());
        let interaction = run.medium.interaction(run.salt_molar.first().copied())?;
        if run.effective_charges.is_none() {
            return self.costs(&interaction, trials);
        }
        let engine = self.in_medium(run, &interaction)?;
        engine.costs(&interaction, trials)
    }

    /// Estimates the cost of energies in one medium, for this many trial moves.
    ///
    /// # Errors
    /// If the interaction makes no sense.
    pub fn costs(&self, interaction: &ScreenedCoulomb, trial_moves: f64) -> Result<EnergyCosts> {
        // The number of cells hardly depends on the reach.
        const REACH_ANGSTROM: f64 = 300.0;
        let of_type = |kind: &Arc<BodyType>| {
            let evaluations = PotentialTable::evaluations(&kind.charges, REACH_ANGSTROM);
            (kind.charges.len(), evaluations)
        };
        let types: Vec<_> = self.types.iter().map(of_type).collect();
        let images = self.images_of_a_partner(interaction)?;
        let kinds = &self.assembly.kinds;
        Ok(EnergyCosts::estimate(&types, kinds, images, trial_moves))
    }

    /// Number of images of another body that a body interacts with, for bodies spread evenly over
    /// the box; one at least, for those that are near.
    fn images_of_a_partner(&self, interaction: &ScreenedCoulomb) -> Result<f64> {
        let system = self.system()?;
        let Boundary::Periodic { .. } = system.boundary() else {
            return Ok(1.0);
        };
        let reach = DirectSum::new(interaction.yukawa()?).range_angstrom(&system);
        let ball = 4.0 / 3.0 * PI * reach.powi(3);
        Ok((ball / system.boundary().volume_angstrom3()).max(1.0))
    }

    /// Warning about what a run in open space can and cannot answer; `None` with a box or a wall.
    pub fn open_space_warning(&self) -> Option<String> {
        let edge_angstrom = self.suggested_box_angstrom()?;
        Some(format!(
            "warning: the assembly has no box: bodies that come apart drift away for ever. The run shows \
             whether contacts last as many sweeps as it has, and no equilibrium: no half salt, no K_D; \
             R_g measures how far the bodies have drifted. For an equilibrium give the assembly a box: \
             \"box_angstrom\": [{edge_angstrom}, {edge_angstrom}, {edge_angstrom}] in its file"
        ))
    }

    /// An edge for a box, Å, in which an assembly in open space has as much space as matter about it;
    /// `None` if it has a box or a wall.
    fn suggested_box_angstrom(&self) -> Option<f64> {
        if !matches!(self.assembly.boundary, Boundary::Open) {
            return None;
        }
        const WIDTHS: f64 = 2.0;
        const STEP_ANGSTROM: f64 = 50.0;
        let (mut low, mut high) = (Vec3::repeat(f64::MAX), Vec3::repeat(f64::MIN));
        // The hard radius, since what has to fit into the box is the bodies.
        for (kind, pose) in self.assembly.kinds.iter().zip(&self.assembly.poses) {
            let radius = self.types[*kind].hard_radius_angstrom();
            low = low.inf(&pose.position.add_scalar(-radius));
            high = high.sup(&pose.position.add_scalar(radius));
        }
        let width_angstrom = (high - low).max().max(0.0);
        // In whole steps: the number is a proposal and reads better round.
        Some(STEP_ANGSTROM * (WIDTHS * width_angstrom / STEP_ANGSTROM).ceil().max(1.0))
    }

    /// Refuses what open space has not: a fluid to start from, and an equilibrium that exchanges
    /// between salts would sample.
    ///
    /// # Errors
    /// Says what to give.
    pub fn require_space_for(&self, run: &RunSettings) -> Result<()> {
        let Some(edge_angstrom) = self.suggested_box_angstrom() else {
            return Ok(());
        };
        let wanted = match (run.starts, run.exchange_every) {
            (Starts::Both | Starts::Fluid, _) => {
                "a fluid to start from needs a box: in open space bodies cannot be scattered"
            }
            (Starts::Assembly, 1..) => {
                "exchanges between salts sample an equilibrium, and open space has none: bodies that \
                 come apart drift away for ever"
            }
            (Starts::Assembly, 0) => return Ok(()),
        };
        bail!(
            "{wanted}; give the assembly a box, \"box_angstrom\": [{edge_angstrom}, {edge_angstrom}, \
             {edge_angstrom}] in its file, or leave out --starts and --exchange-every"
        )
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
        if let Some(depletants) = run.depletants()? {
            depletants
                .require_room(&system)
                .context("the box does not suit the depletants")?;
        }
        if run.proton_moves_per_sweep > 0 {
            for interaction in interactions {
                titratable::groups_of_bodies(&self.assembly.bodies, interaction)?;
            }
        }
        // Every salt: the reach of the charges grows as the salt falls.
        for interaction in interactions {
            // Without tables: what counts is the reach of the charges.
            let model: Box<dyn EnergyModel> = match run.energy {
                Some(EnergyMode::None) => Box::new(NoCharges),
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
        let trials = run.trial_moves_per_salt(self.assembly.len());
        let energy = match run.energy {
            Some(energy) => energy,
            None => self.costs(interaction, trials)?.fastest(),
        };
        // Tables hold the whole potential and know no cut-off.
        if energy.is_by_levels() && interaction.cutoff_angstrom.is_finite() {
            bail!("energies by levels have no cut-off; leave out --cutoff, or add --energy direct");
        }
        let interaction = match energy {
            EnergyMode::None => Interaction::HardOnly,
            EnergyMode::Certified => Interaction::YukawaCertified(interaction.yukawa()?),
            EnergyMode::Calibrated => Interaction::YukawaCalibrated(interaction.yukawa()?),
            EnergyMode::Direct => Interaction::YukawaDirect(interaction.yukawa()?),
            EnergyMode::Approximate => Interaction::YukawaApproximate {
                yukawa: interaction.yukawa()?,
                tolerance_kt: energy
                    .tolerance_kt(run.tolerance_kt)?
                    .unwrap_or(DEFAULT_TOLERANCE_KT),
            },
        };
        Ok(Settings {
            equilibration_sweeps: run.equilibration_sweeps,
            cluster_moves_per_sweep: run.cluster_moves_per_sweep,
            binding_moves_per_sweep: run.binding_moves_per_sweep,
            proton_moves_per_sweep: run.proton_moves_per_sweep,
            depletants: run.depletants()?,
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

/// The settings with their energies, and with what follows from these.
fn with_energy(run: &RunSettings, energy: EnergyMode) -> RunSettings {
    let is_uncut = energy != EnergyMode::None && run.medium.cutoff_angstrom.is_none();
    let mut resolved = RunSettings {
        energy: Some(energy),
        contact_definition: Some(ContactDefinition::BetweenSurfaces),
        ..run.clone()
    };
    // Stated where it applies only, so that settings of hard bodies do not change with it.
    resolved.medium.definition = is_uncut.then_some(Definition::NoCutOff);
    resolved
}
