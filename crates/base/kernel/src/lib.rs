//! What every protomer engine builds on: units, rigid bodies, meshes, random numbers, statistics.
//!
//! | module | one idea |
//! |---|---|
//! | [`units`] | physical constants |
//! | [`electrolyte`] | a salt solution and its Bjerrum and Debye lengths |
//! | [`pose`] | rigid motions: where a body is and how it is turned |
//! | [`boundary`] | the space that bodies live in: open, periodic, or inside a spherical wall |
//! | [`periodic_box`] | periodic boxes of any shape in one, two and three dimensions |
//! | [`mesh`] | closed triangle meshes, their topology and mass properties |
//! | [`name`] | names that users and files choose: what they may hold |
//! | [`null`] | numbers that JSON does not have |
//! | [`plain_text`] | bytes of a file as text: encodings, line ends, what is not text |
//! | [`point_record`] | atoms, spheres and point charges as files of points describe them |
//! | [`random`] | counter-based random numbers: directions, rotations, streams per step |
//! | [`fused`] | multiply-add where it is one instruction |
//! | [`exponential`] | exponentials for loops in vectors |
//! | [`mod@vectorised`] | methods compiled for several instruction sets |
//! | [`disjoint_sets`] | sets of numbers that are joined pair by pair |
//! | [`bisection`] | intervals in which a condition changes, by halving |
//! | [`quadrature`] | Gauss-Legendre and Gauss-Kronrod rules, points on the sphere |
//! | [`chebyshev`] | polynomials through Chebyshev points |
//! | [`jet`] | numbers that carry their first and second derivatives |
//! | [`potential`] | radial pair potentials |
//! | [`pair_energy`] | energies of pairs of rigid bodies from terms in a file, with forces where they have them |
//! | [`height_energy`] | the energy of a body by its height, from a table |
//! | [`cells`] | which bodies are near a point |
//! | [`overlap`] | whether two rigid bodies overlap, and how far apart they are if not |
//! | [`shape`] | convex shapes, and what is known of them exactly |
//! | [`shell`] | the space between two balls, and points drawn in it |
//! | [`setting`] | values of settings by kind, and enums whose names and texts users see |
//! | [`sparse`] | symmetric sparse systems of a fixed pattern |
//! | [`spline`] | cubic splines through points |
//! | [`statistics`] | averages of correlated series and their errors |
//!
//! Lengths are in Å, energies in kT, charges in elementary charges, salt in mol/L.

pub mod bisection;
pub mod boundary;
pub mod cells;
pub mod chebyshev;
pub mod disjoint_sets;
pub mod electrolyte;
mod error;
pub mod exponential;
pub mod fused;
pub mod height_energy;
pub mod jet;
pub mod mesh;
pub mod name;
pub mod null;
pub mod overlap;
pub mod pair_energy;
pub mod periodic_box;
pub mod plain_text;
pub mod point_record;
pub mod pose;
pub mod potential;
pub mod quadrature;
pub mod random;
pub mod setting;
pub mod shape;
pub mod shell;
pub mod sparse;
pub mod spline;
pub mod statistics;
pub mod units;
pub mod vectorised;

pub use boundary::Boundary;
pub use electrolyte::Electrolyte;
pub use error::{AtMost, KernelError, Number, Result};
pub use mesh::TriangleMesh;
pub use overlap::CollisionShape;
pub use point_record::PointRecord;
pub use pose::{Pose, RelativePose};

/// A point or a displacement in three dimensions, Å.
pub type Vec3 = nalgebra::Vector3<f64>;

/// A rotation stored as a unit quaternion. Files and Python write it scalar first, `(w, x, y, z)`.
pub type Rotation = nalgebra::UnitQuaternion<f64>;
