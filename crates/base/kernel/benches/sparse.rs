//! Factorisation and solution of elastic networks on a grid, in processor time of one core:
//!
//! ```text
//! cargo bench -p protomer-kernel --bench sparse
//! ```
//!
//! Nodes are coupled to their nearest and diagonal neighbours, with two unknowns each in the plane
//! and three in space.

#![allow(clippy::unwrap_used, clippy::print_stdout)]

mod cpu_time;

use cpu_time::{are_requested, cpu_seconds, seconds_per_call};
use protomer_kernel::random::CounterRng;
use protomer_kernel::sparse::LdlFactor;

fn main() {
    if !are_requested() {
        return;
    }
    println!(
        "grid unknowns | s: prepare factor solve | fill per unknown, multiplications, fronts | \
         residual"
    );
    for (size, unknowns) in [
        ([100, 100, 1], 2),
        ([316, 316, 1], 2),
        ([12, 12, 12], 3),
        ([20, 20, 20], 3),
    ] {
        let network = Network::new(size, unknowns);
        println!("{size:?} {}", network.measure());
    }
}

/// A symmetric positive definite system.
struct Network {
    entries: Vec<(usize, usize)>,
    numbers: Vec<f64>,
    places: Vec<[f64; 3]>,
    b: Vec<f64>,
}

impl Network {
    fn new([columns, rows, layers]: [usize; 3], unknowns: usize) -> Self {
        let place = |node| {
            [
                node % columns,
                node / columns % rows,
                node / (columns * rows),
            ]
        };
        let nodes = columns * rows * layers;
        // No node before this one is a neighbour.
        let reach = columns * rows * usize::from(layers > 1) + columns + 1;
        let mut entries = Vec::new();
        let mut places = Vec::new();
        for node in 0..nodes {
            for other in node.saturating_sub(reach)..=node {
                if are_neighbours(place(node), place(other)) {
                    add_block(&mut entries, node, other, unknowns);
                }
            }
            for _ in 0..unknowns {
                places.push(place(node).map(|x| x as f64));
            }
        }
        let mut rng = CounterRng::new(1, 0, 0);
        let mut number = |(row, column): &(usize, usize)| {
            if row == column {
                60.0
            } else {
                rng.uniform_in(-1.0, 1.0)
            }
        };
        let numbers = entries.iter().map(&mut number).collect();
        let b = places.iter().map(|_| rng.uniform_in(-1.0, 1.0)).collect();
        Self {
            entries,
            numbers,
            places,
            b,
        }
    }

    /// A line of the table.
    fn measure(&self) -> String {
        let begin = cpu_seconds();
        let unknowns = self.places.len();
        let mut factor = LdlFactor::new(unknowns, &self.entries, &self.places);
        let prepare = cpu_seconds() - begin;
        let factoring = seconds_per_call(|| factor.factor(&self.numbers).unwrap());
        let mut x = Vec::new();
        let solving = seconds_per_call(|| {
            x.clone_from(&self.b);
            factor.solve(&mut x);
        });
        format!(
            "{unknowns} | {prepare:.3} {factoring:.4} {solving:.5} | {:.1} {:.2e} {} | {:.0e}",
            factor.fill() as f64 / unknowns as f64,
            factor.multiplications(),
            factor.fronts(),
            self.largest_residual(&x)
        )
    }

    fn largest_residual(&self, x: &[f64]) -> f64 {
        let mut residual = self.b.clone();
        for (&(row, column), number) in self.entries.iter().zip(&self.numbers) {
            residual[row] -= number * x[column];
            if row != column {
                residual[column] -= number * x[row];
            }
        }
        residual.iter().fold(0.0, |largest, r| r.abs().max(largest))
    }
}

/// Whether two nodes coincide or are nearest or diagonal neighbours.
fn are_neighbours(a: [usize; 3], b: [usize; 3]) -> bool {
    (0..3).all(|axis| a[axis].abs_diff(b[axis]) <= 1)
}

/// Adds the places of the lower triangle that couple the unknowns of two nodes.
fn add_block(entries: &mut Vec<(usize, usize)>, here: usize, other: usize, unknowns: usize) {
    for row in unknowns * here..unknowns * (here + 1) {
        for column in unknowns * other..unknowns * (other + 1) {
            if column <= row {
                entries.push((row, column));
            }
        }
    }
}
