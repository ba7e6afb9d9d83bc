//! A walk is stopped, continued, shared out and tampered with; each time its files equal those of
//! the undisturbed walk byte for byte, or it is refused.

use crate::walk;

use protomer_results::{
    Campaign, End, Error, Execution, Exit, Interrupt, Progress, Record, Result, ResultsDirectory,
    Run, Shard, Turn, Work, conduct, conduct_shard, drive, extend, recorded,
};
use std::path::Path;
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

/// A walk with steps of another kind.
struct Changed<F> {
    walk: Walk,
    advance: F,
}

impl<F: Fn(&mut <Walk as Run>::State, &Turn) -> Result<()>> Run for Changed<F> {
    type State = <Walk as Run>::State;
    type Checkpoint = <Walk as Run>::Checkpoint;
    type Answer = <Walk as Run>::Answer;
    type Error = Error;

    fn work(&self) -> Work {
        self.walk.work()
    }

    fn length(&self) -> u64 {
        self.walk.length()
    }

    fn open(&self, directory: &Path, saved: Option<Self::Checkpoint>) -> Result<Self::State> {
        self.walk.open(directory, saved)
    }

    fn done(&self, state: &Self::State) -> u64 {
        self.walk.done(state)
    }

    fn advance(&self, state: &mut Self::State, turn: &Turn) -> Result<()> {
        (self.advance)(state, turn)
    }

    fn save(&self, state: &mut Self::State) -> Result<Self::Checkpoint> {
        assert!(self.done(state) > 0, "nothing has been done yet");
        self.walk.save(state)
    }

    fn answer(&self, state: &mut Self::State, directory: &Path) -> Result<Self::Answer> {
        self.walk.answer(state, directory)
    }
}

#[test]
fn a_run_stopped_within_its_first_step_is_stopped_and_not_failed() {
    let folder = tempfile::tempdir().unwrap();
    let interrupt = Interrupt::default();
    let execution = Execution {
        interrupt: interrupt.clone(),
        // A checkpoint is always due.
        checkpoint_interval: std::time::Duration::ZERO,
        ..Execution::default()
    };
    let run = Changed {
        walk: Walk { seed: 1, steps: 9 },
        // A long step, which the request to stop meets: there is nothing to save.
        advance: |_: &mut <Walk as Run>::State, _: &Turn| -> Result<()> {
            interrupt.request();
            Ok(())
        },
    };
    assert_eq!(
        drive(&run, folder.path(), &execution).unwrap(),
        End::Stopped
    );
    let record = Record::read(folder.path()).unwrap().unwrap();
    assert_eq!(record.exit.word(), "stopped");
    assert!(!folder.path().join("checkpoint.bin").exists());
}

#[test]
fn work_whose_process_ends_in_the_middle_of_a_step_is_recorded_as_stopped() {
    let folder = tempfile::tempdir().unwrap();
    let (whole, ended) = (folder.path().join("whole"), folder.path().join("ended"));
    let plan = Walk { seed: 3, steps: 9 };
    drive(&plan, &whole, &Execution::default()).unwrap();
    let interrupt = Interrupt::default();
    let execution = Execution {
        interrupt: interrupt.clone(),
        checkpoint_interval: std::time::Duration::ZERO,
        ..Execution::default()
    };
    let run = Changed {
        walk: plan.clone(),
        // The process ends in the middle of a step, a moment after a signal.
        advance: |state: &mut <Walk as Run>::State, turn: &Turn| -> Result<()> {
            if plan.done(state) == 4 {
                interrupt.request();
                interrupt.record_stop();
                panic!("the process ends");
            }
            plan.advance(state, turn)
        },
    };
    let process = std::panic::AssertUnwindSafe(|| drive(&run, &ended, &execution));
    assert!(std::panic::catch_unwind(process).is_err());
    let record = Record::read(&ended).unwrap().unwrap();
    let by = Some("a signal".into());
    assert_eq!((record.exit, record.done), (Exit::Stopped { by }, Some(4)));
    drive(&plan, &ended, &Execution::default()).unwrap();
    assert_eq!(contents(&whole), contents(&ended));
    // What has ended is left as it ended, by the same signal too.
    drive(&plan, &whole, &execution).unwrap();
    interrupt.record_stop();
    assert_eq!(Record::read(&whole).unwrap().unwrap().exit, Exit::Done);
}

#[test]
fn a_campaign_whose_process_ends_in_the_middle_of_a_step_is_recorded_as_stopped() {
    let folder = tempfile::tempdir().unwrap();
    let walks = Walks::new(2, 9, folder.path());
    let (work, execution) = (walks.work(), Execution::default());
    let path = folder.path();
    let enter =
        || ResultsDirectory::enter(path, &LAYOUT, &walks.settings, &work.identity, &execution);
    let exit = || Record::read(path).unwrap().unwrap().exit;
    let interrupt = Interrupt::default();
    let stops = || {
        assert_eq!(exit(), Exit::Running);
        interrupt.request();
        interrupt.record_stop();
        assert_eq!(exit().word(), "stopped");
        Ok::<_, Error>(End::Finished(()))
    };
    // Work that ends after all has the last word.
    recorded(&work, &enter().unwrap(), &interrupt, stops).unwrap();
    assert_eq!(exit(), Exit::Done);
    extend(path, &interrupt, stops).unwrap();
    assert_eq!(exit(), Exit::Done);
}

/// A walk that knows by a separate file that it is finished, whatever its record says.
struct Marked(Walk);

impl Run for Marked {
    type State = <Walk as Run>::State;
    type Checkpoint = <Walk as Run>::Checkpoint;
    type Answer = <Walk as Run>::Answer;
    type Error = Error;

    fn work(&self) -> Work {
        self.0.work()
    }

    fn length(&self) -> u64 {
        self.0.length()
    }

    fn open(&self, directory: &Path, saved: Option<Self::Checkpoint>) -> Result<Self::State> {
        self.0.open(directory, saved)
    }

    fn done(&self, state: &Self::State) -> u64 {
        self.0.done(state)
    }

    fn advance(&self, state: &mut Self::State, turn: &Turn) -> Result<()> {
        self.0.advance(state, turn)
    }

    fn save(&self, state: &mut Self::State) -> Result<Self::Checkpoint> {
        self.0.save(state)
    }

    fn answer(&self, state: &mut Self::State, directory: &Path) -> Result<Self::Answer> {
        let place = self.0.answer(state, directory)?;
        std::fs::write(directory.join("place.txt"), place.position.to_string()).unwrap();
        Ok(place)
    }

    fn details(&self, _: &mut Self::State, _: &Path) -> Result<serde_json::Value> {
        Ok(serde_json::Value::Null)
    }

    fn finished(&self, directory: &Path, _: Option<&Record>) -> Result<Option<Self::Answer>> {
        let text = std::fs::read_to_string(directory.join("place.txt"));
        Ok(text.ok().map(|text| walk::Place {
            step: self.0.steps,
            position: text.parse().unwrap(),
        }))
    }
}

#[test]
fn a_run_killed_before_its_last_record_is_recorded_as_done_by_the_next() {
    let folder = tempfile::tempdir().unwrap();
    let run = Marked(Walk { seed: 2, steps: 9 });
    let whole = drive(&run, folder.path(), &Execution::default()).unwrap();
    let files = contents(folder.path());
    let done = Record::read(folder.path()).unwrap().unwrap();
    let killed = Record {
        exit: Exit::Running,
        done: Some(0),
        ..done.clone()
    };
    killed.write(folder.path()).unwrap();
    assert_eq!(
        drive(&run, folder.path(), &Execution::default()).unwrap(),
        whole
    );
    assert_eq!(contents(folder.path()), files);
}

#[test]
fn further_work_in_the_directory_of_a_finished_run_is_recorded() {
    let folder = tempfile::tempdir().unwrap();
    let plan = Walk { seed: 4, steps: 9 };
    walk(&plan, folder.path(), &Execution::default()).unwrap();
    let files = contents(folder.path());
    let exit = || Record::read(folder.path()).unwrap().unwrap().exit;
    let interrupt = Interrupt::default();
    let end = extend(folder.path(), &interrupt, || {
        assert_eq!(exit(), Exit::Running);
        Ok::<_, Error>(End::<()>::Stopped)
    });
    assert_eq!((end.unwrap(), exit().word()), (End::Stopped, "stopped"));
    extend(folder.path(), &interrupt, || {
        Ok::<_, Error>(End::Finished(()))
    })
    .unwrap();
    // Equal to what it was, but for the reason of the earlier stop.
    assert_eq!(contents(folder.path()), files);
}
