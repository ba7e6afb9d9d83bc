//! Values on a grid as files: MRC (CCP4), OpenDX and NumPy archives.

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

/// A NumPy archive of a volume: the values under `name` with axes z, y, x, `origin_angstrom` and
/// `spacing_angstrom`.
///
/// # Errors
/// [`crate::IoError::Unwritable`] if the values do not fit the shape.
///
/// ```
/// use protomer_io::volume::{Volume, write_volume_npz};
/// let volume = Volume { shape: [2, 1, 1], origin_angstrom: [0.0; 3], spacing_angstrom: 0.5, values: vec![1.0, 2.0] };
/// assert!(write_volume_npz("potential_kt_per_e", &volume).is_ok());
/// ```
pub fn write_volume_npz(name: &str, volume: &Volume) -> crate::Result<Vec<u8>> {
    use crate::npz::{NamedArray, NpyValues, write_npz};
    let [nx, ny, nz] = volume.shape;
    write_npz(&[
        NamedArray {
            name,
            shape: &[nz, ny, nx],
            values: NpyValues::F64(&volume.values),
        },
        NamedArray {
            name: "origin_angstrom",
            shape: &[3],
            values: NpyValues::F64(&volume.origin_angstrom),
        },
        NamedArray {
            name: "spacing_angstrom",
            shape: &[],
            values: NpyValues::F64(&[volume.spacing_angstrom]),
        },
    ])
}
