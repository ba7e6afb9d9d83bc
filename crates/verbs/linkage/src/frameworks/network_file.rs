//! Networks as TOML: the keys are the fields of [`Framework`] and its parts.

use anyhow::{Context, Result};
use protomer_linkage::framework::{Framework, Neighbour};
use protomer_results::keys;
use std::fmt::Write;
use std::path::Path;

/// Reads a network and checks it.
///
/// # Errors
/// Names the file and the line, or the invalid node, rod or hinge. For an unknown key, suggests
/// the nearest valid one.
pub fn read(path: &Path) -> Result<Framework> {
    let text = protomer_io::input::read_to_string(path)
        .with_context(|| format!("cannot read {}", path.display()))?;
    let network: Framework = keys::from_toml(path, &text)?;
    network
        .check()
        .with_context(|| path.display().to_string())?;
    Ok(network)
}

/// The text of a network file; `about` becomes a comment at its head.
///
/// ```
/// use protomer_linkage_verbs::frameworks::network_file::to_toml;
/// let network = protomer_linkage::framework::build::face_centred_cubic(3.0, 7.0)?;
/// let read: protomer_linkage::framework::Framework = toml::from_str(&to_toml(&network, "a test"))?;
/// assert_eq!(read, network);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn to_toml(network: &Framework, about: &str) -> String {
    let mut text = format!(
        "# {about}\n# Lengths in Å, stiffnesses in kcal/mol/Å² (rods) and kcal/mol/rad² (hinges, torsions); an image counts \
         cells along each cell vector.\n# Add rest_length_angstrom to a rod, or rest_angle_rad to a hinge, whose rest \
         state differs from the drawn geometry.\n\n"
    );
    text += &format!("cell_angstrom = {:?}\n", network.cell_angstrom);
    if network.dimension() == 2 {
        text += &format!("thickness_angstrom = {:?}\n", network.thickness_angstrom);
    }
    text += &list(
        "nodes_angstrom",
        network
            .nodes_angstrom
            .iter()
            .map(|node| format!("{node:?}")),
    );
    text += &list(
        "rods",
        network.rods.iter().map(|rod| {
            let rest_length = optional("rest_length_angstrom", rod.rest_length_angstrom);
            let (from, to, k) = (
                rod.from,
                neighbour(&rod.to),
                rod.stiffness_kcal_mol_angstrom2,
            );
            format!(
                "{{ from = {from}, to = {to}, stiffness_kcal_mol_angstrom2 = {k:?}{rest_length} }}"
            )
        }),
    );
    text += &list(
        "hinges",
        network.hinges.iter().map(|hinge| {
            let rest_angle = optional("rest_angle_rad", hinge.rest_angle_rad);
            let (vertex, k) = (hinge.vertex, hinge.stiffness_kcal_mol_rad2);
            let [first, second] = hinge.between.each_ref().map(neighbour);
            format!("{{ vertex = {vertex}, between = [{first}, {second}], stiffness_kcal_mol_rad2 = {k:?}{rest_angle} }}")
        }),
    );
    text += &list(
        "torsions",
        network.torsions.iter().map(|torsion| {
            let rest_angle = optional("rest_angle_rad", torsion.rest_angle_rad);
            let nodes = torsion.along.each_ref().map(neighbour).join(", ");
            format!(
                "{{ along = [{nodes}], stiffness_kcal_mol_rad2 = {:?}{rest_angle} }}",
                torsion.stiffness_kcal_mol_rad2
            )
        }),
    );
    text
}

fn list(key: &str, items: impl Iterator<Item = String>) -> String {
    let mut text = String::new();
    for item in items {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "  {item},");
    }
    if text.is_empty() {
        text
    } else {
        format!("{key} = [\n{text}]\n")
    }
}

fn optional(key: &str, value: Option<f64>) -> String {
    value.map_or_else(String::new, |value| format!(", {key} = {value:?}"))
}

fn neighbour(neighbour: &Neighbour) -> String {
    if neighbour.image.is_empty() {
        format!("{{ node = {} }}", neighbour.node)
    } else {
        format!(
            "{{ node = {}, image = {:?} }}",
            neighbour.node, neighbour.image
        )
    }
}
