//! How bodies begin: on a lattice so wide that none feels another, turned at random, with the
//! velocities of a temperature.

use crate::bath::{normal_turns, normal_vector, require};
use crate::near::free_distance;
use crate::state::{Bodies, State};
use crate::{Error, Result};
use protomer_kernel::random::{CounterRng, Purpose};
use protomer_kernel::{Boundary, Vec3};
use std::f64::consts::TAU;

/// Third length of a box in a plane, where nothing depends on it.
pub const ACROSS_THE_PLANE: f64 = 1e6;

/// The least number density at which bodies may be turned at random on a square or simple cubic
/// lattice without repelling each other.
///
/// ```
/// use protomer_md::{body::Kind, start::free_density, state::Bodies};
/// let bodies = |radius| Kind::ball(3, radius).map(|kind| Bodies::of_one_kind(kind, 27));
/// let ratio = free_density(&bodies(1.0)?) / free_density(&bodies(2.0)?);
/// assert!((ratio - 8.0).abs() < 1e-9, "twice the radius needs eight times the room");
/// # Ok::<(), protomer_md::Error>(())
/// ```
pub fn free_density(bodies: &Bodies) -> f64 {
    let mut spacing = 0.0_f64;
    for first in &bodies.kinds {
        for second in &bodies.kinds {
            spacing = spacing.max(free_distance(first, second));
        }
    }
    let count = bodies.count();
    let sites = sites(count, bodies.dimension()).powi(bodies.dimension() as i32);
    count as f64 / (sites * spacing.powi(bodies.dimension() as i32))
}

/// Sites along an edge of the lattice.
fn sites(count: usize, dimension: usize) -> f64 {
    let mut sites = 1_usize;
    while sites.pow(dimension as u32) < count {
        sites += 1;
    }
    sites as f64
}

/// Bodies at this number density, at rest, turned at random.
///
/// ```
/// use protomer_md::start::{free_density, on_a_lattice};
/// use protomer_md::{body::Kind, state::Bodies};
/// let bodies = Bodies::of_one_kind(Kind::ball(3, 0.5)?, 8);
/// let density = 0.5 * free_density(&bodies);
/// let state = on_a_lattice(&bodies, density, 1)?;
/// assert!((state.volume(3) * density - 8.0).abs() < 1e-9);
/// assert!(on_a_lattice(&bodies, 3.0 * density, 1).is_err());
/// # Ok::<(), protomer_md::Error>(())
/// ```
///
/// # Errors
/// [`Error::OutOfRange`] for a density above [`free_density`], where they might overlap.
pub fn on_a_lattice(bodies: &Bodies, density: f64, seed: u64) -> Result<State> {
    require("the number density", density)?;
    let free = free_density(bodies);
    if density > free * (1.0 + 1e-12) {
        return Err(Error::OutOfRange {
            what: "the number density of the start",
            value: density,
            expected: "one at which bodies on a lattice do not feel each other",
        });
    }
    let (count, dimension) = (bodies.count(), bodies.dimension());
    let edge = (count as f64 / density).powf(1.0 / dimension as f64);
    let sites = sites(count, dimension) as usize;
    let spacing = edge / sites as f64;
    let third = if dimension == 2 {
        ACROSS_THE_PLANE
    } else {
        edge
    };
    let space = Boundary::Periodic {
        lengths_angstrom: Vec3::new(edge, edge, third),
    };
    let place = |number: usize| {
        let coordinate = |site: usize| (site as f64 + 0.5) * spacing - 0.5 * edge;
        let [x, y] = [number % sites, number / sites % sites];
        match dimension {
            2 => Vec3::new(coordinate(x), coordinate(y), 0.0),
            _ => Vec3::new(
                coordinate(x),
                coordinate(y),
                coordinate(number / (sites * sites)),
            ),
        }
    };
    let mut state = State::at_rest(bodies, space, (0..count).map(place).collect());
    let mut rng = CounterRng::for_purpose(seed, 0, 0, Purpose::ContactStart);
    for angle in &mut state.angles_rad {
        *angle = TAU * rng.uniform();
    }
    for rotation in &mut state.rotations {
        *rotation = rng.rotation();
    }
    Ok(state)
}

/// Draws velocities and angular momenta of a temperature (kT), takes the momentum of the whole away
/// and brings the kinetic energies of motion and of rotation to their means.
///
/// # Errors
/// [`Error::OutOfRange`] for a temperature that is not positive.
pub fn set_velocities(
    state: &mut State,
    bodies: &Bodies,
    temperature: f64,
    seed: u64,
) -> Result<()> {
    require("the temperature", temperature)?;
    let mut rng = CounterRng::for_purpose(seed, 0, 0, Purpose::ContactVelocities);
    let root = temperature.sqrt();
    let mut mass = 0.0;
    for body in 0..bodies.count() {
        let kind = bodies.kind(body);
        let thermal = root / kind.mass.sqrt();
        state.velocities[body] = thermal * normal_vector(&mut rng, kind.dimension);
        let turns = normal_turns(&mut rng, kind.turns());
        state.spins[body] = root * turns.component_mul(&kind.moments.map(f64::sqrt));
        mass += kind.mass;
    }
    let drift = state.momentum(bodies) / mass;
    if bodies.count() > 1 {
        for velocity in &mut state.velocities {
            *velocity -= drift;
        }
    }
    let [moving, turning] = state.kinetic_energies(bodies);
    let movements = bodies.dimension() * bodies.count().saturating_sub(1);
    let scale = |freedoms: usize, kinetic: f64| match kinetic > 0.0 {
        true => (0.5 * freedoms as f64 * temperature / kinetic).sqrt(),
        false => 1.0,
    };
    let scales = [scale(movements, moving), scale(bodies.turns(), turning)];
    for body in 0..bodies.count() {
        state.velocities[body] *= scales[0];
        state.spins[body] *= scales[1];
    }
    Ok(())
}
