//! Which squares turn together, directly or through others.
//!
//! The synchronisation index of two squares is the time average (eq. 38 of the preprint)
//!
//! R_ab = ⟨exp i(θ_a - θ_b)⟩,
//!
//! 1 in absolute value if their angles keep their difference, near 0 if they are independent. Two
//! squares may also follow a third: what is left between them when the others are accounted for is
//! the partial phase synchronisation index, the partial coherence of the matrix R
//! (Schelter, Winterhalder, Dahlhaus, Kurths and Timmer, Phys. Rev. Lett. 96, 208103 (2006)),
//!
//! P_ab = -(R⁻¹)_ab / √((R⁻¹)_aa (R⁻¹)_bb),
//!
//! which is R_ab less its linear prediction from *all* others Z together, R_ab - R_aZ (R_ZZ)⁻¹
//! R_Zb, normalised by the same for a and b alone. Eq. 39 of the preprint as printed sums over
//! single Z instead, with R_ZZ = 1; it is kept as [`Synchronisation::printed_partial`], and is not
//! bounded by 1.
//!
//! The coherent motion turns neighbours oppositely, so their θ_a - θ_b is no constant.
//! [`staggered`] gives (-1)^(i+j) θ, of which coherent squares keep the difference.

use crate::error::{CrystalError, Result, require};
use crate::lattice::{Network, state};
use nalgebra::{Complex, DMatrix, DVector};
use protomer_kernel::statistics::RunningMoments;
use serde::{Deserialize, Serialize};

/// Eigenvalues below this many roundings per square of the largest are zero.
const ROUNDINGS: f64 = 16.0;

/// The angles of an array x, y, θ per square.
///
/// ```
/// use protomer_linkage::analysis::synchronisation::angles;
/// assert_eq!(angles(&[1.0, 2.0, 0.1, 3.0, 4.0, -0.1]), [0.1, -0.1]);
/// ```
pub fn angles(positions: &[f64]) -> Vec<f64> {
    state::angles(positions).collect()
}

/// (-1)^(i+j) θ of every square.
pub fn staggered(network: &Network, positions: &[f64]) -> Vec<f64> {
    let angles = state::angles(positions).enumerate();
    // A flexible cell comes after the squares.
    let squares = angles.take(network.squares.len());
    squares.map(|(p, angle)| network.sign(p) * angle).collect()
}

/// θ_a - θ_b of all pairs a < b, in the order (0, 1), (0, 2), ... (1, 2), ... The angles are those
/// of the motion, not brought back into one turn.
///
/// ```
/// use protomer_linkage::analysis::synchronisation::phase_differences;
/// assert_eq!(phase_differences(&[3.0, 1.0, 7.0]), [2.0, -4.0, -6.0]);
/// ```
pub fn phase_differences(angles: &[f64]) -> Vec<f64> {
    let mut differences = Vec::new();
    for (a, angle) in angles.iter().enumerate() {
        for other in &angles[a + 1..] {
            differences.push(angle - other);
        }
    }
    differences
}

/// The largest |θ_a - θ_b|: phases are locked within c (eq. 37 of the preprint) as long as it stays
/// below c.
///
/// ```
/// use protomer_linkage::analysis::synchronisation::largest_phase_difference;
/// assert_eq!(largest_phase_difference(&[3.0, 1.0, 7.0]), 6.0);
/// ```
pub fn largest_phase_difference(angles: &[f64]) -> f64 {
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for angle in angles {
        low = low.min(*angle);
        high = high.max(*angle);
    }
    (high - low).max(0.0)
}

/// √⟨(θ_a - θ_b)²⟩ over all pairs: √(2 n/(n-1)) times the standard deviation.
///
/// ```
/// use protomer_linkage::analysis::synchronisation::root_mean_square_difference;
/// assert!((root_mean_square_difference(&[0.1, 0.4]) - 0.3).abs() < 1e-15);
/// ```
pub fn root_mean_square_difference(angles: &[f64]) -> f64 {
    (2.0 * RunningMoments::in_two_passes(angles).variance()).sqrt()
}

/// Averages exp i(θ_a - θ_b) over a trajectory sample by sample, in constant memory.
///
/// ```
/// use protomer_linkage::analysis::synchronisation::Synchronisation;
/// let mut index = Synchronisation::new(3);
/// for step in 0..1000 {
///     let time = 0.01 * f64::from(step);
///     index.push(&[time, time + 0.5, -7.0 * time])?;
/// }
/// let index = index.index()?;
/// assert!((index[(0, 1)].norm() - 1.0).abs() < 1e-12 && index[(0, 2)].norm() < 0.05);
/// # Ok::<(), protomer_linkage::CrystalError>(())
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Synchronisation {
    squares: usize,
    samples: u64,
    /// Real and imaginary parts of Σ z_a z_b* for a > b, row after row.
    sums: Vec<[f64; 2]>,
}

impl Synchronisation {
    /// Averages for this many squares, without samples.
    pub fn new(squares: usize) -> Self {
        Self {
            squares,
            samples: 0,
            sums: vec![[0.0; 2]; squares * squares.saturating_sub(1) / 2],
        }
    }

    /// Averages over a whole trajectory of angles, one array per time.
    ///
    /// # Errors
    /// As [`Synchronisation::push`].
    pub fn of_trajectory<'a>(
        squares: usize,
        trajectory: impl IntoIterator<Item = &'a [f64]>,
    ) -> Result<Self> {
        let mut whole = Self::new(squares);
        for angles in trajectory {
            whole.push(angles)?;
        }
        Ok(whole)
    }

    /// Adds the angles at one time.
    ///
    /// # Errors
    /// [`CrystalError::BadState`] for another number of angles, [`CrystalError::NotFinite`] names
    /// the square.
    pub fn push(&mut self, angles: &[f64]) -> Result<()> {
        if angles.len() != self.squares {
            return Err(CrystalError::BadState(format!(
                "{} angles for {} squares",
                angles.len(),
                self.squares
            )));
        }
        if let Some(square) = angles.iter().position(|angle| !angle.is_finite()) {
            return Err(CrystalError::NotFinite {
                square,
                time: f64::NAN,
            });
        }
        let mut phases = Vec::with_capacity(angles.len());
        for angle in angles {
            phases.push([angle.cos(), angle.sin()]);
        }
        let mut sums = self.sums.iter_mut();
        for (a, [x, y]) in phases.iter().enumerate() {
            for ([u, v], sum) in phases[..a].iter().zip(sums.by_ref()) {
                sum[0] += x * u + y * v;
                sum[1] += y * u - x * v;
            }
        }
        self.samples += 1;
        Ok(())
    }

    /// Adds all samples of another trajectory of the same squares.
    ///
    /// ```
    /// use protomer_linkage::analysis::synchronisation::Synchronisation;
    /// let part = |angles: [f64; 2]| Synchronisation::of_trajectory(2, [&angles[..]]);
    /// let mut whole = part([0.0, 0.0])?;
    /// whole.merge(&part([0.0, std::f64::consts::PI])?)?;
    /// assert_eq!(whole.samples(), 2);
    /// assert!(whole.index()?[(0, 1)].norm() < 1e-12, "opposite phases cancel");
    /// # Ok::<(), protomer_linkage::CrystalError>(())
    /// ```
    ///
    /// # Errors
    /// [`CrystalError::BadState`] for another number of squares.
    pub fn merge(&mut self, other: &Self) -> Result<()> {
        if self.squares != other.squares {
            return Err(CrystalError::BadState(format!(
                "trajectories of {} and {} squares have no common average",
                self.squares, other.squares
            )));
        }
        self.samples += other.samples;
        for (ours, theirs) in self.sums.iter_mut().zip(&other.sums) {
            ours[0] += theirs[0];
            ours[1] += theirs[1];
        }
        Ok(())
    }

    /// Number of samples.
    pub fn samples(&self) -> u64 {
        self.samples
    }

    /// The matrix R, Hermitian with ones on the diagonal.
    ///
    /// # Errors
    /// [`CrystalError::BadState`] without samples.
    pub fn index(&self) -> Result<DMatrix<Complex<f64>>> {
        if self.samples == 0 {
            return Err(CrystalError::BadState(
                "a synchronisation index needs at least one sample".into(),
            ));
        }
        let mut index = DMatrix::identity(self.squares, self.squares);
        let mut sums = self.sums.iter();
        for a in 0..self.squares {
            for (b, sum) in (0..a).zip(sums.by_ref()) {
                let mean = Complex::new(sum[0], sum[1]) / self.samples as f64;
                index[(a, b)] = mean;
                index[(b, a)] = mean.conj();
            }
        }
        Ok(index)
    }

    /// The matrix P of partial coherences, Hermitian with ones on the diagonal. Take absolute
    /// values for the strength of the coupling.
    ///
    /// `ridge` ε replaces R by (1 - ε) R + ε 1 first: 0 for none. Squares that are fully
    /// synchronised, or fewer samples than squares, leave R without an inverse; a small ε then
    /// gives a defined, if arbitrary, answer.
    ///
    /// # Errors
    /// [`CrystalError::BadState`] for R without an inverse, [`CrystalError::BadSetting`] for ε
    /// outside 0 to 1.
    pub fn partial(&self, ridge: f64) -> Result<DMatrix<Complex<f64>>> {
        let holds = (0.0..=1.0).contains(&ridge);
        require("ridge", ridge, holds, "between 0 and 1")?;
        let mut index = self.index()?;
        let identity = DMatrix::<Complex<f64>>::identity(self.squares, self.squares);
        index = index * Complex::new(1.0 - ridge, 0.0) + identity * Complex::new(ridge, 0.0);
        let inverse = self.inverse(index)?;
        let scale = |a: usize| inverse[(a, a)].re;
        let mut partial = DMatrix::identity(self.squares, self.squares);
        for a in 0..self.squares {
            for b in (0..self.squares).filter(|b| *b != a) {
                partial[(a, b)] = -inverse[(a, b)] / (scale(a) * scale(b)).sqrt();
            }
        }
        Ok(partial)
    }

    /// R⁻¹ from eigenvalues and eigenvectors.
    fn inverse(&self, index: DMatrix<Complex<f64>>) -> Result<DMatrix<Complex<f64>>> {
        let eigen = index.symmetric_eigen();
        let (least, largest) = (eigen.eigenvalues.min(), eigen.eigenvalues.max());
        let resolution = ROUNDINGS * f64::EPSILON * self.squares as f64;
        if least.is_nan() || least <= resolution * largest {
            return Err(CrystalError::BadState(format!(
                "the synchronisation matrix of {} squares from {} samples has no inverse \
                 (eigenvalues from {least:.1e} to {largest:.1e}): take more samples than squares, \
                 or a small ridge if squares are locked together",
                self.squares, self.samples
            )));
        }
        let mut reciprocals = DVector::zeros(self.squares);
        for (reciprocal, value) in reciprocals.iter_mut().zip(eigen.eigenvalues.iter()) {
            *reciprocal = Complex::new(1.0 / value, 0.0);
        }
        let diagonal = DMatrix::from_diagonal(&reciprocals);
        Ok(&eigen.eigenvectors * diagonal * eigen.eigenvectors.adjoint())
    }

    /// Eq. 39 of the preprint as printed, R_ab - Σ_Z R_aZ (R_ZZ)⁻¹ R_Zb over single squares Z other
    /// than a and b.
    ///
    /// # Errors
    /// As [`Synchronisation::index`].
    pub fn printed_partial(&self) -> Result<DMatrix<Complex<f64>>> {
        let index = self.index()?;
        let square = &index * &index;
        // The sum over all Z holds R_aa R_ab + R_ab R_bb for a ≠ b, and R_aa² once for a = b.
        Ok(DMatrix::from_fn(self.squares, self.squares, |a, b| {
            let multiplicity = if a == b { 2.0 } else { 3.0 };
            index[(a, b)] * multiplicity - square[(a, b)]
        }))
    }
}

/// The eigenvalues of a Hermitian matrix, the largest first (fig. 5c of the preprint shows the
/// first).
///
/// ```
/// use nalgebra::{Complex, DMatrix};
/// use protomer_linkage::analysis::synchronisation::eigenvalues;
/// let entries = [2.0, 1.0, 1.0, 2.0].map(|real| Complex::new(real, 0.0));
/// let values = eigenvalues(&DMatrix::from_row_slice(2, 2, &entries));
/// assert!((values[0] - 3.0).abs() < 1e-12 && (values[1] - 1.0).abs() < 1e-12);
/// ```
pub fn eigenvalues(matrix: &DMatrix<Complex<f64>>) -> Vec<f64> {
    let values = matrix.clone().symmetric_eigenvalues();
    let mut values = values.as_slice().to_vec();
    values.sort_by(|a, b| b.total_cmp(a));
    values
}

/// The leading eigenvalue of the matrix of magnitudes, over the number of squares: 1 if all squares
/// turn as one.
///
/// Of the magnitudes: P itself, with ones on its diagonal, is 2 less a normalised inverse, whose
/// smallest eigenvalue is near 0 wherever squares hold together, so that its own leading eigenvalue
/// is 2 whatever they do.
///
/// ```
/// use nalgebra::{Complex, DMatrix};
/// use protomer_linkage::analysis::synchronisation::leading_eigenvalue;
/// let one = Complex::new(1.0, 0.0);
/// assert!((leading_eigenvalue(&DMatrix::from_element(4, 4, one)) - 1.0).abs() < 1e-12);
/// assert!((leading_eigenvalue(&DMatrix::identity(4, 4)) - 0.25).abs() < 1e-12);
/// ```
pub fn leading_eigenvalue(matrix: &DMatrix<Complex<f64>>) -> f64 {
    let magnitudes = matrix.map(|entry| entry.norm());
    magnitudes.symmetric_eigenvalues().max() / matrix.nrows() as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use protomer_kernel::random::CounterRng;

    fn trajectory(squares: usize, samples: usize) -> Vec<Vec<f64>> {
        let mut rng = CounterRng::new(9, 0, 0);
        let mut angles = vec![0.0; squares];
        let mut frames = Vec::new();
        for _ in 0..samples {
            let common = rng.uniform_in(-1.0, 1.0);
            angles
                .iter_mut()
                .for_each(|angle| *angle += common + rng.uniform_in(-0.3, 0.3));
            // Keeps the differences bounded, so that they are correlated.
            let mean = angles.iter().sum::<f64>() / squares as f64;
            angles
                .iter_mut()
                .for_each(|angle| *angle += 0.2 * (mean - *angle));
            frames.push(angles.clone());
        }
        frames
    }

    #[test]
    fn the_stream_agrees_with_the_definition() {
        let frames = trajectory(5, 300);
        let index = Synchronisation::of_trajectory(5, frames.iter().map(Vec::as_slice))
            .unwrap()
            .index()
            .unwrap();
        for a in 0..5 {
            for b in 0..5 {
                let terms = frames
                    .iter()
                    .map(|frame| Complex::from_polar(1.0, frame[a] - frame[b]));
                let mean = terms.sum::<Complex<f64>>() / 300.0;
                assert!((index[(a, b)] - mean).norm() < 1e-13);
            }
        }
        let mut halves =
            Synchronisation::of_trajectory(5, frames[..100].iter().map(Vec::as_slice)).unwrap();
        let rest =
            Synchronisation::of_trajectory(5, frames[100..].iter().map(Vec::as_slice)).unwrap();
        halves.merge(&rest).unwrap();
        assert!((halves.index().unwrap() - index).norm() < 1e-13);
    }

    /// The Schur complement, pair by pair: what is left of the 2 x 2 block of a and b after all
    /// others.
    #[test]
    fn partial_coherence_is_the_normalised_schur_complement() {
        let squares = 6;
        let frames = trajectory(squares, 400);
        let sync =
            Synchronisation::of_trajectory(squares, frames.iter().map(Vec::as_slice)).unwrap();
        let (index, partial) = (sync.index().unwrap(), sync.partial(0.0).unwrap());
        for a in 0..squares {
            for b in 0..squares {
                if a == b {
                    continue;
                }
                let others: Vec<usize> = (0..squares).filter(|z| *z != a && *z != b).collect();
                let pick = |rows: &[usize], columns: &[usize]| {
                    DMatrix::from_fn(rows.len(), columns.len(), |r, c| {
                        index[(rows[r], columns[c])]
                    })
                };
                let solved = pick(&others, &others)
                    .lu()
                    .solve(&pick(&others, &[a, b]))
                    .unwrap();
                let left = pick(&[a, b], &[a, b]) - pick(&[a, b], &others) * solved;
                let expected = left[(0, 1)] / (left[(0, 0)].re * left[(1, 1)].re).sqrt();
                assert!((partial[(a, b)] - expected).norm() < 1e-10);
            }
        }
        assert!(partial.iter().all(|entry| entry.norm() <= 1.0 + 1e-12));
    }

    #[test]
    fn a_chain_is_coupled_directly_to_its_neighbours_only() {
        // Each square follows the one before: 0 and 2 are synchronised through 1.
        let mut rng = CounterRng::new(4, 0, 0);
        let mut sync = Synchronisation::new(3);
        for _ in 0..20_000 {
            let first = rng.uniform_in(-9.0, 9.0);
            let second = first + rng.uniform_in(-1.0, 1.0);
            sync.push(&[first, second, second + rng.uniform_in(-1.0, 1.0)])
                .unwrap();
        }
        let (index, partial) = (sync.index().unwrap(), sync.partial(0.0).unwrap());
        assert!(index[(0, 2)].norm() > 0.65);
        assert!(partial[(0, 2)].norm() < 0.03 && partial[(0, 1)].norm() > 0.5);
    }

    #[test]
    fn the_printed_formula_is_its_sum() {
        let frames = trajectory(4, 50);
        let sync = Synchronisation::of_trajectory(4, frames.iter().map(Vec::as_slice)).unwrap();
        let (index, printed) = (sync.index().unwrap(), sync.printed_partial().unwrap());
        for a in 0..4 {
            for b in 0..4 {
                let others = (0..4).filter(|z| *z != a && *z != b);
                let sum: Complex<f64> = others.map(|z| index[(a, z)] * index[(z, b)]).sum();
                assert!((printed[(a, b)] - (index[(a, b)] - sum)).norm() < 1e-14);
            }
        }
    }

    #[test]
    fn eigenvalues_sum_to_the_number_of_squares() {
        let frames = trajectory(6, 200);
        let sync = Synchronisation::of_trajectory(6, frames.iter().map(Vec::as_slice)).unwrap();
        let values = eigenvalues(&sync.index().unwrap());
        assert!((values.iter().sum::<f64>() - 6.0).abs() < 1e-12);
        assert!(values.windows(2).all(|pair| pair[0] >= pair[1]) && values[5] > -1e-14);
        // Locked squares have all weight in one eigenvalue, and no inverse.
        let mut locked = Synchronisation::new(4);
        (0..50).for_each(|step| {
            locked
                .push(&[0.1, 0.4, 0.2, 0.7].map(|x| x + f64::from(step)))
                .unwrap()
        });
        assert!((eigenvalues(&locked.index().unwrap())[0] - 4.0).abs() < 1e-12);
        assert!(locked.partial(0.0).is_err() && locked.partial(1e-3).is_ok());
        assert!(Synchronisation::new(2).index().is_err() && locked.push(&[0.0]).is_err());
    }

    #[test]
    fn differences_are_of_all_pairs() {
        assert_eq!(phase_differences(&[3.0, 1.0, 0.5]), [2.0, 2.5, 0.5]);
        assert_eq!(largest_phase_difference(&[3.0, 1.0, 0.5]), 2.5);
        assert_eq!(largest_phase_difference(&[]), 0.0);
    }
}
