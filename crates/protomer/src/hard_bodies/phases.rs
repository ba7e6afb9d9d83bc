//! Coexisting phases: of spheres among depletants by free volume theory, or of tables.

use anyhow::{Context, Result, bail};
use protomer_common::answer::{Answer, columns, heading};
use protomer_common::input::InputFile;
use protomer_common::output_file::write_once;
use protomer_hpmc::free_volume_theory::{Mixture, PHASES};
use protomer_hpmc::jet::Jet;
use protomer_hpmc::spline::Spline;
use protomer_hpmc::tangent::{self, Branch, even_samples};
use protomer_plot::{Axis, Figure, Panel, Point, Series};
use serde::Serialize;
use std::path::{Path, PathBuf};

/// Samples of a table's spline.
const SAMPLES: usize = 20_000;
/// Fewer points make no spline that is worth a tangent.
const FEWEST_POINTS: usize = 5;

/// Phases that coexist, and where none do.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Phases {
    /// Whether any phases coexist.
    pub has_coexistence: bool,
    /// Each coexistence in equilibrium.
    pub coexistences: Vec<Coexistence>,
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

/// Where gas and liquid become one.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CriticalPoint {
    /// Radius of the depletants over that of the spheres.
    pub size_ratio: f64,
    /// Packing fraction of the spheres.
    pub packing_fraction: f64,
    /// Packing fraction of the depletants in the reservoir.
    pub reservoir_packing_fraction: f64,
    /// Whether no solid is more stable there.
    pub is_stable: bool,
}

/// Where gas, liquid and solid coexist.
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
        if self.coexistences.is_empty() {
            lines.push("no coexistence: no line touches the free energy twice from below".into());
        } else {
            lines.push(columns(&rows(&self.coexistences)));
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
        let (q, _) = first.size_ratio.zip(first.reservoir_packing_fraction)?;
        Some(figure_of_mixture(self, q))
    }
}

/// Packing fractions of coexisting phases against that of the depletants in the reservoir.
fn figure_of_mixture(phases: &Phases, q: f64) -> Figure {
    let is_here = |found: &&Coexistence| found.size_ratio == Some(q);
    let series = |name: &str, points: Vec<Point>, line: bool| Series {
        name: name.to_owned(),
        points,
        line,
        ..Series::default()
    };
    let at = |x: f64, y: f64| Point { x, y, error: None };
    let mut drawn = Vec::new();
    for (found, name) in [
        (&phases.metastable, "metastable gas and liquid"),
        (&phases.coexistences, "coexistence"),
    ] {
        for tie in found.iter().filter(is_here) {
            let y = tie.reservoir_packing_fraction.unwrap_or_default();
            let ends = tie.packing_fractions.map(|x| at(x, y)).to_vec();
            drawn.push(series(name, ends, true));
        }
    }
    for point in phases
        .critical_points
        .iter()
        .filter(|point| point.size_ratio == q)
    {
        let place = at(point.packing_fraction, point.reservoir_packing_fraction);
        drawn.push(series("critical point", vec![place], false));
    }
    for point in phases
        .triple_points
        .iter()
        .filter(|point| point.size_ratio == q)
    {
        let y = point.reservoir_packing_fraction;
        let places = point.packing_fractions.map(|x| at(x, y)).to_vec();
        drawn.push(series("triple point", places, true));
    }
    Figure {
        title: format!("Spheres among depletants, size ratio {q}"),
        caption: "lines join phases that coexist".into(),
        x: Axis::linear("packing fraction of the spheres"),
        panels: vec![Panel {
            y: Axis::linear("packing fraction of the depletants in the reservoir"),
            series: drawn,
        }],
    }
}

/// Draws a phase diagram of spheres among depletants, a PNG or SVG file.
///
/// # Errors
/// Without a coexistence, for several size ratios, for another extension, or a file that exists with
/// other content unless `force` is set.
pub fn draw(phases: &Phases, output: &Path, force: bool) -> Result<()> {
    let ratios = phases.coexistences.iter().map(|found| found.size_ratio);
    let Some(figure) = phases.figure() else {
        bail!("no phases coexist, so there is no diagram to draw; leave out --output");
    };
    if ratios
        .clone()
        .any(|ratio| Some(ratio) != ratios.clone().next())
    {
        bail!("a figure holds one size ratio; give one, or leave out --output");
    }
    match output.extension().and_then(|ending| ending.to_str()) {
        Some("png") => write_once(output, &figure.to_png()?, force),
        Some("svg") => write_once(output, &figure.to_svg()?, force),
        _ => bail!(
            "{} ends in neither .png nor .svg; choose one of them",
            output.display()
        ),
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
    let number = |value: Option<f64>| value.map_or_else(|| "-".to_owned(), |x| x.to_string());
    for found in coexistences {
        let [low, high] = found.packing_fractions;
        rows.push(vec![
            number(found.size_ratio),
            number(found.reservoir_packing_fraction),
            found.phases.join(", "),
            format!("{low:.6}, {high:.6}"),
            format!("{:.6}", found.pressure),
            format!("{:.6}", found.chemical_potential),
        ]);
    }
    rows
}

/// Phases of hard spheres among penetrable depletants, for each size ratio and each reservoir.
///
/// # Errors
/// For a size ratio that is not positive, or a negative packing fraction.
///
/// ```
/// let found = protomer::hard_bodies::phases::phases_of_mixtures(&[0.1], &[0.05])?;
/// assert_eq!(found.coexistences[0].phases, ["fluid", "solid"]);
/// assert!((found.coexistences[0].packing_fractions[0] - 0.4854011093).abs() < 1e-9);
/// # Ok::<(), anyhow::Error>(())
/// ```
pub fn phases_of_mixtures(size_ratios: &[f64], reservoirs: &[f64]) -> Result<Phases> {
    let mut phases = Phases {
        has_coexistence: false,
        coexistences: Vec::new(),
        metastable: Vec::new(),
        critical_points: Vec::new(),
        triple_points: Vec::new(),
    };
    for q in size_ratios.iter().copied() {
        for reservoir in reservoirs.iter().copied() {
            let mixture = Mixture::new(q, reservoir)?;
            let stable = mixture.coexistences();
            let named = |found: &tangent::Coexistence, names: [&str; 2]| Coexistence {
                size_ratio: Some(q),
                reservoir_packing_fraction: Some(reservoir),
                phases: names.map(str::to_owned),
                packing_fractions: found.densities,
                pressure: found.pressure + mixture.reservoir_pressure(),
                osmotic_pressure: Some(found.pressure),
                chemical_potential: found.chemical_potential,
                free_volume_fractions: Some(found.densities.map(|eta| mixture.free_volume(eta))),
            };
            for found in &stable {
                let names = match (found.branches, stable.len()) {
                    ([0, 0], _) => ["gas", "liquid"],
                    ([0, _], 2..) => ["liquid", PHASES[1]],
                    _ => PHASES,
                };
                phases.coexistences.push(named(found, names));
            }
            if stable.len() == 1
                && let Some(found) = mixture.gas_and_liquid()
            {
                phases.metastable.push(named(&found, ["gas", "liquid"]));
            }
        }
        if let Some(critical) = Mixture::critical_point(q)? {
            phases.critical_points.push(CriticalPoint {
                size_ratio: q,
                packing_fraction: critical.packing_fraction,
                reservoir_packing_fraction: critical.reservoir,
                is_stable: critical.is_stable,
            });
        }
        if let Some(triple) = Mixture::triple_point(q)? {
            phases.triple_points.push(TriplePoint {
                size_ratio: q,
                reservoir_packing_fraction: triple.reservoir,
                packing_fractions: triple.packing_fractions,
            });
        }
    }
    phases.has_coexistence = !phases.coexistences.is_empty();
    Ok(phases)
}

/// Phases whose free energies per volume are in tables, one file per phase: two columns, the density and
/// the free energy, with densities ascending.
///
/// # Errors
/// Names the file and the line that is wrong.
pub fn phases_of_tables(paths: &[PathBuf]) -> Result<Phases> {
    let (mut names, mut splines) = (Vec::new(), Vec::new());
    for path in paths {
        let file = InputFile::read(path)?;
        let text = String::from_utf8_lossy(&file.bytes);
        splines.push(read_table(&file.name, &text)?);
        let stem = path.file_stem().context("a branch has no file name")?;
        names.push(stem.to_string_lossy().into_owned());
    }
    let energies: Vec<_> = splines.iter().map(|spline| |x: Jet| spline.at(x)).collect();
    let mut branches: Vec<Branch<'_>> = Vec::new();
    for (number, spline) in splines.iter().enumerate() {
        let [first, last] = spline.range();
        branches.push(Branch {
            name: &names[number],
            free_energy: &energies[number],
            samples: even_samples(first, last, SAMPLES),
        });
    }
    let found = tangent::coexistences(&branches);
    let named = |found: &tangent::Coexistence| Coexistence {
        size_ratio: None,
        reservoir_packing_fraction: None,
        phases: found.branches.map(|branch| names[branch].clone()),
        packing_fractions: found.densities,
        pressure: found.pressure,
        osmotic_pressure: None,
        chemical_potential: found.chemical_potential,
        free_volume_fractions: None,
    };
    Ok(Phases {
        has_coexistence: !found.is_empty(),
        coexistences: found.iter().map(named).collect(),
        metastable: Vec::new(),
        critical_points: Vec::new(),
        triple_points: Vec::new(),
    })
}

/// The spline of a table: two columns.
fn read_table(name: &str, text: &str) -> Result<Spline> {
    let (mut x, mut y) = (Vec::new(), Vec::new());
    for (number, line) in text.lines().enumerate() {
        let line = line.split('#').next().unwrap_or_default();
        let cells = line.split([' ', '\t', ',']).filter(|cell| !cell.is_empty());
        let numbers: Option<Vec<f64>> = cells.map(|cell| cell.parse().ok()).collect();
        match numbers.as_deref() {
            Some([]) => {}
            Some([density, energy])
                if energy.is_finite() && x.last().is_none_or(|last| last < density) =>
            {
                x.push(*density);
                y.push(*energy);
            }
            _ => bail!(
                "{name}:{}: '{}' is not a density above the last and a free energy; write two \
                 numbers per line",
                number + 1,
                line.trim()
            ),
        }
    }
    if x.len() < FEWEST_POINTS {
        bail!(
            "{name} has {} points; give at least {FEWEST_POINTS}",
            x.len()
        );
    }
    Spline::through(x.into_iter().zip(y)).with_context(|| name.to_owned())
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    fn table(name: &str, low: f64, high: f64, f: impl Fn(f64) -> f64) -> (PathBuf, String) {
        let points = 400;
        let mut text = String::from("# density free energy\n");
        for number in 0..=points {
            let x = low + (high - low) * f64::from(number) / f64::from(points);
            text.push_str(&format!("{x} {}\n", f(x)));
        }
        (PathBuf::from(name), text)
    }

    fn phases(tables: &[(PathBuf, String)]) -> Phases {
        let folder = tempfile::tempdir().unwrap();
        let mut paths = Vec::new();
        for (name, text) in tables {
            let path = folder.path().join(name);
            std::fs::write(&path, text).unwrap();
            paths.push(path);
        }
        phases_of_tables(&paths).unwrap()
    }

    #[test]
    fn tables_have_the_tangents_of_their_functions() {
        let one = table("one.txt", 0.0, 1.0, |x| 2.0 * (x - 0.2_f64).powi(2) + 0.1);
        let two = table("two.txt", 0.0, 1.0, |x| 3.0 * (x - 0.7_f64).powi(2) + 0.05);
        let found = phases(&[one.clone(), two]);
        assert_eq!(found.coexistences.len(), 1);
        let tangent = &found.coexistences[0];
        assert_eq!(tangent.phases, ["one", "two"]);
        assert!((tangent.packing_fractions[0] - 0.17520493180230945).abs() < 1e-10);
        assert!((tangent.pressure + 0.1186064637442962).abs() < 1e-10);
        let wells = table("wells.txt", -2.0, 2.0, |x| {
            (x * x - 1.0).powi(2) + 0.3 * x + 2.0
        });
        let tangent = &phases(&[wells]).coexistences[0];
        assert!((tangent.packing_fractions[1] - 1.0).abs() < 1e-6);
        assert!((tangent.chemical_potential - 0.3).abs() < 1e-6);
        let none = phases(&[one]);
        assert!(!none.has_coexistence && none.text().contains("no coexistence"));
    }

    #[test]
    fn wrong_lines_are_named() {
        for text in ["1 2\n1 3\n", "1 2\nx\n", "1 2\n2 nan\n"] {
            let words = read_table("table", text).unwrap_err().to_string();
            assert!(words.starts_with("table:2: "), "{words}");
        }
        assert!(read_table("table", "1 2\n").is_err());
    }
}
