//! Potentials of pairs and fields from files, for hard bodies and for bodies in motion.
//!
//! ```text
//! [[term]]                       distance,energy_kt          height,energy_kt
//! kind = "square-well"           1.0,-1.5                    0,3
//! range = 1.5                    1.4,-0.7                    5,0
//! depth_kt = 1.0                 2.0,0
//! ```

use anyhow::{Context, Result, bail};
use protomer_common::input::InputFile;
use protomer_kernel::height_energy::{HeightCurve, HeightTable};
use protomer_kernel::pair_energy::Term;
use protomer_results::keys::read_toml;
use serde::Deserialize;
use std::path::Path;

/// Terms in a file.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Terms {
    term: Vec<Term>,
}

/// Reads the energy of pairs of bodies: terms in TOML, or a table with the columns `distance` and `energy_kt`.
///
/// # Errors
/// Names the file, the line and what it should hold.
///
/// ```
/// use protomer_kernel::pair_energy::Term;
/// use protomer_shape_verbs::potential_file::read_potential;
/// # let folder = tempfile::tempdir()?;
/// let path = folder.path().join("well.toml");
/// std::fs::write(&path, "[[term]]\nkind = \"square-well\"\nrange = 1.5\ndepth_kt = 1.0\n")?;
/// assert_eq!(read_potential(&path)?, [Term::SquareWell { range: 1.5, depth_kt: 1.0 }]);
/// # Ok::<(), anyhow::Error>(())
/// ```
pub fn read_potential(path: &Path) -> Result<Vec<Term>> {
    if path
        .extension()
        .is_some_and(|end| end.eq_ignore_ascii_case("toml"))
    {
        let terms = read_toml::<Terms>(path)?.term;
        if terms.is_empty() {
            bail!("{} has no [[term]]; give one or several", path.display());
        }
        return Ok(terms);
    }
    let (distances, energies_kt) = read_table(path, ["distance", "energy_kt"])?;
    Ok(vec![Term::Radial {
        distances,
        energies_kt,
        curve: None,
    }])
}

/// Reads the energy of pairs of bodies that move in a plane (dimension 2) or in space (3), which need a finite force.
///
/// # Errors
/// As [`read_potential`]; for a term without a finite force, and for sites of another dimension, names the file and the number of
/// the term.
///
/// ```
/// use protomer_shape_verbs::potential_file::read_smooth_potential;
/// # let folder = tempfile::tempdir()?;
/// let path = folder.path().join("well.toml");
/// std::fs::write(&path, "[[term]]\nkind = \"square-well\"\nrange = 1.5\ndepth_kt = 1.0\n")?;
/// let message = read_smooth_potential(&path, 3).map_err(|error| format!("{error:#}"));
/// assert!(message.unwrap_err().contains("well.toml: [[term]] 1: the energy of a square-well jumps"));
/// # Ok::<(), anyhow::Error>(())
/// ```
pub fn read_smooth_potential(path: &Path, dimension: usize) -> Result<Vec<Term>> {
    let terms = read_potential(path)?;
    for (number, term) in (1..).zip(&terms) {
        let checked = match dimension {
            2 => term.smooth_potential::<2>().map(drop),
            _ => term.smooth_potential::<3>().map(drop),
        };
        checked.with_context(|| format!("{}: [[term]] {number}", path.display()))?;
    }
    Ok(terms)
}

/// Reads the energy by the height of bodies that move.
///
/// # Errors
/// As [`read_field`]; names the file of a table that has no curve without jumps.
pub fn read_smooth_field(path: &Path) -> Result<HeightTable> {
    let table = read_field(path)?;
    HeightCurve::through(&table).with_context(|| path.display().to_string())?;
    Ok(table)
}

/// Reads the energy of each body by its height: a table with the columns `height` and `energy_kt`.
///
/// # Errors
/// Names the file, the line and what it should hold.
pub fn read_field(path: &Path) -> Result<HeightTable> {
    let (heights, energies_kt) = read_table(path, ["height", "energy_kt"])?;
    Ok(HeightTable {
        heights,
        energies_kt,
    })
}

/// The two columns of a table with headings.
fn read_table(path: &Path, columns: [&str; 2]) -> Result<(Vec<f64>, Vec<f64>)> {
    let file = InputFile::read(path)?;
    let text = String::from_utf8_lossy(&file.bytes);
    let mut lines = text.lines().enumerate();
    let [first, second] = columns;
    let heading = lines
        .next()
        .map(|(_, line)| line.trim().to_owned())
        .unwrap_or_default();
    if heading != format!("{first},{second}") {
        bail!(
            "{}:1: the heading is '{heading}'; write {first},{second} and rows of two numbers (or give terms in a .toml file)",
            path.display()
        );
    }
    let (mut places, mut energies) = (Vec::new(), Vec::new());
    for (number, line) in lines.filter(|(_, line)| !line.trim().is_empty()) {
        let numbers = line.split_once(',').and_then(|(place, energy)| {
            Some((place.trim().parse().ok()?, energy.trim().parse().ok()?))
        });
        let Some((place, energy)) = numbers else {
            bail!(
                "{}:{}: '{}' is not a {first} and an energy; write two numbers with a comma between them",
                path.display(),
                number + 1,
                line.trim()
            );
        };
        places.push(place);
        energies.push(energy);
    }
    Ok((places, energies))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_read_and_what_is_wrong_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let file = |name: &str, text: &str| {
            let path = folder.path().join(name);
            std::fs::write(&path, text).unwrap();
            path
        };
        let table = file("u.csv", "distance,energy_kt\n1,-1.5\n\n2, 0\n");
        let radial = Term::Radial {
            distances: vec![1.0, 2.0],
            energies_kt: vec![-1.5, 0.0],
            curve: None,
        };
        assert_eq!(read_potential(&table).unwrap(), [radial]);
        let field = file("f.csv", "height,energy_kt\n0,3\n1,0\n");
        assert_eq!(read_field(&field).unwrap().energies_kt, [3.0, 0.0]);
        for (path, words) in [
            (file("a.csv", "r,u\n1,2\n"), "a.csv:1: the heading is 'r,u'"),
            (file("b.csv", "distance,energy_kt\n1;2\n"), "b.csv:2: '1;2'"),
            (
                file(
                    "c.toml",
                    "[[term]]\nkind = \"square-well\"\nrange = 1.5\ndepth = 1\n",
                ),
                "unknown field `depth`",
            ),
            (
                file("d.toml", "[[term]]\nkind = \"morse\"\n"),
                "unknown variant `morse`",
            ),
            (file("e.toml", "term = []\n"), "has no [[term]]"),
        ] {
            let message = format!("{:#}", read_potential(&path).unwrap_err());
            assert!(message.contains(words), "{message}");
        }
    }
}
