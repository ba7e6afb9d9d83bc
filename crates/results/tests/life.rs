//! A walk is stopped, continued, shared out and tampered with; each time its files equal those of
//! the undisturbed walk byte for byte, or it is refused.

#![allow(clippy::unwrap_used, clippy::panic)] // a test fails by panicking

mod walk;

use protomer_results::{
    Campaign, End, Execution, Exit, Interrupt, Progress, Record, ResultsDirectory, Shard, conduct,
    conduct_shard,
};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use walk::{LAYOUT, Walk, Walks, contents, walk};

/// An execution that is asked to stop after so many steps.
fn stopping_after(steps: u64) -> Execution {
    struct StopAfter {
        left: AtomicU64,
        interrupt: Interrupt,
    }
    impl Progress for StopAfter {
        fn begin(&self, _total: u64, _unit: &'static str) {}
        fn advance(&self, units: u64) {
            if self.left.fetch_sub(units, Ordering::SeqCst) <= units {
                self.interrupt.request();
            }
        }
    }
    let interrupt = Interrupt::default();
    Execution {
        interrupt: interrupt.clone(),
        progress: Arc::new(StopAfter {
            left: steps.into(),
            interrupt,
        }),
        ..Execution::default()
    }
}

#[test]
fn a_walk_that_was_stopped_and_continued_equals_the_whole_one() {
    let folder = tempfile::tempdir().unwrap();
    let (whole, parts) = (folder.path().join("whole"), folder.path().join("parts"));
    let plan = Walk {
        seed: 7,
        steps: 100,
    };
    let End::Finished(place) = walk(&plan, &whole, &Execution::default()).unwrap() else {
        panic!("nobody asked it to stop")
    };
    assert_eq!(place.step, 100);
    for _ in 0..3 {
        assert_eq!(
            walk(&plan, &parts, &stopping_after(30)).unwrap(),
            End::Stopped
        );
        let record = Record::read(&parts).unwrap().unwrap();
        assert_eq!(
            record.exit,
            Exit::Stopped {
                by: Some("a signal".into())
            }
        );
    }
    assert_eq!(
        walk(&plan, &parts, &Execution::default()).unwrap(),
        End::Finished(place)
    );
    assert_eq!(contents(&whole), contents(&parts));
    // A finished walk is found, not repeated; a longer one continues it.
    assert_eq!(
        walk(&plan, &parts, &stopping_after(0)).unwrap(),
        End::Finished(place)
    );
    let longer = Walk { steps: 150, ..plan };
    walk(&longer, &parts, &Execution::default()).unwrap();
    let fresh = folder.path().join("fresh");
    walk(&longer, &fresh, &Execution::default()).unwrap();
    assert_eq!(contents(&fresh), contents(&parts));
}

#[test]
fn parts_of_a_campaign_make_the_same_directory_as_one_process() {
    let folder = tempfile::tempdir().unwrap();
    let (whole, shared) = (folder.path().join("whole"), folder.path().join("shared"));
    let enter = |walks: &Walks| {
        let identity = walks.work().identity;
        let execution = Execution::default();
        ResultsDirectory::enter(&walks.path, &LAYOUT, &walks.settings, &identity, &execution)
    };
    let walks = Walks::new(5, 40, &whole);
    conduct(&walks, &enter(&walks).unwrap(), &Execution::default()).unwrap();

    let walks = Walks::new(5, 40, &shared);
    let identity = walks.work().identity;
    let execution = Execution::default();
    for (index, expected) in [(1, 3), (2, 2)] {
        let ours =
            ResultsDirectory::share(&shared, &LAYOUT, &walks.settings, &identity, &execution);
        let shard = Shard { index, of: 2 };
        let end = conduct_shard(&walks, &ours.unwrap(), shard, &execution).unwrap();
        assert_eq!(end, End::Finished(expected));
    }
    assert!(!shared.join("sum.txt").exists());
    conduct(&walks, &enter(&walks).unwrap(), &execution).unwrap();
    assert_eq!(contents(&whole), contents(&shared));
}

#[test]
fn one_walk_that_fails_is_recorded_and_stops_the_campaign() {
    let folder = tempfile::tempdir().unwrap();
    let walks = Walks::new(3, 40, folder.path());
    let identity = walks.work().identity;
    // A folder in the place of the log: the second walk cannot begin.
    std::fs::create_dir_all(folder.path().join("seed_1/log.csv")).unwrap();
    let execution = Execution::default();
    let ours = ResultsDirectory::enter(
        folder.path(),
        &LAYOUT,
        &walks.settings,
        &identity,
        &execution,
    );
    let error = conduct(&walks, &ours.unwrap(), &execution).unwrap_err();
    assert!(error.to_string().contains("log.csv"), "{error}");
    assert_eq!(execution.interrupt.reason(), "the failure of another part");
    for directory in ["", "seed_1"] {
        let record = Record::read(&folder.path().join(directory))
            .unwrap()
            .unwrap();
        assert!(
            matches!(record.exit, Exit::Failed { .. }),
            "{directory}: {record:?}"
        );
    }
}

#[test]
fn other_work_and_changed_files_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let plan = Walk { seed: 1, steps: 50 };
    walk(&plan, folder.path(), &Execution::default()).unwrap();
    let refusal = |plan: Walk| {
        walk(&plan, folder.path(), &Execution::default())
            .unwrap_err()
            .to_string()
    };
    assert!(
        refusal(Walk {
            seed: 2,
            ..plan.clone()
        })
        .contains("seed: 1 there, 2 here")
    );
    assert!(
        refusal(Walk {
            steps: 20,
            ..plan.clone()
        })
        .contains("more than 20")
    );
    let log = folder.path().join("log.csv");
    let changed = std::fs::read_to_string(&log)
        .unwrap()
        .replacen("\n1,", "\n2,", 1);
    std::fs::write(&log, changed).unwrap();
    assert!(refusal(plan.clone()).contains("changed since its checkpoint"));
    let anew = Execution {
        start_anew: true,
        ..Execution::default()
    };
    walk(&plan, folder.path(), &anew).unwrap();
    walk(&plan, folder.path(), &Execution::default()).unwrap();
}
