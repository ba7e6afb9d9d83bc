//! Sub-steps by the constant-length ansatz (eqs. 34 to 39 of the paper).
//!
//! Every rod vector is taken to turn at constant length,
//!
//! Δr(t+δ) = Δr cos φ + (Δv/ω) sin φ,   φ = ω δ + α δ²/2,   ω = |Δv|/r0,   α = |Δr·Δa|^½ (Δv·Δa) /
//! (|Δv|² r0),
//!
//! and the squares are to follow: with D the gradient of the rod vectors (two rows per rod), K = D
//! M⁻¹ Dᵀ, and vectors χ in place of the multipliers, K χ = 2/δ² (Δr(t+δ) - Δr - Δv δ) - D f + ω²
//! ρ - ω'² ρ' (eq. 38). There are more such equations than squares can fulfil: from 4 x 4 on K is
//! singular and the system has no solution, so it is solved by least squares, and the lengths of
//! the rods are missed. The error is part of what the paper's method is, and is measured.

use crate::lattice::contact::layout::Layout;
use crate::lattice::network::{Network, Rod};
use crate::plane::{Vector, dot, left_of};
use nalgebra::{DMatrix, DVector, Dyn, SymmetricEigen};

/// Eigenvalues of K below this share of the largest count as zero.
const SINGULAR: f64 = 1e-10;

/// Quantities that do not change from sub-step to sub-step.
pub struct Ansatz<'a> {
    network: &'a Network,
    positions: &'a [f64],
    velocities: &'a [f64],
    accelerations: &'a [f64],
    /// Matrix D.
    gradient: DMatrix<f64>,
    /// K = D M⁻¹ Dᵀ.
    gram: SymmetricEigen<f64, Dyn>,
    rods: Vec<RodMotion>,
}

/// A rod vector that turns.
struct RodMotion {
    delta: Vector,
    rate: Vector,
    omega: f64,
    alpha: f64,
    /// ω² ρ - ω'² ρ'.
    centripetal: Vector,
}

/// Result of a sub-step.
pub struct Landing {
    /// x, y, θ of square after square.
    pub positions: Vec<f64>,
    /// Residual of the equations (38), as a share of their right-hand side.
    pub residual: f64,
}

impl<'a> Ansatz<'a> {
    /// An ansatz for sub-steps from a state. `accelerations` are those of the forces, `total` with
    /// those of the rods (eq. 23).
    pub fn new(
        network: &'a Network,
        positions: &'a [f64],
        velocities: &'a [f64],
        accelerations: &'a [f64],
        total: &[f64],
    ) -> Self {
        let layout = Layout::new(network, positions);
        let mut gradient = DMatrix::zeros(2 * network.rods.len(), positions.len());
        let mut rods = Vec::with_capacity(network.rods.len());
        for (index, rod) in network.rods.iter().enumerate() {
            add_gradient(&mut gradient, index, rod, &layout);
            rods.push(RodMotion::new(rod, &layout, velocities, total));
        }
        let mut scaled = gradient.clone();
        for (p, square) in network.squares.iter().enumerate() {
            scaled.column_mut(3 * p).scale_mut(1.0 / square.mass);
            scaled.column_mut(3 * p + 1).scale_mut(1.0 / square.mass);
            scaled.column_mut(3 * p + 2).scale_mut(1.0 / square.inertia);
        }
        let gram = SymmetricEigen::new(&scaled * gradient.transpose());
        Self {
            network,
            positions,
            velocities,
            accelerations,
            gradient,
            gram,
            rods,
        }
    }

    /// Threshold up to which eigenvalues of K count as zero.
    fn zero(&self) -> f64 {
        SINGULAR * self.gram.eigenvalues.amax()
    }

    /// Number of independent equations (38).
    pub fn rank(&self) -> usize {
        let zero = self.zero();
        let eigenvalues = self.gram.eigenvalues.iter();
        eigenvalues.filter(|value| **value > zero).count()
    }

    /// Positions after a time δ, which may be negative.
    pub fn land(&self, time: f64) -> Landing {
        let mut positions = self.positions.to_vec();
        if time == 0.0 {
            return Landing {
                positions,
                residual: 0.0,
            };
        }
        let right = self.right_hand_side(time);
        let (multipliers, missed) = self.least_squares(&right);
        let push = self.gradient.tr_mul(&multipliers);
        for (p, square) in self.network.squares.iter().enumerate() {
            for (axis, inertia) in [square.mass, square.mass, square.inertia]
                .into_iter()
                .enumerate()
            {
                let k = 3 * p + axis;
                let acceleration = self.accelerations[k] + push[k] / inertia;
                positions[k] += self.velocities[k] * time + 0.5 * acceleration * time * time;
            }
        }
        Landing {
            positions,
            residual: missed / right.norm().max(f64::MIN_POSITIVE),
        }
    }

    /// The right-hand side of eq. 38.
    fn right_hand_side(&self, time: f64) -> DVector<f64> {
        let forces = DVector::from_column_slice(self.accelerations);
        let mut right = -(&self.gradient * forces);
        for (index, rod) in self.rods.iter().enumerate() {
            let displacement = rod.moved(time);
            for axis in 0..2 {
                let curved = displacement[axis] - rod.rate[axis] * time;
                right[2 * index + axis] += 2.0 / (time * time) * curved + rod.centripetal[axis];
            }
        }
        right
    }

    /// χ of least squares, and the norm of what it misses.
    fn least_squares(&self, right: &DVector<f64>) -> (DVector<f64>, f64) {
        let zero = self.zero();
        let mut inside = self.gram.eigenvectors.tr_mul(right);
        let mut missed = 0.0;
        for (x, value) in inside.iter_mut().zip(self.gram.eigenvalues.iter()) {
            if *value > zero {
                *x /= value;
            } else {
                missed += *x * *x;
                *x = 0.0;
            }
        }
        (&self.gram.eigenvectors * inside, missed.sqrt())
    }
}

/// Writes the two rows of D of a rod.
fn add_gradient(gradient: &mut DMatrix<f64>, index: usize, rod: &Rod, layout: &Layout) {
    for (corner, sign) in [(rod.from, 1.0), (rod.to, -1.0)] {
        let (tangent, p) = (left_of(layout.arm(corner)), 3 * corner.square);
        for axis in 0..2 {
            gradient[(2 * index + axis, p + axis)] += sign;
            gradient[(2 * index + axis, p + 2)] += sign * tangent[axis];
        }
    }
}

impl RodMotion {
    fn new(rod: &Rod, layout: &Layout, velocities: &[f64], total: &[f64]) -> Self {
        let shift = layout.shift(rod.image);
        let (mut delta, mut rate, mut change) = ([-shift[0], -shift[1]], [0.0; 2], [0.0; 2]);
        let mut centripetal = [0.0; 2];
        for (corner, sign) in [(rod.from, 1.0), (rod.to, -1.0)] {
            let (rho, p) = (layout.arm(corner), 3 * corner.square);
            let tangent = left_of(rho);
            let omega = velocities[p + 2];
            for axis in 0..2 {
                delta[axis] += sign * (layout.positions[p + axis] + rho[axis]);
                rate[axis] += sign * (velocities[p + axis] + omega * tangent[axis]);
                change[axis] += sign
                    * (total[p + axis] + total[p + 2] * tangent[axis] - omega * omega * rho[axis]);
                centripetal[axis] += sign * omega * omega * rho[axis];
            }
        }
        let speed = dot(rate, rate).sqrt();
        let alpha = if speed > 0.0 {
            dot(delta, change).abs().sqrt() * dot(rate, change) / (speed * speed * rod.length)
        } else {
            0.0
        };
        Self {
            delta,
            rate,
            omega: speed / rod.length,
            alpha,
            centripetal,
        }
    }

    /// Δr(t+δ) - Δr.
    fn moved(&self, time: f64) -> Vector {
        let phi = self.omega * time + 0.5 * self.alpha * time * time;
        let (sine, cosine) = phi.sin_cos();
        let over = if self.omega > 0.0 {
            sine / self.omega
        } else {
            time
        };
        [0, 1].map(|axis| self.delta[axis] * (cosine - 1.0) + self.rate[axis] * over)
    }
}
