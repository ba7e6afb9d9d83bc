//! What a verb knows of whoever called it: the flags that every verb understands, and ways to say
//! something meanwhile, to show progress, and to be stopped.

use crate::host::{Bar, Host};
use crate::reply::note;
use anyhow::{Context, Result, anyhow, bail};
use clap::Args;
use protomer_results::{Execution, Interrupt, Progress};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// More threads than any machine has cores for.
const MOST_THREADS: usize = 1024;

/// Options every verb understands.
#[derive(Debug, Clone, Args)]
pub struct Global {
    /// Print one JSON object on stdout instead of text.
    #[arg(long, global = true)]
    pub json: bool,
    /// Threads to use; 0 means all.
    #[arg(
        short = 'j',
        long,
        global = true,
        default_value_t = 0,
        env = "PROTOMER_THREADS"
    )]
    pub threads: usize,
    /// Say less: errors only.
    #[arg(short, long, global = true)]
    pub quiet: bool,
    /// Say more: settings and timings.
    #[arg(short, long, global = true)]
    pub verbose: bool,
    /// Never draw progress bars.
    #[arg(long, global = true)]
    pub no_progress: bool,
    /// Overwrite results that are already there.
    #[arg(long, global = true)]
    pub force: bool,
}

impl Global {
    /// The pool of threads that these flags ask for.
    pub fn thread_pool(&self) -> Result<rayon::ThreadPoolBuilder> {
        if self.threads > MOST_THREADS {
            bail!("--threads is {}; give at most {MOST_THREADS}", self.threads);
        }
        Ok(rayon::ThreadPoolBuilder::new().num_threads(self.threads))
    }
}

/// The caller of a verb: a person at a terminal, or a program.
pub struct Front {
    flags: Global,
    host: Host,
    bar: Arc<Bar>,
}

impl Front {
    /// A person at a terminal.
    pub fn terminal(flags: Global) -> Self {
        let bar = Arc::new(Bar::on_terminal(&flags));
        Self {
            flags,
            host: Host::default(),
            bar,
        }
    }

    /// A program, which reads answers and not notes.
    pub fn program(flags: Global, host: Host) -> Self {
        let bar = Arc::new(Bar::for_listener(host.progress.clone()));
        Self { flags, host, bar }
    }

    /// The flags that every verb understands.
    pub fn flags(&self) -> &Global {
        &self.flags
    }

    /// Whether earlier results may be replaced.
    pub fn force(&self) -> bool {
        self.flags.force
    }

    /// Says a line now, unless quiet.
    pub fn say(&self, line: &str) {
        if !self.flags.quiet {
            note(line);
        }
    }

    /// Says a line now to whoever asked for more.
    pub fn explain(&self, line: &str) {
        if self.flags.verbose {
            note(line);
        }
    }

    /// What to call for a warning that cannot wait.
    pub fn warner(&self) -> fn(&str) {
        if self.flags.quiet { |_| () } else { note }
    }

    /// A bar on a terminal, calls to a program that listens.
    pub fn progress(&self) -> Arc<dyn Progress> {
        Arc::clone(&self.bar) as Arc<dyn Progress>
    }

    /// Takes the bar away: the work is over.
    pub fn clear_progress(&self) {
        self.bar.clear();
    }

    /// How work is carried out that the first Ctrl-C or SIGTERM, or a time limit, asks to stop;
    /// then `what` is said. The second signal ends the process at once.
    pub fn execution(&self, what: &'static str, limit_minutes: Option<f64>) -> Result<Execution> {
        Ok(Execution {
            interrupt: self.interrupt(what, limit_minutes)?,
            ..self.execution_without_signals()
        })
    }

    /// How work is carried out that a signal ends at once: there is nothing to keep. A program that
    /// calls has an interrupt of its own.
    pub fn execution_without_signals(&self) -> Execution {
        Execution {
            interrupt: self.host.interrupt.clone().unwrap_or_default(),
            start_anew: self.flags.force,
            progress: self.progress(),
            ..Execution::default()
        }
    }

    fn interrupt(&self, what: &'static str, limit_minutes: Option<f64>) -> Result<Interrupt> {
        let duration = |minutes: f64| {
            Duration::try_from_secs_f64(minutes * 60.0)
                .map_err(|_| anyhow!("--time-limit is {minutes} minutes; give zero or more"))
        };
        let limit = limit_minutes.map(duration).transpose()?;
        if let Some(interrupt) = &self.host.interrupt {
            return Ok(interrupt.clone().with_limit(limit));
        }
        let interrupt = Interrupt::after(limit);
        listen_for_signals(&interrupt, what)?;
        Ok(interrupt)
    }
}

fn listen_for_signals(interrupt: &Interrupt, what: &'static str) -> Result<()> {
    let on_signal = interrupt.clone();
    // Not `is_requested`: a time limit that is over as well does not make the first signal the
    // second.
    let signalled = AtomicBool::new(false);
    ctrlc::set_handler(move || {
        if signalled.swap(true, Ordering::Relaxed) {
            std::process::exit(130);
        }
        note(&format!("{what} (again: stop at once)"));
        on_signal.request();
    })
    .context("cannot listen for Ctrl-C")
}
