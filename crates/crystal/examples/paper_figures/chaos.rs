//! Maximal Lyapunov exponents of 2 x 2 lattices near the coherent orbit (paper, fig. 8), with
//! collisions and without, and the growth along the orbit itself before the first contact.

use crate::common::{Failure, Settings, lattice, map, mean, table, time_step};
use protomer_crystal::CrystalError;
use protomer_crystal::analysis::lyapunov::{
    CollisionFlow, LyapunovSettings, RodFlow, maximal_exponent,
};
use protomer_crystal::lattice::{
    AngularVelocities, CollisionSettings, Dynamics, Engine, Network, Start, State,
};
use std::sync::Arc;

const LENGTHS: [f64; 9] = [0.05, 0.1, 3.0 / 22.0, 0.25, 0.5, 0.75, 1.0, 1.5, 2.0];
const REPLICAS: usize = 4;

fn near_coherent(network: &Network, replica: u32) -> Result<State, CrystalError> {
    let velocities = AngularVelocities::Normal {
        rate: 1.0,
        spread: 0.01,
        sum_of_squares: Some(4.0),
    };
    Ok(Start {
        angle_spread: 0.01,
        velocities,
        seed: 11,
        ..Start::default()
    }
    .build(network, replica)?
    .state)
}

fn exponent(
    network: &Arc<Network>,
    step: f64,
    replica: u32,
    collide: bool,
) -> Result<f64, Failure> {
    let mut state = near_coherent(network, replica)?;
    let settings = LyapunovSettings {
        discarded: 20,
        intervals: 180,
        seed: u64::from(replica),
        ..LyapunovSettings::default()
    };
    let found = if collide {
        let flow = |state: &State| -> Result<CollisionFlow, CrystalError> {
            let engine = Engine::new(
                network.clone(),
                Vec::new(),
                state,
                CollisionSettings::default(),
            )?;
            Ok(CollisionFlow::new(engine, step))
        };
        let (mut here, mut there) = (flow(&state)?, flow(&state)?);
        maximal_exponent(network, &mut here, &mut there, &mut state, &settings)?
    } else {
        let flow = |state: &State| -> Result<RodFlow, CrystalError> {
            Ok(RodFlow::new(
                Dynamics::new(network.clone(), Vec::new(), state)?,
                step,
            ))
        };
        let (mut here, mut there) = (flow(&state)?, flow(&state)?);
        maximal_exponent(network, &mut here, &mut there, &mut state, &settings)?
    };
    Ok(found.exponent)
}

/// How fast neighbours leave the coherent orbit itself from the open state on, before squares meet.
fn growth(network: &Arc<Network>, step: f64, direction: u64) -> Result<f64, Failure> {
    let velocities = AngularVelocities::Checkerboard { rate: 1.0 };
    let mut state = Start {
        velocities,
        ..Start::default()
    }
    .build(network, 0)?
    .state;
    let settings = LyapunovSettings {
        interval: 0.1,
        discarded: 0,
        intervals: 15,
        seed: direction,
        ..LyapunovSettings::default()
    };
    let flow = || {
        Dynamics::new(network.clone(), Vec::new(), &state)
            .map(|dynamics| RodFlow::new(dynamics, step))
    };
    let (mut here, mut there) = (flow()?, flow()?);
    Ok(maximal_exponent(network, &mut here, &mut there, &mut state, &settings)?.exponent)
}

/// Writes the table.
pub fn write(settings: &Settings) -> Result<(), Failure> {
    let mut rows = Vec::new();
    for rod_length in LENGTHS {
        let network = lattice(2, rod_length)?;
        let mut row = vec![rod_length, REPLICAS as f64];
        for collide in [true, false] {
            let found = map(settings.jobs, REPLICAS, |replica| {
                // What cannot be carried to the end is left out and said.
                match exponent(&network, time_step(rod_length), replica as u32, collide) {
                    Ok(exponent) => Ok(Some(exponent)),
                    Err(error) => {
                        println!(
                            "r0 = {rod_length}, replica {replica}, collisions {collide}: {error}"
                        );
                        Ok(None)
                    }
                }
            })?;
            let found: Vec<f64> = found.into_iter().flatten().collect();
            row.extend(mean(&found));
            row.push(found.len() as f64);
        }
        let found = map(settings.jobs, 8, |index| {
            growth(&network, time_step(rod_length), index as u64)
        })?;
        row.extend(mean(&found));
        rows.push(row);
    }
    let head = "r0,replicas,exponent,error,completed,free_exponent,free_error,free_completed,growth_to_1.5,growth_error";
    table(settings, "lyapunov", head, &rows)
}
