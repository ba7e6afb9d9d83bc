//! Which residues hold a bound pose together.

use super::result::PoseResult;
use anyhow::{Context, Result, bail};
use protomer_body::{Body, Residue};
use protomer_io::csv::{Cell, Table, cells};
use protomer_io::written::csv_cell;
use protomer_kernel::pose::RelativePose;
use protomer_kernel::{Pose, Vec3};
use protomer_mc::contributions::ResiduePlaces;
use protomer_mc::energy::terms::{EnergyParts, Term};
use protomer_mc::pair::BodyPair;
use std::path::Path;

/// The file with the energies of residues at the bound poses of one condition.
pub(super) const RESIDUES: &str = "residues.csv";
/// Columns of a residue and its energy.
const COLUMNS: [&str; 7] = [
    "pose",
    "body",
    "chain",
    "number",
    "insertion_code",
    "residue",
    "energy_kt",
];

/// Columns of that file: a residue, its energy, and the terms of it. Tables of earlier versions lack the last
/// terms.
fn columns() -> Vec<&'static str> {
    let mut columns = COLUMNS.to_vec();
    columns.extend(Term::ALL.map(Term::key));
    columns
}

/// The energies of the residues of both bodies at one pose, in the order of the residues.
///
/// The energy of a pair of residues counts in full with both, so that the residues of each body add
/// up to the energy of the pose; solvent counts with the residue that displaces it. Charges and
/// displaced volumes belong to the residue of the nearest atom.
pub(super) type ResidueEnergies = [Vec<EnergyParts>; 2];

/// The energies of residues at a pose; `None` for bodies without residues.
pub(super) fn residue_energies(
    bodies: [&Body; 2],
    pair: &BodyPair,
    pose: &PoseResult,
) -> Option<ResidueEnergies> {
    if bodies.iter().any(|body| body.residues.is_empty()) {
        return None;
    }
    let of_second = Pose::from_wxyz(Vec3::from(pose.position_angstrom), pose.orientation_wxyz);
    let relative = RelativePose::from(&of_second);
    let places = bodies.map(ResiduePlaces::from_body);
    let mut energies = bodies.map(|body| vec![EnergyParts::default(); body.residues.len()]);
    for term in &pair.potential.0 {
        term.shares(&relative, &mut |body, place, energy_kt| {
            if let Some(residue) = places[body].of_term(term.term(), place) {
                energies[body][residue].add(term.term(), energy_kt);
            }
        });
    }
    Some(energies)
}

/// A table of residues over all poses; residues with less than 0.01 kT are left out.
pub(super) fn to_csv(bodies: [&Body; 2], poses: &[ResidueEnergies]) -> Result<String> {
    const LEAST_KT: f64 = 0.01;
    let mut table = Table::new(columns());
    for (number, energies) in poses.iter().enumerate() {
        for (body, of_body) in energies.iter().enumerate() {
            for (residue, parts) in bodies[body].residues.iter().zip(of_body) {
                if parts.total_kt().abs() >= LEAST_KT {
                    table.push(row(number + 1, body + 1, residue, parts))?;
                }
            }
        }
    }
    Ok(table.to_csv()?)
}

/// The table of the residues of a condition, as its file has it.
#[derive(Debug, Clone, PartialEq)]
pub struct ResidueTable {
    /// Path that it was read from.
    pub path: String,
    /// The text of the file.
    pub csv: String,
}

impl ResidueTable {
    /// Reads the table of a condition's folder.
    ///
    /// # Errors
    /// If the file cannot be read.
    pub fn read(folder: &Path) -> Result<Self> {
        let path = folder.join(RESIDUES).display().to_string();
        let csv = protomer_io::input::read_to_string(&path)
            .with_context(|| format!("cannot read {path}"))?;
        Ok(Self { path, csv })
    }

    /// The energies (kT) of the residues of both bodies at one pose, counted from 1; zero for those
    /// that the table leaves out.
    ///
    /// # Errors
    /// If the table is damaged, or names a residue that the bodies do not have.
    pub fn energies_kt(&self, bodies: [&Body; 2], pose: usize) -> Result<[Vec<f64>; 2]> {
        let mut energies = bodies.map(|body| vec![0.0; body.residues.len()]);
        let columns = columns();
        // The rows are in the order of the residues, so that two of one name stay apart.
        let mut next = [0, 0];
        for (index, line) in self.csv.lines().enumerate() {
            let number = index + 1;
            let row = cells(&self.path, number, line)?;
            let line_name = || format!("{}:{number}", self.path);
            if number == 1 {
                let is_shorter = row.len() > COLUMNS.len() && row.len() <= columns.len();
                if !is_shorter || row != columns[..row.len()] {
                    bail!(
                        "{} has other columns than residues of a pair have",
                        line_name()
                    );
                }
                continue;
            }
            let &[
                of_pose,
                of_body,
                chain,
                in_chain,
                insertion_code,
                name,
                energy_kt,
                ..,
            ] = &*row.iter().map(String::as_str).collect::<Vec<&str>>()
            else {
                bail!(
                    "{} has {} cells under {} columns",
                    line_name(),
                    row.len(),
                    columns.len()
                );
            };
            if of_pose.parse() != Ok(pose) {
                continue;
            }
            let body = match of_body {
                "1" => 0,
                "2" => 1,
                _ => bail!("{} names body {of_body:?}; there are 1 and 2", line_name()),
            };
            // As a table has them.
            let is_named = |residue: &Residue| {
                csv_cell(residue.chain.trim()) == chain
                    && in_chain.parse() == Ok(residue.number)
                    && csv_cell(residue.insertion_code.trim()) == insertion_code
                    && csv_cell(&residue.name) == name
            };
            let mut left = bodies[body].residues.iter().skip(next[body]);
            let Some(further) = left.position(is_named) else {
                bail!(
                    "{} names the residue {name} {in_chain} of chain {chain:?}, which body {} does \
                     not have there",
                    line_name(),
                    of_body
                );
            };
            let residue = next[body] + further;
            next[body] = residue + 1;
            let energy: f64 = energy_kt.parse().with_context(line_name)?;
            energies[body][residue] = energy;
        }
        Ok(energies)
    }
}

fn row(pose: usize, body: usize, residue: &Residue, parts: &EnergyParts) -> Vec<Cell> {
    let mut cells = vec![
        Cell::Number(pose as f64),
        Cell::Number(body as f64),
        Cell::Text(residue.chain.clone()),
        Cell::Number(f64::from(residue.number)),
        Cell::Text(residue.insertion_code.clone()),
        Cell::Text(residue.name.clone()),
        Cell::Number(parts.total_kt()),
    ];
    cells.extend(parts.values().map(Cell::Number));
    cells
}

#[cfg(test)]
mod tests {
    use super::*;
    use protomer_body::{BodySettings, Source, build_body};

    const ATOM: &str = "\
ATOM      1  CA  LYS X   1      11.639   6.071  -5.147  1.00 10.00           C";

    /// A body of these residues (chain, number, name), an atom each, 10 Å apart along x.
    fn body(residues: &[(&str, i32, &str)]) -> Body {
        let source = Source {
            file: "atom.pdb",
            sha256: "",
        };
        let built = build_body("atom", source, ATOM.as_bytes(), &BodySettings::default());
        let mut body = built.unwrap().body;
        let (residue, site) = (body.residues[0].clone(), body.sites[0].clone());
        (body.residues, body.sites) = (Vec::new(), Vec::new());
        for (number, (chain, in_chain, name)) in residues.iter().enumerate() {
            body.residues.push(Residue {
                chain: (*chain).into(),
                number: *in_chain,
                name: (*name).into(),
                ..residue.clone()
            });
            let mut site = site.clone();
            site.position = Vec3::new(10.0 * number as f64, 0.0, 0.0);
            site.residue = Some(number as u32);
            body.sites.push(site);
        }
        body
    }

    fn parts(energies_kt: &[f64]) -> Vec<EnergyParts> {
        let part = |energy_kt: &f64| EnergyParts {
            charges_kt: 2.0 * energy_kt,
            contacts_kt: -energy_kt,
            ..EnergyParts::default()
        };
        energies_kt.iter().map(part).collect()
    }

    fn table(csv: String) -> ResidueTable {
        ResidueTable {
            path: "residues.csv".into(),
            csv,
        }
    }

    #[test]
    fn a_table_reads_back_pose_by_pose_also_with_names_that_repeat() {
        let first = body(&[("A", 1, "LYS"), ("A, B", 2, "GLU"), ("A", 1, "LYS")]);
        let second = body(&[("", -4, "ASP"), ("", -3, "ASP")]);
        let poses = [
            [parts(&[-1.5, 0.0, 0.25]), parts(&[-0.5, 0.0])],
            [parts(&[1e-3, 3.0, 0.1]), parts(&[0.0, 0.125])],
        ];
        let table = table(to_csv([&first, &second], &poses).unwrap());
        let read = |pose: usize| table.energies_kt([&first, &second], pose).unwrap();
        assert_eq!(read(1), [vec![-1.5, 0.0, 0.25], vec![-0.5, 0.0]]);
        // What is less than 0.01 kT is not in the table.
        assert_eq!(read(2), [vec![0.0, 3.0, 0.1], vec![0.0, 0.125]]);
        assert_eq!(read(3), [vec![0.0; 3], vec![0.0; 2]]);
        let head = columns()[..COLUMNS.len() + 3].join(",");
        let earlier = ResidueTable {
            csv: format!("{head}\n1,1,A,1,,LYS,-1.5,-3,1.5,0\n"),
            ..table
        };
        let found = earlier.energies_kt([&first, &second], 1).unwrap();
        assert_eq!(found[0], [-1.5, 0.0, 0.0]);
    }

    #[test]
    fn a_table_of_other_bodies_or_a_damaged_one_is_refused() {
        let types = body(&[("A", 1, "LYS"), ("A", 2, "GLU")]);
        let refused = |csv: String| {
            let error = table(csv).energies_kt([&types, &types], 1).unwrap_err();
            format!("{error:#}")
        };
        let head = columns().join(",");
        let other = refused(format!("{head}\n1,2,A,3,,GLU,1,1,0,0\n"));
        assert!(
            other.contains("residues.csv:2 names the residue GLU 3"),
            "{other}"
        );
        assert!(other.contains("which body 2 does not have"), "{other}");
        // Out of order: the same residue twice.
        let row = "1,1,A,2,,GLU,1,1,0,0\n";
        assert!(refused(format!("{head}\n{row}{row}")).contains("residues.csv:3"));
        assert!(refused(format!("{head}\n1,1,A\n")).contains("3 cells under 11"));
        assert!(refused(format!("{head}\n1,7,A,1,,LYS,1,1,0,0\n")).contains("body \"7\""));
        assert!(refused(format!("{head}\n1,1,A,1,,LYS,x,1,0,0\n")).contains("residues.csv:2"));
        assert!(refused("a,b\n".into()).contains("other columns"));
    }
}
