//! Many hard convex bodies: runs in directories, phases by theory.
//!
//! | module | one idea |
//! |---|---|
//! | [`settings`] | the settings of a run |
//! | [`start`] | bodies and starts from names and files |
//! | `kinds` | kinds of bodies from the settings |
//! | [`placed`] | bodies that begin where another simulation left them |
//! | [`run`] | one run in its directory |
//! | [`live`] | hard bodies in memory, for loops of one's own |
//! | [`result`] | what it found |
//! | [`equilibrium`] | whether a run has arrived at what it should measure |
//! | [`sweep`] | runs over packing fraction or pressure: an equation of state |
//! | [`free_energy`] | the free energy of a crystal in its directory |
//! | [`log`], [`trajectory`] | the files of a run |
//! | [`page`] | the pages of runs, sweeps and free energies |
//! | [`phases`] | coexisting phases: by theory, from tables, or from what sweeps and free energies measured |
//! | [`static_free_volume`] | free volumes of crystals that do not move |

pub mod equilibrium;
pub mod free_energy;
mod kinds;
pub mod live;
pub mod log;
pub mod page;
pub mod phases;
pub mod placed;
pub mod result;
pub mod run;
pub mod settings;
pub mod start;
pub mod static_free_volume;
pub mod sweep;
pub mod trajectory;
