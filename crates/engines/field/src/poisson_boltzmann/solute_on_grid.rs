//! A solute on a grid: what neither the salt nor the charges change.
//!
//! Permittivities, the points inside and the part of each box that ions reach follow from the spheres
//! alone ([`SoluteOnGrid`]). The sources at the surface follow from the charges as well
//! ([`ChargedSolute`]). Only the term of the ions, and the potential on the faces of the grid, depend on the salt.
//! So a solute is prepared once and solved at many salts, or with many sets of charges.

use super::coulomb_source;
use super::dielectric_map::DielectricMap;
use super::dot::dot;
use super::faces;
use super::ion_gap::IonGap;
use super::newton::{Faces, NonlinearEquation};
use super::operator::Operator;
use super::potential::{Potential, Sides};
use super::settings::{LARGEST_SPACING_ANGSTROM, SolveSettings};
use super::{check_charges, check_dielectric, check_spheres, conjugate_gradient};
use crate::charge_tree::ChargeTree;
use crate::charged_sphere::ChargedSphere;
use crate::debye_huckel::Superposition;
use crate::dielectric::DielectricModel;
use crate::grid::{Grid, ScalarField};
use crate::ion_response::IonResponse;
use crate::point_charges::Source;
use crate::{FieldError, Result};
use protomer_body::surface::ImplicitSolid;
use protomer_kernel::{Electrolyte, Vec3};
use std::f64::consts::PI;
use std::sync::Arc;

/// Coulomb potentials nearer to a charge are those at this distance, Å.
const NEAREST_ANGSTROM: f64 = 1e-3;

/// The surface of a solute on a grid, for solves at many salts and with many sets of charges.
///
/// ```
/// use protomer_field::poisson_boltzmann::{SoluteOnGrid, grid_around};
/// use protomer_field::surface::surface_of;
/// use protomer_field::{ChargedSphere, DielectricModel, SolveSettings, solve};
/// use protomer_kernel::{Electrolyte, Vec3};
/// let ions = [ChargedSphere { centre: Vec3::zeros(), radius_angstrom: 3.0, charge_e: 1.0 }];
/// let model = DielectricModel::new(Electrolyte::in_water(298.15, 0.1)?);
/// let settings = SolveSettings::default();
/// let solid = surface_of(&ions, model.surface, model.probe_angstrom)?;
/// let solute = SoluteOnGrid::new(&*solid, &ions, &model, grid_around(&ions, &settings)?)?;
/// let charged = solute.with_charges(&ions)?;
/// for salt_molar in [0.01, 0.1, 1.0] {
///     let saline = Electrolyte::in_water(298.15, salt_molar)?;
///     let energy_kt = charged.solve(&saline, &settings)?.solvation_energy_kt;
///     let alone = solve(&ions, &DielectricModel { electrolyte: saline, ..model }, &settings)?;
///     assert_eq!(energy_kt, alone.solvation_energy_kt);
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct SoluteOnGrid<'a> {
    solid: &'a dyn ImplicitSolid,
    dielectric: DielectricModel,
    grid: Grid,
    /// Permittivities of the edges.
    edges: Arc<[Vec<f32>; 3]>,
    /// The part of the box around a point that ions reach.
    accessible: Vec<f32>,
    sides: Arc<Sides>,
}

impl<'a> SoluteOnGrid<'a> {
    /// The solid that these spheres bound, on a grid that holds them. Their charges do not matter yet.
    ///
    /// # Errors
    /// [`FieldError::BadSetting`] for a dielectric model out of range, [`FieldError::BadInput`] without
    /// spheres and for an invalid one.
    pub fn new(
        solid: &'a dyn ImplicitSolid,
        spheres: &[ChargedSphere],
        dielectric: &DielectricModel,
        grid: Grid,
    ) -> Result<Self> {
        check_dielectric(dielectric)?;
        check_spheres(spheres)?;
        Ok(Self::within(solid, spheres, dielectric, grid))
    }

    /// Variant of [`new`](Self::new) for input that has been checked.
    pub(super) fn within(
        solid: &'a dyn ImplicitSolid,
        spheres: &[ChargedSphere],
        dielectric: &DielectricModel,
        grid: Grid,
    ) -> Self {
        let permittivities = permittivities(dielectric);
        let ion_radius = dielectric.ion_radius_angstrom;
        // On a coarse grid a box can be larger than the signed distances reach: then the spheres
        // themselves keep ions out.
        // The gap is a lower bound of the distance from
        // the solid, which also saves signed distances.
        let by_spheres = ion_radius > 0.0 || grid.spacing_angstrom > LARGEST_SPACING_ANGSTROM;
        let reach = dielectric.probe_angstrom;
        let gap = by_spheres.then(|| IonGap::new(&grid, spheres, ion_radius, reach));
        let map = DielectricMap::new(&grid, solid, permittivities, gap.as_ref());
        Self {
            solid,
            dielectric: *dielectric,
            grid,
            edges: Arc::new(map.edges),
            accessible: map.accessible,
            sides: Arc::new(Sides {
                inside: map.inside,
                on_surface: map.on_surface,
            }),
        }
    }

    /// The grid.
    pub(crate) fn grid(&self) -> &Grid {
        &self.grid
    }

    /// Dielectric model of the preparation.
    pub(crate) fn dielectric(&self) -> &DielectricModel {
        &self.dielectric
    }

    /// Whether a point of the grid is inside the surface.
    pub(crate) fn is_inside(&self, point: usize) -> bool {
        self.sides.inside[point]
    }

    /// The part of the box around a point of the grid that ions reach, 0 to 1.
    pub(crate) fn accessible_part(&self, point: usize) -> f64 {
        f64::from(self.accessible[point]).min(1.0)
    }

    /// The same solute with charges at the centres of these spheres. Their radii only serve the
    /// potential on the faces of the grid.
    ///
    /// # Errors
    /// [`FieldError::ChargeOutside`] for a charge outside the surface, [`FieldError::BadInput`] without
    /// spheres and for an invalid one.
    pub fn with_charges<'b>(&'b self, charges: &'b [ChargedSphere]) -> Result<ChargedSolute<'b>> {
        check_spheres(charges)?;
        check_charges(charges, self.solid)?;
        Ok(ChargedSolute::new(self, charges))
    }
}

/// The permittivities inside and outside the surface.
fn permittivities(dielectric: &DielectricModel) -> [f64; 2] {
    let outer = dielectric.electrolyte.relative_permittivity();
    [dielectric.inner_permittivity, outer]
}

/// A solute on a grid with its charges, for solves at many salts.
pub struct ChargedSolute<'a> {
    solute: &'a SoluteOnGrid<'a>,
    charges: &'a [ChargedSphere],
    coulomb: ChargeTree,
    /// The sources of the charges.
    right: Vec<f64>,
}

impl<'a> ChargedSolute<'a> {
    pub(super) fn new(solute: &'a SoluteOnGrid<'a>, charges: &'a [ChargedSphere]) -> Self {
        let SoluteOnGrid {
            dielectric,
            grid,
            edges,
            sides,
            ..
        } = solute;
        let coulomb = coulomb_inside(charges, dielectric);
        let inside = &sides.inside;
        let permittivities = permittivities(dielectric);
        let right = coulomb_source::at_surface(grid, edges, inside, &coulomb, permittivities);
        Self {
            solute,
            charges,
            coulomb,
            right,
        }
    }

    /// The potential in an electrolyte that differs from that of the solute in its salt only. On the
    /// faces of the grid it is the sum of screened atoms
    /// ([`BoundaryCondition::ScreenedAtoms`](super::BoundaryCondition::ScreenedAtoms)).
    ///
    /// # Errors
    /// [`FieldError::BadInput`] for an electrolyte of another temperature or permittivity,
    /// [`FieldError::BadSetting`] for a tolerance out of range, [`FieldError::NotConverged`] if the
    /// iteration fails.
    pub fn solve(&self, electrolyte: &Electrolyte, settings: &SolveSettings) -> Result<Potential> {
        settings.check()?;
        self.require_same_solvent(electrolyte)?;
        let dielectric = DielectricModel {
            electrolyte: *electrolyte,
            ..self.solute.dielectric
        };
        let values = superposed_on_faces(&self.solute.grid, self.charges, &dielectric);
        // Cloned, as `mass` overwrites it: the solute serves many salts.
        let accessible = self.solute.accessible.clone();
        let tolerance = settings.relative_tolerance;
        self.solve_from(
            values,
            Faces::Proportional,
            accessible,
            &dielectric,
            tolerance,
        )
    }

    /// Variant of [`solve`](Self::solve) with the potential on the faces from a solve of the same
    /// charges on a grid that holds this one.
    ///
    /// # Errors
    /// As [`solve`](Self::solve), and [`FieldError::BadInput`] for a grid that reaches out of the other.
    pub fn solve_within(
        &self,
        outer: &Potential,
        electrolyte: &Electrolyte,
        settings: &SolveSettings,
    ) -> Result<Potential> {
        settings.check()?;
        self.require_same_solvent(electrolyte)?;
        let grid = &self.solute.grid;
        let [i, j, k] = grid.shape.map(|points| points - 1);
        let corners = [grid.point(0, 0, 0), grid.point(i, j, k)];
        if corners
            .iter()
            .any(|corner| outer.grid().locate(corner).is_none())
        {
            let reason = "the inner grid reaches out of the outer one; give that a larger margin";
            return Err(FieldError::BadInput(reason.into()));
        }
        // Cannot be missing: both corners are inside, and a grid is a box.
        let on_faces = |place: &Vec3| outer.reduced_at(place).unwrap_or(0.0);
        let values = faces::point_by_point(grid, on_faces);
        let dielectric = DielectricModel {
            electrolyte: *electrolyte,
            ..self.solute.dielectric
        };
        let accessible = self.solute.accessible.clone();
        let tolerance = settings.relative_tolerance;
        self.solve_from(values, Faces::Given, accessible, &dielectric, tolerance)
    }

    fn require_same_solvent(&self, electrolyte: &Electrolyte) -> Result<()> {
        let prepared = &self.solute.dielectric.electrolyte;
        let is_same = |a: f64, b: f64| (a - b).abs() <= 1e-12 * b;
        let [permittivity, length] = [electrolyte, prepared].map(|solvent| {
            [
                solvent.relative_permittivity(),
                solvent.bjerrum_length_angstrom(),
            ]
        });
        if is_same(permittivity[0], length[0]) && is_same(permittivity[1], length[1]) {
            return Ok(());
        }
        Err(FieldError::BadInput(format!(
            "the solute was prepared for a solvent of relative permittivity {} and Bjerrum length {} Å, and \
             this one has {} and {} Å; prepare it again",
            length[0], length[1], permittivity[0], permittivity[1]
        )))
    }

    /// The potential, given that on the faces and zero at other points, and what ions reach.
    fn solve_from(
        &self,
        mut values: Vec<f64>,
        on_faces: Faces,
        accessible: Vec<f32>,
        dielectric: &DielectricModel,
        relative_tolerance: f64,
    ) -> Result<Potential> {
        let SoluteOnGrid {
            grid, edges, sides, ..
        } = self.solute;
        let mass = mass(accessible, dielectric, grid.spacing_angstrom);
        let operator = Operator::new(grid.shape, Arc::clone(edges), mass);
        let mut first_residual = 0.0;
        if dielectric.ion_response != IonResponse::Linear {
            first_residual = first_residual_norm(&operator, &self.right, &values);
        }
        let mut iterations =
            conjugate_gradient::solve(&operator, &self.right, &mut values, relative_tolerance)?;
        let mut excess_kt = 0.0;
        if let IonResponse::Boltzmann(salt) = dielectric.ion_response {
            let equation = NonlinearEquation {
                linear: &operator,
                right: &self.right,
                salt,
                faces: on_faces,
            };
            iterations += equation.solve(&mut values, first_residual, relative_tolerance)?;
            excess_kt = equation.excess_energy_kt(&values, energy_per_mass(dielectric, grid));
        }
        let reduced = ScalarField {
            grid: *grid,
            values,
        };
        let (sides, coulomb) = (Arc::clone(sides), self.coulomb.clone());
        Ok(Potential::new(
            reduced,
            sides,
            coulomb,
            self.charges,
            excess_kt,
            iterations,
        ))
    }
}

/// One solve, given the potential on the faces and zero at other points. It keeps nothing for another.
pub(super) fn solve_once(
    mut solute: SoluteOnGrid<'_>,
    charges: &[ChargedSphere],
    values: Vec<f64>,
    on_faces: Faces,
    relative_tolerance: f64,
) -> Result<Potential> {
    // Taken, not cloned: a single solve has no use for it afterwards.
    let accessible = std::mem::take(&mut solute.accessible);
    let dielectric = solute.dielectric;
    let charged = ChargedSolute::new(&solute, charges);
    charged.solve_from(
        values,
        on_faces,
        accessible,
        &dielectric,
        relative_tolerance,
    )
}

/// The sum of screened atoms on the faces of a grid, each with ions up to its radius; zero elsewhere.
pub(super) fn superposed_on_faces(
    grid: &Grid,
    charges: &[ChargedSphere],
    dielectric: &DielectricModel,
) -> Vec<f64> {
    let without_shell = DielectricModel {
        ion_radius_angstrom: 0.0,
        ..*dielectric
    };
    faces::superposed(grid, &Superposition::new(charges, &without_shell))
}

/// ε_out κ² h² of the part of each box that ions reach.
fn mass(mut accessible: Vec<f32>, dielectric: &DielectricModel, h: f64) -> Vec<f32> {
    let electrolyte = &dielectric.electrolyte;
    let kappa = electrolyte.inverse_debye_length_per_angstrom();
    // ε κ² h²: balances are divided by one spacing.
    let full_mass = electrolyte.relative_permittivity() * (kappa * h).powi(2);
    for part in &mut accessible {
        *part = (full_mass * f64::from(*part)) as f32;
    }
    accessible
}

/// Norm of b - A x for an x that is zero but on the faces.
fn first_residual_norm(operator: &Operator, right: &[f64], values: &[f64]) -> f64 {
    let mut residual = vec![0.0; values.len()];
    operator.residual_of_faces(values, right, &mut residual);
    dot(&residual, &residual).sqrt()
}

/// S h³ λ over ε_out κ² h² λ, with S = Σ c z² = ε_out κ²/(4π l) over the ions.
fn energy_per_mass(dielectric: &DielectricModel, grid: &Grid) -> f64 {
    let bjerrum = dielectric.electrolyte.vacuum_bjerrum_length_angstrom();
    grid.spacing_angstrom / (4.0 * PI * bjerrum)
}

/// The sources l q/ε_in of the Coulomb potential inside.
fn coulomb_inside(charges: &[ChargedSphere], dielectric: &DielectricModel) -> ChargeTree {
    let bjerrum = dielectric.electrolyte.vacuum_bjerrum_length_angstrom();
    let per_charge = bjerrum / dielectric.inner_permittivity;
    let mut sources = Vec::new();
    for sphere in charges {
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
