//! What each residue, and each pair of residues, contributes to the energy of a state.
//!
//! Charges and contacts act between places of two bodies, and each place belongs to a residue:
//!
//! ```text
//! E = Σ_{a<b} e_ab + Σ_a d_a     e_a = Σ_b e_ab + d_a
//! ```
//!
//! over the residues a, b of different bodies. A pair counts in full with both of its residues, so
//! the e_a without the desolvation add up to twice the energy; solvent (d_a) counts with the residue
//! that displaces it, and its response with the residue whose charges and volume it acts on.
//!
//! | module | one idea |
//! |---|---|
//! | `places` | which residue a place of a body belongs to |
//! | `kind` | the residues of one kind of body with their charges and atoms |
//! | `state` | the contributions in one state |
//! | `average` | their mean over the frames of a run, with errors |
//! | `response` | what another charge at a residue would change, and the reweighted frames |

mod average;
mod kind;
mod places;
mod response;
mod state;

pub use average::{Averages, Mean, mean_of_blocks};
pub use kind::{ResiduesOfKind, charge_sites};
pub use places::ResiduePlaces;
pub use response::{ChargeSites, Response, Reweighted, reweighted};
pub use state::{
    Contributions, PairContribution, ResidueContribution, ResiduePairs, StateEnergies,
};

#[cfg(test)]
mod tests;
