//! What an impact does to the velocities.
//!
//! With the rows N of the contacts and the inverse mass that respects the rods,
//!
//! S = M⁻¹ - M⁻¹ Jᵀ A⁻¹ J M⁻¹,   v⁺ = v⁻ + S Nᵀ p,   0 ≤ p ⟂ N v⁺ + e N v⁻ ≥ 0,
//!
//! impulses p only push, every contact moves apart at least e times as fast as it came together,
//! and exactly so where there is an impulse. At e = 1 the energy changes by ½ pᵀ (N v⁺ + N v⁻) = 0,
//! however many contacts there are.

use super::lcp;
use crate::error::{Result, require};
use crate::lattice::contact::Row;
use crate::lattice::network::Network;
use crate::lattice::rods::RodSystem;

/// The result of an impact.
#[derive(Debug, Clone, PartialEq)]
pub struct Impact {
    /// p of every contact, ≥ 0.
    pub impulses: Vec<f64>,
    /// Rates N v⁻ of the gaps before the impact.
    pub before: Vec<f64>,
    /// Change of the kinetic energy by the impulses.
    pub energy_change: f64,
    /// False if the complementarity problem had to be relaxed.
    pub exact: bool,
}

/// Lets the contacts with these rows act on the velocities; `rods` must be linearised at the
/// positions. With `lift`, every contact parts at least at that speed, whatever the restitution.
pub fn impact(
    network: &Network,
    rods: &mut RodSystem,
    velocities: &mut [f64],
    rows: &[Row],
    restitution: f64,
    lift: Option<f64>,
) -> Impact {
    let mut before = Vec::with_capacity(rows.len());
    let mut demands = Vec::with_capacity(rows.len());
    let mut columns = Vec::with_capacity(rows.len());
    for row in rows {
        let rate = row.dot(velocities);
        // w = W p + (1 + e) N v⁻ ≥ 0.
        let rebound = (1.0 + restitution) * rate;
        // At least this fast, also where restitution would demand less.
        demands.push(lift.map_or(rebound, |lift| rebound.min(rate - lift)));
        before.push(rate);
        columns.push(constrained_response(network, rods, row, velocities.len()));
    }
    let solution = lcp::solve(&coupling(rows, &columns), &demands);
    add_impulses(&solution.impulses, &columns, velocities);
    let mut energy_change = 0.0;
    for ((impulse, row), before) in solution.impulses.iter().zip(rows).zip(&before) {
        // ½ pᵀ (N v⁺ + N v⁻): the work of the impulses, exactly.
        energy_change += 0.5 * impulse * (row.dot(velocities) + before);
    }
    Impact {
        impulses: solution.impulses,
        before,
        energy_change,
        exact: solution.exact,
    }
}

/// N S Nᵀ row by row, made symmetric.
fn coupling(rows: &[Row], columns: &[Vec<f64>]) -> Vec<f64> {
    let count = rows.len();
    let mut w = vec![0.0; count * count];
    for (i, row) in rows.iter().enumerate() {
        for (j, column) in columns.iter().enumerate() {
            w[i * count + j] = row.dot(column);
        }
    }
    for i in 0..count {
        for j in 0..i {
            // Rounding makes both halves differ; the solver wants a symmetric matrix.
            let mean = 0.5 * (w[i * count + j] + w[j * count + i]);
            w[i * count + j] = mean;
            w[j * count + i] = mean;
        }
    }
    w
}

/// v += S Nᵀ p.
pub(crate) fn add_impulses(impulses: &[f64], columns: &[Vec<f64>], velocities: &mut [f64]) {
    for (impulse, column) in impulses.iter().zip(columns) {
        for (v, x) in velocities.iter_mut().zip(column) {
            *v += impulse * x;
        }
    }
}

/// S nᵀ.
pub(crate) fn constrained_response(
    network: &Network,
    rods: &mut RodSystem,
    row: &Row,
    coordinates: usize,
) -> Vec<f64> {
    let mut column = vec![0.0; coordinates];
    for (p, n) in row.entries() {
        let inertia = network.inertia_per_coordinate(p);
        for axis in 0..3 {
            column[3 * p + axis] = n[axis] / inertia[axis];
        }
    }
    // M⁻¹ n less what would change the rods: S n.
    let mut multipliers = vec![0.0; rods.len()];
    rods.apply(&column, &mut multipliers);
    rods.solve(&mut multipliers);
    rods.add_response(&multipliers, -1.0, &mut column);
    column
}

/// Refuses a restitution outside 0 to 1.
pub(crate) fn check_restitution(value: f64) -> Result<()> {
    let holds = (0.0..=1.0).contains(&value);
    require("restitution", value, holds, "between 0 and 1")
}
