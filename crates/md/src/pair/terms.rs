//! Forces on points, added up to the energy of two bodies, the force between them and their torques.

use super::repulsion::Repulsion;
use protomer_kernel::Vec3;
use protomer_kernel::shape::closest::ClosestPoints;

/// What two bodies feel so far.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Terms {
    centroids: [Vec3; 2],
    /// Energy in units of ε.
    pub energy: f64,
    /// Force on the first body; that on the second is its opposite.
    pub force: Vec3,
    /// Torques about the centroids.
    pub torques: [Vec3; 2],
}

impl Terms {
    /// Nothing yet.
    pub fn about(centroids: [Vec3; 2]) -> Self {
        Self {
            centroids,
            energy: 0.0,
            force: Vec3::zeros(),
            torques: [Vec3::zeros(); 2],
        }
    }

    /// Adds a force on a point of the first body, and its opposite on a point of the second.
    pub fn push(&mut self, points: [Vec3; 2], force: Vec3) {
        self.force += force;
        self.torques[0] += (points[0] - self.centroids[0]).cross(&force);
        self.torques[1] += (points[1] - self.centroids[1]).cross(&-force);
    }

    /// Adds the repulsion of two points.
    pub fn repel(&mut self, repulsion: &Repulsion, points: &ClosestPoints) {
        let distance = points.distance();
        if distance >= repulsion.range() {
            return;
        }
        self.energy += repulsion.energy(distance);
        let force = points.separation() * (-repulsion.slope(distance) / distance);
        self.push([points.on_first, points.on_second], force);
    }
}
