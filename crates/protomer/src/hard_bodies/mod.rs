//! Many hard convex bodies: runs in directories, phases by theory.
//!
//! | module | one idea |
//! |---|---|
//! | [`settings`] | the settings of a run |
//! | [`run`] | one run in its directory |
//! | [`log`], [`trajectory`] | the files of a run |
//! | [`phases`] | coexisting phases of spheres and depletants by free volume theory |

pub mod log;
pub mod phases;
pub mod run;
pub mod settings;
pub mod trajectory;
