//! When bodies meet, and what follows.
//!
//! | module | one idea |
//! |---|---|
//! | [`lcp`] | impulses that only push |
//! | [`response`] | what an impact does to the velocities |
//! | [`march`] | the first root of a gap along a path |
//! | [`detection`] | the first contact in a step |
//! | [`replay`] | first contact and response for scripts |

pub mod detection;
pub mod lcp;
pub mod march;
pub mod replay;
pub mod response;
