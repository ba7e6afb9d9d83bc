//! Where bodies stand: assemblies from structures, from recipes, and relaxed to freedom from
//! overlap.
//!
//! Nothing here knows meshes: whether placements overlap is asked of the caller's predicate.
//!
//! | module | one idea |
//! |---|---|
//! | [`superposition`] | the rigid motion that best maps one point set onto another (Kabsch) |
//! | [`copies`] | identical chains become one body and its poses |
//! | [`recipe`] | rings C_n and stacks D_n, closed to contact |
//! | [`candidates`] | up/down arrangements of a ring or stack that are different under its symmetry |
//! | [`relax`] | the smallest uniform expansion without overlaps |
//! | `contact` | the parameter at which placements touch |

pub mod candidates;
mod contact;
pub mod copies;
pub mod recipe;
pub mod relax;
pub mod superposition;

pub use candidates::{Candidates, Stack, Symmetry};
pub use copies::{BodyType, ChainCopy, body_types};
pub use recipe::{ClosedAssembly, Recipe, RecipeSite};
pub use relax::{Expansion, expand_until_free};
pub use superposition::{Superposition, superpose};

use protomer_kernel::Pose;

/// A body, by its index in a list the caller keeps, and its pose.
pub type Placement = (usize, Pose);
