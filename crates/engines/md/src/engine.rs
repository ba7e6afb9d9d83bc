//! Bodies in motion: velocity Verlet for the centres, free rotations between kicks of torque.
//!
//! ```text
//! kick ½ dt   v += F dt/2m,  L += τ dt/2      drift dt   x += v dt, the body turns freely
//! forces      of all pairs, in order          kick ½ dt
//! ```
//!
//! A step is reversible and symplectic. Forces are added in the order of the pairs, whatever thread
//! computed them, so results do not depend on threads.

use crate::added::{Added, AddedEnergies, PairEnergy};
use crate::bath::{self, Ensemble, noise_of, normal_turns, normal_vector, require};
use crate::near::{Felt, Law, Turned, felt};
use crate::neighbours::{Neighbours, Pair};
use crate::pair::central::Central;
use crate::pair::{Form, Interaction};
use crate::rotation;
use crate::state::{Bodies, State};
use crate::{Error, Result};
use protomer_kernel::{Boundary, Rotation, Vec3};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Number of pairs below which one thread computes all.
const WORTH_THREADS: usize = 2000;
/// Pairs that a thread takes at a time.
const SHARE: usize = 256;

/// Steps between two trials of the volume.
const TRIAL_EVERY: u64 = 10;

/// Settings of the motion of bodies.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Interaction between bodies.
    pub interaction: Interaction,
    /// Time step.
    pub time_step: f64,
    /// Ensemble, including the heat bath.
    pub ensemble: Ensemble,
    /// Seed of the noise.
    pub seed: u64,
    /// Whether the pairs are shared among the threads of the pool.
    pub is_threaded: bool,
}

/// Everything that changes during a run, which continues from it bit for bit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Motion {
    /// Positions, orientations and velocities of the bodies.
    pub state: State,
    /// Number of steps done.
    pub steps: u64,
    /// Energy of all pairs, and of the heights.
    pub potential_energy: f64,
    /// Virial: the sum over pairs of force times the vector between the centres.
    pub virial: f64,
    /// Heat that the baths have given, and energy that the barostat has.
    pub heat: f64,
    /// Numbers of refused and of accepted trials of the volume.
    #[serde(default)]
    pub volume_trials: [u64; 2],
    /// Pairs of bodies that may interact.
    pub neighbours: Neighbours,
    forces: Vec<Vec3>,
    /// Torques in space.
    torques: Vec<Vec3>,
}

/// Quantities that a trial of the volume changes.
pub(crate) struct Placement {
    space: Boundary,
    positions: Vec<Vec3>,
    forces: Vec<Vec3>,
    torques: Vec<Vec3>,
    potential_energy: f64,
    virial: f64,
}

impl Motion {
    /// Copy of the quantities that a trial changes, to restore them if it is refused.
    pub(crate) fn placement(&self) -> Placement {
        Placement {
            space: self.state.space,
            positions: self.state.positions.clone(),
            forces: self.forces.clone(),
            torques: self.torques.clone(),
            potential_energy: self.potential_energy,
            virial: self.virial,
        }
    }

    pub(crate) fn put_back(&mut self, placement: Placement) {
        self.state.space = placement.space;
        self.state.positions = placement.positions;
        self.forces = placement.forces;
        self.torques = placement.torques;
        self.potential_energy = placement.potential_energy;
        self.virial = placement.virial;
    }
}

/// Bodies, their settings and their motion so far.
#[derive(Debug, Clone)]
pub struct Engine {
    pub(crate) bodies: Bodies,
    settings: Settings,
    pub(crate) motion: Motion,
    /// Interaction laws, a row and a column for each part of each kind.
    laws: Vec<Law>,
    /// The row of the first part of each kind.
    first_rows: Vec<usize>,
    geometry: Turned,
    felt: Vec<Felt>,
    added: Added,
    /// Turns of the bodies for energies that depend on them.
    turns: Vec<Rotation>,
}

impl Engine {
    /// An engine for bodies that begin in this state.
    ///
    /// # Errors
    /// For a time step or an ensemble out of range, bodies that overlap, and a box that is too
    /// small.
    ///
    /// ```
    /// use protomer_kernel::shape::{builders, polytope::Polytope};
    /// use protomer_kernel::{Boundary, Vec3};
    /// use protomer_md::bath::Ensemble;
    /// use protomer_md::body::Kind;
    /// use protomer_md::engine::{Engine, Settings};
    /// use protomer_md::pair::Form;
    /// use protomer_md::state::{Bodies, State};
    /// let square = Kind::from_polytope(&Polytope::from_shape(&builders::by_name("polygon:4")?)?)?;
    /// let bodies = Bodies::of_one_kind(square, 2);
    /// let places = vec![Vec3::zeros(), Vec3::new(1.6, 0.1, 0.0)];
    /// let mut state = State::at_rest(&bodies, Boundary::Open, places);
    /// state.velocities[1].x = -1.0;
    /// let settings = Settings {
    ///     interaction: Form::Smooth.into(),
    ///     time_step: 1e-4,
    ///     ensemble: Ensemble::Nve,
    ///     seed: 1,
    ///     is_threaded: false,
    /// };
    /// let mut engine = Engine::new(bodies, state, settings)?;
    /// for _ in 0..5000 {
    ///     engine.step(1.0)?;
    /// }
    /// assert!((engine.energy() - 0.5).abs() < 1e-4);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn new(bodies: Bodies, state: State, settings: Settings) -> Result<Self> {
        Self::with_added(bodies, state, settings, Added::default())
    }

    /// An engine for bodies that have energies in addition to their contacts.
    ///
    /// # Errors
    /// As [`Engine::new`]; also for a box that is too short for a table of heights, and for heights at constant pressure.
    pub fn with_added(
        bodies: Bodies,
        mut state: State,
        settings: Settings,
        added: Added,
    ) -> Result<Self> {
        if !bodies.fit(&state) {
            return Err(Error::OtherBodies);
        }
        let count = bodies.count();
        for (body, spin) in state.spins.iter_mut().enumerate() {
            if bodies.kind(body).is_fixed() {
                *spin = Vec3::zeros();
            }
        }
        let motion = Motion {
            steps: 0,
            potential_energy: 0.0,
            virial: 0.0,
            heat: 0.0,
            volume_trials: [0; 2],
            neighbours: Neighbours::find_within(
                &bodies,
                &state,
                &settings.interaction,
                added.range(),
            )?,
            forces: vec![Vec3::zeros(); count],
            torques: vec![Vec3::zeros(); count],
            state,
        };
        let mut engine = Self::continued_with_added(bodies, motion, settings, added)?;
        engine.find_forces()?;
        Ok(engine)
    }

    /// An engine for bodies that go on from where they were.
    ///
    /// # Errors
    /// As [`Engine::new`], and [`Error::OtherBodies`] for a state of other bodies.
    pub fn continued(bodies: Bodies, motion: Motion, settings: Settings) -> Result<Self> {
        Self::continued_with_added(bodies, motion, settings, Added::default())
    }

    /// An engine for bodies that go on from where they were, with the energies in addition to their contacts that they had.
    ///
    /// # Errors
    /// As [`Engine::continued`] and [`Engine::with_added`].
    pub fn continued_with_added(
        bodies: Bodies,
        motion: Motion,
        settings: Settings,
        added: Added,
    ) -> Result<Self> {
        require("the time step", settings.time_step)?;
        settings.ensemble.check()?;
        check_field(&added, &settings.ensemble)?;
        check_interaction(&bodies, &settings.interaction)?;
        let count = bodies.count();
        let dimension = bodies.dimension();
        let fits = bodies.fit(&motion.state) && motion.forces.len() == count;
        if !fits {
            return Err(Error::OtherBodies);
        }
        if bodies.kinds.iter().any(|kind| kind.dimension != dimension) {
            return Err(Error::MixedDimensions);
        }
        added.check(&bodies, &motion.state)?;
        let (mut parts, mut first_rows) = (Vec::new(), Vec::new());
        for kind in &bodies.kinds {
            first_rows.push(parts.len());
            parts.extend(&kind.parts);
        }
        let mut laws = Vec::new();
        for first in &parts {
            for second in &parts {
                laws.push(Law::between(first, second, &settings.interaction));
            }
        }
        // Room for all bodies at once; turned again in every step.
        let geometry = Turned::from_kinds((0..count).map(|body| bodies.kind(body)));
        Ok(Self {
            bodies,
            settings,
            motion,
            laws,
            first_rows,
            geometry,
            felt: Vec::new(),
            added,
            turns: Vec::new(),
        })
    }

    /// The bodies.
    pub fn bodies(&self) -> &Bodies {
        &self.bodies
    }

    /// State of the motion.
    pub fn motion(&self) -> &Motion {
        &self.motion
    }

    /// Settings of the motion.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Counts further steps from this one on: the number of a step says which random numbers it takes.
    pub fn count_from(&mut self, steps: u64) {
        self.motion.steps = steps;
    }

    /// Moves on with another time step and ensemble; the interaction stays.
    ///
    /// # Errors
    /// [`Error::OutOfRange`]; [`Error::FieldAtPressure`] for a constant pressure where bodies have an energy by their height.
    pub fn change_settings(&mut self, settings: Settings) -> Result<()> {
        require("the time step", settings.time_step)?;
        settings.ensemble.check()?;
        check_field(&self.added, &settings.ensemble)?;
        self.settings = Settings {
            interaction: self.settings.interaction,
            ..settings
        };
        Ok(())
    }

    /// Draws the spins of spheroids about their axes at a temperature: contacts never change them, so
    /// they stay as cold as a compression with a bath for all momenta leaves them.
    pub fn draw_free_spins(&mut self, temperature: f64) {
        let motion = &mut self.motion;
        let state = &mut motion.state;
        let seed = [self.settings.seed, motion.steps];
        motion.heat += bath::draw_free_spins(state, &self.bodies, temperature, seed);
    }

    /// The energy: of the pairs and of the motion.
    pub fn energy(&self) -> f64 {
        let kinetic = self.motion.state.kinetic_energies(&self.bodies);
        self.motion.potential_energy + kinetic[0] + kinetic[1]
    }

    /// The part of the potential energy that is in addition to the contacts.
    pub fn added_energies(&self) -> AddedEnergies {
        let motion = &self.motion;
        self.added
            .energies(&self.bodies, &motion.state, &motion.neighbours.pairs)
    }

    /// The energy without the heat that a bath has given: kept by all ensembles with momenta.
    pub fn kept_energy(&self) -> f64 {
        self.energy() - self.motion.heat
    }

    /// Number of translational degrees of freedom, without those of the centre of mass in ensembles
    /// that conserve the momentum. Energies by the height conserve it across the last axis alone.
    pub fn movements(&self) -> usize {
        let (count, dimension) = (self.bodies.count(), self.bodies.dimension());
        let is_free = matches!(
            self.settings.ensemble,
            Ensemble::Nve | Ensemble::Nvt { .. } | Ensemble::Npt { .. }
        );
        let freed = usize::from(is_free && self.added.heights.is_some() && count > 0);
        dimension * count.saturating_sub(usize::from(is_free)) + freed
    }

    /// Number of translational and rotational degrees of freedom.
    fn freedoms(&self) -> usize {
        self.movements() + self.bodies.turns()
    }

    /// Temperatures (kT) of all momenta, of the centres and of the rotations; zero where nothing
    /// moves. Overdamped bodies have the temperature of their bath.
    pub fn temperatures(&self) -> [f64; 3] {
        if let Ensemble::Brownian { temperature, .. } = self.settings.ensemble {
            return [temperature; 3];
        }
        let [moving, turning] = self.motion.state.kinetic_energies(&self.bodies);
        let over = |kinetic: f64, freedoms: usize| 2.0 * kinetic / freedoms.max(1) as f64;
        [
            over(moving + turning, self.freedoms()),
            over(moving, self.movements()),
            over(turning, self.bodies.turns()),
        ]
    }

    /// The pressure: P V = N kT + W/d, with the virial W of the forces between the centres and the
    /// kinetic energy of the centres for N kT. Overdamped bodies have no velocities; the
    /// temperature of the bath stands for them.
    pub fn pressure(&self) -> f64 {
        let dimension = self.bodies.dimension();
        let [moving, _] = self.motion.state.kinetic_energies(&self.bodies);
        let ideal = match self.settings.ensemble {
            Ensemble::Brownian { temperature, .. } => self.bodies.count() as f64 * temperature,
            _ => 2.0 * moving / dimension as f64,
        };
        let virial = self.motion.virial / dimension as f64;
        (ideal + virial) / self.motion.state.volume(dimension)
    }

    /// Advances by one step. The box and the centres shrink by the factor `scale`; 1 leaves them.
    ///
    /// # Errors
    /// [`Error::Met`] if bodies overlap, and [`Error::Diverged`]; the state is then no good.
    pub fn step(&mut self, scale: f64) -> Result<()> {
        let time = self.settings.time_step;
        // Numbers depend on the step alone: a run continues with the same noise.
        let mut noise = noise_of(self.settings.seed, self.motion.steps);
        match self.settings.ensemble {
            Ensemble::Brownian {
                temperature,
                friction,
            } => {
                self.diffuse(temperature, friction, &mut noise);
                self.shrink(scale);
                self.motion
                    .neighbours
                    .refresh(&self.bodies, &self.motion.state)?;
                self.find_forces()?;
            }
            Ensemble::Langevin {
                temperature,
                friction,
            } => {
                // Half a step of friction on either side keeps the integration symmetric.
                let part = 0.5 * friction * time;
                let mut damp = |motion: &mut Motion, bodies: &Bodies| {
                    let state = &mut motion.state;
                    motion.heat += bath::damp(state, bodies, temperature, part, &mut noise);
                };
                damp(&mut self.motion, &self.bodies);
                self.move_on(time, scale)?;
                damp(&mut self.motion, &self.bodies);
            }
            Ensemble::Nvt {
                temperature,
                // Velocities after the second kick are those that the bath acts on.
                relaxation_time,
            } => {
                self.move_on(time, scale)?;
                self.rescale(temperature, relaxation_time, &mut noise);
            }
            Ensemble::Npt {
                temperature,
                relaxation_time,
                pressure,
            } => {
                self.move_on(time, scale)?;
                // Bath first: the trial takes velocities and
                // positions of the canonical distribution.
                self.rescale(temperature, relaxation_time, &mut noise);
                if (self.motion.steps + 1).is_multiple_of(TRIAL_EVERY) {
                    self.try_volume(temperature, pressure, &mut noise)?;
                }
            }
            Ensemble::Nve => self.move_on(time, scale)?,
        }
        self.motion.steps += 1;
        Ok(())
    }

    /// Applies the global thermostat over a step.
    fn rescale(&mut self, temperature: f64, relaxation_time: f64, noise: &mut Noise) {
        let freedoms = self.freedoms();
        let part = self.settings.time_step / relaxation_time;
        let (motion, bodies) = (&mut self.motion, &self.bodies);
        let state = &mut motion.state;
        motion.heat += bath::rescale(state, bodies, freedoms, temperature, part, noise);
    }

    /// Integrates Newton's equations over a step.
    fn move_on(&mut self, time: f64, scale: f64) -> Result<()> {
        // Velocity Verlet: half a kick, the drift, new forces, half a kick.
        self.kick(0.5 * time);
        self.drift(time);
        self.shrink(scale);
        self.motion
            .neighbours
            .refresh(&self.bodies, &self.motion.state)?;
        self.find_forces()?;
        self.kick(0.5 * time);
        Ok(())
    }

    fn kick(&mut self, time: f64) {
        let motion = &mut self.motion;
        let state = &mut motion.state;
        let is_flat = self.bodies.dimension() == 2;
        for body in 0..self.bodies.count() {
            let kind = self.bodies.kind(body);
            state.velocities[body] += time / kind.mass * motion.forces[body];
            if kind.turns() == 0 {
                continue;
            }
            if is_flat {
                state.spins[body].z += time * motion.torques[body].z;
            } else {
                // Torques are in space, spins in the frame of the body.
                let torque = state.rotations[body].inverse() * motion.torques[body];
                state.spins[body] += time * torque;
            }
        }
    }

    fn drift(&mut self, time: f64) {
        let state = &mut self.motion.state;
        for (position, velocity) in state.positions.iter_mut().zip(&state.velocities) {
            *position += time * velocity;
        }
        // Angles in a plane; in space there are none, and the loop is empty.
        for (body, angle) in state.angles_rad.iter_mut().enumerate() {
            let kind = self.bodies.kind(body);
            *angle += time * state.spins[body].z / kind.moments.z;
        }
        for (body, rotation) in state.rotations.iter_mut().enumerate() {
            let kind = self.bodies.kind(body);
            rotation::turn(kind, rotation, &mut state.spins[body], time);
        }
    }

    /// Moves bodies without momenta: a step along the forces, and noise.
    fn diffuse(&mut self, temperature: f64, friction: f64, noise: &mut Noise) {
        let time = self.settings.time_step;
        let motion = &mut self.motion;
        let state = &mut motion.state;
        let is_flat = self.bodies.dimension() == 2;
        for body in 0..self.bodies.count() {
            let kind = self.bodies.kind(body);
            // No momenta in this limit.
            state.velocities[body] = Vec3::zeros();
            state.spins[body] = Vec3::zeros();
            let displacement_per_force = time / (friction * kind.mass);
            let wander = (2.0 * temperature * displacement_per_force).sqrt();
            state.positions[body] += displacement_per_force * motion.forces[body];
            state.positions[body] += wander * normal_vector(noise, kind.dimension);
            if kind.turns() == 0 {
                continue;
            }
            let turns = normal_turns(noise, kind.turns());
            let about = kind.moments.map(|moment| time / (friction * moment));
            let wander = about.map(|about| (2.0 * temperature * about).sqrt());
            if is_flat {
                let torque = motion.torques[body].z;
                state.angles_rad[body] += about.z * torque + wander.z * turns.z;
            } else {
                let rotation = &mut state.rotations[body];
                let torque = rotation.inverse() * motion.torques[body];
                let turn = about.component_mul(&torque) + wander.component_mul(&turns);
                *rotation *= Rotation::from_scaled_axis(turn);
                rotation.renormalize();
            }
        }
    }

    pub(crate) fn shrink(&mut self, scale: f64) {
        if scale == 1.0 {
            return;
        }
        let state = &mut self.motion.state;
        if let Boundary::Periodic { lengths_angstrom } = &mut state.space {
            let flat = self.bodies.dimension() == 2;
            // A plane has no third length to shrink.
            let third = if flat { 1.0 } else { scale };
            lengths_angstrom.component_mul_assign(&Vec3::new(scale, scale, third));
        }
        for position in &mut state.positions {
            *position *= scale;
        }
        // The list's reference places shrink too, so that only true motion counts.
        self.motion.neighbours.shrink(scale);
    }

    /// Computes energy, forces, torques and virial.
    pub(crate) fn find_forces(&mut self) -> Result<()> {
        let motion = &mut self.motion;
        let is_flat = self.bodies.dimension() == 2;
        for body in 0..self.bodies.count() {
            let kind = self.bodies.kind(body);
            if is_flat {
                let angle = motion.state.angles_rad[body];
                self.geometry.turn_flat(body, kind, angle);
            } else {
                let rotation = &motion.state.rotations[body];
                self.geometry.turn_solid(body, kind, rotation);
            }
        }
        motion.forces.fill(Vec3::zeros());
        motion.torques.fill(Vec3::zeros());
        if let Some(pairs) = &self.added.pairs {
            pairs.turns(&self.bodies, &motion.state, &mut self.turns);
        }
        let view = View {
            bodies: &self.bodies,
            state: &motion.state,
            geometry: &self.geometry,
            laws: &self.laws,
            first_rows: &self.first_rows,
            rows: self.bodies.kinds.iter().map(|kind| kind.parts.len()).sum(),
            form: self.settings.interaction.form,
            added: self.added.pairs.as_ref(),
            turns: &self.turns,
        };
        let mut sum = Sum::new(&mut motion.forces, &mut motion.torques);
        let pairs = &mut motion.neighbours.pairs;
        // Few pairs are computed faster than they are shared.
        if self.settings.is_threaded && pairs.len() >= WORTH_THREADS {
            self.felt.resize(pairs.len(), Felt::nothing());
            let shares = pairs.par_chunks_mut(SHARE);
            let shares = shares.zip(self.felt.par_chunks_mut(SHARE));
            shares.for_each(|(pairs, felt)| {
                for (pair, felt) in pairs.iter_mut().zip(felt) {
                    *felt = view.felt(pair, &view.between(pair));
                }
            });
            // Added in the order of the pairs, on one thread:
            // the same bits for any number of threads.
            for (pair, felt) in pairs.iter().zip(&self.felt) {
                sum.add(pair, felt, &view.between(pair));
            }
        } else {
            for pair in pairs {
                let between = view.between(pair);
                let felt = view.felt(pair, &between);
                sum.add(pair, &felt, &between);
            }
        }
        // Copied, as `sum` borrows the forces.
        let (energy, virial, met) = (sum.energy, sum.virial, sum.met);
        motion.potential_energy = energy;
        motion.virial = virial;
        if let Some(heights) = &self.added.heights {
            let dimension = self.bodies.dimension();
            motion.potential_energy += heights.add(&motion.state, dimension, &mut motion.forces);
        }
        if let Some([first, second]) = met {
            return Err(Error::Met { first, second });
        }
        // A NaN anywhere ends in the virial.
        if !virial.is_finite() {
            return Err(Error::Diverged);
        }
        Ok(())
    }
}

type Noise = protomer_kernel::random::CounterRng;

/// Fails for energies by the height in a box that changes.
fn check_field(added: &Added, ensemble: &Ensemble) -> Result<()> {
    match (&added.heights, ensemble) {
        (Some(_), Ensemble::Npt { .. }) => Err(Error::FieldAtPressure),
        _ => Ok(()),
    }
}

/// Fails for an attraction that is none, a central term that only pairs have, and ellipsoids along
/// with bodies with faces.
fn check_interaction(bodies: &Bodies, interaction: &Interaction) -> Result<()> {
    interaction.attraction.check()?;
    if !interaction.attraction.cut_off.is_finite() {
        return Err(Error::OutOfRange {
            what: "the cut-off of the attraction",
            value: interaction.attraction.cut_off,
            expected: "a finite number for bodies in motion",
        });
    }
    if matches!(interaction.central, Central::Printed | Central::Gradient) {
        return Err(Error::CentralTerm);
    }
    let parts = || bodies.kinds.iter().flat_map(|kind| &kind.parts);
    let has_faces = parts().any(|part| !part.is_round());
    if has_faces && parts().any(|part| part.half_axes.is_some()) {
        return Err(Error::EllipsoidBesideFaces);
    }
    Ok(())
}

/// Quantities that forces depend on.
struct View<'a> {
    bodies: &'a Bodies,
    state: &'a State,
    geometry: &'a Turned,
    laws: &'a [Law],
    first_rows: &'a [usize],
    rows: usize,
    form: Form,
    added: Option<&'a PairEnergy>,
    turns: &'a [Rotation],
}

impl View<'_> {
    /// The vector from the first body of a pair to the image of the second.
    fn between(&self, pair: &Pair) -> Vec3 {
        pair.between(self.state)
    }

    /// Interaction of two bodies through two of their parts, with torques about their centres of mass. What the bodies as
    /// wholes do to each other comes with their first parts.
    fn felt(&self, pair: &mut Pair, between: &Vec3) -> Felt {
        let mut felt = self.contact(pair, between);
        if let Some(added) = self.added
            && pair.parts == [0, 0]
        {
            let [first, second] = pair.bodies.map(|body| self.turns.get(body as usize));
            added.add(&mut felt, between, first.zip(second).map(<[_; 2]>::from));
        }
        felt
    }

    /// Repulsion and attraction of two parts, with torques about the centres of mass of their bodies.
    fn contact(&self, pair: &mut Pair, between: &Vec3) -> Felt {
        let numbers = [0, 1].map(|n| (pair.bodies[n] as usize, pair.parts[n] as usize));
        let [row, column] =
            numbers.map(|(body, part)| self.first_rows[self.bodies.kind_of[body]] + part);
        // A row and a column per part of each kind.
        let law = &self.laws[row * self.rows + column];
        // More rows than kinds: some body has several parts.
        let has_unions = self.rows > self.first_rows.len();
        let arms = match has_unions {
            true => numbers.map(|(body, part)| self.geometry.centre(body, part)),
            false => [Vec3::zeros(); 2],
        };
        let between = between + arms[1] - arms[0];
        // Most pairs of the list are farther apart; nothing of them is looked at.
        if between.norm_squared() > law.range * law.range {
            return Felt::nothing();
        }
        let [first, second] = numbers.map(|(body, part)| {
            let kind = self.bodies.kind(body);
            self.geometry.part(body, part, kind)
        });
        let mut felt = felt(first, second, between, law, self.form, &mut pair.hint);
        if has_unions {
            // Forces act at the parts; their arms add torques about the centres of mass.
            felt.torques[0] += arms[0].cross(&felt.force);
            felt.torques[1] -= arms[1].cross(&felt.force);
        }
        felt
    }
}

/// Forces on bodies, added up in the order of the pairs.
struct Sum<'a> {
    forces: &'a mut [Vec3],
    torques: &'a mut [Vec3],
    energy: f64,
    virial: f64,
    met: Option<[usize; 2]>,
}

impl<'a> Sum<'a> {
    fn new(forces: &'a mut [Vec3], torques: &'a mut [Vec3]) -> Self {
        Self {
            forces,
            torques,
            energy: 0.0,
            virial: 0.0,
            met: None,
        }
    }

    fn add(&mut self, pair: &Pair, felt: &Felt, between: &Vec3) {
        // Most listed pairs feel nothing.
        if felt.energy == 0.0 && felt.force == Vec3::zeros() {
            return;
        }
        let [first, second] = pair.bodies.map(|body| body as usize);
        if felt.energy == f64::INFINITY {
            // The first pair that met; others would only say so again.
            self.met.get_or_insert([first, second]);
            return;
        }
        self.energy += felt.energy;
        // The force pushes the first body back along the way.
        self.virial -= felt.force.dot(between);
        self.forces[first] += felt.force;
        self.forces[second] -= felt.force;
        self.torques[first] += felt.torques[0];
        self.torques[second] += felt.torques[1];
    }
}
