//! Convex shapes and many bodies of such shapes: settings to answers, files, run directories.
//!
//! | module | one idea |
//! |---|---|
//! | [`shapes`] | convex shapes from files and names |
//! | [`hard_bodies`] | Monte Carlo of many hard convex bodies, phases by theory |
//! | [`dynamics`] | contact dynamics of convex shapes |
//! | [`given_state`] | bodies where a file has them |
//! | [`potential_file`] | potentials of pairs and fields from files |
//! | `course` | the log of a run as a figure |
//! | `last_frame` | the bodies of a trajectory as meshes to look at |
//!
//! The engines are `protomer-hpmc` and `protomer-md`.

mod course;
pub mod dynamics;
pub mod given_state;
pub mod hard_bodies;
mod last_frame;
pub mod potential_file;
mod shape_words;
pub mod shapes;
