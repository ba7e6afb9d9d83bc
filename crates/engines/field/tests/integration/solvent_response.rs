//! The response of the solvent to two bodies, against exact potentials and a solve of both bodies.

use protomer_field::solvent_response::{
    REFERENCE_SALT_MOLAR, ResponseSite, SolventResponse, regulated_response, solvent_response,
};
use protomer_field::{ChargedSphere, DielectricModel, SolveSettings, solve};
use protomer_kernel::{Electrolyte, Vec3};
use std::f64::consts::LN_10;

const RADIUS_ANGSTROM: f64 = 10.0;

fn model(salt_molar: f64) -> DielectricModel {
    DielectricModel::new(Electrolyte::in_water(298.15, salt_molar).unwrap())
}

/// A ball with charges off its centre, as the atoms of a protein are: (offset, charge).
fn ball(centre: Vec3, charges: &[(Vec3, f64)]) -> Vec<ChargedSphere> {
    let mut spheres = vec![ChargedSphere {
        centre,
        radius_angstrom: RADIUS_ANGSTROM,
        charge_e: 0.0,
    }];
    for (offset, charge_e) in charges {
        spheres.push(ChargedSphere {
            centre: centre + offset,
            radius_angstrom: 1.0,
            charge_e: *charge_e,
        });
    }
    spheres
}

/// Outside an ion the table is the difference of two exact potentials.
#[test]
fn the_table_of_an_ion_is_exact() {
    let medium = model(0.1);
    let ion = ChargedSphere {
        centre: Vec3::new(0.3, -0.2, 0.1),
        radius_angstrom: 3.0,
        charge_e: 2.0,
    };
    let response = solvent_response(&[ion], &medium).unwrap();
    let solved_less_plain = |salt_molar: f64, r: f64| {
        let electrolyte = Electrolyte::in_water(298.15, salt_molar).unwrap();
        let kappa = electrolyte.inverse_debye_length_per_angstrom();
        let b = ion.radius_angstrom + medium.ion_radius_angstrom;
        let factor = (kappa * b).exp() / (1.0 + kappa * b);
        let plain = electrolyte.bjerrum_length_angstrom() * ion.charge_e * (-kappa * r).exp() / r;
        (factor - 1.0) * plain
    };
    for r in [7.0, 9.0, 14.0] {
        let direction = Vec3::new(1.0, 2.0, -2.0) / 3.0;
        let [found, _, _, _] = response.table.value_at(&(ion.centre + r * direction));
        let exact = solved_less_plain(0.1, r) - solved_less_plain(REFERENCE_SALT_MOLAR, r);
        assert!(
            (found - exact).abs() < 0.03 * exact.abs() + 1e-3,
            "{r} {found} {exact}"
        );
    }
    let corner = Vec3::from(response.table.grid.origin_angstrom);
    assert_eq!(response.table.value_at(&corner), [0.0; 4]);
}

#[test]
fn sites_keep_charge_dipole_and_volume() {
    let charges = [
        (Vec3::new(7.0, 1.0, 0.0), 1.5),
        (Vec3::new(-2.0, -6.0, 3.0), -0.5),
    ];
    let centre = Vec3::new(1.0, 2.0, 3.0);
    let sites = solvent_response(&ball(centre, &charges), &model(0.3))
        .unwrap()
        .sites;
    let (mut charge, mut dipole, mut volumes) = (0.0, Vec3::zeros(), [0.0; 2]);
    for site in &sites {
        charge += site.charge_e;
        dipole += site.charge_e * site.place;
        volumes[0] += site.dielectric_angstrom3;
        volumes[1] += site.ionic_angstrom3;
    }
    let mut expected = Vec3::zeros();
    for (offset, charge_e) in charges {
        expected += charge_e * (centre + offset);
    }
    assert!((charge - 1.0).abs() < 1e-12);
    assert!((dipole - expected).norm() < 1e-9);
    let ball_volume = |radius: f64| 4.0 / 3.0 * std::f64::consts::PI * radius.powi(3);
    let reach = RADIUS_ANGSTROM + model(0.3).ion_radius_angstrom;
    assert!((volumes[0] / ball_volume(RADIUS_ANGSTROM) - 1.0).abs() < 0.02);
    assert!((volumes[1] / ball_volume(reach) - 1.0).abs() < 0.02);
}

/// The slow twin: the equation solved for both bodies together.
#[test]
fn the_salt_effect_of_two_balls_is_that_of_a_solve_of_both() {
    let charges = [
        vec![
            (Vec3::new(7.5, 1.0, 0.0), 3.0),
            (Vec3::new(-4.0, -5.0, 3.0), -1.0),
        ],
        vec![
            (Vec3::new(-7.5, -2.0, 1.0), -4.0),
            (Vec3::new(3.0, 2.0, 4.0), 1.0),
        ],
    ];
    let salts_molar = [0.05, REFERENCE_SALT_MOLAR];
    for gap_angstrom in [8.0, 12.0] {
        let away = Vec3::new(2.0 * RADIUS_ANGSTROM + gap_angstrom, 0.0, 0.0);
        let bodies = [ball(Vec3::zeros(), &charges[0]), ball(away, &charges[1])];
        let exact = salts_molar.map(|salt_molar| {
            let settings = SolveSettings {
                spacing_angstrom: 1.0,
                margin_angstrom: 20.0,
                ..SolveSettings::default()
            };
            let solvation = |spheres: &[ChargedSphere]| {
                let solved = solve(spheres, &model(salt_molar), &settings).unwrap();
                solved.solvation_energy_kt
            };
            solvation(&bodies.concat()) - solvation(&bodies[0]) - solvation(&bodies[1])
        });
        let plain = salts_molar.map(|salt_molar| {
            let electrolyte = model(salt_molar).electrolyte;
            let kappa = electrolyte.inverse_debye_length_per_angstrom();
            let mut sum = 0.0;
            for first in &bodies[0] {
                for second in &bodies[1] {
                    let r = (first.centre - second.centre).norm();
                    sum += first.charge_e * second.charge_e * (-kappa * r).exp() / r;
                }
            }
            electrolyte.bjerrum_length_angstrom() * sum
        });
        let [first, second] =
            bodies.map(|body| solvent_response(&body, &model(salts_molar[0])).unwrap());
        let acting = |response: &SolventResponse, sites: &[ResponseSite]| -> f64 {
            let energies = sites.iter().map(|site| {
                let [a, b, c, _] = response.table.value_at(&site.place);
                a * site.charge_e + b * site.dielectric_angstrom3 + c * site.ionic_angstrom3
            });
            energies.sum()
        };
        let response = acting(&first, &second.sites) + acting(&second, &first.sites);
        let exact = exact[0] - exact[1];
        let plain = plain[0] - plain[1];
        let found = plain + response;
        let (error, error_of_plain) = ((found - exact).abs(), (plain - exact).abs());
        assert!(
            error < 0.08 * exact.abs() && error_of_plain > 0.3 * exact.abs(),
            "gap {gap_angstrom}: exact {exact}, plain {plain}, first order {found}"
        );
    }
}

#[test]
fn a_medium_without_salt_is_refused() {
    let refused = solvent_response(&ball(Vec3::zeros(), &[]), &model(0.0)).unwrap_err();
    assert!(
        refused.to_string().contains("give a salt above zero"),
        "{refused}"
    );
}

/// Two spheres in 30 mM of salt, each with one acid in its middle, some of which is charged; `w` is the energy
/// of two charges by Debye and Hückel, kT. The exact partition sum has four states. Mean charges and the tables
/// miss the correlation of the fluctuations of both, ½ C² w² (Kirkwood and Shumaker), and terms of third order.
#[test]
fn two_titratable_spheres_have_the_free_energy_of_the_exact_partition_sum() {
    let medium = model(0.03);
    let electrolyte = &medium.electrolyte;
    let kappa = electrolyte.inverse_debye_length_per_angstrom();
    let place = Vec3::new(0.3, 22.0, 0.1);
    let (r, b) = (place.norm(), RADIUS_ANGSTROM + medium.ion_radius_angstrom);
    let w =
        electrolyte.bjerrum_length_angstrom() * (-kappa * (r - b)).exp() / (r * (1.0 + kappa * b));
    let share = |ph: f64| 10_f64.powf(ph) / (1.0 + 10_f64.powf(ph));
    // The sites of either sphere in the table of the other, which is the same seen from it.
    let regulation_kt = |ph: f64| {
        let f = share(ph);
        let spheres = ball(Vec3::zeros(), &[(Vec3::zeros(), -f)]);
        let capacitances_e2 = [0.0, f * (1.0 - f)];
        let response = regulated_response(&spheres, &capacitances_e2, &medium).unwrap();
        let mut energy_kt = 0.0;
        for site in &response.sites {
            let [_, _, _, per_capacitance] = response.table.value_at(&(site.place + place));
            energy_kt += 2.0 * site.capacitance_e2 * per_capacitance;
        }
        energy_kt
    };
    // In units of the pH from the pKa.
    for ph in [-0.6, 0.0, 0.4] {
        let (f, x) = (share(ph), 10_f64.powf(ph));
        let capacitance = f * (1.0 - f);
        let partition = |w: f64| 1.0 + 2.0 * x + x * x * (-w).exp();
        let exact = -(partition(w) / partition(0.0)).ln();
        let correlation = -0.5 * capacitance * capacitance * w * w;
        let regulation = regulation_kt(ph);
        let error = f * f * w + regulation + correlation - exact;
        eprintln!("w = {w:.3}, f = {f:.2}: regulation {regulation:.2e}, error {error:.1e}");
        assert!(
            error.abs() < 0.15 * regulation.abs(),
            "{error} {regulation}"
        );

        // Protons taken up on binding are the slope of the free energy with the pH.
        let step = 0.1;
        let energy_kt = |ph: f64| share(ph).powi(2) * w + regulation_kt(ph);
        let slope = (energy_kt(ph + step) - energy_kt(ph - step)) / (2.0 * step * LN_10);
        let bound = (x + x * x * (-w).exp()) / partition(w);
        let uptake = 2.0 * (f - bound);
        assert!((slope / uptake - 1.0).abs() < 0.05, "{slope} {uptake}");
    }
}
