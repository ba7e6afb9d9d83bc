//! The loop: sweeps of trial moves.

use crate::checkpoint::{Checkpoint, type_names};
use crate::depletants::{Depletion, Moved};
use crate::energy::LevelReport;
use crate::energy::{Effort, EnergyModel, PairEnergy, Pairs, compared_kt};
use crate::hard::{HardBodies, overlapping_pairs};
use crate::moves::binding;
use crate::moves::proposal::Proposal;
use crate::moves::step_sizes::Tuner;
use crate::moves::{BindingMove, HalfTurn, Kind, StepSizes, cluster, single};
use crate::neighbours::{Neighbours, Ranges};
use crate::observables::{Observables, cluster_sizes, contacts, r_g_angstrom, survival};
use crate::statistics::Statistics;
use crate::system::{System, Trial};
use crate::{McError, Result, Settings};
use protomer_kernel::cells::require_minimum_image;
use protomer_kernel::random::{CounterRng, Purpose};
use protomer_kernel::{Boundary, Pose};
use std::ops::ControlFlow;

/// Outcome of a call of [`Simulation::run_until`].
///
/// ```
/// use protomer_kernel::{Boundary, Pose};
/// use protomer_mc::{BodyType, Interaction, Outcome, Settings, Simulation, System};
/// use std::ops::ControlFlow;
/// # use protomer_kernel::{TriangleMesh, Vec3};
/// # use std::sync::Arc;
/// # let mesh = TriangleMesh::cuboid(&Vec3::repeat(-5.0), &Vec3::repeat(5.0));
/// # let cube = Arc::new(BodyType::new("cube", &mesh, &[])?);
/// # let system = System::new(vec![cube], &[(0, Pose::identity())], Boundary::Open)?;
/// let mut simulation = Simulation::new(system, Settings::new(Interaction::HardOnly), 1, 0)?;
/// let outcome = simulation.run_until(10, &mut |_| ControlFlow::Break(()))?;
/// assert_eq!((outcome, simulation.sweep()), (Outcome::Stopped, 1));
/// # Ok::<(), protomer_mc::McError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outcome {
    /// The requested number of sweeps is done.
    Finished,
    /// The observer asked to stop; the simulation can be continued.
    Stopped,
}

/// A Monte Carlo simulation of one replica.
///
/// A sweep is one trial move per body (of bodies drawn at random), then the geometric cluster
/// moves, then those that form and dissolve contacts. Trial move s of a replica draws its random numbers from the stream (seed, replica, s), so
/// nothing random needs to be saved.
///
/// ```
/// use protomer_kernel::{Boundary, Pose};
/// use protomer_mc::{BodyType, Interaction, Settings, Simulation, System};
/// use std::{ops::ControlFlow, sync::Arc};
/// # use protomer_kernel::{TriangleMesh, Vec3};
/// # let mesh = TriangleMesh::tetrahedron(5.0);
/// # let body = Arc::new(BodyType::new("tetrahedron", &mesh, &[])?);
/// # let far = Pose { position: Vec3::new(30.0, 0.0, 0.0), ..Pose::identity() };
/// # let system = System::new(vec![body], &[(0, Pose::identity()), (0, far)], Boundary::Open)?;
/// let settings = Settings::new(Interaction::HardOnly);
/// let (seed, replica) = (1, 0);
/// let mut simulation = Simulation::new(system, settings, seed, replica)?;
/// simulation.run_until(10, &mut |_| ControlFlow::Continue(()))?;
/// assert_eq!(simulation.sweep(), 10);
/// assert!(simulation.observables().r_g_angstrom > 0.0);
/// # Ok::<(), protomer_mc::McError>(())
/// ```
pub struct Simulation {
    system: System,
    settings: Settings,
    seed: u64,
    replica: u32,
    sweep: u64,
    energy: Box<dyn EnergyModel>,
    hard: HardBodies,
    depletion: Option<Depletion>,
    neighbours: Neighbours,
    tuners: Vec<Tuner>,
    statistics: Statistics,
    native_contacts: Vec<(usize, usize)>,
    near: Vec<usize>,
}

impl Simulation {
    /// A new simulation, before its first move.
    ///
    /// # Errors
    /// [`McError::OverlappingStart`] lists the pairs that overlap; [`McError::BadSetting`];
    /// [`McError::NonFiniteEnergy`];
    /// [`KernelError::BoxTooSmall`](protomer_kernel::KernelError::BoxTooSmall).
    pub fn new(system: System, settings: Settings, seed: u64, replica: u32) -> Result<Self> {
        let model = settings.interaction.model(&system);
        Self::with_model(system, settings, model, seed, replica)
    }

    /// Variant of [`Simulation::new`] with a custom energy model instead of the one named in the
    /// settings.
    ///
    /// # Errors
    /// As [`Simulation::new`].
    pub fn with_model(
        system: System,
        settings: Settings,
        mut energy: Box<dyn EnergyModel>,
        seed: u64,
        replica: u32,
    ) -> Result<Self> {
        settings.check()?;
        let neighbours = neighbours(&system, energy.as_ref(), &settings)?;
        let depletion = depletion(&system, &settings)?;
        let pairs = overlapping_pairs(&system);
        if !pairs.is_empty() {
            return Err(McError::OverlappingStart { pairs });
        }
        // After the test for overlaps: energies of overlapping bodies may be infinite.
        energy.reset(&system)?;
        let steps = StepSizes {
            translation_angstrom: settings.translation_step_angstrom,
            rotation_rad: settings.rotation_step_rad,
        };
        let tuners = system
            .types()
            .iter()
            .map(|_| Tuner::new(steps, largest_translation(&system)))
            .collect();
        Ok(Self {
            hard: HardBodies::new(system.len()),
            depletion,
            statistics: Statistics::new(system.types().len()),
            native_contacts: contacts(&system, settings.contact_gap_angstrom),
            near: Vec::new(),
            sweep: 0,
            system,
            settings,
            seed,
            replica,
            energy,
            neighbours,
            tuners,
        })
    }

    /// Continues from a checkpoint. `system` gives the body types and the boundary; its poses
    /// are replaced.
    ///
    /// # Errors
    /// [`McError::ForeignCheckpoint`] if the checkpoint was written from another system.
    pub fn resume(system: System, checkpoint: Checkpoint) -> Result<Self> {
        let model = checkpoint.settings.interaction.model(&system);
        Self::resume_with_model(system, checkpoint, model)
    }

    /// Variant of [`Simulation::resume`] with a custom energy model.
    ///
    /// # Errors
    /// As [`Simulation::resume`].
    pub fn resume_with_model(
        mut system: System,
        checkpoint: Checkpoint,
        mut energy: Box<dyn EnergyModel>,
    ) -> Result<Self> {
        checkpoint.check_system(&system)?;
        for (body, pose) in checkpoint.poses.iter().enumerate() {
            system.set_pose(body, *pose);
        }
        // The energies that decided before the interruption,
        // not new ones, which may differ in the last bits.
        energy.take_protonation(&system, &checkpoint.protonation)?;
        energy.restore(&system, &checkpoint.energies)?;
        Ok(Self {
            neighbours: neighbours(&system, energy.as_ref(), &checkpoint.settings)?,
            // Empty: the memory of gaps saves time and never changes a decision.
            hard: HardBodies::new(system.len()),
            depletion: depletion(&system, &checkpoint.settings)?,
            near: Vec::new(),
            settings: checkpoint.settings,
            seed: checkpoint.seed,
            replica: checkpoint.replica,
            sweep: checkpoint.sweep,
            tuners: checkpoint.tuners,
            statistics: checkpoint.statistics,
            native_contacts: checkpoint.native_contacts,
            system,
            energy,
        })
    }

    /// The same simulation, before its first move, that counts these native contacts (ascending)
    /// instead of those of its own start.
    pub fn with_native_contacts(mut self, contacts: Vec<(usize, usize)>) -> Self {
        self.native_contacts = contacts;
        self
    }

    /// The energy of its bodies at the poses of another simulation of the same bodies, kT: the
    /// present state is not touched.
    ///
    /// # Errors
    /// [`McError::NonFiniteEnergy`] names the pair.
    pub fn energy_at_kt(&self, poses: &[Pose], effort: Effort) -> Result<f64> {
        self.energy
            .energy_elsewhere_kt(&self.system.with_poses(poses), Pairs::All, effort)
    }

    /// Puts all bodies at other poses, which must be free of overlaps.
    ///
    /// # Errors
    /// As [`Simulation::energy_at_kt`].
    pub(crate) fn take_poses(&mut self, poses: &[Pose]) -> Result<()> {
        // Everything that depends on poses is built again.
        self.system = self.system.with_poses(poses);
        self.neighbours = neighbours(&self.system, self.energy.as_ref(), &self.settings)?;
        self.hard = HardBodies::new(self.system.len());
        self.energy.reset(&self.system)
    }

    /// The simulation with its bodies at the poses of another system, and with other settings and energies: steps, counts and the
    /// number of sweeps go on, and with that the random numbers.
    ///
    /// # Errors
    /// As [`Simulation::with_model`]; also for another number of bodies.
    pub fn placed(
        &self,
        system: System,
        settings: Settings,
        energy: Box<dyn EnergyModel>,
    ) -> Result<Self> {
        if system.len() != self.system.len() {
            let (given, count) = (system.len(), self.system.len());
            return Err(McError::BadSystem(format!(
                "there are {given} poses for {count} bodies; give one for each"
            )));
        }
        let begun = Self::with_model(system, settings, energy, self.seed, self.replica)?;
        Ok(Self {
            sweep: self.sweep,
            tuners: self.tuners.clone(),
            statistics: self.statistics.clone(),
            native_contacts: self.native_contacts.clone(),
            ..begun
        })
    }

    /// The state between two sweeps, from which a run continues bit for bit.
    pub fn checkpoint(&self) -> Checkpoint {
        Checkpoint {
            version: Checkpoint::VERSION,
            settings: self.settings,
            seed: self.seed,
            replica: self.replica,
            sweep: self.sweep,
            type_names: type_names(&self.system),
            boundary: *self.system.boundary(),
            poses: self.system.poses().to_vec(),
            energies: self.energy.pairs(&self.system),
            tuners: self.tuners.clone(),
            statistics: self.statistics.clone(),
            native_contacts: self.native_contacts.clone(),
            protonation: self.energy.protonation().to_vec(),
        }
    }

    /// Runs until a total of `sweep` sweeps are done, calling the observer after each; the
    /// observer may stop the run.
    ///
    /// # Errors
    /// [`McError::NonFiniteEnergy`] names the trial move and the pair.
    pub fn run_until(
        &mut self,
        sweep: u64,
        observer: &mut dyn FnMut(&Simulation) -> ControlFlow<()>,
    ) -> Result<Outcome> {
        while self.sweep < sweep {
            self.advance()?;
            if observer(self).is_break() {
                return Ok(Outcome::Stopped);
            }
        }
        Ok(Outcome::Finished)
    }

    /// Makes one sweep.
    fn advance(&mut self) -> Result<()> {
        let bodies = self.system.len() as u64;
        let cluster_moves = u64::from(self.settings.cluster_moves_per_sweep);
        // Steps number the random streams: each sweep owns its range, whatever was accepted.
        let first_step = self.sweep * (bodies + cluster_moves);
        for step in first_step..first_step + bodies {
            self.single_move(step)
                .map_err(|error| at_step(error, step))?;
        }
        for step in first_step + bodies..first_step + bodies + cluster_moves {
            self.cluster_move(step)
                .map_err(|error| at_step(error, step))?;
        }
        let binding_moves = u64::from(self.settings.binding_moves_per_sweep);
        // Streams of their own purpose, so their numbers may start at zero again.
        let first_step = self.sweep * binding_moves;
        for step in first_step..first_step + binding_moves {
            self.binding_move(step)
                .map_err(|error| at_step(error, step))?;
        }
        let proton_moves = u64::from(self.settings.proton_moves_per_sweep);
        let first_step = self.sweep * proton_moves;
        for step in first_step..first_step + proton_moves {
            self.proton_move(step)
                .map_err(|error| at_step(error, step))?;
        }
        self.sweep += 1;
        // What was counted while step sizes were learning is dropped.
        if self.sweep == self.settings.equilibration_sweeps {
            self.statistics = Statistics::new(self.system.types().len());
        }
        Ok(())
    }

    /// Makes trial moves 0 to `moves` of this replica's stream without cluster moves or tuning
    /// between them, and reports each decision, for benchmarks and for comparisons of energy
    /// models. Meant for a new simulation; sweeps are not counted.
    ///
    /// # Errors
    /// As [`Simulation::run_until`].
    pub fn trial_moves(&mut self, moves: u64, decided: &mut dyn FnMut(bool)) -> Result<()> {
        for step in 0..moves {
            decided(
                self.single_move(step)
                    .map_err(|error| at_step(error, step))?,
            );
        }
        Ok(())
    }

    /// Makes one trial move and returns whether it was accepted.
    fn single_move(&mut self, step: u64) -> Result<bool> {
        let mut rng = CounterRng::new(self.seed, self.replica, step);
        // The random number first: the model may stop as soon as the decision is certain.
        let budget_kt = -rng.uniform().ln();
        let body = rng.index(self.system.len());
        let kind = if rng.uniform() < self.settings.rotation_fraction {
            Kind::Rotation
        } else {
            Kind::Translation
        };
        let body_type = self.system.type_index(body);
        let proposed = single::propose(
            self.system.pose(body),
            kind,
            &self.tuners[body_type].steps,
            &mut rng,
        );
        let accepted = self.try_pose(body, proposed, budget_kt, &mut rng)?;
        self.statistics.count(kind, body_type, accepted);
        // Steps are frozen afterwards: adapting for ever would break detailed balance.
        if self.sweep < self.settings.equilibration_sweeps {
            self.tuners[body_type].learn(kind, accepted, self.settings.target_acceptance);
        }
        Ok(accepted)
    }

    /// Moves the body if it overlaps nothing, no depletant forbids it and the energy rises by less than the budget.
    fn try_pose(
        &mut self,
        body: usize,
        pose: Pose,
        budget_kt: f64,
        rng: &mut CounterRng,
    ) -> Result<bool> {
        // Cheapest first: the wall, then surfaces, then depletants, then energies.
        if !self.system.boundary().contains(&pose.position) {
            return Ok(false);
        }
        let trial = Trial {
            system: &self.system,
            body,
            pose: self.system.tidy(pose),
        };
        let place = &trial.pose.position;
        self.neighbours
            .find_touching(&self.system, place, &mut self.near);
        self.near.retain(|partner| *partner != body);
        if self.hard.blocks(&trial, &self.near) {
            return Ok(false);
        }
        let poses = [(body, trial.pose)];
        let moved = Moved {
            poses: &poses,
            is_rigid: true,
        };
        if !self.depletants_allow(&moved, rng) {
            return Ok(false);
        }
        let places = [&self.system.pose(body).position, place];
        // Partners of the old place and the new one: the change of energy has terms of both.
        self.neighbours
            .find_at_both(&self.system, places, &mut self.near);
        self.near.retain(|partner| *partner != body);
        if !self.energy.accept(&trial, &self.near, budget_kt)? {
            self.energy.reject();
            return Ok(false);
        }
        let pose = trial.pose;
        // Cells, poses and energies change together: the next move asks all three.
        self.move_bodies(&[(body, pose)]);
        self.energy.commit(&[body]);
        Ok(true)
    }

    fn cluster_move(&mut self, step: u64) -> Result<()> {
        let mut rng = CounterRng::new(self.seed, self.replica, step);
        let seed_body = rng.index(self.system.len());
        let reach = self
            .settings
            .cluster_axis_reach_angstrom
            .unwrap_or(self.system.hard_range_angstrom());
        let turn = HalfTurn::random(&self.system, seed_body, reach, &mut rng);
        let (hard, energy) = (&mut self.hard, self.energy.as_mut());
        let members = cluster::grow(
            &self.system,
            seed_body,
            &turn,
            hard,
            energy,
            &self.neighbours,
            &mut rng,
        )?;
        let trial_pose =
            |body: &usize| (*body, self.system.tidy(turn.apply(self.system.pose(*body))));
        let poses: Vec<(usize, Pose)> = members.iter().map(trial_pose).collect();
        self.statistics.cluster_moves += 1;
        let moved = Moved {
            poses: &poses,
            is_rigid: true,
        };
        if !self.depletants_allow(&moved, &mut rng) {
            self.energy.reject();
            return Ok(());
        }
        self.move_bodies(&poses);
        self.energy.commit(&members);
        self.statistics.cluster_bodies += members.len() as u64;
        Ok(())
    }

    /// Makes one move that forms or dissolves contacts, of a random kind.
    fn binding_move(&mut self, step: u64) -> Result<()> {
        let (seed, replica) = (self.seed, self.replica);
        let mut rng = CounterRng::for_purpose(seed, replica, step, Purpose::BindingMove);
        let kinds = binding::available(&self.system);
        let kind = kinds[rng.index(kinds.len())];
        let accepted = self.binding_move_by(kind, &mut rng, |allowance_kt| allowance_kt)?;
        self.statistics.binding.count(kind, accepted);
        Ok(())
    }

    /// Makes one move that changes protons of a random body.
    fn proton_move(&mut self, step: u64) -> Result<()> {
        let (seed, replica) = (self.seed, self.replica);
        let mut rng = CounterRng::for_purpose(seed, replica, step, Purpose::ProtonMove);
        let body = rng.index(self.system.len());
        let place = &self.system.pose(body).position;
        self.neighbours
            .find_at_both(&self.system, [place, place], &mut self.near);
        self.near.retain(|partner| *partner != body);
        let accepted = self
            .energy
            .change_protons(&self.system, body, &self.near, &mut rng)?;
        self.statistics.protons.count(accepted);
        Ok(())
    }

    /// Net charge of each body, e; `None` where charges are fixed.
    pub fn net_charges_e(&self) -> Option<Vec<f64>> {
        self.energy.net_charges_e()
    }

    /// Titratable groups of each body, true where charged; empty where charges are fixed.
    pub fn protonation(&self) -> &[Vec<bool>] {
        self.energy.protonation()
    }

    /// A move of this kind by a rule: what that makes of the allowance decides.
    pub(crate) fn binding_move_by(
        &mut self,
        kind: BindingMove,
        rng: &mut CounterRng,
        rule: impl Fn(f64) -> f64,
    ) -> Result<bool> {
        let budget_kt = -rng.uniform().ln();
        let gap_angstrom = self.settings.contact_gap_angstrom;
        let Some(proposal) = binding::propose(kind, &self.system, gap_angstrom, rng) else {
            return Ok(false);
        };
        // The move's probability ratio enters as an energy that it allows or costs.
        let budget_kt = budget_kt + rule(proposal.allowance_kt);
        match proposal.poses[..] {
            // One body: the model's own decision with all
            // its levels. Several: energies from scratch.
            [(body, pose)] => self.try_pose(body, pose, budget_kt, rng),
            _ => self.try_poses(&proposal, budget_kt, rng),
        }
    }

    /// Moves several bodies if they overlap nothing, no depletant forbids it and the energy rises by less than the budget.
    fn try_poses(
        &mut self,
        proposal: &Proposal,
        budget_kt: f64,
        rng: &mut CounterRng,
    ) -> Result<bool> {
        let poses = &proposal.poses;
        let boundary = self.system.boundary();
        if poses
            .iter()
            .any(|(_, pose)| !boundary.contains(&pose.position))
        {
            return Ok(false);
        }
        let new = self.system.with_moved(poses);
        let bodies: Vec<usize> = poses.iter().map(|(body, _)| *body).collect();
        if self.overlap_of_moved(&new, &bodies, proposal.is_rigid) {
            return Ok(false);
        }
        let moved = Moved {
            poses,
            is_rigid: proposal.is_rigid,
        };
        if !self.depletants_allow(&moved, rng) {
            return Ok(false);
        }
        let rise_kt = |effort| -> Result<f64> {
            let energy_kt = |system| {
                self.energy
                    // Pairs with a moved body only; all others cancel.
                    .energy_elsewhere_kt(system, Pairs::With(&bodies), effort)
            };
            Ok(energy_kt(&new)? - energy_kt(&self.system)?)
        };
        if compared_kt(budget_kt, rise_kt)? >= budget_kt {
            return Ok(false);
        }
        self.move_bodies(poses);
        // The model followed no single move, so it starts again from the new poses.
        self.energy.reset(&self.system)?;
        Ok(true)
    }

    /// Whether no depletant forbids a move; none are there without depletants.
    fn depletants_allow(&self, moved: &Moved<'_>, rng: &mut CounterRng) -> bool {
        let (system, neighbours) = (&self.system, &self.neighbours);
        let depletion = self.depletion.as_ref();
        depletion.is_none_or(|depletion| depletion.allows(system, neighbours, moved, rng))
    }

    /// Whether a moved body overlaps another; bodies that move as one do not meet each other.
    fn overlap_of_moved(&mut self, new: &System, bodies: &[usize], is_rigid: bool) -> bool {
        for &body in bodies {
            for other in 0..new.len() {
                let has_moved = bodies.binary_search(&other).is_ok();
                let is_looked_at = match has_moved {
                    // A rigid group keeps its inner distances; others are tested once per pair.
                    true => !is_rigid && body < other,
                    false => true,
                };
                if is_looked_at && self.hard.overlap(&new.pair(body, other)) {
                    return true;
                }
            }
        }
        false
    }

    /// Moves these bodies to their new poses, which are already normalised, so that they equal,
    /// bit for bit, those used for the energies.
    fn move_bodies(&mut self, poses: &[(usize, Pose)]) {
        for (body, pose) in poses {
            self.neighbours
                .moved(*body, &self.system.pose(*body).position, &pose.position);
            self.system.set_pose(*body, *pose);
        }
    }

    /// The observables of the current state.
    ///
    /// ```
    /// use protomer_kernel::{Boundary, Pose};
    /// use protomer_mc::{BodyType, Interaction, Settings, Simulation, System};
    /// # use protomer_kernel::{TriangleMesh, Vec3};
    /// # use std::sync::Arc;
    /// # let mesh = TriangleMesh::cuboid(&Vec3::repeat(-5.0), &Vec3::repeat(5.0));
    /// # let cube = Arc::new(BodyType::new("cube", &mesh, &[])?);
    /// let place = |x| Pose { position: Vec3::new(x, 0.0, 0.0), ..Pose::identity() };
    /// let row = [(0, place(0.0)), (0, place(14.0)), (0, place(40.0))];
    /// // Cubes with edges of 10 Å
    /// let system = System::new(vec![cube], &row, Boundary::Open)?;
    /// let start = Simulation::new(system, Settings::new(Interaction::HardOnly), 1, 0)?.observables();
    /// assert_eq!((start.contacts, start.clusters, start.largest_cluster), (1, 2, 2));
    /// assert_eq!((start.native_contacts, start.bound_fraction), (Some(1.0), 1.0 - 1.0 / 3.0));
    /// # Ok::<(), protomer_mc::McError>(())
    /// ```
    pub fn observables(&self) -> Observables {
        let present = contacts(&self.system, self.settings.contact_gap_angstrom);
        let clusters = cluster_sizes(self.system.len(), &present);
        let alone = clusters.iter().filter(|size| **size == 1).count();
        Observables {
            sweep: self.sweep,
            energy_kt: self.energy.total_kt(&self.system),
            r_g_angstrom: r_g_angstrom(&self.system, |_| 1.0),
            r_g_volume_weighted_angstrom: r_g_angstrom(&self.system, |body| {
                self.system.body_type(body).volume_angstrom3
            }),
            native_contacts: survival(&self.native_contacts, &present),
            contacts: present.len(),
            largest_cluster: clusters.first().copied().unwrap_or(0),
            clusters: clusters.len(),
            bound_fraction: 1.0 - alone as f64 / self.system.len().max(1) as f64,
        }
    }

    /// Memory used by the energy model, bytes.
    pub fn energy_memory_bytes(&self) -> usize {
        self.energy.memory_bytes()
    }

    /// The largest error bound of the pair energies used so far, kT; zero for direct sums.
    /// A continued simulation counts from the point of continuation.
    pub fn energy_error_bound_kt(&self) -> f64 {
        self.energy.error_bound_kt(&self.system)
    }

    /// Basis of the decisions of an energy model that makes them by levels; `None` for other
    /// models.
    pub fn energy_levels(&self) -> Option<LevelReport> {
        self.energy.levels()
    }

    /// The bodies and their poses.
    pub fn system(&self) -> &System {
        &self.system
    }

    /// Sweeps done.
    pub fn sweep(&self) -> u64 {
        self.sweep
    }

    /// The settings.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// The step sizes in use, by body type.
    pub fn step_sizes(&self) -> Vec<StepSizes> {
        self.tuners.iter().map(|tuner| tuner.steps).collect()
    }

    /// Acceptance counts.
    pub fn statistics(&self) -> &Statistics {
        &self.statistics
    }

    /// The pairs in contact at the start.
    pub fn native_contacts(&self) -> &[(usize, usize)] {
        &self.native_contacts
    }

    /// The energies of all pairs in range, kT.
    ///
    /// ```
    /// use protomer_kernel::{Boundary, Pose, potential::Yukawa};
    /// use protomer_mc::{BodyType, Interaction, Settings, Simulation, System};
    /// # use protomer_kernel::{TriangleMesh, Vec3};
    /// # use std::sync::Arc;
    /// # let mesh = TriangleMesh::cuboid(&Vec3::repeat(-5.0), &Vec3::repeat(5.0));
    /// let charged = Arc::new(BodyType::new("cube", &mesh, &[(Vec3::zeros(), 2.0)])?);
    /// let place = |x| Pose { position: Vec3::new(x, 0.0, 0.0), ..Pose::identity() };
    /// let system = System::new(vec![charged], &[(0, place(0.0)), (0, place(20.0))], Boundary::Open)?;
    /// let yukawa = Yukawa::new(7.0, 0.1, 48.0)?;
    /// let settings = Settings::new(Interaction::YukawaDirect(yukawa));
    /// let energies = Simulation::new(system, settings, 1, 0)?.pair_energies();
    /// assert!((energies[0].energy_kt - 4.0 * yukawa.energy_kt(20.0)).abs() < 1e-12);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn pair_energies(&self) -> Vec<PairEnergy> {
        self.energy.pairs(&self.system)
    }
}

/// The depletants of the settings around these bodies.
fn depletion(system: &System, settings: &Settings) -> Result<Option<Depletion>> {
    let depletants = settings.depletants.as_ref();
    depletants
        .map(|depletants| Depletion::new(depletants, system))
        .transpose()
}

/// Checks that the box is large enough: no body may touch two images of another, and the energy
/// model has its own say.
///
/// # Errors
/// [`KernelError::BoxTooSmall`](protomer_kernel::KernelError::BoxTooSmall);
/// [`McError::UnscreenedInBox`] and [`McError::ReachesTooFar`].
pub fn require_room(system: &System, energy: &dyn EnergyModel) -> Result<()> {
    require_minimum_image(system.boundary(), system.hard_range_angstrom())?;
    energy.require_room(system)
}

/// Neighbours in ranges that hold surfaces, charges and depletants.
fn neighbours(
    system: &System,
    energy: &dyn EnergyModel,
    settings: &Settings,
) -> Result<Neighbours> {
    require_room(system, energy)?;
    let depletants = settings.depletants.as_ref();
    let ranges = Ranges {
        hard_angstrom: system.hard_range_angstrom(),
        interaction_angstrom: energy.range_angstrom(system),
        reach_angstrom: energy.reach_angstrom(system),
        depletion_angstrom: depletants.map_or(0.0, |spheres| spheres.range_angstrom(system)),
    };
    Ok(Neighbours::new(system, ranges))
}

/// Largest translation that is of use: half the box, or two diameters in open space.
fn largest_translation(system: &System) -> f64 {
    match system.boundary() {
        Boundary::Periodic { lengths_angstrom } => 0.5 * lengths_angstrom.min(),
        Boundary::SphereWall { radius_angstrom } => *radius_angstrom,
        Boundary::Open => 2.0 * system.hard_range_angstrom(),
    }
}

fn at_step(error: McError, step: u64) -> McError {
    match error {
        McError::NonFiniteEnergy {
            first,
            second,
            energy_kt,
            ..
        } => McError::NonFiniteEnergy {
            step,
            first,
            second,
            energy_kt,
        },
        other => other,
    }
}
