//! The free rotation of a rigid body over a time step, reversible and symplectic.
//!
//! H = L²/(2 I₁) + (1/I₃ - 1/I₁) L₃²/2 + (1/I₂ - 1/I₁) L₂²/2 with the angular momentum L in the frame of
//! the body. The first term turns the body about the fixed direction of L and commutes with the
//! others, each of which turns it about one of its own axes (Dullweber, Leimkuhler and McLachlan, J.
//! Chem. Phys. 107, 5840 (1997)). Bodies with three or with two equal moments need no splitting, so
//! their rotation is exact. The others use Suzuki's composition of fourth order (Phys. Lett. A 146,
//! 319 (1990)). Every factor keeps the angular momentum in space to rounding.

use crate::body::Kind;
use nalgebra::{Quaternion, UnitQuaternion};
use protomer_kernel::{Rotation, Vec3};

/// Turns a body and its angular momentum (in its own frame) over a time.
///
/// ```
/// use protomer_kernel::{Rotation, Vec3};
/// use protomer_md::{body::Kind, rotation::turn};
/// let ball = Kind::ball(3, 1.0)?;
/// let (mut rotation, mut spin) = (Rotation::identity(), ball.moments.z * 0.5 * Vec3::z());
/// turn(&ball, &mut rotation, &mut spin, 2.0);
/// assert!((rotation.angle() - 1.0).abs() < 1e-12, "half a radian per time, for two");
/// # Ok::<(), protomer_md::Error>(())
/// ```
pub fn turn(kind: &Kind, rotation: &mut Rotation, spin: &mut Vec3, time: f64) {
    let [first, second, third] = kind.moments.into();
    let (is_spherical, is_symmetric) = kind.symmetry();
    if !is_spherical {
        // Splitting of H: a symmetric top about L, and corrections about the third and second axes.
        let about_third = 1.0 / third - 1.0 / first;
        let about_second = 1.0 / second - 1.0 / first;
        if is_symmetric {
            turn_about(2, about_third * time, rotation, spin);
        } else {
            // Five Strang steps with these parts are of fourth order.
            for part in suzuki() {
                let time = part * time;
                turn_about(1, 0.5 * about_second * time, rotation, spin);
                turn_about(2, about_third * time, rotation, spin);
                turn_about(1, 0.5 * about_second * time, rotation, spin);
            }
        }
    }
    // About L itself, which this leaves as it is.
    // (L/I₁) t about L: the half angle for the quaternion.
    let half = 0.5 * time / first;
    let size = spin.norm();
    let axis = match size > 0.0 {
        true => *spin * ((half * size).sin() / size),
        false => Vec3::zeros(),
    };
    let increment = Quaternion::from_parts((half * size).cos(), axis);
    // The product of unit quaternions leaves length one by rounding only; do not let it grow.
    *rotation = UnitQuaternion::new_normalize(rotation.quaternion() * increment);
}

fn suzuki() -> [f64; 5] {
    const OUTER: f64 = 0.414_490_771_794_375_7; // 1/(4 - 4^(1/3))
    [OUTER, OUTER, 1.0 - 4.0 * OUTER, OUTER, OUTER]
}

/// Turns the body about one of its axes by `strength` times the spin about it.
fn turn_about(axis: usize, strength: f64, rotation: &mut Rotation, spin: &mut Vec3) {
    let angle = strength * spin[axis];
    let (sine, cosine) = angle.sin_cos();
    let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
    // The body turns by the angle, so what is fixed in space turns back in its frame.
    let [x, y] = [spin[next], spin[last]];
    spin[next] = cosine * x + sine * y;
    spin[last] = cosine * y - sine * x;
    let mut vector_part = Vec3::zeros();
    let (sine, cosine) = (0.5 * angle).sin_cos();
    vector_part[axis] = sine;
    let increment = Quaternion::from_parts(cosine, vector_part);
    *rotation = UnitQuaternion::new_unchecked(rotation.quaternion() * increment);
}
