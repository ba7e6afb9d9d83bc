//! How much of an assembly there is: the partition function of each of its connected parts, and the law of mass
//! action over them.
//!
//! ```text
//! q_S = ∫ exp(-U_S) Π d³R_i dΩ_i/8π²    over the poses of all bodies of part S but one, near those of the assembly
//! c_S = q_S/σ_S Π_k c_k^n_k             with n_k free bodies of kind k and the rotations σ_S that leave S as it is
//! ```
//!
//! A part is near the assembly if each body is within a limit of its pose relative to the body that it was attached to:
//! edges of a tree, whose relative poses have the measure of the absolute ones. Contacts that close a ring act
//! with their energy, so the ring closes as often as its bodies let it: nothing is assumed about it.
//!
//! ```text
//! Arrangement --connected_parts--> PartKind, each grown from a smaller one by one body
//!      PartSamples of the smaller --attach (nested sampling)--> ln q_S, PartSamples --> ... --> MassAction: yields
//! ```
//!
//! | module | one idea |
//! |---|---|
//! | `arrangement` | the assembly: kinds, poses, who touches whom |
//! | `connected` | the different connected parts, each with a smaller one that it grows from |
//! | `configuration` | poses of the bodies of a part, and moves of one of them |
//! | `growth` | partition functions by attaching one body after the other |
//! | `windows` | windows from a part to a free body |
//! | `pulled` | simulations in these windows, which exchange their states |
//! | `unbiased` | partition functions from the windows, in the place of growth |
//! | `mass_action` | concentrations of all parts at total concentrations |

mod arrangement;
mod configuration;
mod connected;
mod growth;
mod mass_action;
mod pulled;
mod unbiased;
mod windows;

pub use arrangement::{Arrangement, PlacedBody};
pub use configuration::BodyEnergies;
pub use connected::{ConnectedParts, PartKind, connected_parts};
pub use growth::{Attached, GrowthSettings, PartSamples, Weighted, attach, free_body};
pub use mass_action::{Species, free_concentrations, species_concentrations};
pub use windows::{WindowSettings, WindowsFound};

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests;
#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod window_tests;
