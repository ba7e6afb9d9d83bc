//! Contact dynamics of convex bodies: settings, run directories.
//!
//! ```text
//! DynamicsSettings --start--> bodies, motion --run--> directory (log, trajectory, checkpoint)
//! ```
//!
//! | module | one idea |
//! |---|---|
//! | [`settings`] | the settings of a run |
//! | [`start`] | bodies from the settings, and how dense they may begin |
//! | [`log`], [`trajectory`] | the files of a run |
//! | [`run`] | one run in its directory |
//! | [`page`] | the page of a run |

pub mod log;
pub mod page;
pub mod run;
pub mod settings;
pub mod start;
pub mod trajectory;
