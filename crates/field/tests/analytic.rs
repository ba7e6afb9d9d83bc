//! Potentials and energies with closed forms, and converged ones computed elsewhere.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::print_stderr)]

use protomer_field::{ChargedSphere, Medium, SolveSettings, solve};
use protomer_kernel::{Conditions, Vec3};
use std::path::{Path, PathBuf};

fn shared() -> Option<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/reference/electrostatics");
    if !folder.is_dir() {
        eprintln!("skipped: {} is absent", folder.display());
        return None;
    }
    Some(folder)
}

#[test]
fn spheres_have_the_energies_of_the_series() {
    let Some(folder) = shared() else { return };
    let cases: serde_json::Value =
        serde_json::from_slice(&std::fs::read(folder.join("analytic.json")).unwrap()).unwrap();
    let mut worst = 0.0_f64;
    for case in cases.as_array().unwrap() {
        let number = |key: &str| case[key].as_f64().unwrap_or(0.0);
        let radius = number("a");
        if radius < 2.0 || number("s") > 0.8 * radius || number("I") > 0.0 && number("I") != 0.1 {
            continue;
        }
        let conditions = Conditions::with_permittivity(298.15, number("I"), 7.0, 78.54).unwrap();
        let mut medium = Medium::new(conditions);
        medium.inner_permittivity = number("eps_in");
        medium.ion_radius_angstrom = number("stern");
        let mut spheres = vec![ChargedSphere { centre: Vec3::zeros(), radius_angstrom: radius, charge_e: 0.0 }];
        let charges = if case["case"] == "kirkwood_dipole_pm8z" {
            vec![(8.0, 1.0), (-8.0, -1.0)]
        } else {
            vec![(number("s"), number("q"))]
        };
        for (z, q) in charges {
            spheres.push(ChargedSphere { centre: Vec3::new(0.0, 0.0, z), radius_angstrom: 0.01, charge_e: q });
        }
        let begun = std::time::Instant::now();
        let to_kj = conditions.kilojoule_per_mol_per_kt();
        let errors: Vec<f64> = [0.7, 0.5]
            .iter()
            .map(|spacing| {
                let settings = SolveSettings { spacing_angstrom: *spacing, ..SolveSettings::default() };
                solve(&spheres, &medium, &settings).unwrap().solvation_energy_kt * to_kj / number("dG") - 1.0
            })
            .collect();
        let c: f64 = (0.7_f64 / 0.5).powi(2);
        let extrapolated = errors[1] + (errors[1] - errors[0]) / (c - 1.0);
        eprintln!(
            "{} a={radius} s={} eps={} I={} stern={}: {:+.3} % {:+.3} % -> {:+.3} %",
            case["case"],
            number("s"),
            number("eps_in"),
            number("I"),
            number("stern"),
            100.0 * errors[0],
            100.0 * errors[1],
            100.0 * extrapolated
        );
        worst = worst.max(errors[1].abs());
    }
    assert!(worst < 0.01, "{worst}");
}
