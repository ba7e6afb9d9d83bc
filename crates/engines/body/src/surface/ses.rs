//! Atoms in, solvent-excluded surface out: first exactly, as a solid with a signed distance, then the
//! mesh, what it should measure exactly, and by how much it misses that.

use super::arrangement::invalid;
use super::calibrate::Target;
use super::deviation::Deviation;
use super::interior::ball_fits_inside;
use super::mesher::{Goal, MeshSettings, Meshed, mesh_in_full};
use super::{Arrangement, Measure, SesSolid, SurfaceMeasure};
use crate::Result;
use protomer_kernel::mesh::Topology;
use protomer_kernel::{TriangleMesh, Vec3};

/// The lattice on which the surface is first found is at least this fine, in radii of the smallest
/// atom.
const SPACING_PER_RADIUS: f64 = 0.6;
/// Exact areas whose estimated relative error is larger are refused; 10⁻⁸ is the rule.
const LARGEST_RELATIVE_ERROR: f64 = 1e-3;
/// Atoms smaller than this do not make the lattice finer, Å.
const SMALLEST_RESOLVED_RADIUS_ANGSTROM: f64 = 0.3;

/// A solvent-excluded surface before it has a mesh.
///
/// ```
/// use protomer_body::surface::{ExactSurface, ImplicitSolid, MeshSettings};
/// use protomer_kernel::Vec3;
/// let exact = ExactSurface::new(&[Vec3::zeros()], &[1.7], 1.4)?;
/// assert!((exact.solid().signed_distance(&Vec3::x()) + 0.7).abs() < 1e-7);
/// let surface = exact.mesh(&MeshSettings::default(), None)?;
/// assert_eq!(surface.topology.components, 1);
/// # Ok::<(), protomer_body::BodyError>(())
/// ```
#[derive(Debug, Clone)]
pub struct ExactSurface {
    accessible: Arrangement,
    solid: SesSolid,
    /// The smallest radius that the lattice resolves, Å.
    smallest_radius: f64,
}

impl ExactSurface {
    /// The surface of atoms at these places, Å.
    ///
    /// # Errors
    /// As [`Arrangement::new`].
    pub fn new(
        centres: &[Vec3],
        radii_angstrom: &[f64],
        probe_radius_angstrom: f64,
    ) -> Result<Self> {
        let accessible = Arrangement::new(centres, radii_angstrom, probe_radius_angstrom)?;
        let resolved = radii_angstrom
            .iter()
            .filter(|radius| **radius >= SMALLEST_RESOLVED_RADIUS_ANGSTROM);
        Ok(Self {
            solid: SesSolid::new(&accessible),
            smallest_radius: resolved.copied().fold(f64::INFINITY, f64::min),
            accessible,
        })
    }

    /// The solid that the surface encloses.
    pub fn solid(&self) -> &SesSolid {
        &self.solid
    }

    /// The mesh: with all cavities as [`solvent_excluded_surface`] makes it, or with those that hold a
    /// ball of a radius (Å) as [`surface_without_cavities`] does.
    ///
    /// # Errors
    /// [`crate::BodyError::Invalid`] for settings that make no sense, and surfaces too large to be
    /// meshed.
    pub fn mesh(
        self,
        settings: &MeshSettings,
        interior_radius_angstrom: Option<f64>,
    ) -> Result<Surface> {
        let Self {
            accessible,
            solid,
            smallest_radius,
        } = self;
        let measure = Measure::new(&accessible);
        require_small_error(&measure.total())?;
        // The mesh needs the memory.
        // A large structure's arrangement is as large as its mesh.
        drop(accessible);
        let settings = MeshSettings {
            // Fine enough for the smallest atom: a sphere narrower than the cells could be missed.
            base_spacing_angstrom: settings
                .base_spacing_angstrom
                .min(SPACING_PER_RADIUS * smallest_radius),
            ..*settings
        };
        let mut selection = Selection::everything(&measure);
        let Meshed {
            mesh,
            topology,
            expected_squares,
        } = mesh_in_full(&solid, &settings, &mut |uncalibrated| {
            if let Some(radius_angstrom) = interior_radius_angstrom {
                selection =
                    Selection::of_shells(&uncalibrated.to_shells(), &measure, radius_angstrom);
            }
            Ok(Goal {
                target: Some(target(&selection.exact)),
                is_kept: selection.is_kept.clone(),
            })
        })?;
        let Selection {
            exact, cavities, ..
        } = selection;
        Ok(Surface {
            mesh,
            topology,
            exact,
            measure,
            cavities,
            solid,
            expected_squares,
        })
    }
}

/// A solvent-excluded surface; [`solvent_excluded_surface`] and [`surface_without_cavities`] make it.
#[derive(Debug, Clone)]
pub struct Surface {
    /// The surface as a closed, 2-manifold, outward mesh.
    pub mesh: TriangleMesh,
    /// Shells, genus and cavities of the mesh.
    pub topology: Topology,
    /// Exact areas and volumes of the shells that the mesh has.
    pub exact: SurfaceMeasure,
    /// Exact areas and volumes of all shells, cavities included.
    pub measure: Measure,
    /// Cavities that [`surface_without_cavities`] filled and kept.
    pub cavities: FilledCavities,
    solid: SesSolid,
    /// An estimate of the mean squared distance from the exact surface on each triangle, Å².
    expected_squares: Vec<f64>,
}

/// Cavities that [`surface_without_cavities`] filled, and those that it kept.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct FilledCavities {
    /// Number of cavities filled.
    pub filled: usize,
    /// Exact volume of the filled cavities in all, Å³.
    pub filled_volume_angstrom3: f64,
    /// Number of enclosed interiors kept.
    pub kept: usize,
    /// Exact volume of the kept interiors in all, Å³.
    pub kept_volume_angstrom3: f64,
}

impl Surface {
    /// Area of the mesh over the exact area, less one.
    pub fn relative_area_error(&self) -> f64 {
        self.mesh.area_angstrom2() / self.exact.ses_area_angstrom2() - 1.0
    }

    /// Volume of the mesh over the exact volume, less one.
    pub fn relative_volume_error(&self) -> f64 {
        self.mesh.volume_angstrom3() / self.exact.ses_volume_angstrom3 - 1.0
    }

    /// Deviation of the mesh, as it was made, from the exact surface.
    pub fn deviation(&self) -> Deviation {
        Deviation::guided(&self.mesh, &self.solid, &self.expected_squares)
    }

    #[cfg(test)]
    pub(crate) fn solid(&self) -> &SesSolid {
        &self.solid
    }

    #[cfg(test)]
    pub(crate) fn expected_squares(&self) -> &Vec<f64> {
        &self.expected_squares
    }
}

/// Refuses areas that are not exact after all: a mesh is calibrated to them.
fn require_small_error(total: &SurfaceMeasure) -> Result<()> {
    // A mesh can only be as right as the area it is calibrated to.
    let area = total.ses_area_angstrom2();
    let error = total.area_error_estimate_angstrom2;
    if error <= LARGEST_RELATIVE_ERROR * area {
        return Ok(());
    }
    let cause = format!(
        "the area of the surface, {area:.3} Å², is uncertain by {error:.0e} Å²: its faces do not close"
    );
    Err(invalid(cause, "move the atoms by about 1e-3 Å"))
}

/// Area and volume that a mesh of this surface should have.
fn target(exact: &SurfaceMeasure) -> Target {
    Target {
        area_angstrom2: exact.ses_area_angstrom2(),
        volume_angstrom3: exact.ses_volume_angstrom3,
    }
}

/// The solvent-excluded surface of atoms, internal cavities included, as a mesh calibrated to its
/// exact area and volume.
///
/// The topology is that of the surface down to the base spacing of `settings` (0.3 Å, or 0.6 radii
/// of the smallest atom if that is less): a gap, wall or handle thinner than that may be missed,
/// the same way in every orientation. The walls of a re-entrant surface end in cusps, thinner than
/// any lattice, so there can be handles that no spacing settles.
///
/// # Errors
/// [`crate::BodyError::Invalid`] for no atoms, coordinates, radii or settings that make no sense,
/// and surfaces too large to be meshed.
///
/// ```
/// use protomer_body::surface::{MeshSettings, solvent_excluded_surface};
/// use protomer_kernel::Vec3;
///
/// let centres = [Vec3::zeros(), Vec3::new(2.5, 0.0, 0.0)];
/// let surface = solvent_excluded_surface(&centres, &[1.7, 1.55], 1.4, &MeshSettings::default())?;
/// assert_eq!((surface.topology.components, surface.topology.genus), (1, 0));
/// assert!((surface.exact.ses_area_angstrom2() - 57.53365).abs() < 1e-4);
/// assert!(surface.relative_area_error().abs() < 0.01 && surface.relative_volume_error().abs() < 0.002);
/// # Ok::<(), protomer_body::BodyError>(())
/// ```
pub fn solvent_excluded_surface(
    centres: &[Vec3],
    radii_angstrom: &[f64],
    probe_radius_angstrom: f64,
    settings: &MeshSettings,
) -> Result<Surface> {
    ExactSurface::new(centres, radii_angstrom, probe_radius_angstrom)?.mesh(settings, None)
}

/// Variant of [`solvent_excluded_surface`] without the walls of cavities, calibrated to the exact
/// area and volume of the shells that are left. Enclosed interiors stay: cavities into which a ball
/// of `interior_radius_angstrom` fits ([`ball_fits_inside`]), as other bodies may be in there. An
/// infinite radius fills every cavity.
///
/// # Errors
/// As [`solvent_excluded_surface`].
///
/// ```
/// use protomer_body::surface::{MeshSettings, surface_without_cavities};
/// use protomer_kernel::Vec3;
///
/// // Atoms on a sphere of radius 12 Å, close enough to keep every probe inside.
/// let centres: Vec<Vec3> = (0..500)
///     .map(|n| {
///         let z = 1.0 - (2.0 * f64::from(n) + 1.0) / 500.0;
///         let (sine, cosine) = (2.4 * f64::from(n)).sin_cos();
///         let r = (1.0 - z * z).sqrt();
///         12.0 * Vec3::new(r * cosine, r * sine, z)
///     })
///     .collect();
/// let settings = MeshSettings::default();
/// let solid = surface_without_cavities(&centres, &[1.7; 500], 1.4, &settings, f64::INFINITY)?;
/// assert_eq!((solid.topology.cavities, solid.cavities.filled), (0, 1));
/// let hollow = surface_without_cavities(&centres, &[1.7; 500], 1.4, &settings, 8.0)?;
/// assert_eq!((hollow.topology.cavities, hollow.cavities.kept), (1, 1));
/// assert!(hollow.cavities.kept_volume_angstrom3 > 4000.0);
/// # Ok::<(), protomer_body::BodyError>(())
/// ```
pub fn surface_without_cavities(
    centres: &[Vec3],
    radii_angstrom: &[f64],
    probe_radius_angstrom: f64,
    settings: &MeshSettings,
    interior_radius_angstrom: f64,
) -> Result<Surface> {
    let exact = ExactSurface::new(centres, radii_angstrom, probe_radius_angstrom)?;
    exact.mesh(settings, Some(interior_radius_angstrom))
}

/// Shells of a mesh that stay.
struct Selection {
    exact: SurfaceMeasure,
    /// Whether each shell stays, by its number; `None` where all do.
    is_kept: Option<Vec<bool>>,
    cavities: FilledCavities,
}

impl Selection {
    fn everything(measure: &Measure) -> Self {
        Self {
            exact: measure.total(),
            is_kept: None,
            cavities: FilledCavities::default(),
        }
    }

    /// All shells but the cavities into which no ball of this radius (Å) fits.
    fn of_shells(shells: &[TriangleMesh], measure: &Measure, radius_angstrom: f64) -> Self {
        let mut is_kept = Vec::with_capacity(shells.len());
        // Volumes of the cavities, and whether each is kept.
        let mut ranking = Vec::new();
        for shell in shells {
            let volume = shell.volume_angstrom3();
            let is_interior = volume < 0.0 && ball_fits_inside(shell, radius_angstrom);
            is_kept.push(volume >= 0.0 || is_interior);
            if volume < 0.0 {
                ranking.push((volume, is_interior));
            }
        }
        let (exact, cavities) = exact_with(measure, ranking);
        // Nothing filled: the exact values of the whole surface hold without any matching.
        if cavities.filled == 0 {
            return Self {
                cavities,
                ..Self::everything(measure)
            };
        }
        Self {
            exact,
            is_kept: Some(is_kept),
            cavities,
        }
    }
}

/// Exact areas and volumes of the outer shells and of the cavities that are kept, and the volumes of
/// cavities. The mesh may have lost cavities smaller than its lattice, so the cavities of both are
/// matched by their rank in volume, largest first. A cavity of the mesh alone, a pocket with a mouth
/// finer than the lattice, counts with its own volume.
fn exact_with(
    measure: &Measure,
    mut ranking: Vec<(f64, bool)>,
) -> (SurfaceMeasure, FilledCavities) {
    let (mut exact, mut filling) = (measure.without_cavities(), FilledCavities::default());
    let mut cavities = measure.cavities();
    // Volumes of cavities are negative.
    // Matched by rank: the mesh's volumes are inexact, their order is not.
    ranking.sort_by(|a, b| a.0.total_cmp(&b.0));
    cavities.sort_by(|a, b| a.ses_volume_angstrom3.total_cmp(&b.ses_volume_angstrom3));
    for (rank, (volume_of_mesh, is_kept)) in ranking.into_iter().enumerate() {
        let cavity = cavities.get(rank).copied();
        let volume_angstrom3 = -cavity.map_or(volume_of_mesh, |shell| shell.ses_volume_angstrom3);
        if is_kept {
            filling.kept += 1;
            filling.kept_volume_angstrom3 += volume_angstrom3;
            exact += cavity.unwrap_or_default();
        } else {
            filling.filled += 1;
            filling.filled_volume_angstrom3 += volume_angstrom3;
        }
    }
    (exact, filling)
}
