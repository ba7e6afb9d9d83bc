//! What scattering sees of bodies in solution: the distances of their centres, their forms, the
//! clusters they make and how fast those diffuse.
//!
//! | module | one idea |
//! |---|---|
//! | [`structure_factor`] | S(q) between points: all distances, or a wave vector |
//! | [`wave_vectors`] | the wave vectors of a periodic box, in shells |
//! | [`directions`] | averages over all orientations |
//! | [`scatterers`] | what of a body scatters; its amplitude and its P(q) |
//! | `filling` | points that fill a body without atoms |
//! | [`clusters`] | bodies that touch, in one piece across the borders of a box |
//! | [`capacity`] | hydrodynamic radii from the electrostatic capacity |
//! | [`experiment`] | all of this for one state |
//!
//! Wave numbers are in Å⁻¹, q = 4π n sin(θ/2) / λ.

pub mod capacity;
pub mod clusters;
pub mod directions;
pub mod experiment;
mod filling;
pub mod scatterers;
pub mod structure_factor;
pub mod wave_vectors;

/// sin(x)/x.
pub(crate) fn sinc(x: f64) -> f64 {
    match x.abs() < 1e-4 {
        true => 1.0 - x * x / 6.0,
        false => x.sin() / x,
    }
}
