//! Solids with names: sphere, box, tetrahedron, cylinder, torus, cross.

use super::raster::filled;
use protomer_kernel::Vec3;
use protomer_kernel::random::CounterRng;

/// The solids, in alphabetical order.
pub(super) const SOLIDS: [&str; 6] = ["box", "cross", "cylinder", "sphere", "tetrahedron", "torus"];

/// Signed distance of a box with these half edges.
fn of_box(p: &Vec3, half: &Vec3) -> f64 {
    let beyond = p.abs() - half;
    beyond.map(|x| x.max(0.0)).norm() + beyond.max().min(0.0)
}

/// Signed distance of the solid number `kind` of [`SOLIDS`] that fits a ball of the radius 1;
/// `slenderness` in 0..1 varies its proportions.
fn distance(kind: usize, slenderness: f64, p: &Vec3) -> f64 {
    match SOLIDS.get(kind).copied().unwrap_or_default() {
        "box" => {
            let half = Vec3::new(1.0, 0.9 - 0.2 * slenderness, 0.8 - 0.3 * slenderness);
            of_box(p, &(half / half.norm()))
        }
        "cross" => {
            let width = 0.16 + 0.1 * slenderness;
            let long = (1.0f64 - 2.0 * width * width).sqrt();
            let arms = [
                Vec3::new(long, width, width),
                Vec3::new(width, long, width),
                Vec3::new(width, width, long),
            ];
            let distances = arms.map(|half| of_box(p, &half));
            distances[0].min(distances[1]).min(distances[2])
        }
        "cylinder" => {
            // Half height over radius from 1/2 to 3/2.
            let angle = (0.5 + slenderness).atan();
            let (radius, half_height) = (angle.cos(), angle.sin());
            let (radial, axial) = (p.xy().norm() - radius, p.z.abs() - half_height);
            radial.max(0.0).hypot(axial.max(0.0)) + radial.max(axial).min(0.0)
        }
        "sphere" => p.norm() - 1.0,
        "tetrahedron" => {
            // Faces at a third of the circumradius, opposite the corners.
            let outward = [
                [1.0, 1.0, 1.0],
                [1.0, -1.0, -1.0],
                [-1.0, 1.0, -1.0],
                [-1.0, -1.0, 1.0],
            ];
            let mut distance = f64::NEG_INFINITY;
            for [x, y, z] in outward {
                let beyond = (p.x * x + p.y * y + p.z * z) / 3f64.sqrt() - 1.0 / 3.0;
                distance = distance.max(beyond);
            }
            distance
        }
        _ => {
            let tube = 0.2 + 0.12 * slenderness;
            (p.xy().norm() - (1.0 - tube)).hypot(p.z) - tube
        }
    }
}

/// The solid number `kind` at a random size, in random proportions and turned at random.
pub(super) fn random_solid(kind: usize, size: usize, random: &mut CounterRng) -> Vec<(u32, f32)> {
    let radius = size as f64 * random.uniform_in(0.34, 0.48);
    let slenderness = random.uniform();
    let back = random.rotation().inverse();
    filled(size, |p| {
        radius * distance(kind, slenderness, &(back * p / radius))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_solid_fits_the_ball_and_touches_it() {
        let mut random = CounterRng::new(5, 0, 0);
        for (kind, name) in SOLIDS.iter().enumerate() {
            for slenderness in [0.0, 0.5, 1.0] {
                let mut farthest = 0f64;
                for _ in 0..200_000 {
                    let p = random.vector_in_ball(1.2);
                    if distance(kind, slenderness, &p) < 0.0 {
                        farthest = farthest.max(p.norm());
                    }
                }
                assert!(
                    (0.93..1.0 + 1e-9).contains(&farthest),
                    "{name} at {slenderness}: {farthest}"
                );
            }
        }
    }
}
