//! Periodic networks of springs, hinges and torsions, and what they do under load.
//!
//! ```text
//! Framework (cell, nodes, rods, hinges, torsions)
//!    --energy: second-order numbers--> energy, gradient, Hessian over nodes and strain
//!    --elastic--> stiffness C, clamped and relaxed; compliance; mechanisms
//!    --load--> the deformed cell under a stress
//! ```
//!
//! | module | one idea |
//! |---|---|
//! | [`model`] | the network as data |
//! | `check`, `supercell` | what is wrong with a network; the same network with a larger cell |
//! | [`build`] | honeycombs, rotating squares and triangles, arrowheads, missing-rib foams, stars, chiral honeycombs, the rod lattice, FCC, diamond, alpha-cristobalite |
//! | [`flexure`] | ribs that flex: chains of segments |
//! | `term` | one spring: its length or angle, and its energy with derivatives |
//! | `configuration` | nodes and cell, and strains of them |
//! | [`energy`] | energy, gradient and Hessian of a network |
//! | `relaxation` | how nodes follow a strain |
//! | [`elastic`] | elastic constants, mechanisms, Maxwell's count |
//! | [`moduli`] | Young's and shear moduli, Poisson's ratios, on axis and off |
//! | [`shares`] | the energy in rods and in hinges |
//! | [`load`] | minimisation, with and without the cell, under uniaxial stress |
//! | `newton`, `work` | its steps; the work of a load on the cell |
//! | [`analytic`] | the closed formulas for honeycombs |
//!
//! The method is "empirical modelling using dummy atoms", Grima, Gatt, Bray, Alderson and Evans,
//! Mol. Simul. 31, 925 (2005), below "the paper": nodes without mass, rods that stretch, hinges
//! that turn, elastic constants from second derivatives. Lengths are in Å, energies in kcal/mol,
//! moduli in GPa. Two-dimensional networks lie in the plane of y and z and have a thickness along
//! x, so their strains come in the order yy, zz, yz; three-dimensional ones in the order xx, yy,
//! zz, yz, xz, xy. Shear strains are engineering strains.

pub mod analytic;
pub mod build;
mod check;
mod configuration;
pub mod elastic;
pub mod energy;
pub mod flexure;
pub mod load;
pub mod model;
pub mod moduli;
mod newton;
mod relaxation;
pub mod shares;
mod supercell;
mod term;
mod work;

pub use elastic::{Elasticity, Mechanism};
pub use flexure::Flexure;
pub use load::{Load, StressKind};
pub use model::{Framework, Hinge, Neighbour, Rod, Torsion};
pub use moduli::Moduli;
pub use shares::rod_shares;

/// Avogadro's number, 1/mol (exact, SI of 2019).
pub const AVOGADRO_PER_MOL: f64 = 6.022_140_76e23;

/// GPa per kcal/mol/Å³ for this value of Avogadro's number (1/mol): 4184 J/kcal · 10³⁰ Å³/m³ / N_A
/// / 10⁹.
///
/// ```
/// let factor = protomer_linkage::framework::gpa_per_kcal_mol_angstrom3(6.022e23);
/// assert!((factor - 6.947_857_854_533_377).abs() < 1e-12);
/// ```
pub fn gpa_per_kcal_mol_angstrom3(avogadro_per_mol: f64) -> f64 {
    4184e21 / avogadro_per_mol
}
