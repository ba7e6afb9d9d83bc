//! A coherent start of 10 x 10 at r0 = 5 % of l (paper, fig. 10; preprint, fig. 3): angles, their
//! spread, snapshots.

use crate::common::{FRAME, Failure, Run, Settings, lattice, table, time_step};
use protomer_linkage::analysis::modes::{Modes, orientational_spread, spread_of_magnitudes};
use protomer_linkage::analysis::synchronisation::angles;
use protomer_linkage::lattice::{CollisionSettings, Start, StartVelocities};

/// Writes the tables.
pub fn write(settings: &Settings) -> Result<(), Failure> {
    let network = lattice(10, 0.05)?;
    let velocities = StartVelocities::Checkerboard { rate: 1.0 };
    let state = Start {
        velocities,
        ..Start::default()
    }
    .build(&network, 0)?
    .state;
    let energy = state.kinetic_energy(&network);
    let mut run = Run::new(
        &network,
        Vec::new(),
        state,
        0.5 * time_step(0.05),
        CollisionSettings::default(),
    )?;
    let (mut rows, mut snapshots, mut contact) = (Vec::new(), Vec::new(), None);
    for frame in 0..=1000 {
        if frame > 0 {
            run.advance(FRAME)?;
        }
        let positions = &run.state.positions;
        if contact.is_none() && run.engine.statistics().impacts > 0 {
            contact = Some(frame);
        }
        if [0, 200, 400, 600, 1000].contains(&frame) {
            let body = |s: &[f64]| vec![FRAME * f64::from(frame), s[0], s[1], s[2]];
            snapshots.extend(positions.chunks_exact(3).map(body));
        }
        if frame % 2 == 0 {
            let modes = Modes::from_coordinates(&network, positions);
            let mut row = vec![
                run.state.time,
                modes.checkerboard,
                orientational_spread(&network, positions),
                spread_of_magnitudes(positions),
                run.state.kinetic_energy(&network) / energy,
                run.engine.statistics().impacts as f64,
            ];
            row.extend(
                angles(positions)
                    .iter()
                    .enumerate()
                    .step_by(11)
                    .map(|(p, angle)| network.sign(p) * angle),
            );
            rows.push(row);
        }
    }
    println!(
        "opening: first impact in frame {contact:?}, {:?}",
        run.engine.statistics()
    );
    let head = "time,checkerboard,spread,spread_of_magnitudes,relative_energy,impacts,a0,a1,a2,a3,a4,a5,a6,a7,a8,a9";
    table(settings, "opening", head, &rows)?;
    table(settings, "opening_snapshots", "time,x,y,angle", &snapshots)
}
