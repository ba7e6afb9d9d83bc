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

use crate::lattice::contact::{arm, rod_shift};
use crate::lattice::network::Network;
use nalgebra::{DMatrix, DVector, SymmetricEigen};

/// Eigenvalues of K below this share of the largest count as zero.
const SINGULAR: f64 = 1e-10;

/// What does not change from sub-step to sub-step.
pub struct Ansatz<'a> {
    network: &'a Network,
    positions: &'a [f64],
    velocities: &'a [f64],
    accelerations: &'a [f64],
    gradient: DMatrix<f64>,
    /// K = D M⁻¹ Dᵀ.
    gram: SymmetricEigen<f64, nalgebra::Dyn>,
    rods: Vec<RodMotion>,
}

struct RodMotion {
    delta: [f64; 2],
    rate: [f64; 2],
    omega: f64,
    alpha: f64,
    /// ω² ρ - ω'² ρ'.
    centripetal: [f64; 2],
}

/// Where a sub-step leads.
pub struct Landing {
    /// x, y, θ of square after square.
    pub positions: Vec<f64>,
    /// What the equations (38) leave over, as a share of their right-hand side.
    pub residual: f64,
}

impl<'a> Ansatz<'a> {
    /// For sub-steps from a state. `accelerations` are those of the forces, `total` with those of
    /// the rods (eq. 23).
    pub fn new(
        network: &'a Network,
        positions: &'a [f64],
        velocities: &'a [f64],
        accelerations: &'a [f64],
        total: &[f64],
    ) -> Self {
        let count = network.rods.len();
        let mut gradient = DMatrix::zeros(2 * count, positions.len());
        let mut rods = Vec::with_capacity(count);
        for (index, rod) in network.rods.iter().enumerate() {
            let shift = rod_shift(network, index);
            let (mut delta, mut rate, mut change) = ([-shift[0], -shift[1]], [0.0; 2], [0.0; 2]);
            let mut centripetal = [0.0; 2];
            for (corner, sign) in [(rod.from, 1.0), (rod.to, -1.0)] {
                let (rho, p) = (arm(network, positions, corner), 3 * corner.square);
                let turned = [-rho[1], rho[0]];
                let omega = velocities[p + 2];
                for axis in 0..2 {
                    gradient[(2 * index + axis, p + axis)] += sign;
                    gradient[(2 * index + axis, p + 2)] += sign * turned[axis];
                    delta[axis] += sign * (positions[p + axis] + rho[axis]);
                    rate[axis] += sign * (velocities[p + axis] + omega * turned[axis]);
                    change[axis] += sign
                        * (total[p + axis] + total[p + 2] * turned[axis]
                            - omega * omega * rho[axis]);
                    centripetal[axis] += sign * omega * omega * rho[axis];
                }
            }
            let dot = |a: [f64; 2], b: [f64; 2]| a[0] * b[0] + a[1] * b[1];
            let speed = dot(rate, rate).sqrt();
            let omega = speed / rod.length;
            let alpha = if speed > 0.0 {
                dot(delta, change).abs().sqrt() * dot(rate, change) / (speed * speed * rod.length)
            } else {
                0.0
            };
            rods.push(RodMotion {
                delta,
                rate,
                omega,
                alpha,
                centripetal,
            });
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

    /// How many of the equations (38) are independent.
    pub fn rank(&self) -> usize {
        let largest = self.gram.eigenvalues.amax();
        self.gram
            .eigenvalues
            .iter()
            .filter(|value| **value > SINGULAR * largest)
            .count()
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
        let forces = DVector::from_column_slice(self.accelerations);
        let mut right = -(&self.gradient * forces);
        for (index, rod) in self.rods.iter().enumerate() {
            let phi = rod.omega * time + 0.5 * rod.alpha * time * time;
            let (sine, cosine) = phi.sin_cos();
            let over = if rod.omega > 0.0 {
                sine / rod.omega
            } else {
                time
            };
            for axis in 0..2 {
                let moved = rod.delta[axis] * (cosine - 1.0) + rod.rate[axis] * over;
                right[2 * index + axis] +=
                    2.0 / (time * time) * (moved - rod.rate[axis] * time) + rod.centripetal[axis];
            }
        }
        let largest = self.gram.eigenvalues.amax();
        let mut inside = self.gram.eigenvectors.tr_mul(&right);
        let mut missed = 0.0;
        for (x, value) in inside.iter_mut().zip(self.gram.eigenvalues.iter()) {
            if *value > SINGULAR * largest {
                *x /= value;
            } else {
                missed += *x * *x;
                *x = 0.0;
            }
        }
        let multipliers = &self.gram.eigenvectors * inside;
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
            residual: missed.sqrt() / right.norm().max(f64::MIN_POSITIVE),
        }
    }
}
