//! Networks that are often wanted. Where ks and kh are stiffnesses they are those of every rod
//! (kcal/mol/Å²) and every hinge (kcal/mol/rad²).

use super::analytic::Honeycomb;
use super::model::{Framework, Hinge, Neighbour, Rod};
use crate::{CrystalError, Result};
use std::f64::consts::PI;

/// The hexagonal honeycomb of the paper: ribs h along z, ribs l at the angle θ to them; re-entrant
/// for θ below 90°. Hinges sit between an h rib and an l rib, none between two l ribs.
///
/// ```
/// use protomer_crystal::framework::{analytic::Honeycomb, build::honeycomb, Elasticity};
/// let made_of = Honeycomb {
///     h_angstrom: 2.0,
///     l_angstrom: 1.0,
///     theta_rad: 60_f64.to_radians(),
///     hinge_stiffness_kcal_mol_rad2: 50.0,
///     rod_stiffness_kcal_mol_angstrom2: 10_000.0,
///     thickness_angstrom: 1.0,
/// };
/// let compliance = Elasticity::of(&honeycomb(&made_of)?)?.compliance().unwrap();
/// let poissons_ratio = -compliance[(1, 0)] / compliance[(0, 0)];
/// assert!((poissons_ratio + 0.961).abs() < 1e-3); // table 3: -0.961
/// # Ok::<(), protomer_crystal::CrystalError>(())
/// ```
///
/// # Errors
/// [`CrystalError::BadSetting`] for lengths or an angle that give no cell.
pub fn honeycomb(made_of: &Honeycomb) -> Result<Framework> {
    let Honeycomb {
        h_angstrom: h,
        l_angstrom: l,
        theta_rad: theta,
        ..
    } = *made_of;
    positive("h", h)?;
    positive("l", l)?;
    if !(theta > 0.0 && theta < PI) {
        return Err(CrystalError::BadSetting {
            setting: "theta",
            value: degrees(theta),
            requirement: "between 0 and 180 degrees",
        });
    }
    let [x1, x2] = made_of.cell_angstrom();
    if x2 <= 0.0 {
        return Err(CrystalError::BadSetting {
            setting: "h",
            value: h,
            requirement: "greater than l cos(theta), or the cell has no height",
        });
    }
    let (sine, cosine) = theta.sin_cos();
    let nodes_angstrom = vec![
        vec![0.0, 0.0],
        vec![0.0, h],
        vec![l * sine, l * cosine],
        vec![l * sine, l * cosine - h],
    ];
    let n = |node: usize, y: i32, z: i32| Neighbour::there(node, &[y, z]);
    let rod = |from: usize, to: Neighbour| Rod {
        from,
        to,
        stiffness_kcal_mol_angstrom2: made_of.rod_stiffness_kcal_mol_angstrom2,
        rest_length_angstrom: None,
    };
    let rods = vec![
        rod(0, n(1, 0, 0)),
        rod(2, n(3, 0, 0)),
        rod(0, n(2, 0, 0)),
        rod(0, n(2, -1, 0)),
        rod(1, n(3, 0, 1)),
        rod(1, n(3, -1, 1)),
    ];
    let hinge = |vertex: usize, rib: Neighbour, inclined: Neighbour| Hinge {
        vertex,
        between: [rib, inclined],
        stiffness_kcal_mol_rad2: made_of.hinge_stiffness_kcal_mol_rad2,
        rest_angle_rad: None,
    };
    let hinges = vec![
        hinge(0, n(1, 0, 0), n(2, 0, 0)),
        hinge(0, n(1, 0, 0), n(2, -1, 0)),
        hinge(1, n(0, 0, 0), n(3, 0, 1)),
        hinge(1, n(0, 0, 0), n(3, -1, 1)),
        hinge(2, n(3, 0, 0), n(0, 0, 0)),
        hinge(2, n(3, 0, 0), n(0, 1, 0)),
        hinge(3, n(2, 0, 0), n(1, 0, -1)),
        hinge(3, n(2, 0, 0), n(1, 1, -1)),
    ];
    Ok(Framework {
        cell_angstrom: vec![vec![x1, 0.0], vec![0.0, x2]],
        thickness_angstrom: made_of.thickness_angstrom,
        nodes_angstrom,
        rods,
        hinges,
        torsions: Vec::new(),
    })
}

/// Squares of side a, made stiff by rods along sides and diagonals, that touch at corners and are
/// turned by ±`angle_rad` (zero: fully extended); hinges between the sides of neighbouring squares
/// (Grima and Evans, J. Mater. Sci. Lett. 19, 1563 (2000)). Each corner is one node.
///
/// # Errors
/// [`CrystalError::BadSetting`] for a side that is not positive or an angle of 45° and beyond,
/// where squares overlap.
pub fn rotating_squares(side_angstrom: f64, angle_rad: f64, ks: f64, kh: f64) -> Result<Framework> {
    positive("side", side_angstrom)?;
    turned("angle", angle_rad, PI / 4.0)?;
    // Square A about the origin, square B about (c/2, 0), c the cell's edge; corners are shared.
    let (radius, edge) = (
        side_angstrom / 2f64.sqrt(),
        2.0 * side_angstrom * 2f64.sqrt() * angle_rad.cos(),
    );
    let corner = |k: usize| {
        let direction = angle_rad + k as f64 * PI / 2.0;
        [radius * direction.cos(), radius * direction.sin()]
    };
    // The four corners of A at (0, 0) and of A at (c/2, c/2) are all the nodes; squares B lie
    // between.
    let half = 0.5 * edge;
    let mut nodes: Vec<Vec<f64>> = (0..4).map(|k| corner(k).to_vec()).collect();
    nodes.extend((0..4).map(|k| vec![half + corner(k)[0], half + corner(k)[1]]));
    let n = |node: usize, y: i32, z: i32| Neighbour::there(node, &[y, z]);
    let squares: [[Neighbour; 4]; 4] = [
        std::array::from_fn(|k| n(k, 0, 0)),
        std::array::from_fn(|k| n(4 + k, 0, 0)),
        // B at (c/2, 0): its west corner is the east corner of A, and so on.
        [n(2, 1, 0), n(7, 0, 0), n(0, 0, 0), n(5, 0, -1)],
        // B at (0, c/2).
        [n(6, 0, 0), n(3, 0, 1), n(4, -1, 0), n(1, 0, 0)],
    ];
    let mut framework = polygons(
        vec![vec![edge, 0.0], vec![0.0, edge]],
        nodes,
        &squares.map(|s| s.to_vec()),
        ks,
    );
    hinge_all(&mut framework, kh);
    Ok(framework)
}

/// Equilateral triangles of side a that touch at corners and are turned by ±`angle_rad` (zero:
/// fully extended, the kagome lattice); hinges between the sides of neighbours (Grima and Evans, J.
/// Mater. Sci. 41, 3193 (2006)).
///
/// # Errors
/// [`CrystalError::BadSetting`] for a side that is not positive or an angle of 60° and beyond.
pub fn rotating_triangles(
    side_angstrom: f64,
    angle_rad: f64,
    ks: f64,
    kh: f64,
) -> Result<Framework> {
    positive("side", side_angstrom)?;
    turned("angle", angle_rad, PI / 3.0)?;
    // An upright triangle about the origin and one upside down; three nodes in a hexagonal cell.
    let (radius, edge) = (
        side_angstrom / 3f64.sqrt(),
        2.0 * side_angstrom * angle_rad.cos(),
    );
    let corner = |k: usize| {
        let direction = angle_rad + PI / 6.0 + k as f64 * 2.0 * PI / 3.0;
        vec![radius * direction.cos(), radius * direction.sin()]
    };
    let cell = vec![vec![edge, 0.0], vec![0.5 * edge, 0.5 * 3f64.sqrt() * edge]];
    let n = |node: usize, y: i32, z: i32| Neighbour::there(node, &[y, z]);
    // The corners of the triangle upside down are corners of three upright ones around it.
    let triangles = [
        vec![n(0, 0, 0), n(1, 0, 0), n(2, 0, 0)],
        vec![n(0, 0, 0), n(2, 0, 1), n(1, 1, 0)],
    ];
    let mut framework = polygons(cell, (0..3).map(corner).collect(), &triangles, ks);
    hinge_all(&mut framework, kh);
    Ok(framework)
}

/// Rigid polygons: a rod between any two corners.
fn polygons(
    cell: Vec<Vec<f64>>,
    nodes: Vec<Vec<f64>>,
    polygons: &[Vec<Neighbour>],
    ks: f64,
) -> Framework {
    let mut rods = Vec::new();
    for polygon in polygons {
        for (index, first) in polygon.iter().enumerate() {
            for second in &polygon[index + 1..] {
                let image: Vec<i32> = second
                    .image
                    .iter()
                    .zip(&first.image)
                    .map(|(b, a)| b - a)
                    .collect();
                rods.push(Rod {
                    from: first.node,
                    to: Neighbour {
                        node: second.node,
                        image,
                    },
                    stiffness_kcal_mol_angstrom2: ks,
                    rest_length_angstrom: None,
                });
            }
        }
    }
    Framework {
        cell_angstrom: cell,
        thickness_angstrom: 1.0,
        nodes_angstrom: nodes,
        rods,
        hinges: Vec::new(),
        torsions: Vec::new(),
    }
}

/// Hinges between any two rods that follow each other around a node.
fn hinge_all(framework: &mut Framework, kh: f64) {
    if kh == 0.0 {
        return;
    }
    for vertex in 0..framework.nodes_angstrom.len() {
        let mut around: Vec<(f64, Neighbour)> = Vec::new();
        for rod in &framework.rods {
            let back = Neighbour {
                node: rod.from,
                image: rod.to.image.iter().map(|i| -i).collect(),
            };
            let ends = [
                (rod.from == vertex).then(|| rod.to.clone()),
                (rod.to.node == vertex).then_some(back),
            ];
            for end in ends.into_iter().flatten() {
                let d = framework.difference(&Neighbour::here(vertex), &end);
                around.push((d[1].atan2(d[0]), end));
            }
        }
        around.sort_by(|a, b| a.0.total_cmp(&b.0));
        let count = around.len();
        for i in 0..if count == 2 { 1 } else { count } {
            framework.hinges.push(Hinge {
                vertex,
                between: [around[i].1.clone(), around[(i + 1) % count].1.clone()],
                stiffness_kcal_mol_rad2: kh,
                rest_angle_rad: None,
            });
        }
    }
}

/// The arrowhead (double-arrow) network: long ribs at ±`outer_rad` and short ribs at ±`inner_rad`
/// to the axis z join the same tips, chained along z and hinged everywhere (Larsen, Sigmund and
/// Bouwstra, J. Microelectromech. Syst. 6, 99 (1997)). `width_angstrom` is the cell along y.
///
/// # Errors
/// [`CrystalError::BadSetting`] unless 0 < outer < inner < 90°.
pub fn arrowhead(
    width_angstrom: f64,
    outer_rad: f64,
    inner_rad: f64,
    ks: f64,
    kh: f64,
) -> Result<Framework> {
    positive("width", width_angstrom)?;
    turned("inner angle", inner_rad, PI / 2.0)?;
    if !(outer_rad > 0.0 && outer_rad < inner_rad) {
        let requirement = "positive and smaller than the inner angle";
        return Err(CrystalError::BadSetting {
            setting: "outer angle",
            value: degrees(outer_rad),
            requirement,
        });
    }
    let half = 0.5 * width_angstrom;
    let (tall, short) = (half / outer_rad.tan(), half / inner_rad.tan());
    let height = tall - short;
    let n = |node: usize, y: i32, z: i32| Neighbour::there(node, &[y, z]);
    let rod = |from: usize, to: Neighbour| Rod {
        from,
        to,
        stiffness_kcal_mol_angstrom2: ks,
        rest_length_angstrom: None,
    };
    // Node 1 is a wing between two columns, node 0 a tip on a column: long ribs rise from the wing
    // to its tip, short ribs to the tip of the arrow below.
    let mut framework = Framework {
        cell_angstrom: vec![vec![width_angstrom, 0.0], vec![0.0, height]],
        thickness_angstrom: 1.0,
        nodes_angstrom: vec![vec![0.0, tall], vec![half, 0.0]],
        rods: vec![
            rod(1, n(0, 0, 0)),
            rod(1, n(0, 1, 0)),
            rod(1, n(0, 0, -1)),
            rod(1, n(0, 1, -1)),
        ],
        hinges: Vec::new(),
        torsions: Vec::new(),
    };
    hinge_all(&mut framework, kh);
    Ok(framework)
}

/// The lattice of rigid squares joined by rods, with rods that stretch: half-diagonal l, rods r0,
/// the coherent state at `angle_rad` (open is π/4); squares are made stiff by rods along sides and
/// diagonals of stiffness `square_ks`.
///
/// # Errors
/// [`CrystalError::BadSetting`] for lengths that are not positive.
pub fn rod_lattice(
    l_angstrom: f64,
    r0_angstrom: f64,
    angle_rad: f64,
    square_ks: f64,
    rod_ks: f64,
    kh: f64,
) -> Result<Framework> {
    positive("l", l_angstrom)?;
    positive("r0", r0_angstrom)?;
    let spacing = 2.0 * l_angstrom * (angle_rad - PI / 4.0).cos() + r0_angstrom;
    // Corners at θ + 135°, 45°, 225°, -45°; θ = ±angle.
    let corners = [135.0, 45.0, 225.0, -45.0].map(f64::to_radians);
    let centres = [
        [0.0, 0.0],
        [spacing, 0.0],
        [0.0, -spacing],
        [spacing, -spacing],
    ];
    let signs = [1.0, -1.0, -1.0, 1.0];
    let mut nodes = Vec::new();
    for (centre, sign) in centres.iter().zip(signs) {
        for corner in corners {
            let direction = sign * angle_rad + corner;
            nodes.push(vec![
                centre[0] + l_angstrom * direction.cos(),
                centre[1] + l_angstrom * direction.sin(),
            ]);
        }
    }
    let cell = vec![vec![2.0 * spacing, 0.0], vec![0.0, 2.0 * spacing]];
    let squares: Vec<Vec<Neighbour>> = (0..4)
        .map(|s| {
            (0..4)
                .map(|k| Neighbour::there(4 * s + k, &[0, 0]))
                .collect()
        })
        .collect();
    let mut framework = polygons(cell, nodes, &squares, square_ks);
    let at = |square: usize, vertex: usize| 4 * square + vertex - 1;
    let links = [
        (at(0, 4), at(1, 3), [0, 0]),
        (at(0, 3), at(2, 1), [0, 0]),
        (at(1, 2), at(0, 1), [1, 0]),
        (at(1, 4), at(3, 2), [0, 0]),
        (at(2, 2), at(3, 1), [0, 0]),
        (at(2, 4), at(0, 2), [0, -1]),
        (at(3, 4), at(2, 3), [1, 0]),
        (at(3, 3), at(1, 1), [0, -1]),
    ];
    for (from, to, image) in links {
        framework.rods.push(Rod {
            from,
            to: Neighbour::there(to, &image),
            stiffness_kcal_mol_angstrom2: rod_ks,
            rest_length_angstrom: None,
        });
    }
    hinge_all(&mut framework, kh);
    Ok(framework)
}

/// Face-centred cubic net of nearest-neighbour springs in the cubic cell of edge a: C11 = 2 ks/a,
/// C12 = C44 = ks/a.
///
/// # Errors
/// [`CrystalError::BadSetting`] for an edge that is not positive.
pub fn face_centred_cubic(edge_angstrom: f64, ks: f64) -> Result<Framework> {
    positive("edge", edge_angstrom)?;
    let sites = [
        [0.0, 0.0, 0.0],
        [0.0, 0.5, 0.5],
        [0.5, 0.0, 0.5],
        [0.5, 0.5, 0.0],
    ];
    Ok(cubic_net(edge_angstrom, &sites, 0.5f64.sqrt(), ks))
}

/// Diamond net of nearest-neighbour springs in the cubic cell of edge a, with hinges between all
/// bonds at a node. Without hinges C11 = C12 = ks/(3a), and shear costs nothing.
///
/// # Errors
/// [`CrystalError::BadSetting`] for an edge that is not positive.
pub fn diamond(edge_angstrom: f64, ks: f64, kh: f64) -> Result<Framework> {
    positive("edge", edge_angstrom)?;
    let basis = [
        [0.0, 0.0, 0.0],
        [0.0, 0.5, 0.5],
        [0.5, 0.0, 0.5],
        [0.5, 0.5, 0.0],
    ];
    let sites: Vec<[f64; 3]> = basis
        .iter()
        .flat_map(|s| [*s, s.map(|x| x + 0.25)])
        .collect();
    let mut framework = cubic_net(edge_angstrom, &sites, 0.1875f64.sqrt(), ks);
    if kh != 0.0 {
        for vertex in 0..sites.len() {
            let mut around = Vec::new();
            for rod in &framework.rods {
                if rod.from == vertex {
                    around.push(rod.to.clone());
                }
                if rod.to.node == vertex {
                    around.push(Neighbour {
                        node: rod.from,
                        image: rod.to.image.iter().map(|i| -i).collect(),
                    });
                }
            }
            for (index, first) in around.iter().enumerate() {
                for second in &around[index + 1..] {
                    let between = [first.clone(), second.clone()];
                    framework.hinges.push(Hinge {
                        vertex,
                        between,
                        stiffness_kcal_mol_rad2: kh,
                        rest_angle_rad: None,
                    });
                }
            }
        }
    }
    Ok(framework)
}

/// Rods between all sites of a cubic cell at this distance (in edges).
fn cubic_net(edge: f64, sites: &[[f64; 3]], distance: f64, ks: f64) -> Framework {
    let mut rods = Vec::new();
    for (from, a) in sites.iter().enumerate() {
        for (to, b) in sites.iter().enumerate() {
            for code in 0..27 {
                let image = [code / 9 - 1, code / 3 % 3 - 1, code % 3 - 1];
                let square: f64 = (0..3)
                    .map(|i| (b[i] + f64::from(image[i]) - a[i]).powi(2))
                    .sum();
                let once = from < to || (from == to && image > [0, 0, 0]);
                if once && (square.sqrt() - distance).abs() < 1e-9 {
                    rods.push(Rod {
                        from,
                        to: Neighbour::there(to, &image),
                        stiffness_kcal_mol_angstrom2: ks,
                        rest_length_angstrom: None,
                    });
                }
            }
        }
    }
    Framework {
        cell_angstrom: (0..3)
            .map(|i| (0..3).map(|j| if i == j { edge } else { 0.0 }).collect())
            .collect(),
        thickness_angstrom: 1.0,
        nodes_angstrom: sites
            .iter()
            .map(|s| s.iter().map(|x| x * edge).collect())
            .collect(),
        rods,
        hinges: Vec::new(),
        torsions: Vec::new(),
    }
}

fn positive(setting: &'static str, value: f64) -> Result<()> {
    if value.is_finite() && value > 0.0 {
        Ok(())
    } else {
        Err(CrystalError::BadSetting {
            setting,
            value,
            requirement: "positive",
        })
    }
}

/// Degrees for a message: without the last bits, which a conversion there and back changes.
fn degrees(angle_rad: f64) -> f64 {
    (angle_rad.to_degrees() * 1e9).round() / 1e9
}

fn turned(setting: &'static str, angle_rad: f64, limit: f64) -> Result<()> {
    if angle_rad.abs() < limit {
        Ok(())
    } else {
        let requirement = "small enough that the parts do not overlap (squares 45, triangles 60, arrows 90 degrees)";
        Err(CrystalError::BadSetting {
            setting,
            value: degrees(angle_rad),
            requirement,
        })
    }
}
