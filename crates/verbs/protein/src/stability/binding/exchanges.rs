//! What single exchanges of charge at the interface would change.
//!
//! Each residue that can carry a charge is exchanged as in the mutation scan of `residues`: a charged side
//! chain for an uncharged one or one of the opposite charge, a titratable one for a lysine or a glutamate.
//! The change of charge sits on the outermost atoms of the side chain, and the shape stays as it is.

use super::input::{Partners, in_frame};
use super::interface::Interface;
use super::result::ExchangeRow;
use crate::stability::residues::{Change, ResidueName, exchanges_of};
use protomer_body::Body;
use protomer_body::chemistry::AminoAcid;
use protomer_body::chemistry::protonation::side_chain_groups;
use protomer_field::ChargedSphere;
use protomer_field::binding::{AddedCharges, BindingEnergy};
use protomer_mc::contributions::charge_sites;

/// Radius of the atoms that carry an added charge, Å. Only the potential on the faces of the grid
/// depends on it, and hardly.
const RADIUS_ANGSTROM: f64 = 1.5;

/// A residue at the interface whose charge can be exchanged.
pub(super) struct InterfaceCharge {
    part: usize,
    name: ResidueName,
    changes: Vec<(Change, AminoAcid, f64)>,
    one_charge: Vec<ChargedSphere>,
}

/// The residues at the interface that carry a charge or can.
pub(super) fn at_interface(partners: &Partners, interface: &Interface) -> Vec<InterfaceCharge> {
    let mut charges = Vec::new();
    for (part, body) in partners.bodies.iter().enumerate() {
        for index in &interface.near[part] {
            let residue = *index as usize;
            let one_charge = one_charge(body, residue);
            let changes = exchanges_of(body, residue);
            if is_titratable(body, residue) && !one_charge.is_empty() && !changes.is_empty() {
                charges.push(InterfaceCharge {
                    part,
                    name: ResidueName::from_body(body, residue),
                    changes,
                    one_charge,
                });
            }
        }
    }
    charges
}

fn is_titratable(body: &Body, residue: usize) -> bool {
    let amino_acid = AminoAcid::of_residue(&body.residues[residue].name);
    amino_acid.is_some_and(|amino_acid| !side_chain_groups(amino_acid).is_empty())
}

/// An elementary charge on the outermost atoms of a side chain.
fn one_charge(body: &Body, residue: usize) -> Vec<ChargedSphere> {
    let places = charge_sites(body, residue);
    let charge_e = 1.0 / places.len().max(1) as f64;
    let charge = |place| ChargedSphere {
        centre: in_frame(body, place),
        radius_angstrom: RADIUS_ANGSTROM,
        charge_e,
    };
    places.iter().map(charge).collect()
}

impl InterfaceCharge {
    /// An elementary charge at this residue.
    pub fn one_charge(&self) -> AddedCharges {
        AddedCharges {
            part: self.part,
            charges: self.one_charge.clone(),
        }
    }
}

/// The rows of a table, the exchange that strengthens the complex most first.
pub(super) fn rows(
    ph: Option<f64>,
    charges: &[InterfaceCharge],
    energy: &BindingEnergy,
) -> Vec<ExchangeRow> {
    let mut rows = Vec::new();
    for (charge, response) in charges.iter().zip(&energy.added) {
        for (change, to, charge_change_e) in &charge.changes {
            rows.push(ExchangeRow {
                ph,
                name: charge.name.clone(),
                mutation: format!("{}{}", charge.name.short(), to.letter()),
                change: *change,
                charge_change_e: *charge_change_e,
                energy_change_kt: response.change_kt(*charge_change_e),
                first_order_kt: charge_change_e * response.first_order_kt,
                second_order_kt: charge_change_e.powi(2) * response.second_order_kt,
            });
        }
    }
    rows.sort_by(|a, b| a.energy_change_kt.total_cmp(&b.energy_change_kt));
    rows
}
