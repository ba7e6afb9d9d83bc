//! The energy between the centroids, the second term of the published potential.
//!
//! ```text
//! conservative   U(r; σ)           along the line of the centroids, no torque
//! printed        U(r - M; σ)       eq. 4.6 of the thesis: ε_s L₂ = ε L₁ puts L₁ for ε_s L₂
//! gradient       U(r - M; σ)       with the forces that belong to it
//! ```
//!
//! M = (|a| - σ_i/2) + (|b| - σ_j/2), where a and b lead from the centroids to the closest points and
//! σ_i is the diameter of the ball that fits into body i. As printed, ε_s = ε L₁/L₂ is held fixed when
//! the force is derived; so the force is not the gradient, has no torque, and grows without bound
//! where L₂ vanishes. The gradient lets a and b move: with the features on which they lie (a corner, an
//! edge, a face) as a + U s and b + V t, the places s and t solve
//!
//! ```text
//! Uᵀ(a - b) = 0,  Vᵀ(a - b) = 0
//! ```
//!
//! and their derivatives by a displacement of one body are those of a linear system. Where features
//! are parallel the closest points are not unique and M has no gradient; the shortest change is taken.

use super::radial::Radial;
use super::{PairForces, Placed};
use nalgebra::{DMatrix, DVector};
use protomer_kernel::Vec3;
use protomer_kernel::choices;
use protomer_kernel::shape::closest::ClosestPoints;
use protomer_kernel::shape::polytope::Polytope;

/// Distance to the plane of a face below which a point lies on it, as a part of the circumradius.
const ON_FACE: f64 = 1e-10;
/// Size below which singular values are zero, as a part of the largest.
const SINGULAR: f64 = 1e-10;

choices! {
    /// Energy between the centroids.
    pub enum Central {
        /// No energy between the centroids.
        None = "none",
        /// Energy with epsilon_s = epsilon.
        Conservative = "conservative",
        /// Eq. 4.6 with its force as printed, which is not the gradient.
        Printed = "printed",
        /// The energy of eq. 4.6 with its gradient.
        Gradient = "gradient",
    }
}

/// Adds the central term; `radial` has the length σ.
pub fn add(
    forces: &mut PairForces,
    central: Central,
    radial: &Radial,
    pair: &Placed,
    closest: &ClosestPoints,
) {
    let between = pair.poses[0].position - pair.poses[1].position;
    let r = between.norm();
    let direction = between / r;
    if central == Central::None || r >= radial.range() {
        return;
    }
    if central == Central::Conservative {
        let [energy, slope] = radial.energy_and_slope(r);
        forces.energy += energy;
        forces.force -= slope * direction;
        return;
    }
    let excess = excess(pair, closest);
    let [energy, slope] = radial.energy_and_slope(r - excess);
    forces.energy += energy;
    if central == Central::Printed {
        let [unscaled, slope] = radial.energy_and_slope(r);
        forces.force -= energy / unscaled * slope * direction;
        return;
    }
    let gradient = gradient_of_excess(pair, closest);
    forces.force -= slope * (direction - gradient.position);
    for (torque, component) in forces.torques.iter_mut().zip(gradient.rotations) {
        *torque += slope * component;
    }
}

/// Vectors from the centroids to the closest points on the surfaces of the rounded bodies.
fn arms(pair: &Placed, closest: &ClosestPoints) -> [Vec3; 2] {
    let direction = closest.separation().normalize();
    [
        closest.on_first - pair.radii[0] * direction - pair.poses[0].position,
        closest.on_second + pair.radii[1] * direction - pair.poses[1].position,
    ]
}

/// Excess M of the distances between closest points and centroids over the inradii.
fn excess(pair: &Placed, closest: &ClosestPoints) -> f64 {
    let arms = arms(pair, closest);
    [0, 1]
        .map(|n| arms[n].norm() - pair.bodies[n].inradius() - pair.radii[n])
        .iter()
        .sum()
}

/// Derivatives of M by the position of the first body and by turns of both.
struct Gradient {
    position: Vec3,
    rotations: [Vec3; 2],
}

/// Computes the derivatives by differences along the linear response of the closest points.
fn gradient_of_excess(pair: &Placed, closest: &ClosestPoints) -> Gradient {
    let arms = arms(pair, closest);
    let features = [0, 1].map(|n| {
        let on = [closest.on_first, closest.on_second][n] - pair.poses[n].position;
        directions(pair.bodies[n], &(pair.poses[n].rotation.inverse() * on))
            .iter()
            .map(|direction| pair.poses[n].rotation * direction)
            .collect::<Vec<Vec3>>()
    });
    let separation = closest.separation();
    let distance = separation.norm();
    let response = Response::from_features(&features);
    // How M changes when the closest points move by `shift` in space, in addition to what their
    // bodies take along: `displacements` is how each point moves with its body, `turn` how the body
    // turns.
    let change = |displacements: [Vec3; 2], turn: [Vec3; 2]| -> f64 {
        let rate = displacements[0] - displacements[1];
        let derivatives = [0, 1].map(|n| {
            let derivatives = features[n].iter().map(|direction| turn[n].cross(direction));
            derivatives.collect::<Vec<Vec3>>()
        });
        let slides = response.along(&features, &derivatives, &separation, &rate);
        let rate = rate + slides[0] - slides[1];
        // The direction of the separation turns by this, and the rounded points with it.
        let swing =
            (rate - separation * (separation.dot(&rate) / (distance * distance))) / distance;
        let mut sum = 0.0;
        for n in 0..2 {
            let sign = [-1.0, 1.0][n];
            let core = displacements[n] + slides[n];
            // The centroid moves with the body: what is left is the change of the arm.
            let carried = displacements[n]
                - turn[n]
                    .cross(&([closest.on_first, closest.on_second][n] - pair.poses[n].position));
            let arm = core - carried + sign * pair.radii[n] * swing;
            sum += arms[n].dot(&arm) / arms[n].norm();
        }
        sum
    };
    let none = Vec3::zeros();
    let axis = |n: usize| Vec3::ith(n, 1.0);
    let position = Vec3::from_fn(|n, _| change([axis(n), none], [none; 2]));
    let rotations = [0, 1].map(|body| {
        Vec3::from_fn(|n, _| {
            let point = [closest.on_first, closest.on_second][body] - pair.poses[body].position;
            let (mut displacements, mut turn) = ([none; 2], [none; 2]);
            displacements[body] = axis(n).cross(&point);
            turn[body] = axis(n);
            change(displacements, turn)
        })
    });
    Gradient {
        position,
        rotations,
    }
}

/// Directions along which a point may move on the feature it lies on, in the frame of the body:
/// none for a corner, one along an edge, two in a face.
fn directions(body: &Polytope, point: &Vec3) -> Vec<Vec3> {
    let near = ON_FACE * body.circumradius();
    let faces = body.faces.iter();
    let on: Vec<Vec3> = faces
        .filter(|face| (face.normal.dot(point) - face.offset).abs() < near)
        .map(|face| face.normal)
        .collect();
    match (body.dimension, on.as_slice()) {
        (2, [normal]) => vec![Vec3::new(-normal.y, normal.x, 0.0)],
        (3, [normal]) => {
            let first = normal.cross(&Vec3::ith(normal.iamin(), 1.0)).normalize();
            vec![first, normal.cross(&first)]
        }
        (3, [first, second]) => vec![first.cross(second).normalize()],
        _ => Vec::new(),
    }
}

/// The linear response of the places of the closest points on their features.
struct Response(DMatrix<f64>);

impl Response {
    fn from_features(features: &[Vec<Vec3>; 2]) -> Self {
        let sizes = [features[0].len(), features[1].len()];
        let total = sizes[0] + sizes[1];
        let column = |n: usize| match n < sizes[0] {
            true => features[0][n],
            false => -features[1][n - sizes[0]],
        };
        let matrix = DMatrix::from_fn(total, total, |row, other| column(row).dot(&column(other)));
        if total == 0 {
            return Self(matrix);
        }
        let inverse = matrix
            .clone()
            .pseudo_inverse(SINGULAR * matrix.norm().max(1e-300));
        Self(inverse.unwrap_or_else(|_| DMatrix::zeros(total, total)))
    }

    /// Displacements of the two points along their features, when their separation changes at
    /// `rate` and the features turn.
    fn along(
        &self,
        features: &[Vec<Vec3>; 2],
        derivatives: &[Vec<Vec3>; 2],
        separation: &Vec3,
        rate: &Vec3,
    ) -> [Vec3; 2] {
        let signed = |lists: &[Vec<Vec3>; 2]| -> Vec<Vec3> {
            let second = lists[1].iter().map(|x| -x);
            lists[0].iter().copied().chain(second).collect()
        };
        let (fixed, derivatives) = (signed(features), signed(derivatives));
        let right = DVector::from_iterator(
            fixed.len(),
            fixed
                .iter()
                .zip(&derivatives)
                .map(|(direction, derivative)| -(direction.dot(rate) + derivative.dot(separation))),
        );
        let places = &self.0 * right;
        let mut slid = [Vec3::zeros(); 2];
        for (n, directions) in features.iter().enumerate() {
            for (k, direction) in directions.iter().enumerate() {
                slid[n] += places[n * features[0].len() + k] * direction;
            }
        }
        slid
    }
}
