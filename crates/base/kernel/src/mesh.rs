//! Closed triangle meshes: topology and mass properties.

use crate::{KernelError, Result, Vec3};
use nalgebra::Matrix3;
use serde::{Deserialize, Serialize};
use std::collections::HashMap;

/// The largest coordinate of a body, Å: up to here the single-precision bounds of the overlap test
/// are sharp enough.
pub const LARGEST_COORDINATE_ANGSTROM: f64 = 1e6;

/// A triangle mesh. A mesh that bounds a solid is closed, 2-manifold and counter-clockwise seen
/// from outside; [`TriangleMesh::topology`] checks that.
///
/// ```
/// use protomer_kernel::{TriangleMesh, Vec3};
/// let tetrahedron = TriangleMesh {
///     vertices: vec![Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::z()],
///     triangles: vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
/// };
/// let topology = tetrahedron.topology()?;
/// assert_eq!((topology.components, topology.genus), (1, 0));
/// assert!((tetrahedron.volume_angstrom3() - 1.0 / 6.0).abs() < 1e-15);
/// # Ok::<(), protomer_kernel::KernelError>(())
/// ```
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct TriangleMesh {
    /// Vertex positions, Å.
    pub vertices: Vec<Vec3>,
    /// Vertex indices of each triangle, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
}

/// Topology of a closed mesh, found by [`TriangleMesh::topology`].
///
/// ```
/// use protomer_kernel::{TriangleMesh, Vec3};
/// let cube = TriangleMesh::cuboid(&Vec3::zeros(), &Vec3::repeat(1.0)).topology()?;
/// // 8 vertices, 18 edges, 12 triangles
/// assert_eq!((cube.euler_number, cube.genus, cube.cavities), (8 - 18 + 12, 0, 0));
/// # Ok::<(), protomer_kernel::KernelError>(())
/// ```
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
///
/// ```
/// use protomer_kernel::{TriangleMesh, Vec3};
/// let cube = TriangleMesh::cuboid(&Vec3::zeros(), &Vec3::repeat(2.0)).mass_properties()?;
/// assert!((cube.centroid - Vec3::repeat(1.0)).norm() < 1e-12);
/// // m a²/6 about each axis
/// assert!((cube.inertia_angstrom5[(0, 0)] - 8.0 * 4.0 / 6.0).abs() < 1e-12);
/// # Ok::<(), protomer_kernel::KernelError>(())
/// ```
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
    /// A cuboid between its lowest and its highest corner, Å, with two triangles to a face.
    ///
    /// ```
    /// use protomer_kernel::{TriangleMesh, Vec3};
    /// let cuboid = TriangleMesh::cuboid(&Vec3::zeros(), &Vec3::new(1.0, 2.0, 3.0));
    /// assert!((cuboid.volume_angstrom3() - 6.0).abs() < 1e-12);
    /// ```
    pub fn cuboid(low: &Vec3, high: &Vec3) -> Self {
        let corner = |number: usize| Vec3::from_fn(|axis, _| [low, high][number >> axis & 1][axis]);
        let faces = [
            [0, 2, 3, 1],
            [4, 5, 7, 6],
            [0, 1, 5, 4],
            [2, 6, 7, 3],
            [0, 4, 6, 2],
            [1, 3, 7, 5],
        ];
        let halves = |[a, b, c, d]: [u32; 4]| [[a, b, c], [a, c, d]];
        Self {
            vertices: (0..8).map(corner).collect(),
            triangles: faces.into_iter().flat_map(halves).collect(),
        }
    }

    /// A regular tetrahedron about the origin with corners (±reach, ±reach, ±reach), Å.
    ///
    /// ```
    /// use protomer_kernel::TriangleMesh;
    /// let volume = TriangleMesh::tetrahedron(1.0).volume_angstrom3();
    /// assert!((volume - 8.0 / 3.0).abs() < 1e-12);
    /// ```
    pub fn tetrahedron(reach: f64) -> Self {
        let corners = [[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]];
        Self {
            vertices: corners
                .map(|corner| reach * Vec3::from(corner.map(f64::from)))
                .to_vec(),
            triangles: vec![[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]],
        }
    }

    /// A regular octahedron about the origin with corners on the axes, Å.
    ///
    /// ```
    /// use protomer_kernel::TriangleMesh;
    /// let volume = TriangleMesh::octahedron(1.0).volume_angstrom3();
    /// assert!((volume - 4.0 / 3.0).abs() < 1e-12);
    /// ```
    pub fn octahedron(reach: f64) -> Self {
        let axes = [Vec3::x(), Vec3::y(), Vec3::z()].map(|axis| reach * axis);
        let above = [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4]];
        let below = [[2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]];
        Self {
            vertices: axes.iter().flat_map(|corner| [*corner, -corner]).collect(),
            triangles: [above, below].concat(),
        }
    }

    /// The three corners of a triangle, Å.
    ///
    /// ```
    /// use protomer_kernel::{TriangleMesh, Vec3};
    /// let mesh = TriangleMesh {
    ///     vertices: vec![Vec3::zeros(), Vec3::x(), Vec3::y()],
    ///     triangles: vec![[1, 2, 0]],
    /// };
    /// assert_eq!(mesh.corners(0), [Vec3::x(), Vec3::y(), Vec3::zeros()]);
    /// ```
    pub fn corners(&self, triangle: usize) -> [Vec3; 3] {
        self.triangles[triangle].map(|vertex| self.vertices[vertex as usize])
    }

    /// The corners of all triangles, Å.
    fn all_corners(&self) -> impl Iterator<Item = [Vec3; 3]> + '_ {
        (0..self.triangles.len()).map(|triangle| self.corners(triangle))
    }

    /// Surface area, Å².
    ///
    /// ```
    /// use protomer_kernel::{TriangleMesh, Vec3};
    /// let cuboid = TriangleMesh::cuboid(&Vec3::zeros(), &Vec3::new(1.0, 2.0, 3.0));
    /// assert!((cuboid.area_angstrom2() - 22.0).abs() < 1e-12);
    /// ```
    pub fn area_angstrom2(&self) -> f64 {
        let area = |[a, b, c]: [Vec3; 3]| 0.5 * (b - a).cross(&(c - a)).norm();
        self.all_corners().map(area).sum()
    }

    /// Enclosed volume by the divergence theorem, V = Σ a·(b × c) / 6, Å³; positive for an outward
    /// mesh.
    ///
    /// ```
    /// use protomer_kernel::{TriangleMesh, Vec3};
    /// let mut cube = TriangleMesh::cuboid(&Vec3::zeros(), &Vec3::repeat(2.0));
    /// assert!((cube.volume_angstrom3() - 8.0).abs() < 1e-12);
    /// cube.triangles.iter_mut().for_each(|triangle| triangle.reverse());
    /// assert!((cube.volume_angstrom3() + 8.0).abs() < 1e-12, "its faces now look inwards");
    /// ```
    pub fn volume_angstrom3(&self) -> f64 {
        let origin = self.vertices.first().copied().unwrap_or_default();
        let volume = |corners: [Vec3; 3]| signed_tetrahedron(&corners, &origin);
        self.all_corners().map(volume).sum()
    }

    /// Volume, centroid and inertia of the enclosed solid at unit density.
    ///
    /// Each triangle spans a tetrahedron with the first vertex; with corners a, b, c and s = a +
    /// b + c its second moment is V/20 (aaᵀ + bbᵀ + ccᵀ + ssᵀ).
    ///
    /// ```
    /// use protomer_kernel::{TriangleMesh, Vec3};
    /// let tetrahedron = TriangleMesh {
    ///     vertices: vec![Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::z()],
    ///     triangles: vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
    /// };
    /// let centroid = tetrahedron.mass_properties()?.centroid;
    /// assert!((centroid - Vec3::repeat(0.25)).norm() < 1e-15);
    /// # Ok::<(), protomer_kernel::KernelError>(())
    /// ```
    ///
    /// # Errors
    /// [`KernelError::BadMesh`] if the enclosed volume is not positive.
    pub fn mass_properties(&self) -> Result<MassProperties> {
        // About the first vertex: far from the origin the terms would cancel.
        let origin = self.vertices.first().copied().unwrap_or_default();
        let mut volume = 0.0;
        let mut first_moment = Vec3::zeros();
        let mut second_moment = Matrix3::zeros();
        for corners in self.all_corners() {
            let [a, b, c] = corners.map(|corner| corner - origin);
            let s = a + b + c;
            let v = a.dot(&b.cross(&c)) / 6.0;
            volume += v;
            first_moment += s * (v / 4.0);
            let outer =
                a * a.transpose() + b * b.transpose() + c * c.transpose() + s * s.transpose();
            second_moment += outer * (v / 20.0);
        }
        if !(volume.is_finite() && volume > 0.0) {
            return bad_mesh(format!(
                "it encloses {volume} Å³; the volume must be positive"
            ));
        }
        let centroid = first_moment / volume;
        // The parallel axis theorem takes the moments to the centroid.
        let central = second_moment - centroid * centroid.transpose() * volume;
        Ok(MassProperties {
            volume_angstrom3: volume,
            centroid: centroid + origin,
            // Inertia from second moments: I = tr(M) 1 - M.
            inertia_angstrom5: Matrix3::identity() * central.trace() - central,
        })
    }

    /// Radius of the smallest sphere about the origin that holds every vertex, Å.
    ///
    /// ```
    /// use protomer_kernel::{TriangleMesh, Vec3};
    /// let cuboid = TriangleMesh::cuboid(&Vec3::zeros(), &Vec3::new(3.0, 4.0, 0.0));
    /// assert_eq!(cuboid.radius_about_origin_angstrom(), 5.0);
    /// ```
    pub fn radius_about_origin_angstrom(&self) -> f64 {
        let squares = self.vertices.iter().map(Vec3::norm_squared);
        squares.fold(0.0, f64::max).sqrt()
    }

    /// The same mesh with every vertex moved by `transform`.
    ///
    /// ```
    /// use protomer_kernel::{Pose, TriangleMesh, Vec3};
    /// let point = TriangleMesh { vertices: vec![Vec3::x()], triangles: Vec::new() };
    /// let pose = Pose { position: Vec3::x(), ..Pose::identity() };
    /// let moved = point.map_vertices(|vertex| pose.transform_point(vertex));
    /// assert_eq!(moved.vertices, [Vec3::new(2.0, 0.0, 0.0)]);
    /// ```
    pub fn map_vertices(&self, transform: impl Fn(&Vec3) -> Vec3) -> Self {
        Self {
            vertices: self.vertices.iter().map(transform).collect(),
            triangles: self.triangles.clone(),
        }
    }

    /// Checks that the mesh is closed and 2-manifold and counts its shells.
    ///
    /// ```
    /// use protomer_kernel::{TriangleMesh, Vec3};
    /// let mut cube = TriangleMesh::cuboid(&Vec3::zeros(), &Vec3::repeat(1.0));
    /// assert!(cube.topology().is_ok());
    /// cube.triangles.pop();
    /// assert!(cube.topology().is_err(), "it has a hole");
    /// ```
    ///
    /// # Errors
    /// [`KernelError::BadMesh`] names the first defect: an index out of range, a repeated corner,
    /// an edge that is not shared by exactly two triangles of opposite direction, a vertex whose
    /// triangles do not form one fan, a vertex that no triangle uses, a coordinate that is not
    /// finite or out of range, an outer shell that is inside out.
    pub fn topology(&self) -> Result<Topology> {
        self.check_coordinates()?;
        self.check_triangles()?;
        let fans = Fans::new(self);
        let neighbours = self.edge_neighbours(&fans)?;
        self.check_vertex_fans(&fans)?;
        let (component_of, components) = label_components(&neighbours);
        let mut volumes = vec![0.0; components];
        for (corners, component) in self.all_corners().zip(component_of) {
            // Relative to a vertex of the mesh, as far coordinates would cost digits.
            let origin = self.vertices[self.triangles[0][0] as usize];
            volumes[component] += signed_tetrahedron(&corners, &origin);
        }
        // A shell of negative volume is the wall of a cavity; if all are, the mesh is inside out.
        let cavities = volumes.iter().filter(|volume| **volume < 0.0).count();
        if components > 0 && cavities == components {
            return bad_mesh("it is inside out; reverse the corner order of every triangle");
        }
        // Each edge belongs to two triangles: E = 3 F/2.
        let edges = self.triangles.len() as i64 * 3 / 2;
        let euler_number = self.vertices.len() as i64 - edges + self.triangles.len() as i64;
        Ok(Topology {
            components,
            euler_number,
            genus: (2 * components as i64 - euler_number) / 2,
            cavities,
        })
    }

    /// The connected shells of a closed mesh, each as a separate mesh, in the order of their first
    /// triangle.
    ///
    /// ```
    /// use protomer_kernel::{TriangleMesh, Vec3};
    /// let mut mesh = TriangleMesh::cuboid(&Vec3::zeros(), &Vec3::repeat(1.0));
    /// let other = TriangleMesh::cuboid(&Vec3::repeat(5.0), &Vec3::repeat(7.0));
    /// mesh.triangles.extend(other.triangles.iter().map(|corners| corners.map(|corner| corner + 8)));
    /// mesh.vertices.extend(&other.vertices);
    /// let volumes: Vec<f64> = mesh.shells()?.iter().map(TriangleMesh::volume_angstrom3).collect();
    /// assert!((volumes[0] - 1.0).abs() < 1e-12 && (volumes[1] - 8.0).abs() < 1e-12);
    /// # Ok::<(), protomer_kernel::KernelError>(())
    /// ```
    ///
    /// # Errors
    /// [`KernelError::BadMesh`] if an edge is not shared by exactly two triangles.
    pub fn shells(&self) -> Result<Vec<TriangleMesh>> {
        self.check_coordinates()?;
        self.check_triangles()?;
        let (component_of, components) = label_components(&self.edge_neighbours(&Fans::new(self))?);
        let mut shells = vec![TriangleMesh::default(); components];
        let mut renumbered: HashMap<(usize, u32), u32> = HashMap::new();
        for (triangle, component) in self.triangles.iter().zip(component_of) {
            let shell = &mut shells[component];
            let mut corners = *triangle;
            for corner in &mut corners {
                let next = shell.vertices.len() as u32;
                // Each component has a copy of its own of a vertex in which it touches another.
                let number = *renumbered.entry((component, *corner)).or_insert(next);
                if number == next {
                    shell.vertices.push(self.vertices[*corner as usize]);
                }
                *corner = number;
            }
            shell.triangles.push(corners);
        }
        Ok(shells)
    }

    fn check_coordinates(&self) -> Result<()> {
        for (index, vertex) in self.vertices.iter().enumerate() {
            let in_range = vertex
                .iter()
                // NaN fails the comparison, which is why it is not written as "greater than".
                .all(|x| x.abs() <= LARGEST_COORDINATE_ANGSTROM);
            if !in_range {
                return bad_mesh(format!(
                    "vertex {index} has a coordinate that is not a number within \
                     {LARGEST_COORDINATE_ANGSTROM:.0} Å"
                ));
            }
        }
        Ok(())
    }

    fn check_triangles(&self) -> Result<()> {
        let count = self.vertices.len();
        for (index, [a, b, c]) in self.triangles.iter().enumerate() {
            if *a.max(b).max(c) as usize >= count {
                return bad_mesh(format!(
                    "triangle {index} names a vertex beyond the {count} there are"
                ));
            }
            if a == b || b == c || c == a {
                return bad_mesh(format!("triangle {index} uses a vertex twice"));
            }
        }
        Ok(())
    }

    /// Finds, for each triangle, the triangles across its three edges.
    fn edge_neighbours(&self, fans: &Fans) -> Result<Vec<[u32; 3]>> {
        for (triangle, corners) in (0..).zip(&self.triangles) {
            for (from, to) in edges(corners) {
                if fans
                    .edge(from, to)
                    // `edge` finds the first triangle with this
                    // directed edge; another one has it twice.
                    .is_some_and(|edge| edge.triangle != triangle)
                {
                    return bad_mesh(format!(
                        "edge {from}-{to} is used twice in the same direction"
                    ));
                }
            }
        }
        let mut neighbours = Vec::with_capacity(self.triangles.len());
        // In the order of the triangles, so that the same mesh gives the same message every time.
        for corners in &self.triangles {
            let mut adjacent = [0; 3];
            for (neighbour, (from, to)) in adjacent.iter_mut().zip(edges(corners)) {
                match fans.edge(to, from) {
                    Some(other) => *neighbour = other.triangle,
                    None => {
                        return bad_mesh(format!(
                            "edge {from}-{to} has a triangle on one side only"
                        ));
                    }
                }
            }
            neighbours.push(adjacent);
        }
        Ok(neighbours)
    }

    /// Checks that every vertex is used and that its triangles form a single closed fan.
    fn check_vertex_fans(&self, fans: &Fans) -> Result<()> {
        for vertex in 0..self.vertices.len() as u32 {
            let fan = fans.leaving(vertex);
            if fan.is_empty() {
                return bad_mesh(format!("vertex {vertex} belongs to no triangle"));
            }
            // A fan that closes early leaves triangles over: the vertex joins two sheets.
            if fans.turn(vertex) != fan.len() {
                return bad_mesh(format!("vertex {vertex} joins two fans of triangles"));
            }
        }
        Ok(())
    }
}

/// The edges that leave each vertex.
struct Fans {
    /// Start of the edges of each vertex: those of vertex v are `leaving[start[v]..start[v + 1]]`,
    /// sorted by the vertex they lead to and then by triangle.
    start: Vec<u32>,
    leaving: Vec<Leaving>,
}

/// An edge of a triangle, seen from its start.
#[derive(Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord)]
struct Leaving {
    to: u32,
    triangle: u32,
    /// The third corner.
    apex: u32,
}

impl Fans {
    /// The fans of a mesh whose triangles name existing vertices only.
    fn new(mesh: &TriangleMesh) -> Self {
        // Counting sort by the vertex at which an edge starts: one array, no list per vertex.
        let mut start = vec![0; mesh.vertices.len() + 1];
        for vertex in mesh.triangles.as_flattened() {
            start[*vertex as usize + 1] += 1;
        }
        for vertex in 0..mesh.vertices.len() {
            start[vertex + 1] += start[vertex];
        }
        let mut filled = start.clone();
        let mut leaving = vec![Leaving::default(); 3 * mesh.triangles.len()];
        for (triangle, &[a, b, c]) in (0..).zip(&mesh.triangles) {
            for (from, to, apex) in [(a, b, c), (b, c, a), (c, a, b)] {
                let place = &mut filled[from as usize];
                leaving[*place as usize] = Leaving { to, triangle, apex };
                *place += 1;
            }
        }
        for ends in start.windows(2) {
            // Sorted, so `edge` finds by bisection what a hash map would need memory for.
            leaving[ends[0] as usize..ends[1] as usize].sort_unstable();
        }
        Self { start, leaving }
    }

    fn leaving(&self, vertex: u32) -> &[Leaving] {
        let [first, end] = [vertex, vertex + 1].map(|v| self.start[v as usize] as usize);
        &self.leaving[first..end]
    }

    /// The edge between two vertices in this direction, of the first triangle that has it.
    fn edge(&self, from: u32, to: u32) -> Option<&Leaving> {
        let fan = self.leaving(from);
        let place = fan.partition_point(|edge| edge.to < to);
        fan.get(place).filter(|edge| edge.to == to)
    }

    /// Number of triangles around a vertex that follow one another from its first edge.
    fn turn(&self, vertex: u32) -> usize {
        let mut length = 0;
        let mut current = self.leaving(vertex).first();
        let first = current.map(|edge| edge.to);
        while let Some(edge) = current {
            // A closed mesh leads back to the first edge; `edge` ends the walk where it does not.
            length += 1;
            if Some(edge.apex) == first {
                break;
            }
            current = self.edge(vertex, edge.apex);
        }
        length
    }
}

/// Volume of the tetrahedron that a triangle spans with an origin, Å³; positive if the triangle is
/// counter-clockwise seen from the far side.
fn signed_tetrahedron(corners: &[Vec3; 3], origin: &Vec3) -> f64 {
    let [a, b, c] = corners.map(|corner| corner - origin);
    a.dot(&b.cross(&c)) / 6.0
}

/// The directed edges of a triangle.
fn edges([a, b, c]: &[u32; 3]) -> [(u32, u32); 3] {
    [(*a, *b), (*b, *c), (*c, *a)]
}

/// The component of each triangle, numbered in the order of first appearance, and how many there
/// are.
fn label_components(neighbours: &[[u32; 3]]) -> (Vec<usize>, usize) {
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
        // A stack, not recursion: a shell has as many triangles as it likes.
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
    (component_of, components)
}

/// The error that names a defect.
fn bad_mesh<T>(defect: impl Into<String>) -> Result<T> {
    Err(KernelError::BadMesh(defect.into()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn unit_cube() -> TriangleMesh {
        TriangleMesh::cuboid(&Vec3::zeros(), &Vec3::repeat(1.0))
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
        let shells = mesh.shells().unwrap();
        assert!((shells[0].volume_angstrom3() - 27.0).abs() < 1e-12);
        assert!((shells[1].volume_angstrom3() + 1.0).abs() < 1e-12);
    }

    #[test]
    fn defects_are_named() {
        let mut open = unit_cube();
        open.triangles.pop();
        let mut inverted = unit_cube();
        inverted.triangles.iter_mut().for_each(|t| t.swap(0, 1));
        let mut unused = unit_cube();
        unused.vertices.push(Vec3::zeros());
        let mut beyond = unit_cube();
        beyond.triangles[0][0] = 8;
        let mut far = unit_cube();
        far.vertices[3].x = f64::NAN;
        // Two cubes that share a corner.
        let mut joined = unit_cube();
        let other = unit_cube().map_vertices(|v| v + Vec3::repeat(1.0));
        let renumbered = |v: u32| if v == 0 { 7 } else { v + 7 };
        joined.vertices.extend(&other.vertices[1..]);
        joined
            .triangles
            .extend(other.triangles.iter().map(|t| t.map(renumbered)));
        for (mesh, defect) in [
            (open, "one side only"),
            (inverted, "inside out"),
            (unused, "no triangle"),
            (beyond, "beyond the 8"),
            (far, "not a number"),
            (joined, "two fans"),
        ] {
            let message = mesh.topology().unwrap_err().to_string();
            assert!(message.contains(defect), "{message}");
        }
    }
}
