//! Tetrahedra of alpha-cristobalite.

use super::hinges::hinge;
use super::polygons::seen_from;
use super::{network, rod};
use crate::error::{Result, require_positive};
use crate::framework::model::{Framework, Neighbour};

/// Edges of the tetragonal cell, Å, and coordinates of Si (x, x, 0) and O: Downs and Palmer, Am. Mineral.
/// 79, 9 (1994), at ambient pressure.
const A_ANGSTROM: f64 = 4.9717;
const C_ANGSTROM: f64 = 6.9223;
const SILICON: f64 = 0.3003;
const OXYGEN: [f64; 3] = [0.2392, 0.1044, 0.1787];
/// Longer than a bond between Si and O, shorter than any other distance between the two, Å.
const BOND_ANGSTROM: f64 = 2.0;

/// Alpha-cristobalite (space group P4₁2₁2): SiO₄ tetrahedra that share corners, made stiff by rods of
/// stiffness `ks` between Si and O and between every two O. At each O there are nine hinges of stiffness
/// `kh`, between the three other O of one tetrahedron and those of the other, which resist bending and
/// twisting (a hinge between the two Si would leave a strain without resistance). The lengths of the crystal
/// are multiplied by `scale`.
///
/// ```
/// use protomer_linkage::framework::{Elasticity, build::alpha_cristobalite};
/// let network = alpha_cristobalite(1.0, 100.0, 1.0)?;
/// assert_eq!((network.nodes_angstrom.len(), network.rods.len(), network.hinges.len()), (12, 40, 72));
/// let c = Elasticity::from_framework(&network)?.stiffness;
/// // Tetragonal: x and y are alike.
/// assert!((c[(0, 0)] / c[(1, 1)] - 1.0).abs() < 1e-9);
/// # Ok::<(), protomer_linkage::CrystalError>(())
/// ```
///
/// # Errors
/// [`CrystalError::BadSetting`](crate::CrystalError::BadSetting) for a scale that is not positive.
pub fn alpha_cristobalite(scale: f64, ks: f64, kh: f64) -> Result<Framework> {
    require_positive("scale", scale)?;
    let edges = [A_ANGSTROM, A_ANGSTROM, C_ANGSTROM].map(|edge| edge * scale);
    let sites: Vec<[f64; 3]> = silicon().into_iter().chain(oxygen()).collect();
    let mut cell = Vec::with_capacity(3);
    for (axis, edge) in edges.iter().enumerate() {
        let mut vector = vec![0.0; 3];
        vector[axis] = *edge;
        cell.push(vector);
    }
    let nodes = sites
        .iter()
        .map(|site| site.iter().zip(edges).map(|(x, edge)| x * edge).collect());
    let mut framework = network(cell, nodes.collect(), Vec::new());
    // The corners of the tetrahedra at each O, as seen from it.
    let mut tetrahedra = vec![Vec::new(); sites.len()];
    for centre in 0..4 {
        let corners = corners_of(&framework, centre, BOND_ANGSTROM * scale);
        for (index, corner) in corners.iter().enumerate() {
            framework.rods.push(rod(centre, corner.clone(), ks));
            for other in &corners[index + 1..] {
                framework
                    .rods
                    .push(rod(corner.node, seen_from(corner, other), ks));
            }
            let others = corners
                .iter()
                .enumerate()
                .filter(|(place, _)| *place != index);
            let others: Vec<_> = others.map(|(_, other)| seen_from(corner, other)).collect();
            tetrahedra[corner.node].push(others);
        }
    }
    if kh != 0.0 {
        for (oxygen, around) in tetrahedra.iter().enumerate() {
            if let [first, second] = &around[..] {
                for (a, b) in first
                    .iter()
                    .flat_map(|a| second.iter().map(move |b| (a, b)))
                {
                    let between = [a.clone(), b.clone()];
                    framework.hinges.push(hinge(oxygen, between, kh));
                }
            }
        }
    }
    Ok(framework)
}

/// The special position 4a of P4₁2₁2.
fn silicon() -> [[f64; 3]; 4] {
    let u = SILICON;
    [
        [u, u, 0.0],
        [-u, -u, 0.5],
        [0.5 - u, 0.5 + u, 0.25],
        [0.5 + u, 0.5 - u, 0.75],
    ]
}

/// The general position 8b of P4₁2₁2.
fn oxygen() -> [[f64; 3]; 8] {
    let [x, y, z] = OXYGEN;
    [
        [x, y, z],
        [-x, -y, z + 0.5],
        [0.5 - y, 0.5 + x, z + 0.25],
        [0.5 + y, 0.5 - x, z + 0.75],
        [0.5 - x, 0.5 + y, 0.25 - z],
        [0.5 + x, 0.5 - y, 0.75 - z],
        [y, x, -z],
        [-y, -x, 0.5 - z],
    ]
}

/// The images of nodes from the fifth on, O, that are nearer to a node than this distance (Å).
fn corners_of(framework: &Framework, centre: usize, distance: f64) -> Vec<Neighbour> {
    let mut corners = Vec::with_capacity(4);
    for node in 4..framework.nodes_angstrom.len() {
        for code in 0..125 {
            let image = [code / 25 - 2, code / 5 % 5 - 2, code % 5 - 2];
            let corner = Neighbour::in_image(node, &image);
            let way = framework.difference(&Neighbour::in_own_cell(centre), &corner);
            if way.iter().map(|x| x * x).sum::<f64>() < distance * distance {
                corners.push(corner);
            }
        }
    }
    corners
}
