//! `protomer reweight`: curves over salt from all frames of a sweep.

use crate::flags::tables::TablesArgs;
use crate::front::Front;
use crate::reply::Reply;
use anyhow::Result;
use clap::Args;
use protomer_common::{quantity, range};
use protomer_protein_verbs::stability::reweighting::{ReweightingSettings, reweighting};
use std::path::PathBuf;

/// Weight the frames of a sweep at all salts together into curves between the salts that were
/// simulated, with errors, and at other concentrations of bodies by mass action: where half of the
/// contacts are left.
#[derive(Debug, Args)]
#[command(after_long_help = examples!(
    "reweight stability -o curves",
    "reweight stability --salt 50mM..200mM/20 --concentration 1uM,100uM"
))]
pub struct ReweightArgs {
    /// Directory of a sweep over several salt concentrations.
    input: PathBuf,
    /// Directory for tables (CSV), JSON and figure.
    #[arg(short, long)]
    output: Option<PathBuf>,
    /// Salt concentrations of the curves: a list or a range such as 10mM..300mM/30 [default: those of
    /// the sweep and three between neighbours].
    #[arg(long, allow_hyphen_values = true)]
    salt: Option<String>,
    /// Concentrations of bodies, in addition to that of the sweep: a list such as 10uM,1mM.
    #[arg(long, allow_hyphen_values = true)]
    concentration: Option<String>,
    /// Share of the frames at the beginning of each trajectory that is left out.
    #[arg(long, default_value_t = 0.2, value_parser = range::SHARE.number())]
    skip: f64,
    /// Frames of each trajectory that are used at most, evenly spread.
    #[arg(long, default_value_t = 200, value_parser = range::OBJECTS.number::<usize>())]
    most_frames: usize,
    /// Assembly file of the sweep, if it has moved.
    #[arg(long)]
    assembly: Option<PathBuf>,
    #[command(flatten)]
    tables: TablesArgs,
}

impl ReweightArgs {
    pub fn run(&self, front: &Front) -> Result<Reply> {
        let list = |text: &Option<String>| -> Result<Vec<f64>> {
            let salts = text.as_deref().map(quantity::salt_list);
            Ok(salts.transpose()?.unwrap_or_default())
        };
        let settings = ReweightingSettings {
            input: self.input.clone(),
            salt_molar: list(&self.salt)?,
            concentration_molar: list(&self.concentration)?,
            skip: self.skip,
            most_frames: self.most_frames,
            assembly: self.assembly.clone(),
            output: self.output.clone(),
            force: front.force(),
        };
        let (tables, store) = (
            self.tables.tables(front),
            self.tables.cache.effective_store(front),
        );
        let result = reweighting(&settings, tables, store, front.progress().as_ref())?;
        let reply = Reply::from_answer(result);
        Ok(match &self.output {
            Some(directory) => {
                let figure = directory.join("reweighting.png");
                reply.with_note(format!("figure: {}", figure.display()))
            }
            None => reply,
        })
    }
}
