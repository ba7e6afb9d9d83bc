//! The behaviour of assemblies in salt water: simulations, sweeps over salt, comparisons.

pub mod affinity;
pub mod bench;
pub mod binding;
pub mod compare;
pub mod contacts;
pub mod disk_cache;
pub mod effective;
pub mod energy_tables;
pub mod equilibrium;
pub mod inspect;
pub mod interaction;
pub mod joint;
pub mod live;
pub mod model;
pub mod pair;
pub mod residues;
pub mod response;
pub mod reweighting;
pub mod run;
pub mod score;
pub mod sweep;
pub mod terms;

pub use protomer_mc::DEFAULT_CONTACT_GAP_ANGSTROM;
