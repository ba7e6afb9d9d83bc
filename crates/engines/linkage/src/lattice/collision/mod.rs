//! When bodies meet, and what follows.
//!
//! | module | one idea |
//! |---|---|
//! | [`watch`] | what could meet: how far apart it is, and how it touches |
//! | [`march`] | the first root of a gap along a path |
//! | `path` | the path that a step is taken to follow, and bounds of its curvature |
//! | [`detection`] | the first contact in a step |
//! | [`lcp`] | impulses that only push |
//! | [`response`] | what an impact does to the velocities |
//! | [`replay`] | first contact and response of single states |

pub mod detection;
pub mod lcp;
pub mod march;
mod path;
pub mod replay;
pub mod response;
pub mod watch;
