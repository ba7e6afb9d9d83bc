//! What assemblies do in salt water: simulations, sweeps over salt, and what they are compared by.

pub mod bench;
pub mod compare;
pub mod disk_cache;
pub mod energy_tables;
pub mod inspect;
pub mod interaction;
pub mod run;
pub mod sweep;
