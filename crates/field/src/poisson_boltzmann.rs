//! The linearised Poisson-Boltzmann equation around charged spheres,
//!
//! -∇·ε∇φ + ε_out κ² λ φ = 4π l ρ,
//!
//! with φ in kT/e, ρ in e/Å³, l = e²/(4π ε₀ kT) the Bjerrum length of the vacuum, and λ = 1 where
//! ions go. The dielectric boundary is the solvent-excluded surface of the spheres, or another
//! ([`SurfaceDefinition`]).
//!
//! Charges are points. Inside the surface the Coulomb potential φ_C = l/ε_in Σ q/r is taken out, so
//! what is solved for is the reaction field u = φ - φ_C inside and φ outside, both smooth; on edges
//! that meet the surface φ_C appears as a source (`coulomb_source`). One solve gives the solvation
//! energy ½ Σ q u, without the grid's self-energy and without a reference solve.
//!
//! Boundary values are the atoms' Debye-Hückel potentials, or come from a coarse grid twice as
//! large ([`Boundary`]).

use crate::conjugate_gradient;
use crate::coulomb_source;
use crate::debye_huckel::Superposition;
use crate::dielectric::{DielectricMap, LARGEST_SPACING_ANGSTROM};
use crate::grid::{Grid, ScalarField, interpolate, interpolate_cubically};
use crate::operator::Operator;
use crate::point_charges::{PointCharges, Source};
use crate::surface::{SurfaceDefinition, bounds, surface_of};
use crate::{FieldError, Result};
use protomer_body::surface::ImplicitSolid;
use protomer_kernel::{Electrolyte, Vec3};
use rayon::prelude::*;
use std::ops::RangeInclusive;

/// An atom: a sphere with a charge at its centre.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ChargedSphere {
    /// Centre, Å.
    pub centre: Vec3,
    /// Radius, Å.
    pub radius_angstrom: f64,
    /// Charge, e.
    pub charge_e: f64,
}

/// The dielectric model of a solver: what is inside and outside the surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DielectricModel {
    /// The solvent and its salt.
    pub electrolyte: Electrolyte,
    /// Relative permittivity inside the surface.
    pub inner_permittivity: f64,
    /// Which surface that is.
    pub surface: SurfaceDefinition,
    /// Radius of the solvent's molecules, Å.
    pub probe_angstrom: f64,
    /// Ions keep their centres this far from the spheres, Å; zero: up to the surface.
    pub ion_radius_angstrom: f64,
}

impl DielectricModel {
    /// Proteins in this electrolyte: permittivity 2 inside the solvent-excluded surface of a probe
    /// of 1.4 Å, ions of 2 Å.
    pub fn new(electrolyte: Electrolyte) -> Self {
        Self {
            electrolyte,
            inner_permittivity: 2.0,
            surface: SurfaceDefinition::SolventExcluded,
            probe_angstrom: 1.4,
            ion_radius_angstrom: 2.0,
        }
    }
}

/// What the potential on the grid's faces is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Boundary {
    /// The sum of the atoms' Debye-Hückel potentials, each alone in the solvent with ions up to its
    /// radius: the usual choice. It ignores what the solute displaces: at 100 mM and a margin of 10
    /// Å that is 1.5 % of the potential outside crambin.
    #[default]
    ScreenedAtoms,
    /// That of a coarse grid twice as large, on whose faces all charges are seen from one sphere
    /// around the solute: hardly depends on the margin, and takes a second, smaller solve.
    CoarseGrid,
}

/// How finely to solve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SolveSettings {
    /// Grid spacing, Å.
    pub spacing_angstrom: f64,
    /// From the spheres to the grid's faces at least, Å.
    pub margin_angstrom: f64,
    /// Potential on the faces.
    pub boundary: Boundary,
    /// Residual of the linear equations over its start.
    pub relative_tolerance: f64,
    /// Memory that a solve may take, bytes.
    pub memory_limit_bytes: usize,
}

impl Default for SolveSettings {
    fn default() -> Self {
        Self {
            spacing_angstrom: 0.5,
            margin_angstrom: 10.0,
            boundary: Boundary::default(),
            relative_tolerance: 1e-6,
            memory_limit_bytes: 16 << 30,
        }
    }
}

/// Bytes per grid point that a solve takes.
const BYTES_PER_POINT: usize = 140;
/// The coarse grid is this many times larger along each axis,
const COARSE_EXTENT: f64 = 2.0;
/// and this many times coarser, up to a limit in Å.
const COARSE_SPACING: f64 = 4.0;
const COARSEST_SPACING_ANGSTROM: f64 = 2.0;
/// Coulomb potentials are those at this distance of a charge, if nearer, Å.
const NEAREST_ANGSTROM: f64 = 1e-3;
/// Grids have a multiple of this many cells along each axis, so that they can be halved four times.
const CELLS_MULTIPLE: usize = 16;

/// A solved potential.
#[derive(Debug, Clone)]
pub struct Potential {
    /// u inside, φ outside, kT/e.
    reduced: ScalarField,
    inside: Vec<bool>,
    /// λ_B q / ε_in at each charge.
    coulomb: PointCharges,
    /// Half the sum of charges times reaction field, kT.
    pub solvation_energy_kt: f64,
    /// Iterations of the solver.
    pub iterations: usize,
}

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
/// [`FieldError::TooLarge`] says what would be needed; [`FieldError::NotConverged`] if the
/// iteration fails.
pub fn solve(
    spheres: &[ChargedSphere],
    dielectric: &DielectricModel,
    settings: &SolveSettings,
) -> Result<Potential> {
    check(spheres, dielectric, settings)?;
    let solid = surface_of(spheres, dielectric)?;
    check_charges(spheres, &*solid)?;
    let fine = grid_around(spheres, settings)?;
    if settings.boundary == Boundary::ScreenedAtoms {
        let atoms = Superposition::new(
            spheres,
            &DielectricModel {
                ion_radius_angstrom: 0.0,
                ..*dielectric
            },
        );
        return solve_on(fine, spheres, dielectric, &*solid, settings, |place| {
            atoms.at(place)
        });
    }
    let (low, high) = bounds(spheres.iter());
    let margin = Vec3::repeat(settings.margin_angstrom);
    let extent = high - low + 2.0 * margin;
    let larger = 0.5 * (COARSE_EXTENT - 1.0) * extent;
    let spacing = (COARSE_SPACING * settings.spacing_angstrom)
        .min(COARSEST_SPACING_ANGSTROM.max(settings.spacing_angstrom));
    let coarse = Grid::around(
        &(low - margin - larger),
        &(high + margin + larger),
        spacing,
        CELLS_MULTIPLE,
    )?;
    check_memory(&coarse, settings)?;
    let size = 0.25 * (high - low).sum() / 1.5;
    let far = Superposition::of_solute(spheres, dielectric, size);
    let wide = solve_on(coarse, spheres, dielectric, &*solid, settings, |place| {
        far.at(place)
    })?;
    solve_on(fine, spheres, dielectric, &*solid, settings, |place| {
        wide.reduced.at(place).unwrap_or(0.0)
    })
}

fn check(
    spheres: &[ChargedSphere],
    dielectric: &DielectricModel,
    settings: &SolveSettings,
) -> Result<()> {
    if spheres.is_empty() {
        return Err(FieldError::BadInput(
            "there are no atoms; give at least one".into(),
        ));
    }
    check_settings(settings)?;
    check_ranges([
        (
            "inner permittivity",
            dielectric.inner_permittivity,
            1.0..=1000.0,
            "1 to 1000",
        ),
        (
            "outer permittivity",
            dielectric.electrolyte.relative_permittivity(),
            1.0..=1000.0,
            "1 to 1000",
        ),
        (
            "probe",
            dielectric.probe_angstrom,
            0.1..=20.0,
            "0.1 to 20 Å",
        ),
        (
            "ion radius",
            dielectric.ion_radius_angstrom,
            0.0..=20.0,
            "0 to 20 Å",
        ),
    ])?;
    for (index, sphere) in spheres.iter().enumerate() {
        let numbers = [
            sphere.centre.x,
            sphere.centre.y,
            sphere.centre.z,
            sphere.radius_angstrom,
            sphere.charge_e,
        ];
        if numbers.iter().any(|x| !x.is_finite()) || sphere.radius_angstrom < 0.0 {
            return Err(FieldError::BadInput(format!(
                "atom {index} has a number that makes no sense: {numbers:?}"
            )));
        }
    }
    Ok(())
}

fn check_settings(settings: &SolveSettings) -> Result<()> {
    check_ranges([
        (
            "spacing",
            settings.spacing_angstrom,
            0.05..=LARGEST_SPACING_ANGSTROM,
            "0.05 to 1.1 Å",
        ),
        (
            "margin",
            settings.margin_angstrom,
            1.0..=1000.0,
            "1 to 1000 Å",
        ),
        (
            "tolerance",
            settings.relative_tolerance,
            1e-12..=1e-2,
            "1e-12 to 1e-2",
        ),
    ])
}

fn check_ranges<const N: usize>(
    ranges: [(&'static str, f64, RangeInclusive<f64>, &'static str); N],
) -> Result<()> {
    for (setting, value, range, requirement) in ranges {
        if !range.contains(&value) {
            return Err(FieldError::BadSetting {
                setting,
                value,
                requirement,
            });
        }
    }
    Ok(())
}

/// The grid on which spheres are solved for.
///
/// # Errors
/// [`FieldError::BadInput`] and [`FieldError::TooLarge`] for one that is too large.
pub fn grid_around(spheres: &[ChargedSphere], settings: &SolveSettings) -> Result<Grid> {
    check_settings(settings)?;
    let (low, high) = bounds(spheres.iter());
    let margin = Vec3::repeat(settings.margin_angstrom);
    let grid = Grid::around(
        &(low - margin),
        &(high + margin),
        settings.spacing_angstrom,
        CELLS_MULTIPLE,
    )?;
    check_memory(&grid, settings)?;
    Ok(grid)
}

fn check_memory(grid: &Grid, settings: &SolveSettings) -> Result<()> {
    let (points, allowed_bytes) = (grid.len(), settings.memory_limit_bytes);
    let needed_bytes = points.saturating_mul(BYTES_PER_POINT);
    if needed_bytes > allowed_bytes {
        return Err(FieldError::TooLarge {
            points,
            needed_bytes,
            allowed_bytes,
        });
    }
    Ok(())
}

/// Refuses charges in the solvent.
fn check_charges(spheres: &[ChargedSphere], solid: &dyn ImplicitSolid) -> Result<()> {
    for (index, sphere) in spheres
        .iter()
        .enumerate()
        .filter(|(_, sphere)| sphere.charge_e != 0.0)
    {
        let distance = solid.signed_distance(&sphere.centre);
        if distance >= 0.0 {
            return Err(FieldError::ChargeOutside {
                index,
                charge_e: sphere.charge_e,
                distance_angstrom: distance,
            });
        }
    }
    Ok(())
}

fn solve_on(
    grid: Grid,
    spheres: &[ChargedSphere],
    dielectric: &DielectricModel,
    solid: &dyn ImplicitSolid,
    settings: &SolveSettings,
    boundary: impl Fn(&Vec3) -> f64 + Sync,
) -> Result<Potential> {
    let (inner, outer) = (
        dielectric.inner_permittivity,
        dielectric.electrolyte.relative_permittivity(),
    );
    // On a coarse grid a box can be larger than what the surface's distances tell: then the spheres
    // themselves keep ions out.
    let by_spheres =
        dielectric.ion_radius_angstrom > 0.0 || grid.spacing_angstrom > LARGEST_SPACING_ANGSTROM;
    let gap = by_spheres.then(|| ion_gap(&grid, spheres, dielectric.ion_radius_angstrom));
    let DielectricMap {
        inside,
        edges,
        accessible,
    } = DielectricMap::new(&grid, solid, inner, outer, gap.as_deref());
    drop(gap);
    let h = grid.spacing_angstrom;
    let per_part = outer * (dielectric.electrolyte.inverse_debye_length_per_angstrom() * h).powi(2);
    let mass: Vec<f32> = accessible
        .par_iter()
        .map(|part| (per_part * f64::from(*part)) as f32)
        .collect();
    drop(accessible);
    let operator = Operator::new(grid.shape, edges, mass);
    let charges: Vec<ChargedSphere> = spheres
        .iter()
        .copied()
        .filter(|sphere| sphere.charge_e != 0.0)
        .collect();
    let coulomb: PointCharges = charges
        .iter()
        .map(|charge| Source {
            place: charge.centre,
            strength: dielectric.electrolyte.vacuum_bjerrum_length_angstrom() / inner
                * charge.charge_e,
            least_distance_angstrom: NEAREST_ANGSTROM,
        })
        .collect();
    let mut right = coulomb_source::at_surface(&grid, &operator, &inside, &coulomb, [inner, outer]);
    coulomb_source::add_ions(&mut right, &grid, &operator, &inside, &coulomb);
    let mut reduced = faces(&grid, boundary);
    let iterations = solve_with_faces(&operator, right, &mut reduced, settings.relative_tolerance)?;
    let mut potential = Potential {
        reduced: ScalarField {
            grid,
            values: reduced,
        },
        inside,
        coulomb,
        solvation_energy_kt: 0.0,
        iterations,
    };
    potential.solvation_energy_kt = 0.5
        * charges
            .par_iter()
            .map(|c| c.charge_e * potential.reaction_at(&c.centre))
            .collect::<Vec<_>>()
            .iter()
            .sum::<f64>();
    Ok(potential)
}

/// Zero inside, boundary values on the faces.
fn faces(grid: &Grid, boundary: impl Fn(&Vec3) -> f64 + Sync) -> Vec<f64> {
    let [nx, ny, nz] = grid.shape;
    let mut values = vec![0.0; grid.len()];
    values
        .par_chunks_mut(nx * ny)
        .enumerate()
        .for_each(|(k, plane)| {
            for (n, value) in plane.iter_mut().enumerate() {
                let (i, j) = (n % nx, n / nx);
                if i == 0 || i + 1 == nx || j == 0 || j + 1 == ny || k == 0 || k + 1 == nz {
                    *value = boundary(&grid.point(i, j, k));
                }
            }
        });
    values
}

/// Solves for the inner points with the values on the faces as they are.
fn solve_with_faces(
    operator: &Operator,
    mut right: Vec<f64>,
    x: &mut [f64],
    tolerance: f64,
) -> Result<usize> {
    // b - A (faces), then zero faces.
    let mut from_faces = vec![0.0; x.len()];
    operator.apply(x, &mut from_faces);
    operator.inner_rows(&mut right, |row, start| {
        for (offset, b) in row.iter_mut().enumerate() {
            *b -= from_faces[start + offset];
        }
    });
    drop(from_faces);
    let mut inner = vec![0.0; x.len()];
    let iterations = conjugate_gradient::solve(operator, &right, &mut inner, tolerance)?;
    operator.inner_rows(x, |row, start| {
        row.copy_from_slice(&inner[start..start + row.len()])
    });
    Ok(iterations)
}

/// How far outside the spheres grown by the radius of ions a place is, Å, to within a spacing or
/// so.
fn ion_gap(grid: &Grid, spheres: &[ChargedSphere], ion_radius: f64) -> Vec<f32> {
    let h = grid.spacing_angstrom;
    let mut gap = vec![f32::MAX; grid.len()];
    let [nx, ny, _] = grid.shape;
    gap.par_chunks_mut(nx * ny)
        .enumerate()
        .for_each(|(k, plane)| {
            let z = grid.origin_angstrom[2] + h * k as f64;
            for sphere in spheres.iter().filter(|sphere| sphere.radius_angstrom > 0.0) {
                let radius = sphere.radius_angstrom + ion_radius;
                let reach = radius + h;
                let dz = z - sphere.centre.z;
                let square = reach * reach - dz * dz;
                if square <= 0.0 {
                    continue;
                }
                let range = |centre: f64, origin: f64, half: f64, points: usize| {
                    let first = ((centre - half - origin) / h).ceil().max(0.0) as usize;
                    let last = ((centre + half - origin) / h)
                        .floor()
                        .min(points as f64 - 1.0);
                    if last < 0.0 {
                        0..0
                    } else {
                        first..last as usize + 1
                    }
                };
                for j in range(sphere.centre.y, grid.origin_angstrom[1], square.sqrt(), ny) {
                    let dy = grid.origin_angstrom[1] + h * j as f64 - sphere.centre.y;
                    let left = square - dy * dy;
                    if left <= 0.0 {
                        continue;
                    }
                    for i in range(sphere.centre.x, grid.origin_angstrom[0], left.sqrt(), nx) {
                        let dx = grid.origin_angstrom[0] + h * i as f64 - sphere.centre.x;
                        let value = ((dx * dx + dy * dy + dz * dz).sqrt() - radius) as f32;
                        let gap = &mut plane[j * nx + i];
                        *gap = gap.min(value);
                    }
                }
            }
        });
    gap
}

impl Potential {
    /// The grid.
    pub fn grid(&self) -> &Grid {
        &self.reduced.grid
    }

    /// The reaction field φ - φ_C at a place, kT/e: cubic deep inside, trilinear near the surface.
    fn reaction_at(&self, place: &Vec3) -> f64 {
        let grid = &self.reduced.grid;
        let Some((cell, part)) = grid.locate(place) else {
            return 0.0;
        };
        let has_neighbours = (0..3).all(|axis| cell[axis] > 0 && cell[axis] + 2 < grid.shape[axis]);
        let index = |di: usize, dj: usize, dk: usize| {
            grid.index(cell[0] + di - 1, cell[1] + dj - 1, cell[2] + dk - 1)
        };
        if has_neighbours && (0..64).all(|n| self.inside[index(n & 3, n >> 2 & 3, n >> 4)]) {
            return interpolate_cubically(&part, |di, dj, dk| {
                self.reduced.values[index(di, dj, dk)]
            });
        }
        interpolate(&part, |di, dj, dk| {
            let [i, j, k] = [cell[0] + di, cell[1] + dj, cell[2] + dk];
            let at = grid.index(i, j, k);
            let taken = if self.inside[at] {
                0.0
            } else {
                self.coulomb.coulomb(&grid.point(i, j, k))
            };
            self.reduced.values[at] - taken
        })
    }

    /// The potential at a place, kT/e; `None` outside the grid. Where all corners of the place's
    /// cell are outside the surface it is interpolated, elsewhere the reaction field is, and the
    /// Coulomb potential is added.
    pub fn at(&self, place: &Vec3) -> Option<f64> {
        let grid = &self.reduced.grid;
        let (cell, part) = grid.locate(place)?;
        let corner = |d: usize| {
            grid.index(
                cell[0] + (d & 1),
                cell[1] + (d >> 1 & 1),
                cell[2] + (d >> 2),
            )
        };
        if (0..8).all(|d| !self.inside[corner(d)]) {
            return Some(interpolate(&part, |di, dj, dk| {
                self.reduced.values[grid.index(cell[0] + di, cell[1] + dj, cell[2] + dk)]
            }));
        }
        Some(self.reaction_at(place) + self.coulomb.coulomb(place))
    }

    /// The potential at all points, kT/e.
    pub fn field(&self) -> ScalarField {
        let grid = self.reduced.grid;
        let [nx, ny, _] = grid.shape;
        let mut values = self.reduced.values.clone();
        values
            .par_chunks_mut(nx * ny)
            .enumerate()
            .for_each(|(k, plane)| {
                for (n, value) in plane.iter_mut().enumerate() {
                    if self.inside[k * nx * ny + n] {
                        *value += self.coulomb.coulomb(&grid.point(n % nx, n / nx, k));
                    }
                }
            });
        ScalarField { grid, values }
    }
}
