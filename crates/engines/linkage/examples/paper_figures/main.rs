//! The figures of the two papers on the rigid-square lattice, as tables of numbers:
//!
//! ```text
//! cargo run --release -p protomer-linkage --example paper_figures -- \
//!     FOLDER [--random N] [--reseeded N] [--small N] [--full] [--jobs N] [FIGURE...]
//! ```
//!
//! | module | figures |
//! |---|---|
//! | `ensemble` | random lattices of 10 x 10: preprint 4 to 7, paper 5 |
//! | `long` | ten times longer: preprint 8 |
//! | `grima` | phase space of the coherent motion: paper 4 |
//! | `contact` | 2 x 2 after the first contact: for comparison with paper 7 |
//! | `opening` | a coherent start of 10 x 10: paper 10 |
//! | `reseeded` | the checkerboard mode of 10 x 10: paper 11 |
//! | `potential` | what a coherence potential does: paper 12 |
//!
//! The checkerboard mode of 2 x 2 (paper 7) and Lyapunov exponents (paper 8) are those of `protomer
//! lattice sweep`.
//!
//! "The paper" and "the preprint" are those of `protomer_linkage::analysis`. Times are in the
//! paper's unit, in which its step is 0.01; our steps are `common::time_step`. Numbers do not
//! depend on how many threads make them.

#![allow(clippy::print_stdout, clippy::print_stderr)]

mod common;
mod contact;
mod ensemble;
mod grima;
mod long;
mod opening;
mod potential;
mod reseeded;

use common::{Failure, Settings};
use std::path::PathBuf;

type Figure = (&'static str, fn(&Settings) -> Result<(), Failure>);

const FIGURES: [Figure; 7] = [
    ("grima", grima::write),
    ("opening", opening::write),
    ("potential", potential::write),
    ("contact", contact::write),
    ("ensemble", ensemble::write),
    ("reseeded", reseeded::write),
    ("long", long::write),
];

fn main() -> Result<(), Failure> {
    let mut settings = Settings {
        folder: PathBuf::new(),
        random: 10,
        reseeded: 24,
        small: 16,
        jobs: 1,
    };
    let mut wanted: Vec<String> = Vec::new();
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        let mut number = || -> Result<usize, Failure> {
            let text = arguments
                .next()
                .ok_or_else(|| format!("{argument} needs a number"))?;
            Ok(text
                .parse::<usize>()
                .map_err(|error| format!("{argument} {text}: {error}"))?)
        };
        match argument.as_str() {
            "--random" => settings.random = number()?.max(2),
            "--reseeded" => settings.reseeded = number()?.max(2),
            "--small" => settings.small = number()?.max(2),
            "--jobs" => settings.jobs = number()?.max(1),
            // As many as in the papers.
            "--full" => (settings.random, settings.reseeded, settings.small) = (10, 24, 100),
            option if option.starts_with("--") => {
                return Err(format!("there is no option {option}").into());
            }
            folder if settings.folder.as_os_str().is_empty() => {
                settings.folder = PathBuf::from(folder)
            }
            figure if FIGURES.iter().any(|(name, _)| *name == figure) => wanted.push(argument),
            other => return Err(format!("there is no figure {other}").into()),
        }
    }
    if settings.folder.as_os_str().is_empty() {
        return Err("give a folder for the tables".into());
    }
    std::fs::create_dir_all(&settings.folder)?;
    for (name, write) in FIGURES {
        if wanted.is_empty() || wanted.iter().any(|figure| figure == name) {
            let begin = common::processor_seconds();
            write(&settings)?;
            println!(
                "{name}: {:.1} CPU-seconds",
                common::processor_seconds() - begin
            );
        }
    }
    Ok(())
}
