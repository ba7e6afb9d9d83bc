//! The motion from a state in a file: without collisions, up to the first contact, and through it.
//!
//! The file is JSON with `ns` (squares along an edge), `r0`, `s0` and `v0` (x, y, θ and their
//! rates, square after square), `times`; `kappa`, `l` and `I` are optional; other keys are ignored.

use super::limits::{
    COORDINATE, INERTIA, KAPPA, LENGTH, MOST_SQUARES, MOST_STEPS, TIME, TIME_STEP, TIME_STEP_LEAST,
};
use anyhow::{Context, Result, bail};
use protomer_common::answer::Answer;
use protomer_common::range::Range;
use protomer_linkage::lattice::collision::replay;
use protomer_linkage::lattice::contact::TOUCHING;
use protomer_linkage::lattice::{Coherence, Dynamics, Edges, Network, Square, State};
use protomer_results::keys;
use serde::{Deserialize, Serialize};
use std::f64::consts::FRAC_PI_4;
use std::path::Path;
use std::sync::Arc;

/// A lattice, its initial state, and the times to report.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct LatticeFile {
    /// Squares along an edge.
    #[serde(rename = "ns")]
    pub squares_along_edge: usize,
    /// Length of the rods.
    pub r0: f64,
    /// κ of the coherence potential, an inverse time squared.
    #[serde(default)]
    pub kappa: f64,
    /// Half-diagonal of the squares.
    #[serde(default = "one")]
    pub l: f64,
    /// Moment of inertia of the squares; l²/3 if left out. Their mass is 1.
    #[serde(rename = "I")]
    pub inertia: Option<f64>,
    /// Coordinates x, y, θ of square after square at time 0.
    #[serde(default)]
    pub s0: Vec<f64>,
    /// Rates of change of the coordinates in `s0`.
    #[serde(default)]
    pub v0: Vec<f64>,
    /// Times to report.
    #[serde(default)]
    pub times: Vec<f64>,
    /// A state in which squares touch.
    pub first_collision: Option<ContactState>,
}

/// A state in which squares touch.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct ContactState {
    /// Time of the contact.
    #[serde(default)]
    pub t: f64,
    /// Coordinates x, y, θ of square after square.
    pub s: Vec<f64>,
    /// Rates of the coordinates just before the contact.
    pub v: Vec<f64>,
    /// The contacts; found from the state if omitted.
    #[serde(default)]
    pub contacts: Vec<[usize; 3]>,
}

fn one() -> f64 {
    1.0
}

/// Checks that there are three numbers in range for every square, or none where the file leaves the
/// state out.
fn check_state(name: &str, numbers: &[f64], count: usize) -> Result<()> {
    if !numbers.is_empty() && numbers.len() != count {
        bail!(
            "{name} has {} numbers; {} squares need {count}: three for each",
            numbers.len(),
            count / 3
        );
    }
    for number in numbers {
        COORDINATE.require(&format!("a number in {name}"), *number)?;
    }
    Ok(())
}

/// The result of [`replay()`].
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Replay {
    /// The largest time step taken.
    pub time_step: f64,
    /// The times of the file.
    pub times: Vec<f64>,
    /// Coordinates x, y, θ at these times. Collisions are ignored, even after the first contact.
    pub s: Vec<Vec<f64>>,
    /// Rates of the coordinates at these times.
    pub v: Vec<Vec<f64>>,
    /// Sum of the kinetic energy and the coherence potential.
    pub energy: Vec<f64>,
    /// The largest error of a coordinate in `s`: 4/3 of its change with half the step, for an
    /// integrator of second order.
    pub estimated_error: f64,
    /// The first contact; `None` if there is none before the limit.
    pub first_collision: Option<FirstCollision>,
}

/// The first contact and its outcome.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FirstCollision {
    /// Time of the contact.
    pub t: f64,
    /// Coordinates x, y, θ of square after square.
    pub s: Vec<f64>,
    /// Rates of the coordinates just before the contact.
    pub v: Vec<f64>,
    /// The striking square, its corner (1 to 4), and the struck square.
    pub contacts: Vec<[usize; 3]>,
    /// Rates of the coordinates just after an elastic collision.
    pub v_after: Vec<f64>,
}

/// The result of [`respond`].
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Response {
    /// Rates of the coordinates just after an elastic collision.
    pub v_after: Vec<f64>,
    /// The striking square, its corner (1 to 4), and the struck square.
    pub contacts: Vec<[usize; 3]>,
    /// Impulses along the normals; corners that meet head-on are listed from both sides and share
    /// one impulse.
    pub impulses: Vec<f64>,
    /// Change of the kinetic energy.
    pub energy_change: f64,
}

impl Answer for Replay {
    fn text(&self) -> String {
        let energies = self.times.iter().zip(&self.energy);
        let mut lines: Vec<String> = energies
            .map(|(time, energy)| format!("t = {time}: energy {energy:.12}"))
            .collect();
        if !self.times.is_empty() {
            lines.push(format!(
                "coordinates are off by about {:.1e} at most",
                self.estimated_error
            ));
        }
        lines.push(match &self.first_collision {
            Some(first) => first.describe(),
            None => "no contact".into(),
        });
        lines.join("\n")
    }
}

impl FirstCollision {
    fn describe(&self) -> String {
        let contact = |[striker, vertex, target]: &[usize; 3]| {
            format!("corner {vertex} of square {striker} on square {target}")
        };
        let contacts: Vec<String> = self.contacts.iter().map(contact).collect();
        format!(
            "first contact at t = {:.12}: {}",
            self.t,
            contacts.join(", ")
        )
    }
}

impl Answer for Response {
    fn text(&self) -> String {
        format!(
            "{} contacts, impulses {:?}, kinetic energy changes by {:.1e}",
            self.contacts.len(),
            self.impulses,
            self.energy_change
        )
    }
}

impl LatticeFile {
    /// Reads a file and checks its numbers.
    ///
    /// # Errors
    /// Names the file, the line and the key.
    pub fn read(path: &Path) -> Result<Self> {
        let file: Self = keys::read_json(path)?;
        file.check().with_context(|| path.display().to_string())?;
        Ok(file)
    }

    /// Checks what the types cannot: ranges, and the order of the times.
    ///
    /// # Errors
    /// Names the key, its value and its range.
    pub fn check(&self) -> Result<()> {
        let size = self.squares_along_edge;
        if size == 0 || size.saturating_mul(size) > MOST_SQUARES {
            bail!(
                "ns is {size}; it must be from 1 to {}, the squares along an edge",
                MOST_SQUARES.isqrt()
            );
        }
        LENGTH.require("r0", self.r0)?;
        LENGTH.require("l", self.l)?;
        KAPPA.require("kappa", self.kappa)?;
        if let Some(inertia) = self.inertia {
            INERTIA.require("I", inertia)?;
        }
        for (name, numbers) in [("s0", &self.s0), ("v0", &self.v0)] {
            check_state(name, numbers, 3 * size * size)?;
        }
        if let Some(contact) = &self.first_collision {
            check_state("first_collision.s", &contact.s, 3 * size * size)?;
            check_state("first_collision.v", &contact.v, 3 * size * size)?;
        }
        let mut earlier = 0.0;
        for time in &self.times {
            TIME.require("a time in times", *time)?;
            if *time < earlier {
                bail!(
                    "the time {time} follows {earlier} in times; list the times in increasing order"
                );
            }
            earlier = *time;
        }
        Ok(())
    }

    fn network(&self) -> Result<Arc<Network>> {
        let square = Square {
            half_diagonal: self.l,
            mass: 1.0,
            inertia: self.inertia.unwrap_or(self.l * self.l / 3.0),
        };
        let size = self.squares_along_edge;
        Ok(Arc::new(Network::lattice(
            size,
            size,
            self.r0,
            square,
            Edges::Open,
            FRAC_PI_4,
        )?))
    }

    fn first_state(&self) -> State {
        State {
            time: 0.0,
            positions: self.s0.clone(),
            velocities: self.v0.clone(),
        }
    }

    fn dynamics(&self, state: &State) -> Result<Dynamics> {
        Ok(Dynamics::new(
            self.network()?,
            vec![Box::new(Coherence { kappa: self.kappa })],
            state,
        )?)
    }
}

/// Integrates the state of a file with steps of at most `time_step`, and up to its first contact
/// if that comes before `longest`.
///
/// # Errors
/// For a state that does not fit the lattice, times that do not increase, or a step that is too
/// large.
pub fn replay(file: &LatticeFile, time_step: f64, longest: f64) -> Result<Replay> {
    TIME_STEP.require("--dt", time_step)?;
    Range::new(TIME_STEP_LEAST, 1e9, "").require("--longest", longest)?;
    file.check()?;
    let last = file.times.last().copied().unwrap_or(0.0);
    if last.max(longest) / time_step > MOST_STEPS as f64 {
        bail!(
            "a time of {} in steps of {time_step} takes more than {MOST_STEPS} steps; give a larger --dt",
            last.max(longest)
        );
    }
    let motion = Motion::from_file(file, time_step)?;
    let finer = Motion::from_file(file, 0.5 * time_step)?;
    Ok(Replay {
        time_step,
        times: file.times.clone(),
        estimated_error: SECOND_ORDER * motion.largest_difference(&finer),
        s: motion.s,
        v: motion.v,
        energy: motion.energy,
        first_collision: first_collision(file, time_step, longest)?,
    })
}

/// The error of a step over the change with half of it, where errors grow with the square of the
/// step: 1/(1 - 1/4).
const SECOND_ORDER: f64 = 4.0 / 3.0;

/// States and energies at the times of a file, without collisions.
struct Motion {
    s: Vec<Vec<f64>>,
    v: Vec<Vec<f64>>,
    energy: Vec<f64>,
}

impl Motion {
    fn from_file(file: &LatticeFile, time_step: f64) -> Result<Self> {
        let mut state = file.first_state();
        let mut dynamics = file.dynamics(&state)?;
        let (mut s, mut v, mut energy) = (Vec::new(), Vec::new(), Vec::new());
        for time in &file.times {
            advance(&mut dynamics, &mut state, *time, time_step)?;
            s.push(state.positions.clone());
            v.push(state.velocities.clone());
            energy.push(state.kinetic_energy(dynamics.network()) + dynamics.potential_energy());
        }
        Ok(Self { s, v, energy })
    }

    fn largest_difference(&self, other: &Self) -> f64 {
        let mut largest = 0.0_f64;
        for (a, b) in self.s.iter().flatten().zip(other.s.iter().flatten()) {
            largest = largest.max((a - b).abs());
        }
        largest
    }
}

/// Advances to `time` in the smallest number of equal steps that are no longer than `time_step`.
fn advance(dynamics: &mut Dynamics, state: &mut State, time: f64, time_step: f64) -> Result<()> {
    let duration = time - state.time;
    // A ratio that is an integer up to rounding is meant to be an integer.
    let steps = (duration / time_step - 1e-9).ceil().max(0.0) as u64;
    for _ in 0..steps {
        dynamics.step(state, duration / steps as f64)?;
    }
    state.time = time;
    Ok(())
}

fn first_collision(
    file: &LatticeFile,
    time_step: f64,
    longest: f64,
) -> Result<Option<FirstCollision>> {
    let mut state = file.first_state();
    let mut dynamics = file.dynamics(&state)?;
    let Some(collision) =
        replay::first_contact(&mut dynamics, &mut state, time_step, longest, false)?
    else {
        return Ok(None);
    };
    let contacts = collision.listed();
    let State {
        positions: s,
        velocities: v,
        ..
    } = collision.state;
    let response = replay::respond(dynamics.network(), &s, &v, &contacts, 1.0)?;
    Ok(Some(FirstCollision {
        t: collision.time,
        s,
        v,
        contacts,
        v_after: response.velocities_after,
    }))
}

/// Computes the elastic impact at the contact state of a file.
///
/// # Errors
/// If the file has no contact state, the state does not fit the lattice, or no squares touch.
pub fn respond(file: &LatticeFile) -> Result<Response> {
    let Some(contact) = &file.first_collision else {
        bail!(
            "the file has no first_collision; add one with the state s and the rates v just before"
        );
    };
    let network = file.network()?;
    let state = State {
        time: contact.t,
        positions: contact.s.clone(),
        velocities: contact.v.clone(),
    };
    state.check(&network)?;
    let pairs = replay::touching(&network, &state);
    let contacts = if pairs.is_empty() {
        contact.contacts.clone()
    } else {
        pairs
    };
    if contacts.is_empty() {
        bail!(
            "no two squares of first_collision.s are within {TOUCHING} of each other; give a contact state"
        );
    }
    let response = replay::respond(
        &network,
        &state.positions,
        &state.velocities,
        &contacts,
        1.0,
    )?;
    let after = State {
        velocities: response.velocities_after.clone(),
        ..state.clone()
    };
    Ok(Response {
        energy_change: after.kinetic_energy(&network) - state.kinetic_energy(&network),
        v_after: response.velocities_after,
        contacts,
        impulses: response.impulses,
    })
}
