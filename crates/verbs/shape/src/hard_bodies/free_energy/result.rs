//! The answer, as text, JSON and a table.

use anyhow::Result;
use protomer_common::answer::Answer;
use protomer_hpmc::frenkel_ladd::FreeEnergy;
use protomer_io::csv::{Cell, Table};
use serde::{Deserialize, Serialize};

/// A point with fewer independent samples is called slow.
pub(super) const FEW_SAMPLES: f64 = 50.0;

/// A point of the integral over the strength of the springs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PointResult {
    /// Strength λ, kT per squared length.
    pub strength_kt_per_area: f64,
    /// Weight of the extent in the integral.
    pub weight: f64,
    /// Extent f, squared length.
    pub extent: f64,
    /// Standard error of the extent.
    pub extent_error: f64,
    /// Contribution to the integral, kT per body.
    pub contribution_kt: f64,
    /// Standard error of the contribution.
    #[serde(alias = "contribution_error_kt")]
    pub contribution_kt_error: f64,
    /// Sweeps measured.
    pub sweeps: u64,
    /// Integrated autocorrelation time of the extent, at least half of the sweeps of a row.
    pub correlation_time_sweeps: f64,
    /// Samples that would be as good if they were independent.
    pub independent_samples: f64,
}

/// A free energy of a crystal. Lengths are in the unit of the shape, energies in kT per body.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FreeEnergyResult {
    /// File or name of the shape.
    pub shape: String,
    /// The crystal.
    pub crystal: String,
    /// Number of dimensions, 1, 2 or 3.
    pub dimension: usize,
    /// Number of bodies.
    pub bodies: usize,
    /// Part of the box that the bodies fill.
    pub packing_fraction: f64,
    /// Bodies per volume.
    pub number_density: f64,
    /// Lengths of the box.
    pub box_edges: Vec<f64>,
    /// Tilt factors of the box, xy, xz and yz; none where its angles are right.
    #[serde(skip_serializing_if = "Vec::is_empty", default)]
    pub box_tilt_factors: Vec<f64>,
    /// Proper rotations that leave the shape as it is; two for an axis of revolution, which they keep or reverse.
    pub symmetry_order: usize,
    /// A/(N kT) for a thermal wavelength of one and an integral of one over all orientations.
    pub free_energy_per_body_kt: f64,
    /// Standard error of the free energy.
    #[serde(alias = "free_energy_per_body_error_kt")]
    pub free_energy_per_body_kt_error: f64,
    /// Free energy less that of an ideal gas of this density, ln ρ - 1: no wavelength is in it.
    pub excess_free_energy_per_body_kt: f64,
    /// Standard error of the excess free energy.
    #[serde(alias = "excess_free_energy_per_body_error_kt")]
    pub excess_free_energy_per_body_kt_error: f64,
    /// The terms of the free energy.
    pub terms: FreeEnergy,
    /// Results for each point of the integral.
    pub points: Vec<PointResult>,
    /// Points with few independent samples, whose errors are uncertain.
    pub slow_points: Vec<usize>,
}

impl Answer for FreeEnergyResult {
    fn text(&self) -> String {
        let terms = &self.terms;
        let mut lines = vec![
            format!(
                "{} bodies ({}), {}, packing fraction {}, number density {:.6}",
                self.bodies, self.shape, self.crystal, self.packing_fraction, self.number_density
            ),
            format!(
                "free energy {:.5} ± {:.5} kT per body (thermal wavelength 1)",
                self.free_energy_per_body_kt, self.free_energy_per_body_kt_error
            ),
            format!(
                "excess over an ideal gas {:.5} ± {:.5} kT per body",
                self.excess_free_energy_per_body_kt, self.excess_free_energy_per_body_kt_error
            ),
            format!("centre of mass      {:10.5}", terms.centre_of_mass_kt),
            format!("strongest springs   {:10.5}", terms.springs_kt),
            format!("orientations        {:10.5}", terms.orientations_kt),
            format!(
                "overlaps with them  {:10.5} ± {:.5}",
                terms.overlaps_kt, terms.overlaps_kt_error
            ),
            format!(
                "weaker springs      {:10.5} ± {:.5}",
                -terms.integral_kt, terms.integral_kt_error
            ),
            format!(
                "a coarser rule differs by {:.5} ± {:.5}",
                terms.rules_difference_kt, terms.rules_difference_kt_error
            ),
        ];
        lines.extend(self.slow());
        lines.join("\n")
    }
}

impl FreeEnergyResult {
    /// Number of slow strengths, and the slowest of them, in words; `None` if none is slow.
    pub fn slow(&self) -> Option<String> {
        let points = self.slow_points.iter().map(|number| &self.points[*number]);
        let slowest = points.min_by(|one, other| {
            one.independent_samples
                .total_cmp(&other.independent_samples)
        })?;
        Some(format!(
            "slow: {} of {} strengths have fewer than {FEW_SAMPLES} independent samples (springs of {:.4}: {:.0} in \
             {} sweeps); their errors are uncertain, so give more sweeps",
            self.slow_points.len(),
            self.points.len(),
            slowest.strength_kt_per_area,
            slowest.independent_samples,
            slowest.sweeps
        ))
    }
}

/// A row per strength.
pub(super) fn table_of(points: &[PointResult]) -> Result<String> {
    let mut table = Table::new(vec![
        "strength_kt_per_area",
        "weight",
        "extent",
        "extent_error",
        "contribution_kt",
        "contribution_kt_error",
        "sweeps",
        "correlation_time_sweeps",
        "independent_samples",
    ]);
    for point in points {
        table.push(vec![
            Cell::from(point.strength_kt_per_area),
            point.weight.into(),
            point.extent.into(),
            point.extent_error.into(),
            point.contribution_kt.into(),
            point.contribution_kt_error.into(),
            Cell::from(point.sweeps as usize),
            point.correlation_time_sweeps.into(),
            point.independent_samples.into(),
        ])?;
    }
    Ok(table.to_csv()?)
}
