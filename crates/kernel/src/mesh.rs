//! Closed triangle meshes: topology and mass properties.

use crate::{KernelError, Result, Vec3};
use nalgebra::Matrix3;
use serde::{Deserialize, Serialize};
use std::collections::HashMap;

/// The largest coordinate of a body, Å: the overlap test's single-precision bounds are sharp enough
/// up to here.
pub const LARGEST_COORDINATE_ANGSTROM: f64 = 1e6;

/// A triangle mesh. A mesh that bounds a solid is closed, 2-manifold and counter-clockwise seen
/// from outside; [`TriangleMesh::topology`] checks that.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct TriangleMesh {
    /// Vertex positions, Å.
    pub vertices: Vec<Vec3>,
    /// Vertex indices of each triangle, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
}

/// What [`TriangleMesh::topology`] finds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Topology {
    /// Connected components (shells).
    pub components: usize,
    /// Euler number V - E + F, over all components.
    pub euler_number: i64,
    /// Sum of the genera of the components, (2 · components - Euler number) / 2.
    pub genus: i64,
    /// Components that enclose negative volume: cavities.
    pub cavities: usize,
}

/// Volume, centroid and second moments of the solid inside a closed mesh.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct MassProperties {
    /// Enclosed volume, Å³.
    pub volume_angstrom3: f64,
    /// Centre of the enclosed volume, Å.
    pub centroid: Vec3,
    /// Inertia tensor about the centroid at unit density, Å⁵.
    pub inertia_angstrom5: Matrix3<f64>,
}

impl TriangleMesh {
    /// The three corners of a triangle, Å.
    pub fn corners(&self, triangle: usize) -> [Vec3; 3] {
        self.triangles[triangle].map(|vertex| self.vertices[vertex as usize])
    }

    /// Surface area, Å².
    pub fn area_angstrom2(&self) -> f64 {
        (0..self.triangles.len())
            .map(|triangle| {
                let [a, b, c] = self.corners(triangle);
                0.5 * (b - a).cross(&(c - a)).norm()
            })
            .sum()
    }

    /// Enclosed volume by the divergence theorem, V = Σ a·(b × c) / 6, Å³; positive for an outward
    /// mesh.
    pub fn volume_angstrom3(&self) -> f64 {
        let origin = self.vertices.first().copied().unwrap_or_default();
        (0..self.triangles.len())
            .map(|triangle| self.signed_tetrahedron(triangle, &origin))
            .sum()
    }

    fn signed_tetrahedron(&self, triangle: usize, origin: &Vec3) -> f64 {
        let [a, b, c] = self.corners(triangle).map(|corner| corner - origin);
        a.dot(&b.cross(&c)) / 6.0
    }

    /// Volume, centroid and inertia of the enclosed solid at unit density.
    ///
    /// Each triangle spans a tetrahedron with the first vertex; with corners a, b, c and s = a +
    /// b + c its second moment is V/20 (aaᵀ + bbᵀ + ccᵀ + ssᵀ).
    ///
    /// # Errors
    /// [`KernelError::BadMesh`] if the enclosed volume is not positive.
    pub fn mass_properties(&self) -> Result<MassProperties> {
        let origin = self.vertices.first().copied().unwrap_or_default();
        let mut volume = 0.0;
        let mut first_moment = Vec3::zeros();
        let mut second_moment = Matrix3::zeros();
        for triangle in 0..self.triangles.len() {
            let [a, b, c] = self.corners(triangle).map(|corner| corner - origin);
            let s = a + b + c;
            let v = a.dot(&b.cross(&c)) / 6.0;
            volume += v;
            first_moment += s * (v / 4.0);
            let outer =
                a * a.transpose() + b * b.transpose() + c * c.transpose() + s * s.transpose();
            second_moment += outer * (v / 20.0);
        }
        if !(volume.is_finite() && volume > 0.0) {
            return Err(KernelError::BadMesh(format!(
                "it encloses {volume} Å³; the volume must be positive"
            )));
        }
        let centroid = first_moment / volume;
        let central = second_moment - centroid * centroid.transpose() * volume;
        let inertia_angstrom5 = Matrix3::identity() * central.trace() - central;
        Ok(MassProperties {
            volume_angstrom3: volume,
            centroid: centroid + origin,
            inertia_angstrom5,
        })
    }

    /// Radius of the smallest sphere about the origin that holds every vertex, Å.
    pub fn radius_about_origin_angstrom(&self) -> f64 {
        self.vertices
            .iter()
            .map(Vec3::norm_squared)
            .fold(0.0, f64::max)
            .sqrt()
    }

    /// The same mesh with every vertex moved by `transform`.
    pub fn map_vertices(&self, transform: impl Fn(&Vec3) -> Vec3) -> Self {
        Self {
            vertices: self.vertices.iter().map(transform).collect(),
            triangles: self.triangles.clone(),
        }
    }

    /// Checks that the mesh is closed and 2-manifold and counts its shells.
    ///
    /// # Errors
    /// [`KernelError::BadMesh`] names the first defect: an index out of range, a repeated corner,
    /// an edge that is not shared by exactly two triangles of opposite direction, a vertex whose
    /// triangles do not form one fan, a vertex that no triangle uses, a coordinate that is not
    /// finite or out of range, an outer shell that is inside out.
    pub fn topology(&self) -> Result<Topology> {
        self.check_indices()?;
        let neighbours = self.edge_neighbours()?;
        self.check_vertex_fans()?;
        let component_of = label_components(&neighbours);
        let components = component_of.iter().max().map_or(0, |last| last + 1);
        let mut volumes = vec![0.0; components];
        for (triangle, &component) in component_of.iter().enumerate() {
            let origin = self.vertices[self.triangles[0][0] as usize];
            volumes[component] += self.signed_tetrahedron(triangle, &origin);
        }
        let cavities = volumes.iter().filter(|volume| **volume < 0.0).count();
        if components > 0 && cavities == components {
            return Err(KernelError::BadMesh(
                "it is inside out; reverse the corner order of every triangle".into(),
            ));
        }
        let edges = self.triangles.len() as i64 * 3 / 2;
        let euler_number = self.vertices.len() as i64 - edges + self.triangles.len() as i64;
        let genus = (2 * components as i64 - euler_number) / 2;
        Ok(Topology {
            components,
            euler_number,
            genus,
            cavities,
        })
    }

    /// The connected shells of a closed mesh, each as a mesh of its own, in order of their first
    /// triangle.
    ///
    /// # Errors
    /// [`KernelError::BadMesh`] if an edge is not shared by exactly two triangles.
    pub fn shells(&self) -> Result<Vec<TriangleMesh>> {
        self.check_indices()?;
        let component_of = label_components(&self.edge_neighbours()?);
        let components = component_of.iter().max().map_or(0, |last| last + 1);
        let mut shells = vec![TriangleMesh::default(); components];
        let mut renumbered: HashMap<(usize, u32), u32> = HashMap::new();
        for (triangle, &component) in component_of.iter().enumerate() {
            let shell = &mut shells[component];
            let corners = self.triangles[triangle].map(|vertex| {
                *renumbered.entry((component, vertex)).or_insert_with(|| {
                    shell.vertices.push(self.vertices[vertex as usize]);
                    shell.vertices.len() as u32 - 1
                })
            });
            shell.triangles.push(corners);
        }
        Ok(shells)
    }

    fn check_indices(&self) -> Result<()> {
        let in_range = |x: &f64| x.abs() <= LARGEST_COORDINATE_ANGSTROM;
        if let Some(vertex) = self.vertices.iter().position(|v| !v.iter().all(in_range)) {
            return Err(KernelError::BadMesh(format!(
                "vertex {vertex} has a coordinate that is no number within {LARGEST_COORDINATE_ANGSTROM:.0} Å"
            )));
        }
        for (index, triangle) in self.triangles.iter().enumerate() {
            let [a, b, c] = *triangle;
            if triangle
                .iter()
                .any(|&vertex| vertex as usize >= self.vertices.len())
            {
                let count = self.vertices.len();
                return Err(KernelError::BadMesh(format!(
                    "triangle {index} names a vertex beyond the {count} there are"
                )));
            }
            if a == b || b == c || c == a {
                return Err(KernelError::BadMesh(format!(
                    "triangle {index} uses a vertex twice"
                )));
            }
        }
        Ok(())
    }

    /// For each triangle the triangles across its three edges.
    fn edge_neighbours(&self) -> Result<Vec<[u32; 3]>> {
        let mut triangle_of: HashMap<(u32, u32), usize> =
            HashMap::with_capacity(self.triangles.len() * 3);
        for (triangle, corners) in self.triangles.iter().enumerate() {
            for side in 0..3 {
                let edge = (corners[side], corners[(side + 1) % 3]);
                if triangle_of.insert(edge, triangle).is_some() {
                    let message = format!(
                        "edge {}-{} is used twice in the same direction",
                        edge.0, edge.1
                    );
                    return Err(KernelError::BadMesh(message));
                }
            }
        }
        let mut neighbours = vec![[0; 3]; self.triangles.len()];
        // In the order of the triangles, so that the same mesh gives the same message every time.
        for (corners, neighbours) in self.triangles.iter().zip(&mut neighbours) {
            for side in 0..3 {
                let (from, to) = (corners[side], corners[(side + 1) % 3]);
                let Some(other) = triangle_of.get(&(to, from)) else {
                    return Err(KernelError::BadMesh(format!(
                        "edge {from}-{to} has a triangle on one side only"
                    )));
                };
                neighbours[side] = *other as u32;
            }
        }
        Ok(neighbours)
    }

    /// Every vertex must be used, and its triangles must form a single closed fan.
    fn check_vertex_fans(&self) -> Result<()> {
        let mut next_around: HashMap<(u32, u32), u32> =
            HashMap::with_capacity(self.triangles.len() * 3);
        let mut first: Vec<Option<u32>> = vec![None; self.vertices.len()];
        let mut valence = vec![0usize; self.vertices.len()];
        for corners in &self.triangles {
            for side in 0..3 {
                let [centre, from, to] = [
                    corners[side],
                    corners[(side + 1) % 3],
                    corners[(side + 2) % 3],
                ];
                next_around.insert((centre, from), to);
                first[centre as usize].get_or_insert(from);
                valence[centre as usize] += 1;
            }
        }
        for (vertex, start) in first.iter().enumerate() {
            let Some(start) = *start else {
                return Err(KernelError::BadMesh(format!(
                    "vertex {vertex} belongs to no triangle"
                )));
            };
            let mut turned = 0;
            let mut current = start;
            while let Some(&next) = next_around.get(&(vertex as u32, current)) {
                turned += 1;
                current = next;
                if current == start {
                    break;
                }
            }
            if turned != valence[vertex] {
                return Err(KernelError::BadMesh(format!(
                    "vertex {vertex} joins two fans of triangles"
                )));
            }
        }
        Ok(())
    }
}

/// The component of each triangle, numbered in order of first appearance.
fn label_components(neighbours: &[[u32; 3]]) -> Vec<usize> {
    const UNSEEN: usize = usize::MAX;
    let mut component_of = vec![UNSEEN; neighbours.len()];
    let mut components = 0;
    let mut stack = Vec::new();
    for seed in 0..neighbours.len() {
        if component_of[seed] != UNSEEN {
            continue;
        }
        component_of[seed] = components;
        stack.push(seed);
        while let Some(triangle) = stack.pop() {
            for &neighbour in &neighbours[triangle] {
                if component_of[neighbour as usize] == UNSEEN {
                    component_of[neighbour as usize] = components;
                    stack.push(neighbour as usize);
                }
            }
        }
        components += 1;
    }
    component_of
}

#[cfg(test)]
mod tests {
    use super::*;

    fn unit_cube() -> TriangleMesh {
        let vertices = (0..8)
            .map(|i| Vec3::new((i & 1) as f64, (i >> 1 & 1) as f64, (i >> 2 & 1) as f64))
            .collect();
        let quads = [
            [0, 2, 3, 1],
            [4, 5, 7, 6],
            [0, 1, 5, 4],
            [2, 6, 7, 3],
            [0, 4, 6, 2],
            [1, 3, 7, 5],
        ];
        let triangles = quads
            .iter()
            .flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]])
            .collect();
        TriangleMesh {
            vertices,
            triangles,
        }
    }

    #[test]
    fn a_cube_has_the_measures_of_a_cube() {
        let cube = unit_cube();
        let properties = cube.mass_properties().unwrap();
        assert!((cube.area_angstrom2() - 6.0).abs() < 1e-12);
        assert!((properties.volume_angstrom3 - 1.0).abs() < 1e-12);
        assert!((properties.centroid - Vec3::repeat(0.5)).norm() < 1e-12);
        assert!((properties.inertia_angstrom5 - Matrix3::identity() / 6.0).norm() < 1e-12);
        let expected = Topology {
            components: 1,
            euler_number: 2,
            genus: 0,
            cavities: 0,
        };
        assert_eq!(cube.topology(), Ok(expected));
    }

    #[test]
    fn a_cavity_is_counted_and_separated() {
        let mut mesh = unit_cube().map_vertices(|v| v * 3.0 - Vec3::repeat(1.0));
        let mut inner = unit_cube();
        inner.triangles.iter_mut().for_each(|t| t.swap(0, 1));
        mesh.triangles
            .extend(inner.triangles.iter().map(|t| t.map(|v| v + 8)));
        mesh.vertices.extend(inner.vertices);
        let topology = mesh.topology().unwrap();
        assert_eq!(
            (topology.components, topology.cavities, topology.genus),
            (2, 1, 0)
        );
        let volumes: Vec<f64> = mesh
            .shells()
            .unwrap()
            .iter()
            .map(TriangleMesh::volume_angstrom3)
            .collect();
        assert!((volumes[0] - 27.0).abs() < 1e-12 && (volumes[1] + 1.0).abs() < 1e-12);
    }

    #[test]
    fn defects_are_named() {
        let mut open = unit_cube();
        open.triangles.pop();
        assert!(
            open.topology()
                .unwrap_err()
                .to_string()
                .contains("one side only")
        );
        let mut inverted = unit_cube();
        inverted.triangles.iter_mut().for_each(|t| t.swap(0, 1));
        assert!(
            inverted
                .topology()
                .unwrap_err()
                .to_string()
                .contains("inside out")
        );
        let mut unused = unit_cube();
        unused.vertices.push(Vec3::zeros());
        assert!(
            unused
                .topology()
                .unwrap_err()
                .to_string()
                .contains("no triangle")
        );
    }
}
