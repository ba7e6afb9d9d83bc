//! Solids on a grid of voxels, from their signed distance.

use protomer_kernel::Vec3;

/// The middle of each voxel of a grid of `size` voxels along each edge, in voxels from the middle
/// of the grid, with the index (z size + y) size + x.
fn middles(size: usize) -> impl Iterator<Item = (u32, Vec3)> {
    let place = move |i: usize| i as f64 + 0.5 - size as f64 / 2.0;
    (0..size.pow(3)).map(move |index| {
        let (x, y, z) = (index % size, index / size % size, index / (size * size));
        (index as u32, Vec3::new(place(x), place(y), place(z)))
    })
}

/// The share of each voxel that a solid fills, where it fills any: clamp(1/2 - d, 0, 1) at the
/// signed distance d of the middle, which is exact for a plane along the grid.
///
/// `distance`: signed distance in voxels, negative inside.
pub(super) fn filled(size: usize, distance: impl Fn(&Vec3) -> f64) -> Vec<(u32, f32)> {
    let mut voxels = Vec::new();
    for (index, middle) in middles(size) {
        let share = (0.5 - distance(&middle)).clamp(0.0, 1.0);
        if share > 0.0 {
            voxels.push((index, share as f32));
        }
    }
    voxels
}

/// The volume of filled voxels, in voxels.
pub(super) fn volume(voxels: &[(u32, f32)]) -> f64 {
    voxels.iter().map(|(_, share)| f64::from(*share)).sum()
}

/// The voxels whose middle lies within `half_width` voxels of the surface of a solid, with that
/// middle.
pub(super) fn shell(
    size: usize,
    half_width: f64,
    distance: impl Fn(&Vec3) -> f64,
) -> Vec<(u32, Vec3)> {
    let mut voxels: Vec<(u32, Vec3)> = middles(size).collect();
    voxels.retain(|(_, middle)| distance(middle).abs() <= half_width);
    voxels
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    #[test]
    fn a_ball_has_its_volume_and_its_shell() {
        let ball = |p: &Vec3| p.norm() - 6.0;
        let found = volume(&filled(16, ball)) / (4.0 / 3.0 * PI * 216.0);
        assert!((found - 1.0).abs() < 0.02, "{found}");
        // A shell of the thickness 1 has the volume of its surface and a little more, 4π (r² +
        // 1/12), on the average over places of the ball.
        let mut voxels = 0;
        for i in 0..64 {
            let place = [i & 3, i >> 2 & 3, i >> 4].map(|x| f64::from(x) / 4.0);
            let shift = Vec3::from(place);
            voxels += shell(16, 0.5, |p| ball(&(p - shift))).len();
        }
        let found = voxels as f64 / 64.0 / (4.0 * PI * (36.0 + 1.0 / 12.0));
        assert!((found - 1.0).abs() < 0.01, "{found}");
    }

    #[test]
    fn indices_run_along_x_first() {
        let half = filled(4, |p| p.x);
        assert!(half.iter().all(|(index, _)| index % 4 < 2) && half.len() == 32);
        let half = filled(4, |p| p.z);
        assert!(half.iter().all(|(index, _)| *index < 32) && half.len() == 32);
    }
}
