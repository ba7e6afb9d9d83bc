//! Stereolithography: a soup of triangles, welded into a mesh where corners have equal coordinates.

use super::builder::MeshBuilder;
use crate::bytes::{Cursor, Ended};
use crate::text::{self, Line};
use crate::{IoError, Result};
use protomer_kernel::{TriangleMesh, Vec3};
use std::collections::HashMap;

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
    (HEADER_BYTES + 4) as u128 + u128::from(triangles) * TRIANGLE_BYTES as u128
}

fn read_binary(name: &str, bytes: &[u8]) -> Result<TriangleMesh> {
    let mut welder = Welder::new(name);
    for record in bytes[HEADER_BYTES + 4..].chunks_exact(TRIANGLE_BYTES) {
        match binary_corners(record) {
            Ok(corners) => welder.add_triangle(0, corners)?,
            Err(ended) => {
                let cause = format!("the file ends at byte {}", ended.at);
                return Err(IoError::parse(name, 0, cause, "make it again"));
            }
        }
    }
    welder.builder.finish()
}

/// The corners of a triangle; the normal before them is redundant and skipped.
fn binary_corners(record: &[u8]) -> std::result::Result<[Vec3; 3], Ended> {
    let mut cursor = Cursor::new(record);
    cursor.take(12)?;
    let mut corners = [Vec3::zeros(); 3];
    for coordinate in corners.iter_mut().flatten() {
        *coordinate = cursor.f32()?.into();
    }
    Ok(corners)
}

fn read_ascii(name: &str, bytes: &[u8]) -> Result<TriangleMesh> {
    let text = text::decode(name, bytes)?;
    let mut welder = Welder::new(name);
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
                welder.add_triangle(line.number, triangle)?;
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
    welder.builder.finish()
}

/// Gives corners with equal coordinates one vertex.
struct Welder<'a> {
    builder: MeshBuilder<'a>,
    vertex_at: HashMap<[u64; 3], i64>,
}

impl<'a> Welder<'a> {
    fn new(name: &'a str) -> Self {
        Self {
            builder: MeshBuilder::new(name),
            vertex_at: HashMap::new(),
        }
    }

    fn add_triangle(&mut self, line: usize, corners: [Vec3; 3]) -> Result<()> {
        let mut indices = [0; 3];
        for (index, corner) in indices.iter_mut().zip(corners) {
            *index = self.vertex(line, corner)?;
        }
        let [a, b, c] = indices;
        if a == b || b == c || c == a {
            Ok(())
        } else {
            self.builder.add_polygon(line, &indices)
        }
    }

    fn vertex(&mut self, line: usize, corner: Vec3) -> Result<i64> {
        // Adding zero turns -0 into 0, which is the same point.
        let key = [corner.x, corner.y, corner.z].map(|coordinate| (coordinate + 0.0).to_bits());
        if let Some(&known) = self.vertex_at.get(&key) {
            return Ok(known);
        }
        let new = self.builder.vertices() as i64;
        self.builder.add_vertex(line, corner)?;
        self.vertex_at.insert(key, new);
        Ok(new)
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
        let across = (b - a).cross(&(c - a));
        let normal = across.try_normalize(0.0).unwrap_or_default();
        for coordinate in [normal, a, b, c].iter().flatten() {
            bytes.extend_from_slice(&(*coordinate as f32).to_le_bytes());
        }
        bytes.extend_from_slice(&[0, 0]);
    }
    bytes
}
