//! The potential on the surface, continued from the solvent.
//!
//! The gradient of φ jumps at the surface by the ratio of the permittivities, some forty-fold, and
//! inside φ rises to the charges within the radius of an atom: interpolation across the surface on a
//! grid of 1 Å is wrong by several kT/e. Outside φ is smooth, and at the surface it has the same
//! value on both sides. So it is continued from the grid points outside, by a plane fitted to those
//! around the place (moving least squares; Lancaster and Salkauskas, Math. Comp. 37, 141 (1981)):
//!
//! min Σ w_i (φ_i - a - b·(x_i - x))² + μ |b|²,   w_i = exp(-(r_i/h)²),   φ(x) = a.

use crate::grid::Grid;
use crate::poisson_boltzmann::Potential;
use nalgebra::{Matrix4, Vector4};
use protomer_body::surface::ImplicitSolid;
use protomer_kernel::Vec3;
use rayon::prelude::*;

/// μ in units of h² Σ w: keeps slopes bounded where all points outside lie in a plane.
const STIFFNESS: f64 = 1e-3;
/// Points count if they are farther outside than this, Å: for the solver, whose distances are
/// rounded, nearer ones may be inside.
const OUTSIDE_ANGSTROM: f64 = 1e-4;

/// The potential at places on the surface of the solid for which the potential was solved, kT/e.
/// Where no grid point outside is near, in cavities smaller than the grid, it is interpolated.
pub fn at_surface(potential: &Potential, solid: &dyn ImplicitSolid, places: &[Vec3]) -> Vec<f64> {
    let grid = potential.grid();
    let known = OuterPoints::new(potential, solid, places);
    let value_at = |place: &Vec3| {
        let continued = known.near(grid, place);
        let value = continue_to_origin(&continued).or_else(|| potential.at(place));
        value.unwrap_or(f64::NAN)
    };
    places.par_iter().map(value_at).collect()
}

/// The potential at the grid points near some places that are outside the surface; not a number at all
/// others.
struct OuterPoints {
    values: Vec<f64>,
}

impl OuterPoints {
    fn new(potential: &Potential, solid: &dyn ImplicitSolid, places: &[Vec3]) -> Self {
        let grid = potential.grid();
        // Neighbouring places share grid points, and each is evaluated once.
        let mut wanted = vec![false; grid.len()];
        for place in places {
            for point in points_around(grid, place) {
                wanted[point] = true;
            }
        }
        let value_outside = |point: usize| {
            let is_outside = !potential.inside()[point]
                && solid.signed_distance(&grid.point_at(point)) > OUTSIDE_ANGSTROM;
            match is_outside {
                true => potential.at_outer_point(point),
                false => f64::NAN,
            }
        };
        let points = wanted.into_par_iter().enumerate();
        let values = points.map(|(point, wanted)| match wanted {
            true => value_outside(point),
            false => f64::NAN,
        });
        Self {
            values: values.collect(),
        }
    }

    /// Offsets, in spacings, and potentials of the outer points around a place.
    fn near(&self, grid: &Grid, place: &Vec3) -> Vec<(Vec3, f64)> {
        let mut near = Vec::with_capacity(64);
        for point in points_around(grid, place) {
            let value = self.values[point];
            if !value.is_nan() {
                let offset = (grid.point_at(point) - place) / grid.spacing_angstrom;
                near.push((offset, value));
            }
        }
        near
    }
}

/// The four-by-four-by-four grid points around a place, fewer at the faces.
fn points_around(grid: &Grid, place: &Vec3) -> Vec<usize> {
    let Some((cell, _)) = grid.locate(place) else {
        return Vec::new();
    };
    let first = cell.map(|index| index.saturating_sub(1));
    let mut end = [0; 3];
    for axis in 0..3 {
        end[axis] = (cell[axis] + 3).min(grid.shape[axis]);
    }
    let mut points = Vec::with_capacity(64);
    for k in first[2]..end[2] {
        for j in first[1]..end[1] {
            for i in first[0]..end[0] {
                points.push(grid.index(i, j, k));
            }
        }
    }
    points
}

/// The fitted plane at the origin, from values at other points; `None` without any.
fn continue_to_origin(known: &[(Vec3, f64)]) -> Option<f64> {
    let (mut matrix, mut right, mut total) = (Matrix4::zeros(), Vector4::zeros(), 0.0);
    for (offset, value) in known {
        let weight = (-offset.norm_squared()).exp();
        let row = Vector4::new(1.0, offset.x, offset.y, offset.z);
        matrix += weight * row * row.transpose();
        right += weight * *value * row;
        total += weight;
    }
    for slope in 1..4 {
        matrix[(slope, slope)] += STIFFNESS * total;
    }
    let solution = matrix.cholesky()?.solve(&right);
    Some(solution[0])
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use protomer_kernel::random::CounterRng;

    #[test]
    fn planes_are_continued_and_constants_kept_exactly() {
        let mut rng = CounterRng::new(2, 0, 0);
        for _ in 0..20 {
            let slope = rng.vector_in_ball(3.0);
            // Points on one side of a plane through the origin.
            let normal = rng.unit_vector();
            let points: Vec<Vec3> = (0..40)
                .map(|_| rng.vector_in_ball(2.0))
                .map(|x| x - 2.0 * normal * x.dot(&normal).min(0.0))
                .collect();
            let fit = |value: &dyn Fn(&Vec3) -> f64| {
                let known: Vec<(Vec3, f64)> = points.iter().map(|x| (*x, value(x))).collect();
                continue_to_origin(&known).unwrap()
            };
            assert!((fit(&|x| 5.0 + slope.dot(x)) - 5.0).abs() < 0.05 * slope.norm());
            assert!((fit(&|_| -7.0) + 7.0).abs() < 1e-12);
        }
        let of_one_point = continue_to_origin(&[(Vec3::x(), 3.0)]).unwrap();
        assert!((of_one_point - 3.0).abs() < 1e-9);
        assert_eq!(continue_to_origin(&[]), None);
    }
}
