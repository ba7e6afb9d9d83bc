//! One driver for everything that can be started, advanced, saved, continued and recorded.

use crate::checkpoint::{self, CHECKPOINT, Checkpoint};
use crate::{End, Error, Execution, Exit, Interrupt, Record, Work};
use protomer_io::atomic::remove_abandoned;
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::Value;
use std::fmt::Display;
use std::path::Path;
use std::time::Instant;

/// A run: a task and its input. Its state in memory, with open files, is a separate type.
///
/// A state is only ever saved between two calls of [`advance`](Self::advance), so a run that was
/// interrupted anywhere continues from a state that an uninterrupted run passes through too. An
/// implementation guarantees equal bytes if `open` truncates its files to the part that belongs to
/// the checkpoint, as [`Log::open`](crate::Log::open) does.
pub trait Run {
    /// The state in memory, with its open files.
    type State;
    /// The checkpoint that a state is restored from.
    type Checkpoint: Checkpoint;
    /// The result of the run.
    type Answer: Serialize + DeserializeOwned;
    /// The type of errors.
    type Error: From<Error> + Display;

    /// The kind declared in the container of a checkpoint.
    const CHECKPOINT_KIND: &'static str = "checkpoint";

    /// The identity of the work.
    fn work(&self) -> Work;

    /// The length of the run in its own units: steps, sweeps, epochs.
    fn length(&self) -> u64;

    /// The initial state, or that of a checkpoint.
    ///
    /// # Errors
    /// If the start is invalid, or the files next to the checkpoint do not match it.
    fn open(
        &self,
        directory: &Path,
        saved: Option<Self::Checkpoint>,
    ) -> Result<Self::State, Self::Error>;

    /// The progress of the state, in the units of the length. A run that ends early returns
    /// its length.
    fn done(&self, state: &Self::State) -> u64;

    /// Advances by at least one unit: to the next output, or until the time slice is over.
    ///
    /// # Errors
    /// If a step fails, or a file cannot be written.
    fn advance(&self, state: &mut Self::State, turn: &Turn<'_>) -> Result<(), Self::Error>;

    /// Flushes the outputs to disk and returns the matching checkpoint.
    ///
    /// # Errors
    /// If the file cannot be written.
    fn save(&self, state: &mut Self::State) -> Result<Self::Checkpoint, Self::Error>;

    /// The result so far; at the end, the final result.
    ///
    /// # Errors
    /// If it cannot be computed or written.
    fn answer(
        &self,
        state: &mut Self::State,
        directory: &Path,
    ) -> Result<Self::Answer, Self::Error>;

    /// The details for the record: by default the result so far. Override it if that takes long.
    ///
    /// # Errors
    /// As [`answer`](Self::answer).
    fn details(&self, state: &mut Self::State, directory: &Path) -> Result<Value, Self::Error> {
        let answer = self.answer(state, directory)?;
        let value = serde_json::to_value(answer).map_err(|error| Error::Unwritable {
            content: "the record",
            cause: error.to_string(),
        })?;
        Ok(value)
    }

    /// The result of a finished run, if the directory holds it.
    ///
    /// # Errors
    /// If the result exists but cannot be read.
    fn finished(
        &self,
        directory: &Path,
        record: Option<&Record>,
    ) -> Result<Option<Self::Answer>, Self::Error> {
        let done = record.filter(|record| record.is_done_at(self.length()));
        let answer = done.map(|record| record.read_details(directory));
        Ok(answer.transpose()?)
    }

    /// Checks the files of a finished run against its last checkpoint.
    ///
    /// # Errors
    /// If one was changed or lost since then.
    fn check(&self, _directory: &Path, _saved: &Self::Checkpoint) -> Result<(), Self::Error> {
        Ok(())
    }

    /// The last good state after `advance` has failed, if there is one, so that the run can
    /// be inspected, or continued by a corrected version.
    fn rescue(&self, _state: &mut Self::State) -> Option<Self::Checkpoint> {
        None
    }
}

/// A time slice: it ends when a run must stop or save.
#[derive(Debug)]
pub struct Turn<'a> {
    execution: &'a Execution,
    began: Instant,
}

impl Turn<'_> {
    /// Whether the run has been asked to stop.
    pub fn must_stop(&self) -> bool {
        self.execution.interrupt.is_requested()
    }

    /// Whether the run has been asked to stop, or a checkpoint is due.
    pub fn is_over(&self) -> bool {
        self.must_stop() || self.is_save_due()
    }

    fn is_save_due(&self) -> bool {
        self.began.elapsed() >= self.execution.checkpoint_interval
    }
}

/// Starts or continues a run in a directory, until it is complete or asked to stop. The caller
/// holds the lock of the directory.
///
/// # Errors
/// For a directory that belongs to other work, and the errors of the run itself. `run.json` records
/// the error and the progress. A start that fails leaves the files of an earlier process untouched,
/// because they are the only evidence of what is wrong with them.
pub fn drive<R: Run>(
    run: &R,
    directory: &Path,
    execution: &Execution,
) -> Result<End<R::Answer>, R::Error> {
    // Work that was killed in the middle of a write; the lock of the directory is held.
    if directory.is_dir() {
        remove_abandoned(directory).map_err(Error::from)?;
    }
    let work = run.work();
    // Before the checkpoint is read: a record of other work makes anything else meaningless.
    let record = Record::read(directory)?;
    if let Some(record) = &record {
        record.require(&work.identity, &work.kind, directory)?;
    }
    let checkpoint = directory.join(CHECKPOINT);
    let read = || checkpoint::read(&checkpoint, R::CHECKPOINT_KIND, &work.identity);
    // A finished run answers from its record; its state is not even opened.
    if let Some(answer) = run.finished(directory, record.as_ref())? {
        // The record may have been copied without its files, or these damaged since.
        if let Some(saved) = read()? {
            run.check(directory, &saved)?;
        }
        record_as_done(run, directory, record)?;
        execution.progress.advance(run.length());
        return Ok(End::Finished(answer));
    }
    // Nothing has been started or changed; finished work was handled above.
    if execution.interrupt.is_requested() {
        return Ok(End::Stopped);
    }
    std::fs::create_dir_all(directory).map_err(Error::file("create the directory", directory))?;
    let opened = read()
        .map_err(R::Error::from)
        .and_then(|saved| open(run, directory, saved));
    let mut state = match opened {
        Ok(state) => state,
        Err(error) => {
            // Nothing of an earlier attempt is there: the failure is all there is to record.
            if record.is_none() && !checkpoint.exists() {
                let failed = Record {
                    done: Some(0),
                    ..Record::new(&work, Exit::failed(&error))
                };
                // The error takes precedence, even if it cannot be recorded.
                let _ = failed.write(directory);
            }
            return Err(error);
        }
    };
    Recorded {
        run,
        directory,
        work,
    }
    .live(&mut state, execution)
}

/// Records a finished run as done, if the process that finished it was killed before it could.
fn record_as_done<R: Run>(
    run: &R,
    directory: &Path,
    record: Option<Record>,
) -> Result<(), R::Error> {
    if record
        .as_ref()
        .is_some_and(|record| record.is_done_at(run.length()))
    {
        return Ok(());
    }
    let done = Record {
        done: Some(run.length()),
        details: record.map_or(Value::Null, |record| record.details),
        ..Record::new(&run.work(), Exit::Done)
    };
    Ok(done.write(directory)?)
}

/// Does more work in the directory of a finished run, such as the further trainings of an ablation:
/// its record says that it is running until that work is done too. The caller holds the lock of the
/// directory.
///
/// # Errors
/// The errors of the work; also if the record cannot be read or written.
pub fn extend<T, E: From<Error> + Display>(
    directory: &Path,
    interrupt: &Interrupt,
    more: impl FnOnce() -> Result<End<T>, E>,
) -> Result<End<T>, E> {
    let Some(finished) = Record::read(directory)? else {
        return more();
    };
    let record = |exit| {
        let record = Record {
            exit,
            ..finished.clone()
        };
        record.write(directory)
    };
    // Noted before the record says running, so that a stop
    // of the process in between finds it.
    interrupt.at_work().begin(directory);
    record(Exit::Running)?;
    let end = more();
    let write = |exit| interrupt.at_work().end(directory, || record(exit));
    match &end {
        Ok(End::Finished(_)) => write(Exit::Done)?,
        Ok(End::Stopped) => write(Exit::stopped_by(interrupt))?,
        // The error of the work takes precedence over a failure to record it.
        Err(error) => drop(write(Exit::failed(error))),
    }
    end
}

/// Opens the run; refuses a state beyond its length.
fn open<R: Run>(
    run: &R,
    directory: &Path,
    saved: Option<R::Checkpoint>,
) -> Result<R::State, R::Error> {
    // The checkpoint's state may come from a longer run of the same identity.
    let state = run.open(directory, saved)?;
    let (done, length) = (run.done(&state), run.length());
    if done > length {
        let error = Error::NoContinuation {
            path: directory.to_owned(),
            reason: format!(
                "is at step {done}, which is more than {length}; ask for at least as many"
            ),
        };
        return Err(error.into());
    }
    Ok(state)
}

/// Advances a state until the run is complete or asked to stop, and keeps the checkpoint in
/// `file`. This is [`drive`] without a record and a directory.
///
/// # Errors
/// The errors of the run; the last good state is then in the file, if the run provides it.
pub fn proceed<R: Run>(
    run: &R,
    state: &mut R::State,
    file: &Path,
    execution: &Execution,
) -> Result<End<()>, R::Error> {
    let identity = run.work().identity;
    let write =
        |saved: &R::Checkpoint| checkpoint::write(file, R::CHECKPOINT_KIND, &identity, saved);
    let save = |state: &mut R::State| -> Result<u64, R::Error> {
        // Outputs are flushed in `save`, then the checkpoint refers to them: in
        // this order a crash leaves outputs that are too long and never too short.
        write(&run.save(state)?)?;
        let (done, directory) = (run.done(state), file.parent().unwrap_or(file));
        execution.interrupt.at_work().saved(directory, done);
        Ok(done)
    };
    let begin_turn = || Turn {
        execution,
        began: Instant::now(),
    };
    let mut turn = begin_turn();
    let mut saved_at = run.done(state);
    // Tested between units only: within one a state is not whole.
    while run.done(state) < run.length() && !turn.must_stop() {
        let before = run.done(state);
        if let Err(error) = run.advance(state, &turn) {
            if let Some(saved) = run.rescue(state) {
                // The error takes precedence, even if the state cannot be saved.
                let _ = write(&saved);
            }
            return Err(error);
        }
        execution.progress.advance(run.done(state) - before);
        if turn.is_save_due() {
            // A run that was asked to stop within its first unit has nothing to save.
            if run.done(state) > saved_at {
                saved_at = save(state)?;
            }
            turn = begin_turn();
        }
    }
    let is_finished = run.done(state) >= run.length();
    // At the end always: a finished run keeps a checkpoint from which it can be extended.
    if is_finished || run.done(state) > saved_at {
        save(state)?;
    }
    Ok(if is_finished {
        End::Finished(())
    } else {
        End::Stopped
    })
}

/// A run with its record.
struct Recorded<'a, R> {
    run: &'a R,
    directory: &'a Path,
    work: Work,
}

impl<R: Run> Recorded<'_, R> {
    fn live(
        &self,
        state: &mut R::State,
        execution: &Execution,
    ) -> Result<End<R::Answer>, R::Error> {
        let interrupt = &execution.interrupt;
        // See `extend`: noted before it is written.
        interrupt.at_work().begin(self.directory);
        // The end recorded by an earlier process is no longer valid.
        self.record(state, Exit::Running)?.write(self.directory)?;
        execution.progress.advance(self.run.done(state));
        let end = self.to_the_end(state, execution);
        let mut write = |exit| -> Result<(), R::Error> {
            let record = self.record(state, exit)?;
            let at_work = interrupt.at_work();
            Ok(at_work.end(self.directory, || record.write(self.directory))?)
        };
        match &end {
            Ok(End::Finished(_)) => write(Exit::Done)?,
            Ok(End::Stopped) => write(Exit::stopped_by(interrupt))?,
            // The error of the work takes precedence over a failure to record it, for example on a
            // full disk.
            Err(error) => drop(write(Exit::failed(error))),
        }
        end
    }

    fn to_the_end(
        &self,
        state: &mut R::State,
        execution: &Execution,
    ) -> Result<End<R::Answer>, R::Error> {
        let checkpoint = self.directory.join(CHECKPOINT);
        match proceed(self.run, state, &checkpoint, execution)? {
            End::Finished(()) => self.run.answer(state, self.directory).map(End::Finished),
            End::Stopped => Ok(End::Stopped),
        }
    }

    fn record(&self, state: &mut R::State, exit: Exit) -> Result<Record, R::Error> {
        Ok(Record {
            done: Some(self.run.done(state)),
            details: self.run.details(state, self.directory)?,
            ..Record::new(&self.work, exit)
        })
    }
}
