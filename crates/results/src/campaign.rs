//! Many runs that share a directory: all of them on all threads, or a part of them beside other
//! processes; tables and figures at the end.

use crate::lock::lock;
use crate::{
    End, Error, Execution, Exit, Hold, Interrupt, Record, Result, ResultsDirectory, Shard, Work,
};
use rayon::prelude::*;
use serde_json::Value;
use std::fmt::Display;
use std::path::{Path, PathBuf};

/// Does a list of tasks on all threads. The first that fails asks the others to stop at their next
/// step. A task that finds itself asked before it begins should say [`End::Stopped`], unless it was
/// done earlier.
///
/// ```
/// use protomer_results::{End, Interrupt, each};
/// let double = |number: &u32| Ok::<_, String>(End::Finished(2 * number));
/// assert_eq!(each(&[1, 2, 3], &Interrupt::default(), double), Ok(End::Finished(vec![2, 4, 6])));
/// ```
///
/// # Errors
/// The first error, in the order of the tasks.
pub fn each<T: Sync, A: Send, E: Send>(
    tasks: &[T],
    interrupt: &Interrupt,
    one: impl Fn(&T) -> Result<End<A>, E> + Sync,
) -> Result<End<Vec<A>>, E> {
    let one = |task: &T| one(task).inspect_err(|_| interrupt.request_after_failure());
    // Every task must have come to rest before the first error is looked at.
    let ends: Vec<Result<End<A>, E>> = tasks.par_iter().map(one).collect();
    // An error counts more than a stop that it has caused.
    let ends: Vec<End<A>> = ends.into_iter().collect::<Result<_, E>>()?;
    Ok(ends.into_iter().collect())
}

/// Tasks with directories of their own within one directory.
pub trait Campaign: Sync {
    /// One task.
    type Task: Sync;
    /// What a task comes to.
    type Part: Send;
    /// What all of them come to.
    type Answer;
    /// What can go wrong.
    type Error: From<Error> + Display + Send;

    /// Which work it is.
    fn work(&self) -> Work;

    /// What the record says besides.
    fn details(&self) -> Value {
        Value::Null
    }

    /// The tasks, in an order that never changes: parts of the campaign are told by their numbers.
    fn tasks(&self) -> &[Self::Task];

    /// The directory of a task.
    fn directory(&self, task: &Self::Task) -> PathBuf;

    /// Does a task in its directory, or continues it.
    ///
    /// # Errors
    /// What the task meets, with its name.
    fn run(
        &self,
        task: &Self::Task,
        directory: &Path,
        execution: &Execution,
    ) -> Result<End<Self::Part>, Self::Error>;

    /// Makes tables and figures of what all tasks came to, in their order, and writes them.
    ///
    /// # Errors
    /// If a file of a task is damaged, or a file cannot be written.
    fn collect(&self, parts: Vec<Self::Part>) -> Result<Self::Answer, Self::Error>;
}

/// Does all tasks of a campaign, or what is left of them, and collects what they came to.
///
/// # Errors
/// The first task that fails stops the others at their next step; what they did is kept, and
/// `run.json` says what happened.
pub fn conduct<C: Campaign>(
    campaign: &C,
    directory: &ResultsDirectory,
    execution: &Execution,
) -> Result<End<C::Answer>, C::Error> {
    let details = campaign.details();
    let work = campaign.work();
    let all = || to_the_end(campaign, execution);
    recorded_with(&work, details, directory, &execution.interrupt, all)
}

/// Does some work and keeps the record of its directory: running, and then how it ended.
///
/// # Errors
/// As the work; also if the record cannot be written.
pub fn recorded<T, E: From<Error> + Display>(
    work: &Work,
    directory: &ResultsDirectory,
    interrupt: &Interrupt,
    run: impl FnOnce() -> Result<End<T>, E>,
) -> Result<End<T>, E> {
    recorded_with(work, Value::Null, directory, interrupt, run)
}

fn recorded_with<T, E: From<Error> + Display>(
    work: &Work,
    details: Value,
    directory: &ResultsDirectory,
    interrupt: &Interrupt,
    run: impl FnOnce() -> Result<End<T>, E>,
) -> Result<End<T>, E> {
    let path = directory.path();
    let record = |exit| {
        let details = details.clone();
        Record {
            details,
            ..Record::new(work, exit)
        }
    };
    // Finished work stays finished, whatever becomes of a second look at it. Work that is to be
    // longer is no longer finished.
    let present = Record::read(path)?;
    let was_done = !directory.settings_are_new() && present.is_some_and(|record| record.is_done());
    if !was_done {
        record(Exit::Running).write(path)?;
    }
    let end = run();
    match &end {
        Ok(End::Finished(_)) => record(Exit::Done).write(path)?,
        Ok(End::Stopped) => record(Exit::stopped_by(interrupt)).write(path)?,
        Err(_) if was_done => {}
        // The error is what counts; on a full disk there may be no room for its record.
        Err(error) => drop(record(Exit::failed(error)).write(path)),
    }
    end
}

fn to_the_end<C: Campaign>(
    campaign: &C,
    execution: &Execution,
) -> Result<End<C::Answer>, C::Error> {
    let one = |task: &C::Task| campaign.run(task, &campaign.directory(task), execution);
    match each(campaign.tasks(), &execution.interrupt, one)? {
        End::Finished(parts) => campaign.collect(parts).map(End::Finished),
        End::Stopped => Ok(End::Stopped),
    }
}

/// Does the tasks of one part of a campaign while other processes do other parts in the same
/// directory, and returns their number. [`conduct`] finds them done and collects them.
///
/// # Errors
/// As [`conduct`]; also if another process works on one of the tasks.
pub fn conduct_shard<C: Campaign>(
    campaign: &C,
    directory: &ResultsDirectory,
    shard: Shard,
    execution: &Execution,
) -> Result<End<usize>, C::Error> {
    if directory.settings_are_new() {
        let running = Record {
            details: campaign.details(),
            ..Record::new(&campaign.work(), Exit::Running)
        };
        running.write(directory.path())?;
    }
    let numbered = campaign.tasks().iter().enumerate();
    let ours: Vec<&C::Task> = numbered
        .filter(|(number, _)| shard.has(*number))
        .map(|(_, task)| task)
        .collect();
    let one = |task: &&C::Task| {
        let path = campaign.directory(task);
        std::fs::create_dir_all(&path).map_err(Error::file("make the directory", &path))?;
        // A process that was given up for lost may still be at work here.
        let _alone = lock(&path, Hold::Alone)?;
        campaign.run(task, &path, execution)
    };
    let parts = each(&ours, &execution.interrupt, one)?;
    Ok(parts.map(|parts| parts.len()))
}
