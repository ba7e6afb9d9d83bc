//! Compliances of a lattice in a heat bath, from the fluctuations of its strain.
//!
//! In equilibrium at kT, with strains ε_x, ε_y and the shear ε_xy from a fixed state and the area A₀ there,
//!
//! S_xx = A₀ ⟨δε_x²⟩/kT, S_xy = A₀ ⟨δε_x δε_y⟩/kT, S_yy = A₀ ⟨δε_y²⟩/kT,
//!
//! which is also how ⟨ε⟩ changes with a stress of Biot ([`load`](crate::lattice::load)), exactly
//! and for any size. ν_xy = -S_xy/S_xx for a load along x, Young's modulus 1/S_xx. The shear modulus
//! is kT/(4 A₀ ⟨δε_xy²⟩): γ = 2 ε_xy. Errors are those of a jackknife over blocks.

use crate::error::{CrystalError, Result, require_positive};
use protomer_kernel::statistics::jackknife_error;
use serde::{Deserialize, Serialize};

/// A number and its standard error.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct WithError {
    /// Value.
    pub value: f64,
    /// Standard error.
    pub error: f64,
}

/// Elastic answer of a lattice. Reduced units.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Compliances {
    /// Mean strain along x.
    pub strain_xx: WithError,
    /// Mean strain along y.
    pub strain_yy: WithError,
    /// Compliance S_xx, area per energy.
    pub compliance_xx: WithError,
    /// Compliance S_xy.
    pub compliance_xy: WithError,
    /// Compliance S_yy.
    pub compliance_yy: WithError,
    /// Poisson's ratio for a load along x.
    pub poisson_ratio_xy: WithError,
    /// Poisson's ratio for a load along y.
    pub poisson_ratio_yx: WithError,
    /// Young's modulus along x, energy per area.
    pub young_modulus_x: WithError,
    /// Young's modulus along y.
    pub young_modulus_y: WithError,
    /// Shear modulus.
    pub shear_modulus: WithError,
    /// Number of strains.
    pub samples: usize,
}

/// Compliances from strains (ε_x, ε_y, ε_xy) in the order of time, at kT and with the area A₀; errors
/// from this many blocks. Blocks must be longer than the correlation time of the strains.
///
/// ```
/// use protomer_linkage::analysis::elastic::compliances;
/// let strains: Vec<[f64; 3]> =
///     (0..400).map(|k| (0.1 * f64::from(k).sin(), 0.1 * f64::from(k).cos())).map(|(a, b)| [a, 0.5 * a, b]).collect();
/// let found = compliances(&strains, 2.0, 0.1, 10)?;
/// assert!((found.poisson_ratio_xy.value + 0.5).abs() < 1e-9);
/// assert!((found.compliance_xx.value - 2.0 * 0.005 / 0.1).abs() < 1e-3);
/// # Ok::<(), protomer_linkage::CrystalError>(())
/// ```
///
/// # Errors
/// [`CrystalError::BadSetting`] for an area or kT that is not positive, [`CrystalError::BadState`] for
/// too few strains, or strains that are not finite or do not vary.
pub fn compliances(strains: &[[f64; 3]], area: f64, kt: f64, blocks: usize) -> Result<Compliances> {
    require_positive("area", area)?;
    require_positive("kt", kt)?;
    let samples = strains.len();
    if blocks < 2 || samples < 2 * blocks {
        return Err(CrystalError::BadState(format!(
            "{samples} strains cannot be split into {blocks} blocks; take two blocks or more, of two \
             strains or more"
        )));
    }
    let origin = strains[0];
    let all = Sums::from_strains(strains, origin);
    let mut without = Vec::with_capacity(blocks);
    for block in 0..blocks {
        let range = block * samples / blocks..(block + 1) * samples / blocks;
        let remainder = all.less(&Sums::from_strains(&strains[range], origin));
        without.push(remainder.answers(area / kt));
    }
    let answers = all.answers(area / kt);
    if answers.iter().any(|answer| !answer.is_finite()) {
        return Err(CrystalError::BadState(
            "the strains are not finite, or do not vary along x, along y and in shear".into(),
        ));
    }
    let with_error = |which: usize| {
        let values: Vec<f64> = without.iter().map(|answers| answers[which]).collect();
        let shift = if which < 2 { origin[which] } else { 0.0 };
        WithError {
            value: answers[which] + shift,
            error: jackknife_error(&values).unwrap_or(f64::NAN),
        }
    };
    Ok(Compliances {
        strain_xx: with_error(0),
        strain_yy: with_error(1),
        compliance_xx: with_error(2),
        compliance_xy: with_error(3),
        compliance_yy: with_error(4),
        poisson_ratio_xy: with_error(5),
        poisson_ratio_yx: with_error(6),
        young_modulus_x: with_error(7),
        young_modulus_y: with_error(8),
        shear_modulus: with_error(9),
        samples,
    })
}

/// Strains of a run under a load along one axis.
#[derive(Debug, Clone, Copy)]
pub struct LoadedRun<'a> {
    /// Stress along the axis.
    pub stress: f64,
    /// Strains along the load and across it, in the order of time.
    pub strains: &'a [[f64; 2]],
}

/// Response of the strains to a load, and the same from their fluctuations.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Response {
    /// Compliance along the load, from the change of the mean strain with the stress.
    pub compliance: WithError,
    /// Poisson's ratio, minus the change of the strain across the load over that along it.
    pub poisson_ratio: WithError,
    /// Compliance along the load from the fluctuations, the mean over the runs.
    pub fluctuation_compliance: WithError,
    /// Poisson's ratio from the fluctuations, of the mean covariances over the runs.
    pub fluctuation_poisson_ratio: WithError,
    /// Difference of the two ratios over its error.
    pub deviation: f64,
}

/// The response of runs under different loads along one axis.
///
/// Slopes are those of least squares. The jackknife leaves out the same block of all runs at once, so
/// that runs with the same noise, whose strains vary together, give the small error that their
/// difference has.
///
/// # Errors
/// [`CrystalError::BadSetting`] for an area or kT that is not positive, [`CrystalError::BadState`] for
/// too few strains, or for runs that all have the same stress.
pub fn response(runs: &[LoadedRun<'_>], area: f64, kt: f64, blocks: usize) -> Result<Response> {
    require_positive("area", area)?;
    require_positive("kt", kt)?;
    let shortest = runs.iter().map(|run| run.strains.len()).min().unwrap_or(0);
    if blocks < 2 || shortest < 2 * blocks {
        return Err(CrystalError::BadState(format!(
            "a run of {shortest} strains cannot be split into {blocks} blocks; run longer"
        )));
    }
    let mut wholes = Vec::with_capacity(runs.len());
    for run in runs {
        wholes.push((
            run.stress,
            Sums::from_strains(&widened(run.strains), [0.0; 3]),
        ));
    }
    let answers = Answers::from_runs(&wholes, area / kt);
    let mut without = Vec::with_capacity(blocks);
    for block in 0..blocks {
        let mut shortened = Vec::with_capacity(runs.len());
        for (run, (stress, whole)) in runs.iter().zip(&wholes) {
            let samples = run.strains.len();
            let range = block * samples / blocks..(block + 1) * samples / blocks;
            let block_sums = Sums::from_strains(&widened(&run.strains[range]), [0.0; 3]);
            shortened.push((*stress, whole.less(&block_sums)));
        }
        without.push(Answers::from_runs(&shortened, area / kt));
    }
    let with_error = |value: fn(&Answers) -> f64| {
        let values: Vec<f64> = without.iter().map(value).collect();
        WithError {
            value: value(&answers),
            error: jackknife_error(&values).unwrap_or(f64::NAN),
        }
    };
    let difference = with_error(|answers| answers.ratio - answers.fluctuation_ratio);
    if !difference.value.is_finite() {
        return Err(CrystalError::BadState(
            "the runs have one stress or strains that do not vary; add runs with other stresses"
                .into(),
        ));
    }
    Ok(Response {
        compliance: with_error(|answers| answers.compliance),
        poisson_ratio: with_error(|answers| answers.ratio),
        fluctuation_compliance: with_error(|answers| answers.fluctuation_compliance),
        fluctuation_poisson_ratio: with_error(|answers| answers.fluctuation_ratio),
        deviation: difference.value / difference.error,
    })
}

fn widened(strains: &[[f64; 2]]) -> Vec<[f64; 3]> {
    strains.iter().map(|[x, y]| [*x, *y, 0.0]).collect()
}

struct Answers {
    compliance: f64,
    ratio: f64,
    fluctuation_compliance: f64,
    fluctuation_ratio: f64,
}

impl Answers {
    fn from_runs(runs: &[(f64, Sums)], scale: f64) -> Self {
        let count = runs.len() as f64;
        let mean_stress = runs.iter().map(|(stress, _)| stress).sum::<f64>() / count;
        let (mut squares, mut along, mut across) = (0.0, 0.0, 0.0);
        let (mut xx, mut xy) = (0.0, 0.0);
        for (stress, sums) in runs {
            let [x, y, _] = sums.first.map(|sum| sum / sums.count);
            let away = stress - mean_stress;
            squares += away * away;
            along += away * x;
            across += away * y;
            xx += (sums.xx / sums.count - x * x) / count;
            xy += (sums.xy / sums.count - x * y) / count;
        }
        Self {
            compliance: along / squares,
            ratio: -across / along,
            fluctuation_compliance: scale * xx,
            fluctuation_ratio: -xy / xx,
        }
    }
}

/// Number, sums and sums of products of the strains.
#[derive(Debug, Clone, Copy, Default)]
struct Sums {
    count: f64,
    first: [f64; 3],
    xx: f64,
    xy: f64,
    yy: f64,
    shear: f64,
}

impl Sums {
    fn from_strains(strains: &[[f64; 3]], origin: [f64; 3]) -> Self {
        let mut sums = Self::default();
        for strain in strains {
            let [x, y, shear] = [0, 1, 2].map(|axis| strain[axis] - origin[axis]);
            sums.count += 1.0;
            for (sum, value) in sums.first.iter_mut().zip([x, y, shear]) {
                *sum += value;
            }
            sums.xx += x * x;
            sums.xy += x * y;
            sums.yy += y * y;
            sums.shear += shear * shear;
        }
        sums
    }

    fn less(&self, other: &Self) -> Self {
        Self {
            count: self.count - other.count,
            first: [0, 1, 2].map(|axis| self.first[axis] - other.first[axis]),
            xx: self.xx - other.xx,
            xy: self.xy - other.xy,
            yy: self.yy - other.yy,
            shear: self.shear - other.shear,
        }
    }

    fn answers(&self, scale: f64) -> [f64; 10] {
        let [x, y, shear] = self.first.map(|sum| sum / self.count);
        let covariance = |product: f64, a: f64, b: f64| product / self.count - a * b;
        let [xx, xy, yy, shear] = [
            covariance(self.xx, x, x),
            covariance(self.xy, x, y),
            covariance(self.yy, y, y),
            covariance(self.shear, shear, shear),
        ];
        [
            x,
            y,
            scale * xx,
            scale * xy,
            scale * yy,
            -xy / xx,
            -xy / yy,
            1.0 / (scale * xx),
            1.0 / (scale * yy),
            0.25 / (scale * shear),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Matrix3, Vector3};
    use protomer_kernel::random::CounterRng;

    /// Strains of a body with known stiffness, drawn from exp(-A ½ ε C ε/kT): the answers are those of
    /// its inverse, and errors as large as seen.
    #[test]
    fn the_compliances_of_a_body_are_found_within_their_errors() {
        let stiffness = Matrix3::new(3.0, 1.2, 0.0, 1.2, 2.0, 0.0, 0.0, 0.0, 0.7);
        let compliance = stiffness.try_inverse().unwrap();
        let (area, kt) = (5.0, 0.3);
        let root = (compliance * (kt / area)).cholesky().unwrap().l();
        let mut misses = Vec::new();
        for cloud in 0..40 {
            let mut rng = CounterRng::new(8, cloud, 0);
            let strains: Vec<[f64; 3]> = (0..4000)
                .map(|_| {
                    let ([a, b], [c, _]) = (rng.normal_pair(), rng.normal_pair());
                    let strain = root * Vector3::new(a, b, c);
                    // Engineering shear to ε_xy, and a mean that must not matter.
                    [strain[0] + 0.4, strain[1] - 0.1, 0.5 * strain[2]]
                })
                .collect();
            let answer_of_body = compliances(&strains, area, kt, 20).unwrap();
            for (answer, exact) in [
                (answer_of_body.strain_xx, 0.4),
                (answer_of_body.strain_yy, -0.1),
                (answer_of_body.compliance_xx, compliance[(0, 0)]),
                (answer_of_body.compliance_xy, compliance[(0, 1)]),
                (answer_of_body.compliance_yy, compliance[(1, 1)]),
                (
                    answer_of_body.poisson_ratio_xy,
                    -compliance[(0, 1)] / compliance[(0, 0)],
                ),
                (
                    answer_of_body.poisson_ratio_yx,
                    -compliance[(0, 1)] / compliance[(1, 1)],
                ),
                (answer_of_body.young_modulus_x, 1.0 / compliance[(0, 0)]),
                (answer_of_body.young_modulus_y, 1.0 / compliance[(1, 1)]),
                (answer_of_body.shear_modulus, 0.7),
            ] {
                misses.push(((answer.value - exact) / answer.error).powi(2));
            }
        }
        let mean = misses.iter().sum::<f64>() / misses.len() as f64;
        assert!((0.7..1.4).contains(&mean), "{mean}");
    }

    /// Strains of a body with known compliances under loads: both ways find them, within errors that are
    /// as large as seen.
    #[test]
    fn response_and_fluctuation_find_the_same_compliances() {
        let (area, kt, [xx, xy, yy]) = (4.0, 0.2, [0.5, 0.3, 0.7]);
        let (a, b) = (
            f64::sqrt(xx * kt / area),
            xy / f64::sqrt(xx) * f64::sqrt(kt / area),
        );
        let c = f64::sqrt(yy * kt / area - b * b);
        let mut misses = Vec::new();
        for cloud in 0..40 {
            let runs: Vec<(f64, Vec<[f64; 2]>)> = [-0.2, 0.0, 0.2]
                .into_iter()
                .enumerate()
                .map(|(number, stress)| {
                    let mut rng = CounterRng::new(8, cloud, number as u64);
                    let draw = |_| {
                        let [p, q] = rng.normal_pair();
                        [
                            0.1 + xx * stress + a * p,
                            -0.2 + xy * stress + b * p + c * q,
                        ]
                    };
                    (stress, (0..3000).map(draw).collect())
                })
                .collect();
            let loaded: Vec<LoadedRun<'_>> = runs
                .iter()
                .map(|(stress, strains)| LoadedRun {
                    stress: *stress,
                    strains,
                })
                .collect();
            let answer_of_body = response(&loaded, area, kt, 20).unwrap();
            for (answer, exact) in [
                (answer_of_body.compliance, xx),
                (answer_of_body.poisson_ratio, -xy / xx),
                (answer_of_body.fluctuation_compliance, xx),
                (answer_of_body.fluctuation_poisson_ratio, -xy / xx),
            ] {
                misses.push(((answer.value - exact) / answer.error).powi(2));
            }
            misses.push(answer_of_body.deviation.powi(2));
            assert!(response(&loaded[..1], area, kt, 20).is_err());
        }
        let mean = misses.iter().sum::<f64>() / misses.len() as f64;
        assert!((0.7..1.4).contains(&mean), "{mean}");
    }

    #[test]
    fn strains_that_say_nothing_are_refused() {
        assert!(compliances(&[[0.1; 3]; 40], 1.0, 1.0, 10).is_err());
        assert!(compliances(&[[0.1; 3]; 4], 1.0, 1.0, 10).is_err());
        assert!(compliances(&[[f64::NAN; 3]; 40], 1.0, 1.0, 10).is_err());
        assert!(compliances(&[[0.1; 3]; 40], 1.0, 0.0, 10).is_err());
    }
}
