//! Converts very many structure files to body files: in bounded memory, with tables instead of an
//! answer per file, in parts, and with continuation.
//!
//! Files are converted in blocks. After each block the rows of its files are appended to two tables in the folder
//! of the bodies, `ingest.csv` (a row per file) and `warnings.csv` (a row per warning or error), and
//! `ingest.json` vouches for their lengths. A run that was killed anywhere cuts the tables back to that,
//! removes files that were not finished and converts the rest; a body that is already there is
//! recognised by its bytes. So the folder equals that of an uninterrupted run byte for byte.
//!
//! An error in a file is a row. An error of writing, such as a full disk, says nothing of the file: it ends
//! the stream, and the same command continues there. The table holds the SHA-256 of
//! every file, so files that have changed since are noticed.

use super::ingest::{FileOutcome, IngestSettings, body_names, ingest_one};
use super::tables::{FileRow, Paths, Tables, record_of};
use anyhow::{Context, Result, bail};
use protomer_common::answer::Answer;
use protomer_common::input::InputFile;
use protomer_io::atomic::write_atomically;
use protomer_io::digest::Digest;
use protomer_results::{End, Execution, Interrupt, LogMark, Shard, log};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

/// Files of a block per thread: enough that threads rarely wait for the slowest.
const FILES_PER_THREAD: usize = 16;
/// Version of the tables. Increase it with every change of their columns.
const FORMAT: u32 = 2;

/// State in which a stream ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum StreamState {
    /// All files are done.
    Finished,
    /// The stream was stopped on request; the same command continues it.
    Stopped,
}

/// The result of a stream: numbers, and where the tables are.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct StreamReport {
    /// The table with a row per file.
    pub table: PathBuf,
    /// The table with a row per warning or error.
    pub warnings_table: PathBuf,
    /// State in which the stream ended.
    pub state: StreamState,
    /// Number of files, or of those of the part.
    pub files: usize,
    /// Files that were converted in an earlier run.
    pub taken_over: usize,
    /// Files that were converted.
    pub ok: usize,
    /// Files that failed.
    pub failed: usize,
    /// Warnings.
    pub warnings: usize,
    /// Wall time, s.
    pub seconds: f64,
}

impl Answer for StreamReport {
    fn text(&self) -> String {
        let done = self.ok + self.failed;
        let rate = (done - self.taken_over) as f64 / self.seconds.max(1e-3);
        let stopped = match self.state {
            StreamState::Finished => String::new(),
            StreamState::Stopped => format!("stopped: {done} of {} files done\n", self.files),
        };
        format!(
            "{stopped}{} bodies, {} failed, {} warnings, {rate:.1} files per second\n{}\n{}",
            self.ok,
            self.failed,
            self.warnings,
            self.table.display(),
            self.warnings_table.display()
        )
    }
}

/// Progress as of the last block.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Done {
    /// SHA-256 of the settings and the names of the files.
    identity: String,
    ok: usize,
    failed: usize,
    warnings: usize,
    table: LogMark,
    warnings_table: LogMark,
}

impl Done {
    /// Appends the rows of a file and counts it.
    fn add(&mut self, outcome: &FileOutcome, tables: &mut Tables) -> Result<()> {
        tables.append(&record_of(outcome))?;
        self.warnings += outcome.warnings.len();
        match outcome.error {
            None => self.ok += 1,
            Some(_) => self.failed += 1,
        }
        Ok(())
    }
}

fn resumable(error: anyhow::Error) -> anyhow::Error {
    error.context("the stream has ended early; once this is mended, the same command continues it")
}

/// Ingests every file of a part into `folder`. With `execution.start_anew` the tables begin again.
///
/// # Errors
/// If the folder or a body cannot be written, the folder is in use by another process or holds the
/// tables of other files or settings, a file has changed since it was converted, or two files would
/// give the same body. An error in a single file is a row of the tables.
///
/// ```no_run
/// use protomer_protein_verbs::bodies::ingest::IngestSettings;
/// use protomer_protein_verbs::bodies::stream::ingest_stream;
/// use protomer_common::answer::Answer;
/// use protomer_results::{Execution, Shard};
/// use std::path::{Path, PathBuf};
/// let files = [PathBuf::from("5pti.cif.gz"), PathBuf::from("4e43.pdb.gz")];
/// let (settings, execution) = (IngestSettings::default(), Execution::default());
/// let report = ingest_stream(&files, Path::new("bodies"), &settings, Shard::WHOLE, &execution)?;
/// println!("{}", report.text());
/// # Ok::<(), anyhow::Error>(())
/// ```
pub fn ingest_stream(
    files: &[PathBuf],
    folder: &Path,
    settings: &IngestSettings,
    shard: Shard,
    execution: &Execution,
) -> Result<StreamReport> {
    settings.body.surface.check()?;
    let mut jobs = Vec::new();
    for (number, (file, name)) in files.iter().zip(body_names(files, settings)?).enumerate() {
        if shard.has(number) {
            jobs.push((file, name));
        }
    }
    let (paths, _held) = Paths::claim(folder, shard)?;
    let stream = Stream {
        jobs,
        folder,
        settings,
        identity: identity(files, settings, shard)?,
        paths,
    };
    stream.run(execution)
}

/// SHA-256 of what decides the rows, and of the version that wrote them.
fn identity(files: &[PathBuf], settings: &IngestSettings, shard: Shard) -> Result<String> {
    let (body, exports) = (&settings.body, &settings.exports);
    let version = env!("CARGO_PKG_VERSION");
    let digest = Digest::of_written(|writer| {
        write!(
            writer,
            "{FORMAT}\n{version}\n{body:?}\n{exports:?}\n{shard:?}\n"
        )?;
        for file in files {
            writeln!(writer, "{}", file.display())?;
        }
        Ok(())
    })?;
    Ok(digest.to_string())
}

struct Stream<'a> {
    jobs: Vec<(&'a PathBuf, String)>,
    folder: &'a Path,
    settings: &'a IngestSettings,
    identity: String,
    paths: Paths,
}

impl Stream<'_> {
    fn run(&self, execution: &Execution) -> Result<StreamReport> {
        let start = Instant::now();
        let bodies = self.jobs.iter().map(|(_, name)| name.as_str());
        self.paths
            // What a killed run left unfinished, before anything is converted again.
            .remove_unfinished(self.folder, &bodies.collect())?;
        let mut done = self.begin(execution.start_anew)?;
        // Cut to what was vouched for: rows beyond belong to files that are done again.
        let mut tables = Tables::open(&self.paths, [&done.table, &done.warnings_table])?;
        let taken_over = done.ok + done.failed;
        let progress = execution.progress.as_ref();
        progress.begin(self.jobs.len() as u64, "structures");
        // Rows are matched with files by their place, so files must still be what they were.
        if self.check_inputs(taken_over, &execution.interrupt)? == End::Stopped {
            return Ok(self.report(StreamState::Stopped, taken_over, &done, start));
        }
        progress.advance(taken_over as u64);
        // A block is the unit of loss: what a kill undoes.
        let block = FILES_PER_THREAD * rayon::current_num_threads();
        let mut state = StreamState::Finished;
        for jobs in self.jobs[taken_over..].chunks(block) {
            if execution.interrupt.is_requested() {
                state = StreamState::Stopped;
                break;
            }
            let end = self.convert(jobs, execution, &mut done, &mut tables);
            // Tables on disk first, then what vouches for their lengths.
            (done.table, done.warnings_table) = tables.sync()?;
            self.save(&done)?;
            // Only now: rows before the error are safe.
            if end? == End::Stopped {
                state = StreamState::Stopped;
                break;
            }
        }
        Ok(self.report(state, taken_over, &done, start))
    }

    /// Converts the files of a block and appends the rows of those at its beginning that are done, up to
    /// one that was not begun or whose body could not be written.
    fn convert(
        &self,
        jobs: &[(&PathBuf, String)],
        execution: &Execution,
        done: &mut Done,
        tables: &mut Tables,
    ) -> Result<End<()>> {
        let cannot_go_on = AtomicBool::new(false);
        let one = |(file, name): &(&PathBuf, String)| {
            // Nobody begins a further file once writing has failed.
            if execution.interrupt.is_requested() || cannot_go_on.load(Ordering::Relaxed) {
                return Ok(End::Stopped);
            }
            let outcome = ingest_one(file, name, self.folder, self.settings);
            let outcome = outcome.inspect_err(|_| cannot_go_on.store(true, Ordering::Relaxed))?;
            execution.progress.advance(1);
            Ok(End::Finished(outcome))
        };
        let ends: Vec<Result<End<FileOutcome>>> = jobs.par_iter().map(one).collect();
        let mut ends = ends.into_iter();
        // Only rows without a gap before them: continuation counts files from the beginning.
        for end in ends.by_ref() {
            match end {
                Ok(End::Finished(outcome)) => done.add(&outcome, tables)?,
                // An error takes precedence over the stops it has caused.
                Ok(End::Stopped) => {
                    let error = ends.find_map(Result::err);
                    return error.map_or(Ok(End::Stopped), |error| Err(resumable(error)));
                }
                Err(error) => return Err(resumable(error)),
            }
        }
        Ok(End::Finished(()))
    }

    /// Refuses to continue if a file is no longer what it was when it was converted.
    fn check_inputs(&self, converted: usize, interrupt: &Interrupt) -> Result<End<()>> {
        if converted == 0 {
            return Ok(End::Finished(()));
        }
        let rows: Vec<FileRow> = log::read(&self.paths.table)?;
        let converted: Vec<_> = self.jobs[..converted].iter().zip(&rows).collect();
        let one = |((file, _), row): &(&(&PathBuf, String), &FileRow)| {
            if interrupt.is_requested() {
                return Ok(End::Stopped);
            }
            // A file that is gone has no digest, which differs from any.
            let now = InputFile::sha256_of(file).unwrap_or_default();
            if now != row.sha256() {
                bail!(
                    "{} has changed since {} was made of it; choose another folder, or start again \
                     with --force",
                    file.display(),
                    self.paths.table.display()
                );
            }
            Ok(End::Finished(()))
        };
        let ends: Result<Vec<End<()>>> = converted.par_iter().map(one).collect();
        let end: End<Vec<()>> = ends?.into_iter().collect();
        Ok(end.map(drop))
    }

    fn report(
        &self,
        state: StreamState,
        taken_over: usize,
        done: &Done,
        start: Instant,
    ) -> StreamReport {
        StreamReport {
            table: self.paths.table.clone(),
            warnings_table: self.paths.warnings_table.clone(),
            state,
            files: self.jobs.len(),
            taken_over,
            ok: done.ok,
            failed: done.failed,
            warnings: done.warnings,
            seconds: start.elapsed().as_secs_f64(),
        }
    }

    /// Progress of earlier runs; none if the tables begin again.
    fn begin(&self, start_anew: bool) -> Result<Done> {
        let path = &self.paths.done;
        if start_anew || !path.exists() {
            return Ok(Done {
                identity: self.identity.clone(),
                ok: 0,
                failed: 0,
                warnings: 0,
                table: LogMark::default(),
                warnings_table: LogMark::default(),
            });
        }
        let shown = path.display();
        let text = protomer_io::input::read_to_string(path)
            .with_context(|| format!("cannot read {shown}"))?;
        let done: Done = serde_json::from_str(&text)
            .with_context(|| format!("{shown} is damaged; start again with --force"))?;
        if done.identity != self.identity || done.ok + done.failed > self.jobs.len() {
            bail!(
                "{shown} belongs to other files or settings; choose another folder, or start again \
                 with --force"
            );
        }
        Ok(done)
    }

    fn save(&self, done: &Done) -> Result<()> {
        let text = serde_json::to_string_pretty(done)?;
        Ok(write_atomically(&self.paths.done, |file| {
            file.write_all(text.as_bytes())
        })?)
    }
}

#[cfg(test)]
mod tests {
    use super::super::tables::WarningRow;
    use super::*;
    use std::collections::BTreeMap;

    /// A glycine somewhere; every seventh file holds none.
    fn structures(folder: &Path, count: usize) -> Vec<PathBuf> {
        let mut files = Vec::new();
        for number in 0..count {
            let mut text = String::new();
            for (serial, (name, x)) in [("N", 0.0), ("CA", 1.46), ("C", 2.0), ("O", 1.4)]
                .into_iter()
                .enumerate()
            {
                let (y, z) = (serial as f64 * 0.7, number as f64 * 0.01);
                text += &format!(
                    "ATOM  {:>5}  {name:<3} GLY A   1    {x:>8.3}{y:>8.3}{z:>8.3}  1.00  0.00           {}\n",
                    serial + 1,
                    &name[..1]
                );
            }
            let path = folder.join(format!("s{number:05}.pdb"));
            let content = if number % 7 == 3 { "END\n" } else { &text };
            std::fs::write(&path, content).unwrap();
            files.push(path);
        }
        files
    }

    fn settings() -> IngestSettings {
        let mut settings = IngestSettings::default();
        settings.body.surface.density_per_angstrom2 = 0.2;
        settings
    }

    /// The bytes of every file of a folder, but locks.
    fn contents(folder: &Path) -> BTreeMap<String, Vec<u8>> {
        let mut contents = BTreeMap::new();
        for entry in folder.read_dir().unwrap() {
            let path = entry.unwrap().path();
            let name = path.file_name().unwrap().to_string_lossy().into_owned();
            if !name.starts_with('.') {
                let text = std::fs::read(&path).unwrap();
                contents.insert(name, text);
            }
        }
        contents
    }

    #[test]
    fn a_stream_that_was_killed_and_continued_equals_one_that_was_not() {
        let inputs = tempfile::tempdir().unwrap();
        let files = structures(inputs.path(), 70);
        let run = |folder: &Path, execution: &Execution| {
            // One thread: blocks of 16 files.
            let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build();
            pool.unwrap()
                .install(|| ingest_stream(&files, folder, &settings(), Shard::WHOLE, execution))
        };
        let place = tempfile::tempdir().unwrap();
        let folder = place.path().join("bodies");
        let report = run(&folder, &Execution::default()).unwrap();
        assert_eq!((report.ok, report.failed), (60, 10));
        let whole = contents(&folder);
        assert_eq!(whole.len(), 60 + 3);
        let rows = protomer_results::log::read::<FileRow>(&report.table).unwrap();
        assert_eq!(rows.len(), 70);
        let messages = protomer_results::log::read::<WarningRow>(&report.warnings_table).unwrap();
        assert_eq!(messages.len(), report.warnings + report.failed);

        // As a process killed in the first block leaves it: half a row, and a body without one.
        std::fs::remove_dir_all(&folder).unwrap();
        let stop = Execution::default();
        stop.interrupt.request();
        let stopped = run(&folder, &stop).unwrap();
        assert_eq!((stopped.state, stopped.ok), (StreamState::Stopped, 0));
        ingest_one(&files[0], "s00000", &folder, &settings()).unwrap();
        std::fs::write(folder.join("ingest.csv"), "file,status\ns0000").unwrap();
        let unfinished = [".s00001.body.12-3.partial", ".ingest.json.12-4.partial"];
        let of_others = folder.join(".s00099.body.13-3.partial");
        for name in unfinished {
            std::fs::write(folder.join(name), "half").unwrap();
        }
        std::fs::write(&of_others, "half").unwrap();
        assert_eq!(run(&folder, &Execution::default()).unwrap().ok, 60);
        assert_eq!(contents(&folder), whole);
        assert!(unfinished.iter().all(|name| !folder.join(name).exists()));
        assert!(of_others.exists());
        std::fs::remove_file(of_others).unwrap();

        // The tables as they are after the third of five blocks, and more.
        let mut done: Done = serde_json::from_slice(&whole["ingest.json"]).unwrap();
        let cut = |name: &str, rows: usize| -> LogMark {
            let text = String::from_utf8(whole[name].clone()).unwrap();
            let lines: Vec<&str> = text.split_inclusive('\n').take(rows + 1).collect();
            let text = lines.concat();
            std::fs::write(folder.join(name), format!("{text}more, and half a ro")).unwrap();
            LogMark {
                bytes: text.len() as u64,
                sha256: Digest::hash(text.as_bytes()).to_string(),
            }
        };
        let failed = (0..48).filter(|number| number % 7 == 3).count();
        let told: usize = rows[..48]
            .iter()
            .map(|row| row.0[11].parse::<usize>().unwrap())
            .sum();
        done.table = cut("ingest.csv", 48);
        done.warnings_table = cut("warnings.csv", told + failed);
        (done.ok, done.failed, done.warnings) = (48 - failed, failed, told);
        std::fs::write(
            folder.join("ingest.json"),
            serde_json::to_string_pretty(&done).unwrap(),
        )
        .unwrap();
        for number in 48..70 {
            let _ = std::fs::remove_file(folder.join(format!("s{number:05}.body")));
        }
        let continued = run(&folder, &Execution::default()).unwrap();
        assert_eq!((continued.taken_over, continued.ok), (48, 60));
        assert_eq!(contents(&folder), whole);
    }

    #[test]
    fn parts_hold_all_files_and_other_settings_are_refused() {
        let inputs = tempfile::tempdir().unwrap();
        let files = structures(inputs.path(), 9);
        let folder = inputs.path().join("bodies");
        let mut rows = 0;
        for index in 1..=2 {
            let part = Shard { index, of: 2 };
            let report =
                ingest_stream(&files, &folder, &settings(), part, &Execution::default()).unwrap();
            rows += report.files;
        }
        assert_eq!(rows, 9);
        let mut other = settings();
        other.body.surface.density_per_angstrom2 = 0.3;
        let part = Shard { index: 1, of: 2 };
        let refusal = ingest_stream(&files, &folder, &other, part, &Execution::default());
        let refusal = format!("{:#}", refusal.unwrap_err());
        assert!(refusal.contains("other files or settings"), "{refusal}");
    }

    #[test]
    fn settings_that_no_file_can_have_stop_everything() {
        let folder = tempfile::tempdir().unwrap();
        let output = folder.path().join("bodies");
        let mut wrong = settings();
        wrong.body.surface.lattice_spacing_angstrom = 3.0;
        let whole = Shard { index: 1, of: 1 };
        let files = [PathBuf::from("never-read.pdb")];
        let refusal = ingest_stream(&files, &output, &wrong, whole, &Execution::default());
        let refusal = refusal.unwrap_err().to_string();
        assert!(refusal.contains("a spacing of 3 Å"), "{refusal}");
        assert!(!output.exists());
        wrong.body.surface.lattice_spacing_angstrom = 0.3;
        wrong.body.surface.density_per_angstrom2 = -1.0;
        let refusal = crate::bodies::ingest::ingest_files(&files, &output, &wrong, &());
        assert!(refusal.is_err() && !output.exists());
    }
}
