//! Selected residues copied by the operators of a biological assembly.

use super::BiologicalAssembly;
use super::selection::{SelectedResidue, SelectionReport, count, reason};
use crate::{BodyError, Result};
use protomer_kernel::Pose;
use std::collections::{BTreeSet, HashMap};
use std::sync::Arc;

/// Atoms an assembly may have: twice the largest in the archive.
const MOST_ATOMS: usize = 5_000_000;

/// Copies the residues by the operators of the assembly.
pub(crate) fn apply_assembly(
    residues: Vec<SelectedResidue>,
    assembly: &BiologicalAssembly,
    report: &mut SelectionReport,
) -> Result<Vec<SelectedResidue>> {
    let mut of_chain: HashMap<Arc<str>, Vec<usize>> = HashMap::new();
    for (index, residue) in residues.iter().enumerate() {
        if let Some(atom) = residue.atoms.first() {
            of_chain
                .entry(atom.label_chain.clone())
                .or_default()
                .push(index);
        }
    }
    let mut copies = Vec::new();
    let mut used = vec![false; residues.len()];
    // How often each residue has been copied: the number in the name of the copy's chain.
    let mut times: Vec<usize> = vec![0; residues.len()];
    let mut atoms = 0;
    for part in &assembly.parts {
        let members: Vec<usize> = {
            let chains: BTreeSet<&Arc<str>> = part.chains.iter().collect();
            let mut members: Vec<usize> = chains
                .iter()
                .filter_map(|chain| of_chain.get(*chain))
                .flatten()
                .copied()
                .collect();
            members.sort_unstable();
            members
        };
        for operator in &part.operators {
            let pose = operator.pose()?;
            for &index in &members {
                used[index] = true;
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
    let left_out = residues.iter().zip(&used).filter(|(_, used)| !**used);
    count(
        report,
        reason::ASSEMBLY,
        left_out.map(|(residue, _)| residue.atoms.len()).sum(),
    );
    Ok(copies)
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
