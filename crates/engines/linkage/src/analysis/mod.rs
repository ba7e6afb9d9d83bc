//! What the motion of a lattice shows.
//!
//! | module | one idea |
//! |---|---|
//! | [`modes`] | collective rotations and the share of the energy in them |
//! | [`synchronisation`] | which squares turn together, directly or through others |
//! | [`strain`] | deformation, strain, Poisson's ratio |
//! | [`lyapunov`] | how fast neighbouring trajectories part |
//! | [`spread`] | the first maximum of a quantity in time |
//! | [`elastic`] | compliances from the fluctuations of the strain |
//! | [`domains`] | how far neighbours close to the same side |
//! | [`locking`] | the time from which phases are locked |
//! | [`divergence`] | Lyapunov exponents from time series |
//! | [`crossings`] | passages of a quantity through a level |
//! | [`grima`] | the coherent motion, which has one degree of freedom, exactly |
//! | [`elliptic`] | elliptic integrals of the second kind |
//!
//! "The paper" is that of [`lattice`](crate::lattice); "the preprint" is its first version
//! (Campos-Gonzalez-Angulo, Wiesehan, Ribeiro and Yuen-Zhou, "Computational method for
//! highly-constrained molecular dynamics", with the sections on synchronisation and Poisson's
//! ratio).

pub mod crossings;
pub mod divergence;
pub mod domains;
pub mod elastic;
pub mod elliptic;
pub mod grima;
pub mod locking;
pub mod lyapunov;
pub mod modes;
pub mod spread;
pub mod strain;
pub mod synchronisation;
