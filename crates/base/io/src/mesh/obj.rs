//! Wavefront OBJ: `v x y z` and `f a b c ...`, indices counted from one, or from the end if
//! negative.
//!
//! Texture and normal indices, groups, materials, lines and points are ignored: they are not part
//! of the surface.

use super::builder::MeshBuilder;
use crate::Result;
use crate::text::{self, Line};
use protomer_kernel::TriangleMesh;
use std::fmt::Write;

/// Reads the vertices and faces of an OBJ file; polygons are triangulated.
///
/// ```
/// let text = b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n";
/// let square = protomer_io::mesh::obj::read_obj("square.obj", text)?;
/// assert_eq!(square.triangles.len(), 2);
/// # Ok::<(), protomer_io::IoError>(())
/// ```
///
/// # Errors
/// [`IoError::Parse`](crate::IoError::Parse) names the line.
pub fn read_obj(name: &str, bytes: &[u8]) -> Result<TriangleMesh> {
    let text = text::decode(name, bytes)?;
    let text = with_joined_lines(&text);
    let mut builder = MeshBuilder::new(name);
    // A face may only refer to vertices above it, so one pass is enough.
    for line in Line::significant(name, &text) {
        let mut tokens = line.text.split_whitespace();
        match tokens.next() {
            Some("v") => builder.add_vertex(line.number, line.point(&mut tokens, "a vertex")?)?,
            Some("f") => {
                let count = builder.vertices() as i64;
                let mut corners = Vec::new();
                for token in tokens {
                    corners.push(corner(&line, token, count)?);
                }
                builder.add_polygon(line.number, &corners)?;
            }
            _ => {}
        }
    }
    builder.finish()
}

/// The text with each line that ends with a backslash joined to the next one. As many blank lines
/// follow the joined ones, so that messages name the lines of the file.
fn with_joined_lines(text: &str) -> String {
    let mut joined = String::with_capacity(text.len());
    let mut continued = 0;
    // Line ends are `\n` alone in decoded text.
    for line in text.split_inclusive('\n') {
        if let Some(start) = line.strip_suffix("\\\n") {
            joined.push_str(start);
            joined.push(' ');
            continued += 1;
        } else {
            joined.push_str(line);
            joined.extend(std::iter::repeat_n('\n', continued));
            continued = 0;
        }
    }
    joined
}

/// The vertex, counted from zero, of a face corner written `v`, `v/vt`, `v//vn` or `v/vt/vn`.
fn corner(line: &Line, token: &str, vertices: i64) -> Result<i64> {
    let index = line.integer(token.split('/').next(), "a vertex index")?;
    match index {
        0 => Err(line.error("a face refers to vertex 0", "count vertices from one")),
        // -1 is the latest vertex so far.
        negative if negative < 0 => Ok(vertices.saturating_add(negative)),
        positive => Ok(positive - 1),
    }
}

/// The text of an OBJ file; coordinates are written so that they read back exactly.
///
/// ```
/// use protomer_io::mesh::obj::{read_obj, write_obj};
/// use protomer_kernel::{TriangleMesh, Vec3};
/// let vertices = vec![Vec3::zeros(), Vec3::x() / 3.0, Vec3::y()];
/// let mesh = TriangleMesh { vertices, triangles: vec![[0, 1, 2]] };
/// assert_eq!(read_obj("mesh.obj", write_obj(&mesh).as_bytes())?, mesh);
/// # Ok::<(), protomer_io::IoError>(())
/// ```
pub fn write_obj(mesh: &TriangleMesh) -> String {
    let mut text = String::from("# protomer surface mesh, lengths in angstrom\n");
    for v in &mesh.vertices {
        let _ = writeln!(text, "v {} {} {}", v.x, v.y, v.z);
    }
    for corners in &mesh.triangles {
        let [a, b, c] = corners.map(|corner| u64::from(corner) + 1);
        let _ = writeln!(text, "f {a} {b} {c}");
    }
    text
}
