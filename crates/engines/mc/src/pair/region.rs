//! Poses around one: within a limit of the displacement of the second body, and coordinates for them.
//!
//! The displacement is the root mean square over the points of the body: with the shift s, the angle θ and the
//! radius of gyration R of its volume, s² + 4/3 (1 - cos θ) R².

use super::wells::{square_displacement, versine};
use nalgebra::{UnitQuaternion, Vector6};
use protomer_kernel::random::CounterRng;
use protomer_kernel::{Pose, Vec3};
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Poses around one, by displacement (Å) and rotation vector (rad).
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct Region {
    /// The pose in the middle.
    pub about: Pose,
    /// Square of the radius of gyration of the body, Å².
    pub square_of_gyration_angstrom2: f64,
    /// Largest displacement, Å (root mean square).
    pub limit_angstrom: f64,
}

impl Region {
    /// Square of the displacement of the body at a pose, Å².
    pub fn square_displacement(&self, pose: &Pose) -> f64 {
        let turn = pose.rotation * self.about.rotation.inverse();
        let square_shift = (pose.position - self.about.position).norm_squared();
        square_displacement(
            square_shift,
            versine(&turn),
            self.square_of_gyration_angstrom2,
        )
    }

    /// Square of the displacement of the body at a place, Å².
    pub fn square_displacement_at_place(&self, place: &Vector6<f64>) -> f64 {
        let (shift, turn) = parts(place);
        let versine = 1.0 - turn.norm().cos();
        square_displacement(
            shift.norm_squared(),
            versine,
            self.square_of_gyration_angstrom2,
        )
    }

    /// The widest rotation within the limit, rad.
    fn widest_turn_rad(&self) -> f64 {
        // 1 - cos θ at which the turn alone moves the points by the limit.
        let versine = self.limit_angstrom.powi(2) / (4.0 / 3.0 * self.square_of_gyration_angstrom2);
        // Beyond 2 even a half turn stays within the limit: small bodies.
        if versine < 2.0 {
            (1.0 - versine).acos()
        } else {
            PI
        }
    }

    /// Whether a place is within the limit, and its rotation vector the only one of its rotation.
    pub fn holds(&self, place: &Vector6<f64>) -> bool {
        let (_, turn) = parts(place);
        // |turn| ≤ π: every rotation has one vector, so none is counted twice.
        turn.norm() <= PI && self.square_displacement_at_place(place) < self.limit_angstrom.powi(2)
    }

    /// Whether a pose is within the limit: as [`Region::holds`] for its place, without its angles.
    pub fn holds_pose(&self, pose: &Pose) -> bool {
        self.square_displacement(pose) < self.limit_angstrom.powi(2)
    }

    /// ∫ d³R dΩ/8π² over the region, Å³: with the density (1 - cos θ)/π of rotation angles and the ball that
    /// the limit leaves to displacements.
    pub fn volume_angstrom3(&self) -> f64 {
        const INTERVALS: usize = 2000;
        let widest = self.widest_turn_rad();
        let step = widest / INTERVALS as f64;
        let mut sum = 0.0;
        // The midpoint rule in the angle; the integrand
        // is smooth but at its end, where it vanishes.
        for interval in 0..INTERVALS {
            let angle = (interval as f64 + 0.5) * step;
            let turned =
                square_displacement(0.0, 1.0 - angle.cos(), self.square_of_gyration_angstrom2);
            let radius = (self.limit_angstrom.powi(2) - turned).max(0.0).sqrt();
            sum += (1.0 - angle.cos()) / PI * 4.0 / 3.0 * PI * radius.powi(3) * step;
        }
        sum
    }

    /// The pose at a place.
    pub fn pose(&self, place: &Vector6<f64>) -> Pose {
        let (shift, turn) = parts(place);
        Pose {
            position: self.about.position + shift,
            rotation: UnitQuaternion::from_scaled_axis(turn) * self.about.rotation,
        }
    }

    /// The place of a pose.
    pub fn place(&self, pose: &Pose) -> Vector6<f64> {
        let turn = pose.rotation * self.about.rotation.inverse();
        joined(&(pose.position - self.about.position), &turn.scaled_axis())
    }

    /// A place drawn evenly.
    pub fn draw(&self, rng: &mut CounterRng) -> Vector6<f64> {
        let widest = self.widest_turn_rad();
        loop {
            let shift = rng.vector_in_ball(self.limit_angstrom);
            let turn = rng.vector_in_ball(widest);
            let place = joined(&shift, &turn);
            // Rejection turns evenly drawn vectors into evenly
            // drawn rotations; the density is at most one.
            if rng.uniform() < density(&place) && self.holds(&place) {
                return place;
            }
        }
    }
}

/// Displacement and rotation vector.
pub(crate) fn parts(place: &Vector6<f64>) -> (Vec3, Vec3) {
    let shift = Vec3::new(place[0], place[1], place[2]);
    (shift, Vec3::new(place[3], place[4], place[5]))
}

fn joined(shift: &Vec3, turn: &Vec3) -> Vector6<f64> {
    Vector6::new(shift.x, shift.y, shift.z, turn.x, turn.y, turn.z)
}

/// Density of even rotations over rotation vectors, relative to that of small ones: 2 (1 - cos θ)/θ².
pub(crate) fn density(place: &Vector6<f64>) -> f64 {
    let angle_rad = parts(place).1.norm();
    // The quotient of two small numbers would lose its digits.
    match angle_rad < 1e-4 {
        true => 1.0,
        false => 2.0 * (1.0 - angle_rad.cos()) / angle_rad.powi(2),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pose_is_held_if_its_place_is() {
        let mut rng = CounterRng::new(3, 0, 0);
        let region = Region {
            about: Pose {
                position: rng.vector_in_ball(9.0),
                rotation: rng.rotation(),
            },
            square_of_gyration_angstrom2: 40.0,
            limit_angstrom: 5.0,
        };
        let mut held = 0;
        for _ in 0..2000 {
            let pose = Pose {
                position: region.about.position + rng.vector_in_ball(6.0),
                rotation: rng.small_rotation(1.0) * region.about.rotation,
            };
            let place = region.place(&pose);
            let squares = [
                region.square_displacement(&pose),
                region.square_displacement_at_place(&place),
            ];
            assert!(
                (squares[0] - squares[1]).abs() < 1e-12 * squares[1],
                "{squares:?}"
            );
            assert_eq!(region.holds_pose(&pose), region.holds(&place));
            held += usize::from(region.holds(&place));
        }
        assert!((200..1800).contains(&held), "{held}");
    }
}
