//! The wave vectors of a periodic box: those whose wavelengths fit into it.

use protomer_kernel::Vec3;
use protomer_kernel::random::CounterRng;
use std::collections::BTreeSet;
use std::f64::consts::{PI, TAU};

/// Wave vectors of similar length.
#[derive(Debug, Clone, PartialEq)]
pub struct Shell {
    /// Mean length of the vectors, Å⁻¹.
    pub q_per_angstrom: f64,
    /// The vectors, one of each pair q, -q.
    pub vectors: Vec<Vec3>,
}

/// Shells with many more vectors than are wanted are drawn from, not listed.
const LISTED_PER_WANTED: f64 = 4.0;
/// Draws for each wanted vector, before a shell is left with fewer.
const DRAWS_PER_VECTOR: usize = 100;

/// The wave vectors 2π (n_x/L_x, n_y/L_y, n_z/L_z) of a box up to a length, in `count` shells of
/// equal width. A shell with more than `most` vectors has `most` of them, drawn with this seed; one
/// without any is left out.
///
/// ```
/// use protomer_mc::scattering::wave_vectors::shells;
/// let found = shells([100.0; 3], 0.08, 2, 50, 1);
/// // None is shorter than 0.04; of the six of length 2π/100 three stand for all.
/// assert_eq!((found.len(), found[0].vectors.len()), (1, 3));
/// ```
pub fn shells(
    lengths_angstrom: [f64; 3],
    largest_q_per_angstrom: f64,
    count: usize,
    most: usize,
    seed: u64,
) -> Vec<Shell> {
    let width = largest_q_per_angstrom / count as f64;
    let steps = lengths_angstrom.map(|length| TAU / length);
    let volume: f64 = lengths_angstrom.iter().product();
    let mut shells = Vec::new();
    for shell in 0..count {
        let (low, high) = (width * shell as f64, width * (shell + 1) as f64);
        let expected = volume * (high.powi(3) - low.powi(3)) / (12.0 * PI * PI);
        let vectors = match expected > LISTED_PER_WANTED * most as f64 {
            true => drawn(
                steps,
                low,
                high,
                most,
                CounterRng::new(seed, shell as u32, 0),
            ),
            false => {
                let listed = listed(steps, low, high);
                thinned(listed, most, CounterRng::new(seed, shell as u32, 0))
            }
        };
        if vectors.is_empty() {
            continue;
        }
        let lengths: f64 = vectors.iter().map(Vec3::norm).sum();
        shells.push(Shell {
            q_per_angstrom: lengths / vectors.len() as f64,
            vectors,
        });
    }
    shells
}

/// All vectors of a shell (its lower end left out), of each pair q, -q one.
fn listed(steps: [f64; 3], low: f64, high: f64) -> Vec<Vec3> {
    let [nx, ny, nz] = steps.map(|step| (high / step).floor() as i64);
    let mut vectors = Vec::new();
    for x in 0..=nx {
        for y in -ny..=ny {
            for z in -nz..=nz {
                let number = [x, y, z];
                let vector = vector_of(steps, number);
                let length = vector.norm();
                if number > [0, 0, 0] && length > low && length <= high {
                    vectors.push(vector);
                }
            }
        }
    }
    vectors
}

fn vector_of(steps: [f64; 3], number: [i64; 3]) -> Vec3 {
    Vec3::from_fn(|axis, _| steps[axis] * number[axis] as f64)
}

/// A random choice without repetition.
fn thinned(mut vectors: Vec<Vec3>, most: usize, mut rng: CounterRng) -> Vec<Vec3> {
    for place in 0..most.min(vectors.len()) {
        let remaining = vectors.len() - place;
        let chosen = place + ((rng.uniform() * remaining as f64) as usize).min(remaining - 1);
        vectors.swap(place, chosen);
    }
    vectors.truncate(most);
    vectors
}

/// Vectors of a large shell at random: points of the shell, moved to the nearest wave vector.
fn drawn(steps: [f64; 3], low: f64, high: f64, most: usize, mut rng: CounterRng) -> Vec<Vec3> {
    let mut numbers = BTreeSet::new();
    for _ in 0..DRAWS_PER_VECTOR * most {
        if numbers.len() == most {
            break;
        }
        let cube = low.powi(3) + rng.uniform() * (high.powi(3) - low.powi(3));
        let point = rng.unit_vector() * cube.cbrt();
        let mut number = [0, 1, 2].map(|axis| (point[axis] / steps[axis]).round() as i64);
        if number < [0, 0, 0] {
            number = number.map(|part| -part);
        }
        let length = vector_of(steps, number).norm();
        if length > low && length <= high {
            numbers.insert(number);
        }
    }
    numbers
        .into_iter()
        .map(|number| vector_of(steps, number))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shells_hold_each_vector_of_the_box_once() {
        let lengths = [60.0, 70.0, 90.0];
        let steps = lengths.map(|length| TAU / length);
        let found = shells(lengths, 0.5, 5, 100_000, 1);
        let mut expected = 0;
        for x in -10_i64..=10 {
            for y in -10_i64..=10 {
                for z in -10_i64..=10 {
                    let length = vector_of(steps, [x, y, z]).norm();
                    expected += usize::from(length > 0.0 && length <= 0.5);
                }
            }
        }
        let count: usize = found.iter().map(|shell| shell.vectors.len()).sum();
        assert_eq!(2 * count, expected);
    }

    #[test]
    fn large_shells_are_drawn_without_repetition() {
        let found = shells([1000.0; 3], 0.3, 10, 20, 7);
        assert_eq!(found.len(), 10);
        for (number, shell) in found.iter().enumerate() {
            let (low, high) = (0.03 * number as f64, 0.03 * (number + 1) as f64);
            assert_eq!(shell.vectors.len(), 20);
            for (place, vector) in shell.vectors.iter().enumerate() {
                assert!(vector.norm() > low && vector.norm() <= high + 1e-12);
                let waves = vector * (1000.0 / TAU);
                assert!((waves - waves.map(f64::round)).norm() < 1e-9);
                assert!(
                    !shell.vectors[..place].contains(vector)
                        && !shell.vectors[..place].contains(&-vector)
                );
            }
        }
        assert_ne!(found, shells([1000.0; 3], 0.3, 10, 20, 8));
    }
}
