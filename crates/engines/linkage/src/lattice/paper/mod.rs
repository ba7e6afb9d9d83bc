//! Collisions as the paper prescribes them, for comparison.
//!
//! A step that ends with corners inside squares is repeated: a collision time is found for every
//! one of them, forward from the start and backward from the end by the [`ansatz`], the nearer of
//! the two is kept, and the *mean* of all is taken for the whole lattice. There one system of
//! equalities (eq. 43) reverses the approach of all of them at once, through the rods. The step
//! then continues to its end, where nothing is checked again.
//!
//! The cost is measured: corners left inside squares, impulses that pull, rods of wrong length in
//! the sub-steps. The [`Engine`](super::Engine) has none of these. Where the paper is silent, this
//! is done: a corner that is inside at the start as well takes part with collision time 0 if it goes
//! deeper and not at all if it leaves; dependent equations are solved by least squares.

pub mod ansatz;
mod normal;

use super::collision::response::{add_impulses, constrained_response};
use super::contact::candidates::{Body, Candidates};
use super::contact::layout::Layout;
use super::contact::{Contact, Row, TOUCHING, without_repetitions};
use super::dynamics::Dynamics;
use super::force::Force;
use super::network::{Corner, Network};
use super::rods::RodSystem;
use super::state::State;
use crate::{CrystalError, Result};
use ansatz::Ansatz;
use nalgebra::{DMatrix, DVector, SVD};
pub use normal::printed_normal;
use protomer_kernel::bisection::narrowed;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Extra width of the candidate list.
const SKIN: f64 = 0.5;
/// Bisections for a collision time by the ansatz end at this share of the step.
const ANSATZ_TIME: f64 = 1e-12;
/// Searches by sub-steps end at this share of the step.
const SUB_STEP_TIME: f64 = 1e-10;
/// Singular values of eq. 43 below this share of the largest count as zero.
const SINGULAR: f64 = 1e-10;
/// Iterations after which a decomposition of eq. 43 is given up; it takes a few per contact.
const MOST_ITERATIONS: usize = 10_000;

/// Settings of the paper's protocol.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct PaperSettings {
    /// Collision times by the constant-length ansatz, as printed; otherwise by sub-steps that keep
    /// the rods.
    pub ansatz: bool,
}

impl Default for PaperSettings {
    fn default() -> Self {
        Self { ansatz: true }
    }
}

/// Counts and extremes of a run: what the protocol costs.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct PaperStatistics {
    /// Steps completed.
    pub steps: u64,
    /// Steps with collisions.
    pub collisions: u64,
    /// Corners found inside squares, over all steps.
    pub contacts: u64,
    /// Steps with collisions whose eq. 43 could not be solved: squares kept their velocities.
    pub unsolved_collisions: u64,
    /// Impulses that pull.
    pub pulling_impulses: u64,
    /// Sum of the impulses that pull.
    pub pull: f64,
    /// The deepest corner inside a square at the end of a step.
    pub deepest_overlap: f64,
    /// Steps that ended with a corner inside a square by more than 1e-9.
    pub steps_with_overlap: u64,
    /// The largest spread of the collision times that were replaced by their mean.
    pub largest_time_spread: f64,
    /// The largest ||Δ| - r0| at a collision time by the ansatz.
    pub largest_ansatz_rod_error: f64,
    /// The largest share of eq. 38 left unfulfilled.
    pub largest_ansatz_residual: f64,
    /// The largest change of energy in a collision, over the energy.
    pub largest_relative_energy_change: f64,
}

/// The paper's protocol.
pub struct PaperEngine {
    dynamics: Dynamics,
    settings: PaperSettings,
    candidates: Candidates,
    statistics: PaperStatistics,
    next: Vec<f64>,
}

/// A corner inside a square.
#[derive(Debug, Clone, Copy)]
struct Hit {
    striker: Corner,
    target: usize,
    image: [i32; 2],
}

impl PaperEngine {
    /// The protocol for this network under these forces, prepared at this state.
    ///
    /// # Errors
    /// Those of [`Dynamics::new`], and [`CrystalError::BadNetwork`] for a flexible cell.
    pub fn new(
        network: Arc<Network>,
        forces: Vec<Box<dyn Force>>,
        state: &State,
        settings: PaperSettings,
    ) -> Result<Self> {
        if network.cell_mass.is_some() {
            return Err(CrystalError::BadNetwork(
                "the paper's protocol has no flexible cell; give cell = \"fixed\" or paper = false"
                    .into(),
            ));
        }
        let candidates = Candidates::new(&network, &state.positions, SKIN, false);
        let dynamics = Dynamics::new(network, forces, state)?;
        Ok(Self {
            dynamics,
            settings,
            candidates,
            statistics: PaperStatistics::default(),
            next: state.positions.clone(),
        })
    }

    /// Counts and extremes so far.
    pub fn statistics(&self) -> &PaperStatistics {
        &self.statistics
    }

    /// Continues counting from here, for a run that is resumed.
    pub fn set_statistics(&mut self, statistics: PaperStatistics) {
        self.statistics = statistics;
    }

    /// The dynamics between collisions.
    pub fn dynamics(&mut self) -> &mut Dynamics {
        &mut self.dynamics
    }

    /// Makes one step of length `step`.
    ///
    /// # Errors
    /// Those of [`Dynamics::step`]; the state may then be that of the collision.
    pub fn step(&mut self, state: &mut State, step: f64) -> Result<()> {
        let network = self.dynamics.network().clone();
        self.dynamics.drift(state, step, &mut self.next)?;
        let hits = self.hits_at_next(&network);
        let times = self.collision_times(&network, state, step, &hits)?;
        if times.is_empty() {
            if !hits.is_empty() {
                self.dynamics.drift(state, step, &mut self.next)?;
            }
            self.dynamics.arrive(state, step, &self.next)?;
        } else {
            self.collide(&network, state, step, &times)?;
        }
        self.measure_overlap(&network, state);
        self.statistics.steps += 1;
        Ok(())
    }

    /// Reverses all collisions at the mean of their times.
    fn collide(
        &mut self,
        network: &Network,
        state: &mut State,
        step: f64,
        times: &[(Hit, f64)],
    ) -> Result<()> {
        let (mut sum, mut spread) = (0.0, 0.0_f64);
        let mut struck = Vec::with_capacity(times.len());
        for (hit, time) in times {
            sum += time;
            struck.push(*hit);
        }
        let mean = sum / times.len() as f64;
        for (_, time) in times {
            spread = spread.max((time - mean).abs());
        }
        let statistics = &mut self.statistics;
        statistics.largest_time_spread = statistics.largest_time_spread.max(spread);
        statistics.collisions += 1;
        statistics.contacts += times.len() as u64;
        if mean > 0.0 {
            self.advance(state, mean)?;
        }
        self.reverse(network, state, &struck);
        self.advance(state, step - mean)
    }

    fn advance(&mut self, state: &mut State, time: f64) -> Result<()> {
        self.dynamics.drift(state, time, &mut self.next)?;
        self.dynamics.arrive(state, time, &self.next)
    }

    fn measure_overlap(&mut self, network: &Network, state: &State) {
        let mut depth = 0.0_f64;
        for hit in corners_inside(&mut self.candidates, network, &state.positions) {
            depth = depth.max(-height(network, &state.positions, &hit));
        }
        let statistics = &mut self.statistics;
        statistics.deepest_overlap = statistics.deepest_overlap.max(depth);
        statistics.steps_with_overlap += u64::from(depth > TOUCHING);
    }

    fn hits_at_next(&mut self, network: &Network) -> Vec<Hit> {
        corners_inside(&mut self.candidates, network, &self.next)
    }

    /// Steps 1 to 3 of the protocol.
    fn collision_times(
        &mut self,
        network: &Network,
        state: &State,
        step: f64,
        hits: &[Hit],
    ) -> Result<Vec<(Hit, f64)>> {
        if hits.is_empty() {
            return Ok(Vec::new());
        }
        let hit_times = if self.settings.ansatz {
            self.times_by_ansatz(network, state, step, hits)?
        } else {
            self.times_by_sub_steps(network, state, step, hits)?
        };
        let mut times = Vec::new();
        for (hit, hit_time) in hits.iter().zip(hit_times) {
            let time = if height(network, &state.positions, hit) < 0.0 {
                // Inside at the start as well.
                (hit.rate(network, state) < 0.0).then_some(0.0)
            } else {
                hit_time
            };
            if let Some(time) = time {
                times.push((*hit, time));
            }
        }
        Ok(times)
    }

    /// The nearer of the times forward from the start and backward from the end.
    fn times_by_ansatz(
        &mut self,
        network: &Network,
        state: &State,
        step: f64,
        hits: &[Hit],
    ) -> Result<Vec<Option<f64>>> {
        let mut at_end = state.clone();
        let end = self.next.clone();
        let forward = self.roots_by_ansatz(network, state, step, hits)?;
        // `arrive` completes the last drift, which was that of the whole step.
        self.dynamics.arrive(&mut at_end, step, &end)?;
        let backward = self.roots_by_ansatz(network, &at_end, -step, hits)?;
        self.dynamics.prepare(state)?;
        let mut times = Vec::with_capacity(hits.len());
        for pair in forward.into_iter().zip(backward) {
            let time = match pair {
                (Some(ahead), Some(behind)) if ahead > -behind => Some(step + behind),
                (Some(ahead), _) => Some(ahead),
                (None, Some(behind)) => Some(step + behind),
                (None, None) => None,
            };
            times.push(time.map(|time| time.clamp(0.0, step)));
        }
        Ok(times)
    }

    /// Collision times from a prepared state, where the ansatz leads through the side of the
    /// target.
    fn roots_by_ansatz(
        &mut self,
        network: &Network,
        state: &State,
        step: f64,
        hits: &[Hit],
    ) -> Result<Vec<Option<f64>>> {
        let mut free = vec![0.0; state.positions.len()];
        let mut total = free.clone();
        self.dynamics.accelerations_into(&mut free, &mut total);
        let mut ansatz = Ansatz::new(network, &state.positions, &state.velocities, &free, &total)?;
        let mut times = Vec::with_capacity(hits.len());
        for hit in hits {
            let time = root_by_ansatz(&mut ansatz, network, step, hit);
            if let Some(time) = time {
                self.measure_ansatz(&mut ansatz, network, time);
            }
            times.push(time);
        }
        Ok(times)
    }

    fn measure_ansatz(&mut self, ansatz: &mut Ansatz, network: &Network, time: f64) {
        let landing = ansatz.land(time);
        let mut rods = RodSystem::new(network);
        let mut sigma = vec![0.0; rods.len()];
        let (rod, sigma) = rods.violations(&landing.positions, &mut sigma);
        // σ = (|Δ|² - r0²) / 2 r0.
        let r0 = network.rods.get(rod).map_or(1.0, |rod| rod.length);
        let error = (r0 * r0 + 2.0 * r0 * sigma).max(0.0).sqrt() - r0;
        let statistics = &mut self.statistics;
        statistics.largest_ansatz_rod_error = statistics.largest_ansatz_rod_error.max(error.abs());
        statistics.largest_ansatz_residual =
            statistics.largest_ansatz_residual.max(landing.residual);
    }

    /// The collision times with the rods kept, by bisection.
    fn times_by_sub_steps(
        &mut self,
        network: &Network,
        state: &State,
        step: f64,
        hits: &[Hit],
    ) -> Result<Vec<Option<f64>>> {
        let mut times = Vec::with_capacity(hits.len());
        for hit in hits {
            let (mut open, mut closed) = (0.0, step);
            while closed - open > SUB_STEP_TIME * step {
                let middle = 0.5 * (open + closed);
                self.dynamics.drift(state, middle, &mut self.next)?;
                if height(network, &self.next, hit) < 0.0 {
                    closed = middle;
                } else {
                    open = middle;
                }
            }
            times.push(Some(closed));
        }
        Ok(times)
    }

    /// Eq. 43: N v⁺ = -N v⁻ for all contacts, whatever the sign of the impulses.
    fn reverse(&mut self, network: &Network, state: &mut State, hits: &[Hit]) {
        let mut contacts = Vec::with_capacity(hits.len());
        for hit in hits {
            contacts.push(hit.contact(network, &state.positions));
        }
        let (mut rows, mut columns, mut demands) = (Vec::new(), Vec::new(), Vec::new());
        for contact in without_repetitions(&contacts) {
            let row = printed_row(network, state, &contact);
            let (rods, coordinates) = (self.dynamics.rods(), state.velocities.len());
            columns.push(constrained_response(network, rods, &row, coordinates));
            demands.push(-2.0 * row.dot(&state.velocities));
            rows.push(row);
        }
        let w = DMatrix::from_fn(rows.len(), rows.len(), |i, j| rows[i].dot(&columns[j]));
        let Some(impulses) = least_squares(w, DVector::from_vec(demands)) else {
            self.statistics.unsolved_collisions += 1;
            return;
        };
        let energy = state.kinetic_energy(network);
        add_impulses(impulses.as_slice(), &columns, &mut state.velocities);
        self.dynamics.velocities_changed(&mut state.velocities);
        let change = (state.kinetic_energy(network) / energy - 1.0).abs();
        let statistics = &mut self.statistics;
        for impulse in impulses.iter().filter(|impulse| **impulse < 0.0) {
            statistics.pulling_impulses += 1;
            statistics.pull -= impulse;
        }
        statistics.largest_relative_energy_change =
            statistics.largest_relative_energy_change.max(change);
    }
}

/// The smallest solution of w x = b in the sense of least squares; `None` if w holds numbers that are
/// not finite or cannot be decomposed.
fn least_squares(w: DMatrix<f64>, b: DVector<f64>) -> Option<DVector<f64>> {
    if w.iter().chain(b.iter()).any(|x| !x.is_finite()) {
        return None;
    }
    let svd = SVD::try_new(w, true, true, f64::EPSILON, MOST_ITERATIONS)?;
    let threshold = SINGULAR * svd.singular_values.amax();
    svd.solve(&b, threshold).ok()
}

impl Hit {
    fn contact(&self, network: &Network, positions: &[f64]) -> Contact {
        Contact::of_corner(network, positions, self.striker, self.target, self.image)
    }

    /// Rate at which the corner leaves the square.
    fn rate(&self, network: &Network, state: &State) -> f64 {
        let contact = self.contact(network, &state.positions);
        let row = contact.row(network, &state.positions);
        row.dot(&state.velocities)
    }
}

/// The time at which the ansatz takes a corner through the side of its target, by bisection.
fn root_by_ansatz(ansatz: &mut Ansatz, network: &Network, step: f64, hit: &Hit) -> Option<f64> {
    let mut is_inside = |time: f64| height(network, &ansatz.land(time).positions, hit) < 0.0;
    let starts_inside = is_inside(0.0);
    if starts_inside == is_inside(step) {
        return None;
    }
    let is_before = |time: f64| is_inside(time) == starts_inside;
    Some(narrowed([0.0, step], ANSATZ_TIME * step.abs(), is_before)[1])
}

/// The row of a contact; corners head on take the normal of eq. 42 as printed, where it is defined.
fn printed_row(network: &Network, state: &State, contact: &Contact) -> Row {
    if let Contact::VertexVertex {
        striker, target, ..
    } = *contact
        && let Some(normal) = printed_normal(network, state, striker, target)
    {
        let layout = Layout::new(network, &state.positions);
        let arms = [layout.arm(striker), layout.arm(target)];
        return Row::along([striker.square, target.square], normal, arms);
    }
    contact.row(network, &state.positions)
}

/// Corners inside squares (inequality 13 violated), in both roles.
fn corners_inside(candidates: &mut Candidates, network: &Network, positions: &[f64]) -> Vec<Hit> {
    if !candidates.holds(network, positions, 0.0) {
        candidates.rebuild(network, positions);
    }
    let mut hits = Vec::new();
    for pair in candidates.pairs() {
        let Body::Square(second) = pair.second else {
            continue;
        };
        let back = pair.image.map(|cells| -cells);
        let roles = [(pair.first, second, pair.image), (second, pair.first, back)];
        for (square, target, image) in roles {
            for vertex in 1..=4 {
                let hit = Hit {
                    striker: Corner { square, vertex },
                    target,
                    image,
                };
                if height(network, positions, &hit) < 0.0 {
                    hits.push(hit);
                }
            }
        }
    }
    hits
}

/// Eq. 12 less l², over √2 l: how far a corner is above the sides of its target.
fn height(network: &Network, positions: &[f64], hit: &Hit) -> f64 {
    let mut highest = f64::NEG_INFINITY;
    for side in 0..4 {
        let contact = Contact::VertexSide {
            striker: hit.striker,
            target: hit.target,
            side,
            image: hit.image,
        };
        highest = highest.max(contact.gap(network, positions));
    }
    highest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dependent_equations_have_the_smallest_solution_and_broken_ones_none() {
        let twice = DMatrix::from_row_slice(2, 2, &[1.0, 1.0, 1.0, 1.0]);
        let x = least_squares(twice.clone(), DVector::from_vec(vec![2.0, 2.0])).unwrap();
        assert!((x[0] - 1.0).abs() < 1e-14 && (x[1] - 1.0).abs() < 1e-14);
        assert_eq!(
            least_squares(twice * f64::NAN, DVector::from_vec(vec![2.0, 2.0])),
            None
        );
    }
}
