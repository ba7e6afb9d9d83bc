//! `protomer lattice replay` and `respond`: states from a file.

use super::super::{Global, Outcome, output};
use anyhow::Result;
use clap::Args;
use protomer::lattice::replay::{LatticeFile, replay, respond};
use std::path::PathBuf;

/// Follow the state of a file (JSON: ns, r0, kappa, s0, v0, times), without collisions at the
/// listed times, and to the first contact and through it.
#[derive(Debug, Args)]
pub struct ReplayArgs {
    /// The file.
    file: PathBuf,
    /// Time step; it shrinks a little where times ask for it.
    #[arg(long = "dt", default_value_t = 1e-3, allow_negative_numbers = true)]
    time_step: f64,
    /// How long to look for a contact.
    #[arg(long, default_value_t = 20.0, allow_negative_numbers = true)]
    longest: f64,
}

impl ReplayArgs {
    pub(super) fn run(&self, global: &Global) -> Result<Outcome> {
        let file = LatticeFile::read(&self.file)?;
        let replay = replay(&file, self.time_step, self.longest)?;
        if global.json {
            output::json(&replay)?;
            return Ok(Outcome::Done);
        }
        for (time, energy) in replay.times.iter().zip(&replay.energy) {
            output::text(&format!("t = {time}: energy {energy:.12}"))?;
        }
        let contact = replay
            .first_collision
            .as_ref()
            .map_or("no contact".to_owned(), |first| {
                let contacts = first.contacts.iter().map(|[striker, vertex, target]| {
                    format!("corner {vertex} of square {striker} on square {target}")
                });
                format!(
                    "first contact at t = {:.12}: {}",
                    first.t,
                    contacts.collect::<Vec<_>>().join(", ")
                )
            });
        output::text(&contact)?;
        Ok(Outcome::Done)
    }
}

/// The elastic impact at the state of contact of a file (JSON: ns, r0, first_collision with s and
/// v).
#[derive(Debug, Args)]
pub struct RespondArgs {
    /// The file.
    file: PathBuf,
}

impl RespondArgs {
    pub(super) fn run(&self, global: &Global) -> Result<Outcome> {
        let response = respond(&LatticeFile::read(&self.file)?)?;
        if global.json {
            output::json(&response)?;
        } else {
            output::text(&format!(
                "{} contacts, impulses {:?}, kinetic energy changes by {:.1e}",
                response.contacts.len(),
                response.impulses,
                response.energy_change
            ))?;
        }
        Ok(Outcome::Done)
    }
}
