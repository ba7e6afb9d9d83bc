//! Distances of grid points from the surface.

use crate::grid::Grid;
use crate::poisson_boltzmann::Potential;
use rayon::prelude::*;

/// The distance of every grid point from the nearest grid point on the other side of the surface,
/// Å: right to about half a grid spacing.
pub struct SurfaceDistances {
    /// Distances of points outside from the inside; zero inside.
    pub outside_angstrom: Vec<f32>,
    /// Distances of points inside from the outside; zero outside.
    pub depth_angstrom: Vec<f32>,
}

impl SurfaceDistances {
    /// The distances on the grid of a potential.
    pub fn new(potential: &Potential) -> Self {
        let (grid, inside) = (potential.grid(), potential.inside());
        let outside: Vec<bool> = inside.iter().map(|inside| !inside).collect();
        // Half a spacing lies between the last point of one side and the surface.
        let half = 0.5 * grid.spacing_angstrom as f32;
        let from = |marked: &[bool]| -> Vec<f32> {
            let mut distances = distance_from(grid, marked);
            for distance in &mut distances {
                *distance = (*distance - half).max(0.0);
            }
            distances
        };
        Self {
            outside_angstrom: from(inside),
            depth_angstrom: from(&outside),
        }
    }
}

/// The Euclidean distance of every point from the nearest marked one, Å, by three passes of the
/// lower envelope of parabolas (Felzenszwalb and Huttenlocher, Theory of Computing 8, 415 (2012)).
fn distance_from(grid: &Grid, marked: &[bool]) -> Vec<f32> {
    // Farther than any distance on a grid, and its square still finite.
    const FAR: f32 = 1e12;
    let mut squares: Vec<f32> = marked
        .iter()
        .map(|marked| if *marked { 0.0 } else { FAR })
        .collect();
    let strides = grid.strides();
    for (length, stride) in grid.shape.into_iter().zip(strides) {
        let lines: Vec<usize> = (0..grid.len())
            .filter(|point| (point / stride) % length == 0)
            .collect();
        let new: Vec<Vec<f32>> = lines
            .par_iter()
            .map(|start| {
                let line: Vec<f32> = (0..length).map(|i| squares[start + i * stride]).collect();
                lower_envelope(&line)
            })
            .collect();
        for (start, line) in lines.iter().zip(&new) {
            for (i, value) in line.iter().enumerate() {
                squares[start + i * stride] = *value;
            }
        }
    }
    let spacing = grid.spacing_angstrom as f32;
    for square in &mut squares {
        *square = square.sqrt() * spacing;
    }
    squares
}

/// min_j f(j) + (i - j)² for every i.
fn lower_envelope(f: &[f32]) -> Vec<f32> {
    let mut parabolas: Vec<usize> = vec![0];
    let mut starts: Vec<f32> = vec![f32::NEG_INFINITY];
    for j in 1..f.len() {
        let crossing = |k: usize| {
            let (j_, k_) = (j as f32, k as f32);
            ((f[j] + j_ * j_) - (f[k] + k_ * k_)) / (2.0 * (j_ - k_))
        };
        let mut start = crossing(parabolas[parabolas.len() - 1]);
        while parabolas.len() > 1 && start <= starts[starts.len() - 1] {
            parabolas.pop();
            starts.pop();
            start = crossing(parabolas[parabolas.len() - 1]);
        }
        parabolas.push(j);
        starts.push(start);
    }
    let mut values = Vec::with_capacity(f.len());
    let mut current = 0;
    for i in 0..f.len() {
        while current + 1 < parabolas.len() && starts[current + 1] < i as f32 {
            current += 1;
        }
        let j = parabolas[current];
        let apart = i as f32 - j as f32;
        values.push(f[j] + apart * apart);
    }
    values
}

#[cfg(test)]
mod tests {
    use super::*;
    use protomer_kernel::Vec3;
    use protomer_kernel::random::CounterRng;

    #[test]
    fn distances_are_those_of_all_pairs() {
        let grid = Grid::around(&Vec3::zeros(), &Vec3::new(7.0, 5.0, 9.0), 1.0, 1).unwrap();
        let mut rng = CounterRng::new(1, 0, 0);
        let marked: Vec<bool> = (0..grid.len()).map(|_| rng.uniform() < 0.02).collect();
        assert!(marked.iter().any(|marked| *marked));
        let fast = distance_from(&grid, &marked);
        for (point, distance) in fast.iter().enumerate() {
            let mut least = f64::INFINITY;
            for (other, is_marked) in marked.iter().enumerate() {
                if *is_marked {
                    least = least.min((grid.point_at(point) - grid.point_at(other)).norm());
                }
            }
            assert!((f64::from(*distance) - least).abs() < 1e-4);
        }
    }
}
