//! Sets of voxel grids: made, interrupted, continued, joined, read; whatever the order and the
//! threads, the same files.

use crate::common::{Watcher, program};
use protomer_body::Draft;
use protomer_body::surface::ExactSurface;
use protomer_field::voxels::{Channel, Orientation, PotentialModel};
use protomer_learn::SampleSource;
use protomer_learn_verbs::voxels::body_store::BodyStore;
use protomer_learn_verbs::voxels::manifest::Manifest;
use protomer_learn_verbs::voxels::merge::merge;
use protomer_learn_verbs::voxels::samples::VoxelSet;
use protomer_learn_verbs::voxels::structure::Reason;
use protomer_learn_verbs::voxels::{
    Fit, Spacing, State, VoxelizeReport, VoxelizeSettings, voxelize, work_path,
};
use protomer_results::{Execution, FileRecord, Shard};
use serde_json::json;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Output;
use std::sync::Mutex;
use std::sync::atomic::Ordering;

/// Helices of five residues each, as PDB text: small, and enough to have a surface, charges and
/// hydropathy.
fn peptide(names: [&str; 5], turn: f64) -> String {
    let mut text = String::new();
    let mut serial = 1;
    for (number, name) in names.iter().enumerate() {
        for (atom, along, radius, angle) in [
            ("N", 0.0, 1.5, 0.0),
            ("CA", 0.9, 2.3, 0.5),
            ("C", 1.9, 1.7, 0.9),
            ("O", 2.2, 2.1, 1.5),
            ("CB", 0.6, 3.3, 0.9),
        ] {
            let angle = angle + turn * number as f64;
            let (x, y, z) = (
                radius * angle.cos(),
                radius * angle.sin(),
                along + 1.5 * number as f64,
            );
            text += &format!(
                "ATOM  {serial:>5}  {atom:<3} {name} A{:>4}    {x:8.3}{y:8.3}{z:8.3}  1.00  0.00           {}\n",
                number + 1,
                &atom[..1]
            );
            serial += 1;
        }
    }
    text + "END\n"
}

struct Place {
    folder: tempfile::TempDir,
}

impl Place {
    /// Six peptides, three of which cannot be used.
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let write =
            |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
        write("one.pdb", &peptide(["ALA"; 5], 1.7));
        write(
            "two.pdb",
            &peptide(["ALA", "GLY", "ALA", "ALA", "GLY"], 1.75),
        );
        write(
            "three.pdb",
            &peptide(["GLY", "ALA", "GLY", "ALA", "ALA"], 1.65),
        );
        let trace: Vec<&str> = peptide(["LYS"; 5], 1.7)
            .leak()
            .lines()
            .filter(|line| line.contains(" CA "))
            .collect();
        write("trace.pdb", &trace.join("\n"));
        write("broken.pdb", "ATOM      1  N   ALA A   1      xx.xxx\n");
        write(
            "water.pdb",
            "HETATM    1  O   HOH A   1       0.000   0.000   0.000  1.00  0.00           O\n",
        );
        let far = peptide(["ALA"; 5], 1.7)
            .replace("   1.500   0.000   0.000", "  91.500   0.000   0.000");
        write("far.pdb", &far);
        write(
            "set.csv",
            "file,label,cluster,family\none.pdb,\"P 1\",a,f\ntrace.pdb,x,b,\ntwo.pdb,y,a,\nbroken.pdb,x,c,\nwater.pdb,x,d,\n\
             missing.pdb,x,e,\nfar.pdb,x,g,\nthree.pdb,\"P 1\",h,\n",
        );
        Self { folder }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn make(&self, name: &str, shard: Shard, settings: &VoxelizeSettings) -> VoxelizeReport {
        let manifest = Manifest::read(&self.path("set.csv")).unwrap();
        let execution = Execution::default();
        voxelize(
            &manifest,
            shard,
            settings,
            None,
            &self.path(name),
            &execution,
        )
        .unwrap()
    }

    /// A manifest of these files in place of the six peptides, each of a cluster of its own.
    fn list(&self, files: &[String]) {
        let lines: String = files.iter().map(|file| format!("{file},x,\n")).collect();
        std::fs::write(self.path("set.csv"), format!("file,label,cluster\n{lines}")).unwrap();
    }

    /// The program.
    fn run(&self, words: &str) -> Output {
        let mut command = program(words.split_whitespace());
        command.current_dir(self.folder.path()).output().unwrap()
    }
}

/// One of the structures that the project comes with, gzipped, and its text.
fn bundled(name: &str) -> (Vec<u8>, String) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../../data/structures")
        .join(name);
    let text = protomer_common::input::InputFile::read(&path)
        .unwrap()
        .bytes;
    (
        std::fs::read(path).unwrap(),
        String::from_utf8(text).unwrap(),
    )
}

fn settings() -> VoxelizeSettings {
    VoxelizeSettings {
        size: 32,
        potential: PotentialModel::DebyeHueckel,
        most_incomplete: 0.3,
        ..Default::default()
    }
}

/// All files of a folder with their content.
fn content(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut found = BTreeMap::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(next) = folders.pop() {
        for entry in next.read_dir().unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else {
                found.insert(
                    path.strip_prefix(folder).unwrap().to_owned(),
                    std::fs::read(path).unwrap(),
                );
            }
        }
    }
    found
}

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
        channels: Channel::ALL.to_vec(),
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

fn rayon_pool(threads: usize) -> rayon::ThreadPool {
    rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .unwrap()
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
fn a_damaged_file_is_named_with_its_samples() {
    let place = Place::new();
    place.make("a.zarr", Shard::WHOLE, &settings());
    let file = place.path("a.zarr/potential/c/0");
    let bytes = std::fs::read(&file).unwrap();
    std::fs::write(&file, &bytes[..bytes.len() / 2]).unwrap();
    let message = VoxelSet::open(&place.path("a.zarr"))
        .unwrap()
        .voxels(1)
        .unwrap_err()
        .to_string();
    assert!(
        message.contains("a.zarr/potential/c/0") && message.contains("one to three"),
        "{message}"
    );
}

#[test]
fn a_structure_that_was_cut_in_half_is_never_a_silent_sample() {
    let place = Place::new();
    let settings = VoxelizeSettings {
        size: 48,
        spacing: Spacing::Angstrom(2.0),
        ..settings()
    };
    let mut files = Vec::new();
    for ((zipped, whole), ending) in [
        (bundled("4e43.pdb.gz"), "pdb"),
        (bundled("5pti.cif.gz"), "cif"),
    ] {
        let first = whole.find("\nATOM ").unwrap() + 1;
        let last = whole.rfind("\nHETATM").unwrap();
        let after_a_line = |at: usize| at + whole[at..].find('\n').unwrap() + 1;
        let middle = after_a_line((first + last) / 2);
        let mut cuts: Vec<usize> = (1..=5)
            .map(|part| first + part * (last - first) / 6)
            .collect();
        // Between two lines, with and without the end of the one before, and at each place of the
        // next line.
        cuts.extend([middle - 1, middle]);
        cuts.extend(
            (1..after_a_line(middle) - middle)
                .step_by(3)
                .map(|within| middle + within),
        );
        for cut in cuts {
            let name = format!("cut{cut}.{ending}");
            std::fs::write(place.path(&name), &whole[..cut]).unwrap();
            files.push(name);
        }
        for part in [1, 2, 3] {
            let name = format!("zipped{part}{ending}.{ending}.gz");
            std::fs::write(place.path(&name), &zipped[..part * zipped.len() / 4]).unwrap();
            files.push(name);
        }
    }
    place.list(&files);
    let report = place.make("a.zarr", Shard::WHOLE, &settings);
    assert_eq!(
        (report.samples, report.excluded.len()),
        (0, files.len()),
        "{:?}",
        report.warnings
    );
    let count = |reason| {
        report
            .excluded
            .iter()
            .filter(|excluded| excluded.reason == reason)
            .count()
    };
    assert!(
        count(Reason::Truncated) > 5 && count(Reason::Unreadable) > 5,
        "{:?}",
        report.excluded
    );
    assert_eq!(
        count(Reason::Truncated) + count(Reason::Unreadable),
        files.len()
    );
    let zipped = report
        .excluded
        .iter()
        .filter(|excluded| excluded.row.file.ends_with(".gz"));
    assert!(
        zipped.clone().count() == 6
            && zipped
                .clone()
                .all(|excluded| excluded.detail.contains("damaged or truncated"))
    );
}

#[test]
fn a_file_by_hand_without_an_end_is_a_sample_with_a_warning() {
    let place = Place::new();
    let whole = peptide(["ALA"; 5], 1.7);
    let atoms = whole.strip_suffix("END\n").unwrap();
    let write = |name: &str, text: &str| std::fs::write(place.path(name), text).unwrap();
    write("bare.pdb", atoms);
    write("open.pdb", atoms.trim_end());
    write("whole.pdb", &whole);
    write("within.pdb", &atoms[..atoms.len() - 40]);
    write("digits.pdb", &atoms[..atoms.len() - 28]);
    let pqr: String = atoms
        .lines()
        .map(|line| format!("{}  {:>8.4} {:>7.4}\n", &line[..54], 0.1, 1.7))
        .collect();
    write("bare.pqr", &pqr);
    write("within.pqr", pqr.strip_suffix("00\n").unwrap());
    write(
        "set.csv",
        "file,label,cluster,name\nbare.pdb,x,,bare\nopen.pdb,x,,open\nwhole.pdb,x,,whole\nwithin.pdb,x,,within\n\
                      digits.pdb,x,,digits\nbare.pqr,x,,pqr\nwithin.pqr,x,,within_pqr\n",
    );
    let report = place.make("a.zarr", Shard::WHOLE, &settings());
    let reasons: Vec<(&str, Reason)> = report
        .excluded
        .iter()
        .map(|e| (e.row.name.as_str(), e.reason))
        .collect();
    let [within, digits] = [
        ("within", Reason::Unreadable),
        ("digits", Reason::Truncated),
    ];
    assert_eq!(
        reasons,
        [within, digits, ("within_pqr", Reason::Truncated)],
        "{:?}",
        report.excluded
    );
    let warned: Vec<&str> = report.warnings.keys().map(String::as_str).collect();
    assert_eq!(warned, ["bare", "open", "pqr"]);
    assert!(
        report
            .warnings
            .values()
            .all(|of| of[0].contains("no mark of its end")),
        "{:?}",
        report.warnings
    );
}

#[test]
fn nucleotides_are_no_amino_acids() {
    let place = Place::new();
    let line = |number: usize, name: &str| {
        format!(
            "ATOM {number} P {name} {number} {}.0 0.0 0.0 -1.0 1.9\n",
            3 * number
        )
    };
    let rna: String = ["A", "C", "G", "A"]
        .iter()
        .enumerate()
        .map(|(number, name)| line(number + 1, name))
        .collect();
    std::fs::write(place.path("rna.pqr"), format!("{rna}END\n")).unwrap();
    std::fs::write(
        place.path("mixed.pqr"),
        format!("\u{feff}{rna}{}END\n", line(5, "ALA")),
    )
    .unwrap();
    place.list(&["rna.pqr".into(), "mixed.pqr".into()]);
    let report = place.make("a.zarr", Shard::WHOLE, &settings());
    assert_eq!(
        (report.samples, report.excluded[0].reason),
        (1, Reason::NoProtein),
        "{:?}",
        report.excluded
    );
    let set = VoxelSet::open(&place.path("a.zarr")).unwrap();
    assert_eq!(
        (
            set.descriptions()[0].residues,
            set.descriptions()[0].composition[0]
        ),
        (1.0, 1.0)
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

#[test]
fn relatives_in_several_clusters_are_told() {
    let place = Place::new();
    std::fs::copy(place.path("one.pdb"), place.path("copy.pdb")).unwrap();
    std::fs::write(
        place.path("set.csv"),
        "file,label,cluster,family\none.pdb,x,a,\ncopy.pdb,x,b,\ntwo.pdb,y,c,f\nthree.pdb,y,d,f\n",
    )
    .unwrap();
    let report = place.make("a.zarr", Shard::WHOLE, &settings());
    assert_eq!(
        report.manifest_warnings.len(),
        2,
        "{:?}",
        report.manifest_warnings
    );
    let said = report.manifest_warnings.join("\n");
    assert!(
        said.contains("'one' and 'copy'") && said.contains("the family 'f'"),
        "{said}"
    );
    // Parts that each have one of them do not see it; where they meet it is seen.
    let parts: Vec<PathBuf> = (1..=2)
        .map(|index| {
            place.make(
                &format!("{index}.zarr"),
                Shard { index, of: 2 },
                &settings(),
            )
        })
        .inspect(|part| assert_eq!(part.manifest_warnings, [""; 0]))
        .map(|part| part.set)
        .collect();
    assert_eq!(
        merge(&parts, &place.path("b.zarr"), false)
            .unwrap()
            .manifest_warnings,
        report.manifest_warnings
    );
    let output = place.run("voxelize --manifest set.csv -o c.zarr --size 32 --channels shape");
    assert_eq!(output.status.code(), Some(0));
    assert!(
        String::from_utf8_lossy(&output.stderr)
            .contains("warning: 'one' and 'copy' are in different clusters")
    );
}

#[test]
fn a_run_without_a_single_sample_has_failed() {
    let place = Place::new();
    place.list(&["broken.pdb".into(), "missing.pdb".into()]);
    for words in ["-q", "--json -q"] {
        let output = place.run(&format!(
            "voxelize --manifest set.csv -o a.zarr --size 32 --channels shape {words}"
        ));
        assert_eq!(output.status.code(), Some(1), "{words}");
        let said = String::from_utf8(output.stderr).unwrap();
        assert!(
            said.contains("none of the 2 structures could be used") && said.contains("'excluded'"),
            "{said}"
        );
    }
    let set = VoxelSet::open(&place.path("a.zarr")).unwrap();
    assert_eq!(
        set.reader().attributes()["excluded"]
            .as_array()
            .unwrap()
            .len(),
        2,
        "the report is there"
    );
    // A part may be without samples; all parts together may not.
    for part in [1, 2] {
        let words = format!(
            "voxelize --manifest set.csv -o {part}.zarr --shard {part}/2 --size 32 --channels shape -q"
        );
        assert_eq!(place.run(&words).status.code(), Some(0));
    }
    let output = place.run("merge 1.zarr 2.zarr -o b.zarr -q");
    assert_eq!(output.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&output.stderr).contains("has no samples"));
}

/// The rows of a table that say `ok`.
fn good_rows(table: &Path) -> Vec<String> {
    let text = std::fs::read_to_string(table).unwrap();
    let rows = text.lines().filter(|row| row.contains(",ok,"));
    rows.map(|row| row.replace("ingested/", "made/")).collect()
}

/// The slow twin: voxels and bodies one after the other.
#[test]
fn bodies_on_the_way_are_those_of_ingest_and_the_set_is_the_same() {
    let place = Place::new();
    let set = "voxelize --manifest set.csv --size 32 --most-incomplete 0.3 -o";
    let both = place.run(&format!("{set} both.zarr --bodies made --density 0.3"));
    assert!(both.status.success(), "{both:?}");
    assert!(place.run(&format!("{set} alone.zarr")).status.success());
    place.run("ingest --stream one.pdb two.pdb far.pdb three.pdb --density 0.3 -o ingested");
    assert_eq!(
        content(&place.path("both.zarr")),
        content(&place.path("alone.zarr"))
    );
    // The one that does not fit the grid has a body too.
    for name in ["one", "two", "far", "three"] {
        let [made, ingested] = ["made", "ingested"]
            .map(|folder| std::fs::read(place.path(&format!("{folder}/{name}.body"))).unwrap());
        assert!(made == ingested, "{name}");
    }
    let [made, ingested] =
        ["made", "ingested"].map(|folder| good_rows(&place.path(&format!("{folder}/ingest.csv"))));
    assert_eq!((made.len(), &made), (4, &ingested));
    let warnings = std::fs::read_to_string(place.path("made/warnings.csv")).unwrap();
    let errors = warnings.lines().filter(|line| line.contains(",error,"));
    assert_eq!(errors.count(), 4, "{warnings}");

    let again = place.run(&format!("{set} both.zarr --bodies made --density 0.3"));
    assert!(again.status.success(), "{again:?}");
    let late = place.run(&format!("{set} alone.zarr --bodies late"));
    let told = String::from_utf8(late.stderr).unwrap();
    assert!(told.contains("'protomer ingest'"), "{told}");
    assert!(!place.path("late").exists());
    let told = String::from_utf8(both.stderr).unwrap();
    assert!(told.contains("for 4 of 8 structures"), "{told}");
    let taken = place.run(&format!("{set} other.zarr --bodies ingested"));
    let told = String::from_utf8(taken.stderr).unwrap();
    assert!(
        !taken.status.success() && told.contains("--stream"),
        "{told}"
    );
    std::fs::write(
        place.path("paths.csv"),
        "file,label,cluster,name\none.pdb,x,a,../one\n",
    )
    .unwrap();
    let escaping = place.run("voxelize --manifest paths.csv -o paths.zarr --bodies paths");
    let told = String::from_utf8(escaping.stderr).unwrap();
    assert!(told.contains("'../one'"), "{told}");
    let wrong = place.run(&format!("{set} wrong.zarr --bodies wrong --density -1"));
    assert!(!wrong.status.success() && !place.path("wrong").exists());
}

/// Keeps nothing, and counts.
#[derive(Default)]
struct Counting {
    kept: Mutex<Vec<String>>,
    finished: Mutex<Vec<String>>,
}

impl BodyStore for Counting {
    fn density_per_angstrom2(&self) -> f64 {
        0.3
    }

    fn keep(&self, file: &Path, _: Draft, _: ExactSurface) -> anyhow::Result<FileRecord> {
        let file = file.file_name().unwrap().to_string_lossy().into_owned();
        self.kept.lock().unwrap().push(file.clone());
        Ok(FileRecord {
            row: vec!["ok".into()],
            file,
            warnings: Vec::new(),
            error: None,
        })
    }

    fn failed(&self, file: &Path, error: &anyhow::Error) -> FileRecord {
        FileRecord {
            file: file.file_name().unwrap().to_string_lossy().into_owned(),
            row: vec!["failed".into()],
            warnings: Vec::new(),
            error: Some(error.to_string()),
        }
    }

    fn finish(
        &self,
        records: &mut dyn Iterator<Item = anyhow::Result<FileRecord>>,
    ) -> anyhow::Result<()> {
        for record in records {
            self.finished.lock().unwrap().push(record?.file);
        }
        Ok(())
    }
}

#[test]
fn bodies_of_a_run_that_was_continued_are_made_once_and_told_in_order() {
    let place = Place::new();
    let manifest = Manifest::read(&place.path("set.csv")).unwrap();
    let (output, store) = (place.path("set.zarr"), Counting::default());
    loop {
        let watcher = Watcher::stopping_after(1);
        let execution = watcher.execution();
        let pool = rayon_pool(1);
        let report = pool.install(|| {
            let bodies = Some(&store as &dyn BodyStore);
            voxelize(
                &manifest,
                Shard::WHOLE,
                &settings(),
                bodies,
                &output,
                &execution,
            )
            .unwrap()
        });
        if report.state == State::Written {
            break;
        }
        assert!(store.finished.lock().unwrap().is_empty());
    }
    let mut kept = store.kept.into_inner().unwrap();
    kept.sort();
    assert_eq!(kept, ["far.pdb", "one.pdb", "three.pdb", "two.pdb"]);
    let expected = [
        "one.pdb",
        "trace.pdb",
        "two.pdb",
        "broken.pdb",
        "water.pdb",
        "missing.pdb",
        "far.pdb",
        "three.pdb",
    ];
    assert_eq!(store.finished.into_inner().unwrap(), expected);
}

/// Poses of two bodies: each is a sample, cropped to its contact, and the pose itself is in its identity.
#[test]
fn poses_of_two_bodies_become_samples() {
    let place = Place::new();
    let poses = [
        ("touching", "0,0,6.5,1,0,0,0"),
        ("again", "0,0,6.5,1,0,0,0"),
        ("turned", "0,0,6.5,0,1,0,0"),
        ("apart", "0,0,90,1,0,0,0"),
    ];
    let heading = "file,partner,label,cluster,name,x_angstrom,y_angstrom,z_angstrom,qw,qx,qy,qz\n";
    let rows = poses.map(|(name, pose)| format!("one.pdb,two.pdb,x,one-two,{name},{pose}\n"));
    let manifest = place.path("poses.csv");
    std::fs::write(&manifest, heading.to_owned() + &rows.concat()).unwrap();
    let words = |output: &str, threads: usize| {
        let flags = "--size 24 --spacing 1 --potential debye-hueckel --orientation deposited";
        let line = format!("voxelize --manifest poses.csv -o {output} {flags} -q -j {threads}");
        let mut command = program(line.split_whitespace());
        command.current_dir(place.folder.path()).output().unwrap()
    };
    let made = words("poses.zarr", 1);
    assert!(
        made.status.success(),
        "{}",
        String::from_utf8_lossy(&made.stderr)
    );
    assert!(words("again.zarr", 3).status.success());
    assert_eq!(
        content(&place.path("poses.zarr")),
        content(&place.path("again.zarr"))
    );

    let set = VoxelSet::open(&place.path("poses.zarr")).unwrap();
    let channels = [
        "shape",
        "potential",
        "hydropathy",
        "partner_shape",
        "partner_potential",
        "partner_hydropathy",
    ];
    assert_eq!(set.channels(), channels);
    let names: Vec<&str> = set
        .descriptions()
        .iter()
        .map(|known| &*known.name)
        .collect();
    assert_eq!(
        names,
        ["touching", "again", "turned"],
        "bodies apart have no interface"
    );
    let grids: Vec<_> = (0..3).map(|sample| set.voxels(sample).unwrap()).collect();
    // One pose under two names, in the frame of the file: the same voxels.
    assert_eq!(grids[0], grids[1]);
    assert_ne!(grids[0], grids[2]);
    for grid in &grids {
        let count = grid.index.len();
        for body in [0, 3] {
            let shape = &grid.values[body * count..(body + 1) * count];
            let potential = &grid.values[(body + 1) * count..(body + 2) * count];
            assert!(shape.iter().sum::<f32>() > 30.0);
            let on_shell = shape.iter().zip(potential);
            assert!(
                on_shell
                    .clone()
                    .any(|(shape, value)| *shape == 1.0 && *value != 0.0)
            );
            assert!(
                on_shell
                    .clone()
                    .all(|(shape, value)| *shape == 1.0 || *value == 0.0)
            );
        }
    }
    // Poses of one complex differ in their hashes, or a training could not tell them apart.
    assert_ne!(set.file_sha256(0), set.file_sha256(2));

    for (text, flags, expected) in [
        (
            "file,label,cluster,qw\none.pdb,x,c,1\n",
            "",
            "add a column 'partner'",
        ),
        (
            "file,partner,label,cluster\none.pdb,,x,c\n",
            "",
            "column partner: the cell is empty",
        ),
        (
            "file,partner,label,cluster,qw\none.pdb,two.pdb,x,c,1\n",
            "",
            "column x_angstrom: '' is not a number",
        ),
        (
            "file,partner,label,cluster\none.pdb,two.pdb,x,c\n",
            "--channels solid",
            "of one body alone",
        ),
        (
            "file,label,cluster\none.pdb,x,c\n",
            "--channels partner_shape",
            "column 'partner'",
        ),
        (
            "file,label,cluster\none.pdb,x,c\n",
            "--interface-reach 5",
            "is for interfaces",
        ),
    ] {
        std::fs::write(place.path("bad.csv"), text).unwrap();
        let line = format!("voxelize --manifest bad.csv -o bad.zarr --size 24 {flags}");
        let mut command = program(line.split_whitespace());
        let refused = command.current_dir(place.folder.path()).output().unwrap();
        let said = String::from_utf8_lossy(&refused.stderr).into_owned();
        assert!(
            !refused.status.success() && said.contains(expected),
            "{said}"
        );
    }
}

/// The exit code on request, where structures are left out.
#[test]
fn strict_runs_fail_where_structures_are_left_out() {
    let place = Place::new();
    let run = |flags: &str| {
        let line = format!(
            "voxelize --manifest set.csv -o set.zarr --size 24 --channels shape -q {flags}"
        );
        let mut command = program(line.split_whitespace());
        let output = command.current_dir(place.folder.path()).output().unwrap();
        output.status.code()
    };
    assert_eq!(run(""), Some(0));
    // The set is there already, and the answer is the same.
    assert_eq!(run("--strict"), Some(1));
    assert_eq!(run("--strict --force"), Some(1));
    assert!(place.path("set.zarr").exists());
}
