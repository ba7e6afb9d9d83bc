//! Values on a regular grid.

/// Values on a regular grid, x running fastest.
///
/// ```
/// use protomer_io::volume::Volume;
/// let volume = Volume {
///     shape: [2, 1, 1],
///     origin_angstrom: [0.0; 3],
///     spacing_angstrom: 0.5,
///     values: vec![1.0, 2.0],
/// };
/// assert_eq!(volume.shape.iter().product::<usize>(), volume.values.len());
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Volume {
    /// Points along x, y and z.
    pub shape: [usize; 3],
    /// The lowest corner, Å.
    pub origin_angstrom: [f64; 3],
    /// Distance of neighbouring points, Å.
    pub spacing_angstrom: f64,
    /// The values, in the unit of the quantity.
    pub values: Vec<f64>,
}
