//! How far a point is from what ions cannot enter.

use crate::charged_sphere::ChargedSphere;
use crate::grid::Grid;
use protomer_body::surface::Ball;
use protomer_kernel::vectorised;
use rayon::prelude::*;
use std::ops::Range;

/// Distances of the points of a grid from the region that ions cannot enter: the spheres grown by
/// the radius of ions.
pub(super) struct IonGap {
    /// The distance of every point, Å. It is exact up to a spacing; farther out it is at least that.
    pub angstrom: Vec<f32>,
    spacing_angstrom: f64,
    /// Lower bound of the distance by which the region that ions cannot enter reaches beyond the
    /// solid, Å.
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
        let mut balls: Vec<Ball> = Vec::with_capacity(spheres.len());
        for sphere in spheres {
            if sphere.radius_angstrom > 0.0 {
                balls.push((sphere.centre, sphere.radius_angstrom + ion_radius_angstrom));
            }
        }
        let planes = gap.par_chunks_mut(nx * ny).enumerate();
        // Planes in parallel, all balls for each: no two threads write the same point.
        planes.for_each(|(k, gaps)| Plane { grid, k }.lower(gaps, &balls));
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

/// Points of a row that are looked at together.
const TOGETHER: usize = 16;

/// A plane of a grid.
struct Plane<'a> {
    grid: &'a Grid,
    k: usize,
}

impl Plane<'_> {
    vectorised!(
        /// Lowers the gaps to the distances from balls, at least where these are below a spacing.
        fn lower[lower_avx512, lower_avx2, lower_any](self: &Self, gaps: &mut [f32], balls: &[Ball])
    );

    #[inline(always)]
    fn lower_any(&self, gaps: &mut [f32], balls: &[Ball]) {
        let h = self.grid.spacing_angstrom;
        let [x0, y0, z0] = self.grid.origin_angstrom;
        let [nx, ny, _] = self.grid.shape;
        // A ball lowers only what it reaches: a disc of the plane, a range of each row.
        for (centre, radius) in balls {
            let reach = radius + h;
            let dz = z0 + h * self.k as f64 - centre.z;
            let across_plane = reach * reach - dz * dz;
            if across_plane <= 0.0 {
                continue;
            }
            for j in points_within(across_plane.sqrt(), centre.y, y0, h, ny) {
                let dy = y0 + h * j as f64 - centre.y;
                let across_row = across_plane - dy * dy;
                if across_row > 0.0 {
                    let points = points_within(across_row.sqrt(), centre.x, x0, h, nx);
                    let row = &mut gaps[j * nx..][points.start..nx];
                    // To the end of the row, as whole vectors may run a few points past the range.
                    let first_dx = x0 + h * points.start as f64 - centre.x;
                    let row_square = dy * dy + dz * dz;
                    lower_row(row, points.len(), [first_dx, h, row_square, *radius]);
                }
            }
        }
    }
}

/// Lowers the gaps of the first `points` of a row, or a few more, to the distances from a ball. The first
/// point is at `first_dx` from its centre along the row; `row_square` is the square of the row's distance
/// from it. In single precision, good to 10⁻⁶ Å.
#[inline(always)]
fn lower_row(row: &mut [f32], points: usize, [first_dx, h, row_square, radius]: [f64; 4]) {
    let [first_dx, h, row_square, radius] = [first_dx, h, row_square, radius].map(|x| x as f32);
    let lower = |gap: &mut f32, step: usize| {
        let dx = first_dx + h * step as f32;
        let distance = (dx * dx + row_square).sqrt() - radius;
        // A lower distance is right wherever it is found, so the extra points do no harm.
        *gap = if distance < *gap { distance } else { *gap };
    };
    let mut step = 0;
    while step < points {
        if let Some(gaps) = row[step..].first_chunk_mut::<TOGETHER>() {
            for (lane, gap) in gaps.iter_mut().enumerate() {
                lower(gap, step + lane);
            }
            step += TOGETHER;
        } else {
            lower(&mut row[step], step);
            step += 1;
        }
    }
}

/// The points of a row (first point, spacing and number) within a distance of a centre.
#[inline(always)]
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
    // The range ends before the row begins.
    if last < 0.0 {
        return 0..0;
    }
    let end = last as usize + 1;
    (first as usize).min(end)..end
}

#[cfg(test)]
mod tests {
    use super::*;
    use protomer_kernel::Vec3;
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
