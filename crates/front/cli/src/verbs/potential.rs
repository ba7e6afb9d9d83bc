//! `protomer potential`: the electrostatic potential around a structure.

use crate::flags::settings::choice;
use crate::front::Front;
use crate::reply::Reply;
use anyhow::{Result, anyhow, bail};
use clap::Args;
use protomer_common::{quantity, range};
use protomer_field::{
    BoundaryCondition, DielectricModel, IonModel, PotentialModel, SaltValence, SolveSettings,
    SurfaceDefinition,
};
use protomer_kernel::Electrolyte;
use protomer_kernel::setting::Choices;
use protomer_protein_verbs::potential::{PotentialSettings, potential, read_places};
use std::path::PathBuf;

/// Solve the Poisson-Boltzmann equation around a structure, PQR or body: potential in kT/e and
/// solvation energy.
#[derive(Debug, Args)]
#[command(after_long_help = examples!(
    "potential 5pti.cif.gz --salt 100mM -o bpti.mrc",
    "potential a.body --salt 0.15M --points points.txt --json"
))]
#[group(id = "PotentialResult")]
pub struct PotentialArgs {
    /// Structure, PQR or body file, optionally gzipped.
    input: PathBuf,
    /// Concentration of the salt, such as 100mM or 0.1M.
    #[arg(long, value_parser = quantity::salt_molar, allow_hyphen_values = true)]
    salt: f64,
    /// Model of the potential.
    #[arg(long, value_parser = choice::<PotentialModel>(), default_value = "poisson-boltzmann")]
    model: PotentialModel,
    /// Response of the ions: proportional to the potential, or by Boltzmann factors (the nonlinear
    /// equation).
    #[arg(long, value_parser = choice::<IonModel>(), default_value = "linear")]
    ions: IonModel,
    /// Charges of cation and anion of the salt, such as 2:1 for MgCl2.
    #[arg(long, default_value = "1:1", value_parser = salt_valence)]
    valence: SaltValence,
    /// Grid spacing, Å.
    #[arg(long, default_value_t = 0.5)]
    spacing: f64,
    /// Minimum distance between the atoms and the faces of the grid, Å.
    #[arg(long, default_value_t = 10.0)]
    margin: f64,
    /// Potential on the faces of the grid.
    #[arg(long, value_parser = choice::<BoundaryCondition>(), default_value = BoundaryCondition::default().name())]
    boundary: BoundaryCondition,
    /// Temperature, K.
    #[arg(long, default_value = "298.15", allow_hyphen_values = true, value_parser = range::TEMPERATURE.read(quantity::temperature_kelvin))]
    temperature: f64,
    /// Relative permittivity inside the surface.
    #[arg(long, default_value_t = 2.0, value_parser = range::PERMITTIVITY.number())]
    inner_permittivity: f64,
    /// Relative permittivity of the solvent; that of water at the temperature if omitted.
    #[arg(long, value_parser = range::PERMITTIVITY.number())]
    outer_permittivity: Option<f64>,
    /// Minimum distance of ion centres from the atoms, Å; 0 lets ions reach the surface.
    #[arg(long, default_value_t = 2.0, value_parser = range::RADIUS.number())]
    ion_radius: f64,
    /// The dielectric boundary.
    #[arg(long, value_parser = choice::<SurfaceDefinition>(), default_value = SurfaceDefinition::default().name())]
    surface: SurfaceDefinition,
    /// Probe radius of the surface, Å.
    #[arg(long, default_value_t = 1.4, value_parser = range::RADIUS.number())]
    probe: f64,
    /// File of points (x y z per line, Å) at which to print the potential.
    #[arg(long)]
    points: Option<PathBuf>,
    /// Omit the second solution, which estimates the error of the energy.
    #[arg(long)]
    no_error_estimate: bool,
    /// Volume file to write: .mrc for programs of electron microscopy, .ccp4 or .map for programs of
    /// crystallography (gemmi, Coot), .dx (OpenDX) or .npz (NumPy). ChimeraX and PyMOL open both kinds
    /// of map.
    #[arg(short, long)]
    output: Option<PathBuf>,
}

impl PotentialArgs {
    pub fn run(&self, front: &Front) -> Result<Reply> {
        front.warn(quantity::salt_warning([self.salt]));
        let settings = PotentialSettings {
            model: self.model,
            dielectric: self.dielectric()?,
            solve: SolveSettings {
                spacing_angstrom: self.spacing,
                margin_angstrom: self.margin,
                boundary: self.boundary,
                ..SolveSettings::default()
            },
            estimate_error: !self.no_error_estimate,
            places: self.points.as_deref().map(read_places).transpose()?,
        };
        let report = potential(
            &self.input,
            &settings,
            self.output.as_deref(),
            front.force(),
        )?;
        Ok(Reply::from_answer(report))
    }

    fn dielectric(&self) -> Result<DielectricModel> {
        if self.ions == IonModel::Boltzmann && self.model == PotentialModel::DebyeHueckel {
            bail!(
                "--model debye-hueckel is a sum of linear potentials; leave out --ions boltzmann"
            );
        }
        let strength = self.valence.ionic_strength_molar(self.salt);
        let electrolyte = match self.outer_permittivity {
            Some(permittivity) => Electrolyte::new(self.temperature, strength, permittivity)?,
            None => Electrolyte::in_water(self.temperature, strength)?,
        };
        Ok(DielectricModel {
            electrolyte,
            inner_permittivity: self.inner_permittivity,
            surface: self.surface,
            probe_angstrom: self.probe,
            ion_radius_angstrom: self.ion_radius,
            ion_response: self.ions.with(self.valence),
        })
    }
}

/// Reads the charges of the ions of a salt, such as 2:1.
fn salt_valence(text: &str) -> Result<SaltValence> {
    let charges = text.split_once(':').and_then(|(cation, anion)| {
        let [cation, anion] = [cation, anion].map(|number| number.trim().parse::<u8>().ok());
        SaltValence::new(cation?, anion?).ok()
    });
    charges.ok_or_else(|| {
        anyhow!("'{text}' is not the charges of a salt; give two numbers from 1 to 4, such as 2:1 for MgCl2")
    })
}
