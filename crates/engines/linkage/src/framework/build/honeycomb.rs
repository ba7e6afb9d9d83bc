//! Hexagonal honeycombs and arrowheads: ribs that hinge.

use super::hinges::{hinge, hinge_neighbouring_rods};
use super::{degrees, neighbour, network, rod};
use crate::error::{Result, require, require_positive};
use crate::framework::analytic::Honeycomb;
use crate::framework::model::{Framework, Neighbour};
use std::f64::consts::{FRAC_PI_2, PI};

/// The hexagonal honeycomb of the paper: ribs h along z, ribs l at the angle θ to them; re-entrant
/// for θ below 90°. Hinges sit between an h rib and an l rib, none between two l ribs.
///
/// ```
/// use protomer_linkage::framework::{analytic::Honeycomb, build::honeycomb, Elasticity};
/// let made_of = Honeycomb {
///     h_angstrom: 2.0,
///     l_angstrom: 1.0,
///     theta_rad: 60_f64.to_radians(),
///     hinge_stiffness_kcal_mol_rad2: 50.0,
///     rod_stiffness_kcal_mol_angstrom2: 10_000.0,
///     thickness_angstrom: 1.0,
/// };
/// let compliance = Elasticity::from_framework(&honeycomb(&made_of)?)?.compliance().unwrap();
/// let poissons_ratio = -compliance[(1, 0)] / compliance[(0, 0)];
/// assert!((poissons_ratio + 0.961).abs() < 1e-3); // table 3: -0.961
/// # Ok::<(), protomer_linkage::CrystalError>(())
/// ```
///
/// # Errors
/// [`CrystalError::BadSetting`](crate::CrystalError::BadSetting) for lengths or an angle that give
/// no cell.
pub fn honeycomb(made_of: &Honeycomb) -> Result<Framework> {
    let (h, l, theta) = (made_of.h_angstrom, made_of.l_angstrom, made_of.theta_rad);
    require_positive("h", h)?;
    require_positive("l", l)?;
    let is_inside = theta > 0.0 && theta < PI;
    require(
        "theta",
        degrees(theta),
        is_inside,
        "between 0 and 180 degrees",
    )?;
    let [x1, x2] = made_of.cell_angstrom();
    let requirement = "greater than l cos(theta), or the cell has no height";
    require("h", h, x2 > 0.0, requirement)?;
    let (sine, cosine) = theta.sin_cos();
    let nodes = vec![
        vec![0.0, 0.0],
        vec![0.0, h],
        vec![l * sine, l * cosine],
        vec![l * sine, l * cosine - h],
    ];
    let ribs = [
        (0, neighbour(1, 0, 0)),
        (2, neighbour(3, 0, 0)),
        (0, neighbour(2, 0, 0)),
        (0, neighbour(2, -1, 0)),
        (1, neighbour(3, 0, 1)),
        (1, neighbour(3, -1, 1)),
    ];
    let ks = made_of.rod_stiffness_kcal_mol_angstrom2;
    let rods = ribs.map(|(from, to)| rod(from, to, ks)).to_vec();
    let mut framework = network(vec![vec![x1, 0.0], vec![0.0, x2]], nodes, rods);
    framework.thickness_angstrom = made_of.thickness_angstrom;
    let kh = made_of.hinge_stiffness_kcal_mol_rad2;
    for (vertex, rib, inclined) in honeycomb_angles() {
        framework.hinges.push(hinge(vertex, [rib, inclined], kh));
    }
    Ok(framework)
}

/// Vertex, end of the h rib and end of an l rib of every angle θ.
fn honeycomb_angles() -> [(usize, Neighbour, Neighbour); 8] {
    [
        (0, neighbour(1, 0, 0), neighbour(2, 0, 0)),
        (0, neighbour(1, 0, 0), neighbour(2, -1, 0)),
        (1, neighbour(0, 0, 0), neighbour(3, 0, 1)),
        (1, neighbour(0, 0, 0), neighbour(3, -1, 1)),
        (2, neighbour(3, 0, 0), neighbour(0, 0, 0)),
        (2, neighbour(3, 0, 0), neighbour(0, 1, 0)),
        (3, neighbour(2, 0, 0), neighbour(1, 0, -1)),
        (3, neighbour(2, 0, 0), neighbour(1, 1, -1)),
    ]
}

/// The arrowhead (double-arrow) network: long ribs at ±`outer_rad` and short ribs at ±`inner_rad`
/// to the axis z join the same tips, chained along z, with hinges between ribs that are next to each
/// other around a node (Larsen, Sigmund and Bouwstra, J. Microelectromech. Syst. 6, 99 (1997)).
/// `width_angstrom` is the cell along y.
///
/// ```
/// use protomer_linkage::framework::{Elasticity, Moduli, build::arrowhead};
/// let net = arrowhead(2.0, 0.5, 1.1, 1000.0, 10.0)?;
/// let moduli = Moduli::new(&Elasticity::from_framework(&net)?, 1.0);
/// assert!(moduli.poissons[0][1].unwrap() < 0.0); // auxetic
/// # Ok::<(), protomer_linkage::CrystalError>(())
/// ```
///
/// # Errors
/// [`CrystalError::BadSetting`](crate::CrystalError::BadSetting) unless 0 < outer < inner < 90°.
pub fn arrowhead(
    width_angstrom: f64,
    outer_rad: f64,
    inner_rad: f64,
    ks: f64,
    kh: f64,
) -> Result<Framework> {
    require_positive("width", width_angstrom)?;
    let inner = degrees(inner_rad);
    let is_below = inner_rad.abs() < FRAC_PI_2;
    require(
        "inner angle",
        inner,
        is_below,
        "less than 90 degrees, or the arrows overlap",
    )?;
    let is_smaller = outer_rad > 0.0 && outer_rad < inner_rad;
    let requirement = "positive and smaller than the inner angle";
    require("outer angle", degrees(outer_rad), is_smaller, requirement)?;
    let half = 0.5 * width_angstrom;
    let (tall, short) = (half / outer_rad.tan(), half / inner_rad.tan());
    // Node 1 is a wing between two columns, node 0 a tip on a column: long ribs rise from the wing
    // to its tip, short ribs to the tip of the arrow below.
    let cell = vec![vec![width_angstrom, 0.0], vec![0.0, tall - short]];
    let nodes = vec![vec![0.0, tall], vec![half, 0.0]];
    let tips = [
        neighbour(0, 0, 0),
        neighbour(0, 1, 0),
        neighbour(0, 0, -1),
        neighbour(0, 1, -1),
    ];
    let ribs = tips.map(|tip| rod(1, tip, ks)).to_vec();
    let mut framework = network(cell, nodes, ribs);
    hinge_neighbouring_rods(&mut framework, kh);
    Ok(framework)
}
