//! Lattices in their directories: continued bit for bit, what trajectories and pages hold, what is
//! refused.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::print_stderr
)]

mod common;

use common::Watcher;
use protomer_io::gsd::{ChunkData, GsdFile};
use protomer_linkage::analysis::divergence::Embedding;
use protomer_linkage::analysis::domains::{Domains, sides};
use protomer_linkage::analysis::grima::CoherentOrbit;
use protomer_linkage::analysis::lyapunov::{LyapunovSettings, SteppedFlow, maximal_exponent};
use protomer_linkage::analysis::strain::poisson_ratio;
use protomer_linkage::lattice::pair::SquareCharge;
use protomer_linkage::lattice::{Edges, Mover, Square, State};
use protomer_linkage_verbs::lattice::animation::Animation;
use protomer_linkage_verbs::lattice::divergence::{DivergenceSettings, from_log};
use protomer_linkage_verbs::lattice::elastic::{ElasticSettings, elastic};
use protomer_linkage_verbs::lattice::log::LogRow;
use protomer_linkage_verbs::lattice::potential_table::PotentialTable;
use protomer_linkage_verbs::lattice::replay::{LatticeFile, replay, respond};
use protomer_linkage_verbs::lattice::run::{LARGEST_ENERGY_ERROR, LatticeResult, run_lattice};
use protomer_linkage_verbs::lattice::settings::{
    LatticeSettings, NamedTimeStep, OtherSquare, Screening, Start, SweepAxes, TimeStep, Velocities,
};
use protomer_linkage_verbs::lattice::square_of_body::{Axis, Size, square_of_body};
use protomer_linkage_verbs::lattice::start::{begin, charge_warning, network};
use protomer_linkage_verbs::lattice::sweep::{LatticeSweep, run_sweep};
use protomer_linkage_verbs::lattice::trajectory::read_states;
use protomer_protein_verbs::bodies::own_body::{OwnBody, build};
use protomer_results::{End, Execution, log};
use std::f64::consts::FRAC_PI_4;
use std::path::Path;
use std::sync::Arc;

fn small() -> LatticeSettings {
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
fn periodic() -> LatticeSettings {
    let removed_rods = (0..4).flat_map(|i| [[i, i, 3], [i, i, 4]]).collect();
    LatticeSettings {
        edges: Edges::Periodic,
        r0: 0.15,
        removed_rods,
        ..small()
    }
}

fn finish(settings: &LatticeSettings, directory: &Path) -> LatticeResult {
    match run_lattice(settings, directory, &Execution::default()).unwrap() {
        End::Finished(result) => result,
        End::Stopped => panic!("nobody asked it to stop"),
    }
}

/// Runs on until so many steps were done, then asks to stop.
fn stop_after(settings: &LatticeSettings, directory: &Path, steps: u64) {
    let execution = Watcher::stopping_after(steps).execution();
    let end = run_lattice(settings, directory, &execution);
    assert_eq!(end.unwrap(), End::Stopped);
}

#[test]
fn cut_and_continued_runs_equal_uninterrupted_ones_bit_for_bit() {
    let variants = [
        ("collisions", small()),
        (
            "free, coherent force",
            LatticeSettings {
                collisions: false,
                kappa: 5.0,
                ..small()
            },
        ),
        (
            "heat bath",
            LatticeSettings {
                temperature: Some(0.05),
                friction: 2.0,
                ..small()
            },
        ),
        (
            "inelastic",
            LatticeSettings {
                restitution: 0.5,
                ..small()
            },
        ),
        ("periodic", periodic()),
        (
            "tabulated potentials and a stress",
            LatticeSettings {
                angle_potential: Some(well(0.1)),
                opening_potential: Some(well(0.2)),
                stress_xx: 0.02,
                stress_yy: -0.01,
                ..small()
            },
        ),
        (
            "the paper's protocol",
            LatticeSettings {
                paper: true,
                r0: 0.5,
                ..small()
            },
        ),
        (
            "a hole",
            LatticeSettings {
                removed_squares: vec![[1, 2]],
                ..small()
            },
        ),
    ];
    for (name, settings) in variants {
        let folder = tempfile::tempdir().unwrap();
        let (whole, cut) = (folder.path().join("whole"), folder.path().join("cut"));
        let result = finish(&settings, &whole);
        assert_eq!(result.steps, 300);
        stop_after(&settings, &cut, 61);
        // What a kill leaves behind the checkpoint is cut off.
        let log = cut.join("log.csv");
        std::fs::write(&log, std::fs::read_to_string(&log).unwrap() + "62,0.3").unwrap();
        stop_after(&settings, &cut, 140);
        // A run to fewer steps, run on.
        finish(
            &LatticeSettings {
                steps: Some(201),
                ..settings.clone()
            },
            &cut,
        );
        assert_eq!(finish(&settings, &cut), result, "{name}");
        for file in [
            "log.csv",
            "trajectory.gsd",
            "checkpoint.bin",
            "run.toml",
            "run.json",
        ] {
            let same =
                std::fs::read(whole.join(file)).unwrap() == std::fs::read(cut.join(file)).unwrap();
            assert!(same, "{name}: {file} differs");
        }
        eprintln!(
            "{name}: {} collisions, energy off by {:.1e}",
            result.events, result.energy_error
        );
        if name == "collisions" {
            assert!(result.events > 0, "the test should see collisions");
            assert!(result.max_rod_violation < 1e-12);
        }
    }
}

#[test]
fn logs_tell_of_energy_and_modes() {
    let folder = tempfile::tempdir().unwrap();
    let settings = LatticeSettings {
        velocities: Velocities::Checkerboard,
        start: "open".parse().unwrap(),
        rows: 2,
        columns: 2,
        ..small()
    };
    let result = finish(&settings, folder.path());
    let rows: Vec<LogRow> = log::read(&folder.path().join("log.csv")).unwrap();
    assert_eq!(rows.len(), 300 / 7 + 1);
    let (first, second) = (rows[0], rows[10]);
    assert_eq!((first.time, first.step), (0.0, 0));
    // Four squares of inertia 1/3 that turn at 1; all of it in the checkerboard mode until they
    // meet.
    assert!(
        (first.energy - 4.0 / 6.0).abs() < 1e-12
            && (result.start_energy - first.energy).abs() < 1e-15
    );
    assert!((first.checkerboard - std::f64::consts::FRAC_PI_4).abs() < 1e-12);
    assert!(
        (second.checkerboard_fraction - 1.0).abs() < 1e-9
            && second.checkerboard < first.checkerboard
    );
    // Closing by the same amount along x and y.
    assert!(second.strain_xx < 0.0 && (second.strain_xx - second.strain_yy).abs() < 1e-9);
    assert!(second.angle_spread < 1e-9 && second.rod_violation < 1e-12);
}

#[test]
fn rods_in_the_trajectory_have_their_length() {
    let folder = tempfile::tempdir().unwrap();
    let settings = LatticeSettings { r0: 0.3, ..small() };
    finish(&settings, folder.path());
    let path = folder.path().join("trajectory.gsd");
    let mut file = GsdFile::open(&path).unwrap();
    assert_eq!((file.frames(), file.schema().0), (13, "hoomd"));
    let numbers =
        |file: &mut GsdFile, frame, name| match file.chunk(frame, name).unwrap().unwrap().data {
            ChunkData::F32(values) => values.into_iter().map(f64::from).collect::<Vec<_>>(),
            ChunkData::U32(values) => values.into_iter().map(f64::from).collect(),
            ChunkData::U8(values) => values.into_iter().map(f64::from).collect(),
            other => panic!("{other:?}"),
        };
    assert_eq!(numbers(&mut file, 0, "configuration/dimensions"), [2.0]);
    let bonds = numbers(&mut file, 0, "bonds/group");
    assert_eq!(bonds.len(), 2 * 24);
    for frame in 0..file.frames() {
        let positions = numbers(&mut file, frame, "particles/position");
        let orientations = numbers(&mut file, frame, "particles/orientation");
        let half_box = numbers(&mut file, frame, "configuration/box")
            .iter()
            .map(|x| 0.5 * x)
            .collect::<Vec<_>>();
        assert_eq!(positions.len(), 3 * (16 + 48));
        assert!(
            positions
                .chunks(3)
                .all(|x| x[0].abs() <= half_box[0] && x[1].abs() <= half_box[1] && x[2] == 0.0)
        );
        assert!(
            orientations
                .chunks(4)
                .all(|q| (q.iter().map(|x| x * x).sum::<f64>() - 1.0).abs() < 1e-6)
        );
        for ends in bonds.chunks(2) {
            let place = |end: f64| &positions[3 * end as usize..3 * end as usize + 2];
            let (a, b) = (place(ends[0]), place(ends[1]));
            let length = (a[0] - b[0]).hypot(a[1] - b[1]);
            assert!((length - 0.3).abs() < 1e-5, "frame {frame}: {length}");
        }
    }
    let states = read_states(&path).unwrap();
    let begun = begin(&settings).unwrap();
    assert_eq!((states[0].0, &states[0].1), (0.0, &begun.state.positions));
}

#[test]
fn a_page_needs_nothing_else_and_frames_show_every_square_and_rod() {
    let folder = tempfile::tempdir().unwrap();
    finish(&periodic(), folder.path());
    let animation = Animation::read(folder.path(), 5).unwrap();
    assert_eq!(animation.len(), 5, "13 frames thinned out");
    let page = animation.to_html();
    for outside in ["http://", "https://", "src=", "@import", "url(", "{{"] {
        assert!(!page.contains(outside), "{outside}");
    }
    let data = page
        .split("const data = ")
        .nth(1)
        .unwrap()
        .split(";\n")
        .next()
        .unwrap();
    let data: serde_json::Value = serde_json::from_str(data).unwrap();
    assert_eq!(
        (
            data["frames"].as_array().unwrap().len(),
            data["rods"].as_array().unwrap().len()
        ),
        (5, 24)
    );
    let svg = animation.to_svg(4);
    assert_eq!(
        (
            svg.matches("<polygon").count(),
            svg.matches("<line").count()
        ),
        (16, 24)
    );
    assert!(Animation::read(&folder.path().join("elsewhere"), 5).is_err());
}

#[test]
fn what_makes_no_sense_is_refused_by_name() {
    let refused = |settings: LatticeSettings| {
        let folder = tempfile::tempdir().unwrap();
        let error =
            run_lattice(&settings, &folder.path().join("run"), &Execution::default()).unwrap_err();
        assert!(
            !folder.path().join("run").exists(),
            "a start that is refused leaves nothing behind"
        );
        format!("{error:#}")
    };
    let complaint = refused(LatticeSettings {
        r0: -0.1,
        ..small()
    });
    assert!(complaint.contains("r0 is -0.1"), "{complaint}");
    assert!(refused(LatticeSettings { r0: 0.0, ..small() }).contains("no direction"));
    // Beyond the angle at which neighbours meet.
    let complaint = refused(LatticeSettings {
        start: Start::Angle(-0.5),
        ..small()
    });
    assert!(complaint.contains("overlap"), "{complaint}");
    let complaint = refused(LatticeSettings {
        rows: 3,
        edges: Edges::Periodic,
        ..small()
    });
    assert!(complaint.contains("even number"), "{complaint}");
    let complaint = refused(LatticeSettings {
        edges: Edges::Periodic,
        ..small()
    });
    assert!(complaint.contains("removed_rods"), "{complaint}");
    let toml = "rows = 1\ncolumns = 2\nsteps = 3\nrods = [{ from = [0, 0, 4], to = [0, 1, 3] }, { from = [0, 0, 4], to = [0, 1, 3] }]";
    let complaint = refused(toml::from_str(toml).unwrap());
    assert!(complaint.contains("over-constrain"), "{complaint}");
    let complaint = refused(LatticeSettings {
        removed_rods: vec![[0, 0, 1]],
        ..small()
    });
    assert!(complaint.contains("no rod ends"), "{complaint}");
    let complaint = refused(LatticeSettings {
        removed_squares: vec![[4, 0]],
        ..small()
    });
    assert!(complaint.contains("rows go from 0 to 3"), "{complaint}");
    assert!(
        refused(LatticeSettings {
            temperature: Some(1.0),
            ..small()
        })
        .contains("friction")
    );
    assert!(
        refused(LatticeSettings {
            restitution: 1.5,
            ..small()
        })
        .contains("restitution")
    );
    let unknown = toml::from_str::<LatticeSettings>("kapa = 3")
        .unwrap_err()
        .to_string();
    assert!(unknown.contains("kapa"), "{unknown}");
    let unknown = toml::from_str::<LatticeSettings>("time_step = \"fast\"")
        .unwrap_err()
        .to_string();
    assert!(unknown.contains("'auto' or a number"), "{unknown}");
}

#[test]
fn a_failed_step_leaves_the_last_good_state() {
    let folder = tempfile::tempdir().unwrap();
    let settings = LatticeSettings {
        time_step: TimeStep::Fixed(0.4),
        ..small()
    };
    let error = run_lattice(&settings, folder.path(), &Execution::default()).unwrap_err();
    let error = format!("{error:#}");
    assert!(
        error.contains("last good state") && error.contains("time step"),
        "{error}"
    );
    assert!(
        folder.path().join("checkpoint.bin").exists() && folder.path().join("log.csv").exists()
    );
    let record = std::fs::read_to_string(folder.path().join("run.json")).unwrap();
    assert!(record.contains("time step"), "{record}");
    // Another time step is another run.
    let error = run_lattice(&small(), folder.path(), &Execution::default()).unwrap_err();
    assert!(error.to_string().contains("other settings"), "{error}");
    let anew = Execution {
        start_anew: true,
        ..Execution::default()
    };
    assert!(matches!(
        run_lattice(&small(), folder.path(), &anew),
        Ok(End::Finished(_))
    ));
}

/// From every start, also from the closed state, in which squares are slower than they will be.
#[test]
fn automatic_time_steps_keep_the_energy() {
    for (r0, start, velocities, kappa) in [
        (0.05, "0.4", Velocities::Random, 0.0),
        (0.136, "open", Velocities::Random, 0.0),
        (1.0, "0.2", Velocities::Random, 0.0),
        (0.05, "closed", Velocities::Checkerboard, 0.0),
        (3.0 / 22.0, "closed", Velocities::Checkerboard, 0.0),
        (0.5, "closed", Velocities::Checkerboard, 0.0),
        (1.0, "closed", Velocities::Checkerboard, 0.0),
        (0.35, "closed", Velocities::Checkerboard, 600.0),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let settings = LatticeSettings {
            r0,
            start: start.parse().unwrap(),
            velocities,
            kappa,
            rows: 6,
            columns: 6,
            time_step: TimeStep::Named(NamedTimeStep::Auto),
            steps: None,
            time: 0.8,
            ..small()
        };
        let result = finish(&settings, folder.path());
        assert!(
            result.energy_error <= LARGEST_ENERGY_ERROR,
            "r0 = {r0} from {start}: {result:?}"
        );
        assert_eq!(result.energy_warning(&settings), None);
    }
}

/// Four by four squares that open from the closed state, with steps that turn out to be too long.
fn too_fast() -> LatticeSettings {
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

/// A run whose energy is lost begins again with shorter steps, and where it was stopped makes no
/// difference.
#[test]
fn runs_that_begin_again_equal_uninterrupted_ones() {
    let (settings, folder) = (too_fast(), tempfile::tempdir().unwrap());
    let [whole, cut] = ["whole", "cut"].map(|name| folder.path().join(name));
    let result = finish(&settings, &whole);
    assert!(
        result.sub_steps > 1,
        "the case is no longer one: {result:?}"
    );
    assert!(result.energy_error <= LARGEST_ENERGY_ERROR);
    for steps in [20, 700, 1100] {
        stop_after(&settings, &cut, steps);
    }
    assert_eq!(finish(&settings, &cut), result);
    // The result of a finished run is read, not computed again.
    assert_eq!(finish(&settings, &cut), result);
    for file in ["log.csv", "trajectory.gsd", "run.json"] {
        let read = |folder: &Path| std::fs::read(folder.join(file)).unwrap();
        assert!(read(&whole) == read(&cut), "{file} differs");
    }
    let rows: Vec<LogRow> = log::read(&whole.join("log.csv")).unwrap();
    assert_eq!((rows[0].step, rows[1].step), (0, settings.log_every));
    assert_eq!(rows.last().unwrap().step, result.steps / 7 * 7);
}

/// What the paper's protocol costs is part of the result, and a run that was stopped counts on.
#[test]
fn the_papers_protocol_reports_its_overlaps_and_pulls() {
    let settings = LatticeSettings {
        paper: true,
        time_step: TimeStep::Fixed(1e-2),
        steps: Some(400),
        r0: 3.0 / 22.0,
        start: "open".parse().unwrap(),
        ..small()
    };
    let folder = tempfile::tempdir().unwrap();
    let [whole, cut] = ["whole", "cut"].map(|name| folder.path().join(name));
    let result = finish(&settings, &whole);
    let paper = result.paper.unwrap();
    assert!(
        paper.steps == 400 && paper.steps_with_overlap > 0,
        "{paper:?}"
    );
    assert!(paper.deepest_overlap > 1e-6 && paper.contacts >= result.events);
    assert_eq!(
        (paper.collisions, paper.unsolved_collisions),
        (result.events, 0)
    );
    stop_after(&settings, &cut, 300);
    assert_eq!(finish(&settings, &cut), result);
    let record = std::fs::read_to_string(cut.join("run.json")).unwrap();
    assert!(record.contains("pulling_impulses"), "{record}");
    assert_eq!(finish(&small(), &folder.path().join("events")).paper, None);
}

/// A step that was given is taken as it is: the result warns of the energy.
#[test]
fn given_steps_that_lose_the_energy_are_warned_of() {
    let folder = tempfile::tempdir().unwrap();
    let settings = LatticeSettings {
        time_step: TimeStep::Fixed(1e-3),
        ..too_fast()
    };
    let result = finish(&settings, folder.path());
    let warning = result.energy_warning(&settings).unwrap();
    assert!(
        warning.contains("more than 0.001, with steps of 0.001"),
        "{warning}"
    );
    let braked = LatticeSettings {
        friction: 0.1,
        ..settings
    };
    assert_eq!(result.energy_warning(&braked), None);
}

/// A run that fails is a row with the reason; the others are tabulated, and the same sweep again says
/// the same.
#[test]
fn a_failed_run_leaves_the_table_of_the_others() {
    let settings = LatticeSettings {
        rows: 2,
        columns: 2,
        steps: Some(60),
        time_step: TimeStep::Fixed(0.1),
        start: "closed".parse().unwrap(),
        velocities: Velocities::Checkerboard,
        log_every: 2,
        trajectory_every: 5,
        sweep: Some(SweepAxes {
            r0: vec![0.02, 1.0],
            kappa: vec![0.0],
            seeds: vec![1, 2],
            lyapunov: None,
            locked_within: None,
        }),
        ..small()
    };
    let folder = tempfile::tempdir().unwrap();
    let sweep = finish_sweep(&settings, folder.path());
    let [failed, done] = &sweep.conditions[..] else {
        panic!("{:?}", sweep.conditions)
    };
    assert_eq!((failed.r0, failed.runs, failed.failed_runs), (0.02, 0, 2));
    assert_eq!((done.r0, done.runs, done.failed_runs), (1.0, 2, 0));
    assert!(failed.synchronisation.mean.is_nan() && done.synchronisation.mean > 0.9);
    let reasons = sweep.failed_runs();
    assert_eq!(reasons.len(), 2);
    assert!(
        reasons[0].starts_with("r0 = 0.02, κ = 0, seed 1 failed: step "),
        "{reasons:?}"
    );
    assert!(reasons[0].contains("is too large"), "{reasons:?}");
    let table = || std::fs::read_to_string(folder.path().join("runs.csv")).unwrap();
    let first = table();
    assert_eq!(first.lines().count(), 5);
    assert!(
        first.contains("0.02,0,2,NaN") && first.contains("is too large"),
        "{first}"
    );
    assert!(folder.path().join("indices.svg").exists());
    assert_eq!(
        finish_sweep(&settings, folder.path()).failed_runs(),
        reasons
    );
    assert_eq!(table(), first);
}

/// Large random angles at short rods take hours, and a request to stop is heard.
#[test]
fn a_long_start_can_be_stopped() {
    let folder = tempfile::tempdir().unwrap();
    let settings = LatticeSettings {
        r0: 1e-4,
        angle_spread: 3.0,
        start: "open".parse().unwrap(),
        ..small()
    };
    let execution = Execution::default();
    execution.interrupt.request();
    let run = folder.path().join("run");
    assert_eq!(
        run_lattice(&settings, &run, &execution).unwrap(),
        End::Stopped
    );
    assert!(!run.exists());
}

/// Puts a number into settings.
type Setter = fn(&mut LatticeSettings, f64);

/// Every number of the settings: what lies outside its range is refused by name, with its value and
/// the range.
#[test]
fn numbers_outside_their_ranges_are_refused_by_name() {
    let set: [(&str, Setter); 22] = [
        ("r0", |s, x| s.r0 = x),
        ("kappa", |s, x| s.kappa = x),
        ("start", |s, x| s.start = Start::Angle(x)),
        ("angle_spread", |s, x| s.angle_spread = x),
        ("speed", |s, x| s.speed = x),
        ("velocity_spread", |s, x| s.velocity_spread = x),
        ("time", |s, x| s.time = x),
        ("time_step", |s, x| s.time_step = TimeStep::Fixed(x)),
        ("restitution", |s, x| s.restitution = x),
        ("temperature", |s, x| s.temperature = Some(x)),
        ("friction", |s, x| s.friction = x),
        ("half_diagonal_angstrom", |s, x| {
            s.half_diagonal_angstrom = Some(x)
        }),
        ("square.half_diagonal", |s, x| s.square.half_diagonal = x),
        ("square.mass", |s, x| s.square.mass = x),
        ("square.inertia", |s, x| s.square.inertia = x),
        ("other_squares[0].half_diagonal", |s, x| {
            s.other_squares = vec![other(Some(x), None, None)]
        }),
        ("other_squares[0].mass", |s, x| {
            s.other_squares = vec![other(None, Some(x), None)]
        }),
        ("other_squares[0].inertia", |s, x| {
            s.other_squares = vec![other(None, None, Some(x))]
        }),
        ("charges[0].position", |s, x| {
            s.charges = vec![SquareCharge {
                position: [0.0, x],
                charge: 1.0,
            }]
        }),
        ("charges[0].charge", |s, x| {
            s.charges = vec![SquareCharge {
                position: [0.0; 2],
                charge: x,
            }]
        }),
        ("screening.debye_length_angstrom", |s, x| {
            screen(s, 7.0, x, 1.0)
        }),
        ("screening.kt", |s, x| screen(s, 7.0, 9.6, x)),
    ];
    for (name, set) in set {
        for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e308, -1e308] {
            let mut settings = small();
            set(&mut settings, value);
            let error = format!("{:#}", settings.check().unwrap_err());
            assert!(
                error.starts_with(&format!("{name} is ")),
                "{name}, {value}: {error}"
            );
            assert!(error.contains("; give "), "{error}");
        }
    }
    // So small that squares and products vanish.
    for (name, set) in set {
        let has_zero_inside =
            ["start", "angle_spread", "restitution"].contains(&name) || name.starts_with("charges");
        let mut settings = small();
        set(&mut settings, 1e-308);
        assert_eq!(settings.check().is_err(), !has_zero_inside, "{name}");
    }
    let endless = LatticeSettings {
        time: 1e9,
        steps: None,
        time_step: TimeStep::Fixed(1e-9),
        ..small()
    };
    assert!(
        endless
            .check()
            .unwrap_err()
            .to_string()
            .contains("give a larger time_step")
    );
}

fn other(half_diagonal: Option<f64>, mass: Option<f64>, inertia: Option<f64>) -> OtherSquare {
    OtherSquare {
        at: [0, 0],
        half_diagonal,
        mass,
        inertia,
    }
}

/// A potential with wells in the closed states, of this depth.
fn well(depth: f64) -> PotentialTable {
    let angle_rad: Vec<f64> = (-4..=36).map(|k| 0.1 * f64::from(k)).collect();
    let energies = angle_rad.iter().map(|angle| depth * angle.sin().powi(2));
    PotentialTable {
        energy: Some(energies.collect()),
        energy_kt: None,
        angle_rad,
    }
}

/// A run with an automatic step keeps its energy under a tabulated potential, says when an angle left
/// the table, and a table in kT needs a temperature.
#[test]
fn tabulated_potentials_are_part_of_the_settings() {
    let settings = LatticeSettings {
        angle_potential: Some(well(0.3)),
        time_step: TimeStep::AUTO,
        time: 2.0,
        steps: None,
        ..small()
    };
    let folder = tempfile::tempdir().unwrap();
    let result = finish(&settings, &folder.path().join("wide"));
    assert!(result.energy_error < LARGEST_ENERGY_ERROR);
    assert_eq!(
        (result.rows_beyond_table, result.table_warning()),
        (0, None)
    );
    let rows: Vec<LogRow> = log::read(&folder.path().join("wide/log.csv")).unwrap();
    // At θ = ± 0.4, 24 joints: 24 · 0.3 sin² 0.8.
    let at_first = 24.0 * 0.3 * 0.8f64.sin().powi(2);
    assert!((rows[0].potential_energy - at_first).abs() < 1e-3 * at_first);
    let energies = rows.iter().map(|row| row.potential_energy);
    assert!(energies.fold(0.0, f64::max) > 1.05 * at_first, "it moves");

    let mut narrow = settings.clone();
    let table = narrow.angle_potential.as_mut().unwrap();
    table.angle_rad.truncate(14);
    table.energy.as_mut().unwrap().truncate(14);
    let result = finish(&narrow, &folder.path().join("narrow"));
    assert!(result.rows_beyond_table > 0 && result.table_warning().is_some());

    let mut in_kt = settings.clone();
    let table = in_kt.angle_potential.as_mut().unwrap();
    table.energy_kt = table.energy.take();
    let message = format!("{:#}", in_kt.check().unwrap_err());
    assert!(
        message.contains("angle_potential") && message.contains("--temperature"),
        "{message}"
    );
    in_kt.temperature = Some(0.5);
    in_kt.friction = 1.0;
    in_kt.check().unwrap();
    in_kt.angle_potential.as_mut().unwrap().angle_rad.pop();
    assert!(in_kt.check().is_err());
    let periodic = LatticeSettings {
        stress_xx: 0.1,
        ..periodic()
    };
    assert!(
        periodic
            .check()
            .unwrap_err()
            .to_string()
            .contains("open edges")
    );
}

/// Charges so screened that nothing acts are told of, and others not.
#[test]
fn charges_that_do_not_act_are_told_of() {
    let warning = |debye: f64| {
        let mut settings = small();
        screen(&mut settings, 7.0, debye, 0.1);
        let begun = begin(&settings).unwrap();
        charge_warning(&settings, &begun).unwrap()
    };
    assert_eq!(warning(10.0), None);
    let told = warning(1.0).unwrap();
    assert!(
        told.contains("do not act") && told.contains("1 Å"),
        "{told}"
    );
    assert_eq!(
        charge_warning(&small(), &begin(&small()).unwrap()).unwrap(),
        None
    );
}

/// Runs in a heat bath under three loads: the answers of the verb are those of the library from the
/// logs, response and fluctuation agree, and runs without a bath are refused.
#[test]
fn elastic_answers_are_those_of_the_logs() {
    let folder = tempfile::tempdir().unwrap();
    let directory = |name: &str| folder.path().join(name);
    let settings = |stress_xx: f64| LatticeSettings {
        rows: 3,
        columns: 3,
        r0: 0.5,
        collisions: false,
        angle_potential: Some(well(-0.5)),
        velocities: Velocities::Thermal,
        temperature: Some(0.05),
        friction: 1.0,
        stress_xx,
        time_step: TimeStep::Fixed(0.02),
        steps: Some(20_000),
        log_every: 10,
        trajectory_every: 0,
        ..small()
    };
    let mut directories = Vec::new();
    for (name, stress) in [("push", -0.02), ("free", 0.0), ("pull", 0.02)] {
        finish(&settings(stress), &directory(name));
        directories.push(directory(name));
    }
    let wanted = ElasticSettings {
        discard: 0.1,
        blocks: 20,
    };
    let found = elastic(&directories, &wanted).unwrap();
    assert_eq!((found.runs.len(), found.responses.len()), (3, 1));
    let rows: Vec<LogRow> = log::read(&directory("free/log.csv")).unwrap();
    let strains: Vec<[f64; 2]> = rows
        .iter()
        .skip(200)
        .map(|row| [row.strain_xx, row.strain_yy])
        .collect();
    let ratio = poisson_ratio(&strains, 20).unwrap();
    let own = found.runs[1].compliances.poisson_ratio_xy;
    assert!((own.value - ratio.xy).abs() < 1e-9 && (own.error - ratio.xy_error).abs() < 1e-9);
    let response = &found.responses[0].response;
    assert!(response.deviation.abs() < 4.0, "{response:?}");
    assert!(
        response.compliance.value > 5.0 * response.compliance.error,
        "{response:?}"
    );
    finish(&small(), &directory("cold"));
    let refused = elastic(&[directory("cold")], &wanted).unwrap_err();
    assert!(format!("{refused:#}").contains("heat bath"));
}

/// A sweep says when phases lock, how many domains there are, and how far sides are correlated.
#[test]
fn sweeps_tell_of_domains_and_locking() {
    let settings = LatticeSettings {
        steps: Some(400),
        sweep: Some(SweepAxes {
            r0: vec![0.02, 2.0],
            seeds: vec![1, 2],
            ..SweepAxes::default()
        }),
        time_step: TimeStep::AUTO,
        trajectory_every: 10,
        ..small()
    };
    let folder = tempfile::tempdir().unwrap();
    let sweep = finish_sweep(&settings, folder.path());
    let [short, long] = &sweep.conditions[..] else {
        panic!("{:?}", sweep.conditions)
    };
    // Short rods keep squares in step from the start, in one domain.
    assert_eq!((short.locked_share, short.locking_time.mean), (1.0, 0.0));
    assert_eq!((short.domains.mean, short.largest_domain.mean), (1.0, 1.0));
    assert!(short.correlation_length.is_nan());
    assert!(long.domains.mean >= 1.0 && long.largest_domain.mean <= 1.0);
    let table = std::fs::read_to_string(folder.path().join("correlation.csv")).unwrap();
    assert_eq!(table.lines().count(), 1 + 2 * 4);
    for figure in ["correlation", "domains", "orbits"] {
        assert!(
            folder.path().join(format!("{figure}.svg")).is_file(),
            "{figure}"
        );
    }
    // The slow twin, from the frames.
    let frames = read_states(&folder.path().join("r0_2_kappa_0/seed_1/trajectory.gsd")).unwrap();
    let net = network(&LatticeSettings { r0: 2.0, ..small() }).unwrap();
    let mut counts = 0.0;
    for (_, positions) in &frames {
        counts += Domains::of(&net, &sides(&net, positions)).count as f64 / frames.len() as f64;
    }
    let run = sweep
        .runs
        .iter()
        .find(|run| run.r0 == 2.0 && run.seed == 1)
        .unwrap();
    assert!((run.domains - counts).abs() < 1e-12);
}

/// The series of a log gives a positive exponent for a chaotic run, by either method, and an unknown
/// column is refused by name.
#[test]
fn logs_give_exponents() {
    let folder = tempfile::tempdir().unwrap();
    let settings = LatticeSettings {
        velocity_spread: 0.1,
        steps: Some(4000),
        ..nearly_coherent()
    };
    let directory = folder.path().join("run");
    finish(&settings, &directory);
    let wanted = DivergenceSettings {
        column: "checkerboard".into(),
        embedding: Embedding {
            dimension: 4,
            delay: 5,
            window: 50,
            horizon: 30,
        },
        radius: None,
        fit: [0, 10],
    };
    let nearest = from_log(&directory, &wanted).unwrap();
    assert!(nearest.exponent > 0.0 && nearest.samples == 2001);
    let ball = DivergenceSettings {
        radius: Some(0.2),
        ..wanted.clone()
    };
    assert!(from_log(&directory, &ball).unwrap().exponent > 0.0);
    let unknown = DivergenceSettings {
        column: "angle".into(),
        ..wanted
    };
    let message = from_log(&directory, &unknown).unwrap_err().to_string();
    assert!(message.contains("angle_spread"), "{message}");
}

fn screen(settings: &mut LatticeSettings, bjerrum: f64, debye: f64, kt: f64) {
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

/// A state in a file: numbers out of range, too few of them, times out of order.
#[test]
fn files_that_make_no_sense_are_refused_by_key() {
    let state = "[0, 0, 0.785, 2.05, 0, -0.785, 0, -2.05, -0.785, 2.05, -2.05, 0.785]";
    let rest = "[0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0]";
    let file = |ns: &str, r0: &str, s0: &str, times: &str, more: &str| {
        format!(
            "{{\"ns\": {ns}, \"r0\": {r0}, \"s0\": {s0}, \"v0\": {rest}, \"times\": {times}{more}}}"
        )
    };
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("state.json");
    for (text, complaint) in [
        (
            file("1000000", "0.05", "[0]", "[1]", ""),
            "ns is 1000000; it must be from 1 to 1000",
        ),
        (file("0", "0.05", "[]", "[]", ""), "ns is 0"),
        (
            file("2", "0.05", "[0]", "[1]", ""),
            "s0 has 1 numbers; 4 squares need 12",
        ),
        (file("2", "1e308", state, "[1]", ""), "r0 is 1e308; give"),
        (
            file("2", "0.05", state, "[1, 0.5]", ""),
            "the time 0.5 follows 1",
        ),
        (
            file("2", "0.05", state, "[-1]", ""),
            "a time in times is -1",
        ),
        (
            file("2", "0.05", state, "[1e308]", ""),
            "a time in times is 1e308",
        ),
        (
            file("2", "0.05", state, "[1]", ", \"kappa\": 1e300"),
            "kappa is 1e300",
        ),
        (file("2", "0.05", state, "[1]", ", \"l\": -1"), "l is -1"),
        (
            file("2", "0.05", state, "[1]", ", \"I\": 1e-300"),
            "I is 1e-300",
        ),
        (
            file("2", "0.05", &state.replace("2.05", "1e308"), "[1]", ""),
            "a number in s0 is 1e308",
        ),
    ] {
        std::fs::write(&path, &text).unwrap();
        let error = format!("{:#}", LatticeFile::read(&path).unwrap_err());
        assert!(
            error.contains(complaint) && error.contains("state.json"),
            "{text}: {error}"
        );
    }
    std::fs::write(&path, file("2", "0.05", state, "[1]", "")).unwrap();
    let good = LatticeFile::read(&path).unwrap();
    for (step, longest, complaint) in [
        (f64::NAN, 20.0, "--dt is NaN"),
        (1e-308, 20.0, "--dt is 1e-308"),
        (1e308, 20.0, "--dt is 1e308"),
        (1e-3, f64::INFINITY, "--longest is inf"),
        (1e-9, 1e9, "give a larger --dt"),
    ] {
        let error = replay(&good, step, longest).unwrap_err().to_string();
        assert!(error.contains(complaint), "{error}");
    }
}

#[test]
fn defects_and_other_squares_are_where_they_should_be() {
    let settings = LatticeSettings {
        removed_squares: vec![[0, 0]],
        removed_rods: vec![[1, 1, 1]],
        other_squares: vec![OtherSquare {
            at: [3, 3],
            half_diagonal: Some(0.9),
            mass: Some(2.0),
            inertia: None,
        }],
        ..small()
    };
    let network = network(&settings).unwrap();
    assert_eq!(
        (network.squares.len(), network.rods.len()),
        (15, 24 - 2 - 1)
    );
    let other = network.squares[network.at(3, 3).unwrap()];
    assert!((other.inertia - 2.0 * 0.81 / 3.0).abs() < 1e-15 && other.mass == 2.0);
    // The rods of the smaller square are brought to their length.
    let begun = begin(&settings).unwrap();
    let folder = tempfile::tempdir().unwrap();
    assert!(finish(&settings, folder.path()).max_rod_violation < 1e-12);
    assert_eq!(begun.state.positions.len(), 45);
}

#[test]
fn sweeps_do_not_depend_on_threads_and_are_taken_up_again() {
    let settings = LatticeSettings {
        rows: 2,
        columns: 2,
        steps: Some(300),
        log_every: 4,
        trajectory_every: 4,
        sweep: Some(SweepAxes {
            r0: vec![0.2, 1.0],
            kappa: vec![0.0, 1.0, 10.0],
            seeds: vec![1, 2],
            lyapunov: None,
            locked_within: None,
        }),
        ..small()
    };
    let folder = tempfile::tempdir().unwrap();
    let run = |threads: usize, name: &str, execution: &Execution| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| run_sweep(&settings, &folder.path().join(name), execution))
            .unwrap()
    };
    let End::Finished(sweep) = run(1, "one", &Execution::default()) else {
        panic!("it was not asked to stop")
    };
    assert_eq!((sweep.conditions.len(), sweep.runs.len()), (6, 12));
    let stopped = Execution::default();
    stopped.interrupt.request();
    assert_eq!(run(2, "two", &stopped), End::Stopped);
    run(2, "two", &Execution::default());
    for file in [
        "lattice.csv",
        "runs.csv",
        "crossings.csv",
        "lattice.json",
        "indices.svg",
        "spread.svg",
        "poisson.png",
    ] {
        let read = |name: &str| std::fs::read(folder.path().join(name).join(file)).expect(file);
        assert!(read("one") == read("two"), "{file} differs");
    }
    // The force that draws the squares together keeps them together.
    let spread = |kappa: f64| {
        let row = sweep
            .conditions
            .iter()
            .find(|row| row.r0 == 1.0 && row.kappa == kappa)
            .unwrap();
        row.largest_spread.mean
    };
    assert!(
        spread(10.0) < spread(1.0),
        "{} {}",
        spread(10.0),
        spread(1.0)
    );
}

/// A sweep in the given folder, on one thread.
fn finish_sweep(settings: &LatticeSettings, directory: &Path) -> LatticeSweep {
    match run_sweep(settings, directory, &Execution::default()).unwrap() {
        End::Finished(sweep) => sweep,
        End::Stopped => panic!("nobody asked it to stop"),
    }
}

/// Two by two squares from the open state, all turning alike but for a small disorder.
fn nearly_coherent() -> LatticeSettings {
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

/// The exponent of the sweep is the one that the library finds for the same trajectory, it is
/// chaotic, it is kept, and settings of another exponent are another sweep.
#[test]
fn sweeps_measure_lyapunov_exponents() {
    let lyapunov = LyapunovSettings {
        intervals: 60,
        discarded: 10,
        ..LyapunovSettings::default()
    };
    let settings = LatticeSettings {
        velocity_spread: 0.1,
        sweep: Some(SweepAxes {
            r0: vec![0.5, 1.0],
            seeds: vec![1, 2],
            lyapunov: Some(lyapunov),
            ..SweepAxes::default()
        }),
        ..nearly_coherent()
    };
    let folder = tempfile::tempdir().unwrap();
    let sweep = finish_sweep(&settings, folder.path());
    assert!(sweep.runs.iter().all(|run| run.lyapunov_exponent > 0.2));
    assert!(folder.path().join("lyapunov.svg").exists());

    let run = LatticeSettings {
        r0: 1.0,
        seed: 2,
        sweep: None,
        ..settings.clone()
    };
    let begun = begin(&run).unwrap();
    let (network, mut state) = (Arc::new(begun.network), begun.state);
    let flow = |state: &State| {
        let motion = run.motion().unwrap();
        SteppedFlow::new(Mover::new(&motion, network.clone(), state).unwrap(), 5e-3)
    };
    let (mut first, mut second) = (flow(&state), flow(&state));
    let seeded = LyapunovSettings {
        seed: 2,
        ..lyapunov
    };
    let found = maximal_exponent(&network, &mut first, &mut second, &mut state, &seeded).unwrap();
    let of_sweep = sweep.runs.iter().find(|run| run.r0 == 1.0 && run.seed == 2);
    assert_eq!(of_sweep.unwrap().lyapunov_exponent, found.exponent);

    // A second look reads what is there.
    let file = folder.path().join("r0_1_kappa_0/seed_2/lyapunov.json");
    let text = std::fs::read_to_string(&file).unwrap();
    let other = text.replace(
        &format!("\"exponent\": {}", found.exponent),
        "\"exponent\": 7.5",
    );
    assert_ne!(other, text);
    std::fs::write(&file, other).unwrap();
    let again = finish_sweep(&settings, folder.path());
    assert!(again.runs.iter().any(|run| run.lyapunov_exponent == 7.5));

    let noisy = LatticeSettings {
        temperature: Some(0.1),
        friction: 1.0,
        ..settings
    };
    assert!(noisy.check().unwrap_err().to_string().contains("noise"));
}

/// In the coherent motion the checkerboard mode passes the open state at the same speed every time,
/// and as often as the exact orbit does; disorder ends that at the first contact.
#[test]
fn sweeps_follow_the_mode_through_the_open_state() {
    let exact = CoherentOrbit::new(2, 2, Square::default(), 1.0, FRAC_PI_4, -1.0).unwrap();
    let mut expected = 0;
    let mut before = exact.at(1e-9)[0];
    for step in 1..=1000 {
        let angle = exact.at(0.01 * f64::from(step))[0];
        expected += usize::from((angle - FRAC_PI_4) * (before - FRAC_PI_4) < 0.0);
        before = angle;
    }
    assert!(expected >= 2, "{expected}");
    let coherent = LatticeSettings {
        r0: 1.0,
        ..nearly_coherent()
    };
    let disordered = LatticeSettings {
        velocity_spread: 0.3,
        ..coherent.clone()
    };
    let folder = tempfile::tempdir().unwrap();
    let run = |settings: &LatticeSettings, name: &str| {
        let directory = folder.path().join(name);
        let row = finish_sweep(settings, &directory).runs.remove(0);
        (
            row,
            std::fs::read_to_string(directory.join("crossings.csv")).unwrap(),
        )
    };
    let (row, table) = run(&coherent, "coherent");
    assert_eq!(table.lines().count(), 1 + expected, "{table}");
    assert!((row.crossing_rate - 0.1 * expected as f64).abs() < 1e-12);
    assert!((row.crossing_speed - 1.0).abs() < 1e-3, "{row:?}");
    let (row, _) = run(&disordered, "disordered");
    assert!(row.crossing_speed < 0.9, "{row:?}");
    assert!(folder.path().join("disordered/crossings.svg").exists());
}

/// Disorder is added to the spins and the energy of rotation stays; starts in which squares overlap
/// are drawn again.
#[test]
fn starts_may_be_disordered() {
    let settings = LatticeSettings {
        velocity_spread: 0.2,
        speed: 0.5,
        ..nearly_coherent()
    };
    let velocities = begin(&settings).unwrap().state.velocities;
    let spins: Vec<f64> = velocities.iter().skip(2).step_by(3).copied().collect();
    let sum: f64 = spins.iter().map(|omega| omega * omega).sum();
    assert!((sum - 4.0 * 0.25).abs() < 1e-12, "{spins:?}");
    assert!(spins.iter().any(|omega| (omega.abs() - 0.5).abs() > 0.02));
    let random = LatticeSettings {
        velocities: Velocities::Random,
        ..settings.clone()
    };
    let error = random.check().unwrap_err().to_string();
    assert!(error.contains("checkerboard start"), "{error}");

    let crowded = LatticeSettings {
        rows: 4,
        columns: 4,
        r0: 0.2,
        angle_spread: 1.0,
        velocity_spread: 0.0,
        ..settings
    };
    let seeds: Vec<u32> = (1..=8)
        .map(|seed| {
            let settings = LatticeSettings {
                seed,
                ..crowded.clone()
            };
            begin(&settings).unwrap().discarded_draws
        })
        .collect();
    assert!(seeds.iter().any(|draws| *draws > 0), "{seeds:?}");
    // Squares that pass through each other may overlap.
    let free = LatticeSettings {
        collisions: false,
        ..crowded
    };
    assert_eq!(begin(&free).unwrap().discarded_draws, 0);
}

#[test]
fn a_box_is_the_square_it_looks_like() {
    // A prism with a base of 10 Å turned by 30° about z, and a charge in each of two corners.
    let folder = tempfile::tempdir().unwrap();
    let (sine, cosine) = std::f64::consts::FRAC_PI_6.sin_cos();
    let turned = |x: f64, y: f64| (cosine * x - sine * y, sine * x + cosine * y);
    let mut off = "OFF\n8 12 0\n".to_owned();
    for (x, y, z) in [
        (-5, -5, -9),
        (5, -5, -9),
        (5, 5, -9),
        (-5, 5, -9),
        (-5, -5, 9),
        (5, -5, 9),
        (5, 5, 9),
        (-5, 5, 9),
    ] {
        let (x, y) = turned(f64::from(x), f64::from(y));
        off += &format!("{x} {y} {z}\n");
    }
    off += "3 0 2 1\n3 0 3 2\n3 4 5 6\n3 4 6 7\n3 0 1 5\n3 0 5 4\n3 1 2 6\n3 1 6 5\n3 2 3 7\n3 2 7 6\n3 3 0 4\n3 3 4 7\n";
    let (charge_x, charge_y) = turned(4.0, 4.0);
    let charges = format!(
        "{charge_x} {charge_y} 1 2\n{} {} -1 -1\n",
        -charge_x, -charge_y
    );
    std::fs::write(folder.path().join("box.off"), off).unwrap();
    std::fs::write(folder.path().join("box.xyzq"), charges).unwrap();
    let body = build(&OwnBody {
        name: "box".into(),
        mesh: folder.path().join("box.off"),
        charges: Some(folder.path().join("box.xyzq")),
    })
    .unwrap();
    for size in [Size::Corners, Size::Outside, Size::Area] {
        let named = square_of_body(&body, Axis::Auto, size).unwrap();
        let square = &named.square;
        let exact = 50f64.sqrt();
        assert!(
            (square.half_diagonal_angstrom / exact - 1.0).abs() < 2e-3,
            "{square:?}"
        );
        assert!(
            (square.inertia - 1.0 / 3.0).abs() < 2e-3 && square.symmetry_order == 4,
            "{square:?}"
        );
        assert!(square.deviation_from_fourfold < 1e-10 && square.moments_differ < 1e-10);
        assert!(
            (square.axis[2] - 1.0).abs() < 1e-10 && (square.height_angstrom - 18.0).abs() < 1e-9
        );
        // 4 Å along either side, where no site may be: moved inwards, the two opposite each other.
        let moment = |weight: fn([f64; 2]) -> f64| -> f64 {
            let charges = square.charges.iter();
            charges
                .map(|site| site.charge * weight(site.position))
                .sum()
        };
        assert!((moment(|_| 1.0) - 1.0).abs() < 1e-12, "{square:?}");
        let inset = (exact / 2f64.sqrt() - 2.0) / square.half_diagonal_angstrom;
        for dipole in [moment(|[x, _]| x), moment(|[_, y]| y)] {
            assert!(
                (dipole.abs() - 3.0 * inset).abs() < 5e-3,
                "{dipole} {inset}"
            );
        }
        assert_eq!((square.moved.count, square.moved.out_of), (2, 2));
        assert!((square.moved.farthest_angstrom - 2f64.sqrt()).abs() < 0.02);
        let warning = named.warning().unwrap();
        assert!(
            warning.starts_with("2 of 2 charges (+2.00 and -1.00 e)"),
            "{warning}"
        );
        let part: toml::Table = toml::from_str(&named.to_toml().unwrap()).unwrap();
        let settings: LatticeSettings = part.try_into().unwrap();
        assert_eq!(settings.charges, square.charges);
    }
}

/// The error of a replay of 10 x 10 squares with random velocities is of second order, and the
/// answer says how large it is.
#[test]
fn replays_state_their_error() {
    let settings = LatticeSettings {
        rows: 10,
        columns: 10,
        r0: 0.5,
        ..small()
    };
    let start = begin(&settings).unwrap().state;
    let file = LatticeFile {
        squares_along_edge: 10,
        r0: 0.5,
        kappa: 0.0,
        l: 1.0,
        inertia: None,
        s0: start.positions,
        v0: start.velocities,
        times: vec![0.3, 0.6],
        first_collision: None,
    };
    let [coarse, fine, finest] = [4e-3, 2e-3, 5e-4].map(|step| replay(&file, step, 0.01).unwrap());
    let ratio = coarse.estimated_error / fine.estimated_error;
    assert!((3.7..4.3).contains(&ratio), "{ratio}");
    let mut error = 0.0_f64;
    for (a, b) in coarse.s.iter().flatten().zip(finest.s.iter().flatten()) {
        error = error.max((a - b).abs());
    }
    assert!(
        (0.9..1.1).contains(&(error / coarse.estimated_error)),
        "{error}"
    );
}

#[path = "../../../../tests/test_data.rs"]
mod test_data;

#[test]
#[ignore = "needs PROTOMER_TEST_DATA: reference/lattice"]
fn files_are_replayed_to_their_contacts() {
    let entries = std::fs::read_dir(test_data::test_data("reference/lattice")).unwrap();
    for path in entries
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|e| e == "json"))
    {
        let file = LatticeFile::read(&path).unwrap();
        let reference: serde_json::Value =
            serde_json::from_slice(&std::fs::read(&path).unwrap()).unwrap();
        let numbers = |value: &serde_json::Value| -> Vec<f64> {
            value
                .as_array()
                .unwrap()
                .iter()
                .map(|x| x.as_f64().unwrap())
                .collect()
        };
        let apart = |a: &[f64], b: &[f64]| {
            a.iter()
                .zip(b)
                .map(|(a, b)| (a - b).abs())
                .fold(0.0, f64::max)
        };
        let found = replay(&file, 1e-3, 20.0).unwrap();
        for (s, expected) in found.s.iter().zip(reference["s"].as_array().unwrap()) {
            assert!(apart(s, &numbers(expected)) < 1e-4, "{}", path.display());
        }
        let energies = numbers(&reference["energy"]);
        assert!(
            apart(&found.energy, &energies) < 2e-3 * energies[0],
            "{}",
            path.display()
        );
        let contact = &reference["first_collision"];
        let first = found.first_collision.unwrap();
        assert!((first.t - contact["t"].as_f64().unwrap()).abs() < 1e-4);
        assert_eq!(
            serde_json::json!(first.contacts),
            contact["contacts"],
            "{}",
            path.display()
        );
        let response = respond(&file).unwrap();
        assert!(apart(&response.v_after, &numbers(&contact["v_after"])) < 1e-9);
        assert!(
            response.energy_change.abs() < 1e-12
                && response.impulses.iter().all(|impulse| *impulse >= 0.0)
        );
    }
}
