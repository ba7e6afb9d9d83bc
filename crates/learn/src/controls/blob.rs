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
    /// Balls grown one on another at random, of extent 1: the farthest point lies at the distance 1
    /// from the origin.
    pub(super) fn random(random: &mut CounterRng) -> Self {
        let mut balls = vec![(Vec3::zeros(), 1.0)];
        for _ in 0..7 + random.index(6) {
            let (at, radius) = balls[random.index(balls.len())];
            let middle = at + random.unit_vector() * radius;
            balls.push((middle, random.uniform_in(0.6, 1.1)));
        }
        Self { balls }.centred().with_extent(1.0)
    }

    /// A rod along z with a rough surface, of extent 1.
    pub(super) fn rod(random: &mut CounterRng) -> Self {
        let ball = |i: i32, random: &mut CounterRng| {
            (
                Vec3::z() * (0.6 * f64::from(i)) + random.vector_in_ball(0.3),
                random.uniform_in(0.8, 1.0),
            )
        };
        let balls = (-4..=4).map(|i| ball(i, random)).collect();
        Self { balls }.centred().with_extent(1.0)
    }

    fn centred(mut self) -> Self {
        let volume: f64 = self.balls.iter().map(|(_, radius)| radius.powi(3)).sum();
        let middle = self
            .balls
            .iter()
            .map(|(middle, radius)| middle * radius.powi(3))
            .sum::<Vec3>()
            / volume;
        self.balls.iter_mut().for_each(|(at, _)| *at -= middle);
        self
    }

    /// Distance of the farthest point from the origin.
    pub(super) fn extent(&self) -> f64 {
        self.balls
            .iter()
            .map(|(middle, radius)| middle.norm() + radius)
            .fold(0.0, f64::max)
    }

    /// The same blob scaled to this extent.
    pub(super) fn with_extent(&self, extent: f64) -> Self {
        self.scaled(extent / self.extent())
    }

    /// The same blob scaled by a factor.
    pub(super) fn scaled(&self, factor: f64) -> Self {
        Self {
            balls: self
                .balls
                .iter()
                .map(|(middle, radius)| (middle * factor, radius * factor))
                .collect(),
        }
    }

    /// The same blob turned about the origin.
    pub(super) fn turned(&self, rotation: &Rotation) -> Self {
        Self {
            balls: self
                .balls
                .iter()
                .map(|(middle, radius)| (rotation * middle, *radius))
                .collect(),
        }
    }

    /// The same blob shifted.
    pub(super) fn shifted(&self, by: &Vec3) -> Self {
        Self {
            balls: self
                .balls
                .iter()
                .map(|(middle, radius)| (middle + by, *radius))
                .collect(),
        }
    }

    /// A lower bound of the distance to the surface outside, minus the depth below the nearest
    /// ball's surface inside.
    pub(super) fn distance(&self, p: &Vec3) -> f64 {
        self.balls
            .iter()
            .map(|(middle, radius)| (p - middle).norm() - radius)
            .fold(f64::INFINITY, f64::min)
    }

    /// A point inside, at least 0.4 of its ball's radius below that ball's surface.
    pub(super) fn point_inside(&self, random: &mut CounterRng) -> Vec3 {
        let (middle, radius) = self.balls[random.index(self.balls.len())];
        middle + random.vector_in_ball(0.6 * radius)
    }

    /// A point on the surface: where a ray from inside leaves the union for good.
    pub(super) fn point_on_surface(&self, direction: &Vec3) -> Vec3 {
        // |t u - m| = r at t = u.m ± sqrt((u.m)² - m² + r²); the largest root over all balls.
        let exits = self.balls.iter().filter_map(|(middle, radius)| {
            let along = direction.dot(middle);
            let inside = along * along - middle.norm_squared() + radius * radius;
            (inside >= 0.0).then(|| along + inside.sqrt())
        });
        direction * exits.fold(0.0, f64::max)
    }

    /// Radius of gyration of the balls, overlaps counted twice.
    pub(super) fn radius_of_gyration(&self) -> f64 {
        let volume: f64 = self.balls.iter().map(|(_, radius)| radius.powi(3)).sum();
        let moment: f64 = self
            .balls
            .iter()
            .map(|(m, r)| (m.norm_squared() + 0.6 * r * r) * r.powi(3))
            .sum();
        (moment / volume).sqrt()
    }

    /// Extents along the axes of its frame, largest first.
    pub(super) fn extents(&self) -> [f64; 3] {
        let mut extents = [0, 1, 2].map(|axis| {
            let high = self
                .balls
                .iter()
                .map(|(m, r)| m[axis] + r)
                .fold(f64::NEG_INFINITY, f64::max);
            let low = self
                .balls
                .iter()
                .map(|(m, r)| m[axis] - r)
                .fold(f64::INFINITY, f64::min);
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
            assert!(
                (blob.turned(&rotation).distance(&(rotation * p)) - blob.distance(&p)).abs()
                    < 1e-12
            );
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
