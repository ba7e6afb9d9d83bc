//! Stopped and continued runs, parts, and what is refused.

use super::*;
use protomer_results::Record;

/// Settings of a small crystal of squares.
fn squares(sweeps: u64) -> FreeEnergySettings {
    FreeEnergySettings {
        shape: "polygon:4".into(),
        crystal: "square".into(),
        turn: vec![45.0],
        bodies: 36,
        packing_fraction: 0.85,
        equilibration: 100,
        sweeps,
        ..FreeEnergySettings::default()
    }
}

#[test]
fn strengths_apart_give_the_same_bytes_for_any_number_of_parts() {
    let folder = tempfile::tempdir().unwrap();
    let settings = FreeEnergySettings {
        share: Share::Even,
        // Not whole rows.
        ..squares(310)
    };
    let run = |settings: &FreeEnergySettings, name: &str| {
        let path = folder.path().join(name);
        let end = run_free_energy(settings, &path, &Execution::default()).unwrap();
        end.finished().unwrap()
    };
    let parts = folder.path().join("parts");
    let mut done = 0;
    for index in [3, 1, 4, 2] {
        let shard = Shard::parse(&format!("{index}/4")).unwrap();
        let end = run_shard(&settings, &parts, shard, &Execution::default()).unwrap();
        done += end.finished().unwrap();
    }
    assert_eq!(done, STRENGTHS);
    let (in_parts, at_once) = (run(&settings, "parts"), run(&settings, "whole"));
    assert_eq!(in_parts, at_once);
    assert!(at_once.points.iter().all(|point| point.sweeps == 350));
    let read = |name: &str, file: &str| std::fs::read(folder.path().join(name).join(file)).unwrap();
    for file in [
        "run.json",
        POINTS,
        CRYSTAL,
        "run.toml",
        "strength_07/log.csv",
    ] {
        assert!(read("parts", file) == read("whole", file), "{file}");
    }
    // More sweeps extend it, to the bytes of a long one.
    let long = FreeEnergySettings {
        sweeps: 600,
        ..settings.clone()
    };
    assert_eq!(run(&long, "parts"), run(&long, "long"));
    assert!(read("parts", POINTS) == read("long", POINTS));
    // The record is read as that of any free energy.
    let record = Record::read(&folder.path().join("long")).unwrap().unwrap();
    let recorded = record.answer::<FreeEnergyResult>().unwrap();
    assert!(record.is_done() && recorded.points.len() == STRENGTHS);
    let adaptive = FreeEnergySettings {
        share: Share::Errors,
        ..settings
    };
    let shard = Shard::parse("1/2").unwrap();
    let refused = run_shard(&adaptive, &parts, shard, &Execution::default());
    assert!(refused.unwrap_err().to_string().contains("--share even"));
    assert!(run_free_energy(&adaptive, &parts, &Execution::default()).is_err());
}

#[test]
fn even_sweeps_agree_with_those_by_errors() {
    // Rods on a line, whose free energy is known: ln(1/(1 - η)) and the ideal gas.
    let folder = tempfile::tempdir().unwrap();
    let settings = |share| FreeEnergySettings {
        shape: "rod:1".into(),
        crystal: "row".into(),
        bodies: 8,
        packing_fraction: 0.5,
        equilibration: 100,
        sweeps: 2000,
        share,
        ..FreeEnergySettings::default()
    };
    let [even, by_errors] = [Share::Even, Share::Errors].map(|share| {
        let path = folder
            .path()
            .join(protomer_kernel::setting::Choices::name(share));
        let end = run_free_energy(&settings(share), &path, &Execution::default()).unwrap();
        end.finished().unwrap()
    });
    let error = even
        .free_energy_per_body_kt_error
        .hypot(by_errors.free_energy_per_body_kt_error);
    let apart = even.free_energy_per_body_kt - by_errors.free_energy_per_body_kt;
    assert!(error < 0.03 && apart.abs() < 4.0 * error, "{apart} {error}");
    assert!(
        (even.free_energy_per_body_kt + 0.84051).abs() < 4.0 * even.free_energy_per_body_kt_error
    );
}

#[test]
fn a_free_energy_that_stops_and_goes_on_writes_the_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let short = squares(400);
    let long = FreeEnergySettings {
        sweeps: 800,
        ..short.clone()
    };
    let run = |settings: &FreeEnergySettings, name: &str| {
        let path = folder.path().join(name);
        let end = run_free_energy(settings, &path, &Execution::default()).unwrap();
        end.finished().unwrap()
    };
    run(&short, "parts");
    let (in_parts, at_once) = (run(&long, "parts"), run(&long, "whole"));
    assert_eq!(in_parts, at_once);
    assert_eq!(in_parts.symmetry_order, 4);
    for file in [LOG, POINTS, CRYSTAL, CHECKPOINT] {
        let read = |name: &str| std::fs::read(folder.path().join(name).join(file)).unwrap();
        assert!(read("parts") == read("whole"), "{file}");
    }
    let terms = &in_parts.terms;
    let sum =
        terms.centre_of_mass_kt + terms.springs_kt + terms.orientations_kt + terms.overlaps_kt
            - terms.integral_kt;
    assert!((sum - in_parts.free_energy_per_body_kt).abs() < 1e-12);
}
