//! Steps with collisions, event by event.
//!
//! A step drifts to its end, or to the first contact on the way; there everything that touches
//! takes part in one impact, and the rest of the step goes on from the new velocities. Steps of an
//! engine therefore end where the caller wants them, and each sub-step is one of [`Dynamics`]: rods
//! are exact throughout.

use super::collision::detection::{Detector, Meeting, overlap};
use super::collision::replay::check_restitution;
use super::collision::response::impact;
use super::contact::{Contact, Row, TOUCHING, without_repetitions};
use super::dynamics::Dynamics;
use super::force::Force;
use super::network::Network;
use super::state::State;
use crate::{CrystalError, Result};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// A contact that approaches no faster than this is at rest.
const AT_REST: f64 = 1e-13;
/// After so many impacts in one step, lossy contacts are taken to rest on each other.
const IMPACTS_BEFORE_REST: usize = 4;
/// A contact that closes again within this share of the rest of a step has not really opened.
const AT_ONCE: f64 = 0.02;
/// The smallest speed with which resting contacts are made to part; it doubles with every impact in
/// a step.
const LEAST_LIFT: f64 = 1e-9;
/// Rods longer than this, in half-diagonals, are obstacles by default. On random 10 x 10 lattices
/// no corner met a rod up to r0 = 0.7 in 2000 steps of 0.005, and some did at 1.
const BLOCKING_LENGTH: f64 = 0.5;
/// A jam is reported after so many times the cap.
const JAMMED: usize = 25;

/// How bodies collide.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct CollisionSettings {
    /// e, 0 (no rebound) to 1 (elastic).
    pub restitution: f64,
    /// Whether rods are obstacles for corners and for the squares they hang on. By default they are
    /// where a rod is longer than half a half-diagonal: corners do not come between shorter ones.
    pub rods_block: Option<bool>,
    /// Impacts in one step after which the contacts of the rest of the step are held apart with a
    /// little speed of their own; such steps are counted.
    pub most_impacts_per_step: usize,
}

impl Default for CollisionSettings {
    fn default() -> Self {
        Self {
            restitution: 1.0,
            rods_block: None,
            most_impacts_per_step: 40,
        }
    }
}

/// What has happened.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct CollisionStatistics {
    /// Steps completed.
    pub steps: u64,
    /// Impacts.
    pub impacts: u64,
    /// Contacts with an impulse, over all impacts.
    pub contacts: u64,
    /// Of these, contacts with rods.
    pub rod_contacts: u64,
    /// Sum of all impulses.
    pub impulse: f64,
    /// Energy the impacts changed (zero for elastic ones but for rounding).
    pub impact_energy: f64,
    /// The largest change of energy in one impact, over the energy (for restitution 1).
    pub largest_relative_energy_change: f64,
    /// Impacts in which contacts were held apart with a little speed: resting contacts, and steps
    /// with too many impacts.
    pub lifts: u64,
    /// Energy that gave.
    pub lift_energy: f64,
    /// Steps with more impacts than `most_impacts_per_step`.
    pub capped_steps: u64,
    /// Impacts whose complementarity problem had to be relaxed.
    pub relaxed: u64,
    /// The largest |Δ| - r0 after an impact or at a check, every 16th step.
    pub largest_rod_violation: f64,
    /// The largest |J v| there.
    pub largest_rod_rate: f64,
    /// The smallest gap (negative: overlap) of all pairs that were near at the end of a sub-step;
    /// none if none ever was.
    pub smallest_gap: Option<f64>,
    /// How often the list of near pairs was made since the engine was.
    pub candidate_lists: u64,
}

/// A network whose squares collide.
pub struct Engine {
    dynamics: Dynamics,
    settings: CollisionSettings,
    detector: Detector,
    statistics: CollisionStatistics,
    next: Vec<f64>,
    kept: State,
    scratch: Vec<f64>,
}

impl Engine {
    /// The engine for this network under these forces, prepared at this state.
    ///
    /// # Errors
    /// Those of [`Dynamics::new`]; [`CrystalError::Overlap`] names bodies that overlap at the
    /// start; [`CrystalError::BadSetting`] for a restitution outside 0 to 1.
    pub fn new(
        network: Arc<Network>,
        forces: Vec<Box<dyn Force>>,
        state: &State,
        settings: CollisionSettings,
    ) -> Result<Self> {
        check_restitution(settings.restitution)?;
        let dynamics = Dynamics::new(network.clone(), forces, state)?;
        let longer =
            |end: usize, length: f64| length > BLOCKING_LENGTH * network.squares[end].half_diagonal;
        let long = network
            .rods
            .iter()
            .any(|rod| longer(rod.from.square, rod.length) || longer(rod.to.square, rod.length));
        let detector = Detector::new(
            &network,
            &state.positions,
            settings.rods_block.unwrap_or(long),
        );
        detector.check_no_overlap(&network, &state.positions, state.time)?;
        let statistics = CollisionStatistics::default();
        Ok(Self {
            scratch: vec![0.0; network.rods.len()],
            next: state.positions.clone(),
            kept: state.clone(),
            dynamics,
            settings,
            detector,
            statistics,
        })
    }

    /// The dynamics between collisions.
    pub fn dynamics(&mut self) -> &mut Dynamics {
        &mut self.dynamics
    }

    /// The network.
    pub fn network(&self) -> &Arc<Network> {
        self.dynamics.network()
    }

    /// How bodies collide.
    pub fn settings(&self) -> &CollisionSettings {
        &self.settings
    }

    /// Whether rods are obstacles.
    pub fn rods_block(&self) -> bool {
        self.detector.rods_block()
    }

    /// What has happened so far.
    pub fn statistics(&self) -> &CollisionStatistics {
        &self.statistics
    }

    /// Goes on counting from here, for a run taken up again.
    pub fn set_statistics(&mut self, statistics: CollisionStatistics) {
        self.statistics = statistics;
    }

    /// To be called when a state has been changed from outside, or another one taken.
    ///
    /// # Errors
    /// As [`Engine::new`].
    pub fn prepare(&mut self, state: &State) -> Result<()> {
        state.check(self.dynamics.network())?;
        self.dynamics.prepare(state)?;
        let network = self.dynamics.network().clone();
        self.detector.reset(&network, &state.positions);
        self.detector
            .check_no_overlap(&network, &state.positions, state.time)
    }

    /// One step of length `step`, with whatever collisions there are.
    ///
    /// # Errors
    /// Those of [`Dynamics::step`], [`CrystalError::Overlap`] if bodies overlap by more than 1e-9
    /// after all, [`CrystalError::Jammed`]; the state is then the one before the step.
    pub fn step(&mut self, state: &mut State, step: f64) -> Result<()> {
        if !(step.is_finite() && step > 0.0) {
            return Err(CrystalError::BadSetting {
                setting: "step",
                value: step,
                requirement: "positive",
            });
        }
        self.kept.clone_from(state);
        let result = self.advance(state, step);
        if result.is_err() {
            state.clone_from(&self.kept);
            // A state that was prepared once can be prepared again; the first error is the one that
            // matters.
            let _ = self.prepare(state);
        }
        result
    }

    fn advance(&mut self, state: &mut State, step: f64) -> Result<()> {
        let network = self.dynamics.network().clone();
        let end = state.time + step;
        let mut left = step;
        let mut impacts = 0;
        loop {
            let meeting =
                self.detector
                    .first_meeting(&mut self.dynamics, state, left, &mut self.next)?;
            let length = meeting.map_or(left, |meeting| meeting.time);
            if length > 0.0 {
                self.dynamics.arrive(state, length, &self.next)?;
            }
            for watch in self.detector.hot() {
                let gap = watch.gap(&network, &state.positions);
                self.statistics.smallest_gap = Some(
                    self.statistics
                        .smallest_gap
                        .map_or(gap, |smallest| smallest.min(gap)),
                );
                if gap.is_nan() || gap < -TOUCHING {
                    return Err(overlap(&network, watch, -gap, state.time));
                }
            }
            left -= length;
            let Some(meeting) = meeting else {
                break;
            };
            impacts += 1;
            self.meet(&network, state, meeting, left, impacts)?;
            if left <= 1e-14 * step {
                break;
            }
        }
        state.time = end;
        if impacts > self.settings.most_impacts_per_step {
            self.statistics.capped_steps += 1;
        }
        self.statistics.steps += 1;
        self.statistics.candidate_lists = self.detector.lists();
        if impacts > 0 || self.statistics.steps.is_multiple_of(16) {
            self.measure(state);
        }
        Ok(())
    }

    /// Everything that touches takes part in one impact.
    fn meet(
        &mut self,
        network: &Network,
        state: &mut State,
        meeting: Meeting,
        left: f64,
        impacts: usize,
    ) -> Result<()> {
        if impacts > JAMMED * self.settings.most_impacts_per_step.max(1) {
            let (first, second) = meeting.watch.names(network);
            return Err(CrystalError::Jammed {
                events: impacts,
                first,
                second,
                time: self.kept.time,
            });
        }
        let contacts = without_repetitions(&self.detector.touching(network, &state.positions));
        let lossy = self.settings.restitution < 1.0;
        let at_once = impacts > 1 && meeting.time < AT_ONCE * (meeting.time + left);
        let rests = if lossy {
            at_once || impacts > IMPACTS_BEFORE_REST
        } else {
            false
        };
        let capped = impacts > self.settings.most_impacts_per_step;
        if (rests || capped) && left > 0.0 {
            return self.rest(network, state, &contacts, left, impacts);
        }
        // An impact may send a contact that was parting back together: it then takes part in the
        // next one, at once.
        for _ in 0..self.settings.most_impacts_per_step.max(1) {
            let approaching: Vec<Contact> = contacts
                .iter()
                .filter(|contact| rate(contact, network, state) <= AT_REST)
                .copied()
                .collect();
            if !approaching
                .iter()
                .any(|contact| rate(contact, network, state) < -AT_REST)
            {
                break;
            }
            let energy = state.kinetic_energy(network);
            let change = self.strike(
                network,
                state,
                &approaching,
                self.settings.restitution,
                None,
            );
            let statistics = &mut self.statistics;
            statistics.impact_energy += change;
            if !lossy {
                statistics.largest_relative_energy_change = statistics
                    .largest_relative_energy_change
                    .max(change.abs() / energy);
            }
        }
        Ok(())
    }

    /// One impact; returns the change of the kinetic energy.
    fn strike(
        &mut self,
        network: &Network,
        state: &mut State,
        contacts: &[Contact],
        restitution: f64,
        lift: Option<f64>,
    ) -> f64 {
        let energy = state.kinetic_energy(network);
        let rows: Vec<Row> = contacts
            .iter()
            .map(|contact| contact.row(network, &state.positions))
            .collect();
        let result = impact(
            network,
            self.dynamics.rods(),
            &mut state.velocities,
            &rows,
            restitution,
            lift,
        );
        self.dynamics.velocities_changed(&mut state.velocities);
        let statistics = &mut self.statistics;
        statistics.impacts += 1;
        statistics.relaxed += u64::from(!result.exact);
        for (contact, impulse) in contacts
            .iter()
            .zip(&result.impulses)
            .filter(|(_, impulse)| **impulse > 0.0)
        {
            statistics.contacts += 1;
            let with_rod = matches!(contact, Contact::RodCorner { .. } | Contact::RodStop { .. });
            statistics.rod_contacts += u64::from(with_rod);
            statistics.impulse += impulse;
        }
        state.kinetic_energy(network) - energy
    }

    /// Holds contacts apart that would strike again and again. An impact takes what is left of
    /// their approach; how far they would sink into each other in the rest of the step tells the
    /// speed with which they must part so as not to.
    fn rest(
        &mut self,
        network: &Network,
        state: &mut State,
        contacts: &[Contact],
        left: f64,
        impacts: usize,
    ) -> Result<()> {
        let restitution = if self.settings.restitution < 1.0 {
            0.0
        } else {
            1.0
        };
        let mut change = self.strike(network, state, contacts, restitution, Some(0.0));
        self.dynamics.drift(state, left, &mut self.next)?;
        let sunk = contacts
            .iter()
            .map(|contact| -contact.gap(network, &self.next))
            .fold(0.0, f64::max);
        // Contacts that sink only in between ask for more each time.
        let least = LEAST_LIFT * f64::from(1 << impacts.min(20));
        change += self.strike(
            network,
            state,
            contacts,
            restitution,
            Some(least.max(1.5 * sunk / left)),
        );
        self.statistics.lifts += 1;
        self.statistics.lift_energy += change;
        Ok(())
    }

    fn measure(&mut self, state: &State) {
        let rods = self.dynamics.rods();
        let (_, violation) = rods.violations(&state.positions, &mut self.scratch);
        rods.apply(&state.velocities, &mut self.scratch);
        let rate = self
            .scratch
            .iter()
            .fold(0.0_f64, |rate, x| rate.max(x.abs()));
        let statistics = &mut self.statistics;
        statistics.largest_rod_violation = statistics.largest_rod_violation.max(violation.abs());
        statistics.largest_rod_rate = statistics.largest_rod_rate.max(rate);
    }
}

fn rate(contact: &Contact, network: &Network, state: &State) -> f64 {
    contact
        .row(network, &state.positions)
        .dot(&state.velocities)
}
