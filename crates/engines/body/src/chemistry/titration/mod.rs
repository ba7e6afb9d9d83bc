//! A protein whose titratable groups can be charged one by one.
//!
//! Everything that no proton changes is the background: the partial charges of the neutral form of
//! every residue, with the hydrogens of polar atoms at places of their own. A group is a change of
//! these charges, from its neutral to its charged form, that adds up to ±1 e ([`TitratableGroup`]).
//!
//! | module | one idea |
//! |---|---|
//! | [`groups`] | the titratable groups of a selection, as changes of charge |
//! | [`hydrogens`] | places of the hydrogens on polar atoms |
//! | `body_groups` | the groups of a body, for charges that respond |
//! | `sites` | atoms, hydrogens and groups of a selection together |

mod body_groups;
pub mod groups;
pub mod hydrogens;
mod sites;

pub use body_groups::{BodyGroup, BodyTitration, change_on_atoms_e};
pub use groups::{GroupKind, TitratableGroup, formal_changes_e, protonation_of_residues};
pub use sites::{TitratableSites, titratable_sites};
