//! The potential on the surface, continued from the solvent.
//!
//! The gradient of φ jumps at the surface by the ratio of the permittivities, some forty-fold, and
//! inside φ rises to the charges within the radius of an atom: interpolation across the surface on a
//! grid of 1 Å is wrong by several kT/e. Outside φ is smooth, and at the surface it has the same
//! value on both sides. So it is continued from the grid points outside, by a plane fitted to those
//! around the place (moving least squares; Lancaster and Salkauskas, Math. Comp. 37, 141 (1981)):
//!
//! min Σ w_i (φ_i - a - b·(x_i - x))² + μ |b|²,   w_i = exp(-(r_i/h)²),   φ(x) = a.

use crate::poisson_boltzmann::Potential;
use nalgebra::{Matrix4, Vector4};
use protomer_kernel::Vec3;
use rayon::prelude::*;

/// μ in units of h² Σ w: keeps slopes bounded where all points outside lie in a plane.
const STIFFNESS: f64 = 1e-3;

/// The potential at places on the surface for which it was solved, kT/e. Where no grid point outside
/// is near, in cavities smaller than the grid, it is interpolated.
pub fn at_surface(potential: &Potential, places: &[Vec3]) -> Vec<f64> {
    let value_at = |place: &Vec3| {
        let continued = sums_around(potential, place).at_origin();
        let value = continued.or_else(|| potential.value_at(place));
        value.unwrap_or(f64::NAN)
    };
    places.par_iter().map(value_at).collect()
}

/// The sums over those of the four by four by four grid points around a place, fewer at the faces, that
/// are outside.
fn sums_around(potential: &Potential, place: &Vec3) -> Sums {
    let (grid, mut sums) = (potential.grid(), Sums::default());
    let Some((cell, _)) = grid.locate(place) else {
        return sums;
    };
    // One point before the cell and two after: four along each axis around the place.
    let first = cell.map(|index| index.saturating_sub(1));
    let end = [0, 1, 2].map(|axis| (cell[axis] + 3).min(grid.shape[axis]));
    let [i0, j0, k0] = first;
    let from_place = (grid.point(i0, j0, k0) - place) / grid.spacing_angstrom;
    // Offsets, in spacings, and the parts of the weights by axis.
    // exp(-r²) is the product over axes: twelve exponentials instead of sixty-four.
    let axis_offsets = |axis: usize| [0.0, 1.0, 2.0, 3.0].map(|step| from_place[axis] + step);
    let offsets = [0, 1, 2].map(axis_offsets);
    let weights = offsets.map(|row| row.map(|x| (-x * x).exp()));
    for k in k0..end[2] {
        for j in j0..end[1] {
            for i in i0..end[0] {
                let point = grid.index(i, j, k);
                if potential.is_outside(point) {
                    let [x, y, z] = [i - i0, j - j0, k - k0];
                    let weight = weights[0][x] * weights[1][y] * weights[2][z];
                    let offset = Vec3::new(offsets[0][x], offsets[1][y], offsets[2][z]);
                    sums.add(weight, &offset, potential.at_outer_point(point));
                }
            }
        }
    }
    sums
}

/// The sums of a fit: w, w x, w x xᵀ, w φ and w φ x over points at x with values φ.
#[derive(Default)]
struct Sums {
    weight: f64,
    first: Vec3,
    /// xx, xy, xz, yy, yz, zz.
    second: [f64; 6],
    value: f64,
    value_first: Vec3,
}

impl Sums {
    fn add(&mut self, weight: f64, offset: &Vec3, value: f64) {
        let weighted = offset * weight;
        let products = [
            weighted.x * offset.x,
            weighted.x * offset.y,
            weighted.x * offset.z,
            weighted.y * offset.y,
            weighted.y * offset.z,
            weighted.z * offset.z,
        ];
        for (sum, product) in self.second.iter_mut().zip(products) {
            *sum += product;
        }
        self.weight += weight;
        self.first += weighted;
        self.value += weight * value;
        self.value_first += weighted * value;
    }

    /// The fitted plane at the origin; `None` without points.
    fn at_origin(&self) -> Option<f64> {
        let (w, [x, y, z]) = (self.weight, self.first.into());
        let [xx, xy, xz, yy, yz, zz] = self.second;
        // In units of the spacing, so h² is one.
        let stiffness = STIFFNESS * w;
        let matrix = Matrix4::new(
            w,
            x,
            y,
            z, //
            x,
            xx + stiffness,
            xy,
            xz, //
            y,
            xy,
            yy + stiffness,
            yz, //
            z,
            xz,
            yz,
            zz + stiffness,
        );
        let [u, v, t] = self.value_first.into();
        // Positive definite by the stiffness, unless no point has a weight.
        let solution = matrix.cholesky()?.solve(&Vector4::new(self.value, u, v, t));
        Some(solution[0])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::poisson_boltzmann::{SolveSettings, solve};
    use crate::{ChargedSphere, DielectricModel};
    use protomer_body::surface::ImplicitSolid;
    use protomer_kernel::Electrolyte;
    use protomer_kernel::random::CounterRng;

    fn sums(known: &[(Vec3, f64)]) -> Sums {
        let mut sums = Sums::default();
        for (offset, value) in known {
            sums.add((-offset.norm_squared()).exp(), offset, *value);
        }
        sums
    }

    /// The slow twin: every grid point outside, near the place or not, as a row of a least-squares
    /// problem.
    #[test]
    fn places_get_what_all_points_within_reach_say() {
        let electrolyte = Electrolyte::in_water(298.15, 0.15).unwrap();
        let ion = ChargedSphere {
            centre: Vec3::new(0.1, -0.3, 0.2),
            radius_angstrom: 3.0,
            charge_e: 2.0,
        };
        let dielectric = DielectricModel::new(electrolyte);
        let potential = solve(&[ion], &dielectric, &SolveSettings::default()).unwrap();
        let solid = crate::surface::solvent_excluded(&[ion], 1.4).unwrap();
        let grid = potential.grid();
        let mut rng = CounterRng::new(3, 0, 0);
        for _ in 0..20 {
            let place = ion.centre + rng.unit_vector() * ion.radius_angstrom;
            let (cell, _) = grid.locate(&place).unwrap();
            let mut samples = Vec::new();
            for point in 0..grid.len() {
                let vertex = grid.point_at(point);
                let (from_cell, _) = grid.locate(&vertex).unwrap();
                let is_near =
                    (0..3).all(|a| (-1..=2).contains(&(from_cell[a] as i64 - cell[a] as i64)));
                if is_near && solid.signed_distance(&vertex) > 1e-4 {
                    let offset = (vertex - place) / grid.spacing_angstrom;
                    samples.push((offset, potential.at_outer_point(point)));
                }
            }
            let expected = sums(&samples).at_origin().unwrap();
            let found = at_surface(&potential, &[place])[0];
            assert!((found / expected - 1.0).abs() < 1e-12, "{found} {expected}");
        }
    }

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
                let samples: Vec<(Vec3, f64)> = points.iter().map(|x| (*x, value(x))).collect();
                sums(&samples).at_origin().unwrap()
            };
            assert!((fit(&|x| 5.0 + slope.dot(x)) - 5.0).abs() < 0.05 * slope.norm());
            assert!((fit(&|_| -7.0) + 7.0).abs() < 1e-12);
        }
        let of_one_point = sums(&[(Vec3::x(), 3.0)]).at_origin().unwrap();
        assert!((of_one_point - 3.0).abs() < 1e-9);
        assert_eq!(sums(&[]).at_origin(), None);
    }
}
