//! protomer: run directories, sweeps and reports on top of the engines.
