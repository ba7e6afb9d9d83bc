//! Honeycombs of crosses, stars and wheels: missing-rib foams, connected stars, chiral honeycombs.

use super::hinges::{hinge, hinge_neighbouring_rods};
use super::polygons::stiff_polygons;
use super::{degrees, neighbour, network, rod};
use crate::error::{CrystalError, Result, require, require_positive};
use crate::framework::model::{Framework, Neighbour};
use std::f64::consts::{FRAC_PI_2, PI};

/// Shape and stiffness of a missing-rib foam.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MissingRib {
    /// Length of the arms of the crosses, Å.
    pub arm_angstrom: f64,
    /// Length of the ribs between the arms of two crosses, Å.
    pub rib_angstrom: f64,
    /// Rotation of the crosses out of the axes, rad.
    pub angle_rad: f64,
    /// Stiffness of every arm and rib, kcal/mol/Å².
    pub ks: f64,
    /// Stiffness of the hinges at elbows, between arm and rib, kcal/mol/rad².
    pub kh: f64,
    /// Stiffness of the hinges between neighbouring arms of a cross, kcal/mol/rad².
    pub cross_kh: f64,
}

/// The missing-rib foam: crosses of four arms, turned out of the axes, whose arms are joined by ribs
/// at elbows (Smith, Grima and Evans, Acta Mater. 48, 4349 (2000)).
///
/// The foam has no mirror lines, so that a pull along an axis also shears it. With crosses and ribs that
/// keep their shape and a cell that shears freely, E = `kh` / (2 arm² sin² `angle_rad`) per unit
/// thickness and ν is 0; without shear ν is -1, by C_yz/C_zz.
///
/// ```
/// use protomer_linkage::framework::build::{MissingRib, missing_rib};
/// use protomer_linkage::framework::{Elasticity, Moduli};
/// let made_of = MissingRib {
///     arm_angstrom: 1.0, rib_angstrom: 1.6, angle_rad: 0.5, ks: 1e6, kh: 2.0, cross_kh: 1e6,
/// };
/// let moduli = Moduli::new(&Elasticity::from_framework(&missing_rib(&made_of)?)?, 1.0);
/// let rigid = 2.0 / (2.0 * 0.5_f64.sin().powi(2));
/// assert!((moduli.youngs_gpa[0].unwrap() / rigid - 1.0).abs() < 1e-4);
/// assert!(moduli.poissons[0][1].unwrap().abs() < 1e-4);
/// # Ok::<(), protomer_linkage::CrystalError>(())
/// ```
///
/// # Errors
/// [`CrystalError::BadSetting`] for lengths or an angle with which the ribs do not reach.
pub fn missing_rib(made_of: &MissingRib) -> Result<Framework> {
    let (arm, rib, angle) = (
        made_of.arm_angstrom,
        made_of.rib_angstrom,
        made_of.angle_rad,
    );
    require_positive("arm", arm)?;
    require_positive("rib", rib)?;
    let requirement = "between 0 and 90 degrees";
    let is_inside = angle > 0.0 && angle < FRAC_PI_2;
    require("angle", degrees(angle), is_inside, requirement)?;
    // The rib leads back to the axis: 2 arm sin(angle) = rib sin(lean).
    let sine = 2.0 * arm * angle.sin() / rib;
    let requirement = "longer than 2 arm sin(angle), or the ribs do not reach";
    require("rib", rib, sine < 1.0, requirement)?;
    let edge = 2.0 * arm * angle.cos() + rib * (1.0 - sine * sine).sqrt();
    let mut nodes = vec![vec![0.0, 0.0]];
    for quarter in 0..4 {
        let direction = angle + f64::from(quarter) * FRAC_PI_2;
        nodes.push(vec![arm * direction.cos(), arm * direction.sin()]);
    }
    let ks = made_of.ks;
    let mut rods = Vec::with_capacity(6);
    for elbow in 1..=4 {
        rods.push(rod(0, neighbour(elbow, 0, 0), ks));
    }
    // Elbows: 1 to the right, 2 up, 3 to the left, 4 down.
    rods.push(rod(1, neighbour(3, 1, 0), ks));
    rods.push(rod(2, neighbour(4, 0, 1), ks));
    let mut framework = network(vec![vec![edge, 0.0], vec![0.0, edge]], nodes, rods);
    if made_of.kh != 0.0 {
        let beyond = [
            neighbour(3, 1, 0),
            neighbour(4, 0, 1),
            neighbour(1, -1, 0),
            neighbour(2, 0, -1),
        ];
        for (index, far) in beyond.into_iter().enumerate() {
            let between = [neighbour(0, 0, 0), far];
            framework.hinges.push(hinge(index + 1, between, made_of.kh));
        }
    }
    if made_of.cross_kh != 0.0 {
        for elbow in 1..=4 {
            let between = [neighbour(elbow, 0, 0), neighbour(elbow % 4 + 1, 0, 0)];
            framework.hinges.push(hinge(0, between, made_of.cross_kh));
        }
    }
    Ok(framework)
}

/// Connected stars: stars of four or six points on a square or hexagonal lattice, joined by ribs from point
/// to point (Theocaris, Stavroulakis and Panagiotopoulos, Arch. Appl. Mech. 67, 274 (1997)). `angle_rad`
/// is the angle at a point, between two sides; hinges sit between any two rods that are next to each
/// other around a node. With stiff rods ν of four points is between sin `angle_rad` and 1 on the axes, never
/// negative.
///
/// ```
/// use protomer_linkage::framework::build::stars;
/// use protomer_linkage::framework::{Elasticity, Moduli};
/// let moduli = Moduli::new(&Elasticity::from_framework(&stars(4, 1.0, 0.5, 0.6, 1e6, 1.0)?)?, 1.0);
/// assert!(moduli.poissons[0][1].unwrap() > 0.6_f64.sin());
/// # Ok::<(), protomer_linkage::CrystalError>(())
/// ```
///
/// # Errors
/// [`CrystalError::BadSetting`] for another number of points, lengths that are not positive, or an
/// angle with which the points are none.
pub fn stars(
    points: usize,
    side_angstrom: f64,
    rib_angstrom: f64,
    angle_rad: f64,
    ks: f64,
    kh: f64,
) -> Result<Framework> {
    require_lattice(points)?;
    require_positive("side", side_angstrom)?;
    require_positive("rib", rib_angstrom)?;
    // The angle of a convex polygon with twice as many corners, in which all are alike.
    let flat = PI * (1.0 - 2.0 / points as f64);
    let requirement = match points {
        4 => "between 0 and 90 degrees, where the star is a square",
        _ => "between 0 and 120 degrees, where the star is a hexagon",
    };
    let is_inside = angle_rad > 0.0 && angle_rad < flat;
    require("angle", degrees(angle_rad), is_inside, requirement)?;
    let step = PI / points as f64;
    // From the triangle of centre, point and notch, by the law of sines.
    let half = 0.5 * angle_rad;
    let point = side_angstrom * (step + half).sin() / step.sin();
    let notch = side_angstrom * half.sin() / step.sin();
    let mut nodes = Vec::with_capacity(2 * points);
    for corner in 0..2 * points {
        let direction = step * corner as f64;
        let radius = if corner % 2 == 0 { point } else { notch };
        nodes.push(vec![radius * direction.cos(), radius * direction.sin()]);
    }
    let mut rods = Vec::with_capacity(2 * points + points / 2);
    for corner in 0..2 * points {
        rods.push(rod(
            corner,
            neighbour((corner + 1) % (2 * points), 0, 0),
            ks,
        ));
    }
    for (direction, image) in neighbours(points).into_iter().enumerate() {
        let opposite = 2 * direction + points;
        rods.push(rod(
            2 * direction,
            neighbour(opposite, image[0], image[1]),
            ks,
        ));
    }
    let spacing = 2.0 * point + rib_angstrom;
    let mut framework = network(cell(points, spacing), nodes, rods);
    hinge_neighbouring_rods(&mut framework, kh);
    Ok(framework)
}

/// Chiral honeycombs: wheels of four or six spokes on a square or hexagonal lattice, joined by ligaments that
/// touch them (Prall and Lakes, Int. J. Mech. Sci. 39, 305 (1997)). A wheel is made stiff by rods of
/// stiffness `ks` between all its corners; they come before the ligaments, of the same stiffness. Hinges sit
/// between a ligament and each of its two wheels.
///
/// With rigid wheels and ligaments and R² = ligament² + 4 radius², six spokes have ν = -1 and
/// E = √3 `kh` R²/(radius² ligament²) per unit thickness. Four spokes couple stretch and shear as the
/// [missing-rib foam](missing_rib) does: E = `kh` R²/(2 radius² ligament²) and ν = 0.
///
/// ```
/// use protomer_linkage::framework::build::chiral;
/// use protomer_linkage::framework::{Elasticity, Moduli};
/// let (radius, ligament, kh) = (0.5_f64, 2.0_f64, 3.0);
/// let moduli = Moduli::new(&Elasticity::from_framework(&chiral(6, radius, ligament, 1e9, kh)?)?, 1.0);
/// let square = ligament * ligament + 4.0 * radius * radius;
/// let rigid = 3f64.sqrt() * kh * square / (radius * ligament).powi(2);
/// assert!((moduli.youngs_gpa[0].unwrap() / rigid - 1.0).abs() < 1e-5);
/// # Ok::<(), protomer_linkage::CrystalError>(())
/// ```
///
/// # Errors
/// [`CrystalError::BadSetting`] for another number of spokes or lengths that are not positive.
pub fn chiral(
    spokes: usize,
    radius_angstrom: f64,
    ligament_angstrom: f64,
    ks: f64,
    kh: f64,
) -> Result<Framework> {
    require_lattice(spokes)?;
    require_positive("radius", radius_angstrom)?;
    require_positive("ligament", ligament_angstrom)?;
    let spacing = ligament_angstrom.hypot(2.0 * radius_angstrom);
    let lean = (2.0 * radius_angstrom).atan2(ligament_angstrom);
    let step = 2.0 * PI / spokes as f64;
    let mut nodes = Vec::with_capacity(spokes);
    for spoke in 0..spokes {
        // Ligaments touch a wheel on the left of the way to its neighbour.
        let direction = step * spoke as f64 - lean + FRAC_PI_2;
        nodes.push(vec![
            radius_angstrom * direction.cos(),
            radius_angstrom * direction.sin(),
        ]);
    }
    let wheel: Vec<Neighbour> = (0..spokes).map(|spoke| neighbour(spoke, 0, 0)).collect();
    let mut framework = stiff_polygons(cell(spokes, spacing), nodes, &[wheel], ks);
    let half = spokes / 2;
    for (spoke, image) in neighbours(spokes).into_iter().enumerate() {
        let far = neighbour(spoke + half, image[0], image[1]);
        let near = neighbour(spoke, -image[0], -image[1]);
        framework.rods.push(rod(spoke, far.clone(), ks));
        if kh != 0.0 {
            let [own, opposite] = [neighbour(spoke, 0, 0), neighbour(spoke + half, 0, 0)];
            framework.hinges.push(hinge(spoke, [opposite, far], kh));
            framework.hinges.push(hinge(spoke + half, [own, near], kh));
        }
    }
    Ok(framework)
}

fn require_lattice(neighbours: usize) -> Result<()> {
    if [4, 6].contains(&neighbours) {
        return Ok(());
    }
    Err(CrystalError::BadNetwork(format!(
        "{neighbours} neighbours do not make a lattice of equal cells; give 4 or 6"
    )))
}

/// The cell of a square or hexagonal lattice with this distance between neighbours.
fn cell(neighbours: usize, spacing: f64) -> Vec<Vec<f64>> {
    let second = match neighbours {
        4 => vec![0.0, spacing],
        _ => vec![0.5 * spacing, 0.75_f64.sqrt() * spacing],
    };
    vec![vec![spacing, 0.0], second]
}

/// The first half of the neighbours of a cell, anticlockwise from y.
fn neighbours(count: usize) -> Vec<[i32; 2]> {
    match count {
        4 => vec![[1, 0], [0, 1]],
        _ => vec![[1, 0], [0, 1], [-1, 1]],
    }
}
