//! Runs are continued bit for bit; their logs, trajectories and pages hold what they should.

use crate::support::{
    finish, flexible, nearly_coherent, periodic, small, stop_after, too_fast, well,
};
use protomer_io::gsd::{ChunkData, GsdFile};
use protomer_linkage::analysis::divergence::Embedding;
use protomer_linkage::analysis::strain::poisson_ratio;
use protomer_linkage_verbs::lattice::animation::Animation;
use protomer_linkage_verbs::lattice::divergence::{DivergenceSettings, from_log};
use protomer_linkage_verbs::lattice::elastic::{ElasticSettings, elastic};
use protomer_linkage_verbs::lattice::log::LogRow;
use protomer_linkage_verbs::lattice::run::{LARGEST_ENERGY_ERROR, run_lattice};
use protomer_linkage_verbs::lattice::settings::{
    LatticeSettings, NamedTimeStep, TimeStep, Velocities,
};
use protomer_linkage_verbs::lattice::start::begin;
use protomer_linkage_verbs::lattice::trajectory::read_states;
use protomer_results::{End, Execution, log};
use std::path::Path;

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
        ("a flexible cell", flexible()),
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
fn a_flexible_cell_is_the_box_of_its_frames_and_the_strain_of_its_log() {
    let folder = tempfile::tempdir().unwrap();
    let settings = LatticeSettings {
        cell_mass: Some(2.5),
        log_every: 25,
        ..flexible()
    };
    let begun = begin(&settings).unwrap();
    assert_eq!(begun.network.cell_mass, Some(2.5));
    assert_eq!(
        begin(&flexible())
            .unwrap()
            .network
            .cell_mass
            .map(|mass| (mass * 1e9).round()),
        Some(1.6e9),
        "a tenth of 16 squares"
    );
    let result = finish(&settings, folder.path());
    assert!(result.events > 0 && result.max_rod_violation < 1e-11);
    let rows: Vec<LogRow> = log::read(&folder.path().join(log::FILE)).unwrap();
    let path = folder.path().join("trajectory.gsd");
    let states = read_states(&path).unwrap();
    assert_eq!((rows.len(), states.len()), (13, 13));
    let [first_x, first_y] = begun.network.cell.unwrap();
    let mut file = GsdFile::open(&path).unwrap();
    let mut largest = 0.0_f64;
    for (frame, (row, (time, positions))) in rows.iter().zip(&states).enumerate() {
        assert_eq!((*time, positions.len()), (row.time, 48));
        let mut numbers = |name: &str| match file.chunk(frame as u64, name).unwrap().unwrap().data {
            ChunkData::F64(numbers) => numbers,
            ChunkData::F32(numbers) => numbers.into_iter().map(f64::from).collect(),
            _ => panic!("{name} is of another type"),
        };
        let (cell, shape) = (numbers("log/cell"), numbers("configuration/box"));
        for (found, expected) in [
            (shape[0], cell[0]),
            (shape[1], cell[1]),
            (shape[3], cell[2] / cell[1]),
        ] {
            assert!((found - expected).abs() < 1e-5);
        }
        // F = H H₀⁻¹ with an upright H₀; the strain of Biot by F = R U.
        let (xx, yy, xy) = (cell[0] / first_x, cell[1] / first_y, cell[2] / first_y);
        let turn = (-xy).atan2(xx + yy);
        let (sine, cosine) = turn.sin_cos();
        let strain = [cosine * xx - 1.0, cosine * yy - sine * xy - 1.0];
        assert!(
            (row.strain_xx - strain[0]).abs() < 1e-12,
            "{} {strain:?}",
            row.strain_xx
        );
        assert!(
            (row.strain_yy - strain[1]).abs() < 1e-12,
            "{} {strain:?}",
            row.strain_yy
        );
        largest = largest.max(row.strain_xx.abs());
    }
    assert!(largest > 1e-3, "{largest}");
    // Another run starts where this one is, with its cell.
    let next = LatticeSettings {
        state: Some(folder.path().display().to_string()),
        ..settings
    };
    let begun = begin(&next).unwrap();
    let last = GsdFile::open(&path)
        .unwrap()
        .chunk(12, "log/cell")
        .unwrap()
        .unwrap();
    let ChunkData::F64(cell) = last.data else {
        panic!("the cell is in double precision")
    };
    for (found, expected) in begun.state.positions[48..].iter().zip(cell) {
        assert!((found - expected).abs() < 1e-9);
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

/// Lengths of the lines of a picture, pixels.
fn line_lengths(svg: &str) -> Vec<f64> {
    let mut lengths = Vec::new();
    for line in svg.lines().filter(|line| line.starts_with("<line")) {
        let number = |name: &str| -> f64 {
            let rest = line.split(&format!("{name}=\"")).nth(1).unwrap();
            rest.split('"').next().unwrap().parse().unwrap()
        };
        lengths.push((number("x1") - number("x2")).hypot(number("y1") - number("y2")));
    }
    lengths
}

#[test]
fn rods_across_a_flexible_cell_are_drawn_with_their_length() {
    let folder = tempfile::tempdir().unwrap();
    finish(&flexible(), folder.path());
    let animation = Animation::read(folder.path(), 5).unwrap();
    let rods = begin(&flexible()).unwrap().network.rods.len();
    for frame in [0, animation.len() - 1] {
        let lengths = line_lengths(&animation.to_svg(frame));
        assert_eq!(lengths.len(), rods);
        // Ends are written to a tenth of a pixel.
        let longest = lengths.iter().copied().fold(0.0, f64::max);
        assert!(
            lengths.iter().all(|length| *length > longest - 0.3),
            "{lengths:?}"
        );
    }
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
