//! `protomer score`: many complexes, a row each.

use crate::flags::body::{ChainGroupArgs, ProtonationArgs, SelectionArgs};
use crate::flags::execution::ExecutionArgs;
use crate::flags::model::ModelArgs;
use crate::flags::scheduler::PartArgs;
use crate::flags::settings::choice;
use crate::flags::terms::ContactArgs;
use crate::front::Front;
use crate::reply::Reply;
use anyhow::{Result, bail};
use clap::Args;
use protomer_common::{quantity, range};
use protomer_kernel::setting::Choices;
use protomer_protein_verbs::stability::binding::BindingSettings;
use protomer_protein_verbs::stability::contacts::ContactCore;
use protomer_protein_verbs::stability::model::Model;
use protomer_protein_verbs::stability::score::{
    Complexes, LAYOUT, Measure, ScoreSettings, run_score, run_score_shard,
};
use protomer_results::{End, ResultsDirectory};
use std::path::PathBuf;

/// Score many complexes or designs: a folder or a table of structures in, a table with a row for each out. The
/// same command continues work that was stopped, and adds complexes and columns.
#[derive(Debug, Args)]
// `--model` names what acts between the bodies here.
#[command(mut_arg(SelectionArgs::MODEL, |model| model.long("structure-model").value_name("NUMBER")))]
#[command(after_long_help = examples!(
    "score designs -o scores --columns energy,area,shape",
    "score complexes.csv -o scores --columns affinity,kd --salt 50mM,150mM"
))]
#[group(id = "ScoreResult")]
pub struct ScoreArgs {
    /// Folder of structure files, list of them (NAME.txt, one file a line), or table (NAME.csv) with the columns
    /// name, and file or receptor and ligand; receptor_chains and ligand_chains where a file has more than two
    /// chains.
    source: PathBuf,
    #[command(flatten)]
    bodies: ChainGroupArgs,
    /// Score every contact of the crystal of each file: chains and their symmetry copies that touch.
    #[arg(long, conflicts_with = "body")]
    crystal: bool,
    /// Directory of the results.
    #[arg(short, long)]
    output: PathBuf,
    /// Groups of columns.
    #[arg(long, value_delimiter = ',', value_parser = choice::<Measure>(), default_values = Measure::CHEAP.map(Choices::name))]
    columns: Vec<Measure>,
    /// Concentrations of a 1:1 salt: a list such as 50mM,150mM or a range such as 10mM..1M/5.
    #[arg(long, default_value = "150mM", allow_hyphen_values = true)]
    salt: String,
    /// pH at which structure files are charged [default: 7.4].
    #[arg(long, value_parser = range::PH.number())]
    ph: Option<f64>,
    #[command(flatten)]
    protonation: ProtonationArgs,
    /// Total concentration of each partner, for the columns half-salt.
    #[arg(long, default_value = "1uM", allow_hyphen_values = true, value_parser = quantity::concentration_molar)]
    concentration: f64,
    /// Temperature, K.
    #[arg(long, default_value = "298.15", allow_hyphen_values = true, value_parser = range::TEMPERATURE.read(quantity::temperature_kelvin))]
    temperature: f64,
    #[command(flatten)]
    model: ModelArgs,
    #[command(flatten)]
    attraction: ContactArgs,
    /// Spacing of the fine grid of the columns slope, kd, half-salt and exchange, Å.
    #[arg(long, default_value_t = BindingSettings::SPACING_ANGSTROM, value_parser = range::FINE_SPACING.number())]
    spacing: f64,
    /// Seed of the random numbers of the column kd.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// End with exit code 1 if some complexes could not be scored.
    #[arg(long)]
    strict: bool,
    #[command(flatten)]
    part: PartArgs,
    #[command(flatten)]
    selection: SelectionArgs,
    #[command(flatten)]
    execution: ExecutionArgs,
}

impl ScoreArgs {
    pub fn run(&self, front: &Front) -> Result<Reply> {
        self.part.check()?;
        let stated = self.bodies.body.len();
        if stated != 0 && stated != 2 {
            bail!(
                "a complex is that of two bodies, and --body states {stated}; give it twice, such as --body H,L --body A"
            );
        }
        let settings = self.settings()?;
        front.warn(quantity::salt_warning(settings.salt_molar.iter().copied()));
        let execution = self.execution.execution(front)?;
        ResultsDirectory::refuse_other_settings(&self.output, &LAYOUT, &settings, &execution)?;
        let complexes = match self.crystal {
            true => Complexes::of_crystals(&self.source, &self.selection.settings())?,
            false => Complexes::read(&self.source, &self.bodies.body)?,
        };
        let settings = ScoreSettings {
            complexes: complexes.0.len(),
            ..settings
        };
        let directory = &self.output;
        if let Some(shard) = self.part.shard() {
            let end = run_score_shard(&complexes, &settings, directory, shard, &execution)?;
            return Ok(Reply::of_part(end, shard, ["complex", "complexes"]));
        }
        match run_score(&complexes, &settings, directory, &execution)? {
            End::Finished(result) => {
                let some_failed = self.strict && result.failed > 0;
                Ok(Reply::from_answer(result).partial_if(some_failed))
            }
            End::Stopped => Ok(Reply::stopped(format!(
                "stopped; the same command continues {}",
                directory.display()
            ))),
        }
    }

    fn settings(&self) -> Result<ScoreSettings> {
        let model = self.model.model().unwrap_or(Model::Natural1);
        let settings = ScoreSettings {
            complexes: 0,
            columns: self.columns.clone(),
            salt_molar: quantity::salt_list(&self.salt)?,
            ph: self.ph,
            titration: self.protonation.titration_over(model.titration())?,
            concentration_molar: self.concentration,
            temperature_kelvin: self.temperature,
            model,
            contacts: self
                .attraction
                .over(model.contacts(), ContactCore::Surface)?,
            spacing_angstrom: self.spacing,
            seed: self.seed,
            selection: self.selection.settings(),
        };
        settings.check()?;
        Ok(settings)
    }
}
