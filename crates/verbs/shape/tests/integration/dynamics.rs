//! Contact dynamics in a directory: continued runs, refused work, files.

use protomer_io::gsd::{ChunkData, GsdFile};
use protomer_kernel::height_energy::HeightTable;
use protomer_kernel::pair_energy::Term;
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

/// Runs at once and in three parts, into `through` and `parts`: the bytes are the same.
fn assert_continued(settings: &DynamicsSettings, folder: &Path) {
    let [through, parts] = ["through", "parts"].map(|name| folder.join(name));
    run(settings, &through);
    for steps in [0, 37, 150] {
        let settings = DynamicsSettings {
            steps,
            ..settings.clone()
        };
        run(&settings, &parts);
    }
    for file in ["log.csv", "trajectory.gsd", "checkpoint.bin"] {
        let [one, other] = [&through, &parts].map(|path| std::fs::read(path.join(file)));
        assert!(
            one.unwrap() == other.unwrap(),
            "{:?}: {file} differs",
            settings.shape
        );
    }
}

#[test]
fn a_run_continued_twice_writes_the_bytes_of_one_that_was_not() {
    for shape in ["polygon:5", "octahedron"] {
        let folder = tempfile::tempdir().unwrap();
        assert_continued(&short(shape), folder.path());
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

/// Cubes with charges at two faces, in a table and a field; their names have edges of one, so nothing is scaled.
fn with_potentials() -> DynamicsSettings {
    let dipole = Term::Charges {
        positions: vec![vec![0.4, 0.0, 0.0], vec![-0.4, 0.0, 0.0]],
        charges_e: vec![2.0, -2.0],
        bjerrum_length: 0.7,
        debye_length: 0.4,
        cut_off: 1.0,
    };
    let table = Term::Radial {
        distances: vec![1.0, 1.4, 1.8],
        energies_kt: vec![-1.0, -0.4, 0.0],
        curve: None,
    };
    let valley = HeightTable {
        heights: vec![0.0, 1.0, 2.0, 3.0],
        energies_kt: vec![1.0, 0.0, 0.5, 1.0],
    };
    DynamicsSettings {
        bodies: 125,
        pair_potential: vec![dipole, table],
        field: Some(valley),
        ..short("cube")
    }
}

#[test]
fn potentials_and_fields_are_in_the_settings_and_go_on() {
    let folder = tempfile::tempdir().unwrap();
    let (settings, through) = (with_potentials(), folder.path().join("through"));
    assert_continued(&settings, folder.path());
    let text = std::fs::read_to_string(through.join("run.toml")).unwrap();
    assert_eq!(toml::from_str::<DynamicsSettings>(&text).unwrap(), settings);
    let plain = folder.path().join("plain");
    let bare = DynamicsSettings {
        bodies: 125,
        ..short("cube")
    };
    run(&bare, &plain);
    let energy = |path: &Path| {
        let rows: Vec<LogRow> = log::read(&path.join("log.csv")).unwrap();
        rows.last().unwrap().potential_energy
    };
    assert!((energy(&through) - energy(&plain)).abs() > 0.2);
    let heading = |path: &Path| {
        let text = std::fs::read_to_string(path.join("log.csv")).unwrap();
        text.lines().next().unwrap().to_owned()
    };
    let columns = ",pair_potential_energy,field_energy";
    assert_eq!(heading(&through), heading(&plain) + columns);
    let rows: Vec<LogRow> = log::read(&through.join("log.csv")).unwrap();
    for row in rows {
        let (pairs, field) = (
            row.pair_potential_energy.unwrap(),
            row.field_energy.unwrap(),
        );
        // What remains is that of the contacts, which repel.
        assert!(pairs + field <= row.potential_energy + 1e-12, "{row:?}");
    }
    let words = std::fs::read_to_string(plain.join("run.toml")).unwrap();
    assert!(
        !words.contains("potential]") && !words.contains("field"),
        "{words}"
    );
}

#[test]
fn potentials_at_constant_pressure_pull_bodies_together() {
    let folder = tempfile::tempdir().unwrap();
    let pressed = |depth: f64, name: &str| {
        let table = Term::Radial {
            distances: vec![1.2, 1.6, 2.0],
            energies_kt: vec![-depth, -0.5 * depth, 0.0],
            curve: None,
        };
        let settings = DynamicsSettings {
            ensemble: EnsembleName::Npt,
            pressure: Some(0.2),
            steps: 20_000,
            packing_fraction: 0.2,
            time_step: 5e-4,
            field: None,
            pair_potential: vec![table],
            trajectory_every: 0,
            ..with_potentials()
        };
        let end = run_dynamics(&settings, &folder.path().join(name), &Execution::default());
        let result = end.unwrap().finished().unwrap();
        assert!(result.volume_acceptance.unwrap() > 0.1);
        result
    };
    let (repelled, attracted) = (pressed(-0.5, "repelled"), pressed(0.5, "attracted"));
    assert!(attracted.mean_packing_fraction > repelled.mean_packing_fraction + 0.01);
    // The pressure with the virial of the table is the one that was set.
    for result in [repelled, attracted] {
        assert!((result.pressure - 0.2).abs() < 0.02, "{}", result.pressure);
    }
}

#[test]
fn potentials_that_do_not_fit_say_what_to_do() {
    let complaint = |settings: DynamicsSettings| {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("run");
        let error = run_dynamics(&settings, &path, &Execution::default()).unwrap_err();
        assert!(!path.exists(), "nothing is left behind");
        format!("{error:#}")
    };
    let scaled = DynamicsSettings {
        shape: "cuboid:1,1,2".into(),
        ..with_potentials()
    };
    assert!(complaint(scaled).contains("give --keep-size"));
    let well = DynamicsSettings {
        pair_potential: vec![Term::SquareWell {
            range: 1.5,
            depth_kt: 1.0,
        }],
        ..with_potentials()
    };
    assert!(complaint(well).contains("no finite force"));
    let pressed = DynamicsSettings {
        ensemble: EnsembleName::Npt,
        pressure: Some(1.0),
        ..with_potentials()
    };
    assert!(complaint(pressed).contains("--field has its heights"));
    let high = DynamicsSettings {
        field: Some(HeightTable {
            heights: vec![0.0, 10.0, 20.0],
            energies_kt: vec![1.0, 0.0, 1.0],
        }),
        ..with_potentials()
    };
    let words = complaint(high);
    assert!(
        words.contains("heights from 0 to 20") && words.contains("125 bodies"),
        "{words}"
    );
    let balls = DynamicsSettings {
        shape: "ball".into(),
        ..with_potentials()
    };
    assert!(complaint(balls).contains("ellipsoid:0.5,0.5,0.5"));
}
