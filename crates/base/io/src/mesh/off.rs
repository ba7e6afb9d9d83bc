//! Object File Format (Geomview): `OFF`, counts of vertices, faces and edges, then one vertex or
//! face per line.

use super::builder::MeshBuilder;
use crate::text::{self, Line};
use crate::{IoError, Result};
use protomer_kernel::TriangleMesh;
use std::fmt::Write;

/// Reads an OFF file (also `COFF`, `NOFF` and `STOFF`, of which only positions are kept); polygons
/// are triangulated.
///
/// ```
/// let text = b"OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
/// let triangle = protomer_io::mesh::off::read_off("triangle.off", text)?;
/// assert_eq!(triangle.vertices.len(), 3);
/// # Ok::<(), protomer_io::IoError>(())
/// ```
///
/// # Errors
/// [`IoError::Parse`] names the line.
pub fn read_off(name: &str, bytes: &[u8]) -> Result<TriangleMesh> {
    let text = text::decode(name, bytes)?;
    let mut lines = Line::significant(name, &text);
    let cut = || {
        let cause = "the file ends before all its faces";
        IoError::parse(name, 0, cause, "it is truncated: make it again")
    };
    let (vertices, faces) = counts(&mut lines)?.ok_or_else(cut)?;
    let mut builder = MeshBuilder::new(name);
    // Counts only control the loops: each iteration consumes a line, so a wrong header runs out of
    // lines, not of memory.
    for _ in 0..vertices {
        let line = lines.next().ok_or_else(cut)?;
        let position = line.point(&mut line.text.split_whitespace(), "a vertex")?;
        builder.add_vertex(line.number, position)?;
    }
    for _ in 0..faces {
        let line = lines.next().ok_or_else(cut)?;
        builder.add_polygon(line.number, &corners(&line)?)?;
    }
    builder.finish()
}

/// The corners of a face: their number, then their vertices.
fn corners(line: &Line) -> Result<Vec<i64>> {
    let mut tokens = line.text.split_whitespace();
    let stated = line.integer(tokens.next(), "the number of corners")?;
    let mut corners = Vec::new();
    // Colours may follow the corners; they are left alone.
    for token in tokens.take(usize::try_from(stated).unwrap_or(0)) {
        corners.push(line.integer(Some(token), "a vertex index")?);
    }
    if corners.len() as i64 != stated {
        let cause = format!("a face has {} of its {stated} corners", corners.len());
        return Err(line.error(cause, "complete the line"));
    }
    Ok(corners)
}

/// The counts of vertices and faces, on the line of the keyword or on the next one.
fn counts<'a>(lines: &mut impl Iterator<Item = Line<'a>>) -> Result<Option<(i64, i64)>> {
    let Some(mut line) = lines.next() else {
        return Ok(None);
    };
    let mut tokens = line.text.split_whitespace().peekable();
    let keyword = tokens.next().unwrap_or_default();
    match keyword {
        "OFF" | "COFF" | "NOFF" | "CNOFF" | "STOFF" => {}
        other if other.ends_with("OFF") => {
            let shown = text::shown(other);
            let cause = format!("{shown} is not a surface in three dimensions");
            return Err(line.error(cause, "write an OFF file"));
        }
        _ => return Err(line.error("the file does not begin with OFF", "give an OFF file")),
    }
    if tokens.peek().is_none() {
        match lines.next() {
            Some(next) => line = next,
            None => return Ok(None),
        }
        tokens = line.text.split_whitespace().peekable();
    }
    let vertices = line.integer(tokens.next(), "the number of vertices")?;
    let faces = line.integer(tokens.next(), "the number of faces")?;
    Ok(Some((vertices, faces)))
}

/// The text of an OFF file; coordinates are written so that they read back exactly.
///
/// ```
/// use protomer_io::mesh::off::{read_off, write_off};
/// use protomer_kernel::{TriangleMesh, Vec3};
/// let vertices = vec![Vec3::zeros(), Vec3::x() / 3.0, Vec3::y()];
/// let mesh = TriangleMesh { vertices, triangles: vec![[0, 1, 2]] };
/// assert_eq!(read_off("mesh.off", write_off(&mesh).as_bytes())?, mesh);
/// # Ok::<(), protomer_io::IoError>(())
/// ```
pub fn write_off(mesh: &TriangleMesh) -> String {
    let mut text = format!("OFF\n{} {} 0\n", mesh.vertices.len(), mesh.triangles.len());
    for v in &mesh.vertices {
        let _ = writeln!(text, "{} {} {}", v.x, v.y, v.z);
    }
    for [a, b, c] in &mesh.triangles {
        let _ = writeln!(text, "3 {a} {b} {c}");
    }
    text
}
