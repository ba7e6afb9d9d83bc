//! One driver for everything that can be begun, advanced, saved, continued and recorded.

use crate::checkpoint::{self, CHECKPOINT, Checkpoint};
use crate::{End, Error, Execution, Exit, Record, Work};
use protomer_io::atomic::remove_abandoned;
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::Value;
use std::fmt::Display;
use std::path::Path;
use std::time::Instant;

/// A run: what is to be done, on what. Its state in memory, with open files, is a type of its own.
///
/// A state is only ever saved between two calls of [`advance`](Self::advance), so a run that was
/// cut anywhere continues from a state that an uninterrupted run passes through as well. An
/// implementation keeps the promise of equal bytes if `open` cuts its own files back to what the
/// checkpoint vouches for, as [`Log::open`](crate::Log::open) does.
pub trait Run {
    /// The state in memory, with its open files.
    type State;
    /// What a state is restored from.
    type Checkpoint: Checkpoint;
    /// What the run comes to.
    type Answer: Serialize + DeserializeOwned;
    /// What can go wrong.
    type Error: From<Error> + Display;

    /// What the container of a checkpoint says it holds.
    const CHECKPOINT_KIND: &'static str = "checkpoint";

    /// Which work it is.
    fn work(&self) -> Work;

    /// How long the run is, in units of its own: steps, sweeps, epochs.
    fn length(&self) -> u64;

    /// The state to begin with, or that of a checkpoint.
    ///
    /// # Errors
    /// If the start makes no sense, or the files beside the checkpoint are not those it vouches
    /// for.
    fn open(
        &self,
        directory: &Path,
        saved: Option<Self::Checkpoint>,
    ) -> Result<Self::State, Self::Error>;

    /// How far the state has come, in the units of the length. A run that ends early says its
    /// length.
    fn done(&self, state: &Self::State) -> u64;

    /// Goes on by at least one unit: to the next output, or until the turn is over.
    ///
    /// # Errors
    /// If a step fails, or a file cannot be written.
    fn advance(&self, state: &mut Self::State, turn: &Turn<'_>) -> Result<(), Self::Error>;

    /// Forces the outputs onto the disk and returns the checkpoint that vouches for them.
    ///
    /// # Errors
    /// If the file cannot be written.
    fn save(&self, state: &mut Self::State) -> Result<Self::Checkpoint, Self::Error>;

    /// What the run has come to so far; at the end, what it came to.
    ///
    /// # Errors
    /// If it cannot be computed or written.
    fn answer(
        &self,
        state: &mut Self::State,
        directory: &Path,
    ) -> Result<Self::Answer, Self::Error>;

    /// What the record says of a state: the answer so far, unless that takes long.
    ///
    /// # Errors
    /// As [`answer`](Self::answer).
    fn details(&self, state: &mut Self::State, directory: &Path) -> Result<Value, Self::Error> {
        let answer = self.answer(state, directory)?;
        let value = serde_json::to_value(answer).map_err(|error| Error::Unwritable {
            what: "the record",
            cause: error.to_string(),
        })?;
        Ok(value)
    }

    /// The answer of a run that came to its end earlier, if the directory holds it.
    ///
    /// # Errors
    /// If the directory says so and the answer cannot be read.
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
    /// If one was changed or lost since.
    fn check(&self, _directory: &Path, _saved: &Self::Checkpoint) -> Result<(), Self::Error> {
        Ok(())
    }

    /// The last good state after `advance` has failed, where there is one: the run can then be
    /// looked at, or continued by a version that does not fail.
    fn rescue(&self, _state: &mut Self::State) -> Option<Self::Checkpoint> {
        None
    }
}

/// The time until a run has to look up from its work: to stop, or to save.
#[derive(Debug)]
pub struct Turn<'a> {
    execution: &'a Execution,
    began: Instant,
}

impl Turn<'_> {
    /// Whether the run is asked to stop.
    pub fn must_stop(&self) -> bool {
        self.execution.interrupt.is_requested()
    }

    /// Whether the run is asked to stop, or a checkpoint is due.
    pub fn is_over(&self) -> bool {
        self.must_stop() || self.is_save_due()
    }

    fn is_save_due(&self) -> bool {
        self.began.elapsed() >= self.execution.checkpoint_interval
    }
}

/// Begins a run in a directory, or continues the one that is there, to its end or until it is asked
/// to stop. The caller holds the directory.
///
/// # Errors
/// For a directory that belongs to other work, and what the run itself meets. `run.json` says what
/// happened and how far the run had come; a start that fails leaves the files of an earlier process
/// alone, because what is wrong with them can be seen nowhere else.
pub fn drive<R: Run>(
    run: &R,
    directory: &Path,
    execution: &Execution,
) -> Result<End<R::Answer>, R::Error> {
    if directory.is_dir() {
        remove_abandoned(directory).map_err(Error::from)?;
    }
    let work = run.work();
    let record = Record::read(directory)?;
    if let Some(record) = &record {
        record.require(&work.identity, &work.kind, directory)?;
    }
    let checkpoint = directory.join(CHECKPOINT);
    let read = || checkpoint::read(&checkpoint, R::CHECKPOINT_KIND, &work.identity);
    if let Some(answer) = run.finished(directory, record.as_ref())? {
        if let Some(saved) = read()? {
            run.check(directory, &saved)?;
        }
        execution.progress.advance(run.length());
        return Ok(End::Finished(answer));
    }
    // Neither begun nor touched; what is done already was found above.
    if execution.interrupt.is_requested() {
        return Ok(End::Stopped);
    }
    std::fs::create_dir_all(directory).map_err(Error::file("make the directory", directory))?;
    let opened = read()
        .map_err(R::Error::from)
        .and_then(|saved| open(run, directory, saved));
    let mut state = match opened {
        Ok(state) => state,
        Err(error) => {
            if record.is_none() && !checkpoint.exists() {
                let failed = Record {
                    done: Some(0),
                    ..Record::new(&work, Exit::failed(&error))
                };
                // The error is what counts, also where its record cannot be written.
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

/// Opens the run and refuses a state beyond its length.
fn open<R: Run>(
    run: &R,
    directory: &Path,
    saved: Option<R::Checkpoint>,
) -> Result<R::State, R::Error> {
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

/// Advances a state to the length of its run or until it is asked to stop, and keeps the checkpoint
/// in `file`. This is [`drive`] without a record and a directory.
///
/// # Errors
/// What the run meets; the last good state is then in the file if the run can tell it.
pub fn proceed<R: Run>(
    run: &R,
    state: &mut R::State,
    file: &Path,
    execution: &Execution,
) -> Result<End<()>, R::Error> {
    let identity = run.work().identity;
    let write =
        |saved: &R::Checkpoint| checkpoint::write(file, R::CHECKPOINT_KIND, &identity, saved);
    let begin_turn = || Turn {
        execution,
        began: Instant::now(),
    };
    let mut turn = begin_turn();
    let mut saved_at = run.done(state);
    while run.done(state) < run.length() && !turn.must_stop() {
        let before = run.done(state);
        if let Err(error) = run.advance(state, &turn) {
            if let Some(saved) = run.rescue(state) {
                // The error is what counts, also where the state cannot be kept.
                let _ = write(&saved);
            }
            return Err(error);
        }
        execution.progress.advance(run.done(state) - before);
        if turn.is_save_due() {
            write(&run.save(state)?)?;
            saved_at = run.done(state);
            turn = begin_turn();
        }
    }
    let is_finished = run.done(state) >= run.length();
    if is_finished || run.done(state) > saved_at {
        write(&run.save(state)?)?;
    }
    Ok(if is_finished {
        End::Finished(())
    } else {
        End::Stopped
    })
}

/// A run whose record says how it stands.
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
        // What an earlier process said of its end no longer holds.
        self.record(state, Exit::Running)?;
        execution.progress.advance(self.run.done(state));
        let end = self.to_the_end(state, execution);
        match &end {
            Ok(End::Finished(_)) => self.record(state, Exit::Done)?,
            Ok(End::Stopped) => self.record(state, Exit::stopped_by(&execution.interrupt))?,
            // The error is what counts; on a full disk there may be no room for its record.
            Err(error) => drop(self.record(state, Exit::failed(error))),
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

    fn record(&self, state: &mut R::State, exit: Exit) -> Result<(), R::Error> {
        let record = Record {
            done: Some(self.run.done(state)),
            details: self.run.details(state, self.directory)?,
            ..Record::new(&self.work, exit)
        };
        Ok(record.write(self.directory)?)
    }
}
