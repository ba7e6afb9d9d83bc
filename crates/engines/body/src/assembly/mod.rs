//! Poses of bodies: assemblies from structures, from recipes, at random, and relaxed until nothing
//! overlaps.
//!
//! Most of this does not depend on meshes: the caller supplies a predicate that says whether
//! placements overlap. [`HardBodies`] supplies the one of hard bodies.
//!
//! | module | one idea |
//! |---|---|
//! | [`superposition`] | the rigid motion that best maps one point set onto another (Kabsch) |
//! | [`units`] | what becomes one body: a chain, chains joined, or a file |
//! | [`joined`] | chains joined by covalent bonds or base pairs |
//! | [`copies`] | identical units as one body with several poses |
//! | [`native_contacts`] | residues of different units in contact |
//! | [`recipe`] | rings C_n and stacks D_n, closed to contact |
//! | [`cage`] | bodies in general positions of a cubic group, closed to contact |
//! | [`orbits`] | bodies of an arrangement that rotations map onto each other |
//! | [`point_group`] | the rotations that map placed bodies onto each other |
//! | [`candidates`] | up/down arrangements of a ring or stack that are different under its symmetry |
//! | [`relax`] | the least displacements that leave no overlap |
//! | [`insertion`] | random sequential insertion into a periodic box |
//! | [`hard_bodies`] | bodies prepared for overlap tests |
//! | `cells` | near pairs of points |
//! | `contact` | the parameter at which placements touch |
//! | `placement` | a body and its pose |

pub mod cage;
pub mod candidates;
mod cells;
mod contact;
pub mod copies;
pub mod hard_bodies;
pub mod insertion;
pub mod joined;
pub mod native_contacts;
pub mod orbits;
mod placement;
pub mod point_group;
pub mod recipe;
pub mod relax;
pub mod superposition;
pub mod units;

pub use cage::{Cage, CageSite, ClosedCage, CubicGroup};
pub use candidates::{Candidates, Stack, Symmetry};
pub use copies::{BodyType, ChainCopy, body_types, body_types_of_units};
pub use hard_bodies::{HardBodies, HardBody, SymmetricAssembly};
pub use joined::{Joined, JoinedBy, joined_groups, joined_units};
pub use native_contacts::ResidueContacts;
pub use placement::Placement;
pub use point_group::PointGroup;
pub use recipe::{ClosedAssembly, Recipe, RecipeSite};
pub use relax::{CoreAtoms, Separation, separate};
pub use superposition::{Superposition, superpose};
pub use units::{Unit, units_of_chains};
