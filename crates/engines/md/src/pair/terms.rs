//! Forces on points, added up to the energy of two bodies, the force between them and their torques.

use super::radial::Radial;
use protomer_kernel::Vec3;
use protomer_kernel::shape::closest::ClosestPoints;

/// Sum of the terms of two bodies so far.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Terms {
    centroids: [Vec3; 2],
    /// The energy of two points.
    pub radial: Radial,
    /// Sum of the radii by which the two bodies are rounded: points are nearer by as much.
    pub radii: f64,
    /// Energy in units of ε.
    pub energy: f64,
    /// Force on the first body; that on the second is its opposite.
    pub force: Vec3,
    /// Torques about the centroids.
    pub torques: [Vec3; 2],
}

impl Terms {
    /// An empty sum.
    pub fn about(centroids: [Vec3; 2], radial: Radial, radii: f64) -> Self {
        Self {
            centroids,
            radial,
            radii,
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

    /// Adds the energy and the force of two points.
    pub fn repel(&mut self, points: &ClosestPoints) {
        let separation = points.separation();
        let distance = separation.norm();
        let x = distance - self.radii;
        if x >= self.radial.range() {
            return;
        }
        let [energy, slope] = self.radial.energy_and_slope(x);
        self.energy += energy;
        let force = separation * (-slope / distance);
        self.push([points.on_first, points.on_second], force);
    }
}
