//! What a potential for coherence does (paper, fig. 12): 10 x 10 from the closed state in coherent
//! motion, ω_c = 1 with the translations that belong to it; the first maximum of the spread of the
//! orientations, and the largest within a time of 3.

use crate::common::{Failure, Run, Settings, lattice, map, table, time_step};
use protomer_linkage::analysis::modes::orientational_spread;
use protomer_linkage::analysis::spread::FirstMaximum;
use protomer_linkage::lattice::{Coherence, CollisionSettings, Force, Start, StartVelocities};

const LENGTHS: [f64; 5] = [0.05, 3.0 / 22.0, 0.25, 0.5, 1.0];
const KAPPAS: [f64; 8] = [0.0, 10.0, 100.0, 300.0, 1e3, 3e3, 1e4, 3e4];
const LONGEST: f64 = 3.0;
/// The fall after which a maximum counts: fast ripples of stiff potentials do not.
const DROP: f64 = 1e-4;

fn first_maximum(rod_length: f64, kappa: f64) -> Result<Vec<f64>, Failure> {
    let network = lattice(10, rod_length)?;
    let velocities = StartVelocities::Checkerboard { rate: 1.0 };
    let state = Start {
        velocities,
        ..Start::closed()
    }
    .build(&network, 0)?
    .state;
    let energy = state.kinetic_energy(&network);
    let forces: Vec<Box<dyn Force>> = vec![Box::new(Coherence { kappa })];
    // The coherent motion is ten times faster in the open state than in the closed one.
    let step = (time_step(rod_length) / 8.0).min(0.1 / kappa.sqrt());
    let mut run = Run::new(&network, forces, state, step, CollisionSettings::default())?;
    let mut first = FirstMaximum::new(DROP);
    let mut largest = [0.0; 2];
    while run.state.time < LONGEST {
        run.advance(step)?;
        let spread = orientational_spread(&network, &run.state.positions);
        first.push(run.state.time, spread);
        if spread > largest[1] {
            largest = [run.state.time, spread];
        }
    }
    let all = run.state.kinetic_energy(&network) + run.engine.dynamics().potential_energy();
    let impacts = run.engine.statistics().impacts as f64;
    let [time, value] = first
        .found()
        .map_or([f64::NAN; 2], |maximum| [maximum.time, maximum.value]);
    Ok(vec![
        rod_length,
        kappa,
        value,
        time,
        largest[1],
        largest[0],
        impacts,
        all / energy - 1.0,
    ])
}

/// Writes the table.
pub fn write(settings: &Settings) -> Result<(), Failure> {
    let rows = map(settings.jobs, LENGTHS.len() * KAPPAS.len(), |index| {
        first_maximum(LENGTHS[index / KAPPAS.len()], KAPPAS[index % KAPPAS.len()])
    })?;
    table(
        settings,
        "potential",
        "r0,kappa,spread,time,largest_spread,largest_time,impacts,energy_error",
        &rows,
    )
}
