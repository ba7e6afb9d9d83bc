//! `protomer bench`: trial moves per CPU-second.

use crate::flags::medium::ConditionArgs;
use crate::flags::model::ModelArgs;
use crate::flags::settings::choice;
use crate::flags::solute::{Charges, ChargesArgs};
use crate::flags::tables::TablesArgs;
use crate::flags::terms::TermsArgs;
use crate::flags::tolerance::ToleranceArgs;
use crate::front::Front;
use crate::reply::{Outcome, Reply};
use anyhow::{Result, bail};
use clap::Args;
use protomer_common::{quantity, range};
use protomer_protein_verbs::assemblies::assembly_file::Assembly;
use protomer_protein_verbs::stability::bench::suite::{Part, SuiteSettings, run_suite};
use protomer_protein_verbs::stability::bench::{BenchSettings, bench};
use protomer_protein_verbs::stability::effective;
use protomer_protein_verbs::stability::interaction::{InteractionSettings, ScreenedCoulomb};
use protomer_protein_verbs::stability::run::{EnergyMode, RunSettings};
use std::path::{Path, PathBuf};

/// Upper limit for the number of charges: a direct sum over sixteen bodies with more takes too
/// long.
const MOST_CHARGES: usize = 50_000;

/// Measure trial moves per CPU-second on an assembly, from the state it is in, and hash the
/// decisions made.
///
/// Without an assembly: measure on states that the program makes itself, and print a table of each
/// energy mode's rate against the number of charges, of the parts of a move, of the cost against
/// the number of bodies, and of replicas on several threads. That takes a few minutes.
#[derive(Debug, Args)]
#[command(after_long_help = examples!(
    "bench ring.json --salt 300mM --moves 2000",
    "bench --part charges --charges 500"
))]
#[group(id = "BenchResult")]
pub struct BenchArgs {
    /// Assembly file; left out, the program makes its own states.
    assembly: Option<PathBuf>,
    /// Trial moves [default: 10000; without an assembly, as many as the direct sum makes in a few
    /// seconds].
    #[arg(long, value_parser = range::MOVES.number::<u64>())]
    moves: Option<u64>,
    /// Method of computing energies [default: the fastest way that decides as the direct sum;
    /// without an assembly, each way].
    #[arg(long, value_parser = choice::<EnergyMode>(), requires = "assembly")]
    energy: Option<EnergyMode>,
    #[command(flatten)]
    tolerance: ToleranceArgs,
    /// Only this table (repeat for several).
    #[arg(long, value_parser = choice::<Part>(), conflicts_with = "assembly")]
    part: Vec<Part>,
    /// Numbers of charges per body in the tables [default: 500,3000].
    #[arg(long, value_delimiter = ',', conflicts_with = "assembly")]
    charges: Vec<usize>,
    /// Seed of the random numbers, and of the program's own states.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    #[command(flatten)]
    conditions: ConditionArgs,
    #[command(flatten)]
    acting: ChargesArgs,
    #[command(flatten)]
    model: ModelArgs,
    #[command(flatten)]
    terms: TermsArgs,
    #[command(flatten)]
    tables: TablesArgs,
}

impl BenchArgs {
    pub fn run(&self, front: &Front) -> Result<Reply> {
        if self.moves == Some(0) {
            bail!("--moves is 0; give at least 1");
        }
        front.warn(quantity::salt_warning(self.conditions.salt));
        match &self.assembly {
            Some(path) => self.on_assembly(path, front),
            None => self.on_own_states(front),
        }
    }

    fn on_assembly(&self, path: &Path, front: &Front) -> Result<Reply> {
        let energy = self.energy;
        let interaction = match energy {
            Some(energy) => self.conditions.interaction_for(energy)?,
            None => self.conditions.interaction()?,
        };
        let assembly = Assembly::read(path)?;
        let usual = BenchSettings::default();
        let run = RunSettings {
            energy,
            tolerance_kt: self.tolerance.tolerance,
            ..RunSettings::default()
        };
        let settings = BenchSettings {
            moves: self.moves.unwrap_or(usual.moves),
            run: self.model.acting(&self.acting, &self.terms, run)?,
            seed: self.seed,
            ..usual
        };
        let tables = self.tables.tables(front);
        let effective_store = self.tables.cache.effective_store(front);
        let result = bench(assembly, &settings, interaction, tables, effective_store)?;
        let warnings = effective::warnings(result.effective_bodies.iter().flatten());
        Ok(Reply::data(result).with_notes(warnings))
    }

    fn on_own_states(&self, front: &Front) -> Result<Reply> {
        let settings = self.suite_settings()?;
        if self
            .acting
            .interaction
            .is_some_and(|charges| charges != Charges::Bare)
        {
            bail!(
                "the states that the program makes have no atoms, which --interaction effective and \
                 response need; leave it out, or give an assembly"
            );
        }
        let interaction = self.interaction_of_own_states()?;
        let execution = front.execution("stopping after the present run of moves", None)?;
        let tables = self.tables.tables(front);
        let result = run_suite(&settings, interaction, &tables, &execution)?;
        if result.complete {
            return Ok(Reply::data(result));
        }
        let note = "stopped; rows that were not measured are left out";
        let reply = Reply::data(result).with_note(note.into());
        Ok(reply.ending(Outcome::Stopped))
    }

    fn suite_settings(&self) -> Result<SuiteSettings> {
        let usual = SuiteSettings::default();
        let is_fit = |charges: &&usize| (1..=MOST_CHARGES).contains(*charges);
        if let Some(charges) = self.charges.iter().find(|charges| !is_fit(charges)) {
            bail!(
                "--charges has {charges}; give numbers from 1 to {MOST_CHARGES}, such as 500,3000"
            );
        }
        let tolerance_kt = EnergyMode::Approximate.tolerance_kt(self.tolerance.tolerance)?;
        Ok(SuiteSettings {
            parts: if self.part.is_empty() {
                usual.parts
            } else {
                self.part.clone()
            },
            charges: if self.charges.is_empty() {
                usual.charges
            } else {
                self.charges.clone()
            },
            moves: self.moves,
            seed: self.seed,
            tolerance_kt: tolerance_kt.unwrap_or(usual.tolerance_kt),
            ..usual
        })
    }

    /// The medium of the flags; without salt and Debye length, a plain one of fixed lengths.
    fn interaction_of_own_states(&self) -> Result<ScreenedCoulomb> {
        let stated = self.conditions.medium.medium();
        if self.conditions.salt.is_some() || stated.debye_length_angstrom.is_some() {
            return self.conditions.interaction();
        }
        let usual = InteractionSettings {
            bjerrum_length_angstrom: Some(7.0),
            debye_length_angstrom: Some(9.6),
            ..InteractionSettings::default()
        };
        let mut medium = usual;
        self.conditions.medium.override_in(&mut medium);
        medium.interaction(None)
    }
}
