//! `protomer inspect`: overlaps, energies and size of an assembly.

use crate::flags::choices::Energy;
use crate::flags::contacts::ContactArgs;
use crate::flags::medium::ConditionArgs;
use crate::flags::solute::SoluteArgs;
use crate::flags::tables::TablesArgs;
use crate::flags::tolerance::ToleranceArgs;
use crate::front::Front;
use crate::reply::Reply;
use anyhow::{Result, bail};
use clap::{Args, ValueEnum};
use protomer::assemblies::assembly_file::Assembly;
use protomer::stability::contacts::ContactCore;
use protomer::stability::effective::SoluteModel;
use protomer::stability::inspect::{inspect, inspection_settings};
use protomer::stability::run::Engine;
use protomer::stability::terms::FurtherTerms;
use std::path::PathBuf;

/// Inspect an assembly: overlaps, pair energies, radius of gyration.
#[derive(Debug, Args)]
pub struct InspectArgs {
    /// Assembly file.
    assembly: PathBuf,
    /// Energy model.
    #[arg(long, value_enum, default_value_t = Energy::Direct)]
    energy: Energy,
    #[command(flatten)]
    tolerance: ToleranceArgs,
    /// Whether the charges of the bodies act, or their effective charges: those that give the
    /// potential around bodies of low permittivity that salt does not enter.
    #[arg(long, value_enum, default_value_t = Charges::Bare)]
    interaction: Charges,
    /// Surfaces closer than this are in contact, Å.
    #[arg(long, default_value_t = 5.0)]
    contact_gap: f64,
    /// Count what charges lose where other bodies displace solvent; with effective charges.
    #[arg(long)]
    desolvation: bool,
    #[command(flatten)]
    contacts: ContactArgs,
    #[command(flatten)]
    conditions: ConditionArgs,
    #[command(flatten)]
    solute: SoluteArgs,
    #[command(flatten)]
    tables: TablesArgs,
}

/// The charges of an interaction.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Charges {
    /// The charges of the bodies.
    Bare,
    /// Their effective charges.
    Effective,
}

impl InspectArgs {
    pub fn run(&self, front: &Front) -> Result<Reply> {
        let assembly = Assembly::read(&self.assembly)?;
        let engine = Engine::new(assembly)?.with_tables(self.tables.tables(front));
        let energy = self.energy.into();
        let interaction = self.conditions.interaction_for(energy)?;
        let (engine, warnings) = match (self.interaction, self.solute.solute()) {
            (Charges::Bare, None) => (engine, Vec::new()),
            (Charges::Bare, Some(_)) => bail!(
                "--inner-permittivity and --ion-radius apply to effective charges only; add \
                 --interaction effective, or leave them out"
            ),
            (Charges::Effective, solute) => {
                engine.with_effective_charges(&interaction, &solute.unwrap_or_default())?
            }
        };
        let further = FurtherTerms {
            contacts: self.contacts.term(ContactCore::Surface)?,
            desolvation: self.desolvated()?,
        };
        let engine = engine.with_terms(&further, &interaction)?;
        let settings = inspection_settings(energy, self.tolerance.tolerance, self.contact_gap);
        Ok(Reply::data(inspect(&engine, &settings, interaction)?).with_notes(warnings))
    }

    /// The inside of bodies, if desolvation counts.
    fn desolvated(&self) -> Result<Option<SoluteModel>> {
        match (self.desolvation, self.interaction) {
            (false, _) => Ok(None),
            (true, Charges::Effective) => Ok(Some(self.solute.solute().unwrap_or_default())),
            (true, Charges::Bare) => {
                bail!("desolvation is that of effective charges; add --interaction effective")
            }
        }
    }
}
