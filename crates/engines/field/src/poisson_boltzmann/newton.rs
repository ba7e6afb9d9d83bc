//! The Poisson-Boltzmann equation with ions that follow Boltzmann factors,
//!
//! -∇·ε∇φ + ε_out κ² λ N(φ) = 4π l ρ,
//!
//! with N of [`SaltValence`], by Newton's method: each step solves the linear equation with N'(φ) in
//! the place of one. A step that does not lower the residual is halved (Holst and Saied, J. Comput. Chem.
//! 16, 337 (1995)).
//!
//! Ions are at points outside the surface only, where the unknown of the grid is φ itself.
//!
//! The potential on the faces of the grid is not that of the linear equation: a saturated cloud
//! screens a highly charged solute to a smaller charge. Far away both solutions have the same form. So
//! the faces keep the potential of the linear equation times a factor, found with the solution: that
//! which relates the two on a box between solute and faces.

use super::conjugate_gradient;
use super::dot::dot;
use super::operator::Operator;
use crate::grid::set_points;
use crate::ion_response::SaltValence;
use crate::{FieldError, Result};
use rayon::prelude::*;
use std::sync::Arc;

/// Steps after which the iteration gives up.
const MOST_STEPS: usize = 60;
/// Halvings of one step.
const MOST_HALVINGS: usize = 12;
/// Residual of the linear equations of a step over its start.
const STEP_TOLERANCE: f64 = 1e-3;
/// Change of the factor on the faces at which it has been found.
const FACTOR_TOLERANCE: f64 = 1e-4;
/// The box of the factor is this part of the grid away from the faces.
const PART_FROM_FACES: usize = 8;

/// Potential on the faces of the grid.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Faces {
    /// The given potential.
    Given,
    /// The given potential times a factor; it belongs to the linear equation.
    Proportional,
}

/// The nonlinear equation on a grid.
pub(super) struct NonlinearEquation<'a> {
    /// Operator of the linear equation.
    pub linear: &'a Operator,
    /// Sources of the charges.
    pub right: &'a [f64],
    pub salt: SaltValence,
    pub faces: Faces,
}

impl NonlinearEquation<'_> {
    /// Turns the solution of the linear equation into that of the nonlinear one. `start` is the norm of
    /// the first residual of the linear equation. Returns the iterations of all steps.
    ///
    /// # Errors
    /// [`FieldError::NotConverged`] after too many steps.
    pub fn solve(&self, values: &mut [f64], start: f64, relative_tolerance: f64) -> Result<usize> {
        let linear_solution = match self.faces {
            Faces::Given => Vec::new(),
            Faces::Proportional => values.to_vec(),
        };
        let mut factor = 1.0;
        self.saturate(values);
        let goal = relative_tolerance * start;
        let (mut norm, mut residual) = self.residual(values);
        let mut iterations = 0;
        for _ in 0..MOST_STEPS {
            let wanted = self.factor(values, &linear_solution);
            let change = wanted - factor;
            let faces_are_found = change.abs() < FACTOR_TOLERANCE;
            if norm <= goal && faces_are_found {
                return Ok(iterations);
            }
            let mut step = vec![0.0; values.len()];
            if !faces_are_found {
                self.on_faces(&mut step, |point| change * linear_solution[point]);
                factor = wanted;
            }
            let tolerance = STEP_TOLERANCE.max(0.1 * goal / norm.max(goal));
            iterations +=
                conjugate_gradient::solve(&self.tangent(values), &residual, &mut step, tolerance)?;
            // Where the faces move, the residual may grow once: the full step is right.
            (norm, residual) = self.advance(values, &step, norm, !faces_are_found);
        }
        Err(FieldError::NotConverged {
            iterations,
            relative_residual: norm / start,
        })
    }

    /// Adds as much of a step as lowers the residual. Returns the new residual and its norm.
    fn advance(
        &self,
        values: &mut [f64],
        step: &[f64],
        norm: f64,
        always_whole: bool,
    ) -> (f64, Vec<f64>) {
        add_scaled(values, 1.0, step);
        let mut part = 1.0;
        let mut next = self.residual(values);
        for _ in 0..MOST_HALVINGS {
            // Not below: a residual that is not finite must be halved too.
            if always_whole || next.0 < norm {
                break;
            }
            add_scaled(values, -0.5 * part, step);
            part *= 0.5;
            next = self.residual(values);
        }
        next
    }

    /// Replaces potentials in the ions by those of a saturated cloud. Linear potentials of highly charged
    /// solutes would make exponentials from which Newton's method comes back by 1 kT/e per step.
    fn saturate(&self, values: &mut [f64]) {
        let mass = &self.linear.mass;
        let salt = self.salt;
        let is_face = faces_of(self.linear.shape);
        let points = values.par_iter_mut().zip(mass).enumerate();
        points.for_each(|(point, (value, mass))| {
            if *mass > 0.0 && !is_face(point) {
                *value = salt.saturated(*value);
            }
        });
    }

    /// b - (stiffness φ + k N(φ)) on the inner points, and its norm.
    fn residual(&self, values: &[f64]) -> (f64, Vec<f64>) {
        let salt = self.salt;
        // The operator adds k φ; the source takes it away again and adds k N(φ).
        let points = self.right.par_iter().zip(values).zip(&self.linear.mass);
        let source: Vec<f64> = points
            .map(|((right, value), mass)| match *mass > 0.0 {
                true => right - f64::from(*mass) * (salt.charge(*value) - value),
                false => *right,
            })
            .collect();
        let mut residual = vec![0.0; values.len()];
        self.linear.residual(values, &source, &mut residual);
        let norm = dot(&residual, &residual).sqrt();
        (norm, residual.into_iter().map(f64::from).collect())
    }

    /// The derivative of the equation at a potential.
    fn tangent(&self, values: &[f64]) -> Operator {
        let salt = self.salt;
        let points = values.par_iter().zip(&self.linear.mass);
        let mass = points.map(|(value, mass)| match *mass > 0.0 {
            true => (f64::from(*mass) * salt.slope(*value)) as f32,
            false => 0.0,
        });
        let edges = Arc::clone(&self.linear.edges);
        Operator::new(self.linear.shape, edges, mass.collect())
    }

    /// The ratio of this potential to that of the linear equation, by least squares over a box between
    /// solute and faces.
    fn factor(&self, values: &[f64], linear_solution: &[f64]) -> f64 {
        if self.faces == Faces::Given {
            return 1.0;
        }
        let shape = self.linear.shape;
        let [nx, ny, _] = shape;
        let first = shape.map(|points| points / PART_FROM_FACES);
        let last: [usize; 3] = std::array::from_fn(|axis| shape[axis] - 1 - first[axis]);
        let (mut product, mut square) = (0.0, 0.0);
        for k in first[2]..=last[2] {
            for j in first[1]..=last[1] {
                // All of the two outer planes, of the others their outline.
                let is_outer = [(k, 2), (j, 1)]
                    .iter()
                    .any(|(place, axis)| *place == first[*axis] || *place == last[*axis]);
                let step = if is_outer { 1 } else { last[0] - first[0] };
                for i in (first[0]..=last[0]).step_by(step.max(1)) {
                    let point = (k * ny + j) * nx + i;
                    product += values[point] * linear_solution[point];
                    square += linear_solution[point].powi(2);
                }
            }
        }
        // Without a potential there is nothing to scale.
        if square > 0.0 { product / square } else { 1.0 }
    }

    /// Sets values on the faces.
    fn on_faces(&self, values: &mut [f64], potential: impl Fn(usize) -> f64 + Sync) {
        let shape = self.linear.shape;
        let is_face = faces_of(shape);
        set_points(shape, values, |[i, j, k], value| {
            let point = (k * shape[1] + j) * shape[0] + i;
            if is_face(point) {
                *value = potential(point);
            }
        });
    }

    /// Free energy of the ions beyond ½ Σ q φ, kT: the sum of S h³ λ (½ φ N - M) over the grid.
    /// `energy_per_mass` is S h³ λ over k.
    pub fn excess_energy_kt(&self, values: &[f64], energy_per_mass: f64) -> f64 {
        let points = values.par_iter().zip(&self.linear.mass);
        let terms: Vec<f64> = points
            .filter(|(_, mass)| **mass > 0.0)
            .map(|(value, mass)| f64::from(*mass) * self.salt.excess_energy(*value))
            .collect();
        energy_per_mass * terms.iter().sum::<f64>()
    }
}

/// Whether a point is on a face of a grid.
fn faces_of(shape: [usize; 3]) -> impl Fn(usize) -> bool + Sync {
    let [nx, ny, nz] = shape;
    move |point| {
        let place = [point % nx, point / nx % ny, point / (nx * ny)];
        (0..3).any(|axis| place[axis] == 0 || place[axis] + 1 == [nx, ny, nz][axis])
    }
}

fn add_scaled(values: &mut [f64], factor: f64, step: &[f64]) {
    let pairs = values.par_iter_mut().zip(step);
    pairs.for_each(|(value, step)| *value += factor * step);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Gouy and Chapman: a plane of potential φ₀ in a 1:1 salt has, at x/κ from it,
    /// tanh(φ/4) = tanh(φ₀/4) exp(-x). The faces of the grid carry the exact solution.
    #[test]
    fn a_charged_plane_has_the_potential_of_gouy_and_chapman() {
        let (points, kappa_h) = (65_usize, 0.02);
        let shape = [points, 17, 17];
        let count = shape.iter().product();
        let exact = |i: usize, surface: f64| {
            let x = kappa_h * i as f64;
            4.0 * ((surface / 4.0).tanh() * (-x).exp()).atanh()
        };
        let edges = [0; 3].map(|_| vec![80.0; count]);
        let mass = vec![(80.0 * kappa_h * kappa_h) as f32; count];
        let operator = Operator::new(shape, edges, mass);
        let right = vec![0.0; count];
        for surface in [0.01, 1.0, -4.0, 8.0] {
            let equation = NonlinearEquation {
                linear: &operator,
                right: &right,
                salt: SaltValence::ONE_TO_ONE,
                faces: Faces::Given,
            };
            let mut values = vec![0.0; count];
            equation.on_faces(&mut values, |point| exact(point % points, surface));
            let mut first = vec![0.0; count];
            operator.residual_of_faces(&values, &right, &mut first);
            let start = dot(&first, &first).sqrt();
            conjugate_gradient::solve(&operator, &right, &mut values, 1e-8).unwrap();
            equation.solve(&mut values, start, 1e-8).unwrap();
            for (point, value) in values.iter().enumerate() {
                let expected = exact(point % points, surface);
                let error = (value / expected - 1.0).abs();
                assert!(error < 0.01, "{surface}, {point}: {value} for {expected}");
            }
        }
    }
}
