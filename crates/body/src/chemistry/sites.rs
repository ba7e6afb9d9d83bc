//! The sites and residues of a body.

use super::amino_acid::AminoAcid;
use super::charges::{ChargeModel, atom_charges_e, residue_charge_e};
use super::radii::radius_angstrom;
use super::residue_names::modified_residue;
use crate::body::{Residue, Site};
use crate::structure::Selection;
use crate::{BodyError, Result};
use protomer_io::points::PointRecord;
use protomer_kernel::Vec3;
use serde::{Deserialize, Serialize};
use std::collections::HashMap;

/// How sites are charged.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SiteSettings {
    /// pH of the protonation equilibria.
    pub ph: f64,
    /// Where the charges sit.
    pub charges: ChargeModel,
}

impl Default for SiteSettings {
    fn default() -> Self {
        Self {
            ph: 7.4,
            charges: ChargeModel::ForceField,
        }
    }
}

/// Sites and residues in the body's frame.
#[derive(Debug, Clone, PartialEq)]
pub struct ChargedSites {
    /// The frame's origin in the coordinates of the file, Å: the centroid of the atoms, each
    /// counted alike.
    pub origin_angstrom: Vec3,
    /// One site per atom, relative to the origin.
    pub sites: Vec<Site>,
    /// Residues in file order.
    pub residues: Vec<Residue>,
}

impl ChargedSites {
    /// Net charge, e.
    pub fn net_charge_e(&self) -> f64 {
        self.sites.iter().map(|site| site.charge_e).sum()
    }
}

/// Charges the selected atoms at a pH and moves them to the body's frame.
///
/// ```
/// use protomer_body::chemistry::{SiteSettings, build_sites};
/// use protomer_body::structure::{SelectionSettings, Structure};
/// let text = "ATOM      1  N   LYS A   1      11.104   6.134  -6.504  1.00 10.00           N\n\
///             ATOM      2  CA  LYS A   1      11.639   6.071  -5.147  1.00 10.00           C\n";
/// let structure = Structure::read("lysine.pdb", text.as_bytes())?;
/// let selection = structure.select(&SelectionSettings::default())?;
/// let sites = build_sites(&selection, &SiteSettings::default())?;
/// assert!((sites.net_charge_e() - 1.798).abs() < 0.001); // side chain and amine
/// # Ok::<(), protomer_body::BodyError>(())
/// ```
///
/// # Errors
/// [`BodyError::Invalid`] for a pH that is not a number between -10 and 30, and for a selection
/// without atoms.
pub fn build_sites(selection: &Selection, settings: &SiteSettings) -> Result<ChargedSites> {
    if !(-10.0..=30.0).contains(&settings.ph) {
        return Err(BodyError::Invalid {
            cause: format!("a pH of {}", settings.ph),
            remedy: "give a pH, usually between 0 and 14".into(),
        });
    }
    let atoms = || selection.residues.iter().flat_map(|residue| &residue.atoms);
    let origin = centroid(atoms().map(|atom| atom.position))?;
    let mut sites = Vec::with_capacity(atoms().count());
    let mut residues = Vec::with_capacity(selection.residues.len());
    for (index, residue) in selection.residues.iter().enumerate() {
        let charges = atom_charges_e(residue, settings.ph, settings.charges);
        for (atom, charge_e) in residue.atoms.iter().zip(charges) {
            sites.push(Site {
                position: atom.position - origin,
                charge_e,
                radius_angstrom: radius_angstrom(&atom.element),
                atom_name: atom.name.to_string(),
                residue: u32::try_from(index).ok(),
            });
        }
        residues.push(Residue {
            chain: residue.key.chain.to_string(),
            number: residue.key.number,
            insertion_code: residue.key.insertion_code.to_string(),
            name: residue.name.to_string(),
            charge_e: match settings.charges {
                ChargeModel::None => 0.0,
                _ => residue_charge_e(residue, settings.ph),
            },
            hydropathy: residue.class.amino_acid().map(AminoAcid::hydropathy),
        });
    }
    Ok(ChargedSites {
        origin_angstrom: origin,
        sites,
        residues,
    })
}

/// The sites of a PQR or XYZR file, with its own charges and radii.
///
/// # Errors
/// [`BodyError::Invalid`] without atoms.
pub fn sites_of_points(atoms: &[PointRecord]) -> Result<ChargedSites> {
    let origin = centroid(atoms.iter().map(|atom| atom.position))?;
    let mut residues: Vec<Residue> = Vec::new();
    let mut index_of = HashMap::new();
    let mut sites = Vec::with_capacity(atoms.len());
    for atom in atoms {
        let key = (
            &atom.chain,
            atom.residue_number,
            &atom.insertion_code,
            &atom.residue_name,
        );
        let residue = (!atom.residue_name.is_empty()).then(|| {
            *index_of.entry(key).or_insert_with(|| {
                residues.push(bare_residue(atom));
                residues.len() - 1
            })
        });
        if let Some(residue) = residue {
            residues[residue].charge_e += atom.charge_e;
        }
        sites.push(Site {
            position: atom.position - origin,
            charge_e: atom.charge_e,
            radius_angstrom: atom.radius_angstrom,
            atom_name: atom.atom_name.clone(),
            residue: residue.and_then(|index| u32::try_from(index).ok()),
        });
    }
    Ok(ChargedSites {
        origin_angstrom: origin,
        sites,
        residues,
    })
}

fn bare_residue(atom: &PointRecord) -> Residue {
    let name = atom.residue_name.as_str();
    let amino_acid = AminoAcid::of_residue(name);
    let parent = amino_acid.or_else(|| modified_residue(name)?.parent);
    Residue {
        chain: atom.chain.clone(),
        number: atom.residue_number,
        insertion_code: atom.insertion_code.clone(),
        name: atom.residue_name.clone(),
        charge_e: 0.0,
        hydropathy: parent.map(AminoAcid::hydropathy),
    }
}

fn centroid(positions: impl Iterator<Item = Vec3>) -> Result<Vec3> {
    let (sum, count) = positions.fold((Vec3::zeros(), 0_usize), |(sum, count), position| {
        (sum + position, count + 1)
    });
    if count == 0 {
        return Err(BodyError::Invalid {
            cause: "a body without atoms".into(),
            remedy: "select some".into(),
        });
    }
    Ok(sum / count as f64)
}
