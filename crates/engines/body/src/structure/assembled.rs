//! Selected residues copied by the operators of a biological assembly.

use super::biological_assembly::{AssemblyPart, BiologicalAssembly};
use super::report::{SelectionReport, reason};
use super::selected::SelectedResidue;
use crate::{BodyError, Result};
use protomer_kernel::Pose;
use std::collections::{BTreeSet, HashMap};
use std::sync::Arc;

/// Limit on the atoms of an assembly: twice the largest in the archive.
const MOST_ATOMS: usize = 5_000_000;

/// Copies the residues by the operators of the assembly.
pub(crate) fn apply_assembly(
    residues: Vec<SelectedResidue>,
    assembly: &BiologicalAssembly,
    report: &mut SelectionReport,
) -> Result<Vec<SelectedResidue>> {
    let of_chain = by_label_chain(&residues);
    let mut copies = Vec::new();
    // How often each residue has been copied so far; the number names the chain of the copy.
    let mut times: Vec<usize> = vec![0; residues.len()];
    let mut atoms = 0;
    for part in &assembly.parts {
        let members = match part.chains.is_empty() {
            true => (0..residues.len()).collect(),
            false => members(part, &of_chain),
        };
        for operator in &part.operators {
            let pose = operator.pose()?;
            for &index in &members {
                times[index] += 1;
                atoms += residues[index].atoms.len();
                if atoms > MOST_ATOMS {
                    return Err(BodyError::Invalid {
                        cause: format!("assembly {} has more than {MOST_ATOMS} atoms", assembly.id),
                        remedy: "choose another assembly".into(),
                    });
                }
                copies.push(copied(&residues[index], &pose, times[index]));
            }
        }
    }
    for (residue, times) in residues.iter().zip(times) {
        if times == 0 {
            report.skip(reason::ASSEMBLY, residue.atoms.len());
        }
    }
    Ok(copies)
}

fn by_label_chain(residues: &[SelectedResidue]) -> HashMap<Arc<str>, Vec<usize>> {
    let mut of_chain: HashMap<Arc<str>, Vec<usize>> = HashMap::new();
    for (index, residue) in residues.iter().enumerate() {
        if let Some(atom) = residue.atoms.first() {
            let chain = atom.label_chain.clone();
            of_chain.entry(chain).or_default().push(index);
        }
    }
    of_chain
}

/// The residues that a part of an assembly copies, in file order, without repeats.
fn members(part: &AssemblyPart, of_chain: &HashMap<Arc<str>, Vec<usize>>) -> Vec<usize> {
    let chains: BTreeSet<&Arc<str>> = part.chains.iter().collect();
    let mut members = Vec::new();
    for chain in chains {
        members.extend(of_chain.get(chain).into_iter().flatten().copied());
    }
    members.sort_unstable();
    members
}

fn copied(residue: &SelectedResidue, pose: &Pose, copy: usize) -> SelectedResidue {
    let mut residue = residue.clone();
    if copy > 1 {
        residue.key.chain = Arc::from(format!("{}-{copy}", residue.key.chain));
    }
    for atom in &mut residue.atoms {
        atom.position = pose.transform_point(&atom.position);
        atom.chain = residue.key.chain.clone();
    }
    residue
}
