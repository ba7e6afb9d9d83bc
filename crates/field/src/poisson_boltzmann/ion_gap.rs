//! How far a point is from what ions cannot enter.

use crate::charged_sphere::ChargedSphere;
use crate::grid::Grid;
use protomer_kernel::Vec3;
use rayon::prelude::*;
use std::ops::Range;

/// How far the points of a grid are from what ions cannot enter: the spheres grown by the radius of
/// ions.
pub(super) struct IonGap {
    /// The distance of every point, Å. It is exact up to a spacing; farther out it is at least that.
    pub angstrom: Vec<f32>,
    spacing_angstrom: f64,
    /// What ions cannot enter reaches at least this far beyond the solid, Å.
    beyond_solid_angstrom: f64,
}

impl IonGap {
    /// `reach_angstrom` is how far the solid may reach beyond the spheres, Å.
    pub fn new(
        grid: &Grid,
        spheres: &[ChargedSphere],
        ion_radius_angstrom: f64,
        reach_angstrom: f64,
    ) -> Self {
        let mut gap = vec![f32::MAX; grid.len()];
        let [nx, ny, _] = grid.shape;
        let planes = gap.par_chunks_mut(nx * ny).enumerate();
        planes.for_each(|(k, plane)| {
            for sphere in spheres {
                if sphere.radius_angstrom > 0.0 {
                    let radius = sphere.radius_angstrom + ion_radius_angstrom;
                    lower_plane(grid, k, plane, &sphere.centre, radius);
                }
            }
        });
        Self {
            angstrom: gap,
            spacing_angstrom: grid.spacing_angstrom,
            beyond_solid_angstrom: ion_radius_angstrom - reach_angstrom,
        }
    }

    /// A lower bound of the distance of a point from the solid, Å.
    pub fn distance_from_solid(&self, index: usize) -> f64 {
        f64::from(self.angstrom[index]).min(self.spacing_angstrom) + self.beyond_solid_angstrom
    }
}

/// Lowers the gaps of plane k to the distance from one sphere, where that is below a spacing.
fn lower_plane(grid: &Grid, k: usize, plane: &mut [f32], centre: &Vec3, radius: f64) {
    let h = grid.spacing_angstrom;
    let [x0, y0, z0] = grid.origin_angstrom;
    let [nx, ny, _] = grid.shape;
    let reach = radius + h;
    let dz = z0 + h * k as f64 - centre.z;
    let across_plane = reach * reach - dz * dz;
    if across_plane <= 0.0 {
        return;
    }
    for j in points_within(across_plane.sqrt(), centre.y, y0, h, ny) {
        let dy = y0 + h * j as f64 - centre.y;
        let across_row = across_plane - dy * dy;
        if across_row <= 0.0 {
            continue;
        }
        let points = points_within(across_row.sqrt(), centre.x, x0, h, nx);
        let first_dx = x0 + h * points.start as f64 - centre.x;
        let row = &mut plane[j * nx..][points];
        lower_row(row, first_dx, h, dy * dy + dz * dz, radius);
    }
}

/// The same for points of a row, from the first on; `across` is the square of the row's distance from
/// the centre. In single precision, good to 10⁻⁶ Å, and without branches: it is compiled into vectors.
fn lower_row(row: &mut [f32], first_dx: f64, h: f64, across: f64, radius: f64) {
    let [first_dx, h, across, radius] = [first_dx, h, across, radius].map(|x| x as f32);
    for (step, gap) in (0_i32..).zip(row) {
        let dx = first_dx + h * step as f32;
        let distance = (dx * dx + across).sqrt() - radius;
        *gap = if distance < *gap { distance } else { *gap };
    }
}

/// The points of a row (first point, spacing and number) within a distance of a centre.
fn points_within(
    distance: f64,
    centre: f64,
    origin: f64,
    spacing: f64,
    points: usize,
) -> Range<usize> {
    let first = ((centre - distance - origin) / spacing).ceil().max(0.0);
    let last = ((centre + distance - origin) / spacing)
        .floor()
        .min(points as f64 - 1.0);
    if last < 0.0 {
        return 0..0;
    }
    let end = last as usize + 1;
    (first as usize).min(end)..end
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use protomer_kernel::random::CounterRng;

    /// The slow twin: all spheres at all points, in double precision. Some spheres are off the grid.
    #[test]
    fn gaps_are_distances_up_to_a_spacing() {
        let mut rng = CounterRng::new(9, 0, 0);
        let grid = Grid::around(&Vec3::repeat(-6.0), &Vec3::repeat(7.0), 0.8, 1).unwrap();
        let spheres: Vec<ChargedSphere> = (0..200)
            .map(|_| ChargedSphere {
                centre: rng.vector_in_ball(20.0),
                radius_angstrom: rng.uniform_in(0.0, 2.0),
                charge_e: 0.0,
            })
            .collect();
        let gap = IonGap::new(&grid, &spheres, 2.0, 1.4);
        for index in 0..grid.len() {
            let place = grid.point_at(index);
            let distance = |sphere: &ChargedSphere| {
                (sphere.centre - place).norm() - sphere.radius_angstrom - 2.0
            };
            let least = spheres.iter().map(distance).fold(f64::INFINITY, f64::min);
            let found = f64::from(gap.angstrom[index]);
            if least < 0.8 {
                assert!((found - least).abs() < 2e-6, "{found} {least}");
            } else {
                assert!(found > 0.8 - 2e-6, "{found} {least}");
            }
        }
    }
}
