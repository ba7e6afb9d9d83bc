//! Convex shapes and many bodies of such shapes: settings to answers, files, run directories.
//!
//! | module | one idea |
//! |---|---|
//! | [`shapes`] | convex shapes from files and names |
//! | [`hard_bodies`] | Monte Carlo of many hard convex bodies, phases by theory |
//! | [`dynamics`] | contact dynamics of convex shapes |
//!
//! The engines are `protomer-hpmc` and `protomer-md`.

pub mod dynamics;
pub mod hard_bodies;
pub mod shapes;
