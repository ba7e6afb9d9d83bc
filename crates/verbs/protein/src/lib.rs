//! protomer: from structure files to stability curves.
//!
//! ```text
//! input --ingest--> body files --assemble--> assembly file --sweep--> run directories --> table and figure
//! ```
//!
//! | module | one idea |
//! |---|---|
//! | [`bodies`] | bodies from structures, custom bodies, body files |
//! | [`assemblies`] | building and reading assemblies |
//! | [`stability`] | simulations, sweeps over salt, comparisons, benchmarks |
//! | [`export`] | back to atoms: structure files of assemblies, frames and poses |
//! | [`potential`] | the electrostatic potential around a structure |
//! | [`scattering`] | what light and X-rays see of an assembly or a trajectory |
//! | [`titration`] | pKa values, charges and titration curve of a structure |
//! | [`file_kind`] | what a file is, so that one of the wrong kind is refused with its verb |

pub mod assemblies;
pub mod bodies;
pub mod export;
pub mod file_kind;
pub mod potential;
pub mod scattering;
pub mod stability;
pub mod titration;
