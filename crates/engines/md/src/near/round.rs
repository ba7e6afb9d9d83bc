//! Forces between ellipses, ellipsoids, disks and balls.
//!
//! With the support functions h(n) = √(nᵀ A n) of two ellipsoids about their centres (A = R diag(a²) Rᵀ)
//! and the way r between the centres, a plane across n leaves the gap
//!
//! ```text
//! f(n) = n·r - h₁(n) - h₂(n),   |n| = 1
//! ```
//!
//! and the distance of the bodies is the largest gap: f is concave, so apart bodies have one maximum.
//! Newton's method on the sphere of directions finds it from where it was a step ago. At the maximum
//! the points A₁n/h₁ and r - A₂n/h₂ are the closest points, the distance does not change with n to
//! first order, and the force acts along n.

use super::{Felt, Hint, Law, SURELY_BEYOND, TurnedPart};
use nalgebra::Matrix3;
use protomer_kernel::Vec3;

/// Largest number of steps; a dozen are enough from anywhere for axes in proportions of ten.
const MOST_STEPS: usize = 100;
/// The tangential gradient over the size at which a direction is found.
const CONVERGED: f64 = 1e-15;
/// The least curvature over the size, where the bodies overlap and f is not positive.
const LEAST_CURVATURE: f64 = 1e-2;

/// The energy, force and torques of two bodies without faces; `between` leads from the centre of the
/// first to that of the second.
pub fn felt(
    first: TurnedPart<'_>,
    second: TurnedPart<'_>,
    between: Vec3,
    law: &Law,
    hint: &mut Hint,
) -> Felt {
    let apart = first.part.circumradius + second.part.circumradius + law.radial.range();
    let squared = between.norm_squared();
    if squared > apart * apart {
        return Felt::nothing();
    }
    // Each centre is inside its body, and there is no direction between two that coincide.
    if squared == 0.0 {
        return Felt::touching();
    }
    let reach = law.reach * SURELY_BEYOND;
    let gap = Gap {
        axes: [first.normals, second.normals],
        between,
        size: squared.sqrt(),
    };
    let straight = between / gap.size;
    // A remembered direction has length one; at first it is the zero vector.
    let start = match hint.direction.norm_squared() > 0.5 {
        true => hint.direction,
        false => straight,
    };
    let mut widest = gap.widest(start, reach);
    if widest.value <= law.radii {
        // Bodies that overlap may hold a direction at a lower maximum; the line of the centres leads
        // away from it.
        widest = gap.widest(straight, reach);
    }
    hint.direction = widest.direction;
    let distance = widest.value - law.radii;
    if distance <= 0.0 {
        return Felt::touching();
    }
    if widest.value >= law.reach {
        return Felt::nothing();
    }
    let [energy, slope] = law.radial.energy_and_slope(distance);
    let force = slope * widest.direction;
    // The points of the rounded bodies lie on the line of the force.
    let on_second = -widest.points[1];
    Felt {
        energy,
        force,
        torques: [widest.points[0].cross(&force), -on_second.cross(&force)],
    }
}

/// The gap between two ellipsoids as a function of direction.
struct Gap<'a> {
    axes: [&'a [Vec3]; 2],
    between: Vec3,
    size: f64,
}

/// The gap in one direction, and where the ellipsoids reach farthest: the first along it, the second
/// against it (with the sign turned).
#[derive(Clone, Copy)]
struct Along {
    direction: Vec3,
    value: f64,
    points: [Vec3; 2],
}

impl Gap<'_> {
    /// The largest gap, or the first that is found to be beyond the reach.
    fn widest(&self, start: Vec3, reach: f64) -> Along {
        let mut current = self.along(start);
        for _ in 0..MOST_STEPS {
            // Beyond the reach in one direction is beyond it in all that matter.
            if current.value > reach {
                break;
            }
            // The gradient of the gap; its part along n does not change the direction.
            let gradient = self.between - current.points[0] - current.points[1];
            let slope = gradient - current.direction * current.direction.dot(&gradient);
            if slope.norm() <= CONVERGED * self.size {
                break;
            }
            let Some(step) = self.step(&current, &slope) else {
                break;
            };
            let Some(next) = self.higher(&current, &step) else {
                break;
            };
            current = next;
        }
        current
    }

    fn along(&self, direction: Vec3) -> Along {
        let mut value = direction.dot(&self.between);
        let points = self.axes.map(|axes| {
            let (height, point) = support(axes, &direction);
            value -= height;
            point
        });
        Along {
            direction,
            value,
            points,
        }
    }

    /// Newton's step on the sphere: (P (H₁ + H₂) P + f) t = the tangential gradient.
    fn step(&self, current: &Along, slope: &Vec3) -> Option<Vec3> {
        let n = current.direction;
        let projector = Matrix3::identity() - n * n.transpose();
        let mut curvature = Matrix3::zeros();
        // Second derivatives of both supports: A/h - p pᵀ/h.
        for (axes, point) in self.axes.iter().zip(&current.points) {
            let height = point.dot(&n);
            if height > 0.0 {
                for axis in *axes {
                    curvature += axis * axis.transpose() / height;
                }
                curvature -= point * point.transpose() / height;
            }
        }
        let matrix = projector * curvature * projector
            // A floor keeps the matrix positive where bodies overlap and the gap is negative.
            + Matrix3::identity() * current.value.max(LEAST_CURVATURE * self.size);
        matrix.try_inverse().map(|inverse| inverse * slope)
    }

    /// The first direction with a larger gap, after the whole step, a half, a quarter of it and so
    /// on; `None` if rounding leaves none.
    fn higher(&self, current: &Along, step: &Vec3) -> Option<Along> {
        let mut share = 1.0;
        // Halvings: the whole step is right near the maximum, shorter ones far from it.
        for _ in 0..30 {
            let next = self.along((current.direction + share * step).normalize());
            if next.value > current.value {
                return Some(next);
            }
            // Near the maximum the gap is flat to rounding, and the step itself says where it is.
            if step.norm() < 1e-7 {
                return (share == 1.0 && step.norm() > 1e-15).then_some(next);
            }
            share *= 0.5;
        }
        None
    }
}

/// The height of an ellipsoid along a direction, and the point there.
fn support(axes: &[Vec3], direction: &Vec3) -> (f64, Vec3) {
    let mut point = Vec3::zeros();
    let mut squared = 0.0;
    for axis in axes {
        let projection = axis.dot(direction);
        // A n / h with A = Σ a aᵀ.
        point += projection * axis;
        squared += projection * projection;
    }
    if squared > 0.0 {
        point /= squared.sqrt();
    }
    (squared.sqrt(), point)
}
