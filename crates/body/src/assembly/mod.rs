//! Poses of bodies: assemblies from structures, from recipes, at random, and relaxed until nothing
//! overlaps.
//!
//! Most of this does not depend on meshes: the caller supplies a predicate that says whether
//! placements overlap. [`HardBodies`] supplies the one of hard bodies.
//!
//! | module | one idea |
//! |---|---|
//! | [`superposition`] | the rigid motion that best maps one point set onto another (Kabsch) |
//! | [`copies`] | identical chains as one body with several poses |
//! | [`recipe`] | rings C_n and stacks D_n, closed to contact |
//! | [`candidates`] | up/down arrangements of a ring or stack that are different under its symmetry |
//! | [`relax`] | the smallest uniform expansion without overlaps |
//! | [`insertion`] | random sequential insertion into a periodic box |
//! | [`hard_bodies`] | bodies prepared for overlap tests |
//! | `contact` | the parameter at which placements touch |
//! | `placement` | a body and its pose |

pub mod candidates;
mod contact;
pub mod copies;
pub mod hard_bodies;
pub mod insertion;
mod placement;
pub mod recipe;
pub mod relax;
pub mod superposition;

pub use candidates::{Candidates, Stack, Symmetry};
pub use copies::{BodyType, ChainCopy, body_types};
pub use hard_bodies::{HardBodies, HardBody};
pub use placement::Placement;
pub use recipe::{ClosedAssembly, Recipe, RecipeSite};
pub use relax::{Expansion, expand_until_free};
pub use superposition::{Superposition, superpose};
