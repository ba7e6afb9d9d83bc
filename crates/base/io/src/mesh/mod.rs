//! Triangle meshes: one module per format, and the choice between them by extension.
//!
//! Readers check that the file can be understood, that coordinates are finite and that faces refer
//! to existing vertices. Use [`TriangleMesh::topology`] to check whether the surface is closed.

mod builder;
pub mod obj;
pub mod off;
pub mod ply;
mod polygon;
pub mod stl;
mod weld;

use crate::{IoError, Result};
use protomer_kernel::TriangleMesh;

/// The mesh formats.
///
/// ```
/// use protomer_io::mesh::{MeshFormat, write_mesh};
/// use protomer_kernel::{TriangleMesh, Vec3};
/// let vertices = vec![Vec3::zeros(), Vec3::x(), Vec3::y()];
/// let mesh = TriangleMesh { vertices, triangles: vec![[0, 1, 2]] };
/// assert!(write_mesh(MeshFormat::Off, &mesh).starts_with(b"OFF\n3 1 "));
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MeshFormat {
    /// Polygon File Format (Stanford), written as binary little-endian.
    Ply,
    /// Wavefront OBJ.
    Obj,
    /// Object File Format (Geomview).
    Off,
    /// Stereolithography, written as binary.
    Stl,
}

impl MeshFormat {
    /// The format given by the extension of a file name; a final `.gz` is ignored.
    ///
    /// ```
    /// use protomer_io::mesh::MeshFormat;
    /// assert_eq!(MeshFormat::from_name("surface.ply.gz")?, MeshFormat::Ply);
    /// # Ok::<(), protomer_io::IoError>(())
    /// ```
    ///
    /// # Errors
    /// [`IoError::Parse`] lists the known extensions.
    pub fn from_name(name: &str) -> Result<Self> {
        let lower = name.to_ascii_lowercase();
        let plain = lower.strip_suffix(".gz").unwrap_or(&lower);
        match plain.rsplit('.').next() {
            Some("ply") => Ok(MeshFormat::Ply),
            Some("obj") => Ok(MeshFormat::Obj),
            Some("off") => Ok(MeshFormat::Off),
            Some("stl") => Ok(MeshFormat::Stl),
            _ => {
                let cause = "the extension does not name a mesh format";
                let remedy = "name it .ply, .obj, .off or .stl";
                Err(IoError::parse(name, 0, cause, remedy))
            }
        }
    }
}

/// Reads a mesh in the format given by the extension of its name.
///
/// ```
/// let off = "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
/// let mesh = protomer_io::mesh::read_mesh("triangle.off", off.as_bytes())?;
/// assert_eq!(mesh.triangles, [[0, 1, 2]]);
/// # Ok::<(), protomer_io::IoError>(())
/// ```
///
/// # Errors
/// [`IoError::Parse`] with the line (zero for binary formats), the cause and a remedy.
pub fn read_mesh(name: &str, bytes: &[u8]) -> Result<TriangleMesh> {
    let mesh = match MeshFormat::from_name(name)? {
        MeshFormat::Ply => ply::read_ply(name, bytes),
        MeshFormat::Obj => obj::read_obj(name, bytes),
        MeshFormat::Off => off::read_off(name, bytes),
        MeshFormat::Stl => stl::read_stl(name, bytes),
    }?;
    Ok(weld::closed(mesh))
}

/// The bytes of a mesh file in this format. PLY, OBJ and OFF keep coordinates exactly; STL rounds
/// them to `f32`.
///
/// ```
/// use protomer_io::mesh::{MeshFormat, read_mesh, write_mesh};
/// use protomer_kernel::{TriangleMesh, Vec3};
/// let mesh = TriangleMesh {
///     vertices: vec![Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::z()],
///     triangles: vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
/// };
/// let bytes = write_mesh(MeshFormat::Ply, &mesh);
/// assert_eq!(read_mesh("tetrahedron.ply", &bytes)?, mesh);
/// # Ok::<(), protomer_io::IoError>(())
/// ```
pub fn write_mesh(format: MeshFormat, mesh: &TriangleMesh) -> Vec<u8> {
    match format {
        MeshFormat::Ply => ply::write_ply_binary(mesh),
        MeshFormat::Obj => obj::write_obj(mesh).into_bytes(),
        MeshFormat::Off => off::write_off(mesh).into_bytes(),
        MeshFormat::Stl => stl::write_stl_binary(mesh),
    }
}
