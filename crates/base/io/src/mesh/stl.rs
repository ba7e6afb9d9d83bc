//! Stereolithography: a soup of triangles, welded into a mesh where corners have equal coordinates.

use super::builder::MeshBuilder;
use super::weld::welded;
use crate::bytes::{Cursor, Ended};
use crate::text::{self, Line};
use crate::{IoError, Result};
use protomer_kernel::{TriangleMesh, Vec3};

const HEADER_BYTES: usize = 80;
const TRIANGLE_BYTES: usize = 50;

/// Reads binary or ASCII STL. Corners with equal coordinates become one vertex, and triangles that
/// have lost their area to the rounding of coordinates are dropped: their two remaining edges
/// coincide, so a closed surface stays closed.
///
/// ```
/// let text = b"solid one\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\n\
///              vertex 0 1 0\nendloop\nendfacet\nendsolid one\n";
/// let mesh = protomer_io::mesh::stl::read_stl("one.stl", text)?;
/// assert_eq!(mesh.triangles, [[0, 1, 2]]);
/// # Ok::<(), protomer_io::IoError>(())
/// ```
///
/// # Errors
/// [`IoError::Parse`] names the line (ASCII) or the number of bytes missing (binary).
pub fn read_stl(name: &str, bytes: &[u8]) -> Result<TriangleMesh> {
    let refuse = |cause: &str| {
        let remedy = "it is truncated or not STL: make it again";
        Err(IoError::parse(name, 0, cause, remedy))
    };
    let promised = binary_triangles(bytes);
    // Binary headers may start with "solid" too; the length distinguishes them.
    if promised.is_some_and(|count| bytes.len() as u128 == binary_length(count)) {
        return read_binary(name, bytes);
    }
    // No zero byte: a binary file whose length is wrong must not be read as text.
    if bytes.trim_ascii_start().starts_with(b"solid") && !bytes.contains(&0) {
        return read_ascii(name, bytes);
    }
    match promised {
        Some(count) => refuse(&format!(
            "its header states {count} triangles in {} bytes, but the file has {} bytes",
            binary_length(count),
            bytes.len()
        )),
        None => refuse("the file is too short for STL"),
    }
}

/// The number of triangles that a binary header states.
fn binary_triangles(bytes: &[u8]) -> Option<u32> {
    let mut cursor = Cursor::new(bytes);
    cursor.take(HEADER_BYTES).ok()?;
    cursor.u32().ok()
}

/// Length of a binary file with `count` triangles.
fn binary_length(triangles: u32) -> u128 {
    // In 128 bits, as 2³² triangles of 50 bytes overflow 32 bits and nothing may wrap.
    (HEADER_BYTES + 4) as u128 + u128::from(triangles) * TRIANGLE_BYTES as u128
}

fn read_binary(name: &str, bytes: &[u8]) -> Result<TriangleMesh> {
    let mut soup = Soup::new(name);
    for record in bytes[HEADER_BYTES + 4..].chunks_exact(TRIANGLE_BYTES) {
        match binary_corners(record) {
            Ok(corners) => soup.add_triangle(0, corners)?,
            Err(ended) => {
                let cause = format!("the file ends at byte {}", ended.byte);
                return Err(IoError::parse(name, 0, cause, "make it again"));
            }
        }
    }
    soup.finish()
}

/// The corners of a triangle; the normal before them is redundant and skipped.
fn binary_corners(record: &[u8]) -> std::result::Result<[Vec3; 3], Ended> {
    let mut cursor = Cursor::new(record);
    // The normal: three f32.
    cursor.take(12)?;
    let mut corners = [Vec3::zeros(); 3];
    for coordinate in corners.iter_mut().flatten() {
        *coordinate = cursor.f32()?.into();
    }
    Ok(corners)
}

fn read_ascii(name: &str, bytes: &[u8]) -> Result<TriangleMesh> {
    let text = text::decode(name, bytes)?;
    let mut soup = Soup::new(name);
    let mut corners = Vec::with_capacity(3);
    let mut closed = false;
    for line in Line::significant(name, &text) {
        let mut tokens = line.text.split_whitespace();
        match tokens.next().unwrap_or_default() {
            "vertex" => corners.push(line.point(&mut tokens, "a vertex")?),
            "endloop" => {
                let Ok(triangle) = <[Vec3; 3]>::try_from(corners.as_slice()) else {
                    let cause = format!("a facet has {} corners", corners.len());
                    return Err(line.error(cause, "facets of STL have three"));
                };
                soup.add_triangle(line.number, triangle)?;
                corners.clear();
            }
            "endsolid" => closed = true,
            "solid" => closed = false,
            "facet" | "outer" | "endfacet" => {}
            other => {
                let cause = format!("{} is not a keyword of STL", text::shown(other));
                return Err(line.error(cause, "give an STL file"));
            }
        }
    }
    if !closed {
        let cause = "the file ends before `endsolid`";
        return Err(IoError::parse(
            name,
            0,
            cause,
            "it is truncated: make it again",
        ));
    }
    soup.finish()
}

/// Triangles without common vertices.
struct Soup<'a> {
    name: &'a str,
    builder: MeshBuilder<'a>,
}

impl<'a> Soup<'a> {
    fn new(name: &'a str) -> Self {
        Self {
            name,
            builder: MeshBuilder::new(name),
        }
    }

    fn add_triangle(&mut self, line: usize, corners: [Vec3; 3]) -> Result<()> {
        // Three vertices of its own; `welded` finds those that coincide.
        let first = self.builder.vertices() as i64;
        for corner in corners {
            self.builder.add_vertex(line, corner)?;
        }
        self.builder
            .add_polygon(line, &[first, first + 1, first + 2])
    }

    /// The mesh with one vertex per place.
    fn finish(self) -> Result<TriangleMesh> {
        let mesh = welded(&self.builder.finish()?);
        if mesh.triangles.is_empty() {
            let cause = "no facet has three different corners";
            return Err(IoError::parse(self.name, 0, cause, "make the mesh again"));
        }
        Ok(mesh)
    }
}

/// The bytes of a binary STL file; coordinates are rounded to `f32`.
///
/// ```
/// use protomer_io::mesh::stl::{read_stl, write_stl_binary};
/// use protomer_kernel::{TriangleMesh, Vec3};
/// let vertices = vec![Vec3::zeros(), Vec3::x(), Vec3::y()];
/// let mesh = TriangleMesh { vertices, triangles: vec![[0, 1, 2]] };
/// assert_eq!(read_stl("mesh.stl", &write_stl_binary(&mesh))?, mesh);
/// # Ok::<(), protomer_io::IoError>(())
/// ```
pub fn write_stl_binary(mesh: &TriangleMesh) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(HEADER_BYTES + 4 + TRIANGLE_BYTES * mesh.triangles.len());
    bytes.extend_from_slice(b"protomer surface mesh, lengths in angstrom");
    bytes.resize(HEADER_BYTES, b' ');
    bytes.extend_from_slice(&(mesh.triangles.len() as u32).to_le_bytes());
    for triangle in 0..mesh.triangles.len() {
        let [a, b, c] = mesh.corners(triangle);
        let perpendicular = (b - a).cross(&(c - a));
        // Readers that trust the normal get zeros for a triangle without a direction.
        let normal = perpendicular.try_normalize(0.0).unwrap_or_default();
        for coordinate in [normal, a, b, c].iter().flatten() {
            bytes.extend_from_slice(&(*coordinate as f32).to_le_bytes());
        }
        // The attribute byte count, which nobody uses.
        bytes.extend_from_slice(&[0, 0]);
    }
    bytes
}
