//! `protomer ingest`: structure files to bodies.

use crate::flags::body::{ChargeArgs, CoreArgs, SelectionArgs, SurfaceFlags, body_settings};
use crate::flags::settings::{Chosen, choice_or};
use crate::front::Front;
use crate::reply::{Outcome, Reply};
use anyhow::{Result, bail};
use clap::Args;
use protomer_common::input;
use protomer_common::output_file::MeshFormat;
use protomer_common::range;
use protomer_kernel::setting::Choices;
use protomer_protein_verbs::bodies::ingest::{IngestSettings, Ingested, ingest_files};
use protomer_protein_verbs::bodies::stream::{StreamState, ingest_stream};
use protomer_results::Shard;
use std::path::PathBuf;

/// Turn structure files (PDB, mmCIF, PQR, each also gzipped) into bodies: surface mesh, charges,
/// hydropathy.
#[derive(Debug, Args)]
#[command(after_long_help = examples!(
    "ingest 5pti.cif.gz -o bodies",
    "ingest 5pti.cif.gz -o bodies --name plus --ph 7 --mutate A:D3K,A:E7K"
))]
pub struct IngestArgs {
    /// Structure files, folders that contain them, or lists of them (NAME.txt, one file a line).
    #[arg(required = true)]
    inputs: Vec<PathBuf>,
    /// Folder for the bodies.
    #[arg(short, long)]
    output: PathBuf,
    /// Name of the body, for a single file; that of the file if omitted.
    #[arg(long)]
    name: Option<String>,
    #[command(flatten)]
    selection: SelectionArgs,
    #[command(flatten)]
    charges: ChargeArgs,
    #[command(flatten)]
    surface: SurfaceFlags,
    #[command(flatten)]
    core: CoreArgs,
    /// Write the mesh and the charges in these formats as well.
    #[arg(long, value_parser = choice_or::<MeshFormat>(CHARGES, "Charges and radii"), value_delimiter = ',')]
    export: Vec<Chosen<MeshFormat>>,
    /// For very many files: outcomes and warnings go to ingest.csv and warnings.csv in the output
    /// folder instead of the answer, memory is bounded, and the same command continues.
    #[arg(long, conflicts_with = "name", help_heading = "Many files")]
    stream: bool,
    /// With --stream: only a part of the files, such as 2/8, with separate tables.
    #[arg(long, value_parser = Shard::parse, default_value = "1/1", requires = "stream", help_heading = "Many files")]
    part: Shard,
    /// With --stream: stop after this many minutes; the same command continues.
    #[arg(
        long,
        requires = "stream",
        help_heading = "Many files", value_parser = range::MINUTES.number())]
    time_limit: Option<f64>,
}

/// Extension of the file of charges.
const CHARGES: &str = "pqr";

impl IngestArgs {
    pub fn run(&self, front: &Front) -> Result<Reply> {
        let files = input::expand(&self.inputs)?;
        self.check_name(files.len())?;
        let name = |Chosen(format): &Chosen<MeshFormat>| format.map_or(CHARGES, Choices::name);
        let settings = IngestSettings {
            body: body_settings(&self.selection, &self.charges, &self.surface, self.core)?,
            name: self.name.clone(),
            exports: self.export.iter().map(name).collect(),
            force: front.force(),
        };
        if self.stream {
            return self.run_stream(&files, &settings, front);
        }
        let ingested = ingest_files(&files, &self.output, &settings, front.progress().as_ref())?;
        let (errors, warnings) = (errors(&ingested), warnings(&ingested));
        let some_failed = ingested.has_failures();
        Ok(Reply::from_answer(ingested)
            .with_errors(errors)
            .with_repeated(warnings)
            .partial_if(some_failed))
    }

    fn run_stream(
        &self,
        files: &[PathBuf],
        settings: &IngestSettings,
        front: &Front,
    ) -> Result<Reply> {
        let notice = "finishing the current files; the same command continues";
        let execution = front.execution(notice, self.time_limit)?;
        let report = ingest_stream(files, &self.output, settings, self.part, &execution)?;
        let (stopped, some_failed) = (report.state == StreamState::Stopped, report.failed > 0);
        let reply = Reply::from_answer(report);
        Ok(match stopped {
            true => reply.ending(Outcome::Stopped),
            false => reply.partial_if(some_failed),
        })
    }

    fn check_name(&self, files: usize) -> Result<()> {
        let Some(name) = &self.name else {
            return Ok(());
        };
        if name.contains(['/', '\\']) {
            bail!("--name is the name of the body, not a path; use --output for the folder");
        }
        if files > 1 {
            bail!("--name applies to a single file, but {files} files are given");
        }
        Ok(())
    }
}

fn errors(ingested: &Ingested) -> Vec<String> {
    let errors = ingested.files.iter().filter_map(|file| file.error.as_ref());
    errors.map(|error| format!("error: {error}")).collect()
}

fn warnings(ingested: &Ingested) -> Vec<String> {
    let mut lines = Vec::new();
    for outcome in &ingested.files {
        let file = &outcome.file;
        let warnings = outcome.warnings.iter();
        lines.extend(warnings.map(|warning| format!("warning: {file}: {warning}")));
    }
    lines
}
