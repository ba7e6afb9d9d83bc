//! Collisions as the paper prescribes them, for comparison.
//!
//! A step that ends with corners inside squares is repeated: a collision time is found for every
//! one of them, forward from the start and backward from the end by the [`ansatz`], the nearer of
//! the two is kept, and the *mean* of all is taken for the whole lattice. There one system of
//! equalities (eq. 43) reverses the approach of all of them at once, through the rods. The step
//! then goes on to its end, where nothing is checked again.
//!
//! What that costs is measured: corners left inside squares, impulses that pull, rods of wrong
//! length in the sub-steps. The [`Engine`](super::Engine) has none of these. Where the paper is
//! silent: a corner that is inside at the start as well takes part with collision time 0 if it goes
//! deeper and not at all if it leaves; dependent equations are solved by least squares.

pub mod ansatz;

use super::contact::candidates::{Body, Candidates};
use super::contact::{Contact, Row, TOUCHING, arm, without_repetitions};
use super::dynamics::Dynamics;
use super::force::Force;
use super::network::{Corner, Network};
use super::rods::RodSystem;
use super::state::State;
use crate::Result;
use ansatz::Ansatz;
use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// How close corners must be to count as head on, with the normal of eq. 42.
const HEAD_ON: f64 = 1e-8;
const SKIN: f64 = 0.5;

/// How the paper's protocol is followed.
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

/// What the protocol has left behind.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct PaperStatistics {
    /// Steps completed.
    pub steps: u64,
    /// Steps with collisions.
    pub collisions: u64,
    /// Corners found inside squares, over all steps.
    pub contacts: u64,
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

#[derive(Debug, Clone, Copy)]
struct Hit {
    striker: Corner,
    target: usize,
    shift: [f64; 2],
}

impl PaperEngine {
    /// The protocol for this network under these forces, prepared at this state.
    ///
    /// # Errors
    /// Those of [`Dynamics::new`].
    pub fn new(
        network: Arc<Network>,
        forces: Vec<Box<dyn Force>>,
        state: &State,
        settings: PaperSettings,
    ) -> Result<Self> {
        let candidates = Candidates::new(&network, &state.positions, SKIN, false);
        let dynamics = Dynamics::new(network, forces, state)?;
        let statistics = PaperStatistics::default();
        Ok(Self {
            dynamics,
            settings,
            candidates,
            statistics,
            next: state.positions.clone(),
        })
    }

    /// What the protocol has left behind so far.
    pub fn statistics(&self) -> &PaperStatistics {
        &self.statistics
    }

    /// The dynamics between collisions.
    pub fn dynamics(&mut self) -> &mut Dynamics {
        &mut self.dynamics
    }

    /// One step of length `step`.
    ///
    /// # Errors
    /// Those of [`Dynamics::step`]; the state may then be that of the collision.
    pub fn step(&mut self, state: &mut State, step: f64) -> Result<()> {
        let network = self.dynamics.network().clone();
        self.dynamics.drift(state, step, &mut self.next)?;
        let hits = corners_inside(&mut self.candidates, &network, &self.next);
        let times = if hits.is_empty() {
            Vec::new()
        } else {
            self.collision_times(&network, state, step, &hits)?
        };
        if times.is_empty() {
            if !hits.is_empty() {
                self.dynamics.drift(state, step, &mut self.next)?;
            }
            self.dynamics.arrive(state, step, &self.next)?;
        } else {
            let mean = times.iter().map(|(_, time)| time).sum::<f64>() / times.len() as f64;
            let spread = times
                .iter()
                .fold(0.0_f64, |spread, (_, time)| spread.max((time - mean).abs()));
            self.statistics.largest_time_spread = self.statistics.largest_time_spread.max(spread);
            self.statistics.collisions += 1;
            self.statistics.contacts += times.len() as u64;
            if mean > 0.0 {
                self.dynamics.drift(state, mean, &mut self.next)?;
                self.dynamics.arrive(state, mean, &self.next)?;
            }
            let struck: Vec<Hit> = times.iter().map(|(hit, _)| *hit).collect();
            self.reverse(&network, state, &struck);
            self.dynamics.drift(state, step - mean, &mut self.next)?;
            self.dynamics.arrive(state, step - mean, &self.next)?;
        }
        let depth = corners_inside(&mut self.candidates, &network, &state.positions)
            .iter()
            .fold(0.0_f64, |depth, hit| {
                depth.max(-height(&network, &state.positions, hit))
            });
        self.statistics.deepest_overlap = self.statistics.deepest_overlap.max(depth);
        self.statistics.steps_with_overlap += u64::from(depth > TOUCHING);
        self.statistics.steps += 1;
        Ok(())
    }

    /// Steps 1 to 3 of the protocol.
    fn collision_times(
        &mut self,
        network: &Network,
        state: &State,
        step: f64,
        hits: &[Hit],
    ) -> Result<Vec<(Hit, f64)>> {
        let mut at_end = state.clone();
        let end = self.next.clone();
        let forward = if self.settings.ansatz {
            self.by_ansatz(network, state, step, hits)
        } else {
            Vec::new()
        };
        let true_times = if self.settings.ansatz {
            Vec::new()
        } else {
            hits.iter()
                .map(|hit| self.by_sub_steps(network, state, step, hit))
                .collect::<Result<Vec<f64>>>()?
        };
        let mut backward = Vec::new();
        if self.settings.ansatz {
            // `arrive` completes the last drift, which was that of the whole step.
            self.dynamics.arrive(&mut at_end, step, &end)?;
            backward = self.by_ansatz(network, &at_end, -step, hits);
            self.dynamics.prepare(state)?;
        }
        let mut times = Vec::new();
        for (index, hit) in hits.iter().enumerate() {
            if height(network, &state.positions, hit) < 0.0 {
                let contact = Contact::of_corner(
                    network,
                    &state.positions,
                    hit.striker,
                    hit.target,
                    hit.shift,
                );
                if contact
                    .row(network, &state.positions)
                    .dot(&state.velocities)
                    < 0.0
                {
                    times.push((*hit, 0.0));
                }
            } else if self.settings.ansatz {
                let (ahead, behind) = (forward[index], backward[index]);
                let time = match (ahead, behind) {
                    (Some(ahead), Some(behind)) if ahead > -behind => step + behind,
                    (Some(ahead), _) => ahead,
                    (None, Some(behind)) => step + behind,
                    (None, None) => continue,
                };
                times.push((*hit, time.clamp(0.0, step)));
            } else {
                times.push((*hit, true_times[index]));
            }
        }
        Ok(times)
    }

    /// Collision times from a prepared state, where the ansatz leads through the side of the
    /// target.
    fn by_ansatz(
        &mut self,
        network: &Network,
        state: &State,
        step: f64,
        hits: &[Hit],
    ) -> Vec<Option<f64>> {
        let (mut free, mut total) = (
            vec![0.0; state.positions.len()],
            vec![0.0; state.positions.len()],
        );
        self.dynamics.accelerations_into(&mut free, &mut total);
        let ansatz = Ansatz::new(network, &state.positions, &state.velocities, &free, &total);
        let mut times = Vec::with_capacity(hits.len());
        for hit in hits {
            let at = |time: f64| height(network, &ansatz.land(time).positions, hit);
            let (mut low, mut high) = (0.0, step);
            let (begin, end) = (at(low), at(high));
            if (begin < 0.0) == (end < 0.0) {
                times.push(None);
                continue;
            }
            while (high - low).abs() > 1e-12 * step.abs() {
                let middle = 0.5 * (low + high);
                if middle == low || middle == high {
                    break;
                }
                if (at(middle) < 0.0) == (begin < 0.0) {
                    low = middle
                } else {
                    high = middle
                }
            }
            let landing = ansatz.land(high);
            let mut rods = RodSystem::new(network);
            let mut sigma = vec![0.0; rods.len()];
            let (rod, sigma) = rods.violations(&landing.positions, &mut sigma);
            // σ = (|Δ|² - r0²) / 2 r0.
            let r0 = network.rods.get(rod).map_or(1.0, |rod| rod.length);
            let error = (r0 * r0 + 2.0 * r0 * sigma).max(0.0).sqrt() - r0;
            let statistics = &mut self.statistics;
            statistics.largest_ansatz_rod_error =
                statistics.largest_ansatz_rod_error.max(error.abs());
            statistics.largest_ansatz_residual =
                statistics.largest_ansatz_residual.max(landing.residual);
            times.push(Some(high));
        }
        times
    }

    /// The collision time of one corner with the rods kept, by bisection.
    fn by_sub_steps(
        &mut self,
        network: &Network,
        state: &State,
        step: f64,
        hit: &Hit,
    ) -> Result<f64> {
        let (mut open, mut closed) = (0.0, step);
        while closed - open > 1e-10 * step {
            let middle = 0.5 * (open + closed);
            self.dynamics.drift(state, middle, &mut self.next)?;
            if height(network, &self.next, hit) < 0.0 {
                closed = middle
            } else {
                open = middle
            }
        }
        Ok(closed)
    }

    /// Eq. 43: N v⁺ = -N v⁻ for all contacts, whatever the sign of the impulses.
    fn reverse(&mut self, network: &Network, state: &mut State, hits: &[Hit]) {
        let contacts: Vec<Contact> = hits
            .iter()
            .map(|hit| {
                Contact::of_corner(
                    network,
                    &state.positions,
                    hit.striker,
                    hit.target,
                    hit.shift,
                )
            })
            .collect();
        let contacts = without_repetitions(&contacts);
        let rows: Vec<Row> = contacts
            .iter()
            .map(|contact| self.row(network, state, contact))
            .collect();
        let rods = self.dynamics.rods();
        let columns: Vec<Vec<f64>> = rows
            .iter()
            .map(|row| {
                super::collision::response::constrained_response(
                    network,
                    rods,
                    row,
                    state.velocities.len(),
                )
            })
            .collect();
        let w = DMatrix::from_fn(rows.len(), rows.len(), |i, j| rows[i].dot(&columns[j]));
        let q = DVector::from_iterator(
            rows.len(),
            rows.iter().map(|row| -2.0 * row.dot(&state.velocities)),
        );
        let svd = w.svd(true, true);
        let threshold = 1e-10 * svd.singular_values.amax();
        let Ok(impulses) = svd.solve(&q, threshold) else {
            return;
        };
        let energy = state.kinetic_energy(network);
        for (impulse, column) in impulses.iter().zip(&columns) {
            if *impulse < 0.0 {
                self.statistics.pulling_impulses += 1;
                self.statistics.pull -= impulse;
            }
            for (v, x) in state.velocities.iter_mut().zip(column) {
                *v += impulse * x;
            }
        }
        self.dynamics.velocities_changed(&mut state.velocities);
        let change = (state.kinetic_energy(network) / energy - 1.0).abs();
        self.statistics.largest_relative_energy_change =
            self.statistics.largest_relative_energy_change.max(change);
    }

    /// The row of a contact; corners head on take the normal of eq. 42 as printed, where it is
    /// defined.
    fn row(&self, network: &Network, state: &State, contact: &Contact) -> Row {
        if let Contact::VertexVertex {
            striker, target, ..
        } = *contact
            && let Some(normal) = printed_normal(network, state, striker, target)
        {
            let arms = [striker, target].map(|corner| arm(network, &state.positions, corner));
            return Row::along([striker.square, target.square], normal, arms);
        }
        contact.row(network, &state.positions)
    }
}

/// Corners inside squares (inequality 13 violated), in both roles.
fn corners_inside(candidates: &mut Candidates, network: &Network, positions: &[f64]) -> Vec<Hit> {
    if !candidates.holds(positions, 0.0) {
        candidates.rebuild(network, positions);
    }
    let mut hits = Vec::new();
    for pair in candidates.pairs() {
        let Body::Square(second) = pair.second else {
            continue;
        };
        let back = [-pair.shift[0], -pair.shift[1]];
        for (striker, target, shift) in
            [(pair.first, second, pair.shift), (second, pair.first, back)]
        {
            for vertex in 1..=4 {
                let hit = Hit {
                    striker: Corner {
                        square: striker,
                        vertex,
                    },
                    target,
                    shift,
                };
                if height(network, positions, &hit) < 0.0 {
                    hits.push(hit);
                }
            }
        }
    }
    hits
}

/// Eq. 12 less l², over √2 l.
fn height(network: &Network, positions: &[f64], hit: &Hit) -> f64 {
    let contact = (0..4).map(|side| {
        Contact::VertexSide {
            striker: hit.striker,
            target: hit.target,
            side,
            shift: hit.shift,
        }
        .gap(network, positions)
    });
    contact.fold(f64::NEG_INFINITY, f64::max)
}

/// The direction of eq. 42, turned from target to striker:
///
/// n ∝ G ((ρ_l ρ_lᵀ - ρ_k ρ_kᵀ)/I)⁻¹ ((Gᵀ + ρ_l e_zᵀ) ṡ_target + (Gᵀ + ρ_k e_zᵀ) ṡ_striker).
///
/// It holds the *sum* of the velocities, so it depends on the observer. `None` where the matrix is
/// singular.
pub fn printed_normal(
    network: &Network,
    state: &State,
    striker: Corner,
    target: Corner,
) -> Option<[f64; 2]> {
    let (k, l) = (
        arm(network, &state.positions, striker),
        arm(network, &state.positions, target),
    );
    let inertia = network.squares[striker.square].inertia;
    let entry = |i: usize, j: usize| (l[i] * l[j] - k[i] * k[j]) / inertia;
    let (a, b, c) = (entry(0, 0), entry(0, 1), entry(1, 1));
    let determinant = a * c - b * b;
    if determinant.abs() <= HEAD_ON {
        return None;
    }
    // G = (0 -1; 1 0): G x = (-y, x), Gᵀ x = (y, -x).
    let part = |corner: Corner, rho: [f64; 2]| {
        let v = &state.velocities[3 * corner.square..3 * corner.square + 3];
        [v[1] + rho[0] * v[2], -v[0] + rho[1] * v[2]]
    };
    let (first, second) = (part(target, l), part(striker, k));
    let sum = [first[0] + second[0], first[1] + second[1]];
    let solved = [
        (c * sum[0] - b * sum[1]) / determinant,
        (a * sum[1] - b * sum[0]) / determinant,
    ];
    let (x, y) = (-solved[1], solved[0]);
    let length = x.hypot(y);
    if length.is_nan() || length <= HEAD_ON {
        return None;
    }
    let outward = (l[0] - k[0]) * x + (l[1] - k[1]) * y;
    let sign = if outward < 0.0 { -1.0 } else { 1.0 };
    Some([sign * x / length, sign * y / length])
}
