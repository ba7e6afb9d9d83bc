//! The benchmark: its states, its decisions and its tables. No test measures time.

use crate::common::{TemporaryFolder, Watcher, is_ok};
use protomer_protein_verbs::stability::bench::suite::{Part, SuiteSettings, run_suite};
use protomer_protein_verbs::stability::bench::tables::{BodiesRow, SuiteResult};
use protomer_protein_verbs::stability::energy_tables::EnergyTables;
use protomer_protein_verbs::stability::interaction::{InteractionSettings, ScreenedCoulomb};
use protomer_protein_verbs::stability::run::EnergyMode;
use protomer_results::Execution;
use std::sync::atomic::Ordering;
use std::sync::{Arc, OnceLock};

/// Every table on small bodies.
fn small() -> SuiteSettings {
    SuiteSettings {
        charges: vec![10, 40],
        bodies: vec![16, 100],
        few_charges: 10,
        moves: Some(100),
        replica_moves: [200, 50, 50],
        seconds_per_rate: 0.0,
        edge_divisions: 6,
        ..SuiteSettings::default()
    }
}

fn interaction() -> ScreenedCoulomb {
    let medium = InteractionSettings {
        debye_length_angstrom: Some(9.6),
        ..InteractionSettings::default()
    };
    medium.interaction(None).unwrap()
}

/// Shared by all tests, so that each table is made once.
fn tables() -> &'static EnergyTables {
    static TABLES: OnceLock<EnergyTables> = OnceLock::new();
    TABLES.get_or_init(EnergyTables::default)
}

fn run(settings: &SuiteSettings) -> SuiteResult {
    run_suite(settings, interaction(), tables(), &Execution::default()).unwrap()
}

/// What does not depend on the machine.
fn decisions(result: &SuiteResult) -> Vec<String> {
    let rates = result
        .charges
        .iter()
        .map(|row| row.decisions_sha256.clone());
    rates
        .chain(
            result
                .threads
                .iter()
                .map(|row| row.decisions_sha256.clone()),
        )
        .collect()
}

#[test]
fn a_seed_makes_the_same_decisions_and_calibrated_energies_decide_as_the_direct_sum() {
    let settings = SuiteSettings {
        parts: vec![Part::Charges, Part::Threads],
        ..small()
    };
    let result = run(&settings);
    assert!(result.complete);
    assert_eq!(decisions(&result), decisions(&run(&settings)));
    assert_ne!(
        decisions(&result),
        decisions(&run(&SuiteSettings {
            seed: 2,
            ..settings.clone()
        }))
    );
    for charges in settings.charges {
        let of = |energy| {
            result
                .charges
                .iter()
                .find(|row| row.charges == charges && row.energy == energy)
                .unwrap()
        };
        let (direct, calibrated) = (of(EnergyMode::Direct), of(EnergyMode::Calibrated));
        assert_eq!(direct.decisions_sha256, calibrated.decisions_sha256);
        assert_eq!(calibrated.decides_as_direct, Some(true));
        assert_eq!(direct.error_bound_kt_per_pair, 0.0);
        let certified = of(EnergyMode::Certified);
        assert_eq!(direct.decisions_sha256, certified.decisions_sha256);
        assert!(certified.error_bound_kt_per_pair > 0.0);
        let approximate = of(EnergyMode::Approximate);
        let bounds = (
            calibrated.error_bound_kt_per_pair,
            approximate.error_bound_kt_per_pair,
        );
        assert!(
            bounds.0 > 0.0 && bounds.1 > 0.0 && bounds.1 <= settings.tolerance_kt,
            "{bounds:?}"
        );
        assert!(
            direct.acceptance > 0.1 && direct.acceptance < 0.9,
            "both answers occur: {}",
            direct.acceptance
        );
    }
}

#[test]
fn the_tables_are_complete_and_hang_together() {
    let settings = small();
    let watcher = Arc::new(Watcher::default());
    let result = run_suite(&settings, interaction(), tables(), &watcher.execution()).unwrap();
    let rows = watcher.total.load(Ordering::Relaxed);
    assert_eq!(watcher.described.lock().unwrap().len() as u64, rows);
    assert_eq!(watcher.done.load(Ordering::Relaxed), rows);
    assert_eq!(result.parts.len(), settings.charges.len());
    for row in &result.parts {
        let parts = row.overlap_microseconds
            + row.coarse_microseconds
            + row.refinement_microseconds
            + row.keeping_microseconds;
        assert!(
            (parts - row.move_microseconds).abs() < 1e-6 * row.move_microseconds,
            "{row:?}"
        );
        assert!(
            row.decided_by_energy > 0.1
                && row.decided_by_energy < 1.0
                && row.coarse_energies_per_move > 1.0,
            "{row:?}"
        );
    }
    for rows in result.bodies.chunks(settings.bodies.len()) {
        let density = |row: &BodiesRow| row.bodies as f64 / row.box_angstrom.powi(3);
        assert!((density(&rows[0]) / density(&rows[1]) - 1.0).abs() < 1e-9);
        let ratio = rows[1].neighbours / rows[0].neighbours;
        assert!(
            ratio > 0.5 && ratio < 2.0,
            "equal density, about as many neighbours: {rows:?}"
        );
    }
    for rows in result.threads.chunks(settings.threads.len()) {
        assert_eq!(
            rows[0].decisions_sha256, rows[1].decisions_sha256,
            "threads change nothing"
        );
    }
}

#[test]
fn an_interrupt_leaves_what_was_measured() {
    // At the beginning of the second row, which is still measured.
    let execution = Watcher::stopping_after(2).execution();
    let result = run_suite(&small(), interaction(), tables(), &execution).unwrap();
    assert!(!result.complete);
    assert_eq!(
        (
            result.charges.len(),
            result.bodies.len(),
            result.threads.len()
        ),
        (2, 0, 0)
    );
}

#[test]
fn the_command_prints_one_table_or_one_json_object() {
    let place = TemporaryFolder::new();
    // Each rate takes a second: this part has one.
    let output = place.run("bench --part parts --charges 15 --moves 20 --json");
    is_ok(&output);
    let found: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let parts = found["parts"].as_array().unwrap();
    assert_eq!(parts.len(), 1);
    assert_eq!(parts[0]["charges"], 15);
    assert!(parts[0]["moves"].as_u64().unwrap() >= 20);
    assert_eq!(found["debye_length_angstrom"], 9.6);
    assert!(found["charges"].as_array().unwrap().is_empty());
    let output = place.run("bench --part charges --charges 15 --moves 20");
    is_ok(&output);
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(
        text.contains("moves/s")
            && text.contains("certified")
            && text.contains("calibrated")
            && text.contains("approximate")
            && text.contains("error bound (kT)")
            && !text.contains("neighbours"),
        "{text}"
    );
}

#[test]
fn an_assembly_gives_its_keys_and_equal_hashes() {
    let place = TemporaryFolder::new();
    let bench = |energy: &str| -> serde_json::Value {
        let output = place.run(&format!(
            "bench ring.json --debye 3A --moves 500 --json --energy {energy}"
        ));
        is_ok(&output);
        serde_json::from_slice(&output.stdout).unwrap()
    };
    let (direct, calibrated, none) = (bench("direct"), bench("calibrated"), bench("none"));
    for key in [
        "moves_per_cpu_second",
        "acceptance",
        "setup_seconds",
        "memory_bytes",
    ] {
        assert!(
            direct[key].as_f64().is_some_and(f64::is_finite),
            "{key}: {}",
            direct[key]
        );
    }
    assert_eq!(direct["decisions_sha256"], calibrated["decisions_sha256"]);
    assert_ne!(direct["decisions_sha256"], none["decisions_sha256"]);
    let approximate = bench("approximate --tolerance 1e-5");
    let bound = |result: &serde_json::Value| result["error_bound_kt_per_pair"].as_f64().unwrap();
    assert!(bound(&direct) == 0.0 && bound(&calibrated) > 0.0 && bound(&approximate) <= 1e-5);
    assert!(
        calibrated["memory_bytes"].as_u64() > direct["memory_bytes"].as_u64(),
        "the tables count"
    );
}

#[test]
fn one_part_is_one_table() {
    let settings = SuiteSettings {
        parts: vec![Part::Bodies],
        ..small()
    };
    let result = run(&settings);
    assert!(result.charges.is_empty() && result.parts.is_empty() && result.threads.is_empty());
    assert_eq!(result.bodies.len(), settings.bodies.len() * 3);
}
