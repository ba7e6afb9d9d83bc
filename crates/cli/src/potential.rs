//! `protomer potential`: the electrostatic potential around a structure.

use super::potential_name::PotentialName;
use super::{Global, Outcome, output};
use anyhow::{Result, bail};
use clap::{Args, ValueEnum};
use protomer::potential::{PotentialReport, potential_of_file, read_places, volume};
use protomer::quantity;
use protomer_field::{Boundary, Medium, SolveSettings, SurfaceDefinition};
use protomer_io::atomic::write_atomically;
use protomer_io::volume::{dx::write_dx, mrc::write_mrc, write_volume_npz};
use protomer_kernel::Conditions;
use std::path::PathBuf;

/// Solve the linearised Poisson-Boltzmann equation around a structure, PQR or body: potential in
/// kT/e and solvation energy.
#[derive(Debug, Args)]
pub struct PotentialArgs {
    /// Structure, PQR or body file, perhaps gzipped.
    input: PathBuf,
    /// Concentration of a 1:1 salt, such as 100mM or 0.1M.
    #[arg(long, value_parser = quantity::salt_molar, allow_hyphen_values = true)]
    salt: f64,
    /// How the potential is found.
    #[arg(long, value_enum, default_value_t = PotentialName::PoissonBoltzmann)]
    model: PotentialName,
    /// Grid spacing, Å.
    #[arg(long, default_value_t = 0.5, allow_negative_numbers = true)]
    spacing: f64,
    /// From the atoms to the faces of the grid at least, Å.
    #[arg(long, default_value_t = 10.0, allow_negative_numbers = true)]
    margin: f64,
    /// Potential on the faces of the grid.
    #[arg(long, value_enum, default_value_t = BoundaryValues::ScreenedAtoms)]
    boundary: BoundaryValues,
    /// Temperature, K.
    #[arg(long, default_value_t = 298.15, allow_negative_numbers = true)]
    temperature: f64,
    /// Relative permittivity inside the surface.
    #[arg(long, default_value_t = 2.0, allow_negative_numbers = true)]
    inner_permittivity: f64,
    /// Relative permittivity of the solvent; that of water at the temperature if left out.
    #[arg(long, allow_negative_numbers = true)]
    outer_permittivity: Option<f64>,
    /// Ions keep their centres this far from the atoms, Å; 0: up to the surface.
    #[arg(long, default_value_t = 2.0, allow_negative_numbers = true)]
    ion_radius: f64,
    /// The dielectric boundary.
    #[arg(long, value_enum, default_value_t = Surface::SolventExcluded)]
    surface: Surface,
    /// Probe radius of the surface, Å.
    #[arg(long, default_value_t = 1.4, allow_negative_numbers = true)]
    probe: f64,
    /// File of points (x y z per line, Å) at which to print the potential.
    #[arg(long)]
    points: Option<PathBuf>,
    /// Leave out the second solve that tells the error of the energy.
    #[arg(long)]
    no_error_estimate: bool,
    /// Volume file to write: .mrc, .map, .ccp4, .dx or .npz.
    #[arg(short, long)]
    output: Option<PathBuf>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Surface {
    /// Where a probe that rolls over the atoms cannot get in.
    SolventExcluded,
    /// The atoms themselves: crevices between them hold solvent.
    VanDerWaals,
    /// Where the centre of the probe gets: the atoms grown by its radius.
    SolventAccessible,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum BoundaryValues {
    /// The sum of the atoms' Debye-Hückel potentials, each alone in the solvent.
    ScreenedAtoms,
    /// From a solve on a coarse grid twice as large: hardly depends on the margin.
    CoarseGrid,
}

impl PotentialArgs {
    pub(super) fn run(&self, global: &Global) -> Result<Outcome> {
        let name = self.output.as_ref().map(|path| path.display().to_string());
        let known = [".mrc", ".map", ".ccp4", ".dx", ".npz"];
        if let Some(name) = name
            .as_ref()
            .filter(|name| !known.iter().any(|ending| name.ends_with(ending)))
        {
            bail!(
                "{name} has none of the endings {}; name one of them",
                known.join(", ")
            );
        }
        let folder = self
            .output
            .as_ref()
            .and_then(|path| path.parent())
            .filter(|folder| !folder.as_os_str().is_empty());
        if let Some(folder) = folder.filter(|folder| !folder.is_dir()) {
            bail!(
                "there is no folder {} to write into; make it first",
                folder.display()
            );
        }
        let conditions = match self.outer_permittivity {
            Some(permittivity) => {
                Conditions::with_permittivity(self.temperature, self.salt, 7.0, permittivity)?
            }
            None => Conditions::new(self.temperature, self.salt, 7.0)?,
        };
        let medium = Medium {
            conditions,
            inner_permittivity: self.inner_permittivity,
            surface: match self.surface {
                Surface::SolventExcluded => SurfaceDefinition::SolventExcluded,
                Surface::VanDerWaals => SurfaceDefinition::VanDerWaals,
                Surface::SolventAccessible => SurfaceDefinition::SolventAccessible,
            },
            probe_angstrom: self.probe,
            ion_radius_angstrom: self.ion_radius,
        };
        let settings = SolveSettings {
            spacing_angstrom: self.spacing,
            margin_angstrom: self.margin,
            boundary: match self.boundary {
                BoundaryValues::ScreenedAtoms => Boundary::ScreenedAtoms,
                BoundaryValues::CoarseGrid => Boundary::CoarseGrid,
            },
            ..SolveSettings::default()
        };
        let places = self
            .points
            .as_ref()
            .map(|path| read_places(path))
            .transpose()?;
        let model = self.model.model();
        let estimate_error = !self.no_error_estimate;
        let (field, report) = potential_of_file(
            &self.input,
            &medium,
            &settings,
            model,
            estimate_error,
            places.as_deref(),
        )?;
        if let (Some(path), Some(name)) = (&self.output, name) {
            let volume = volume(field);
            let bytes = if name.ends_with(".dx") {
                write_dx("potential, kT/e", &volume).into_bytes()
            } else if name.ends_with(".npz") {
                write_volume_npz("potential_kt_per_e", &volume)?
            } else {
                write_mrc("potential, kT/e", &volume)
            };
            write_atomically(path, |file| file.write_all(&bytes))?;
        }
        if global.json {
            output::json(&report)?;
        } else if !global.quiet {
            output::text(&describe(&report))?;
        }
        Ok(Outcome::Done)
    }
}

fn describe(report: &PotentialReport) -> String {
    let debye = report
        .debye_length_angstrom
        .map_or("no salt".into(), |debye| {
            format!("Debye length {debye:.2} Å")
        });
    let mut lines = vec![format!(
        "{} atoms, net charge {:+.2} e, {debye}",
        report.atoms, report.net_charge_e
    )];
    if let Some(energy) = report.solvation_energy_kj_mol {
        // Of the estimate no more than its size is worth telling.
        let error = report
            .error_estimate_kj_mol
            .map_or(String::new(), |error| format!(", error about {error:.1e}"));
        lines.push(format!("solvation energy {energy:.2} kJ/mol{error}"));
    }
    let [nx, ny, nz] = report.grid.shape;
    let iterations = report
        .iterations
        .map_or(String::new(), |count| format!(", {count} iterations"));
    let spacing = report.grid.spacing_angstrom;
    lines.push(format!(
        "grid {nx} x {ny} x {nz} at {spacing} Å{iterations}, {:.2} s",
        report.seconds
    ));
    let potentials = report.potentials_kt_per_e.iter().flatten();
    lines.extend(potentials.map(|value| value.map_or("nan".into(), |value| format!("{value:.6}"))));
    lines.join("\n")
}
