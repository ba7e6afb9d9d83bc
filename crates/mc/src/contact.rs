//! Contacts between surfaces.

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

    /// Whether a vertex of this surface and one of the other, at the pose `relative`, are closer
    /// than `distance_angstrom`. With one vertex per Å² and distances of a few Å this differs from
    /// the gap between the surfaces by less than 0.1 Å.
    pub fn comes_within(
        &self,
        other: &SurfacePoints,
        relative: &RelativePose,
        distance_angstrom: f64,
    ) -> bool {
        let near = |a: &ChargeGroup, b: &ChargeGroup, centre: &Vec3| {
            let reach = a.radius_angstrom + b.radius_angstrom + distance_angstrom;
            (centre - a.centre).norm_squared() < reach * reach
                && groups_come_within(a, b, relative, distance_angstrom)
        };
        other.0.groups().iter().any(|b| {
            let centre = relative.transform_point(&b.centre);
            let reach = self.0.radius_angstrom() + b.radius_angstrom + distance_angstrom;
            centre.norm_squared() < reach * reach
                && self.0.groups().iter().any(|a| near(a, b, &centre))
        })
    }
}

impl SurfacePoints {
    /// Which vertices of this surface come closer than `distance_angstrom` to a vertex of the
    /// other: sets those marks. A mark stands for a lane of a group.
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
                            let moved = relative.transform_point(&point(b, of_b));
                            (moved - point(a, lane)).norm_squared() < squared
                        });
                }
            }
        }
    }

    /// The vertex of a mark, Å.
    pub(crate) fn of_mark(&self, mark: usize) -> Vec3 {
        point(&self.0.groups()[mark / LANES], mark % LANES)
    }

    /// The distance of the nearest vertex from the origin, Å.
    pub(crate) fn least_radius_angstrom(&self) -> f64 {
        let mut least = f64::INFINITY;
        for group in self.0.groups() {
            for lane in 0..LANES {
                least = least.min(point(group, lane).norm());
            }
        }
        least
    }
}

fn point(group: &ChargeGroup, lane: usize) -> Vec3 {
    Vec3::new(group.x[lane], group.y[lane], group.z[lane])
}

/// Empty lanes repeat the first point, so they need no special treatment.
fn groups_come_within(
    a: &ChargeGroup,
    b: &ChargeGroup,
    relative: &RelativePose,
    distance: f64,
) -> bool {
    (0..LANES).any(|lane| {
        let moved = relative.transform_point(&point(b, lane));
        (0..LANES).any(|other| (point(a, other) - moved).norm_squared() < distance * distance)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use protomer_kernel::Pose;
    use protomer_kernel::random::CounterRng;

    #[test]
    fn it_is_the_least_distance_of_all_pairs_of_vertices() {
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
            let relative = RelativePose::new(&Pose::identity(), &pose, &pose.position);
            let least = a
                .vertices
                .iter()
                .flat_map(|p| {
                    b.vertices
                        .iter()
                        .map(move |q| (p - pose.transform_point(q)).norm())
                })
                .fold(f64::INFINITY, f64::min);
            let within =
                SurfacePoints::new(&a).comes_within(&SurfacePoints::new(&b), &relative, 5.0);
            assert_eq!(within, least < 5.0);
            near += usize::from(within);
        }
        assert!((20..180).contains(&near), "{near}");
    }
}
