//! The field of a body's charges on a grid.

use crate::charges::ChargeCloud;
use protomer_kernel::Vec3;
use protomer_kernel::potential::Yukawa;
use rayon::prelude::*;

/// The table ends this far from the sphere that encloses the body, Å.
pub const MARGIN_ANGSTROM: f64 = 20.0;
/// Grid spacing, Å.
const SPACING_ANGSTROM: f64 = 1.0;
/// Charges count as at least this far away, Å: nearer places lie inside the body, where no other
/// body comes.
const LEAST_DISTANCE_ANGSTROM: f64 = 1.0;

/// Potential and gradient at the points of a cube, in single precision.
#[derive(Debug)]
pub struct FieldTable {
    half_edge: f64,
    count: usize,
    /// Gradient (kT/e/Å) and potential (kT/e).
    points: Vec<[f32; 4]>,
}

/// The field at a place.
#[derive(Debug, Clone, Copy)]
pub struct Field {
    /// |∇φ|², (kT/e/Å)².
    pub square_of_gradient: f64,
    /// φ², (kT/e)².
    pub square_of_potential: f64,
}

impl FieldTable {
    /// Tabulates the screened potential of charges around a body of this radius.
    pub fn new(charges: &ChargeCloud, yukawa: &Yukawa, radius_angstrom: f64) -> Self {
        let steps = ((radius_angstrom + MARGIN_ANGSTROM) / SPACING_ANGSTROM).ceil();
        let half_edge = steps * SPACING_ANGSTROM;
        // Symmetric about the origin, which is a point of the grid.
        let count = 2 * steps as usize + 1;
        let charges: Vec<(Vec3, f64)> = charges.iter().collect();
        let point = |index: usize| {
            let numbers = [
                index / (count * count),
                index / count % count,
                index % count,
            ];
            let place = Vec3::from(numbers.map(|n| n as f64 * SPACING_ANGSTROM - half_edge));
            field_of(&charges, yukawa, &place)
        };
        Self {
            half_edge,
            count,
            points: (0..count.pow(3)).into_par_iter().map(point).collect(),
        }
    }

    /// The field at a place in the body's frame, interpolated linearly; `None` beyond the table.
    pub fn value_at(&self, place: &Vec3) -> Option<Field> {
        let mut cell = [0; 3];
        let mut fraction = [0.0_f32; 3];
        for axis in 0..3 {
            let steps = (place[axis] + self.half_edge) / SPACING_ANGSTROM;
            // NaN is in no range.
            if !(0.0..(self.count - 1) as f64).contains(&steps) {
                return None;
            }
            cell[axis] = steps as usize;
            fraction[axis] = (steps - steps.floor()) as f32;
        }
        let mut sum = [0.0_f32; 4];
        for corner in 0..8_usize {
            // Bit `axis` of the corner says on which side; x is slowest in the index.
            let (mut weight, mut index) = (1.0, 0);
            for axis in 0..3 {
                let upper = corner >> axis & 1;
                weight *= match upper {
                    1 => fraction[axis],
                    _ => 1.0 - fraction[axis],
                };
                index = index * self.count + cell[axis] + upper;
            }
            for (sum, value) in sum.iter_mut().zip(self.points[index]) {
                *sum += weight * value;
            }
        }
        let [x, y, z, potential] = sum.map(f64::from);
        Some(Field {
            // Squared after the interpolation: the field
            // is smooth, its square has kinks at charges.
            square_of_gradient: x * x + y * y + z * z,
            square_of_potential: potential * potential,
        })
    }
}

/// Σ λ_B q exp(-κr)/r and its gradient.
fn field_of(charges: &[(Vec3, f64)], yukawa: &Yukawa, place: &Vec3) -> [f32; 4] {
    let kappa = yukawa.inverse_debye_length_per_angstrom;
    let (mut gradient, mut potential) = (Vec3::zeros(), 0.0);
    for (position, charge) in charges {
        let apart = place - position;
        // No division by zero at a charge, which no other body can reach.
        let distance = apart.norm().max(LEAST_DISTANCE_ANGSTROM);
        let of_charge = charge * yukawa.energy_kt(distance);
        potential += of_charge;
        gradient -= of_charge * (1.0 + kappa * distance) / (distance * distance) * apart;
    }
    [
        gradient.x as f32,
        gradient.y as f32,
        gradient.z as f32,
        potential as f32,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_gives_the_field_of_the_charges_and_ends() {
        let charges = ChargeCloud::new(&[(Vec3::new(0.3, 0.0, 1.0), 2.0), (Vec3::zeros(), -0.5)]);
        let yukawa = Yukawa::uncut(7.0, 0.1).unwrap();
        let table = FieldTable::new(&charges, &yukawa, 8.0);
        let listed: Vec<(Vec3, f64)> = charges.iter().collect();
        for place in [Vec3::new(9.3, -4.1, 2.2), Vec3::new(-3.0, 14.4, -7.7)] {
            let [x, y, z, potential] = field_of(&listed, &yukawa, &place).map(f64::from);
            let found = table.value_at(&place).unwrap();
            let square = x * x + y * y + z * z;
            assert!((found.square_of_gradient / square - 1.0).abs() < 0.02);
            assert!((found.square_of_potential / (potential * potential) - 1.0).abs() < 0.02);
            // The gradient is that of the potential.
            let along = |step: f64| {
                let moved = place + Vec3::new(step, 0.0, 0.0);
                f64::from(field_of(&listed, &yukawa, &moved)[3])
            };
            let slope = (along(0.05) - along(-0.05)) / 0.1;
            assert!((slope / x - 1.0).abs() < 1e-2, "{slope} {x}");
        }
        assert!(table.value_at(&Vec3::new(28.5, 0.0, 0.0)).is_none());
    }
}
