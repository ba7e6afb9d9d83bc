//! Values on a grid as files: MRC (CCP4) and OpenDX.

pub mod dx;
pub mod mrc;

/// Values on a regular grid, x running fastest.
#[derive(Debug, Clone, PartialEq)]
pub struct Volume {
    /// Points along x, y and z.
    pub shape: [usize; 3],
    /// The lowest corner, Å.
    pub origin_angstrom: [f64; 3],
    /// Distance of neighbouring points, Å.
    pub spacing_angstrom: f64,
    /// What is there.
    pub values: Vec<f64>,
}
