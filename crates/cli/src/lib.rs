//! The command line: one file per verb. Data goes to stdout, everything else to stderr.

mod assemble;
mod bench;
mod body;
mod candidates;
mod choices;
mod command;
mod compare;
mod device;
mod execution;
mod fetch;
mod framework;
mod framework_builders;
mod generate;
mod host;
mod ingest;
mod inspect;
mod lattice;
mod medium;
mod merge;
mod output;
mod potential;
mod potential_name;
mod predict;
mod python_source;
mod report;
mod scheduler;
mod scores;
mod simulate;
mod surface;
mod sweep;
mod tables;
mod tolerance;
mod train;
mod tune;
mod voxelize;

use anyhow::{Context, Result, anyhow, bail};
use clap::{Args, Parser, Subcommand};
use protomer_results::{Interrupt, Progress};
use std::ffi::OsString;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

pub use command::Command;
pub use host::{Answer, Host, ProgressListener, UsageError, call};
pub use python_source::python_functions;

/// Coarse-grained protein assembly modelling: structures to rigid bodies, bodies to assemblies,
/// assemblies to stability.
#[derive(Debug, Parser)]
#[command(
    name = "protomer",
    version,
    propagate_version = true,
    max_term_width = 100
)]
pub struct Cli {
    #[command(flatten)]
    global: Global,
    #[command(subcommand)]
    verb: Verb,
}

/// More threads than any machine has cores for.
const MOST_THREADS: usize = 1024;

/// Options every verb understands.
#[derive(Debug, Clone, Args)]
pub struct Global {
    /// Print one JSON object on stdout instead of text.
    #[arg(long, global = true)]
    json: bool,
    /// Threads to use; 0 means all.
    #[arg(
        short = 'j',
        long,
        global = true,
        default_value_t = 0,
        env = "PROTOMER_THREADS"
    )]
    threads: usize,
    /// Say less: errors only.
    #[arg(short, long, global = true)]
    quiet: bool,
    /// Say more: settings and timings.
    #[arg(short, long, global = true)]
    verbose: bool,
    /// Never draw progress bars.
    #[arg(long, global = true)]
    no_progress: bool,
    /// Overwrite results that are already there.
    #[arg(long, global = true)]
    force: bool,
    /// Who asked.
    #[arg(skip)]
    host: Host,
}

#[derive(Debug, Subcommand)]
enum Verb {
    Ingest(ingest::IngestArgs),
    Fetch(fetch::FetchArgs),
    Surface(surface::SurfaceArgs),
    Potential(potential::PotentialArgs),
    Body(body::BodyArgs),
    Assemble(assemble::AssembleArgs),
    Candidates(candidates::CandidatesArgs),
    Compare(compare::CompareArgs),
    Framework(framework::FrameworkArgs),
    Inspect(inspect::InspectArgs),
    Simulate(simulate::SimulateArgs),
    Sweep(sweep::SweepArgs),
    Lattice(lattice::LatticeArgs),
    Report(report::ReportArgs),
    Train(Box<train::TrainArgs>),
    Predict(predict::PredictArgs),
    Tune(Box<tune::TuneArgs>),
    Voxelize(voxelize::VoxelizeArgs),
    Merge(merge::MergeArgs),
    Bench(bench::BenchArgs),
    Completions(generate::CompletionsArgs),
    Man(generate::ManArgs),
}

/// How a verb ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outcome {
    /// Everything asked for is there.
    Done,
    /// Some of the inputs failed; the rest is there.
    Partial,
    /// Stopped early on request; the same command goes on from here.
    Stopped,
}

/// Parses the words of a command line, the program's name first, and runs the verb. Returns the
/// exit code: 0 done, 1 error, 2 usage, 3 stopped early and resumable.
pub fn run(words: impl IntoIterator<Item = OsString>) -> u8 {
    let cli = match Cli::try_parse_from(words) {
        Ok(cli) => cli,
        Err(error) => {
            let error = framework::explain_usage(error);
            // That nobody reads it is no reason to fail otherwise.
            let _ = error.print();
            return u8::try_from(error.exit_code()).unwrap_or(2);
        }
    };
    let start = Instant::now();
    let outcome = cli
        .global
        .build_thread_pool()
        .and_then(|()| cli.verb.run(&cli.global));
    cli.global
        .explain(&format!("{:.2} s", start.elapsed().as_secs_f64()));
    match outcome {
        Ok(Outcome::Done) => 0,
        Ok(Outcome::Partial) => 1,
        Ok(Outcome::Stopped) => 3,
        Err(error) if output::is_broken_pipe(&error) => 0,
        Err(error) => {
            output::note(&format!("error: {error:#}"));
            1
        }
    }
}

impl Verb {
    fn run(&self, global: &Global) -> Result<Outcome> {
        match self {
            Verb::Ingest(args) => args.run(global),
            Verb::Fetch(args) => args.run(global),
            Verb::Surface(args) => args.run(global),
            Verb::Potential(args) => args.run(global),
            Verb::Body(args) => args.run(global),
            Verb::Assemble(args) => args.run(global),
            Verb::Candidates(args) => args.run(global),
            Verb::Compare(args) => args.run(global),
            Verb::Framework(args) => args.run(global),
            Verb::Inspect(args) => args.run(global),
            Verb::Simulate(args) => args.run(global),
            Verb::Sweep(args) => args.run(global),
            Verb::Lattice(args) => args.run(global),
            Verb::Report(args) => args.run(global),
            Verb::Train(args) => args.run(global),
            Verb::Predict(args) => args.run(global),
            Verb::Tune(args) => args.run(global),
            Verb::Voxelize(args) => args.run(global),
            Verb::Merge(args) => args.run(global),
            Verb::Bench(args) => args.run(global),
            Verb::Completions(args) => args.run(),
            Verb::Man(args) => args.run(),
        }
    }
}

impl Global {
    fn checked_threads(&self) -> Result<usize> {
        if self.threads > MOST_THREADS {
            bail!("--threads is {}; give at most {MOST_THREADS}", self.threads);
        }
        Ok(self.threads)
    }

    fn build_thread_pool(&self) -> Result<()> {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(self.checked_threads()?);
        pool.build_global()
            .context("cannot start the threads; try a smaller --threads")
    }

    /// A line for the user, unless quiet.
    fn say(&self, line: &str) {
        if !self.quiet {
            output::note(line);
        }
    }

    /// A line for the user who asked for more.
    fn explain(&self, line: &str) {
        if self.verbose {
            output::note(line);
        }
    }

    /// A bar on a terminal, calls to a program that listens; nothing elsewhere.
    fn progress(&self) -> Arc<dyn Progress> {
        Arc::new(host::Bar::new(self.bar(), self.host.progress.clone()))
    }

    fn bar(&self) -> indicatif::ProgressBar {
        use std::io::IsTerminal;
        if self.quiet || self.no_progress || !std::io::stderr().is_terminal() {
            return indicatif::ProgressBar::hidden();
        }
        let style =
            indicatif::ProgressStyle::with_template("{msg} {wide_bar} {pos}/{len} ({eta} left)");
        let bar = indicatif::ProgressBar::new(0);
        match style {
            Ok(style) => bar.with_style(style),
            Err(_) => bar,
        }
    }
}

/// An interrupt that the first Ctrl-C or SIGTERM requests; the second one ends the process at once.
/// A program that called has an interrupt of its own.
fn interrupt_on_signals(global: &Global, limit_minutes: Option<f64>) -> Result<Interrupt> {
    interrupt_saying(
        global,
        "stopping at the next step; the same command goes on from there",
        limit_minutes,
    )
}

/// As [`interrupt_on_signals`], saying this when the first signal comes.
fn interrupt_saying(
    global: &Global,
    what: &'static str,
    limit_minutes: Option<f64>,
) -> Result<Interrupt> {
    let duration = |minutes: f64| {
        Duration::try_from_secs_f64(minutes * 60.0)
            .map_err(|_| anyhow!("--time-limit is {minutes} minutes; give zero or more"))
    };
    let limit = limit_minutes.map(duration).transpose()?;
    if let Some(interrupt) = &global.host.interrupt {
        return Ok(interrupt.clone().with_limit(limit));
    }
    let interrupt = Interrupt::after(limit);
    let on_signal = interrupt.clone();
    // Not `is_requested`: a time limit that is over as well does not make the first signal the
    // second.
    let signalled = AtomicBool::new(false);
    ctrlc::set_handler(move || {
        if signalled.swap(true, Ordering::Relaxed) {
            std::process::exit(130);
        }
        output::note(&format!("{what} (again: stop at once)"));
        on_signal.request();
    })
    .context("cannot listen for Ctrl-C")?;
    Ok(interrupt)
}
