//! `protomer framework`: elastic constants of networks of rods and hinges.

mod builders;

use crate::Cli;
use crate::flags::settings::choice;
use crate::front::Front;
use crate::reply::Reply;
use anyhow::{Result, bail};
use builders::Builder;
use clap::error::ErrorKind;
use clap::{Args, CommandFactory};
use protomer_common::quantity::length_angstrom;
use protomer_common::range::Range;
use protomer_linkage::framework::analytic::Honeycomb;
use protomer_linkage::framework::{AVOGADRO_PER_MOL, Flexure, Framework, StressKind};
use protomer_linkage_verbs::frameworks::answer::{
    Analysis, LoadSettings, PaperTables, cell_counts,
};
use protomer_linkage_verbs::frameworks::report::{Relax, Report, Settings};
use protomer_linkage_verbs::frameworks::scan::{Scan, ScannedParameter};
use protomer_linkage_verbs::frameworks::{competition, curve, network_file};
use protomer_results::keys::nearest;
use std::path::{Path, PathBuf};

/// The builders of `framework`.
const BUILDERS: [&str; 12] = [
    "honeycomb",
    "rotating-squares",
    "rotating-triangles",
    "arrowhead",
    "missing-rib",
    "stars",
    "chiral",
    "rod-lattice",
    "fcc",
    "diamond",
    "alpha-cristobalite",
    "tables",
];

/// Values of the Avogadro constant in the literature.
const AVOGADRO: Range = Range::new(5.9e23, 6.2e23, "/mol");

/// Segments of a rib that flexes: moduli are then 0.8 % below those of a beam.
const SEGMENTS: usize = 16;

/// Upper limit for the number of nodes, set by time and memory.
const MOST_NODES: usize = 1_000_000;

/// Elastic constants, mechanisms and deformation of a periodic network of rods and hinges: from a
/// builder, or custom, from a TOML file (--write gives an example).
#[derive(Debug, Args)]
#[command(
    args_conflicts_with_subcommands = false,
    subcommand_value_name = "BUILDER",
    subcommand_help_heading = "Commands"
)]
#[command(after_long_help = examples!(
    "framework honeycomb --theta 60 --kh 50 --ks 10000",
    "framework net.toml --load y --stress 1GPa,2GPa -o pulled"
))]
#[group(id = "FrameworkResult")]
pub struct FrameworkArgs {
    #[command(subcommand)]
    builder: Option<Builder>,
    /// Network file (TOML), instead of a builder.
    #[arg(value_name = "NET.toml")]
    file: Option<PathBuf>,
    #[command(flatten)]
    analysis: AnalysisArgs,
}

/// The analysis of the network.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Analysis")]
pub struct AnalysisArgs {
    /// Avogadro constant for the conversion of kcal/mol/Å³ to GPa, 1/mol [default: 6.02214076e23].
    #[arg(long, global = true)]
    na: Option<f64>,
    /// Cells along each cell vector, such as 2x2.
    #[arg(long, global = true)]
    cells: Option<String>,
    /// Thickness of a two-dimensional network, along x [default: 1A, or that of the file].
    #[arg(long, global = true, allow_hyphen_values = true)]
    thickness: Option<String>,
    /// First minimise the energy over nodes and cell.
    #[arg(long, global = true)]
    relax: bool,
    /// With --relax: keep the cell fixed.
    #[arg(long, global = true, requires = "relax")]
    fixed_cell: bool,
    /// EI of ribs that flex and are joined rigidly, in place of hinges (give --kh 0), kcal Å/mol.
    #[arg(long, global = true)]
    flexure: Option<f64>,
    /// Segments of each rib that flexes [default: 16].
    #[arg(long, global = true, requires = "flexure")]
    segments: Option<usize>,
    /// Analyse the network over a range of a parameter, such as theta=30:150:10 (from, to, step) or
    /// h=1,2; repeatable, for all combinations.
    #[arg(long, global = true, value_name = "NAME=VALUES")]
    scan: Vec<String>,
    /// Axis along which to load the network: x, y or z.
    #[arg(long, global = true, requires = "stress")]
    load: Option<String>,
    /// Stresses to apply one after another, such as 1GPa,2GPa; negative values are compressive.
    #[arg(long, global = true, requires = "load", allow_hyphen_values = true)]
    stress: Option<String>,
    /// Reference area of the stress [default: nominal].
    #[arg(long, global = true, value_parser = choice::<StressKind>())]
    stress_kind: Option<StressKind>,
    /// Report energy, forces and Hessian (with --json or -o).
    #[arg(long, global = true)]
    derivatives: bool,
    /// Write the network as TOML.
    #[arg(long, global = true, value_name = "NET.toml")]
    write: Option<PathBuf>,
    /// Folder for result.json, tables (CSV), the drawing and the figure.
    #[arg(short, long, global = true)]
    output: Option<PathBuf>,
}

impl FrameworkArgs {
    pub fn run(&self, front: &Front) -> Result<Reply> {
        let thickness = self.analysis.thickness.as_deref();
        let thickness = thickness.map(length_angstrom).transpose()?;
        if !self.analysis.scan.is_empty() {
            return self.scan(thickness);
        }
        let (network, name) = match (&self.builder, &self.file) {
            (Some(_), Some(file)) => {
                bail!(
                    "both {} and a builder are given; give only one",
                    file.display()
                )
            }
            (None, None) => bail!(
                "give a network: a TOML file or one of {}",
                BUILDERS.join(", ")
            ),
            (None, Some(file)) => {
                refuse_unknown(file)?;
                (network_file::read(file)?, file.display().to_string())
            }
            (Some(builder), None) => {
                match (builder.build(thickness.unwrap_or(1.0))?, builder.describe()) {
                    (Some(network), Some(name)) => (network, name),
                    _ => return self.tables(front),
                }
            }
        };
        let (network, name) = self.flex(network, name)?;
        let network = self.analysis.shape(network, thickness)?;
        self.analyse(network, name, front)
    }

    /// The network with ribs that flex, if they are to.
    fn flex(&self, network: Framework, name: String) -> Result<(Framework, String)> {
        let Some(flexure) = self.analysis.flexure() else {
            return Ok((network, name));
        };
        let first = match &self.builder {
            None => Some(0),
            Some(builder) => builder.rods_before_ribs(),
        };
        let Some(first) = first else {
            bail!(
                "--flexure is for honeycomb, arrowhead, missing-rib, stars, chiral and network files; the rods of \
                 this network have no bending"
            );
        };
        let name = format!(
            "{name}, EI = {} in {} segments",
            flexure.bending_stiffness_kcal_angstrom_mol, flexure.segments
        );
        Ok((network.flexing(first, &flexure)?, name))
    }

    /// Analyses the networks of a scan.
    fn scan(&self, thickness: Option<f64>) -> Result<Reply> {
        let args = &self.analysis;
        let Some(builder) = &self.builder else {
            bail!(
                "--scan changes the parameters of a builder; give one of {}",
                BUILDERS.join(", ")
            );
        };
        let unused = [
            ("--load", args.load.is_some()),
            ("--derivatives", args.derivatives),
            ("--write", args.write.is_some()),
            ("--output", args.output.is_some()),
        ];
        if let Some((flag, _)) = unused.iter().find(|(_, is_given)| *is_given) {
            bail!("--scan prints a table and does not accept {flag}; --json prints it as JSON");
        }
        let parameters = args.scan.iter().map(|text| ScannedParameter::parse(text));
        let parameters = parameters.collect::<Result<Vec<_>>>()?;
        for parameter in &parameters {
            for value in &parameter.values {
                builder.clone().set(&parameter.name, *value)?;
            }
        }
        let scan = Scan::run(&parameters, &args.settings()?, |values| {
            let mut builder = builder.clone();
            for (parameter, value) in parameters.iter().zip(values) {
                builder.set(&parameter.name, *value)?;
            }
            let Some(network) = builder.build(thickness.unwrap_or(1.0))? else {
                bail!("the tables of the paper have no parameters to scan");
            };
            let (network, _) = self.flex(network, String::new())?;
            args.shape(network, thickness)
        })?;
        Ok(Reply::from_answer(scan))
    }

    fn analyse(&self, network: Framework, name: String, front: &Front) -> Result<Reply> {
        let args = &self.analysis;
        if args.derivatives && !front.flags().json && args.output.is_none() {
            bail!("--derivatives only affects the JSON; add --json or -o DIR");
        }
        let competition = competition::warning(&network).unwrap_or_default();
        let analysis = Analysis {
            honeycomb: self.honeycomb(network.thickness_angstrom),
            network,
            name,
            settings: args.settings()?,
            load: args.load()?,
            network_file: args.write.clone(),
            output: args.output.clone(),
        };
        let report = analysis.run(front.force())?;
        let mut notes = args.notes(&report);
        if report.relaxed.is_none() && report.at_rest() {
            notes.extend(competition);
        }
        Ok(Reply::from_answer(report).with_notes(notes))
    }

    /// The parameters of the honeycomb, if it is one.
    fn honeycomb(&self, thickness_angstrom: f64) -> Option<Honeycomb> {
        match &self.builder {
            Some(Builder::Honeycomb(honeycomb)) if self.analysis.flexure.is_none() => {
                Some(honeycomb.made_of(thickness_angstrom))
            }
            _ => None,
        }
    }

    fn tables(&self, front: &Front) -> Result<Reply> {
        let args = &self.analysis;
        let unused = [
            ("--na", args.na.is_some()),
            ("--cells", args.cells.is_some()),
            ("--thickness", args.thickness.is_some()),
            ("--relax", args.relax),
            ("--flexure", args.flexure.is_some()),
            ("--load", args.load.is_some()),
            ("--stress-kind", args.stress_kind.is_some()),
            ("--derivatives", args.derivatives),
            ("--write", args.write.is_some()),
        ];
        if let Some((flag, _)) = unused.iter().find(|(_, is_given)| *is_given) {
            bail!("the tables are those of the paper and do not accept {flag}");
        }
        let tables = PaperTables::compute(args.output.as_deref(), front.force())?;
        Ok(Reply::from_answer(tables))
    }
}

/// Refuses a word that is neither a file nor has an extension: it is a misspelt builder.
fn refuse_unknown(file: &Path) -> Result<()> {
    if !file.exists() && file.extension().is_none() {
        bail!("{}", unknown(&file.to_string_lossy()));
    }
    Ok(())
}

fn unknown(word: &str) -> String {
    let hint = nearest(word, BUILDERS)
        .map_or_else(String::new, |name| format!("; did you mean '{name}'?"));
    format!(
        "'{word}' is neither a network file nor a builder ({}){hint}",
        BUILDERS.join(", ")
    )
}

/// Explains a usage error: if an unknown flag follows a misspelt builder, it is about the builder.
pub fn explain_usage(error: clap::Error) -> clap::Error {
    if error.kind() != ErrorKind::UnknownArgument {
        return error;
    }
    let words: Vec<String> = std::env::args().skip(1).collect();
    let verb = words.iter().position(|word| word == "framework");
    let builder = verb.and_then(|verb| words.get(verb + 1));
    match builder {
        Some(word)
            if !word.starts_with('-')
                && !BUILDERS.contains(&word.as_str())
                && !word.ends_with(".toml")
                && !std::path::Path::new(word).exists() =>
        {
            Cli::command().error(ErrorKind::InvalidSubcommand, unknown(word))
        }
        _ => error,
    }
}

impl AnalysisArgs {
    fn flexure(&self) -> Option<Flexure> {
        Some(Flexure {
            bending_stiffness_kcal_angstrom_mol: self.flexure?,
            segments: self.segments.unwrap_or(SEGMENTS),
        })
    }

    fn settings(&self) -> Result<Settings> {
        let avogadro_per_mol = self.na.unwrap_or(AVOGADRO_PER_MOL);
        AVOGADRO.require("--na", avogadro_per_mol)?;
        let relax = match (self.relax, self.fixed_cell) {
            (false, _) => None,
            (true, false) => Some(Relax::FreeCell),
            (true, true) => Some(Relax::FixedCell),
        };
        Ok(Settings {
            avogadro_per_mol,
            relax,
            derivatives: self.derivatives,
        })
    }

    /// The network with the requested thickness and cells.
    fn shape(&self, mut network: Framework, thickness: Option<f64>) -> Result<Framework> {
        if let Some(thickness) = thickness {
            if network.dimension() == 3 {
                bail!("--thickness is for two-dimensional networks; this one has three dimensions");
            }
            network.thickness_angstrom = thickness;
        }
        let Some(cells) = &self.cells else {
            return Ok(network);
        };
        let counts = cell_counts(cells, network.dimension())?;
        let in_one_cell = network.nodes_angstrom.len();
        let nodes = counts
            .iter()
            .try_fold(in_one_cell, |nodes, count| nodes.checked_mul(*count));
        if nodes.is_none_or(|nodes| nodes > MOST_NODES) {
            bail!("--cells {cells} makes more than {MOST_NODES} nodes; ask for fewer cells");
        }
        Ok(network.supercell(&counts)?)
    }

    fn load(&self) -> Result<Option<LoadSettings>> {
        let (Some(axis), Some(stress)) = (&self.load, &self.stress) else {
            if self.stress_kind.is_some() {
                bail!(
                    "--stress-kind is the reference area of --stress; add --load y --stress 1GPa"
                );
            }
            return Ok(None);
        };
        Ok(Some(LoadSettings {
            axis: axis.clone(),
            stresses_gpa: curve::stresses_gpa(stress)?,
            kind: self.stress_kind.unwrap_or(StressKind::Nominal),
        }))
    }

    /// The paths of written files, and warnings.
    fn notes(&self, report: &Report) -> Vec<String> {
        let mut lines = Vec::new();
        if let Some(path) = &self.write {
            lines.push(format!("network: {}", path.display()));
        }
        if !report.at_rest() {
            lines.push(format!(
                "warning: the network is not at rest: a force of {:.3e} kcal/mol/Å is left; --relax \
                 finds the minimum",
                report.largest_force_kcal_mol_angstrom
            ));
        }
        if let Some(folder) = &self.output {
            lines.push(format!("drawing: {}", folder.join("drawing.svg").display()));
        }
        lines
    }
}
