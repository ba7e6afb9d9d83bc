//! 2 x 2 lattices: what is left of the checkerboard mode after the first contact of the coherent
//! motion, if the start was disturbed by a little.

use crate::common::{Failure, Run, Settings, lattice, map, mean, table, time_step};
use protomer_linkage::analysis::grima::CoherentOrbit;
use protomer_linkage::analysis::modes::{ModeEnergies, OutOf};
use protomer_linkage::lattice::{CollisionSettings, Square, Start, StartVelocities};
use std::f64::consts::FRAC_PI_4;

const LENGTHS: [f64; 5] = [0.05, 3.0 / 22.0, 0.5, 1.0, 2.0];
const SPREADS: [f64; 6] = [0.0, 1e-10, 1e-8, 1e-6, 1e-4, 1e-2];
/// The time after the contact at which the mode is looked at.
const AFTER: f64 = 0.1;

/// The share of the checkerboard mode in the rotational energy shortly after the first contact of
/// the undisturbed motion, and impacts so far; `None` for a run that ended early.
fn after_contact(
    rod_length: f64,
    spread: f64,
    replica: usize,
) -> Result<Option<[f64; 2]>, Failure> {
    let network = lattice(2, rod_length)?;
    let orbit = CoherentOrbit::new(2, 2, Square::default(), rod_length, FRAC_PI_4, 1.0)?;
    let velocities = StartVelocities::Normal {
        rate: 1.0,
        spread,
        sum_of_squares: Some(4.0),
    };
    let start = Start {
        velocities,
        seed: 8,
        ..Start::default()
    };
    let state = start.build(&network, replica as u32)?.state;
    let (step, settings) = (time_step(rod_length), CollisionSettings::default());
    let mut run = Run::new(&network, Vec::new(), state, step, settings)?;
    let contact = orbit.first_contact().ok_or("the squares never meet")?;
    if let Err(error) = run.advance(contact + AFTER) {
        println!("r0 = {rod_length}, spread {spread}, replica {replica}: {error}");
        return Ok(None);
    }
    let energies = ModeEnergies::from_state(&network, &run.state);
    let share = energies.checkerboard_fraction(OutOf::Rotational, 0.0);
    Ok(share.map(|share| [share, run.engine.statistics().impacts as f64]))
}

/// Writes the table.
pub fn write(settings: &Settings) -> Result<(), Failure> {
    let mut rows = Vec::new();
    for rod_length in LENGTHS {
        for spread in SPREADS {
            let found = map(settings.jobs, settings.small, |replica| {
                after_contact(rod_length, spread, replica)
            })?;
            let found: Vec<[f64; 2]> = found.into_iter().flatten().collect();
            let shares: Vec<f64> = found.iter().map(|[share, _]| *share).collect();
            let impacts: Vec<f64> = found.iter().map(|[_, impacts]| *impacts).collect();
            let [share, error] = mean(&shares);
            let least = shares.iter().copied().fold(f64::INFINITY, f64::min);
            let count = found.len() as f64;
            let [impacts, _] = mean(&impacts);
            rows.push(vec![
                rod_length, spread, count, share, error, least, impacts,
            ]);
        }
    }
    let head = "r0,rate_spread,completed,share,share_error,smallest_share,impacts";
    table(settings, "after_contact", head, &rows)
}
