//! Blobs: unions of balls that stand for proteins.

use protomer_kernel::random::CounterRng;
use protomer_kernel::{Rotation, Vec3};

/// A union of balls about the origin.
#[derive(Debug, Clone)]
pub(super) struct Blob {
    /// Middle and radius of each ball.
    pub(super) balls: Vec<(Vec3, f64)>,
}

impl Blob {
    /// Balls grown one on another at random. The extent is 1: the farthest point lies at the
    /// distance 1 from the origin.
    pub(super) fn random(random: &mut CounterRng) -> Self {
        let mut balls = vec![(Vec3::zeros(), 1.0)];
        for _ in 0..7 + random.index(6) {
            let (centre, radius) = balls[random.index(balls.len())];
            let middle = centre + random.unit_vector() * radius;
            balls.push((middle, random.uniform_in(0.6, 1.1)));
        }
        Self { balls }.centred().with_extent(1.0)
    }

    /// A rod along z with a rough surface, of extent 1.
    pub(super) fn rod(random: &mut CounterRng) -> Self {
        let mut balls = Vec::new();
        for i in -4..=4 {
            let middle = Vec3::z() * (0.6 * f64::from(i)) + random.vector_in_ball(0.3);
            balls.push((middle, random.uniform_in(0.8, 1.0)));
        }
        Self { balls }.centred().with_extent(1.0)
    }

    fn centred(self) -> Self {
        let (mut volume, mut moment) = (0.0, Vec3::zeros());
        for (middle, radius) in &self.balls {
            volume += radius.powi(3);
            moment += middle * radius.powi(3);
        }
        let middle = moment / volume;
        self.map(|centre, radius| (centre - middle, radius))
    }

    /// The blob of the balls that `change` makes of these.
    fn map(&self, change: impl Fn(Vec3, f64) -> (Vec3, f64)) -> Self {
        let balls = self
            .balls
            .iter()
            .map(|(middle, radius)| change(*middle, *radius));
        Self {
            balls: balls.collect(),
        }
    }

    /// Distance of the farthest point from the origin.
    pub(super) fn extent(&self) -> f64 {
        let mut extent = 0.0;
        for (middle, radius) in &self.balls {
            extent = f64::max(extent, middle.norm() + radius);
        }
        extent
    }

    /// The same blob scaled to this extent.
    pub(super) fn with_extent(&self, extent: f64) -> Self {
        self.scaled(extent / self.extent())
    }

    /// The same blob scaled by a factor.
    pub(super) fn scaled(&self, factor: f64) -> Self {
        self.map(|middle, radius| (middle * factor, radius * factor))
    }

    /// The same blob turned about the origin.
    pub(super) fn turned(&self, rotation: &Rotation) -> Self {
        self.map(|middle, radius| (rotation * middle, radius))
    }

    /// The same blob shifted.
    pub(super) fn shifted(&self, by: &Vec3) -> Self {
        self.map(|middle, radius| (middle + by, radius))
    }

    /// Signed distance: outside, a lower bound of the distance to the surface; inside, the depth
    /// below the surface of the nearest ball, negative.
    pub(super) fn distance(&self, p: &Vec3) -> f64 {
        let mut distance = f64::INFINITY;
        for (middle, radius) in &self.balls {
            distance = distance.min((p - middle).norm() - radius);
        }
        distance
    }

    /// A point inside, at least 0.4 of its ball's radius below that ball's surface.
    pub(super) fn point_inside(&self, random: &mut CounterRng) -> Vec3 {
        let (middle, radius) = self.balls[random.index(self.balls.len())];
        middle + random.vector_in_ball(0.6 * radius)
    }

    /// The point on the surface where a ray from the origin leaves the union for good.
    pub(super) fn point_on_surface(&self, direction: &Vec3) -> Vec3 {
        // |t u - m| = r at t = u.m ± sqrt((u.m)² - m² + r²); the largest root over all balls.
        let mut farthest = 0.0;
        for (middle, radius) in &self.balls {
            let projection = direction.dot(middle);
            let square = projection * projection - middle.norm_squared() + radius * radius;
            if square >= 0.0 {
                farthest = f64::max(farthest, projection + square.sqrt());
            }
        }
        direction * farthest
    }

    /// Radius of gyration of the balls, overlaps counted twice.
    pub(super) fn radius_of_gyration(&self) -> f64 {
        let (mut volume, mut moment) = (0.0, 0.0);
        for (middle, radius) in &self.balls {
            volume += radius.powi(3);
            moment += (middle.norm_squared() + 0.6 * radius * radius) * radius.powi(3);
        }
        (moment / volume).sqrt()
    }

    /// Extents along the axes of its frame, largest first.
    pub(super) fn extents(&self) -> [f64; 3] {
        let mut extents = [0, 1, 2].map(|axis| {
            let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
            for (middle, radius) in &self.balls {
                low = low.min(middle[axis] - radius);
                high = high.max(middle[axis] + radius);
            }
            high - low
        });
        extents.sort_by(|a, b| b.total_cmp(a));
        extents
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_lie_where_they_should() {
        let mut random = CounterRng::new(1, 0, 0);
        for _ in 0..50 {
            let blob = Blob::random(&mut random);
            assert!((blob.extent() - 1.0).abs() < 1e-12);
            assert!(blob.distance(&blob.point_inside(&mut random)) < 0.0);
            let direction = random.unit_vector();
            assert!(blob.distance(&blob.point_on_surface(&direction)).abs() < 1e-9);
            let rotation = random.rotation();
            let p = random.vector_in_ball(1.5);
            let turned = blob.turned(&rotation).distance(&(rotation * p));
            assert!((turned - blob.distance(&p)).abs() < 1e-12);
        }
    }

    #[test]
    fn a_rod_is_longest_along_z() {
        let mut random = CounterRng::new(2, 0, 0);
        let rod = Blob::rod(&mut random);
        let along = rod.point_on_surface(&Vec3::z()).norm();
        let across = rod.point_on_surface(&Vec3::x()).norm();
        assert!(along > 2.0 * across, "{along} {across}");
    }
}
