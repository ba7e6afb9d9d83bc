//! Lattices of rigid squares: settings, run directories, sweeps, figures.
//!
//! ```text
//! LatticeSettings --start--> network, state --run--> directory (log, trajectory, checkpoint) --animation--> page
//! [sweep] of the settings --sweep--> one directory per run --> tables and figures
//! ```
//!
//! | module | one idea |
//! |---|---|
//! | [`settings`] | the settings of a run |
//! | [`potential_table`] | a potential of an angle as a table |
//! | [`given_state`] | squares where another simulation left them |
//! | [`live`] | a lattice in memory |
//! | [`limits`] | the values that settings may have |
//! | [`start`] | network, initial state and time step from the settings |
//! | [`log`], [`trajectory`], [`directory`] | the files of a run |
//! | [`run`] | one run in its directory |
//! | [`replay`] | the motion from a state in a file, up to the first contact and through it |
//! | [`mod@bench`] | steps per CPU-second |
//! | [`exponent`] | the Lyapunov exponent of a run of a sweep |
//! | [`elastic`] | compliances and Poisson's ratio of runs in a heat bath |
//! | [`divergence`] | the Lyapunov exponent from the series of a log |
//! | [`sweep`] | many runs, their tables and figures |
//! | [`animation`] | the page that plays a run |
//! | [`page`] | the pages of runs and sweeps |
//! | [`square_of_body`] | the square that represents a body |

pub mod animation;
pub mod bench;
pub mod directory;
pub mod divergence;
pub mod elastic;
pub mod exponent;
pub mod given_state;
pub mod limits;
pub mod live;
pub mod log;
pub mod page;
pub mod potential_table;
pub mod replay;
pub mod run;
pub mod settings;
pub mod square_of_body;
pub mod start;
pub mod sweep;
pub mod trajectory;
