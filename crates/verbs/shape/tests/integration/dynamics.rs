//! Contact dynamics in a directory: continued runs, refused work, files.

use protomer_io::gsd::{ChunkData, GsdFile};
use protomer_md::pair::Form;
use protomer_results::{Execution, log};
use protomer_shape_verbs::dynamics::log::LogRow;
use protomer_shape_verbs::dynamics::run::run_dynamics;
use protomer_shape_verbs::dynamics::settings::{DynamicsSettings, EnsembleName};
use std::path::Path;

fn short(shape: &str) -> DynamicsSettings {
    DynamicsSettings {
        shape: shape.into(),
        bodies: 64,
        packing_fraction: 0.3,
        ensemble: EnsembleName::Nvt,
        steps: 150,
        compress_steps: 300,
        equilibrate_steps: 50,
        log_every: 10,
        trajectory_every: 50,
        ..DynamicsSettings::default()
    }
}

fn run(settings: &DynamicsSettings, path: &Path) {
    let end = run_dynamics(settings, path, &Execution::default()).unwrap();
    assert!(end.finished().is_some());
}

#[test]
fn a_run_continued_twice_writes_the_bytes_of_one_that_was_not() {
    for shape in ["polygon:5", "octahedron"] {
        let folder = tempfile::tempdir().unwrap();
        let [through, parts] = ["through", "parts"].map(|name| folder.path().join(name));
        let settings = short(shape);
        run(&settings, &through);
        for steps in [0, 37, 150] {
            let settings = DynamicsSettings {
                steps,
                ..settings.clone()
            };
            run(&settings, &parts);
        }
        for file in ["log.csv", "trajectory.gsd", "checkpoint.bin"] {
            let [one, other] = [&through, &parts].map(|path| std::fs::read(path.join(file)));
            assert!(one.unwrap() == other.unwrap(), "{shape}: {file} differs");
        }
    }
}

#[test]
fn another_run_in_the_directory_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run");
    let settings = short("cube");
    run(&settings, &path);
    let other = DynamicsSettings {
        seed: 2,
        ..settings
    };
    let words = run_dynamics(&other, &path, &Execution::default()).unwrap_err();
    assert!(format!("{words:#}").contains("seed"), "{words:#}");
}

#[test]
fn the_log_and_the_trajectory_hold_what_they_should() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run");
    run(&short("polygon:6"), &path);
    let rows: Vec<LogRow> = log::read(&path.join("log.csv")).unwrap();
    assert_eq!((rows[0].step, rows.last().unwrap().step), (-350, 150));
    assert_eq!(rows.len(), 51);
    assert!(rows.iter().all(|row| row.packing_fraction < 0.3 + 1e-9));
    assert!((rows.last().unwrap().packing_fraction - 0.3).abs() < 1e-9);
    let mut file = GsdFile::open(&path.join("trajectory.gsd")).unwrap();
    assert_eq!(file.frames(), 4);
    let shapes = file.chunk(0, "particles/type_shapes").unwrap().unwrap();
    let ChunkData::I8(text) = shapes.data else {
        panic!("no text");
    };
    let text: String = text.iter().map(|byte| *byte as u8 as char).collect();
    assert!(text.contains("\"Polygon\""), "{text}");
    let angles = file.chunk(3, "log/particles/unwrapped_angle").unwrap();
    assert_eq!(angles.unwrap().data.len(), 64);
}

#[test]
fn disks_and_balls_and_brownian_bodies_move_too() {
    for (shape, ensemble) in [
        ("disk", EnsembleName::Nve),
        ("ball", EnsembleName::Langevin),
        ("polygon:3", EnsembleName::Brownian),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let settings = DynamicsSettings {
            ensemble,
            bodies: 100,
            potential: Form::Contact,
            friction: 50.0,
            ..short(shape)
        };
        let path = folder.path().join("run");
        let end = run_dynamics(&settings, &path, &Execution::default()).unwrap();
        let result = end.finished().unwrap();
        let is_brownian = ensemble == EnsembleName::Brownian;
        assert_eq!(result.energy_drift_per_body.is_none(), is_brownian);
        assert!(result.pressure > 0.0 && result.pressure.is_finite());
    }
}
