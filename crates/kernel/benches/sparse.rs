//! Factorisation and solution of elastic networks on a grid, in processor time of one core:
//!
//! ```text
//! cargo bench -p protomer-kernel --bench sparse
//! ```
//!
//! Nodes are coupled to their nearest and diagonal neighbours, with two unknowns each in the plane
//! and three in space.

#![allow(clippy::unwrap_used, clippy::print_stdout)]

use protomer_kernel::random::CounterRng;
use protomer_kernel::sparse::LdlFactor;
use std::time::Instant;

/// Processor time of this thread in seconds; where the system does not tell, the time since
/// `origin`.
fn thread_seconds(origin: Instant) -> f64 {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    let nanoseconds = text
        .split_whitespace()
        .next()
        .and_then(|word| word.parse::<f64>().ok());
    nanoseconds.map_or_else(|| origin.elapsed().as_secs_f64(), |count| 1e-9 * count)
}

fn main() {
    // Nothing is timed under `cargo test`.
    if !std::env::args().any(|argument| argument == "--bench") {
        return;
    }
    println!(
        "grid unknowns | s: prepare factor solve | fill per unknown, multiplications, fronts | residual"
    );
    for (size, unknowns) in [
        ([100, 100, 1], 2),
        ([316, 316, 1], 2),
        ([12, 12, 12], 3),
        ([20, 20, 20], 3),
    ] {
        let [columns, rows, layers] = size;
        let place = |node: usize| {
            [
                node % columns,
                node / columns % rows,
                node / (columns * rows),
            ]
        };
        let nodes = columns * rows * layers;
        let mut entries = Vec::new();
        let near = |a: usize, b: usize| a.abs_diff(b) <= 1;
        for here in 0..nodes {
            let [x, y, z] = place(here);
            let reach = columns * rows * usize::from(layers > 1) + columns + 1;
            for other in (here.saturating_sub(reach)..=here).filter(|other| {
                let [a, b, c] = place(*other);
                near(a, x) && near(b, y) && near(c, z)
            }) {
                for row in unknowns * here..unknowns * (here + 1) {
                    entries.extend(
                        (unknowns * other..=row.min(unknowns * other + unknowns - 1))
                            .map(|column| (row, column)),
                    );
                }
            }
        }
        let places: Vec<[f64; 3]> = (0..nodes * unknowns)
            .map(|unknown| place(unknown / unknowns).map(|x| x as f64))
            .collect();
        let mut rng = CounterRng::new(1, 0, 0);
        let numbers: Vec<f64> = entries
            .iter()
            .map(|(row, column)| {
                if row == column {
                    60.0
                } else {
                    rng.uniform_in(-1.0, 1.0)
                }
            })
            .collect();
        let b: Vec<f64> = (0..places.len())
            .map(|_| rng.uniform_in(-1.0, 1.0))
            .collect();
        let origin = Instant::now();
        let begin = thread_seconds(origin);
        let mut factor = LdlFactor::new(places.len(), &entries, &places);
        let prepare = thread_seconds(origin) - begin;
        let time = |work: &mut dyn FnMut()| {
            let mut best = f64::INFINITY;
            for _ in 0..3 {
                let (begin, mut calls) = (thread_seconds(origin), 0);
                while thread_seconds(origin) - begin < 0.25 {
                    work();
                    calls += 1;
                }
                best = best.min((thread_seconds(origin) - begin) / f64::from(calls));
            }
            best
        };
        let factoring = time(&mut || factor.factor(&numbers).unwrap());
        let mut x = Vec::new();
        let solving = time(&mut || {
            x.clone_from(&b);
            factor.solve(&mut x);
        });
        let mut residual = b.clone();
        for (&(row, column), number) in entries.iter().zip(&numbers) {
            residual[row] -= number * x[column];
            if row != column {
                residual[column] -= number * x[row];
            }
        }
        let residual = residual.iter().fold(0.0_f64, |worst, x| worst.max(x.abs()));
        println!(
            "{size:?} {} | {prepare:.3} {factoring:.4} {solving:.5} | {:.1} {:.2e} {} | {residual:.0e}",
            places.len(),
            factor.fill() as f64 / places.len() as f64,
            factor.multiplications(),
            factor.fronts(),
        );
    }
}
