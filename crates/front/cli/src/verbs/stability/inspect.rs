//! `protomer inspect`: overlaps, energies and size of an assembly.

use crate::flags::medium::ConditionArgs;
use crate::flags::model::ModelArgs;
use crate::flags::settings::choice;
use crate::flags::solute::ChargesArgs;
use crate::flags::tables::TablesArgs;
use crate::flags::terms::TermsArgs;
use crate::flags::tolerance::ToleranceArgs;
use crate::front::Front;
use crate::reply::Reply;
use anyhow::Result;
use clap::Args;
use protomer_common::{quantity, range};
use protomer_protein_verbs::assemblies::assembly_file::Assembly;
use protomer_protein_verbs::stability::DEFAULT_CONTACT_GAP_ANGSTROM;
use protomer_protein_verbs::stability::inspect::{inspect, inspection_settings};
use protomer_protein_verbs::stability::run::EnergyMode;
use std::path::PathBuf;

/// Inspect an assembly: overlaps, pair energies, radius of gyration.
#[derive(Debug, Args)]
#[command(after_long_help = examples!(
    "inspect ring.json",
    "inspect ring.json --salt 100mM --interaction effective"
))]
pub struct InspectArgs {
    /// Assembly file.
    assembly: PathBuf,
    /// Energy model [default: direct].
    #[arg(long, value_parser = choice::<EnergyMode>())]
    energy: Option<EnergyMode>,
    #[command(flatten)]
    tolerance: ToleranceArgs,
    /// Surfaces closer than this are in contact, Å.
    #[arg(long, default_value_t = DEFAULT_CONTACT_GAP_ANGSTROM, value_parser = range::CONTACT_GAP.number())]
    contact_gap: f64,
    #[command(flatten)]
    model: ModelArgs,
    #[command(flatten)]
    terms: TermsArgs,
    #[command(flatten)]
    conditions: ConditionArgs,
    #[command(flatten)]
    charges: ChargesArgs,
    #[command(flatten)]
    tables: TablesArgs,
}

impl InspectArgs {
    /// Whether energies are requested, as by any flag of the charges or the medium; overlaps and
    /// contacts need no salt.
    fn asks_for_energies(&self) -> bool {
        let asked_for_charges = self.energy.is_some()
            || self.charges.interaction.is_some()
            || self.charges.solute.solute().is_some();
        let has_medium =
            self.conditions.salt.is_some() || self.conditions.medium.medium() != Default::default();
        asked_for_charges
            || has_medium
            || self.tolerance.tolerance.is_some()
            || self.model.model.is_some()
            || self.terms.is_given()
    }

    pub fn run(&self, front: &Front) -> Result<Reply> {
        front.warn(quantity::salt_warning(self.conditions.salt));
        let assembly = Assembly::read(&self.assembly)?;
        front.warn(self.model.body_warning(&assembly));
        let engine = self.tables.engine(assembly, front)?;
        let energy = self.energy.unwrap_or(EnergyMode::Direct);
        let interaction = match self.asks_for_energies() {
            true => Some(self.conditions.interaction_for(energy)?),
            false => None,
        };
        let usual = inspection_settings(energy, self.tolerance.tolerance, self.contact_gap);
        let settings = self.model.acting(&self.charges, &self.terms, usual)?;
        let inspection = inspect(&engine, &settings, interaction)?;
        let warnings = inspection.warnings.clone();
        Ok(Reply::data(inspection).with_notes(warnings))
    }
}
