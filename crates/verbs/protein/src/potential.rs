//! The electrostatic potential around a structure, from the linearised Poisson-Boltzmann equation
//! or as a sum over screened charges.

use crate::bodies::surface_of_file::read_sites;
use anyhow::{Context, Result, bail};
use protomer_common::answer::Answer;
use protomer_common::input::InputFile;
use protomer_common::output_file::require_writable;
use protomer_field::debye_huckel::Superposition;
use protomer_field::poisson_boltzmann::{error_estimate_kt, grid_around};
use protomer_field::{
    ChargedSphere, DielectricModel, Grid, PotentialModel, ScalarField, SolveSettings, solve,
};
use protomer_io::atomic::write_bytes;
use protomer_io::volume::{
    Volume,
    dx::write_dx,
    mrc::{write_ccp4, write_mrc},
    write_volume_npz,
};
use protomer_io::without_byte_order_mark;
use protomer_kernel::Vec3;
use protomer_kernel::units::kilojoule_per_mol_per_kt;
use serde::Serialize;
use std::path::Path;
use std::time::Instant;

/// The results of a potential calculation.
#[derive(Debug, Clone, Serialize)]
pub struct PotentialReport {
    /// The input file.
    pub file: String,
    /// Atoms with a radius.
    pub atoms: usize,
    /// Sum of the charges, e.
    pub net_charge_e: f64,
    /// The model of the potential.
    pub model: PotentialModel,
    /// Energy of transferring the charges from a uniform medium of the inner permittivity into
    /// the solvent, kJ/mol; null for screened Coulomb potentials, which have no interior.
    pub solvation_energy_kj_mol: Option<f64>,
    /// Estimated error of the solvation energy, from a second grid, kJ/mol; null if not requested.
    pub error_estimate_kj_mol: Option<f64>,
    /// The potential at the requested points, kT/e; null outside the grid.
    #[serde(
        rename = "potentials_kT_per_e",
        skip_serializing_if = "Option::is_none"
    )]
    pub potentials_kt_per_e: Option<Vec<Option<f64>>>,
    /// The grid.
    pub grid: Grid,
    /// Debye length, Å; null without salt.
    pub debye_length_angstrom: Option<f64>,
    /// Iterations of the solver; null without a solver.
    pub iterations: Option<usize>,
    /// Wall time, s.
    pub seconds: f64,
    /// Peak memory of the process, bytes, where the system reports it.
    pub peak_bytes: Option<u64>,
}

impl Answer for PotentialReport {
    fn text(&self) -> String {
        let debye = match self.debye_length_angstrom {
            Some(length) => format!("Debye length {length:.2} Å"),
            None => "no salt".into(),
        };
        let mut lines = vec![format!(
            "{} atoms, net charge {:+.2} e, {debye}",
            self.atoms, self.net_charge_e
        )];
        if let Some(energy) = self.solvation_energy_kj_mol {
            // The estimate is good to an order of magnitude only.
            let error = self.error_estimate_kj_mol;
            let error = error.map_or(String::new(), |error| format!(", error about {error:.1e}"));
            lines.push(format!("solvation energy {energy:.2} kJ/mol{error}"));
        }
        let [nx, ny, nz] = self.grid.shape;
        let spacing = self.grid.spacing_angstrom;
        let iterations = self.iterations;
        let iterations = iterations.map_or(String::new(), |count| format!(", {count} iterations"));
        lines.push(format!(
            "grid {nx} x {ny} x {nz} at {spacing} Å{iterations}, {:.2} s",
            self.seconds
        ));
        let potentials = self.potentials_kt_per_e.iter().flatten();
        let shown = |value: &Option<f64>| value.map_or("nan".into(), |value| format!("{value:.6}"));
        lines.extend(potentials.map(shown));
        lines.join("\n")
    }
}

/// The model of a potential, and the requested results.
#[derive(Debug, Clone)]
pub struct PotentialSettings {
    /// The model: the Poisson-Boltzmann equation, or a sum over screened charges.
    pub model: PotentialModel,
    /// Solute and solvent.
    pub dielectric: DielectricModel,
    /// The grid and the solver.
    pub solve: SolveSettings,
    /// Whether to solve a second time, to estimate the error of the energy.
    pub estimate_error: bool,
    /// Points at which to evaluate the potential, Å.
    pub places: Option<Vec<Vec3>>,
}

/// The points of the field that a calculation returns.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FieldPoints {
    /// The grid of the solution, centred on the structure.
    Solution,
    /// Points of the same spacing at whole multiples of it, between those of the solution.
    Multiples,
}

/// Computes the potential around a structure and, if an output file is given, writes it in the
/// format of the file's extension.
///
/// # Errors
/// As [`potential_of_file`]; also for an unknown extension, a missing folder, or a file that exists
/// unless `force` is set, which are refused before the computation.
pub fn potential(
    path: &Path,
    settings: &PotentialSettings,
    output: Option<&Path>,
    force: bool,
) -> Result<PotentialReport> {
    // Refused before hours of solving, not after.
    let format = output.map(VolumeFormat::of_file).transpose()?;
    output.map_or(Ok(()), |path| require_writable(path, force))?;
    let points = format.map_or(FieldPoints::Solution, VolumeFormat::points);
    let (field, report) = potential_of_file(path, settings, points)?;
    if let (Some(path), Some(format)) = (output, format) {
        let bytes = format.encode(&volume(field))?;
        write_bytes(path, &bytes)?;
    }
    Ok(report)
}

/// The formats of volume files.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum VolumeFormat {
    Mrc,
    Ccp4,
    Dx,
    Npz,
}

impl VolumeFormat {
    const ENDINGS: [(&str, Self); 5] = [
        (".mrc", Self::Mrc),
        (".map", Self::Ccp4),
        (".ccp4", Self::Ccp4),
        (".dx", Self::Dx),
        (".npz", Self::Npz),
    ];

    /// The format of an output file.
    fn of_file(path: &Path) -> Result<Self> {
        let name = path.display().to_string();
        let mut formats = Self::ENDINGS.iter();
        let Some((_, format)) = formats.find(|(ending, _)| name.ends_with(ending)) else {
            let endings = Self::ENDINGS.map(|(ending, _)| ending).join(", ");
            bail!("{name} has none of the extensions {endings}; use one of them");
        };
        Ok(*format)
    }

    /// The points that a file of this format can hold.
    fn points(self) -> FieldPoints {
        match self {
            Self::Ccp4 => FieldPoints::Multiples,
            Self::Mrc | Self::Dx | Self::Npz => FieldPoints::Solution,
        }
    }

    fn encode(self, volume: &Volume) -> Result<Vec<u8>> {
        Ok(match self {
            Self::Mrc => write_mrc("potential, kT/e", volume),
            Self::Ccp4 => write_ccp4("potential, kT/e", volume)?,
            Self::Dx => write_dx("potential, kT/e", volume).into_bytes(),
            Self::Npz => write_volume_npz("potential_kt_per_e", volume)?,
        })
    }
}

/// The atoms of a structure, PQR or body file.
///
/// # Errors
/// Names the file and the line, and says what to do.
pub fn spheres_of_file(path: &Path) -> Result<(String, Vec<ChargedSphere>)> {
    let file = InputFile::read(path)?;
    let (sites, origin) = read_sites(&file)?;
    let mut spheres = Vec::with_capacity(sites.len());
    for site in sites.iter() {
        spheres.push(ChargedSphere {
            // Bodies are stored about their centre; the potential is that of the file's frame.
            centre: site.position + origin,
            radius_angstrom: site.radius_angstrom,
            charge_e: site.charge_e,
        });
    }
    Ok((file.name, spheres))
}

/// Reads points, Å: x y z on each line. Further numbers are ignored, and `#` begins a comment.
///
/// # Errors
/// Names the line.
pub fn read_places(path: &Path) -> Result<Vec<Vec3>> {
    let file = InputFile::read(path)?;
    let text = std::str::from_utf8(without_byte_order_mark(&file.bytes))
        .with_context(|| format!("{} is not text", file.name))?;
    let mut places = Vec::new();
    for (number, line) in text.lines().enumerate() {
        let line = line.split('#').next().unwrap_or_default();
        let words: Vec<&str> = line.split_whitespace().collect();
        if words.is_empty() {
            continue;
        }
        let Some(place) = place(&words) else {
            let line = line.trim();
            bail!(
                "{}, line {}: '{line}' is not a point; give x y z in Å, three finite numbers",
                file.name,
                number + 1
            )
        };
        places.push(place);
    }
    Ok(places)
}

/// Parses three finite numbers. Others may follow, because other programs write x y z and the
/// potential.
fn place(words: &[&str]) -> Option<Vec3> {
    let mut numbers = Vec::with_capacity(words.len());
    for word in words {
        let number: f64 = word.parse().ok()?;
        if !number.is_finite() {
            return None;
        }
        numbers.push(number);
    }
    let [x, y, z, ..] = numbers[..] else {
        return None;
    };
    Some(Vec3::new(x, y, z))
}

/// Computes the potential of the atoms of a file on a grid, and the results.
///
/// # Errors
/// For a file that cannot be read, and as [`protomer_field::solve`].
///
/// ```no_run
/// use protomer_protein_verbs::potential::{FieldPoints, PotentialSettings, potential_of_file};
/// use protomer_field::{DielectricModel, PotentialModel, SolveSettings};
/// use protomer_kernel::Electrolyte;
/// use std::path::Path;
/// let salt_molar = 0.15;
/// let settings = PotentialSettings {
///     model: PotentialModel::PoissonBoltzmann,
///     dielectric: DielectricModel::new(Electrolyte::in_water(298.15, salt_molar)?),
///     solve: SolveSettings::default(),
///     estimate_error: true,
///     places: None,
/// };
/// let (field, report) =
///     potential_of_file(Path::new("5pti.pqr"), &settings, FieldPoints::Solution)?;
/// println!("{:?}: {:?} kJ/mol", field.grid.shape, report.solvation_energy_kj_mol);
/// # Ok::<(), anyhow::Error>(())
/// ```
pub fn potential_of_file(
    path: &Path,
    settings: &PotentialSettings,
    points: FieldPoints,
) -> Result<(ScalarField, PotentialReport)> {
    let start = Instant::now();
    let (file, spheres) = spheres_of_file(path)?;
    let potential = match settings.model {
        PotentialModel::PoissonBoltzmann => solved(&spheres, settings, points),
        PotentialModel::DebyeHueckel => superposed(&spheres, settings, points),
    };
    let Found {
        grid,
        field,
        energy_kt,
        error_kt,
        potentials_kt_per_e,
        iterations,
    } = potential.with_context(|| file.clone())?;
    let electrolyte = &settings.dielectric.electrolyte;
    // Energies are in kT inside, at the medium's temperature.
    let per_kt = kilojoule_per_mol_per_kt(electrolyte.temperature_kelvin());
    let debye = electrolyte.debye_length_angstrom();
    let (mut atoms, mut net_charge_e) = (0, 0.0);
    for sphere in &spheres {
        atoms += usize::from(sphere.radius_angstrom > 0.0);
        net_charge_e += sphere.charge_e;
    }
    let report = PotentialReport {
        file,
        atoms,
        net_charge_e,
        model: settings.model,
        solvation_energy_kj_mol: energy_kt.map(|energy| energy * per_kt),
        error_estimate_kj_mol: error_kt.map(|error| error * per_kt),
        potentials_kt_per_e,
        grid,
        debye_length_angstrom: debye.is_finite().then_some(debye),
        iterations,
        seconds: start.elapsed().as_secs_f64(),
        peak_bytes: peak_bytes(),
    };
    Ok((field, report))
}

/// The common results of both models.
struct Found {
    /// The grid of the solution.
    grid: Grid,
    field: ScalarField,
    energy_kt: Option<f64>,
    error_kt: Option<f64>,
    potentials_kt_per_e: Option<Vec<Option<f64>>>,
    iterations: Option<usize>,
}

fn solved(
    spheres: &[ChargedSphere],
    settings: &PotentialSettings,
    points: FieldPoints,
) -> Result<Found> {
    let (dielectric, numerical) = (&settings.dielectric, &settings.solve);
    let solved = solve(spheres, dielectric, numerical)?;
    let energy_kt = solved.solvation_energy_kt;
    let error_kt = match settings.estimate_error {
        true => Some(error_estimate_kt(
            spheres, dielectric, numerical, energy_kt,
        )?),
        false => None,
    };
    let places = settings.places.as_deref();
    let at_places = |places: &[Vec3]| places.iter().map(|place| solved.value_at(place)).collect();
    Ok(Found {
        grid: *solved.grid(),
        field: match points {
            FieldPoints::Solution => solved.field(),
            FieldPoints::Multiples => solved.on_multiples(),
        },
        energy_kt: Some(energy_kt),
        error_kt,
        potentials_kt_per_e: places.map(at_places),
        iterations: Some(solved.iterations),
    })
}

fn superposed(
    spheres: &[ChargedSphere],
    settings: &PotentialSettings,
    points: FieldPoints,
) -> Result<Found> {
    let superposition = Superposition::new(spheres, &settings.dielectric);
    let grid = grid_around(spheres, &settings.solve)?;
    let places = settings.places.as_deref();
    // Outside the grid the sum would be as right, but both models answer alike.
    let potential = |place: &Vec3| grid.locate(place).map(|_| superposition.value_at(place));
    Ok(Found {
        grid,
        field: superposition.tabulate(match points {
            FieldPoints::Solution => grid,
            FieldPoints::Multiples => grid.on_multiples(),
        }),
        energy_kt: None,
        error_kt: None,
        potentials_kt_per_e: places.map(|places| places.iter().map(potential).collect()),
        iterations: None,
    })
}

/// Converts the potential to a volume for output.
pub fn volume(field: ScalarField) -> Volume {
    let ScalarField { grid, values } = field;
    let Grid {
        shape,
        origin_angstrom,
        spacing_angstrom,
    } = grid;
    Volume {
        shape,
        origin_angstrom,
        spacing_angstrom,
        values,
    }
}

/// Peak memory of this process.
fn peak_bytes() -> Option<u64> {
    let status = protomer_io::input::read_to_string("/proc/self/status").ok()?;
    let line = status
        .lines()
        .find_map(|line| line.strip_prefix("VmHWM:"))?;
    // The line states kB.
    Some(line.split_whitespace().next()?.parse::<u64>().ok()? * 1024)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_of_points_holds_three_finite_numbers_or_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("places.txt");
        let read = |text: &str| {
            std::fs::write(&path, text).unwrap();
            read_places(&path)
        };
        assert_eq!(
            read("\u{feff}1 2 3\n\n# none\n-1e1 0 0.5 # one\n")
                .unwrap()
                .len(),
            2
        );
        assert_eq!(read("1 2 3 -0.25\n").unwrap(), [Vec3::new(1.0, 2.0, 3.0)]);
        for line in ["1 2 3 hello", "nan 0 0", "0 inf 0", "1 2", "hello"] {
            let message = read(&format!("0 0 0\n{line}\n")).unwrap_err().to_string();
            assert!(message.contains(&format!("line 2: '{line}'")), "{message}");
        }
    }
}
