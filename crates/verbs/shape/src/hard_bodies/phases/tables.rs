//! Phases whose free energies are in files.

use super::{Coexistence, Phases};
use anyhow::{Context, Result, bail};
use protomer_common::input::InputFile;
use protomer_hpmc::tangent::{self, Branch, even_samples};
use protomer_kernel::jet::Jet;
use protomer_kernel::spline::{Ends, Spline};
use std::path::PathBuf;

/// Samples of a table's spline.
const SAMPLES: usize = 20_000;
/// Smallest number of points for a spline that is worth a tangent.
const FEWEST_POINTS: usize = 5;

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
    let curve = |spline: &Spline, x: Jet| {
        let [value, slope, curvature] = spline.evaluate(x.value);
        x.chain(value, slope, curvature)
    };
    let energies: Vec<_> = splines
        .iter()
        .map(|spline| move |x| curve(spline, x))
        .collect();
    let mut branches: Vec<Branch<'_>> = Vec::new();
    for (number, spline) in splines.iter().enumerate() {
        let [first, last] = spline.range();
        branches.push(Branch {
            name: &names[number],
            free_energy: &energies[number],
            samples: even_samples(first, last, SAMPLES),
        });
    }
    let coexistences = tangent::coexistences(&branches);
    let named = |coexistence: &tangent::Coexistence| Coexistence {
        size_ratio: None,
        reservoir_packing_fraction: None,
        phases: coexistence.branches.map(|branch| names[branch].clone()),
        packing_fractions: coexistence.densities,
        uncertainty: None,
        pressure: coexistence.pressure,
        osmotic_pressure: None,
        chemical_potential: coexistence.chemical_potential,
        free_volume_fractions: None,
    };
    Ok(Phases {
        has_coexistence: !coexistences.is_empty(),
        coexistences: coexistences.iter().map(named).collect(),
        ..Phases::none()
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
                // Ascending densities, as the spline needs them; NaN ascends from nothing.
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
    Spline::through(&x, &y, Ends::Cubic).with_context(|| name.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;
    use protomer_common::answer::Answer;

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
