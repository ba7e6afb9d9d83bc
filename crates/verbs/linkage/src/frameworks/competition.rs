//! A warning where rods and hinges share the strain.

use super::axes;
use anyhow::Result;
use protomer_linkage::framework::{Framework, rod_shares};

/// Shares of the elastic energy above this are told: a single mechanism is then more than 10 % off in its
/// moduli, as above 10⁴ GPa in table 4 of the paper.
const COMPETING_SHARE: f64 = 0.1;
/// Larger networks are not analysed again for it.
const MOST_NODES: usize = 2000;

/// A warning if both stretching rods and turning hinges take a part of the energy of a load along an axis.
///
/// ```
/// use protomer_linkage::framework::build::rotating_squares;
/// use protomer_linkage_verbs::frameworks::competition::warning;
/// // Squares that are nearly rigid turn by their hinges alone; soft ones are stretched as well.
/// assert!(warning(&rotating_squares(1.0, 0.4, 1e5, 1.0)?)?.is_none());
/// let soft = warning(&rotating_squares(1.0, 0.4, 30.0, 1.0)?)?.unwrap_or_default();
/// assert!(soft.contains("is in the rods"));
/// # Ok::<(), anyhow::Error>(())
/// ```
///
/// # Errors
/// If the network is not at a minimum of its energy.
pub fn warning(network: &Framework) -> Result<Option<String>> {
    let has_rods = network
        .rods
        .iter()
        .any(|rod| rod.stiffness_kcal_mol_angstrom2 > 0.0);
    let has_hinges = network
        .hinges
        .iter()
        .any(|hinge| hinge.stiffness_kcal_mol_rad2 > 0.0);
    if !has_rods || !has_hinges || network.nodes_angstrom.len() > MOST_NODES {
        return Ok(None);
    }
    let mut loads = Vec::new();
    for (axis, share) in axes(network.dimension()).iter().zip(rod_shares(network)?) {
        if let Some(share) = share
            && (COMPETING_SHARE..=1.0 - COMPETING_SHARE).contains(&share)
        {
            loads.push(format!("{:.0} % (load along {axis})", 100.0 * share));
        }
    }
    if loads.is_empty() {
        return Ok(None);
    }
    Ok(Some(format!(
        "warning: two mechanisms compete: of the elastic energy {} is in the rods, the rest in the hinges; the results \
         are those of both. For one mechanism alone make the other ten times stiffer",
        loads.join(" and ")
    )))
}
