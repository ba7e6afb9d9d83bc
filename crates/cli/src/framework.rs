//! `protomer framework`: elastic constants of networks of rods and hinges.

use super::framework_builders::Builder;
use super::{Global, Outcome, output};
use anyhow::{Context, Result, bail};
use clap::error::ErrorKind;
use clap::{Args, CommandFactory, ValueEnum};
use protomer::frameworks::curve::{self, Curve};
use protomer::frameworks::report::{Analytic, Relax, Report, Settings, analyse};
use protomer::frameworks::{directory, network_file, tables};
use protomer::quantity::length_angstrom;
use protomer_crystal::framework::{AVOGADRO_PER_MOL, Framework, StressKind};
use protomer_results::ResultKind;
use protomer_results::keys::nearest;
use std::path::PathBuf;

/// What `framework` builds, besides files.
const BUILDERS: [&str; 8] = [
    "honeycomb",
    "rotating-squares",
    "rotating-triangles",
    "arrowhead",
    "rod-lattice",
    "fcc",
    "diamond",
    "tables",
];

/// More nodes than can be analysed in reasonable time and memory.
const MOST_NODES: usize = 1_000_000;

/// Elastic constants, mechanisms and deformation of a periodic network of rods and hinges: one that
/// is built from a few numbers, or one of your own in a TOML file (--write shows what that looks
/// like).
#[derive(Debug, Args)]
#[command(
    args_conflicts_with_subcommands = false,
    subcommand_value_name = "BUILDER",
    subcommand_help_heading = "Commands"
)]
pub struct FrameworkArgs {
    #[command(subcommand)]
    builder: Option<Builder>,
    /// Network file, in place of a builder.
    #[arg(value_name = "NET.toml")]
    file: Option<PathBuf>,
    #[command(flatten)]
    analysis: AnalysisArgs,
}

/// What is done with the network.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Analysis")]
pub struct AnalysisArgs {
    /// Avogadro's number that converts kcal/mol/Å³ to GPa, 1/mol [default: 6.02214076e23].
    #[arg(long, global = true, allow_negative_numbers = true)]
    na: Option<f64>,
    /// Cells along each cell vector, such as 2x2.
    #[arg(long, global = true)]
    cells: Option<String>,
    /// Extent of a two-dimensional network along x [default: 1A, or what the file says].
    #[arg(long, global = true, allow_hyphen_values = true)]
    thickness: Option<String>,
    /// Find the minimum of the energy first, nodes and cell.
    #[arg(long, global = true)]
    relax: bool,
    /// With --relax: keep the cell.
    #[arg(long, global = true, requires = "relax")]
    fixed_cell: bool,
    /// Axis along which to load the network: x, y or z.
    #[arg(long, global = true, requires = "stress")]
    load: Option<String>,
    /// Stresses to apply one after the other, such as 1GPa,2GPa; negative ones push.
    #[arg(long, global = true, requires = "load", allow_hyphen_values = true)]
    stress: Option<String>,
    /// What the stress is referred to [default: nominal].
    #[arg(long, global = true, value_enum)]
    stress_kind: Option<Kind>,
    /// Print energy, forces and Hessian (with --json or -o).
    #[arg(long, global = true)]
    derivatives: bool,
    /// Write the network as TOML.
    #[arg(long, global = true, value_name = "NET.toml")]
    write: Option<PathBuf>,
    /// Folder for result.json, tables (CSV), the drawing and the figure.
    #[arg(short, long, global = true)]
    output: Option<PathBuf>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Kind {
    /// Force per area before loading.
    Nominal,
    /// Force per area under load.
    Cauchy,
}

impl FrameworkArgs {
    pub(super) fn run(&self, global: &Global) -> Result<Outcome> {
        let thickness = self
            .analysis
            .thickness
            .as_deref()
            .map(length_angstrom)
            .transpose()?;
        let (mut network, name) = match (&self.builder, &self.file) {
            (Some(_), Some(file)) => {
                bail!(
                    "{} and a builder are both named; give one of them",
                    file.display()
                )
            }
            (None, None) => bail!(
                "name a network: a TOML file or one of {}",
                BUILDERS.join(", ")
            ),
            (None, Some(file)) => {
                self.refuse_unknown(file)?;
                (network_file::read(file)?, file.display().to_string())
            }
            (Some(builder), None) => {
                match (builder.build(thickness.unwrap_or(1.0))?, builder.describe()) {
                    (Some(network), Some(name)) => (network, name),
                    _ => return self.tables(global),
                }
            }
        };
        if let Some(thickness) = thickness {
            if network.dimension() == 3 {
                bail!("--thickness is for two-dimensional networks; this one has three dimensions");
            }
            network.thickness_angstrom = thickness;
        }
        if let Some(cells) = &self.analysis.cells {
            let counts = cell_counts(cells, network.dimension())?;
            let nodes = counts
                .iter()
                .try_fold(network.nodes_angstrom.len(), |nodes, count| {
                    nodes.checked_mul(*count)
                });
            if nodes.is_none_or(|nodes| nodes > MOST_NODES) {
                bail!("--cells {cells} makes more than {MOST_NODES} nodes; ask for fewer cells");
            }
            network = network.supercell(&counts)?;
        }
        if let Some(path) = &self.analysis.write {
            directory::write_one(path, &network_file::to_toml(&network, &name), global.force)?;
            global.say(&format!("network: {}", path.display()));
        }
        self.analyse(&network, &name, global)
    }

    fn analyse(&self, network: &Framework, name: &str, global: &Global) -> Result<Outcome> {
        let args = &self.analysis;
        if args.derivatives && !global.json && args.output.is_none() {
            bail!("--derivatives go into the JSON; add --json or -o DIR");
        }
        let settings = args.settings()?;
        let (placed, mut report) = analyse(network, name, &settings)?;
        if let (Some(Builder::Honeycomb(honeycomb)), None) = (&self.builder, settings.relax) {
            let made_of = honeycomb.made_of(network.thickness_angstrom);
            report.analytic = Some(Analytic::of(&made_of, report.gpa_per_kcal_mol_angstrom3));
        }
        let mut loaded = None;
        if let (Some(axis), Some(stress)) = (&args.load, &args.stress) {
            let kind = match args.stress_kind {
                Some(Kind::Cauchy) => StressKind::Cauchy,
                _ => StressKind::Nominal,
            };
            let stresses = curve::stresses_gpa(stress)?;
            let (curve, last) = curve::load(
                &placed,
                axis,
                &stresses,
                kind,
                report.gpa_per_kcal_mol_angstrom3,
            )?;
            report.curve = Some(curve);
            loaded = Some(last);
        } else if args.stress_kind.is_some() {
            bail!("--stress-kind says what --stress is referred to; add --load y --stress 1GPa");
        }
        if !report.at_rest() {
            global.say(&format!(
                "warning: the network is not at rest: a force of {:.3e} kcal/mol/Å is left; --relax finds the minimum",
                report.largest_force_kcal_mol_angstrom
            ));
        }
        if let Some(folder) = &args.output {
            let files = directory::files(&report, &placed, loaded.as_ref())?;
            directory::write(folder, ResultKind::ElasticConstants, &files, global.force)?;
        }
        if global.json {
            output::json(&report)?;
        } else if !global.quiet {
            output::text(&describe(&report)?)?;
        }
        if let Some(folder) = &args.output {
            global.say(&format!(
                "drawing: {}",
                folder.join("drawing.svg").display()
            ));
        }
        Ok(Outcome::Done)
    }

    fn tables(&self, global: &Global) -> Result<Outcome> {
        let args = &self.analysis;
        let unused = [
            ("--na", args.na.is_some()),
            ("--cells", args.cells.is_some()),
            ("--thickness", args.thickness.is_some()),
            ("--relax", args.relax),
            ("--load", args.load.is_some()),
            ("--stress-kind", args.stress_kind.is_some()),
            ("--derivatives", args.derivatives),
            ("--write", args.write.is_some()),
        ];
        if let Some((flag, _)) = unused.iter().find(|(_, given)| *given) {
            bail!("tables are those of the paper and take no {flag}");
        }
        let rows = tables::rows()?;
        let text: Vec<String> = tables::describe(&rows)
            .into_iter()
            .map(|(title, lines)| format!("{title}\n{}\n", output::table(&lines)))
            .collect();
        let text = format!("{}\n{}", text.join("\n"), tables::legend(&rows));
        if let Some(folder) = &args.output {
            let files = [
                (
                    "tables.json".to_owned(),
                    (serde_json::to_string_pretty(&rows)? + "\n").into_bytes(),
                ),
                ("tables.txt".to_owned(), (text.clone() + "\n").into_bytes()),
            ];
            directory::write(folder, ResultKind::FrameworkTables, &files, global.force)?;
        }
        if global.json {
            output::json(&rows)?;
        } else if !global.quiet {
            output::text(&text)?;
        }
        Ok(Outcome::Done)
    }

    /// A word that is neither a file nor ends like one is a misspelt builder.
    fn refuse_unknown(&self, file: &std::path::Path) -> Result<()> {
        let word = file.to_string_lossy();
        if !file.exists() && file.extension().is_none() {
            bail!("{}", unknown(&word));
        }
        Ok(())
    }
}

fn unknown(word: &str) -> String {
    let hint = nearest(word, BUILDERS)
        .map_or_else(String::new, |name| format!("; did you mean '{name}'?"));
    format!(
        "'{word}' is no network file and no builder ({}){hint}",
        BUILDERS.join(", ")
    )
}

/// Where an unknown flag follows a misspelt builder, the builder is what is wrong.
pub(super) fn explain_usage(error: clap::Error) -> clap::Error {
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
            super::Cli::command().error(ErrorKind::InvalidSubcommand, unknown(word))
        }
        _ => error,
    }
}

impl AnalysisArgs {
    fn settings(&self) -> Result<Settings> {
        let avogadro_per_mol = self.na.unwrap_or(AVOGADRO_PER_MOL);
        if !(avogadro_per_mol.is_finite() && avogadro_per_mol > 0.0) {
            bail!("--na is {avogadro_per_mol}; Avogadro's number is about 6.022e23 /mol");
        }
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
}

/// `2x2`, or one number for all directions.
fn cell_counts(text: &str, dimension: usize) -> Result<Vec<usize>> {
    let counts: Result<Vec<usize>, _> = text
        .split('x')
        .map(|count| count.trim().parse::<usize>())
        .collect();
    let counts = counts
        .ok()
        .context(format!("--cells is '{text}'; write it like 2x2"))?;
    match counts.as_slice() {
        [one] => Ok(vec![*one; dimension]),
        several if several.len() == dimension => Ok(counts),
        _ => bail!(
            "--cells is '{text}'; the network has {dimension} dimensions, so give {dimension} counts"
        ),
    }
}

fn describe(report: &Report) -> Result<String> {
    let [head, tail] = report.describe();
    let mut text = format!(
        "{head}\n\n{}\n\n{tail}",
        output::table(&report.moduli_rows())
    );
    if let Some(curve) = &report.curve {
        text += &format!("\n\n{}", describe_curve(curve)?);
    }
    Ok(text)
}

fn describe_curve(curve: &Curve) -> Result<String> {
    let kind = match curve.stress_kind {
        StressKind::Nominal => "nominal",
        StressKind::Cauchy => "Cauchy",
    };
    Ok(format!(
        "loaded along {} ({kind} stress):\n{}",
        curve.axis,
        output::table(&curve.rows()?)
    ))
}
