//! Heat baths.
//!
//! | name | what it acts on |
//! |---|---|
//! | [`Ensemble::Nve`] | nothing: the energy is kept |
//! | [`Ensemble::Nvt`] | the kinetic energy as a whole, by stochastic velocity rescaling |
//! | [`Ensemble::Npt`] | the same, and the volume, by trials ([`barostat`](crate::barostat)) |
//! | [`Ensemble::Langevin`] | each body, by friction and noise |
//! | [`Ensemble::Brownian`] | each body, by friction so strong that it has no momentum |
//!
//! The global bath multiplies all momenta by one number close to one. So it keeps the total momentum
//! at zero, and trajectories over times short against its relaxation time are those of Newton:
//! displacements, correlations and relaxation times are those of the bodies alone. Baths that act on
//! single bodies destroy momentum: friction γ makes the motion diffusive after 1/γ, whether or not
//! bodies met until then, and takes the hydrodynamic tails of the velocities. Their dynamics are of
//! bodies in a solvent at rest; averages over configurations are the same.

use crate::state::{Bodies, State};
use crate::{Error, Result};
use protomer_kernel::Vec3;
use protomer_kernel::random::{CounterRng, Purpose};

/// Ensembles, with the bath that keeps the temperature, if any. Temperatures are kT in units of ε.
///
/// ```
/// use protomer_md::bath::Ensemble;
/// assert!(Ensemble::Nve.check().is_ok());
/// assert!(Ensemble::Langevin { temperature: 1.0, friction: 0.5 }.check().is_ok());
/// assert!(Ensemble::Langevin { temperature: 1.0, friction: 0.0 }.check().is_err());
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Ensemble {
    /// Constant energy.
    Nve,
    /// Stochastic velocity rescaling (Bussi, Donadio and Parrinello, J. Chem. Phys. 126, 014101
    /// (2007)) of translations and rotations together.
    Nvt {
        /// Temperature kT.
        temperature: f64,
        /// Relaxation time of the kinetic energy.
        relaxation_time: f64,
    },
    /// Constant pressure and the thermostat of [`Ensemble::Nvt`]: the volume changes by trials.
    Npt {
        /// Temperature kT.
        temperature: f64,
        /// Relaxation time of the kinetic energy.
        relaxation_time: f64,
        /// Pressure.
        pressure: f64,
    },
    /// Langevin dynamics: velocities and angular velocities decay with rate γ.
    Langevin {
        /// Temperature kT.
        temperature: f64,
        /// Friction γ, an inverse time.
        friction: f64,
    },
    /// Overdamped dynamics (Ermak and McCammon): frictions are γ times mass and moments.
    Brownian {
        /// Temperature kT.
        temperature: f64,
        /// Friction γ, an inverse time.
        friction: f64,
    },
}

impl Ensemble {
    /// Checks the numbers.
    ///
    /// ```
    /// use protomer_md::bath::Ensemble;
    /// assert!(Ensemble::Nve.check().is_ok());
    /// assert!(Ensemble::Langevin { temperature: 1.0, friction: 0.1 }.check().is_ok());
    /// assert!(Ensemble::Langevin { temperature: 1.0, friction: -0.1 }.check().is_err());
    /// ```
    ///
    /// # Errors
    /// [`Error::OutOfRange`].
    pub fn check(&self) -> Result<()> {
        let (temperature, other, setting) = match *self {
            Ensemble::Nve => return Ok(()),
            Ensemble::Nvt {
                temperature,
                relaxation_time,
            }
            | Ensemble::Npt {
                temperature,
                relaxation_time,
                ..
            } => (temperature, relaxation_time, "the relaxation time"),
            Ensemble::Langevin {
                temperature,
                friction,
            }
            | Ensemble::Brownian {
                temperature,
                friction,
            } => (temperature, friction, "the friction"),
        };
        if let Ensemble::Npt { pressure, .. } = *self {
            require("the pressure", pressure)?;
        }
        require("the temperature", temperature)?;
        require(setting, other)
    }
}

pub(crate) fn require(setting: &'static str, value: f64) -> Result<()> {
    match value.is_finite() && value > 0.0 {
        true => Ok(()),
        false => Err(Error::OutOfRange {
            what: setting,
            value,
            expected: "a positive number",
        }),
    }
}

/// The random numbers of a step.
pub(crate) fn noise_of(seed: u64, step: u64) -> CounterRng {
    CounterRng::for_purpose(seed, 0, step, Purpose::ContactBath)
}

/// A vector of normal random numbers; in a plane the third is zero.
pub(crate) fn normal_vector(rng: &mut CounterRng, dimension: usize) -> Vec3 {
    let mut vector = Vec3::zeros();
    for axis in 0..dimension {
        vector[axis] = rng.normal();
    }
    vector
}

/// Normal random numbers for the rotational degrees of freedom of a body.
pub(crate) fn normal_turns(rng: &mut CounterRng, turns: usize) -> Vec3 {
    match turns {
        0 => Vec3::zeros(),
        1 => Vec3::new(0.0, 0.0, rng.normal()),
        _ => normal_vector(rng, 3),
    }
}

/// A sum of `count` squares of normal random numbers: twice a gamma variate (Marsaglia and Tsang,
/// ACM Trans. Math. Softw. 26, 363 (2000)).
fn sum_of_squares(rng: &mut CounterRng, count: usize) -> f64 {
    // The method below is for shapes of one and more; here that is count/2.
    if count < 3 {
        return (0..count).map(|_| rng.normal().powi(2)).sum();
    }
    let d = 0.5 * count as f64 - 1.0 / 3.0;
    let c = 1.0 / (9.0 * d).sqrt();
    loop {
        let x = rng.normal();
        let cube = (1.0 + c * x).powi(3);
        let u = 1.0 - rng.uniform();
        // Acceptance without the squeeze: rarely rejected, and simple.
        if cube > 0.0 && u.ln() < 0.5 * x * x + d - d * cube + d * cube.ln() {
            return 2.0 * d * cube;
        }
    }
}

/// Rescales all momenta over a time step; returns the heat taken up.
pub(crate) fn rescale(
    state: &mut State,
    bodies: &Bodies,
    freedoms: usize,
    temperature: f64,
    part: f64,
    rng: &mut CounterRng,
) -> f64 {
    let kinetic: f64 = state.kinetic_energies(bodies).iter().sum();
    if freedoms == 0 || kinetic <= 0.0 {
        return 0.0;
    }
    let decay = (-part).exp();
    // (1 - c) K̄/(N_f K) per degree of freedom, with K̄ = N_f kT/2.
    let share = (1.0 - decay) * 0.5 * temperature / kinetic;
    let first = rng.normal();
    // One number is needed by itself, the others only as the sum of their squares.
    let squares = first * first + sum_of_squares(rng, freedoms - 1);
    // α², by which the kinetic energy changes (Bussi, Donadio and Parrinello, appendix).
    let factor = decay + share * squares + 2.0 * first * (decay * share).sqrt();
    let root = factor.sqrt();
    for body in 0..bodies.count() {
        state.velocities[body] *= root;
        state.spins[body] *= root;
    }
    kinetic * (factor - 1.0)
}

/// Applies friction and noise to each body over a time; returns the heat taken up.
pub(crate) fn damp(
    state: &mut State,
    bodies: &Bodies,
    temperature: f64,
    part: f64,
    rng: &mut CounterRng,
) -> f64 {
    let before: f64 = state.kinetic_energies(bodies).iter().sum();
    // Exact solution of the friction and noise over this time, for any length of it.
    let decay = (-part).exp();
    let added = (temperature * (1.0 - decay * decay)).sqrt();
    for body in 0..bodies.count() {
        let kind = bodies.kind(body);
        let kick = added / kind.mass.sqrt() * normal_vector(rng, kind.dimension);
        state.velocities[body] = decay * state.velocities[body] + kick;
        let turns = normal_turns(rng, kind.turns());
        // L = I ω: noise of the angular momentum grows with √I.
        let twist = added * turns.component_mul(&kind.moments.map(f64::sqrt));
        state.spins[body] = decay * state.spins[body] + twist;
    }
    state.kinetic_energies(bodies).iter().sum::<f64>() - before
}

/// Draws the spins about axes of revolution at a temperature, and returns the heat taken up.
///
/// No contact changes these spins, so a bath that scales all momenta together never brings them to the
/// temperature of the others: a compression leaves them cold.
pub(crate) fn draw_free_spins(
    state: &mut State,
    bodies: &Bodies,
    temperature: f64,
    [seed, step]: [u64; 2],
) -> f64 {
    let mut rng = CounterRng::for_purpose(seed, 0, step, Purpose::ContactVelocities);
    let before = state.kinetic_energies(bodies)[1];
    for (body, spin) in state.spins.iter_mut().enumerate() {
        let kind = bodies.kind(body);
        if let Some(axis) = kind.axis_of_revolution() {
            spin[axis] = (temperature * kind.moments[axis]).sqrt() * rng.normal();
        }
    }
    state.kinetic_energies(bodies)[1] - before
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_of_squares_have_their_moments() {
        let mut rng = CounterRng::new(3, 0, 0);
        for count in [1, 2, 7, 500] {
            const DRAWS: usize = 40_000;
            let (mut mean, mut square) = (0.0, 0.0);
            for _ in 0..DRAWS {
                let sum = sum_of_squares(&mut rng, count);
                mean += sum / DRAWS as f64;
                square += sum * sum / DRAWS as f64;
            }
            let expected = count as f64;
            // The standard error of the mean is sqrt(2 count/40 000).
            assert!((mean - expected).abs() < 5.0 * (2.0 * expected / DRAWS as f64).sqrt());
            let variance = square - mean * mean;
            assert!(
                (variance / (2.0 * expected) - 1.0).abs() < 0.1,
                "{count}: {variance}"
            );
        }
    }
}
