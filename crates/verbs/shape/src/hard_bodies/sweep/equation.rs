//! An equation of state: what the runs of a sweep measured, at each condition.

use super::HardBodySweepSettings;
use crate::hard_bodies::equilibrium::Equilibrium;
use crate::hard_bodies::result::{HardBodyResult, with_error};
use anyhow::Result;
use protomer_common::answer::{Answer, columns, heading};
use protomer_hpmc::equation_of_state::{Factor, excess_free_energies};
use protomer_io::csv::{Cell, Table};
use protomer_plot::{Axis, Figure, Panel, Point, Series};
use serde::{Deserialize, Serialize};

/// An equation of state. Lengths are in the unit of the shape.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct EquationOfState {
    /// The settings.
    pub settings: HardBodySweepSettings,
    /// Number of dimensions, 1, 2 or 3.
    pub dimension: usize,
    /// Volume of a body.
    pub body_volume: f64,
    /// Second virial coefficient over the volume of a body, for a fluid of the bodies alone.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub b2_over_volume: Option<f64>,
    /// Results for each condition, in the order of the packing fractions.
    pub points: Vec<StatePoint>,
}

/// Results of all runs at one condition: means, and their standard errors.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct StatePoint {
    /// The part of the box that the bodies fill.
    pub packing_fraction: f64,
    /// Standard error of the packing fraction, at constant pressure.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub packing_fraction_error: Option<f64>,
    /// The constant pressure βP, kT per volume.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub pressure_kt_per_volume: Option<f64>,
    /// Z = βP/ρ of the bodies, by trial compressions.
    pub compressibility_factor: f64,
    /// Standard error of the compressibility factor.
    pub compressibility_factor_error: Option<f64>,
    /// βP times the volume of a body.
    pub reduced_pressure: f64,
    /// Excess chemical potential by insertion, kT.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub excess_chemical_potential_kt: Option<f64>,
    /// Standard error of the excess chemical potential.
    #[serde(
        skip_serializing_if = "Option::is_none",
        default,
        alias = "excess_chemical_potential_error_kt"
    )]
    pub excess_chemical_potential_kt_error: Option<f64>,
    /// Excess free energy per body by integration from no bodies, kT.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub excess_free_energy_per_body_kt: Option<f64>,
    /// Standard error of the excess free energy.
    #[serde(
        skip_serializing_if = "Option::is_none",
        default,
        alias = "excess_free_energy_per_body_error_kt"
    )]
    pub excess_free_energy_per_body_kt_error: Option<f64>,
    /// Free volume of the first depletant, as a part of the box.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub free_volume_fraction: Option<f64>,
    /// Standard error of the free volume.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub free_volume_fraction_error: Option<f64>,
    /// Verdict on equilibrium, at constant pressure and under gravity.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub equilibrium: Option<MeanEquilibrium>,
    /// Number of runs at this condition.
    pub seeds: usize,
}

/// Verdict on whether all runs at one condition have arrived: means, and their standard errors.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MeanEquilibrium {
    /// Whether nothing speaks against equilibrium in any of the runs.
    pub is_reached: bool,
    /// Pressure of the bodies, kT per volume; between walls, the pressure at the lower wall less
    /// that at the upper.
    pub measured_pressure_kt_per_volume: f64,
    /// Standard error of the measured pressure.
    pub measured_pressure_kt_per_volume_error: Option<f64>,
    /// Pressure in equilibrium, kT per volume.
    pub expected_pressure_kt_per_volume: f64,
    /// Growth of the packing fraction, or of the mean height, over the measurement.
    pub drift: Option<f64>,
    /// Standard error of the drift.
    pub drift_error: Option<f64>,
    /// Doubts about equilibrium, each once.
    pub doubts: Vec<String>,
}

impl MeanEquilibrium {
    /// Verdict on runs at one condition; `None` if they do not have to reach an equilibrium.
    fn from_runs(runs: &[HardBodyResult]) -> Option<Self> {
        let all: Option<Vec<&Equilibrium>> =
            runs.iter().map(|run| run.equilibrium.as_ref()).collect();
        let all = all?;
        let (measured, measured_error) = mean(&all, |run| {
            let error = run.measured_pressure_kt_per_volume_error;
            (run.measured_pressure_kt_per_volume, error)
        });
        let (drift, drift_error) =
            mean(&all, |run| (run.drift.unwrap_or(f64::NAN), run.drift_error));
        let mut doubts: Vec<String> = Vec::new();
        for doubt in all.iter().flat_map(|run| &run.doubts) {
            if !doubts.contains(doubt) {
                doubts.push(doubt.clone());
            }
        }
        Some(Self {
            is_reached: all.iter().all(|run| run.is_reached),
            measured_pressure_kt_per_volume: measured,
            measured_pressure_kt_per_volume_error: measured_error,
            expected_pressure_kt_per_volume: all[0].expected_pressure_kt_per_volume,
            drift: Some(drift).filter(|drift| drift.is_finite()),
            drift_error,
            doubts,
        })
    }

    /// The verdict in a word or two.
    fn verdict(&self) -> &'static str {
        match self.is_reached {
            true => "reached",
            false => "not reached",
        }
    }
}

/// The mean over runs; its error if all have one.
fn mean<T>(runs: &[T], value: impl Fn(&T) -> (f64, Option<f64>)) -> (f64, Option<f64>) {
    let count = runs.len() as f64;
    let (mut sum, mut squares) = (0.0, Some(0.0));
    for run in runs {
        let (value, error) = value(run);
        sum += value;
        squares = squares
            .zip(error)
            // One run without an error leaves the mean without one.
            .map(|(squares, error)| squares + error * error);
    }
    (
        sum / count,
        // Of independent runs: √(Σ σ²) / n.
        squares.map(|squares: f64| squares.sqrt() / count),
    )
}

impl StatePoint {
    pub(super) fn from_runs(runs: &[HardBodyResult]) -> Self {
        let first = &runs[0];
        let (packing, packing_error) = mean(runs, |run| {
            (run.packing_fraction, run.packing_fraction_error)
        });
        let (factor, factor_error) = mean(runs, |run| {
            (run.compressibility_factor, run.compressibility_factor_error)
        });
        let (reduced, _) = mean(runs, |run| (run.reduced_pressure, None));
        // The mean of the probabilities: that of their logarithms would be biased.
        let insertion = first.insertion_probability.map(|_| {
            mean(runs, |run| {
                let probability = run.insertion_probability.unwrap_or_default();
                (probability, run.insertion_probability_error)
            })
        });
        // No insertion succeeded in any run: there is no logarithm.
        let insertion = insertion.filter(|(probability, _)| *probability > 0.0);
        let free = first.free_volume_fraction.map(|_| {
            mean(runs, |run| {
                let fraction = run.free_volume_fraction.unwrap_or_default();
                (fraction, run.free_volume_fraction_error)
            })
        });
        Self {
            packing_fraction: packing,
            packing_fraction_error: packing_error,
            pressure_kt_per_volume: first.pressure_kt_per_volume,
            compressibility_factor: factor,
            compressibility_factor_error: factor_error,
            reduced_pressure: reduced,
            excess_chemical_potential_kt: insertion.map(|(probability, _)| -probability.ln()),
            excess_chemical_potential_kt_error: insertion
                .and_then(|(probability, error)| Some(error? / probability)),
            excess_free_energy_per_body_kt: None,
            excess_free_energy_per_body_kt_error: None,
            free_volume_fraction: free.map(|(fraction, _)| fraction),
            free_volume_fraction_error: free.and_then(|(_, error)| error),
            equilibrium: MeanEquilibrium::from_runs(runs),
            seeds: runs.len(),
        }
    }
}

/// Adds the free energies of a fluid, by integration from no bodies.
pub(super) fn integrate(points: &mut [StatePoint], b2_over_volume: f64) -> Result<()> {
    let factors: Vec<Factor> = points
        .iter()
        .map(|point| Factor {
            packing_fraction: point.packing_fraction,
            value: point.compressibility_factor,
            // NaN, not zero: an unknown error must not pass
            // for certainty, and comes out as NaN again.
            standard_error: point.compressibility_factor_error.unwrap_or(f64::NAN),
        })
        .collect();
    let energies = excess_free_energies(&factors, b2_over_volume)?;
    for (point, (energy_kt, error_kt)) in points.iter_mut().zip(energies) {
        point.excess_free_energy_per_body_kt = Some(energy_kt);
        point.excess_free_energy_per_body_kt_error =
            Some(error_kt).filter(|error| error.is_finite());
    }
    Ok(())
}

fn or_dash(value: Option<f64>, error: Option<f64>) -> String {
    value.map_or_else(|| "-".to_owned(), |value| with_error(value, error))
}

impl Answer for EquationOfState {
    fn text(&self) -> String {
        let mut rows = vec![heading([
            "packing fraction",
            "compressibility factor",
            "reduced pressure",
            "free energy (kT)",
            "chemical potential (kT)",
            "free volume",
        ])];
        let must_arrive = self.points.iter().any(|point| point.equilibrium.is_some());
        if must_arrive {
            rows[0].extend(["bodies bear", "of", "drift", "equilibrium"].map(str::to_owned));
        }
        for point in &self.points {
            rows.push(vec![
                with_error(point.packing_fraction, point.packing_fraction_error),
                with_error(
                    point.compressibility_factor,
                    point.compressibility_factor_error,
                ),
                format!("{:.5}", point.reduced_pressure),
                or_dash(
                    point.excess_free_energy_per_body_kt,
                    point.excess_free_energy_per_body_kt_error,
                ),
                or_dash(
                    point.excess_chemical_potential_kt,
                    point.excess_chemical_potential_kt_error,
                ),
                or_dash(point.free_volume_fraction, point.free_volume_fraction_error),
            ]);
            if let (Some(equilibrium), Some(row)) = (&point.equilibrium, rows.last_mut()) {
                row.extend([
                    with_error(
                        equilibrium.measured_pressure_kt_per_volume,
                        equilibrium.measured_pressure_kt_per_volume_error,
                    ),
                    format!("{:.5}", equilibrium.expected_pressure_kt_per_volume),
                    or_dash(equilibrium.drift, equilibrium.drift_error),
                    equilibrium.verdict().to_owned(),
                ]);
            }
        }
        columns(&rows)
    }

    fn figure(&self) -> Option<Figure> {
        let panels = [
            self.panel("compressibility factor", |point| {
                let factor = point.compressibility_factor;
                Some((factor, point.compressibility_factor_error))
            }),
            self.panel("excess chemical potential (kT)", |point| {
                let error = point.excess_chemical_potential_kt_error;
                Some((point.excess_chemical_potential_kt?, error))
            }),
            self.panel("free volume of depletants", |point| {
                let fraction = point.free_volume_fraction?;
                Some((fraction, point.free_volume_fraction_error))
            }),
        ];
        Some(Figure {
            title: format!("Equation of state: {}", self.settings.run.shape.join(", ")),
            caption: self.caption(),
            x: Axis::linear("packing fraction"),
            panels: panels.into_iter().flatten().collect(),
        })
    }
}

impl EquationOfState {
    /// The states that have not arrived at equilibrium, and why.
    pub fn warnings(&self) -> Vec<String> {
        let mut warnings = Vec::new();
        for point in &self.points {
            if let Some(equilibrium) = &point.equilibrium
                && !equilibrium.is_reached
            {
                warnings.push(format!(
                    "equilibrium is not reached or not shown at {} {}: {}",
                    match point.pressure_kt_per_volume {
                        Some(_) => "pressure",
                        None => "packing fraction",
                    },
                    point
                        .pressure_kt_per_volume
                        .unwrap_or(point.packing_fraction),
                    equilibrium.doubts.join("; ")
                ));
            }
        }
        warnings
    }

    fn caption(&self) -> String {
        let bodies = self.settings.run.bodies;
        let caption = format!("{bodies} bodies; error bars: standard errors");
        match self.warnings().len() {
            0 => caption,
            count => format!(
                "{caption}; {count} of {} states not shown to be in equilibrium",
                self.points.len()
            ),
        }
    }

    /// Panel of a measured quantity, with its error, against the packing fraction; `None` if it was
    /// not measured.
    fn panel(
        &self,
        label: &str,
        measured: impl Fn(&StatePoint) -> Option<(f64, Option<f64>)>,
    ) -> Option<Panel> {
        let mut points = Vec::new();
        for point in &self.points {
            if let Some((y, error)) = measured(point) {
                let x = point.packing_fraction;
                points.push(Point { x, y, error });
            }
        }
        let series = Series {
            name: label.to_owned(),
            line: true,
            points,
            ..Series::default()
        };
        (!series.points.is_empty()).then(|| Panel {
            y: Axis::linear(label),
            series: vec![series],
        })
    }

    pub(super) fn table(&self) -> Result<String> {
        let mut table = Table::new(vec![
            "packing_fraction",
            "packing_fraction_error",
            "pressure_kt_per_volume",
            "compressibility_factor",
            "compressibility_factor_error",
            "reduced_pressure",
            "excess_free_energy_per_body_kt",
            "excess_free_energy_per_body_kt_error",
            "excess_chemical_potential_kt",
            "excess_chemical_potential_kt_error",
            "free_volume_fraction",
            "free_volume_fraction_error",
            "measured_pressure_kt_per_volume",
            "measured_pressure_kt_per_volume_error",
            "expected_pressure_kt_per_volume",
            "drift",
            "drift_error",
            "is_in_equilibrium",
            "seeds",
        ]);
        let cell = |value: Option<f64>| value.map_or_else(|| Cell::from(""), Cell::from);
        for point in &self.points {
            let equilibrium = point.equilibrium.as_ref();
            table.push(vec![
                Cell::from(point.packing_fraction),
                cell(point.packing_fraction_error),
                cell(point.pressure_kt_per_volume),
                point.compressibility_factor.into(),
                cell(point.compressibility_factor_error),
                point.reduced_pressure.into(),
                cell(point.excess_free_energy_per_body_kt),
                cell(point.excess_free_energy_per_body_kt_error),
                cell(point.excess_chemical_potential_kt),
                cell(point.excess_chemical_potential_kt_error),
                cell(point.free_volume_fraction),
                cell(point.free_volume_fraction_error),
                cell(equilibrium.map(|equilibrium| equilibrium.measured_pressure_kt_per_volume)),
                cell(
                    equilibrium
                        .and_then(|equilibrium| equilibrium.measured_pressure_kt_per_volume_error),
                ),
                cell(equilibrium.map(|equilibrium| equilibrium.expected_pressure_kt_per_volume)),
                cell(equilibrium.and_then(|equilibrium| equilibrium.drift)),
                cell(equilibrium.and_then(|equilibrium| equilibrium.drift_error)),
                Cell::from(
                    equilibrium.map_or("", |equilibrium| match equilibrium.is_reached {
                        true => "true",
                        false => "false",
                    }),
                ),
                point.seeds.into(),
            ])?;
        }
        Ok(table.to_csv()?)
    }
}
