//! How much the share of the checkerboard mode in the rotational energy varies along trajectories
//! of 10 x 10 (paper, fig. 11): a random trajectory from the open state; at random frames of it new
//! ones begin, with new random angular velocities.

use crate::common::{
    FRAME, Failure, LENGTHS, Run, Settings, deviation, lattice, map, mean, table, time_step,
};
use crate::ensemble::start;
use protomer_kernel::random::{CounterRng, Purpose};
use protomer_linkage::analysis::modes::{ModeEnergies, OutOf};
use protomer_linkage::lattice::Projector;
use protomer_linkage::lattice::{CollisionSettings, State};

const FRAMES: usize = 1000;

/// Writes the table.
pub fn write(settings: &Settings) -> Result<(), Failure> {
    let mut rows = Vec::new();
    for rod_length in LENGTHS {
        let network = lattice(10, rod_length)?;
        let step = time_step(rod_length);
        let parent = start(2).build(&network, 0)?.state;
        let mut rng = CounterRng::for_purpose(2, 0, 0, Purpose::ReseededVelocities);
        let mut chosen: Vec<usize> = (0..settings.reseeded)
            .map(|_| 1 + rng.index(FRAMES))
            .collect();
        chosen.sort_unstable();
        let mut run = Run::new(
            &network,
            Vec::new(),
            parent,
            step,
            CollisionSettings::default(),
        )?;
        let mut seeds: Vec<State> = Vec::new();
        for frame in 1..=chosen.last().copied().unwrap_or(0) {
            run.advance(FRAME)?;
            seeds.extend(
                chosen
                    .iter()
                    .filter(|wanted| **wanted == frame)
                    .map(|_| run.state.clone()),
            );
        }
        let found = map(settings.jobs, seeds.len(), |child| {
            let mut state = seeds[child].clone();
            let mut rng =
                CounterRng::for_purpose(2, 1 + child as u32, 0, Purpose::ReseededVelocities);
            for velocity in state.velocities.chunks_exact_mut(3) {
                velocity.copy_from_slice(&[0.0, 0.0, rng.uniform_in(-1.0, 1.0)]);
            }
            Projector::new(&network).velocities(&state.positions, &mut state.velocities)?;
            let mut run = Run::new(
                &network,
                Vec::new(),
                state,
                step,
                CollisionSettings::default(),
            )?;
            let mut shares = [Vec::new(), Vec::new()];
            for _ in 0..FRAMES {
                if let Err(error) = run.advance(FRAME) {
                    println!(
                        "r0 = {rod_length}, child {child} ended at {}: {error}",
                        run.state.time
                    );
                    break;
                }
                let energies = ModeEnergies::from_state(&network, &run.state);
                for (shares, out_of) in shares.iter_mut().zip([OutOf::Rotational, OutOf::Total]) {
                    shares.extend(energies.checkerboard_fraction(out_of, 0.0));
                }
            }
            let impacts = run.engine.statistics().impacts as f64;
            Ok([
                deviation(&shares[0]),
                deviation(&shares[1]),
                mean(&shares[0])[0],
                impacts,
            ])
        })?;
        let mut row = vec![rod_length, found.len() as f64];
        (0..4).for_each(|which| {
            row.extend(mean(
                &found
                    .iter()
                    .map(|numbers| numbers[which])
                    .collect::<Vec<f64>>(),
            ))
        });
        rows.push(row);
    }
    let head = "r0,trajectories,of_rotational,of_rotational_error,of_total,of_total_error,mean_share,mean_share_error,\
                impacts,impacts_error";
    table(settings, "checkerboard_large", head, &rows)
}
