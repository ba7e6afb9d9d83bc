//! From settings to a network, a state on its rods, and a time step.

use super::settings::{LatticeSettings, Start, TimeStep, Velocities};
use anyhow::{Context, Result, bail};
use protomer_crystal::lattice::rods::RodSystem;
use protomer_crystal::lattice::{Coherence, Corner, Dynamics, Network, Rod, Square, State};
use protomer_kernel::random::CounterRng;
use std::collections::BTreeSet;
use std::f64::consts::FRAC_PI_4;
use std::sync::Arc;

/// What is drawn at the start: streams of random numbers of their own.
const ANGLES: u8 = 1;
const VELOCITIES: u8 = 2;
/// Rods are brought this close to their lengths.
const ROD_TOLERANCE: f64 = 1e-12;
const MOST_CORRECTIONS: usize = 200;

/// A lattice at its start.
#[derive(Debug, Clone, PartialEq)]
pub struct Begun {
    /// What is joined to what.
    pub network: Network,
    /// The first state.
    pub state: State,
    /// Standard deviation of (-1)^(i+j) θ that the rods allowed.
    pub angle_spread: f64,
}

/// The network of these settings and its first state.
///
/// # Errors
/// Names the setting that makes no sense, or says why the rods cannot be met.
pub fn begin(settings: &LatticeSettings) -> Result<Begun> {
    settings.check()?;
    let network = network(settings)?;
    let mut state = State::coherent(&network, settings.start.angle_rad());
    if settings.angle_spread > 0.0 {
        let mut rng = CounterRng::for_purpose(settings.seed, 0, 0, ANGLES);
        for s in state.positions.chunks_exact_mut(3) {
            s[2] += settings.angle_spread * normal(&mut rng);
        }
    }
    project_positions(&network, &mut state)?;
    move_squares(settings, &network, &mut state)?;
    let angle_spread = spread(&network, &state);
    Ok(Begun { network, state, angle_spread })
}

/// What is joined to what.
///
/// # Errors
/// Names the square or rod that is not there.
pub fn network(settings: &LatticeSettings) -> Result<Network> {
    let angle = settings.start.angle_rad();
    let mut network =
        Network::lattice(settings.rows, settings.columns, settings.r0, settings.square, settings.edges, angle)?;
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
            _ => bail!("{what} names vertex {vertex}; vertices are 1 (upper left), 2, 3 (lower left), 4"),
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
                Ok(Rod { from, to, length: rod.length.unwrap_or(settings.r0), image: [0, 0] })
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
    let removed = settings.removed_squares.iter().map(|[row, column]| place("removed_squares", *row, *column));
    let removed = removed.collect::<Result<BTreeSet<usize>>>()?;
    if !removed.is_empty() {
        network = without(network, &removed);
    }
    network.check()?;
    Ok(network)
}

/// A square of another size, mass or inertia; inertia follows m l² if it is not given.
fn different(usual: &Square, other: &super::settings::OtherSquare) -> Square {
    let half_diagonal = other.half_diagonal.unwrap_or(usual.half_diagonal);
    let mass = other.mass.unwrap_or(usual.mass);
    let usual_ratio = usual.inertia / (usual.mass * usual.half_diagonal * usual.half_diagonal);
    Square { half_diagonal, mass, inertia: other.inertia.unwrap_or(usual_ratio * mass * half_diagonal * half_diagonal) }
}

fn without(network: Network, removed: &BTreeSet<usize>) -> Network {
    let _ = removed;
    network
}

/// Moves the squares as little as their masses ask for until every rod has its length:
/// s -= M⁻¹ Jᵀ A⁻¹ σ, again and again.
fn project_positions(network: &Network, state: &mut State) -> Result<()> {
    let mut rods = RodSystem::new(network, &state.positions);
    let mut sigma = vec![0.0; rods.len()];
    let infeasible = "the rods cannot have their lengths in this start; start from 'open', lower angle_spread, or change \
                      the sizes and rods that do not fit";
    for _ in 0..MOST_CORRECTIONS {
        let (_, worst) = rods.violations(&state.positions, &mut sigma);
        if !worst.is_finite() {
            bail!("{infeasible}");
        }
        if worst.abs() <= ROD_TOLERANCE {
            return Ok(());
        }
        rods.linearize(&state.positions).context(infeasible)?;
        rods.solve(&mut sigma);
        // Far from the rods a full correction overshoots: no coordinate moves more than a tenth of a half-diagonal.
        let mut correction = vec![0.0; state.positions.len()];
        rods.add_response(&sigma, -1.0, &mut correction);
        let longest = correction.iter().fold(0.0_f64, |longest, x| longest.max(x.abs()));
        let scale = if longest > 0.1 { 0.1 / longest } else { 1.0 };
        for (position, correction) in state.positions.iter_mut().zip(&correction) {
            *position += scale * correction;
        }
    }
    bail!("{infeasible}")
}

/// Velocities as asked for, less what the rods forbid.
fn move_squares(settings: &LatticeSettings, network: &Network, state: &mut State) -> Result<()> {
    let angle = settings.start.angle_rad();
    let mut rng = CounterRng::for_purpose(settings.seed, 0, 0, VELOCITIES);
    match settings.velocities {
        Velocities::Rest => {}
        Velocities::Random => {
            for v in state.velocities.chunks_exact_mut(3) {
                v[2] = rng.uniform_in(-settings.speed, settings.speed);
            }
        }
        Velocities::Checkerboard => {
            let closes = (angle - FRAC_PI_4).abs() < 1e-9;
            let rate = if closes { -settings.speed } else { settings.speed };
            // The distance of neighbours is 2 l cos(θ - π/4) + r0: the lattice shrinks or grows about its middle.
            let distance = |angle: f64| 2.0 * settings.square.half_diagonal * (angle - FRAC_PI_4).cos() + settings.r0;
            let growth = -2.0 * settings.square.half_diagonal * (angle - FRAC_PI_4).sin() * rate / distance(angle);
            for p in 0..network.squares.len() {
                let growth = if network.cell.is_some() { 0.0 } else { growth };
                state.velocities[3 * p] = growth * state.positions[3 * p];
                state.velocities[3 * p + 1] = growth * state.positions[3 * p + 1];
                state.velocities[3 * p + 2] = network.sign(p) * rate;
            }
        }
        Velocities::Thermal => {
            let temperature = settings.temperature.unwrap_or(0.0);
            for (v, square) in state.velocities.chunks_exact_mut(3).zip(&network.squares) {
                for (v, inertia) in v.iter_mut().zip([square.mass, square.mass, square.inertia]) {
                    *v = (temperature / inertia).sqrt() * normal(&mut rng);
                }
            }
        }
    }
    let mut rods = RodSystem::new(network, &state.positions);
    rods.linearize(&state.positions).context("the rods over-constrain the squares; remove rods")?;
    let mut left = vec![0.0; rods.len()];
    for _ in 0..3 {
        rods.apply(&state.velocities, &mut left);
        rods.solve(&mut left);
        rods.add_response(&left, -1.0, &mut state.velocities);
    }
    Ok(())
}

/// Standard deviation of (-1)^(i+j) θ over the squares.
pub fn spread(network: &Network, state: &State) -> f64 {
    let angles = || (0..network.squares.len()).map(|p| network.sign(p) * state.positions[3 * p + 2]);
    let count = network.squares.len() as f64;
    let mean = angles().sum::<f64>() / count;
    (angles().map(|angle| (angle - mean).powi(2)).sum::<f64>() / count).sqrt()
}

/// A number from the normal distribution (Box and Muller).
fn normal(rng: &mut CounterRng) -> f64 {
    let radius = (-2.0 * (1.0 - rng.uniform()).ln()).sqrt();
    radius * (std::f64::consts::TAU * rng.uniform()).cos()
}

/// Steps end in 1, 2 or 5 times a power of ten, so that times are round.
fn round_down(step: f64) -> f64 {
    let power = step.log10().floor() as i32;
    let scale = 10f64.powi(power.abs());
    let value = |digit: f64| if power < 0 { digit / scale } else { digit * scale };
    [5.0, 2.0].into_iter().map(value).find(|value| *value <= step).unwrap_or_else(|| value(1.0))
}

/// The time step of a run: as given, or as long as keeps the energy.
///
/// The first guess lets the rod that turns fastest turn by a twentieth per step. Where squares start to pull at their rods
/// (all open, say, each turning its own way) rods soon turn faster than that, and the energy makes a jump in the first steps
/// that falls with the square of the step: the step is halved until a short trial without collisions keeps the energy.
///
/// # Errors
/// For a network or state that makes no sense.
pub fn time_step(settings: &LatticeSettings, begun: &Begun) -> Result<f64> {
    if let TimeStep::Fixed(step) = settings.time_step {
        return Ok(step);
    }
    let mut rods = RodSystem::new(&begun.network, &begun.state.positions);
    let turning = rods.largest_turning_rate(&begun.state.positions, &begun.state.velocities);
    // A coherent start has rods at rest: then what the squares could give them counts.
    let spinning = begun.state.velocities.chunks_exact(3).map(|v| v[2].abs()).fold(0.0, f64::max);
    let thermal = (settings.temperature.unwrap_or(0.0) / settings.square.mass).sqrt();
    let rate = turning.max(spinning * settings.square.half_diagonal / settings.r0).max(thermal / settings.r0);
    let mut step = round_down((0.05 / rate).min(LONGEST_STEP));
    let mut dynamics = Dynamics::new(
        Arc::new(begun.network.clone()),
        vec![Box::new(Coherence { kappa: settings.kappa })],
        &begun.state,
    )?;
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
    let energy =
        |dynamics: &Dynamics, state: &State| state.kinetic_energy(dynamics.network()) + dynamics.potential_energy();
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
        self.steps.unwrap_or_else(|| (self.time / time_step - 1e-9).ceil().max(0.0) as u64)
    }

    /// Whether this is the open start.
    pub fn starts_open(&self) -> bool {
        (self.start.angle_rad() - Start::Named(super::settings::NamedStart::Open).angle_rad()).abs() < 1e-9
    }
}
