//! Lattices of the tests, and what runs them.

use crate::common::Watcher;
use protomer_linkage::lattice::pair::SquareCharge;
use protomer_linkage::lattice::{CellKind, Edges};
use protomer_linkage_verbs::lattice::potential_table::PotentialTable;
use protomer_linkage_verbs::lattice::run::{LatticeResult, run_lattice};
use protomer_linkage_verbs::lattice::settings::{
    LatticeSettings, NamedTimeStep, OtherSquare, Screening, Start, TimeStep, Velocities,
};
use protomer_linkage_verbs::lattice::sweep::{LatticeSweep, run_sweep};
use protomer_results::{End, Execution};
use std::path::Path;

pub fn small() -> LatticeSettings {
    LatticeSettings {
        rows: 4,
        columns: 4,
        start: Start::Angle(0.4),
        velocities: Velocities::Random,
        steps: Some(300),
        time_step: TimeStep::Fixed(5e-3),
        log_every: 7,
        trajectory_every: 25,
        ..LatticeSettings::default()
    }
}

/// With all its rods, straight rows and columns would hold each other: one rod is missing from
/// each.
pub fn periodic() -> LatticeSettings {
    let removed_rods = (0..4).flat_map(|i| [[i, i, 3], [i, i, 4]]).collect();
    LatticeSettings {
        edges: Edges::Periodic,
        r0: 0.15,
        removed_rods,
        ..small()
    }
}

/// A flexible cell in a heat bath, under a stress.
pub fn flexible() -> LatticeSettings {
    LatticeSettings {
        edges: Edges::Periodic,
        cell: CellKind::Flexible,
        r0: 0.15,
        temperature: Some(0.05),
        friction: 1.0,
        stress_xx: 0.02,
        ..small()
    }
}

pub fn finish(settings: &LatticeSettings, directory: &Path) -> LatticeResult {
    match run_lattice(settings, directory, &Execution::default()).unwrap() {
        End::Finished(result) => result,
        End::Stopped => panic!("nobody asked it to stop"),
    }
}

/// Runs on until so many steps were done, then asks to stop.
pub fn stop_after(settings: &LatticeSettings, directory: &Path, steps: u64) {
    let execution = Watcher::stopping_after(steps).execution();
    let end = run_lattice(settings, directory, &execution);
    assert_eq!(end.unwrap(), End::Stopped);
}

/// Four by four squares that open from the closed state, with steps that turn out to be too long.
pub fn too_fast() -> LatticeSettings {
    LatticeSettings {
        r0: 0.05,
        start: "closed".parse().unwrap(),
        velocities: Velocities::Checkerboard,
        time_step: TimeStep::Named(NamedTimeStep::Auto),
        steps: None,
        time: 1.5,
        ..small()
    }
}

pub fn other(half_diagonal: Option<f64>, mass: Option<f64>, inertia: Option<f64>) -> OtherSquare {
    OtherSquare {
        at: [0, 0],
        half_diagonal,
        mass,
        inertia,
    }
}

/// A potential with wells in the closed states, of this depth.
pub fn well(depth: f64) -> PotentialTable {
    let angle_rad: Vec<f64> = (-4..=36).map(|k| 0.1 * f64::from(k)).collect();
    let energies = angle_rad.iter().map(|angle| depth * angle.sin().powi(2));
    PotentialTable {
        energy: Some(energies.collect()),
        energy_kt: None,
        angle_rad,
    }
}

pub fn screen(settings: &mut LatticeSettings, bjerrum: f64, debye: f64, kt: f64) {
    settings.half_diagonal_angstrom = Some(20.0);
    settings.charges = vec![SquareCharge {
        position: [0.0; 2],
        charge: 1.0,
    }];
    settings.screening = Some(Screening {
        bjerrum_length_angstrom: bjerrum,
        debye_length_angstrom: debye,
        kt,
    });
}

/// A sweep in the given folder, on one thread.
pub fn finish_sweep(settings: &LatticeSettings, directory: &Path) -> LatticeSweep {
    match run_sweep(settings, directory, &Execution::default()).unwrap() {
        End::Finished(sweep) => sweep,
        End::Stopped => panic!("nobody asked it to stop"),
    }
}

/// Two by two squares from the open state, all turning alike but for a small disorder.
pub fn nearly_coherent() -> LatticeSettings {
    LatticeSettings {
        rows: 2,
        columns: 2,
        start: "open".parse().unwrap(),
        velocities: Velocities::Checkerboard,
        steps: Some(2000),
        log_every: 2,
        ..small()
    }
}
