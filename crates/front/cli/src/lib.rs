//! The command line: flags to settings, answers to the terminal.
//!
//! ```text
//! words --clap--> flags of a verb --verbs--> settings --protomer--> answer --Reply--> stdout, or a program's value
//! ```
//!
//! | module | one idea |
//! |---|---|
//! | `verbs` | one file per verb: its flags, the settings they make, the call, the reply |
//! | `flags` | flags that several verbs share |
//! | `front` | the interface of a verb to its caller |
//! | `host` | a program as the caller; progress |
//! | `help` | verbs in groups, examples |
//! | `reply` | the reply of a verb, and the only place that prints |
//! | `command` | a command line, parsed into its parts |
//! | `numbers` | the flags that take numbers |
//! | `paths` | names of files must be text |
//! | `python` | the verbs as Python functions: their table, and the stub with their types |

mod command;
mod flags;
mod front;
mod global;
#[macro_use]
mod help;
mod host;
mod numbers;
mod paths;
mod python;
mod reply;
mod stderr;
mod verbs;

use anyhow::{Context, Result, anyhow};
use clap::{CommandFactory, FromArgMatches, Parser};
use front::Front;
use global::Global;
use protomer_common::live::{Arrays, Live};
use protomer_common::remedy;
use std::ffi::OsString;
use std::fmt;
use std::time::Instant;

pub use command::Command;
pub use host::{Host, ProgressListener};
pub use numbers::{NumberFlag, number_flags};
pub use python::{Function, Group, Parameter, python_functions, python_stub};
pub use reply::{Outcome, Reply};

/// Coarse-grained protein assembly modelling: structures to rigid bodies, bodies to assemblies,
/// assemblies to stability.
#[derive(Debug, Parser)]
#[command(
    name = "protomer",
    version,
    propagate_version = true,
    max_term_width = 100
)]
struct Cli {
    #[command(flatten)]
    global: Global,
    #[command(subcommand)]
    verb: verbs::Verb,
}

/// Words that are not a command, with the message of the command line.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct UsageError(pub String);

impl fmt::Display for UsageError {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(&self.0)
    }
}

impl std::error::Error for UsageError {}

/// The command line with its groups of verbs and examples.
fn syntax() -> clap::Command {
    help::completed(Cli::command())
}

fn parsed<W: Into<OsString>>(words: impl IntoIterator<Item = W>) -> Result<Cli, clap::Error> {
    let mut syntax = syntax();
    let words: Vec<OsString> = words.into_iter().map(Into::into).collect();
    let matches = syntax.try_get_matches_from_mut(&words);
    let matches = matches
        .map_err(help::without_double_dash)
        .map_err(help::with_plain_number)
        .map_err(|error| help::with_missing_feature(error, &mut syntax))
        .map_err(|error| help::with_missing_verb(error, &mut syntax, &words))?;
    paths::require_text(&syntax, &matches)?;
    Cli::from_arg_matches(&matches).map_err(|error| error.format(&mut syntax))
}

/// Parses the words of a command line, the program's name first, runs the verb and prints its
/// reply. Returns the exit code: 0 done, 1 error, 2 usage, 3 stopped early and resumable.
pub fn run(words: impl IntoIterator<Item = OsString>) -> u8 {
    let cli = match parsed(words) {
        Ok(cli) => cli,
        Err(error) => {
            let error = verbs::explain_usage(error);
            // A closed stdout is not an error.
            let _ = error.print();
            return u8::try_from(error.exit_code()).unwrap_or(2);
        }
    };
    let start = Instant::now();
    let front = Front::terminal(cli.global);
    let code = run_on_terminal(&cli.verb, &front);
    front.explain(&format!("{:.2} s", start.elapsed().as_secs_f64()));
    match code {
        Ok(code) => code,
        Err(error) if reply::is_broken_pipe(&error) => 0,
        Err(error) => {
            stderr::note(&format!("error: {}", remedy::message(&error)));
            1
        }
    }
}

fn run_on_terminal(verb: &verbs::Verb, front: &Front) -> Result<u8> {
    let pool = front.flags().thread_pool()?;
    pool.build_global()
        .context("cannot start the threads; try a smaller --threads")?;
    let reply = verb.run(front);
    front.clear_progress();
    reply?.print(front.flags())
}

/// Runs a verb for a program, as `protomer WORDS` would, on separate threads. The words do not
/// include the program's name.
///
/// ```
/// use protomer_cli::{Host, call};
/// let words = ["framework", "honeycomb", "--theta", "60", "--kh", "50", "--ks", "10000"];
/// let reply = call(&words, Host::default()).unwrap();
/// assert!(reply.value().unwrap().unwrap()["c_gpa"].is_array());
/// ```
///
/// # Errors
/// [`UsageError`] for words that are not a command; otherwise the error of the verb.
pub fn call<S: AsRef<str>>(words: &[S], host: Host) -> Result<Reply> {
    let words = ["protomer", "--json", "--quiet"]
        .into_iter()
        .chain(words.iter().map(AsRef::as_ref));
    let Cli { global, verb } = parsed(words).map_err(usage)?;
    let pool = global.thread_pool()?.build();
    let pool = pool.map_err(|error| anyhow!("cannot start the threads: {error}; try fewer"))?;
    let front = Front::program(global, host);
    let reply = pool.install(|| verb.run(&front))?.unless_failed()?;
    Ok(reply.with_notes(front.warnings()))
}

/// Begins the simulation of an assembly in memory, by the words of `simulate`, and returns it with its warnings; with arrays the
/// bodies begin where these have them.
///
/// # Errors
/// As the verb; also for words of another verb.
pub fn simulation<S: AsRef<str>>(
    words: &[S],
    arrays: Option<Arrays>,
) -> Result<(Box<dyn Live>, Vec<String>)> {
    let words = ["protomer", "--quiet"]
        .into_iter()
        .chain(words.iter().map(AsRef::as_ref));
    let Cli { global, verb } = parsed(words).map_err(usage)?;
    let front = Front::program(global, Host::default());
    let verbs::Verb::Simulate(args) = verb else {
        return Err(anyhow!(
            "only simulate has a simulation in memory; give its words"
        ));
    };
    let simulation = args.live(&front, arrays)?;
    Ok((simulation, front.warnings()))
}

fn usage(error: clap::Error) -> UsageError {
    UsageError(error.to_string().trim().to_owned())
}
