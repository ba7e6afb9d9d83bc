//! `protomer ingest`: structure files to bodies.

use super::{Global, Outcome, output};
use anyhow::{Result, bail};
use clap::{Args, ValueEnum};
use protomer::bodies::ingest::{FileOutcome, IngestSettings, ingest_files};
use protomer::input;
use protomer_body::chemistry::{ChargeModel, SiteSettings, parse_mutations};
use protomer_body::structure::{MissingAtoms, SelectionSettings};
use protomer_body::{BodySettings, SurfaceSettings};
use std::path::PathBuf;

/// Turn structure files (PDB, mmCIF, PQR, each also gzipped) into bodies: surface mesh, charges,
/// hydropathy.
#[derive(Debug, Args)]
pub struct IngestArgs {
    /// Structure files, or folders of them.
    #[arg(required = true)]
    inputs: Vec<PathBuf>,
    /// Folder for the bodies.
    #[arg(short, long)]
    output: PathBuf,
    /// Name of the body, for a single file; that of the file if left out.
    #[arg(long)]
    name: Option<String>,
    #[command(flatten)]
    selection: SelectionArgs,
    #[command(flatten)]
    charges: ChargeArgs,
    #[command(flatten)]
    surface: SurfaceFlags,
    /// Also write the mesh and the charges in these formats.
    #[arg(long, value_enum, value_delimiter = ',')]
    export: Vec<Export>,
}

/// Which atoms.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Selection")]
pub struct SelectionArgs {
    /// Chains by the authors' names; all if left out.
    #[arg(long, value_delimiter = ',')]
    chain: Vec<String>,
    /// Model number; the first if left out.
    #[arg(long)]
    model: Option<i32>,
    /// Biological assembly by its number; the deposited coordinates if left out.
    #[arg(long)]
    assembly: Option<String>,
    /// Alternate location to prefer; the highest occupancy if left out.
    #[arg(long)]
    altloc: Option<char>,
    /// Keep ligands, ions and sugars.
    #[arg(long)]
    keep_ligands: bool,
    /// Keep waters.
    #[arg(long)]
    keep_waters: bool,
    /// Keep hydrogens.
    #[arg(long)]
    keep_hydrogens: bool,
    /// Keep nucleic acids.
    #[arg(long)]
    keep_nucleic_acids: bool,
    /// What to do with residues that lack heavy atoms.
    #[arg(long, value_enum, default_value_t = Missing::Keep)]
    missing: Missing,
}

/// Which charges.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Charges")]
pub struct ChargeArgs {
    /// pH of the protonation equilibria.
    #[arg(long, default_value_t = 7.4)]
    ph: f64,
    /// Where the charges sit.
    #[arg(long, value_enum, default_value_t = Charges::ForceField)]
    charges: Charges,
    /// Residues exchanged in place: chain:from-number-to, such as A:K45E,B:N12D.
    #[arg(long)]
    mutate: Option<String>,
}

/// Which surface.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Surface")]
pub struct SurfaceFlags {
    /// Mesh vertices per Å².
    #[arg(long, default_value_t = 1.0)]
    pub density: f64,
    /// Probe radius, Å.
    #[arg(long, default_value_t = 1.4, allow_negative_numbers = true)]
    pub probe: f64,
    /// What to do with cavities inside the body.
    #[arg(long, value_enum, default_value_t = Cavities::Drop)]
    pub cavities: Cavities,
    /// Move the surface inward by this much, Å.
    #[arg(long, default_value_t = 0.0)]
    pub offset: f64,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Missing {
    /// Keep the residue as it is.
    Keep,
    /// Leave the residue out.
    Skip,
    /// Refuse the structure.
    Fail,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Charges {
    /// Partial charges of a force field on every heavy atom.
    ForceField,
    /// Formal charges on the charged groups.
    Formal,
    /// No charges.
    None,
}

/// What to do with cavities.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Cavities {
    /// Fill them.
    Drop,
    /// Keep their walls as part of the mesh.
    Keep,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Export {
    Ply,
    Obj,
    Off,
    Stl,
    Pqr,
}

impl SelectionArgs {
    fn settings(&self) -> SelectionSettings {
        SelectionSettings {
            model: self.model,
            chains: self.chain.clone(),
            assembly: self.assembly.clone(),
            alternate: self.altloc,
            keep_ligands: self.keep_ligands,
            keep_waters: self.keep_waters,
            keep_hydrogens: self.keep_hydrogens,
            keep_nucleic_acids: self.keep_nucleic_acids,
            missing: match self.missing {
                Missing::Keep => MissingAtoms::Keep,
                Missing::Skip => MissingAtoms::Skip,
                Missing::Fail => MissingAtoms::Fail,
            },
        }
    }
}

impl SurfaceFlags {
    /// The settings these flags describe.
    pub fn settings(&self) -> SurfaceSettings {
        SurfaceSettings {
            density_per_angstrom2: self.density,
            probe_radius_angstrom: self.probe,
            keep_cavities: self.cavities == Cavities::Keep,
            inward_offset_angstrom: self.offset,
        }
    }
}

impl IngestArgs {
    pub(super) fn run(&self, global: &Global) -> Result<Outcome> {
        let files = input::expand(&self.inputs)?;
        if self
            .name
            .as_ref()
            .is_some_and(|name| name.contains(['/', '\\']))
        {
            bail!("--name is the name of the body, not a path; use --output for the folder");
        }
        if self.name.is_some() && files.len() > 1 {
            bail!("--name names one body, and {} files are given", files.len());
        }
        let settings = IngestSettings {
            body: body_settings(&self.selection, &self.charges, &self.surface)?,
            name: self.name.clone(),
            exports: self.export.iter().map(|export| export.ending()).collect(),
            force: global.force,
        };
        let progress = global.progress();
        let outcomes = ingest_files(&files, &self.output, &settings, progress.as_ref())?;
        drop(progress);
        for outcome in &outcomes {
            self.say(outcome, global);
        }
        if global.json {
            output::json(&serde_json::json!({"files": outcomes}))?;
        } else if !global.quiet {
            output::text(&summary(&outcomes))?;
        }
        let failed = outcomes.iter().any(|outcome| outcome.error.is_some());
        Ok(if failed {
            Outcome::Partial
        } else {
            Outcome::Done
        })
    }

    fn say(&self, outcome: &FileOutcome, global: &Global) {
        if let Some(error) = outcome.error.as_ref().filter(|_| !output::is_captured()) {
            output::note(&format!("error: {error}"));
        }
        for warning in &outcome.warnings {
            global.say(&format!("warning: {}: {warning}", outcome.file));
        }
    }
}

/// The settings these flags describe.
pub fn body_settings(
    selection: &SelectionArgs,
    charges: &ChargeArgs,
    surface: &SurfaceFlags,
) -> Result<BodySettings> {
    let model = match charges.charges {
        Charges::ForceField => ChargeModel::ForceField,
        Charges::Formal => ChargeModel::Formal,
        Charges::None => ChargeModel::None,
    };
    Ok(BodySettings {
        selection: selection.settings(),
        sites: SiteSettings {
            ph: charges.ph,
            charges: model,
        },
        mutations: charges
            .mutate
            .as_deref()
            .map(parse_mutations)
            .transpose()?
            .unwrap_or_default(),
        surface: surface.settings(),
    })
}

impl Export {
    fn ending(self) -> &'static str {
        match self {
            Export::Ply => "ply",
            Export::Obj => "obj",
            Export::Off => "off",
            Export::Stl => "stl",
            Export::Pqr => "pqr",
        }
    }
}

fn summary(outcomes: &[FileOutcome]) -> String {
    let heading = [
        "file",
        "status",
        "atoms",
        "residues",
        "net charge (e)",
        "area (Å²)",
        "volume (Å³)",
        "skipped",
    ];
    let mut rows = vec![heading.map(str::to_owned).to_vec()];
    for outcome in outcomes {
        let skipped: Vec<String> = outcome
            .skipped
            .iter()
            .map(|(why, count)| format!("{count} {why}"))
            .collect();
        rows.push(match &outcome.measures {
            None => vec![outcome.file.clone(), outcome.status.into()],
            Some(body) => vec![
                outcome.file.clone(),
                outcome.status.into(),
                body.atoms.to_string(),
                body.residues.to_string(),
                format!("{:+.2}", body.net_charge_e),
                format!("{:.0}", body.mesh_area_angstrom2),
                format!("{:.0}", body.mesh_volume_angstrom3),
                skipped.join(", "),
            ],
        });
    }
    output::table(&rows)
}
