//! Settings that make no sense are refused by name; the others make the lattice that they state.

use crate::support::{finish, flexible, nearly_coherent, other, periodic, screen, small, well};
use protomer_linkage::lattice::Edges;
use protomer_linkage::lattice::pair::SquareCharge;
use protomer_linkage_verbs::lattice::log::LogRow;
use protomer_linkage_verbs::lattice::replay::{LatticeFile, replay};
use protomer_linkage_verbs::lattice::run::{LARGEST_ENERGY_ERROR, run_lattice};
use protomer_linkage_verbs::lattice::settings::{
    LatticeSettings, OtherSquare, Start, TimeStep, Velocities,
};
use protomer_linkage_verbs::lattice::square_of_body::{Axis, Size, square_of_body};
use protomer_linkage_verbs::lattice::start::{begin, charge_warning, network};
use protomer_protein_verbs::bodies::own_body::{OwnBody, build};
use protomer_results::{Execution, log};

/// Message of an error.
fn message<T, E: ToString>(refused: Result<T, E>) -> String {
    refused.err().unwrap().to_string()
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
    let unknown = message(toml::from_str::<LatticeSettings>("kapa = 3"));
    assert!(unknown.contains("kapa"), "{unknown}");
    let unknown = message(toml::from_str::<LatticeSettings>("time_step = \"fast\""));
    assert!(unknown.contains("'auto' or a number"), "{unknown}");
}

/// Puts a number into settings.
type Setter = fn(&mut LatticeSettings, f64);

/// Every number of the settings: what lies outside its range is refused by name, with its value and
/// the range.
#[test]
fn numbers_outside_their_ranges_are_refused_by_name() {
    let set: [(&str, Setter); 23] = [
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
        ("cell_mass", |s, x| s.cell_mass = Some(x)),
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
    assert!(message(endless.check()).contains("give a larger time_step"));
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
    let refusal = format!("{:#}", in_kt.check().unwrap_err());
    assert!(
        refusal.contains("angle_potential") && refusal.contains("--temperature"),
        "{refusal}"
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
    assert!(message(periodic.check()).contains("fixed; give cell = \"flexible\""));
}

#[test]
fn a_flexible_cell_needs_periodic_edges_and_its_own_collisions() {
    flexible().check().unwrap();
    for (settings, expected) in [
        (
            LatticeSettings {
                edges: Edges::Open,
                ..flexible()
            },
            "edges = \"periodic\"",
        ),
        (
            LatticeSettings {
                paper: true,
                ..flexible()
            },
            "remove paper",
        ),
        (
            LatticeSettings {
                cell_mass: Some(1.0),
                ..periodic()
            },
            "remove cell_mass",
        ),
    ] {
        let refusal = message(settings.check());
        assert!(refusal.contains(expected), "{refusal}");
    }
    // Straight rows and columns hold each other in the open state.
    let open = LatticeSettings {
        start: "open".parse().unwrap(),
        ..flexible()
    };
    let refusal = format!("{:#}", begin(&open).unwrap_err());
    assert!(refusal.contains("start = 0.3"), "{refusal}");
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
        let error = message(replay(&good, step, longest));
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
    let other = network.squares[network.square(3, 3).unwrap()];
    assert!((other.inertia - 2.0 * 0.81 / 3.0).abs() < 1e-15 && other.mass == 2.0);
    // The rods of the smaller square are brought to their length.
    let begun = begin(&settings).unwrap();
    let folder = tempfile::tempdir().unwrap();
    assert!(finish(&settings, folder.path()).max_rod_violation < 1e-12);
    assert_eq!(begun.state.positions.len(), 45);
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
    let error = message(random.check());
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
