//! Stereolithography: a soup of triangles, welded into a mesh where corners have equal coordinates.

use super::MeshBuilder;
use crate::bytes::{Cursor, Ended};
use crate::text::{self, Line};
use crate::{IoError, Result, mesh::TriangleMesh};
use protomer_kernel::Vec3;
use std::collections::HashMap;

const HEADER_BYTES: usize = 80;
const TRIANGLE_BYTES: usize = 50;

/// Reads binary or ASCII STL. Corners with equal coordinates become one vertex, and triangles that
/// have lost their area to the rounding of coordinates are dropped: their two remaining edges
/// coincide, so a closed surface stays closed.
///
/// # Errors
/// [`IoError::Parse`] names the line (ASCII) or the number of bytes missing (binary).
pub fn read_stl(name: &str, bytes: &[u8]) -> Result<TriangleMesh> {
    // Binary headers may begin with "solid" too; the length tells them apart.
    match binary_triangles(bytes) {
        Some(count) if bytes.len() == HEADER_BYTES + 4 + count * TRIANGLE_BYTES => {
            read_binary(name, bytes)
        }
        _ if bytes.trim_ascii_start().starts_with(b"solid") && !bytes.contains(&0) => {
            read_ascii(name, bytes)
        }
        Some(count) => {
            let cause = format!(
                "its header promises {count} triangles in {} bytes, but the file has {} bytes",
                (HEADER_BYTES + 4) as u128 + count as u128 * TRIANGLE_BYTES as u128,
                bytes.len()
            );
            Err(IoError::parse(
                name,
                0,
                cause,
                "it is cut or not STL: make it again",
            ))
        }
        None => Err(IoError::parse(
            name,
            0,
            "the file is too short for STL",
            "it is cut or not STL: make it again",
        )),
    }
}

fn binary_triangles(bytes: &[u8]) -> Option<usize> {
    let mut cursor = Cursor::new(bytes);
    cursor.take(HEADER_BYTES).ok()?;
    cursor.u32().ok().map(|count| count as usize)
}

fn read_binary(name: &str, bytes: &[u8]) -> Result<TriangleMesh> {
    let mut welder = Welder::new(name);
    let ended = |ended: Ended| {
        IoError::parse(
            name,
            0,
            format!("the file ends at byte {}", ended.at),
            "make it again",
        )
    };
    for record in bytes[HEADER_BYTES + 4..].chunks_exact(TRIANGLE_BYTES) {
        let mut cursor = Cursor::new(record);
        cursor.take(12).map_err(ended)?; // the normal, which the corners' order states as well
        let mut corners = [Vec3::zeros(); 3];
        for corner in &mut corners {
            let [x, y, z] = [cursor.f32(), cursor.f32(), cursor.f32()].map(|c| c.map_err(ended));
            *corner = Vec3::new(x?.into(), y?.into(), z?.into());
        }
        welder.add_triangle(0, corners)?;
    }
    welder.builder.finish()
}

fn read_ascii(name: &str, bytes: &[u8]) -> Result<TriangleMesh> {
    let text = text::decode(name, bytes)?;
    let mut welder = Welder::new(name);
    let mut corners = Vec::with_capacity(3);
    let mut closed = false;
    for line in Line::significant(name, &text) {
        let mut tokens = line.text.split_whitespace();
        match tokens.next() {
            Some("vertex") => corners.push(line.point(&mut tokens, "a vertex")?),
            Some("endloop") => {
                let triangle = <[Vec3; 3]>::try_from(std::mem::take(&mut corners)).map_err(
                    |corners: Vec<Vec3>| {
                        line.error(
                            format!("a facet has {} corners", corners.len()),
                            "facets of STL have three",
                        )
                    },
                )?;
                welder.add_triangle(line.number, triangle)?;
            }
            Some("endsolid") => closed = true,
            Some("solid") => closed = false,
            Some("facet" | "outer" | "endfacet") => {}
            other => {
                let cause = format!(
                    "{} is no keyword of STL",
                    text::shown(other.unwrap_or_default())
                );
                return Err(line.error(cause, "give an STL file"));
            }
        }
    }
    if !closed {
        return Err(IoError::parse(
            name,
            0,
            "the file ends before `endsolid`",
            "it is cut: make it again",
        ));
    }
    welder.builder.finish()
}

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
            // Adding zero turns -0 into 0, which is the same place.
            let key = [corner.x, corner.y, corner.z].map(|coordinate| (coordinate + 0.0).to_bits());
            *index = match self.vertex_at.get(&key) {
                Some(&known) => known,
                None => {
                    self.builder.add_vertex(line, corner)?;
                    let new = self.builder.mesh.vertices.len() as i64 - 1;
                    self.vertex_at.insert(key, new);
                    new
                }
            };
        }
        let [a, b, c] = indices;
        if a == b || b == c || c == a {
            Ok(())
        } else {
            self.builder.add_polygon(line, &indices)
        }
    }
}

/// The bytes of a binary STL file; coordinates are rounded to `f32`.
pub fn write_stl_binary(mesh: &TriangleMesh) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(HEADER_BYTES + 4 + TRIANGLE_BYTES * mesh.triangles.len());
    bytes.extend_from_slice(b"protomer surface mesh, lengths in angstrom");
    bytes.resize(HEADER_BYTES, b' ');
    bytes.extend_from_slice(&(mesh.triangles.len() as u32).to_le_bytes());
    for triangle in 0..mesh.triangles.len() {
        let [a, b, c] = mesh.corners(triangle);
        let normal = (b - a)
            .cross(&(c - a))
            .try_normalize(0.0)
            .unwrap_or_default();
        for coordinate in [normal, a, b, c].iter().flat_map(|point| point.iter()) {
            bytes.extend_from_slice(&(*coordinate as f32).to_le_bytes());
        }
        bytes.extend_from_slice(&[0, 0]);
    }
    bytes
}
