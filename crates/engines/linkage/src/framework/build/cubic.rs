//! Nets of nearest neighbours in a cubic cell.

use super::hinges::hinge_all_rods;
use super::{network, rod};
use crate::error::{Result, require_positive};
use crate::framework::model::{Framework, Neighbour, Rod};

/// The sites of a face-centred cubic cell of edge 1.
const FACE_CENTRED: [[f64; 3]; 4] = [
    [0.0, 0.0, 0.0],
    [0.0, 0.5, 0.5],
    [0.5, 0.0, 0.5],
    [0.5, 0.5, 0.0],
];

/// Face-centred cubic net of nearest-neighbour springs in the cubic cell of edge a: C11 = 2 ks/a,
/// C12 = C44 = ks/a.
///
/// ```
/// use protomer_linkage::framework::{Elasticity, build::face_centred_cubic};
/// let stiffness = Elasticity::from_framework(&face_centred_cubic(3.0, 7.0)?)?.stiffness;
/// assert!((stiffness[(0, 0)] - 2.0 * 7.0 / 3.0).abs() < 1e-12);
/// # Ok::<(), protomer_linkage::CrystalError>(())
/// ```
///
/// # Errors
/// [`CrystalError::BadSetting`](crate::CrystalError::BadSetting) for an edge that is not positive.
pub fn face_centred_cubic(edge_angstrom: f64, ks: f64) -> Result<Framework> {
    require_positive("edge", edge_angstrom)?;
    Ok(cubic_net(edge_angstrom, &FACE_CENTRED, 0.5f64.sqrt(), ks))
}

/// Diamond net of nearest-neighbour springs in the cubic cell of edge a, with hinges between all
/// bonds at a node. Without hinges C11 = C12 = ks/(3a), and shear costs nothing.
///
/// ```
/// use protomer_linkage::framework::{Elasticity, build::diamond};
/// let floppy = Elasticity::from_framework(&diamond(3.0, 7.0, 0.0)?)?;
/// assert_eq!(floppy.mechanisms.len(), 5);
/// let hinged = Elasticity::from_framework(&diamond(3.0, 7.0, 1.0)?)?;
/// assert!(hinged.mechanisms.is_empty());
/// # Ok::<(), protomer_linkage::CrystalError>(())
/// ```
///
/// # Errors
/// [`CrystalError::BadSetting`](crate::CrystalError::BadSetting) for an edge that is not positive.
pub fn diamond(edge_angstrom: f64, ks: f64, kh: f64) -> Result<Framework> {
    require_positive("edge", edge_angstrom)?;
    let mut sites = Vec::with_capacity(8);
    for site in FACE_CENTRED {
        sites.extend([site, site.map(|x| x + 0.25)]);
    }
    let mut framework = cubic_net(edge_angstrom, &sites, 0.1875f64.sqrt(), ks);
    hinge_all_rods(&mut framework, kh);
    Ok(framework)
}

/// Rods between all sites of a cubic cell at this distance (in edges).
fn cubic_net(edge: f64, sites: &[[f64; 3]], distance: f64, ks: f64) -> Framework {
    let mut rods = Vec::new();
    for from in 0..sites.len() {
        for to in 0..sites.len() {
            rods.extend(rods_between(sites, [from, to], distance, ks));
        }
    }
    let cell = (0..3).map(|axis| {
        let mut vector = vec![0.0; 3];
        vector[axis] = edge;
        vector
    });
    let nodes = sites.iter().map(|site| site.map(|x| x * edge).to_vec());
    network(cell.collect(), nodes.collect(), rods)
}

/// Rods from a site to the images of another at this distance, each pair once.
fn rods_between(sites: &[[f64; 3]], [from, to]: [usize; 2], distance: f64, ks: f64) -> Vec<Rod> {
    let mut rods = Vec::new();
    for code in 0..27 {
        let image = [code / 9 - 1, code / 3 % 3 - 1, code % 3 - 1];
        let once = from < to || (from == to && image > [0, 0, 0]);
        let apart = distance_to_image(&sites[from], &sites[to], image);
        if once && (apart - distance).abs() < 1e-9 {
            rods.push(rod(from, Neighbour::in_image(to, &image), ks));
        }
    }
    rods
}

fn distance_to_image(a: &[f64; 3], b: &[f64; 3], image: [i32; 3]) -> f64 {
    let mut square = 0.0;
    for axis in 0..3 {
        square += (b[axis] + f64::from(image[axis]) - a[axis]).powi(2);
    }
    square.sqrt()
}
