//! The solvent-excluded surface of a file, without charges.

use crate::bodies::body_file;
use crate::file_kind::FileKind;
use anyhow::{Context, Result};
use protomer_body::chemistry::{SiteSettings, build_sites, sites_of_points};
use protomer_body::structure::{Format, SelectionSettings, Structure};
use protomer_body::{Site, SurfaceSettings, surface_of_sites};
use protomer_common::answer::Answer;
use protomer_common::input::InputFile;
use protomer_common::output_file::write_once;
use protomer_io::mesh::{MeshFormat, write_mesh};
use protomer_io::points::read_xyzr;
use protomer_io::pqr::read_pqr;
use protomer_kernel::{TriangleMesh, Vec3};
use serde::Serialize;
use std::path::Path;

/// Summary numbers of a surface.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SurfaceReport {
    /// The input file.
    pub file: String,
    /// Atoms with a radius.
    pub atoms: usize,
    /// Probe radius, Å.
    pub probe_radius_angstrom: f64,
    /// Requested vertices per Å².
    pub density_per_angstrom2: f64,
    /// Spacing of the lattice on which the surface was first found, Å.
    pub lattice_spacing_angstrom: f64,
    /// Exact area from the arrangement of the accessible surface, cavities included, Å².
    pub ses_area_angstrom2: f64,
    /// Exact volume, cavities excluded, Å³.
    pub ses_volume_angstrom3: f64,
    /// Estimated relative error of the exact area and volume.
    pub relative_error_estimate: f64,
    /// Area of the mesh, Å².
    pub mesh_area_angstrom2: f64,
    /// Volume inside the mesh, Å³.
    pub mesh_volume_angstrom3: f64,
    /// Root mean square of the mesh's distance from the exact surface, Å.
    pub mesh_rms_distance_angstrom: f64,
    /// The largest distance of the mesh from the exact surface, Å.
    pub mesh_largest_distance_angstrom: f64,
    /// Mesh vertices.
    pub vertices: usize,
    /// Mesh triangles.
    pub triangles: usize,
    /// Connected components of the surface, walls of cavities included.
    pub components: usize,
    /// Sum of the genera of the components.
    pub genus: i64,
    /// Components that are walls of cavities.
    pub cavities: usize,
}

impl Answer for SurfaceReport {
    fn text(&self) -> String {
        format!(
            "{} atoms\n\
             exact:  area {:.3} Å², volume {:.3} Å³ (relative error about {:.0e})\n\
             mesh:   area {:.3} Å² ({:+.2} %), volume {:.3} Å³ ({:+.3} %)\n\
             {:8}{:.3} Å from the exact surface (root mean square), {:.2} Å at most\n\
             {} vertices, {} triangles, {} components, {} of them cavities, genus {}",
            self.atoms,
            self.ses_area_angstrom2,
            self.ses_volume_angstrom3,
            self.relative_error_estimate,
            self.mesh_area_angstrom2,
            100.0 * (self.mesh_area_angstrom2 / self.ses_area_angstrom2 - 1.0),
            self.mesh_volume_angstrom3,
            100.0 * (self.mesh_volume_angstrom3 / self.ses_volume_angstrom3 - 1.0),
            "",
            self.mesh_rms_distance_angstrom,
            self.mesh_largest_distance_angstrom,
            self.vertices,
            self.triangles,
            self.components,
            self.cavities,
            self.genus
        )
    }
}

/// Computes a surface and, if an output file is given, writes its mesh in the format of the file's
/// extension.
///
/// # Errors
/// As [`surface_of_file`]; also for an unknown extension, which is refused before the computation, and
/// a file that exists with other content, unless `force` is set.
pub fn measure_surface(
    path: &Path,
    settings: &SurfaceSettings,
    output: Option<&Path>,
    force: bool,
) -> Result<SurfaceReport> {
    let format = output.map(|path| MeshFormat::from_name(&path.display().to_string()));
    let format = format.transpose()?;
    let (mesh, report) = surface_of_file(path, settings)?;
    if let (Some(path), Some(format)) = (output, format) {
        let bytes = write_mesh(format, &mesh);
        write_once(path, &bytes, force)?;
    }
    Ok(report)
}

/// The surface of a structure, PQR, `.xyzr` or body file, in the coordinates of the file.
///
/// # Errors
/// Names the file and the line, and says what to do.
///
/// ```no_run
/// use protomer_protein_verbs::bodies::surface_of_file::surface_of_file;
/// use protomer_body::SurfaceSettings;
/// use std::path::Path;
/// let (mesh, report) = surface_of_file(Path::new("5pti.cif.gz"), &SurfaceSettings::default())?;
/// println!("{} triangles, {} cavities", mesh.triangles.len(), report.cavities);
/// # Ok::<(), anyhow::Error>(())
/// ```
pub fn surface_of_file(
    path: &Path,
    settings: &SurfaceSettings,
) -> Result<(TriangleMesh, SurfaceReport)> {
    let file = InputFile::read(path)?;
    let (sites, origin) = read_sites(&file)?;
    // A large file would count in the memory of the surface.
    drop(file.bytes);
    let surface = surface_of_sites(&sites, settings).with_context(|| file.name.clone())?;
    let deviation = surface.deviation();
    let (mesh, exact, topology) = (surface.mesh, surface.exact, surface.topology);
    let report = SurfaceReport {
        file: file.name,
        atoms: sites
            .iter()
            .filter(|site| site.radius_angstrom > 0.0)
            .count(),
        probe_radius_angstrom: settings.probe_radius_angstrom,
        density_per_angstrom2: settings.density_per_angstrom2,
        lattice_spacing_angstrom: settings.lattice_spacing_angstrom,
        ses_area_angstrom2: exact.ses_area_angstrom2(),
        ses_volume_angstrom3: exact.ses_volume_angstrom3,
        relative_error_estimate: exact.area_error_estimate_angstrom2 / exact.ses_area_angstrom2(),
        mesh_area_angstrom2: mesh.area_angstrom2(),
        mesh_volume_angstrom3: mesh.volume_angstrom3(),
        mesh_rms_distance_angstrom: deviation.rms_angstrom,
        mesh_largest_distance_angstrom: deviation.largest_angstrom,
        vertices: mesh.vertices.len(),
        triangles: mesh.triangles.len(),
        components: topology.components,
        genus: topology.genus,
        cavities: topology.cavities,
    };
    Ok((mesh.map_vertices(|vertex| vertex + origin), report))
}

/// Whether the content is PQR.
fn is_pqr(file: &InputFile) -> Result<bool> {
    FileKind::Structure.require(Path::new(&file.name))?;
    Ok(Format::of_file(&file.name, &file.bytes)? == Format::Pqr)
}

/// Reads the sites of a structure, PQR, `.xyzr` or body file relative to an origin, and that
/// origin in the coordinates of the file (for a body: of the file it was made from).
pub(crate) fn read_sites(file: &InputFile) -> Result<(Vec<Site>, Vec3)> {
    let plain = file.name.strip_suffix(".gz").unwrap_or(&file.name);
    if plain.ends_with(".body") {
        let body = body_file::from_bytes(&file.name, &file.bytes)?;
        return Ok((body.sites, body.provenance.origin_angstrom));
    }
    let charged = if plain.ends_with(".xyzr") {
        sites_of_points(&read_xyzr(&file.name, &file.bytes)?)
    } else if is_pqr(file)? {
        sites_of_points(&read_pqr(&file.name, &file.bytes)?)
    } else {
        let selection =
            Structure::read(&file.name, &file.bytes)?.select(&SelectionSettings::default());
        selection.and_then(|selection| build_sites(&selection, &SiteSettings::default()))
    };
    let charged = charged.with_context(|| file.name.clone())?;
    Ok((charged.sites, charged.origin_angstrom))
}
