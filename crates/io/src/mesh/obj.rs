//! Wavefront OBJ: `v x y z` and `f a b c ...`, indices counted from one, or from the end if
//! negative.
//!
//! Texture and normal indices, groups, materials, lines and points are passed over: they are no
//! part of the surface.

use super::MeshBuilder;
use crate::text::{self, Line};
use crate::{Result, mesh::TriangleMesh};
use std::fmt::Write;

/// Reads the vertices and faces of an OBJ file; polygons are triangulated.
///
/// # Errors
/// [`crate::IoError::Parse`] names the line.
pub fn read_obj(name: &str, bytes: &[u8]) -> Result<TriangleMesh> {
    let text = text::decode(name, bytes)?;
    let text = text.replace("\\\r\n", " ").replace("\\\n", " ");
    let mut builder = MeshBuilder::new(name);
    // A face may only name vertices above it, so one pass does.
    for line in Line::significant(name, &text) {
        let mut tokens = line.text.split_whitespace();
        match tokens.next() {
            Some("v") => builder.add_vertex(line.number, line.point(&mut tokens, "a vertex")?)?,
            Some("f") => {
                let count = builder.mesh.vertices.len() as i64;
                let corners = tokens
                    .map(|token| corner(&line, token, count))
                    .collect::<Result<Vec<_>>>()?;
                builder.add_polygon(line.number, &corners)?;
            }
            _ => {}
        }
    }
    builder.finish()
}

/// The vertex, counted from zero, of a face corner written `v`, `v/vt`, `v//vn` or `v/vt/vn`.
fn corner(line: &Line, token: &str, vertices: i64) -> Result<i64> {
    let index = line.integer(token.split('/').next(), "a vertex index")?;
    match index {
        0 => Err(line.error("a face names vertex 0", "count vertices from one")),
        negative if negative < 0 => Ok(vertices.saturating_add(negative)),
        positive => Ok(positive - 1),
    }
}

/// The text of an OBJ file; coordinates are written so that they read back exactly.
pub fn write_obj(mesh: &TriangleMesh) -> String {
    let mut text = String::from("# protomer surface mesh, lengths in angstrom\n");
    for v in &mesh.vertices {
        let _ = writeln!(text, "v {} {} {}", v.x, v.y, v.z);
    }
    for [a, b, c] in &mesh.triangles {
        let _ = writeln!(
            text,
            "f {} {} {}",
            u64::from(*a) + 1,
            u64::from(*b) + 1,
            u64::from(*c) + 1
        );
    }
    text
}
