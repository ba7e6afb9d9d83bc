//! Atoms, spheres and point charges as files of points describe them.

use crate::Vec3;

/// The largest charge of an atom or a point, e: more than any ion or colloid has in one place, and little enough
/// for energies of all pairs to stay finite.
pub const LARGEST_CHARGE_E: f64 = 1e4;

/// One atom, sphere or point charge. Fields that a format lacks are zero or empty.
///
/// ```
/// use protomer_kernel::{PointRecord, Vec3};
/// let sphere = PointRecord {
///     position: Vec3::new(0.0, 0.0, 3.0),
///     radius_angstrom: 1.7,
///     ..PointRecord::default()
/// };
/// assert_eq!(sphere.charge_e, 0.0);
/// ```
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PointRecord {
    /// Position, Å.
    pub position: Vec3,
    /// Charge, e.
    pub charge_e: f64,
    /// Radius, Å.
    pub radius_angstrom: f64,
    /// Atom name.
    pub atom_name: String,
    /// Residue name.
    pub residue_name: String,
    /// Chain identifier; empty for none.
    pub chain: String,
    /// Residue number.
    pub residue_number: i32,
    /// Insertion code; empty for none.
    pub insertion_code: String,
}
