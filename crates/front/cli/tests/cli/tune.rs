//! Searches in their directories: losers stop early, stopped and killed searches go on, others are
//! refused.

use crate::common::{TemporaryFolder, contents, is_ok, message};
use protomer_learn::controls::{Control, Variant};
use protomer_learn::scaling::ScalingMode;
use protomer_learn::trial::TrialSettings;
use protomer_learn_verbs::learning::train::{Source, TrainSettings};
use protomer_learn_verbs::learning::tune::{Trial, TuneSettings, tune_in};
use protomer_results::{End, Execution};
use serde_json::Value;
use std::collections::BTreeMap;
use std::time::{Duration, Instant};

/// One protein in two classes under many names: there is nothing to learn, but something to search.
pub fn place() -> TemporaryFolder {
    let place = TemporaryFolder::new();
    let data = std::path::Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../../data")
        .canonicalize()
        .unwrap();
    std::os::unix::fs::symlink(data, place.path("data")).unwrap();
    let mut manifest = "file,label,cluster,name\n".to_owned();
    for number in 0..16 {
        let label = if number % 2 == 0 { "even" } else { "odd" };
        manifest += &format!("data/structures/5pti.cif.gz,{label},c{number},s{number}\n");
    }
    std::fs::write(place.path("set.csv"), manifest).unwrap();
    let words = "--size 24 --spacing 2 --channels shape --potential debye-hueckel -q";
    is_ok(&place.run(&format!("voxelize --manifest set.csv -o set.zarr {words}")));
    place
}

/// Four trials, two of which see three epochs, one of them nine.
const SEARCH: &str =
    "tune set.zarr --least-samples 5 --trials 4 --epochs 9 --checkpoint-every 0 -q";

/// The results of a search by name, without its locks.
fn results(place: &TemporaryFolder, name: &str) -> BTreeMap<String, Vec<u8>> {
    let mut files = contents(&place.path(name));
    files.retain(|name, _| !name.ends_with(".lock"));
    files
}

fn column(csv: &str, name: &str) -> Vec<String> {
    let mut lines = csv.lines();
    let index = lines
        .next()
        .unwrap()
        .split(',')
        .position(|column| column == name)
        .unwrap();
    lines
        .map(|line| line.split(',').nth(index).unwrap().to_owned())
        .collect()
}

#[test]
fn losers_stop_early_and_the_best_is_trained_as_in_the_search() {
    let place = place();
    let output =
        place.run("tune set.zarr --least-samples 5 --trials 4 --epochs 9 --json -o search");
    is_ok(&output);
    let csv = std::fs::read_to_string(place.path("search/trials.csv")).unwrap();
    assert_eq!(column(&csv, "epochs"), ["9", "3", "1", "1"]);
    let losses: Vec<f64> = column(&csv, "validation_loss_nats")
        .iter()
        .map(|loss| loss.parse().unwrap())
        .collect();
    assert!(losses[2] <= losses[3], "{losses:?}");
    let mut numbers = column(&csv, "trial");
    let best = numbers[0].clone();
    numbers.sort();
    assert_eq!(numbers, ["0", "1", "2", "3"]);
    let printed: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(printed["best"], "search/best.toml");
    assert_eq!(printed["trials"].as_array().unwrap().len(), 4);
    assert_eq!(printed["trials"][0]["number"].to_string(), best);
    assert!(
        std::fs::read_to_string(place.path("search/trials.svg"))
            .unwrap()
            .contains("3\u{a0}epochs")
    );
    // The winner, trained by itself, goes through the same epochs.
    is_ok(&place.run("train set.zarr --config search/best.toml -q -o best"));
    let history = std::fs::read_to_string(place.path("best/history.csv")).unwrap();
    let losses_again = column(&history, "validation_loss_nats");
    assert!(
        losses_again.contains(&column(&csv, "validation_loss_nats")[0]),
        "{losses_again:?} {losses:?}"
    );
    // With another seed its test part stays: none of it has chosen the settings.
    let test_part = |words: &str, run: &str| {
        is_ok(&place.run(&format!(
            "train set.zarr --config search/best.toml --epochs 1 -q {words} -o {run}"
        )));
        let mut names = column(
            &std::fs::read_to_string(place.path(run).join("predictions.csv")).unwrap(),
            "name",
        );
        names.sort();
        names
    };
    let kept = test_part("--seed 1", "first");
    assert_eq!(test_part("--seed 5", "second"), kept);
    assert_ne!(test_part("--seed 5 --split-seed 5", "third"), kept);
}

#[test]
fn stopped_or_killed_and_continued_it_ends_with_the_same_files() {
    let place = place();
    is_ok(&place.run(&format!("{SEARCH} -j 1 -o whole")));
    let whole = results(&place, "whole");
    assert!(
        whole.contains_key("trials.csv")
            && whole.contains_key("best.toml")
            && whole.contains_key("trials.svg")
    );
    // Complete, it has nothing to do, and threads make no difference.
    is_ok(&place.run(&format!("{SEARCH} -j 2 -o whole")));
    assert!(results(&place, "whole") == whole);
    let stopped = place.run(&format!("{SEARCH} --time-limit 0 -o stopped"));
    assert_eq!(stopped.status.code(), Some(3), "{}", message(&stopped));
    assert!(!place.path("stopped/trials.csv").exists());
    is_ok(&place.run(&format!("{SEARCH} -j 2 -o stopped")));
    assert!(
        results(&place, "stopped") == whole,
        "stopped and continued it differs"
    );
    // Killed with the first checkpoint on the disk, and after the first rung.
    for (name, threads, until) in [("first", 2, "trials/0000.bin"), ("second", 1, "trials.csv")] {
        let command = format!("{SEARCH} -j {threads} -o {name}");
        let mut killed = place.command(&command).spawn().unwrap();
        let begun = Instant::now();
        while !place.path(name).join(until).exists() && begun.elapsed() < Duration::from_secs(60) {
            std::thread::sleep(Duration::from_millis(1));
        }
        killed.kill().unwrap();
        killed.wait().unwrap();
        assert!(place.path(name).join(until).exists());
        assert!(
            !place.path(name).join("best.toml").exists(),
            "it was done before it was killed"
        );
        is_ok(&place.run(&command));
        assert!(
            results(&place, name) == whole,
            "killed at {until} and continued it differs"
        );
    }
}

/// The worst case for a search that goes on: every checkpoint is already at the end when the first
/// rung is decided.
#[test]
fn what_came_after_a_rung_does_not_decide_who_goes_on_from_it() {
    let place = place();
    let output =
        place.run("tune set.zarr --least-samples 5 --trials 4 --epochs 9 --json -o search");
    is_ok(&output);
    let whole = results(&place, "search");
    let printed: Value = serde_json::from_slice(&output.stdout).unwrap();
    for trial in printed["trials"].as_array().unwrap() {
        let settings: TrainSettings = serde_json::from_value(trial["settings"].clone()).unwrap();
        std::fs::write(
            place.path("trial.toml"),
            toml::to_string(&settings).unwrap(),
        )
        .unwrap();
        is_ok(
            &place.run("train set.zarr --config trial.toml --permutations 0 -q --force -o alone"),
        );
        let checkpoint = format!("search/trials/{:04}.bin", trial["number"].as_u64().unwrap());
        std::fs::copy(place.path("alone/checkpoint.bin"), place.path(&checkpoint)).unwrap();
    }
    let files = ["trials.csv", "best.toml", "trials.svg"];
    for file in files {
        std::fs::remove_file(place.path(&format!("search/{file}"))).unwrap();
    }
    for record in whole
        .keys()
        .filter(|name| name.starts_with("trials/") && name.ends_with(".toml"))
    {
        std::fs::remove_file(place.path("search").join(record)).unwrap();
    }
    is_ok(&place.run("tune set.zarr --least-samples 5 --trials 4 --epochs 9 -q -o search"));
    let again = results(&place, "search");
    for file in files {
        assert!(again[file] == whole[file], "{file} differs");
    }
}

#[test]
fn parts_that_wait_for_each_other_leave_the_files_of_one_search() {
    let place = place();
    is_ok(&place.run(&format!("{SEARCH} -o whole")));
    let mut finished = vec![];
    // Rungs at one, three and nine epochs; the first round is never the last.
    for _round in 0..3 {
        assert!(!finished.contains(&true));
        assert!(!place.path("parts/trials.csv").exists());
        let part = |part: usize| -> bool {
            let output = place.run(&format!("{SEARCH} --shard {part}/3 --json -o parts"));
            is_ok(&output);
            let printed: Value = serde_json::from_slice(&output.stdout).unwrap();
            printed["finished"].as_bool().unwrap()
        };
        finished = (1..=3).map(part).collect();
    }
    assert_eq!(finished, [true; 3]);
    let trained = |name: &str| -> BTreeMap<String, Vec<u8>> {
        results(&place, name)
            .into_iter()
            .filter(|(name, _)| name.starts_with("trials/"))
            .collect()
    };
    assert!(trained("parts") == trained("whole"));
    is_ok(&place.run(&format!("{SEARCH} -o parts")));
    assert!(results(&place, "parts") == results(&place, "whole"));
    let anew = place.run(&format!("{SEARCH} --shard 1/3 --force -o parts"));
    assert!(
        message(&anew).contains("cannot start again"),
        "{}",
        message(&anew)
    );
    let held = std::fs::File::open(place.path("parts/.lock")).unwrap();
    held.lock_shared().unwrap();
    let collected = place.run(&format!("{SEARCH} -o parts"));
    assert!(
        message(&collected).contains("another process works in"),
        "{}",
        message(&collected)
    );
}

#[test]
fn other_settings_are_refused() {
    let place = place();
    is_ok(&place.run("tune set.zarr --least-samples 5 --trials 2 --epochs 1 -q -o search"));
    let before = results(&place, "search");
    for other in [
        "--trials 3 --epochs 1",
        "--trials 2 --epochs 2",
        "--trials 2 --epochs 1 --seed 2",
    ] {
        let refused = place.run(&format!(
            "tune set.zarr --least-samples 5 {other} -o search"
        ));
        assert_eq!(refused.status.code(), Some(1));
        assert!(
            message(&refused).contains("holds a search for settings with other settings"),
            "{}",
            message(&refused)
        );
    }
    assert!(results(&place, "search") == before);
    is_ok(&place.run(
        "tune set.zarr --least-samples 5 --trials 2 --epochs 1 --seed 2 -q --force -o search",
    ));
    assert!(results(&place, "search") != before);
}

/// Potentials beyond what a float can square: only networks with normalisation bear them. The
/// others have lost, and where there are no more than those, the search says so instead of naming a
/// winner.
#[test]
fn a_trial_that_diverges_has_lost() {
    let mut set = Control::Charge.samples(Variant::Usual, 40, 8, 1);
    set.grids
        .iter_mut()
        .flat_map(|grid| grid.values.iter_mut())
        .for_each(|value| *value *= 1e30);
    let source = Source::Control {
        name: Control::Charge,
        variant: Variant::Usual,
        samples: 40,
        size: 8,
        seed: 1,
    };
    let mut base = TrainSettings::of_set(source, vec!["shape".into(), "potential".into()]).unwrap();
    base.training.scaling = ScalingMode::Raw;
    let draws_norm = |seed: u64, number: usize| {
        let drawn = TrialSettings::draw(seed, number, 8, &base.training.channels).unwrap();
        drawn.blocks[0].groups.is_some()
    };
    let seed = (1..)
        .find(|seed| [0, 1, 2].map(|number| draws_norm(*seed, number)) == [false, false, true])
        .unwrap();
    let place = TemporaryFolder::new();
    let search = |trials: usize| {
        let settings = TuneSettings {
            trials,
            epochs: 2,
            seed,
            vary_channels: false,
            base: base.clone(),
        };
        let path = place.path(&format!("search{trials}"));
        let end = tune_in(
            &settings,
            &set,
            &path,
            &protomer_learn::Device::Cpu,
            &Execution::default(),
        );
        (end, path)
    };
    let (end, path) = search(3);
    let End::Finished(report) = end.unwrap() else {
        panic!("it was not asked to stop")
    };
    let trials = report.trials;
    let has_norm = |trial: &Trial| trial.settings.blocks[0].groups.is_some();
    assert!(has_norm(&trials[0]) && trials[0].reached.validation_loss_nats.is_some());
    assert!(
        trials[1..]
            .iter()
            .all(|trial| !has_norm(trial) && trial.reached.validation_loss_nats.is_none())
    );
    let csv = std::fs::read_to_string(path.join("trials.csv")).unwrap();
    assert_eq!(column(&csv, "validation_loss_nats")[1..], ["", ""]);
    assert!(
        std::fs::read_to_string(path.join("trials.svg"))
            .unwrap()
            .contains("diverged")
    );
    let (end, path) = search(2);
    let error = end.unwrap_err();
    assert!(
        format!("{error:#}").contains("every trial diverged"),
        "{error:#}"
    );
    assert!(!path.join("best.toml").exists());
}
