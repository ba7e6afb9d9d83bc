//! A time step that keeps the energy.
//!
//! A step may move the corners of the fastest square by a twentieth of a rod, at most by a hundredth
//! of a half-diagonal. How fast squares will turn follows from the energy, not from the start: a
//! lattice of 10 x 10 squares that opens coherently turns ten times faster in the open state than in
//! the closed one, because its translations stop there. The bound is the rate at which all of the
//! energy is in the spins, equally shared,
//!
//! ω² = 2 E / Σ I + kT / min I.
//!
//! Where squares start to pull at their rods (all open, say, each turning its own way) rods soon turn
//! faster than that, and the energy makes a jump in the first steps that falls with the square of
//! the step: the step is halved until a short trial without collisions keeps the energy.

use super::dynamics::Dynamics;
use super::force::Force;
use super::network::Network;
use super::state::{State, angles};
use crate::Result;
use std::sync::Arc;

/// A rod turns by at most this angle in the first guess, rad.
const TURN_PER_STEP: f64 = 0.05;
/// Rods longer than this share of a half-diagonal count as this long: the corners of squares that
/// pull at long rods still move on arcs of a half-diagonal.
const LONGEST_LEVER: f64 = 0.2;
/// The longest step: squares that are at rest may be pushed later.
const LONGEST_STEP: f64 = 0.01;
/// The largest relative change of the energy in a trial.
const TRIAL_ERROR: f64 = 1e-3;
/// Steps of a trial.
const TRIAL_STEPS: u64 = 20;
/// Largest number of times that the step is shortened, by about half.
const MOST_HALVINGS: usize = 8;

/// A time step for a run from this state under these forces at the temperature kT (0 without a heat
/// bath): 1, 2 or 5 times a power of ten, so that times are round.
///
/// ```
/// use protomer_linkage::lattice::time_step::automatic_time_step;
/// use protomer_linkage::lattice::{Plan, Start, StartVelocities};
/// let plan = Plan { rows: 2, columns: 2, rod_length: 1.0, ..Plan::default() };
/// let network = plan.network()?;
/// let velocities = StartVelocities::Checkerboard { rate: 1.0 };
/// let open = Start { velocities, ..Start::default() }.build(&network, 0)?.state;
/// assert_eq!(automatic_time_step(&network, &open, Vec::new(), 0.0)?, 0.01);
/// // From the closed state the squares come through the open one faster than they left.
/// let closed = Start { velocities, ..Start::closed() }.build(&network, 0)?.state;
/// assert_eq!(automatic_time_step(&network, &closed, Vec::new(), 0.0)?, 0.005);
/// # Ok::<(), protomer_linkage::CrystalError>(())
/// ```
///
/// # Errors
/// Those of [`Dynamics::new`].
pub fn automatic_time_step(
    network: &Network,
    state: &State,
    forces: Vec<Box<dyn Force>>,
    kt: f64,
) -> Result<f64> {
    let mut dynamics = Dynamics::new(Arc::new(network.clone()), forces, state)?;
    let rate = fastest_turning(&mut dynamics, state, kt);
    let mut step = round_down((TURN_PER_STEP / rate).min(LONGEST_STEP));
    for _ in 0..MOST_HALVINGS {
        // A trial, as the bound from the energy misses squares that start to pull at their rods.
        if trial_error(&mut dynamics, state, step)? < TRIAL_ERROR {
            break;
        }
        step = round_down(0.55 * step);
    }
    Ok(step)
}

/// Largest rate at which rods turn at the start, or could turn once the squares have all of the
/// energy.
fn fastest_turning(dynamics: &mut Dynamics, state: &State, kt: f64) -> f64 {
    let turning = dynamics
        .rods()
        .largest_turning_rate(&state.positions, &state.velocities);
    let network = dynamics.network();
    let spins = angles(&state.velocities).take(network.squares.len());
    let spin = spins.fold(0.0_f64, |most, omega| most.max(omega.abs()));
    let most_energy = state.kinetic_energy(network) + dynamics.potential_energy().max(0.0);
    let (mut largest, mut inertia) = (0.0_f64, 0.0);
    let mut lightest = f64::INFINITY;
    for square in &network.squares {
        largest = largest.max(square.half_diagonal);
        inertia += square.inertia;
        lightest = lightest.min(square.inertia);
    }
    // All energy in the spins, equally shared, and kT for one square.
    let shared = (2.0 * most_energy / inertia + kt / lightest).sqrt();
    let mut lever = LONGEST_LEVER * largest;
    for rod in &network.rods {
        lever = lever.min(rod.length);
    }
    // The corner of the largest square over the shortest rod.
    turning.max(spin.max(shared) * largest / lever)
}

/// Largest relative change of the energy in a few steps; infinite if one of them fails, or leaves an
/// energy that is not a number.
fn trial_error(dynamics: &mut Dynamics, first: &State, step: f64) -> Result<f64> {
    let mut state = first.clone();
    dynamics.prepare(&state)?;
    let start = energy(dynamics, &state);
    let mut largest = 0.0_f64;
    for _ in 0..TRIAL_STEPS {
        // A step that fails counts as an infinite error: try a shorter one.
        if dynamics.step(&mut state, step).is_err() {
            return Ok(f64::INFINITY);
        }
        let change = (energy(dynamics, &state) - start).abs();
        if change.is_nan() {
            return Ok(f64::INFINITY);
        }
        largest = largest.max(change);
    }
    Ok(if start > 0.0 { largest / start } else { 0.0 })
}

fn energy(dynamics: &Dynamics, state: &State) -> f64 {
    state.kinetic_energy(dynamics.network()) + dynamics.potential_energy()
}

/// The largest of 1, 2 or 5 times a power of ten that is not above the step.
fn round_down(step: f64) -> f64 {
    let power = step.log10().floor() as i32;
    let scale = 10f64.powi(power.abs());
    // Division by an exact power of ten is correctly rounded; multiplication by 0.001 is not.
    let [five, two, one] = [5.0, 2.0, 1.0].map(|digit| {
        if power < 0 {
            digit / scale
        } else {
            digit * scale
        }
    });
    if five <= step {
        five
    } else if two <= step {
        two
    } else {
        one
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice::{Plan, Start, StartVelocities};

    /// A force whose energy is a number only where the first square has this angle.
    struct OnlyAt(f64);

    impl Force for OnlyAt {
        fn accelerate(&self, _: &Network, positions: &[f64], _: &mut [f64]) -> f64 {
            if positions[2] == self.0 {
                1.0
            } else {
                f64::NAN
            }
        }
    }

    #[test]
    fn a_trial_whose_energy_is_no_number_fails() {
        let plan = Plan {
            rows: 2,
            columns: 2,
            rod_length: 1.0,
            ..Plan::default()
        };
        let network = plan.network().unwrap();
        let start = Start {
            velocities: StartVelocities::Checkerboard { rate: 1.0 },
            ..Start::default()
        };
        let state = start.build(&network, 0).unwrap().state;
        let force = OnlyAt(state.positions[2]);
        let mut dynamics = Dynamics::new(Arc::new(network), vec![Box::new(force)], &state).unwrap();
        let error = trial_error(&mut dynamics, &state, 1e-4).unwrap();
        assert_eq!(error, f64::INFINITY);
    }

    #[test]
    fn steps_are_round() {
        for (step, rounded) in [
            (0.0123, 0.01),
            (0.05, 0.05),
            (0.0499, 0.02),
            (1.9e-3, 1e-3),
            (7e-4, 5e-4),
            (3.0, 2.0),
            (60.0, 50.0),
        ] {
            assert_eq!(round_down(step), rounded);
        }
    }
}
