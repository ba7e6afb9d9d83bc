//! Scores of many complexes: a folder or a table in, one row each out.
//!
//! ```text
//! DIR/run.toml  run.json  score.csv  score.json  score.svg  score.png
//! DIR/rows/NAME/row.json       what is found for one complex, kept as soon as it is done
//! ```
//!
//! A row is known by its name, and by the hashes of its files. The same command computes what is missing: complexes that
//! are new or have changed, and columns that were not requested before.
//!
//! | module | one idea |
//! |---|---|
//! | `settings` | what is requested, as stored in `run.toml` |
//! | `source` | the complexes of a folder or a table |
//! | `record` | what is found for one complex, as stored |
//! | `measure` | the groups of columns, from cheap to expensive |
//! | `geometry` | columns of the structure alone |
//! | `confidence` | columns of the files next to a predicted structure |
//! | `reality` | chance that a contact is more than packing |
//! | `energies` | columns of the model's energy |
//! | `self_attraction` | columns of the parts with their own kind |
//! | `solved` | columns of the Poisson-Boltzmann equation and of the integrated K_D |
//! | `half_salt` | the salt at which half of a complex is bound |
//! | `complex` | one complex, from its files to its record |
//! | `table` | the table of all complexes |
//! | `result` | the answer in words and files |
//! | `figure` | the complexes as points |
//! | [`page`] | the page of a directory |

mod complex;
mod confidence;
mod energies;
pub mod figure;
mod geometry;
mod half_salt;
mod measure;
pub mod page;
mod reality;
mod record;
mod result;
mod self_attraction;
mod settings;
mod solved;
mod source;
mod table;

pub use measure::Measure;
pub use result::ScoreResult;
pub use settings::ScoreSettings;
pub use source::{Complexes, StatedComplex};
pub use table::ShownScores;

use anyhow::{Context, Error, Result};
use complex::score;
use protomer_common::cpu_time::ProcessClock;
use protomer_results::{
    Campaign, End, Execution, Layout, ResultKind, Shard, Work, carry_out, carry_out_shard,
    settings as stored,
};
use record::ScoreRecord;
use result::Cost;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;
use table::ScoreTable;

/// The directory of scores.
pub const LAYOUT: Layout = Layout {
    kind: ResultKind::Scores,
    settings: "run.toml",
    results: &[
        "run.json",
        "score.csv",
        "score.json",
        "score.svg",
        "score.png",
        "report.html",
    ],
    is_result,
};

/// Folder of the records.
const ROWS: &str = "rows";

fn is_result(path: &Path) -> bool {
    path.file_name().is_some_and(|name| name == ROWS) && path.is_dir()
}

/// Scores the complexes, or those that are not done, and writes the table.
///
/// A complex that cannot be scored is a row with the reason.
///
/// # Errors
/// For settings that make no sense, a directory that holds other work or is in use, and files that cannot be written.
///
/// ```no_run
/// use protomer_common::answer::Answer;
/// use protomer_protein_verbs::stability::score::{Complexes, ScoreSettings, run_score};
/// use protomer_results::{End, Execution};
/// use std::path::Path;
/// let complexes = Complexes::read(Path::new("designs"), &[])?;
/// let settings = ScoreSettings { complexes: complexes.0.len(), ..ScoreSettings::default() };
/// if let End::Finished(found) = run_score(&complexes, &settings, Path::new("scores"), &Execution::default())? {
///     println!("{}", found.text());
/// }
/// # Ok::<(), anyhow::Error>(())
/// ```
pub fn run_score(
    complexes: &Complexes,
    settings: &ScoreSettings,
    directory: &Path,
    execution: &Execution,
) -> Result<End<ScoreResult>> {
    settings.check()?;
    let scores = Scores::new(complexes, settings, directory)?;
    carry_out(&scores, directory, &LAYOUT, settings, execution)
}

/// Scores some of the complexes, while other processes score others in the same directory; returns their number.
/// [`run_score`] finds them done and writes the table.
///
/// # Errors
/// As [`run_score`].
pub fn run_score_shard(
    complexes: &Complexes,
    settings: &ScoreSettings,
    directory: &Path,
    shard: Shard,
    execution: &Execution,
) -> Result<End<usize>> {
    settings.check()?;
    let scores = Scores::new(complexes, settings, directory)?;
    carry_out_shard(&scores, directory, &LAYOUT, settings, shard, execution)
}

/// All complexes with their settings.
struct Scores<'a> {
    complexes: &'a Complexes,
    settings: &'a ScoreSettings,
    directory: &'a Path,
    identity: String,
    started: Instant,
    processor: ProcessClock,
    /// Complexes that were found done.
    taken_over: AtomicUsize,
}

impl<'a> Scores<'a> {
    fn new(
        complexes: &'a Complexes,
        settings: &'a ScoreSettings,
        directory: &'a Path,
    ) -> Result<Self> {
        Ok(Self {
            complexes,
            settings,
            directory,
            // Files belong to rows, not to the whole: a folder of designs may grow.
            identity: stored::identity(settings, "")?,
            started: Instant::now(),
            processor: ProcessClock::start(),
            taken_over: AtomicUsize::new(0),
        })
    }
}

impl Campaign for Scores<'_> {
    type Task = StatedComplex;
    type Part = ScoreRecord;
    type Answer = ScoreResult;
    type Error = Error;

    fn work(&self) -> Work {
        Work::new(ResultKind::Scores, "score", &self.identity, "")
    }

    fn tasks(&self) -> &[StatedComplex] {
        &self.complexes.0
    }

    fn length(&self) -> (u64, &'static str) {
        (1, "complexes")
    }

    fn directory(&self, complex: &StatedComplex) -> PathBuf {
        self.directory.join(ROWS).join(&complex.name)
    }

    fn run(
        &self,
        complex: &StatedComplex,
        directory: &Path,
        execution: &Execution,
    ) -> Result<End<ScoreRecord>> {
        if execution.interrupt.is_requested() {
            return Ok(End::Stopped);
        }
        let earlier = ScoreRecord::read(directory)?;
        let part = execution.of_part();
        let place = (directory, &part);
        let end = score(complex, self.settings, earlier.clone(), place);
        let End::Finished(record) = end else {
            return Ok(End::Stopped);
        };
        match earlier.is_some_and(|earlier| earlier == record) {
            true => drop(self.taken_over.fetch_add(1, Ordering::Relaxed)),
            false => {
                std::fs::create_dir_all(directory)
                    .with_context(|| format!("cannot create the folder {}", directory.display()))?;
                record.write(directory)?;
            }
        }
        execution.progress.advance(1);
        Ok(End::Finished(record))
    }

    fn collect(&self, records: Vec<ScoreRecord>) -> Result<ScoreResult> {
        let table = ScoreTable::new(self.complexes, self.settings, &records);
        let cost = Cost {
            taken_over: self.taken_over.load(Ordering::Relaxed),
            seconds: self.started.elapsed().as_secs_f64(),
            cpu_seconds: self.processor.seconds(),
        };
        let place = (self.directory, cost);
        let result = ScoreResult::new(self.complexes, self.settings, &records, &table, place);
        result.write(&table, self.directory)?;
        Ok(result)
    }
}
