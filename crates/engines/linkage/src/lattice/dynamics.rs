//! One step in time.
//!
//! Störmer-Verlet with the rods kept by SHAKE and RATTLE:
//!
//! s(t+h) = s + v h + (a + M⁻¹ Jᵀ λ) h²/2, with λ such that every rod has its length at t + h,
//! v(t+h) = v + (a + M⁻¹ Jᵀ λ + a(t+h)) h/2 - M⁻¹ J(t+h)ᵀ μ, with μ such that J v = 0 at t + h.
//!
//! λ starts from the multipliers of the accelerations (eq. 23 of the paper) and is improved by
//! chord iteration, λ -= A⁻¹ σ 2/h², with A = J M⁻¹ Jᵀ factored once per state: the same factors
//! serve the velocities of the step that arrives there, the start of λ, and all iterations of the
//! step that leaves.
//!
//! Measured on one core of a virtual Xeon (family 6, model 207, shared with other work), processor
//! time, by `cargo bench -p protomer-linkage --bench lattice`, for r0 = 0.136, a step of 1e-3 and
//! rods that turn by at most 0.005 or so per step:
//!
//! | squares | steps per second | corrections per step | ms per step | J and A factored | one solution | one σ |
//! |---|---|---|---|---|---|---|
//! | 10 x 10 | 22 000 | 1.9 | 0.046 | 0.018 | 0.004 | 0.002 |
//! | 32 x 32 | 1790 | 1.3 | 0.56 | 0.27 | 0.054 | 0.017 |
//! | 100 x 100 | 84 | 3.1 | 11.9 | 4.4 | 0.86 | 0.18 |
//! | 316 x 316 | 3.5 | 5.8 | 286 | 73 | 22 | 2.7 |

use super::force::Force;
use super::network::Network;
use super::rods::RodSystem;
use super::state::State;
use crate::plane::largest_magnitude;
use crate::{CrystalError, Result};
use std::sync::Arc;

/// Rods are brought this close to their lengths, plus the rounding of the largest coordinate.
const ROD_TOLERANCE: f64 = 1e-13;
/// Rods whose error no longer halves are as near as rounding allows within this many tolerances.
const STALLED_WITHIN: f64 = 4.0;
/// An error that grows by this factor in one correction does not converge.
const DIVERGED: f64 = 1e3;
/// The largest |J v| that a projection leaves.
const VELOCITY_TOLERANCE: f64 = 1e-13;
/// A projection leaves less than this share of |J v|: rounding of the solution.
const PROJECTION_LEAVES: f64 = 1e-11;
/// Projections of the velocities: the second and third only remove what rounding left.
const MOST_PROJECTIONS: usize = 3;
/// A step whose rods are not back after so many corrections is too large.
const MOST_CORRECTIONS: usize = 60;
/// A rod that turns by this angle in a step keeps the energy to about 1e-3.
const GOOD_TURN_PER_STEP: f64 = 0.1;
/// A start whose rods are farther than this from their lengths is refused.
const LARGEST_VIOLATION_AT_START: f64 = 1e-6;

/// Integrator of the motion of a network between collisions.
///
/// [`prepare`](Dynamics::prepare) at a state, then any number of [`drift`](Dynamics::drift)s to see
/// where it would be after some time, then [`arrive`](Dynamics::arrive), which is `prepare` at the
/// new state as well. [`step`](Dynamics::step) is a drift and an arrival.
///
/// ```
/// use protomer_linkage::lattice::{Dynamics, Edges, Network, Square, Start, StartVelocities};
/// use std::sync::Arc;
/// let start = Start {
///     velocities: StartVelocities::Checkerboard { rate: -1.0 },
///     ..Start::default()
/// };
/// let network = Network::lattice(2, 2, 1.0, Square::default(), Edges::Open, start.angle)?;
/// let mut state = start.build(&network, 0)?.state;
/// let energy = state.kinetic_energy(&network);
/// let mut dynamics = Dynamics::new(Arc::new(network), Vec::new(), &state)?;
/// for _ in 0..100 {
///     dynamics.step(&mut state, 0.01)?;
/// }
/// assert!((state.time - 1.0).abs() < 1e-12);
/// assert!((state.kinetic_energy(dynamics.network()) / energy - 1.0).abs() < 1e-4);
/// # Ok::<(), protomer_linkage::CrystalError>(())
/// ```
pub struct Dynamics {
    network: Arc<Network>,
    forces: Vec<Box<dyn Force>>,
    rods: RodSystem,
    /// Accelerations at the prepared state.
    accelerations: Vec<f64>,
    potential_energy: f64,
    /// Multipliers of eq. 23 at the prepared state.
    start: Vec<f64>,
    /// Multipliers of the last drift.
    multipliers: Vec<f64>,
    /// Change of the multipliers per length of the drift, from the first drift from the prepared
    /// state: a shorter one then begins near its end. (Kept from state to state it would help
    /// further, but make results depend on the past.)
    slope: Vec<f64>,
    /// Whether `slope` is that of the prepared state.
    has_slope: bool,
    /// Length of the last drift.
    last_step: f64,
    /// Corrections of rod lengths in all drifts.
    corrections: u64,
    sigma: Vec<f64>,
    drifted: Vec<f64>,
    /// Positions of a drift before the rods act, or velocities of an arrival.
    base: Vec<f64>,
}

impl Dynamics {
    /// The dynamics of this network under these forces, prepared at this state.
    ///
    /// # Errors
    /// Those of [`Network::check`], [`State::check`] and [`prepare`](Dynamics::prepare), and
    /// [`CrystalError::BadState`] for rods that do not have their lengths.
    pub fn new(network: Arc<Network>, forces: Vec<Box<dyn Force>>, state: &State) -> Result<Self> {
        network.check()?;
        state.check(&network)?;
        let rods = RodSystem::new(&network);
        let (coordinates, count) = (state.positions.len(), rods.len());
        let mut dynamics = Self {
            network,
            forces,
            rods,
            accelerations: vec![0.0; coordinates],
            potential_energy: 0.0,
            start: vec![0.0; count],
            multipliers: vec![0.0; count],
            slope: vec![0.0; count],
            has_slope: false,
            last_step: 0.0,
            corrections: 0,
            sigma: vec![0.0; count],
            drifted: vec![0.0; coordinates],
            base: vec![0.0; coordinates],
        };
        let sigma = &mut dynamics.sigma;
        let (rod, violation) = dynamics.rods.violations(&state.positions, sigma);
        if violation.is_nan() || violation.abs() >= LARGEST_VIOLATION_AT_START {
            return Err(CrystalError::BadState(format!(
                "rod {rod} is {violation:+e} longer than its length at the start; project the \
                 state onto the rods first"
            )));
        }
        dynamics.prepare(state)?;
        Ok(dynamics)
    }

    /// The network.
    pub fn network(&self) -> &Arc<Network> {
        &self.network
    }

    /// The rods, linearised and factored at the prepared state.
    pub fn rods(&mut self) -> &mut RodSystem {
        &mut self.rods
    }

    /// Potential energy at the prepared state.
    pub fn potential_energy(&self) -> f64 {
        self.potential_energy
    }

    /// Corrections of rod lengths made in all drifts so far.
    pub fn corrections(&self) -> u64 {
        self.corrections
    }

    /// Forces of the rods (positive pushes their ends apart) in the last drift.
    pub fn multipliers(&self) -> &[f64] {
        &self.multipliers
    }

    fn turning_rate(&mut self, state: &State) -> f64 {
        self.rods
            .largest_turning_rate(&state.positions, &state.velocities)
    }

    /// Computes forces, J and A at this state.
    ///
    /// # Errors
    /// [`CrystalError::OverConstrained`] or [`CrystalError::NotFinite`].
    pub fn prepare(&mut self, state: &State) -> Result<()> {
        self.prepare_positions(&state.positions, state.time)?;
        self.prepare_velocities(&state.velocities);
        Ok(())
    }

    fn prepare_positions(&mut self, positions: &[f64], time: f64) -> Result<()> {
        self.accelerations.fill(0.0);
        self.potential_energy = 0.0;
        for force in &self.forces {
            self.potential_energy +=
                force.accelerate(&self.network, positions, &mut self.accelerations);
        }
        self.rods.linearize(positions, time)
    }

    fn prepare_velocities(&mut self, velocities: &[f64]) {
        self.rods
            .acceleration_deficit(velocities, &self.accelerations, &mut self.start);
        self.rods.solve(&mut self.start);
        self.has_slope = false;
    }

    /// Computes where the squares would be `step` after the prepared state, with rods and forces
    /// obeyed and nothing else in the way.
    ///
    /// # Errors
    /// [`CrystalError::StepTooLarge`] if the rods cannot be brought back to their lengths.
    pub fn drift(&mut self, state: &State, step: f64, positions: &mut [f64]) -> Result<()> {
        let half_square = 0.5 * step * step;
        self.predict(state, step, half_square);
        // A step of zero divides by nothing below.
        if half_square == 0.0 {
            positions.copy_from_slice(&self.base);
            return Ok(());
        }
        let extent = largest_magnitude(&self.base).max(1.0);
        // Coordinates far from the origin round more coarsely than rods may be wrong.
        let tolerance = ROD_TOLERANCE + 4.0 * f64::EPSILON * extent;
        let mut before = f64::INFINITY;
        for correction in 0.. {
            positions.copy_from_slice(&self.base);
            self.rods
                .add_response(&self.multipliers, half_square, positions);
            let (rod, violation) = self.rods.violations(positions, &mut self.sigma);
            let error = violation.abs();
            // No longer halving and nearly there: rounding, not divergence.
            let stalled = error >= 0.5 * before && error <= STALLED_WITHIN * tolerance;
            if error <= tolerance || stalled {
                self.corrections += correction as u64;
                // Only the first drift from a state has corrections
                // that say how λ depends on the length.
                self.remember_slope(step);
                break;
            }
            let diverges = !violation.is_finite() || error > DIVERGED * before;
            if diverges || correction == MOST_CORRECTIONS {
                return Err(self.step_too_large(state, step, rod, violation));
            }
            before = error;
            self.rods.solve(&mut self.sigma);
            // Chord iteration: A of the prepared state serves for all corrections.
            for (multiplier, sigma) in self.multipliers.iter_mut().zip(&self.sigma) {
                *multiplier -= sigma / half_square;
            }
        }
        Ok(())
    }

    /// Positions without the rods, and the multipliers from which the corrections start.
    fn predict(&mut self, state: &State, step: f64, half_square: f64) {
        let moving = state.positions.iter().zip(&state.velocities);
        let moving = moving.zip(&self.accelerations);
        for (base, ((s, v), a)) in self.base.iter_mut().zip(moving) {
            *base = s + v * step + a * half_square;
        }
        // Along the line through both ends, a drift of another length begins near its own end.
        if self.has_slope {
            add(&mut self.multipliers, step - self.last_step, &self.slope);
        } else {
            self.multipliers.copy_from_slice(&self.start);
        }
        self.last_step = step;
    }

    fn remember_slope(&mut self, step: f64) {
        if self.has_slope {
            return;
        }
        let ends = self.multipliers.iter().zip(&self.start);
        for (slope, (end, start)) in self.slope.iter_mut().zip(ends) {
            *slope = (end - start) / step;
        }
        self.has_slope = true;
    }

    fn step_too_large(
        &mut self,
        state: &State,
        time_step: f64,
        rod: usize,
        violation: f64,
    ) -> CrystalError {
        self.has_slope = false;
        let slow_enough = GOOD_TURN_PER_STEP / self.turning_rate(state);
        CrystalError::StepTooLarge {
            time: state.time,
            time_step,
            rod,
            violation,
            suggested_time_step: slow_enough.min(0.5 * time_step.abs()),
        }
    }

    /// Completes the step whose [`drift`](Dynamics::drift) gave these positions: velocities at its
    /// end. The state is then the one at the end, and `self` is prepared there.
    ///
    /// # Errors
    /// As [`prepare`](Dynamics::prepare); the state is then as it was.
    pub fn arrive(&mut self, state: &mut State, step: f64, positions: &[f64]) -> Result<()> {
        let half = 0.5 * step;
        // Half a kick with the old accelerations and rods, half with the new ones.
        self.base.copy_from_slice(&state.velocities);
        add(&mut self.base, half, &self.accelerations);
        self.rods
            .add_response(&self.multipliers, half, &mut self.base);
        self.prepare_positions(positions, state.time + step)?;
        add(&mut self.base, half, &self.accelerations);
        state.positions.copy_from_slice(positions);
        state.time += step;
        // Buffers change places: no list is copied or allocated in a step.
        std::mem::swap(&mut state.velocities, &mut self.base);
        // RATTLE: velocities are brought along the rods at the new positions.
        self.project_velocities(&mut state.velocities);
        self.prepare_velocities(&state.velocities);
        Ok(())
    }

    /// Removes from the velocities what would change the lengths of the rods, v -= M⁻¹ Jᵀ A⁻¹ J v,
    /// until nothing is left.
    pub fn project_velocities(&mut self, velocities: &mut [f64]) {
        project(
            &mut self.rods,
            velocities,
            VELOCITY_TOLERANCE,
            &mut self.sigma,
        );
    }

    /// Accelerations at the prepared state: of the forces alone, and with those of the rods (eq. 23
    /// of the paper).
    pub fn accelerations_into(&self, free: &mut [f64], total: &mut [f64]) {
        free.copy_from_slice(&self.accelerations);
        total.copy_from_slice(&self.accelerations);
        self.rods.add_response(&self.start, 1.0, total);
    }

    /// Prepares the next drift after a change of the velocities at the prepared state, as by
    /// impacts. Removes from them what would change the lengths of the rods.
    pub fn velocities_changed(&mut self, velocities: &mut [f64]) {
        self.project_velocities(velocities);
        self.prepare_velocities(velocities);
    }

    /// Makes one step without collisions.
    ///
    /// # Errors
    /// As [`drift`](Dynamics::drift) and [`arrive`](Dynamics::arrive); the state is then as it was.
    pub fn step(&mut self, state: &mut State, step: f64) -> Result<()> {
        // Taken out, since the drift borrows everything else.
        let mut positions = std::mem::take(&mut self.drifted);
        let result = self
            .drift(state, step, &mut positions)
            .and_then(|()| self.arrive(state, step, &positions));
        self.drifted = positions;
        result
    }
}

/// v -= M⁻¹ Jᵀ A⁻¹ J v until |J v| is within the tolerance, at the positions at which the rods are
/// linearised.
pub(crate) fn project(
    rods: &mut RodSystem,
    velocities: &mut [f64],
    tolerance: f64,
    scratch: &mut [f64],
) {
    // More than once only where rounding of the solution is above the tolerance.
    for _ in 0..MOST_PROJECTIONS {
        rods.apply(velocities, scratch);
        let rate = largest_magnitude(scratch);
        if rate <= tolerance {
            return;
        }
        rods.solve(scratch);
        rods.add_response(scratch, -1.0, velocities);
        // What the solution leaves is known: it need not be measured again.
        if PROJECTION_LEAVES * rate <= tolerance {
            return;
        }
    }
}

fn add(target: &mut [f64], scale: f64, source: &[f64]) {
    for (target, source) in target.iter_mut().zip(source) {
        *target += scale * source;
    }
}
