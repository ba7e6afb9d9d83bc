//! Many runs that share a directory: all of them on all threads, or a part of them alongside
//! other processes; tables and figures at the end.

use crate::lock::lock;
use crate::{
    End, Error, Execution, Exit, Hold, Interrupt, Layout, Record, Result, ResultsDirectory,
    Settings, Shard, Work,
};
use rayon::prelude::*;
use serde_json::Value;
use std::fmt::Display;
use std::path::{Path, PathBuf};

/// Does a list of tasks on all threads. The first that fails asks the others to stop at their next
/// step. A task that is asked to stop before it begins should return [`End::Stopped`], unless it
/// was done earlier.
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
    // In the closure of each task, so that the others hear of it at once.
    let one = |task: &T| one(task).inspect_err(|_| interrupt.request_after_failure());
    // All tasks must have ended before the first error is reported.
    let ends: Vec<Result<End<A>, E>> = tasks.par_iter().map(one).collect();
    // An error takes precedence over the stops it has caused.
    let ends: Vec<End<A>> = ends.into_iter().collect::<Result<_, E>>()?;
    Ok(ends.into_iter().collect())
}

/// Tasks with their own subdirectories in one directory.
pub trait Campaign: Sync {
    /// One task.
    type Task: Sync;
    /// The result of a task.
    type Part: Send;
    /// The combined result.
    type Answer;
    /// The type of errors.
    type Error: From<Error> + Display + Send;

    /// True where [`run`](Self::run) enters the directory of its task and so locks it.
    const ENTERS_DIRECTORIES: bool = false;

    /// The identity of the work.
    fn work(&self) -> Work;

    /// Further details for the record.
    fn details(&self) -> Value {
        Value::Null
    }

    /// Further details for the record of the finished campaign.
    fn details_of(&self, _answer: &Self::Answer) -> Value {
        self.details()
    }

    /// The tasks, in a fixed order: parts of the campaign are defined by task numbers.
    fn tasks(&self) -> &[Self::Task];

    /// Progress of one task: how many steps it has, and their name.
    fn length(&self) -> (u64, &'static str) {
        (1, "runs")
    }

    /// The directory of a task.
    fn directory(&self, task: &Self::Task) -> PathBuf;

    /// Runs or continues a task in its directory.
    ///
    /// # Errors
    /// The errors of the task, with its name.
    fn run(
        &self,
        task: &Self::Task,
        directory: &Path,
        execution: &Execution,
    ) -> Result<End<Self::Part>, Self::Error>;

    /// Writes tables and figures from the results of all tasks, in their order.
    ///
    /// # Errors
    /// If a file of a task is damaged, or a file cannot be written.
    fn collect(&self, parts: Vec<Self::Part>) -> Result<Self::Answer, Self::Error>;
}

/// Runs the remaining tasks of a campaign and collects their results.
///
/// # Errors
/// If a task fails, the others stop at their next step and keep their progress, and
/// `run.json` records the error.
pub fn conduct<C: Campaign>(
    campaign: &C,
    directory: &ResultsDirectory,
    execution: &Execution,
) -> Result<End<C::Answer>, C::Error> {
    let details = |answer: Option<&C::Answer>| match answer {
        Some(answer) => campaign.details_of(answer),
        None => campaign.details(),
    };
    let work = campaign.work();
    let all = || to_the_end(campaign, execution);
    recorded_with(&work, &details, directory, &execution.interrupt, all)
}

/// Runs some work and keeps the record of its directory up to date: running, then how it ended.
///
/// # Errors
/// The errors of the work; also if the record cannot be written.
pub fn recorded<T, E: From<Error> + Display>(
    work: &Work,
    directory: &ResultsDirectory,
    interrupt: &Interrupt,
    run: impl FnOnce() -> Result<End<T>, E>,
) -> Result<End<T>, E> {
    recorded_with(work, &|_| Value::Null, directory, interrupt, run)
}

fn recorded_with<T, E: From<Error> + Display>(
    work: &Work,
    details: &dyn Fn(Option<&T>) -> Value,
    directory: &ResultsDirectory,
    interrupt: &Interrupt,
    run: impl FnOnce() -> Result<End<T>, E>,
) -> Result<End<T>, E> {
    let path = directory.path();
    let at_work = interrupt.at_work();
    let record = |exit, answer: Option<&T>| Record {
        details: details(answer),
        ..Record::new(work, exit)
    };
    // Finished work stays finished, even if a later call fails. Work that has been extended is
    // no longer finished.
    let present = Record::read(path)?;
    // Extended work has new settings on disk, and its old record says done.
    let was_done = !directory.settings_are_new() && present.is_some_and(|record| record.is_done());
    if !was_done {
        at_work.begin(path);
        record(Exit::Running, None).write(path)?;
    }
    let end = run();
    // Under the lock of `at_work`: the end of the process must not overwrite this record.
    let write = |exit, answer| at_work.end(path, || record(exit, answer).write(path));
    match &end {
        Ok(End::Finished(answer)) => write(Exit::Done, Some(answer))?,
        Ok(End::Stopped) => write(Exit::stopped_by(interrupt), None)?,
        Err(_) if was_done => {}
        // The error of the work takes precedence over a failure to record it, for example on a full
        // disk.
        Err(error) => drop(write(Exit::failed(error), None)),
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

/// Enters the directory of a campaign, runs the remaining tasks and collects their results.
///
/// # Errors
/// As [`ResultsDirectory::enter`] and [`conduct`].
pub fn carry_out<C: Campaign, S: Settings>(
    campaign: &C,
    path: &Path,
    layout: &Layout,
    settings: &S,
    execution: &Execution,
) -> Result<End<C::Answer>, C::Error> {
    let identity = campaign.work().identity;
    let entered = ResultsDirectory::enter(path, layout, settings, &identity, execution)?;
    begin(campaign, campaign.tasks().len(), execution);
    conduct(campaign, &entered, execution)
}

/// Enters the directory of a campaign alongside other processes and runs the tasks of one part of it; returns their number.
///
/// # Errors
/// As [`ResultsDirectory::share`] and [`conduct_shard`].
pub fn carry_out_shard<C: Campaign, S: Settings>(
    campaign: &C,
    path: &Path,
    layout: &Layout,
    settings: &S,
    shard: Shard,
    execution: &Execution,
) -> Result<End<usize>, C::Error> {
    let identity = campaign.work().identity;
    let entered = ResultsDirectory::share(path, layout, settings, &identity, execution)?;
    let numbers = 0..campaign.tasks().len();
    let ours = numbers.filter(|number| shard.has(*number)).count();
    begin(campaign, ours, execution);
    conduct_shard(campaign, &entered, shard, execution)
}

/// Announces the progress of some tasks.
fn begin<C: Campaign>(campaign: &C, tasks: usize, execution: &Execution) {
    let (steps, name) = campaign.length();
    let total = steps.saturating_mul(tasks as u64);
    execution.progress.begin(total, name);
}

/// Runs the tasks of one part of a campaign while other processes run other parts in the same
/// directory, and returns their number. [`conduct`] then finds them done and collects the results.
///
/// # Errors
/// As [`conduct`]; also if another process works on one of the tasks.
pub fn conduct_shard<C: Campaign>(
    campaign: &C,
    directory: &ResultsDirectory,
    shard: Shard,
    execution: &Execution,
) -> Result<End<usize>, C::Error> {
    // Whoever wrote the settings is first and writes the record; the others find it.
    if directory.settings_are_new() {
        let running = Record {
            details: campaign.details(),
            ..Record::new(&campaign.work(), Exit::Running)
        };
        running.write(directory.path())?;
    }
    let mut ours = Vec::new();
    for (number, task) in campaign.tasks().iter().enumerate() {
        // By number in a fixed order: all processes divide the tasks alike without talking.
        if shard.has(number) {
            ours.push(task);
        }
    }
    let one = |task: &&C::Task| {
        let path = campaign.directory(task);
        // The lock file lies in the task's directory, which must exist for it.
        std::fs::create_dir_all(&path).map_err(Error::file("create the directory", &path))?;
        // A process that was presumed lost may still be at work here.
        let _alone = match C::ENTERS_DIRECTORIES {
            true => None,
            false => Some(lock(&path, Hold::Alone)?),
        };
        campaign.run(task, &path, execution)
    };
    let parts = each(&ours, &execution.interrupt, one)?;
    Ok(parts.map(|parts| parts.len()))
}
