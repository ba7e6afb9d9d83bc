//! The potential of mean force of two bodies that are tied at a corner.
//!
//! Each body has an axis and an arm that leads from its origin to the place of its tie. The axes stay
//! parallel, or antiparallel, and a rod joins the ends of the arms in the plane across the axes. Two
//! angles are left: the bend b between the arms, 0 where they point at each other and 180° where the
//! second body lies on the first, and the direction α of the rod. At fixed b,
//!
//! F(b) = -kT ln ⟨exp(-U(b, α)/kT)⟩,
//!
//! with the average over those α at which the surfaces do not overlap. The share of α that they leave
//! is given separately, since a model with hard bodies of its own has that part already. The sum over
//! equally spaced α is exact for smooth periodic U; its error is what half of the directions change.

use super::BodyPair;
use crate::Result;
use crate::error::require;
use nalgebra::{Rotation3, Unit, UnitQuaternion};
use protomer_kernel::{Pose, RelativePose, Vec3};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::f64::consts::{PI, TAU};

/// Fewest directions of the rod.
const FEWEST_DIRECTIONS: usize = 8;

/// Tie of two equal bodies, in their own frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tie {
    /// Axis, a unit vector.
    pub axis: Vec3,
    /// Centre from which the arm is measured, Å.
    pub centre: Vec3,
    /// Vector from the centre to the tied place, across the axis, Å.
    pub arm: Vec3,
    /// Length of the rod, Å.
    pub rod_angstrom: f64,
    /// Whether the second body is turned over, so that its axis is antiparallel.
    pub is_turned_over: bool,
}

/// Mean force at one bend.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct TiedPoint {
    /// Bend of the arms, rad.
    pub bend_rad: f64,
    /// Share of the directions of the rod at which the bodies do not overlap.
    pub free_share: f64,
    /// F in kT, without the part of the surfaces; NaN where no direction is left.
    pub energy_kt: f64,
    /// Change of F with half of the directions, kT.
    pub error_kt: f64,
    /// Lowest energy of any direction, kT.
    pub lowest_kt: f64,
}

impl Tie {
    /// Checks that the axis is a unit vector and the arm across it.
    ///
    /// # Errors
    /// [`McError::BadSetting`](crate::McError::BadSetting) names what is not.
    pub fn check(&self) -> Result<()> {
        let length = self.axis.norm();
        let is_unit = (length - 1.0).abs() < 1e-6;
        require("length of the axis", length, "1", is_unit)?;
        let component = self.axis.dot(&self.arm);
        let arm = self.arm.norm();
        let is_across = arm > 0.0 && component.abs() < 1e-6 * arm;
        let longer = "0, and the arm longer than that";
        require("arm along the axis in Å", component, longer, is_across)?;
        let rod = self.rod_angstrom;
        let is_length = rod.is_finite() && rod >= 0.0;
        require("length of the rod in Å", rod, "zero or positive", is_length)
    }

    /// The pose of the second body in the frame of the first at a bend and a direction of the rod,
    /// which is 0 along the first arm, both rad and anticlockwise about the axis.
    ///
    /// ```
    /// use protomer_kernel::Vec3;
    /// use protomer_mc::pair::tied::Tie;
    /// let tie = Tie {
    ///     axis: Vec3::z(),
    ///     centre: Vec3::zeros(),
    ///     arm: Vec3::new(10.0, 0.0, 0.0),
    ///     rod_angstrom: 3.0,
    ///     is_turned_over: false,
    /// };
    /// // Stretched: the second centre lies two arms and a rod away.
    /// assert!((tie.pose(0.0, 0.0).position - Vec3::new(23.0, 0.0, 0.0)).norm() < 1e-12);
    /// ```
    pub fn pose(&self, bend_rad: f64, rod_rad: f64) -> Pose {
        let axis = Unit::new_normalize(self.axis);
        let about = |angle| Rotation3::from_axis_angle(&axis, angle);
        let direction = self.arm.normalize();
        let first = match self.is_turned_over {
            true => Rotation3::from_axis_angle(&Unit::new_normalize(self.arm), PI),
            false => Rotation3::identity(),
        };
        // The second arm points back at the first, less the bend.
        let rotation = about(PI - bend_rad) * first;
        let tied = self.centre + self.arm + about(rod_rad) * direction * self.rod_angstrom;
        Pose {
            position: tied - rotation * (self.centre + self.arm),
            rotation: UnitQuaternion::from_rotation_matrix(&rotation),
        }
    }
}

/// F at these bends (rad), from so many directions of the rod.
///
/// # Errors
/// Those of [`Tie::check`]; [`McError::BadSetting`](crate::McError::BadSetting) for fewer than eight directions or an odd number.
pub fn mean_force(
    pair: &BodyPair,
    tie: &Tie,
    bends_rad: &[f64],
    directions: usize,
) -> Result<Vec<TiedPoint>> {
    tie.check()?;
    let is_even = directions >= FEWEST_DIRECTIONS && directions.is_multiple_of(2);
    let requirement = "even, and eight or more";
    require(
        "number of directions",
        directions as f64,
        requirement,
        is_even,
    )?;
    let bends = bends_rad.par_iter();
    Ok(bends
        .map(|bend_rad| at_bend(pair, tie, *bend_rad, directions))
        .collect())
}

fn at_bend(pair: &BodyPair, tie: &Tie, bend_rad: f64, directions: usize) -> TiedPoint {
    let mut energies = Vec::with_capacity(directions);
    for number in 0..directions {
        let rod_rad = (number as f64 + 0.5) / directions as f64 * TAU;
        let pose = tie.pose(bend_rad, rod_rad);
        let relative = RelativePose::from(&pose);
        energies.push((!pair.excludes(&relative)).then(|| pair.potential.energy_kt(&relative)));
    }
    let all = average_kt(energies.iter().copied());
    let half = average_kt(energies.iter().copied().step_by(2));
    let free: Vec<f64> = energies.into_iter().flatten().collect();
    TiedPoint {
        bend_rad,
        free_share: free.len() as f64 / directions as f64,
        energy_kt: all,
        error_kt: (half - all).abs(),
        lowest_kt: free.into_iter().fold(f64::INFINITY, f64::min),
    }
}

/// -ln of the mean of exp(-U) over the free directions; NaN without any.
fn average_kt(energies: impl Iterator<Item = Option<f64>>) -> f64 {
    let free: Vec<f64> = energies.flatten().collect();
    let lowest = free.iter().copied().fold(f64::INFINITY, f64::min);
    let mut sum = 0.0;
    // About the lowest energy, so that no exponential overflows.
    for energy in &free {
        sum += (lowest - energy).exp();
    }
    lowest - (sum / free.len() as f64).ln()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::BodyType;
    use crate::pair::{Charged, Core, Terms};
    use protomer_kernel::TriangleMesh;
    use protomer_kernel::potential::Yukawa;
    use std::sync::Arc;

    const HALF_EDGE: f64 = 10.0;

    /// Slabs with an edge of 20 Å about a place away from the origin, with these charges.
    fn slabs(charges: &[(Vec3, f64)], centre: Vec3) -> BodyPair {
        let half = Vec3::new(HALF_EDGE, HALF_EDGE, 5.0);
        let mesh = TriangleMesh::cuboid(&(centre - half), &(centre + half));
        let placed: Vec<_> = charges
            .iter()
            .map(|(place, q)| (centre + place, *q))
            .collect();
        let slab = Arc::new(BodyType::new("slab", &mesh, &placed).unwrap());
        let charged = Charged::new(yukawa(), &slab.charges, &slab.charges).unwrap();
        BodyPair {
            first: Arc::clone(&slab),
            second: slab,
            potential: Terms(vec![Arc::new(charged)]),
            core: Core::Surfaces,
            contact_gap_angstrom: 5.0,
        }
    }

    fn yukawa() -> Yukawa {
        Yukawa::uncut(7.0, 0.1).unwrap()
    }

    fn tie(centre: Vec3, is_turned_over: bool) -> Tie {
        Tie {
            axis: Vec3::z(),
            centre,
            arm: Vec3::new(HALF_EDGE, HALF_EDGE, 0.0),
            rod_angstrom: 6.0,
            is_turned_over,
        }
    }

    const CHARGES: [([f64; 3], f64); 4] = [
        ([6.0, 2.0, 3.0], 2.0),
        ([-3.0, 7.0, -1.0], -1.0),
        ([1.0, -4.0, 2.0], 1.0),
        ([8.0, 8.0, 0.0], 1.5),
    ];

    /// The slow twin: charges turned and shifted in the plane by hand, directions one by one, and
    /// overlap by whether any point of one outline lies in the other.
    #[test]
    fn the_mean_force_is_that_of_a_sum_by_hand() {
        let centre = Vec3::new(3.0, -2.0, 1.0);
        let charges = CHARGES.map(|(place, q)| (Vec3::from(place), q));
        for over in [false, true] {
            let pair = slabs(&charges, centre);
            let bends: Vec<f64> = (-3..=3).map(|k| 0.3 * f64::from(k) + 0.01).collect();
            let points = mean_force(&pair, &tie(centre, over), &bends, 64).unwrap();
            for (bend, point) in bends.iter().zip(points) {
                let (energy, share) = by_hand(&charges, *bend, over);
                assert!(
                    (point.energy_kt - energy).abs() < 1e-9,
                    "{point:?} {energy}"
                );
                assert_eq!(point.free_share, share);
                assert!(point.lowest_kt <= point.energy_kt);
            }
        }
    }

    fn by_hand(charges: &[(Vec3, f64)], bend: f64, over: bool) -> (f64, f64) {
        let corner = HALF_EDGE * 2f64.sqrt();
        let (mut sum, mut free) = (0.0, 0.0);
        for number in 0..64 {
            let rod = (f64::from(number) + 0.5) / 64.0 * TAU + PI / 4.0;
            // The first arm points to 45°, the second back along it, less the bend.
            let second_arm = PI / 4.0 + PI - bend;
            let end = [
                corner * (PI / 4.0).cos() + 6.0 * rod.cos() - corner * second_arm.cos(),
                corner * (PI / 4.0).sin() + 6.0 * rod.sin() - corner * second_arm.sin(),
            ];
            let place = |point: &Vec3| {
                // Turned over about its own arm, at 45°: x and y change places, z its sign.
                let [x, y, z] = match over {
                    true => [point.y, point.x, -point.z],
                    false => [point.x, point.y, point.z],
                };
                let (sine, cosine) = (second_arm - PI / 4.0).sin_cos();
                Vec3::new(
                    end[0] + cosine * x - sine * y,
                    end[1] + sine * x + cosine * y,
                    z,
                )
            };
            if overlap(&place) {
                continue;
            }
            let mut energy = 0.0;
            for (site, q) in charges {
                for (point, other) in charges {
                    energy += q * other * yukawa().energy_kt((place(point) - site).norm());
                }
            }
            sum += (-energy).exp();
            free += 1.0;
        }
        (-(sum / free).ln(), free / 64.0)
    }

    /// Whether a fine outline of the second square has a point in the first, or the other way round.
    fn overlap(place: &dyn Fn(&Vec3) -> Vec3) -> bool {
        let inside = |x: f64, y: f64| x.abs() < HALF_EDGE && y.abs() < HALF_EDGE;
        let origin = place(&Vec3::zeros());
        let axes = [Vec3::x(), Vec3::y()].map(|axis| place(&axis) - origin);
        (0..4000).any(|k| {
            let place_on_side = (k % 1000) as f64 / 500.0 * HALF_EDGE - HALF_EDGE;
            let (x, y) = match k / 1000 {
                0 => (place_on_side, HALF_EDGE),
                1 => (place_on_side, -HALF_EDGE),
                2 => (HALF_EDGE, place_on_side),
                _ => (-HALF_EDGE, place_on_side),
            };
            let second = place(&Vec3::new(x, y, 0.0));
            let first = Vec3::new(x, y, 0.0) - origin;
            inside(second.x, second.y) || inside(first.dot(&axes[0]), first.dot(&axes[1]))
        })
    }

    /// One charge at the end of the arm: its distance is the rod, whatever the angles.
    #[test]
    fn charges_at_the_tie_have_the_energy_of_the_rod() {
        let pair = slabs(
            &[(Vec3::new(HALF_EDGE, HALF_EDGE, 0.0), 2.0)],
            Vec3::zeros(),
        );
        for point in mean_force(&pair, &tie(Vec3::zeros(), false), &[-0.4, 0.0, 0.9], 32).unwrap() {
            assert!((point.energy_kt - 4.0 * yukawa().energy_kt(6.0)).abs() < 1e-9);
            assert!(point.error_kt < 1e-9 && point.free_share < 1.0);
        }
    }

    /// Equal bodies that face one way: exchanging them turns the bend about.
    #[test]
    fn the_mean_force_of_equal_bodies_is_even_in_the_bend() {
        let charges = CHARGES.map(|(place, q)| (Vec3::from(place), q));
        let pair = slabs(&charges, Vec3::zeros());
        let [plus, minus] = [0.5, -0.5].map(|bend| {
            mean_force(&pair, &tie(Vec3::zeros(), false), &[bend], 720).unwrap()[0].energy_kt
        });
        assert!((plus - minus).abs() < 0.02, "{plus} {minus}");
    }

    #[test]
    fn bodies_that_always_overlap_have_no_mean_force() {
        let pair = slabs(&[(Vec3::zeros(), 1.0)], Vec3::zeros());
        let short = Tie {
            rod_angstrom: 0.1,
            ..tie(Vec3::zeros(), false)
        };
        let point = mean_force(&pair, &short, &[PI], 16).unwrap()[0];
        assert!(point.free_share == 0.0 && point.energy_kt.is_nan());
        let skew = Tie {
            arm: Vec3::new(1.0, 0.0, 1.0),
            ..short
        };
        assert!(mean_force(&pair, &skew, &[0.0], 16).is_err());
        assert!(mean_force(&pair, &short, &[0.0], 7).is_err());
    }
}
