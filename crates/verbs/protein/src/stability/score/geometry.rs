//! Columns of the structure alone.

use super::Measure;
use super::complex::Pose;
use super::record::{count, number};
use crate::stability::binding::input::Partners;
use crate::stability::binding::interface::Interface;
use anyhow::Result;
use protomer_body::Body;
use protomer_body::chemistry::AminoAcid;
use protomer_body::chemistry::residue_names::parent_amino_acid;
use protomer_body::interface::{
    Partner, buried_area_angstrom2, polar_contacts, shape_complementarity,
};
use serde_json::Value;

/// Radius of a water molecule, Å.
pub(super) const PROBE_ANGSTROM: f64 = 1.4;
/// A body with a larger share of glycine is the backbone of a design without its sequence.
const MOST_GLYCINE: f64 = 0.8;

/// The columns of a group.
///
/// # Errors
/// If a surface cannot be made.
pub(super) fn columns(measure: Measure, pose: &Pose) -> Result<Vec<(String, Value)>> {
    let (partners, interface) = (&pose.partners, &pose.interface);
    let placed = partners
        .bodies
        .each_ref()
        .map(|body| Partner::in_file(body));
    Ok(match measure {
        Measure::Quality => quality(pose),
        Measure::Charge => charges(partners),
        Measure::Contacts => {
            let polar = polar_contacts(placed);
            vec![
                count("residue_contacts", interface.contacts()),
                count("hydrogen_bonds", polar.hydrogen_bonds),
                count("salt_bridges", polar.salt_bridges),
            ]
        }
        Measure::Area => {
            let area = buried_area_angstrom2(placed, PROBE_ANGSTROM)?;
            vec![number("buried_area_angstrom2", area)]
        }
        Measure::Shape => {
            let fit = shape_complementarity(placed, PROBE_ANGSTROM)?;
            vec![number("shape_complementarity", fit.unwrap_or(f64::NAN))]
        }
        Measure::Affinity => affinity(partners, interface),
        Measure::Real
        | Measure::B22
        | Measure::Confidence
        | Measure::Energy
        | Measure::Slope
        | Measure::Kd
        | Measure::HalfSalt
        | Measure::Exchange => Vec::new(),
    })
}

fn quality(pose: &Pose) -> Vec<(String, Value)> {
    let found = pose.inputs.quality();
    vec![
        count("incomplete_residues", found.incomplete_residues),
        count("chain_breaks", found.chain_breaks),
        count(
            "residues_of_low_confidence",
            found.residues_of_low_confidence,
        ),
        count("clashing_atoms", pose.interface.clashing_atoms),
        number("closest_angstrom", pose.interface.closest_angstrom),
    ]
}

fn charges(partners: &Partners) -> Vec<(String, Value)> {
    let [receptor, ligand] = partners.bodies.each_ref().map(|body| body.net_charge_e());
    vec![
        number("receptor_charge_e", receptor),
        number("ligand_charge_e", ligand),
    ]
}

fn affinity(partners: &Partners, interface: &Interface) -> Vec<(String, Value)> {
    let contacts = interface.affinity(partners);
    vec![number(
        "contact_delta_g_kcal_per_mol",
        contacts.delta_g_kcal_per_mol(),
    )]
}

/// Warnings about bodies that are a backbone without a sequence, as generators of backbones write them.
pub(super) fn backbone_warnings(partners: &Partners) -> Vec<String> {
    let bare = partners.bodies.iter().filter(|body| is_backbone(body));
    bare.map(|body| {
        format!(
            "{} is a backbone without side chains: its charges and contacts mean nothing; design its sequence first",
            body.name
        )
    })
    .collect()
}

fn is_backbone(body: &Body) -> bool {
    let is_glycine = |name: &str| parent_amino_acid(name) == Some(AminoAcid::Gly);
    let glycines = body
        .residues
        .iter()
        .filter(|residue| is_glycine(&residue.name));
    let without_side_chains = !body.sites.iter().any(|site| site.atom_name == "CB");
    let share = glycines.count() as f64 / body.residues.len().max(1) as f64;
    !body.residues.is_empty() && (share > MOST_GLYCINE || without_side_chains)
}
