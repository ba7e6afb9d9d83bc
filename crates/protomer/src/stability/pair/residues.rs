//! Which residues hold a bound pose together.

use super::result::PoseResult;
use anyhow::Result;
use protomer_body::residue_contacts::{Bead, beads_of};
use protomer_body::{Body, Residue};
use protomer_io::csv::{Cell, Table};
use protomer_kernel::pose::RelativePose;
use protomer_kernel::{Pose, Vec3};
use protomer_mc::energy::terms::{EnergyParts, Term};
use protomer_mc::pair::BodyPair;

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
    let relative = RelativePose::new(&Pose::identity(), &of_second, &of_second.position);
    let beads = bodies.map(beads_of);
    let mut energies = bodies.map(|body| vec![EnergyParts::default(); body.residues.len()]);
    for term in &pair.potential.0 {
        term.shares(&relative, &mut |body, place, energy_kt| {
            let residue = match term.term() {
                Term::Contacts => nearest_bead(&beads[body], place),
                Term::Charges | Term::Desolvation => nearest_residue(bodies[body], place),
            };
            if let Some(residue) = residue {
                let parts = &mut energies[body][residue];
                match term.term() {
                    Term::Charges => parts.charges_kt += energy_kt,
                    Term::Contacts => parts.contacts_kt += energy_kt,
                    Term::Desolvation => parts.desolvation_kt += energy_kt,
                }
            }
        });
    }
    Some(energies)
}

/// The residue of the bead at a place.
fn nearest_bead(beads: &[Bead], place: &Vec3) -> Option<usize> {
    let square = |bead: &&Bead| (bead.position - place).norm_squared();
    let nearest = beads.iter().min_by(|a, b| square(a).total_cmp(&square(b)));
    nearest.map(|bead| bead.residue)
}

/// The residue of the atom nearest to a place in the body's frame (Å).
fn nearest_residue(body: &Body, place: &Vec3) -> Option<usize> {
    let mut nearest = (f64::INFINITY, None);
    for site in &body.sites {
        let square = (site.position - place).norm_squared();
        if site.residue.is_some() && square < nearest.0 {
            nearest = (square, site.residue);
        }
    }
    nearest.1.map(|residue| residue as usize)
}

/// A table of residues over all poses; residues with less than 0.01 kT are left out.
pub(super) fn to_csv(bodies: [&Body; 2], poses: &[ResidueEnergies]) -> Result<String> {
    const LEAST_KT: f64 = 0.01;
    let mut table = Table::new([
        "pose",
        "body",
        "chain",
        "number",
        "insertion_code",
        "residue",
        "energy_kt",
        "charges_kt",
        "contacts_kt",
        "desolvation_kt",
    ]);
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

fn row(pose: usize, body: usize, residue: &Residue, parts: &EnergyParts) -> Vec<Cell> {
    vec![
        Cell::Number(pose as f64),
        Cell::Number(body as f64),
        Cell::Text(residue.chain.clone()),
        Cell::Number(f64::from(residue.number)),
        Cell::Text(residue.insertion_code.clone()),
        Cell::Text(residue.name.clone()),
        Cell::Number(parts.total_kt()),
        Cell::Number(parts.charges_kt),
        Cell::Number(parts.contacts_kt),
        Cell::Number(parts.desolvation_kt),
    ]
}
