//! From settings to a network, a state on its rods, and a time step.

use super::mover::forces;
use super::settings::{LatticeSettings, OtherSquare, TimeStep, Velocities};
use anyhow::{Result, bail};
use protomer_crystal::CrystalError;
use protomer_crystal::lattice::rods::RodSystem;
use protomer_crystal::lattice::{
    AngularVelocities, Corner, Dynamics, Langevin, Network, Rod, Square, Start, State,
};
use std::collections::BTreeSet;
use std::f64::consts::FRAC_PI_4;
use std::sync::Arc;

/// A lattice at its start.
#[derive(Debug, Clone, PartialEq)]
pub struct Begun {
    /// What is joined to what.
    pub network: Network,
    /// The first state.
    pub state: State,
    /// Standard deviation about the coherent state of the random angles that were drawn.
    pub angle_spread_drawn: f64,
    /// The same of what the rods allowed.
    pub angle_spread: f64,
}

/// The network of these settings and its first state.
///
/// # Errors
/// Names the setting that makes no sense, or says why the rods cannot be met.
pub fn begin(settings: &LatticeSettings) -> Result<Begun> {
    settings.check()?;
    let network = network(settings)?;
    let angle = settings.start.angle_rad();
    let closes = (angle - FRAC_PI_4).abs() < 1e-9;
    let velocities = match settings.velocities {
        Velocities::Rest | Velocities::Thermal => AngularVelocities::Rest,
        Velocities::Random if settings.speed > 0.0 => AngularVelocities::Uniform {
            largest: settings.speed,
            sum_of_squares: None,
        },
        Velocities::Random => AngularVelocities::Rest,
        Velocities::Checkerboard => AngularVelocities::Checkerboard {
            rate: if closes {
                -settings.speed
            } else {
                settings.speed
            },
        },
    };
    let start = Start {
        angle,
        angle_spread: settings.angle_spread,
        velocities,
        seed: settings.seed,
    };
    let started = start.build(&network, 0).map_err(|error| match error {
        CrystalError::OverConstrained { .. } if network.cell.is_some() => anyhow::Error::from(error).context(
            "straight rows and columns across periodic edges hold each other; leave out a rod of each with removed_rods",
        ),
        // That says itself what is wrong.
        CrystalError::OverConstrained { .. } => anyhow::Error::from(error),
        _ => anyhow::Error::from(error).context(
            "the rods cannot have their lengths in this start; start from 'open', lower angle_spread, or change the \
             sizes and rods that do not fit",
        ),
    })?;
    let mut state = started.state;
    if settings.velocities == Velocities::Thermal {
        let mut dynamics = Dynamics::new(Arc::new(network.clone()), Vec::new(), &state)?;
        heat_bath(settings)?.draw_velocities(&mut dynamics, &mut state);
    }
    Ok(Begun {
        network,
        state,
        angle_spread_drawn: started.angle_spread_drawn,
        angle_spread: started.angle_spread_reached,
    })
}

/// The heat bath of these settings; at kT = 0 if they have no temperature.
///
/// # Errors
/// For a temperature or friction that makes no sense.
pub fn heat_bath(settings: &LatticeSettings) -> Result<Langevin> {
    Ok(Langevin::new(
        settings.temperature.unwrap_or(0.0),
        settings.friction,
        settings.seed,
        0,
    )?)
}

/// What is joined to what.
///
/// # Errors
/// Names the square or rod that is not there.
pub fn network(settings: &LatticeSettings) -> Result<Network> {
    let angle = settings.start.angle_rad();
    let mut network = Network::lattice(
        settings.rows,
        settings.columns,
        settings.r0,
        settings.square,
        settings.edges,
        angle,
    )?;
    let place = |what: &str, row: usize, column: usize| {
        if row >= settings.rows || column >= settings.columns {
            bail!(
                "{what} names the square in row {row} and column {column}; rows go from 0 to {}, columns from 0 to {}",
                settings.rows - 1,
                settings.columns - 1
            );
        }
        Ok(row * settings.columns + column)
    };
    let corner = |what: &str, [row, column, vertex]: [usize; 3]| -> Result<Corner> {
        let square = place(what, row, column)?;
        match u8::try_from(vertex) {
            Ok(vertex @ 1..=4) => Ok(Corner { square, vertex }),
            _ => bail!(
                "{what} names vertex {vertex}; vertices are 1 (upper left), 2, 3 (lower left), 4"
            ),
        }
    };
    for other in &settings.other_squares {
        let square = place("other_squares", other.at[0], other.at[1])?;
        network.squares[square] = different(&settings.square, other);
    }
    if let Some(listed) = &settings.rods {
        network.rods = listed
            .iter()
            .map(|rod| {
                let (from, to) = (corner("rods", rod.from)?, corner("rods", rod.to)?);
                Ok(Rod {
                    from,
                    to,
                    length: rod.length.unwrap_or(settings.r0),
                    image: [0, 0],
                })
            })
            .collect::<Result<_>>()?;
    }
    for ends in &settings.removed_rods {
        let end = corner("removed_rods", *ends)?;
        let before = network.rods.len();
        network.rods.retain(|rod| rod.from != end && rod.to != end);
        if network.rods.len() == before {
            bail!("removed_rods names {ends:?}, where no rod ends; leave it out");
        }
    }
    let removed = settings
        .removed_squares
        .iter()
        .map(|[row, column]| place("removed_squares", *row, *column));
    let removed = removed.collect::<Result<BTreeSet<usize>>>()?;
    if !removed.is_empty() {
        network = network.without_squares(&removed.into_iter().collect::<Vec<_>>())?;
    }
    network.check()?;
    Ok(network)
}

/// A square of another size, mass or inertia; inertia follows m l² if it is not given.
fn different(usual: &Square, other: &OtherSquare) -> Square {
    let half_diagonal = other.half_diagonal.unwrap_or(usual.half_diagonal);
    let mass = other.mass.unwrap_or(usual.mass);
    let usual_ratio = usual.inertia / (usual.mass * usual.half_diagonal * usual.half_diagonal);
    Square {
        half_diagonal,
        mass,
        inertia: other
            .inertia
            .unwrap_or(usual_ratio * mass * half_diagonal * half_diagonal),
    }
}

/// Steps end in 1, 2 or 5 times a power of ten, so that times are round.
fn round_down(step: f64) -> f64 {
    let power = step.log10().floor() as i32;
    let scale = 10f64.powi(power.abs());
    let value = |digit: f64| {
        if power < 0 {
            digit / scale
        } else {
            digit * scale
        }
    };
    [5.0, 2.0]
        .into_iter()
        .map(value)
        .find(|value| *value <= step)
        .unwrap_or_else(|| value(1.0))
}

/// The time step of a run: as given, or as long as keeps the energy.
///
/// The first guess lets the rod that turns fastest turn by a twentieth per step. Where squares
/// start to pull at their rods (all open, say, each turning its own way) rods soon turn faster than
/// that, and the energy makes a jump in the first steps that falls with the square of the step: the
/// step is halved until a short trial without collisions keeps the energy.
///
/// # Errors
/// For a network or state that makes no sense.
pub fn time_step(settings: &LatticeSettings, begun: &Begun) -> Result<f64> {
    if let TimeStep::Fixed(step) = settings.time_step {
        return Ok(step);
    }
    let mut rods = RodSystem::new(&begun.network);
    let turning = rods.largest_turning_rate(&begun.state.positions, &begun.state.velocities);
    // A coherent start has rods at rest: then what the squares could give them counts.
    let spinning = begun
        .state
        .velocities
        .chunks_exact(3)
        .map(|v| v[2].abs())
        .fold(0.0, f64::max);
    let thermal = (settings.temperature.unwrap_or(0.0) / settings.square.mass).sqrt();
    let rate = turning
        .max(spinning * settings.square.half_diagonal / settings.r0)
        .max(thermal / settings.r0);
    let mut step = round_down((0.05 / rate).min(LONGEST_STEP));
    let forces = forces(settings, &begun.network)?;
    let mut dynamics = Dynamics::new(Arc::new(begun.network.clone()), forces, &begun.state)?;
    for _ in 0..MOST_HALVINGS {
        if trial(&mut dynamics, &begun.state, step)? < TRIAL_ERROR {
            break;
        }
        step = round_down(0.55 * step);
    }
    Ok(step)
}

/// Largest relative change of the energy in a few steps; infinite if one cannot be done.
fn trial(dynamics: &mut Dynamics, first: &State, step: f64) -> Result<f64> {
    let mut state = first.clone();
    dynamics.prepare(&state)?;
    let energy = |dynamics: &Dynamics, state: &State| {
        state.kinetic_energy(dynamics.network()) + dynamics.potential_energy()
    };
    let start = energy(dynamics, &state);
    let mut largest = 0.0_f64;
    for _ in 0..TRIAL_STEPS {
        if dynamics.step(&mut state, step).is_err() {
            return Ok(f64::INFINITY);
        }
        largest = largest.max((energy(dynamics, &state) - start).abs());
    }
    Ok(if start > 0.0 { largest / start } else { 0.0 })
}

/// A square at rest may be pushed.
const LONGEST_STEP: f64 = 0.01;
/// What the energy may jump by in a trial.
const TRIAL_ERROR: f64 = 1e-3;
const TRIAL_STEPS: u64 = 20;
const MOST_HALVINGS: usize = 8;

impl LatticeSettings {
    /// Steps to do in all.
    pub fn total_steps(&self, time_step: f64) -> u64 {
        self.steps
            .unwrap_or_else(|| (self.time / time_step - 1e-9).ceil().max(0.0) as u64)
    }
}
