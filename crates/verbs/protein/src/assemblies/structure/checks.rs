//! What a user should know of the bodies of a structure before they are simulated: chains that belong
//! together, bodies that touch nothing, and gaps in interfaces.

use super::files::{File, NamedUnit};
use anyhow::{Result, bail};
use protomer_body::assembly::{ResidueContacts, Unit, joined_groups, joined_units};
use protomer_kernel::Vec3;
use std::collections::BTreeSet;

/// Atoms of two bodies this near each other are in one place, Å: less than a covalent bond.
const ONE_PLACE_ANGSTROM: f64 = 1.2;
/// The share of the atoms of a body in the place of others from which on the bodies are not in one frame.
const SHARE_IN_ONE_PLACE: f64 = 0.05;
/// Residues without all their atoms this near another body matter to its contacts, Å.
const INTERFACE_ANGSTROM: f64 = 8.0;
/// Longest list of residues in a warning.
const MOST_LISTED: usize = 8;

/// Refuses bodies that fill the same space, as those of files in different frames may.
///
/// # Errors
/// Names the two bodies.
pub(super) fn require_one_frame(units: &[Unit]) -> Result<()> {
    let atoms: Vec<Vec<Vec3>> = units.iter().map(positions).collect();
    for second in 0..units.len() {
        for first in 0..second {
            let [few, many] = match atoms[first].len() < atoms[second].len() {
                true => [&atoms[first], &atoms[second]],
                false => [&atoms[second], &atoms[first]],
            };
            let shared = count_within(few, many, ONE_PLACE_ANGSTROM);
            if shared > 1 && shared as f64 > SHARE_IN_ONE_PLACE * few.len() as f64 {
                bail!(
                    "{shared} atoms of {} and {} lie in the same places; if these are files in different \
                     frames, superpose them on the complex first, and if the file holds copies, choose \
                     one with --chain or --model",
                    units[first].name,
                    units[second].name
                );
            }
        }
    }
    Ok(())
}

/// Proposals to join bodies, each with the flag that accepts it.
pub(super) fn joined(units: &[Unit], is_of_one_file: bool) -> Vec<String> {
    let joined = joined_units(units);
    let mut proposals = Vec::new();
    for group in joined_groups(units.len(), &joined) {
        let mut reasons = Vec::new();
        for pair in joined.iter().filter(|pair| group.contains(&pair.units.0)) {
            reasons.push(pair.by.to_string());
        }
        let names: Vec<&str> = group.iter().map(|unit| &*units[*unit].name).collect();
        let remedy = match is_of_one_file {
            true => format!("--body {} makes them one body", names.join(",")),
            false => "put them into one file to make them one body".into(),
        };
        proposals.push(format!(
            "{} belong together, by {}; {remedy}",
            names.join(" and "),
            shortened(&reasons)
        ));
    }
    proposals
}

/// A warning where bodies touch nothing.
pub(super) fn apart(units: &[Unit], contacts: &ResidueContacts) -> Vec<String> {
    if units.len() < 2 {
        return Vec::new();
    }
    let alone = (0..units.len()).filter(|unit| contacts.partners(*unit).is_empty());
    let alone: Vec<usize> = alone.collect();
    let Some(&first) = alone.first() else {
        return Vec::new();
    };
    let names: Vec<String> = alone.iter().map(|unit| units[*unit].name.clone()).collect();
    let coordinates = positions(&units[first]);
    let others = (0..units.len()).filter(|unit| *unit != first);
    let others: Vec<Vec3> = others.flat_map(|unit| positions(&units[unit])).collect();
    vec![format!(
        "no atom of {} is within 4.5 Å of another body ({} is {:.1} Å away); if files are in different \
         frames, superpose them on the complex first, and if the file holds the asymmetric unit, ask \
         for the biological assembly with --assembly 1",
        shortened(&names),
        units[first].name,
        least_distance_angstrom(&coordinates, &others)
    )]
}

/// A warning where residues at an interface lack atoms.
pub(super) fn gaps_in_interfaces(files: &[File], units: &[NamedUnit]) -> Vec<String> {
    let mut listed = Vec::new();
    for (number, named_unit) in units.iter().enumerate() {
        let incomplete = &files[named_unit.file].selection.report.incomplete;
        let keys: BTreeSet<_> = incomplete.iter().map(|residue| &residue.residue).collect();
        let residues = named_unit.unit.residues.iter();
        for residue in residues.filter(|residue| keys.contains(&residue.key)) {
            let coordinates: Vec<Vec3> = residue.atoms.iter().map(|atom| atom.position).collect();
            let others = units
                .iter()
                .enumerate()
                .filter(|(other, _)| *other != number);
            let mut others = others.map(|(_, other)| positions(&other.unit));
            if others.any(|other| count_within(&coordinates, &other, INTERFACE_ANGSTROM) > 0) {
                listed.push(format!("{} {}", residue.name, residue.key));
            }
        }
    }
    if listed.is_empty() {
        return Vec::new();
    }
    vec![format!(
        "residues within {INTERFACE_ANGSTROM} Å of another body lack atoms, so contacts and charges are missing \
         there: {}; rebuild the side chains in a modelling program",
        shortened(&listed)
    )]
}

/// The first items of a list, and the number of further ones.
pub(super) fn shortened(list: &[String]) -> String {
    match list.len() {
        0..=MOST_LISTED => list.join(", "),
        count => format!(
            "{} and {} more",
            list[..MOST_LISTED].join(", "),
            count - MOST_LISTED
        ),
    }
}

fn positions(unit: &Unit) -> Vec<Vec3> {
    let atoms = unit.residues.iter().flat_map(|residue| &residue.atoms);
    atoms.map(|atom| atom.position).collect()
}

/// Number of `points` within a distance of any of `others`.
fn count_within(points: &[Vec3], others: &[Vec3], distance_angstrom: f64) -> usize {
    let Some((low, high)) = bounds(points) else {
        return 0;
    };
    let margin = Vec3::repeat(distance_angstrom);
    let (low, high) = (low - margin, high + margin);
    let is_near = |point: &&Vec3| (0..3).all(|i| point[i] >= low[i] && point[i] <= high[i]);
    let others: Vec<&Vec3> = others.iter().filter(is_near).collect();
    let square = distance_angstrom * distance_angstrom;
    let has_near = |point: &&Vec3| {
        let mut others = others.iter();
        others.any(|other| (*point - **other).norm_squared() <= square)
    };
    points.iter().filter(has_near).count()
}

fn bounds(points: &[Vec3]) -> Option<(Vec3, Vec3)> {
    let first = *points.first()?;
    Some(points.iter().fold((first, first), |(low, high), point| {
        (low.inf(point), high.sup(point))
    }))
}

fn least_distance_angstrom(points: &[Vec3], others: &[Vec3]) -> f64 {
    let pairs = points.iter().flat_map(|point| {
        others
            .iter()
            .map(move |other| (point - other).norm_squared())
    });
    pairs.fold(f64::INFINITY, f64::min).sqrt()
}
