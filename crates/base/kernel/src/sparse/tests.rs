//! The factorisation against dense elimination and against its slow twin.

use super::factorisation::factor_fronts;
use super::solution::solve_fronts;
use super::up_looking::UpLooking;
use super::{LdlFactor, SparseError};
use crate::random::CounterRng;
use nalgebra::{DMatrix, DVector};

#[test]
fn solutions_are_those_of_dense_elimination() {
    let mut rng = CounterRng::new(5, 0, 0);
    for dimension in [1, 2, 7, 30, 90] {
        let places: Vec<[f64; 3]> = (0..dimension)
            .map(|_| rng.vector_in_ball(1.0).into())
            .collect();
        let mut entries: Vec<(usize, usize)> = (0..dimension).map(|i| (i, i)).collect();
        for row in 1..dimension {
            for column in 0..row {
                if rng.uniform_in(0.0, 1.0) < 4.0 / dimension as f64 {
                    entries.push((row, column));
                }
            }
        }
        let mut factor = LdlFactor::new(dimension, &entries, &places);
        // The same pattern with other numbers, twice.
        for _ in 0..2 {
            let mut number = |(i, j): &(usize, usize)| {
                if i == j {
                    12.0 + rng.uniform()
                } else {
                    rng.uniform_in(-1.0, 1.0)
                }
            };
            let numbers: Vec<f64> = entries.iter().map(&mut number).collect();
            let mut dense = DMatrix::zeros(dimension, dimension);
            for (&(i, j), number) in entries.iter().zip(&numbers) {
                dense[(i, j)] = *number;
                dense[(j, i)] = *number;
            }
            let b = DVector::from_fn(dimension, |_, _| rng.uniform_in(-1.0, 1.0));
            let mut x = b.as_slice().to_vec();
            factor.factor(&numbers).unwrap();
            factor.solve(&mut x);
            let residual = &dense * DVector::from_vec(x) - &b;
            assert!(residual.amax() < 1e-13, "{dimension}: {}", residual.amax());
            assert!((factor.log_determinant() - dense.determinant().ln()).abs() < 1e-9);
        }
    }
}

/// Nodes on a grid with `unknowns` each, coupled to their neighbours in all directions, around
/// the edges along x.
fn grid(size: [usize; 3], unknowns: usize) -> (Vec<(usize, usize)>, Vec<[f64; 3]>) {
    let node = |i: usize, j: usize, k: usize| (i * size[1] + j) * size[2] + k;
    let (mut entries, mut places) = (Vec::new(), Vec::new());
    for (i, j, k) in cells(size) {
        let cell = node(i, j, k);
        let around = node((i + 1) % size[0], j, k);
        let mut others = vec![cell, around];
        if j + 1 < size[1] {
            others.extend([node(i, j + 1, k), node((i + 1) % size[0], j + 1, k)]);
        }
        if k + 1 < size[2] {
            others.push(node(i, j, k + 1));
        }
        for other in others {
            for a in 0..unknowns {
                for b in 0..unknowns {
                    let (row, column) = (unknowns * cell + a, unknowns * other + b);
                    entries.push((row.max(column), row.min(column)));
                }
            }
        }
        places.extend(vec![[i as f64, j as f64, k as f64]; unknowns]);
    }
    entries.sort_unstable();
    entries.dedup();
    (entries, places)
}

fn cells([nx, ny, nz]: [usize; 3]) -> Vec<(usize, usize, usize)> {
    let cell = |index| (index / (ny * nz), index / nz % ny, index % nz);
    (0..nx * ny * nz).map(cell).collect()
}

#[test]
fn dissection_keeps_fill_below_half_of_a_band() {
    // A band of n² unknowns, ring by ring around a cylinder, has a half-width of n.
    let n = 100;
    let (entries, places) = grid([n, n, 1], 1);
    let factor = LdlFactor::new(n * n, &entries, &places);
    let band = n * n * n;
    assert!(2 * factor.fill() < band, "{} of {band}", factor.fill());
}

#[test]
fn planar_and_spatial_networks_are_solved_as_row_by_row() {
    let mut rng = CounterRng::new(6, 0, 0);
    for (size, unknowns) in [
        ([3, 1, 1], 1),
        ([23, 17, 1], 1),
        ([30, 41, 1], 2),
        ([7, 8, 9], 3),
        ([500, 1, 1], 3),
    ] {
        let (entries, places) = grid(size, unknowns);
        let dimension = places.len();
        let mut factor = LdlFactor::new(dimension, &entries, &places);
        let mut twin = UpLooking::new(dimension, &entries, &places);
        // A sum of squares of differences, weakly held in place: the smallest eigenvalues are
        // near 0.01.
        let mut numbers = vec![0.0; entries.len()];
        let mut diagonal = vec![0.01; dimension];
        for (&(row, column), number) in entries.iter().zip(&mut numbers) {
            if row != column {
                let stiffness = rng.uniform();
                *number = -stiffness;
                diagonal[row] += stiffness;
                diagonal[column] += stiffness;
            }
        }
        for (&(row, column), number) in entries.iter().zip(&mut numbers) {
            if row == column {
                *number = diagonal[row];
            }
        }
        factor.factor(&numbers).unwrap();
        twin.factor(&numbers).unwrap();
        assert!(factor.fill() >= twin.fill() && factor.fronts() <= dimension);
        assert!(factor.multiplications() > 0.0);
        let b: Vec<f64> = (0..dimension).map(|_| rng.uniform_in(-1.0, 1.0)).collect();
        let (mut x, mut y) = (b.clone(), b.clone());
        factor.solve(&mut x);
        twin.solve(&mut y);
        let (mut largest, mut worst) = (0.0_f64, 0.0_f64);
        for (x, y) in x.iter().zip(&y) {
            largest = largest.max(y.abs());
            worst = worst.max((x - y).abs());
        }
        assert!(worst < 1e-12 * largest, "{size:?}: {worst} of {largest}");
        let (determinant, expected) = (factor.log_determinant(), twin.log_determinant());
        assert!(
            (determinant - expected).abs() < 1e-13 * dimension as f64,
            "{size:?}: {determinant} {expected}"
        );
        // The same bits again, whatever was factored in between.
        let other: Vec<f64> = numbers.iter().map(|number| 2.0 * number).collect();
        factor.factor(&other).unwrap();
        factor.factor(&numbers).unwrap();
        let mut again = b.clone();
        factor.solve(&mut again);
        assert_eq!(again, x);
    }
}

#[test]
fn every_instruction_set_gives_the_same_bits() {
    let (entries, places) = grid([19, 14, 1], 2);
    let mut rng = CounterRng::new(7, 0, 0);
    let mut number = |(row, column): &(usize, usize)| {
        if row == column {
            25.0
        } else {
            rng.uniform_in(-1.0, 1.0)
        }
    };
    let numbers: Vec<f64> = entries.iter().map(&mut number).collect();
    let mut factor = LdlFactor::new(places.len(), &entries, &places);
    factor.factor(&numbers).unwrap();
    let mut x: Vec<f64> = (0..places.len())
        .map(|_| rng.uniform_in(-1.0, 1.0))
        .collect();
    let mut portable = x.clone();
    factor.solve(&mut x);
    factor_fronts(&factor.symbolic, &mut factor.numbers, &numbers).unwrap();
    solve_fronts(&factor.symbolic, &mut factor.numbers, &mut portable);
    assert_eq!(x, portable);
}

#[test]
fn a_dependent_row_is_named() {
    let mut factor = LdlFactor::new(2, &[(0, 0), (1, 0), (1, 1)], &[[0.0; 3]; 2]);
    let error = factor.factor(&[1.0, 2.0, 4.0]).unwrap_err();
    assert!(
        matches!(error, SparseError::Dependent { row: 0 | 1, .. }),
        "{error}"
    );
    assert!(matches!(
        factor.factor(&[1.0, f64::NAN, 4.0]).unwrap_err(),
        SparseError::NotFinite { .. }
    ));
    factor.factor(&[2.0, 1.0, 2.0]).unwrap();
}
