//! `protomer compare`: several sweeps in one figure.

use super::{Global, Outcome, output};
use anyhow::{Result, bail};
use clap::Args;
use protomer::stability::compare::{CompareReport, figure, read_curves};
use std::path::PathBuf;

/// Draw several finished sweeps in one figure; the legend names the directories.
#[derive(Debug, Args)]
pub struct CompareArgs {
    /// Sweep directories.
    #[arg(required = true)]
    sweeps: Vec<PathBuf>,
    /// Figure to write: .png or .svg.
    #[arg(short, long)]
    output: PathBuf,
    /// Title of the figure.
    #[arg(long, default_value = "Stability against salt")]
    title: String,
}

impl CompareArgs {
    pub(super) fn run(&self, global: &Global) -> Result<Outcome> {
        let curves = read_curves(&self.sweeps)?;
        let figure = figure(&curves, &self.title);
        match self.output.extension().and_then(|ending| ending.to_str()) {
            Some("png") => figure.write_png(&self.output)?,
            Some("svg") => figure.write_svg(&self.output)?,
            _ => bail!("{} ends in neither .png nor .svg", self.output.display()),
        }
        if global.json {
            output::json(&CompareReport::of(&self.output, &curves))?;
        }
        global.say(&format!("figure: {}", self.output.display()));
        Ok(Outcome::Done)
    }
}
