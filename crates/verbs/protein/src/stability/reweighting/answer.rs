//! The answer: text, tables, figure.

use super::equilibrated;
use super::samples::Samples;
use crate::stability::sweep::stability::with_interval;
use anyhow::Result;
use protomer_common::answer::{Answer, columns, heading};
use protomer_io::csv::{Cell, Table};
use protomer_mc::contributions::Mean;
use protomer_plot::{Axis, Figure, Panel, Point, Series, Span};
use protomer_results::keys::read_json_if_present;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Largest energy of a body that touches no other, kT; above it mass action holds only roughly. In
/// the validation half of it shifts a fraction by 5 % at an eighth of the concentration.
const LARGEST_ENERGY_APART_KT: f64 = 0.05;

/// Name of the file of the result.
pub(super) const FILE: &str = "reweighting.json";

/// Curves over salt from all frames of a sweep.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ReweightingResult {
    /// Version of the program.
    pub version: String,
    /// Number of bodies.
    pub bodies: usize,
    /// Frames of all salts and replicas.
    pub frames: usize,
    /// Blocks of frames from which the errors come.
    pub blocks: usize,
    /// Salts that were simulated, mol/L.
    #[serde(rename = "simulated_salt_M")]
    pub simulated_salt_molar: Vec<f64>,
    /// -ln of the partition function at each simulated salt, kT, that of the first being zero.
    #[serde(rename = "free_energy_kT")]
    pub free_energy_kt: Vec<f64>,
    /// Whether the starts of the sweep agree; null if all start alike.
    pub equilibrated: Option<bool>,
    /// Mean size of the energy of a body in frames in which none touch, kT, at the salt where it is
    /// largest; null without such frames.
    #[serde(rename = "energy_apart_kT")]
    pub energy_apart_kt: Option<f64>,
    /// The curves at the concentration of bodies of the sweep, and at others.
    pub concentrations: Vec<ConcentrationCurve>,
}

/// The curves at one concentration of bodies.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ConcentrationCurve {
    /// Concentration of the bodies, mol/L; zero in open space.
    #[serde(rename = "concentration_M")]
    pub concentration_molar: f64,
    /// Salt at which half of the contacts are left; null if there is none, if the frames are too
    /// few, or if the starts of the sweep disagree.
    pub half_salt: Option<HalfSaltEstimate>,
    /// Salt at which half of the bodies touch another.
    pub half_bound_salt: Option<HalfSaltEstimate>,
    /// Points of the curves, ascending by salt.
    pub points: Vec<CurvePoint>,
}

/// A point of the curves.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct CurvePoint {
    /// Salt concentration, mol/L.
    #[serde(rename = "salt_M")]
    pub salt_molar: f64,
    /// Contacts over those of the assembly; null if the assembly has none.
    pub contacts_left: Option<Mean>,
    /// Fraction of the bodies that touch another.
    pub bound_fraction: Mean,
    /// Number of frames of equal weight that would be as good.
    pub effective_frames: f64,
}

/// A half salt.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct HalfSaltEstimate {
    /// Salt concentration, mol/L.
    #[serde(rename = "salt_M")]
    pub salt_molar: f64,
    /// Interval of 95 % of the half salt, mol/L; null if the curve without some of the frames has
    /// none within the salts of the sweep.
    #[serde(rename = "interval_M")]
    pub interval_molar: Option<[f64; 2]>,
    /// Number of frames of equal weight that would be as good near the half salt.
    pub effective_frames: f64,
}

impl ReweightingResult {
    /// Reads the result in a folder; `None` if there is none.
    ///
    /// # Errors
    /// If it is damaged.
    pub fn read(folder: &Path) -> protomer_results::Result<Option<Self>> {
        read_json_if_present(&folder.join(FILE))
    }

    pub(super) fn new(
        directory: &Path,
        samples: &Samples,
        free_energy_kt: Vec<f64>,
        mut concentrations: Vec<ConcentrationCurve>,
        bodies: usize,
    ) -> Result<Self> {
        let equilibrated = equilibrated(directory)?;
        if equilibrated == Some(false) {
            for curve in &mut concentrations {
                (curve.half_salt, curve.half_bound_salt) = (None, None);
            }
        }
        Ok(Self {
            version: env!("CARGO_PKG_VERSION").into(),
            bodies,
            frames: samples.frames.len(),
            blocks: samples.blocks,
            simulated_salt_molar: samples.simulated_molar.clone(),
            free_energy_kt,
            equilibrated,
            energy_apart_kt: samples.energy_apart_kt(bodies),
            concentrations,
        })
    }

    /// A row for each point of each curve.
    pub(super) fn table(&self) -> Result<String> {
        let mut table = Table::new(vec![
            "concentration_M",
            "salt_M",
            "contacts_left",
            "contacts_left_error",
            "bound_fraction",
            "bound_fraction_error",
            "effective_frames",
        ]);
        for curve in &self.concentrations {
            for point in &curve.points {
                table.push(vec![
                    Cell::from(curve.concentration_molar),
                    point.salt_molar.into(),
                    Cell::from(point.contacts_left.map(|estimate| estimate.mean)),
                    Cell::from(point.contacts_left.and_then(|estimate| estimate.error)),
                    point.bound_fraction.mean.into(),
                    Cell::from(point.bound_fraction.error),
                    point.effective_frames.into(),
                ])?;
            }
        }
        Ok(table.to_csv()?)
    }

    pub(super) fn drawn(&self) -> Figure {
        let has_salt = self.simulated_salt_molar.iter().all(|salt| *salt > 0.0);
        let panel = |name: &str, value: ValueOfPoint, half: HalfOfCurve| Panel {
            y: Axis::linear(name).with_range(0.0, 1.05),
            series: self
                .concentrations
                .iter()
                .map(|curve| series(curve, value, half(curve)))
                .collect(),
        };
        let mut panels = vec![panel(
            "bodies that touch another",
            |point| Some(point.bound_fraction),
            |curve| curve.half_bound_salt,
        )];
        if self.has_contacts() {
            let contacts_panel = panel(
                "contacts left",
                |point| point.contacts_left,
                |curve| curve.half_salt,
            );
            panels.insert(0, contacts_panel);
        }
        Figure {
            title: "Stability against salt, from all frames".into(),
            caption: format!(
                "{} bodies, {} frames; horizontal bars: where one half is left, 95 %",
                self.bodies, self.frames
            ),
            x: match has_salt {
                true => Axis::log("salt (mM)"),
                false => Axis::linear("salt (mM)"),
            },
            panels,
        }
    }

    /// Whether the assembly has contacts, of which a share can be left.
    fn has_contacts(&self) -> bool {
        let mut points = self.concentrations.iter().flat_map(|curve| &curve.points);
        points.any(|point| point.contacts_left.is_some())
    }

    fn notes(&self) -> Vec<String> {
        let mut notes = Vec::new();
        if !self.has_contacts() {
            notes.push(
                "in the assembly no two bodies touch, so there are no contacts of which a share could \
                 be left; the share of bodies that touch another is known"
                    .into(),
            );
        }
        match self.equilibrated {
            Some(false) => notes.push(
                "not equilibrated: the answer of the sweep says why and what to do; weights say nothing of the \
                 half salt"
                    .into(),
            ),
            None => notes.push(
                "whether this is an equilibrium is not known, and weights suppose it: begin the sweep \
                 with --starts both"
                    .into(),
            ),
            Some(true) => {}
        }
        if self.concentrations.len() > 1 && self.equilibrated != Some(false) {
            notes.push(match self.energy_apart_kt {
                Some(energy_kt) if energy_kt <= LARGEST_ENERGY_APART_KT => format!(
                    "other concentrations by mass action: a body that touches none has at most \
                     {energy_kt:.3} kT, so clusters hardly feel each other"
                ),
                Some(energy_kt) => format!(
                    "other concentrations are rough: a body that touches none has up to \
                     {energy_kt:.2} kT, so clusters feel each other, most at the lowest salt, and \
                     mass action leaves that out"
                ),
                None => {
                    "other concentrations by mass action, which supposes that clusters do not feel \
                         each other: no frame without contacts shows whether that is so"
                        .into()
                }
            });
        }
        notes
    }
}

impl Answer for ReweightingResult {
    fn text(&self) -> String {
        let mut lines = vec![format!(
            "{} bodies, {} frames of {} salts in {} blocks",
            self.bodies,
            self.frames,
            self.simulated_salt_molar.len(),
            self.blocks
        )];
        // Half salts are all that is said of other concentrations, and there are none.
        let told = match self.equilibrated {
            Some(false) => 1,
            _ => self.concentrations.len(),
        };
        for (number, curve) in self.concentrations.iter().take(told).enumerate() {
            let concentration = 1e3 * curve.concentration_molar;
            match (number, concentration > 0.0) {
                (0, true) => {
                    lines.push(format!("at {concentration:.4} mM of bodies, as simulated"))
                }
                (_, true) => lines.push(format!("at {concentration:.4} mM of bodies:")),
                (_, false) => {}
            }
            // The other curves are in the table and the figure.
            if number == 0 {
                lines.push(columns(&curve.rows()));
            }
            if self.equilibrated != Some(false) {
                lines.extend(curve.halves());
            }
        }
        lines.extend(self.notes());
        lines.join("\n")
    }

    fn figure(&self) -> Option<Figure> {
        Some(self.drawn())
    }
}

impl ConcentrationCurve {
    fn rows(&self) -> Vec<Vec<String>> {
        let mut rows = vec![heading([
            "salt (M)",
            "contacts left",
            "±",
            "bound",
            "±",
            "effective frames",
        ])];
        let mean = |estimate: Option<Mean>| {
            estimate.map_or("-".into(), |estimate| format!("{:.3}", estimate.mean))
        };
        let error = |estimate: Option<Mean>| {
            let error = estimate.and_then(|estimate| estimate.error);
            error.map_or("-".into(), |error| format!("{error:.3}"))
        };
        for point in &self.points {
            rows.push(vec![
                format!("{:.4}", point.salt_molar),
                mean(point.contacts_left),
                error(point.contacts_left),
                mean(Some(point.bound_fraction)),
                error(Some(point.bound_fraction)),
                format!("{:.0}", point.effective_frames),
            ]);
        }
        rows
    }

    fn halves(&self) -> Vec<String> {
        let mut crossings = vec![("half of the bodies touch another", self.half_bound_salt)];
        if self
            .points
            .iter()
            .any(|point| point.contacts_left.is_some())
        {
            crossings.insert(0, ("half of the contacts are left", self.half_salt));
        }
        let in_words = |(event, half): (&str, Option<HalfSaltEstimate>)| match half {
            Some(half) => {
                let interval = half.interval_molar.map(|ends| ends.map(Some));
                let salt = with_interval(half.salt_molar, interval.unwrap_or([None, None]));
                format!("{event} at {salt}")
            }
            None => format!("{event} at no salt of the sweep, or on too few frames to say where"),
        };
        crossings.into_iter().map(in_words).collect()
    }
}

type ValueOfPoint = fn(&CurvePoint) -> Option<Mean>;
type HalfOfCurve = fn(&ConcentrationCurve) -> Option<HalfSaltEstimate>;

/// A curve, with the salt at which it is one half and its interval.
fn series(
    curve: &ConcentrationCurve,
    value: ValueOfPoint,
    half: Option<HalfSaltEstimate>,
) -> Series {
    let mut points = Vec::new();
    for point in &curve.points {
        if let Some(estimate) = value(point) {
            points.push(Point {
                x: 1e3 * point.salt_molar,
                y: estimate.mean,
                error: estimate.error,
            });
        }
    }
    Series {
        name: match curve.concentration_molar > 0.0 {
            true => format!("{:.3} mM of bodies", 1e3 * curve.concentration_molar),
            false => "no box".into(),
        },
        points,
        line: true,
        spans: half.into_iter().map(span).collect(),
        ..Series::default()
    }
}

/// Bar of a half salt; without an interval it has no length.
fn span(half: HalfSaltEstimate) -> Span {
    let [from, to] = half.interval_molar.unwrap_or([half.salt_molar; 2]);
    Span {
        x: 1e3 * half.salt_molar,
        y: 0.5,
        from: 1e3 * from,
        to: 1e3 * to,
    }
}
