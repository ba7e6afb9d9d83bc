//! How the elastic energy is shared between rods and hinges.
//!
//! Under a load the compliance S of a network of springs has ∂ ln S/∂ ln k = -(the part of the
//! energy in the springs of stiffness k), so the share of the rods is ∂ ln E/∂ ln k over all rods.

use super::elastic::Elasticity;
use super::model::Framework;
use super::moduli::Moduli;
use crate::Result;

/// Relative change of the stiffness for the derivative; its error is of the second order.
const CHANGE: f64 = 1e-3;

/// The part of the elastic energy that is in the rods when a network at rest is loaded along each axis, from 0
/// to 1; the rest is in hinges and torsions. Absent where a mechanism yields.
///
/// ```
/// use protomer_linkage::framework::analytic::Honeycomb;
/// use protomer_linkage::framework::{build::honeycomb, rod_shares};
/// let made_of = Honeycomb {
///     h_angstrom: 2.0,
///     l_angstrom: 1.0,
///     theta_rad: 70_f64.to_radians(),
///     hinge_stiffness_kcal_mol_rad2: 50.0,
///     rod_stiffness_kcal_mol_angstrom2: 800.0,
///     thickness_angstrom: 1.0,
/// };
/// // Compliances of hinging and stretching add up.
/// let exact = made_of.both(1.0).e_y_gpa / made_of.stretching(1.0).e_y_gpa;
/// assert!((rod_shares(&honeycomb(&made_of)?)?[0].unwrap() - exact).abs() < 1e-6);
/// # Ok::<(), protomer_linkage::CrystalError>(())
/// ```
///
/// # Errors
/// As [`Elasticity::from_framework`].
pub fn rod_shares(framework: &Framework) -> Result<Vec<Option<f64>>> {
    let [less, more] = [1.0 - CHANGE, 1.0 + CHANGE].map(|factor| youngs(framework, factor));
    let (less, more) = (less?, more?);
    let step = ((1.0 + CHANGE) / (1.0 - CHANGE)).ln();
    let pairs = less.iter().zip(&more);
    Ok(pairs
        .map(|(less, more)| {
            less.zip(*more)
                .map(|(less, more)| (more / less).ln() / step)
        })
        .collect())
}

/// Young's moduli with rods that are stiffer by a factor.
fn youngs(framework: &Framework, factor: f64) -> Result<Vec<Option<f64>>> {
    let mut changed = framework.clone();
    for rod in &mut changed.rods {
        rod.stiffness_kcal_mol_angstrom2 *= factor;
    }
    Ok(Moduli::new(&Elasticity::from_framework(&changed)?, 1.0).youngs_gpa)
}
