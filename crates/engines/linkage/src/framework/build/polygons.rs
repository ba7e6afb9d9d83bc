//! Stiff squares and triangles, joined at corners or by rods.

use super::hinges::{bearing, hinge, hinge_neighbouring_rods};
use super::{degrees, neighbour, network, rod};
use crate::error::{Result, require, require_positive};
use crate::framework::model::{Framework, Neighbour};
use std::f64::consts::{FRAC_PI_2, FRAC_PI_3, FRAC_PI_4, FRAC_PI_6, PI};

/// The corners of a polygon in order around it.
type Polygon = Vec<Neighbour>;

/// Squares of side a, made stiff by rods along sides and diagonals, that touch at corners and are
/// turned by ±`angle_rad` (zero: fully extended). Each corner is one node with one hinge of
/// stiffness `kh` between the sides of its two squares, as published: E = 8 K_h / (a² (1 - sin θ))
/// per unit thickness with θ = π/2 - 2 `angle_rad` between squares (Grima and Evans, J. Mater. Sci.
/// Lett. 19, 1563 (2000)).
///
/// ```
/// use protomer_linkage::framework::{Elasticity, Moduli, build::rotating_squares};
/// let (side, angle, kh) = (2.0, 0.4_f64, 1.0);
/// let net = rotating_squares(side, angle, 1e7, kh)?;
/// let moduli = Moduli::new(&Elasticity::from_framework(&net)?, 1.0);
/// let published = 8.0 * kh / (side * side * (1.0 - (2.0 * angle).cos()));
/// assert!((moduli.youngs_gpa[0].unwrap() / published - 1.0).abs() < 1e-4);
/// assert!((moduli.poissons[0][1].unwrap() + 1.0).abs() < 1e-4);
/// # Ok::<(), protomer_linkage::CrystalError>(())
/// ```
///
/// # Errors
/// [`CrystalError::BadSetting`](crate::CrystalError::BadSetting) for a side that is not positive or
/// an angle of 45° and beyond, where squares overlap.
pub fn rotating_squares(side_angstrom: f64, angle_rad: f64, ks: f64, kh: f64) -> Result<Framework> {
    require_positive("side", side_angstrom)?;
    let requirement = "less than 45 degrees either way, or the squares overlap";
    let is_apart = angle_rad.abs() < FRAC_PI_4;
    require("angle", degrees(angle_rad), is_apart, requirement)?;
    // Square A about the origin, square B about (c/2, 0), c the cell's edge; corners are shared.
    let radius = side_angstrom / 2f64.sqrt();
    let edge = 2.0 * side_angstrom * 2f64.sqrt() * angle_rad.cos();
    // The four corners of A at (0, 0) and of A at (c/2, c/2) are all the nodes; squares B lie
    // between.
    let mut nodes = Vec::with_capacity(8);
    for middle in [0.0, 0.5 * edge] {
        for k in 0..4 {
            let direction = angle_rad + k as f64 * FRAC_PI_2;
            nodes.push(vec![
                middle + radius * direction.cos(),
                middle + radius * direction.sin(),
            ]);
        }
    }
    let squares = [
        [
            neighbour(0, 0, 0),
            neighbour(1, 0, 0),
            neighbour(2, 0, 0),
            neighbour(3, 0, 0),
        ],
        [
            neighbour(4, 0, 0),
            neighbour(5, 0, 0),
            neighbour(6, 0, 0),
            neighbour(7, 0, 0),
        ],
        // B at (c/2, 0): its west corner is the east corner of A, and so on.
        [
            neighbour(2, 1, 0),
            neighbour(7, 0, 0),
            neighbour(0, 0, 0),
            neighbour(5, 0, -1),
        ],
        // B at (0, c/2).
        [
            neighbour(6, 0, 0),
            neighbour(3, 0, 1),
            neighbour(4, -1, 0),
            neighbour(1, 0, 0),
        ],
    ]
    .map(Vec::from);
    let cell = vec![vec![edge, 0.0], vec![0.0, edge]];
    let mut framework = stiff_polygons(cell, nodes, &squares, ks);
    hinge_polygons(&mut framework, &squares, kh);
    Ok(framework)
}

/// Equilateral triangles of side a that touch at corners and are turned by ±`angle_rad` (zero:
/// fully extended, the kagome lattice). Each corner is one node with one hinge of stiffness `kh`
/// between the sides of its two triangles, as published: E = 4√3 K_h / (a² (1 + cos(π/3 + θ))) per
/// unit thickness with θ = 2π/3 - 2 `angle_rad` between triangles (Grima and Evans, J. Mater. Sci.
/// 41, 3193 (2006)).
///
/// ```
/// use protomer_linkage::framework::{Elasticity, Moduli, build::rotating_triangles};
/// let (side, angle, kh) = (2.0, 0.4_f64, 1.0);
/// let net = rotating_triangles(side, angle, 1e7, kh)?;
/// let moduli = Moduli::new(&Elasticity::from_framework(&net)?, 1.0);
/// let published = 48f64.sqrt() * kh / (side * side * (1.0 - (2.0 * angle).cos()));
/// assert!((moduli.youngs_gpa[0].unwrap() / published - 1.0).abs() < 1e-4);
/// # Ok::<(), protomer_linkage::CrystalError>(())
/// ```
///
/// # Errors
/// [`CrystalError::BadSetting`](crate::CrystalError::BadSetting) for a side that is not positive or
/// an angle of 60° and beyond.
pub fn rotating_triangles(
    side_angstrom: f64,
    angle_rad: f64,
    ks: f64,
    kh: f64,
) -> Result<Framework> {
    require_positive("side", side_angstrom)?;
    let requirement = "less than 60 degrees either way, or the triangles overlap";
    let is_apart = angle_rad.abs() < FRAC_PI_3;
    require("angle", degrees(angle_rad), is_apart, requirement)?;
    // An upright triangle about the origin and one upside down; three nodes in a hexagonal cell.
    let radius = side_angstrom / 3f64.sqrt();
    let edge = 2.0 * side_angstrom * angle_rad.cos();
    let mut nodes = Vec::with_capacity(3);
    for k in 0..3 {
        let direction = angle_rad + FRAC_PI_6 + k as f64 * 2.0 * PI / 3.0;
        nodes.push(vec![radius * direction.cos(), radius * direction.sin()]);
    }
    // The corners of the triangle upside down are corners of three upright ones around it.
    let triangles = [
        vec![neighbour(0, 0, 0), neighbour(1, 0, 0), neighbour(2, 0, 0)],
        vec![neighbour(0, 0, 0), neighbour(2, 0, 1), neighbour(1, 1, 0)],
    ];
    let cell = vec![vec![edge, 0.0], vec![0.5 * edge, 0.5 * 3f64.sqrt() * edge]];
    let mut framework = stiff_polygons(cell, nodes, &triangles, ks);
    hinge_polygons(&mut framework, &triangles, kh);
    Ok(framework)
}

/// The lattice of rigid squares joined by rods, with rods that stretch: half-diagonal l, rods r0,
/// the coherent state at `angle_rad` (open is π/4). Squares are made stiff by rods along sides and
/// diagonals of stiffness `square_ks`; hinges sit between any two rods that are next to each other
/// around a node, those of the squares included.
///
/// ```
/// use protomer_linkage::framework::build::rod_lattice;
/// let net = rod_lattice(1.0, 0.3, 0.4, 1000.0, 100.0, 0.0)?;
/// // Four squares of six rods each, and eight rods between them.
/// assert_eq!((net.nodes_angstrom.len(), net.rods.len()), (16, 32));
/// # Ok::<(), protomer_linkage::CrystalError>(())
/// ```
///
/// # Errors
/// [`CrystalError::BadSetting`](crate::CrystalError::BadSetting) for lengths that are not positive.
pub fn rod_lattice(
    l_angstrom: f64,
    r0_angstrom: f64,
    angle_rad: f64,
    square_ks: f64,
    rod_ks: f64,
    kh: f64,
) -> Result<Framework> {
    require_positive("l", l_angstrom)?;
    require_positive("r0", r0_angstrom)?;
    let spacing = 2.0 * l_angstrom * (angle_rad - FRAC_PI_4).cos() + r0_angstrom;
    let cell = vec![vec![2.0 * spacing, 0.0], vec![0.0, 2.0 * spacing]];
    let nodes = corners_of_four_squares(l_angstrom, spacing, angle_rad);
    let squares: Vec<Polygon> = (0..4).map(square_of_corners).collect();
    let mut framework = stiff_polygons(cell, nodes, &squares, square_ks);
    for (from, to) in lattice_links() {
        framework.rods.push(rod(from, to, rod_ks));
    }
    hinge_neighbouring_rods(&mut framework, kh);
    Ok(framework)
}

/// Corners of a square at θ + 135°, 45°, 225°, -45°, of four squares with alternating θ = ±angle.
fn corners_of_four_squares(l: f64, spacing: f64, angle_rad: f64) -> Vec<Vec<f64>> {
    let corners = [135.0, 45.0, 225.0, -45.0].map(f64::to_radians);
    let squares = [
        ([0.0, 0.0], 1.0),
        ([spacing, 0.0], -1.0),
        ([0.0, -spacing], -1.0),
        ([spacing, -spacing], 1.0),
    ];
    let mut nodes = Vec::with_capacity(16);
    for (centre, sign) in squares {
        for corner in corners {
            let direction: f64 = sign * angle_rad + corner;
            nodes.push(vec![
                centre[0] + l * direction.cos(),
                centre[1] + l * direction.sin(),
            ]);
        }
    }
    nodes
}

fn square_of_corners(square: usize) -> Polygon {
    (0..4).map(|k| neighbour(4 * square + k, 0, 0)).collect()
}

/// The rods of table I of the paper on the lattice: from a node to a node or its image.
fn lattice_links() -> [(usize, Neighbour); 8] {
    let node = |square: usize, vertex: usize| 4 * square + vertex - 1;
    [
        (node(0, 4), neighbour(node(1, 3), 0, 0)),
        (node(0, 3), neighbour(node(2, 1), 0, 0)),
        (node(1, 2), neighbour(node(0, 1), 1, 0)),
        (node(1, 4), neighbour(node(3, 2), 0, 0)),
        (node(2, 2), neighbour(node(3, 1), 0, 0)),
        (node(2, 4), neighbour(node(0, 2), 0, -1)),
        (node(3, 4), neighbour(node(2, 3), 1, 0)),
        (node(3, 3), neighbour(node(1, 1), 0, -1)),
    ]
}

/// Polygons made stiff by a rod between any two corners.
pub(super) fn stiff_polygons(
    cell: Vec<Vec<f64>>,
    nodes: Vec<Vec<f64>>,
    polygons: &[Polygon],
    ks: f64,
) -> Framework {
    let mut rods = Vec::new();
    for polygon in polygons {
        for (index, first) in polygon.iter().enumerate() {
            for second in &polygon[index + 1..] {
                rods.push(rod(first.node, seen_from(first, second), ks));
            }
        }
    }
    network(cell, nodes, rods)
}

/// A corner of a polygon, where another corner is taken to be in the cell itself.
pub(super) fn seen_from(first: &Neighbour, second: &Neighbour) -> Neighbour {
    let images = second.image.iter().zip(&first.image);
    Neighbour {
        node: second.node,
        image: images.map(|(target, origin)| target - origin).collect(),
    }
}

/// Adds one hinge to every corner at which two polygons touch: across the gap that follows the first
/// of the two anticlockwise. The gap on the other side changes by the opposite angle and needs no
/// separate hinge.
fn hinge_polygons(framework: &mut Framework, polygons: &[Polygon], kh: f64) {
    if kh == 0.0 {
        return;
    }
    for vertex in 0..framework.nodes_angstrom.len() {
        let mut sides = sides_at(framework, polygons, vertex);
        sides.sort_by(|a, b| a.bearing.total_cmp(&b.bearing));
        for (index, side) in sides.iter().enumerate() {
            let next = &sides[(index + 1) % sides.len()];
            if side.polygon < next.polygon {
                let between = [side.end.clone(), next.end.clone()];
                framework.hinges.push(hinge(vertex, between, kh));
            }
        }
    }
}

/// A side of a polygon that ends at a node.
struct Side {
    polygon: usize,
    end: Neighbour,
    bearing: f64,
}

fn sides_at(framework: &Framework, polygons: &[Polygon], vertex: usize) -> Vec<Side> {
    let mut sides = Vec::new();
    for (polygon, corners) in polygons.iter().enumerate() {
        let count = corners.len();
        for (k, corner) in corners.iter().enumerate() {
            if corner.node != vertex {
                continue;
            }
            for other in [(k + 1) % count, (k + count - 1) % count] {
                let end = seen_from(corner, &corners[other]);
                let bearing = bearing(framework, vertex, &end);
                sides.push(Side {
                    polygon,
                    end,
                    bearing,
                });
            }
        }
    }
    sides
}
