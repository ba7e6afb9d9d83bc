//! A process that is killed at work and continued leaves the files of the undisturbed one.
//!
//! This is a separate binary: a child that is being started holds the locks of its parent for a moment, so that
//! tests in the same process would find their directories busy.

#![allow(clippy::unwrap_used, clippy::panic, reason = "tests fail by panicking")]

#[allow(dead_code, reason = "the campaign is for the other tests")]
#[path = "../integration/walk/mod.rs"]
mod walk;

use protomer_results::{Execution, Exit, Record};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;
use walk::{Walk, contents, walk};

const STEPS: u64 = 20_000;

/// Saves after every step.
fn eager() -> Execution {
    Execution {
        checkpoint_interval: Duration::ZERO,
        ..Execution::default()
    }
}

/// Walks in the directory that the environment names: what the test below kills.
#[test]
fn child() {
    if let Some(path) = std::env::var_os("WALK_IN") {
        let plan = Walk {
            seed: 3,
            steps: STEPS,
        };
        walk(&plan, Path::new(&path), &eager()).unwrap();
    }
}

#[test]
fn a_walk_that_was_killed_and_continued_equals_the_whole_one() {
    let folder = tempfile::tempdir().unwrap();
    let (whole, killed) = (folder.path().join("whole"), folder.path().join("killed"));
    let plan = Walk {
        seed: 3,
        steps: STEPS,
    };
    walk(&plan, &whole, &Execution::default()).unwrap();
    for kill in 1..=3 {
        let mut child = Command::new(std::env::current_exe().unwrap())
            .args(["--exact", "child"])
            .env("WALK_IN", &killed)
            .stdout(Stdio::null())
            .spawn()
            .unwrap();
        let saved = || std::fs::read(killed.join("checkpoint.bin")).ok();
        let before = saved();
        while saved() == before {
            assert!(
                child.try_wait().unwrap().is_none(),
                "kill {kill} came too late"
            );
        }
        child.kill().unwrap();
        child.wait().unwrap();
        let record = Record::read(&killed).unwrap().unwrap();
        assert_eq!(
            record.exit,
            Exit::Running,
            "a killed process says nothing of its end"
        );
    }
    walk(&plan, &killed, &Execution::default()).unwrap();
    assert_eq!(contents(&whole), contents(&killed));
}
