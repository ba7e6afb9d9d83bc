//! A set says what it holds, and continues.

use super::{Place, content, peptide, rayon_pool, settings};
use crate::common::Watcher;
use protomer_field::voxels::{Channel, Orientation, PotentialModel};
use protomer_learn::SampleSource;
use protomer_learn_verbs::voxels::manifest::Manifest;
use protomer_learn_verbs::voxels::merge::merge;
use protomer_learn_verbs::voxels::samples::VoxelSet;
use protomer_learn_verbs::voxels::structure::Reason;
use protomer_learn_verbs::voxels::{Fit, Spacing, State, VoxelizeSettings, voxelize, work_path};
use protomer_results::{Execution, Shard};
use serde_json::json;
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;

#[test]
fn a_manifest_becomes_a_set_with_its_exclusions() {
    let place = Place::new();
    let report = place.make("a.zarr", Shard::WHOLE, &settings());
    assert_eq!(
        (report.state, report.structures, report.samples),
        (State::Written, 8, 3)
    );
    let reasons: Vec<(&str, Reason)> = report
        .excluded
        .iter()
        .map(|e| (e.row.name.as_str(), e.reason))
        .collect();
    let expected = [
        ("trace", Reason::Truncated),
        ("broken", Reason::Unreadable),
        ("water", Reason::NoProtein),
        ("missing", Reason::Unreadable),
        ("far", Reason::TooLarge),
    ];
    assert_eq!(reasons, expected);
    assert!(!work_path(&place.path("a.zarr")).exists());
    let set = VoxelSet::open(&place.path("a.zarr")).unwrap();
    assert_eq!(
        (set.size(), set.channels()),
        (
            32,
            &["shape", "potential", "hydropathy"].map(String::from)[..]
        )
    );
    let known = &set.descriptions()[0];
    assert_eq!(
        (
            known.name.as_str(),
            known.label.as_str(),
            known.cluster.as_str()
        ),
        ("one", "P 1", "a")
    );
    assert_eq!(
        (known.family.as_str(), known.residues, known.composition[0]),
        ("f", 5.0, 1.0)
    );
    assert!(
        known.extents_angstrom.is_sorted_by(|a, b| a >= b)
            && known.radius_of_gyration_angstrom > 2.0
    );
    let mut dense = vec![0.0; 3 * 32 * 32 * 32];
    for (sample, known) in set.descriptions().iter().enumerate() {
        let grid = set.voxels(sample).unwrap();
        grid.check().unwrap();
        grid.write_dense(&mut dense).unwrap();
        let shell = dense[..32 * 32 * 32]
            .iter()
            .filter(|value| **value == 1.0)
            .count();
        assert!(
            shell == grid.index.len() && shell > 100,
            "{}: {shell}",
            known.name
        );
        // Nothing but alanine: every hydropathy is that of alanine.
        if known.name == "one" {
            assert!(
                grid.values[2 * shell..]
                    .iter()
                    .all(|value| (value - 1.8).abs() < 1e-3)
            );
        }
    }
}

#[test]
fn a_set_says_what_values_its_channels_have_and_what_of_its_files_is_odd() {
    let place = Place::new();
    let gap = peptide(["ALA", "GLY", "ALA", "ALA", "GLY"], 1.75);
    let gap: Vec<&str> = gap
        .lines()
        .filter(|line| !line.contains("CB  ALA A   3"))
        .collect();
    std::fs::write(place.path("two.pdb"), gap.join("\n")).unwrap();
    let report = place.make("a.zarr", Shard::WHOLE, &settings());
    assert_eq!(report.warnings["two"], ["ALA A:3 lacks CB"]);
    assert!(
        !report.warnings.contains_key("one"),
        "{:?}",
        report.warnings
    );
    assert_eq!(
        place.make("a.zarr", Shard::WHOLE, &settings()).warnings,
        report.warnings
    );
    let set = VoxelSet::open(&place.path("a.zarr")).unwrap();
    let attributes = set.reader().attributes();
    assert_eq!(
        attributes["warnings"],
        serde_json::to_value(&report.warnings).unwrap()
    );
    // Two clusters are too few to split.
    let statistics = &attributes["statistics"];
    assert_eq!(
        (&statistics["over"], &statistics["samples"]),
        (&json!("all samples"), &json!([0, 1, 2]))
    );
    let potentials = (0..3).flat_map(|sample| {
        let grid = set.voxels(sample).unwrap();
        grid.values[grid.index.len()..2 * grid.index.len()]
            .iter()
            .map(|value| f64::from(*value))
            .collect::<Vec<_>>()
    });
    let mut potentials: Vec<f64> = potentials.collect();
    potentials.sort_by(f64::total_cmp);
    let count = potentials.len() as f64;
    let mean = potentials.iter().sum::<f64>() / count;
    let deviation = (potentials
        .iter()
        .map(|value| (value - mean).powi(2))
        .sum::<f64>()
        / count)
        .sqrt();
    let found = &statistics["channels"]["potential"];
    let close = |name: &str, expected: f64| {
        let value = found[name].as_f64().unwrap();
        assert!(
            (value - expected).abs() < 1e-9 * (1.0 + expected.abs()),
            "{name} {value} {expected}"
        );
    };
    close("voxels", count);
    close("mean", mean);
    close("standard_deviation", deviation);
    close("median", potentials[potentials.len() / 2]);
    close("minimum", potentials[0]);
    close("maximum", potentials[potentials.len() - 1]);
}

#[test]
fn the_same_command_again_has_nothing_to_do_until_something_changes() {
    let place = Place::new();
    let first = place.make("a.zarr", Shard::WHOLE, &settings());
    let before = content(&place.path("a.zarr"));
    let again = place.make("a.zarr", Shard::WHOLE, &settings());
    assert_eq!(
        (again.state, again.samples, &again.excluded),
        (State::NothingToDo, 3, &first.excluded)
    );
    assert_eq!(content(&place.path("a.zarr")), before);
    let manifest = Manifest::read(&place.path("set.csv")).unwrap();
    let voxelize_into = |name: &str, settings: &VoxelizeSettings, start_anew| {
        let execution = Execution {
            start_anew,
            ..Execution::default()
        };
        voxelize(
            &manifest,
            Shard::WHOLE,
            settings,
            None,
            &place.path(name),
            &execution,
        )
    };
    let voxelize = |settings: &VoxelizeSettings, force| voxelize_into("a.zarr", settings, force);
    let other = VoxelizeSettings {
        seed: 1,
        ..settings()
    };
    assert!(
        voxelize(&other, false)
            .unwrap_err()
            .to_string()
            .contains("--force")
    );
    assert_eq!(voxelize(&other, true).unwrap().state, State::Written);
    assert_ne!(
        content(&place.path("a.zarr"))[Path::new("index/c/0")],
        before[Path::new("index/c/0")]
    );
    std::fs::write(place.path("one.pdb"), peptide(["GLY"; 5], 1.7)).unwrap();
    assert!(voxelize(&other, false).is_err(), "an input changed");
    std::fs::create_dir(place.path("folder")).unwrap();
    let refused = voxelize_into("folder", &other, true);
    assert!(
        refused.unwrap_err().to_string().contains("not a voxel set"),
        "a folder of the user's is not removed"
    );
}

#[test]
fn an_interrupted_run_goes_on_and_ends_as_if_it_had_not_been() {
    let place = Place::new();
    place.make("whole.zarr", Shard::WHOLE, &settings());
    let manifest = Manifest::read(&place.path("set.csv")).unwrap();
    let output = place.path("parts.zarr");
    let mut runs = 0;
    loop {
        // Stops after the first structure that gets done.
        let watcher = Watcher::stopping_after(1);
        let execution = watcher.execution();
        let report = voxelize(
            &manifest,
            Shard::WHOLE,
            &settings(),
            None,
            &output,
            &execution,
        )
        .unwrap();
        assert_eq!(
            report.taken_over as u64 + watcher.total.load(Ordering::Relaxed),
            8
        );
        runs += 1;
        match report.state {
            State::Stopped => assert!(report.samples >= runs && !output.exists()),
            _ => break,
        }
        if runs == 2 {
            // What a killed process may leave.
            let work = work_path(&output);
            let mut bytes = std::fs::read(&work).unwrap();
            bytes.extend([7; 30]);
            std::fs::write(&work, bytes).unwrap();
            std::fs::create_dir_all(place.path("parts.zarr.partial/index")).unwrap();
        }
    }
    assert!(runs > 1);
    assert_eq!(content(&output), content(&place.path("whole.zarr")));
    assert!(!place.path("parts.zarr.partial").exists());
}

#[test]
fn shards_join_to_what_one_run_makes() {
    let place = Place::new();
    let settings = VoxelizeSettings {
        channels: Channel::SINGLE.to_vec(),
        spacing: Spacing::Fit(Fit::Fit),
        ..settings()
    };
    let whole = place.make("whole.zarr", Shard::WHOLE, &settings);
    assert_eq!(whole.samples, 3, "{:?}", whole.excluded);
    let parts: Vec<PathBuf> = (1..=3)
        .map(|index| {
            let name = format!("part{index}.zarr");
            place.make(&name, Shard { index, of: 3 }, &settings);
            place.path(&name)
        })
        .collect();
    let joined = place.path("joined.zarr");
    let shuffled = [parts[2].clone(), parts[0].clone(), parts[1].clone()];
    let report = merge(&shuffled, &joined, false).unwrap();
    assert_eq!(
        (report.samples, report.excluded, report.nothing_to_do),
        (3, 5, false)
    );
    assert_eq!(content(&joined), content(&place.path("whole.zarr")));
    assert!(merge(&shuffled, &joined, false).unwrap().nothing_to_do);
    assert_eq!(
        place.make("joined.zarr", Shard::WHOLE, &settings).state,
        State::NothingToDo
    );
    let twice = merge(
        &[parts[0].clone(), parts[0].clone()],
        &place.path("b.zarr"),
        false,
    )
    .unwrap_err()
    .to_string();
    assert!(twice.contains("give each part once"), "{twice}");
    let other = place.make(
        "other.zarr",
        Shard { index: 1, of: 3 },
        &VoxelizeSettings {
            seed: 5,
            ..settings
        },
    );
    let unlike = merge(&[parts[0].clone(), other.set], &place.path("b.zarr"), false)
        .unwrap_err()
        .to_string();
    assert!(unlike.contains("different settings"), "{unlike}");
    assert!(
        ["0/3", "4/3", "3", "a/b", "1/0"]
            .iter()
            .all(|text| Shard::parse(text).is_err())
    );
}

#[test]
fn threads_do_not_change_the_set() {
    let place = Place::new();
    let settings = VoxelizeSettings {
        potential: PotentialModel::PoissonBoltzmann,
        ..settings()
    };
    for threads in [1, 3] {
        let pool = rayon_pool(threads);
        pool.install(|| place.make(&format!("{threads}.zarr"), Shard::WHOLE, &settings));
    }
    assert_eq!(
        content(&place.path("1.zarr")),
        content(&place.path("3.zarr"))
    );
}

#[test]
fn orientations_do_what_they_say() {
    let place = Place::new();
    let rotation = |name: &str, settings: &VoxelizeSettings| {
        place.make(name, Shard::WHOLE, settings);
        let set = VoxelSet::open(&place.path(name)).unwrap();
        (0..3)
            .map(|sample| set.reader().row(sample)[8..12].to_vec())
            .collect::<Vec<_>>()
    };
    let of = |orientation, seed| VoxelizeSettings {
        orientation,
        seed,
        ..settings()
    };
    let deposited = rotation("d.zarr", &of(Orientation::Deposited, 0));
    assert!(
        deposited
            .iter()
            .all(|quaternion| quaternion == &[1.0, 0.0, 0.0, 0.0])
    );
    let random = rotation("r0.zarr", &of(Orientation::Random, 0));
    assert!(random[0] != random[1] && random != rotation("r1.zarr", &of(Orientation::Random, 1)));
    assert_eq!(
        rotation("p0.zarr", &of(Orientation::Principal, 0)),
        rotation("p1.zarr", &of(Orientation::Principal, 9))
    );
}

#[test]
fn parts_that_are_missing_are_told() {
    let place = Place::new();
    let whole = place.make("whole.zarr", Shard::WHOLE, &settings());
    for index in 1..=3 {
        place.make(
            &format!("part{index}.zarr"),
            Shard { index, of: 3 },
            &settings(),
        );
    }
    let parts = |numbers: &[usize]| -> Vec<PathBuf> {
        numbers
            .iter()
            .map(|number| place.path(&format!("part{number}.zarr")))
            .collect()
    };
    let report = merge(&parts(&[3, 1]), &place.path("two.zarr"), false).unwrap();
    let missing = &report.missing[0];
    // Numbers 1, 4 and 7, counted from 0.
    assert_eq!(
        (missing.missing, missing.structures, report.missing.len()),
        (3, 8, 1)
    );
    assert_eq!(missing.parts, ["1/3", "3/3"]);
    // An incomplete set may be completed later, and is then that of one run.
    let rest = [place.path("two.zarr"), place.path("part2.zarr")];
    assert_eq!(
        merge(&rest, &place.path("all.zarr"), false)
            .unwrap()
            .missing,
        []
    );
    assert_eq!(content(&place.path("all.zarr")), content(&whole.set));
    let output = place.run("merge part1.zarr part2.zarr -o again.zarr --json");
    assert_eq!(output.status.code(), Some(1), "partial results");
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(
        said.contains("2 of 8 structures") && said.contains("the parts present are 1/3, 2/3"),
        "{said}"
    );
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(
        (
            &json["missing"][0]["missing"],
            &json["missing"][0]["structures"]
        ),
        (&json!(2), &json!(8))
    );
    // It is there all the same, and says so again.
    assert_eq!(
        place
            .run("merge part1.zarr part2.zarr -o again.zarr -q")
            .status
            .code(),
        Some(1)
    );
    assert_eq!(
        place
            .run("merge part1.zarr part2.zarr part3.zarr -o again.zarr --force -q")
            .status
            .code(),
        Some(0)
    );
}

#[test]
fn sets_of_several_manifests_follow_each_other_as_given() {
    let place = Place::new();
    let write = |name: &str, text: &str| std::fs::write(place.path(name), text).unwrap();
    let make = |rows: &str, output: &str| {
        write("set.csv", &format!("file,label,cluster,name\n{rows}"));
        place.make(output, Shard::WHOLE, &settings());
        place.path(output)
    };
    let a = make("one.pdb,x,k,a1\n", "a.zarr");
    let b = make("two.pdb,x,l,b1\nthree.pdb,x,l,b2\n", "b.zarr");
    let c = make("three.pdb,x,l,c1\nbroken.pdb,x,m,c2\n", "c.zarr");
    let d = make("two.pdb,x,l,d1\none.pdb,x,k,d2\n", "d.zarr");
    let merged = |inputs: &[&PathBuf], output: &str| {
        let inputs: Vec<PathBuf> = inputs.iter().map(|path| (*path).clone()).collect();
        assert_eq!(
            merge(&inputs, &place.path(output), false).unwrap().missing,
            []
        );
        place.path(output)
    };
    let names = |path: &Path| {
        let set = VoxelSet::open(path).unwrap();
        set.descriptions()
            .iter()
            .map(|known| known.name.clone())
            .collect::<Vec<_>>()
    };
    let (ab, dc) = (merged(&[&a, &b], "ab.zarr"), merged(&[&d, &c], "dc.zarr"));
    assert_eq!(
        (names(&ab), names(&dc)),
        (
            vec!["a1".into(), "b1".into(), "b2".into()],
            vec!["d1".into(), "d2".into(), "c1".into()]
        )
    );
    // Both have several manifests, which are not one.
    assert_eq!(
        names(&merged(&[&ab, &dc], "abdc.zarr")),
        ["a1", "b1", "b2", "d1", "d2", "c1"]
    );
    assert_eq!(
        names(&merged(&[&dc, &ab], "dcab.zarr")),
        ["d1", "d2", "c1", "a1", "b1", "b2"]
    );
    // In another order it is another set.
    assert!(
        merge(&[b, a], &ab, false)
            .unwrap_err()
            .to_string()
            .contains("--force")
    );
}
