//! `log.csv`: what a run looks like from step to step.

use super::mover::Mover;
use super::start::spread;
use anyhow::{Context, Result, bail};
use protomer_crystal::lattice::{Network, State};
use std::path::Path;

/// One row of the log. Reduced units.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct LogRow {
    /// Steps done.
    pub step: u64,
    /// Time.
    pub time: f64,
    /// Kinetic energy.
    pub kinetic_energy: f64,
    /// Energy of the potentials.
    pub potential_energy: f64,
    /// Their sum.
    pub energy: f64,
    /// ⟨θ⟩₀, the mean orientation.
    pub uniform: f64,
    /// ⟨θ⟩₁, the mean of (-1)^(i+j) θ.
    pub checkerboard: f64,
    /// Share of the checkerboard mode in the rotational energy, without that of the uniform mode; NaN where nothing turns.
    pub checkerboard_fraction: f64,
    /// Standard deviation of (-1)^(i+j) θ over the squares.
    pub angle_spread: f64,
    /// Strain along x since the start.
    pub strain_xx: f64,
    /// Strain along y since the start.
    pub strain_yy: f64,
    /// Shear since the start.
    pub strain_xy: f64,
    /// Largest deviation of a rod from its length.
    pub rod_violation: f64,
    /// Collisions so far.
    pub events: u64,
}

/// A column: its name and its number in a row.
type Column = (&'static str, fn(&LogRow) -> f64, fn(&mut LogRow) -> &mut f64);

macro_rules! columns {
    ($($name:ident),*) => { [$((stringify!($name), |row| row.$name, |row| &mut row.$name)),*] };
}

/// The columns between `step` and `events`.
const NUMBERS: [Column; 12] = columns![
    time,
    kinetic_energy,
    potential_energy,
    energy,
    uniform,
    checkerboard,
    checkerboard_fraction,
    angle_spread,
    strain_xx,
    strain_yy,
    strain_xy,
    rod_violation
];

/// The names of the columns, in order.
pub fn columns() -> Vec<&'static str> {
    let numbers = NUMBERS.iter().map(|(name, ..)| *name);
    std::iter::once("step").chain(numbers).chain(std::iter::once("events")).collect()
}

impl LogRow {
    /// What there is to say of a state; strains are against `start`.
    pub fn new(step: u64, mover: &mut Mover, state: &State, start: &State) -> Self {
        let network = mover.network().clone();
        let kinetic_energy = state.kinetic_energy(&network);
        let potential_energy = mover.potential_energy();
        let [strain_xx, strain_yy, strain_xy] = strain(start, state);
        let [uniform, checkerboard] = modes(&network, &state.positions);
        Self {
            step,
            time: state.time,
            kinetic_energy,
            potential_energy,
            energy: kinetic_energy + potential_energy,
            uniform,
            checkerboard,
            checkerboard_fraction: checkerboard_fraction(&network, state),
            angle_spread: spread(&network, state),
            strain_xx,
            strain_yy,
            strain_xy,
            rod_violation: mover.rod_violation(state),
            events: mover.events(),
        }
    }

    /// The row as a line of the log. Rust prints the shortest decimal that reads back as the same number.
    pub fn to_line(&self) -> String {
        let numbers = NUMBERS.iter().map(|(_, number, _)| number(self).to_string());
        let cells = std::iter::once(self.step.to_string()).chain(numbers).chain([self.events.to_string()]);
        cells.collect::<Vec<_>>().join(",")
    }

    fn from_line(line: &str) -> Option<Self> {
        let mut cells = line.split(',');
        let mut row = Self { step: cells.next()?.parse().ok()?, ..Self::default() };
        for (_, _, place) in NUMBERS {
            *place(&mut row) = cells.next()?.parse().ok()?;
        }
        row.events = cells.next()?.parse().ok()?;
        cells.next().is_none().then_some(row)
    }
}

/// Reads a log.
///
/// # Errors
/// Names the file and line that is not a row.
pub fn read_log(path: &Path) -> Result<Vec<LogRow>> {
    let text = std::fs::read_to_string(path).with_context(|| format!("cannot read the log {}", path.display()))?;
    let mut rows = Vec::new();
    for (index, line) in text.lines().enumerate().skip(1) {
        match LogRow::from_line(line) {
            Some(row) => rows.push(row),
            None => bail!("{}:{}: '{line}' is not a row of a log; run again with --force", path.display(), index + 1),
        }
    }
    Ok(rows)
}

/// Means over the squares of x₃ and of (-1)^(i+j) x₃.
fn modes(network: &Network, x: &[f64]) -> [f64; 2] {
    let count = network.squares.len() as f64;
    let thirds = || x.iter().skip(2).step_by(3).enumerate();
    let uniform = thirds().map(|(_, x)| x).sum::<f64>() / count;
    let checkerboard = thirds().map(|(p, x)| network.sign(p) * x).sum::<f64>() / count;
    [uniform, checkerboard]
}

/// n ⟨ω⟩₁² / (Σ ω² - n ⟨ω⟩₀²): modes of equal inertia are orthogonal, so their energies add up.
fn checkerboard_fraction(network: &Network, state: &State) -> f64 {
    let count = network.squares.len() as f64;
    let [uniform, checkerboard] = modes(network, &state.velocities);
    let total: f64 = state.velocities.iter().skip(2).step_by(3).map(|omega| omega * omega).sum();
    let without_uniform = total - count * uniform * uniform;
    if without_uniform > 1e-14 * total { count * checkerboard * checkerboard / without_uniform } else { f64::NAN }
}

/// (Fᵀ F)^½ - 1 of the deformation gradient F that takes the centres from one state to another with the least squares of
/// error; xx, yy, xy.
fn strain(from: &State, to: &State) -> [f64; 3] {
    use nalgebra::{Matrix2, SymmetricEigen, Vector2};
    let centre = |state: &State| {
        let count = (state.positions.len() / 3) as f64;
        let sum = state.positions.chunks_exact(3).fold(Vector2::zeros(), |sum, s| sum + Vector2::new(s[0], s[1]));
        sum / count
    };
    let (middle, other_middle) = (centre(from), centre(to));
    let (mut crossed, mut own) = (Matrix2::zeros(), Matrix2::zeros());
    for (s, t) in from.positions.chunks_exact(3).zip(to.positions.chunks_exact(3)) {
        let (x, y) = (Vector2::new(s[0], s[1]) - middle, Vector2::new(t[0], t[1]) - other_middle);
        crossed += y * x.transpose();
        own += x * x.transpose();
    }
    let Some(inverse) = own.try_inverse() else { return [f64::NAN; 3] };
    let gradient = crossed * inverse;
    let eigen = SymmetricEigen::new(gradient.transpose() * gradient);
    let stretch = eigen.eigenvectors
        * Matrix2::from_diagonal(&eigen.eigenvalues.map(|x| x.max(0.0).sqrt()))
        * eigen.eigenvectors.transpose();
    [stretch[(0, 0)] - 1.0, stretch[(1, 1)] - 1.0, stretch[(0, 1)]]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_survive_a_round_trip() {
        let row = LogRow { step: 3, time: 0.1 + 0.2, checkerboard_fraction: 0.5, events: 7, ..LogRow::default() };
        assert_eq!(LogRow::from_line(&row.to_line()), Some(row));
        assert_eq!(row.to_line().split(',').count(), columns().len());
        assert_eq!(LogRow::from_line("1,2,3"), None);
    }
}
