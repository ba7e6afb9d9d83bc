//! Networks under load: the minimum of energy less work.
//!
//! Nodes x and strain ε are found together by Newton's method with the Hessian of
//! [`energy`](super::energy),
//!
//! (K_xx K_xε; K_xεᵀ K_εε - ∂w/∂ε) (δx; δε) = -(g_x; g_ε - w),
//!
//! shifted towards steepest descent while it is not positive (Levenberg and Marquardt) and applied
//! to the cell as it then is. w is the load on the cell: V0 Pᵀ F for a nominal stress P (force per
//! area of the unloaded cell), V σ for a Cauchy stress σ (force per area as loaded). Under tens of
//! GPa the two differ by some per cent, so the kind is always named.
//!
//! A load is approached in steps, each from the minimum before (continuation): Newton's method finds
//! no minimum that is far away, or one that the network would not have come to. A step that fails, or
//! that strains the cell by more than a tenth, is halved; one that succeeds is doubled. The curve
//! therefore does not depend on how many loads are listed on the way.

use super::energy::{Configuration, Derivatives, NetworkEnergy};
use super::model::Framework;
use super::newton::{Newton, Step};
use super::work::{CellWork, cell_work};
pub use super::work::{Load, StressKind};
use crate::plane::largest_magnitude;
use crate::{CrystalError, Result};

/// Newton steps after which a minimisation gives up.
const MOST_STEPS: usize = 500;
/// Largest strain and largest displacement (in cell edges) of one step.
const LONGEST_STEP: f64 = 0.05;
/// Forces left on nodes are rounding below this share of the largest entry of the Hessian times a
/// cell edge, and loads left on the cell below this share of that entry times the square of the
/// edge.
const AT_REST: f64 = 1e-12;
/// The first shift of the Hessian's diagonal that is tried when a step fails, in parts of its
/// largest entry.
const FIRST_SHIFT: f64 = 1e-9;
/// The largest shift, at which steps have become far too short to get anywhere.
const LARGEST_SHIFT: f64 = 1e6;
/// Largest change of the cell's lengths, in parts of them, in one step towards a load.
const LARGEST_STRETCH: f64 = 0.1;
/// The smallest step towards a load, in parts of the way to it. A step this small may lead anywhere:
/// the network snaps.
const SMALLEST_LOAD_STEP: f64 = 1.0 / 4096.0;
/// A shift grows by this factor while steps fail.
const SHIFT_GROWTH: f64 = 10.0;
/// A shift shrinks by this factor after a step that does not fail.
const SHIFT_DECAY: f64 = 0.2;

/// A network at rest under a load.
#[derive(Debug, Clone, PartialEq)]
pub struct Loaded {
    /// Nodes and cell.
    pub configuration: Configuration,
    /// Lengths of the cell along the axes over those at the start, less one: engineering strains of
    /// stretch.
    pub stretch: Vec<f64>,
    /// Energy, kcal/mol.
    pub energy_kcal_mol: f64,
    /// Newton steps made.
    pub steps: usize,
    /// Largest force left on a node, kcal/mol/Å.
    pub largest_force_kcal_mol_angstrom: f64,
}

/// The minimum of a network's energy from where it stands: at fixed cell, or with the cell free and
/// under a load.
///
/// ```
/// use protomer_linkage::framework::load::minimise;
/// use protomer_linkage::framework::{Load, StressKind, build::face_centred_cubic};
/// let net = face_centred_cubic(3.0, 7.0)?;
/// let load = Load { axis: 0, stress_kcal_mol_angstrom3: 1e-3, kind: StressKind::Nominal };
/// let loaded = minimise(&net, true, Some(load))?;
/// // E = (C11 - C12)(C11 + 2 C12)/(C11 + C12) = 4 ks / 3a.
/// let youngs = 4.0 * 7.0 / (3.0 * 3.0);
/// assert!((loaded.stretch[0] / (1e-3 / youngs) - 1.0).abs() < 1e-3);
/// # Ok::<(), protomer_linkage::CrystalError>(())
/// ```
///
/// # Errors
/// As [`Framework::check`]; [`CrystalError::NoMinimum`] if the minimum is not reached: a load that
/// the network cannot bear, or a mechanism that it drives without end.
pub fn minimise(framework: &Framework, free_cell: bool, load: Option<Load>) -> Result<Loaded> {
    let energy = NetworkEnergy::new(framework)?;
    let start = Configuration::built(framework);
    Minimiser::new(framework, &energy, &start, free_cell, load)?.run(start)
}

/// The curve of a network under one load after another, each followed from the one before.
///
/// ```
/// use protomer_linkage::framework::load::stretch_curve;
/// use protomer_linkage::framework::{Load, StressKind, build::face_centred_cubic};
/// let net = face_centred_cubic(3.0, 7.0)?;
/// let pulled = |stress| Load {
///     axis: 0,
///     stress_kcal_mol_angstrom3: stress,
///     kind: StressKind::Nominal,
/// };
/// let at_once = stretch_curve(&net, &[pulled(2.0)])?;
/// let in_steps = stretch_curve(&net, &[pulled(0.5), pulled(1.0), pulled(2.0)])?;
/// assert!((at_once[0].stretch[0] - in_steps[2].stretch[0]).abs() < 1e-9);
/// # Ok::<(), protomer_linkage::CrystalError>(())
/// ```
///
/// # Errors
/// As [`minimise`]; [`CrystalError::NoMinimum`] says which load cannot be reached, and how far the
/// network bears it.
pub fn stretch_curve(framework: &Framework, loads: &[Load]) -> Result<Vec<Loaded>> {
    let energy = NetworkEnergy::new(framework)?;
    let built = Configuration::built(framework);
    let mut start = Approach {
        framework,
        energy: &energy,
        stretch: vec![0.0; energy.dimension()],
        configuration: built,
        stress: 0.0,
        steps: 0,
    };
    let mut curve = Vec::with_capacity(loads.len());
    for load in loads {
        curve.push(start.follow(*load)?);
    }
    Ok(curve)
}

/// The way of a network towards a load.
struct Approach<'a> {
    framework: &'a Framework,
    energy: &'a NetworkEnergy,
    /// The last minimum.
    configuration: Configuration,
    stretch: Vec<f64>,
    /// Stress at the last minimum, kcal/mol/Å³.
    stress: f64,
    /// Newton steps towards this load.
    steps: usize,
}

impl Approach<'_> {
    /// The minimum under a load, by steps from the last one.
    fn follow(&mut self, load: Load) -> Result<Loaded> {
        let (start, goal) = (self.stress, load.stress_kcal_mol_angstrom3);
        let (mut done, mut share) = (0.0, 1.0_f64);
        self.steps = 0;
        loop {
            let next = (done + share).min(1.0);
            // The goal itself, not a sum that rounds to its neighbour.
            let stress = if next == 1.0 {
                goal
            } else {
                start + next * (goal - start)
            };
            let step = Load {
                stress_kcal_mol_angstrom3: stress,
                ..load
            };
            let is_smallest = share <= SMALLEST_LOAD_STEP;
            match self.minimum(step) {
                Ok(minimum) if is_smallest || self.is_near(&minimum) => {
                    self.steps += minimum.steps;
                    self.configuration = minimum.configuration.clone();
                    self.stretch.clone_from(&minimum.stretch);
                    self.stress = stress;
                    done = next;
                    share *= 2.0;
                    if done == 1.0 {
                        let steps = self.steps;
                        return Ok(Loaded { steps, ..minimum });
                    }
                }
                Ok(_) => share *= 0.5,
                Err(CrystalError::NoMinimum(_)) if !is_smallest => share *= 0.5,
                Err(CrystalError::NoMinimum(reason)) => return Err(beyond(done, &reason)),
                Err(error) => return Err(error),
            }
        }
    }

    fn minimum(&self, load: Load) -> Result<Loaded> {
        let start = &self.configuration;
        let minimiser = Minimiser::new(self.framework, self.energy, start, true, Some(load))?;
        minimiser.run(start.clone())
    }

    fn is_near(&self, minimum: &Loaded) -> bool {
        let changes = minimum.stretch.iter().zip(&self.stretch);
        changes
            .into_iter()
            .all(|(now, before)| (now - before).abs() <= LARGEST_STRETCH * (1.0 + before))
    }
}

fn beyond(done: f64, reason: &str) -> CrystalError {
    CrystalError::NoMinimum(format!(
        "no equilibrium is found beyond {:.2} % of the way to this load: {reason}",
        100.0 * done
    ))
}

struct Minimiser<'a> {
    framework: &'a Framework,
    energy: &'a NetworkEnergy,
    built: Configuration,
    free_cell: bool,
    load: Option<Load>,
    newton: Newton<'a>,
    /// Shift of the Hessian's diagonal, in parts of its largest entry.
    shift: f64,
}

/// Balance of forces for given nodes and cell.
struct Balance {
    derivatives: Derivatives,
    work: CellWork,
    /// g_ε - w; zero at fixed cell.
    strain_force: Vec<f64>,
    /// The largest entry of the Hessian.
    scale: f64,
    /// The first cell edge.
    edge: f64,
}

impl<'a> Minimiser<'a> {
    fn new(
        framework: &'a Framework,
        energy: &'a NetworkEnergy,
        start: &Configuration,
        free_cell: bool,
        load: Option<Load>,
    ) -> Result<Self> {
        if let Some(load) = load {
            let dimension = energy.dimension();
            if load.axis >= dimension || !load.stress_kcal_mol_angstrom3.is_finite() {
                return Err(CrystalError::BadNetwork(format!(
                    "a load of {load:?} on {dimension} dimensions makes no sense"
                )));
            }
        }
        Ok(Self {
            framework,
            energy,
            built: Configuration::built(framework),
            free_cell,
            load,
            newton: Newton::new(energy, start),
            shift: 0.0,
        })
    }

    fn run(mut self, mut configuration: Configuration) -> Result<Loaded> {
        for steps in 0..MOST_STEPS {
            let balance = self.balance(&configuration);
            if balance.is_at_rest() {
                return Ok(self.loaded(configuration, &balance, steps));
            }
            configuration = self.descend(&configuration, &balance)?;
        }
        Err(CrystalError::NoMinimum(format!(
            "no minimum is found in {MOST_STEPS} steps: see whether a mechanism yields"
        )))
    }

    fn balance(&self, configuration: &Configuration) -> Balance {
        let derivatives = self.energy.derivatives(configuration);
        let work = cell_work(self.framework, configuration, &self.built, self.load);
        let mut strain_force = vec![0.0; work.work.len()];
        if self.free_cell {
            let pairs = derivatives.strain_gradient.iter().zip(&work.work);
            for (force, (g, w)) in strain_force.iter_mut().zip(pairs) {
                *force = g - w;
            }
        }
        let first = configuration.cell_angstrom[0];
        Balance {
            scale: largest_magnitude(&derivatives.hessian),
            edge: first.iter().map(|x| x * x).sum::<f64>().sqrt(),
            derivatives,
            work,
            strain_force,
        }
    }

    fn loaded(&self, configuration: Configuration, balance: &Balance, steps: usize) -> Loaded {
        let mut stretch = Vec::with_capacity(self.energy.dimension());
        for axis in 0..self.energy.dimension() {
            let now = configuration.cell_angstrom[axis][axis];
            stretch.push(now / self.built.cell_angstrom[axis][axis] - 1.0);
        }
        Loaded {
            configuration,
            stretch,
            energy_kcal_mol: balance.derivatives.energy,
            steps,
            largest_force_kcal_mol_angstrom: balance.force(),
        }
    }

    /// A step that goes down: the Hessian is shifted until it is positive and the step lowers the
    /// residual.
    fn descend(
        &mut self,
        configuration: &Configuration,
        balance: &Balance,
    ) -> Result<Configuration> {
        loop {
            if let Some(trial) = self.trial(configuration, balance) {
                self.shift = if self.shift < FIRST_SHIFT {
                    0.0
                } else {
                    SHIFT_DECAY * self.shift
                };
                return Ok(trial);
            }
            if self.shift > LARGEST_SHIFT {
                return Err(CrystalError::NoMinimum(format!(
                    "no minimum is found: a force of {:.2e} kcal/mol/Å and {:.2e} kcal/mol on the \
                     cell remain; see whether a mechanism yields",
                    balance.force(),
                    balance.stress()
                )));
            }
            self.shift = if self.shift == 0.0 {
                FIRST_SHIFT
            } else {
                SHIFT_GROWTH * self.shift
            };
        }
    }

    /// A step with the present shift, if it goes down.
    fn trial(&mut self, configuration: &Configuration, balance: &Balance) -> Option<Configuration> {
        let strain_force = self.free_cell.then_some(&balance.strain_force[..]);
        let step = self.newton.step(
            &balance.derivatives,
            &balance.work.slope,
            strain_force,
            self.shift * balance.scale,
        )?;
        let trial = self.moved(configuration, &step, balance.edge);
        let next = self.balance(&trial);
        let before = balance.residual(balance.edge);
        let less_residual = next.residual(balance.edge) < before;
        // Far from the minimum forces may grow on the way; for nodes alone a drop in energy is as
        // good.
        let less_energy = next.derivatives.energy < balance.derivatives.energy;
        (less_residual || (self.load.is_none() && less_energy)).then_some(trial)
    }

    /// Nodes and cell after a step, which is shortened if it is too long.
    fn moved(&self, configuration: &Configuration, step: &Step, edge: f64) -> Configuration {
        let longest = step.nodes.amax().max(edge * step.strains.amax());
        let excess = longest / (LONGEST_STEP * edge);
        let share = if excess > 1.0 { 1.0 / excess } else { 1.0 };
        let mut trial = configuration.clone();
        for (x, change) in trial.nodes_angstrom.iter_mut().zip(step.nodes.iter()) {
            *x += share * change;
        }
        if self.free_cell {
            let strains = &step.strains * share;
            trial.strain(self.energy.dimension(), strains.as_slice());
        }
        trial
    }
}

impl Balance {
    /// The largest force on a node, kcal/mol/Å.
    fn force(&self) -> f64 {
        largest_magnitude(&self.derivatives.gradient)
    }

    /// The largest force on the cell, kcal/mol.
    fn stress(&self) -> f64 {
        largest_magnitude(&self.strain_force)
    }

    fn is_at_rest(&self) -> bool {
        self.force() <= AT_REST * self.scale * self.edge
            && self.stress() <= AT_REST * self.scale * self.edge * self.edge
    }

    /// The squared forces on nodes, and on the cell over an edge.
    fn residual(&self, edge: f64) -> f64 {
        let mut nodes = 0.0;
        for g in &self.derivatives.gradient {
            nodes += g * g;
        }
        let mut cell = 0.0;
        for g in &self.strain_force {
            cell += g * g;
        }
        nodes + cell / (edge * edge)
    }
}
