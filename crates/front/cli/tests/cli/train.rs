//! Trainings in their directories: killed and continued, stopped, refused.

use crate::common::{is_ok, program};
use serde_json::Value;
use std::path::Path;
use std::process::Stdio;
use std::time::{Duration, Instant};

fn metrics(directory: &Path) -> Value {
    serde_json::from_slice(&std::fs::read(directory.join("metrics.json")).unwrap()).unwrap()
}

const SOME: [&str; 9] = [
    "train",
    "--control",
    "orientation",
    "--short",
    "--epochs",
    "5",
    "--checkpoint-every",
    "0",
    "-q",
];

#[test]
fn killed_and_continued_it_ends_with_the_same_weights() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let words = |name: &str, threads: &'static str| -> Vec<String> {
        let rest = ["-j", threads, "-o"].map(String::from);
        let start = SOME.iter().map(|word| (*word).to_owned());
        start
            .chain(rest)
            .chain([path(name).display().to_string()])
            .collect()
    };
    let whole = program(words("whole", "1")).output().unwrap();
    is_ok(&whole);
    let mut killed = program(words("killed", "2"))
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let begun = Instant::now();
    while !path("killed").join("checkpoint.bin").exists()
        && begun.elapsed() < Duration::from_secs(120)
    {
        std::thread::sleep(Duration::from_millis(5));
    }
    killed.kill().unwrap();
    killed.wait().unwrap();
    assert!(path("killed").join("checkpoint.bin").exists());
    assert!(
        !path("killed").join("metrics.json").exists(),
        "it was done before it was killed"
    );
    let continued = program(words("killed", "2")).output().unwrap();
    is_ok(&continued);
    for file in [
        "model.safetensors",
        "metrics.json",
        "history.csv",
        "predictions.csv",
        "learning_curve.svg",
    ] {
        let read = |name: &str| std::fs::read(path(name).join(file)).unwrap();
        assert!(read("whole") == read("killed"), "{file} differs");
    }
    // Complete, it has nothing to do; other settings are refused, and so is another seed.
    assert!(
        program(words("killed", "1"))
            .output()
            .unwrap()
            .status
            .success()
    );
    let other = program(words("killed", "1"))
        .args(["--seed", "2"])
        .output()
        .unwrap();
    assert!(String::from_utf8_lossy(&other.stderr).contains("--force"));
}

/// As a process leaves it that was killed between its last file and its last record.
#[test]
fn killed_before_its_last_record_it_says_so_and_the_same_command_mends_it() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run");
    let name = path.display().to_string();
    let train = || program(SOME).args(["-o", &name]).output().unwrap();
    let status = || {
        is_ok(
            &program(["report", &name, "-q", "--force"])
                .output()
                .unwrap(),
        );
        std::fs::read_to_string(path.join("report.html")).unwrap()
    };
    is_ok(&train());
    let record = std::fs::read_to_string(path.join("run.json")).unwrap();
    assert!(status().contains("nothing failed and nothing is missing"));
    let mut killed: Value = serde_json::from_str(&record).unwrap();
    killed["exit_reason"] = "running".into();
    killed["done"] = 0.into();
    std::fs::write(path.join("run.json"), killed.to_string()).unwrap();
    assert!(status().contains("According to its record it is still running"));
    is_ok(&train());
    assert_eq!(
        std::fs::read_to_string(path.join("run.json")).unwrap(),
        record
    );
    assert!(status().contains("nothing failed and nothing is missing"));
}

#[test]
fn a_time_limit_stops_it_resumably() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run").display().to_string();
    let stopped = program(SOME)
        .args(["-o", &path, "--time-limit", "0"])
        .output()
        .unwrap();
    assert_eq!(
        stopped.status.code(),
        Some(3),
        "{}",
        String::from_utf8_lossy(&stopped.stderr)
    );
    assert!(!folder.path().join("run/metrics.json").exists());
}

#[test]
fn metrics_hold_scores_beside_baselines_and_the_ablation() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run");
    let output = program([
        "train",
        "--control",
        "charge",
        "--short",
        "--epochs",
        "2",
        "--ablate",
        "--ablation-seeds",
        "1",
        "--channels",
        "shape,potential",
        "-o",
        &path.display().to_string(),
    ])
    .output()
    .unwrap();
    is_ok(&output);
    let text = String::from_utf8_lossy(&output.stdout);
    let line = |start: &str| {
        text.lines()
            .find(|line| line.starts_with(start))
            .unwrap_or_else(|| panic!("{text}"))
    };
    let heads = [
        "accuracy",
        "balanced accuracy",
        "macro-F1",
        "top 3",
        "log-loss (nats)",
        "gained over prior",
    ];
    let head = text.lines().find(|line| line.contains("macro-F1")).unwrap();
    assert!(heads.iter().all(|word| head.contains(word)), "{head}");
    for row in [
        "network",
        "majority",
        "prior",
        "size ",
        "composition",
        "size and charge",
    ] {
        assert_eq!(
            line(row)
                .split("  ")
                .filter(|cell| !cell.is_empty())
                .count(),
            7,
            "{text}"
        );
    }
    let intervals = line("95 % over clusters");
    assert_eq!(intervals.matches("(majority 0.").count(), 2, "{text}");
    let test = line("permutation test");
    assert!(
        test.contains("can move") && test.contains("does not test the gain over the prior"),
        "{text}"
    );
    assert!(
        line("calibration").contains("Brier") && line("true").contains("positive"),
        "{text}"
    );
    let metrics = metrics(&path);
    let number = |key: &str| {
        metrics[key]
            .as_f64()
            .unwrap_or_else(|| panic!("{key} is missing"))
    };
    for key in [
        "balanced_accuracy",
        "accuracy",
        "majority_accuracy",
        "log_loss_nats",
        "prior_log_loss_nats",
        "nats_gained_over_prior",
        "macro_f1",
        "top3_accuracy",
        "expected_calibration_error",
        "permutation_p",
    ] {
        assert!(number(key).is_finite(), "{key}");
    }
    assert!(number("balanced_accuracy") > 0.9 && number("permutation_p") < 0.01);
    assert!(
        (number("nats_gained_over_prior") - number("prior_log_loss_nats")
            + number("log_loss_nats"))
        .abs()
            < 1e-12
    );
    assert_eq!(
        metrics["classes"],
        serde_json::json!(["negative", "positive"])
    );
    assert_eq!(metrics["confusion_matrix"].as_array().unwrap().len(), 2);
    // Descriptions know the net charge: the regression on it must do well here, and the one on size
    // must not.
    assert!(
        metrics["baselines"]["size_and_charge"]["balanced_accuracy"]
            .as_f64()
            .unwrap()
            > 0.9
    );
    assert!(
        (metrics["baselines"]["majority"]["balanced_accuracy"]
            .as_f64()
            .unwrap()
            - 0.5)
            .abs()
            < 1e-12
    );
    let rows = metrics["ablation"]["rows"].as_array().unwrap();
    assert_eq!(rows.len(), 3);
    let of = |channels: &[&str]| {
        let row = rows
            .iter()
            .find(|row| row["channels"] == serde_json::json!(channels))
            .unwrap();
        row["balanced_accuracy"]["mean"].as_f64().unwrap()
    };
    assert!(of(&["shape", "potential"]) > 0.9 && of(&["potential"]) > 0.9 && of(&["shape"]) < 0.65);
    assert!(
        path.join("ablation.csv").exists()
            && path.join("ablation/shape/seed_1/metrics.json").exists()
    );
    let experiments = metrics["control"]["experiments"].as_array().unwrap();
    assert_eq!(experiments.len(), 2);
    assert_eq!(metrics["control"]["reached"], true);
    let predictions = std::fs::read_to_string(path.join("predictions.csv")).unwrap();
    assert_eq!(
        predictions.lines().next().unwrap(),
        "name,cluster,label,predicted,p_negative,p_positive"
    );
    assert_eq!(
        predictions.lines().count() as u64,
        1 + metrics["samples"]["test"].as_u64().unwrap()
    );
}

#[test]
fn wrong_names_are_told_the_right_ones() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run").display().to_string();
    let complaint = |words: &[&str]| {
        let output = program(["train"])
            .args(words)
            .args(["-o", &path])
            .output()
            .unwrap();
        assert!(!output.status.success());
        String::from_utf8_lossy(&output.stderr).into_owned()
    };
    let control = complaint(&["--control", "shape"]);
    assert!(
        control.contains("'shape'") && control.contains("heavy-tails"),
        "{control}"
    );
    let target = complaint(&["--control", "charge", "--target", "crystal"]);
    assert!(
        target.contains("crystal-system") && target.contains("polar"),
        "{target}"
    );
    let channel = complaint(&[
        "--control",
        "charge",
        "--short",
        "--channels",
        "shape,charge",
    ]);
    assert!(
        channel.contains("charge") && channel.contains("hydropathy"),
        "{channel}"
    );
    let polar = complaint(&["--control", "charge", "--short", "--target", "polar"]);
    assert!(polar.contains("0 of 600 samples have a class"), "{polar}");
    assert!(complaint(&[]).contains("SET"));
    assert!(
        !folder.path().join("run").exists(),
        "a refused training leaves nothing behind"
    );
}
