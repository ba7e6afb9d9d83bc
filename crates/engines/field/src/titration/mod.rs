//! Electrostatic energies of titratable groups: in the protein, and in a model compound in water.
//!
//! The charges of a group change by δ from its neutral to its charged form. With φ the potential
//! of these changes alone (Coulomb potential in the solute and reaction field of its surroundings),
//! charging the group costs
//!
//! ½ Σ δ u + Σ_b q_b φ(r_b) + Σ_j n_j Σ δ_j φ(r_j),
//!
//! the self-energy in the reaction field u, the interaction with the background of partial charges,
//! and that with the other groups in their states n_j. The first two terms are also those of the
//! model compound, the residue with its neighbouring peptide bonds alone in water; the difference
//! shifts the pKa (Bashford and Karplus, Biochemistry 29, 10219 (1990)).
//!
//! | module | one idea |
//! |---|---|
//! | `energies` | one solve for each group in the protein and in its model compound |
//! | `model` | the fitted numbers, and the groups that follow from them |
//! | `equilibrium` | mean protonation of all groups together |
//! | `curve` | pKa values, net charge, isoelectric point |
//! | `protonation` | from selected residues to their protonation |

mod curve;
mod energies;
mod equilibrium;
mod model;
mod protonation;

pub use energies::{GroupEnergies, group_energies, solve_settings};
pub use equilibrium::{DELTA_SHARE, EXACT_NEIGHBOURS, TitratingGroups};
pub use model::TitrationModel;
pub use protonation::SolvedProtonation;
