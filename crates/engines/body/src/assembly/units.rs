//! Parts of a structure that become one body each: a chain, several chains joined, or a whole file.

use crate::structure::{SelectedResidue, Selection, SelectionReport};
use std::collections::HashMap;
use std::sync::Arc;

/// The residues that become one body.
#[derive(Debug, Clone, PartialEq)]
pub struct Unit {
    /// Name: the chains joined by commas, or another one.
    pub name: String,
    /// Chains of the unit. A copy has the chains that correspond to those of the original in the
    /// same order.
    pub chains: Vec<Arc<str>>,
    /// Residues in the order of the structure.
    pub residues: Vec<SelectedResidue>,
}

impl Unit {
    /// Number of atoms.
    pub fn atoms(&self) -> usize {
        crate::structure::atom_count(&self.residues)
    }

    /// The unit as a selection, with the report of the whole structure.
    pub fn to_selection(&self, report: &SelectionReport) -> Selection {
        let mut report = report.clone();
        report.atoms = self.atoms();
        Selection {
            residues: self.residues.clone(),
            report,
        }
    }

    /// Some chains of a selection as one unit, in the order in which they are named.
    ///
    /// ```
    /// use protomer_body::assembly::Unit;
    /// use protomer_body::structure::{SelectionSettings, Structure};
    /// let text = "\
    /// ATOM      1  CA  GLY A   7       0.000   0.000   0.000  1.00 10.00           C
    /// ATOM      2  CA  GLY B   7       4.000   0.000   0.000  1.00 10.00           C
    /// ATOM      3  CA  GLY C   7      20.000   0.000   0.000  1.00 10.00           C";
    /// let selection = Structure::read("three.pdb", text.as_bytes())?.select(&SelectionSettings::default())?;
    /// let unit = Unit::of_chains(&selection, &["C".to_owned(), "A".to_owned()]);
    /// assert_eq!((unit.name.as_str(), unit.atoms()), ("C,A", 2));
    /// # Ok::<(), protomer_body::BodyError>(())
    /// ```
    pub fn of_chains(selection: &Selection, chains: &[String]) -> Self {
        let mut residues = Vec::new();
        for chain in chains {
            residues.extend(selection.only_chain(chain).residues);
        }
        Self {
            name: chains.join(","),
            chains: chains
                .iter()
                .map(|chain| Arc::from(chain.as_str()))
                .collect(),
            residues,
        }
    }

    /// The whole selection as one unit.
    pub fn of_selection(name: &str, selection: &Selection) -> Self {
        let mut chains: Vec<Arc<str>> = Vec::new();
        for residue in &selection.residues {
            if chains.last() != Some(&residue.key.chain) && !chains.contains(&residue.key.chain) {
                chains.push(residue.key.chain.clone());
            }
        }
        Self {
            name: name.to_owned(),
            chains,
            residues: selection.residues.clone(),
        }
    }
}

/// One unit per chain, in the order of the structure.
///
/// ```
/// use protomer_body::assembly::units_of_chains;
/// use protomer_body::structure::{SelectionSettings, Structure};
/// let text = "\
/// ATOM      1  CA  GLY A   7       0.000   0.000   0.000  1.00 10.00           C
/// ATOM      2  CA  GLY B   7       4.000   0.000   0.000  1.00 10.00           C";
/// let selection = Structure::read("two.pdb", text.as_bytes())?.select(&SelectionSettings::default())?;
/// let names: Vec<String> = units_of_chains(&selection).into_iter().map(|unit| unit.name).collect();
/// assert_eq!(names, ["A", "B"]);
/// # Ok::<(), protomer_body::BodyError>(())
/// ```
pub fn units_of_chains(selection: &Selection) -> Vec<Unit> {
    let mut index_of: HashMap<&str, usize> = HashMap::new();
    let mut units: Vec<Unit> = Vec::new();
    for residue in &selection.residues {
        let chain = &residue.key.chain;
        let index = *index_of.entry(chain).or_insert_with(|| {
            units.push(Unit {
                name: chain.to_string(),
                chains: vec![chain.clone()],
                residues: Vec::new(),
            });
            units.len() - 1
        });
        units[index].residues.push(residue.clone());
    }
    units
}
