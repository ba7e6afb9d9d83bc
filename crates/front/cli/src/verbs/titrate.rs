//! `protomer titrate`: pKa values and charges against pH.

use crate::flags::body::SelectionArgs;
use crate::front::Front;
use crate::reply::Reply;
use anyhow::Result;
use clap::Args;
use protomer_common::{quantity, range};
use protomer_field::titration::TitrationModel;
use protomer_kernel::Electrolyte;
use protomer_protein_verbs::titration::{PhRange, TitrateSettings, titrate};
use protomer_results::End;
use std::path::PathBuf;

/// Compute the pKa values of a structure with the Poisson-Boltzmann equation: what shifts them, the
/// net charge against pH, the isoelectric point.
#[derive(Debug, Args)]
#[command(after_long_help = examples!(
    "titrate 5pti.cif.gz --ph 7 --salt 100mM",
    "titrate 5pti.cif.gz --ph 2..12 --salt 100mM -o titration"
))]
pub struct TitrateArgs {
    /// Structure file (PDB or mmCIF), optionally gzipped.
    input: PathBuf,
    /// pH of the table, or range of the curve, such as 2..12 or 2..12/21 for 21 values.
    #[arg(long, default_value = "7.4", allow_hyphen_values = true, value_parser = str::parse::<PhRange>)]
    ph: PhRange,
    /// Concentration of a 1:1 salt, such as 100mM or 0.1M.
    #[arg(long, value_parser = quantity::salt_molar, allow_hyphen_values = true)]
    salt: f64,
    /// Temperature, K.
    #[arg(long, default_value = "298.15", allow_hyphen_values = true, value_parser = range::TEMPERATURE.read(quantity::temperature_kelvin))]
    temperature: f64,
    /// Relative permittivity inside the surface; other values than 20 leave the range of the fit.
    #[arg(long, default_value_t = TitrationModel::default().inner_permittivity, value_parser = range::PERMITTIVITY.number())]
    inner_permittivity: f64,
    /// Constant of the binding of the salt's anion to a positive group in water, L/mol; a group with a
    /// bound anion has no charge.
    #[arg(long, default_value_t = 0.0, value_parser = range::ANION_BINDING.number())]
    anion_binding: f64,
    /// Directory for tables (CSV), JSON and figure.
    #[arg(short, long)]
    output: Option<PathBuf>,
    #[command(flatten)]
    selection: SelectionArgs,
}

impl TitrateArgs {
    pub fn run(&self, front: &Front) -> Result<Reply> {
        front.warn(quantity::salt_warning([self.salt]));
        let settings = TitrateSettings {
            input: self.input.clone(),
            selection: self.selection.settings(),
            ph: self.ph,
            electrolyte: Electrolyte::in_water(self.temperature, self.salt)?,
            model: TitrationModel {
                inner_permittivity: self.inner_permittivity,
                anion_binding_per_molar: self.anion_binding,
                ..TitrationModel::default()
            },
            output: self.output.clone(),
            force: front.force(),
        };
        let end = titrate(&settings, &front.execution_without_signals())?;
        let End::Finished(report) = end else {
            return Ok(Reply::stopped("stopped; nothing was written".into()));
        };
        let warnings = report.warnings.iter();
        let warnings: Vec<String> = warnings
            .map(|warning| format!("warning: {warning}"))
            .collect();
        let reply = Reply::from_answer(report).with_notes(warnings);
        Ok(match &self.output {
            Some(directory) => {
                let figure = directory.join("titration.png");
                reply.with_note(format!("figure: {}", figure.display()))
            }
            None => reply,
        })
    }
}
