//! Residues as beads.

use crate::Body;
use crate::chemistry::AminoAcid;
use crate::chemistry::residue_names::parent_amino_acid;
use protomer_kernel::Vec3;

/// A residue as one point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bead {
    /// Centre of the heavy atoms, in the frame of the body, Å.
    pub position: Vec3,
    /// Amino acid of the residue; a modified residue counts as its parent.
    pub amino_acid: AminoAcid,
    /// Index into [`Body::residues`].
    pub residue: usize,
}

/// The amino acids of a body as beads, in the order of its residues. Nucleotides, ligands and ions
/// have none: no scale knows them.
pub fn beads_of(body: &Body) -> Vec<Bead> {
    let mut sums = vec![(Vec3::zeros(), 0_u32); body.residues.len()];
    for site in &body.sites {
        let sum = site
            .residue
            .and_then(|residue| sums.get_mut(residue as usize));
        if let (Some((sum, count)), false) = (sum, site.is_hydrogen()) {
            *sum += site.position;
            *count += 1;
        }
    }
    let mut beads = Vec::new();
    for (residue, (sum, count)) in sums.into_iter().enumerate() {
        let amino_acid = parent_amino_acid(&body.residues[residue].name);
        if let (Some(amino_acid), true) = (amino_acid, count > 0) {
            beads.push(Bead {
                position: sum / f64::from(count),
                amino_acid,
                residue,
            });
        }
    }
    beads
}
