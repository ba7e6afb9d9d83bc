//! From an implicit solid to its mesh: extract, remesh, calibrate, check.

use super::calibrate::{Target, calibrate};
use super::extract::{FirstEdges, extract};
use super::frame::Frame;
use super::implicit::ImplicitSolid;
use super::remesh::{HalfEdgeMesh, SHORT_EDGES_PER_ANGSTROM2, remesh};
use crate::{BodyError, Result};
use protomer_kernel::mesh::Topology;
use protomer_kernel::{TriangleMesh, Vec3};

/// Largest number of vertices; more are refused.
const MOST_VERTICES: f64 = 1e7;
/// Largest value of [`MeshSettings::fewest_vertices_per_shell`].
const MOST_PER_SHELL: usize = 10_000;
/// Factor of the lattice spacing from each attempt to the next. It is not a simple fraction, so
/// that the planes differ.
const REFINEMENT: f64 = 0.73;
/// Attempts with ever finer lattices before giving up.
const ATTEMPTS: usize = 3;

/// Edges of the first mesh, in units of density^(-1/2), which is about the length of those of the
/// final mesh.
const FIRST_EDGE: f64 = 0.65;
/// Variant of [`FIRST_EDGE`] for large shells, if edges are short ([`SHORT_EDGES_PER_ANGSTROM2`]):
/// elsewhere a first mesh as coarse as the last one would cut the corners of small shapes.
const FIRST_SHORT_EDGE: f64 = 1.0;
/// Least number of vertices of a large shell.
const FEWEST_OF_LARGE_SHELL: usize = 240;

/// Settings of a mesh.
///
/// ```
/// use protomer_body::surface::MeshSettings;
/// let coarse = MeshSettings { density_per_angstrom2: 0.25, ..MeshSettings::default() };
/// assert_eq!(coarse.base_spacing_angstrom, 0.3);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeshSettings {
    /// Vertices per Å² of surface.
    pub density_per_angstrom2: f64,
    /// Edge of the cubes of the lattice on which the surface is first found, Å. It sets the
    /// smallest feature that is seen, about its own size, independently of the density. At the
    /// default of 0.3 Å the shells and cavities of proteins are those of lattices many times finer.
    /// Handles are too, except through walls that end in a cusp: these get thinner than any
    /// lattice, and whether such an edge has a hole may depend on the lattice at every spacing.
    pub base_spacing_angstrom: f64,
    /// Least number of vertices of every closed shell, so that small bodies stay round.
    pub fewest_vertices_per_shell: usize,
}

impl MeshSettings {
    /// The default of [`MeshSettings::base_spacing_angstrom`].
    pub const BASE_SPACING_ANGSTROM: f64 = 0.3;
}

impl Default for MeshSettings {
    fn default() -> Self {
        Self {
            density_per_angstrom2: 1.0,
            base_spacing_angstrom: Self::BASE_SPACING_ANGSTROM,
            fewest_vertices_per_shell: 120,
        }
    }
}

/// A closed, 2-manifold, outward mesh of the surface of `solid`, cavities included.
///
/// With a `target` the mesh is calibrated to it; without, it is only made locally true to volume.
///
/// # Errors
/// [`BodyError::Invalid`] for settings that make no sense or need too many vertices, and for a
/// solid without a surface that the lattice can see.
///
/// ```
/// use protomer_body::surface::{ImplicitSolid, MeshSettings, mesh_solid};
/// use protomer_kernel::Vec3;
///
/// struct Ball(f64);
/// impl ImplicitSolid for Ball {
///     fn signed_distance(&self, point: &Vec3) -> f64 {
///         point.norm() - self.0
///     }
///     fn project(&self, point: &Vec3) -> (Vec3, Vec3) {
///         let normal = point.normalize();
///         (normal * self.0, normal)
///     }
///     fn bounds(&self) -> (Vec3, Vec3) {
///         (Vec3::repeat(-self.0), Vec3::repeat(self.0))
///     }
///     fn cover(&self) -> Vec<(Vec3, f64)> {
///         vec![(Vec3::zeros(), self.0)]
///     }
/// }
///
/// let mesh = mesh_solid(&Ball(5.0), &MeshSettings::default(), None)?;
/// assert_eq!(mesh.topology()?.genus, 0);
/// assert!((mesh.volume_angstrom3() / 523.6 - 1.0).abs() < 2e-3);
/// # Ok::<(), protomer_body::BodyError>(())
/// ```
pub fn mesh_solid(
    solid: &dyn ImplicitSolid,
    settings: &MeshSettings,
    target: Option<Target>,
) -> Result<TriangleMesh> {
    let mut all_shells = |_: &HalfEdgeMesh| {
        Ok(Goal {
            target,
            is_kept: None,
        })
    };
    mesh_in_full(solid, settings, &mut all_shells).map(|meshed| meshed.mesh)
}

/// A checked mesh.
pub(crate) struct Meshed {
    pub(crate) mesh: TriangleMesh,
    pub(crate) topology: Topology,
    /// An estimate of the mean squared distance from the surface on each triangle, Å².
    pub(crate) expected_squares: Vec<f64>,
}

/// Treatment of a mesh whose vertices are on the surface.
pub(crate) struct Goal {
    /// Area and volume to which the mesh is calibrated.
    pub(crate) target: Option<Target>,
    /// Whether each shell stays, in the order of [`HalfEdgeMesh::to_shells`]; `None` if all do.
    pub(crate) is_kept: Option<Vec<bool>>,
}

/// [`mesh_solid`] with everything that it found. `goal` sees the mesh before it is calibrated.
pub(crate) fn mesh_in_full(
    solid: &dyn ImplicitSolid,
    settings: &MeshSettings,
    goal: &mut dyn FnMut(&HalfEdgeMesh) -> Result<Goal>,
) -> Result<Meshed> {
    settings.check()?;
    let centres: Vec<Vec3> = solid.cover().iter().map(|(centre, _)| *centre).collect();
    let frame = Frame::of_points(&centres);
    let mut spacing = settings.base_spacing_angstrom;
    let first_edges = settings.first_edges();
    let mut last = no_surface();
    for _ in 0..ATTEMPTS {
        let first = extract(solid, &frame, spacing, &first_edges)?;
        settings.check_size(&first)?;
        if !first.triangles.is_empty() {
            match finish(first, solid, settings, goal) {
                Ok(result) => return Ok(result),
                Err(defect) => last = defect,
            }
        }
        spacing *= REFINEMENT;
    }
    Err(last)
}

/// Remeshes, calibrates and checks a first mesh.
fn finish(
    first: TriangleMesh,
    solid: &dyn ImplicitSolid,
    settings: &MeshSettings,
    goal: &mut dyn FnMut(&HalfEdgeMesh) -> Result<Goal>,
) -> Result<Meshed> {
    let mut half_edges = remesh(
        first,
        solid,
        settings.density_per_angstrom2,
        settings.fewest_vertices_per_shell,
    )?;
    let goal = goal(&half_edges)?;
    if let Some(is_kept) = &goal.is_kept {
        half_edges = half_edges.with_shells(is_kept);
    }
    let expected_squares = calibrate(&mut half_edges, solid, goal.target);
    let mesh = half_edges.to_mesh();
    let topology = mesh.topology()?;
    Ok(Meshed {
        mesh,
        topology,
        expected_squares,
    })
}

/// The mesh without the shells that enclose negative volume, and how many those were.
///
/// ```
/// use protomer_body::surface::without_cavities;
/// use protomer_kernel::{TriangleMesh, Vec3};
/// let mut hollow = TriangleMesh::cuboid(&Vec3::zeros(), &Vec3::repeat(3.0));
/// let wall = TriangleMesh::cuboid(&Vec3::repeat(1.0), &Vec3::repeat(2.0));
/// hollow.triangles.extend(wall.triangles.iter().map(|[a, b, c]| [a + 8, c + 8, b + 8]));
/// hollow.vertices.extend(&wall.vertices);
/// let (filled, cavities) = without_cavities(&hollow)?;
/// assert_eq!(cavities, 1);
/// assert!((hollow.volume_angstrom3() - 26.0).abs() < 1e-9 && (filled.volume_angstrom3() - 27.0).abs() < 1e-9);
/// # Ok::<(), protomer_body::BodyError>(())
/// ```
///
/// # Errors
/// [`BodyError::Kernel`] if the mesh is not closed.
pub fn without_cavities(mesh: &TriangleMesh) -> Result<(TriangleMesh, usize)> {
    let mut outer = TriangleMesh::default();
    let mut dropped = 0;
    for shell in mesh.shells()? {
        if shell.volume_angstrom3() < 0.0 {
            dropped += 1;
        } else {
            append(&mut outer, shell);
        }
    }
    Ok((outer, dropped))
}

fn append(mesh: &mut TriangleMesh, shell: TriangleMesh) {
    let offset = mesh.vertices.len() as u32;
    mesh.vertices.extend(shell.vertices);
    for corners in shell.triangles {
        mesh.triangles.push(corners.map(|vertex| vertex + offset));
    }
}

impl MeshSettings {
    /// Refuses a surface that would need too many vertices.
    fn check_size(&self, first: &TriangleMesh) -> Result<()> {
        let needed = first.area_angstrom2() * self.density_per_angstrom2;
        if needed <= MOST_VERTICES {
            return Ok(());
        }
        Err(BodyError::Invalid {
            cause: format!(
                "{} vertices per Å² make {needed:.1e} vertices, of at most 1e7",
                self.density_per_angstrom2
            ),
            remedy: "ask for a lower density".into(),
        })
    }

    fn first_edges(&self) -> FirstEdges {
        let density = self.density_per_angstrom2;
        let in_large_shells = if density < SHORT_EDGES_PER_ANGSTROM2 {
            FIRST_EDGE
        } else {
            FIRST_SHORT_EDGE
        };
        // A shell that gets more vertices than its area asks for has shorter edges.
        let large_shell = FEWEST_OF_LARGE_SHELL.max(2 * self.fewest_vertices_per_shell);
        FirstEdges {
            large_shell_angstrom2: large_shell as f64 / density,
            in_large_shells_angstrom: in_large_shells * density.powf(-0.5),
            in_small_shells_angstrom: FIRST_EDGE * density.powf(-0.5),
        }
    }

    pub(crate) fn check(&self) -> Result<()> {
        let Self {
            density_per_angstrom2: density,
            base_spacing_angstrom: spacing,
            fewest_vertices_per_shell: fewest,
        } = *self;
        let (cause, remedy) = if !is_positive(density) {
            (
                format!("a mesh cannot have {density} vertices per Å²"),
                "ask for a positive density, 1 per Å² for example",
            )
        } else if !is_positive(spacing) {
            (
                format!("a lattice cannot have a spacing of {spacing} Å"),
                "ask for a positive spacing, 0.3 Å for example",
            )
        } else if fewest > MOST_PER_SHELL {
            (
                format!("{fewest} is too many vertices for the smallest shells"),
                "ask for 10000 at most, or for a higher density",
            )
        } else {
            return Ok(());
        };
        Err(BodyError::Invalid {
            cause,
            remedy: remedy.into(),
        })
    }
}

fn is_positive(value: f64) -> bool {
    value.is_finite() && value > 0.0
}

fn no_surface() -> BodyError {
    BodyError::Invalid {
        cause: "the solid has no surface that a lattice of this spacing can see".into(),
        remedy: "check that there are atoms with positive radii, or ask for a finer base spacing"
            .into(),
    }
}
