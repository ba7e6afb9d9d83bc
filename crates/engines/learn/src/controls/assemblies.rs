//! Rings of copies of one blob about an axis.

use super::blob::Blob;
use super::raster::filled;
use protomer_kernel::random::CounterRng;
use protomer_kernel::{Rotation, Vec3};
use std::f64::consts::{PI, TAU};

/// Numbers of copies.
pub(super) const COPIES: [usize; 5] = [1, 2, 3, 4, 6];

/// A ring of `copies` of a blob of extent 1 about z, at a distance at which neighbours touch. Each
/// is turned by 2π/copies from the one before. The ring has the extent 1 again, so that size tells
/// nothing.
pub(super) fn ring(blob: &Blob, copies: usize) -> Blob {
    let radius = match copies {
        1 => 0.0,
        _ => 0.6 / (PI / copies as f64).sin(),
    };
    let first = blob.shifted(&(Vec3::x() * radius));
    let mut balls = Vec::with_capacity(copies * first.balls.len());
    for copy in 0..copies {
        let angle = TAU * copy as f64 / copies as f64;
        let turn = Rotation::from_axis_angle(&Vec3::z_axis(), angle);
        balls.extend(first.turned(&turn).balls);
    }
    Blob { balls }.with_extent(1.0)
}

/// A ring turned at random, in a box that it fills up to a margin of one voxel.
pub(super) fn voxels(ring: &Blob, size: usize, random: &mut CounterRng) -> Vec<(u32, f32)> {
    let blob = ring
        .turned(&random.rotation())
        .scaled(size as f64 / 2.0 - 1.0);
    filled(size, |p| blob.distance(p))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ring_is_as_symmetric_as_it_says() {
        let mut random = CounterRng::new(6, 0, 0);
        let blob = Blob::random(&mut random);
        for copies in COPIES {
            let ring = ring(&blob, copies);
            assert!((ring.extent() - 1.0).abs() < 1e-12);
            let turn = Rotation::from_axis_angle(&Vec3::z_axis(), TAU / copies as f64);
            let turned = ring.turned(&turn);
            for _ in 0..100 {
                let p = random.vector_in_ball(1.2);
                let difference = ring.distance(&p) - turned.distance(&p);
                assert!(difference.abs() < 1e-9, "{copies}");
            }
        }
    }
}
