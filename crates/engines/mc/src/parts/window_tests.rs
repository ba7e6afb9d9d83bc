//! Windows against quadrature and against growth.

use super::tests::{ring, with_neighbours};
use super::windows::Windows;
use super::*;
use crate::McError;
use crate::pair::region::Region;
use protomer_kernel::Pose;

const DEPTH_KT: f64 = 14.0;
const WIDTH_ANGSTROM: f64 = 1.2;
const NEAREST_ANGSTROM: f64 = 10.0;

/// Hard balls with a well about each place next to a neighbour: -D exp(-d²/2w²) of the displacement d. Where they touch in
/// other places, beyond the limit of the well, they may stick.
struct Wells<'a> {
    arrangement: &'a Arrangement,
    depth_kt: f64,
    sticks_kt: f64,
}

/// Range in which balls touch, Å.
const TOUCHING_ANGSTROM: f64 = 1.5;
/// Limit of a well, Å.
const LIMIT_ANGSTROM: f64 = 5.0;

impl Wells<'_> {
    fn region(&self, (i, j): (usize, usize)) -> Region {
        let bodies = &self.arrangement.bodies;
        Region {
            about: bodies[j].pose.then(&bodies[i].pose.inverse()),
            square_of_gyration_angstrom2: bodies[j].square_of_gyration_angstrom2,
            limit_angstrom: LIMIT_ANGSTROM,
        }
    }

    fn well_kt(&self, square_angstrom2: f64) -> f64 {
        -self.depth_kt * (-0.5 * square_angstrom2 / WIDTH_ANGSTROM.powi(2)).exp()
    }
}

impl BodyEnergies for Wells<'_> {
    fn overlap(&self, _: usize, _: usize, a: &Pose, b: &Pose) -> bool {
        (a.position - b.position).norm() < NEAREST_ANGSTROM
    }

    fn energy_kt(&self, i: usize, j: usize, a: &Pose, b: &Pose) -> f64 {
        if !self.arrangement.neighbours[i].contains(&j) {
            return 0.0;
        }
        // Always of the higher body in the frame of the lower, so that the energy is one function.
        let ((i, a), (j, b)) = if i < j {
            ((i, a), (j, b))
        } else {
            ((j, b), (i, a))
        };
        let region = self.region((i, j));
        let place = region.place(&b.then(&a.inverse()));
        let square_angstrom2 = region.square_displacement_at_place(&place);
        let gap_angstrom = (a.position - b.position).norm() - NEAREST_ANGSTROM;
        if square_angstrom2 > LIMIT_ANGSTROM.powi(2) && gap_angstrom < TOUCHING_ANGSTROM {
            return -self.sticks_kt;
        }
        self.well_kt(square_angstrom2)
    }
}

fn settings(windows: Option<WindowSettings>) -> GrowthSettings {
    GrowthSettings {
        live_states: 100,
        runs: 6,
        windows,
        ..GrowthSettings::default()
    }
}

fn windows() -> GrowthSettings {
    settings(Some(WindowSettings {
        windows: 20,
        sweeps: 6000,
    }))
}

/// Partition functions of all parts.
fn partitions(wells: &Wells<'_>, settings: &GrowthSettings) -> crate::Result<Vec<Attached>> {
    let arrangement = wells.arrangement;
    let found = connected_parts(arrangement, 100).unwrap();
    let mut samples: Vec<PartSamples> = Vec::new();
    for (number, part) in (0..).zip(&found.parts) {
        let grown = match part.grown_from {
            None => free_body(arrangement.bodies[part.bodies[0]].pose, settings),
            Some(smaller) => attach(
                arrangement,
                (number, part),
                &samples[smaller],
                wells,
                settings,
                &|| true,
            )?
            .unwrap(),
        };
        samples.push(grown);
    }
    Ok(samples.iter().map(|grown| *grown.attached()).collect())
}

/// ln ∫ exp(-U) over the poses within 5 Å by the midpoint rule: U depends on the displacement alone.
fn ln_by_quadrature(wells: &Wells<'_>) -> f64 {
    let region = wells.region((0, 1));
    let within = |limit_angstrom: f64| {
        let region = Region {
            limit_angstrom,
            ..region.clone()
        };
        region.volume_angstrom3()
    };
    const SHELLS: usize = 1000;
    let step = region.limit_angstrom / SHELLS as f64;
    let shell = |number: usize| {
        let (low, middle) = (step * number as f64, step * (number as f64 + 0.5));
        let inside = if number == 0 { 0.0 } else { within(low) };
        (within(low + step) - inside) * (-wells.well_kt(middle * middle)).exp()
    };
    (0..SHELLS).map(shell).sum::<f64>().ln()
}

#[test]
fn windows_of_a_pair_have_the_integral_by_quadrature() {
    let pair = with_neighbours(ring(8, 1).bodies[..2].to_vec(), |_, _| true);
    for depth_kt in [6.0, DEPTH_KT, 30.0] {
        let wells = Wells {
            arrangement: &pair,
            depth_kt,
            sticks_kt: 0.0,
        };
        let found = *partitions(&wells, &windows()).unwrap().last().unwrap();
        let exact = ln_by_quadrature(&wells);
        let error = found.ln_partition_error;
        println!(
            "{depth_kt} kT: quadrature {exact:.2}, windows {:.2} ± {error:.2}",
            found.ln_partition
        );
        assert!(error < 0.35, "{depth_kt} kT: {found:?}");
        let deviation = (found.ln_partition - exact) / error;
        assert!(deviation.abs() < 3.0, "{depth_kt} kT: {found:?} {exact}");
        let connection = found.windows.unwrap();
        assert!(connection.least_exchanged > 0.05, "{connection:?}");
        assert!(connection.round_trips > 10, "{connection:?}");
    }
}

/// A body that is pulled over a surface that holds it 25 kT deep would stay there.
#[test]
fn windows_lead_around_deep_contacts_in_other_places() {
    let pair = with_neighbours(ring(8, 1).bodies[..2].to_vec(), |_, _| true);
    let wells = Wells {
        arrangement: &pair,
        depth_kt: DEPTH_KT,
        sticks_kt: 25.0,
    };
    let found = *partitions(&wells, &windows()).unwrap().last().unwrap();
    let deviation = (found.ln_partition - ln_by_quadrature(&wells)) / found.ln_partition_error;
    assert!(found.ln_partition_error < 0.35, "{found:?}");
    assert!(deviation.abs() < 3.0, "{found:?} {deviation}");
    assert!(found.windows.unwrap().round_trips > 10, "{found:?}");
}

/// The link that holds up the best way is that of the smallest share on it; a worse way around it does not count.
#[test]
fn the_narrowest_link_is_on_the_best_way() {
    let windows = Windows::new(LIMIT_ANGSTROM, [40.0, 50.0], 12);
    let links = windows.links.len();
    // Two windows confine, two decouple in place and six release; two more decouple within the limit.
    assert_eq!((windows.free_window, links), (9, 9 + 3));
    let mut exchanged = vec![0.5; links];
    exchanged[8] = 0.2;
    assert_eq!(windows.narrowest_link(&exchanged), 8);
    // The place itself cannot be left, but there is the way within the limit.
    exchanged[1] = 0.0;
    assert_eq!(windows.narrowest_link(&exchanged), 8);
    exchanged[10] = 0.1;
    assert_eq!(windows.narrowest_link(&exchanged), 10);
}

#[test]
#[ignore = "takes 18 s of processor time; run by name"]
fn windows_of_a_chain_and_of_rings_have_the_integrals_of_growth() {
    for bodies in [3, 4] {
        let ring = ring(bodies, 1);
        let wells = Wells {
            arrangement: &ring,
            depth_kt: DEPTH_KT,
            sticks_kt: 0.0,
        };
        let grown = partitions(&wells, &settings(None)).unwrap();
        let pulled = partitions(&wells, &windows()).unwrap();
        for (a, b) in grown.iter().zip(&pulled).skip(1) {
            let error = a.ln_partition_error.hypot(b.ln_partition_error);
            assert!(error < 0.6, "{bodies}: {a:?} {b:?}");
            let apart = (a.ln_partition - b.ln_partition).abs();
            assert!(apart < 3.0 * error, "{bodies}: {a:?} {b:?}");
            let displaced = a.displacement_angstrom - b.displacement_angstrom;
            assert!(displaced.abs() < 0.4, "{bodies}: {a:?} {b:?}");
        }
    }
}

/// Few windows in a deep and narrow well have nothing in common, and say what to do.
#[test]
fn windows_that_have_nothing_in_common_are_refused() {
    let pair = with_neighbours(ring(8, 1).bodies[..2].to_vec(), |_, _| true);
    let wells = Wells {
        arrangement: &pair,
        depth_kt: 300.0,
        sticks_kt: 0.0,
    };
    let few = settings(Some(WindowSettings {
        windows: 4,
        sweeps: 200,
    }));
    let refused = partitions(&wells, &few).unwrap_err();
    let McError::BadSystem(message) = &refused else {
        panic!("{refused:?}");
    };
    assert!(message.contains("more windows (--windows)"), "{message}");
}

#[test]
fn settings_of_windows_out_of_range_are_refused() {
    for (windows, sweeps) in [(3, 2000), (500, 2000), (20, 10)] {
        let settings = settings(Some(WindowSettings { windows, sweeps }));
        assert!(matches!(settings.check(), Err(McError::BadSetting { .. })));
    }
}
