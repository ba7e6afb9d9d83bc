//! The potential on the surface, from the solvent's side.
//!
//! The gradient of φ jumps at the surface by the ratio of the permittivities, some forty-fold, and
//! inside φ rises to the charges within an atom's radius: what is interpolated across the surface
//! on a grid of 1 Å is wrong by several kT/e. Outside φ is smooth, and on the surface it has the
//! same value from both sides. So it is continued from the grid points outside, by a plane fitted
//! to those around the place (moving least squares; Lancaster and Salkauskas, Math. Comp. 37, 141
//! (1981)):
//!
//! min Σ w_i (φ_i - a - b·(x_i - x))² + μ |b|²,   w_i = exp(-(r_i/h)²),   φ(x) = a.

use crate::poisson_boltzmann::Potential;
use nalgebra::{Matrix4, Vector4};
use protomer_body::surface::ImplicitSolid;
use protomer_kernel::Vec3;
use rayon::prelude::*;

/// μ in units of h² Σ w: keeps slopes bounded where all points outside lie in a plane.
const STIFFNESS: f64 = 1e-3;
/// Points this far outside count, Å: nearer ones may be inside for the solver, by the rounding of
/// its distances.
const OUTSIDE_ANGSTROM: f64 = 1e-4;

/// The potential at places on the surface of the solid that the potential was solved for, kT/e.
/// Where no grid point outside is near, in cavities smaller than the grid, it is interpolated.
pub fn at_surface(potential: &Potential, solid: &dyn ImplicitSolid, places: &[Vec3]) -> Vec<f64> {
    let grid = *potential.grid();
    let around = |place: &Vec3| -> Vec<usize> {
        let Some((cell, _)) = grid.locate(place) else {
            return Vec::new();
        };
        let range =
            |axis: usize| cell[axis].saturating_sub(1)..(cell[axis] + 3).min(grid.shape[axis]);
        let [xs, ys, zs] = [range(0), range(1), range(2)];
        let rows = zs.flat_map(|k| ys.clone().map(move |j| (j, k)));
        rows.flat_map(|(j, k)| xs.clone().map(move |i| grid.index(i, j, k)))
            .collect()
    };
    let point = |index: usize| {
        let (i, rest) = (index % grid.shape[0], index / grid.shape[0]);
        grid.point(i, rest % grid.shape[1], rest / grid.shape[1])
    };
    // Neighbouring places share grid points: each is looked at once.
    let mut needed: Vec<usize> = places.par_iter().flat_map_iter(around).collect();
    needed.par_sort_unstable();
    needed.dedup();
    let values: Vec<Option<f64>> = needed
        .par_iter()
        .map(|index| {
            let node = point(*index);
            (solid.signed_distance(&node) > OUTSIDE_ANGSTROM)
                .then(|| potential.at(&node))
                .flatten()
        })
        .collect();
    let value_of = |index: usize| needed.binary_search(&index).ok().and_then(|at| values[at]);
    let h = grid.spacing_angstrom;
    places
        .par_iter()
        .map(|place| {
            let known = around(place)
                .into_iter()
                .filter_map(|index| Some(((point(index) - place) / h, value_of(index)?)));
            continued(known)
                .or_else(|| potential.at(place))
                .unwrap_or(f64::NAN)
        })
        .collect()
}

/// The fitted plane at the origin, from values at other points; `None` without any.
fn continued(known: impl Iterator<Item = (Vec3, f64)>) -> Option<f64> {
    let (mut matrix, mut right, mut total) = (Matrix4::zeros(), Vector4::zeros(), 0.0);
    for (offset, value) in known {
        let weight = (-offset.norm_squared()).exp();
        let row = Vector4::new(1.0, offset.x, offset.y, offset.z);
        matrix += weight * row * row.transpose();
        right += weight * value * row;
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
                continued(points.iter().map(|x| (*x, value(x)))).unwrap()
            };
            assert!((fit(&|x| 5.0 + slope.dot(x)) - 5.0).abs() < 0.05 * slope.norm());
            assert!((fit(&|_| -7.0) + 7.0).abs() < 1e-12);
        }
        assert_eq!(
            continued(std::iter::once((Vec3::x(), 3.0))).map(|x| (x * 1e9).round() / 1e9),
            Some(3.0)
        );
        assert_eq!(continued(std::iter::empty()), None);
    }
}
