//! 2 x 2 lattices: how much the share of the checkerboard mode in the energy varies along a
//! trajectory, against the spread of the initial angles and angular velocities (paper, fig. 7),
//! 3000 frames, Σ ω² = 4; and what is left of the mode after the first contact.

use crate::common::{
    FRAME, Failure, Run, Settings, deviation, lattice, map, mean, table, time_step,
};
use protomer_crystal::CrystalError;
use protomer_crystal::analysis::grima::CoherentOrbit;
use protomer_crystal::analysis::modes::{ModeEnergies, OutOf};
use protomer_crystal::lattice::{AngularVelocities, CollisionSettings, Engine, Square, Start};
use std::f64::consts::FRAC_PI_4;

const FRAMES: usize = 3000;
const LENGTHS: [f64; 5] = [0.05, 3.0 / 22.0, 0.5, 1.0, 2.0];
const ANGLES: [f64; 3] = [0.0, 0.01, 0.1];
const RATES: [f64; 6] = [0.0, 1e-3, 1e-2, 0.1, 0.3, 1.0];

/// σ of the share out of all and out of rotational energy, its mean, the spread reached, draws that
/// overlapped.
fn deviations(
    rod_length: f64,
    angles: f64,
    rates: f64,
    replica: usize,
) -> Result<[f64; 5], Failure> {
    let network = lattice(2, rod_length)?;
    let velocities = AngularVelocities::Normal {
        rate: 1.0,
        spread: rates,
        sum_of_squares: Some(4.0),
    };
    let start = Start {
        angle_spread: angles,
        velocities,
        seed: 7,
        ..Start::default()
    };
    let mut draws = 0;
    let (mut run, reached) = loop {
        let started = start.build(&network, replica as u32 + 1000 * draws);
        let run = started.and_then(|started| {
            let reached = started.angle_spread_reached;
            let engine = Engine::new(
                network.clone(),
                Vec::new(),
                &started.state,
                CollisionSettings::default(),
            )?;
            Ok((
                Run::of(engine, started.state, time_step(rod_length)),
                reached,
            ))
        });
        match run {
            Ok(run) => break run,
            Err(CrystalError::Overlap { .. } | CrystalError::BadState(_)) if draws < 200 => {
                draws += 1
            }
            Err(other) => return Err(other.into()),
        }
    };
    let mut shares = [Vec::new(), Vec::new()];
    for _ in 0..FRAMES {
        run.advance(FRAME)?;
        let energies = ModeEnergies::of(&network, &run.state);
        for (shares, out_of) in shares.iter_mut().zip([OutOf::Total, OutOf::Rotational]) {
            shares.extend(energies.checkerboard_fraction(out_of, 0.0));
        }
    }
    Ok([
        deviation(&shares[0]),
        deviation(&shares[1]),
        mean(&shares[0])[0],
        reached,
        f64::from(draws),
    ])
}

/// The share of the checkerboard mode in the rotational energy a time of 0.1 after the first
/// contact of the undisturbed motion, and impacts so far.
fn after_contact(
    rod_length: f64,
    spread: f64,
    replica: usize,
) -> Result<Option<[f64; 2]>, Failure> {
    let network = lattice(2, rod_length)?;
    let orbit = CoherentOrbit::new(2, 2, Square::default(), rod_length, FRAC_PI_4, 1.0)?;
    let velocities = AngularVelocities::Normal {
        rate: 1.0,
        spread,
        sum_of_squares: Some(4.0),
    };
    let state = Start {
        velocities,
        seed: 8,
        ..Start::default()
    }
    .build(&network, replica as u32)?
    .state;
    let mut run = Run::new(
        &network,
        Vec::new(),
        state,
        time_step(rod_length),
        CollisionSettings::default(),
    )?;
    if let Err(error) = run.advance(orbit.first_contact().ok_or("no contact")? + 0.1) {
        println!("r0 = {rod_length}, spread {spread}, replica {replica}: {error}");
        return Ok(None);
    }
    let share =
        ModeEnergies::of(&network, &run.state).checkerboard_fraction(OutOf::Rotational, 0.0);
    Ok(share.map(|share| [share, run.engine.statistics().impacts as f64]))
}

/// Writes the tables.
pub fn write(settings: &Settings) -> Result<(), Failure> {
    let mut rows = Vec::new();
    for rod_length in LENGTHS {
        for angles in ANGLES {
            for rates in RATES {
                // Without spread all trajectories are one.
                let count = if angles + rates == 0.0 {
                    2
                } else {
                    settings.small
                };
                let found = map(settings.jobs, count, |replica| {
                    deviations(rod_length, angles, rates, replica)
                })?;
                let column = |which: usize| {
                    mean(
                        &found
                            .iter()
                            .map(|numbers| numbers[which])
                            .collect::<Vec<f64>>(),
                    )
                };
                let mut row = vec![rod_length, angles, rates, count as f64];
                (0..3).for_each(|which| row.extend(column(which)));
                row.extend([column(3)[0], column(4)[0]]);
                rows.push(row);
            }
        }
    }
    let head = "r0,angle_spread,rate_spread,trajectories,of_total,of_total_error,of_rotational,of_rotational_error,\
                mean_share,mean_share_error,angle_spread_reached,draws_that_overlapped";
    table(settings, "checkerboard_small", head, &rows)?;
    let mut rows = Vec::new();
    for rod_length in LENGTHS {
        for spread in [0.0, 1e-10, 1e-8, 1e-6, 1e-4, 1e-2] {
            let found = map(settings.jobs, settings.small, |replica| {
                after_contact(rod_length, spread, replica)
            })?;
            let found: Vec<[f64; 2]> = found.into_iter().flatten().collect();
            let column = |which: usize| {
                mean(
                    &found
                        .iter()
                        .map(|numbers| numbers[which])
                        .collect::<Vec<f64>>(),
                )
            };
            let ([share, error], [impacts, _]) = (column(0), column(1));
            let least = found
                .iter()
                .map(|numbers| numbers[0])
                .fold(f64::INFINITY, f64::min);
            rows.push(vec![
                rod_length,
                spread,
                found.len() as f64,
                share,
                error,
                least,
                impacts,
            ]);
        }
    }
    table(
        settings,
        "after_contact",
        "r0,rate_spread,completed,share,share_error,smallest_share,impacts",
        &rows,
    )
}
