//! Coexisting phases: of spheres among depletants by free volume theory, of tables, or of what
//! simulations measured.
//!
//! | module | one idea |
//! |---|---|
//! | [`mod@mixtures`] | spheres among depletants, by theory |
//! | [`mod@tables`] | free energies from files |
//! | [`mod@measured`] | free energies from sweeps and free energies of crystals, with errors |
//! | `figure` | the diagram |

mod figure;
pub mod measured;
pub mod mixtures;
pub mod tables;

pub use figure::draw;
pub use measured::{PhaseDirectories, phases_of_measurements};
pub use mixtures::phases_of_mixtures;
pub use tables::phases_of_tables;

use protomer_common::answer::{Answer, columns, heading};
use protomer_plot::Figure;
use serde::Serialize;

/// Phases that coexist, and where none do.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Phases {
    /// Whether any phases coexist.
    pub has_coexistence: bool,
    /// Each coexistence in equilibrium.
    pub coexistences: Vec<Coexistence>,
    /// Packing fractions of the reservoir for which no phases coexist where they were measured.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub reservoirs_without: Vec<f64>,
    /// Coexistence of gas and liquid where a solid is more stable.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub metastable: Vec<Coexistence>,
    /// Critical point of gas and liquid for each size ratio that has one.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub critical_points: Vec<CriticalPoint>,
    /// Triple point for each size ratio that has one.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub triple_points: Vec<TriplePoint>,
}

/// Two phases that coexist.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Coexistence {
    /// Radius of the depletants over that of the spheres.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub size_ratio: Option<f64>,
    /// Packing fraction of the depletants in the reservoir.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reservoir_packing_fraction: Option<f64>,
    /// Names of the phases.
    pub phases: [String; 2],
    /// Packing fractions, ascending; densities if the tables have those.
    pub packing_fractions: [f64; 2],
    /// Uncertainty from the errors of measured free energies.
    #[serde(flatten)]
    pub uncertainty: Option<Uncertainty>,
    /// Pressure, with that of the depletants.
    pub pressure: f64,
    /// Pressure beyond that of the reservoir.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub osmotic_pressure: Option<f64>,
    /// Chemical potential of the bodies.
    pub chemical_potential: f64,
    /// Free volume of the depletants in each phase, as a part of it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub free_volume_fractions: Option<[f64; 2]>,
}

/// Scatter of a coexistence when the measured values are drawn again within their errors.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Uncertainty {
    /// Standard errors of the packing fractions.
    pub packing_fractions_error: [f64; 2],
    /// Standard error of the pressure.
    pub pressure_error: f64,
    /// Standard error of the chemical potential.
    pub chemical_potential_error: f64,
    /// The part of all draws in which these phases coexist here: one that is far from 1 is in doubt.
    pub share_of_draws: f64,
}

/// Critical point, at which gas and liquid become one.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CriticalPoint {
    /// Radius of the depletants over that of the spheres.
    pub size_ratio: f64,
    /// Packing fraction of the spheres.
    pub packing_fraction: f64,
    /// Packing fraction of the depletants in the reservoir.
    pub reservoir_packing_fraction: f64,
    /// Whether no solid is more stable at the critical point.
    pub is_stable: bool,
}

/// Triple point, at which gas, liquid and solid coexist.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TriplePoint {
    /// Radius of the depletants over that of the spheres.
    pub size_ratio: f64,
    /// Packing fraction of the depletants in the reservoir.
    pub reservoir_packing_fraction: f64,
    /// Packing fractions of the spheres in gas, liquid and solid.
    pub packing_fractions: [f64; 3],
}

impl Answer for Phases {
    fn text(&self) -> String {
        let mut lines = Vec::new();
        if !self.coexistences.is_empty() {
            lines.push(columns(&rows(&self.coexistences)));
        } else if self.reservoirs_without.is_empty() {
            lines.push("no coexistence: no line touches the free energy twice from below".into());
        }
        for reservoir in &self.reservoirs_without {
            lines.push(format!(
                "reservoir {reservoir}: no phases coexist at the packing fractions that were measured"
            ));
        }
        if !self.metastable.is_empty() {
            lines.push("metastable, a solid is more stable:".into());
            lines.push(columns(&rows(&self.metastable)));
        }
        for point in &self.critical_points {
            let stable = if point.is_stable { "" } else { " (metastable)" };
            lines.push(format!(
                "q = {}: critical point at packing fraction {:.6}, reservoir {:.6}{stable}",
                point.size_ratio, point.packing_fraction, point.reservoir_packing_fraction
            ));
        }
        for point in &self.triple_points {
            let [gas, liquid, solid] = point.packing_fractions;
            lines.push(format!(
                "q = {}: triple point at reservoir {:.6}: {gas:.6}, {liquid:.6}, {solid:.6}",
                point.size_ratio, point.reservoir_packing_fraction
            ));
        }
        lines.join("\n")
    }

    fn figure(&self) -> Option<Figure> {
        let first = self.coexistences.first()?;
        first.reservoir_packing_fraction?;
        Some(figure::against_reservoir(self, first.size_ratio))
    }
}

fn rows(coexistences: &[Coexistence]) -> Vec<Vec<String>> {
    let mut rows = vec![heading([
        "q",
        "reservoir",
        "phases",
        "packing fractions",
        "pressure",
        "chemical potential",
    ])];
    let is_measured = coexistences
        .iter()
        .any(|coexistence| coexistence.uncertainty.is_some());
    if is_measured {
        rows[0].push("share of draws".into());
    }
    let number = |value: Option<f64>| value.map_or_else(|| "-".to_owned(), |x| x.to_string());
    for coexistence in coexistences {
        let mut row = vec![
            number(coexistence.size_ratio),
            number(coexistence.reservoir_packing_fraction),
            coexistence.phases.join(", "),
        ];
        row.extend(coexistence.values());
        rows.push(row);
    }
    rows
}

impl Coexistence {
    /// Packing fractions, pressure and chemical potential, with their errors and the share of draws if
    /// they were measured.
    fn values(&self) -> Vec<String> {
        let [low, high] = self.packing_fractions;
        let Some(uncertainty) = &self.uncertainty else {
            return vec![
                format!("{low:.6}, {high:.6}"),
                format!("{:.6}", self.pressure),
                format!("{:.6}", self.chemical_potential),
            ];
        };
        let with_error = |value: f64, error: f64| format!("{value:.4} ± {error:.4}");
        let [low_error, high_error] = uncertainty.packing_fractions_error;
        vec![
            format!(
                "{}, {}",
                with_error(low, low_error),
                with_error(high, high_error)
            ),
            with_error(self.pressure, uncertainty.pressure_error),
            with_error(
                self.chemical_potential,
                uncertainty.chemical_potential_error,
            ),
            format!("{:.2}", uncertainty.share_of_draws),
        ]
    }
}

impl Phases {
    /// Phases without any coexistence, so far.
    fn none() -> Self {
        Self {
            has_coexistence: false,
            coexistences: Vec::new(),
            reservoirs_without: Vec::new(),
            metastable: Vec::new(),
            critical_points: Vec::new(),
            triple_points: Vec::new(),
        }
    }
}
