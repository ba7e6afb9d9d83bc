//! Triangle meshes: one module per format, and the choice between them by extension.
//!
//! Readers check that the file can be understood, that coordinates are finite and that faces name
//! vertices that exist; whether the surface is closed is for [`TriangleMesh::topology`] to say.

pub mod obj;
pub mod off;
pub mod ply;
mod polygon;
pub mod stl;

use crate::{IoError, Result};
use protomer_kernel::{TriangleMesh, Vec3};

/// The mesh formats.
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
    /// The format that a file name's extension means; `.gz` after it is ignored.
    ///
    /// # Errors
    /// [`IoError::Parse`] names the extensions there are.
    pub fn from_name(name: &str) -> Result<Self> {
        let lower = name.to_ascii_lowercase();
        let stem = lower.strip_suffix(".gz").unwrap_or(&lower);
        match stem.rsplit('.').next() {
            Some("ply") => Ok(MeshFormat::Ply),
            Some("obj") => Ok(MeshFormat::Obj),
            Some("off") => Ok(MeshFormat::Off),
            Some("stl") => Ok(MeshFormat::Stl),
            _ => {
                let remedy = "name it .ply, .obj, .off or .stl";
                Err(IoError::parse(
                    name,
                    0,
                    "the extension does not name a mesh format",
                    remedy,
                ))
            }
        }
    }
}

/// Reads a mesh in the format that the name's extension means.
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
    match MeshFormat::from_name(name)? {
        MeshFormat::Ply => ply::read_ply(name, bytes),
        MeshFormat::Obj => obj::read_obj(name, bytes),
        MeshFormat::Off => off::read_off(name, bytes),
        MeshFormat::Stl => stl::read_stl(name, bytes),
    }
}

/// The bytes of a mesh file in this format. PLY, OBJ and OFF keep coordinates exactly; STL rounds
/// them to `f32`.
pub fn write_mesh(format: MeshFormat, mesh: &TriangleMesh) -> Vec<u8> {
    match format {
        MeshFormat::Ply => ply::write_ply_binary(mesh),
        MeshFormat::Obj => obj::write_obj(mesh).into_bytes(),
        MeshFormat::Off => off::write_off(mesh).into_bytes(),
        MeshFormat::Stl => stl::write_stl_binary(mesh),
    }
}

/// Collects polygons into triangles, refusing faces that name vertices which do not exist.
struct MeshBuilder<'a> {
    file: &'a str,
    mesh: TriangleMesh,
}

/// Polygons with more corners than this are refused: no surface program writes them, and they are
/// slow to triangulate.
const MOST_CORNERS: usize = 256;

impl<'a> MeshBuilder<'a> {
    fn new(file: &'a str) -> Self {
        Self {
            file,
            mesh: TriangleMesh::default(),
        }
    }

    fn add_vertex(&mut self, line: usize, position: Vec3) -> Result<()> {
        if self.mesh.vertices.len() >= u32::MAX as usize {
            return Err(IoError::parse(
                self.file,
                line,
                "more vertices than 2^32",
                "give a coarser mesh",
            ));
        }
        if !position.iter().all(|coordinate| coordinate.is_finite()) {
            let cause = format!(
                "vertex {} has a coordinate that is not finite",
                self.mesh.vertices.len()
            );
            return Err(IoError::parse(
                self.file,
                line,
                cause,
                "make the mesh again",
            ));
        }
        self.mesh.vertices.push(position);
        Ok(())
    }

    /// Adds a face with these corners (counted from zero), triangulated. All vertices must have
    /// been added.
    fn add_polygon(&mut self, line: usize, corners: &[i64]) -> Result<()> {
        let count = self.mesh.vertices.len();
        if corners.len() < 3 || corners.len() > MOST_CORNERS {
            let cause = format!("a face has {} corners", corners.len());
            let remedy = format!("faces need 3 to {MOST_CORNERS} corners: triangulate the mesh");
            return Err(IoError::parse(self.file, line, cause, remedy));
        }
        let mut indices = Vec::with_capacity(corners.len());
        for &corner in corners {
            match u32::try_from(corner) {
                Ok(index) if (index as usize) < count => indices.push(index),
                _ => {
                    let cause = format!(
                        "a face names vertex {corner} (counted from zero), but there are {count}"
                    );
                    return Err(IoError::parse(
                        self.file,
                        line,
                        cause,
                        "the file is damaged or cut: make it again",
                    ));
                }
            }
        }
        polygon::triangulate(&self.mesh.vertices, &indices, &mut self.mesh.triangles);
        Ok(())
    }

    fn finish(self) -> Result<TriangleMesh> {
        if self.mesh.triangles.is_empty() {
            return Err(IoError::parse(
                self.file,
                0,
                "the file holds no faces",
                "give a surface mesh, not a point cloud",
            ));
        }
        Ok(self.mesh)
    }
}
