//! Object File Format (Geomview): `OFF`, counts of vertices, faces and edges, then one vertex or
//! face per line.

use super::MeshBuilder;
use crate::text::{self, Line};
use crate::{IoError, Result, mesh::TriangleMesh};
use std::fmt::Write;

/// Reads an OFF file (also `COFF`, `NOFF` and `STOFF`, of which only positions are kept); polygons
/// are triangulated.
///
/// # Errors
/// [`IoError::Parse`] names the line.
pub fn read_off(name: &str, bytes: &[u8]) -> Result<TriangleMesh> {
    let text = text::decode(name, bytes)?;
    let mut lines = Line::significant(name, &text);
    let cut = || {
        IoError::parse(
            name,
            0,
            "the file ends before all its faces",
            "it is cut: make it again",
        )
    };
    let (vertices, faces) = counts(&mut lines)?.ok_or_else(cut)?;
    let mut builder = MeshBuilder::new(name);
    // Counts only steer the loops: each turn takes a line, so a lying header runs out of lines, not
    // of memory.
    for _ in 0..vertices {
        let line = lines.next().ok_or_else(cut)?;
        builder.add_vertex(
            line.number,
            line.point(&mut line.text.split_whitespace(), "a vertex")?,
        )?;
    }
    for _ in 0..faces {
        let line = lines.next().ok_or_else(cut)?;
        let mut tokens = line.text.split_whitespace();
        let stated = line.integer(tokens.next(), "the number of corners")?;
        let corners = tokens
            .take(usize::try_from(stated).unwrap_or(0))
            .map(|token| line.integer(Some(token), "a vertex index"))
            .collect::<Result<Vec<_>>>()?;
        if corners.len() as i64 != stated {
            let cause = format!("a face has {} of its {stated} corners", corners.len());
            return Err(line.error(cause, "complete the line"));
        }
        builder.add_polygon(line.number, &corners)?;
    }
    builder.finish()
}

/// The counts of vertices and faces, on the line of the keyword or on the next one.
fn counts<'a>(lines: &mut impl Iterator<Item = Line<'a>>) -> Result<Option<(i64, i64)>> {
    let Some(mut line) = lines.next() else {
        return Ok(None);
    };
    let mut tokens = line.text.split_whitespace().peekable();
    match tokens.peek() {
        Some(&("OFF" | "COFF" | "NOFF" | "CNOFF" | "STOFF")) => {
            tokens.next();
        }
        Some(keyword) if keyword.ends_with("OFF") => {
            return Err(line.error(
                format!(
                    "{} is not a surface in three dimensions",
                    text::shown(keyword)
                ),
                "write an OFF file",
            ));
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
