//! Deformation, strain, Poisson's ratio.
//!
//! Points of a lattice at one time, A, and at another, B, are joined by the uniform deformation B =
//! F A + c that fits best (least squares): with the sums over points about their means, F = (Σ b
//! aᵀ)(Σ a aᵀ)⁻¹ (eq. 41 of the preprint). The strain is that of Biot, ε = (Fᵀ F)^(1/2) - 1 (eq.
//! 42), blind to how the lattice turns as a whole. A is the step before for increments of strain,
//! or a fixed state for all of it.
//!
//! Poisson's ratio follows from how the two strains of a fluctuating body vary together. The energy
//! of a small strain is V/2 ε C ε, so strains in equilibrium have the covariances s_ij = ⟨ε_i ε_j⟩ =
//! kT S_ij / V with the compliances S = C⁻¹. Under a load along x, ν_xy = -S_xy/S_xx, and therefore
//!
//! ν_xy = -s_xy/s_xx,   ν_yx = -s_xy/s_yy:
//!
//! minus the ordinary slope of ε_yy on ε_xx, and of ε_xx on ε_yy. The scatter about the slope is the
//! fluctuation itself and no error of measurement. In a lattice with a four-fold axis s_xx = s_yy,
//! and both ratios are -r, with r the correlation of the strains. Total least squares does not
//! measure this: the long axis of a cloud with s_xx = s_yy is a diagonal, whatever r is. Increments
//! of strain from one time to the next, as the preprint takes them, give the same ratios of the
//! strain rates. r² = s_xy²/(s_xx s_yy) = ν_xy ν_yx. Errors are those of the jackknife over blocks of
//! consecutive samples.

use crate::lattice::contact::layout::Layout;
use crate::lattice::{Cell, Corner, Network};
use crate::{CrystalError, Result};
use nalgebra::{Matrix2, Vector2};
use protomer_kernel::statistics::jackknife_error;
use serde::{Deserialize, Serialize};

/// A determinant below this share of the squared trace means that the points lie on one line.
const ON_ONE_LINE: f64 = 1e-12;

/// The centres of the squares.
///
/// ```
/// use protomer_linkage::analysis::strain::centres;
/// assert_eq!(centres(&[1.0, 2.0, 0.1, 3.0, 4.0, -0.1]), [[1.0, 2.0], [3.0, 4.0]]);
/// ```
pub fn centres(positions: &[f64]) -> Vec<[f64; 2]> {
    positions.chunks_exact(3).map(|s| [s[0], s[1]]).collect()
}

/// The corners of all squares, four per square.
pub fn corners(network: &Network, positions: &[f64]) -> Vec<[f64; 2]> {
    let layout = Layout::new(network, positions);
    let mut corners = Vec::with_capacity(4 * network.squares.len());
    for square in 0..network.squares.len() {
        for vertex in 1..=4 {
            corners.push(layout.place(Corner { square, vertex }));
        }
    }
    corners
}

/// The uniform deformation F that takes `before` to `after` best, `after` = F `before` + c.
///
/// ```
/// use protomer_linkage::analysis::strain::{biot_strain, deformation_gradient};
/// let before = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]];
/// let after = before.map(|[x, y]| [1.1 * x + 7.0, 0.9 * y]);
/// let strain = biot_strain(&deformation_gradient(&before, &after)?);
/// assert!((strain[(0, 0)] - 0.1).abs() < 1e-14 && (strain[(1, 1)] + 0.1).abs() < 1e-14);
/// # Ok::<(), protomer_linkage::CrystalError>(())
/// ```
///
/// # Errors
/// [`CrystalError::BadState`] for different numbers of points, or points on one line, as the
/// centres of a single row.
pub fn deformation_gradient(before: &[[f64; 2]], after: &[[f64; 2]]) -> Result<Matrix2<f64>> {
    if before.len() != after.len() || before.is_empty() {
        return Err(CrystalError::BadState(format!(
            "{} points before and {} after the deformation; give the same number, at least three",
            before.len(),
            after.len()
        )));
    }
    let (from, to) = (mean(before), mean(after));
    let (mut moments, mut mixed) = (Matrix2::zeros(), Matrix2::zeros());
    for (a, b) in before.iter().zip(after) {
        let (a, b) = (Vector2::from(*a) - from, Vector2::from(*b) - to);
        moments += a * a.transpose();
        mixed += b * a.transpose();
    }
    let flat = moments.determinant() <= ON_ONE_LINE * moments.trace().powi(2);
    let inverse = if flat { None } else { moments.try_inverse() };
    match inverse {
        Some(inverse) => Ok(mixed * inverse),
        None => Err(CrystalError::BadState(
            "the points lie on one line and show no strain across it; use the corners".into(),
        )),
    }
}

/// The deformation gradient between two arrays of positions of a network: that of a flexible cell,
/// or else of the corners of all squares.
///
/// ```
/// use protomer_linkage::analysis::strain::gradient_between;
/// use protomer_linkage::lattice::{Edges, Network, Square, State};
/// let network = Network::lattice(2, 2, 0.5, Square::default(), Edges::Periodic, 0.3)?;
/// let network = network.with_flexible_cell(1.0)?;
/// let before = State::coherent(&network, 0.3).positions;
/// let after = State::coherent(&network, 0.5).positions;
/// let gradient = gradient_between(&network, &before, &after)?;
/// assert!(gradient[(0, 0)] > 1.0 && (gradient[(0, 0)] - gradient[(1, 1)]).abs() < 1e-14);
/// # Ok::<(), protomer_linkage::CrystalError>(())
/// ```
///
/// # Errors
/// As [`deformation_gradient`].
pub fn gradient_between(network: &Network, before: &[f64], after: &[f64]) -> Result<Matrix2<f64>> {
    if network.cell_mass.is_some() {
        let first = Cell::read(network, before);
        return Ok(Cell::read(network, after).gradient_since(&first));
    }
    deformation_gradient(&corners(network, before), &corners(network, after))
}

fn mean(points: &[[f64; 2]]) -> Vector2<f64> {
    let mut sum = Vector2::zeros();
    for point in points {
        sum += Vector2::from(*point);
    }
    sum / points.len() as f64
}

/// Strain (Fᵀ F)^(1/2) - 1, symmetric.
///
/// The root of a symmetric positive 2 x 2 matrix C is (C + √det C) / √(tr C + 2 √det C).
///
/// ```
/// use nalgebra::Matrix2;
/// use protomer_linkage::analysis::strain::biot_strain;
/// let quarter_turn = Matrix2::new(0.0, -1.0, 1.0, 0.0);
/// assert!(biot_strain(&quarter_turn).norm() < 1e-12, "a rotation is no strain");
/// let stretched = biot_strain(&(quarter_turn * Matrix2::new(1.2, 0.0, 0.0, 1.0)));
/// assert!((stretched[(0, 0)] - 0.2).abs() < 1e-12);
/// ```
pub fn biot_strain(gradient: &Matrix2<f64>) -> Matrix2<f64> {
    let square = gradient.transpose() * gradient;
    let root_determinant = gradient.determinant().abs();
    let scale = (square.trace() + 2.0 * root_determinant).sqrt();
    (square + Matrix2::identity() * root_determinant) / scale - Matrix2::identity()
}

/// Poisson's ratio of a cloud of strains.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PoissonRatio {
    /// ν_xy = -s_xy/s_xx, the ratio for a load along x.
    pub xy: f64,
    /// Standard error of ν_xy.
    pub xy_error: f64,
    /// ν_yx = -s_xy/s_yy, the ratio for a load along y.
    pub yx: f64,
    /// Standard error of ν_yx.
    pub yx_error: f64,
    /// Squared correlation of ε_xx and ε_yy.
    pub r_squared: f64,
    /// Number of strains.
    pub samples: usize,
}

#[derive(Debug, Clone, Copy, Default)]
struct Sums {
    count: f64,
    x: f64,
    y: f64,
    xx: f64,
    xy: f64,
    yy: f64,
}

impl Sums {
    fn from_strains(strains: &[[f64; 2]], origin: [f64; 2]) -> Self {
        let mut sums = Self::default();
        for strain in strains {
            let (x, y) = (strain[0] - origin[0], strain[1] - origin[1]);
            sums.count += 1.0;
            sums.x += x;
            sums.y += y;
            sums.xx += x * x;
            sums.xy += x * y;
            sums.yy += y * y;
        }
        sums
    }

    fn less(&self, other: &Self) -> Self {
        Self {
            count: self.count - other.count,
            x: self.x - other.x,
            y: self.y - other.y,
            xx: self.xx - other.xx,
            xy: self.xy - other.xy,
            yy: self.yy - other.yy,
        }
    }

    /// s_xx, s_xy, s_yy.
    fn moments(&self) -> [f64; 3] {
        let about = |product: f64, a: f64, b: f64| (product - a * b / self.count) / self.count;
        [
            about(self.xx, self.x, self.x),
            about(self.xy, self.x, self.y),
            about(self.yy, self.y, self.y),
        ]
    }

    /// ν_xy and ν_yx.
    fn ratios(&self) -> [f64; 2] {
        let [xx, xy, yy] = self.moments();
        [-xy / xx, -xy / yy]
    }
}

/// Poisson's ratio from pairs (ε_xx, ε_yy) in the order of time, with errors from this many blocks
/// of them.
///
/// The error is meaningful if a block is much longer than the correlation time of the strains.
///
/// ```
/// use protomer_linkage::analysis::strain::poisson_ratio;
/// // An auxetic material: both strains grow together.
/// let strains: Vec<[f64; 2]> = (0..20).map(|k| [0.01 * f64::from(k), 0.008 * f64::from(k)]).collect();
/// let found = poisson_ratio(&strains, 4)?;
/// assert!((found.xy + 0.8).abs() < 1e-12 && (found.yx + 1.25).abs() < 1e-12);
/// # Ok::<(), protomer_linkage::CrystalError>(())
/// ```
///
/// # Errors
/// [`CrystalError::BadState`] for fewer than two samples a block, fewer than two blocks, or strains
/// without any spread.
pub fn poisson_ratio(strains: &[[f64; 2]], blocks: usize) -> Result<PoissonRatio> {
    let samples = strains.len();
    if blocks < 2 || samples < 2 * blocks {
        return Err(CrystalError::BadState(format!(
            "{samples} strains cannot be split into {blocks} blocks; take two blocks or more, of \
             two strains or more"
        )));
    }
    let origin = mean_strain(strains);
    let all = Sums::from_strains(strains, origin);
    let [xx, xy, yy] = all.moments();
    let spread_is_real = xx > 0.0 && yy > 0.0 && (xx + yy).is_finite();
    if !spread_is_real {
        return Err(CrystalError::BadState(
            "the strains do not vary along both axes, so there is no ratio".into(),
        ));
    }
    let mut without = Vec::with_capacity(blocks);
    for block in 0..blocks {
        let range = block * samples / blocks..(block + 1) * samples / blocks;
        let left_out = Sums::from_strains(&strains[range], origin);
        without.push(all.less(&left_out).ratios());
    }
    let error = |which: usize| {
        let ratios: Vec<f64> = without.iter().map(|ratios| ratios[which]).collect();
        jackknife_error(&ratios).unwrap_or(f64::NAN)
    };
    let [ratio_xy, ratio_yx] = all.ratios();
    Ok(PoissonRatio {
        xy: ratio_xy,
        xy_error: error(0),
        yx: ratio_yx,
        yx_error: error(1),
        r_squared: xy * xy / (xx * yy),
        samples,
    })
}

fn mean_strain(strains: &[[f64; 2]]) -> [f64; 2] {
    let (mut x, mut y) = (0.0, 0.0);
    for strain in strains {
        x += strain[0];
        y += strain[1];
    }
    let count = strains.len() as f64;
    [x / count, y / count]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice::{Edges, Square, State};
    use protomer_kernel::random::CounterRng;
    use protomer_kernel::statistics::RunningMoments;
    use std::f64::consts::FRAC_PI_4;

    #[test]
    fn a_uniform_deformation_is_recovered_and_turning_is_no_strain() {
        let stretch = Matrix2::new(1.2, 0.05, 0.05, 0.9);
        let (sine, cosine) = 0.8f64.sin_cos();
        let gradient = Matrix2::new(cosine, -sine, sine, cosine) * stretch;
        let mut rng = CounterRng::new(1, 0, 0);
        let before: Vec<[f64; 2]> = (0..20).map(|_| [rng.uniform(), rng.uniform()]).collect();
        let after: Vec<[f64; 2]> = before
            .iter()
            .map(|a| (gradient * Vector2::from(*a) + Vector2::new(3.0, -1.0)).into())
            .collect();
        let found = deformation_gradient(&before, &after).unwrap();
        assert!((found - gradient).norm() < 1e-13);
        let strain = biot_strain(&found);
        assert!((strain - (stretch - Matrix2::identity())).norm() < 1e-13);
        // The slow way: by eigenvalues.
        let eigen = (found.transpose() * found).symmetric_eigen();
        let root = eigen.eigenvectors
            * Matrix2::from_diagonal(&eigen.eigenvalues.map(f64::sqrt))
            * eigen.eigenvectors.transpose();
        assert!((strain - (root - Matrix2::identity())).norm() < 1e-13);
    }

    #[test]
    fn the_fit_is_the_least_of_squares() {
        let mut rng = CounterRng::new(2, 0, 0);
        let before: Vec<[f64; 2]> = (0..12).map(|_| [rng.uniform(), rng.uniform()]).collect();
        let after: Vec<[f64; 2]> = (0..12).map(|_| [rng.uniform(), rng.uniform()]).collect();
        let best = deformation_gradient(&before, &after).unwrap();
        let squares = |gradient: Matrix2<f64>| {
            let misses: Vec<Vector2<f64>> = before
                .iter()
                .zip(&after)
                .map(|(a, b)| Vector2::from(*b) - gradient * Vector2::from(*a))
                .collect();
            let mean = misses.iter().sum::<Vector2<f64>>() / 12.0;
            misses
                .iter()
                .map(|miss| (miss - mean).norm_squared())
                .sum::<f64>()
        };
        for entry in 0..4 {
            for change in [1e-3, -1e-3] {
                let mut other = best;
                other[entry] += change;
                assert!(squares(other) > squares(best));
            }
        }
        assert!(
            deformation_gradient(&[[0.0, 1.0], [1.0, 1.0], [2.0, 1.0]], &[[0.0; 2]; 3]).is_err()
        );
        assert!(deformation_gradient(&before, &after[1..]).is_err());
    }

    #[test]
    fn the_coherent_motion_has_the_ratio_minus_one() {
        let network =
            Network::lattice(4, 6, 0.2, Square::default(), Edges::Open, FRAC_PI_4).unwrap();
        let reference = State::coherent(&network, 0.5);
        let strains: Vec<[f64; 2]> = (0..40)
            .map(|step| {
                let state = State::coherent(&network, 0.2 + 0.01 * f64::from(step));
                let gradient = deformation_gradient(
                    &centres(&reference.positions),
                    &centres(&state.positions),
                )
                .unwrap();
                let strain = biot_strain(&gradient);
                assert!(strain[(0, 1)].abs() < 1e-14);
                [strain[(0, 0)], strain[(1, 1)]]
            })
            .collect();
        let found = poisson_ratio(&strains, 4).unwrap();
        assert!((found.xy + 1.0).abs() < 1e-10 && (found.yx + 1.0).abs() < 1e-10);
        assert!((found.r_squared - 1.0).abs() < 1e-10);
    }

    #[test]
    fn corners_are_where_the_rods_end() {
        let network =
            Network::lattice(3, 3, 0.2, Square::default(), Edges::Open, FRAC_PI_4).unwrap();
        let state = State::coherent(&network, 0.3);
        let corners = corners(&network, &state.positions);
        for rod in &network.rods {
            let position =
                |corner: Corner| corners[4 * corner.square + usize::from(corner.vertex) - 1];
            let (a, b) = (position(rod.from), position(rod.to));
            assert!(((a[0] - b[0]).hypot(a[1] - b[1]) - 0.2).abs() < 1e-14);
        }
    }

    /// A cloud of strains with these standard deviations and this correlation.
    fn cloud(number: u32, deviations: [f64; 2], correlation: f64, samples: usize) -> Vec<[f64; 2]> {
        let mut rng = CounterRng::new(3, number, 0);
        let rest = (1.0 - correlation * correlation).sqrt();
        let mut strains = Vec::with_capacity(samples);
        for _ in 0..samples {
            let ([x, y], [dx, dy]) = (rng.normal_pair(), deviations);
            strains.push([dx * x, dy * (correlation * x + rest * y)]);
        }
        strains
    }

    fn mean_and_deviation(values: &[f64]) -> (f64, f64) {
        let moments = RunningMoments::in_two_passes(values);
        (moments.mean(), moments.standard_deviation())
    }

    /// Slope of the long axis of a cloud: what total least squares takes for -ν.
    fn slope_of_long_axis(strains: &[[f64; 2]]) -> f64 {
        let [xx, xy, yy] = Sums::from_strains(strains, mean_strain(strains)).moments();
        (0.5 * (2.0 * xy).atan2(xx - yy)).tan()
    }

    /// Strains of equal variance and correlation r have the ratio -r. Total least squares calls it
    /// -1 for every r.
    #[test]
    fn strains_of_equal_variance_have_minus_their_correlation_as_the_ratio() {
        for correlation in [0.2, 0.5, 0.9] {
            let strains = cloud(0, [1.0, 1.0], correlation, 40_000);
            let found = poisson_ratio(&strains, 20).unwrap();
            assert!(
                (found.xy + correlation).abs() < 5.0 * found.xy_error,
                "{found:?}"
            );
            assert!(
                (found.yx + correlation).abs() < 5.0 * found.yx_error,
                "{found:?}"
            );
            assert!(found.xy_error < 0.01 && found.yx_error < 0.01);
            assert!((slope_of_long_axis(&strains) - 1.0).abs() < 0.06);
        }
    }

    /// ν_xy = -S_xy/S_xx and ν_yx = -S_xy/S_yy of a body with compliances S whose strains are drawn
    /// from its thermal distribution; the errors are the deviations seen over many such clouds.
    #[test]
    fn fluctuations_give_the_ratios_of_the_compliances_and_errors_are_as_seen() {
        let (clouds, deviations, correlation) = (200_u32, [1.0, 0.6], 0.7);
        let compliances = [1.0, 0.7 * 0.6, 0.36];
        let (mut along_x, mut along_y, mut errors) = (Vec::new(), Vec::new(), [0.0; 2]);
        for number in 0..clouds {
            let strains = cloud(number, deviations, correlation, 400);
            let found = poisson_ratio(&strains, 20).unwrap();
            along_x.push(found.xy);
            along_y.push(found.yx);
            errors[0] += found.xy_error / f64::from(clouds);
            errors[1] += found.yx_error / f64::from(clouds);
        }
        let root = f64::from(clouds).sqrt();
        for (ratios, own, error) in [
            (along_x, compliances[0], errors[0]),
            (along_y, compliances[2], errors[1]),
        ] {
            let (mean, deviation) = mean_and_deviation(&ratios);
            let exact = -compliances[1] / own;
            assert!(
                (mean - exact).abs() < 4.0 * deviation / root,
                "{mean} {exact}"
            );
            assert!((error / deviation - 1.0).abs() < 0.2, "{error} {deviation}");
        }
    }

    #[test]
    fn exchanging_the_axes_exchanges_the_ratios() {
        let strains = cloud(1, [1.0, 0.5], -0.8, 50);
        let exchanged: Vec<[f64; 2]> = strains.iter().map(|[x, y]| [*y, *x]).collect();
        let (found, other) = (
            poisson_ratio(&strains, 5).unwrap(),
            poisson_ratio(&exchanged, 5).unwrap(),
        );
        assert!((found.xy - other.yx).abs() < 1e-12 && (found.yx - other.xy).abs() < 1e-12);
        assert!((found.xy * found.yx - found.r_squared).abs() < 1e-12);
        assert!(poisson_ratio(&[[0.1, 0.2]; 8], 2).is_err() && poisson_ratio(&strains, 1).is_err());
    }
}
