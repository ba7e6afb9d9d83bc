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
use protomer_kernel::setting::Choices;

protomer_kernel::choices! {
    /// The mesh formats, each by the extension of its files.
    ///
    /// ```
    /// use protomer_io::mesh::{MeshFormat, write_mesh};
    /// use protomer_kernel::{TriangleMesh, Vec3};
    /// let vertices = vec![Vec3::zeros(), Vec3::x(), Vec3::y()];
    /// let mesh = TriangleMesh { vertices, triangles: vec![[0, 1, 2]] };
    /// assert!(write_mesh(MeshFormat::Off, &mesh).starts_with(b"OFF\n3 1 "));
    /// ```
    pub enum MeshFormat {
        /// Polygon File Format (Stanford), written as binary little-endian.
        Ply = "ply",
        /// Wavefront OBJ.
        Obj = "obj",
        /// Object File Format (Geomview).
        Off = "off",
        /// Stereolithography, written as binary.
        Stl = "stl",
    }
}

/// Reader and writer of a format.
struct Codec {
    read: fn(&str, &[u8]) -> Result<TriangleMesh>,
    write: fn(&TriangleMesh) -> Vec<u8>,
    is_exact: bool,
}

impl MeshFormat {
    fn codec(self) -> Codec {
        match self {
            Self::Ply => Codec {
                read: ply::read_ply,
                write: ply::write_ply_binary,
                is_exact: true,
            },
            Self::Obj => Codec {
                read: obj::read_obj,
                write: |mesh| obj::write_obj(mesh).into_bytes(),
                is_exact: true,
            },
            Self::Off => Codec {
                read: off::read_off,
                write: |mesh| off::write_off(mesh).into_bytes(),
                is_exact: true,
            },
            Self::Stl => Codec {
                read: stl::read_stl,
                write: stl::write_stl_binary,
                is_exact: false,
            },
        }
    }

    /// Whether files hold vertices by number and coordinates to the last bit; others hold the corners of each triangle,
    /// rounded to `f32`.
    pub fn is_exact(self) -> bool {
        self.codec().is_exact
    }

    /// The extensions of all formats, in words.
    ///
    /// ```
    /// use protomer_io::mesh::MeshFormat;
    /// assert_eq!(MeshFormat::extensions(), ".ply, .obj, .off or .stl");
    /// ```
    pub fn extensions() -> String {
        let names: Vec<String> = Self::ALL
            .iter()
            .map(|format| format!(".{}", format.name()))
            .collect();
        match names.split_last() {
            Some((last, others)) if !others.is_empty() => {
                format!("{} or {last}", others.join(", "))
            }
            _ => names.concat(),
        }
    }

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
        let extension = plain.rsplit('.').next().unwrap_or_default();
        <Self as Choices>::from_name(extension).ok_or_else(|| {
            let cause = "the extension does not name a mesh format";
            let remedy = format!("name it {}", Self::extensions());
            IoError::parse(name, 0, cause, remedy)
        })
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
    let codec = MeshFormat::from_name(name)?.codec();
    Ok(weld::closed((codec.read)(name, bytes)?))
}

/// The bytes of a mesh file in this format. Coordinates read back as they are where the format
/// [is exact](MeshFormat::is_exact).
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
    (format.codec().write)(mesh)
}
