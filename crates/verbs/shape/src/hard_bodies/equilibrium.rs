//! Whether a run has arrived at what it should measure.
//!
//! **Balance.** At constant pressure a volume has the weight Q(V) exp(-βPV), where Q is the partition function of the
//! bodies in it. What they bear in it is βp = d ln Q/dV, so partial integration over V gives
//!
//! ```text
//! ⟨βp⟩ = βP
//! ```
//!
//! exactly, for any number of bodies (Eppenga and Frenkel, Mol. Phys. 52, 1303 (1984)); βp is measured by trial
//! compressions. Under gravity the pressures at the two walls differ by the weight of the bodies over the area. A
//! box or a column that has not arrived breaks these equations: the first even where it is stuck and nothing moves.
//!
//! **Drift.** In equilibrium nothing has a trend. A straight line is fitted to the means of `BLOCKS` blocks of the
//! packing fraction or of the mean height, and the error of its slope is that of their scatter about it.
//!
//! **Error of the pressure.** The pressure of single states scatters by much more than the slow changes of the volume
//! move it, so its own correlations hide them. Its error counts the part that follows the packing fraction, or the
//! mean height, with the error of that.
//!
//! **Samples.** Both need a series that is long compared with its own correlations.

use super::result::{mean_and_error_following, with_error};
use protomer_kernel::statistics::summarize;
use serde::{Deserialize, Serialize};

/// Blocks of a series, to whose means a line is fitted.
const BLOCKS: usize = 10;
/// A drift, or a difference of pressures, of more standard errors is not chance. Of runs that are in equilibrium, less
/// than one in two hundred has one: the slope has eight degrees of freedom.
const SIGNIFICANT: f64 = 4.0;
/// Pressures that differ by less than this part are equal: so far the density of pairs is extrapolated.
const TOLERANCE: f64 = 0.02;
/// A pressure that is known less well than to this part says nothing.
const VAGUE: f64 = 0.1;
/// Smallest number of independent samples; fewer say little about errors.
const FEW_SAMPLES: f64 = 20.0;

/// Verdict on whether a run at constant pressure, or of a column under gravity, has reached
/// equilibrium.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Equilibrium {
    /// Whether nothing speaks against equilibrium.
    pub is_reached: bool,
    /// Pressure of the bodies by trial compressions, kT per volume; between walls, the pressure at
    /// the lower wall less that at the upper.
    pub measured_pressure_kt_per_volume: f64,
    /// Standard error of the measured pressure.
    pub measured_pressure_kt_per_volume_error: Option<f64>,
    /// Pressure in equilibrium: the imposed pressure; between walls, the weight of the bodies over
    /// the area.
    pub expected_pressure_kt_per_volume: f64,
    /// Growth of the packing fraction along a straight line over the measurement; between walls, of
    /// the mean height.
    pub drift: Option<f64>,
    /// Standard error of the drift.
    pub drift_error: Option<f64>,
    /// Measurements of the packing fraction, or of the mean height, that would be as good if they
    /// were independent.
    pub independent_samples: f64,
    /// Doubts about equilibrium, in words.
    pub doubts: Vec<String>,
}

/// Quantities that a run should hold constant, measurement by measurement.
#[derive(Debug, Clone, Copy)]
pub(super) struct Series<'a> {
    /// Measured pressure, for which an equation gives the value in equilibrium, kT per volume.
    pub pressure: &'a [f64],
    /// Pressure that the equation gives, kT per volume.
    pub expected_pressure: f64,
    /// Quantity that must not drift.
    pub observable: &'a [f64],
    /// Name of the quantity that must not drift.
    pub observable_name: &'static str,
}

impl Equilibrium {
    pub(super) fn from_series(series: &Series<'_>) -> Self {
        let (pressure, pressure_error) =
            mean_and_error_following(series.pressure, series.observable);
        let drift = drift(series.observable);
        let samples = summarize(series.observable).effective_samples;
        let mut equilibrium = Self {
            // Until a doubt is found; each is said in words of its own.
            is_reached: true,
            measured_pressure_kt_per_volume: pressure,
            measured_pressure_kt_per_volume_error: pressure_error,
            expected_pressure_kt_per_volume: series.expected_pressure,
            drift: drift.map(|(drift, _)| drift),
            drift_error: drift.map(|(_, error)| error),
            independent_samples: samples,
            doubts: Vec::new(),
        };
        equilibrium.doubts.extend(equilibrium.imbalance());
        equilibrium
            .doubts
            .extend(equilibrium.trend(series.observable_name));
        if samples < FEW_SAMPLES {
            equilibrium.doubts.push(format!(
                "the {} has {samples:.0} independent samples, fewer than {FEW_SAMPLES}",
                series.observable_name
            ));
        }
        equilibrium.is_reached = equilibrium.doubts.is_empty();
        equilibrium
    }

    /// Whether the pressures differ by more than chance and the extrapolation allow.
    fn is_out_of_balance(&self) -> bool {
        let expected = self.expected_pressure_kt_per_volume;
        // The tolerance is on the pressure itself: with many samples chance
        // no longer covers the systematic error of the extrapolation.
        let allowed = (SIGNIFICANT * self.error_of_pressure()).max(TOLERANCE * expected);
        (self.measured_pressure_kt_per_volume - expected).abs() > allowed
    }

    /// Whether it is certain that the run has not arrived. Errors from few samples are too small to say so, unless
    /// the pressures differ much.
    fn is_refuted(&self) -> bool {
        let expected = self.expected_pressure_kt_per_volume;
        let difference = (self.measured_pressure_kt_per_volume - expected).abs();
        match self.independent_samples < FEW_SAMPLES {
            // Errors from few samples are too small, so that only a large difference counts.
            true => self.is_out_of_balance() && difference > VAGUE * expected,
            false => self.is_out_of_balance() || self.drifts(),
        }
    }

    fn error_of_pressure(&self) -> f64 {
        self.measured_pressure_kt_per_volume_error
            // Without an error nothing is certain.
            .unwrap_or(f64::INFINITY)
    }

    fn drifts(&self) -> bool {
        let drift = self.drift.zip(self.drift_error);
        drift.is_some_and(|(drift, error)| drift.abs() > SIGNIFICANT * error)
    }

    /// Doubt about the pressure, in words; `None` if there is none.
    fn imbalance(&self) -> Option<String> {
        let expected = self.expected_pressure_kt_per_volume;
        let measured = with_error(
            self.measured_pressure_kt_per_volume,
            self.measured_pressure_kt_per_volume_error,
        );
        if self.is_out_of_balance() {
            return Some(format!(
                "the bodies bear a pressure of {measured} where equilibrium has {expected:.5}"
            ));
        }
        (self.error_of_pressure() > VAGUE * expected).then(|| {
            format!(
                "the pressure of the bodies, {measured}, is known too poorly to compare it with {expected:.5}"
            )
        })
    }

    /// Doubt about the drift, in words; `None` if there is none.
    fn trend(&self, name: &str) -> Option<String> {
        let Some(drift) = self.drift else {
            return Some(format!(
                "there are too few measurements to tell whether the {name} drifts"
            ));
        };
        self.drifts().then(|| {
            format!(
                "the {name} drifts: by {} over the measurement",
                with_error(drift, self.drift_error)
            )
        })
    }

    /// The verdict in one line.
    pub fn text(&self) -> String {
        if !self.is_reached {
            let verdict = match self.is_refuted() {
                true => "not in equilibrium",
                false => "equilibrium is not shown",
            };
            return format!(
                "{verdict}: {}; give more --equilibration and --sweeps",
                self.doubts.join("; ")
            );
        }
        format!(
            "in equilibrium: the bodies bear {} of {:.5} kT per volume, drift {}",
            with_error(
                self.measured_pressure_kt_per_volume,
                self.measured_pressure_kt_per_volume_error
            ),
            self.expected_pressure_kt_per_volume,
            with_error(self.drift.unwrap_or(0.0), self.drift_error),
        )
    }
}

/// Growth of a series along a straight line from its beginning to its end, and the standard error
/// of the growth; `None` for fewer measurements than two per block.
fn drift(series: &[f64]) -> Option<(f64, f64)> {
    let length = series.len() / BLOCKS;
    // Means of single measurements would leave correlation in the scatter.
    if length < 2 {
        return None;
    }
    // The first measurements of a series that does not divide are left out.
    let measured = &series[series.len() - length * BLOCKS..];
    let mut means = Vec::new();
    for block in measured.chunks(length) {
        means.push(block.iter().sum::<f64>() / length as f64);
    }
    let count = BLOCKS as f64;
    let mean = means.iter().sum::<f64>() / count;
    // Places of the blocks from -1/2 to 1/2, so that the slope is the growth over the whole.
    let place = |block: usize| (block as f64 + 0.5) / count - 0.5;
    // Σ x² of the places; those are centred, so no intercept is needed.
    let squares: f64 = (0..BLOCKS).map(|block| place(block).powi(2)).sum();
    let products = means.iter().enumerate();
    let slope = products
        .map(|(block, y)| place(block) * (y - mean))
        .sum::<f64>()
        / squares;
    let offs = means
        .iter()
        .enumerate()
        .map(|(block, y)| (y - mean - slope * place(block)).powi(2));
    // Two parameters were fitted, intercept and slope.
    let variance = offs.sum::<f64>() / (count - 2.0);
    Some((slope, (variance / squares).sqrt()))
}

#[cfg(test)]
mod tests {
    use super::super::result::mean_and_error;
    use super::*;
    use protomer_kernel::random::CounterRng;

    /// A series with a memory of some measurements.
    fn noise(seed: u64, length: usize, memory: f64) -> Vec<f64> {
        let mut rng = CounterRng::new(seed, 0, 0);
        let (kept, mut value, mut series) = ((-1.0 / memory).exp(), 0.0, Vec::new());
        for _ in 0..length {
            value = kept * value + rng.uniform_in(-1.0, 1.0);
            series.push(value);
        }
        series
    }

    fn verdict(pressure: &[f64], observable: &[f64]) -> Equilibrium {
        Equilibrium::from_series(&Series {
            pressure,
            expected_pressure: 4.0,
            observable,
            observable_name: "packing fraction",
        })
    }

    fn about(value: f64, noise: Vec<f64>) -> Vec<f64> {
        noise.into_iter().map(|x| value + 0.1 * x).collect()
    }

    #[test]
    fn a_straight_line_is_its_own_drift() {
        let series: Vec<f64> = (0..2000).map(|x| 0.3 + 1e-4 * f64::from(x)).collect();
        let (found, error) = drift(&series).unwrap();
        assert!(
            (found - 0.2).abs() < 1e-9 && error < 1e-9,
            "{found} {error}"
        );
        assert_eq!(drift(&series[..19]), None);
    }

    #[test]
    fn noise_is_in_equilibrium_and_its_drift_has_the_error_that_is_named() {
        let (mut reached, mut scaled) = (0, 0.0);
        for seed in 0..400 {
            let found = verdict(
                &about(4.0, noise(seed, 2000, 5.0)),
                &noise(1000 + seed, 2000, 5.0),
            );
            reached += u32::from(found.is_reached);
            scaled += (found.drift.unwrap() / found.drift_error.unwrap()).powi(2) / 400.0;
        }
        assert!(reached >= 395, "{reached}");
        // The square of Student's t with eight degrees of freedom has the mean 8/6.
        assert!((scaled - 8.0 / 6.0).abs() < 0.3, "{scaled}");
    }

    /// A crystal of 108 spheres has such a pressure: noise of 6.6 kT per volume, under which 1.5 follow the volume.
    #[test]
    fn the_error_of_the_pressure_counts_what_follows_the_volume_under_noise() {
        let (runs, length) = (200, 4000);
        let (mut squared, mut counted, mut by_itself) = (0.0, 0.0, 0.0);
        for seed in 0..runs {
            let volume = noise(seed, length, 40.0);
            let pairs = volume.iter().zip(noise(1000 + seed, length, 0.2));
            let pressure: Vec<f64> = pairs
                .map(|(x, noise)| 25.0 + 0.6 * x + 11.4 * noise)
                .collect();
            let (mean, error) = mean_and_error_following(&pressure, &volume);
            squared += (mean - 25.0).powi(2);
            counted += error.unwrap().powi(2);
            by_itself += mean_and_error(&pressure).1.unwrap().powi(2);
        }
        assert!(
            (squared / counted - 1.0).abs() < 0.3,
            "{}",
            squared / counted
        );
        assert!(squared / by_itself > 1.7, "{}", squared / by_itself);
    }

    /// A series that follows nothing keeps the error that it has by itself.
    #[test]
    fn noise_that_follows_nothing_keeps_its_error() {
        let (pressure, volume) = (noise(1, 4000, 3.0), noise(2, 4000, 3.0));
        let (_, error) = mean_and_error_following(&pressure, &volume);
        let (_, by_itself) = mean_and_error(&pressure);
        assert!((error.unwrap() / by_itself.unwrap() - 1.0).abs() < 0.1);
        let fixed = vec![0.5; 4000];
        assert_eq!(mean_and_error_following(&pressure, &fixed).1, by_itself);
    }

    #[test]
    fn each_fault_is_named() {
        let pressure = about(4.0, noise(1, 2000, 5.0));
        let kept = noise(2, 2000, 5.0);
        let climbing: Vec<f64> = kept
            .iter()
            .zip(0..)
            .map(|(x, n)| x + 2e-3 * f64::from(n))
            .collect();
        let doubts = |pressure: &[f64], kept: &[f64]| verdict(pressure, kept).doubts.join("; ");
        assert_eq!(doubts(&pressure, &kept), "");
        let low = about(1.9, noise(3, 2000, 5.0));
        assert!(doubts(&low, &kept).contains("where equilibrium has 4.00000"));
        let vague: Vec<f64> = noise(4, 2000, 5.0).iter().map(|x| 4.0 + 40.0 * x).collect();
        assert!(doubts(&vague, &kept).contains("too poorly"));
        assert!(doubts(&pressure, &climbing).contains("drifts"));
        assert!(doubts(&pressure, &noise(5, 2000, 300.0)).contains("independent samples"));
        assert!(doubts(&pressure[..15], &kept[..15]).contains("too few measurements"));
        let words = verdict(&low, &climbing).text();
        assert!(words.starts_with("not in equilibrium: "), "{words}");
        let words = verdict(&vague, &kept).text();
        assert!(words.starts_with("equilibrium is not shown: "), "{words}");
    }
}
