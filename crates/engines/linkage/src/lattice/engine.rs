//! Steps with collisions, event by event.
//!
//! A step drifts to its end, or to the first contact on the way. There everything that touches takes
//! part in one impact, and the rest of the step continues from the new velocities. A step of an
//! engine therefore ends where the caller wants it, and each sub-step is one of [`Dynamics`]: rods
//! are exact throughout.

use super::collision::detection::{Detector, Meeting, rods_block_by_default};
use super::collision::response::{check_restitution, impact};
use super::contact::{Contact, Row, TOUCHING, without_repetitions};
use super::dynamics::Dynamics;
use super::force::Force;
use super::network::Network;
use super::state::State;
use crate::error::{CrystalError, Result, require_positive};
use crate::plane::largest_magnitude;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// A contact that approaches no faster than this is at rest.
const AT_REST: f64 = 1e-13;
/// After so many impacts in one step, lossy contacts are taken to rest on each other.
const IMPACTS_BEFORE_REST: usize = 4;
/// A contact that closes again within this share of the rest of a step has not really opened.
const AT_ONCE: f64 = 0.02;
/// The smallest speed with which resting contacts are made to part. It doubles with every impact in
/// a step, as contacts that sink only in between ask for more each time.
const LEAST_LIFT: f64 = 1e-9;
/// The lift doubles at most so often.
const MOST_DOUBLINGS: usize = 20;
/// Resting contacts part at this multiple of the speed with which they would sink.
const LIFT_OVER_SINKING: f64 = 1.5;
/// A jam is reported after this multiple of the impacts allowed per step.
const JAMMED: usize = 25;
/// The rest of a step counts as none below this share of it.
const STEP_DONE: f64 = 1e-14;
/// Rods are measured every so many steps without impacts.
const STEPS_BETWEEN_MEASUREMENTS: u64 = 16;

/// Settings of collisions.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct CollisionSettings {
    /// e, 0 (no rebound) to 1 (elastic).
    pub restitution: f64,
    /// Whether rods are obstacles for corners and for the squares on which they hang. By default
    /// they are where a rod is longer than half a half-diagonal: corners do not come between
    /// shorter ones.
    pub rods_block: Option<bool>,
    /// Impacts in one step after which the contacts of the rest of the step are held apart with a
    /// small speed; such steps are counted.
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

/// Counts and extremes of a run.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct CollisionStatistics {
    /// Steps completed.
    pub steps: u64,
    /// Impacts.
    pub impacts: u64,
    /// Contacts with an impulse, over all impacts.
    pub contacts: u64,
    /// Contacts with rods, of those in `contacts`.
    pub rod_contacts: u64,
    /// Sum of all impulses.
    pub impulse: f64,
    /// Energy that impacts added: zero for elastic ones but for rounding.
    pub impact_energy: f64,
    /// The largest change of energy in one impact, over the energy (for restitution 1).
    pub largest_relative_energy_change: f64,
    /// Impacts in which contacts were held apart with a small speed: resting contacts, and steps
    /// with too many impacts.
    pub lifts: u64,
    /// Energy that lifts added.
    pub lift_energy: f64,
    /// Steps with more impacts than `most_impacts_per_step`.
    pub capped_steps: u64,
    /// Impacts whose complementarity problem had to be relaxed.
    pub relaxed: u64,
    /// The largest |Δ| - r0 after an impact or at a check, every 16th step.
    pub largest_rod_violation: f64,
    /// The largest |J v| after an impact or at a check.
    pub largest_rod_rate: f64,
    /// The smallest gap (negative: overlap) of all pairs that were near at the end of a sub-step;
    /// none if none ever was.
    pub smallest_gap: Option<f64>,
    /// Number of times the list of near pairs was made since the engine was made.
    pub candidate_lists: u64,
}

impl CollisionStatistics {
    fn count_impact(&mut self, contacts: &[Contact], impulses: &[f64], exact: bool) {
        self.impacts += 1;
        self.relaxed += u64::from(!exact);
        for (contact, impulse) in contacts.iter().zip(impulses) {
            if *impulse > 0.0 {
                let with_rod =
                    matches!(contact, Contact::RodCorner { .. } | Contact::RodStop { .. });
                self.contacts += 1;
                self.rod_contacts += u64::from(with_rod);
                self.impulse += impulse;
            }
        }
    }

    fn see_gap(&mut self, gap: f64) {
        let smallest = self.smallest_gap.map_or(gap, |smallest| smallest.min(gap));
        self.smallest_gap = Some(smallest);
    }
}

/// A network whose squares collide.
///
/// ```
/// use protomer_linkage::lattice::{
///     CollisionSettings, Edges, Engine, Network, Square, Start, StartVelocities,
/// };
/// use std::sync::Arc;
/// let velocities = StartVelocities::Checkerboard { rate: -1.0 };
/// let start = Start { velocities, ..Start::default() };
/// let network = Network::lattice(2, 2, 1.0, Square::default(), Edges::Open, start.angle)?;
/// let mut state = start.build(&network, 0)?.state;
/// let settings = CollisionSettings::default();
/// let mut engine = Engine::new(Arc::new(network), Vec::new(), &state, settings)?;
/// while engine.statistics().impacts == 0 {
///     engine.step(&mut state, 0.01)?;
/// }
/// // The coherent orbit ends where squares meet, at t = 1.9178.
/// assert!((state.time - 1.92).abs() < 1e-9);
/// # Ok::<(), protomer_linkage::CrystalError>(())
/// ```
pub struct Engine {
    dynamics: Dynamics,
    settings: CollisionSettings,
    detector: Detector,
    statistics: CollisionStatistics,
    next: Vec<f64>,
    /// The state before the step.
    previous_state: State,
    scratch: Vec<f64>,
}

/// A moment in a step at which bodies touch.
#[derive(Clone, Copy)]
struct Moment {
    meeting: Meeting,
    /// Time left in the step.
    remaining_time: f64,
    /// Impacts in this step, this one included.
    impacts: usize,
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
        let rods_block = settings
            .rods_block
            .unwrap_or_else(|| rods_block_by_default(&network));
        let detector = Detector::new(&network, &state.positions, rods_block);
        detector.check_no_overlap(&network, &state.positions, state.time)?;
        Ok(Self {
            scratch: vec![0.0; network.rods.len()],
            next: state.positions.clone(),
            previous_state: state.clone(),
            dynamics,
            settings,
            detector,
            statistics: CollisionStatistics::default(),
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

    /// Settings of collisions.
    pub fn settings(&self) -> &CollisionSettings {
        &self.settings
    }

    /// Whether rods are obstacles.
    pub fn rods_block(&self) -> bool {
        self.detector.rods_block()
    }

    /// Counts and extremes so far.
    pub fn statistics(&self) -> &CollisionStatistics {
        &self.statistics
    }

    /// Continues counting from here, for a run that is resumed.
    pub fn set_statistics(&mut self, statistics: CollisionStatistics) {
        self.statistics = statistics;
    }

    /// Prepares for a state that has been changed from outside, or for another one.
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

    /// Makes one step of length `step`, with its collisions.
    ///
    /// # Errors
    /// Those of [`Dynamics::step`], [`CrystalError::Overlap`] if bodies overlap by more than 1e-9
    /// after all, [`CrystalError::Jammed`]; the state is then the one before the step.
    pub fn step(&mut self, state: &mut State, step: f64) -> Result<()> {
        require_positive("step", step)?;
        self.previous_state.clone_from(state);
        let result = self.advance(state, step);
        if result.is_err() {
            state.clone_from(&self.previous_state);
            // A state that was prepared once can be prepared again; the first error is the one that
            // matters.
            let _ = self.prepare(state);
        }
        result
    }

    fn advance(&mut self, state: &mut State, step: f64) -> Result<()> {
        let network = self.dynamics.network().clone();
        let end = state.time + step;
        let mut remaining_time = step;
        let mut impacts = 0;
        while let Some(meeting) = self.drift_to_contact(&network, state, remaining_time)? {
            remaining_time -= meeting.time;
            impacts += 1;
            let moment = Moment {
                meeting,
                remaining_time,
                impacts,
            };
            self.meet(&network, state, moment)?;
            if remaining_time <= STEP_DONE * step {
                break;
            }
        }
        state.time = end;
        let capped = impacts > self.settings.most_impacts_per_step;
        let statistics = &mut self.statistics;
        statistics.capped_steps += u64::from(capped);
        statistics.steps += 1;
        statistics.candidate_lists = self.detector.lists();
        if impacts > 0 || statistics.steps.is_multiple_of(STEPS_BETWEEN_MEASUREMENTS) {
            self.measure(state);
        }
        Ok(())
    }

    /// Takes the state to the first contact, or to the end of what is left of the step.
    fn drift_to_contact(
        &mut self,
        network: &Network,
        state: &mut State,
        remaining_time: f64,
    ) -> Result<Option<Meeting>> {
        let meeting = self.detector.first_meeting(
            &mut self.dynamics,
            state,
            remaining_time,
            &mut self.next,
        )?;
        let length = meeting.map_or(remaining_time, |meeting| meeting.time);
        if length > 0.0 {
            self.dynamics.arrive(state, length, &self.next)?;
        }
        for watch in self.detector.hot() {
            let gap = watch.gap(network, &state.positions);
            self.statistics.see_gap(gap);
            if gap.is_nan() || gap < -TOUCHING {
                return Err(watch.overlap(network, -gap, state.time));
            }
        }
        Ok(meeting)
    }

    /// Lets everything that touches take part in one impact.
    fn meet(&mut self, network: &Network, state: &mut State, moment: Moment) -> Result<()> {
        let allowed = self.settings.most_impacts_per_step;
        if moment.impacts > JAMMED * allowed.max(1) {
            let (first, second) = moment.meeting.watch.names(network);
            return Err(CrystalError::Jammed {
                events: moment.impacts,
                first,
                second,
                time: self.previous_state.time,
            });
        }
        let touching = self.detector.touching(network, &state.positions);
        let contacts = without_repetitions(&touching);
        let capped = moment.impacts > allowed;
        if moment.remaining_time > 0.0 && (capped || self.rests(moment)) {
            self.hold_apart(network, state, &contacts, moment)
        } else {
            self.strike_while_approaching(network, state, &contacts);
            Ok(())
        }
    }

    /// Whether lossy contacts have come to rest on each other.
    fn rests(
        &self,
        Moment {
            meeting,
            remaining_time,
            impacts,
        }: Moment,
    ) -> bool {
        let at_once = impacts > 1 && meeting.time < AT_ONCE * (meeting.time + remaining_time);
        self.settings.restitution < 1.0 && (at_once || impacts > IMPACTS_BEFORE_REST)
    }

    /// Makes impacts until no contact approaches: one may send a contact that was parting back
    /// together, which then takes part in the next.
    fn strike_while_approaching(
        &mut self,
        network: &Network,
        state: &mut State,
        contacts: &[Contact],
    ) {
        let restitution = self.settings.restitution;
        for _ in 0..self.settings.most_impacts_per_step.max(1) {
            let mut approaching = contacts.to_vec();
            approaching.retain(|contact| rate(contact, network, state) <= AT_REST);
            let is_closing = |contact: &Contact| rate(contact, network, state) < -AT_REST;
            if !approaching.iter().any(is_closing) {
                break;
            }
            let energy = state.kinetic_energy(network);
            let change = self.strike(network, state, &approaching, restitution, None);
            let statistics = &mut self.statistics;
            statistics.impact_energy += change;
            if restitution >= 1.0 {
                let relative = change.abs() / energy;
                statistics.largest_relative_energy_change =
                    statistics.largest_relative_energy_change.max(relative);
            }
        }
    }

    /// Makes one impact and returns the change of the kinetic energy.
    fn strike(
        &mut self,
        network: &Network,
        state: &mut State,
        contacts: &[Contact],
        restitution: f64,
        lift: Option<f64>,
    ) -> f64 {
        let energy = state.kinetic_energy(network);
        let mut rows: Vec<Row> = Vec::with_capacity(contacts.len());
        for contact in contacts {
            rows.push(contact.row(network, &state.positions));
        }
        let (rods, velocities) = (self.dynamics.rods(), &mut state.velocities);
        let result = impact(network, rods, velocities, &rows, restitution, lift);
        self.dynamics.velocities_changed(&mut state.velocities);
        self.statistics
            .count_impact(contacts, &result.impulses, result.exact);
        state.kinetic_energy(network) - energy
    }

    /// Holds contacts apart that would strike again and again. A first impact removes what is left
    /// of their approach; how far they would sink into each other in the rest of the step tells the
    /// speed with which they must part so as not to.
    fn hold_apart(
        &mut self,
        network: &Network,
        state: &mut State,
        contacts: &[Contact],
        Moment {
            remaining_time,
            impacts,
            ..
        }: Moment,
    ) -> Result<()> {
        let lossy = self.settings.restitution < 1.0;
        let restitution = if lossy { 0.0 } else { 1.0 };
        let mut change = self.strike(network, state, contacts, restitution, Some(0.0));
        self.dynamics.drift(state, remaining_time, &mut self.next)?;
        let mut sunk = 0.0_f64;
        for contact in contacts {
            sunk = sunk.max(-contact.gap(network, &self.next));
        }
        let least = LEAST_LIFT * f64::from(1 << impacts.min(MOST_DOUBLINGS));
        let lift = least.max(LIFT_OVER_SINKING * sunk / remaining_time);
        change += self.strike(network, state, contacts, restitution, Some(lift));
        self.statistics.lifts += 1;
        self.statistics.lift_energy += change;
        Ok(())
    }

    fn measure(&mut self, state: &State) {
        let rods = self.dynamics.rods();
        let (_, violation) = rods.violations(&state.positions, &mut self.scratch);
        rods.apply(&state.velocities, &mut self.scratch);
        let rate = largest_magnitude(&self.scratch);
        let statistics = &mut self.statistics;
        statistics.largest_rod_violation = statistics.largest_rod_violation.max(violation.abs());
        statistics.largest_rod_rate = statistics.largest_rod_rate.max(rate);
    }
}

fn rate(contact: &Contact, network: &Network, state: &State) -> f64 {
    let row = contact.row(network, &state.positions);
    row.dot(&state.velocities)
}
