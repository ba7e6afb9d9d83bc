//! The electrostatic potential around a structure, by the linearised Poisson-Boltzmann equation.

use crate::input::InputFile;
use crate::surface_of_file::read_sites;
use anyhow::{Context, Result, bail};
use protomer_field::{ChargedSphere, Grid, Medium, Potential, SolveSettings, solve};
use protomer_io::volume::Volume;
use protomer_kernel::Vec3;
use serde::Serialize;
use std::path::Path;
use std::time::Instant;

/// The second grid, for the error, is this many times coarser,
const SECOND_SPACING: f64 = 1.4;
/// or finer where that would be too coarse, Å.
const COARSEST_ANGSTROM: f64 = 1.1;

/// What is known of a potential.
#[derive(Debug, Clone, Serialize)]
pub struct PotentialReport {
    /// The input file.
    pub file: String,
    /// Atoms with a radius.
    pub atoms: usize,
    /// Sum of the charges, e.
    pub net_charge_e: f64,
    /// Energy of moving the charges from a medium like their inside into the solvent, kJ/mol.
    pub solvation_energy_kj_mol: f64,
    /// How far that may be off, from a second grid, kJ/mol; absent if not asked for.
    pub error_estimate_kj_mol: Option<f64>,
    /// The potential at the points asked for, kT/e; null outside the grid.
    #[serde(rename = "potentials_kT_per_e", skip_serializing_if = "Option::is_none")]
    pub potentials_kt_per_e: Option<Vec<Option<f64>>>,
    /// The grid.
    pub grid: Grid,
    /// Debye length, Å; null without salt.
    pub debye_length_angstrom: Option<f64>,
    /// Iterations of the solver.
    pub iterations: usize,
    /// Wall time, s.
    pub seconds: f64,
    /// The most memory the process has held, bytes, where the system tells.
    pub peak_bytes: Option<u64>,
}

/// The atoms of a structure or PQR file.
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

/// Points to look at: x y z on each line, Å; `#` begins a comment.
///
/// # Errors
/// Names the line.
pub fn read_places(path: &Path) -> Result<Vec<Vec3>> {
    let file = InputFile::read(path)?;
    let text = std::str::from_utf8(&file.bytes).with_context(|| format!("{} is not text", file.name))?;
    let mut places = Vec::new();
    for (number, line) in text.trim_start_matches('\u{feff}').lines().enumerate() {
        let line = line.split('#').next().unwrap_or_default();
        let words: Vec<&str> = line.split_whitespace().collect();
        if words.is_empty() {
            continue;
        }
        let Some(place) = place(&words) else {
            let line = line.trim();
            bail!("{}, line {}: '{line}' is not a point; give x y z in Å, and nothing else", file.name, number + 1)
        };
        places.push(place);
    }
    Ok(places)
}

/// Three finite numbers.
fn place(words: &[&str]) -> Option<Vec3> {
    let [x, y, z] = words else { return None };
    let number = |word: &str| word.parse::<f64>().ok().filter(|number| number.is_finite());
    Some(Vec3::new(number(x)?, number(y)?, number(z)?))
}

/// Solves for the potential of the atoms of a file, at a second spacing too if its error is wanted.
///
/// # Errors
/// For a file that cannot be read, and as [`protomer_field::solve`].
pub fn potential_of_file(
    path: &Path,
    medium: &Medium,
    settings: &SolveSettings,
    estimate_error: bool,
    places: Option<&[Vec3]>,
) -> Result<(Potential, PotentialReport)> {
    let start = Instant::now();
    let (file, spheres) = spheres_of_file(path)?;
    let solved = solve(&spheres, medium, settings).with_context(|| file.clone())?;
    let per_kt = medium.conditions.kilojoule_per_mol_per_kt();
    let error_estimate_kj_mol = if estimate_error {
        let coarser = SECOND_SPACING * settings.spacing_angstrom;
        let finer = settings.spacing_angstrom / SECOND_SPACING;
        let spacing_angstrom = if coarser <= COARSEST_ANGSTROM { coarser } else { finer };
        let second = solve(&spheres, medium, &SolveSettings { spacing_angstrom, ..*settings })?;
        Some((second.solvation_energy_kt - solved.solvation_energy_kt).abs() * per_kt)
    } else {
        None
    };
    let debye = medium.conditions.debye_length_angstrom();
    let report = PotentialReport {
        file,
        atoms: spheres.iter().filter(|sphere| sphere.radius_angstrom > 0.0).count(),
        net_charge_e: spheres.iter().map(|sphere| sphere.charge_e).sum(),
        solvation_energy_kj_mol: solved.solvation_energy_kt * per_kt,
        error_estimate_kj_mol,
        potentials_kt_per_e: places.map(|places| places.iter().map(|place| solved.at(place)).collect()),
        grid: *solved.grid(),
        debye_length_angstrom: debye.is_finite().then_some(debye),
        iterations: solved.iterations,
        seconds: start.elapsed().as_secs_f64(),
        peak_bytes: peak_bytes(),
    };
    Ok((solved, report))
}

/// The potential as a volume for a file.
pub fn volume(potential: &Potential) -> Volume {
    let field = potential.field();
    Volume {
        shape: field.grid.shape,
        origin_angstrom: field.grid.origin_angstrom,
        spacing_angstrom: field.grid.spacing_angstrom,
        values: field.values,
    }
}

/// The most memory this process has held.
fn peak_bytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
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
        assert_eq!(read("\u{feff}1 2 3\n\n# none\n-1e1 0 0.5 # one\n").unwrap().len(), 2);
        for line in ["1 2 3 hello", "nan 0 0", "0 inf 0", "1 2", "1 2 3 4", "hello"] {
            let message = read(&format!("0 0 0\n{line}\n")).unwrap_err().to_string();
            assert!(message.contains(&format!("line 2: '{line}'")), "{message}");
        }
    }
}
