//! The sites and residues of a body.

use super::amino_acid::AminoAcid;
use super::charges::{
    ChargeModel, atom_capacitances_e2, atom_charges_e, residue_charge_e, side_groups,
};
use super::protonation::{ResidueProtonation, StructureProtonation};
use super::radii::{core_radius_angstrom, radius_angstrom};
use super::residue_names::parent_amino_acid;
use crate::body::{Residue, Site};
use crate::structure::residues::residues_of_points;
use crate::structure::{SelectedResidue, Selection};
use crate::{BodyError, Result};
use protomer_kernel::{PointRecord, Vec3};
use serde::{Deserialize, Serialize};

/// Settings of the charges.
///
/// ```
/// use protomer_body::chemistry::{SiteSettings, build_sites};
/// use protomer_body::structure::{SelectionSettings, Structure};
/// # let text = "\
/// # ATOM      1  CB  ASP A   1      11.104   6.134  -6.504  1.00 10.00           C
/// # ATOM      2  CG  ASP A   1      11.639   6.071  -5.147  1.00 10.00           C";
/// let selection = Structure::read("d.pdb", text.as_bytes())?.select(&SelectionSettings::default())?;
/// let charge_at = |ph| build_sites(&selection, &SiteSettings { ph, ..SiteSettings::default() });
/// let [acidic, neutral] = [charge_at(2.0)?, charge_at(7.0)?].map(|sites| sites.net_charge_e());
/// assert!(acidic > neutral && neutral > -1.01);
/// # Ok::<(), protomer_body::BodyError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SiteSettings {
    /// pH of the protonation equilibria, 0 to 14.
    pub ph: f64,
    /// Distribution of the charge of a residue over its atoms.
    pub charges: ChargeModel,
    /// Conditions of a protonation computed from the structure; model pKa values in water for `None`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub structure: Option<StructureProtonation>,
    /// Whether a body keeps the titratable groups of its structure, for simulations that change their protons.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub titratable: bool,
}

impl Default for SiteSettings {
    fn default() -> Self {
        Self {
            ph: 7.4,
            charges: ChargeModel::ForceField,
            structure: None,
            titratable: false,
        }
    }
}

impl SiteSettings {
    fn check(&self) -> Result<()> {
        if self.titratable && (self.structure.is_none() || self.charges == ChargeModel::None) {
            return Err(BodyError::Invalid {
                cause: "titratable groups without the titration of the structure, or without charges"
                    .into(),
                remedy: "add --protonation structure and leave out --charges none, or leave out --titratable".into(),
            });
        }
        if (0.0..=14.0).contains(&self.ph) {
            return Ok(());
        }
        Err(BodyError::Invalid {
            cause: format!("a pH of {}", self.ph),
            remedy: "give a pH between 0 and 14".into(),
        })
    }
}

/// Sites and residues in the body's frame.
///
/// ```
/// use protomer_body::chemistry::{SiteSettings, build_sites};
/// use protomer_body::structure::{SelectionSettings, Structure};
/// let text = "\
/// ATOM      1  N   GLY A   7      10.000   0.000   0.000  1.00 10.00           N
/// ATOM      2  CA  GLY A   7      12.000   0.000   0.000  1.00 10.00           C";
/// let selection = Structure::read("gly.pdb", text.as_bytes())?.select(&SelectionSettings::default())?;
/// let sites = build_sites(&selection, &SiteSettings::default())?;
/// assert_eq!((sites.origin_angstrom.x, sites.sites[0].position.x), (11.0, -1.0));
/// # Ok::<(), protomer_body::BodyError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct ChargedSites {
    /// The frame's origin in the coordinates of the file, Å: the unweighted centroid of the atoms.
    pub origin_angstrom: Vec3,
    /// One site per atom, relative to the origin.
    pub sites: Vec<Site>,
    /// Radius of each site for a native core, Å ([`core_radius_angstrom`]); `None` for points, whose
    /// elements are not known.
    pub core_radii_angstrom: Option<Vec<f64>>,
    /// Residues in file order.
    pub residues: Vec<Residue>,
    /// Capacitance of each site, e² ([`ResidueProtonation::capacitance_e2`]); empty where the charges do
    /// not respond.
    pub capacitances_e2: Vec<f64>,
}

impl ChargedSites {
    /// Net charge, e.
    pub fn net_charge_e(&self) -> f64 {
        crate::body::net_charge_e(&self.sites)
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
/// [`BodyError::Invalid`] for a pH that is not between 0 and 14 and for a selection without atoms,
/// [`BodyError::Trace`] for a protein that has no atoms but Cα.
pub fn build_sites(selection: &Selection, settings: &SiteSettings) -> Result<ChargedSites> {
    settings.check()?;
    let in_water =
        |residue: &SelectedResidue| ResidueProtonation::in_water(side_groups(residue), settings.ph);
    let protonation: Vec<_> = selection.residues.iter().map(in_water).collect();
    build_protonated_sites(selection, &protonation, settings)
}

/// Variant of [`build_sites`] with the protonated fractions of each residue.
///
/// # Errors
/// As [`build_sites`].
pub fn build_protonated_sites(
    selection: &Selection,
    protonation: &[ResidueProtonation],
    settings: &SiteSettings,
) -> Result<ChargedSites> {
    settings.check()?;
    refuse_trace(&selection.residues)?;
    let mut positions = Vec::new();
    for residue in &selection.residues {
        positions.extend(residue.atoms.iter().map(|atom| atom.position));
    }
    let origin_angstrom = centroid(&positions)?;
    let mut sites = Vec::with_capacity(positions.len());
    let mut core_radii = Vec::with_capacity(positions.len());
    let mut residues = Vec::with_capacity(selection.residues.len());
    let mut capacitances_e2 = Vec::new();
    for (index, (residue, protonation)) in selection.residues.iter().zip(protonation).enumerate() {
        let charges = atom_charges_e(residue, protonation, settings.charges);
        for (atom, charge_e) in residue.atoms.iter().zip(charges) {
            core_radii.push(core_radius_angstrom(&atom.element));
            sites.push(Site {
                position: atom.position - origin_angstrom,
                charge_e,
                radius_angstrom: radius_angstrom(&atom.element),
                atom_name: atom.name.to_string(),
                residue: u32::try_from(index).ok(),
            });
        }
        residues.push(charged_residue(residue, protonation, settings.charges));
        capacitances_e2.extend(atom_capacitances_e2(residue, protonation));
    }
    if settings.structure.is_none() || settings.charges == ChargeModel::None {
        capacitances_e2.clear();
    }
    Ok(ChargedSites {
        origin_angstrom,
        sites,
        core_radii_angstrom: Some(core_radii),
        residues,
        capacitances_e2,
    })
}

fn charged_residue(
    residue: &SelectedResidue,
    protonation: &ResidueProtonation,
    charges: ChargeModel,
) -> Residue {
    Residue {
        chain: residue.key.chain.to_string(),
        number: residue.key.number,
        insertion_code: residue.key.insertion_code.to_string(),
        name: residue.name.to_string(),
        charge_e: match charges {
            ChargeModel::None => 0.0,
            _ => residue_charge_e(residue, protonation),
        },
        hydropathy: residue.class.amino_acid().map(AminoAcid::hydropathy),
    }
}

/// Refuses a Cα trace: charges and a surface need the side chains. A single Cα atom is accepted as
/// a fragment.
fn refuse_trace(selected: &[SelectedResidue]) -> Result<()> {
    let mut residues = 0;
    for residue in selected {
        if !residue.class.is_protein() {
            continue;
        }
        match residue.atoms.as_slice() {
            [atom] if &*atom.name == "CA" => residues += 1,
            _ => return Ok(()),
        }
    }
    if residues > 1 {
        return Err(BodyError::Trace { residues });
    }
    Ok(())
}

/// The sites of a PQR or XYZR file, with its own charges and radii.
///
/// ```
/// use protomer_body::chemistry::sites_of_points;
/// use protomer_kernel::{PointRecord, Vec3};
/// let point = |x, charge_e| PointRecord {
///     position: Vec3::new(x, 0.0, 0.0),
///     charge_e,
///     ..PointRecord::default()
/// };
/// let sites = sites_of_points(&[point(0.0, 1.0), point(4.0, -0.5)])?;
/// assert_eq!((sites.origin_angstrom.x, sites.net_charge_e()), (2.0, 0.5));
/// # Ok::<(), protomer_body::BodyError>(())
/// ```
///
/// # Errors
/// [`BodyError::Invalid`] without atoms.
pub fn sites_of_points(atoms: &[PointRecord]) -> Result<ChargedSites> {
    let positions: Vec<Vec3> = atoms.iter().map(|atom| atom.position).collect();
    let origin_angstrom = centroid(&positions)?;
    let groups = residues_of_points(atoms);
    let mut residue_of = vec![None; atoms.len()];
    let mut residues: Vec<Residue> = Vec::with_capacity(groups.len());
    for (index, group) in groups.iter().enumerate() {
        let mut residue = bare_residue(&atoms[group[0]]);
        for &atom in group {
            residue.charge_e += atoms[atom].charge_e;
            residue_of[atom] = u32::try_from(index).ok();
        }
        residues.push(residue);
    }
    let mut sites = Vec::with_capacity(atoms.len());
    for (atom, residue) in atoms.iter().zip(residue_of) {
        sites.push(Site {
            position: atom.position - origin_angstrom,
            charge_e: atom.charge_e,
            radius_angstrom: atom.radius_angstrom,
            atom_name: atom.atom_name.clone(),
            residue,
        });
    }
    Ok(ChargedSites {
        origin_angstrom,
        sites,
        core_radii_angstrom: None,
        residues,
        capacitances_e2: Vec::new(),
    })
}

/// The residue of a point, without charge yet.
fn bare_residue(atom: &PointRecord) -> Residue {
    let name = &atom.residue_name;
    let amino_acid = parent_amino_acid(name);
    Residue {
        chain: atom.chain.clone(),
        number: atom.residue_number,
        insertion_code: atom.insertion_code.clone(),
        name: name.clone(),
        charge_e: 0.0,
        hydropathy: amino_acid.map(AminoAcid::hydropathy),
    }
}

fn centroid(positions: &[Vec3]) -> Result<Vec3> {
    if positions.is_empty() {
        return Err(BodyError::Invalid {
            cause: "a body without atoms".into(),
            remedy: "select some".into(),
        });
    }
    let mut sum = Vec3::zeros();
    for position in positions {
        sum += position;
    }
    Ok(sum / positions.len() as f64)
}
