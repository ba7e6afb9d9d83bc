//! Phase space of the coherent motion (paper, fig. 4), by eqs. 29a and 29b, and 2 x 2 lattices that
//! run along it through collisions.

use crate::common::{FRAME, Failure, Run, Settings, lattice, table, time_step};
use protomer_linkage::analysis::grima::{CoherentOrbit, smallest_angle};
use protomer_linkage::analysis::modes::Modes;
use protomer_linkage::lattice::{CollisionSettings, Square, Start, StartVelocities};
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

/// Writes the tables.
pub fn write(settings: &Settings) -> Result<(), Failure> {
    let mut curves = Vec::new();
    let cases = [
        (2, 0.0),
        (4, 0.0),
        (10, 0.0),
        (2, 0.05),
        (2, 3.0 / 22.0),
        (2, 1.0),
        (2, 2.0),
        (2, 3.0),
    ];
    for (size, rod_length) in cases {
        let least = smallest_angle(rod_length, 1.0).unwrap_or(0.0);
        let orbit = CoherentOrbit::new(size, size, Square::default(), rod_length, FRAC_PI_4, 1.0)?;
        for k in 0..=100 {
            let angle = least + (FRAC_PI_2 - 2.0 * least) * f64::from(k) / 100.0;
            curves.push(vec![size as f64, rod_length, angle, orbit.rate_at(angle)]);
        }
    }
    table(settings, "coherent_orbit", "size,r0,angle,rate", &curves)?;
    let (mut points, mut errors) = (Vec::new(), Vec::new());
    for rod_length in [0.05, 3.0 / 22.0, 1.0, 2.0] {
        let network = lattice(2, rod_length)?;
        let orbit = CoherentOrbit::new(2, 2, Square::default(), rod_length, FRAC_PI_4, -1.0)?;
        for parts in [1.0, 2.0, 4.0] {
            let velocities = StartVelocities::Checkerboard { rate: -1.0 };
            let state = Start {
                velocities,
                ..Start::default()
            }
            .build(&network, 0)?
            .state;
            let step = time_step(rod_length) / parts;
            let mut run = Run::new(
                &network,
                Vec::new(),
                state,
                step,
                CollisionSettings::default(),
            )?;
            let mut worst = [0.0_f64; 2];
            for frame in 0..1000 {
                run.advance(FRAME)?;
                let found = [
                    Modes::from_coordinates(&network, &run.state.positions).checkerboard,
                    Modes::from_coordinates(&network, &run.state.velocities).checkerboard,
                ];
                let exact = orbit.state(run.state.time);
                worst[0] = worst[0].max((found[0] - exact[0]).abs());
                worst[1] = worst[1].max((found[1].abs() - orbit.rate_at(found[0])).abs());
                if parts == 1.0 && frame % 10 == 0 {
                    points.push(vec![rod_length, found[0], found[1]]);
                }
            }
            errors.push(vec![
                rod_length,
                step,
                run.engine.statistics().impacts as f64,
                worst[0],
                worst[1],
            ]);
        }
    }
    table(settings, "coherent_run", "r0,angle,rate", &points)?;
    table(
        settings,
        "coherent_errors",
        "r0,step,impacts,angle_error_29a,rate_error_29b",
        &errors,
    )
}
