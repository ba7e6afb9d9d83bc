//! Polygons collected into a triangle mesh.

use super::polygon;
use crate::{IoError, Result};
use protomer_kernel::{TriangleMesh, Vec3};

/// Collects polygons into triangles, refusing faces that refer to vertices that do not exist.
pub(super) struct MeshBuilder<'a> {
    file: &'a str,
    mesh: TriangleMesh,
}

/// Polygons with more corners than this are refused: no surface program writes them, and they are
/// slow to triangulate.
const MOST_CORNERS: usize = 256;

impl<'a> MeshBuilder<'a> {
    pub(super) fn new(file: &'a str) -> Self {
        Self {
            file,
            mesh: TriangleMesh::default(),
        }
    }

    /// Vertices added so far.
    pub(super) fn vertices(&self) -> usize {
        self.mesh.vertices.len()
    }

    pub(super) fn add_vertex(&mut self, line: usize, position: Vec3) -> Result<()> {
        let count = self.vertices();
        // The largest number stands for "none" elsewhere.
        if count >= u32::MAX as usize {
            return Err(self.error(line, "more vertices than 2^32", "give a coarser mesh"));
        }
        if !position.iter().all(|coordinate| coordinate.is_finite()) {
            let cause = format!("vertex {count} has a coordinate that is not finite");
            return Err(self.error(line, &cause, "make the mesh again"));
        }
        self.mesh.vertices.push(position);
        Ok(())
    }

    /// Adds a face with these corners (counted from zero), triangulated. All vertices must have
    /// been added.
    pub(super) fn add_polygon(&mut self, line: usize, corners: &[i64]) -> Result<()> {
        if corners.len() < 3 || corners.len() > MOST_CORNERS {
            let cause = format!("a face has {} corners", corners.len());
            let remedy = format!("faces need 3 to {MOST_CORNERS} corners: triangulate the mesh");
            return Err(self.error(line, &cause, &remedy));
        }
        let count = self.vertices();
        let mut indices = Vec::with_capacity(corners.len());
        for &corner in corners {
            // Negative and too large alike: one conversion refuses both.
            match u32::try_from(corner) {
                Ok(index) if (index as usize) < count => indices.push(index),
                _ => {
                    let cause = format!(
                        "a face refers to vertex {corner} (counted from zero), but there are {count}"
                    );
                    let remedy = "the file is damaged or truncated: make it again";
                    return Err(self.error(line, &cause, remedy));
                }
            }
        }
        polygon::triangulate(&self.mesh.vertices, &indices, &mut self.mesh.triangles);
        Ok(())
    }

    pub(super) fn finish(self) -> Result<TriangleMesh> {
        if self.mesh.triangles.is_empty() {
            let remedy = "give a surface mesh, not a point cloud";
            return Err(self.error(0, "the file holds no faces", remedy));
        }
        Ok(self.mesh)
    }

    fn error(&self, line: usize, cause: &str, remedy: &str) -> IoError {
        IoError::parse(self.file, line, cause, remedy)
    }
}
