//! A directory that holds one kind of result is refused by every verb that leaves another, and left
//! as it was.

use crate::common::{TemporaryFolder, contents, is_ok, message};

/// What each verb leaves, and the words that leave it; the directory comes last.
const VERBS: [(&str, &str); 7] = [
    (
        "a sweep",
        "simulate ring.json --salt 100mM --cutoff 20A --sweeps 10 --equilibration 1 -q -o",
    ),
    (
        "a sweep",
        "sweep ring.json --salt 100mM --cutoff 20A --sweeps 10 --equilibration 1 --replicas 1 --shard 1/1 -q -o",
    ),
    ("a lattice run", "lattice run --ns 2 --steps 20 -q -o"),
    (
        "a lattice sweep",
        "lattice sweep --ns 2 --time 0.2 --r0-list 0.1 --kappa-list 0 --seeds 1 -q -o",
    ),
    (
        "elastic constants of a network",
        "framework honeycomb --theta 60 --kh 50 --ks 10000 -q -o",
    ),
    ("the tables of a paper", "framework tables -q -o"),
    (
        "a training run",
        "train --control orientation --short --epochs 1 -q -o",
    ),
];

/// Files that tell results of other verbs, which need a set of structures.
const OTHERS: [(&str, &[(&str, &str)]); 3] = [
    ("a voxel set", &[("zarr.json", "{}")]),
    (
        "a search for settings",
        &[("settings.toml", "trials = 4\n[base]\nleast_samples = 5\n")],
    ),
    (
        "one simulation of a sweep",
        &[("run.json", "{}"), ("checkpoint.bin", "")],
    ),
];

fn with_one_of_each() -> (TemporaryFolder, Vec<(&'static str, String)>) {
    let place = TemporaryFolder::new();
    let mut directories = Vec::new();
    for (number, (kind, words)) in VERBS.into_iter().enumerate() {
        let name = format!("made_{number}");
        is_ok(&place.run(&format!("{words} {name}")));
        directories.push((kind, name));
    }
    for (number, (kind, files)) in OTHERS.into_iter().enumerate() {
        let name = format!("other_{number}");
        std::fs::create_dir(place.path(&name)).unwrap();
        for (file, text) in files {
            std::fs::write(place.path(&name).join(file), text).unwrap();
        }
        directories.push((kind, name));
    }
    (place, directories)
}

#[test]
fn no_verb_writes_into_the_results_of_another() {
    let (place, directories) = with_one_of_each();
    for (kind, directory) in &directories {
        let before = contents(&place.path(directory));
        for (ours, words) in VERBS {
            for force in ["", " --force"] {
                if ours == *kind || (words.contains("--shard") && !force.is_empty()) {
                    continue;
                }
                let output = place.run(&format!("{words} {directory}{force}"));
                let expected = format!("error: {directory} holds {kind}; give another directory");
                assert!(
                    message(&output).contains(&expected),
                    "{words}{force}: {}",
                    message(&output)
                );
                assert!(
                    before == contents(&place.path(directory)),
                    "{words}{force} wrote into {kind}"
                );
            }
        }
    }
}

#[test]
fn the_same_command_finds_its_own_results() {
    let (place, directories) = with_one_of_each();
    for ((_, words), (kind, directory)) in VERBS.into_iter().zip(&directories) {
        let again = place.run(&format!("{words} {directory}"));
        // The files of networks are not made anew unasked.
        let refused = words.starts_with("framework") && message(&again).contains("already exists");
        assert!(
            refused || again.status.success(),
            "{kind}: {}",
            message(&again)
        );
    }
}

#[test]
fn nothing_is_put_into_a_voxel_set() {
    let place = TemporaryFolder::new();
    std::fs::create_dir(place.path("set.zarr")).unwrap();
    std::fs::write(place.path("set.zarr/zarr.json"), "{}").unwrap();
    std::fs::write(
        place.path("one.pqr"),
        "ATOM 1 C ALA 1 0.0 0.0 0.0 1.0 1.7\n",
    )
    .unwrap();
    for words in [
        "ingest one.pqr -o",
        "assemble structure one.pqr -o",
        "fetch 5pti -o",
        "man -o",
    ] {
        let output = place.run(&format!("{words} set.zarr"));
        assert!(
            message(&output).contains("set.zarr holds a voxel set; give another directory"),
            "{}",
            message(&output)
        );
        assert_eq!(contents(&place.path("set.zarr")).len(), 1, "{words}");
    }
    // Beside other results files do no harm: a sweep may lie in the directory of its bodies.
    is_ok(&place.run("framework tables -q -o tables"));
    is_ok(&place.run("man -o tables"));
}

#[test]
fn a_shape_keeps_its_name_beside_a_folder_of_that_name() {
    let place = TemporaryFolder::new();
    std::fs::create_dir(place.path("cube")).unwrap();
    std::fs::create_dir(place.path("runs")).unwrap();
    is_ok(&place.run("shape cube --json"));
    let refused = message(&place.run("shape runs --json"));
    assert!(refused.contains("runs is a folder"), "{refused}");
}
