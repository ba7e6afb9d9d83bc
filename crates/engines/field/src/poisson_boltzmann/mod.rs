//! The Poisson-Boltzmann equation around charged spheres, linearised,
//!
//! -∇·ε∇φ + ε_out κ² λ φ = 4π l ρ,
//!
//! or with ions that follow Boltzmann factors (`newton`), with φ in kT/e, ρ in e/Å³,
//! l = e²/(4π ε₀ kT) the Bjerrum length of the vacuum, and λ = 1 where
//! ions go. The permittivity changes at the surface of the spheres
//! ([`SurfaceDefinition`](crate::SurfaceDefinition)).
//!
//! Charges are points. Inside the surface the Coulomb potential φ_C = l/ε_in Σ q/r is taken out, so
//! the unknown is the reaction field u = φ - φ_C inside and φ outside, both smooth; on edges that
//! meet the surface φ_C appears as a source (`coulomb_source`). One solve gives the solvation energy
//! ½ Σ q u, without the self-energy of the grid and without a reference solve.
//!
//! | module | one idea |
//! |---|---|
//! | `settings` | how finely to solve, and on which grid |
//! | `dielectric_map` | permittivities and accessibility on a grid |
//! | `solute_on_grid` | what neither salt nor charges change, kept for several solves |
//! | `ion_gap` | how far a point is from what ions cannot enter |
//! | `coulomb_source` | the Coulomb potential inside as sources at the surface |
//! | `faces` | the potential on the faces of a grid |
//! | `operator` | -∇·ε∇φ + k φ on a grid |
//! | `multigrid`, `transfer` | an approximate inverse of the operator |
//! | `conjugate_gradient`, `dot` | the solution |
//! | `newton` | the solution where ions follow Boltzmann factors |
//! | `potential` | the solution anywhere in space |
//! | `error_estimate` | the error of a solvation energy, from a second grid |

mod conjugate_gradient;
mod coulomb_source;
mod dielectric_map;
mod dot;
mod error_estimate;
mod faces;
mod ion_gap;
mod multigrid;
mod newton;
mod operator;
mod potential;
mod settings;
mod solute_on_grid;
mod transfer;

pub use error_estimate::error_estimate_kt;
pub use potential::Potential;
pub(crate) use settings::grid_for;
pub use settings::{BoundaryCondition, SolveSettings, grid_around};
pub use solute_on_grid::{ChargedSolute, SoluteOnGrid};

use crate::charged_sphere::{ChargedSphere, bounds};
use crate::debye_huckel::Superposition;
use crate::dielectric::DielectricModel;
use crate::grid::Grid;
use crate::ion_response::IonResponse;
use crate::surface::surface_of;
use crate::{FieldError, Result};
use newton::Faces;
use protomer_body::surface::ImplicitSolid;
use protomer_kernel::Vec3;
use settings::{check_range, coarse_grid_around};
use solute_on_grid::{solve_once, superposed_on_faces};

/// Solves for the potential of these spheres.
///
/// ```
/// use protomer_field::{ChargedSphere, DielectricModel, SolveSettings, solve};
/// use protomer_kernel::{Electrolyte, Vec3};
/// // Born's ion: -l q²/(2 a) (1/ε_in - 1/ε_out).
/// let mut dielectric = DielectricModel::new(Electrolyte::new(298.15, 0.0, 78.54)?);
/// dielectric.inner_permittivity = 1.0;
/// let ion = ChargedSphere { centre: Vec3::zeros(), radius_angstrom: 3.0, charge_e: 1.0 };
/// let solved = solve(&[ion], &dielectric, &SolveSettings::default())?;
/// let bjerrum = dielectric.electrolyte.vacuum_bjerrum_length_angstrom();
/// let born = -bjerrum / 6.0 * (1.0 - 1.0 / 78.54);
/// assert!((solved.solvation_energy_kt / born - 1.0).abs() < 0.01);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`FieldError::BadSetting`] names the setting; [`FieldError::ChargeOutside`] the charge;
/// [`FieldError::TooLarge`] says how much memory a solve needs; [`FieldError::NotConverged`] if the
/// iteration fails.
pub fn solve(
    spheres: &[ChargedSphere],
    dielectric: &DielectricModel,
    settings: &SolveSettings,
) -> Result<Potential> {
    settings.check()?;
    check_dielectric(dielectric)?;
    check_spheres(spheres)?;
    let solid = surface_of(spheres, dielectric.surface, dielectric.probe_angstrom)?;
    solve_within(&*solid, spheres, dielectric, settings)
}

/// Variant of [`solve`] that is given the surface of these spheres.
pub(crate) fn solve_within(
    solid: &dyn ImplicitSolid,
    spheres: &[ChargedSphere],
    dielectric: &DielectricModel,
    settings: &SolveSettings,
) -> Result<Potential> {
    settings.check()?;
    check_dielectric(dielectric)?;
    check_spheres(spheres)?;
    check_charges(spheres, solid)?;
    let grid = grid_for(spheres, settings, dielectric.ion_response)?;
    let problem = Problem {
        spheres,
        dielectric,
        solid,
        relative_tolerance: settings.relative_tolerance,
    };
    match settings.boundary {
        // Ions that follow Boltzmann factors screen a solute to a smaller charge, which only a grid that
        // reaches far tells.
        BoundaryCondition::ScreenedAtoms if dielectric.ion_response == IonResponse::Linear => {
            let on_faces = superposed_on_faces(&grid, spheres, dielectric);
            problem.solve_on(grid, on_faces, Faces::Proportional)
        }
        BoundaryCondition::ScreenedAtoms | BoundaryCondition::CoarseGrid => {
            let (low, high) = bounds(spheres);
            // A sixth of the sum of the extents: the mean half-extent.
            let mean_half_extent = 0.25 * (high - low).sum() / 1.5;
            let solute = Superposition::of_solute(spheres, dielectric, mean_half_extent);
            let coarse_grid = coarse_grid_around(spheres, settings, dielectric.ion_response)?;
            let on_faces = faces::superposed(&coarse_grid, &solute);
            let coarse = problem.solve_on(coarse_grid, on_faces, Faces::Proportional)?;
            // From the coarse solution; its own faces are twice as far away.
            let on_faces = |place: &Vec3| coarse.reduced_at(place).unwrap_or(0.0);
            problem.solve_on(grid, faces::point_by_point(&grid, on_faces), Faces::Given)
        }
    }
}

fn check_dielectric(dielectric: &DielectricModel) -> Result<()> {
    let permittivities = 1.0..=1000.0;
    let inner = dielectric.inner_permittivity;
    check_range(
        "inner permittivity",
        inner,
        permittivities.clone(),
        "1 to 1000",
    )?;
    let outer = dielectric.electrolyte.relative_permittivity();
    check_range("outer permittivity", outer, permittivities, "1 to 1000")?;
    check_range(
        "probe",
        dielectric.probe_angstrom,
        0.1..=20.0,
        "0.1 to 20 Å",
    )?;
    let ion_radius = dielectric.ion_radius_angstrom;
    check_range("ion radius", ion_radius, 0.0..=20.0, "0 to 20 Å")
}

fn check_spheres(spheres: &[ChargedSphere]) -> Result<()> {
    if spheres.is_empty() {
        let reason = "there are no atoms; give at least one";
        return Err(FieldError::BadInput(reason.into()));
    }
    for (index, sphere) in spheres.iter().enumerate() {
        let [x, y, z] = sphere.centre.into();
        let numbers = [x, y, z, sphere.radius_angstrom, sphere.charge_e];
        let finite = numbers.iter().all(|number| number.is_finite());
        if !finite || sphere.radius_angstrom < 0.0 {
            return Err(FieldError::BadInput(format!(
                "atom {index} has an invalid place, radius or charge in {numbers:?}; give finite \
                 numbers and no negative radius"
            )));
        }
    }
    Ok(())
}

/// Refuses charges in the solvent.
fn check_charges(spheres: &[ChargedSphere], solid: &dyn ImplicitSolid) -> Result<()> {
    for (index, sphere) in spheres.iter().enumerate() {
        // Spheres without charge may be anywhere, also in the solvent.
        if sphere.charge_e == 0.0 {
            continue;
        }
        let distance_angstrom = solid.signed_distance(&sphere.centre);
        // The sign decides: on the surface counts as outside.
        if distance_angstrom >= 0.0 {
            return Err(FieldError::ChargeOutside {
                index,
                charge_e: sphere.charge_e,
                distance_angstrom,
            });
        }
    }
    Ok(())
}

/// Everything but the grid and the potential on its faces.
struct Problem<'a> {
    spheres: &'a [ChargedSphere],
    dielectric: &'a DielectricModel,
    solid: &'a dyn ImplicitSolid,
    relative_tolerance: f64,
}

impl Problem<'_> {
    /// The potential on a grid, given that on its faces, and zero at other points.
    fn solve_on(&self, grid: Grid, values: Vec<f64>, on_faces: Faces) -> Result<Potential> {
        let solute = SoluteOnGrid::within(self.solid, self.spheres, self.dielectric, grid);
        solve_once(
            solute,
            self.spheres,
            values,
            on_faces,
            self.relative_tolerance,
        )
    }
}
