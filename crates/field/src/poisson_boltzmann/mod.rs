//! The linearised Poisson-Boltzmann equation around charged spheres,
//!
//! -∇·ε∇φ + ε_out κ² λ φ = 4π l ρ,
//!
//! with φ in kT/e, ρ in e/Å³, l = e²/(4π ε₀ kT) the Bjerrum length of the vacuum, and λ = 1 where
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
//! | `ion_gap` | how far a point is from what ions cannot enter |
//! | `coulomb_source` | the Coulomb potential inside as sources at the surface |
//! | `faces` | the potential on the faces of a grid |
//! | `operator` | -∇·ε∇φ + k φ on a grid |
//! | `multigrid`, `transfer` | an approximate inverse of the operator |
//! | `conjugate_gradient`, `dot` | the solution |
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
mod operator;
mod potential;
mod settings;
mod transfer;

pub use error_estimate::error_estimate_kt;
pub use potential::Potential;
pub use settings::{BoundaryCondition, SolveSettings, grid_around};

use crate::charge_tree::ChargeTree;
use crate::charged_sphere::{ChargedSphere, bounds};
use crate::debye_huckel::Superposition;
use crate::dielectric::DielectricModel;
use crate::grid::{Grid, ScalarField};
use crate::point_charges::Source;
use crate::surface::surface_of;
use crate::{FieldError, Result};
use dielectric_map::DielectricMap;
use ion_gap::IonGap;
use operator::Operator;
use potential::Sides;
use protomer_body::surface::ImplicitSolid;
use protomer_kernel::Vec3;
use settings::{LARGEST_SPACING_ANGSTROM, check_range, coarse_grid_around};

/// Coulomb potentials nearer to a charge are those at this distance, Å.
const NEAREST_ANGSTROM: f64 = 1e-3;

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

/// As [`solve`], with the surface of these spheres.
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
    let grid = grid_around(spheres, settings)?;
    let problem = Problem {
        spheres,
        dielectric,
        solid,
        relative_tolerance: settings.relative_tolerance,
    };
    match settings.boundary {
        BoundaryCondition::ScreenedAtoms => {
            let without_shell = DielectricModel {
                ion_radius_angstrom: 0.0,
                ..*dielectric
            };
            let atoms = Superposition::new(spheres, &without_shell);
            problem.solve_on(grid, faces::superposed(&grid, &atoms))
        }
        BoundaryCondition::CoarseGrid => {
            let (low, high) = bounds(spheres);
            let mean_half_extent = 0.25 * (high - low).sum() / 1.5;
            let solute = Superposition::of_solute(spheres, dielectric, mean_half_extent);
            let coarse_grid = coarse_grid_around(spheres, settings)?;
            let coarse = problem.solve_on(coarse_grid, faces::superposed(&coarse_grid, &solute))?;
            let on_faces = |place: &Vec3| coarse.reduced_at(place).unwrap_or(0.0);
            problem.solve_on(grid, faces::point_by_point(&grid, on_faces))
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
        if sphere.charge_e == 0.0 {
            continue;
        }
        let distance_angstrom = solid.signed_distance(&sphere.centre);
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
    fn solve_on(&self, grid: Grid, mut values: Vec<f64>) -> Result<Potential> {
        let inner = self.dielectric.inner_permittivity;
        let outer = self.dielectric.electrolyte.relative_permittivity();
        let (operator, sides) = self.operator_on(&grid);
        let coulomb = self.coulomb_inside();
        let inside = &sides.inside;
        let right = coulomb_source::at_surface(&grid, &operator, inside, &coulomb, [inner, outer]);
        let iterations =
            conjugate_gradient::solve(&operator, &right, &mut values, self.relative_tolerance)?;
        let reduced = ScalarField { grid, values };
        Ok(Potential::new(
            reduced,
            sides,
            coulomb,
            self.spheres,
            iterations,
        ))
    }

    /// The equations on a grid, and on which side of the surface its points are.
    fn operator_on(&self, grid: &Grid) -> (Operator, Sides) {
        let inner = self.dielectric.inner_permittivity;
        let outer = self.dielectric.electrolyte.relative_permittivity();
        let ion_radius = self.dielectric.ion_radius_angstrom;
        let h = grid.spacing_angstrom;
        // On a coarse grid a box can be larger than the signed distances reach: then the spheres
        // themselves keep ions out.
        let by_spheres = ion_radius > 0.0 || h > LARGEST_SPACING_ANGSTROM;
        let reach = self.dielectric.probe_angstrom;
        let gap = by_spheres.then(|| IonGap::new(grid, self.spheres, ion_radius, reach));
        let map = DielectricMap::new(grid, self.solid, [inner, outer], gap.as_ref());
        drop(gap);
        let kappa = self
            .dielectric
            .electrolyte
            .inverse_debye_length_per_angstrom();
        let full_mass = outer * (kappa * h).powi(2);
        let mut mass = map.accessible;
        for part in &mut mass {
            *part = (full_mass * f64::from(*part)) as f32;
        }
        let sides = Sides {
            inside: map.inside,
            on_surface: map.on_surface,
        };
        (Operator::new(grid.shape, map.edges, mass), sides)
    }

    /// The sources l q/ε_in of the Coulomb potential inside.
    fn coulomb_inside(&self) -> ChargeTree {
        let bjerrum = self.dielectric.electrolyte.vacuum_bjerrum_length_angstrom();
        let per_charge = bjerrum / self.dielectric.inner_permittivity;
        let mut sources = Vec::new();
        for sphere in self.spheres {
            if sphere.charge_e != 0.0 {
                sources.push(Source {
                    place: sphere.centre,
                    strength: per_charge * sphere.charge_e,
                    least_distance_angstrom: NEAREST_ANGSTROM,
                });
            }
        }
        ChargeTree::new(&sources)
    }
}
