//! Openings that several tests share.

pub mod brute_force;
pub mod references;

use protomer_kernel::random::CounterRng;
use protomer_linkage::lattice::{
    CollisionSettings, Corner, Dynamics, Edges, Engine, Network, Rod, Square, Start,
    StartVelocities, State,
};
use std::f64::consts::FRAC_PI_4;
use std::sync::Arc;

/// Squares without rods.
pub fn loose(count: usize, cell: Option<[f64; 2]>) -> Network {
    Network {
        rows: 1,
        columns: count,
        squares: vec![Square::default(); count],
        rods: Vec::new(),
        cell,
        cell_mass: None,
        places: None,
    }
}

/// The open lattice of unit squares.
pub fn lattice(size: usize, r0: f64) -> Arc<Network> {
    Arc::new(Network::lattice(size, size, r0, Square::default(), Edges::Open, FRAC_PI_4).unwrap())
}

/// The open lattice with random angular velocities, made to agree with the rods.
pub fn random_start(network: &Arc<Network>, seed: u64) -> State {
    let mut state = State::coherent(network, FRAC_PI_4);
    let mut rng = CounterRng::new(seed, 0, 0);
    for omega in state.velocities.iter_mut().skip(2).step_by(3) {
        *omega = rng.uniform_in(-1.0, 1.0);
    }
    Dynamics::new(network.clone(), Vec::new(), &state)
        .unwrap()
        .project_velocities(&mut state.velocities);
    state
}

/// A start with angular velocities U(-1, 1) brought onto the rods and perhaps scaled, as a run draws
/// it.
pub fn drawn_start(network: &Network, seed: u64, sum_of_squares: Option<f64>) -> State {
    let velocities = StartVelocities::Uniform {
        largest: 1.0,
        sum_of_squares,
    };
    Start {
        velocities,
        seed,
        ..Start::default()
    }
    .build(network, 0)
    .unwrap()
    .state
}

/// The engine of elastic collisions, prepared at a state.
pub fn engine(network: &Arc<Network>, state: &State) -> Engine {
    Engine::new(
        network.clone(),
        Vec::new(),
        state,
        CollisionSettings::default(),
    )
    .unwrap()
}

/// One unit square that nothing holds.
pub fn one_square() -> Network {
    Network {
        rows: 1,
        columns: 1,
        squares: vec![Square::default()],
        rods: Vec::new(),
        cell: None,
        cell_mass: None,
        places: None,
    }
}

/// Two unit squares joined by one rod at these corners.
pub fn two_squares(vertices: [u8; 2], length: f64) -> Arc<Network> {
    let [from, to] = [0, 1].map(|square: usize| Corner {
        square,
        vertex: vertices[square],
    });
    let rods = vec![Rod {
        from,
        to,
        length,
        image: [0, 0],
    }];
    Arc::new(Network {
        rows: 1,
        columns: 2,
        squares: vec![Square::default(); 2],
        rods,
        cell: None,
        cell_mass: None,
        places: None,
    })
}
