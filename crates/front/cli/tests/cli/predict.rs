//! Trained networks applied to sets: the training's own set, another one, a damaged one, and
//! directories that hold none.

use crate::common::{is_ok, program};
use anyhow::Result;
use protomer_field::voxels::Voxels;
use protomer_learn::controls::{Control, Form, Variant};
use protomer_learn::{InMemory, SparseGrid};
use protomer_learn_verbs::learning::train::TrainSettings;
use protomer_learn_verbs::voxels::VoxelizeSettings;
use protomer_learn_verbs::voxels::attributes::Making;
use protomer_learn_verbs::voxels::content::Content;
use protomer_learn_verbs::voxels::records::Exclusion;
use protomer_learn_verbs::voxels::row::Row;
use protomer_learn_verbs::voxels::set;
use protomer_learn_verbs::voxels::structure::Properties;
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

const SIZE: usize = 16;

struct Place {
    folder: tempfile::TempDir,
}

impl Place {
    /// With `set.zarr`: charged blobs, some of them relatives, and a few of a class too rare to be
    /// one.
    fn new() -> Self {
        let place = Self {
            folder: tempfile::tempdir().unwrap(),
        };
        place.write_set("set.zarr", 90, 1, &settings());
        place
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn run(&self, words: &str) -> Output {
        let mut command = program(words.split_whitespace());
        command.current_dir(self.folder.path()).output().unwrap()
    }

    fn train(&self, words: &str) {
        let flags =
            "--least-samples 8 --widths 4 --groups 0 --permutations 20 --fractions 0.5,0.2,0.3 -q";
        let epochs = if words.contains("--epochs") {
            ""
        } else {
            "--epochs 3"
        };
        let flags = format!("{flags} {epochs}");
        is_ok(&self.run(&format!("train set.zarr {flags} {words}")));
    }

    /// What a prediction prints as JSON.
    fn predict(&self, words: &str) -> Value {
        let output = self.run(&format!("predict {words} --json -q"));
        is_ok(&output);
        serde_json::from_slice(&output.stdout).unwrap()
    }

    /// What a prediction complains of.
    fn complaint(&self, words: &str) -> String {
        let output = self.run(&format!("predict {words} -o refused.csv"));
        assert_eq!(output.status.code(), Some(1), "{words}");
        assert!(!self.path("refused.csv").exists(), "{words}");
        String::from_utf8_lossy(&output.stderr).into_owned()
    }

    fn write_set(&self, name: &str, samples: usize, seed: u64, settings: &VoxelizeSettings) {
        let mut set = Control::Charge.samples(Variant::Usual, samples, SIZE, seed);
        for (number, known) in set.descriptions.iter_mut().enumerate() {
            if number % 15 == 7 {
                known.label = "rare".into();
            }
        }
        self.write(name, set, seed, settings);
    }

    /// A set whose labels are the net charges, but for one that is no number.
    fn write_numbers(&self, name: &str, samples: usize, seed: u64) {
        let mut set = Control::Charge.samples(Variant::Usual, samples, SIZE, seed);
        for known in &mut set.descriptions {
            known.label = known.net_charge_e.to_string();
        }
        set.descriptions[3].label = "unknown".into();
        self.write(name, set, seed, &settings());
    }

    fn write(&self, name: &str, set: InMemory, seed: u64, settings: &VoxelizeSettings) {
        let drawn = Drawn {
            seed,
            set,
            warnings: BTreeMap::new(),
        };
        let making = Making {
            settings,
            origins: &[],
            identity: name,
        };
        std::fs::create_dir(self.path(name)).unwrap();
        set::write(&self.path(name), making, &drawn).unwrap();
    }
}

/// Drawn samples as the content of a set.
struct Drawn {
    seed: u64,
    set: InMemory,
    warnings: BTreeMap<String, Vec<String>>,
}

impl Content for Drawn {
    fn len(&self) -> usize {
        self.set.grids.len()
    }

    fn voxels(&self) -> u64 {
        let grids = self.set.grids.iter();
        grids.map(|grid| grid.index.len() as u64).sum()
    }

    fn row(&self, number: usize) -> Result<Row> {
        let known = &self.set.descriptions[number];
        Ok(Row {
            entry: number,
            name: known.name.clone(),
            file: format!("{}.pdb", known.name),
            label: known.label.clone(),
            cluster: format!("{} {}", self.seed, known.cluster),
            family: if number.is_multiple_of(4) {
                format!("family {}", number / 12)
            } else {
                String::new()
            },
            sha256: file(self.seed, number),
        })
    }

    fn sample(&self, number: usize) -> Result<(Properties, Voxels)> {
        let known = &self.set.descriptions[number];
        let properties = Properties {
            residues: known.residues as usize,
            radius_of_gyration_angstrom: known.radius_of_gyration_angstrom,
            extents_angstrom: known.extents_angstrom,
            net_charge_e: known.net_charge_e,
            spacing_angstrom: 1.0,
            rotation_wxyz: [1.0, 0.0, 0.0, 0.0],
            middle_angstrom: [0.0; 3],
            composition: known.composition,
        };
        let SparseGrid { index, values, .. } = &self.set.grids[number];
        let voxels = Voxels {
            index: index.clone(),
            values: values.chunks(index.len()).map(<[f32]>::to_vec).collect(),
        };
        Ok((properties, voxels))
    }

    fn excluded(&self) -> &[Exclusion] {
        &[]
    }

    fn warnings(&self) -> &BTreeMap<String, Vec<String>> {
        &self.warnings
    }
}

/// What stands for the hash of a structure's file.
fn file(seed: u64, number: usize) -> String {
    format!("{seed:032x}{number:032x}")
}

fn settings() -> VoxelizeSettings {
    VoxelizeSettings {
        size: SIZE,
        ..VoxelizeSettings::default()
    }
}

fn copy(from: &Path, to: &Path) {
    let status = Command::new("cp")
        .arg("-r")
        .args([from, to])
        .status()
        .unwrap();
    assert!(status.success());
}

fn json(path: &Path) -> Value {
    serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap()
}

/// The same forward pass and scaling: not a digit differs, although the samples come in other
/// batches.
#[test]
fn on_the_set_of_the_training_the_test_part_has_the_scores_of_the_training() {
    let place = Place::new();
    for (run, flags) in [
        ("usual", ""),
        (
            "turned",
            "--rotations --channels potential --scaling box-standardised",
        ),
    ] {
        place.train(&format!("{flags} -o {run}"));
        let metrics = json(&place.path(run).join("metrics.json"));
        assert_eq!(
            metrics["classes"],
            serde_json::json!(["negative", "positive", "other"])
        );
        let report = place.predict(&format!("{run} set.zarr"));
        assert_eq!(report["is_training_set"], true);
        assert_eq!(report["scores"]["samples"], metrics["samples"]["test"]);
        for key in [
            "accuracy",
            "majority_accuracy",
            "balanced_accuracy",
            "log_loss_nats",
            "prior_log_loss_nats",
            "nats_gained_over_prior",
        ] {
            assert!(metrics[key].is_f64(), "{key}");
            // The prior goes through its logarithm.
            let tolerance = if key.contains("prior") { 1e-12 } else { 0.0 };
            let (predicted, trained) = (
                report["scores"][key].as_f64().unwrap(),
                metrics[key].as_f64().unwrap(),
            );
            assert!(
                (predicted - trained).abs() <= tolerance,
                "{run} {key}: {predicted} {trained}"
            );
        }
        let samples = report["samples"].as_array().unwrap();
        assert_eq!(samples.len(), 90);
        let count = |part: &str| {
            samples
                .iter()
                .filter(|sample| sample["part"] == part)
                .count() as u64
        };
        for part in ["training", "validation", "test"] {
            assert_eq!(
                Some(count(part)),
                metrics["samples"][part].as_u64(),
                "{part}"
            );
        }
        // Row by row as well: both write a number with all the digits that tell it from others.
        let predictions = std::fs::read_to_string(place.path(run).join("predictions.csv")).unwrap();
        let csv =
            String::from_utf8(place.run(&format!("predict {run} set.zarr -q")).stdout).unwrap();
        assert_eq!(
            csv.lines().next(),
            Some("name,file,label,class,part,predicted,p_negative,p_positive,p_other")
        );
        for row in predictions.lines().skip(1) {
            let [name, _, class, rest] = row.splitn(4, ',').collect::<Vec<_>>()[..] else {
                panic!("{row}")
            };
            let label = if class == "other" { "rare" } else { class };
            let expected = format!("{name},{name}.pdb,{label},{class},test,{rest}");
            assert!(csv.lines().any(|line| line == expected), "{expected}");
        }
    }
}

/// A predicted number is the mean over the classes; `predict` finds the scores of the training again, and
/// scores another set.
#[test]
fn numbers_are_predicted_and_scored() {
    let place = Place {
        folder: tempfile::tempdir().unwrap(),
    };
    place.write_numbers("set.zarr", 90, 1);
    place.train("--target number --number-classes 4 -o run");
    let metrics = json(&place.path("run/metrics.json"));
    assert_eq!(metrics["quarantined"].as_array().unwrap().len(), 1);
    let numbers = &metrics["numbers"];
    let list = |value: &Value| -> Vec<f64> {
        let numbers = value.as_array().unwrap().iter();
        numbers.map(|number| number.as_f64().unwrap()).collect()
    };
    let (bounds, means) = (
        list(&numbers["classes"]["bounds"]),
        list(&numbers["classes"]["means"]),
    );
    assert_eq!((bounds.len(), means.len()), (3, 4));
    for (class, bound) in bounds.iter().enumerate() {
        assert!(means[class] < *bound && *bound <= means[class + 1]);
    }
    let table = std::fs::read_to_string(place.path("run/predictions.csv")).unwrap();
    let mut rows = table.lines();
    let heading = rows.next().unwrap();
    assert!(heading.starts_with("name,cluster,label,predicted,number,predicted_number,p_below "));
    for row in rows {
        let cells: Vec<&str> = row.split(',').collect();
        let values: Vec<f64> = cells[4..]
            .iter()
            .map(|cell| cell.parse().unwrap())
            .collect();
        let class = bounds.iter().filter(|bound| **bound <= values[0]).count();
        assert_eq!(metrics["classes"][class], cells[2]);
        let expected: f64 = means.iter().zip(&values[2..]).map(|(m, p)| m * p).sum();
        assert!((values[1] - expected).abs() < 1e-9, "{row}");
    }
    assert!(place.path("run/predicted_numbers.svg").exists());

    is_ok(&place.run("report run -q"));
    let page = std::fs::read_to_string(place.path("run/report.html")).unwrap();
    assert!(page.contains("variance explained") && page.contains("mean of the training part"));

    let report = place.predict("run set.zarr");
    for key in [
        "rms_error",
        "mean_absolute_error",
        "variance_explained",
        "rank_correlation",
    ] {
        let trained = numbers["scores"][key].as_f64().unwrap();
        let found = report["scores"]["numbers"][key].as_f64().unwrap();
        assert!((found - trained).abs() < 1e-9, "{key}: {found} {trained}");
    }
    place.write_numbers("other.zarr", 40, 5);
    let report = place.predict("run other.zarr");
    assert_eq!(report["scores"]["samples"], 39);
    assert!(report["scores"]["numbers"]["rms_error"].as_f64().unwrap() > 0.0);
    let unknown = &report["samples"][3];
    assert_eq!(unknown["unscored"], "no-class");
    assert!(unknown["class"].is_null() && unknown["predicted_number"].is_f64());

    // Labels that are no numbers, and classes without numbers.
    place.write_set("words.zarr", 30, 7, &settings());
    for (words, expected) in [
        (
            "words.zarr --target number",
            "none of the 30 samples has a number",
        ),
        ("set.zarr --number-classes 4", "add --target number"),
        // Another target than the configuration's has no use for its number of classes.
        (
            "set.zarr --config run/settings.toml --target label --least-samples 200",
            "two are needed",
        ),
        (
            "set.zarr --target number --number-classes 1",
            "give 2 to 100",
        ),
    ] {
        let refused = place.run(&format!("train {words} -o refused"));
        let said = String::from_utf8_lossy(&refused.stderr).into_owned();
        assert!(
            !refused.status.success() && said.contains(expected),
            "{said}"
        );
        assert!(!place.path("refused").exists());
    }
}

#[test]
fn another_set_has_no_parts_and_only_labels_that_are_classes() {
    let place = Place::new();
    place.train("-o run");
    let conditions = VoxelizeSettings {
        salt_molar: 0.5,
        seed: 9,
        ..settings()
    };
    place.write_set("other.zarr", 70, 5, &conditions);
    let report = place.predict("run other.zarr");
    assert_eq!(report["is_training_set"], false);
    let samples = report["samples"].as_array().unwrap();
    assert_eq!(
        (samples.len(), &report["left_out"]),
        (70, &serde_json::json!([]))
    );
    for sample in samples {
        assert!(sample["part"].is_null());
        let class = if sample["label"] == "rare" {
            &Value::Null
        } else {
            &sample["label"]
        };
        assert_eq!(
            &sample["class"], class,
            "a class that was joined with others in the training is not known here"
        );
        let p: Vec<f64> = sample["probabilities"]
            .as_array()
            .unwrap()
            .iter()
            .map(|p| p.as_f64().unwrap())
            .collect();
        assert!((p.iter().sum::<f64>() - 1.0).abs() < 1e-9);
    }
    let rare = samples
        .iter()
        .filter(|sample| sample["label"] == "rare")
        .count() as u64;
    assert_eq!(report["scores"]["samples"].as_u64(), Some(70 - rare));
    // The seed of the rotations is no condition.
    let difference = serde_json::json!([{"setting": "salt_molar", "trained_on": 0.15, "set": 0.5}]);
    assert_eq!(report["differences"], difference);
    let said = String::from_utf8(place.run("predict run other.zarr").stderr).unwrap();
    assert!(
        said.contains("salt_molar: 0.5 here, 0.15 in the training"),
        "{said}"
    );
    // A set that was moved is still that of the training.
    std::fs::rename(place.path("set.zarr"), place.path("moved.zarr")).unwrap();
    assert_eq!(place.predict("run moved.zarr")["is_training_set"], true);
}

/// The same structures in another set: made anew, they are as well known to the network as before.
#[test]
fn what_training_has_seen_is_not_scored_in_another_set_either() {
    let place = Place::new();
    place.train("-o run");
    // Turned otherwise: another set, of the same files and clusters.
    place.write_set(
        "turned.zarr",
        90,
        1,
        &VoxelizeSettings {
            seed: 9,
            ..settings()
        },
    );
    let seen = json(&place.path("run/trained_on.json"));
    let metrics = json(&place.path("run/metrics.json"));
    let count = |part: &str| seen[part].as_array().unwrap().len() as u64;
    assert_eq!(
        Some(count("training")),
        metrics["samples"]["training"].as_u64()
    );
    assert_eq!(
        Some(count("validation")),
        metrics["samples"]["validation"].as_u64()
    );
    let report = place.predict("run turned.zarr");
    assert_eq!(report["is_training_set"], false);
    let parts = place.predict("run set.zarr");
    let pairs = || {
        report["samples"]
            .as_array()
            .unwrap()
            .iter()
            .zip(parts["samples"].as_array().unwrap())
    };
    for (turned, own) in pairs().filter(|(turned, _)| turned["label"] != "rare") {
        let expected = if own["part"] == "test" {
            Value::Null
        } else {
            "same-file".into()
        };
        assert_eq!(turned["unscored"], expected, "{turned}");
    }
    let scored = pairs()
        .filter(|(turned, own)| own["part"] == "test" && turned["label"] != "rare")
        .count();
    assert_eq!(report["scores"]["samples"].as_u64(), Some(scored as u64));
    let said = String::from_utf8(place.run("predict run turned.zarr").stderr).unwrap();
    assert!(
        said.contains("whose file was in the training or validation part"),
        "{said}"
    );
    let total: u64 = report["not_scored"]
        .as_array()
        .unwrap()
        .iter()
        .map(|part| part["samples"].as_u64().unwrap())
        .sum();
    assert_eq!(total + scored as u64, 90);

    // Other files, of which some are of clusters that were trained on.
    let moved: Vec<Value> = seen["training"]
        .as_array()
        .unwrap()
        .iter()
        .map(|sample| {
            let mut other = sample.clone();
            other["sha256"] = "0".into();
            other
        })
        .collect();
    let others = serde_json::json!({"training": moved, "validation": []});
    std::fs::write(place.path("run/trained_on.json"), others.to_string()).unwrap();
    let report = place.predict("run turned.zarr");
    let why: Vec<&Value> = report["not_scored"]
        .as_array()
        .unwrap()
        .iter()
        .map(|part| &part["why"])
        .collect();
    assert_eq!(why, ["no-class", "same-cluster"]);

    // Nothing is known of an older run, and nothing is scored, until the same command has written
    // it down.
    std::fs::remove_file(place.path("run/trained_on.json")).unwrap();
    let report = place.predict("run turned.zarr");
    assert!(report["scores"].is_null());
    assert_eq!(report["not_scored"][1]["why"], "training-unknown");
    let said = String::from_utf8(place.run("predict run turned.zarr").stderr).unwrap();
    assert!(
        said.contains("no scores") && said.contains("repeat the train command"),
        "{said}"
    );
    assert!(
        place.predict("run set.zarr")["scores"].is_object(),
        "the own set needs no such file"
    );
    place.train("-o run");
    assert_eq!(json(&place.path("run/trained_on.json")), seen);
    std::fs::write(place.path("run/trained_on.json"), "{").unwrap();
    assert!(
        place
            .complaint("run turned.zarr")
            .contains("trained_on.json is damaged")
    );
}

#[test]
fn voxels_of_another_kind_are_refused() {
    let place = Place::new();
    place.train("-o run");
    let spacing = protomer_learn_verbs::voxels::Spacing::Angstrom(2.0);
    place.write_set(
        "coarse.zarr",
        3,
        1,
        &VoxelizeSettings {
            spacing,
            ..settings()
        },
    );
    assert!(place.complaint("run coarse.zarr").contains("--spacing 1.0"));
}

#[test]
fn a_damaged_sample_is_left_out_and_the_others_are_there() {
    let place = Place::new();
    place.train("-o run");
    let whole = String::from_utf8(place.run("predict run set.zarr -q").stdout).unwrap();
    copy(&place.path("set.zarr"), &place.path("damaged.zarr"));
    let file = place.path("damaged.zarr/potential/c/0");
    let mut bytes = std::fs::read(&file).unwrap();
    bytes[40] ^= 0xff;
    std::fs::write(&file, bytes).unwrap();
    let output = place.run("predict run damaged.zarr -o table.csv --json");
    assert_eq!(
        output.status.code(),
        Some(1),
        "some of the inputs failed, and the rest is there"
    );
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    let left_out = report["left_out"].as_array().unwrap();
    assert!(!left_out.is_empty() && left_out.len() < 90);
    assert!(String::from_utf8_lossy(&output.stderr).contains("left out: "));
    assert!(
        left_out[0]["reason"]
            .as_str()
            .unwrap()
            .contains("damaged.zarr/potential/c/0")
    );
    let table = std::fs::read_to_string(place.path("table.csv")).unwrap();
    assert_eq!(table.lines().count(), 1 + 90 - left_out.len());
    // Samples are dealt out before they are read, so those that stay keep their part.
    for row in table.lines() {
        assert!(whole.lines().any(|line| line == row), "{row}");
    }
    for channel in ["index", "hydropathy"] {
        std::fs::write(place.path("damaged.zarr").join(channel).join("c/0"), [0; 9]).unwrap();
    }
    let said = place.complaint("run damaged.zarr");
    assert!(
        said.contains("the training part has no samples: 90 samples cannot be used"),
        "{said}"
    );
    place.write_set("other.zarr", 3, 5, &settings());
    std::fs::write(place.path("other.zarr/index/c/0"), [0; 9]).unwrap();
    assert!(
        place
            .complaint("run other.zarr")
            .contains("no sample of other.zarr can be read")
    );
}

#[test]
fn directories_without_a_network_for_sets_are_refused() {
    let place = Place::new();
    place.train("--channels shape,potential --ablate --ablation-seeds 1 -o run");
    let said = place.complaint("run/ablation set.zarr");
    assert!(said.contains("run/ablation/potential/seed_1"), "{said}");
    assert_eq!(
        place.predict("run/ablation/potential/seed_1 set.zarr")["channels"],
        serde_json::json!(["potential"])
    );
    copy(&place.path("run"), &place.path("unfinished"));
    std::fs::remove_file(place.path("unfinished/metrics.json")).unwrap();
    assert!(
        place
            .complaint("unfinished set.zarr")
            .contains("not finished")
    );
    copy(&place.path("run"), &place.path("damaged"));
    std::fs::write(place.path("damaged/model.safetensors"), [1; 50]).unwrap();
    let said = place.complaint("damaged set.zarr");
    assert!(
        said.contains("damaged/model.safetensors is damaged"),
        "{said}"
    );
    let control = Control::Charge;
    let settings = TrainSettings::of_control(control, &control.experiments()[0], Form::Short, 1);
    std::fs::create_dir(place.path("control")).unwrap();
    std::fs::write(
        place.path("control/settings.toml"),
        toml::to_string(&settings).unwrap(),
    )
    .unwrap();
    let said = place.complaint("control set.zarr");
    assert!(
        said.contains("the control charge") && said.contains("protomer train SET.zarr"),
        "{said}"
    );
}

/// Labels from a table: the set stays as it is, the training records the table, and `predict` scores by
/// its labels.
#[test]
fn labels_come_from_a_table() {
    let place = Place::new();
    let bytes = || -> Vec<Vec<u8>> {
        let files = ["zarr.json", "offsets/zarr.json"];
        let of_file = |file: &str| std::fs::read(place.path("set.zarr").join(file)).unwrap();
        files.into_iter().map(of_file).collect()
    };
    let before = bytes();
    let blobs = Control::Charge.samples(Variant::Usual, 90, SIZE, 1);
    let own: Vec<String> = blobs
        .descriptions
        .into_iter()
        .map(|known| known.name)
        .collect();
    let table = |label: &dyn Fn(usize) -> String| {
        let rows = own.iter().enumerate();
        let rows = rows.map(|(number, name)| format!("{name},{}\n", label(number)));
        format!("name,label\n{}", rows.collect::<String>())
    };
    let of_place = |number: usize| ["even", "odd"][number % 2].to_owned();
    std::fs::write(place.path("labels.csv"), table(&of_place)).unwrap();
    place.train("--labels labels.csv -o run");
    assert_eq!(bytes(), before, "the set has changed");
    let metrics = json(&place.path("run/metrics.json"));
    assert_eq!(metrics["classes"], serde_json::json!(["even", "odd"]));
    let settings = std::fs::read_to_string(place.path("run/settings.toml")).unwrap();
    let hash = protomer_io::atomic::sha256_hex(table(&of_place).as_bytes());
    assert!(
        settings.contains(&format!("sha256 = \"{hash}\"")),
        "{settings}"
    );

    // The labels stay with the training, though the table is lost.
    std::fs::remove_file(place.path("labels.csv")).unwrap();
    let report = place.predict("run set.zarr");
    assert_eq!(report["is_training_set"], true);
    assert_eq!(report["scores"]["accuracy"], metrics["accuracy"]);

    // Another table is another training.
    let changed = |number: usize| ["odd", "even"][number % 2].to_owned();
    std::fs::write(place.path("labels.csv"), table(&changed)).unwrap();
    let refused = place.run(
        "train set.zarr --labels labels.csv --least-samples 8 --widths 4 --groups 0 --epochs 3 \
         --permutations 20 --fractions 0.5,0.2,0.3 -o run",
    );
    let said = String::from_utf8_lossy(&refused.stderr).into_owned();
    assert!(
        !refused.status.success() && said.contains("sha256"),
        "{said}"
    );
    // Its labels are scored on what the network has not seen.
    let other = place.predict("run set.zarr --labels labels.csv");
    assert_eq!(other["is_training_set"], false);
    assert_eq!(other["scores"]["samples"], metrics["samples"]["test"]);
    let rows = |report: &Value| report["samples"].as_array().unwrap().clone();
    for (theirs, ours) in rows(&other).iter().zip(rows(&report)) {
        assert_ne!(theirs["label"], ours["label"]);
        assert_eq!(theirs["predicted"], ours["predicted"]);
        assert_eq!(theirs["unscored"].is_null(), ours["part"] == "test");
    }

    // Numbers, found by the name of the column.
    let numbers = table(&|number| format!("{}", number * number)).replacen("label", "number", 1);
    std::fs::write(place.path("numbers.csv"), numbers).unwrap();
    place.train("--labels numbers.csv -o numbers");
    assert!(json(&place.path("numbers/metrics.json"))["numbers"].is_object());

    for (words, expected) in [
        ("train set.zarr --labels nowhere.csv", "nowhere.csv"),
        (
            "train set.zarr --labels labels.csv --label-column tm",
            "no column 'tm'",
        ),
        ("train set.zarr --label-column tm", "add --labels TABLE"),
        (
            "train --control charge --labels labels.csv",
            "a control makes its own labels",
        ),
    ] {
        let refused = place.run(&format!("{words} -o refused"));
        let said = String::from_utf8_lossy(&refused.stderr).into_owned();
        assert!(
            !refused.status.success() && said.contains(expected),
            "{said}"
        );
    }
}

/// A finished training goes on for more epochs, and ends as one that had them from the start.
#[test]
fn more_epochs_by_the_same_command_end_as_if_asked_for_at_once() {
    let place = Place::new();
    place.train("--epochs 2 -o short");
    let after_two = json(&place.path("short/metrics.json"));
    assert_eq!(after_two["epochs"], 2);
    place.train("--epochs 5 -o short");
    place.train("--epochs 5 -o long");
    for file in [
        "model.safetensors",
        "metrics.json",
        "history.csv",
        "predictions.csv",
    ] {
        let read = |run: &str| std::fs::read(place.path(run).join(file)).unwrap();
        assert!(read("short") == read("long"), "{file}");
    }
    let flags = "--least-samples 8 --widths 4 --groups 0 --permutations 20 --fractions 0.5,0.2,0.3";
    let fewer = place.run(&format!("train set.zarr {flags} --epochs 3 -o short"));
    let said = String::from_utf8_lossy(&fewer.stderr).into_owned();
    assert!(
        !fewer.status.success() && said.contains("training of 5 epochs"),
        "{said}"
    );
    let other = place.run(&format!(
        "train set.zarr {flags} --epochs 9 --seed 4 -o short"
    ));
    assert!(!other.status.success(), "another seed is another training");
}

/// Fine-tuning starts where another training ended, and says what that one has seen.
#[test]
fn weights_of_another_training_are_a_start() {
    let place = Place::new();
    place.train("--epochs 6 --learning-rate 0.01 -o first");
    place.write_set("other.zarr", 60, 9, &settings());
    let flags = "--least-samples 4 --epochs 1 --permutations 20 --fractions 0.5,0.2,0.3 -q";
    let tuned = place.run(&format!(
        "train other.zarr {flags} --weights-from first --learning-rate 1e-9 -o tuned"
    ));
    is_ok(&tuned);
    let fresh = place.run(&format!(
        "train other.zarr {flags} --widths 4 --groups 0 --learning-rate 1e-9 -o fresh"
    ));
    is_ok(&fresh);
    let loss = |run: &str| json(&place.path(run).join("metrics.json"))["log_loss_nats"].as_f64();
    // A step too small to change anything: what is scored are the weights of the first training.
    assert!(
        loss("tuned").unwrap() < loss("fresh").unwrap() - 0.05,
        "{:?} {:?}",
        loss("tuned"),
        loss("fresh")
    );
    let settings = std::fs::read_to_string(place.path("tuned/settings.toml")).unwrap();
    assert!(settings.contains("[weights_from]"), "{settings}");
    let seen = json(&place.path("tuned/trained_on.json"));
    let count = |run: &str, part: &str| {
        json(&place.path(run).join("trained_on.json"))[part]
            .as_array()
            .unwrap()
            .len()
    };
    let earlier = count("first", "training") + count("first", "validation");
    assert_eq!(seen["earlier"].as_array().unwrap().len(), earlier);
    // On its own set the test part of another split was in the first training.
    let again = place.run("train set.zarr --least-samples 8 --epochs 1 --permutations 20 --fractions 0.5,0.2,0.3 --split-seed 5 --weights-from first -o again");
    is_ok(&again);
    let said = String::from_utf8_lossy(&again.stderr).into_owned();
    assert!(said.contains("weights come from"), "{said}");
    for (words, expected) in [
        ("--weights-from nowhere", "nowhere"),
        ("--weights-from first --widths 8", "other blocks"),
        ("--weights-from first --channels shape", "sees"),
        ("--weights-from first --ablate", "omit one"),
    ] {
        let refused = place.run(&format!("train set.zarr {words} -o refused"));
        let said = String::from_utf8_lossy(&refused.stderr).into_owned();
        assert!(
            !refused.status.success() && said.contains(expected),
            "{said}"
        );
    }
}

/// A number with its spread: in the tables, in the scores, and again in `predict`.
#[test]
fn a_number_is_learnt_with_its_spread() {
    let place = Place {
        folder: tempfile::tempdir().unwrap(),
    };
    place.write_numbers("set.zarr", 120, 1);
    place.train(
        "--target number --loss normal --epochs 30 --learning-rate 0.01 --patience 0 -o run",
    );
    let metrics = json(&place.path("run/metrics.json"));
    let numbers = &metrics["numbers"];
    let explained = numbers["scores"]["variance_explained"].as_f64().unwrap();
    assert!(explained > 0.3, "{explained}");
    // The regression that knows the charge is exact.
    let known = numbers["baselines"]["size_and_charge"]["variance_explained"]
        .as_f64()
        .unwrap();
    assert!(known > 0.999, "{known}");
    assert!(
        metrics["verdict"]
            .as_str()
            .unwrap()
            .starts_with("size and charge alone does better")
    );
    let spread = &numbers["spread"];
    let within = spread["within_two"].as_f64().unwrap();
    assert!(within > 0.7 && spread["within_one"].as_f64().unwrap() <= within);
    let table = std::fs::read_to_string(place.path("run/predictions.csv")).unwrap();
    assert!(
        table.starts_with("name,cluster,label,predicted,number,predicted_number,predicted_spread,")
    );
    let report = place.predict("run set.zarr");
    let found = report["scores"]["numbers"]["rms_error"].as_f64().unwrap();
    assert!((found - numbers["scores"]["rms_error"].as_f64().unwrap()).abs() < 1e-9);
    assert!(report["samples"][0]["predicted_spread"].as_f64().unwrap() > 0.0);
    is_ok(&place.run("report run -q"));
    let page = std::fs::read_to_string(place.path("run/report.html")).unwrap();
    assert!(page.contains("predicted spread") && page.contains("Verdict: "));
    let refused = place.run("train set.zarr --loss normal --least-samples 1 -o refused");
    let said = String::from_utf8_lossy(&refused.stderr).into_owned();
    assert!(
        !refused.status.success() && said.contains("--target number"),
        "{said}"
    );
}

/// A share of the training part leaves the other parts as they are.
#[test]
fn a_share_of_the_training_part_is_trained_on() {
    let place = Place::new();
    place.train("--epochs 1 -o whole");
    place.train("--epochs 1 --training-share 0.5 -o half");
    let parts = |run: &str| json(&place.path(run).join("metrics.json"))["samples"].clone();
    let (whole, half) = (parts("whole"), parts("half"));
    assert_eq!(
        (&whole["validation"], &whole["test"]),
        (&half["validation"], &half["test"])
    );
    let training = |parts: &Value| parts["training"].as_u64().unwrap();
    assert!(training(&half) < training(&whole));
}
