//! The vertices of a surface, about which bodies turn.
//!
//! Whether bodies are in contact is a question to their surfaces
//! ([`comes_within`](protomer_kernel::overlap::comes_within)). A vertex is only a place on one of them.

use crate::charges::{ChargeCloud, ChargeGroup, LANES};
use protomer_kernel::pose::RelativePose;
use protomer_kernel::{TriangleMesh, Vec3};

/// The vertices of a surface, in groups of near neighbours.
#[derive(Debug, Clone)]
pub struct SurfacePoints(ChargeCloud);

impl SurfacePoints {
    /// The vertices of this mesh.
    pub fn new(mesh: &TriangleMesh) -> Self {
        let points: Vec<(Vec3, f64)> = mesh.vertices.iter().map(|vertex| (*vertex, 1.0)).collect();
        Self(ChargeCloud::new(&points))
    }

    /// Marks the vertices of this surface that come closer than `distance_angstrom` to a vertex of
    /// the other. A mark stands for a lane of a group.
    pub(crate) fn mark_within(
        &self,
        other: &SurfacePoints,
        relative: &RelativePose,
        distance_angstrom: f64,
        marks: &mut Vec<bool>,
    ) {
        marks.resize(self.0.groups().len() * LANES, false);
        let squared = distance_angstrom.powi(2);
        for b in other.0.groups() {
            let centre = relative.transform_point(&b.centre);
            for (a, marks) in self.0.groups().iter().zip(marks.chunks_exact_mut(LANES)) {
                let reach = a.radius_angstrom + b.radius_angstrom + distance_angstrom;
                if (centre - a.centre).norm_squared() >= reach * reach {
                    continue;
                }
                for (lane, mark) in marks.iter_mut().enumerate() {
                    // Empty lanes have no charge.
                    *mark |= a.charge_e[lane] != 0.0
                        && (0..LANES).any(|of_b| {
                            let image = relative.transform_point(&point(b, of_b));
                            (image - point(a, lane)).norm_squared() < squared
                        });
                }
            }
        }
    }

    /// The vertex of a mark, Å.
    pub(crate) fn of_mark(&self, mark: usize) -> Vec3 {
        point(&self.0.groups()[mark / LANES], mark % LANES)
    }
}

fn point(group: &ChargeGroup, lane: usize) -> Vec3 {
    Vec3::new(group.x[lane], group.y[lane], group.z[lane])
}

#[cfg(test)]
mod tests {
    use super::*;
    use protomer_kernel::Pose;
    use protomer_kernel::random::CounterRng;

    #[test]
    fn marked_vertices_are_those_of_all_pairs_that_are_near() {
        let mut rng = CounterRng::new(4, 0, 0);
        let mut near = 0;
        for case in 0..200 {
            let mut cloud = |count: usize| TriangleMesh {
                vertices: (0..count).map(|_| rng.unit_vector() * 10.0).collect(),
                triangles: Vec::new(),
            };
            let (a, b) = (cloud(40 + case % 9), cloud(60 + case % 7));
            let pose = Pose {
                position: rng.unit_vector() * 24.0,
                rotation: rng.rotation(),
            };
            let relative = RelativePose::from(&pose);
            let points = SurfacePoints::new(&a);
            let mut marks = Vec::new();
            points.mark_within(&SurfacePoints::new(&b), &relative, 5.0, &mut marks);
            let mut marked: Vec<Vec3> = (0..marks.len())
                .filter(|mark| marks[*mark])
                .map(|mark| points.of_mark(mark))
                .collect();
            let mut expected = a.vertices.clone();
            expected.retain(|p| {
                let is_near = |q| (p - pose.transform_point(q)).norm() < 5.0;
                b.vertices.iter().any(is_near)
            });
            let order = |p: &Vec3, q: &Vec3| p.x.total_cmp(&q.x);
            marked.sort_by(order);
            expected.sort_by(order);
            assert_eq!(marked, expected);
            near += usize::from(!marked.is_empty());
        }
        assert!((20..180).contains(&near), "{near}");
    }
}
