//! Hard bodies in a directory: what is refused, what is doubted, and the names of errors.

use protomer_io::gsd::{ChunkData, GsdFile};
use protomer_results::{Execution, Interrupt};
use protomer_shape_verbs::hard_bodies::free_energy::{FreeEnergySettings, run_free_energy};
use protomer_shape_verbs::hard_bodies::phases::{PhaseDirectories, phases_of_measurements};
use protomer_shape_verbs::hard_bodies::result::HardBodyResult;
use protomer_shape_verbs::hard_bodies::run::run_hard_bodies;
use protomer_shape_verbs::hard_bodies::settings::{
    Freedom, Gravity, HardBodySettings, Pressure, parse_depletants,
};
use protomer_shape_verbs::hard_bodies::sweep::{EquationOfState, HardBodySweepSettings, run_sweep};
use serde::Serialize;
use serde_json::Value;
use std::path::Path;

/// Rods on a line, which take milliseconds.
fn rods() -> HardBodySettings {
    HardBodySettings {
        shape: "rod:1".into(),
        bodies: 20,
        packing_fraction: 0.4,
        equilibration: 100,
        sweeps: 400,
        trajectory_every: 0,
        ..HardBodySettings::default()
    }
}

fn pressed(kt_per_volume: f64) -> Option<Pressure> {
    Some(Pressure {
        kt_per_volume,
        freedom: Freedom::Volume,
        changes_per_sweep: None,
    })
}

fn run(settings: &HardBodySettings, path: &Path) -> HardBodyResult {
    let end = run_hard_bodies(settings, path, &Execution::default()).unwrap();
    end.finished().unwrap()
}

fn sweep(
    run: HardBodySettings,
    packings: &[f64],
    pressures: &[f64],
    path: &Path,
) -> EquationOfState {
    let settings = HardBodySweepSettings {
        packing_fractions: packings.to_vec(),
        pressures_kt_per_volume: pressures.to_vec(),
        seeds: vec![1, 2],
        run,
    };
    let end = run_sweep(&settings, path, &Execution::default()).unwrap();
    end.finished().unwrap()
}

/// The error of `x_kt` is `x_kt_error`, that of a list `lengths` is `lengths_error`: each key with `error` in it ends
/// so, and the value that it belongs to is next to it.
fn assert_errors_are_named(value: &Value, what: &str, count: &mut usize) {
    match value {
        Value::Object(fields) => {
            for (key, inner) in fields {
                if key.contains("error") {
                    let measured = key.strip_suffix("_error");
                    let is_beside = measured.is_some_and(|name| fields.contains_key(name));
                    assert!(is_beside, "{what}: {key}");
                    *count += 1;
                }
                assert_errors_are_named(inner, what, count);
            }
        }
        Value::Array(values) => {
            for inner in values {
                assert_errors_are_named(inner, what, count);
            }
        }
        _ => {}
    }
}

fn json(answer: &impl Serialize) -> Value {
    serde_json::to_value(answer).unwrap()
}

#[test]
fn keys_of_errors_end_in_error_and_what_they_belong_to_is_beside_them() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let with_all = HardBodySettings {
        insertions: 20,
        depletants: parse_depletants("0.1:0").unwrap(),
        ..rods()
    };
    let squares = HardBodySettings {
        shape: "polygon:4".into(),
        bodies: 16,
        packing_fraction: 0.3,
        ..rods()
    };
    let pressed_squares = HardBodySettings {
        pressure: pressed(1.0).map(|pressure| Pressure {
            freedom: Freedom::Shape,
            ..pressure
        }),
        ..squares.clone()
    };
    let fallen = HardBodySettings {
        gravity: Some(Gravity {
            weight_kt_per_length: 0.2,
        }),
        ..squares.clone()
    };
    let free_energy = FreeEnergySettings {
        shape: "polygon:4".into(),
        crystal: "square".into(),
        turn: vec![45.0],
        bodies: 16,
        packing_fraction: 0.7,
        equilibration: 50,
        sweeps: 400,
        ..FreeEnergySettings::default()
    };
    let crystal = HardBodySettings {
        start: "square".into(),
        turn: vec![45.0],
        ..squares.clone()
    };
    let packings = [0.1, 0.2, 0.3, 0.4, 0.5];
    let fluid = sweep(squares.clone(), &packings, &[], &path("fluid"));
    let packings = [0.6, 0.65, 0.7, 0.75, 0.8];
    let ordered = sweep(crystal, &packings, &[], &path("square"));
    let energy = run_free_energy(&free_energy, &path("energy"), &Execution::default()).unwrap();
    let directories = PhaseDirectories {
        fluid: Some(path("fluid")),
        crystals: vec![(path("square"), path("energy"))],
    };
    let mut count = 0;
    for (what, answer) in [
        ("run", json(&run(&with_all, &path("run")))),
        ("pressed", json(&run(&pressed_squares, &path("pressed")))),
        ("fallen", json(&run(&fallen, &path("fallen")))),
        ("fluid", json(&fluid)),
        ("square", json(&ordered)),
        (
            "pressures",
            json(&sweep(rods(), &[], &[0.5, 1.0], &path("pressures"))),
        ),
        ("energy", json(&energy.finished().unwrap())),
        (
            "phases",
            json(&phases_of_measurements(&directories, &[0.0]).unwrap()),
        ),
    ] {
        assert_errors_are_named(&answer, what, &mut count);
    }
    assert!(count > 40, "{count}");
}

/// A table that was written before the keys had their names is still read.
#[test]
fn results_with_the_earlier_names_of_errors_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let with_insertions = HardBodySettings {
        insertions: 20,
        ..rods()
    };
    let equation = sweep(with_insertions, &[0.2, 0.3, 0.4], &[], folder.path());
    let text = serde_json::to_string(&equation).unwrap();
    let earlier = text.replace("_kt_error", "_error_kt");
    assert_ne!(text, earlier);
    let read: EquationOfState = serde_json::from_str(&earlier).unwrap();
    assert_eq!(read, equation);
}

/// Tonks rods at a pressure: P a = φ/(1 - φ).
#[test]
fn rods_arrive_at_their_pressure_and_what_has_not_arrived_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let settings = HardBodySettings {
        pressure: pressed(2.0),
        equilibration: 2000,
        sweeps: 20_000,
        ..rods()
    };
    let arrived = run(&settings, &path("arrived"));
    let found = arrived.equilibrium.as_ref().unwrap();
    assert!(found.is_reached, "{found:?}");
    let error = found.measured_pressure_kt_per_volume_error.unwrap();
    assert!((found.measured_pressure_kt_per_volume - 2.0).abs() < 4.0 * error && error < 0.05);
    assert!(
        (arrived.packing_fraction - 2.0 / 3.0).abs() < 0.02,
        "{arrived:?}"
    );
    assert_eq!(arrived.warning(), None);
    // One change of the box in a sweep, and none before the measurement.
    let early = HardBodySettings {
        bodies: 400,
        packing_fraction: 0.05,
        equilibration: 0,
        sweeps: 300,
        pressure: pressed(2.0).map(|pressure| Pressure {
            changes_per_sweep: Some(1),
            ..pressure
        }),
        ..settings.clone()
    };
    let climbing = run(&early, &path("early"));
    let words = climbing.warning().unwrap();
    assert!(
        words.starts_with("not in equilibrium: the bodies bear a pressure of"),
        "{words}"
    );
    assert!(words.contains("drifts"), "{words}");
    let equation = sweep(early, &[], &[2.0], &path("sweep"));
    assert!(!equation.points[0].equilibrium.as_ref().unwrap().is_reached);
    let table = std::fs::read_to_string(path("sweep").join("equation.csv")).unwrap();
    assert!(
        table.contains("is_in_equilibrium") && table.contains(",false,"),
        "{table}"
    );
    assert!(equation.warnings()[0].contains("at pressure 2: the bodies bear"));
}

/// A column that falls through the whole measurement.
#[test]
fn a_column_that_still_falls_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let settings = |equilibration: u64, sweeps: u64| HardBodySettings {
        packing_fraction: 0.1,
        equilibration,
        sweeps,
        gravity: Some(Gravity {
            weight_kt_per_length: 0.2,
        }),
        ..rods()
    };
    let falling = run(&settings(0, 1000), &folder.path().join("falling"));
    let words = falling.warning().unwrap();
    assert!(words.contains("mean height"), "{words}");
    let fallen = run(&settings(20_000, 200_000), &folder.path().join("fallen"));
    assert_eq!(fallen.warning(), None);
}

#[test]
fn a_run_that_is_stopped_before_it_begins_leaves_no_error() {
    let folder = tempfile::tempdir().unwrap();
    let execution = Execution {
        interrupt: Interrupt::default(),
        ..Execution::default()
    };
    execution.interrupt.request();
    let settings = rods();
    let end = run_hard_bodies(&settings, &folder.path().join("run"), &execution).unwrap();
    assert!(end.finished().is_none());
}

#[test]
fn sites_that_coincide_are_named_by_every_verb() {
    let folder = tempfile::tempdir().unwrap();
    let cell = folder.path().join("cell.txt");
    std::fs::write(&cell, "cell 1 1 1\nsite 0 0 0\nsite 1 0 0\n").unwrap();
    let start = cell.display().to_string();
    let words = "bodies 1 and 2 of the unit cell overlap at any packing fraction";
    let settings = HardBodySettings {
        shape: "cube".into(),
        bodies: 64,
        packing_fraction: 0.05,
        start: start.clone(),
        ..rods()
    };
    let path = folder.path().join("run");
    let error = run_hard_bodies(&settings, &path, &Execution::default()).unwrap_err();
    assert!(error.to_string().contains(words), "{error:#}");
    let settings = FreeEnergySettings {
        shape: "cube".into(),
        crystal: start,
        bodies: 64,
        packing_fraction: 0.05,
        ..FreeEnergySettings::default()
    };
    let error = run_free_energy(&settings, &path, &Execution::default()).unwrap_err();
    assert!(error.to_string().contains(words), "{error:#}");
    assert!(!path.exists());
}

/// Frames begin with the equilibration; the file says where it ends.
#[test]
fn a_trajectory_says_which_frames_are_of_the_measurement() {
    let folder = tempfile::tempdir().unwrap();
    let settings = HardBodySettings {
        trajectory_every: 50,
        ..rods()
    };
    run(&settings, folder.path());
    let mut file = GsdFile::open(&folder.path().join("trajectory.gsd")).unwrap();
    let number = |file: &mut GsdFile, frame: u64, name: &str| match file
        .chunk(frame, name)
        .unwrap()
        .map(|chunk| chunk.data)
    {
        Some(ChunkData::U64(numbers)) => numbers[0],
        other => panic!("{name}: {other:?}"),
    };
    let end = number(&mut file, 0, "log/equilibration_sweeps");
    assert_eq!(end, settings.equilibration);
    let steps: Vec<u64> = (0..=10)
        .map(|frame| number(&mut file, frame, "configuration/step"))
        .collect();
    let measured = steps.iter().filter(|step| **step > end).count();
    assert_eq!((steps[0], measured), (0, 8), "{steps:?}");
}
