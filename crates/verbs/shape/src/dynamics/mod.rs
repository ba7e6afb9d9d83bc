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
//! | [`placed`] | bodies that begin where another simulation left them |
//! | [`log`], [`trajectory`] | the files of a run |
//! | `schedule` | the course of a run: compression, equilibration, the run proper |
//! | [`run`] | one run in its directory |
//! | [`live`] | bodies in motion in memory, for loops of one's own |
//! | [`page`] | the page of a run |

pub mod live;
pub mod log;
pub mod page;
pub mod placed;
pub mod run;
mod schedule;
pub mod settings;
pub mod start;
pub mod trajectory;
