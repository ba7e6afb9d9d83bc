//! Sub-steps by the constant-length ansatz (eqs. 34 to 39 of the paper).
//!
//! Every rod vector is taken to turn at constant length,
//!
//! Δr(t+δ) = Δr cos φ + (Δv/ω) sin φ,   φ = ω δ + α δ²/2,   ω = |Δv|/r0,   α = |Δr·Δa|^½ (Δv·Δa) /
//! (|Δv|² r0),
//!
//! and the squares are to follow: with D the gradient of the rod vectors (two rows per rod), K = D
//! M⁻¹ Dᵀ, and vectors χ in place of the multipliers (eq. 38),
//!
//! K χ = r,   r = 2/δ² (Δr(t+δ) - Δr - Δv δ) - D f + (ω² ρ - ω'² ρ').
//!
//! There are more such equations than squares can fulfil: from 4 x 4 on K is singular and the system
//! has no solution, so it is solved by least squares, and the lengths of the rods are missed. The
//! error is part of what the paper's method is, and is measured.
//!
//! With A = D M^-½ only u = Aᵀ χ moves squares, and it is the shortest solution of Aᵀ A u = Aᵀ r: a
//! sparse system that couples squares joined by a rod, where K couples all rods at a square and is
//! larger. Squares together can move without any rod vector, so it is a floppy one.

use crate::floppy::{FloppySystem, dense};
use crate::lattice::contact::layout::Layout;
use crate::lattice::network::{Network, Rod};
use crate::plane::{Vector, dot, left_of};
use crate::{CrystalError, Result};
use nalgebra::{DVector, SymmetricEigen};

/// Eigenvalues of Aᵀ A below this share of the largest count as zero in the rank.
const SINGULAR: f64 = 1e-10;

/// Quantities that do not change from sub-step to sub-step.
pub struct Ansatz<'a> {
    network: &'a Network,
    positions: &'a [f64],
    velocities: &'a [f64],
    accelerations: &'a [f64],
    /// Matrix A.
    gradient: Gradient,
    /// Aᵀ A.
    normal: FloppySystem,
    /// D f.
    pushed: Vec<f64>,
    rods: Vec<RodMotion>,
}

/// Matrix A = D M^-½: two rows per rod, with numbers at the squares of its ends.
struct Gradient {
    rods: Vec<[Block; 2]>,
    /// Root of the mass or moment of inertia of each coordinate.
    roots: Vec<f64>,
}

/// The numbers of a rod's two rows at one of its squares.
struct Block {
    square: usize,
    rows: [[f64; 3]; 2],
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
    ///
    /// # Errors
    /// [`CrystalError::BadState`] for positions that are not finite.
    pub fn new(
        network: &'a Network,
        positions: &'a [f64],
        velocities: &'a [f64],
        accelerations: &'a [f64],
        total: &[f64],
    ) -> Result<Self> {
        let layout = Layout::new(network, positions);
        let gradient = Gradient::new(network, &layout);
        let mut rods = Vec::with_capacity(network.rods.len());
        for rod in &network.rods {
            rods.push(RodMotion::new(rod, &layout, velocities, total));
        }
        let mut weighted = DVector::from_column_slice(accelerations);
        for (acceleration, root) in weighted.iter_mut().zip(&gradient.roots) {
            *acceleration *= root;
        }
        let normal = gradient.normal_system(network)?;
        Ok(Self {
            network,
            positions,
            velocities,
            accelerations,
            pushed: gradient.apply(&weighted),
            gradient,
            normal,
            rods,
        })
    }

    /// Number of independent equations (38), by a dense decomposition.
    pub fn rank(&self) -> usize {
        let (entries, numbers) = self.gradient.normal_matrix(self.network);
        let eigen = SymmetricEigen::new(dense(&entries, &numbers, self.positions.len()));
        let zero = SINGULAR * eigen.eigenvalues.amax();
        eigen
            .eigenvalues
            .iter()
            .filter(|value| **value > zero)
            .count()
    }

    /// Positions after a time δ, which may be negative.
    pub fn land(&mut self, time: f64) -> Landing {
        let mut positions = self.positions.to_vec();
        if time == 0.0 {
            return Landing {
                positions,
                residual: 0.0,
            };
        }
        let right = self.right_hand_side(time);
        let u = self.normal.solve(&self.gradient.apply_transposed(&right));
        for (k, position) in positions.iter_mut().enumerate() {
            let acceleration = self.accelerations[k] + u[k] / self.gradient.roots[k];
            *position += self.velocities[k] * time + 0.5 * acceleration * time * time;
        }
        let (mut missed, mut whole) = (0.0, 0.0);
        for (reached, wanted) in self.gradient.apply(&u).iter().zip(&right) {
            missed += (wanted - reached) * (wanted - reached);
            whole += wanted * wanted;
        }
        Landing {
            positions,
            residual: missed.sqrt() / whole.sqrt().max(f64::MIN_POSITIVE),
        }
    }

    /// The right-hand side r of eq. 38.
    fn right_hand_side(&self, time: f64) -> Vec<f64> {
        let mut right = Vec::with_capacity(self.pushed.len());
        for (rod, pushed) in self.rods.iter().zip(self.pushed.chunks_exact(2)) {
            let displacement = rod.moved(time);
            for axis in 0..2 {
                let curved = displacement[axis] - rod.rate[axis] * time;
                right.push(2.0 / (time * time) * curved + rod.centripetal[axis] - pushed[axis]);
            }
        }
        right
    }
}

impl Gradient {
    fn new(network: &Network, layout: &Layout) -> Self {
        let mut roots = Vec::with_capacity(3 * network.squares.len());
        for square in &network.squares {
            roots.extend([square.mass, square.mass, square.inertia].map(f64::sqrt));
        }
        let mut rods = Vec::with_capacity(network.rods.len());
        for rod in &network.rods {
            rods.push([(rod.from, 1.0), (rod.to, -1.0)].map(|(corner, sign)| {
                let roots = &roots[3 * corner.square..][..3];
                let [x, y] = left_of(layout.arm(corner));
                Block {
                    square: corner.square,
                    rows: [
                        [sign / roots[0], 0.0, sign * x / roots[2]],
                        [0.0, sign / roots[1], sign * y / roots[2]],
                    ],
                }
            }));
        }
        Self { rods, roots }
    }

    /// A u.
    fn apply(&self, u: &DVector<f64>) -> Vec<f64> {
        let mut product = vec![0.0; 2 * self.rods.len()];
        for (blocks, pair) in self.rods.iter().zip(product.chunks_exact_mut(2)) {
            for block in blocks {
                for (row, sum) in block.rows.iter().zip(pair.iter_mut()) {
                    for (axis, value) in row.iter().enumerate() {
                        *sum += value * u[3 * block.square + axis];
                    }
                }
            }
        }
        product
    }

    /// Aᵀ r.
    fn apply_transposed(&self, r: &[f64]) -> DVector<f64> {
        let mut product = DVector::zeros(self.roots.len());
        for (blocks, pair) in self.rods.iter().zip(r.chunks_exact(2)) {
            for block in blocks {
                for (row, factor) in block.rows.iter().zip(pair) {
                    for (axis, value) in row.iter().enumerate() {
                        product[3 * block.square + axis] += value * factor;
                    }
                }
            }
        }
        product
    }

    /// The lower triangle of Aᵀ A: places, and the numbers there.
    fn normal_matrix(&self, network: &Network) -> (Vec<(usize, usize)>, Vec<f64>) {
        let mut terms = Vec::new();
        for square in 0..network.squares.len() {
            // Squares without rods have a diagonal, too.
            terms.extend((0..3).map(|axis| ((3 * square + axis, 3 * square + axis), 0.0)));
        }
        for blocks in &self.rods {
            for first in blocks {
                for second in blocks.iter().filter(|second| second.square <= first.square) {
                    add_products(first, second, &mut terms);
                }
            }
        }
        terms.sort_by_key(|(place, _)| *place);
        let (mut entries, mut numbers) = (Vec::new(), Vec::new());
        for (place, number) in terms {
            if entries.last() == Some(&place)
                && let Some(sum) = numbers.last_mut()
            {
                *sum += number;
            } else {
                entries.push(place);
                numbers.push(number);
            }
        }
        (entries, numbers)
    }

    fn normal_system(&self, network: &Network) -> Result<FloppySystem> {
        let (entries, numbers) = self.normal_matrix(network);
        let mut places = Vec::with_capacity(self.roots.len());
        for square in 0..network.squares.len() {
            let [row, column] = network.place(square).map(|index| index as f64);
            places.extend([[column, row, 0.0]; 3]);
        }
        FloppySystem::new(entries, numbers, &places).map_err(|error| {
            CrystalError::BadState(format!("the ansatz for the rods has no solution: {error}"))
        })
    }
}

/// Adds the products of two blocks of the same rod that lie in the lower triangle of Aᵀ A.
fn add_products(first: &Block, second: &Block, terms: &mut Vec<((usize, usize), f64)>) {
    for (left, right) in first.rows.iter().zip(&second.rows) {
        for (i, x) in left.iter().enumerate() {
            for (j, y) in right.iter().enumerate() {
                let place = (3 * first.square + i, 3 * second.square + j);
                if place.0 >= place.1 {
                    terms.push((place, x * y));
                }
            }
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice::dynamics::Dynamics;
    use crate::lattice::network::{Edges, Square};
    use crate::lattice::start::{Start, StartVelocities};
    use nalgebra::DMatrix;
    use std::f64::consts::FRAC_PI_4;
    use std::sync::Arc;

    /// Networks with and without edges, and with squares that no or few rods hold.
    fn networks() -> Vec<Network> {
        let open = Network::lattice(5, 4, 0.3, Square::default(), Edges::Open, FRAC_PI_4).unwrap();
        let mut cut = open.clone();
        cut.rods
            .retain(|rod| rod.from.square != 7 && rod.to.square != 7);
        cut.rods.truncate(20);
        cut.squares[3].mass = 5.0;
        let mut around =
            Network::lattice(4, 4, 0.3, Square::default(), Edges::Periodic, FRAC_PI_4).unwrap();
        // Straight rows that close upon themselves would be singular, so another rod of the row goes.
        let across = around.rods.iter().copied().find(|rod| rod.image != [0, 0]);
        around.rods.retain(|rod| rod.image == [0, 0]);
        around.rods[0] = across.unwrap();
        vec![open, cut, around]
    }

    /// Positions by the singular value decomposition of A.
    fn landed_densely(ansatz: &Ansatz, time: f64) -> Vec<f64> {
        let (rows, columns) = (ansatz.pushed.len(), ansatz.positions.len());
        let mut a = DMatrix::zeros(rows, columns);
        for k in 0..columns {
            let mut unit = DVector::zeros(columns);
            unit[k] = 1.0;
            a.set_column(k, &DVector::from_vec(ansatz.gradient.apply(&unit)));
        }
        let right = DVector::from_vec(ansatz.right_hand_side(time));
        let svd = a.svd(true, true);
        let zero = SINGULAR.sqrt() * svd.singular_values.amax();
        let u = svd.solve(&right, zero).unwrap();
        let landed = (0..columns).map(|k| {
            let acceleration = ansatz.accelerations[k] + u[k] / ansatz.gradient.roots[k];
            ansatz.positions[k] + ansatz.velocities[k] * time + 0.5 * acceleration * time * time
        });
        landed.collect()
    }

    #[test]
    fn squares_land_where_the_pseudo_inverse_has_them() {
        for network in networks() {
            let start = Start {
                velocities: StartVelocities::Uniform {
                    largest: 1.0,
                    sum_of_squares: None,
                },
                seed: 4,
                ..Start::default()
            };
            let state = start.build(&network, 0).unwrap().state;
            let network = Arc::new(network);
            let dynamics = Dynamics::new(network.clone(), Vec::new(), &state);
            let dynamics = dynamics.unwrap();
            let (mut free, mut total) = (
                vec![0.0; state.positions.len()],
                vec![0.0; state.positions.len()],
            );
            dynamics.accelerations_into(&mut free, &mut total);
            // Forces that the rods have to hold.
            for (k, acceleration) in free.iter_mut().enumerate() {
                *acceleration += (k as f64).sin();
            }
            let mut ansatz =
                Ansatz::new(&network, &state.positions, &state.velocities, &free, &total).unwrap();
            for time in [0.01, -0.1] {
                let landing = ansatz.land(time);
                for (fast, slow) in landing.positions.iter().zip(landed_densely(&ansatz, time)) {
                    // Rounding over the shift of the floppy system is 2e-7 of the accelerations.
                    let bound = 1e-6 * time * time;
                    assert!((fast - slow).abs() < bound, "{fast} {slow}");
                }
            }
        }
    }
}
