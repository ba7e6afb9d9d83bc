//! What a run of hard bodies found, as text and as data.

use super::equilibrium::Equilibrium;
use super::log::LogRow;
use protomer_common::answer::Answer;
use protomer_kernel::periodic_box::PeriodicBox;
use protomer_kernel::statistics::{block_standard_error, summarize};
use serde::{Deserialize, Serialize};

/// The result of a run. Lengths are in the unit of the shape.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct HardBodyResult {
    /// File or name of the shape.
    pub shape: String,
    /// Number of dimensions, 2 or 3.
    pub dimension: usize,
    /// Radius that rounds the shape.
    pub rounding_radius: f64,
    /// Number of bodies.
    pub bodies: usize,
    /// Part of the box that the bodies fill; at constant pressure its mean.
    pub packing_fraction: f64,
    /// Standard error of the packing fraction, at constant pressure.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub packing_fraction_error: Option<f64>,
    /// First edge of the box at the end.
    pub box_edge: f64,
    /// Lengths of the box at the end: Lx, Ly, Lz. With right angles they are its edges.
    #[serde(default)]
    pub box_edges: Vec<f64>,
    /// Tilt factors of the box at the end, xy, xz and yz; in a plane xy; none where its angles are right.
    #[serde(skip_serializing_if = "Vec::is_empty", default)]
    pub box_tilt_factors: Vec<f64>,
    /// Means of the box, where more than its volume changes.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub mean_box: Option<MeanBox>,
    /// Sweeps after the equilibration.
    pub sweeps: u64,
    /// Z = βP/ρ of the bodies and their potential by trial compressions. It does not hold what depletants add.
    pub compressibility_factor: f64,
    /// Standard error of the compressibility factor.
    pub compressibility_factor_error: Option<f64>,
    /// βP times the volume of a body.
    pub reduced_pressure: f64,
    /// The accepted part of the trial moves.
    pub acceptance: f64,
    /// Largest step of a coordinate.
    pub translation_step: f64,
    /// Largest component of a rotation step.
    pub rotation_step: f64,
    /// Trial moves per second of processor time in this process; `None` if it made none.
    pub trial_moves_per_cpu_second: Option<f64>,
    /// Energy of all pairs over the number of bodies, kT, with a potential.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub energy_kt_per_body: Option<f64>,
    /// Standard error of the energy.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub energy_kt_per_body_error: Option<f64>,
    /// The part of inserted bodies that overlap none, each weighed by exp(-u) with a potential.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub insertion_probability: Option<f64>,
    /// Standard error of the insertion probability.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub insertion_probability_error: Option<f64>,
    /// Excess chemical potential, kT.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub excess_chemical_potential_kt: Option<f64>,
    /// Standard error of the excess chemical potential, kT.
    #[serde(
        skip_serializing_if = "Option::is_none",
        default,
        alias = "excess_chemical_potential_error_kt"
    )]
    pub excess_chemical_potential_kt_error: Option<f64>,
    /// Free volume of the first depletant, as a part of the box.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub free_volume_fraction: Option<f64>,
    /// Standard error of the free volume.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub free_volume_fraction_error: Option<f64>,
    /// The constant pressure βP, kT per volume.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub pressure_kt_per_volume: Option<f64>,
    /// Accepted part of the exchanges of places, where they were tried.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub swap_acceptance: Option<f64>,
    /// The accepted part of the changes of the box.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub box_acceptance: Option<f64>,
    /// Verdict on equilibrium, at constant pressure and under gravity.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub equilibrium: Option<Equilibrium>,
    /// Pressures on the walls, and mean height of the bodies.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub walls: Option<WallsResult>,
    /// Results for each depletant.
    #[serde(skip_serializing_if = "Vec::is_empty", default)]
    pub depletants: Vec<DepletantResult>,
}

/// The box on average. Tilt factors that belong to the same images count as different.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MeanBox {
    /// Mean lengths Lx, Ly, Lz.
    pub lengths: Vec<f64>,
    /// Standard errors of the lengths.
    #[serde(alias = "length_errors")]
    pub lengths_error: Vec<Option<f64>>,
    /// Mean tilt factors xy, xz and yz; in a plane xy.
    pub tilt_factors: Vec<f64>,
    /// Standard errors of the tilt factors.
    #[serde(alias = "tilt_factor_errors")]
    pub tilt_factors_error: Vec<Option<f64>>,
}

impl MeanBox {
    /// Mean box of the measurements; `None` where the box keeps its shape.
    pub(super) fn from_rows(rows: &[LogRow]) -> Option<Self> {
        let series = |column: fn(&LogRow) -> &Vec<f64>| -> Vec<(f64, Option<f64>)> {
            let count = rows.first().map_or(0, |row| column(row).len());
            let number = |number: usize| {
                let numbers = rows
                    .iter()
                    .filter_map(|row| column(row).get(number).copied());
                mean_and_error(&numbers.collect::<Vec<f64>>())
            };
            (0..count).map(number).collect()
        };
        let (lengths, lengths_error) = series(|row| &row.box_lengths).into_iter().unzip();
        let (tilt_factors, tilt_factors_error) =
            series(|row| &row.box_tilt_factors).into_iter().unzip();
        let mean_box = Self {
            lengths,
            lengths_error,
            tilt_factors,
            tilt_factors_error,
        };
        (!mean_box.lengths.is_empty()).then_some(mean_box)
    }

    fn text(&self) -> String {
        let several = |values: &[f64], errors: &[Option<f64>]| {
            let numbers = values.iter().zip(errors);
            let words: Vec<String> = numbers.map(|(x, error)| with_error(*x, *error)).collect();
            words.join(", ")
        };
        let lengths = several(&self.lengths, &self.lengths_error);
        if self.tilt_factors.is_empty() {
            return format!("box {lengths}");
        }
        let tilts = several(&self.tilt_factors, &self.tilt_factors_error);
        format!("box {lengths}; tilt factors {tilts}")
    }
}

/// Bodies under gravity between walls. The pressures differ by the weight over the area, whatever the
/// bodies are.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct WallsResult {
    /// βP at the lower wall, kT per volume, from the bodies near it.
    pub lower_pressure: f64,
    /// Standard error of the pressure at the lower wall.
    pub lower_pressure_error: Option<f64>,
    /// βP at the upper wall.
    pub upper_pressure: f64,
    /// Standard error of the pressure at the upper wall.
    pub upper_pressure_error: Option<f64>,
    /// The weight of all bodies over the area of a wall, kT per volume.
    pub weight_per_area: f64,
    /// Mean height of the centres over the lower wall.
    pub mean_height: f64,
    /// Standard error of the mean height.
    pub mean_height_error: Option<f64>,
}

/// Results for a depletant.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct DepletantResult {
    /// Radius.
    pub radius: f64,
    /// Number density in the reservoir.
    pub fugacity: f64,
    /// The part of the reservoir that the depletants would fill if they did not overlap.
    pub reservoir_packing_fraction: f64,
    /// Part of the box that is open to the centres of the depletants.
    pub free_volume_fraction: f64,
    /// Standard error of the free volume.
    pub free_volume_fraction_error: Option<f64>,
}

impl Answer for HardBodyResult {
    fn text(&self) -> String {
        let mut lines = vec![
            format!(
                "{} bodies ({}), packing fraction {}, {} sweeps",
                self.bodies,
                self.shape,
                match self.pressure_kt_per_volume {
                    None => self.packing_fraction.to_string(),
                    Some(_) => with_error(self.packing_fraction, self.packing_fraction_error),
                },
                self.sweeps
            ),
            format!(
                "compressibility factor {}",
                with_error(
                    self.compressibility_factor,
                    self.compressibility_factor_error
                )
            ),
        ];
        if let Some(energy) = self.energy_kt_per_body {
            let energy = with_error(energy, self.energy_kt_per_body_error);
            lines.push(format!("energy {energy} kT per body"));
        }
        lines.extend(self.equilibrium.as_ref().map(Equilibrium::text));
        lines.extend(self.mean_box.as_ref().map(MeanBox::text));
        if let Some(walls) = &self.walls {
            lines.push(format!(
                "pressure at the lower wall {}, at the upper {}; weight per area {:.5}",
                with_error(walls.lower_pressure, walls.lower_pressure_error),
                with_error(walls.upper_pressure, walls.upper_pressure_error),
                walls.weight_per_area
            ));
            lines.push(format!(
                "mean height {}",
                with_error(walls.mean_height, walls.mean_height_error)
            ));
        }
        if let Some(potential) = self.excess_chemical_potential_kt {
            lines.push(format!(
                "excess chemical potential {} kT",
                with_error(potential, self.excess_chemical_potential_kt_error)
            ));
        }
        for kind in &self.depletants {
            lines.push(format!(
                "depletants of radius {}: free volume fraction {}",
                kind.radius,
                with_error(kind.free_volume_fraction, kind.free_volume_fraction_error)
            ));
        }
        lines.push(format!(
            "{:.1} % of the moves accepted",
            100.0 * self.acceptance
        ));
        if let Some(acceptance) = self.swap_acceptance {
            lines.push(format!(
                "{:.1} % of the exchanges accepted",
                100.0 * acceptance
            ));
        }
        lines.join("\n")
    }
}

impl HardBodyResult {
    /// Warning that the numbers are not those of equilibrium, and why; `None` if nothing speaks
    /// against it.
    pub fn warning(&self) -> Option<String> {
        let is_pressed_among_depletants = self.pressure_kt_per_volume.is_some()
            && self.depletants.iter().any(|kind| kind.fugacity > 0.0);
        if is_pressed_among_depletants {
            return Some(
                "the balance of pressures is not measured among depletants; look at packing_fraction in log.csv".into(),
            );
        }
        let equilibrium = self.equilibrium.as_ref()?;
        (!equilibrium.is_reached).then(|| equilibrium.text())
    }
}

pub(super) fn with_error(value: f64, error: Option<f64>) -> String {
    match error {
        Some(error) => format!("{value:.5} ± {error:.5}"),
        None => format!("{value:.5}"),
    }
}

/// The mean of a series and its standard error by blocks; of a short series, by its autocorrelation.
pub(super) fn mean_and_error(series: &[f64]) -> (f64, Option<f64>) {
    let summary = summarize(series);
    let error = block_standard_error(series).unwrap_or(summary.standard_error);
    (summary.mean, Some(error).filter(|error| error.is_finite()))
}

/// The mean of a noisy series that follows a slow one, as the pressure of the bodies follows the volume, and its
/// standard error.
///
/// Its own correlations do not show how well the mean is known: where noise hides the part that follows, they seem
/// to end at once. The straight line that gives the noisy series from the slow one takes this part out,
///
/// ```text
/// y = ȳ + s (x - x̄) + r,   s = ⟨δx δy⟩/⟨δx²⟩,   error² = s² (error of x̄)² + (error of r̄)²
/// ```
///
/// The slow series is the control variate (Lavenberg and Welch, Management Sci. 27, 322 (1981)).
pub(super) fn mean_and_error_following(series: &[f64], slow: &[f64]) -> (f64, Option<f64>) {
    let (mean, own_error) = mean_and_error(series);
    let (slow_mean, slow_error) = mean_and_error(slow);
    let (mut products, mut squares) = (0.0, 0.0);
    for (y, x) in series.iter().zip(slow) {
        products += (y - mean) * (x - slow_mean);
        squares += (x - slow_mean).powi(2);
    }
    if squares == 0.0 {
        return (mean, own_error);
    }
    let slope = products / squares;
    let pairs = series.iter().zip(slow);
    let residuals: Vec<f64> = pairs.map(|(y, x)| y - slope * (x - slow_mean)).collect();
    let (_, residual_error) = mean_and_error(&residuals);
    let error = slow_error.zip(residual_error);
    (
        mean,
        error.map(|(slow, residual)| (slope * slow).hypot(residual)),
    )
}

/// The tilt factors of a box; none where its angles are right.
pub(super) fn tilt_factors<const D: usize>(space: &PeriodicBox<D>) -> Vec<f64> {
    match space.is_rectangular() {
        true => Vec::new(),
        false => space.tilt_factors(),
    }
}
