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
        for i in points_within(across_row.sqrt(), centre.x, x0, h, nx) {
            let dx = x0 + h * i as f64 - centre.x;
            let distance = (dx * dx + dy * dy + dz * dz).sqrt() - radius;
            let gap = &mut plane[j * nx + i];
            *gap = gap.min(distance as f32);
        }
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
    first as usize..last as usize + 1
}
