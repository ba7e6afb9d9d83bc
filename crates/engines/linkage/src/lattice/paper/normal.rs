//! The normal of corners head on as the paper prints it.

use crate::lattice::contact::layout::Layout;
use crate::lattice::network::{Corner, Network};
use crate::lattice::state::State;
use crate::plane::{Vector, dot, left_of, minus, norm, plus};

/// Below this the equation is singular.
const SINGULAR: f64 = 1e-8;

/// The direction of eq. 42, turned from target to striker:
///
/// n ∝ G ((ρ_l ρ_lᵀ - ρ_k ρ_kᵀ)/I)⁻¹ ((Gᵀ + ρ_l e_zᵀ) ṡ_target + (Gᵀ + ρ_k e_zᵀ) ṡ_striker).
///
/// It holds the *sum* of the velocities, so it depends on the observer. `None` where the matrix is
/// singular.
pub fn printed_normal(
    network: &Network,
    state: &State,
    striker: Corner,
    target: Corner,
) -> Option<[f64; 2]> {
    let layout = Layout::new(network, &state.positions);
    let (k, l) = (layout.arm(striker), layout.arm(target));
    let inertia = network.squares[striker.square].inertia;
    let entry = |i: usize, j: usize| (l[i] * l[j] - k[i] * k[j]) / inertia;
    let (a, b, c) = (entry(0, 0), entry(0, 1), entry(1, 1));
    let determinant = a * c - b * b;
    if determinant.abs() <= SINGULAR {
        return None;
    }
    let sum = plus(part(state, target, l), part(state, striker, k));
    let solved = [
        (c * sum[0] - b * sum[1]) / determinant,
        (a * sum[1] - b * sum[0]) / determinant,
    ];
    // G x = (-y, x).
    let normal = left_of(solved);
    let length = norm(normal);
    if length.is_nan() || length <= SINGULAR {
        return None;
    }
    let outward = dot(minus(l, k), normal);
    let sign = if outward < 0.0 { -1.0 } else { 1.0 };
    Some([sign * normal[0] / length, sign * normal[1] / length])
}

/// (Gᵀ + ρ e_zᵀ) ṡ, with Gᵀ x = (y, -x).
fn part(state: &State, corner: Corner, rho: Vector) -> Vector {
    let v = &state.velocities[3 * corner.square..3 * corner.square + 3];
    [v[1] + rho[0] * v[2], -v[0] + rho[1] * v[2]]
}
