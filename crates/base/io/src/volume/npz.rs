//! Volumes as NumPy archives.

use super::grid::Volume;
use crate::Result;
use crate::npz::{NamedArray, NpyValues, write_npz};

/// A NumPy archive of a volume: the values under `name` with axes z, y, x, `origin_angstrom` and
/// `spacing_angstrom`.
///
/// # Errors
/// [`IoError::Unwritable`](crate::IoError::Unwritable) if the values do not fit the shape.
///
/// ```
/// use protomer_io::volume::{Volume, write_volume_npz};
/// let volume = Volume {
///     shape: [2, 1, 1],
///     origin_angstrom: [0.0; 3],
///     spacing_angstrom: 0.5,
///     values: vec![1.0, 2.0],
/// };
/// assert_eq!(&write_volume_npz("potential_kt_per_e", &volume)?[..2], b"PK");
/// # Ok::<(), protomer_io::IoError>(())
/// ```
pub fn write_volume_npz(name: &str, volume: &Volume) -> Result<Vec<u8>> {
    let [nx, ny, nz] = volume.shape;
    write_npz(&[
        NamedArray {
            name,
            // C order with the last axis fastest: x runs fastest in the values.
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
