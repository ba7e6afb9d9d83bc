//! The electrostatic potential around a structure, by the linearised Poisson-Boltzmann equation or
//! as screened charges.

use crate::answer::Answer;
use crate::bodies::surface_of_file::read_sites;
use crate::input::InputFile;
use anyhow::{Context, Result, bail};
use protomer_field::debye_huckel::Superposition;
use protomer_field::poisson_boltzmann::{error_estimate_kt, grid_around};
use protomer_field::{
    ChargedSphere, DielectricModel, Grid, PotentialModel, ScalarField, SolveSettings, solve,
};
use protomer_io::atomic::write_atomically;
use protomer_io::volume::{Volume, dx::write_dx, mrc::write_mrc, write_volume_npz};
use protomer_io::without_byte_order_mark;
use protomer_kernel::Vec3;
use protomer_kernel::units::kilojoule_per_mol_per_kt;
use serde::Serialize;
use std::path::Path;
use std::time::Instant;

/// What is known of a potential.
#[derive(Debug, Clone, Serialize)]
pub struct PotentialReport {
    /// The input file.
    pub file: String,
    /// Atoms with a radius.
    pub atoms: usize,
    /// Sum of the charges, e.
    pub net_charge_e: f64,
    /// How the potential was found.
    pub model: PotentialModel,
    /// Energy of moving the charges from a medium like their inside into the solvent, kJ/mol; null
    /// for screened Coulomb potentials, which know no inside.
    pub solvation_energy_kj_mol: Option<f64>,
    /// How far that is off, as a second grid lets expect, kJ/mol; null if not asked for.
    pub error_estimate_kj_mol: Option<f64>,
    /// The potential at the points asked for, kT/e; null outside the grid.
    #[serde(
        rename = "potentials_kT_per_e",
        skip_serializing_if = "Option::is_none"
    )]
    pub potentials_kt_per_e: Option<Vec<Option<f64>>>,
    /// The grid.
    pub grid: Grid,
    /// Debye length, Å; null without salt.
    pub debye_length_angstrom: Option<f64>,
    /// Iterations of the solver; null if nothing was solved.
    pub iterations: Option<usize>,
    /// Wall time, s.
    pub seconds: f64,
    /// The most memory the process has held, bytes, where the system tells.
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
            // Only the size of the estimate is worth telling.
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

/// How a potential is found, and what is wanted of it.
#[derive(Debug, Clone)]
pub struct PotentialSettings {
    /// The equation, or the sum that stands for it.
    pub model: PotentialModel,
    /// Solute and solvent.
    pub dielectric: DielectricModel,
    /// The grid and the solver.
    pub solve: SolveSettings,
    /// Solve a second time, for the error of the energy.
    pub estimate_error: bool,
    /// Points at which the potential is wanted, Å.
    pub places: Option<Vec<Vec3>>,
}

/// Finds the potential around a structure, and writes it to a volume file if one is named, in the
/// format of its ending.
///
/// # Errors
/// As [`potential_of_file`]; also for an unknown ending or a missing folder, which are refused
/// before the work.
pub fn potential(
    path: &Path,
    settings: &PotentialSettings,
    output: Option<&Path>,
) -> Result<PotentialReport> {
    let format = output.map(VolumeFormat::of_file).transpose()?;
    let (field, report) = potential_of_file(
        path,
        &settings.dielectric,
        &settings.solve,
        settings.model,
        settings.estimate_error,
        settings.places.as_deref(),
    )?;
    if let (Some(path), Some(format)) = (output, format) {
        let bytes = format.encode(&volume(field))?;
        write_atomically(path, |file| file.write_all(&bytes))?;
    }
    Ok(report)
}

/// The formats of volume files.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum VolumeFormat {
    Mrc,
    Dx,
    Npz,
}

impl VolumeFormat {
    const ENDINGS: [(&str, Self); 5] = [
        (".mrc", Self::Mrc),
        (".map", Self::Mrc),
        (".ccp4", Self::Mrc),
        (".dx", Self::Dx),
        (".npz", Self::Npz),
    ];

    /// The format of a file that is to be written, in a folder that is there.
    fn of_file(path: &Path) -> Result<Self> {
        let name = path.display().to_string();
        let found = Self::ENDINGS
            .iter()
            .find(|(ending, _)| name.ends_with(ending));
        let Some((_, format)) = found else {
            let endings = Self::ENDINGS.map(|(ending, _)| ending).join(", ");
            bail!("{name} has none of the endings {endings}; name one of them");
        };
        let folder = path
            .parent()
            .filter(|folder| !folder.as_os_str().is_empty());
        if let Some(folder) = folder.filter(|folder| !folder.is_dir()) {
            bail!(
                "there is no folder {} to write into; make it first",
                folder.display()
            );
        }
        Ok(*format)
    }

    fn encode(self, volume: &Volume) -> Result<Vec<u8>> {
        Ok(match self {
            Self::Mrc => write_mrc("potential, kT/e", volume),
            Self::Dx => write_dx("potential, kT/e", volume).into_bytes(),
            Self::Npz => write_volume_npz("potential_kt_per_e", volume)?,
        })
    }
}

/// The atoms of a structure, PQR or body file.
///
/// # Errors
/// Names the file, the line, and the remedy.
pub fn spheres_of_file(path: &Path) -> Result<(String, Vec<ChargedSphere>)> {
    let file = InputFile::read(path)?;
    let (sites, origin) = read_sites(&file)?;
    let spheres = sites.iter().map(|site| ChargedSphere {
        centre: site.position + origin,
        radius_angstrom: site.radius_angstrom,
        charge_e: site.charge_e,
    });
    Ok((file.name, spheres.collect()))
}

/// Points to look at: x y z on each line, Å; further numbers are passed over, `#` begins a comment.
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

/// Three finite numbers, perhaps with others behind: other programs write x y z and the potential.
fn place(words: &[&str]) -> Option<Vec3> {
    let number = |word: &&str| word.parse::<f64>().ok().filter(|number| number.is_finite());
    let numbers = words.iter().map(number).collect::<Option<Vec<f64>>>()?;
    let [x, y, z, ..] = numbers[..] else {
        return None;
    };
    Some(Vec3::new(x, y, z))
}

/// The potential of the atoms of a file on a grid, and what is known of it.
///
/// # Errors
/// For a file that cannot be read, and as [`protomer_field::solve`].
pub fn potential_of_file(
    path: &Path,
    dielectric: &DielectricModel,
    settings: &SolveSettings,
    model: PotentialModel,
    estimate_error: bool,
    places: Option<&[Vec3]>,
) -> Result<(ScalarField, PotentialReport)> {
    let start = Instant::now();
    let (file, spheres) = spheres_of_file(path)?;
    let Found {
        field,
        energy_kt,
        error_kt,
        potentials_kt_per_e,
        iterations,
    } = match model {
        PotentialModel::PoissonBoltzmann => {
            solved(&spheres, dielectric, settings, estimate_error, places)
        }
        PotentialModel::DebyeHueckel => superposed(&spheres, dielectric, settings, places),
    }
    .with_context(|| file.clone())?;
    let per_kt = kilojoule_per_mol_per_kt(dielectric.electrolyte.temperature_kelvin());
    let debye = dielectric.electrolyte.debye_length_angstrom();
    let report = PotentialReport {
        file,
        atoms: spheres
            .iter()
            .filter(|sphere| sphere.radius_angstrom > 0.0)
            .count(),
        net_charge_e: spheres.iter().map(|sphere| sphere.charge_e).sum(),
        model,
        solvation_energy_kj_mol: energy_kt.map(|energy| energy * per_kt),
        error_estimate_kj_mol: error_kt.map(|error| error * per_kt),
        potentials_kt_per_e,
        grid: field.grid,
        debye_length_angstrom: debye.is_finite().then_some(debye),
        iterations,
        seconds: start.elapsed().as_secs_f64(),
        peak_bytes: peak_bytes(),
    };
    Ok((field, report))
}

/// What either model finds.
struct Found {
    field: ScalarField,
    energy_kt: Option<f64>,
    error_kt: Option<f64>,
    potentials_kt_per_e: Option<Vec<Option<f64>>>,
    iterations: Option<usize>,
}

fn solved(
    spheres: &[ChargedSphere],
    dielectric: &DielectricModel,
    settings: &SolveSettings,
    estimate_error: bool,
    places: Option<&[Vec3]>,
) -> Result<Found> {
    let solved = solve(spheres, dielectric, settings)?;
    let error_kt = estimate_error
        .then(|| error_estimate_kt(spheres, dielectric, settings, solved.solvation_energy_kt))
        .transpose()?;
    Ok(Found {
        field: solved.field(),
        energy_kt: Some(solved.solvation_energy_kt),
        error_kt,
        potentials_kt_per_e: places
            .map(|places| places.iter().map(|place| solved.at(place)).collect()),
        iterations: Some(solved.iterations),
    })
}

fn superposed(
    spheres: &[ChargedSphere],
    dielectric: &DielectricModel,
    settings: &SolveSettings,
    places: Option<&[Vec3]>,
) -> Result<Found> {
    let superposition = Superposition::new(spheres, dielectric);
    let grid = grid_around(spheres, settings)?;
    let at = |place: &Vec3| grid.locate(place).map(|_| superposition.at(place));
    Ok(Found {
        field: superposition.on(grid),
        energy_kt: None,
        error_kt: None,
        potentials_kt_per_e: places.map(|places| places.iter().map(at).collect()),
        iterations: None,
    })
}

/// The potential as a volume for a file.
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

/// The most memory this process has held.
fn peak_bytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status
        .lines()
        .find_map(|line| line.strip_prefix("VmHWM:"))?;
    Some(line.split_whitespace().next()?.parse::<u64>().ok()? * 1024)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
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
